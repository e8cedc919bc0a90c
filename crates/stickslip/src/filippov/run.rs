//! The state of a run between steps, and the errors of a step.

use std::ops::RangeInclusive;

use super::deflation::has_left_zero;
use super::flow::Flow;
use super::guard::Event;
use super::observer::StepRecord;
use super::options::Options;
use super::uncertainty::EVENT_PRECISION;
use crate::dual::Dual3;
use crate::error::{Error, Point};
use crate::ode::control::first_step;
use crate::ode::{Dense, Timed};
use crate::orbit::Counters;
use crate::system::State;

/// Rounding of a time, relative to its size. Times that are closer are the same, and shorter steps
/// do not change the time.
pub(crate) const TIME_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Roundings of time since the run began within which a state that outruns them is too fast for
/// its times. Chosen: a run up to a singularity spans more than that.
const TOO_LATE: f64 = 1e6;

/// Powers of the distance, as which a rate may vanish, that are not Lipschitz. Chosen: a smooth
/// rate has power 1, `x ln x` has more than 0.94 above 1e-8, and one that does not vanish has 0.
const ROOTS: RangeInclusive<f64> = 0.1..=0.91;

/// Largest difference of two powers, or of two distances as a part, that are the same. Chosen: what
/// is no power of the distance differs by its own size.
const SAME_LAW: f64 = 0.05;

/// The state of a run between steps of any method.
pub struct StepState<const N: usize, const G: usize> {
    pub options: Options,
    /// Number of components that move, as [`crate::Filippov::dimension`].
    pub states: usize,
    pub counters: Counters,
    pub t_start: f64,
    pub t_end: f64,
    /// Next step length to try; 0 until the first is chosen. It is kept over events: the new field
    /// is usually as fast as the old one, and error control corrects the rest.
    pub h: f64,
    /// Start of the present phase.
    pub from: Timed<N>,
    /// End of the last step.
    pub at: Timed<N>,
    /// Number of derivatives of each guard that vanish at its last zero; 0 once it has left that.
    pub orders: [usize; G],
    /// Start and end of the last step, and the solution over it. [`StepState::at`] differs from the
    /// end when a stick phase begins on Σ.
    pub last: (Timed<N>, Timed<N>),
    pub dense: Dense<N>,
    /// Whether the previous step's dense output was used. Then the next step makes it at once, and
    /// so does the first.
    pub wants_dense: bool,
    /// The last event.
    pub event: Option<Event<N>>,
    /// Whether the mode is prescribed and ignores its guards.
    pub is_prescribed: bool,
    /// The end time of the run before which it waits once, ahead of the first step that the end
    /// shortens.
    pub waits_before: Option<f64>,
}

/// Result of an attempt to step.
#[derive(Clone, Copy)]
pub enum Trial {
    /// Only prepared, or rejected: another attempt follows.
    NoStep,
    /// The next step is the first that the end of the run shortens. The same attempt follows.
    BeforeEnd,
    /// A step was taken, the run's last one now.
    Step,
    /// A step was taken that ends at an event, the run's last one now.
    Event,
}

impl<const N: usize, const G: usize> StepState<N, G> {
    /// A run that has not begun, of a system with that number of states.
    ///
    /// # Errors
    /// Those of a run that cannot begin.
    pub(crate) fn new(
        (start, states): (Timed<N>, usize),
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let run = StepState {
            options: *options,
            states,
            counters: Counters::default(),
            t_start: start.t,
            t_end,
            h: 0.0,
            at: start,
            from: start,
            orders: [0; G],
            last: (start, start),
            dense: Dense::resting(start.t, start.x),
            wants_dense: true,
            event: None,
            is_prescribed: false,
            waits_before: None,
        };
        options.atol.check_states(states)?;
        run.check_escape()?;
        Ok(run)
    }

