//! Work and precision of this solver beside other common ones.

fn main() -> std::process::ExitCode {
    replication::peers::main()
}
