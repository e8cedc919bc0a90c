//! The effect of the rounding of the captions of Figs. 10–12.

fn main() -> std::process::ExitCode {
    replication::captions::cli::main()
}
