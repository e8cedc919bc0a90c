//! Derivatives of the numbers of a graph, as numbers of the same graph.

use std::f64::consts::FRAC_2_SQRT_PI;
use std::sync::Arc;

use super::functions::Function;
use super::graph::{Graph, Id, Node, NotANumber};
use super::held::Test;
use super::tree::Binary;

/// An input of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphInput {
    /// Time.
    Time,
    /// A component of the state, counted from 0.
    State(usize),
}

impl Graph {
    /// The derivative of a number along a direction: the sum of its partial derivatives, each times
    /// the component of the direction along that input. `None` stands for zero, there and in the
    /// result. Where an absolute value, a maximum or a minimum has a kink, it is the derivative of
    /// neither side.
    ///
    /// # Errors
    /// [`NotANumber`] if a constant part of it is not finite.
    pub fn along(
        &mut self,
        root: Id,
        direction: impl Fn(GraphInput) -> Option<Id>,
    ) -> Result<Option<Id>, NotANumber> {
        let is_used = self.used_by(&[root]);
        let mut derivatives: Vec<Option<Id>> = vec![None; is_used.len()];
        for (i, _) in is_used.iter().enumerate().filter(|(_, is_used)| **is_used) {
            let of = |id: Id| derivatives[id.index()];
            let found = match self.node(Id::of(i)) {
                Node::Constant(_) | Node::Parameter(_) | Node::Held(..) => None,
                Node::Input(0) => direction(GraphInput::Time),
                Node::Input(k) => direction(GraphInput::State(usize::from(k) - 1)),
                Node::Negative(a) => of(a).map(|da| self.negative(da)).transpose()?,
                Node::Sum(a, b) => self.added(of(a), of(b))?,
                Node::Difference(a, b) => self.less(of(a), of(b))?,
                Node::Product(a, b) => {
                    let (left, right) = (self.times(of(a), b)?, self.times(of(b), a)?);
                    self.added(left, right)?
                }
                Node::Quotient(a, b) => {
                    let moved = self.times(of(b), Id::of(i))?;
                    let above = self.less(of(a), moved)?;
                    let quotient = above.map(|above| self.binary(Binary::Quotient, above, b));
                    quotient.transpose()?
                }
                Node::IntegerPower(a, p) | Node::RealPower(a, p) => self.power_rule(a, p, of(a))?,
                Node::Call(function, a) => match of(a) {
                    None => None,
                    da => {
                        let slope = self.slope(function, a, Id::of(i))?;
                        self.times(da, slope)?
                    }
                },
                Node::Curve(number, a) => match of(a) {
                    None => None,
                    da => {
                        let slope = Arc::new(self.curves()[number as usize].derivative());
                        let slope = self.curve(&slope, a)?;
                        self.times(da, slope)?
                    }
                },
                Node::Angle(y, x) => {
                    let (left, right) = (self.times(of(y), x)?, self.times(of(x), y)?);
                    self.less(left, right)?
                        .map(|turn| {
                            let squares = [x, y].map(|one| self.binary(Binary::Product, one, one));
                            let [x, y] = squares;
                            let square = self.binary(Binary::Sum, x?, y?)?;
                            self.binary(Binary::Quotient, turn, square)
                        })
                        .transpose()?
                }
                Node::Larger(a, b) => self.leading([a, b], [of(a), of(b)])?,
                Node::Smaller(a, b) => self.leading([b, a], [of(a), of(b)])?,
                Node::WherePositive(condition, a) => {
                    let there = of(a).map(|da| self.where_positive(condition, da));
                    there.transpose()?
                }
                Node::WhereNotPositive(condition, a) => {
                    let there = of(a).map(|da| self.where_not_positive(condition, da));
                    there.transpose()?
                }
            };
            derivatives[i] = found;
        }
        Ok(derivatives[root.index()])
    }

