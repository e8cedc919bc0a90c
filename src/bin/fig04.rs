//! Orbits and limit cycle of the belt oscillator, Fig. 4 of the paper.

use std::process::ExitCode;

use replication::figures::cli;
use replication::figures::fig04::FIG04;

fn main() -> ExitCode {
    cli::main(&FIG04)
}
