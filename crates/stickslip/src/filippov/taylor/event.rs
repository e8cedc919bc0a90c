//! The first event of a Taylor step.

use std::cell::OnceCell;

use super::TaylorStepper;
use super::step_series::StepSeries;
use crate::filippov::deflation::{DeflatedGuard, RISE_CHECKS, deflate};
use crate::filippov::flow::Flow;
use crate::filippov::guard::{Event, Probe, StepGuard, ZeroKind, first_event};
use crate::filippov::run::StepState;
use crate::filippov::runge_kutta::Undefined;
use crate::filippov::scan::{Bracket, first_bracket, zero_in};
use crate::filippov::uncertainty::{attracts, uncertainty};
use crate::ode::{Timed, power_series};
use crate::taylor::roots::{is_positive, search, slope_and_bend};

/// An event, its position `s` in the step, and the rounding remainder of its state.
pub(super) struct LocatedEvent<const N: usize> {
    pub(super) event: Event<N>,
    pub(super) s: f64,
    pub(super) remainder: Timed<N>,
}

/// The guard's value at a zero of its series is so large that the series does not represent the
/// guard.
struct SeriesMismatch;

/// Places in the step at which a sampled guard must be defined. Chosen: eighths, which miss a
/// narrower gap in its domain.
const DOMAIN_SAMPLES: [f64; 8] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

/// Largest distance between a zero of the series and that of the guard (fraction of the step).
/// Chosen far above the error of a series within any useful tolerance.
const NEWTON_RANGE: f64 = 1e-6;

/// Number of Newton steps from one to the other. Each squares the distance: two reach rounding.
const NEWTON_STEPS: usize = 3;

/// A guard smaller than this part of its slope agrees with its series. Chosen: this cheap test
/// comes first and nearly always passes.
const SERIES_AGREEMENT: f64 = 1e-10;

/// Part of its step up to which a series is used, slightly beyond the end. Chosen: the error there
/// is up to three times that at the end, which is a tenth of the tolerance.
const SERIES_END: f64 = 1.05;

/// A guard over a Taylor step, represented by its own series. Its first zero is isolated
/// rigorously.
struct SeriesGuard<'a, F, const N: usize> {
    flow: &'a F,
    guard: usize,
    step_series: &'a StepSeries<N>,
    /// Coefficients of the powers of `s`.
    c: &'a [f64],
    /// Order of the zero at the start.
    order: usize,
    /// The part of the step up to which the series represents the guard.
    reach: f64,
    /// Whether the guard is negative from the start of the step on.
    fails_at_once: bool,
}

impl<F: Flow<N>, const N: usize> StepGuard<N> for SeriesGuard<'_, F, N> {
    fn probe_end(&self) -> f64 {
        self.step_series.to_end.min(SERIES_END)
    }

    fn length(&self) -> f64 {
        1.0
    }

    fn starts_at_zero(&self) -> bool {
        self.order > 0
    }

    fn offset(&self) -> f64 {
        0.0
    }

    fn value(&self, s: f64) -> f64 {
        power_series(&self.c[self.order..], s).0
    }

    fn first_zero(&self, from: f64) -> Option<Bracket> {
        if from > 0.0 {
            // The first zero was not an event, which is rare.
            if from >= self.reach {
                return None;
            }
            return first_bracket(&mut |s| self.value(s), from, self.reach);
        }
        let s = if self.fails_at_once {
            0.0
        } else {
            // The quick test for a positive polynomial has failed already.
            search(&self.c[self.order..]).filter(|s| *s <= self.reach)?
        };
        Some(Bracket { a: s, b: s })
    }

    fn zero_in(&self, bracket: Bracket) -> f64 {
        if bracket.a == bracket.b {
            return bracket.a;
        }
        zero_in(&mut |s| self.value(s), bracket)
    }

    fn probe(&self, s: f64) -> Probe<N> {
        let (slope, bend) = slope_and_bend(self.c, s);
        on_piece(self.flow, self.guard, self.step_series, s, slope, bend)
    }
}

/// A guard over a Taylor step, sampled on the series of the state.
struct SampledGuard<'a, F, const N: usize> {
    flow: &'a F,
    guard: usize,
    step_series: &'a StepSeries<N>,
    /// The guard's zero at the start of the step, if it has one.
    start: Option<DeflatedGuard>,
}

