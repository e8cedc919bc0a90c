//! Inputs that depend on time alone, and jumps, as tapes.

use stickslip::dynamics::Jumps;
use stickslip::scalar::{Dual, Interval};
use stickslip::{Direction, Scalar};

use crate::expression::Tape;

/// Numbers that an input holds from one kink to the next: its value is the first, and the second
/// times its clock.
pub const HELD: usize = 2;

/// An input of time alone, linear between its kinks in the reading of its clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// The clock, linear in time; of a switch the function whose sign it is.
    pub clock: Tape,
    /// What it is between kinks.
    pub shape: Shape,
}

/// What an input is between its kinks.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Pieces that come again whenever the clock has gone on by 1. The first begins at 0.
    Repeated(Vec<Piece>),
    /// Pieces that come once. The first goes back without end.
    Once(Vec<Piece>),
    /// The sign of the clock.
    Sign,
}

/// A part of an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Reading of the clock where it begins.
    pub from: f64,
    /// Value there; of a first piece that goes back without end, all the time.
    pub value: f64,
    /// By how much it changes while the clock goes on by 1.
    pub slope: f64,
}

/// Units in the last place by which a clock may be before a kink that it has come to.
const ULPS: f64 = 16.0;

/// Units in the last place within which a time is that of a kink.
const NEAR: f64 = 1024.0;

/// Evaluations in a search for the next change of sign. Where it has not been found by then the run
/// stops for a moment, and looks again.
const MOST: usize = 10_000;

impl Input {
    fn reading<T: Scalar>(&self, t: T, x: &[T]) -> T {
        let mut out = [T::zero()];
        self.clock.evaluate(t, x, &mut out);
        out[0]
    }

    /// The reading of the clock, and its rate.
    fn reading_and_rate(&self, t: f64, x: &[f64]) -> (f64, f64) {
        let frozen: Vec<Dual<f64>> = x.iter().map(|&x| Dual::new(x, 0.0)).collect();
        let Dual { re, eps } = self.reading(Dual::new(t, 1.0), &frozen);
        (re, eps)
    }

    /// The clock at a time, moved on by rounding, so that a kink that is reached is passed.
    fn moved(&self, t: f64, x: &[f64]) -> f64 {
        let reading = self.reading(t, x);
        reading + ULPS * f64::EPSILON * (1.0 + reading.abs())
    }

    /// What it holds from a time on.
    pub fn held(&self, t: f64, x: &[f64]) -> [f64; HELD] {
        let line = |piece: &Piece, turns: f64| match piece.slope {
            0.0 => [piece.value, 0.0],
            slope => [piece.value - slope * (turns + piece.from), slope],
        };
        match &self.shape {
            Shape::Sign => [self.sign(t, x), 0.0],
            Shape::Once(pieces) => {
                let reading = self.moved(t, x);
                let behind = pieces.partition_point(|piece| piece.from <= reading);
                line(&pieces[behind.max(1) - 1], 0.0)
            }
            Shape::Repeated(pieces) => {
                let reading = self.moved(t, x);
                let turns = reading.floor();
                let behind = pieces.partition_point(|piece| piece.from <= reading - turns);
                line(&pieces[behind.max(1) - 1], turns)
            }
        }
    }

    /// When it kinks next, if that is not behind `t_end`.
    fn next_kink(&self, t: f64, x: &[f64], t_end: f64) -> f64 {
        let reading = self.moved(t, x);
        let target = match &self.shape {
            Shape::Sign => return self.next_change(t, x, t_end),
            Shape::Once(pieces) => pieces
                .iter()
                .map(|piece| piece.from)
                .find(|from| *from > reading),
            Shape::Repeated(pieces) => {
                let turns = reading.floor();
                let froms = pieces.iter().map(|piece| turns + piece.from);
                froms.chain([turns + 1.0]).find(|from| *from > reading)
            }
        };
        // From the clock at 0, so that nothing adds up from kink to kink.
        let (at_zero, rate) = self.reading_and_rate(0.0, x);
        match target.map(|target| (target - at_zero) / rate) {
            Some(kink) if kink > t => kink,
            _ => f64::INFINITY,
        }
    }

    /// The sign of the clock just behind a time: of the first value that is not zero; no number
    /// where that is none.
    fn sign(&self, t: f64, x: &[f64]) -> f64 {
        let mut ahead = 4.0 * ULPS * f64::EPSILON * t.abs().max(f64::MIN_POSITIVE / f64::EPSILON);
        while ahead.is_finite() {
            let value = self.reading(t + ahead, x);
            if value.is_nan() {
                return value;
            }
            if value != 0.0 {
                return value.signum();
            }
            ahead *= 8.0;
        }
        1.0
    }

