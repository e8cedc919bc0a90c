//! Chaotic motion of the block and the bracket, Fig. 12 of the paper.

use std::process::ExitCode;

use replication::figures::cli;
use replication::figures::fig12::Fig12;

fn main() -> ExitCode {
    cli::main::<Fig12>()
}
