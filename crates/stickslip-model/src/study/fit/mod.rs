//! Parameters, starts and offsets of a system fitted to measured motion.

mod crossing;
mod directions;
mod errors;
mod grazes;
mod noise;
mod parts;
mod problem;
mod record_run;
mod result;
mod seen;
mod shooting;
mod starts;
mod statistics;
mod uncertainty;
mod unknowns;
mod work;

use crate::study::least_squares::{
    LeastSquares, LeastSquaresEnd, LeastSquaresSettings, Loss, least_squares,
};
use rayon::prelude::*;
use std::sync::Arc;
use stickslip::dynamics::{Interrupt, Matrix, Modes, Vector};
use stickslip::{Error, Options};

use crossing::beyond_events;
pub use errors::FitError;
use problem::{FitProblem, Sequence};
use record_run::ObservedJump;
pub use seen::{SeenModes, SeenPhase};
use starts::Begun;
pub use statistics::RunsTest;
pub use uncertainty::FitUncertainty;
use work::FitWork;

use crate::file::SystemFile;

/// A measured quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Observable {
    /// Name of its column.
    pub name: String,
    /// Formula of time, states, inputs and parameters.
    pub formula: String,
    /// Standard deviation of its noise; estimated from the residuals where there is none.
    pub sigma: Option<f64>,
}

/// One measured record.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Name in messages.
    pub name: String,
    /// Times, rising.
    pub times: Vec<f64>,
    /// A column for each observable. NaN is a missing value.
    pub columns: Vec<Vec<f64>>,
    /// Values of parameters in this record alone.
    pub set: Vec<(String, f64)>,
    /// Start values of states in this record alone.
    pub start: Vec<(String, f64)>,
    /// Time of the start; default as in the file.
    pub t_start: Option<f64>,
    /// Times and values of tables of inputs in this record alone.
    pub inputs: Vec<(String, Vec<f64>, Vec<f64>)>,
}

/// A parameter, a state for its start value, or `t0` for the time of the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Name.
    pub name: String,
    /// Value at which the search begins; default as in the file.
    pub start: Option<f64>,
    /// Bounds, within the range that the file gives.
    pub bounds: (f64, f64),
    /// Whether each record has its own value, as starts always have.
    pub each: bool,
}

/// Data, model and settings of a fit.
#[derive(Clone, Debug)]
pub struct FitRequest {
    /// The system.
    pub file: SystemFile,
    /// Values of its parameters.
    pub set: Vec<(String, f64)>,
    /// Parameters of the observables alone, as offsets, with their values.
    pub extra: Vec<(String, f64)>,
    /// Measured quantities.
    pub observables: Vec<Observable>,
    /// Records.
    pub records: Vec<Record>,
    /// Fitted numbers.
    pub unknowns: Vec<Unknown>,
    /// Weight of large residuals.
    pub loss: Loss,
    /// Number of starts within the bounds, besides the given one.
    pub search: usize,
    /// Parts of each record for multiple shooting, before the search; 0 or 1 for none.
    pub segments: usize,
    /// Most evaluations from one start, all stages of the search together. An evaluation is a run
    /// of all records.
    pub most_evaluations: usize,
    /// Options of the solver.
    pub options: Options,
    /// Ends the fit when raised.
    pub interrupt: Option<Arc<Interrupt>>,
}

/// A fitted value.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedValue {
    /// Name; with several records `x@2` is that of the second.
    pub name: String,
    /// Value at which the search began.
    pub start: f64,
    /// Value.
    pub value: f64,
    /// Bounds.
    pub bounds: (f64, f64),
    /// Whether the value is one of the bounds.
    pub is_at_bound: bool,
    /// Standard error, if there is one.
    pub std_error: Option<f64>,
    /// Interval that contains the true value in 95 of 100 fits, if the model is linear in it.
    pub interval: Option<(f64, f64)>,
}

impl FittedValue {
    /// Whether a value, that of another minimum for instance, is one of the bounds.
    pub fn is_bound(&self, value: f64) -> bool {
        value <= self.bounds.0 || value >= self.bounds.1
    }
}

/// One column of a record at the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedColumn {
    /// Index of the record, from 0.
    pub record: usize,
    /// Index of the observable, from 0.
    pub observable: usize,
    /// Values at the times of the record.
    pub model: Vec<f64>,
    /// Data minus model; NaN where a value is missing.
    pub residuals: Vec<f64>,
    /// Number of values.
    pub count: usize,
    /// Root of the mean square of the residuals.
    pub rms: f64,
    /// Standard deviation of the noise, given or estimated.
    pub sigma: f64,
    /// Test of the order of the signs of the residuals, where there are enough of them.
    pub runs: Option<RunsTest>,
    /// Phases whose residuals are too large, with 1 % of false alarms in all phases together.
    pub off: Vec<PhaseOff>,
}

