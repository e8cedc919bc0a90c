//! Taylor steps through one phase, and the first zero of its guards' series in each.

use super::driver::Stepper;
use super::flow::{Flow, MOST_GUARDS};
use super::leaving::has_left;
use super::locate::{Located, uncertainty};
use super::march::{PhaseEnd, Run};
use super::observer::{Observer, StepRecord, Transition, TransitionKind};
use super::options::Options;
use crate::error::Error;
use crate::math;
use crate::ode::{Dense, Linear, Timed, power_series};
use crate::system::{Mode, Side, State};
use crate::taylor::MOST_ORDER;
use crate::taylor::roots::{first_zero, slope_and_bend, value_and_slope};
use crate::taylor::series::Series;
use crate::taylor::sketch::Sketch;
use crate::taylor::tape::{Combination, Tape};

/// Part of the tolerance that the last coefficients are held to: the steps are long and few, and all of the next ones enlarge
/// what one leaves out.
const SAFETY: f64 = 0.1;

/// Least order: looser tolerances would ask for less.
const LEAST_ORDER: usize = 8;

/// Growth of the step from one to the next at most: a series that ends, of a polynomial solution, says nothing of how far a
/// guard's zero is, and one very near the start of a very long step is badly resolved.
const GROW_MOST: f64 = 8.0;

/// Longest step in units of the radius of convergence as the terms' own ratio tells it: beyond it a series means nothing,
/// however small its terms.
const FARTHEST: f64 = 0.7;

/// Tolerances by which the slope of a series, times the step, may be off the field.
const DEFECT: f64 = 30.0;

/// What a series that is not finite does to the step that it is scaled with.
const SHRINK: f64 = 1e-2;

/// Steps shorter than this part of the time no longer move it.
const SHORTEST: f64 = 4.0 * f64::EPSILON;

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
    /// Where the last step ended, and what rounding took from that.
    end: Timed<f64, N>,
    rest: Timed<f64, N>,
}

fn nowhere<const N: usize>() -> Timed<f64, N> {
    <Timed<f64, N> as Linear<f64>>::zero()
}

/// Sum and rounding error (Knuth).
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// Logarithm to base 2 of a positive number, up to 0.09 too small: good enough for a root of high order.
#[inline(always)]
fn rough_log2(x: f64) -> f64 {
    const MANTISSA: f64 = (1u64 << 52) as f64;
    x.to_bits() as f64 / MANTISSA - 1023.0
}

/// One step's series, in parts of the step.
struct Piece<const N: usize> {
    t: f64,
    h: f64,
    order: usize,
    x: [State<f64, N>; MOST_ORDER + 1],
    rest: Timed<f64, N>,
    /// Step length over the one that the series is scaled with.
    ratio: f64,
}

impl<const N: usize> Piece<N> {
    /// Time and state at the part `s` of the step, and what rounding takes from them.
    #[inline(always)]
    fn at(&self, s: f64) -> (Timed<f64, N>, Timed<f64, N>) {
        let rise = power_series(&self.x[1..=self.order], s);
        let (mut at, mut rest) = (nowhere(), nowhere());
        (at.t, rest.t) = two_sum(self.t, self.rest.t + s * self.h);
        for i in 0..N {
            (at.x[i], rest.x[i]) = two_sum(self.x[0][i], self.rest.x[i] + s * rise[i]);
        }
        (at, rest)
    }

    /// Whether the series still solves the equation at the part `s` of the step, where it leads to `at`: its slope is the
    /// field there. It is not beyond where the field is defined, or where it branches otherwise than the recording.
    #[inline(always)]
    fn agrees<F: Flow<N>>(&self, flow: &F, s: f64, at: &Timed<f64, N>, options: &Options) -> bool {
        let field = flow.field(at.t, &at.x);
        (0..N).all(|i| {
            let (mut value, mut slope) = (0.0, 0.0);
            for x in self.x[..=self.order].iter().rev() {
                slope = slope * s + value;
                value = value * s + x[i];
            }
            let rise = self.h * field[i];
            let size = f64::max(at.x[i].abs(), rise.abs());
            // The slope's own error is the order times the error of the step.
            let allowed = DEFECT * (options.atol + options.rtol * size);
            at.x[i].is_finite() && (rise - slope).abs() <= allowed
        })
    }

    /// A watched function's series.
    #[inline(always)]
    fn polynomial(
        &self,
        series: &Series<1>,
        tape: &Tape,
        function: &Combination,
    ) -> [f64; MOST_ORDER + 1] {
        let mut c = [0.0; MOST_ORDER + 1];
        let mut power = 1.0;
        for (k, c) in c.iter_mut().enumerate().take(self.order + 1) {
            *c = series.combination(tape, function, k)[0] * power;
            power *= self.ratio;
        }
        c
    }
}

