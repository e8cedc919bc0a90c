//! Stick–slip of the forced oscillator as printed and exact, Fig. 8 of the paper.

use std::process::ExitCode;

use replication::figures::cli;
use replication::figures::fig08::Fig08;

fn main() -> ExitCode {
    cli::main::<Fig08>()
}
