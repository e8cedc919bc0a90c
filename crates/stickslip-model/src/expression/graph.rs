//! Expressions with resolved names. Common subexpressions are shared and constants are folded.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::curve::PiecewisePolynomial;
use super::functions::Function;
use super::tree::Binary;
use stickslip::math;

/// A number in a [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Id(u32);

impl Id {
    pub(super) fn of(index: usize) -> Self {
        Id(index as u32)
    }

    pub(super) fn index(self) -> usize {
        self.0 as usize
    }
}

/// A constant part of an expression is not a finite number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotANumber {
    /// Value: infinite or NaN.
    pub value: f64,
}

/// Computation of a number. Constants are stored as bits, so that equal ones compare equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Constant(u64),
    /// Time is input 0, and the states follow.
    Input(u8),
    Negative(Id),
    Sum(Id, Id),
    Difference(Id, Id),
    Product(Id, Id),
    Quotient(Id, Id),
    IntegerPower(Id, i32),
    RealPower(Id, u64),
    Call(Function, Id),
    /// The curve with this number.
    Curve(u32, Id),
    /// The angle of the point whose second coordinate comes first.
    Angle(Id, Id),
    Larger(Id, Id),
    Smaller(Id, Id),
    /// The second where the first is positive, else zero.
    WherePositive(Id, Id),
    /// The second where the first is not positive, else zero.
    WhereNotPositive(Id, Id),
}

impl Node {
    /// The operands.
    pub(super) fn operands(self) -> [Option<Id>; 2] {
        match self {
            Node::Constant(_) | Node::Input(_) => [None, None],
            Node::Negative(a)
            | Node::IntegerPower(a, _)
            | Node::RealPower(a, _)
            | Node::Curve(_, a)
            | Node::Call(_, a) => [Some(a), None],
            Node::Sum(a, b)
            | Node::Difference(a, b)
            | Node::Product(a, b)
            | Node::Quotient(a, b)
            | Node::Angle(a, b)
            | Node::Larger(a, b)
            | Node::Smaller(a, b)
            | Node::WherePositive(a, b)
            | Node::WhereNotPositive(a, b) => [Some(a), Some(b)],
        }
    }

    /// The operands without conditions.
    fn values(self) -> [Option<Id>; 2] {
        match self {
            Node::WherePositive(_, a) | Node::WhereNotPositive(_, a) => [Some(a), None],
            other => other.operands(),
        }
    }
}

/// Numbers and their operands. Each number comes after its operands.
///
/// Nothing is reordered or expanded. A number is bit-for-bit what the expression as written gives.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    ids: FxHashMap<Node, Id>,
    curves: Vec<Arc<PiecewisePolynomial>>,
}

type NodeResult = Result<Id, NotANumber>;

impl Graph {
    /// An empty graph.
    pub fn new() -> Self {
        Graph::default()
    }

    pub(super) fn node(&self, id: Id) -> Node {
        self.nodes[id.index()]
    }

    /// The number that is computed so, if there is one.
    pub(super) fn find(&self, node: Node) -> Option<Id> {
        self.ids.get(&node).copied()
    }

    fn add(&mut self, node: Node) -> Id {
        if let Some(id) = self.find(node) {
            return id;
        }
        let id = Id::of(self.nodes.len());
        self.nodes.push(node);
        self.ids.insert(node, id);
        id
    }

    /// Time.
    pub fn time(&mut self) -> Id {
        self.add(Node::Input(0))
    }

    /// A component of the state, counted from 0.
    pub fn state(&mut self, number: usize) -> Id {
        self.add(Node::Input(number as u8 + 1))
    }

    /// A constant.
    ///
    /// # Errors
    /// [`NotANumber`] unless it is finite.
    pub fn constant(&mut self, value: f64) -> NodeResult {
        if !value.is_finite() {
            return Err(NotANumber { value });
        }
        // Both zeros are stored as +0.
        Ok(self.add(Node::Constant((value + 0.0).to_bits())))
    }

    /// The value of a constant.
    pub fn value(&self, id: Id) -> Option<f64> {
        match self.node(id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// The negative of a number.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn negative(&mut self, a: Id) -> NodeResult {
        match self.node(a) {
            Node::Constant(bits) => self.constant(-f64::from_bits(bits)),
            Node::Negative(inner) => Ok(inner),
            _ => Ok(self.add(Node::Negative(a))),
        }
    }

    /// Two numbers joined by an operator.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn binary(&mut self, operator: Binary, a: Id, b: Id) -> NodeResult {
        match operator {
            Binary::Sum => self.sum(a, b),
            Binary::Difference => self.difference(a, b),
            Binary::Product => self.product(a, b),
            Binary::Quotient => self.quotient(a, b),
            Binary::Power => self.power(a, b),
        }
    }

