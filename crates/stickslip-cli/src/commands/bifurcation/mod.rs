//! `stickslip bifurcation`: attractors over one parameter, up and down.

mod figure;
mod found;
mod request;

use std::num::NonZeroUsize;

use super::Failure;
use super::arguments::{RunArguments, count};
use super::sweeping::{SweepArguments, check_period, sweep};
use crate::terminal::Said;
pub(super) use request::Bifurcation;

/// Follow attractors over a parameter, up and down, each from the state reached at the value before
///
/// For each value: the points of the section, the sequence of phases, durations and lengths of stick, and the largest Lyapunov exponent. Where
/// both ways differ, there is more than one attractor. A change of the phases is located and named by the event function that vanishes there; where
/// none does, by the multiplier on the unit circle: a fold, flip, Neimark-Sacker bifurcation or branch point. Equilibria are followed to where they lose
/// their stability or come to the boundary. Where one orbit ends and the run comes to another one, that began elsewhere, both places are told. Writes
/// bifurcation.csv, sticks.csv, changes.csv and bifurcation.svg. In changes.csv `before` and `after` are the phases of the orbit that is followed
/// through the change; where it is unstable behind it, the attractor there is another one, whose phases bifurcation.csv has. Finished blocks are in sweep/: after a kill the same
/// command goes on from there.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The parameter and its range
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    parameter: String,

    /// Number of values, both ends among them
    #[arg(long, value_name = "NUMBER", value_parser = count, default_value = "201")]
    values: NonZeroUsize,

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
    let wanted = Bifurcation::new(arguments, &system)?;
    sweep(&wanted, &system, &arguments.sweep, &arguments.run.output)
}
