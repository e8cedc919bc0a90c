//! What a recording is written on: operations in order, and every number as a linear combination of their results.
//!
//! Sums, differences and multiples are never operations of their own: they are folded into the combinations, so that constants
//! fold, chains of sums merge, and what cancels cancels exactly. Only what is not linear becomes an operation.

/// A number of the recording: a constant and multiples of results of operations.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Form {
    pub constant: f64,
    first: u32,
    count: u32,
}

/// `factor` times the result of operation `node`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Term {
    pub node: u32,
    pub factor: f64,
}

/// An operation; its arguments are results of earlier ones, by index.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Op {
    /// A component of the state, or the time.
    Input,
    /// A linear combination that another operation needs as one number.
    Combination(Form),
    Product(u32, u32),
    Quotient(u32, u32),
    Reciprocal(u32),
    Root(u32),
    Exponential(u32),
    Logarithm(u32),
    /// The sine; its cosine is the operation after it.
    Sine(u32),
    Cosine,
}

/// Operations and numbers of one recording. Its memory is kept from one recording to the next.
#[derive(Debug, Default)]
pub(crate) struct Sketch {
    pub ops: Vec<Op>,
    forms: Vec<Form>,
    terms: Vec<Term>,
    /// What was compared: the number that was chosen less the one that was not.
    pub choices: Vec<Form>,
    /// Whether a value was read, so that the recording may hold only where it was made.
    pub value_read: bool,
}

/// A number of which nothing is known.
const UNKNOWN: Form = Form {
    constant: f64::NAN,
    first: 0,
    count: 0,
};

impl Sketch {
    /// Starts anew with so many inputs.
    pub(crate) fn restart(&mut self, inputs: usize) {
        self.ops.clear();
        self.forms.clear();
        self.terms.clear();
        self.choices.clear();
        self.value_read = false;
        for _ in 0..inputs {
            self.ops.push(Op::Input);
        }
    }

    pub(crate) fn form(&self, index: u32) -> Form {
        self.forms.get(index as usize).copied().unwrap_or(UNKNOWN)
    }

    pub(crate) fn terms(&self, form: Form) -> &[Term] {
        let first = form.first as usize;
        &self.terms[first..first + form.count as usize]
    }

    fn keep(&mut self, form: Form) -> u32 {
        self.forms.push(form);
        self.forms.len() as u32 - 1
    }

    pub(crate) fn constant(&mut self, constant: f64) -> u32 {
        self.keep(Form {
            constant,
            ..Form::default()
        })
    }

    /// `factor` times the result of an operation.
    pub(crate) fn multiple(&mut self, factor: f64, node: u32) -> u32 {
        let first = self.terms.len() as u32;
        self.terms.push(Term { node, factor });
        self.keep(Form {
            constant: 0.0,
            first,
            count: 1,
        })
    }

    /// `a + factor b`.
    pub(crate) fn sum(&mut self, a: u32, factor: f64, b: u32) -> u32 {
        let (a, b) = (self.form(a), self.form(b));
        let sum = self.combined(a, factor, b);
        self.keep(sum)
    }

    fn combined(&mut self, a: Form, factor: f64, b: Form) -> Form {
        let first = self.terms.len();
        let (mut i, a_end) = (a.first as usize, (a.first + a.count) as usize);
        let (mut j, b_end) = (b.first as usize, (b.first + b.count) as usize);
        // Both are sorted by node.
        while i < a_end || j < b_end {
            let of_a = (i < a_end).then(|| self.terms[i]);
            let of_b = (j < b_end).then(|| self.terms[j]);
            let node = match (of_a, of_b) {
                (Some(a), Some(b)) => a.node.min(b.node),
                (Some(one), None) | (None, Some(one)) => one.node,
                (None, None) => break,
            };
            let mut total = None;
            if let Some(a) = of_a.filter(|a| a.node == node) {
                total = Some(a.factor);
                i += 1;
            }
            if let Some(b) = of_b.filter(|b| b.node == node) {
                let more = factor * b.factor;
                total = Some(total.map_or(more, |t| t + more));
                j += 1;
            }
            let total = total.unwrap_or(0.0);
            if total != 0.0 {
                self.terms.push(Term {
                    node,
                    factor: total,
                });
            }
        }
        Form {
            constant: a.constant + factor * b.constant,
            first: first as u32,
            count: (self.terms.len() - first) as u32,
        }
    }

    pub(crate) fn scaled(&mut self, a: u32, factor: f64) -> u32 {
        let zero = Form::default();
        let a = self.form(a);
        let scaled = self.combined(zero, factor, a);
        self.keep(scaled)
    }

