//! Work and precision of this solver beside those that people use now.

use std::process::ExitCode;

fn main() -> ExitCode {
    replication::peers::main()
}
