//! Taylor steps, and the first zero of the guards' series in each.

mod end;
mod event;
mod kink;
mod piece;
mod step_size;

pub(super) use end::Ends;
use end::{End, sums};
use kink::{jumped, note_turn};
use piece::{Piece, Polynomial, nowhere, powers};
pub(super) use step_size::{GROW_MOST, step_ratio};

use super::flow::Flow;
use super::options::Options;
use super::pile_up::Burst;
use super::run::{Run, Trial};
use crate::error::Error;
use crate::math;
use crate::ode::Timed;
use crate::scalar::Scalar;
use crate::system::State;
use crate::taylor::MOST_ORDER;
use crate::taylor::pass::{AT_ONCE, Rows};
use crate::taylor::repeated::Repeated;
use crate::taylor::row::{Lanes, Row};
use crate::taylor::series::{Expansion, Functions, Series, in_rows};

/// Least order: looser tolerances would ask for less.
const LEAST_ORDER: usize = 8;

/// What a series that is not finite does to the step that it is scaled with, before that is
/// rejected and shrinks tenfold.
const SHRINK: f64 = 1e-2;

/// Growth of steps from equals to equals.
const PAST_TIE: f64 = 16.0;

/// The Taylor stepper: a series, and room for it.
pub(crate) struct TaylorStepper<const N: usize, const G: usize> {
    series: Series<1>,
    /// What the phase's functions did, where they are interpreted.
    repeated: Repeated<1, N, G>,
    /// What the next series is expanded to come to.
    expansion: Expansion<G>,
    /// The next step, if its series is expanded already; else the last one.
    piece: Piece<N>,
    /// Series over it: of the guards that are not constant, and of what the comparisons in it rely
    /// on.
    guards: [Polynomial; G],
    choices: Vec<Polynomial>,
    /// What it comes to at its end, and whether it is sure to come there: then no coefficients were
    /// taken.
    end_of_step: End<N, G>,
    is_clear: bool,
    /// Whether it ends at the end time.
    is_last: bool,
    is_expanded: bool,
    /// Whether the phase, or the rest of one, has yet to begin.
    is_new: bool,
    /// Where the last step ended, and what rounding took from that.
    end: Timed<N>,
    rest: Timed<N>,
    /// Whether the last step was rejected.
    rejected: bool,
    /// The step that the next series is scaled with.
    scale: f64,
    /// Ends of steps where a comparison turns the field round.
    turns: Burst,
    /// Time to go on for where a comparison is between equals: longer by [`PAST_TIE`] than the last
    /// step, if that was so at its start already. A state that moves by less than a unit in its
    /// last place stays there. That the series solves the equation to 30 tolerances is seen at the
    /// step's end.
    past_tie: f64,
}

/// The field of a flow, and its guards.
pub(super) struct OfFlow<'a, F>(pub(super) &'a F);

impl<F: Flow<N>, const N: usize, const G: usize> Functions<N, G> for OfFlow<'_, F> {
    const INTERPRETED: bool = F::INTERPRETED;

    #[inline(always)]
    fn at<T: Scalar>(&self, t: T, x: &[T; N]) -> ([T; N], [T; G]) {
        self.0.field_and_guards(t, x)
    }
}