    pub(crate) fn product(&mut self, a: u32, b: u32) -> u32 {
        let (of_a, of_b) = (self.form(a), self.form(b));
        if of_a.count == 0 {
            return self.scaled(b, of_a.constant);
        }
        if of_b.count == 0 {
            return self.scaled(a, of_b.constant);
        }
        let ((p, a), (q, b)) = (self.factored(of_a), self.factored(of_b));
        // (n/d) d is n: as in the sliding field of a boundary that is itself a velocity.
        for (quotient, other) in [(a, b), (b, a)] {
            match self.ops[quotient as usize] {
                Op::Quotient(n, d) if d == other => {
                    return match self.ops[n as usize] {
                        Op::Combination(form) => {
                            let scaled = self.combined(Form::default(), p * q, form);
                            self.keep(scaled)
                        }
                        _ => self.multiple(p * q, n),
                    };
                }
                Op::Reciprocal(d) if d == other => return self.constant(p * q),
                _ => {}
            }
        }
        let node = self.node(Op::Product(a.min(b), a.max(b)));
        self.multiple(p * q, node)
    }

    pub(crate) fn quotient(&mut self, a: u32, b: u32) -> u32 {
        let (of_a, of_b) = (self.form(a), self.form(b));
        if of_b.count == 0 {
            let divided = of_a.count == 0;
            return if divided {
                self.constant(of_a.constant / of_b.constant)
            } else {
                self.divided(of_a, of_b.constant)
            };
        }
        let (q, b) = self.factored(of_b);
        if of_a.count == 0 {
            if of_a.constant == 0.0 {
                return self.constant(0.0);
            }
            let node = self.node(Op::Reciprocal(b));
            return self.multiple(of_a.constant / q, node);
        }
        let (p, a) = self.factored(of_a);
        if a == b {
            return self.constant(p / q);
        }
        let node = self.node(Op::Quotient(a, b));
        self.multiple(p / q, node)
    }

    /// A form divided by a constant: each factor once rounded, as division by a reciprocal would not have it.
    fn divided(&mut self, a: Form, by: f64) -> u32 {
        let first = self.terms.len();
        for i in a.first..a.first + a.count {
            let Term { node, factor } = self.terms[i as usize];
            self.terms.push(Term {
                node,
                factor: factor / by,
            });
        }
        self.keep(Form {
            constant: a.constant / by,
            first: first as u32,
            count: a.count,
        })
    }

    /// A function of one number; `None` where that number is constant.
    pub(crate) fn function(&mut self, a: u32, op: fn(u32) -> Op) -> Option<u32> {
        let form = self.form(a);
        if form.count == 0 {
            return None;
        }
        let argument = match self.factored(form) {
            (1.0, node) => node,
            (factor, node) => {
                let index = self.multiple(factor, node);
                let whole = self.form(index);
                self.combination(whole)
            }
        };
        Some(self.node(op(argument)))
    }

    /// A factor and an operation whose product the form is. The sign is taken out of a combination, so that a number and its
    /// opposite share the operation.
    fn factored(&mut self, form: Form) -> (f64, u32) {
        let leading = self.terms[form.first as usize];
        if form.count == 1 && form.constant == 0.0 {
            return (leading.factor, leading.node);
        }
        if leading.factor > 0.0 {
            return (1.0, self.combination(form));
        }
        let opposite = self.combined(Form::default(), -1.0, form);
        (-1.0, self.combination(opposite))
    }

    fn combination(&mut self, form: Form) -> u32 {
        let same =
            |other: Form| other.constant == form.constant && self.terms(other) == self.terms(form);
        let known = self
            .ops
            .iter()
            .position(|op| matches!(op, Op::Combination(other) if same(*other)));
        match known {
            Some(node) => node as u32,
            None => self.push(Op::Combination(form)),
        }
    }

    /// The operation, if it is there already, or a new one.
    fn node(&mut self, op: Op) -> u32 {
        let same = |other: &Op| match (op, *other) {
            (Op::Product(a, b), Op::Product(c, d)) | (Op::Quotient(a, b), Op::Quotient(c, d)) => {
                (a, b) == (c, d)
            }
            (Op::Reciprocal(a), Op::Reciprocal(b))
            | (Op::Root(a), Op::Root(b))
            | (Op::Exponential(a), Op::Exponential(b))
            | (Op::Logarithm(a), Op::Logarithm(b))
            | (Op::Sine(a), Op::Sine(b)) => a == b,
            _ => false,
        };
        if let Some(known) = self.ops.iter().position(same) {
            return known as u32;
        }
        let node = self.push(op);
        if let Op::Sine(_) = op {
            self.push(Op::Cosine);
        }
        node
    }

    fn push(&mut self, op: Op) -> u32 {
        self.ops.push(op);
        self.ops.len() as u32 - 1
    }

    /// Notes that `chosen` was taken rather than `other`.
    pub(crate) fn choose(&mut self, chosen: u32, other: u32) {
        let (chosen, other) = (self.form(chosen), self.form(other));
        let ahead = self.combined(chosen, -1.0, other);
        if ahead.count > 0 {
            self.choices.push(ahead);
        }
    }
}