    /// Takes the step to `at`, and the event there, as the last one.
    #[inline(always)]
    pub(crate) fn accept(&mut self, at: Timed<N>, event: Option<&Event<N>>) -> Trial {
        self.last = (self.at, at);
        self.at = at;
        // Called once a step, so nothing is copied without need.
        let Some(event) = event else {
            return Trial::Step;
        };
        self.event = Some(*event);
        Trial::Event
    }

    /// The last step, in this mode; of length zero before the first.
    #[inline(always)]
    pub(crate) fn last_step<K>(&self, mode: K) -> StepRecord<N, K> {
        let (from, to) = self.last;
        StepRecord {
            mode,
            t_start: from.t,
            t_end: to.t,
            x_start: from.x,
            x_end: to.x,
            dense: self.dense,
        }
    }

    /// The first step to try from `(t, x)`.
    pub(crate) fn choose_first_step(
        &self,
        field: &mut dyn FnMut(f64, &State<N>) -> State<N>,
        t: f64,
        x: &State<N>,
        slope: &State<N>,
    ) -> f64 {
        let longest = self.options.longest_step.min(self.t_end - t);
        if let Some(step) = self.options.fixed_step().or(self.options.first_step) {
            return step.min(longest);
        }
        // A state near zero would give a step that does not change the time, though nothing is
        // singular.
        let chosen = first_step(
            field,
            t,
            x,
            slope,
            (&self.options.tolerance(), self.states),
            longest,
        );
        chosen.max(2.0 * TIME_ROUNDING * t.abs())
    }

    /// Length of the next step, and whether it ends at the end time. A last step is stretched a
    /// little rather than followed by one of rounding's length.
    #[inline(always)]
    pub(crate) fn next_step(&self) -> (f64, bool) {
        let (t, h) = (self.at.t, self.h.min(self.options.longest_step));
        if t + 1.01 * h >= self.t_end {
            (self.t_end - t, true)
        } else {
            (h, false)
        }
    }

    /// Whether a run waits before a step that ends at the end time. Asked again, it does not.
    #[inline(always)]
    pub(crate) fn waits(&mut self) -> bool {
        let waits = self.waits_before.is_some_and(|end| end <= self.t_end);
        if waits {
            self.waits_before = None;
        }
        waits
    }

    /// Whether a step no longer moves the time.
    #[inline(always)]
    pub(crate) fn is_too_short(&self, h: f64, is_last: bool) -> bool {
        !is_last && h <= TIME_ROUNDING * self.at.t.abs() || h < f64::MIN_POSITIVE
    }

    /// The step shrank until time no longer moves, by a setting, by the rounding of time or by the
    /// solution.
    pub(crate) fn collapse<F: Flow<N>>(&self, flow: &F, slope: &State<N>, step: f64) -> Error {
        if let Err(error) = self.check_lipschitz(flow) {
            return error;
        }
        if slope.iter().any(|v| !v.is_finite()) {
            return self.non_finite(step);
        }
        let (Timed { t, x }, options) = (&self.at, &self.options);
        let rounding = (TIME_ROUNDING * t.abs()).max(f64::MIN_POSITIVE);
        let (name, longest) = match options.fixed_step() {
            Some(step) => ("method.step", step),
            None => ("longest_step", options.longest_step),
        };
        let is_bounded = longest <= rounding;
        let step = if is_bounded { longest } else { step };
        let outruns = |i: usize| slope[i].abs() * rounding > options.allowed(i, x[i].abs());
        let is_late = t - self.t_start <= TOO_LATE * rounding && (0..self.states).any(outruns);
        let (t, x) = (*t, Point::from(x));
        if is_bounded || is_late {
            let bound = is_bounded.then_some(name);
            return Error::TimeRounding {
                t,
                x,
                step,
                rounding,
                bound,
            };
        }
        Error::StepCollapse {
            t,
            x,
            step,
            rtol: options.rtol,
            atol: options.atol.smallest(),
        }
    }

    /// The state at the end of a step is not a number.
    pub(crate) fn non_finite(&self, step: f64) -> Error {
        let (t, x) = (self.at.t, Point::from(&self.at.x));
        Error::NonFinite { t, x, step }
    }

