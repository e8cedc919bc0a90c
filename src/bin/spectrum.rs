//! Lyapunov spectrum of a time series in a CSV file.

use std::process::ExitCode;

fn main() -> ExitCode {
    replication::spectrum_cli::main()
}
