//! Taylor steps, and the first zero of the guards' series in each of them.

mod end;
mod event;
mod kink;
mod step_series;
mod step_size;

pub(super) use end::Ends;
use end::{TaylorStepEnd, sums};
use kink::{BranchTie, Reversals, guard_jump};
use step_series::{StepPolynomial, StepSeries, origin, powers};
pub(super) use step_size::{MAX_GROWTH, step_ratio};

use super::flow::{Flow, OfFlow};
use super::options::Options;
use super::run::{StepState, Trial};
use crate::error::Error;
use crate::math;
use crate::ode::{Dop853, RungeKutta, Timed};
use crate::system::State;
use crate::taylor::recorded_calls::RecordedCalls;
use crate::taylor::row::{CoefficientRow, Lanes};
use crate::taylor::series::{Expansion, Series};
use crate::taylor::sweep::{CoefficientRows, MIN_ROWS};
use crate::taylor::{MAX_COEFFICIENTS, MAX_ORDER};

/// Lowest order of a series: that of the Runge–Kutta method. Loose tolerances would give a lower
/// one.
const MIN_ORDER: usize = Dop853::ORDER as usize;

/// Factor on the step of a series that is not finite. Rejection shrinks the step by a further
/// factor of ten. Chosen: coefficients of order 24 then shrink by up to 72 decades, a quarter of
/// the range.
const NON_FINITE_SHRINK: f64 = 1e-2;

/// Growth of the step from one tied comparison to the next. Chosen: thirteen steps grow from
/// rounding to one.
const TIE_GROWTH: f64 = 16.0;

/// The Taylor stepper: the series and its workspace.
pub(crate) struct TaylorStepper<const N: usize, const G: usize> {
    series: Series<1>,
    /// Description of the latest expansion.
    expansion: Expansion<G>,
    /// The next step if its series is expanded already, otherwise the last step.
    step_series: StepSeries<N>,
    /// Series over the step: of the guards that are not constant, and of the differences in the
    /// comparisons that the step depends on.
    guards: [StepPolynomial; G],
    choices: Vec<StepPolynomial>,
    /// End of the step. If no guard and no comparison can vanish in the step, it is clear, and no
    /// coefficients are copied.
    end_of_step: TaylorStepEnd<N, G>,
    is_clear: bool,
    /// Whether the step ends at the end time.
    is_last: bool,
    is_expanded: bool,
    /// Whether a phase, or the continuation of one, has yet to begin.
    is_new: bool,
    /// End of the last step, and its rounding remainder.
    end: Timed<N>,
    remainder: Timed<N>,
    /// Whether the last step was rejected.
    rejected: bool,
    /// The step length that scales the next series.
    scale: f64,
    /// Ends of steps where a comparison reverses the field.
    reversals: Reversals,
    /// Step length while a comparison is tied. It grows by a factor of [`TIE_GROWTH`] per step as
    /// long as the tie lasts. A state that moves by less than one unit in the last place stays
    /// tied. At the end of the step the series must solve the equation, as at every step.
    tie_step: f64,
}

