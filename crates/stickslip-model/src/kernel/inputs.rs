//! Inputs that depend on time alone, and jumps, as tapes.

use std::borrow::Cow;
use std::sync::Arc;

use numerics::bisect;
use stickslip::dynamics::{Comparison, Jumps};
use stickslip::scalar::{Dual, Interval};
use stickslip::{Direction, Scalar};

use super::conditions::{Choice, JumpCondition, Motion, StateMap, passes_by_time, sign_from};
use super::impacts::Impacts;
use crate::expression::{Place, Tape};
use crate::file::StopEvent;

/// Number of states that an input adds. They are constant from one kink to the next: a value, and a
/// factor on its clock.
pub const HELD_PER_INPUT: usize = 2;

/// An input that depends on time alone and is linear in its clock between kinks.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// The clock, linear in time. For a switch, it is the function whose sign the input takes.
    pub clock: Tape,
    /// The shape between kinks.
    pub shape: Shape,
    /// The width of a pulse among the held numbers, if it is one.
    pub width: Option<Place>,
}

/// The shapes of an input between its kinks.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Pieces that repeat whenever the clock has advanced by 1. The first begins at 0.
    Repeated(Vec<InputPiece>),
    /// Pieces that do not repeat. The first extends back without limit.
    Once(Vec<InputPiece>),
    /// A [`pulse`] whose width is computed from the state, in which a parameter may be.
    Pulse(Tape),
    /// The sign of the clock.
    Sign,
}

/// A piece of an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputPiece {
    /// Clock reading at its start.
    pub from: f64,
    /// Value at its start. For a first piece without a start, its constant value.
    pub value: f64,
    /// Change per unit of the clock.
    pub slope: f64,
}

/// The pieces of an input that is 1 in a fraction of each period, then 0. Its values are NaN unless
/// the fraction is between 0 and 1.
pub fn pulse(width: f64) -> [InputPiece; 2] {
    let is_valid = width > 0.0 && width < 1.0;
    let piece = |from: f64, value: f64| InputPiece {
        from,
        value: if is_valid { value } else { f64::NAN },
        slope: 0.0,
    };
    [piece(0.0, 1.0), piece(width, 0.0)]
}

/// Rounding error of a clock, in units in the last place: of a quotient and a sum, with a margin of
/// about ten. A kink counts as passed if the clock is before it by no more.
const CLOCK_ULPS: f64 = 16.0;

/// Rounding error of the time of a kink, in units in the last place. It is chosen as 64 times that
/// of the clock, since the time follows from the clock by a difference and a quotient.
const KINK_TIME_ULPS: f64 = 1024.0;

/// Ranges that one search for the next sign change examines. It bounds the time between two steps;
/// after that the run pauses there and searches again.
const MOST_SEARCH_RANGES: usize = 10_000;

impl Input {
    /// The input with other values of the held numbers of its graph.
    fn with_held(&self, held: &Arc<[f64]>) -> Self {
        let width = self.width.and_then(|width| width.of(held));
        Input {
            clock: self.clock.with_held(held),
            shape: match (&self.shape, width) {
                (_, Some(width)) => Shape::Repeated(pulse(width).to_vec()),
                (Shape::Pulse(width), None) => Shape::Pulse(width.with_held(held)),
                (shape, None) => shape.clone(),
            },
            width: self.width,
        }
    }

    fn reading<T: Scalar>(&self, t: T, x: &[T]) -> T {
        let mut out = [T::zero()];
        self.clock.evaluate(t, x, &mut out);
        out[0]
    }

    /// The clock reading and its rate.
    fn reading_and_rate(&self, t: f64, x: &[f64]) -> (f64, f64) {
        let frozen: Vec<Dual<f64>> = x.iter().map(|&x| Dual::new(x, 0.0)).collect();
        let Dual { re, eps } = self.reading(Dual::new(t, 1.0), &frozen);
        (re, eps)
    }

    /// Number of repetitions of an input within a span from a time; `None` for one without any.
    pub fn turns(&self, t: f64, span: f64, x: &[f64]) -> Option<f64> {
        match self.shape {
            Shape::Repeated(_) | Shape::Pulse(_) => {
                Some(self.reading(t + span, x) - self.reading(t, x))
            }
            Shape::Once(_) | Shape::Sign => None,
        }
    }

