//! Search over how Figs. 10–12 of the paper can be read.

fn main() -> std::process::ExitCode {
    replication::readings::main()
}
