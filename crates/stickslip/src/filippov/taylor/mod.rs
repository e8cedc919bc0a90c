//! Taylor steps through one phase, and the first zero of its guards' series in each.

mod event;
mod kink;
pub(super) mod lanes;
mod piece;
mod step_size;

use event::Event;
use piece::{Piece, nowhere};

use super::driver::Stepper;
use super::flow::{Flow, MOST_GUARDS};
use super::locate::Located;
use super::march::{PhaseEnd, Run};
use super::observer::{Observer, StepRecord};
use super::options::Options;
use super::stepper::SHORTEST;
use crate::error::Error;
use crate::math;
use crate::ode::{Dense, Timed};
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
    phase: Phase<N>,
}

/// The phase under way.
struct Phase<const N: usize> {
    mode: Mode,
    /// Its tape.
    index: usize,
    /// Where the last step ended, and what rounding took from that.
    end: Timed<f64, N>,
    rest: Timed<f64, N>,
    /// How many derivatives of each guard vanish where it was last zero; see [`Run::march`].
    orders: [usize; MOST_GUARDS],
    /// Whether the last step was rejected.
    rejected: bool,
    /// The step that the next series is scaled with.
    scale: f64,
}

impl<const N: usize> Default for Phase<N> {
    fn default() -> Self {
        Phase {
            mode: Mode::Stick,
            index: 0,
            end: nowhere(),
            rest: nowhere(),
            orders: [0; MOST_GUARDS],
            rejected: false,
            scale: 0.0,
        }
    }
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
            phase: Phase::default(),
        }
    }

    /// Keeps its room and nothing else, for another orbit.
    fn forget(&mut self) {
        self.stale = [true; TAPES];
        self.phase = Phase::default();
    }

    /// Makes sure that the tape holds at `(t, x)`.
    fn record<F: Flow<N>>(&mut self, flow: &F, index: usize, t: f64, x: &State<f64, N>) {
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
    fn tape(&self) -> &Tape {
        &self.tapes[self.phase.index]
    }

    fn tape_mut(&mut self) -> &mut Tape {
        &mut self.tapes[self.phase.index]
    }

    /// Takes what a step needs of an expansion in which this orbit was the lane `lane`.
    fn take_lane<const L: usize>(&mut self, of: &Series<L>, lane: usize) {
        let tape = &self.tapes[self.phase.index];
        self.series.take_lane(of, lane, &tape.results, self.order);
    }

    /// Expands the series at the end of the last step.
    fn expand(&mut self) {
        let Timed { t, x } = self.phase.end;
        let x: [[f64; 1]; N] = std::array::from_fn(|i| [x[i]]);
        let tape = &self.tapes[self.phase.index];
        self.series
            .expand(tape, t, &x, self.phase.scale, self.order);
    }

    fn piece(&self, t: f64, rest: Timed<f64, N>, h: f64, scaled_with: f64) -> Piece<N> {
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
    /// Begins a phase.
    fn begin<F: Flow<N>, O>(
        &mut self,
        run: &mut Run<'_, O>,
        flow: &F,
        mode: Mode,
        start: Timed<f64, N>,
        orders: [usize; MOST_GUARDS],
    ) {
        let phase = &mut self.phase;
        // What rounding took belongs to the state that it was taken from.
        if start.t != phase.end.t {
            phase.rest.t = 0.0;
        }
        for i in 0..N {
            if start.x[i] != phase.end.x[i] {
                phase.rest.x[i] = 0.0;
            }
        }
        phase.mode = mode;
        phase.index = tape_index(mode, flow.in_contact());
        phase.end = start;
        phase.orders = orders;
        phase.rejected = false;
        if run.h == 0.0 {
            let Timed { t, x } = start;
            let field = &mut |t: f64, x: &State<f64, N>| flow.field(t, x);
            let slope = field(t, &x);
            run.h = run.choose_first_step(field, t, &x, &slope);
            run.counters.field_calls += 2 * F::FIELD_CALLS;
        }
    }

    /// Makes ready for the next expansion, or says that the end time is reached.
    fn prepare<F: Flow<N>, O>(&mut self, run: &mut Run<'_, O>, flow: &F) -> Option<PhaseEnd<N>> {
        let Timed { t, x } = self.phase.end;
        if t >= run.t_end {
            return Some(PhaseEnd::Time(Timed { t, x }));
        }
        self.phase.scale = run.h.min(run.options.longest_step);
        if self.stale[self.phase.index] {
            self.record(flow, self.phase.index, t, &x);
            run.counters.field_calls += F::FIELD_CALLS;
        }
        None
    }

    /// One step on the series that was expanded; the phase's end, if the step has come to it.
    fn step<F: Flow<N>, O: Observer<N>>(
        &mut self,
        run: &mut Run<'_, O>,
        flow: &F,
    ) -> Result<Option<PhaseEnd<N>>, Error> {
        let Phase {
            mode,
            index,
            end: Timed { t, x },
            rest,
            orders,
            scale,
            ..
        } = self.phase;
        if !self.tapes[index].choices.is_empty() && self.compares_otherwise(index) {
            self.record(flow, index, t, &x);
            run.counters.field_calls += F::FIELD_CALLS;
            self.expand();
        }
        let last = self.order;
        if !(0..N).all(|i| (self.series.at(i, last) + self.series.at(i, last - 1)).is_finite()) {
            run.reject_undefined(t, &x, SHRINK * scale)?;
            if run.h <= SHORTEST * t.abs() || run.h < f64::MIN_POSITIVE {
                return Err(run.collapsed(t, &x, &flow.field(t, &x), run.h));
            }
            return Ok(None);
        }
        let ratio = self.step_ratio(index, run.options, &x);
        // After a rejection the step does not grow at once.
        run.h = scale
            * if self.phase.rejected {
                ratio.min(1.0)
            } else {
                ratio
            };
        let mut h = run.h.min(run.options.longest_step);
        let is_last = t + 1.01 * h >= run.t_end;
        if is_last {
            h = (run.t_end - t) - rest.t;
        }
        if !is_last && h <= SHORTEST * t.abs() || h < f64::MIN_POSITIVE {
            return Err(run.collapsed(t, &x, &flow.field(t, &x), h));
        }
        let piece = self.piece(t, rest, h, scale);
        let (mut at, mut rest_there) = piece.at(1.0);
        if is_last {
            (at.t, rest_there.t) = (run.t_end, 0.0);
        }
        let mut part = 1.0;
        let Ok(event) = self.first_event(run, flow, index, &piece, &orders) else {
            self.phase.rejected = true;
            run.reject_undefined(t, &x, h)?;
            return Ok(None);
        };
        let mut event = event.filter(|event| !is_last || event.located.is_before(at.t));
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
            Some(Event {
                located: Located::Exit { at: there, .. } | Located::Touch { at: there, .. },
                rest,
                ..
            }) => (at, rest_there) = (*there, *rest),
            _ => at.x = flow.settle(at.t, at.x),
        }
        let part = event.as_ref().map_or(part, |event| event.s);
        self.phase.rejected = !piece.agrees(flow, part, &at, run.options);
        if self.phase.rejected {
            run.reject_undefined(t, &x, h)?;
            return Ok(None);
        }
        (self.phase.end, self.phase.rest) = (at, rest_there);
        run.counters.steps += 1;
        let record = StepRecord {
            mode,
            t_start: t,
            t_end: at.t,
            x_start: x,
            x_end: at.x,
            dense: Dense::of_series(t, h, self.order, &piece.x),
        };
        let event = event.map(|event| (event.guard, event.located));
        run.conclude(flow, &record, event, &mut self.phase.orders)
    }
}

impl<const N: usize> Stepper<N> for TaylorStepper<N> {
    fn march<F: Flow<N>, O: Observer<N>>(
        &mut self,
        run: &mut Run<'_, O>,
        flow: &F,
        mode: Mode,
        start: Timed<f64, N>,
        orders: [usize; MOST_GUARDS],
    ) -> Result<PhaseEnd<N>, Error> {
        self.begin(run, flow, mode, start, orders);
        loop {
            if let Some(end) = self.prepare(run, flow) {
                return Ok(end);
            }
            self.expand();
            if let Some(end) = self.step(run, flow)? {
                return Ok(end);
            }
        }
    }
}