    /// The clock at a time, plus its rounding error, so that a kink at that time counts as passed.
    fn rounded_up(&self, t: f64, x: &[f64]) -> f64 {
        let reading = self.reading(t, x);
        reading + CLOCK_ULPS * f64::EPSILON * (1.0 + reading.abs())
    }

    /// The pieces between kinks; none for a sign.
    fn pieces(&self, t: f64, x: &[f64]) -> Cow<'_, [InputPiece]> {
        match &self.shape {
            Shape::Repeated(pieces) | Shape::Once(pieces) => pieces.into(),
            Shape::Pulse(width) => {
                let mut out = [0.0];
                width.evaluate(t, x, &mut out);
                pulse(out[0]).to_vec().into()
            }
            Shape::Sign => Cow::default(),
        }
    }

    /// The function of time and state that has whole values, or those of a piece's start, at the
    /// kinks near a moment.
    fn kink_function<T: Scalar>(&self, t: T, x: &[T]) -> T {
        let reading = self.reading(t, x);
        let Shape::Pulse(width) = &self.shape else {
            return reading;
        };
        let mut out = [T::zero()];
        width.evaluate(t, x, &mut out);
        let [width] = out;
        let (part, fall) = (reading.value() - reading.value().floor(), width.value());
        // Not halfway between two kinks, where an orbit may well begin.
        let is_near_fall = part > 0.382 * fall && part < fall + 0.618 * (1.0 - fall);
        if is_near_fall {
            reading - width
        } else {
            reading
        }
    }

    /// The numbers held from a time on.
    pub fn held(&self, t: f64, x: &[f64]) -> [f64; HELD_PER_INPUT] {
        let line = |piece: &InputPiece, turns: f64| match piece.slope {
            0.0 => [piece.value, 0.0],
            slope => [piece.value - slope * (turns + piece.from), slope],
        };
        let (reading, pieces) = match &self.shape {
            Shape::Sign => return [self.sign(t, x), 0.0],
            _ => (self.rounded_up(t, x), self.pieces(t, x)),
        };
        let turns = match &self.shape {
            Shape::Once(_) => 0.0,
            _ => reading.floor(),
        };
        let behind = pieces.partition_point(|piece| piece.from <= reading - turns);
        line(&pieces[behind.max(1) - 1], turns)
    }

    /// The next kink, if it is not after `t_end`.
    fn next_kink(&self, t: f64, x: &[f64], t_end: f64) -> f64 {
        let reading = self.rounded_up(t, x);
        let target = match &self.shape {
            Shape::Sign => return self.next_change(t, x, t_end),
            Shape::Once(pieces) => pieces
                .get(pieces.partition_point(|piece| piece.from <= reading))
                .map(|piece| piece.from),
            _ => {
                let (pieces, turns) = (self.pieces(t, x), reading.floor());
                let froms = pieces.iter().map(|piece| turns + piece.from);
                froms.chain([turns + 1.0]).find(|from| *from > reading)
            }
        };
        // Computed from the clock at 0, so that errors do not add up from kink to kink.
        let (at_zero, rate) = self.reading_and_rate(0.0, x);
        match target.map(|target| (target - at_zero) / rate) {
            Some(kink) if kink > t => kink,
            _ => f64::INFINITY,
        }
    }

    /// The sign of the clock just after a time: that of the first value that is not zero, or NaN if
    /// that value is not a number.
    fn sign(&self, t: f64, x: &[f64]) -> f64 {
        let mut ahead =
            4.0 * CLOCK_ULPS * f64::EPSILON * t.abs().max(f64::MIN_POSITIVE / f64::EPSILON);
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

    /// The next sign change of the clock. Interval bounds exclude ranges without a zero and detect
    /// ranges in which the clock is monotone, so that no sign change is missed.
    fn next_change(&self, t: f64, x: &[f64], t_end: f64) -> f64 {
        let x_there: Vec<Interval> = x.iter().map(|&x| Interval::around(x, 0.0)).collect();
        let constants = x_there
            .iter()
            .map(|&x| Dual::new(x, Interval::around(0.0, 0.0)));
        let constants: Vec<Dual<Interval>> = constants.collect();
        let one = Interval::around(1.0, 0.0);
        let sign = self.sign(t, x);
        let (mut from, mut h) = (t, 1.0_f64);
        // A range in which the clock is zero throughout needs no resolution.
        let mut least = CLOCK_ULPS * f64::EPSILON;
        for _ in 0..MOST_SEARCH_RANGES {
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
                    return bisect(from, to, |t| self.reading(t, x) * sign <= 0.0);
                }
                (from, h) = (to, 2.0 * h);
                least = CLOCK_ULPS * f64::EPSILON;
            } else if to - from <= least * from.abs().max(f64::MIN_POSITIVE) {
                // The clock touches zero, within rounding.
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
}

/// A jump.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// The function whose zero triggers the jump.
    pub when: Tape,
    /// Direction of the sign change.
    pub direction: Direction,
    /// Condition of the jump; `None` if it always happens.
    pub condition: Option<JumpCondition>,
    /// The choices in the formulas of the states after the jump.
    pub choices: Vec<Choice>,
    /// The states after the jump.
    pub set: Map,
    /// The run ends with this jump of the count.
    pub most: Option<u64>,
    /// The stop that it is an event of, and which one.
    pub of_stop: Option<(usize, StopEvent)>,
}

