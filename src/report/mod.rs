//! The report: the verdict on every claim of the paper, by computation, with its reasons.
//!
//! [`ledger::Ledger::compute`] computes all of it:
//!
//! * the findings of the readings for a claim ([`finding`]) and their verdict ([`verdict`]);
//! * evidence for statements ([`evidence`], [`accuracy`]);
//! * the cause of Fig. 8's numbers ([`cause`], [`matrix`], [`convergence`]);
//! * the search for Fig. 8's motion in the stated model ([`scan`]);
//! * the estimator's spread in Figs. 10–12 ([`spread`]);
//! * the misprints ([`errata`]).
//!
//! [`page`] and [`readme`] show the results.

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

use crate::paper::bounded;
use crate::paper::models::{BeltOscillator, tangency};
use stickslip::{
    Error, Filippov, Mode, Orbit, Phase, Side, State, Transition, TransitionKind, Visibility, solve,
};

/// The orbit of model 2 or another from a time and a state over a span, or until it escapes, and
/// whether it does.
fn until_escape<S: Filippov<2>>(
    system: &S,
    (t0, x): (f64, State<2>),
    span: f64,
    tolerance: f64,
) -> Result<(Orbit<2>, bool), Error> {
    match solve(system, t0, x, t0 + span, &bounded(tolerance)) {
        Ok(orbit) => Ok((orbit, false)),
        Err(failure) if matches!(failure.error, Error::Escaped { .. }) => {
            Ok((*failure.partial, true))
        }
        Err(failure) => Err(failure.into()),
    }
}

/// The releases from stick in an orbit, each with the side that applies next and the phase that it
/// ends.
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

/// Equidistant positions on the belt from `-outer` to `outer` (m), at the middles of equal parts.
fn belt_positions(outer: f64, count: u32, belt_speed: f64) -> impl Iterator<Item = State<2>> {
    (0..count).map(move |k| {
        let part = 2.0 * (f64::from(k) + 0.5) / f64::from(count) - 1.0;
        State::from([outer * part, belt_speed])
    })
}

/// The visibility of a tangency of model 1 at a position (m), if there is one.
fn tangent_at(model: &BeltOscillator, x1: f64) -> Option<Visibility> {
    let x = State::from([x1, model.belt_speed]);
    let mut sides = [Side::Below, Side::Above].into_iter();
    sides.find_map(|side| tangency(model, side, 0.0, &x))
}
