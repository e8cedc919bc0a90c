//! Expressions with resolved names. Common subexpressions are shared, and what depends on neither
//! time nor states is computed at once.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::curve::PiecewisePolynomial;
use super::functions::Function;
use super::held::{
    BuildDecision, HeldNumbers, HeldOperation, HeldProbe, Holding, Place, Rule, Test, normal,
};
use super::tree::Binary;

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
    /// The parameter with this number, which has a value.
    Parameter(u32),
    /// An operation of numbers that are literals, parameters, or such operations.
    Held(HeldOperation, Id, Id),
    /// Time is input 0, and the states follow.
    Input(u8),
    Negative(Id),
    Sum(Id, Id),
    Difference(Id, Id),
    Product(Id, Id),
    Quotient(Id, Id),
    /// A power whose exponent is held and an integer.
    IntegerPower(Id, Id),
    /// A power whose exponent is held and no integer.
    RealPower(Id, Id),
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
    /// The operands, without those that are held.
    pub(super) fn operands(self) -> [Option<Id>; 2] {
        match self {
            Node::Constant(_) | Node::Parameter(_) | Node::Held(..) | Node::Input(_) => {
                [None, None]
            }
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
    /// Place of each number that is held.
    places: Vec<Option<Place>>,
    pub(super) held: Holding,
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
        self.find(node).unwrap_or_else(|| self.push(node, None))
    }

    fn push(&mut self, node: Node, place: Option<Place>) -> Id {
        let id = Id::of(self.nodes.len());
        self.nodes.push(node);
        self.places.push(place);
        self.ids.insert(node, id);
        id
    }

    /// Adds a held number with this value.
    fn add_held(&mut self, node: Node, rule: Rule, value: f64) -> NodeResult {
        let value = normal(value).ok_or(NotANumber { value })?;
        if let Some(id) = self.find(node) {
            return Ok(id);
        }
        let place = self.held.add(rule, value);
        Ok(self.push(node, Some(place)))
    }

    /// An operation of held numbers: a literal if both are literals. `None` if one is not held.
    fn operated(&mut self, operation: HeldOperation, a: Id, b: Id) -> Option<NodeResult> {
        let (at, with) = (self.place(a)?, self.place(b)?);
        let (of_a, of_b) = (self.held.value(at), self.held.value(with));
        let value = operation.of(of_a, of_b, &self.held.numbers.curves);
        let is_literal = |id: Id| matches!(self.node(id), Node::Constant(_));
        if is_literal(a) && is_literal(b) {
            return Some(self.constant(value));
        }
        let rule = Rule::Operation(operation, at, with);
        Some(self.add_held(Node::Held(operation, a, b), rule, value))
    }

    /// Time.
    pub fn time(&mut self) -> Id {
        self.add(Node::Input(0))
    }

    /// A component of the state, counted from 0.
    pub fn state(&mut self, number: usize) -> Id {
        self.add(Node::Input(number as u8 + 1))
    }

    /// A literal constant.
    ///
    /// # Errors
    /// [`NotANumber`] unless it is finite.
    pub fn constant(&mut self, value: f64) -> NodeResult {
        let stored = normal(value).ok_or(NotANumber { value })?;
        let node = Node::Constant(stored.to_bits());
        self.add_held(node, Rule::Literal(stored), stored)
    }

    /// The parameter with this number, which has this value now.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn parameter(&mut self, number: usize, value: f64) -> NodeResult {
        let node = Node::Parameter(number as u32);
        self.add_held(node, Rule::Parameter(number), value)
    }

    /// The value of a number that depends on neither time nor states. What is built by it is asked
    /// for with [`Graph::is`], so that it counts as a decision.
    pub fn value(&self, id: Id) -> Option<f64> {
        self.place(id).map(|place| self.held.value(place))
    }

    /// Whether a number depends on neither time nor states.
    pub fn is_held(&self, id: Id) -> bool {
        self.place(id).is_some()
    }

    /// Place of a number among those that are held.
    pub fn place(&self, id: Id) -> Option<Place> {
        self.places[id.index()]
    }

    /// Whether a number is held and this is so of its value.
    pub fn is(&mut self, id: Id, test: Test) -> bool {
        let place = self.place(id);
        place.is_some_and(|place| self.held.ask(test, place))
    }

    /// Evaluates a function of the held numbers and records its value as a decision. The function
    /// gets the values of all held numbers so far, by place.
    pub fn probed(&mut self, probe: Arc<HeldProbe>) -> usize {
        let found = probe(&self.held_values());
        self.held.record(BuildDecision::Probed(probe, found));
        found
    }

    /// Values of the held numbers so far, by place.
    pub(super) fn held_values(&self) -> Arc<[f64]> {
        self.held.values.as_slice().into()
    }

    /// The held numbers, as functions of the parameters, and the decisions by them.
    pub fn into_held_numbers(self) -> HeldNumbers {
        self.held.numbers
    }

    /// The negative of a number.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn negative(&mut self, a: Id) -> NodeResult {
        if let Some(held) = self.operated(HeldOperation::Negative, a, a) {
            return held;
        }
        match self.node(a) {
            Node::Negative(inner) => Ok(inner),
            _ => Ok(self.add(Node::Negative(a))),
        }
    }

    /// The number of the opposite sign: of a difference, the difference turned round.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn opposite(&mut self, a: Id) -> NodeResult {
        match self.node(a) {
            Node::Difference(a, b) => self.difference(b, a),
            _ => self.negative(a),
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
        if let Some(held) = self.operated(HeldOperation::Sum, a, b) {
            return held;
        }
        if self.is(a, Test::Zero) {
            return Ok(b);
        }
        if self.is(b, Test::Zero) {
            return Ok(a);
        }
        Ok(self.commutative(Node::Sum(a, b), Node::Sum(b, a)))
    }

    fn difference(&mut self, a: Id, b: Id) -> NodeResult {
        if let Some(held) = self.operated(HeldOperation::Difference, a, b) {
            return held;
        }
        if self.is(a, Test::Zero) {
            return self.negative(b);
        }
        if self.is(b, Test::Zero) {
            return Ok(a);
        }
        if a == b {
            return self.constant(0.0);
        }
        Ok(self.add(Node::Difference(a, b)))
    }

    fn product(&mut self, a: Id, b: Id) -> NodeResult {
        if let Some(held) = self.operated(HeldOperation::Product, a, b) {
            return held;
        }
        match (self.is_held(a), self.is_held(b)) {
            (true, _) => self.scaled(b, a),
            (_, true) => self.scaled(a, b),
            _ => Ok(self.commutative(Node::Product(a, b), Node::Product(b, a))),
        }
    }

    /// A number times a held factor.
    fn scaled(&mut self, a: Id, factor: Id) -> NodeResult {
        if self.is(factor, Test::One) {
            return Ok(a);
        }
        if self.is(factor, Test::MinusOne) {
            return self.negative(a);
        }
        if self.is(factor, Test::Zero) {
            return self.constant(0.0);
        }
        Ok(self.add(Node::Product(a, factor)))
    }

    fn quotient(&mut self, a: Id, b: Id) -> NodeResult {
        if let Some(held) = self.operated(HeldOperation::Quotient, a, b) {
            return held;
        }
        if self.is(b, Test::Zero) {
            let value = f64::INFINITY;
            return Err(NotANumber { value });
        }
        if self.is(b, Test::One) {
            return Ok(a);
        }
        if self.is(b, Test::MinusOne) {
            return self.negative(a);
        }
        if self.is(a, Test::Zero) {
            return self.constant(0.0);
        }
        Ok(self.add(Node::Quotient(a, b)))
    }

    fn power(&mut self, a: Id, b: Id) -> NodeResult {
        if !self.is_held(b) {
            // For a positive base only: with another base, a power with a varying exponent is not
            // real.
            let logarithm = self.call(Function::Ln, a)?;
            let product = self.product(logarithm, b)?;
            return self.call(Function::Exp, product);
        }
        if let Some(held) = self.operated(HeldOperation::Power, a, b) {
            return held;
        }
        if self.is(b, Test::Zero) {
            return self.constant(1.0);
        }
        if self.is(b, Test::One) {
            return Ok(a);
        }
        if self.is(b, Test::Half) {
            return self.call(Function::Sqrt, a);
        }
        let is_whole = self.is(b, Test::Whole);
        Ok(self.add(match is_whole {
            true => Node::IntegerPower(a, b),
            false => Node::RealPower(a, b),
        }))
    }

    /// A function of one argument.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn call(&mut self, function: Function, a: Id) -> NodeResult {
        let held = self.operated(HeldOperation::Call(function), a, a);
        held.unwrap_or_else(|| Ok(self.add(Node::Call(function, a))))
    }

    /// A curve at a number.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn curve(&mut self, curve: &Arc<PiecewisePolynomial>, a: Id) -> NodeResult {
        let curves = &mut self.held.numbers.curves;
        let mut known = curves.iter();
        let known = known.position(|known| Arc::ptr_eq(known, curve) || known == curve);
        let number = known.unwrap_or_else(|| {
            curves.push(Arc::clone(curve));
            curves.len() - 1
        }) as u32;
        let held = self.operated(HeldOperation::Curve(number), a, a);
        held.unwrap_or_else(|| Ok(self.add(Node::Curve(number, a))))
    }

    /// The curves that numbers of the graph are computed by.
    pub(super) fn curves(&self) -> &[Arc<PiecewisePolynomial>] {
        &self.held.numbers.curves
    }

    /// The angle of the point `(x, y)`.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn angle(&mut self, y: Id, x: Id) -> NodeResult {
        let held = self.operated(HeldOperation::Angle, y, x);
        held.unwrap_or_else(|| Ok(self.add(Node::Angle(y, x))))
    }

    /// The larger of two.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn larger(&mut self, a: Id, b: Id) -> NodeResult {
        let held = self.operated(HeldOperation::Larger, a, b);
        held.unwrap_or_else(|| Ok(self.add(Node::Larger(a, b))))
    }

    /// The smaller of two.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn smaller(&mut self, a: Id, b: Id) -> NodeResult {
        let held = self.operated(HeldOperation::Smaller, a, b);
        held.unwrap_or_else(|| Ok(self.add(Node::Smaller(a, b))))
    }

    /// The number `a` where `condition` is positive, else zero.
    ///
    /// # Errors
    /// See [`Graph::constant`].
    pub fn where_positive(&mut self, condition: Id, a: Id) -> NodeResult {
        if let Some(held) = self.operated(HeldOperation::WherePositive, condition, a) {
            return held;
        }
        match (self.is_held(condition), self.is(condition, Test::Positive)) {
            (true, true) => Ok(a),
            (true, false) => self.constant(0.0),
            (false, _) => Ok(self.add(Node::WherePositive(condition, a))),
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
        if let Some(held) = self.operated(HeldOperation::WhereNotPositive, condition, a) {
            return held;
        }
        match (self.is_held(condition), self.is(condition, Test::Positive)) {
            (true, true) => self.constant(0.0),
            (true, false) => Ok(a),
            (false, _) => Ok(self.add(Node::WhereNotPositive(condition, a))),
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
        let mut is_affine = vec![false; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            let of = |id: Id| is_affine[id.index()];
            is_affine[i] = match *node {
                Node::Constant(_) | Node::Parameter(_) | Node::Held(..) | Node::Input(_) => true,
                Node::Negative(a) => of(a),
                Node::Sum(a, b) | Node::Difference(a, b) => of(a) && of(b),
                Node::Product(a, b) => self.is_held(a) && of(b) || self.is_held(b) && of(a),
                Node::Quotient(a, b) => self.is_held(b) && of(a),
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
