//! Periodic motion of the block and the bracket, Fig. 10 of the paper.

use replication::figures::block_and_bracket::FIG10;
use replication::figures::cli;

fn main() -> std::process::ExitCode {
    cli::main(&FIG10)
}
