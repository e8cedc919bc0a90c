//! Expressions in order of evaluation.

use std::sync::Arc;

use stickslip::Scalar;

use super::curve::PiecewisePolynomial;
use super::functions::Function;
use super::graph::{Graph, Id, Node};
use super::held::Place;

/// Most numbers that a tape can hold at once, including time and states. It is chosen: register
/// numbers fit into 16 bits up to 64 times as many.
pub const MOST_REGISTERS: usize = 1024;

/// Registers of the short and the medium tapes; powers of two. Most systems need no more, and these
/// registers are on the stack.
const FEW_REGISTERS: usize = 16;
const SOME_REGISTERS: usize = 64;

/// An expression needs more than [`MOST_REGISTERS`] numbers at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the expressions need more than {MOST_REGISTERS} numbers at once; write sums so that one part \
        is finished before the next begins"
)]
pub struct TooLarge;

/// Several expressions of time, states and held numbers, evaluated together, with values of the
/// held numbers.
#[derive(Clone, Debug)]
pub struct Tape {
    operations: Arc<Operations>,
    /// Values of the held numbers of the graph, by place.
    held: Arc<[f64]>,
}

/// Operations of a tape, for any values of the held numbers.
#[derive(Debug)]
struct Operations {
    steps: Vec<TapeStep>,
    registers: usize,
    outputs: Vec<Output>,
    curves: Vec<Arc<PiecewisePolynomial>>,
    /// Whether all numbers are affine functions of states and time.
    is_affine: bool,
}

/// One operation: register `to` becomes `a operation b`, or `a operation constant`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TapeStep {
    operation: Operation,
    a: u16,
    b: u16,
    to: u16,
    /// Place of the constant among the held numbers, or number of the curve.
    constant: u32,
}