impl Jump {
    /// Whether a choice is part of the branch that others have chosen.
    fn counts(&self, choice: &Choice, t: f64, x: &[f64]) -> bool {
        let mut within = choice.within.iter();
        within.all(|(number, holds)| self.choices[*number].condition.holds(t, x) == Some(*holds))
    }

    /// The jump with other values of the held numbers of its graph.
    fn with_held(&self, held: &Arc<[f64]>) -> Self {
        let bound = |condition: &JumpCondition| condition.with_held(held);
        let choices = self.choices.iter().map(|choice| Choice {
            condition: bound(&choice.condition),
            within: choice.within.clone(),
        });
        Jump {
            when: self.when.with_held(held),
            condition: self.condition.as_ref().map(bound),
            choices: choices.collect(),
            set: match &self.set {
                Map::Formulas(tape) => Map::Formulas(tape.with_held(held)),
                of_stop => of_stop.clone(),
            },
            ..self.clone()
        }
    }
}

/// Map of the states by a jump.
#[derive(Clone, Debug, PartialEq)]
pub enum Map {
    /// Expressions for the states.
    Formulas(Tape),
    /// The law of impact, for a stop that closes.
    Impact(usize),
    /// The landing of a stop.
    Landing(usize),
    /// The lift-off from a stop.
    LiftOff(usize),
}

/// The jumps and inputs of a system.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Switching {
    /// The jumps.
    pub jumps: Vec<Jump>,
    /// The law of impact, if there are stops.
    pub impacts: Option<Impacts>,
    /// The inputs.
    pub inputs: Vec<Input>,
    /// Number of states before the numbers that inputs hold.
    pub states: usize,
    /// The states that jumps set to isolated values.
    pub discrete: Vec<bool>,
    /// The states that jumps alone change.
    pub constant_between_jumps: Vec<bool>,
}

impl Switching {
    /// No jumps or inputs, for a system with a given number of states.
    pub fn none(states: usize) -> Self {
        Switching {
            states,
            ..Switching::default()
        }
    }

    /// The jumps and inputs with other values of the held numbers of their graph.
    #[must_use]
    pub fn with_held(&self, held: &Arc<[f64]>) -> Self {
        Switching {
            jumps: self.jumps.iter().map(|jump| jump.with_held(held)).collect(),
            impacts: self.impacts.as_ref().map(|law| law.with_held(held)),
            inputs: self
                .inputs
                .iter()
                .map(|input| input.with_held(held))
                .collect(),
            states: self.states,
            discrete: self.discrete.clone(),
            constant_between_jumps: self.constant_between_jumps.clone(),
        }
    }

    /// Length of the vector of states and of numbers that inputs hold.
    pub fn room(&self) -> usize {
        self.states + HELD_PER_INPUT * self.inputs.len()
    }

    /// The states, followed by the numbers that inputs hold from a time on.
    pub fn extended<T: Scalar>(&self, t: f64, x: &[T]) -> Vec<T> {
        let mut values: Vec<f64> = x.iter().map(|x| x.value()).collect();
        self.extend(t, &mut values);
        let held = values[self.states..].iter();
        x.iter()
            .copied()
            .chain(held.map(|&held| T::constant(held)))
            .collect()
    }

    /// Appends the numbers that inputs hold from a time on to the states.
    pub fn extend(&self, t: f64, states: &mut Vec<f64>) {
        states.resize(self.room(), 0.0);
        (0..self.inputs.len()).for_each(|input| self.set_held(input, t, states));
    }

