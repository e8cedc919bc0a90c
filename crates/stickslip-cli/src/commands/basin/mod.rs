//! `stickslip basin`: which attractor each of many starts leads to.

mod figure;
mod found;
mod request;
mod starts;

use std::num::NonZeroUsize;

use super::Failure;
use super::arguments::{RunArguments, count, seed};
use super::sweeping::{SweepArguments, check_period, sweep};
use crate::terminal::Said;
pub(super) use request::Basin;

/// Find which attractor each of many starts in a plane leads to
///
/// Attractors are found by recurrence; none need be named. "Recurrent" is one that comes back near to everywhere that it has been and never
/// closes: quasi-periodic or chaotic, which `lyapunov` tells. Starts that escape, fail or are undecided have rows of their own and no number.
/// Writes basin.csv with all starts, attractors.csv with the shares and their standard errors, and basin.svg. Finished blocks are in sweep/:
/// after a kill the same command goes on from there.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Range of the first coordinate of the starts; default: the first state, with its range in the file
    #[arg(long, value_name = "STATE=LOW:HIGH")]
    x: Option<String>,

    /// Range of the second coordinate; default: the second state, with its range in the file
    #[arg(long, value_name = "STATE=LOW:HIGH")]
    y: Option<String>,

    /// Starts in the middle of so many cells along each coordinate
    #[arg(long, value_name = "COLUMNSxROWS", default_value = "100x100")]
    grid: String,

    /// So many random starts instead of a grid
    #[arg(long, value_name = "NUMBER", value_parser = count, conflicts_with = "grid")]
    random: Option<NonZeroUsize>,

    /// Seed of random starts; default 1
    #[arg(long, value_name = "SEED", value_parser = seed)]
    seed: Option<u64>,

    /// Time after which an orbit that has come to no attractor is called undecided
    #[arg(long, value_name = "TIME", default_value_t = 2000.0)]
    until: f64,

    #[command(flatten)]
    sweep: SweepArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    let system = arguments.run.system()?;
    check_period(&system)?;
    let wanted = Basin::new(arguments, &system)?;
    sweep(&wanted, &system, &arguments.sweep, &arguments.run.output)
}