impl<F: Flow<N>, const N: usize> SampledGuard<'_, F, N> {
    fn on_series(&self, s: f64) -> f64 {
        let at = self.step_series.at(s).0;
        self.flow.guard_at(self.guard, at.t, &at.x)
    }
}

impl<F: Flow<N>, const N: usize> StepGuard<N> for SampledGuard<'_, F, N> {
    fn probe_end(&self) -> f64 {
        self.step_series.to_end.min(SERIES_END)
    }

    fn length(&self) -> f64 {
        1.0
    }

    fn starts_at_zero(&self) -> bool {
        self.start.is_some()
    }

    fn offset(&self) -> f64 {
        self.start.as_ref().map_or(0.0, |start| start.offset)
    }

    fn value(&self, s: f64) -> f64 {
        match &self.start {
            Some(start) => start.value(s, || self.on_series(s)),
            None => self.on_series(s),
        }
    }

    fn probe(&self, s: f64) -> Probe<N> {
        let (at, h) = (self.step_series.at(s).0, self.step_series.h);
        let [_, rate, bend, _] = self.flow.jet(self.guard, at.t, &at.x);
        let probe = on_piece(
            self.flow,
            self.guard,
            self.step_series,
            s,
            rate * h,
            bend * h * h,
        );
        Probe {
            guard: probe.guard + self.offset(),
            ..probe
        }
    }
}

/// A probe of a guard from its slope and second derivative in `s`.
fn on_piece<F: Flow<N>, const N: usize>(
    flow: &F,
    guard: usize,
    step_series: &StepSeries<N>,
    s: f64,
    slope: f64,
    bend: f64,
) -> Probe<N> {
    let mut at = step_series.at(s).0;
    at.x = flow.settle(at.t, at.x);
    Probe {
        s,
        at,
        guard: flow.guard_at(guard, at.t, &at.x),
        rate: slope,
        bend,
    }
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// The first guard that fails in the step, and where. The series holds up to the part `reach`,
    /// where the state is `end`; results beyond that are meaningless.
    ///
    /// # Errors
    /// If a guard is not defined throughout the step, or it leads a slide to where its boundary
    /// repels.
    pub(super) fn first_event<F: Flow<N>>(
        &self,
        run: &mut StepState<N, G>,
        flow: &F,
        (reach, end): &(f64, Timed<N>),
    ) -> Result<Option<LocatedEvent<N>>, Undefined> {
        let step_series = &self.step_series;
        let mut first: Option<LocatedEvent<N>> = None;
        let at_end = OnceCell::new();
        for &guard in flow.guards() {
            let Some(function) = self.expansion.watched[guard] else {
                continue;
            };
            let order = run.orders[guard];
            let c = &self.guards[guard][..=step_series.order];
            // A comparison may have selected a linear branch of a nonlinear function.
            let may_differ = !function.is_linear || self.expansion.choices > 0;
            let located = if self.expansion.value_read || !c[step_series.order].is_finite() {
                let located = first_sampled_event(run, flow, guard, step_series, order)?;
                if located.is_none() && may_differ {
                    defined_at_end(flow, guard, end, &at_end)?;
                }
                located
            } else {
                let by_series = || {
                    if *reach == 1.0 {
                        c[1..].iter().fold(c[0], |sum, c| sum + c)
                    } else {
                        power_series(c, *reach).0
                    }
                };
                match first_event_of(
                    run,
                    flow,
                    guard,
                    step_series,
                    c,
                    (order, *reach, may_differ),
                ) {
                    Ok(Some(located)) => Some(located),
                    Ok(None)
                        if !may_differ
                            || !differs_from_series(
                                run,
                                flow,
                                (guard, by_series()),
                                end,
                                &at_end,
                            )? =>
                    {
                        None
                    }
                    Ok(None) | Err(SeriesMismatch) => {
                        // The search in the series took a start below zero for a zero within
                        // rounding.
                        let order = order.max(usize::from(c[0] <= 0.0));
                        first_sampled_event(run, flow, guard, step_series, order)?
                    }
                }
            };
            let Some(located) = located else { continue };
            if first.as_ref().is_none_or(|first| located.s < first.s) {
                first = Some(located);
            }
        }
        let at = first.as_ref().map_or(end, |first| &first.event.at);
        let is_searched = self.expansion.watched.iter().any(Option::is_some);
        let is_possible = is_searched || flow.may_hide_two_fold();
        match is_possible && !attracts(flow, (&run.at, at), &run.options) {
            true => Err(Undefined),
            false => Ok(first),
        }
    }

    /// Whether all guards agree with their series at the end of a step over which these are
    /// positive.
    pub(super) fn holds_at_end<F: Flow<N>>(&self, run: &StepState<N, G>, flow: &F) -> bool {
        let (end, _) = self.end(run);
        let at_end = OnceCell::new();
        flow.guards().iter().all(|&guard| {
            let by_series = self.end_of_step.guards[guard];
            let may_differ = |is_linear: bool| !is_linear || self.expansion.choices > 0;
            !self.expansion.watched[guard].is_some_and(|function| may_differ(function.is_linear))
                || differs_from_series(run, flow, (guard, by_series), &end, &at_end)
                    .is_ok_and(|differs| !differs)
        })
    }
}

