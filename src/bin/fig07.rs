//! Tangent points, Fig. 7 of the paper.

use replication::figures::cli;
use replication::figures::fig07::FIG07;

fn main() -> std::process::ExitCode {
    cli::main(&FIG07)
}
