//! Error of a located event against the step.

use replication::figures::cli;
use replication::figures::locator::LOCATOR;

fn main() -> std::process::ExitCode {
    cli::main(&LOCATOR)
}
