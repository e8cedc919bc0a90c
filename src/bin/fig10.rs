//! Periodic motion of the block and the bracket, Fig. 10 of the paper.

use std::process::ExitCode;

use replication::figures::cli;
use replication::figures::fig10::Fig10;

fn main() -> ExitCode {
    cli::main::<Fig10>()
}