/// Tapes are equal that do the same with the same constants, whatever else their graphs hold.
impl PartialEq for Tape {
    fn eq(&self, other: &Self) -> bool {
        let (one, two) = (&*self.operations, &*other.operations);
        let constants = |place: u32, beside: u32| {
            let [place, beside] = [place, beside].map(|place| place as usize);
            self.held.get(place) == other.held.get(beside)
        };
        let mut steps = one.steps.iter().zip(&two.steps);
        let mut outputs = one.outputs.iter().zip(&two.outputs);
        let sizes = |of: &Operations| (of.steps.len(), of.registers, of.outputs.len());
        sizes(one) == sizes(two)
            && one.is_affine == two.is_affine
            && one.curves == two.curves
            && steps.all(|(a, b)| {
                let registers = |step: &TapeStep| (step.operation, step.a, step.b, step.to);
                registers(a) == registers(b)
                    && match a.operation.has_constant() {
                        true => constants(a.constant, b.constant),
                        false => a.constant == b.constant,
                    }
            })
            && outputs.all(|pair| match pair {
                (Output::Constant(a), Output::Constant(b)) => constants(*a, *b),
                (a, b) => a == b,
            })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operation {
    Add,
    Subtract,
    Multiply,
    Divide,
    AddConstant,
    SubtractConstant,
    SubtractFromConstant,
    MultiplyConstant,
    DivideByConstant,
    DivideConstant,
    Negate,
    Constant,
    /// Sine into `to`, cosine into `b`.
    SineCosine,
    Curve,
    Called(CalledOperation),
}

/// Operations that take longer than a call. For nested dual numbers these are long functions, which
/// would be compiled for each number of registers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CalledOperation {
    /// The exponent is the constant, here and for real powers.
    IntegerPower,
    RealPower,
    Call(Function),
    Angle,
    Larger,
    Smaller,
    WherePositive,
    WhereNotPositive,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Output {
    Register(u16),
    Constant(u32),
}

impl Tape {
    /// Builds a tape for the numbers `roots` of a system with `states` states.
    ///
    /// # Errors
    /// [`TooLarge`].
    pub fn new(graph: &Graph, roots: &[Id], states: usize) -> Result<Tape, TooLarge> {
        let operations = Arc::new(Layout::new(graph, roots, states).operations(roots)?);
        let held = graph.held_values();
        Ok(Tape { operations, held })
    }

    /// The tape with other values of the held numbers of its graph, by place.
    #[must_use]
    pub fn with_held(&self, held: &Arc<[f64]>) -> Tape {
        Tape {
            operations: Arc::clone(&self.operations),
            held: Arc::clone(held),
        }
    }

    /// Whether all numbers are held.
    pub fn is_constant(&self) -> bool {
        let mut outputs = self.operations.outputs.iter();
        outputs.all(|output| matches!(output, Output::Constant(_)))
    }

    /// Whether all numbers are affine functions of states and time.
    pub fn is_affine(&self) -> bool {
        self.operations.is_affine
    }

    /// Number of operations.
    pub fn operations(&self) -> usize {
        self.operations.steps.len()
    }

    /// Most numbers held at once, including time and states.
    #[inline(always)]
    pub fn registers(&self) -> usize {
        self.operations.registers
    }

    /// Computes the numbers at time `t` and state `x` and writes them to the front of `out`. Those
    /// that do not fit are omitted.
    #[inline(always)]
    pub fn evaluate<T: Scalar>(&self, t: T, x: &[T], out: &mut [T]) {
        if self.registers() <= FEW_REGISTERS {
            self.run_within::<T, FEW_REGISTERS>(t, x, out);
        } else if self.registers() <= SOME_REGISTERS {
            self.run_within::<T, SOME_REGISTERS>(t, x, out);
        } else {
            self.run_many(t, x, out);
        }
    }

    #[inline(never)]
    fn run_within<T: Scalar, const R: usize>(&self, t: T, x: &[T], out: &mut [T]) {
        // All register indices are below this power of two; the mask shows it to the compiler.
        self.run(&mut [T::zero(); R], R - 1, (t, x), out);
    }

    #[inline(never)]
    fn run_many<T: Scalar>(&self, t: T, x: &[T], out: &mut [T]) {
        self.run(
            &mut vec![T::zero(); self.registers()],
            usize::MAX,
            (t, x),
            out,
        );
    }

    /// Inlined into its two callers, so that it is compiled twice for each number type. If inlined
    /// into the solver, it would be compiled for each kind of system.
    #[inline(always)]
    fn run<T: Scalar>(&self, registers: &mut [T], mask: usize, (t, x): (T, &[T]), out: &mut [T]) {
        registers[0] = t;
        for (register, &component) in registers[1..].iter_mut().zip(x) {
            *register = component;
        }
        let (operations, held) = (&*self.operations, &*self.held);
        for step in &operations.steps {
            // Not `map` over an array of three: without optimization that would be a call for every
            // operation.
            let (a, b) = (usize::from(step.a) & mask, usize::from(step.b) & mask);
            let to = usize::from(step.to) & mask;
            // Only operations with a constant read it.
            let constant = || held[step.constant as usize];
            let r = &mut *registers;
            // Each arm stores its own result. A common store would assemble and copy the value,
            // which takes longer than most operations.
            match step.operation {
                Operation::Add => r[to] = r[a] + r[b],
                Operation::Subtract => r[to] = r[a] - r[b],
                Operation::Multiply => r[to] = r[a] * r[b],
                Operation::Divide => r[to] = r[a] / r[b],
                Operation::AddConstant => r[to] = r[a] + constant(),
                Operation::SubtractConstant => r[to] = r[a] - constant(),
                Operation::SubtractFromConstant => r[to] = T::constant(constant()) - r[a],
                Operation::MultiplyConstant => r[to] = r[a] * constant(),
                Operation::DivideByConstant => r[to] = r[a] / constant(),
                Operation::DivideConstant => r[to] = T::constant(constant()) / r[a],
                Operation::Negate => r[to] = -r[a],
                Operation::Constant => r[to] = T::constant(constant()),
                Operation::SineCosine => (r[to], r[b]) = sine_cosine(r[a]),
                Operation::Curve => {
                    r[to] = on_curve(operations.curves.get(step.constant as usize), r[a]);
                }
                Operation::Called(other) => {
                    r[to] = other.of(r[a], r[b], held.get(step.constant as usize));
                }
            }
        }
        for (out, output) in out.iter_mut().zip(&operations.outputs) {
            *out = match *output {
                Output::Register(k) => registers[usize::from(k) & mask],
                Output::Constant(place) => match held[place as usize] {
                    // Number types that fold constants recognize these two without a look at the
                    // value.
                    0.0 => T::zero(),
                    1.0 => T::one(),
                    value => T::constant(value),
                },
            };
        }
    }
}

impl Operation {
    /// Whether its constant is a held number.
    fn has_constant(self) -> bool {
        match self {
            Operation::Add
            | Operation::Subtract
            | Operation::Multiply
            | Operation::Divide
            | Operation::Negate
            | Operation::SineCosine
            | Operation::Curve => false,
            Operation::AddConstant
            | Operation::SubtractConstant
            | Operation::SubtractFromConstant
            | Operation::MultiplyConstant
            | Operation::DivideByConstant
            | Operation::DivideConstant
            | Operation::Constant => true,
            Operation::Called(called) => matches!(
                called,
                CalledOperation::IntegerPower | CalledOperation::RealPower
            ),
        }
    }
}

impl CalledOperation {
    #[inline(never)]
    fn of<T: Scalar>(self, a: T, b: T, constant: Option<&f64>) -> T {
        let exponent = || constant.copied().unwrap_or(f64::NAN);
        match self {
            CalledOperation::IntegerPower => a.powi(exponent() as i32),
            CalledOperation::RealPower => a.powf(exponent()),
            CalledOperation::Call(function) => function.of(a),
            CalledOperation::Angle => a.atan2(b),
            CalledOperation::Larger => a.max(b),
            CalledOperation::Smaller => a.min(b),
            CalledOperation::WherePositive if a.exceeds(T::zero()) => b,
            CalledOperation::WherePositive => T::zero(),
            CalledOperation::WhereNotPositive if a.exceeds(T::zero()) => T::zero(),
            CalledOperation::WhereNotPositive => b,
        }
    }
}

#[inline(never)]
fn on_curve<T: Scalar>(curve: Option<&Arc<PiecewisePolynomial>>, a: T) -> T {
    curve.map_or(T::constant(f64::NAN), |curve| curve.of(a))
}

#[inline(never)]
fn sine_cosine<T: Scalar>(a: T) -> (T, T) {
    a.sin_cos()
}

/// Assigns registers to numbers and frees them after their last use.
struct Layout<'a> {
    graph: &'a Graph,
    is_used: Vec<bool>,
    /// The last number that uses each number. An output is its own last user and is kept.
    last_use: Vec<usize>,
    register: Vec<Option<u16>>,
    free: Vec<u16>,
    given: usize,
    steps: Vec<TapeStep>,
}

impl<'a> Layout<'a> {
    fn new(graph: &'a Graph, roots: &[Id], states: usize) -> Self {
        let is_used = graph.used_by(roots);
        let count = is_used.len();
        let mut last_use = vec![0; count];
        for (i, _) in is_used.iter().enumerate().filter(|(_, is_used)| **is_used) {
            for operand in graph.node(Id::of(i)).operands().into_iter().flatten() {
                last_use[operand.index()] = i;
            }
        }
        for root in roots {
            last_use[root.index()] = usize::MAX;
        }
        Layout {
            graph,
            is_used,
            last_use,
            register: vec![None; count],
            free: Vec::new(),
            given: states + 1,
            steps: Vec::new(),
        }
    }