    /// When the clock changes its sign next. Bounds over ranges of time decide where it does not,
    /// and where it rises or falls all the way, so that no change is missed.
    fn next_change(&self, t: f64, x: &[f64], t_end: f64) -> f64 {
        let x_there: Vec<Interval> = x.iter().map(|&x| Interval::around(x, 0.0)).collect();
        let constants = x_there
            .iter()
            .map(|&x| Dual::new(x, Interval::around(0.0, 0.0)));
        let constants: Vec<Dual<Interval>> = constants.collect();
        let one = Interval::around(1.0, 0.0);
        let sign = self.sign(t, x);
        let (mut from, mut h) = (t, 1.0_f64);
        // Where it is zero for a while there is nothing to resolve.
        let mut least = ULPS * f64::EPSILON;
        for _ in 0..MOST {
            if from >= t_end {
                return f64::INFINITY;
            }
            let to = (from + h).min(t_end);
            let range = Interval::new(from, to);
            let over = Interval::decided(|| self.reading(range, &x_there));
            let is_apart = |over: Interval| over.low > 0.0 || over.high < 0.0;
            let is_clear = over.is_some_and(|over| is_apart(over) && over.low * sign > 0.0);
            let rate = || self.reading(Dual::new(range, one), &constants).eps;
            if is_clear || Interval::decided(rate).is_some_and(is_apart) {
                if !is_clear && self.sign(to, x) != sign {
                    return self.change_between(from, to, x, sign);
                }
                (from, h) = (to, 2.0 * h);
                least = ULPS * f64::EPSILON;
            } else if to - from <= least * from.abs().max(f64::MIN_POSITIVE) {
                // It touches zero, to rounding.
                if self.sign(to, x) != sign && to > t {
                    return to;
                }
                (from, h) = (to, 2.0 * h);
                least *= 2.0;
            } else {
                h = 0.5 * (to - from);
            }
        }
        from
    }

    /// The time between two at which the sign changes, by bisection.
    fn change_between(&self, mut from: f64, mut to: f64, x: &[f64], sign: f64) -> f64 {
        loop {
            let middle = 0.5 * (from + to);
            if !(middle > from && middle < to) {
                return to;
            }
            if self.reading(middle, x) * sign > 0.0 {
                from = middle;
            } else {
                to = middle;
            }
        }
    }
}

/// A jump.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// The function whose zero it is.
    pub when: Tape,
    /// Which way that passes through zero.
    pub direction: Direction,
    /// The states behind it.
    pub set: Tape,
    /// The run ends with so many.
    pub most: Option<u64>,
}

/// The jumps and inputs of a system.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Switching {
    /// The jumps.
    pub jumps: Vec<Jump>,
    /// The inputs.
    pub inputs: Vec<Input>,
    /// How many states there are before what inputs hold.
    pub states: usize,
    /// Which of them jumps set to one of some values, with none near by.
    pub discrete: Vec<bool>,
}

impl Switching {
    /// Neither, of a system of so many states.
    pub fn none(states: usize) -> Self {
        Switching {
            states,
            ..Switching::default()
        }
    }

    /// Room for states and what inputs hold.
    pub fn room(&self) -> usize {
        self.states + HELD * self.inputs.len()
    }

    /// States, and behind them what inputs hold from a time on.
    pub fn extended<T: Scalar>(&self, t: f64, x: &[T]) -> Vec<T> {
        let mut values: Vec<f64> = x.iter().map(|x| x.value()).collect();
        values.resize(self.room(), 0.0);
        (0..self.inputs.len()).for_each(|input| self.set_held(input, t, &mut values));
        let held = values[self.states..].iter();
        x.iter()
            .copied()
            .chain(held.map(|&held| T::constant(held)))
            .collect()
    }

    fn set_held(&self, input: usize, t: f64, x: &mut [f64]) {
        let place = self.states + HELD * input;
        let held = self.inputs[input].held(t, &x[..self.states]);
        x[place..place + HELD].copy_from_slice(&held);
    }
}

impl<const N: usize> Jumps<N> for Switching {
    fn count(&self) -> usize {
        self.jumps.len()
    }

    fn direction(&self, jump: usize) -> Direction {
        self.jumps[jump].direction
    }

    #[inline(always)]
    fn when<T: Scalar>(&self, jump: usize, t: T, x: &[T; N]) -> T {
        let mut out = [T::zero()];
        self.jumps[jump].when.evaluate(t, x, &mut out);
        out[0]
    }

    #[inline(always)]
    fn set<T: Scalar>(&self, jump: usize, t: T, x: &[T; N]) -> [T; N] {
        let mut out = *x;
        self.jumps[jump].set.evaluate(t, x, &mut out);
        out
    }

    fn most(&self, jump: usize) -> Option<u64> {
        self.jumps[jump].most
    }

    fn is_discrete(&self, state: usize) -> bool {
        self.discrete.get(state) == Some(&true)
    }

    fn next_kink(&self, t: f64, x: &[f64], t_end: f64) -> f64 {
        let kinks = self.inputs.iter().map(|input| input.next_kink(t, x, t_end));
        kinks.fold(f64::INFINITY, f64::min)
    }

    fn inputs(&self) -> usize {
        self.inputs.len()
    }

    fn kinks(&self, input: usize, t: f64, x: &[f64]) -> bool {
        let near = NEAR * f64::EPSILON * t.abs().max(f64::MIN_POSITIVE / f64::EPSILON);
        let input = &self.inputs[input];
        input.held(t - near, x) != input.held(t + near, x)
    }

    fn clock<T: Scalar>(&self, input: usize, t: T, x: &[T; N]) -> T {
        self.inputs[input].reading(t, x)
    }

    fn hold(&self, input: usize, t: f64, x: &mut [f64]) {
        self.set_held(input, t, x);
    }
}
