//! Stick–slip of the forced oscillator as printed and exact, Fig. 8 of the paper.

fn main() -> std::process::ExitCode {
    replication::figures::cli::main(&replication::figures::fig08::FIG08)
}