/// A phase in which the residuals of a column are too large for its noise.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseOff {
    /// Index of the phase, from 0.
    pub phase: usize,
    /// Number of values in it.
    pub count: usize,
    /// Root of the mean square of their residuals over the deviation of the noise.
    pub ratio: f64,
    /// Chance that noise alone has as large residuals.
    pub p_value: f64,
}

/// Another minimum that the search has found.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherMinimum {
    /// Values of the unknowns.
    pub values: Vec<f64>,
    /// Cost, as [`Fit::cost`].
    pub cost: f64,
}

/// Result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Fitted values.
    pub values: Vec<FittedValue>,
    /// Uncertainties and what the data do not determine.
    pub uncertainty: FitUncertainty,
    /// Columns of all records.
    pub columns: Vec<FittedColumn>,
    /// Start, end and modes of the phases of each record.
    pub phases: Vec<Vec<(f64, f64, Modes)>>,
    /// Modes that the data of a record show, where a column shows those of a contact.
    pub seen: Vec<SeenModes>,
    /// Times of each record.
    pub times: Vec<Vec<f64>>,
    /// Half the weighted sum of squares of the residuals over their standard deviations.
    pub cost: f64,
    /// Largest mismatch of two parts, over the spread of the state, with multiple shooting that
    /// ends in parts.
    pub mismatch: Option<f64>,
    /// Number of values minus number of unknowns.
    pub freedom: usize,
    /// Reason for the end of the search.
    pub end: LeastSquaresEnd,
    /// Steps, in all stages of the search for this minimum; so are the numbers below.
    pub steps: usize,
    /// Evaluations, each of which runs all records.
    pub evaluations: usize,
    /// Evaluations that failed, each of which shortened a step.
    pub failures: usize,
    /// Steps that changed the sequence of phases.
    pub crossings: usize,
    /// Changes of the sequence at which the residuals jump.
    pub jumps: usize,
    /// Grazing impacts on the straight way from the start to the result, at which the residuals
    /// have a square root; `None` in parts, which have no single way.
    pub grazes: Option<usize>,
    /// Further minima, by rising cost.
    pub others: Vec<OtherMinimum>,
}

/// Words for the end of a search.
pub fn ending(end: LeastSquaresEnd) -> &'static str {
    match end {
        LeastSquaresEnd::Cost => "the sum of squares stays",
        LeastSquaresEnd::Step => "the values stay",
        LeastSquaresEnd::Gradient => "the residuals are orthogonal to their derivatives",
        LeastSquaresEnd::Change => "the sequence of phases changes at the minimum",
        LeastSquaresEnd::Evaluations => "not converged",
        LeastSquaresEnd::NotFinite => "no derivatives where it begins",
    }
}

/// Relative change of the estimated deviations at which they are final, and most rounds.
const SAME_SIGMA: f64 = 1e-3;
const MOST_ROUNDS: usize = 20;

/// Starts of a search from which minima are sought: the best of them. It is chosen.
const SEARCHED_FROM: usize = 8;

/// Relative tolerance of the search: some hundred times the error of derivatives.
const TOLERANCE: f64 = 1e-10;

/// Fits the unknowns of a request by weighted least squares on exact derivatives.
///
/// # Errors
/// [`FitError`].
pub fn fit(request: &FitRequest) -> Result<Fit, FitError> {
    let mut problem = FitProblem::new(request)?;
    let settings = LeastSquaresSettings {
        bounds: problem.unknowns.bounds(),
        loss: request.loss,
        tolerance: TOLERANCE,
        most_evaluations: request.most_evaluations.max(1),
    };
    let given = problem.unknowns.start();
    let starts = match request.search {
        0 => problem.given_starts(given, &settings)?,
        count => problem.best_starts(&given, count, SEARCHED_FROM, &settings)?,
    };
    problem.check_interrupt()?;
    if request.segments > 1
        && let Some((start, evaluations)) = starts.first()
    {
        let mut work = FitWork::of_at_most(settings.most_evaluations);
        work.evaluations = *evaluations;
        return shooting::fit_in_parts(&mut problem, start, &settings, work);
    }
    let work = FitWork::of_at_most(settings.most_evaluations);
    let mut minima = minima(&problem, &starts, &settings)?;
    let others = minima.split_off(1.min(minima.len()));
    let best = minima.pop().ok_or(FitError::NoData)?;
    finished(&mut problem, best, &settings, work, others)
}

