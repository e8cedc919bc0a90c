//! A number whose operations are recorded; see [`super::recording`]. It has one lane; the recording
//! can be repeated in several.

use std::cell::{Cell, RefCell};
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::functions::Flat;
use super::jet::Jet;
use super::recording::{Instruction, Location, Operation, Recording};
use super::row::Lanes;
use super::sweep::{CoefficientRows, Sweep};
use crate::scalar::Scalar;

/// A sweep of order 0 whose operations are recorded.
#[derive(Debug)]
pub(super) struct Recorder<'a> {
    pub(super) sweep: Sweep<'a, 1>,
    recording: RefCell<Recording>,
    /// Whether the recording holds for these values of the held components alone.
    pub(super) reads_held: Cell<bool>,
}

impl<'a> Recorder<'a> {
    /// Begins a recording. Time is the first linear number, and the state's components have the
    /// first rows.
    pub(super) fn new(rows: CoefficientRows<'a, 1>, (t, h): (Lanes<1>, Lanes<1>)) -> Self {
        let sweep = Sweep::new(rows, 0);
        let recording = RefCell::new(Recording::begin(sweep.time(t, h)));
        Recorder {
            sweep,
            recording,
            reads_held: Cell::new(false),
        }
    }

    /// A component of the state that is constant along a solution.
    pub(super) fn held(&'a self, value: f64) -> Recorded<'a> {
        let number = Jet::constant(value);
        let location = self.recording.borrow_mut().hold(number);
        self.at(location, number)
    }

    /// The number that the sweep has at a location.
    pub(super) fn at(&'a self, location: Location, number: Jet<'a, 1>) -> Recorded<'a> {
        let location = Some((location, self));
        Recorded { number, location }
    }

    /// The location of a number, also of a constant.
    pub(super) fn location(&self, number: Recorded<'_>) -> Location {
        match number.location {
            Some((location, _)) => location,
            None => self.recording.borrow_mut().constant(number.number),
        }
    }

    fn instruction(
        &self,
        operation: Operation,
        of: [Recorded<'_>; 2],
        constant: f64,
    ) -> Instruction {
        Instruction {
            operation,
            of: of.map(|number| self.location(number)),
            constant: constant.to_bits(),
        }
    }

    /// Performs an operation and records it.
    #[inline(never)]
    fn record(
        &'a self,
        operation: Operation,
        of: [Recorded<'a>; 2],
        constant: f64,
    ) -> Recorded<'a> {
        let instruction = self.instruction(operation, of, constant);
        let mut recording = self.recording.borrow_mut();
        let of_held = of.iter().any(|number| number.is_held());
        let numbers = (of.map(|number| number.number), of_held);
        let (number, location) = recording.record(instruction, numbers, &self.sweep);
        let location = location.map(|location| (location, self));
        Recorded { number, location }
    }

    /// Number of conditions so far.
    pub(super) fn checks(&self) -> usize {
        self.recording.borrow().checks()
    }

    /// The recording.
    pub(super) fn end(self) -> Recording {
        self.recording.into_inner()
    }
}

/// A number at order 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recorded<'a> {
    pub(super) number: Jet<'a, 1>,
    /// The number's location, unless it is constant.
    location: Option<(Location, &'a Recorder<'a>)>,
}

impl<'a> Recorded<'a> {
    /// A constant.
    #[inline(always)]
    fn constant_of(number: Jet<'a, 1>) -> Self {
        let location = None;
        Recorded { number, location }
    }

    /// Whether the number is constant along a solution and follows from held components.
    #[inline(always)]
    fn is_held(self) -> bool {
        self.location.is_some() && self.number.sweep().is_none()
    }

    /// Notes that the operations that follow depend on the value.
    #[inline(always)]
    fn note_read(self) {
        if let Some((_, recorder)) = self.location
            && self.is_held()
        {
            recorder.reads_held.set(true);
        }
    }

    /// The recorder of either number, unless both are constant.
    #[inline(always)]
    fn recorder(self, other: Self) -> Option<&'a Recorder<'a>> {
        self.location
            .or(other.location)
            .map(|(_, recorder)| recorder)
    }

