//! The tape: what a recording comes to once everything that no result needs has been dropped.

use super::recorder::{Recorded, recording};
use super::sketch::{Form, Op, Sketch, Term};
use crate::system::State;

/// A constant and multiples of rows: terms `first .. first + count` of the tape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Combination {
    pub constant: f64,
    pub first: u32,
    pub count: u32,
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
}

/// A field and functions of its solution as a list of operations.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tape {
    /// What the field takes.
    pub of_field: Vec<Instruction>,
    /// What the watched functions take beyond that.
    pub of_watched: Vec<Instruction>,
    /// Those of the field's that the watched functions take too, at the highest order, which the field itself does not need.
    pub of_both: Vec<Instruction>,
    pub terms: Vec<Term>,
    /// The right-hand side.
    pub field: Vec<Combination>,
    /// The watched functions, those that are constant as such.
    pub watched: Vec<Combination>,
    /// What was compared by [`crate::Scalar::exceeds`]: positive where the comparison came out as it did.
    pub choices: Vec<Combination>,
    /// Rows of coefficients.
    pub rows: usize,
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
        x: &State<f64, N>,
        functions: impl FnOnce(Recorded, &State<Recorded, N>) -> (State<Recorded, N>, [Recorded; W]),
    ) {
        let (field, watched) = recording(sketch, N + 1, || {
            let state = State::from_fn(|i, _| Recorded::input(i, x[i]));
            functions(Recorded::input(N, t), &state)
        });
        let field: [Form; N] = std::array::from_fn(|i| field[i].form(sketch));
        let watched = watched.map(|number| number.form(sketch));
        self.compile(sketch, &field, &watched);
    }

    /// Whether the function is more than a combination of the `n` components of the state and the time.
    pub(crate) fn is_nonlinear(&self, function: &Combination, n: usize) -> bool {
        let terms =
            &self.terms[function.first as usize..(function.first + function.count) as usize];
        terms.iter().any(|term| term.node as usize > n)
    }

    fn compile(&mut self, sketch: &Sketch, field: &[Form], watched: &[Form]) {
        self.of_field.clear();
        self.of_watched.clear();
        self.of_both.clear();
        self.terms.clear();
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
        for node in 0..sketch.ops.len() {
            let by = self.needs[node];
            if by == 0 {
                continue;
            }
            let Some(instruction) = self.instruction(sketch, node) else {
                continue;
            };
            if by & FIELD != 0 {
                self.of_field.push(instruction);
            } else {
                self.of_watched.push(instruction);
            }
            if by == FIELD | WATCHED {
                self.of_both.push(instruction);
            }
        }
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
    }

    fn combination(&mut self, sketch: &Sketch, form: Form) -> Combination {
        let first = self.terms.len() as u32;
        let terms = sketch.terms(form);
        self.terms.extend_from_slice(terms);
        Combination {
            constant: form.constant,
            first,
            count: terms.len() as u32,
        }
    }

    fn instruction(&mut self, sketch: &Sketch, node: usize) -> Option<Instruction> {
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
            Op::Sine(a) => Instruction::SineCosine {
                sine: out,
                a,
                helper: helper(),
            },
        })
    }
}
