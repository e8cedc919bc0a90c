//! Quasi-periodic motion of the block and the bracket, Fig. 11 of the paper.

use replication::figures::block_and_bracket::FIG11;
use replication::figures::cli;

fn main() -> std::process::ExitCode {
    cli::main(&FIG11)
}