    fn sum(&mut self, a: Id, b: Id) -> NodeResult {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.constant(a + b),
            (Some(0.0), None) => Ok(b),
            (None, Some(0.0)) => Ok(a),
            _ => Ok(self.commutative(Node::Sum(a, b), Node::Sum(b, a))),
        }
    }

    fn difference(&mut self, a: Id, b: Id) -> NodeResult {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.constant(a - b),
            (Some(0.0), None) => self.negative(b),
            (None, Some(0.0)) => Ok(a),
            _ if a == b => self.constant(0.0),
            _ => Ok(self.add(Node::Difference(a, b))),
        }
    }

    fn product(&mut self, a: Id, b: Id) -> NodeResult {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.constant(a * b),
            (Some(factor), None) => self.scaled(b, factor),
            (None, Some(factor)) => self.scaled(a, factor),
            _ => Ok(self.commutative(Node::Product(a, b), Node::Product(b, a))),
        }
    }

    fn scaled(&mut self, a: Id, factor: f64) -> NodeResult {
        if factor == 1.0 {
            return Ok(a);
        }
        if factor == -1.0 {
            return self.negative(a);
        }
        let factor = self.constant(factor)?;
        if self.value(factor) == Some(0.0) {
            return Ok(factor);
        }
        Ok(self.add(Node::Product(a, factor)))
    }

    fn quotient(&mut self, a: Id, b: Id) -> NodeResult {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.constant(a / b),
            (None, Some(0.0)) => Err(NotANumber {
                value: f64::INFINITY,
            }),
            (None, Some(1.0)) => Ok(a),
            (None, Some(-1.0)) => self.negative(a),
            (Some(0.0), None) => Ok(a),
            _ => Ok(self.add(Node::Quotient(a, b))),
        }
    }

    fn power(&mut self, a: Id, b: Id) -> NodeResult {
        let Some(exponent) = self.value(b) else {
            // For a positive base only: with another base, a power with a varying exponent is not
            // real.
            let logarithm = self.call(Function::Ln, a)?;
            let product = self.product(logarithm, b)?;
            return self.call(Function::Exp, product);
        };
        let whole = exponent as i32;
        let is_whole = f64::from(whole) == exponent;
        if let Some(base) = self.value(a) {
            return self.constant(if is_whole {
                math::powi(base, whole)
            } else {
                math::pow(base, exponent)
            });
        }
        match exponent {
            0.0 => self.constant(1.0),
            1.0 => Ok(a),
            0.5 => self.call(Function::Sqrt, a),
            _ if is_whole => Ok(self.add(Node::IntegerPower(a, whole))),
            _ => Ok(self.add(Node::RealPower(a, exponent.to_bits()))),
        }
    }

    /// A function of one argument.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn call(&mut self, function: Function, a: Id) -> NodeResult {
        match self.value(a) {
            Some(a) => self.constant(function.of(a)),
            None => Ok(self.add(Node::Call(function, a))),
        }
    }

    /// A curve at a number.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn curve(&mut self, curve: &Arc<PiecewisePolynomial>, a: Id) -> NodeResult {
        if let Some(a) = self.value(a) {
            return self.constant(curve.of(a));
        }
        let mut known = self.curves.iter();
        let known = known.position(|known| Arc::ptr_eq(known, curve) || known == curve);
        let number = known.unwrap_or_else(|| {
            self.curves.push(Arc::clone(curve));
            self.curves.len() - 1
        });
        Ok(self.add(Node::Curve(number as u32, a)))
    }

    /// The curves that numbers of the graph are computed by.
    pub(super) fn curves(&self) -> &[Arc<PiecewisePolynomial>] {
        &self.curves
    }

    /// The angle of the point `(x, y)`.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn angle(&mut self, y: Id, x: Id) -> NodeResult {
        match (self.value(y), self.value(x)) {
            (Some(y), Some(x)) => self.constant(math::atan2(y, x)),
            _ => Ok(self.add(Node::Angle(y, x))),
        }
    }

    /// The larger of two.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn larger(&mut self, a: Id, b: Id) -> NodeResult {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.constant(a.max(b)),
            _ => Ok(self.add(Node::Larger(a, b))),
        }
    }

    /// The smaller of two.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn smaller(&mut self, a: Id, b: Id) -> NodeResult {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.constant(a.min(b)),
            _ => Ok(self.add(Node::Smaller(a, b))),
        }
    }

    /// The number `a` where `condition` is positive, else zero.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn where_positive(&mut self, condition: Id, a: Id) -> NodeResult {
        match self.value(condition) {
            Some(value) if value > 0.0 => Ok(a),
            Some(_) => self.constant(0.0),
            None => Ok(self.add(Node::WherePositive(condition, a))),
        }
    }

    /// One number where `condition` is positive, and another elsewhere.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn chosen(&mut self, condition: Id, there: Id, elsewhere: Id) -> NodeResult {
        if there == elsewhere {
            return Ok(there);
        }
        let there = self.where_positive(condition, there)?;
        let elsewhere = self.where_not_positive(condition, elsewhere)?;
        self.sum(there, elsewhere)
    }

    /// The number `a` where `condition` is not positive, else zero.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn where_not_positive(&mut self, condition: Id, a: Id) -> NodeResult {
        match self.value(condition) {
            Some(value) if value > 0.0 => self.constant(0.0),
            Some(_) => Ok(a),
            None => Ok(self.add(Node::WhereNotPositive(condition, a))),
        }
    }

    /// Adds a node, unless it or the one with exchanged operands exists already.
    fn commutative(&mut self, node: Node, exchanged: Node) -> Id {
        self.find(exchanged).unwrap_or_else(|| self.add(node))
    }

    /// Marks, by index, the numbers that are one of `roots` or an operand of them at any depth.
    pub(super) fn used_by(&self, roots: &[Id]) -> Vec<bool> {
        self.reached(roots, Node::operands)
    }

    /// Marks the numbers of [`Graph::used_by`], through some of the operands.
    fn reached(&self, roots: &[Id], operands: fn(Node) -> [Option<Id>; 2]) -> Vec<bool> {
        let mut is_used = vec![false; self.nodes.len()];
        for root in roots {
            is_used[root.index()] = true;
        }
        for i in (0..self.nodes.len()).rev() {
            if is_used[i] {
                for operand in operands(self.nodes[i]).into_iter().flatten() {
                    is_used[operand.index()] = true;
                }
            }
        }
        is_used
    }

    /// Whether a number depends on time.
    pub fn depends_on_time(&self, root: Id) -> bool {
        self.depends(root, |input| input == 0)
    }

    /// Whether a number depends on one of these states.
    pub fn depends_on_states(&self, root: Id, wanted: impl Fn(usize) -> bool) -> bool {
        self.depends(root, |input| input > 0 && wanted(usize::from(input) - 1))
    }

    /// Whether a number has isolated values where time and these states vary and other states do
    /// not: it depends on them through conditions alone.
    pub fn is_isolated_from(&self, root: Id, vary: impl Fn(usize) -> bool) -> bool {
        let is_used = self.reached(&[root], Node::values);
        let mut nodes = self.nodes.iter().zip(is_used);
        !nodes.any(|(node, is_used)| {
            let varies = |input: u8| input == 0 || vary(usize::from(input) - 1);
            is_used && matches!(node, Node::Input(k) if varies(*k))
        })
    }

    /// Whether a number depends on the state.
    pub fn depends_on_state(&self, root: Id) -> bool {
        self.depends(root, |input| input > 0)
    }

    /// Whether numbers are affine functions of states and time.
    pub(super) fn are_affine(&self, roots: &[Id]) -> bool {
        let is_constant = |id: Id| matches!(self.node(id), Node::Constant(_));
        let mut is_affine = vec![false; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            let of = |id: Id| is_affine[id.index()];
            is_affine[i] = match *node {
                Node::Constant(_) | Node::Input(_) => true,
                Node::Negative(a) => of(a),
                Node::Sum(a, b) | Node::Difference(a, b) => of(a) && of(b),
                Node::Product(a, b) => is_constant(a) && of(b) || is_constant(b) && of(a),
                Node::Quotient(a, b) => is_constant(b) && of(a),
                _ => false,
            };
        }
        roots.iter().all(|root| is_affine[root.index()])
    }

    fn depends(&self, root: Id, wanted: impl Fn(u8) -> bool) -> bool {
        let is_used = self.used_by(&[root]);
        let mut nodes = self.nodes.iter().zip(is_used);
        nodes.any(|(node, is_used)| is_used && matches!(node, Node::Input(k) if wanted(*k)))
    }
}
