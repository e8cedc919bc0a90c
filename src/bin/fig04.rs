//! Orbits and limit cycle of the belt oscillator, Fig. 4 of the paper.

use replication::figures::cli;
use replication::figures::fig04::FIG04;

fn main() -> std::process::ExitCode {
    cli::main(&FIG04)
}
