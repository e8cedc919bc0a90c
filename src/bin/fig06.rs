//! The friction law, Fig. 6 of the paper.

fn main() -> std::process::ExitCode {
    replication::figures::cli::main(&replication::figures::fig06::FIG06)
}
