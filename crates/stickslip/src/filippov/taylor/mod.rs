//! Taylor steps, and the first zero of the guards' series in each.

mod event;
mod kink;
mod piece;
mod step_size;

use piece::{Piece, nowhere};

use super::flow::Flow;
use super::options::Options;
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

/// What a series that is not finite does to the step that it is scaled with.
const SHRINK: f64 = 1e-2;

/// The Taylor stepper: a series, and room for it.
pub(crate) struct TaylorStepper<const N: usize, const G: usize> {
    order: usize,
    series: Series<1>,
    expansion: Expansion<G>,
    /// What the phase's functions did, where they are interpreted.
    repeated: Repeated<1, N, G>,
    /// Whether the series is that of the next step already.
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
    repeated: &mut Repeated<1, N, G>,
) -> Result<Expansion<G>, usize> {
    in_rows(Rows { first, all }, time, x, order, &OfFlow(flow), repeated)
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    pub(crate) fn new(options: &Options) -> Self {
        let tolerance = options.rtol.max(options.atol);
        // Jorba & Zou, Eq. (11), and a few orders more: the time per order falls as the overhead of a step is spread.
        let order = (0.5 * -math::ln(tolerance) + 8.0) as usize;
        TaylorStepper {
            order: order.clamp(LEAST_ORDER, MOST_ORDER),
            series: Series::new(),
            expansion: Expansion::default(),
            repeated: Repeated::new(),
            is_expanded: false,
            is_new: true,
            end: nowhere(),
            rest: nowhere(),
            rejected: false,
            scale: 0.0,
        }
    }

    /// Keeps its room and nothing else, for another orbit.
    pub(super) fn forget(&mut self) {
        (self.end, self.rest) = (nowhere(), nowhere());
    }

    /// Expands the series at the end of the last step.
    fn expand<F: Flow<N>>(&mut self, run: &mut Run<N, G>, flow: &F) {
        let Timed { t, x } = run.at;
        let x = std::array::from_fn(|i| [x[i]]);
        let (scale, order) = (self.scale, self.order);
        let repeated = &mut self.repeated;
        let alone = |rows: Rows<'_, 1>| {
            let time = ([t], [scale]);
            expand_alone(rows.first, rows.all, time, &x, order, flow, repeated)
        };
        self.expansion = self.series.expand_by(alone);
        self.count(run, flow);
    }

    fn count<F: Flow<N>>(&self, run: &mut Run<N, G>, flow: &F) {
        run.counters.field_calls += flow.field_calls() * (self.order as u64 + 1);
    }

    /// The order of the series, and the step that the next one is scaled with.
    pub(super) fn order_and_scale(&self) -> (usize, f64) {
        (self.order, self.scale)
    }

    /// Takes what a step needs of an expansion in which this orbit was the lane `lane`.
    pub(super) fn take_lane<F: Flow<N>, const L: usize>(
        &mut self,
        run: &mut Run<N, G>,
        flow: &F,
        series: &Series<L>,
        expansion: &Expansion<G>,
        lane: usize,
    ) {
        self.series
            .take_lane::<N, L, _>(series, expansion, lane, self.order);
        self.expansion = *expansion;
        self.is_expanded = true;
        self.count(run, flow);
    }

    fn piece(&self, t: f64, rest: Timed<N>, h: f64, scaled_with: f64) -> Piece<N> {
        let ratio = h / scaled_with;
        let mut x = [State::from([0.0; N]); MOST_ORDER + 1];
        let rows: [&Row<1>; N] = std::array::from_fn(|i| self.series.row(i));
        let mut power = 1.0;
        for (k, x) in x.iter_mut().enumerate().take(self.order + 1) {
            for (x, row) in x.iter_mut().zip(rows) {
                *x = row.lane(0, k) * power;
            }
            power *= ratio;
        }
        Piece {
            t,
            h,
            order: self.order,
            x,
            rest,
            ratio,
        }
    }
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// Forgets what belonged to the phase before.
    pub(super) fn begin(&mut self) {
        self.repeated.forget();
        self.is_new = true;
    }

    /// Begins a phase, or the rest of one.
    fn enter<F: Flow<N>>(&mut self, run: &mut Run<N, G>, flow: &F) {
        let Timed { t, x } = run.at;
        // What rounding took belongs to the state that it was taken from.
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
        self.scale = run.h.min(run.options.longest_step);
        self.is_expanded = false;
    }

    /// Tries a step on the series that was expanded.
    pub(super) fn advance<F: Flow<N>>(
        &mut self,
        run: &mut Run<N, G>,
        flow: &F,
    ) -> Result<Trial, Error> {
        if !self.is_expanded {
            self.expand(run, flow);
        }
        let Timed { t, x } = run.at;
        let (rest, scale) = (self.rest, self.scale);
        let last = self.order;
        if !(0..N).all(|i| (self.series.at(i, last) + self.series.at(i, last - 1)).is_finite()) {
            run.reject_undefined(SHRINK * scale)?;
            if run.is_too_short(run.h, false) {
                return Err(run.collapsed(&flow.velocity(t, &x), run.h));
            }
            return Ok(Trial::NoStep);
        }
        let ratio = self.step_ratio(&run.options, &x);
        // After a rejection the step does not grow at once.
        run.h = scale * if self.rejected { ratio.min(1.0) } else { ratio };
        let (mut h, is_last) = run.next_step();
        if is_last {
            h -= rest.t;
        }
        if run.is_too_short(h, is_last) {
            return Err(run.collapsed(&flow.velocity(t, &x), h));
        }
        let piece = self.piece(t, rest, h, scale);
        let (mut at, mut rest_there) = piece.at(1.0);
        if is_last {
            (at.t, rest_there.t) = (run.t_end, 0.0);
        }
        let mut part = 1.0;
        let Ok(event) = self.first_event(run, flow, &piece) else {
            self.rejected = true;
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        };
        let mut event = event.filter(|event| !is_last || event.event.at.t < at.t);
        let before = event.as_ref().map_or(1.0, |event| event.s);
        if let Some(kink) = self.first_kink(&piece, before) {
            event = None;
            part = kink;
            (at, rest_there) = piece.at(kink);
        }
        match &event {
            Some(found) => (at, rest_there) = (found.event.at, found.rest),
            None => at.x = flow.settle(at.t, at.x),
        }
        let part = event.as_ref().map_or(part, |event| event.s);
        self.rejected = !piece.agrees(flow, part, &at, &run.options);
        if self.rejected {
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        }
        (self.end, self.rest) = (at, rest_there);
        run.counters.steps += 1;
        run.dense.become_series(t, h, self.order, &piece.x);
        Ok(run.accept(at, event.map(|found| found.event)))
    }
}