/// The value of a guard at the end of a step.
///
/// # Errors
/// If it is not defined there.
#[inline(always)]
fn defined_at_end<F: Flow<N>, const N: usize, const G: usize>(
    flow: &F,
    guard: usize,
    end: &Timed<N>,
    at_end: &OnceCell<[f64; G]>,
) -> Result<f64, Undefined> {
    let value: f64 = if F::TOGETHER {
        at_end.get_or_init(|| flow.guards_at(end.t, &end.x))[guard]
    } else {
        flow.guard_at(guard, end.t, &end.x)
    };
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Undefined)
    }
}

/// Whether a guard differs from its series at the end of a step over which the series is positive.
/// A series does not show a bend that is too sharp for it. Neither does it show the end of the
/// function's domain, even if the step ends inside the domain again.
///
/// # Errors
/// If the guard is not defined there.
#[inline(always)]
fn differs_from_series<F: Flow<N>, const N: usize, const G: usize>(
    run: &StepState<N, G>,
    flow: &F,
    (guard, by_series): (usize, f64),
    end: &Timed<N>,
    at_end: &OnceCell<[f64; G]>,
) -> Result<bool, Undefined> {
    let value = defined_at_end(flow, guard, end, at_end)?;
    let off = (value - by_series).abs();
    // This test nearly always passes.
    if value > 0.0 && off <= run.options.rtol * value {
        return Ok(false);
    }
    let blur = uncertainty(flow, guard, end, &run.options.tolerance());
    Ok(-value > blur.zero() || off > blur.series_defect())
}

/// The first event of the guard with series `c`, of which `order` coefficients vanish at the start,
/// up to the part `reach` of the step.
///
/// # Errors
/// If the series does not represent the guard.
#[inline(always)]
fn first_event_of<F: Flow<N>, const N: usize, const G: usize>(
    run: &mut StepState<N, G>,
    flow: &F,
    guard: usize,
    step_series: &StepSeries<N>,
    c: &[f64],
    (order, reach, may_differ): (usize, f64, bool),
) -> Result<Option<LocatedEvent<N>>, SeriesMismatch> {
    let (t, x) = (step_series.t, step_series.x[0]);
    let blur = || uncertainty(flow, guard, &Timed { t, x }, &run.options.tolerance());
    let mut order = order.min(3);
    let mut fails_at_once = false;
    if order == 0 && c[0] <= 0.0 {
        // A guard that starts below zero ends the phase at once. The exception is a rising guard
        // that is below zero by no more than rounding.
        fails_at_once = c[1] <= 0.0 || -c[0] > blur().by_rounding;
        order = 1;
    }
    if order > 0 && !fails_at_once {
        let floor = blur().by_rounding;
        // If the guard stays within rounding over the step, no event in it is significant.
        let risen = |s: f64| {
            let power = (0..order).fold(1.0, |power, _| power * s);
            (power_series(&c[order..], s).0 * power).abs()
        };
        if !RISE_CHECKS.iter().any(|&s| risen(s) > floor) {
            return Ok(None);
        }
        if order == 3 && c[order].abs() <= floor {
            // The guard starts flat; its samples show where it falls.
            return Err(SeriesMismatch);
        }
        fails_at_once = c[order] <= 0.0;
    }
    // Nearly every step returns here.
    if !fails_at_once && is_positive(&c[order..]) {
        return Ok(None);
    }
    let series = SeriesGuard {
        flow,
        guard,
        step_series,
        c,
        order,
        reach,
        fails_at_once,
    };
    locate(run, flow, step_series, (guard, may_differ), &series)
}

