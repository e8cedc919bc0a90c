//! Event functions over a step. Functions that differ by a constant share what a step says about
//! them. Over a Taylor step they have series, whose turning points separate all zeros: affine
//! functions as combinations of the series of the states, others by [`super::composed`].

use super::EventFunctions;
use super::over_step::SampledStep;
use crate::filippov::flow::gradient;
use crate::filippov::observer::StepRecord;
use crate::filippov::run::TIME_ROUNDING;
use crate::filippov::uncertainty::STATE_ROUNDING;
use crate::ode::{Timed, power_series};
use crate::system::{State, components};
use crate::taylor::MAX_COEFFICIENTS;
use crate::taylor::roots::{RootBracket, is_positive_folded, newton, turning_points};

/// A function has left its zero where it is so many times its rounding. Chosen above 2, the
/// rounding there and here.
const LEFT: f64 = 4.0;

/// Number of last terms by which the rest of a series is bounded. Chosen: three of four may vanish.
const LAST_TERMS: usize = 4;

/// Bound of what a series leaves out over the sum of these terms. Chosen: terms that fall by a
/// tenth each sum to less.
const TAIL: f64 = 4.0;

/// Largest sum of these terms over that of all. Chosen: terms that come to it by the order of a
/// series halve from one to the next, so that a fast sine in a long step is left to intervals.
const DECAY: f64 = 1e-6;

/// A function of time and state: one of the [`Slopes`], and a constant.
#[derive(Clone, Copy)]
pub(super) struct Affine {
    pub slopes: usize,
    pub constant: f64,
}

/// Common part of functions that differ by a constant: the slopes of affine ones, and the functions
/// without their constant over a step.
pub(super) struct Slopes<const N: usize> {
    normal: State<N>,
    in_time: f64,
    /// Whether there are several of these functions.
    pub is_shared: bool,
    /// Values at the ends of the step.
    start: f64,
    end: f64,
    /// Size of the terms.
    size: f64,
    /// Bound of what the series leaves out.
    tail: f64,
    /// Bounds over the step.
    range: [f64; 2],
    /// Over a Taylor step, the value at its start and the coefficients of the powers of its part.
    series: Option<[f64; MAX_COEFFICIENTS]>,
    order: usize,
    /// The part of the series that the step covers.
    reach: f64,
    /// Turning points of the series, and the end of the step, with the values there; none while
    /// unknown.
    turns: Vec<(f64, f64)>,
}

/// A zero of a function over a Taylor step.
#[derive(Clone, Copy)]
pub(super) struct SeriesZero {
    /// Part of the step.
    pub s: f64,
    /// Parts between which it is the only zero.
    pub between: (f64, f64),
}

impl<const N: usize> Slopes<N> {
    /// The affine ones of event functions, and their slopes.
    pub(super) fn of(events: &impl EventFunctions<N>) -> (Vec<Option<Affine>>, Vec<Self>) {
        let mut all: Vec<Self> = Vec::new();
        let mut affine = |number: usize| {
            if !events.is_affine(number) {
                return None;
            }
            let (t, x) = (0.0, State::from([0.0; N]));
            let value = |t, x: &_| events.value(number, t, x);
            let (normal, in_time) = gradient(value, &Timed { t, x }, N);
            let is_known = |one: &Self| (one.normal, one.in_time) == (normal, in_time);
            let slopes = all.iter().position(is_known).unwrap_or(all.len());
            match all.get_mut(slopes) {
                Some(known) => known.is_shared = true,
                None => all.push(Slopes {
                    normal,
                    in_time,
                    ..Slopes::composed()
                }),
            }
            let constant = events.value(number, t, components(&x));
            Some(Affine { slopes, constant })
        };
        let functions = (0..events.count()).map(&mut affine).collect();
        (functions, all)
    }

    /// The slopes of functions that are not affine, before a step.
    pub(super) fn composed() -> Self {
        Slopes {
            normal: State::from([0.0; N]),
            in_time: 0.0,
            is_shared: false,
            start: 0.0,
            end: 0.0,
            size: 0.0,
            tail: 0.0,
            range: [f64::NEG_INFINITY, f64::INFINITY],
            series: None,
            order: 0,
            reach: 1.0,
            turns: Vec::new(),
        }
    }

    /// Forgets the last step. Nothing is certain of functions that no series follows.
    pub(super) fn forget(&mut self) {
        self.turns.clear();
        self.series = None;
        self.range = [f64::NEG_INFINITY, f64::INFINITY];
    }

