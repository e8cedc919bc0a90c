//! What becomes of every claim of the paper.

fn main() -> std::process::ExitCode {
    replication::report::cli::main()
}
