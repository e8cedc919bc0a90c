//! The recording number: a [`Scalar`] that remembers how it came about.

use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::sketch::{Form, Op, Sketch};
use crate::math;
use crate::scalar::Scalar;

thread_local! {
    static SKETCH: RefCell<Sketch> = RefCell::default();
}

/// A number on the tape of the recording under way in this thread, and its value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recorded {
    form: u32,
    now: f64,
}

/// Runs `body` with `sketch` as this thread's recording, started anew with `inputs`. A recording that was under way (a field
/// that itself runs a solver) goes on afterwards.
pub(crate) fn recording<R>(sketch: &mut Sketch, inputs: usize, body: impl FnOnce() -> R) -> R {
    sketch.restart(inputs);
    let swap = |sketch: &mut Sketch| SKETCH.with_borrow_mut(|ours| std::mem::swap(ours, sketch));
    swap(sketch);
    let result = body();
    swap(sketch);
    result
}

fn on_sketch<R>(act: impl FnOnce(&mut Sketch) -> R) -> R {
    SKETCH.with_borrow_mut(act)
}

impl Recorded {
    /// Input `node` with its value.
    pub(crate) fn input(node: usize, now: f64) -> Self {
        let form = on_sketch(|sketch| sketch.multiple(1.0, node as u32));
        Recorded { form, now }
    }

    /// What it is a combination of.
    pub(crate) fn form(self, sketch: &Sketch) -> Form {
        sketch.form(self.form)
    }

    fn function(self, op: fn(u32) -> Op, now: f64, offset: u32) -> Self {
        on_sketch(|sketch| {
            let form = match sketch.function(self.form, op) {
                Some(node) => sketch.multiple(1.0, node + offset),
                None => sketch.constant(now),
            };
            Recorded { form, now }
        })
    }
}

impl Scalar for Recorded {
    fn constant(value: f64) -> Self {
        Recorded {
            form: on_sketch(|sketch| sketch.constant(value)),
            now: value,
        }
    }
    fn value(self) -> f64 {
        on_sketch(|sketch| sketch.value_read = true);
        self.now
    }
    fn sin(self) -> Self {
        self.function(Op::Sine, math::sin(self.now), 0)
    }
    fn cos(self) -> Self {
        self.function(Op::Sine, math::cos(self.now), 1)
    }
    fn sqrt(self) -> Self {
        self.function(Op::Root, self.now.sqrt(), 0)
    }
    fn exp(self) -> Self {
        self.function(Op::Exponential, math::exp(self.now), 0)
    }
    fn ln(self) -> Self {
        self.function(Op::Logarithm, math::ln(self.now), 0)
    }
    fn exceeds(self, other: Self) -> bool {
        let exceeds = self.now > other.now;
        on_sketch(|sketch| {
            if exceeds {
                sketch.choose(self.form, other.form);
            } else {
                sketch.choose(other.form, self.form);
            }
        });
        exceeds
    }
    fn divided_or(self, by: Self, otherwise: f64) -> Self {
        if by.now == 0.0 {
            // Elsewhere it is the quotient.
            on_sketch(|sketch| sketch.value_read = true);
            return Self::constant(otherwise);
        }
        self / by
    }
}

impl Neg for Recorded {
    type Output = Self;
    fn neg(self) -> Self {
        Recorded {
            form: on_sketch(|sketch| sketch.scaled(self.form, -1.0)),
            now: -self.now,
        }
    }
}

/// An operator between two recorded numbers, and between one and a constant.
macro_rules! operator {
    ($trait:ident, $method:ident, $operator:tt, $record:expr) => {
        impl $trait for Recorded {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                let record: fn(&mut Sketch, u32, u32) -> u32 = $record;
                Recorded {
                    form: on_sketch(|sketch| record(sketch, self.form, other.form)),
                    now: self.now $operator other.now,
                }
            }
        }
        impl $trait<f64> for Recorded {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                self $operator Self::constant(other)
            }
        }
    };
}

operator!(Add, add, +, |sketch, a, b| sketch.sum(a, 1.0, b));
operator!(Sub, sub, -, |sketch, a, b| sketch.sum(a, -1.0, b));
operator!(Mul, mul, *, |sketch, a, b| sketch.product(a, b));
operator!(Div, div, /, |sketch, a, b| sketch.quotient(a, b));
