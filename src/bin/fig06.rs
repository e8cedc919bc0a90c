//! The friction law, Fig. 6 of the paper.

use replication::figures::cli;
use replication::figures::fig06::FIG06;

fn main() -> std::process::ExitCode {
    cli::main(&FIG06)
}