    /// Replaces a state by that after a jump.
    pub fn after<T: Scalar>(&self, jump: usize, t: T, x: &mut [T]) {
        let jump = &self.jumps[jump];
        let impacts = self.impacts.as_ref();
        let is_undefined = jump.condition.as_ref().is_some_and(|condition| {
            let values: Vec<f64> = x.iter().map(|x| x.value()).collect();
            condition.holds(t.value(), &values).is_none()
        });
        if is_undefined {
            return x.fill(T::constant(f64::NAN));
        }
        match &jump.set {
            Map::Formulas(tape) => {
                let before = x.to_vec();
                tape.evaluate(t, &before, x);
                // A jump of the file may move what a closed stop carries.
                if let Some(impacts) = impacts.filter(|_| jump.of_stop.is_none()) {
                    let carried = impacts.carrying(&before);
                    impacts.settle(t, &before, x);
                    self.release(impacts, &carried, t, x);
                }
            }
            Map::Impact(stop) => {
                if let Some(impacts) = impacts {
                    let carried = impacts.carrying(x);
                    impacts.strike(*stop, t, x);
                    self.release(impacts, &carried, t, x);
                }
            }
            Map::Landing(stop) => {
                if let Some(impacts) = impacts {
                    impacts.land(*stop, t, x);
                }
            }
            Map::LiftOff(stop) => {
                if let Some(impacts) = impacts {
                    impacts.lift_off(*stop, t, x);
                }
            }
        }
    }

    /// Opens those of the stops that an impact has closed that let go at once: the body is at rest
    /// on such a stop for an instant only. A lift-off in that instant would be a second event whose
    /// time the first one decides. Stops that carried before have lift-offs of their own.
    fn release<T: Scalar>(&self, impacts: &Impacts, carried: &[bool], t: T, x: &mut [T]) {
        let carries = impacts.carrying(x);
        if carries
            .iter()
            .zip(carried)
            .all(|(now, before)| !now || *before)
        {
            return;
        }
        let values: Vec<f64> = x.iter().map(|x| x.value()).collect();
        let opened = self.letting_go(impacts, (t.value(), &values), None);
        for (stop, closed) in impacts.closed.iter().enumerate() {
            if opened & 1 << stop != 0 && !carried[stop] {
                x[*closed] = T::zero();
            }
        }
    }

