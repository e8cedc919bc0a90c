//! Chaotic motion of the block and the bracket, Fig. 12 of the paper.

fn main() -> std::process::ExitCode {
    replication::figures::cli::main(&replication::figures::block_and_bracket::FIG12)
}
