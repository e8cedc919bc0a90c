//! The tape: what a recording comes to once everything that no result needs has been dropped.

use super::recorder::{Recorded, recording};
use super::sketch::{Form, Op, Sketch};
use crate::system::State;

/// A constant, by its place among the tape's, and multiples of rows: terms `first .. first + count` of the tape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Combination {
    pub constant: u32,
    pub first: u32,
    pub count: u32,
}

impl Combination {
    pub(crate) fn terms(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// The numbers in a tape's combinations, in `L` lanes.
#[derive(Clone, Debug)]
pub(crate) struct Numbers<const L: usize> {
    /// The factor of every term.
    pub factors: Vec<[f64; L]>,
    pub constants: Vec<[f64; L]>,
}

impl<const L: usize> Default for Numbers<L> {
    fn default() -> Self {
        Numbers {
            factors: Vec::new(),
            constants: Vec::new(),
        }
    }
}

impl<const L: usize> Numbers<L> {
    /// Those of `L` tapes of the same shape.
    pub(crate) fn gather(&mut self, of: [&Numbers<1>; L]) {
        let fill = |into: &mut Vec<[f64; L]>, lane: fn(&Numbers<1>) -> &[[f64; 1]]| {
            let lanes = of.map(lane);
            into.clear();
            into.extend((0..lanes[0].len()).map(|i| lanes.map(|lane| lane[i][0])));
        };
        fill(&mut self.factors, |numbers| &numbers.factors);
        fill(&mut self.constants, |numbers| &numbers.constants);
    }
}

/// An operation on rows of coefficients. The state's components are rows `0 .. N`, the time is row `N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Instruction {
    Combination {
        out: u32,
        sum: Combination,
    },
    Product {
        out: u32,
        a: u32,
        b: u32,
    },
    Square {
        out: u32,
        a: u32,
    },
    Quotient {
        out: u32,
        a: u32,
        b: u32,
    },
    Reciprocal {
        out: u32,
        b: u32,
    },
    Root {
        out: u32,
        a: u32,
    },
    /// `helper` holds the coefficients of the argument's derivative.
    Exponential {
        out: u32,
        a: u32,
        helper: u32,
    },
    /// `helper` holds the coefficients of the result's derivative.
    Logarithm {
        out: u32,
        a: u32,
        helper: u32,
    },
    /// The cosine is the row after the sine's.
    SineCosine {
        sine: u32,
        a: u32,
        helper: u32,
    },
    /// The same of an argument that is linear in time, as a harmonic forcing has: only its first two coefficients are not zero.
    SineCosineOfTime {
        sine: u32,
        a: u32,
    },
}

/// A field and functions of its solution as a list of operations.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tape {
    /// What field and watched functions take, at every order but the highest: the field's first, which the next order waits for.
    pub inner: Vec<Instruction>,
    /// What the watched functions take, at the highest order, which the field does not need.
    pub last: Vec<Instruction>,
    /// The row of every term.
    pub nodes: Vec<u32>,
    pub numbers: Numbers<1>,
    /// The right-hand side.
    pub field: Vec<Combination>,
    /// The watched functions, those that are constant as such.
    pub watched: Vec<Combination>,
    /// What was compared by [`crate::Scalar::exceeds`]: positive where the comparison came out as it did.
    pub choices: Vec<Combination>,
    /// Rows of coefficients.
    pub rows: usize,
    /// The rows that the results are made of: the state, and what the watched functions and choices take.
    pub results: Vec<u32>,
    /// A number for all tapes of the same shape, for who wants to give them one.
    pub shape: Option<usize>,
    /// The recording depends on values that were read: it may hold only where it was made.
    pub value_read: bool,
    needs: Vec<u8>,
}

const FIELD: u8 = 1;
const WATCHED: u8 = 2;

impl Tape {
    /// Records `field` and `watched` at `(t, x)` over whatever was on the tape.
    pub(crate) fn record<const N: usize, const W: usize>(
        &mut self,
        sketch: &mut Sketch,
        t: f64,
        x: &State<N>,
        functions: impl FnOnce(Recorded, &[Recorded; N]) -> ([Recorded; N], [Recorded; W]),
    ) {
        let (field, watched) = recording(sketch, N + 1, || {
            let state = std::array::from_fn(|i| Recorded::input(i, x[i]));
            functions(Recorded::input(N, t), &state)
        });
        let field: [Form; N] = std::array::from_fn(|i| field[i].form(sketch));
        let watched = watched.map(|number| number.form(sketch));
        self.compile(sketch, &field, &watched);
    }

    /// Whether the function is more than a combination of the `n` components of the state and the time.
    pub(crate) fn is_nonlinear(&self, function: &Combination, n: usize) -> bool {
        let nodes = &self.nodes[function.terms()];
        nodes.iter().any(|&node| node as usize > n)
    }

