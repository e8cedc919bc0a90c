//! `stickslip continue`: a periodic orbit followed along a parameter.

mod branch;
mod curves;
mod ends;
mod equilibria;
mod figure;
mod report;
mod saving;
mod special;
mod tables;

use std::num::NonZeroUsize;

use serde::Serialize;
use stickslip::analysis::ContinuationSettings;
use stickslip_kernels::file::System;

use super::arguments::{Ready, RunArguments, SolverArguments, StartArguments, count};
use super::range::ParameterRange;
use super::search::SearchArguments;
use super::sweeping::{folder, plan};
use crate::failure::Failure;
use crate::render::{Answer, Report};
use crate::sweep::{Share, Writer};
use crate::terminal::patiently;
use branch::Begin;

/// Continue a periodic orbit or an equilibrium along a parameter, stable or not, through folds and
/// changes of its phases
///
/// The orbit is located at the parameter's present value, of the file or of --set, and followed
/// both ways by pseudo-arclength. A place is located and named where a multiplier is 1 or -1 or a
/// pair is on the unit circle, and where the phases change. So is an end of the branch in an
/// equilibrium, on the boundary or off it, a two-fold, a homoclinic orbit, or a motion at rest. The
/// period of a drive may depend on the parameter.
///
/// With --also, each of these places but branch points is followed in two parameters. With
/// --branches, the tables have a column `branch`: 0 is the branch through the orbit, and the others
/// are in the order of where they begin. The column `branches` of special.csv has the numbers of
/// those that begin at an orbit. A branch of one orbit could not be followed from there.
///
/// With --equilibrium, the equilibrium that the run comes to is followed, into the sliding field
/// and out of it, too. Folds, branch points, Hopf bifurcations and boundary equilibria are located.
///
/// Writes branch.csv, special.csv and continue.svg; with --also curves.csv and curves.svg; with
/// --equilibrium equilibria.csv, equilibria-special.csv and equilibria.svg. The branch is saved in
/// sweep/ as it is followed, and so is each curve and each other branch when it is complete: after
/// a kill the same command goes on from there, and --also or --branches added to a finished command
/// use what is saved.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The parameter and the range in which the branch is followed
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    parameter: String,

    /// A second parameter and its range: each fold, flip, Neimark-Sacker bifurcation and change of
    /// the phases on the branch is followed in both
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    also: Option<String>,

    /// Follow the branches that begin at flips, of twice the period, and at branch points, too
    #[arg(long)]
    branches: bool,

    /// First and longest step, as a part of the range and of the orbit's size
    #[arg(long, value_name = "PART", default_value_t = 0.02)]
    step: f64,

    /// Orbits on the branch, at most this many each way
    #[arg(long, value_name = "NUMBER", value_parser = count, default_value = "1000")]
    points: NonZeroUsize,

    /// Follow the equilibrium that the run comes to, or with --transient 0 the one near the start
    #[arg(long, conflicts_with_all = ["also", "branches", "periods", "longest"])]
    equilibrium: bool,

    #[command(flatten)]
    search: SearchArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let ready = arguments.run.ready()?;
    if arguments.equilibrium {
        return arguments.run.answered(|ready| equilibria(arguments, ready));
    }
    let outcome = continued(arguments, &ready).map_err(|failure| failure.of(&ready.system));
    let (report, writer) = outcome?;
    Ok(report.written(&writer.store.staging()?, &arguments.run.output)?)
}

/// Range of the parameter, and settings of the continuation.
fn settings(
    arguments: &Arguments,
    system: &System,
) -> Result<(ParameterRange, ContinuationSettings), Failure> {
    let range = ParameterRange::new("--parameter", &arguments.parameter, system)?;
    let settings = ContinuationSettings {
        step: arguments.step,
        most_points: arguments.points.get(),
        ..ContinuationSettings::over(range.low, range.high)
    };
    settings.check()?;
    Ok((range, settings))
}

fn equilibria(arguments: &Arguments, ready: &Ready) -> Result<Report, Failure> {
    let (system, options) = (&ready.system, &ready.options);
    let (range, settings) = settings(arguments, system)?;
    let begin = Begin::at(system, &range)?;
    let x = arguments.search.equilibrium(system, &ready.x, options)?;
    let branches = begin.equilibria(&x, &settings, options)?;
    equilibria::report(system, &range, branches)
}

/// Everything that the branch depends on, except the system.
#[derive(Serialize)]
struct Wanted<'a> {
    parameter: &'a ParameterRange,
    step: f64,
    points: NonZeroUsize,
    search: &'a SearchArguments,
    start: &'a StartArguments,
    solver: &'a SolverArguments,
}

/// Number of directions along the branch. Each is saved in a block.
const WAYS: NonZeroUsize = NonZeroUsize::MIN.saturating_add(1);

/// Follows the branch and what begins on it, and reports them.
fn continued(arguments: &Arguments, ready: &Ready) -> Result<(Report, Writer), Failure> {
    let Ready {
        system, options, ..
    } = ready;
    let (range, settings) = settings(arguments, system)?;
    let begin = Begin::at(system, &range)?;
    let also = arguments.also.as_deref();
    let also = also.map(|text| ParameterRange::new("--also", text, system));
    let also = also.transpose()?;
    let also = also.map(|other| begin.also(other)).transpose()?;
    let wanted = Wanted {
        parameter: &range,
        step: arguments.step,
        points: arguments.points,
        search: &arguments.search,
        start: &arguments.run.start,
        solver: &arguments.run.solver,
    };
    let plan = plan("continue", &wanted, (WAYS, NonZeroUsize::MIN), system)?;
    let folder = folder(&arguments.run.output.out);
    Writer::check(&folder, &plan)?;
    let (orbit, periods) = arguments
        .search
        .periodic_orbit(system, (ready.t, &ready.x), options)?;
    let writer = Writer::open(&folder, &plan, Share::WHOLE)?;
    let branch = patiently("following the branch", |status| {
        begin.branch((&orbit, periods), &settings, options, (&writer, status))
    })?;
    let others = arguments.branches.then(|| {
        patiently("following the other branches", |_| {
            begin.others((&orbit, periods), &branch, (&settings, options), &writer)
        })
    });
    let others = others.transpose()?;
    let mut report = report::of(system, &range, (&branch, orbit.family), others.as_deref())?;
    if let Some(also) = also {
        let curves = patiently("following the special orbits in two parameters", |_| {
            let how = (&settings, options);
            begin.curves(&also, (&orbit, periods), &branch, how, &writer)
        })?;
        curves::report(&mut report, system, &range, &also, &curves)?;
    }
    Ok((report, writer))
}