    /// Takes the next step of functions that are not affine. `c` are the coefficients of their
    /// change, by powers of the part of the series. `changes` are those up to the middle and the
    /// end of the step, and `size` is that of their terms. A series that does not converge fast
    /// enough is not taken.
    pub(super) fn follow_series<K>(
        &mut self,
        step: &StepRecord<N, K>,
        (c, order): ([f64; MAX_COEFFICIENTS], usize),
        (changes, size): ([f64; 2], f64),
    ) {
        self.forget();
        (self.end, self.size) = (changes[1], size);
        self.take_series(step, (c, order));
        let Some(c) = &self.series else { return };
        let c = &c[..=self.order];
        let sum = |c: &[f64]| c.iter().map(|c| c.abs()).sum::<f64>();
        let last = sum(&c[c.len().saturating_sub(LAST_TERMS).max(1)..]);
        self.tail = TAIL * last;
        let margin = STATE_ROUNDING * self.size + self.tail;
        let is_at = |(s, change): (f64, f64)| (power_series(c, s).0 - change).abs() <= margin;
        let converges = last <= DECAY * sum(c);
        if !(converges && is_at((0.5, changes[0])) && is_at((1.0, changes[1]))) {
            self.forget();
        }
    }

    /// Takes the next step, of states of this size.
    pub(super) fn follow<K>(&mut self, over: &SampledStep<'_, K, N>, size: &State<N>) {
        let (step, dense) = (over.step, &over.step.dense);
        let at = |t: f64, x: &State<N>| self.normal.dot(x) + self.in_time * t;
        (self.start, self.end) = (at(step.t_start, &step.x_start), at(step.t_end, &step.x_end));
        let late = f64::max(step.t_start.abs(), step.t_end.abs());
        self.size = self.normal.abs().dot(size) + self.in_time.abs() * late;
        self.turns.clear();
        self.series = None;
        let Some(of_states) = dense.series() else {
            let half = 0.5 * dense.h * self.in_time;
            let range = over.terms().range_along(&self.normal, half);
            let middle = self.in_time * dense.t0 + half;
            self.range = [range.low + middle, range.high + middle];
            return;
        };
        let mut c = [0.0; MAX_COEFFICIENTS];
        for (c, of_state) in c.iter_mut().zip(of_states) {
            *c = self.normal.dot(of_state);
        }
        c[0] += self.in_time * step.t_start;
        c[1] += self.in_time * dense.h;
        self.take_series(step, (c, of_states.len() - 1));
    }

    /// Takes the coefficients of the powers of the part of the series.
    fn take_series<K>(
        &mut self,
        step: &StepRecord<N, K>,
        (mut c, order): ([f64; MAX_COEFFICIENTS], usize),
    ) {
        let (dense, late) = (&step.dense, f64::max(step.t_start.abs(), step.t_end.abs()));
        // A step that is cut is shorter than its series.
        let length = step.t_end - step.t_start;
        let is_cut = (length - dense.h).abs() > TIME_ROUNDING * late;
        self.reach = if is_cut { length / dense.h } else { 1.0 };
        if is_cut {
            let mut power = 1.0;
            for c in &mut c[1..] {
                power *= self.reach;
                *c *= power;
            }
        }
        let reach: f64 = c[1..].iter().map(|c| c.abs()).sum();
        if !reach.is_finite() {
            self.range = [f64::NEG_INFINITY, f64::INFINITY];
            return;
        }
        // Terms that cancel leave their rounding.
        self.size = self.size.max(reach);
        self.range = [c[0] - reach, c[0] + reach];
        (self.series, self.order) = (Some(c), order);
    }

    /// Whether a function certainly has the sign `side` throughout the step.
    pub(super) fn has_sign(&mut self, side: f64, of: Affine) -> bool {
        self.is_beyond(side, of)
            || !self.is_shared && self.turns.is_empty() && self.is_positive(side, of)
            || self.find_turns() && self.is_beyond(side, of)
    }

    /// Whether coefficients prove that a function has the sign `side` over a Taylor step.
    fn is_positive(&self, side: f64, of: Affine) -> bool {
        let (Some(c), rounding) = (&self.series, self.rounding(of)) else {
            return false;
        };
        let mut height = c.map(|c| side * c);
        height[0] = side * (c[0] + of.constant) - rounding;
        side * (self.end + of.constant) > rounding && is_positive_folded(&height)
    }

