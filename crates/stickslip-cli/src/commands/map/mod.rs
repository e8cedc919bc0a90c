//! `stickslip map`: what an orbit comes to, over two parameters.

mod cell;
mod figure;
mod found;
mod request;

use super::Failure;
use super::arguments::RunArguments;
use super::sweeping::{SweepArguments, check_period, sweep};
use crate::terminal::Said;
pub(super) use request::Map;

/// Show what the orbit from the start comes to, over a plane of two parameters
///
/// For each cell: the attractor by its kind and sequence of phases, the largest Lyapunov exponent, and the part of time in stick. Writes map.csv and
/// map.svg. Finished blocks are in sweep/: after a kill the same command goes on from there.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Range of the first parameter
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    x: String,

    /// Range of the second parameter
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    y: String,

    /// Number of cells along each parameter; the values are those in their middles
    #[arg(long, value_name = "COLUMNSxROWS", default_value = "60x60")]
    grid: String,

    /// Time after which an orbit that has come to no attractor is called undecided
    #[arg(long, value_name = "TIME", default_value_t = 2000.0)]
    until: f64,

    /// Time over which the Lyapunov exponent is measured, on the attractor
    #[arg(long, value_name = "TIME", default_value_t = 500.0)]
    duration: f64,

    #[command(flatten)]
    sweep: SweepArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    let system = arguments.run.system()?;
    check_period(&system)?;
    let wanted = Map::new(arguments, &system)?;
    sweep(&wanted, &system, &arguments.sweep, &arguments.run.output)
}
