//! The friction law, Fig. 6 of the paper.

use std::process::ExitCode;

use replication::figures::cli;
use replication::figures::fig06::FIG06;

fn main() -> ExitCode {
    cli::main(&FIG06)
}
