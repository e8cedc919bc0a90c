//! Chaotic motion of the block and the bracket, Fig. 12 of the paper.

use replication::figures::block_and_bracket::FIG12;
use replication::figures::cli;

fn main() -> std::process::ExitCode {
    cli::main(&FIG12)
}
