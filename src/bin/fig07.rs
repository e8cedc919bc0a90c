//! Tangent points, Fig. 7 of the paper.

use std::process::ExitCode;

use replication::figures::cli;
use replication::figures::fig07::FIG07;

fn main() -> ExitCode {
    cli::main(&FIG07)
}
