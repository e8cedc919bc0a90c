//! Numbers that are constant along an orbit: literals, parameters, and what follows from them.
//!
//! A graph computes them when they are added, and takes decisions by their values: a factor of one
//! is left out, a denominator of zero is refused. Other values of the parameters build nothing
//! where all decisions are the same. [`HeldNumbers::of`] repeats the operations, so that each
//! number has the bits that a build with these values would give.

use std::fmt;
use std::sync::Arc;

use rustc_hash::FxHashSet;
use stickslip::math;

use super::curve::PiecewisePolynomial;
use super::functions::Function;

/// Place of a number among the held numbers of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Place(pub(super) u32);

impl Place {
    pub(super) fn index(self) -> usize {
        self.0 as usize
    }

    /// The number at this place.
    pub fn of(self, held: &[f64]) -> Option<f64> {
        held.get(self.index()).copied()
    }
}

/// Operations of held numbers. Those of one operand have it twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum HeldOperation {
    Negative,
    Sum,
    Difference,
    Product,
    Quotient,
    Power,
    Call(Function),
    Curve(u32),
    Angle,
    Larger,
    Smaller,
    WherePositive,
    WhereNotPositive,
}

impl HeldOperation {
    /// The value. NaN for a curve that is none of `curves`.
    pub(super) fn of(self, a: f64, b: f64, curves: &[Arc<PiecewisePolynomial>]) -> f64 {
        match self {
            HeldOperation::Negative => -a,
            HeldOperation::Sum => a + b,
            HeldOperation::Difference => a - b,
            HeldOperation::Product => a * b,
            HeldOperation::Quotient => a / b,
            HeldOperation::Power if Test::Whole.holds(b) => math::powi(a, b as i32),
            HeldOperation::Power => math::pow(a, b),
            HeldOperation::Call(function) => function.of(a),
            HeldOperation::Curve(number) => curves
                .get(number as usize)
                .map_or(f64::NAN, |curve| curve.of(a)),
            HeldOperation::Angle => math::atan2(a, b),
            HeldOperation::Larger => a.max(b),
            HeldOperation::Smaller => a.min(b),
            HeldOperation::WherePositive if a > 0.0 => b,
            HeldOperation::WhereNotPositive if a > 0.0 => 0.0,
            HeldOperation::WherePositive => 0.0,
            HeldOperation::WhereNotPositive => b,
        }
    }
}

/// Questions about the value of a held number, by which a build decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Test {
    /// Whether it is 0.
    Zero,
    /// Whether it is 1.
    One,
    /// Whether it is −1.
    MinusOne,
    /// Whether it is 1/2.
    Half,
    /// Whether it is an integer of 32 bits.
    Whole,
    /// Whether it is above 0.
    Positive,
    /// Whether it is below 0.
    Negative,
    /// Whether it is between 0 and 1, and neither of them.
    InsideUnit,
    /// Whether it is between 0 and 1, or one of them.
    WithinUnit,
}

impl Test {
    fn holds(self, value: f64) -> bool {
        match self {
            Test::Zero => value == 0.0,
            Test::One => value == 1.0,
            Test::MinusOne => value == -1.0,
            Test::Half => value == 0.5,
            Test::Whole => f64::from(value as i32) == value,
            Test::Positive => value > 0.0,
            Test::Negative => value < 0.0,
            Test::InsideUnit => value > 0.0 && value < 1.0,
            Test::WithinUnit => (0.0..=1.0).contains(&value),
        }
    }
}

/// Computation of a held number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    Literal(f64),
    /// The parameter with this number.
    Parameter(usize),
    Operation(HeldOperation, Place, Place),
}

/// A function of held numbers by whose value a build decides.
pub type HeldProbe = dyn Fn(&Arc<[f64]>) -> usize + Send + Sync;

/// A decision of a build.
#[derive(Clone)]
pub(super) enum BuildDecision {
    /// Answer to a question about one number.
    Asked(Test, Place, bool),
    /// Whether two numbers are equal.
    Equal(Place, Place, bool),
    /// Value of a function of the held numbers.
    Probed(Arc<HeldProbe>, usize),
}

impl BuildDecision {
    fn is_same(&self, held: &Arc<[f64]>) -> bool {
        let value = |place: &Place| held[place.index()];
        match self {
            BuildDecision::Asked(test, place, holds) => test.holds(value(place)) == *holds,
            BuildDecision::Equal(one, other, holds) => (value(one) == value(other)) == *holds,
            BuildDecision::Probed(probe, found) => probe(held) == *found,
        }
    }
}

/// The held numbers of a graph, in order, and the decisions of its build.
#[derive(Clone, Default)]
pub struct HeldNumbers {
    pub(super) rules: Vec<Rule>,
    pub(super) decisions: Vec<BuildDecision>,
    pub(super) curves: Vec<Arc<PiecewisePolynomial>>,
}

impl HeldNumbers {
    /// The held numbers for these values of the parameters; `None` if one is not finite, or a build
    /// with these values would decide otherwise.
    pub fn of(&self, parameters: &[f64]) -> Option<Arc<[f64]>> {
        let mut held: Vec<f64> = Vec::with_capacity(self.rules.len());
        for rule in &self.rules {
            let value = match *rule {
                Rule::Literal(value) => value,
                Rule::Parameter(number) => *parameters.get(number)?,
                Rule::Operation(operation, a, b) => {
                    operation.of(held[a.index()], held[b.index()], &self.curves)
                }
            };
            held.push(normal(value)?);
        }
        let held: Arc<[f64]> = held.into();
        let is_same = |decision: &BuildDecision| decision.is_same(&held);
        self.decisions.iter().all(is_same).then_some(held)
    }
}

impl fmt::Debug for HeldNumbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (numbers, decisions) = (self.rules.len(), self.decisions.len());
        write!(f, "{numbers} held numbers, {decisions} decisions")
    }
}

/// A held number as it is stored, with one zero; `None` unless it is finite.
pub(super) fn normal(value: f64) -> Option<f64> {
    value.is_finite().then_some(value + 0.0)
}

/// Numbers that a graph holds, and the decisions by them so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Holding {
    /// Values, by place.
    pub values: Vec<f64>,
    pub numbers: HeldNumbers,
    asked: FxHashSet<(Test, Place)>,
}

impl Holding {
    pub(super) fn add(&mut self, rule: Rule, value: f64) -> Place {
        let place = Place(self.values.len() as u32);
        self.values.push(value);
        self.numbers.rules.push(rule);
        place
    }

    pub(super) fn value(&self, place: Place) -> f64 {
        self.values[place.index()]
    }

    fn is_literal(&self, place: Place) -> bool {
        matches!(self.numbers.rules[place.index()], Rule::Literal(_))
    }

    /// The answer to a question, which is a decision unless the number is a literal.
    pub(super) fn ask(&mut self, test: Test, place: Place) -> bool {
        let holds = test.holds(self.value(place));
        if !self.is_literal(place) && self.asked.insert((test, place)) {
            self.record(BuildDecision::Asked(test, place, holds));
        }
        holds
    }

    /// Whether two numbers are equal, which is a decision unless both are literals.
    pub(super) fn equal(&mut self, one: Place, other: Place) -> bool {
        let holds = self.value(one) == self.value(other);
        if one != other && !(self.is_literal(one) && self.is_literal(other)) {
            self.record(BuildDecision::Equal(one, other, holds));
        }
        holds
    }

    pub(super) fn record(&mut self, decision: BuildDecision) {
        self.numbers.decisions.push(decision);
    }
}
