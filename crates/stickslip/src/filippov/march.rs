//! Integration through one phase: steps, and the search of each for the first event.

use std::cell::Cell;

use super::flow::{CONTACT, Flow, MOST_GUARDS};
use super::leaving::{Leaving, has_left, leaving};
use super::locate::{Limits, Located, Origin, uncertainty};
use super::observer::{Observer, StepRecord, Transition, TransitionKind};
use super::options::{Locator, Options};
use super::pile_up::PileUp;
use super::scan::{Bracket, NARROWEST, far_from_zero, first_bracket, zero_in};
use crate::error::{Error, Point};
use crate::interval::Interval;
use crate::ode::{Dense, RungeKutta, Timed, dense_slopes};
use crate::orbit::Counters;
use crate::system::{Mode, State};

/// What lasts from phase to phase.
pub(crate) struct Run<'a, O> {
    pub options: &'a Options,
    pub observer: &'a mut O,
    pub counters: Counters,
    pub pile_up: PileUp,
    pub t_end: f64,
    /// Next step to try; 0 until the first is chosen. It is kept over events: the new field is usually as fast as the
    /// old, and error control corrects it where it is not.
    pub h: f64,
}

/// How a phase ended.
pub(crate) enum PhaseEnd<const N: usize> {
    /// The end time was reached.
    Time(Timed<f64, N>),
    /// Guard `guard` reached zero.
    Exit {
        at: Timed<f64, N>,
        guard: usize,
        residual: f64,
        /// What `orders` had become by then.
        orders: [usize; MOST_GUARDS],
    },
    /// The observer asked to stop.
    Stopped(Timed<f64, N>),
}

/// A guard is not a number in a part of the step.
pub(crate) struct Undefined;

/// An event found in a step.
struct Event<const N: usize> {
    guard: usize,
    located: Located<N>,
}

impl<'a, O> Run<'a, O> {
    pub(crate) fn new(options: &'a Options, observer: &'a mut O, t_end: f64) -> Self {
        Run {
            options,
            observer,
            counters: Counters::default(),
            pile_up: PileUp::new(),
            t_end,
            h: 0.0,
        }
    }
}