    /// Not inlined: a call is recorded once and repeated often.
    #[inline(never)]
    fn recorded(self, operation: Operation, other: Self, constant: f64) -> Self {
        match self.recorder(other) {
            Some(recorder) => recorder.record(operation, [self, other], constant),
            None => Recorded::constant_of(operation.of(self.number, other.number, constant)),
        }
    }

    /// Records the result of a comparison.
    fn check(self, operation: Operation, other: Self) {
        if let Some(recorder) = self.recorder(other) {
            let instruction = recorder.instruction(operation, [self, other], 0.0);
            let row = recorder.sweep.next_row();
            recorder.recording.borrow_mut().check(instruction, row);
        }
    }

    #[inline(always)]
    fn check_flat(self, flat: Flat) {
        match self.number.bound_before(flat) {
            Some(bound) => {
                self.exceeds(Self::constant(bound));
            }
            None => self.check(Operation::IsSteep(flat), self),
        }
    }

    #[inline(always)]
    fn unary(self, operation: Operation, constant: f64) -> Self {
        self.recorded(operation, self, constant)
    }
}

/// An operator between two numbers, and with a constant on the right.
macro_rules! operator {
    ($name:ident, $method:ident, $operation:ident, $with_constant:ident) => {
        impl $name for Recorded<'_> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.recorded(Operation::$operation, other, 0.0)
            }
        }

        impl $name<f64> for Recorded<'_> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, constant: f64) -> Self {
                self.unary(Operation::$with_constant, constant)
            }
        }
    };
}

operator!(Add, add, Add, AddConstant);
operator!(Sub, sub, Subtract, SubtractConstant);
operator!(Mul, mul, Multiply, MultiplyConstant);
operator!(Div, div, Divide, DivideByConstant);

impl Neg for Recorded<'_> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.unary(Operation::Negate, 0.0)
    }
}

impl Scalar for Recorded<'_> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Recorded::constant_of(Jet::constant(value))
    }
    #[inline(always)]
    fn zero() -> Self {
        Recorded::constant_of(Jet::Zero)
    }
    #[inline(always)]
    fn one() -> Self {
        Recorded::constant_of(Jet::One)
    }
    #[inline(always)]
    fn is_same(self, other: Self) -> bool {
        self.number.is_same(other.number)
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.note_read();
        self.number.value()
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> bool {
        let exceeds = self.number.exceeds(other.number);
        let operation = if exceeds {
            Operation::Exceeds
        } else {
            Operation::ExceedsNot
        };
        self.check(operation, other);
        exceeds
    }
    #[inline(always)]
    fn vanishes(self) -> bool {
        // The recorded operations must be those for other values, too.
        false
    }
    #[inline(always)]
    fn divided_or(self, by: Self, otherwise: f64) -> Self {
        if by.number.is_zero() {
            by.note_read();
            return Self::constant(otherwise);
        }
        by.check(Operation::IsNotZero, by);
        self / by
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let sine = self.unary(Operation::SineCosine, 0.0);
        let cosine = match sine.location {
            Some((Location::InRow(row), recorder)) => recorder.at(
                Location::InRow(row + 1),
                recorder.sweep.stored_number(row as usize + 1),
            ),
            _ => {
                self.note_read();
                Recorded::constant_of(self.number.cos())
            }
        };
        (sine, cosine)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    #[inline(always)]
    fn tan(self) -> Self {
        self.unary(Operation::Tangent, 0.0)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        self.unary(Operation::ArcTangent, 0.0)
    }
    #[inline(always)]
    fn erf(self) -> Self {
        self.check_flat(Flat::ErrorFunction);
        self.unary(Operation::ErrorFunction, 0.0)
    }
    #[inline(always)]
    fn sinh(self) -> Self {
        self.check_flat(Flat::Exponential);
        self.unary(Operation::HyperbolicSine, 0.0)
    }
    #[inline(always)]
    fn cosh(self) -> Self {
        self.check_flat(Flat::Exponential);
        self.unary(Operation::HyperbolicCosine, 0.0)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        self.check_flat(Flat::HyperbolicTangent);
        self.unary(Operation::HyperbolicTangent, 0.0)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.unary(Operation::Root, 0.0)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        self.check_flat(Flat::Exponential);
        self.unary(Operation::Exponential, 0.0)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.unary(Operation::Logarithm, 0.0)
    }
    #[inline(always)]
    fn powf(self, p: f64) -> Self {
        self.unary(Operation::Power, p)
    }
}