    /// Whether a number, set as a state, has a continuum of neighbours: its slope along one of
    /// these states is a factor. A slope that is held is one if it is neither 0, 1 nor −1. Another
    /// one is if the number is a curved function of that state. A condition may choose it.
    ///
    /// # Errors
    /// As [`Graph::along`].
    pub fn multiplies(
        &mut self,
        root: Id,
        states: impl Iterator<Item = usize>,
    ) -> Result<bool, NotANumber> {
        let one = self.constant(1.0)?;
        for state in states {
            let along = |input| (input == GraphInput::State(state)).then_some(one);
            if let Some(slope) = self.along(root, along)?
                && self.is_factor(slope, state)
            {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether a slope along a state is a factor in some case.
    fn is_factor(&self, id: Id, state: usize) -> bool {
        if self.is_held(id) {
            let size = self.value(id).map(f64::abs);
            return size != Some(0.0) && size != Some(1.0);
        }
        let of = |id: Id| self.is_factor(id, state);
        match self.node(id) {
            Node::Negative(a) | Node::WherePositive(_, a) | Node::WhereNotPositive(_, a) => of(a),
            Node::Sum(a, b) | Node::Difference(a, b) => of(a) || of(b),
            _ => self.depends_on_states(id, |of| of == state),
        }
    }

    /// Whether a number is a smooth function of its inputs: without absolute values, bounds,
    /// conditions and curves.
    pub fn is_smooth(&self, root: Id) -> bool {
        let is_used = self.used_by(&[root]);
        let mut used = (0..is_used.len()).filter(|&i| is_used[i]);
        used.all(|i| {
            !matches!(
                self.node(Id::of(i)),
                Node::Larger(..)
                    | Node::Smaller(..)
                    | Node::WherePositive(..)
                    | Node::WhereNotPositive(..)
                    | Node::Curve(..)
                    | Node::Call(Function::Abs, _)
            )
        })
    }

    fn added(&mut self, a: Option<Id>, b: Option<Id>) -> Result<Option<Id>, NotANumber> {
        match (a, b) {
            (Some(a), Some(b)) => self.binary(Binary::Sum, a, b).map(Some),
            (one, other) => Ok(one.or(other)),
        }
    }

    fn less(&mut self, a: Option<Id>, b: Option<Id>) -> Result<Option<Id>, NotANumber> {
        match (a, b) {
            (Some(a), Some(b)) => self.binary(Binary::Difference, a, b).map(Some),
            (None, Some(b)) => self.negative(b).map(Some),
            (a, None) => Ok(a),
        }
    }

    /// A derivative, if there is one, times a factor.
    fn times(&mut self, a: Option<Id>, factor: Id) -> Result<Option<Id>, NotANumber> {
        let product = a.map(|a| self.binary(Binary::Product, a, factor));
        let product = product.transpose()?;
        Ok(product.filter(|product| !self.is(*product, Test::Zero)))
    }

    fn power_rule(
        &mut self,
        base: Id,
        exponent: Id,
        moved: Option<Id>,
    ) -> Result<Option<Id>, NotANumber> {
        if moved.is_none() {
            return Ok(None);
        }
        let one = self.constant(1.0)?;
        let lower = self.binary(Binary::Difference, exponent, one)?;
        let power = self.binary(Binary::Power, base, lower)?;
        let slope = self.binary(Binary::Product, exponent, power)?;
        self.times(moved, slope)
    }

    /// The slope of a function of `a` whose value is `value`.
    fn slope(&mut self, function: Function, a: Id, value: Id) -> Result<Id, NotANumber> {
        let one = self.constant(1.0)?;
        Ok(match function {
            Function::Sin => self.call(Function::Cos, a)?,
            Function::Cos => {
                let sine = self.call(Function::Sin, a)?;
                self.negative(sine)?
            }
            Function::Tan => {
                let square = self.binary(Binary::Product, value, value)?;
                self.binary(Binary::Sum, one, square)?
            }
            Function::Atan => {
                let square = self.binary(Binary::Product, a, a)?;
                let sum = self.binary(Binary::Sum, one, square)?;
                self.binary(Binary::Quotient, one, sum)?
            }
            Function::Erf => {
                let square = self.binary(Binary::Product, a, a)?;
                let exponent = self.negative(square)?;
                let (bell, factor) = (
                    self.call(Function::Exp, exponent)?,
                    self.constant(FRAC_2_SQRT_PI)?,
                );
                self.binary(Binary::Product, bell, factor)?
            }
            Function::Sinh => self.call(Function::Cosh, a)?,
            Function::Cosh => self.call(Function::Sinh, a)?,
            Function::Tanh => {
                let square = self.binary(Binary::Product, value, value)?;
                self.binary(Binary::Difference, one, square)?
            }
            Function::Exp => value,
            Function::Ln => self.binary(Binary::Quotient, one, a)?,
            Function::Sqrt => {
                let half = self.constant(0.5)?;
                self.binary(Binary::Quotient, half, value)?
            }
            Function::Abs => {
                let opposite = self.negative(a)?;
                let above = self.where_positive(a, one)?;
                let below = self.where_positive(opposite, one)?;
                self.binary(Binary::Difference, above, below)?
            }
        })
    }

    /// The derivative of the larger of two numbers, given as a difference of `larger` first.
    fn leading(
        &mut self,
        [first, second]: [Id; 2],
        [by_a, by_b]: [Option<Id>; 2],
    ) -> Result<Option<Id>, NotANumber> {
        let lead = self.binary(Binary::Difference, first, second)?;
        let behind = self.negative(lead)?;
        let part = |graph: &mut Graph, condition: Id, of: Option<Id>| {
            of.map(|of| graph.where_positive(condition, of)).transpose()
        };
        let (a, b) = (part(self, lead, by_a)?, part(self, behind, by_b)?);
        self.added(a, b)
    }
}
