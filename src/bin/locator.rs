//! Error of a located event against the step.

fn main() -> std::process::ExitCode {
    replication::figures::cli::main(&replication::figures::locator::LOCATOR)
}