impl<O> Run<'_, O> {
    /// Integrates `flow` from `start` until a guard fails. `orders` says how many derivatives of each guard vanish
    /// at the start.
    pub(crate) fn march<M, F, const N: usize>(
        &mut self,
        flow: &F,
        mode: Mode,
        start: Timed<f64, N>,
        mut orders: [usize; MOST_GUARDS],
    ) -> Result<PhaseEnd<N>, Error>
    where
        M: RungeKutta,
        F: Flow<N>,
        O: Observer<N>,
    {
        let field = &mut |t: f64, x: &State<f64, N>| flow.field(t, x);
        let Timed { mut t, mut x } = start;
        let mut slope = field(t, &x);
        self.counters.field_calls += F::FIELD_CALLS;
        if self.h == 0.0 {
            self.h = self.choose_first_step(field, t, &x, &slope);
            self.counters.field_calls += F::FIELD_CALLS;
        }
        loop {
            if t >= self.t_end {
                return Ok(PhaseEnd::Time(Timed { t, x }));
            }
            let (h, is_last, mut step) = self.accepted_step::<M, F, N>(flow, t, &x, slope)?;
            let t_next = if is_last { self.t_end } else { t + h };
            step.end = flow.settle(t_next, step.end);
            dense_slopes::<M, f64, _>(field, t, &x, h, &mut step);
            self.counters.field_calls += F::FIELD_CALLS * (1 + M::COEFFICIENTS.dense_stages as u64);
            let dense = Dense::new::<M>(t, &x, h, &step);
            if !dense.is_finite() {
                // The solution comes to the edge of where the field is defined: a shorter step may stay inside.
                self.reject_undefined(t, &x, h)?;
                continue;
            }
            let origin = Origin {
                flow,
                t,
                x,
                slope,
                h,
                field_calls: Cell::new(0),
            };
            let found = self.first_event::<M, F, N>(&origin, &dense, &orders);
            self.counters.field_calls += origin.field_calls.get();
            let Ok(event) = found else {
                self.reject_undefined(t, &x, h)?;
                continue;
            };
            let event = event.filter(|event| !is_last || event.located.is_before(t_next));
            let (at, next_slope) = match &event {
                Some(Event {
                    located: Located::Exit { at, .. } | Located::Touch { at, .. },
                    ..
                }) => (*at, None),
                _ => (
                    Timed {
                        t: t_next,
                        x: step.end,
                    },
                    Some(step.k[M::COEFFICIENTS.stages]),
                ),
            };
            self.counters.steps += 1;
            let record = StepRecord {
                mode,
                t_start: t,
                t_end: at.t,
                x_start: x,
                x_end: at.x,
                dense,
            };
            if at.x.iter().any(|v| !v.is_finite()) {
                let x = Point::from(&x);
                return Err(Error::NonFinite { t, x, step: h });
            }
            let event = event.map(|event| (event.guard, event.located));
            if let Some(end) = self.conclude(flow, &record, event, &mut orders)? {
                return Ok(end);
            }
            Timed { t, x } = at;
            slope = match next_slope {
                Some(slope) => slope,
                None => {
                    self.counters.field_calls += F::FIELD_CALLS;
                    field(t, &x)
                }
            };
        }
    }

    /// Tells of a step and of the event at its end, if it has one. The phase's end, or nothing where it goes on; `orders` then
    /// says which guards are still leaving their zero.
    #[inline(always)]
    pub(crate) fn conclude<F: Flow<N>, const N: usize>(
        &mut self,
        flow: &F,
        record: &StepRecord<N>,
        event: Option<(usize, Located<N>)>,
        orders: &mut [usize; MOST_GUARDS],
    ) -> Result<Option<PhaseEnd<N>>, Error>
    where
        O: Observer<N>,
    {
        let at = Timed {
            t: record.t_end,
            x: record.x_end,
        };
        let told = self.observer.step(record);
        self.check_escape(&at)?;
        if told.is_break() {
            return Ok(Some(PhaseEnd::Stopped(at)));
        }
        match event {
            Some((guard, Located::Exit { at, residual })) => {
                return Ok(Some(PhaseEnd::Exit {
                    at,
                    guard,
                    residual,
                    orders: *orders,
                }));
            }
            Some((guard, Located::Touch { at, residual })) => {
                self.note_event(&at, &flow.field(at.t, &at.x))?;
                let touch = Transition {
                    t: at.t,
                    x: at.x,
                    kind: TransitionKind::Touch,
                    from: record.mode,
                    to: record.mode,
                    residual,
                };
                if self.observer.transition(&touch).is_break() {
                    return Ok(Some(PhaseEnd::Stopped(at)));
                }
                orders[guard] = 2;
            }
            _ => {
                for &guard in F::GUARDS {
                    let departs = orders[guard] > 0;
                    if departs && has_left::<F, N>(flow, guard, &at, self.options) {
                        orders[guard] = 0;
                    }
                }
            }
        }
        Ok(None)
    }

    /// Counts a transition; too many within no time are a pile-up.
    pub(crate) fn note_event<const N: usize>(
        &mut self,
        at: &Timed<f64, N>,
        velocity: &State<f64, N>,
    ) -> Result<(), Error> {
        self.counters.events += 1;
        self.pile_up.note(at, velocity, self.options)
    }

    /// The first guard that fails in the step, and where.
    ///
    /// # Errors
    /// No guard fails, but one is not a number at the step's end: a shorter step may not come to where it ends.
    #[inline(always)]
    fn first_event<M: RungeKutta, F: Flow<N>, const N: usize>(
        &mut self,
        origin: &Origin<'_, F, N>,
        dense: &Dense<N>,
        orders: &[usize; MOST_GUARDS],
    ) -> Result<Option<Event<N>>, Undefined> {
        let mut first: Option<(f64, Event<N>)> = None;
        let mut is_undefined = false;
        let reach = dense.enclosure();
        // Written out rather than looped over, so that each guard's code is the guard's own.
        macro_rules! consider {
            ($guard:expr) => {
                match self.first_failure::<M, F, N>($guard, origin, dense, &reach, orders[$guard]) {
                    Ok(Some((t, located)))
                        if first.as_ref().is_none_or(|(earlier, _)| t < *earlier) =>
                    {
                        let guard = $guard;
                        first = Some((t, Event { guard, located }));
                    }
                    Ok(_) => {}
                    Err(Undefined) => is_undefined = true,
                }
            };
        }
        consider!(0);
        if F::GUARDS.contains(&1) {
            consider!(1);
        }
        consider!(CONTACT);
        match first {
            Some((_, event)) => Ok(Some(event)),
            None if is_undefined => Err(Undefined),
            None => Ok(None),
        }
    }

    #[inline(always)]
    fn first_failure<M: RungeKutta, F: Flow<N>, const N: usize>(
        &mut self,
        i: usize,
        origin: &Origin<'_, F, N>,
        dense: &Dense<N>,
        reach: &State<Interval, N>,
        order: usize,
    ) -> Result<Option<(f64, Located<N>)>, Undefined> {
        let on_dense = |s: f64| origin.flow.guard(i, origin.t + s * origin.h, &dense.at(s));
        let found = if order == 0 {
            // Nearly every step ends here: far from any event, for certain or by samples.
            let times = Interval::new(origin.t, origin.t + origin.h);
            if origin.flow.is_clear(i, times, reach) {
                return Ok(None);
            }
            if far_from_zero(on_dense) {
                None
            } else {
                self.near_failure::<M, F, N>(i, origin, dense, on_dense)
            }
        } else {
            let start = leaving(origin, i, order);
            if self.resolves_departure(i, origin, &start, on_dense) {
                self.near_failure::<M, F, N>(i, origin, dense, |s| start.value(s, || on_dense(s)))
            } else {
                None
            }
        };
        if found.is_none() && !on_dense(1.0).is_finite() {
            return Err(Undefined);
        }
        Ok(found)
    }

    /// The first zero of guard `i`, known to be worth a closer look; `value` is the guard over the step, its zero at the
    /// start divided out.
    #[cold]
    #[inline(never)]
    fn near_failure<M: RungeKutta, F: Flow<N>, const N: usize>(
        &mut self,
        i: usize,
        origin: &Origin<'_, F, N>,
        dense: &Dense<N>,
        mut value: impl FnMut(f64) -> f64,
    ) -> Option<(f64, Located<N>)> {
        let chosen = self.options.locator;
        let mut locate = |bracket: Bracket, estimate: f64, locator: Locator| {
            self.counters.locations += 1;
            let near = Timed {
                t: origin.t + estimate * origin.h,
                x: dense.at(estimate),
            };
            let limits = self.limits(i, origin.flow, &near);
            match origin.locate::<M>(i, bracket, estimate, locator, limits) {
                Located::Nothing => None,
                found @ (Located::Exit { at, .. } | Located::Touch { at, .. }) => {
                    Some((at.t, found))
                }
            }
        };
        let mut from = 0.0;
        while let Some(bracket) = first_bracket(&mut value, from, 1.0) {
            let estimate = zero_in(&mut value, bracket);
            if let Some(found) = locate(bracket, estimate, chosen) {
                return Some(found);
            }
            // A dip of the dense output that the re-integrated step does not have. The search goes on where the
            // dense output is positive again; if it nowhere is, the step's end, where both agree, closes the bracket.
            let Some(back) = first_bracket(&mut |s| -value(s), bracket.b, 1.0) else {
                let rest = Bracket {
                    a: bracket.b,
                    b: 1.0,
                };
                return locate(rest, 1.0, Locator::RootSearch);
            };
            from = back.b.max(from + NARROWEST);
        }
        None
    }

    /// What an event of guard `i` near a state is held to. A step of fixed length is taken as it is: only error control
    /// gives a Hénon step something to be compared with.
    fn limits<F: Flow<N>, const N: usize>(
        &self,
        i: usize,
        flow: &F,
        near: &Timed<f64, N>,
    ) -> Limits {
        let blur = uncertainty(flow, i, near, &self.options.tolerance());
        let adaptive = self.options.fixed_step().is_none();
        Limits {
            touch: (self.options.touch * blur.by_tolerance).max(blur.by_rounding),
            mismatch: if adaptive {
                blur.by_tolerance.max(blur.by_rounding)
            } else {
                f64::INFINITY
            },
        }
    }

    /// Whether the step is long enough for the guard to rise out of rounding; a shorter one cannot hold an event that
    /// means anything.
    pub(crate) fn resolves_departure<F: Flow<N>, const N: usize>(
        &self,
        i: usize,
        origin: &Origin<'_, F, N>,
        start: &Leaving,
        on_dense: impl Fn(f64) -> f64,
    ) -> bool {
        let at = Timed {
            t: origin.t,
            x: origin.x,
        };
        let tolerance = self.options.tolerance();
        let floor = uncertainty(origin.flow, i, &at, &tolerance).by_rounding;
        [0.25, 0.5, 1.0]
            .iter()
            .any(|&s| start.risen(s, on_dense(s)).abs() > floor)
    }
}
