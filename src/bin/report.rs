//! What becomes of every claim of the paper.

use std::process::ExitCode;

fn main() -> ExitCode {
    replication::report::cli::main()
}
