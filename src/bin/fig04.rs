//! Orbits and limit cycle of the belt oscillator, Fig. 4 of the paper.

fn main() -> std::process::ExitCode {
    replication::figures::cli::main(&replication::figures::fig04::FIG04)
}