/// The series of one orbit, not inlined: see [`Rows`].
#[inline(never)]
fn expand_alone<F: Flow<N>, const N: usize, const G: usize>(
    first: &[Row<1>; AT_ONCE],
    all: &[Row<1>],
    time: (Lanes<1>, Lanes<1>),
    x: &[Lanes<1>; N],
    order: usize,
    flow: &F,
    (repeated, expansion): (&mut Repeated<1, N, G>, &mut Expansion<G>),
) -> Result<(), usize> {
    *expansion = in_rows(Rows { first, all }, time, x, order, &OfFlow(flow), repeated)?;
    Ok(())
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    pub(crate) fn new(options: &Options) -> Self {
        let tolerance = options.rtol.max(options.atol);
        // Jorba & Zou, Eq. (11), and a few orders more: the time per order falls as the overhead of
        // a step is spread.
        let order = (0.5 * -math::ln(tolerance) + 8.0) as usize;
        TaylorStepper {
            series: Series::default(),
            repeated: Repeated::new(),
            expansion: Expansion::default(),
            piece: Piece {
                t: 0.0,
                h: 0.0,
                to_end: 0.0,
                order: order.clamp(LEAST_ORDER, MOST_ORDER),
                x: [State::from([0.0; N]); MOST_ORDER + 1],
                rest: nowhere(),
            },
            guards: [[0.0; MOST_ORDER + 1]; G],
            choices: Vec::new(),
            end_of_step: End {
                rise: nowhere().x,
                slope: nowhere().x,
                guards: [0.0; G],
            },
            is_clear: false,
            is_last: false,
            is_expanded: false,
            is_new: true,
            end: nowhere(),
            rest: nowhere(),
            rejected: false,
            scale: 0.0,
            turns: Burst::new(),
            past_tie: 0.0,
        }
    }

    /// Forgets where it ended, for another orbit; whatever else it keeps is made anew before it is
    /// used.
    pub(super) fn forget(&mut self) {
        (self.end, self.rest) = (nowhere(), nowhere());
        self.turns = Burst::new();
    }

    /// Expands the series at the end of the last step.
    fn expand<F: Flow<N>>(&mut self, run: &mut Run<N, G>, flow: &F) {
        let Timed { t, x } = run.at;
        let x = std::array::from_fn(|i| [x[i]]);
        let (scale, order) = (self.scale, self.piece.order);
        let mut series = std::mem::take(&mut self.series);
        let (repeated, expansion) = (&mut self.repeated, &mut self.expansion);
        let time = ([t], [scale]);
        series.expand_by(|Rows { first, all }| {
            expand_alone(first, all, time, &x, order, flow, (repeated, expansion))
        });
        self.plan_and_take(run, &series, time, &x);
        self.series = series;
    }

    /// Plans the next step and takes what it needs of the expansion. Compiled once for all fields.
    #[inline(never)]
    fn plan_and_take(
        &mut self,
        run: &mut Run<N, G>,
        series: &Series<1>,
        time: (Lanes<1>, Lanes<1>),
        x: &[Lanes<1>; N],
    ) {
        let (order, options) = (self.piece.order, &run.options);
        let [ratio] = step_ratio(series.rows(), &self.expansion, order, options, time, x);
        let ratio = self.plan(run, ratio);
        self.take(run, series, (0, ratio), None);
    }

    /// The order of the series, and the step that the next one is scaled with.
    pub(super) fn order_and_scale(&self) -> (usize, f64) {
        (self.piece.order, self.scale)
    }

    /// Plans the next step, as the series allows; its length over that which the series is scaled
    /// with.
    pub(super) fn plan(&mut self, run: &mut Run<N, G>, ratio: f64) -> f64 {
        // After a rejection the step does not grow at once.
        run.h = self.scale * if self.rejected { ratio.min(1.0) } else { ratio };
        let (h, is_last) = run.next_step();
        let h = if is_last { h - self.rest.t } else { h };
        (self.piece.h, self.is_last) = (h, is_last);
        // A last step is shorter by what rounding took from the time.
        self.piece.to_end = ((run.t_end - run.at.t) / h).max(1.0);
        h / self.scale
    }

    /// Tells to what an expansion of several orbits has come.
    pub(super) fn expanded(&mut self, expansion: &Expansion<G>) {
        self.expansion = *expansion;
    }

    /// Takes what the step needs of the expansion, in which this orbit was the lane `lane`: the
    /// coefficients, in parts of the step, unless the step's end is all that is wanted of it, which
    /// then is given.
    #[inline(always)]
    pub(super) fn take<const L: usize>(
        &mut self,
        run: &Run<N, G>,
        series: &Series<L>,
        (lane, ratio): (usize, f64),
        end: Option<End<N, G>>,
    ) {
        let order = self.piece.order;
        (self.piece.t, self.piece.rest, self.piece.x[0]) = (run.at.t, self.rest, run.at.x);
        self.is_expanded = true;
        self.choices.clear();
        self.is_clear = end.is_some();
        if let Some(end) = end {
            self.end_of_step = end;
            return;
        }
        let powers = powers([ratio]);
        let of_row = |row: &Row<L>, k: usize| row.lane(lane, k) * powers[k][0];
        let rows: [&Row<L>; N] = std::array::from_fn(|i| &series.rows()[i]);
        // Of those above the order, too, which are zero: so many that the compiler knows their
        // number.
        for (k, x) in self.piece.x.iter_mut().enumerate() {
            for (x, row) in x.iter_mut().zip(rows) {
                *x = of_row(row, k);
            }
        }
        // Above an odd order there is a zero.
        let pairs = self.piece.x[1..=order.next_multiple_of(2)]
            .as_chunks::<2>()
            .0;
        let (rise, slope) = sums(pairs.iter().copied());
        (self.end_of_step.rise, self.end_of_step.slope) = (rise, slope);
        let polynomial = |row: &Row<L>, c: &mut Polynomial| {
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
            let mut c = [0.0; MOST_ORDER + 1];
            polynomial(row, &mut c);
            self.choices.push(c);
        }
    }
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// Forgets what belonged to the phase before.
    pub(super) fn begin(&mut self) {
        self.repeated.forget();
        self.is_new = true;
        self.past_tie = 0.0;
    }

    /// Begins a phase, or the rest of one.
    fn enter<F: Flow<N>>(&mut self, run: &mut Run<N, G>, flow: &F) {
        let Timed { t, x } = run.at;
        // What rounding took belongs to the state that it was taken from; what landing on Σ has
        // moved by a few units in the last place keeps it.
        if t != self.end.t {
            self.rest.t = 0.0;
        }
        for i in 0..N {
            if x[i] != self.end.x[i] {
                self.rest.x[i] = 0.0;
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

    /// Makes ready for the next expansion.
    pub(super) fn prepare<F: Flow<N>>(&mut self, run: &mut Run<N, G>, flow: &F) {
        if self.is_new {
            self.enter(run, flow);
        }
        // Where the series ends, as of a constant field, nothing else bounds it.
        self.scale = run.h.min(run.options.longest_step).min(f64::MAX.sqrt());
        self.is_expanded = false;
        run.counters.field_calls += flow.field_calls() * (self.piece.order as u64 + 1);
    }

    /// Time and state at the end of the step, and what rounding takes from them.
    #[inline(always)]
    fn end(&self, run: &Run<N, G>) -> (Timed<N>, Timed<N>) {
        let (mut at, mut rest) = self.piece.moved(1.0, &self.end_of_step.rise);
        if self.is_last {
            (at.t, rest.t) = (run.t_end, 0.0);
        }
        (at, rest)
    }

    /// Tries a step on the series that was expanded.
    pub(super) fn advance<F: Flow<N>>(
        &mut self,
        run: &mut Run<N, G>,
        flow: &F,
    ) -> Result<Trial, Error> {
        // Where the step's end shows that its series are not the guards', their coefficients are
        // wanted, too.
        if !self.is_expanded || self.is_clear && !self.holds_at_end(run, flow) {
            self.expand(run, flow);
        }
        let (piece, end) = (&self.piece, &self.end_of_step);
        let (Timed { t, x }, h, is_last) = (run.at, piece.h, self.is_last);
        let last = piece.order;
        let is_finite = |i: usize| (piece.x[last][i] + piece.x[last - 1][i]).is_finite();
        let is_undefined = !self.is_clear && !(0..N).all(is_finite);
        if is_undefined || run.is_too_short(h, is_last) {
            // Coefficients that have overflowed are numbers over a shorter step, unless the values
            // had.
            run.reject_undefined(SHRINK * self.scale)?;
            if self.expansion.overflowed || run.is_too_short(run.h, false) {
                return Err(run.collapse(&flow.velocity(t, &x), run.h));
            }
            return Ok(Trial::NoStep);
        }
        let (mut at, mut rest_there) = self.end(run);
        let (kink, is_tie) = self.first_kink();
        let event = if self.is_clear || run.is_held {
            Ok(None)
        } else {
            let reach = kink.map_or((1.0, at), |kink| (kink.before, piece.at(kink.before).0));
            self.first_event(run, flow, &reach)
        };
        let Ok(mut event) = event else {
            self.rejected = true;
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        };
        let mut part = 1.0;
        // Without an event nothing is copied.
        if let Some(found) = &event {
            if kink.is_some_and(|kink| kink.behind < found.s) {
                event = None;
            } else if is_last {
                if found.event.at.t >= at.t {
                    event = None;
                }
            } else if found.s >= piece.to_end {
                // A touch turns back at the end time or behind it, and the step's end is below
                // zero.
                part = found.s;
                (at, rest_there) = (found.event.at, found.rest);
                (at.t, rest_there.t) = (run.t_end, 0.0);
                event = None;
            }
        }
        let kink = kink.filter(|_| event.is_none());
        if let Some(kink) = kink {
            part = kink.behind;
            (at, rest_there) = piece.at(part);
        }
        match &event {
            Some(found) => (at, rest_there) = (found.event.at, found.rest),
            None => at.x = flow.settle(at.t, at.x),
        }
        let part = event.as_ref().map_or(part, |event| event.s);
        let slope = if part == 1.0 {
            end.slope
        } else {
            piece.slope(part)
        };
        self.rejected = !piece.agrees(flow, &slope, &at, &run.options);
        if self.rejected {
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        }
        let mut jump = None;
        if kink.is_some() {
            jump = jumped(flow, &at, &run.options).filter(|_| !run.is_held);
            let field = flow.velocity(at.t, &at.x) * h;
            note_turn(&mut self.turns, &at, [&slope, &field], &run.options)?;
        }
        self.past_tie = if is_tie { PAST_TIE * part * h } else { 0.0 };
        (self.end, self.rest) = (at, rest_there);
        run.counters.steps += 1;
        if !self.is_clear {
            run.dense.become_series(t, h, piece.order, &piece.x);
        }
        let event = event.as_ref().map(|found| &found.event);
        Ok(run.accept(at, event.or(jump.as_ref())))
    }
}