    fn operations(mut self, roots: &[Id]) -> Result<Operations, TooLarge> {
        for i in 0..self.is_used.len() {
            if self.is_used[i] && self.register[i].is_none() {
                self.make(i)?;
            }
        }
        let outputs = roots.iter().map(|&root| match self.graph.place(root) {
            Some(Place(place)) => Output::Constant(place),
            None => Output::Register(self.register[root.index()].unwrap_or(0)),
        });
        Ok(Operations {
            outputs: outputs.collect(),
            curves: self.graph.curves().to_vec(),
            is_affine: self.graph.are_affine(roots),
            registers: self.given,
            steps: self.steps,
        })
    }

    fn make(&mut self, i: usize) -> Result<(), TooLarge> {
        let node = self.graph.node(Id::of(i));
        let place = |id: Id| self.graph.place(id).map(|Place(place)| place);
        let called =
            |operation: CalledOperation, a: Id, b: Id| (Op::Called(operation), a, Some(b), 0);
        let power = |operation: CalledOperation, a: Id, exponent: Id| {
            let exponent = place(exponent).unwrap_or(u32::MAX);
            (Op::Called(operation), a, None, exponent)
        };
        use Operation as Op;
        // The operation of two numbers, and those with a constant on the left and on the right.
        let joined = |a: Id, b: Id, [both, left, right]: [Op; 3]| match (place(a), place(b)) {
            (Some(c), _) => (left, b, None, c),
            (_, Some(c)) => (right, a, None, c),
            _ => (both, a, Some(b), 0),
        };
        let (operation, a, b, constant) = match node {
            // A constant is part of the operation that uses it, or else is loaded there.
            Node::Constant(_) | Node::Parameter(_) | Node::Held(..) => return Ok(()),
            Node::Input(k) => {
                self.register[i] = Some(u16::from(k));
                return Ok(());
            }
            Node::Negative(a) => (Op::Negate, a, None, 0),
            Node::Sum(a, b) => joined(a, b, [Op::Add, Op::AddConstant, Op::AddConstant]),
            Node::Difference(a, b) => {
                let operations = [Op::Subtract, Op::SubtractFromConstant, Op::SubtractConstant];
                joined(a, b, operations)
            }
            Node::Product(a, b) => {
                let operations = [Op::Multiply, Op::MultiplyConstant, Op::MultiplyConstant];
                joined(a, b, operations)
            }
            Node::Quotient(a, b) => {
                let operations = [Op::Divide, Op::DivideConstant, Op::DivideByConstant];
                joined(a, b, operations)
            }
            Node::IntegerPower(a, n) => power(CalledOperation::IntegerPower, a, n),
            Node::RealPower(a, p) => power(CalledOperation::RealPower, a, p),
            Node::Call(function, a) => return self.call(i, function, a),
            Node::Curve(number, a) => (Op::Curve, a, None, number),
            Node::Angle(a, b) => called(CalledOperation::Angle, a, b),
            Node::Larger(a, b) => called(CalledOperation::Larger, a, b),
            Node::Smaller(a, b) => called(CalledOperation::Smaller, a, b),
            Node::WherePositive(a, b) => called(CalledOperation::WherePositive, a, b),
            Node::WhereNotPositive(a, b) => called(CalledOperation::WhereNotPositive, a, b),
        };
        let from = self.operand(a)?;
        let with = b.map_or(Ok(0), |b| self.operand(b))?;
        self.release([Some(a), b], i);
        let to = self.take()?;
        self.register[i] = Some(to);
        self.steps.push(TapeStep {
            operation,
            a: from,
            b: with,
            to,
            constant,
        });
        Ok(())
    }

