//! Tangent points, Fig. 7 of the paper.

fn main() -> std::process::ExitCode {
    replication::figures::cli::main(&replication::figures::fig07::FIG07)
}
