//! The verdict on every claim of the paper.

fn main() -> std::process::ExitCode {
    replication::report::cli::main()
}