/// An event in a step.
struct Event<const N: usize> {
    s: f64,
    guard: usize,
    located: Located<N>,
    rest: Timed<f64, N>,
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
            end: nowhere(),
            rest: nowhere(),
        }
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

    fn expand(&mut self, index: usize, t: f64, x: &State<f64, N>, h: f64) {
        let x: [[f64; 1]; N] = std::array::from_fn(|i| [x[i]]);
        self.series.expand(&self.tapes[index], t, &x, h, self.order);
    }

    /// Whether a comparison that the tape relies on comes out otherwise now.
    fn compares_otherwise(&self, index: usize) -> bool {
        let tape = &self.tapes[index];
        tape.choices.iter().any(|choice| {
            let at = |k| self.series.combination(tape, choice, k)[0];
            // Rounding may leave the start of a branch just off it.
            at(0) < 0.0 && !(at(1) > 0.0 && -at(0) <= 1e-12 * at(1))
        })
    }

    /// The series at `(t, x)` in time over `h`, recorded anew if need be; `false` where it is not finite.
    fn expand_recorded<F: Flow<N>, O>(
        &mut self,
        run: &mut Run<'_, O>,
        flow: &F,
        index: usize,
        at: (f64, &State<f64, N>),
        h: f64,
    ) -> bool {
        let (t, x) = at;
        if self.stale[index] {
            self.record(flow, index, t, x);
            run.counters.field_calls += F::FIELD_CALLS;
        }
        self.expand(index, t, x, h);
        if !self.tapes[index].choices.is_empty() && self.compares_otherwise(index) {
            self.record(flow, index, t, x);
            run.counters.field_calls += F::FIELD_CALLS;
            self.expand(index, t, x, h);
        }
        let last = self.order;
        let finite = (0..N)
            .all(|i| (self.series.at(i, last)[0] + self.series.at(i, last - 1)[0]).is_finite());
        if !finite {
            self.series.clear();
        }
        finite
    }

    /// Step length within the tolerance, over that which the series is scaled with: where the last coefficients, extrapolated
    /// by the radius of convergence that they tell, have fallen to the tolerance (Jorba & Zou 2005, Sect. 3.2).
    fn step_ratio(&self, index: usize, options: &Options, x: &State<f64, N>) -> f64 {
        let p = self.order;
        let relative = options.rtol.max(options.atol);
        let wanted = rough_log2(SAFETY * relative) / p as f64;
        let farthest = rough_log2(FARTHEST);
        let mut log = rough_log2(GROW_MOST);
        for i in 0..N {
            let at = |k| self.series.at(i, k)[0].abs();
            let scale = rough_log2((options.atol + options.rtol * x[i].abs()) / relative);
            // Even or odd series have every other coefficient zero.
            let (mut early, mut late) = (0.0, 0.0);
            for k in p - 3..=p {
                early = f64::max(early, at(k - p / 2));
                late = f64::max(late, at(k));
                if at(k) > 0.0 {
                    log = log.min((scale - rough_log2(at(k))) / k as f64 + wanted);
                }
            }
            if early > 0.0 && late > 0.0 {
                log = log.min((rough_log2(early) - rough_log2(late)) / (p / 2) as f64 + farthest);
            }
        }
        let tape = &self.tapes[index];
        for function in &tape.watched {
            if !tape.is_nonlinear(function, N) {
                continue;
            }
            // What a guard's series leaves out, against how far the guard moves in the step.
            let g = |k| self.series.combination(tape, function, k)[0].abs();
            let ratio = math::exp(log * std::f64::consts::LN_2);
            let size = g(0).max(g(1) * ratio).max(g(2) * ratio * ratio);
            for k in p - 1..=p {
                if g(k) > 0.0 && size > 0.0 {
                    log = log.min(wanted + rough_log2(size / g(k)) / k as f64);
                }
            }
        }
        math::exp(log * std::f64::consts::LN_2)
    }

    fn piece(&self, t: f64, rest: Timed<f64, N>, h: f64, scaled_with: f64) -> Piece<N> {
        let ratio = h / scaled_with;
        let mut x = [State::from([0.0; N]); MOST_ORDER + 1];
        let mut power = 1.0;
        for (k, x) in x.iter_mut().enumerate().take(self.order + 1) {
            for i in 0..N {
                x[i] = self.series.at(i, k)[0] * power;
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

    /// The first guard that fails in the step, and where.
    fn first_event<F: Flow<N>, O>(
        &self,
        run: &mut Run<'_, O>,
        flow: &F,
        index: usize,
        piece: &Piece<N>,
        orders: &[usize; MOST_GUARDS],
    ) -> Option<Event<N>> {
        let tape = &self.tapes[index];
        let mut first: Option<Event<N>> = None;
        for &guard in F::GUARDS {
            let function = &tape.watched[guard];
            if function.count == 0 {
                continue;
            }
            let c = piece.polynomial(&self.series, tape, function);
            let found =
                self.first_failure(run, flow, guard, piece, &c[..=self.order], orders[guard]);
            if let Some(found) = found
                && first.as_ref().is_none_or(|first| found.s < first.s)
            {
                first = Some(found);
            }
        }
        first
    }

    /// The first zero of the guard with series `c`, of which `order` coefficients vanish at the start.
    #[inline(always)]
    fn first_failure<F: Flow<N>, O>(
        &self,
        run: &mut Run<'_, O>,
        flow: &F,
        guard: usize,
        piece: &Piece<N>,
        c: &[f64],
        order: usize,
    ) -> Option<Event<N>> {
        let mut order = order.min(3);
        if order == 0 && c[0] <= 0.0 {
            // A guard left below zero by rounding ends the phase at once, unless it rises.
            if c[1] <= 0.0 {
                return Some(self.locate(run, flow, guard, piece, c, 0.0));
            }
            order = 1;
        }
        if order > 0 {
            let start = Timed {
                t: piece.t,
                x: piece.x[0],
            };
            let floor = uncertainty(flow, guard, &start, &run.options.tolerance()).by_rounding;
            // A step over which the guard does not rise out of rounding cannot hold an event that means anything.
            let risen = |s: f64| {
                let power = (0..order).fold(1.0, |power, _| power * s);
                (value_and_slope(&c[order..], s).0 * power).abs()
            };
            if ![0.25, 0.5, 1.0].iter().any(|&s| risen(s) > floor) {
                return None;
            }
            if c[order] <= 0.0 {
                return Some(self.locate(run, flow, guard, piece, c, 0.0));
            }
        }
        let s = first_zero(&c[order..])?;
        Some(self.locate(run, flow, guard, piece, c, s))
    }

    /// The event at the part `s` of the step: an exit, or a touch where the guard turns back within the touch tolerance.
    #[cold]
    #[inline(never)]
    fn locate<F: Flow<N>, O>(
        &self,
        run: &mut Run<'_, O>,
        flow: &F,
        guard: usize,
        piece: &Piece<N>,
        c: &[f64],
        s: f64,
    ) -> Event<N> {
        run.counters.locations += 1;
        let (slope, bend) = slope_and_bend(c, s);
        let (mut at, mut rest) = piece.at(s);
        if bend > 0.0 && s > 0.0 {
            let blur = uncertainty(flow, guard, &at, &run.options.tolerance());
            let touch = (run.options.touch * blur.by_tolerance).max(blur.by_rounding);
            if slope * slope <= 2.0 * touch * bend {
                let s = turning_point(c, s);
                (at, rest) = piece.at(s);
                at.x = flow.settle(at.t, at.x);
                let residual = value_and_slope(c, s).0.abs();
                let located = Located::Touch { at, residual };
                return Event {
                    s,
                    guard,
                    located,
                    rest,
                };
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
        let located = Located::Exit {
            at,
            residual: left.abs(),
        };
        Event {
            s,
            guard,
            located,
            rest,
        }
    }

    /// Where in the step, before the part `before`, a comparison that the tape relies on first comes out otherwise: a little behind
    /// the place where the two are equal, so that the next recording sees it.
    fn first_kink(&self, index: usize, piece: &Piece<N>, before: f64) -> Option<f64> {
        let tape = &self.tapes[index];
        let mut first: Option<f64> = None;
        for choice in &tape.choices {
            let c = piece.polynomial(&self.series, tape, choice);
            let c = &c[..=self.order];
            // Two that are equal throughout come out the same throughout.
            let Some(start) = c.iter().position(|&c| c != 0.0) else {
                continue;
            };
            let rises = start == 0 && c[0] < 0.0;
            let c_left = &c[if rises { 1 } else { start }..];
            let s = if c_left[0] <= 0.0 {
                0.0
            } else {
                match first_zero(c_left) {
                    Some(s) => s,
                    None => continue,
                }
            };
            let size: f64 = c.iter().map(|c| c.abs()).sum();
            let mut behind = s;
            // At least something, where the step begins at time zero.
            let mut more = 4.0 * f64::EPSILON * (s + (piece.t / piece.h).abs()).max(1.0);
            while behind < 1.0 && value_and_slope(c, behind).0 > -8.0 * f64::EPSILON * size {
                behind = s + more;
                more *= 2.0;
            }
            if behind < first.unwrap_or(before) {
                first = Some(behind);
            }
        }
        first
    }
}

/// Where the series turns near its zero at `s`, by Newton's iteration on its slope.
fn turning_point(c: &[f64], mut s: f64) -> f64 {
    let mut steepness = f64::INFINITY;
    for _ in 0..30 {
        let (slope, bend) = slope_and_bend(c, s);
        if slope == 0.0 || slope.abs() >= steepness || bend <= 0.0 {
            break;
        }
        steepness = slope.abs();
        s = (s - slope / bend).clamp(0.0, 1.05);
    }
    s
}

impl<const N: usize> Stepper<N> for TaylorStepper<N> {
    fn march<F: Flow<N>, O: Observer<N>>(
        &mut self,
        run: &mut Run<'_, O>,
        flow: &F,
        mode: Mode,
        start: Timed<f64, N>,
        mut orders: [usize; MOST_GUARDS],
    ) -> Result<PhaseEnd<N>, Error> {
        let index = tape_index(mode, flow.in_contact());
        let Timed { mut t, mut x } = start;
        let mut rest = self.rest;
        if t != self.end.t {
            rest.t = 0.0;
        }
        for i in 0..N {
            if x[i] != self.end.x[i] {
                rest.x[i] = 0.0;
            }
        }
        if run.h == 0.0 {
            let field = &mut |t: f64, x: &State<f64, N>| flow.field(t, x);
            let slope = field(t, &x);
            run.h = run.choose_first_step(field, t, &x, &slope);
            run.counters.field_calls += 2 * F::FIELD_CALLS;
        }
        let mut rejected = false;
        loop {
            if t >= run.t_end {
                return Ok(PhaseEnd::Time(Timed { t, x }));
            }
            let scale = run.h.min(run.options.longest_step);
            if !self.expand_recorded(run, flow, index, (t, &x), scale) {
                run.reject_undefined(t, &x, SHRINK * scale)?;
                if run.h <= SHORTEST * t.abs() || run.h < f64::MIN_POSITIVE {
                    return Err(run.collapsed(t, &x, &flow.field(t, &x), run.h));
                }
                continue;
            }
            let ratio = self.step_ratio(index, run.options, &x);
            // After a rejection the step does not grow at once.
            run.h = scale * if rejected { ratio.min(1.0) } else { ratio };
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
            let mut event = self
                .first_event(run, flow, index, &piece, &orders)
                .filter(|event| !is_last || event.located.is_before(at.t));
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
            if !piece.agrees(flow, part, &at, run.options) {
                run.reject_undefined(t, &x, h)?;
                rejected = true;
                continue;
            }
            rejected = false;
            (self.end, self.rest) = (at, rest_there);
            run.counters.steps += 1;
            let record = StepRecord {
                mode,
                t_start: t,
                t_end: at.t,
                x_start: x,
                x_end: at.x,
                dense: Dense::of_series(t, h, self.order, &piece.x),
            };
            let told = run.observer.step(&record);
            run.check_escape(&at)?;
            if told.is_break() {
                return Ok(PhaseEnd::Stopped(at));
            }
            match event {
                Some(Event {
                    guard,
                    located: Located::Exit { at, residual },
                    ..
                }) => {
                    return Ok(PhaseEnd::Exit {
                        at,
                        guard,
                        residual,
                        orders,
                    });
                }
                Some(Event {
                    guard,
                    located: Located::Touch { at, residual },
                    ..
                }) => {
                    run.note_event(&at, &flow.field(at.t, &at.x))?;
                    let touch = Transition {
                        t: at.t,
                        x: at.x,
                        kind: TransitionKind::Touch,
                        from: mode,
                        to: mode,
                        residual,
                    };
                    if run.observer.transition(&touch).is_break() {
                        return Ok(PhaseEnd::Stopped(at));
                    }
                    orders[guard] = 2;
                }
                _ => {
                    for &guard in F::GUARDS {
                        let departs = orders[guard] > 0;
                        if departs && has_left::<F, N>(flow, guard, &at, run.options) {
                            orders[guard] = 0;
                        }
                    }
                }
            }
            Timed { t, x } = at;
            rest = rest_there;
        }
    }
}
