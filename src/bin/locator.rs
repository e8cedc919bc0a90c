//! Error of a located event against the step.

use std::process::ExitCode;

use replication::figures::cli;
use replication::figures::locator::LOCATOR;

fn main() -> ExitCode {
    cli::main(&LOCATOR)
}