/// The first event of a guard whose series cannot be used. The series is not finite (a root at
/// zero, such as a distance at its origin), or it belongs to a branch taken by value. The guard
/// itself is sampled on the series of the state.
#[cold]
#[inline(never)]
fn first_sampled_event<F: Flow<N>, const N: usize, const G: usize>(
    run: &mut StepState<N, G>,
    flow: &F,
    guard: usize,
    step_series: &StepSeries<N>,
    order: usize,
) -> Result<Option<LocatedEvent<N>>, Undefined> {
    let mut sampled = SampledGuard {
        flow,
        guard,
        step_series,
        start: None,
    };
    let on_series = |s| sampled.on_series(s);
    // A step into a region where the guard is undefined is rejected; a shorter one may avoid it.
    if on_series(0.0).is_finite() && !DOMAIN_SAMPLES.iter().all(|&s| on_series(s).is_finite()) {
        return Err(Undefined);
    }
    if order > 0 {
        let (t, x) = (step_series.t, step_series.x[0]);
        let (at, step) = (Timed { t, x }, (step_series.h, order));
        let start = deflate(flow, guard, &at, step, &run.options, on_series);
        if start.is_none() {
            return Ok(None);
        }
        sampled.start = start;
    }
    // These are zeros of the guard itself, so they cannot stray.
    Ok(locate(run, flow, step_series, (guard, false), &sampled).unwrap_or(None))
}

/// The first event of a guard over the step. It is an exit, whose state is projected onto Σ, or a
/// touch, where the guard turns back within the touch tolerance.
///
/// # Errors
/// If the guard differs from its series, where it `may_differ`.
#[cold]
#[inline(never)]
fn locate<F: Flow<N>, const N: usize, const G: usize>(
    run: &mut StepState<N, G>,
    flow: &F,
    step_series: &StepSeries<N>,
    (i, may_differ): (usize, bool),
    guard: &dyn StepGuard<N>,
) -> Result<Option<LocatedEvent<N>>, SeriesMismatch> {
    let located = first_event(guard, |_, s, _| {
        run.counters.locations += 1;
        let zero = guard.probe(s);
        if zero.bend > 0.0 && s > 0.0 {
            let blur = uncertainty(flow, i, &zero.at, &run.options.tolerance());
            let touch = (run.options.touch * blur.by_tolerance).max(blur.by_rounding);
            match ZeroKind::classify(&zero, guard, touch) {
                ZeroKind::Exit => {}
                ZeroKind::Touch(turn) => {
                    return Some(Ok(LocatedEvent {
                        event: turn.event(i, true),
                        s: turn.s,
                        remainder: step_series.at(turn.s).1,
                    }));
                }
                ZeroKind::StillAtStart => return None,
            }
        }
        // The series is accurate to the rounding of its largest term; the guard itself may be far
        // more accurate.
        let (mut at, mut remainder) = (zero.at, step_series.at(s).1);
        let (from, mut s, mut value, mut rate) = (s, s, zero.guard, zero.rate);
        for _ in 0..NEWTON_STEPS {
            let change = -value / rate;
            let next = s + change;
            if !((next - from).abs() <= NEWTON_RANGE && next >= 0.0) {
                break;
            }
            let there = step_series.at(next);
            // A Newton iteration leaves an error of second order.
            let is_last = (zero.bend * change * change).abs() <= f64::EPSILON * rate.abs();
            if !is_last {
                let value_there = flow.guard_at(i, there.0.t, &there.0.x) + guard.offset();
                if value_there.is_nan() || value_there.abs() >= value.abs() {
                    break;
                }
                value = value_there;
                rate += zero.bend * change;
            }
            (s, at, remainder) = (next, there.0, there.1);
            if is_last {
                break;
            }
        }
        if may_differ && s > 0.0 && value.abs() > SERIES_AGREEMENT * zero.rate.abs() {
            let blur = uncertainty(flow, i, &at, &run.options.tolerance());
            if value.abs() > blur.series_defect() {
                return Some(Err(SeriesMismatch));
            }
        }
        at.x = flow.land(i, at.t, at.x);
        let left: f64 = flow.guard_at(i, at.t, &at.x);
        let event = Event {
            guard: i,
            at,
            is_touch: false,
            residual: left.abs(),
        };
        Some(Ok(LocatedEvent {
            event,
            s,
            remainder,
        }))
    });
    located.transpose()
}
