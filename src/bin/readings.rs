//! Search over how Figs. 10–12 of the paper can be read.

use std::process::ExitCode;

fn main() -> ExitCode {
    replication::readings::main()
}
