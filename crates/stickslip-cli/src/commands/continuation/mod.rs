//! `stickslip continue`: a periodic orbit followed along a parameter.

mod branch;
mod curves;
mod ends;
mod equilibria;
mod equilibrium_curves;
mod figure;
mod report;
mod saving;
mod special;
mod tables;

use std::num::NonZeroUsize;

use serde::Serialize;
use stickslip::analysis::ContinuationSettings;
use stickslip_model::file::System;

use super::arguments::{PreparedRun, RunArguments, SolverArguments, StartArguments, count};
use super::range::ParameterRange;
use super::search::SearchArguments;
use super::sweeping::{ResumeArguments, folder, plan};
use crate::failure::Failure;
use crate::render::{CommandOutput, Report};
use crate::sweep::{Share, Writer};
use branch::BranchStart;
use output::terminal::with_spinner;

/// Continue a periodic orbit or an equilibrium along a parameter, stable or not, through folds and
/// changes of its phases
///
/// The branch begins at the parameter's value in the file, or at that of --set. It is followed in
/// both directions by pseudo-arclength continuation. Orbits with a multiplier 1 or -1, or with a
/// pair on the unit circle, are located and named. So are changes of the phases. Ends of the branch
/// are located, too: equilibria, on a boundary or off it, two-folds, homoclinic orbits, and rest.
/// The period of a drive may depend on the parameter.
///
/// --also follows each of these special orbits, except branch points, in two parameters, and names
/// special points on the curves: cusps, resonances, and where two conditions meet. Ends of the
/// branch at homoclinic orbits and two-folds are followed, too.
///
/// --branches adds a column `branch` to the tables: 0 is the branch through the orbit, and the
/// others are in the order of their beginnings. The column `branches` of special.csv has the
/// numbers of the branches that begin at an orbit. A branch of one orbit could not be followed from
/// there. With --depth 2 the flips of these branches are followed, too, and so on. A bubble, a
/// branch that ends in another flip of the branch on which it begins, is listed once.
///
/// --equilibrium follows the equilibrium that the run approaches, also into the sliding field and
/// out of it. Folds, branch points, Hopf bifurcations and boundary equilibria are located. With
/// --also, they are followed in two parameters, except branch points.
///
/// Writes branch.csv, special.csv and continue.svg; with --also curves.csv, curves-special.csv and
/// curves.svg; with --equilibrium equilibria.csv, equilibria-special.csv and equilibria.svg.
///
/// The branch is saved in sweep/ as it is followed, each curve and each further branch when it is
/// complete. After a kill, the same command resumes from there. --also or --branches can be added
/// to a finished command, which then uses what is saved.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The parameter and the range in which the branch is followed
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    parameter: String,

    /// A second parameter and its range: each fold, flip, Neimark-Sacker bifurcation and change of
    /// the phases on the branch is followed in both, and its end if that is a homoclinic orbit or a
    /// two-fold; or with --equilibrium each fold, Hopf bifurcation and boundary equilibrium
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    also: Option<String>,

    /// Also follow the branches that begin at flips, with twice the period, and at branch points
    #[arg(long)]
    branches: bool,

    /// Generations of --branches: at 2 the flips of these branches are followed, too, and so on
    #[arg(long, value_name = "NUMBER", value_parser = count, default_value = "1")]
    #[arg(requires = "branches")]
    depth: NonZeroUsize,

    /// First and longest step, as a fraction of the range and of the orbit's size
    #[arg(long, value_name = "PART", default_value_t = 0.02)]
    step: f64,

    /// Largest number of orbits in each direction
    #[arg(long, value_name = "NUMBER", value_parser = count, default_value = "1000")]
    points: NonZeroUsize,

    /// Follow the equilibrium that the run approaches, or with --transient 0 the one near the start
    #[arg(long, conflicts_with_all = ["branches", "depth", "periods", "longest"])]
    equilibrium: bool,

    #[command(flatten)]
    search: SearchArguments,
    #[command(flatten)]
    resume: ResumeArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    if arguments.equilibrium {
        if arguments.resume.fresh {
            Writer::remove_sweep(&folder(&arguments.run.output.out), COMMAND)?;
        }
        return arguments
            .run
            .with_report(|prepared| equilibria(arguments, prepared));
    }
    let prepared = arguments.run.prepared()?;
    let outcome = continued(arguments, &prepared).map_err(|failure| failure.of(&prepared.system));
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

fn equilibria(arguments: &Arguments, prepared: &PreparedRun) -> Result<Report, Failure> {
    let (system, options) = (&prepared.system, &prepared.options);
    let (range, settings) = settings(arguments, system)?;
    let begin = BranchStart::at(system, &range)?;
    let x = arguments.search.equilibrium(system, &prepared.x, options)?;
    let branch = begin.along.equilibria(&x, &settings, options)?;
    let mut report = equilibria::report(system, &range, &branch)?;
    if let Some(also) = begin.also(arguments)? {
        let second = (&also.both, also.value, (also.range.low, also.range.high));
        let curves = branch.curves(second, &settings)?;
        equilibrium_curves::report(&mut report, system, (&range, &also), &branch, &curves)?;
    }
    Ok(report)
}

/// Everything that the branch depends on, except the system.
#[derive(Serialize)]
struct BranchArguments<'a> {
    parameter: &'a ParameterRange,
    step: f64,
    points: NonZeroUsize,
    search: &'a SearchArguments,
    start: &'a StartArguments,
    solver: &'a SolverArguments,
}

/// The command in the manifest of a branch.
const COMMAND: &str = "continue";

/// Number of directions along the branch. Each is saved in a block.
const DIRECTIONS: NonZeroUsize = NonZeroUsize::MIN.saturating_add(1);

/// Follows the branch and what begins on it, and reports them.
fn continued(arguments: &Arguments, prepared: &PreparedRun) -> Result<(Report, Writer), Failure> {
    let PreparedRun {
        system, options, ..
    } = prepared;
    let (range, settings) = settings(arguments, system)?;
    let begin = BranchStart::at(system, &range)?;
    let also = begin.also(arguments)?;
    let wanted = BranchArguments {
        parameter: &range,
        step: arguments.step,
        points: arguments.points,
        search: &arguments.search,
        start: &arguments.run.start,
        solver: &arguments.run.solver,
    };
    let plan = plan(COMMAND, &wanted, (DIRECTIONS, NonZeroUsize::MIN), system)?;
    let folder = folder(&arguments.run.output.out);
    if !arguments.resume.fresh {
        Writer::check(&folder, &plan)?;
    }
    let (orbit, _) = arguments
        .search
        .periodic_orbit(system, (prepared.t, &prepared.x), options)?;
    arguments.resume.prepare(&folder, &plan, Share::WHOLE)?;
    let writer = Writer::open(&folder, &plan, Share::WHOLE)?;
    let branch = with_spinner("following the branch", |status| {
        begin.branch(&orbit, &settings, options, (&writer, status))
    })?;
    let others = arguments.branches.then(|| {
        with_spinner("following the other branches", |_| {
            let how = (&settings, arguments.depth, options);
            begin.side_branches(&orbit, &branch, how, &writer)
        })
    });
    let others = others.transpose()?;
    let mut report = report::of(system, &range, &branch, others.as_deref())?;
    if let Some(also) = also {
        let curves = with_spinner("following the special orbits in two parameters", |_| {
            let how = (&settings, options);
            begin.curves(&also, &orbit, &branch, how, &writer)
        })?;
        curves::report(&mut report, system, &range, &also, &curves)?;
    }
    Ok((report, writer))
}
