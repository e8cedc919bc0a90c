//! Error of a located event against the step.

use std::process::ExitCode;

use stickslip::figures::cli;
use stickslip::figures::locator::Locator;

fn main() -> ExitCode {
    cli::main::<Locator>()
}