    /// Emits a function call. Sine and cosine of the same number are computed together.
    fn call(&mut self, i: usize, function: Function, a: Id) -> Result<(), TooLarge> {
        let other = match function {
            Function::Sin => self.partner(i, Function::Cos, a),
            Function::Cos => self.partner(i, Function::Sin, a),
            _ => None,
        };
        let from = self.operand(a)?;
        let Some(other) = other else {
            self.release([Some(a), None], i);
            let to = self.take()?;
            self.register[i] = Some(to);
            self.steps.push(TapeStep {
                operation: Operation::Called(CalledOperation::Call(function)),
                a: from,
                b: 0,
                to,
                constant: 0,
            });
            return Ok(());
        };
        let (first, second) = (self.take()?, self.take()?);
        self.register[i] = Some(first);
        self.register[other] = Some(second);
        let (sine, cosine) = match function {
            Function::Sin => (first, second),
            _ => (second, first),
        };
        self.steps.push(TapeStep {
            operation: Operation::SineCosine,
            a: from,
            b: cosine,
            to: sine,
            constant: 0,
        });
        self.release([Some(a), None], other);
        Ok(())
    }

    /// A further call with the same argument that comes after `i`.
    fn partner(&self, i: usize, function: Function, a: Id) -> Option<usize> {
        let other = self.graph.find(Node::Call(function, a))?.index();
        (other > i && self.is_used[other]).then_some(other)
    }

    /// The register of an operand; a constant is loaded into one.
    fn operand(&mut self, operand: Id) -> Result<u16, TooLarge> {
        if let Some(register) = self.register[operand.index()] {
            return Ok(register);
        }
        let to = self.take()?;
        self.register[operand.index()] = Some(to);
        self.steps.push(TapeStep {
            operation: Operation::Constant,
            a: 0,
            b: 0,
            to,
            constant: self.graph.place(operand).map_or(0, |Place(place)| place),
        });
        Ok(to)
    }

    fn take(&mut self) -> Result<u16, TooLarge> {
        if let Some(register) = self.free.pop() {
            return Ok(register);
        }
        if self.given == MOST_REGISTERS {
            return Err(TooLarge);
        }
        self.given += 1;
        Ok((self.given - 1) as u16)
    }

    /// Frees the registers of the operands that `user` is the last to use. Inputs keep theirs.
    fn release(&mut self, operands: [Option<Id>; 2], user: usize) {
        for operand in operands.into_iter().flatten() {
            let k = operand.index();
            let is_input = matches!(self.graph.node(operand), Node::Input(_));
            if self.last_use[k] == user
                && !is_input
                && let Some(register) = self.register[k]
                && !self.free.contains(&register)
            {
                self.free.push(register);
            }
        }
    }
}