    /// Shortens the next step after one on which the field was not defined throughout.
    pub(crate) fn reject_undefined(&mut self, step: f64) -> Result<(), Error> {
        if self.options.fixed_step().is_some() {
            return Err(self.non_finite(step));
        }
        self.counters.rejected += 1;
        self.h = 0.1 * step;
        Ok(())
    }

    /// Refuses a state from which a component comes within the tolerance to where the field is not
    /// Lipschitz, after a step was rejected there. Near such a place the component's rate is a
    /// power of the distance, below 1. Its value and two slopes give power, distance and time left,
    /// the same ones nearer to it.
    #[cold]
    pub(crate) fn check_lipschitz<F: Flow<N>>(&self, flow: &F) -> Result<(), Error> {
        let Timed { t, x } = &self.at;
        let constant = |value: f64| Dual3::new(value, 0.0, 0.0, 0.0);
        for i in 0..self.states {
            let law = |moved: f64| {
                let mut along: [_; N] = std::array::from_fn(|k| constant(x[k]));
                along[i] = Dual3::new(x[i] + moved, 1.0, 0.0, 0.0);
                let rate = flow.field(constant(*t), &along)[i];
                let power = 1.0 / (1.0 - rate.re * rate.v2 / (rate.v1 * rate.v1));
                let distance = -power * rate.re / rate.v1;
                let is_root = rate.v1 < 0.0 && ROOTS.contains(&power);
                is_root.then_some((rate.re, power, distance))
            };
            let Some((rate, power, distance)) = law(0.0) else {
                continue;
            };
            let tolerance = self.options.allowed(i, (x[i] + distance).abs());
            let is_same = |&(_, nearer, left): &(f64, f64, f64)| {
                (nearer - power).abs() < SAME_LAW
                    && (left - 0.25 * distance).abs() < SAME_LAW * distance.abs()
            };
            if distance.abs() <= tolerance && law(0.75 * distance).is_some_and(|one| is_same(&one))
            {
                let mut x = *x;
                x[i] += distance;
                let t = t + distance / (rate * (1.0 - power));
                let x = Point::from(&x);
                return Err(Error::NotLipschitz { t, x });
            }
        }
        Ok(())
    }

    /// Distance at which a state counts as being on its manifold.
    pub(crate) fn slack(&self) -> f64 {
        EVENT_PRECISION * self.options.atol.smallest()
    }

    pub(crate) fn check_escape(&self) -> Result<(), Error> {
        let bound = self.options.escape;
        let mut states = self.at.x.iter().take(self.states);
        if states.all(|v| v.abs() <= bound) {
            return Ok(());
        }
        Err(Error::Escaped {
            t: self.at.t,
            x: Point::from(&self.at.x),
            bound,
        })
    }

    #[inline(always)]
    pub(crate) fn check_steps(&self) -> Result<(), Error> {
        self.check_count(self.counters.steps, self.options.most_steps, "most_steps")
    }

    #[inline(always)]
    fn check_count(&self, count: u64, most: u64, name: &'static str) -> Result<(), Error> {
        if count <= most {
            return Ok(());
        }
        let Timed { t, x } = &self.at;
        let x = Point::from(x);
        Err(Error::TooMany {
            name,
            most,
            t: *t,
            x,
        })
    }

    /// Counts a transition.
    pub(crate) fn record_event(&mut self) -> Result<(), Error> {
        self.counters.events += 1;
        self.check_count(
            self.counters.events,
            self.options.most_events,
            "most_events",
        )
    }

    /// Records which guards have left their zero.
    pub(crate) fn record_departures<F: Flow<N>>(&mut self, flow: &F) {
        for &guard in flow.guards() {
            let departs = self.orders[guard] > 0;
            if departs && has_left_zero::<F, N>(flow, guard, &self.at, &self.options) {
                self.orders[guard] = 0;
            }
        }
    }
}
