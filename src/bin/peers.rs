//! Work and precision of this solver beside those that people use now.

fn main() -> std::process::ExitCode {
    replication::peers::main()
}
