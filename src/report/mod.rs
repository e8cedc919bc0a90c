//! The report: the verdict on every claim of the paper, by computation, with its reasons.
//!
//! [`ledger::Ledger::compute`] makes all of it; everything else here is a part of that: what
//! readings give for a claim ([`finding`]) and what that comes to ([`verdict`]), evidence for
//! statements ([`evidence`], [`accuracy`]), the cause of Fig. 8's numbers ([`cause`], [`matrix`],
//! [`convergence`]), the search for what Fig. 8 shows in the stated model ([`scan`]), the
//! estimator's spread in Figs. 10–12 ([`spread`]) and the misprints ([`errata`]). [`page`] and
//! [`readme`] show it.

pub mod accuracy;
pub mod cause;
pub mod cli;
pub mod convergence;
pub mod digits;
mod draw;
pub mod errata;
pub mod evidence;
pub mod exponent;
pub mod figures;
pub mod finding;
pub mod ledger;
pub mod matrix;
pub mod page;
pub mod readme;
pub mod scan;
mod sentences;
pub mod spread;
pub mod tables;
pub mod verdict;

use crate::figures::FigureError;
use crate::paper::bounded;
use crate::paper::published::PublishedError;
use crate::readings::ReadingsError;
use stickslip::analysis::{Visibility, tangency};
use stickslip::models::BeltOscillator;
use stickslip::{
    Error, Failure, Filippov, Mode, Orbit, Phase, Side, State, Transition, TransitionKind, solve,
};

/// What failed on the way to the report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A figure, or a file that could not be written.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The solver.
    #[error("cannot make the ledger: {0}")]
    Solver(#[from] Error),
    /// The table of claims is not sound.
    #[error("cannot make the ledger: {0}")]
    Published(#[from] PublishedError),
    /// The committed search over readings is not whole.
    #[error("cannot make the ledger: {0}")]
    Readings(#[from] ReadingsError),
}

impl<R> From<Failure<R>> for ReportError {
    fn from(failure: Failure<R>) -> ReportError {
        ReportError::Solver(failure.error)
    }
}

/// The orbit of model 2 or another from a time and a state over a span, as far as it goes before it
/// escapes, and whether it does.
fn until_escape<S: Filippov<2>>(
    system: &S,
    (t0, x): (f64, State<2>),
    span: f64,
    tolerance: f64,
) -> Result<(Orbit<2>, bool), Error> {
    match solve(system, t0, x, t0 + span, &bounded(tolerance)) {
        Ok(orbit) => Ok((orbit, false)),
        Err(failure) if matches!(failure.error, Error::Escaped { .. }) => {
            Ok((*failure.reached, true))
        }
        Err(failure) => Err(failure.into()),
    }
}

/// The releases from stick in an orbit, each with the side that takes over and the phase it ends.
fn stick_exits(orbit: &Orbit<2>) -> impl Iterator<Item = (&Transition<2>, Side, &Phase<2>)> {
    orbit
        .transitions
        .iter()
        .filter_map(|at| match (at.kind, at.to) {
            (TransitionKind::StickExit, Mode::Slip(side)) => {
                let phase = orbit.sticks().find(|phase| phase.t_end == at.t)?;
                Some((at, side, phase))
            }
            _ => None,
        })
}

/// So many places on the belt, evenly from `-outer` to `outer` (m), amid equal parts.
fn places(outer: f64, count: u32, belt_speed: f64) -> impl Iterator<Item = State<2>> {
    (0..count).map(move |k| {
        let part = 2.0 * (f64::from(k) + 0.5) / f64::from(count) - 1.0;
        State::from([outer * part, belt_speed])
    })
}

/// How a field of model 1 is tangent to Σ at a position (m), if one is.
fn tangent_at(model: &BeltOscillator, x1: f64) -> Option<Visibility> {
    let x = State::from([x1, model.belt_speed]);
    let mut sides = [Side::Below, Side::Above].into_iter();
    sides.find_map(|side| tangency(model, side, 0.0, &x))
}
