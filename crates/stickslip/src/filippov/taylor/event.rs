//! The first event of a step.

use std::cell::Cell;

use super::TaylorStepper;
use super::piece::Piece;
use crate::filippov::event::Event;
use crate::filippov::flow::Flow;
use crate::filippov::leaving::leaving;
use crate::filippov::locate::{Origin, uncertainty};
use crate::filippov::run::Run;
use crate::filippov::scan;
use crate::filippov::slopes::Undefined;
use crate::ode::Timed;
use crate::taylor::roots::{first_zero, slope_and_bend, value_and_slope};

/// An event with its part of the step, and what rounding took from its state.
pub(super) struct Found<const N: usize> {
    pub(super) event: Event<N>,
    pub(super) s: f64,
    pub(super) rest: Timed<f64, N>,
}

/// Where it is looked at whether a guard is defined.
const SAMPLES: [f64; 8] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

impl<const N: usize> TaylorStepper<N> {
    /// The first guard that fails in the step, and where.
    ///
    /// # Errors
    /// A guard is not defined throughout the step.
    pub(super) fn first_event<F: Flow<N>>(
        &self,
        run: &mut Run<N>,
        flow: &F,
        index: usize,
        piece: &Piece<N>,
    ) -> Result<Option<Found<N>>, Undefined> {
        let tape = &self.tapes[index];
        let mut first: Option<Found<N>> = None;
        for &guard in F::GUARDS {
            let function = &tape.watched[guard];
            let order = run.orders[guard];
            let found = if tape.value_read {
                sampled_failure(run, flow, guard, piece, order)?
            } else if function.count == 0 {
                None
            } else {
                let c = piece.polynomial(&self.series, tape, function);
                let c = &c[..=self.order];
                if c[self.order].is_finite() {
                    self.first_failure(run, flow, guard, piece, c, order)
                } else {
                    sampled_failure(run, flow, guard, piece, order)?
                }
            };
            if let Some(found) = found
                && first.as_ref().is_none_or(|first| found.s < first.s)
            {
                first = Some(found);
            }
        }
        Ok(first)
    }

    /// The first zero of the guard with series `c`, of which `order` coefficients vanish at the start.
    #[inline(always)]
    fn first_failure<F: Flow<N>>(
        &self,
        run: &mut Run<N>,
        flow: &F,
        guard: usize,
        piece: &Piece<N>,
        c: &[f64],
        order: usize,
    ) -> Option<Found<N>> {
        let start = Timed {
            t: piece.t,
            x: piece.x[0],
        };
        let blur = || uncertainty(flow, guard, &start, &run.options.tolerance());
        let mut order = order.min(3);
        if order == 0 && c[0] <= 0.0 {
            // A guard left below zero ends the phase at once, unless rounding alone has put it there and it rises.
            if c[1] <= 0.0 || -c[0] > blur().by_rounding {
                return Some(locate_on_series(run, flow, guard, piece, c, 0.0));
            }
            order = 1;
        }
        if order > 0 {
            let floor = blur().by_rounding;
            // A step over which the guard does not rise out of rounding cannot hold an event that means anything.
            let risen = |s: f64| {
                let power = (0..order).fold(1.0, |power, _| power * s);
                (value_and_slope(&c[order..], s).0 * power).abs()
            };
            if ![0.25, 0.5, 1.0].iter().any(|&s| risen(s) > floor) {
                return None;
            }
            if c[order] <= 0.0 {
                return Some(locate_on_series(run, flow, guard, piece, c, 0.0));
            }
        }
        let s = first_zero(&c[order..])?;
        Some(locate_on_series(run, flow, guard, piece, c, s))
    }
}

