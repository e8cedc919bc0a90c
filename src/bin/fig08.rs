//! Stick–slip of the forced oscillator as printed and exact, Fig. 8 of the paper.

use replication::figures::cli;
use replication::figures::fig08::FIG08;

fn main() -> std::process::ExitCode {
    cli::main(&FIG08)
}