    /// The stops that let go from a moment on, as bits. They are the smallest set such that without
    /// it no reaction pulls, and that of each in it would pull if it alone carried as well: its gap
    /// opens. So reactions and the second derivatives of gaps are complementary.
    ///
    /// Along the motion to the lift-off of a stop that is `due`, rates decide where a reaction
    /// vanishes. That stop lets go where no set follows the rule; without one, none does.
    fn letting_go(
        &self,
        impacts: &Impacts,
        (t, x): (f64, &[f64]),
        due: Option<(usize, Motion<'_>)>,
    ) -> usize {
        let closed = impacts.carrying(x).into_iter().enumerate();
        let all: Vec<(usize, &Tape)> = closed
            .filter(|(_, carries)| *carries)
            .filter_map(|(stop, _)| Some((stop, self.reaction(stop)?)))
            .collect();
        let is_due = |stop: usize| due.is_some_and(|(due, _)| due == stop);
        let follows = |set: &usize| {
            all.iter().all(|&(stop, reaction)| {
                let is_open = set & 1 << stop != 0;
                let mut x = x.to_vec();
                for &(other, _) in &all {
                    let carries = other == stop || set & 1 << other == 0;
                    x[impacts.closed[other]] = f64::from(u8::from(carries));
                }
                let motion = due.map(|(_, motion)| Motion {
                    left: if is_due(stop) { motion.left } else { 0.0 },
                    ..motion
                });
                let sign = sign_from(reaction, (t, &x), motion);
                // A reaction that has come to zero is about to pull.
                let pulls = sign < 0.0 || sign == 0.0 && is_due(stop);
                pulls == is_open
            })
        };
        let bits = |chosen: usize| {
            let chosen = all.iter().enumerate().filter(|(i, _)| chosen & 1 << i != 0);
            chosen.fold(0, |set, (_, (stop, _))| set | 1 << stop)
        };
        let mut sets: Vec<usize> = (0..1 << all.len()).map(bits).collect();
        sets.sort_by_key(|set| set.count_ones());
        let own = due.map_or(0, |(stop, _)| 1 << stop);
        sets.into_iter().find(follows).unwrap_or(own)
    }

    /// The function of a stop's lift-off.
    fn reaction(&self, stop: usize) -> Option<&Tape> {
        let lift_off = Some((stop, StopEvent::LiftOff));
        let mut jumps = self.jumps.iter();
        Some(&jumps.find(|jump| jump.of_stop == lift_off)?.when)
    }

    /// Impulses of all stops at a jump, from the state before it.
    pub fn impulses(&self, jump: usize, t: f64, x: &[f64]) -> Vec<f64> {
        let Some(impacts) = &self.impacts else {
            return Vec::new();
        };
        let jump = &self.jumps[jump];
        match &jump.set {
            Map::Impact(stop) => impacts.impulses(*stop, false, t, x),
            Map::Landing(stop) => impacts.impulses(*stop, true, t, x),
            Map::LiftOff(_) => vec![0.0; impacts.closed.len()],
            Map::Formulas(tape) => {
                let mut behind = x.to_vec();
                tape.evaluate(t, x, &mut behind);
                impacts.impulses_behind(t, x, &mut behind)
            }
        }
    }

    /// Whether a jump whose function is zero happens. A condition that is not defined there counts
    /// as one that holds, and the jump sets what is not a number: an error of the run.
    pub fn happens(&self, jump: usize, t: f64, x: &[f64]) -> bool {
        let condition = self.jumps[jump].condition.as_ref();
        condition.is_none_or(|condition| condition.holds(t, x) != Some(false))
    }

    /// Whether a jump by a function of time alone is due at a moment.
    pub fn is_due_by_time(&self, jump: usize, t: f64, x: &[f64]) -> bool {
        let (of, x) = (&self.jumps[jump], self.extended(t, x));
        passes_by_time(&of.when, self.states, of.direction, (t, &x)) && self.happens(jump, t, &x)
    }

    /// Whether what a jump does hangs on equal numbers: a small change of state or time decides.
    fn is_tied(&self, jump: usize, t: f64, x: &[f64]) -> bool {
        let jump = &self.jumps[jump];
        let is_tied = |of: &JumpCondition| of.is_tied(t, x, &self.discrete);
        let mut choices = jump.choices.iter();
        jump.condition.as_ref().is_some_and(is_tied)
            || choices.any(|choice| jump.counts(choice, t, x) && is_tied(&choice.condition))
    }

    /// The comparisons on which a jump hangs: those of its condition, then those of its choices.
    fn comparisons(&self, number: usize, t: f64, x: &[f64]) -> Vec<Comparison> {
        let jump = &self.jumps[number];
        let map = |x: &mut [f64]| self.after(number, t, x);
        let mut all = Vec::new();
        let conditions = jump.condition.iter().map(|condition| (condition, None));
        let choices = jump.choices.iter();
        let choices = choices.map(|choice| (&choice.condition, Some(choice)));
        for (condition, choice) in conditions.chain(choices) {
            let counts = choice.is_none_or(|choice| jump.counts(choice, t, x));
            let map: Option<&StateMap<'_>> = choice.is_some().then_some(&map);
            let first = (all.len(), map);
            let own = condition.comparisons((t, x), &self.discrete, first);
            all.extend(own.into_iter().map(|one| Comparison {
                decides: one.decides && counts,
                ..one
            }));
        }
        all
    }

    fn set_held(&self, input: usize, t: f64, x: &mut [f64]) {
        let place = self.states + HELD_PER_INPUT * input;
        let held = self.inputs[input].held(t, &x[..self.states]);
        x[place..place + HELD_PER_INPUT].copy_from_slice(&held);
    }
}

impl<const N: usize> Jumps<N> for Switching {
    fn count(&self) -> usize {
        self.jumps.len()
    }

    fn direction(&self, jump: usize) -> Direction {
        self.jumps[jump].direction
    }

    fn is_as_smooth_as_state(&self, jump: usize) -> bool {
        self.jumps[jump].when.is_affine()
    }

    fn is_affine(&self, jump: usize) -> bool {
        self.jumps[jump].when.is_affine()
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
        self.after(jump, t, &mut out);
        out
    }

    fn happens(&self, jump: usize, t: f64, x: &[f64; N]) -> bool {
        Switching::happens(self, jump, t, x)
    }

    fn lets_go(&self, jump: usize, at: (f64, &[f64; N]), velocity: &[f64; N], left: f64) -> bool {
        match (self.jumps[jump].of_stop, &self.impacts) {
            (Some((stop, StopEvent::LiftOff)), Some(impacts)) => {
                let (t, x) = at;
                let motion = Motion {
                    rates: velocity,
                    left,
                };
                let opened = self.letting_go(impacts, (t, x), Some((stop, motion)));
                opened & 1 << stop != 0
            }
            _ => true,
        }
    }

