//! `stickslip continue`: a periodic orbit followed along a parameter.

mod branch;
mod figure;
mod told;

use std::num::NonZeroUsize;

use stickslip::analysis::ContinuationSettings;

use super::arguments::{Ready, RunArguments, count};
use super::range::ParameterRange;
use super::search::SearchArguments;
use super::{Failure, Found};
use crate::terminal::{Said, patiently};
use branch::Begin;
use told::Told;

/// Continue a periodic orbit along a parameter, stable or not, through folds and changes of its phases
///
/// The orbit is found at the parameter's present value (that of the file, or of --set) and followed both ways by pseudo-arclength. Where a
/// multiplier is 1 or -1 or a pair is on the unit circle, and where the phases change, the place is located and named; so is an end in an
/// equilibrium, on the boundary or off it, a homoclinic orbit or rest. Of a driven system the parameter may be one that the period depends on. Writes
/// branch.csv, special.csv and continue.svg.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The parameter and the range in which the branch is followed
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    parameter: String,

    /// First and longest step, as a part of the range and of the orbit's size
    #[arg(long, value_name = "PART", default_value_t = 0.02)]
    step: f64,

    /// Orbits on the branch, at most this many each way
    #[arg(long, value_name = "NUMBER", value_parser = count, default_value = "1000")]
    points: NonZeroUsize,

    #[command(flatten)]
    search: SearchArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    arguments.run.answered(|ready| found(arguments, ready))
}

fn found(arguments: &Arguments, ready: &Ready) -> Result<Found, Failure> {
    let Ready {
        system, options, ..
    } = ready;
    let range = ParameterRange::new("--parameter", &arguments.parameter, system)?;
    let begin = Begin::at(system, &range)?;
    let settings = ContinuationSettings {
        step: arguments.step,
        most_points: arguments.points.get(),
        ..ContinuationSettings::over(range.low, range.high)
    };
    settings.check()?;
    let (orbit, periods) = arguments
        .search
        .found(system, (ready.t, &ready.x), options)?;
    let branch = patiently("following the branch", |telling| {
        begin.branch(&orbit, periods, &settings, options, telling)
    })?;
    let told = Told {
        system,
        range: &range,
        branch: &branch,
        family: orbit.family,
    };
    told.found()
}
