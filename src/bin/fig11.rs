//! Quasi-periodic motion of the block and the bracket, Fig. 11 of the paper.

use std::process::ExitCode;

use replication::figures::cli;
use replication::figures::fig11::Fig11;

fn main() -> ExitCode {
    cli::main::<Fig11>()
}