    fn is_tied(&self, jump: usize, t: f64, x: &[f64; N]) -> bool {
        Switching::is_tied(self, jump, t, x)
    }

    fn comparisons(&self, jump: usize, t: f64, x: &[f64; N]) -> Vec<Comparison> {
        Switching::comparisons(self, jump, t, x)
    }

    fn is_conditional(&self, jump: usize) -> bool {
        self.jumps[jump].condition.is_some()
    }

    fn is_searched(&self, jump: usize) -> bool {
        !matches!(self.jumps[jump].of_stop, Some((_, StopEvent::Landing)))
    }

    fn rests(&self, jump: usize) -> Option<usize> {
        let (stop, StopEvent::Impact) = self.jumps[jump].of_stop? else {
            return None;
        };
        let landing = Some((stop, StopEvent::Landing));
        self.jumps.iter().position(|jump| jump.of_stop == landing)
    }

    fn leaves_at_zero(&self, jump: usize, function: usize) -> bool {
        match (self.jumps[jump].of_stop, self.jumps[function].of_stop) {
            (Some((lifted, StopEvent::LiftOff)), Some((stop, StopEvent::Impact))) => lifted == stop,
            _ => false,
        }
    }

    fn is_never_negative(&self, jump: usize) -> bool {
        matches!(self.jumps[jump].of_stop, Some((_, StopEvent::Impact)))
    }

    fn kept(&self, jump: usize, x: &[f64]) -> Option<f64> {
        let (stop, event) = self.jumps[jump].of_stop?;
        let closed = *self.impacts.as_ref()?.closed.get(stop)?;
        // The discrete state of a stop that carries is added to its gap.
        let kept = match event {
            StopEvent::Impact => 1.0,
            StopEvent::Landing => 0.0,
            StopEvent::LiftOff => return None,
        };
        (*x.get(closed)? > 0.5).then_some(kept)
    }

    fn half_carried(&self, x: &[f64], within: f64) -> Option<f64> {
        let closed = self.impacts.iter().flat_map(|impacts| &impacts.closed);
        let mut values = closed.filter_map(|&closed| x.get(closed).copied());
        values.find(|value| value.abs().min((value - 1.0).abs()) > within)
    }

    fn open(&self, x: &mut [f64]) {
        for &closed in self.impacts.iter().flat_map(|impacts| &impacts.closed) {
            if let Some(closed) = x.get_mut(closed) {
                *closed = 0.0;
            }
        }
    }

    fn is_reaction(&self, jump: usize) -> bool {
        matches!(self.jumps[jump].of_stop, Some((_, StopEvent::LiftOff)))
    }

    fn most(&self, jump: usize) -> Option<u64> {
        self.jumps[jump].most
    }

    fn is_discrete(&self, state: usize) -> bool {
        self.discrete.get(state) == Some(&true)
    }

    fn is_constant_between_jumps(&self, state: usize) -> bool {
        self.constant_between_jumps.get(state) == Some(&true)
    }

    fn next_kink(&self, t: f64, x: &[f64], t_end: f64) -> f64 {
        let kinks = self.inputs.iter().map(|input| input.next_kink(t, x, t_end));
        kinks.fold(f64::INFINITY, f64::min)
    }

    fn inputs(&self) -> usize {
        self.inputs.len()
    }

    fn kinks(&self, input: usize, t: f64, x: &[f64]) -> bool {
        let input = &self.inputs[input];
        // The rounding of a clock that has a phase does not vanish with the time.
        let (reading, rate) = input.reading_and_rate(t, x);
        let of_clock = match input.shape {
            Shape::Sign => 0.0,
            _ if rate == 0.0 => 0.0,
            _ => (1.0 + reading.abs()) / rate.abs(),
        };
        let size = t.abs().max(of_clock).max(f64::MIN_POSITIVE / f64::EPSILON);
        let near = KINK_TIME_ULPS * f64::EPSILON * size;
        input.held(t - near, x) != input.held(t + near, x)
    }

    fn clock<T: Scalar>(&self, input: usize, t: T, x: &[T; N]) -> T {
        self.inputs[input].kink_function(t, x)
    }

    fn hold(&self, input: usize, t: f64, x: &mut [f64]) {
        self.set_held(input, t, x);
    }
}