    fn is_beyond(&self, side: f64, of: Affine) -> bool {
        // The end of the step may have been moved onto a boundary.
        let low = self.range[0].min(self.end);
        let high = self.range[1].max(self.end);
        let nearest = if side > 0.0 { low } else { -high };
        nearest + side * of.constant > self.rounding(of)
    }

    fn rounding(&self, of: Affine) -> f64 {
        STATE_ROUNDING * (of.constant.abs() + self.size) + self.tail
    }

    /// Finds where the series turns, and narrows the bounds to the values there. Returns whether
    /// that is new.
    fn find_turns(&mut self) -> bool {
        let Some(c) = &self.series else { return false };
        if !self.turns.is_empty() {
            return false;
        }
        let c = &c[..=self.order];
        let (places, count) = turning_points(c);
        if count == MAX_COEFFICIENTS {
            return false;
        }
        let with_value = |&s: &f64| (s, power_series(c, s).0);
        let places = places[..count].iter().chain(&[1.0]);
        self.turns.extend(places.map(with_value));
        self.range = [c[0]; 2];
        for (_, value) in &self.turns {
            self.range = [self.range[0].min(*value), self.range[1].max(*value)];
        }
        true
    }

    /// Time and state at a part of a Taylor step, and the slope of the series there.
    fn moving<K>(&self, s: f64, step: &StepRecord<N, K>) -> Option<(Timed<N>, State<N>)> {
        let (x, slope) = power_series(step.dense.series()?, s * self.reach);
        let t = step.t_start + s * (step.t_end - step.t_start);
        Some((Timed { t, x }, slope))
    }

    /// Time and state at a zero of an affine function in a Taylor step, and the rate there.
    pub(super) fn at<K>(
        &self,
        zero: SeriesZero,
        step: &StepRecord<N, K>,
    ) -> Option<(Timed<N>, f64)> {
        let (at, slope) = self.moving(zero.s, step)?;
        let rate = self.normal.dot(&slope) / step.dense.h + self.in_time;
        Some((at, rate))
    }

    /// The part of a step at which the dense output has its state at a part of the series.
    pub(super) fn part<K>(&self, s: f64, step: &StepRecord<N, K>) -> f64 {
        s * self.reach * (step.dense.h / (step.t_end - step.t_start))
    }

    /// Whether a function with the sign `side` has left its last zero where a step begins.
    pub(super) fn has_left(&self, side: f64, of: Affine) -> bool {
        side * (self.start + of.constant) > LEFT * self.rounding(of)
    }

    /// Finds the zeros of a function in a Taylor step, in order. It has the sign `side` before the
    /// step; one that stands at zero has it from the start of the step on. Returns whether it finds
    /// them: not where rounding would decide whether there is one, nor where the step does not end
    /// where its series does.
    pub(super) fn find_zeros(
        &mut self,
        (side, stands): (f64, bool),
        of: Affine,
        zeros: &mut Vec<SeriesZero>,
    ) -> bool {
        self.find_turns();
        zeros.clear();
        let (Some(c), Some((_, end))) = (&self.series, self.turns.last()) else {
            return false;
        };
        let rounding = self.rounding(of);
        let constant = of.constant;
        let leaves = side * if stands { c[1] } else { c[0] + constant };
        let is_whole = (self.start - c[0]).abs() <= rounding && (self.end - end).abs() <= rounding;
        let is_clear = |(_, value): &(f64, f64)| (value + constant).abs() > rounding;
        let is_certain = is_whole && leaves > rounding && self.turns.iter().all(is_clear);
        // One that stands at zero has left it at the first turn. What is left of zero at the start
        // then says nothing of the next zero: at a low speed it would displace it by far.
        let begins = !stands || side * (self.turns[0].1 + constant) > LEFT * rounding;
        if !is_certain || !begins {
            return false;
        }
        let (mut side, mut before) = (side, (0.0, c[0] + constant));
        for (s, value) in self.turns.iter().map(|(s, value)| (*s, value + constant)) {
            if side * value < 0.0 {
                let mut function = [0.0; MAX_COEFFICIENTS];
                for (function, c) in function.iter_mut().zip(c) {
                    *function = side * c;
                }
                function[0] = side * (c[0] + constant);
                let bracket = RootBracket {
                    a: before.0,
                    b: s,
                    at_a: side * before.1,
                    at_b: side * value,
                };
                let guess = before.0 + (s - before.0) * (before.1 / (before.1 - value));
                zeros.push(SeriesZero {
                    s: newton(&function[..=self.order], bracket, guess),
                    between: (before.0, s),
                });
                side = -side;
            }
            before = (s, value);
        }
        true
    }
}
