//! Quasi-periodic motion of the block and the bracket, Fig. 11 of the paper.

use std::process::ExitCode;

use stickslip::figures::cli;
use stickslip::figures::fig11::Fig11;

fn main() -> ExitCode {
    cli::main::<Fig11>()
}