    /// Whether the tapes differ in the numbers of their combinations alone.
    pub(crate) fn is_alike(&self, other: &Tape) -> bool {
        self.rows == other.rows
            && self.inner == other.inner
            && self.last == other.last
            && self.nodes == other.nodes
            && self.field == other.field
            && self.watched == other.watched
            && self.choices == other.choices
    }

    fn compile(&mut self, sketch: &Sketch, field: &[Form], watched: &[Form]) {
        self.inner.clear();
        self.last.clear();
        self.nodes.clear();
        self.numbers.factors.clear();
        self.numbers.constants.clear();
        self.value_read = sketch.value_read;
        self.needs.clear();
        self.needs.resize(sketch.ops.len(), 0);
        let results = field.iter().map(|form| (form, FIELD));
        let others = watched.iter().chain(&sketch.choices);
        for (form, by) in results.chain(others.map(|form| (form, WATCHED))) {
            for term in sketch.terms(*form) {
                self.needs[term.node as usize] |= by;
            }
        }
        for node in (0..sketch.ops.len()).rev() {
            let by = self.needs[node];
            let mut need = |argument: u32| self.needs[argument as usize] |= by;
            match sketch.ops[node] {
                Op::Input => {}
                Op::Combination(form) => {
                    sketch.terms(form).iter().for_each(|term| need(term.node));
                }
                Op::Product(a, b) | Op::Quotient(a, b) => {
                    need(a);
                    need(b);
                }
                Op::Reciprocal(a)
                | Op::Root(a)
                | Op::Exponential(a)
                | Op::Logarithm(a)
                | Op::Sine(a) => need(a),
                Op::Cosine => need(node as u32 - 1),
            }
        }
        self.rows = sketch.ops.len();
        let mut of_watched = Vec::new();
        for node in 0..sketch.ops.len() {
            let by = self.needs[node];
            if by == 0 {
                continue;
            }
            let Some(instruction) = self.instruction(sketch, node, field.len()) else {
                continue;
            };
            if by & FIELD != 0 {
                self.inner.push(instruction);
            } else {
                of_watched.push(instruction);
            }
            if by & WATCHED != 0 {
                self.last.push(instruction);
            }
        }
        self.inner.append(&mut of_watched);
        let mut combinations = |forms: &[Form], into: fn(&mut Tape) -> &mut Vec<Combination>| {
            into(self).clear();
            for form in forms {
                let combination = self.combination(sketch, *form);
                into(self).push(combination);
            }
        };
        combinations(field, |tape| &mut tape.field);
        combinations(watched, |tape| &mut tape.watched);
        combinations(&sketch.choices, |tape| &mut tape.choices);
        self.results.clear();
        self.results.extend(0..field.len() as u32);
        for function in self.watched.iter().chain(&self.choices) {
            self.results.extend(&self.nodes[function.terms()]);
        }
        self.results.sort_unstable();
        self.results.dedup();
        self.shape = None;
    }

    fn combination(&mut self, sketch: &Sketch, form: Form) -> Combination {
        let first = self.nodes.len() as u32;
        for term in sketch.terms(form) {
            self.nodes.push(term.node);
            self.numbers.factors.push([term.factor]);
        }
        self.numbers.constants.push([form.constant]);
        Combination {
            constant: self.numbers.constants.len() as u32 - 1,
            first,
            count: self.nodes.len() as u32 - first,
        }
    }

    /// What computes a node; the time is node `time`.
    fn instruction(&mut self, sketch: &Sketch, node: usize, time: usize) -> Option<Instruction> {
        let out = node as u32;
        let mut helper = || {
            self.rows += 1;
            self.rows as u32 - 1
        };
        Some(match sketch.ops[node] {
            Op::Input | Op::Cosine => return None,
            Op::Combination(form) => Instruction::Combination {
                out,
                sum: self.combination(sketch, form),
            },
            Op::Product(a, b) if a == b => Instruction::Square { out, a },
            Op::Product(a, b) => Instruction::Product { out, a, b },
            Op::Quotient(a, b) => Instruction::Quotient { out, a, b },
            Op::Reciprocal(b) => Instruction::Reciprocal { out, b },
            Op::Root(a) => Instruction::Root { out, a },
            Op::Exponential(a) => Instruction::Exponential {
                out,
                a,
                helper: helper(),
            },
            Op::Logarithm(a) => Instruction::Logarithm {
                out,
                a,
                helper: helper(),
            },
            Op::Sine(a) if is_of_time(sketch, a as usize, time) => {
                Instruction::SineCosineOfTime { sine: out, a }
            }
            Op::Sine(a) => Instruction::SineCosine {
                sine: out,
                a,
                helper: helper(),
            },
        })
    }
}

/// Whether a node is a linear function of the time, which is node `time`, alone.
fn is_of_time(sketch: &Sketch, node: usize, time: usize) -> bool {
    match sketch.ops[node] {
        Op::Input => node == time,
        Op::Combination(form) => {
            let mut terms = sketch.terms(form).iter();
            terms.all(|term| term.node as usize == time)
        }
        _ => false,
    }
}