/// The first zero of a guard whose series says nothing of the step, because it is not finite (a root at zero, as a distance has
/// at the place that it is measured from) or because it belongs to a branch that was taken by value. The guard itself is
/// sampled, on the series of the state.
#[cold]
#[inline(never)]
fn sampled_failure<F: Flow<N>, const N: usize>(
    run: &mut Run<N>,
    flow: &F,
    guard: usize,
    piece: &Piece<N>,
    order: usize,
) -> Result<Option<Found<N>>, Undefined> {
    let on_series = |s: f64| {
        let at = piece.at(s).0;
        flow.guard(guard, at.t, &at.x)
    };
    // A step into where the guard is not defined says nothing of it; a shorter one may.
    if on_series(0.0).is_finite() && !SAMPLES.iter().all(|&s| on_series(s).is_finite()) {
        return Err(Undefined);
    }
    let departure = if order > 0 {
        let origin = Origin {
            flow,
            t: piece.t,
            x: piece.x[0],
            slope: flow.field(piece.t, &piece.x[0]),
            h: piece.h,
            field_calls: Cell::new(0),
        };
        let start = leaving(&origin, guard, order);
        if !run.resolves_departure(guard, &origin, &start, on_series) {
            return Ok(None);
        }
        Some(start)
    } else {
        None
    };
    let mut value = |s: f64| match &departure {
        Some(start) => start.value(s, || on_series(s)),
        None => on_series(s),
    };
    let Some(bracket) = scan::first_bracket(&mut value, 0.0, 1.0) else {
        return Ok(None);
    };
    let s = scan::zero_in(&mut value, bracket);
    let profile = |s: f64| {
        let at = piece.at(s).0;
        let [_, rate, bend, _] = flow.jet(guard, at.t, &at.x);
        (rate * piece.h, bend * piece.h * piece.h)
    };
    Ok(Some(locate(run, flow, guard, piece, &profile, s)))
}

#[cold]
#[inline(never)]
fn locate_on_series<F: Flow<N>, const N: usize>(
    run: &mut Run<N>,
    flow: &F,
    guard: usize,
    piece: &Piece<N>,
    c: &[f64],
    s: f64,
) -> Found<N> {
    locate(run, flow, guard, piece, &|s| slope_and_bend(c, s), s)
}

/// The event at the part `s` of the step: an exit, or a touch where the guard, whose slope and bend `profile` tells, turns back
/// within the touch tolerance.
fn locate<F: Flow<N>, const N: usize>(
    run: &mut Run<N>,
    flow: &F,
    guard: usize,
    piece: &Piece<N>,
    profile: &dyn Fn(f64) -> (f64, f64),
    s: f64,
) -> Found<N> {
    run.counters.locations += 1;
    let found = |at, is_touch, left: f64, s, rest| Found {
        event: Event {
            guard,
            at,
            is_touch,
            residual: left.abs(),
        },
        s,
        rest,
    };
    let (slope, bend) = profile(s);
    let (mut at, mut rest) = piece.at(s);
    if bend > 0.0 && s > 0.0 {
        let blur = uncertainty(flow, guard, &at, &run.options.tolerance());
        let touch = (run.options.touch * blur.by_tolerance).max(blur.by_rounding);
        if slope * slope <= 2.0 * touch * bend {
            let s = turning_point(profile, s);
            (at, rest) = piece.at(s);
            at.x = flow.settle(at.t, at.x);
            let left: f64 = flow.guard(guard, at.t, &at.x);
            return found(at, true, left, s, rest);
        }
    }
    at.x = flow.settle(at.t, at.x);
    // The series knows the guard to the rounding of its largest term, the guard itself may be known far better.
    let left: f64 = flow.guard(guard, at.t, &at.x);
    let change = -left / slope;
    if change.abs() <= 1e-6 && s + change >= 0.0 {
        (at, rest) = piece.at(s + change);
    }
    at.x = flow.land(guard, at.t, at.x);
    let left: f64 = flow.guard(guard, at.t, &at.x);
    found(at, false, left, s, rest)
}

/// A series holds a little beyond its step: a contact that the step's end cuts in two has its turning point there.
const BEYOND: f64 = 1.05;

/// Where the guard turns near its zero at `s`, by Newton's iteration on its slope.
fn turning_point(profile: &dyn Fn(f64) -> (f64, f64), mut s: f64) -> f64 {
    let mut steepness = f64::INFINITY;
    for _ in 0..30 {
        let (slope, bend) = profile(s);
        if slope == 0.0 || slope.abs() >= steepness || bend <= 0.0 {
            break;
        }
        steepness = slope.abs();
        s = (s - slope / bend).clamp(0.0, BEYOND);
    }
    s
}
