//! Formulas of systems written in Rust. Their functions are called once with numbers that record
//! the operations.
//!
//! The formulas run on the solver that is compiled for systems from files. So a program with many
//! systems, such as a test suite, compiles the solver only once.

use std::cell::{Cell, RefCell};
use std::ops::{Add, Div, Mul, Neg, Sub};

use stickslip::{Filippov, Scalar, Side};

use crate::expression::{Binary, Function, Graph, Id, Tape};
use crate::kernel::TapedFilippov;

thread_local! {
    static GRAPH: RefCell<Graph> = RefCell::new(Graph::new());
    /// Whether an operation occurred that a formula cannot express: a value, a comparison, or a
    /// number that is not finite.
    static FAILED: Cell<bool> = const { Cell::new(false) };
}

/// A number known only by its formula.
#[derive(Clone, Copy, Debug)]
struct Symbol(Id);

impl Symbol {
    fn node<E>(make: impl FnOnce(&mut Graph) -> Result<Id, E>) -> Self {
        GRAPH.with_borrow_mut(|graph| {
            let node = make(graph).or_else(|_| {
                FAILED.set(true);
                graph.constant(0.0)
            });
            // Zero is always a valid number.
            Symbol(node.unwrap_or_else(|_| graph.time()))
        })
    }

    fn binary(self, operator: Binary, other: Self) -> Self {
        Symbol::node(|graph| graph.binary(operator, self.0, other.0))
    }

    fn call(self, function: Function) -> Self {
        Symbol::node(|graph| graph.call(function, self.0))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $operator:ident) => {
        impl $trait for Symbol {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.binary(Binary::$operator, other)
            }
        }

        impl $trait<f64> for Symbol {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                self.binary(Binary::$operator, Symbol::constant(other))
            }
        }
    };
}

operator!(Add, add, Sum);
operator!(Sub, sub, Difference);
operator!(Mul, mul, Product);
operator!(Div, div, Quotient);

impl Neg for Symbol {
    type Output = Self;
    fn neg(self) -> Self {
        Symbol::node(|graph| graph.negative(self.0))
    }
}

impl Scalar for Symbol {
    fn constant(value: f64) -> Self {
        Symbol::node(|graph| graph.constant(value))
    }
    fn value(self) -> f64 {
        FAILED.set(true);
        f64::NAN
    }
    fn sin(self) -> Self {
        self.call(Function::Sin)
    }
    fn cos(self) -> Self {
        self.call(Function::Cos)
    }
    fn tan(self) -> Self {
        self.call(Function::Tan)
    }
    fn atan(self) -> Self {
        self.call(Function::Atan)
    }
    fn atan2(self, x: Self) -> Self {
        Symbol::node(|graph| graph.angle(self.0, x.0))
    }
    fn erf(self) -> Self {
        self.call(Function::Erf)
    }
    fn sinh(self) -> Self {
        self.call(Function::Sinh)
    }
    fn cosh(self) -> Self {
        self.call(Function::Cosh)
    }
    fn tanh(self) -> Self {
        self.call(Function::Tanh)
    }
    fn powf(self, p: f64) -> Self {
        self.binary(Binary::Power, Symbol::constant(p))
    }
    fn powi(self, n: i32) -> Self {
        self.powf(f64::from(n))
    }
    fn sqrt(self) -> Self {
        self.call(Function::Sqrt)
    }
    fn exp(self) -> Self {
        self.call(Function::Exp)
    }
    fn ln(self) -> Self {
        self.call(Function::Ln)
    }
    fn max(self, other: Self) -> Self {
        Symbol::node(|graph| graph.larger(self.0, other.0))
    }
    fn min(self, other: Self) -> Self {
        Symbol::node(|graph| graph.smaller(self.0, other.0))
    }
    fn abs(self) -> Self {
        self.call(Function::Abs)
    }
}

/// The formulas of a function's results at time and state; `None` if it branches on values.
fn traced<const N: usize, const K: usize>(
    function: impl FnOnce(Symbol, &[Symbol; N]) -> [Symbol; K],
) -> Option<Tape> {
    GRAPH.set(Graph::new());
    FAILED.set(false);
    let state = |i: usize| GRAPH.with_borrow_mut(|graph| Symbol(graph.state(i)));
    let time = GRAPH.with_borrow_mut(|graph| Symbol(graph.time()));
    let roots = function(time, &std::array::from_fn(state)).map(|root| root.0);
    let tape = GRAPH.with_borrow(|graph| Tape::new(graph, &roots, N).ok());
    tape.filter(|_| !FAILED.get())
}

/// The formula of a function that may have no result; `None` if it branches on values.
fn traced_if_any<const N: usize>(
    function: impl FnOnce(Symbol, &[Symbol; N]) -> Option<Symbol>,
) -> Option<Option<Tape>> {
    let mut is_any = false;
    let tape = traced(|t, x| {
        let made = function(t, x);
        is_any = made.is_some();
        [made.unwrap_or(t)]
    });
    tape.map(|tape| is_any.then_some(tape))
}

/// A system as formulas; `None` if its functions branch on values.
///
/// ```
/// use stickslip::{Filippov, Options, Scalar, Side, solve};
/// use stickslip_model::trace::trace;
///
/// /// A block on a floor, pushed with a period.
/// struct Pushed;
///
/// impl Filippov<2> for Pushed {
///     fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
///         [x[1], t.cos() - x[0] * 0.5 - 0.4 * side.sign()]
///     }
///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
///         x[1]
///     }
/// }
///
/// let formulas = trace(&Pushed).expect("it has no comparisons");
/// let start = [0.5, 1.5];
/// let [one, other] = [
///     solve(&Pushed, 0.0, start, 10.0, &Options::default())?.x_end,
///     solve(&formulas, 0.0, start, 10.0, &Options::default())?.x_end,
/// ];
/// assert!((one - other).amax() < 1e-9);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn trace<S: Filippov<N>, const N: usize>(system: &S) -> Option<TapedFilippov> {
    let field = |side| traced(|t, x| system.field(side, t, x));
    let holding = |side| traced(|t, x| system.holding(side, t, x));
    let field = [field(Side::Below)?, field(Side::Above)?];
    let holding = [holding(Side::Below)?, holding(Side::Above)?];
    Some(TapedFilippov {
        dimension: system.dimension(),
        holding: (holding != field).then_some(holding),
        field,
        boundary: traced(|t, x: &[Symbol; N]| [system.boundary(t, x)])?,
        normal_force: traced_if_any(|t, x: &[Symbol; N]| system.contact(t, x))?,
        period: traced_if_any(|_, x: &[Symbol; N]| system.period(x))?,
    })
}