/// Expands the series of one orbit. Not inlined; see [`CoefficientRows`].
#[inline(never)]
fn expand_alone<F: Flow<N>, const N: usize, const G: usize>(
    first: &[CoefficientRow<1>; MIN_ROWS],
    all: &[CoefficientRow<1>],
    time: (Lanes<1>, Lanes<1>),
    x: &[Lanes<1>; N],
    order: usize,
    flow: &F,
    (repeated, expansion): (&mut Option<&mut RecordedCalls<N, G>>, &mut Expansion<G>),
) -> Result<(), usize> {
    let into = CoefficientRows { first, all };
    *expansion = if const { F::INTERPRETED } {
        let mut temporary = RecordedCalls::default();
        let repeated = repeated.as_deref_mut().unwrap_or(&mut temporary);
        repeated.expand(into, time, x, order, &OfFlow { flow, x })?
    } else {
        flow.expand(into, time, x, order)?
    };
    Ok(())
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    pub(crate) fn new(options: &Options) -> Self {
        let tolerance = options.finest();
        // Jorba & Zou, Eq. (11), plus a few orders: the overhead of a step is spread over more
        // orders.
        let order = (0.5 * -math::ln(tolerance) + 8.0) as usize;
        TaylorStepper {
            series: Series::default(),
            expansion: Expansion::default(),
            step_series: StepSeries {
                t: 0.0,
                h: 0.0,
                to_end: 0.0,
                order: order.clamp(MIN_ORDER, MAX_ORDER),
                x: [State::from([0.0; N]); MAX_COEFFICIENTS],
                remainder: origin(),
            },
            guards: [[0.0; MAX_COEFFICIENTS]; G],
            choices: Vec::new(),
            end_of_step: TaylorStepEnd {
                rise: origin().x,
                slope: origin().x,
                guards: [0.0; G],
            },
            is_clear: false,
            is_last: false,
            is_expanded: false,
            is_new: true,
            end: origin(),
            remainder: origin(),
            rejected: false,
            scale: 0.0,
            reversals: Reversals::NONE,
            tie_step: 0.0,
        }
    }

    /// Resets the stepper for another orbit. Only these fields carry over; all others are
    /// recomputed before use.
    pub(super) fn forget(&mut self) {
        (self.end, self.remainder) = (origin(), origin());
        self.reversals = Reversals::NONE;
    }

    /// Expands the series at the end of the last step.
    fn expand<F: Flow<N>>(
        &mut self,
        run: &mut StepState<N, G>,
        flow: &F,
        mut repeated: Option<&mut RecordedCalls<N, G>>,
    ) {
        let Timed { t, x } = run.at;
        let x = std::array::from_fn(|i| [x[i]]);
        let (scale, order) = (self.scale, self.step_series.order);
        let mut series = std::mem::take(&mut self.series);
        let expansion = &mut self.expansion;
        let time = ([t], [scale]);
        series.expand_by(|CoefficientRows { first, all }| {
            let into = (&mut repeated, &mut *expansion);
            expand_alone(first, all, time, &x, order, flow, into)
        });
        self.plan_and_take(run, &series, time, &x);
        self.series = series;
    }

    /// Plans the next step and copies the coefficients that it needs. Compiled once for all fields.
    #[inline(never)]
    fn plan_and_take(
        &mut self,
        run: &mut StepState<N, G>,
        series: &Series<1>,
        time: (Lanes<1>, Lanes<1>),
        x: &[Lanes<1>; N],
    ) {
        let (order, options) = (self.step_series.order, &run.options);
        let [ratio] = step_ratio(series.rows(), &self.expansion, order, options, time, x);
        let ratio = self.plan(run, ratio);
        self.take(run, series, (0, ratio), None);
    }

    /// The order of the series, and the step length that scales the next series.
    pub(super) fn order_and_scale(&self) -> (usize, f64) {
        (self.step_series.order, self.scale)
    }

    /// Plans the next step within the limit that the series gives. Returns its length over the
    /// length that scales the series.
    pub(super) fn plan(&mut self, run: &mut StepState<N, G>, ratio: f64) -> f64 {
        // The step does not grow immediately after a rejection.
        run.h = self.scale * if self.rejected { ratio.min(1.0) } else { ratio };
        let (h, is_last) = run.next_step();
        let h = if is_last { h - self.remainder.t } else { h };
        (self.step_series.h, self.is_last) = (h, is_last);
        // The last step is shorter by the rounding remainder of the time.
        self.step_series.to_end = ((run.t_end - run.at.t) / h).max(1.0);
        h / self.scale
    }

    /// Stores the description of an expansion of several orbits.
    pub(super) fn expanded(&mut self, expansion: &Expansion<G>) {
        self.expansion = *expansion;
    }

    /// Copies what the step needs from an expansion in which this orbit was lane `lane`. Without
    /// `end` these are the coefficients, in fractions of the step. With `end` the step is clear,
    /// and no coefficients are needed.
    #[inline(always)]
    pub(super) fn take<const L: usize>(
        &mut self,
        run: &StepState<N, G>,
        series: &Series<L>,
        (lane, ratio): (usize, f64),
        end: Option<TaylorStepEnd<N, G>>,
    ) {
        let order = self.step_series.order;
        (
            self.step_series.t,
            self.step_series.remainder,
            self.step_series.x[0],
        ) = (run.at.t, self.remainder, run.at.x);
        self.is_expanded = true;
        self.choices.clear();
        self.is_clear = end.is_some();
        if let Some(end) = end {
            self.end_of_step = end;
            return;
        }
        let powers = powers([ratio]);
        let of_row = |row: &CoefficientRow<L>, k: usize| row.lane(lane, k) * powers[k][0];
        let rows: [&CoefficientRow<L>; N] = std::array::from_fn(|i| &series.rows()[i]);
        // Coefficients above the order are zero and are copied too, so that the loop has a fixed
        // length.
        for (k, x) in self.step_series.x.iter_mut().enumerate() {
            for (x, row) in x.iter_mut().zip(rows) {
                *x = of_row(row, k);
            }
        }
        // For an odd order, the coefficient of the next power is zero.
        let pairs = self.step_series.x[1..=order.next_multiple_of(2)]
            .as_chunks::<2>()
            .0;
        let (rise, slope) = sums(pairs.iter().copied());
        (self.end_of_step.rise, self.end_of_step.slope) = (rise, slope);
        let polynomial = |row: &CoefficientRow<L>, c: &mut StepPolynomial| {
            for (k, c) in c.iter_mut().enumerate() {
                *c = of_row(row, k);
            }
        };
        for (c, watched) in self.guards.iter_mut().zip(&self.expansion.watched) {
            if let Some(watched) = watched {
                polynomial(&series.rows()[watched.row], c);
            }
        }
        for row in series.choices(&self.expansion) {
            let mut c = [0.0; MAX_COEFFICIENTS];
            polynomial(row, &mut c);
            self.choices.push(c);
        }
    }
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// Discards everything that belongs to the previous phase.
    pub(super) fn begin(&mut self) {
        self.is_new = true;
        self.tie_step = 0.0;
    }

    /// Begins a phase, or the continuation of one.
    fn enter<F: Flow<N>>(&mut self, run: &mut StepState<N, G>, flow: &F) {
        let Timed { t, x } = run.at;
        // The rounding remainder belongs to the state it was computed with. Components that landing
        // on Σ has changed lose it.
        if t != self.end.t {
            self.remainder.t = 0.0;
        }
        for i in 0..N {
            if x[i] != self.end.x[i] {
                self.remainder.x[i] = 0.0;
            }
        }
        self.is_new = false;
        self.rejected = false;
        if run.h == 0.0 {
            let field = &mut |t: f64, x: &State<N>| flow.velocity(t, x);
            let slope = field(t, &x);
            run.h = run.choose_first_step(field, t, &x, &slope);
            run.counters.field_calls += 2 * flow.field_calls();
        }
    }

    /// Memory of the next step besides the state of the run: its scale, the rounding remainder and
    /// the length of a tied step.
    pub(super) fn memory(&self) -> (f64, &Timed<N>, f64) {
        (self.scale, &self.remainder, self.tie_step)
    }

    /// Continues between two steps that end at `at`, with [`TaylorStepper::memory`]; without a
    /// scale it begins a phase.
    pub(super) fn restore(&mut self, at: &Timed<N>, (scale, remainder, tie): (f64, Timed<N>, f64)) {
        (self.end, self.remainder, self.tie_step) = (*at, remainder, tie);
        self.is_new = scale == 0.0;
    }

    /// Prepares the next expansion.
    pub(super) fn prepare<F: Flow<N>>(&mut self, run: &mut StepState<N, G>, flow: &F) {
        if self.is_new {
            self.enter(run, flow);
        }
        // If the series terminates, as for a constant field, only these bounds limit the step.
        self.scale = run.h.min(run.options.longest_step).min(f64::MAX.sqrt());
        self.is_expanded = false;
        run.counters.field_calls += flow.field_calls() * (self.step_series.order as u64 + 1);
    }

    /// Time and state at the end of the step, and their rounding remainders.
    #[inline(always)]
    fn end(&self, run: &StepState<N, G>) -> (Timed<N>, Timed<N>) {
        let (mut at, mut remainder) = self.step_series.moved(1.0, &self.end_of_step.rise);
        if self.is_last {
            (at.t, remainder.t) = (run.t_end, 0.0);
        }
        (at, remainder)
    }

    /// Tries a step with the expanded series.
    pub(super) fn advance<F: Flow<N>>(
        &mut self,
        run: &mut StepState<N, G>,
        flow: &F,
        repeated: Option<&mut RecordedCalls<N, G>>,
    ) -> Result<Trial, Error> {
        // If a guard differs from its series at the end of the step, the coefficients are needed
        // too.
        if !self.is_expanded || self.is_clear && !self.holds_at_end(run, flow) {
            self.expand(run, flow, repeated);
        }
        if self.is_last && run.waits() {
            return Ok(Trial::BeforeEnd);
        }
        let (step_series, end) = (&self.step_series, &self.end_of_step);
        let (Timed { t, x }, h, is_last) = (run.at, step_series.h, self.is_last);
        let last = step_series.order;
        let is_finite =
            |i: usize| (step_series.x[last][i] + step_series.x[last - 1][i]).is_finite();
        let is_undefined = !self.is_clear && !(0..N).all(is_finite);
        if is_undefined || run.is_too_short(h, is_last) {
            // Coefficients that overflowed are finite over a shorter step, unless the values
            // themselves overflowed.
            run.reject_undefined(NON_FINITE_SHRINK * self.scale)?;
            if self.expansion.overflowed || run.is_too_short(run.h, false) {
                if let Some(left) = run.leave_without_series(flow) {
                    self.begin();
                    return Ok(left);
                }
                return Err(run.collapse(flow, &flow.velocity(t, &x), run.h));
            }
            return Ok(Trial::NoStep);
        }
        let (mut at, mut remainder) = self.end(run);
        let (kink, is_tie) = self.first_kink();
        let is_clear = self.is_clear && !flow.may_hide_two_fold();
        let event = if is_clear || run.is_prescribed {
            Ok(None)
        } else {
            let reach = kink.filter(|kink| kink.before < 1.0);
            let reach = reach.map_or((1.0, at), |kink| {
                (kink.before, step_series.at(kink.before).0)
            });
            self.first_event(run, flow, &reach)
        };
        let Ok(mut event) = event else {
            self.rejected = true;
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        };
        let mut part = 1.0;
        // Nothing is copied without an event.
        if let Some(located) = &event {
            if kink.is_some_and(|kink| kink.after < located.s) {
                event = None;
            } else if is_last {
                if located.event.at.t >= at.t {
                    event = None;
                }
            } else if located.s >= step_series.to_end {
                // A touch turns back at or after the end time, and the guard is negative at the end
                // of the step.
                part = located.s;
                (at, remainder) = (located.event.at, located.remainder);
                (at.t, remainder.t) = (run.t_end, 0.0);
                event = None;
            }
        }
        let kink = kink.filter(|_| event.is_none());
        if let Some(kink) = kink {
            part = kink.after;
            if part < 1.0 {
                (at, remainder) = step_series.at(part);
            }
        }
        match &event {
            Some(located) => (at, remainder) = (located.event.at, located.remainder),
            None => at.x = flow.settle(at.t, at.x),
        }
        let part = event.as_ref().map_or(part, |event| event.s);
        let slope = if part == 1.0 {
            end.slope
        } else {
            step_series.slope(part)
        };
        let solves = |at: &Timed<N>, slope: &State<N>, options: &Options| {
            step_series.solves_equation(flow, slope, at, options)
        };
        // Behind a kink the field may have jumped, as where a boundary kinks under stick. The kink
        // is where the series has it, as far as the series is exact.
        let solves_before = |kink: BranchTie| {
            let (certain, _) = step_series.at(kink.certain);
            let exactly = Options {
                rtol: run.options.rtol.min(f64::EPSILON),
                atol: run.options.atol.map(|atol| atol.min(f64::EPSILON)),
                ..run.options
            };
            solves(&certain, &step_series.slope(kink.certain), &exactly)
        };
        self.rejected = !solves(&at, &slope, &run.options) && !kink.is_some_and(solves_before);
        if self.rejected {
            run.check_lipschitz(flow)?;
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        }
        let mut jump = None;
        if kink.is_some() {
            jump = guard_jump(flow, &at, &run.options).filter(|_| !run.is_prescribed);
            let field = flow.velocity(at.t, &at.x) * h;
            (self.reversals).record(&at, [&slope, &field], h, &run.options)?;
        }
        self.tie_step = if is_tie { TIE_GROWTH * part * h } else { 0.0 };
        (self.end, self.remainder) = (at, remainder);
        run.counters.steps += 1;
        if !self.is_clear {
            run.dense
                .become_series(t, h, step_series.order, &step_series.x);
        }
        let event = event.as_ref().map(|located| &located.event);
        Ok(run.accept(at, event.or(jump.as_ref())))
    }
}