/// Distinct minima from some starts, by rising cost.
fn minima(
    problem: &FitProblem<'_>,
    starts: &[Begun],
    settings: &LeastSquaresSettings,
) -> Result<Vec<LeastSquares<Sequence>>, FitError> {
    let searches = starts.par_iter();
    let searches = searches.map(|(start, before)| {
        let settings = LeastSquaresSettings {
            most_evaluations: settings.most_evaluations.saturating_sub(*before).max(1),
            ..settings.clone()
        };
        let mut found = least_squares(start, &settings, |x| problem.residuals(x))?;
        found.evaluations += before;
        Ok(found)
    });
    let searches: Vec<Result<LeastSquares<Sequence>, _>> = searches.collect();
    problem.check_interrupt()?;
    let (mut found, mut first_error) = (Vec::new(), None);
    for search in searches {
        match search {
            Ok(one) => found.push(one),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    found.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    let mut distinct: Vec<LeastSquares<Sequence>> = Vec::new();
    for one in found {
        let is_same = |known: &LeastSquares<Sequence>| problem.unknowns.is_same(&known.x, &one.x);
        if !distinct.iter().any(is_same) {
            distinct.push(one);
        }
    }
    match first_error {
        Some(error) if distinct.is_empty() => Err(problem.failed(error)),
        _ => Ok(distinct),
    }
}

/// Estimates the noise, weighs by it, and describes the minimum.
fn finished(
    problem: &mut FitProblem<'_>,
    mut best: LeastSquares<Sequence>,
    settings: &LeastSquaresSettings,
    mut work: FitWork,
    others: Vec<LeastSquares<Sequence>>,
) -> Result<Fit, FitError> {
    work.add(&best);
    best = beyond_events(problem, best, settings, &mut work);
    for _ in 0..MOST_ROUNDS {
        let scales = problem.sigmas.clone();
        let largest = problem.estimate_sigmas(&best.at.values);
        if scales == problem.sigmas {
            break;
        }
        let Some(left) = work.settings_left(settings) else {
            best.end = LeastSquaresEnd::Evaluations;
            break;
        };
        let again = least_squares(&best.x, &left, |x| problem.residuals(x));
        let again = again.map_err(|error| problem.failed(error))?;
        work.add(&again);
        let again = beyond_events(problem, again, settings, &mut work);
        best = LeastSquares {
            // The first search has converged, whatever rounding lets the second find.
            end: match (again.steps, again.end) {
                (_, LeastSquaresEnd::Evaluations) => again.end,
                (0, _) => best.end,
                _ => again.end,
            },
            ..again
        };
        problem.check_interrupt()?;
        if largest <= SAME_SIGMA {
            break;
        }
    }
    let uncertainty = FitUncertainty::of(problem, &best);
    problem.check_interrupt()?;
    let others = others.into_iter().map(|one| OtherMinimum {
        values: one.x.as_slice().to_vec(),
        cost: problem.cost(&one.x).unwrap_or(f64::NAN),
    });
    let others = others.collect();
    problem.result(&best, work, uncertainty, others)
}

/// Values and derivatives of all columns of all records.
#[derive(Clone, Debug)]
pub(crate) struct Modelled {
    /// Values by record, column and time.
    pub(crate) values: Vec<Vec<Vec<f64>>>,
    /// Sizes of what the states contribute to them.
    sizes: Vec<Vec<Vec<f64>>>,
    /// Residuals over deviations, without missing values.
    pub(crate) residuals: Vector,
    /// Derivatives of the residuals.
    pub(crate) jacobian: Matrix,
    /// States at the times of each record.
    points: Vec<Vec<Vector>>,
    /// Phases of each record.
    pub(crate) phases: Vec<Vec<(f64, f64, Modes)>>,
    /// Events of each record, or part, at which an observable jumps.
    jumps: Vec<Vec<ObservedJump>>,
    /// Record without derivatives, and the time and reason of their loss.
    pub(crate) lost: Option<(usize, Error)>,
}

impl Modelled {
    /// Modes of the phases of each record.
    fn sequence(&self) -> Sequence {
        let modes = |phases: &Vec<(f64, f64, Modes)>| phases.iter().map(|one| one.2).collect();
        self.phases.iter().map(modes).collect()
    }
}
