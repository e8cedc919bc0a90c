//! Taylor steps, and the first zero of the guards' series in each.

mod event;
mod kink;
mod piece;
mod step_size;

use piece::{Piece, nowhere};

use super::flow::{Flow, MOST_GUARDS};
use super::options::Options;
use super::run::{Run, Trial};
use crate::error::Error;
use crate::math;
use crate::ode::Timed;
use crate::system::{Mode, Side, State};
use crate::taylor::MOST_ORDER;
use crate::taylor::series::Series;
use crate::taylor::sketch::Sketch;
use crate::taylor::tape::Tape;

/// Least order: looser tolerances would ask for less.
const LEAST_ORDER: usize = 8;

/// What a series that is not finite does to the step that it is scaled with.
const SHRINK: f64 = 1e-2;

/// Three modes, each in contact and out of it.
const TAPES: usize = 6;

fn tape_index(mode: Mode, in_contact: bool) -> usize {
    let of_mode = match mode {
        Mode::Slip(Side::Below) => 0,
        Mode::Slip(Side::Above) => 1,
        Mode::Stick => 2,
    };
    2 * of_mode + usize::from(in_contact)
}

/// The Taylor stepper: the tapes of a run and room to evaluate them.
pub(crate) struct TaylorStepper<const N: usize> {
    order: usize,
    tapes: [Tape; TAPES],
    /// Whether a tape must be recorded before it is used.
    stale: [bool; TAPES],
    sketch: Sketch,
    series: Series<1>,
    /// The tape of the phase under way.
    index: usize,
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

impl<const N: usize> TaylorStepper<N> {
    pub(crate) fn new(options: &Options) -> Self {
        let tolerance = options.rtol.max(options.atol);
        // Jorba & Zou, Eq. (11), and a few orders more: the time per order falls as the overhead of a step is spread.
        let order = (0.5 * -math::ln(tolerance) + 8.0) as usize;
        TaylorStepper {
            order: order.clamp(LEAST_ORDER, MOST_ORDER),
            tapes: std::array::from_fn(|_| Tape::default()),
            stale: [true; TAPES],
            sketch: Sketch::default(),
            series: Series::new(),
            index: 0,
            is_new: true,
            end: nowhere(),
            rest: nowhere(),
            rejected: false,
            scale: 0.0,
        }
    }

    /// Keeps its room and nothing else, for another orbit.
    pub(super) fn forget(&mut self) {
        self.stale = [true; TAPES];
        (self.end, self.rest) = (nowhere(), nowhere());
    }

    /// Makes sure that the tape holds at `(t, x)`.
    fn record<F: Flow<N>>(&mut self, flow: &F, index: usize, t: f64, x: &State<N>) {
        self.tapes[index].record(&mut self.sketch, t, x, |t, x| {
            let field = flow.field(t, x);
            let one = crate::scalar::Scalar::constant(1.0);
            let mut guards = [one; MOST_GUARDS];
            for &i in F::GUARDS {
                guards[i] = flow.guard(i, t, x);
            }
            (field, guards)
        });
        self.series.fit(&self.tapes[index]);
        self.stale[index] = self.tapes[index].value_read;
    }

    /// The tape that the next expansion is of.
    pub(super) fn tape(&self) -> &Tape {
        &self.tapes[self.index]
    }

    pub(super) fn tape_mut(&mut self) -> &mut Tape {
        &mut self.tapes[self.index]
    }

    /// The order of the series, and the step that the next one is scaled with.
    pub(super) fn order_and_scale(&self) -> (usize, f64) {
        (self.order, self.scale)
    }

    /// Takes what a step needs of an expansion in which this orbit was the lane `lane`.
    pub(super) fn take_lane<const L: usize>(&mut self, of: &Series<L>, lane: usize) {
        let tape = &self.tapes[self.index];
        self.series.take_lane(of, lane, &tape.results, self.order);
    }

    /// Expands the series at the end of the last step.
    pub(super) fn expand(&mut self, run: &Run<N>) {
        let Timed { t, x } = run.at;
        let x: [[f64; 1]; N] = std::array::from_fn(|i| [x[i]]);
        let tape = &self.tapes[self.index];
        self.series.expand(tape, t, &x, self.scale, self.order);
    }

    fn piece(&self, t: f64, rest: Timed<N>, h: f64, scaled_with: f64) -> Piece<N> {
        let ratio = h / scaled_with;
        let mut x = [State::from([0.0; N]); MOST_ORDER + 1];
        let mut power = 1.0;
        for (k, x) in x.iter_mut().enumerate().take(self.order + 1) {
            for i in 0..N {
                x[i] = self.series.at(i, k) * power;
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

impl<const N: usize> TaylorStepper<N> {
    /// Forgets what belonged to the phase before.
    pub(super) fn begin(&mut self) {
        self.is_new = true;
    }

    /// Begins a phase, or the rest of one.
    fn enter<F: Flow<N>>(&mut self, run: &mut Run<N>, flow: &F) {
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
        self.index = tape_index(run.mode, flow.in_contact());
        self.is_new = false;
        self.rejected = false;
        if run.h == 0.0 {
            let field = &mut |t: f64, x: &State<N>| flow.velocity(t, x);
            let slope = field(t, &x);
            run.h = run.choose_first_step(field, t, &x, &slope);
            run.counters.field_calls += 2 * F::FIELD_CALLS;
        }
    }

    /// Makes ready for the next expansion.
    pub(super) fn prepare<F: Flow<N>>(&mut self, run: &mut Run<N>, flow: &F) {
        if self.is_new {
            self.enter(run, flow);
        }
        self.scale = run.h.min(run.options.longest_step);
        if self.stale[self.index] {
            let Timed { t, x } = run.at;
            self.record(flow, self.index, t, &x);
            run.counters.field_calls += F::FIELD_CALLS;
        }
    }

    /// Tries a step on the series that was expanded.
    pub(super) fn advance<F: Flow<N>>(
        &mut self,
        run: &mut Run<N>,
        flow: &F,
    ) -> Result<Trial, Error> {
        let Timed { t, x } = run.at;
        let (index, rest, scale) = (self.index, self.rest, self.scale);
        if !self.tapes[index].choices.is_empty() && self.compares_otherwise(index) {
            self.record(flow, index, t, &x);
            run.counters.field_calls += F::FIELD_CALLS;
            self.expand(run);
        }
        let last = self.order;
        if !(0..N).all(|i| (self.series.at(i, last) + self.series.at(i, last - 1)).is_finite()) {
            run.reject_undefined(SHRINK * scale)?;
            if run.is_too_short(run.h, false) {
                return Err(run.collapsed(&flow.velocity(t, &x), run.h));
            }
            return Ok(Trial::NoStep);
        }
        let ratio = self.step_ratio(index, &run.options, &x);
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
        let Ok(event) = self.first_event(run, flow, index, &piece) else {
            self.rejected = true;
            run.reject_undefined(h)?;
            return Ok(Trial::NoStep);
        };
        let mut event = event.filter(|event| !is_last || event.event.at.t < at.t);
        if !self.tapes[index].choices.is_empty() {
            let before = event.as_ref().map_or(1.0, |event| event.s);
            if let Some(kink) = self.first_kink(index, &piece, before) {
                event = None;
                part = kink;
                (at, rest_there) = piece.at(kink);
                self.stale[index] = true;
            }
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
