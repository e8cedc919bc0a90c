//! Optimized steps of a recording for the orders above 0.
//!
//! Constants have no coefficients at these orders. A sum with a constant equals the other summand
//! and is skipped, unless its row is needed. Unused results are omitted.

use super::functions::unless_overflowed;
use super::pass::Rows;
use super::recording::{Call, Made, Operation, Place, Replay};
use super::row::{Lanes, Row, lanes, lanes_of, product, quotient};
use super::{MOST_ORDER, inverse};

/// The kinds of steps at each order.
#[derive(Clone, Copy, Debug)]
enum Way {
    Copy,
    /// `a` times the constant.
    Scale,
    Add,
    Subtract,
    /// The sum of `a` and `b`, each times its factor.
    Combine,
    /// The sum of `a` and this line times the constant.
    AddLine(u32),
    /// This line minus `a`.
    SubtractFromLine(u32),
    Multiply,
    Divide,
    /// A constant over `b`.
    Invert,
    /// The row before it holds the slope of the argument.
    Exponential,
    /// Sine and cosine of the line `a`.
    SineCosine,
    /// The difference of `a` and `b` in a comparison, times the constant, which is a sign.
    Ahead,
    /// The difference in a comparison with a constant.
    AheadOfConstant,
    /// The call `a`, evaluated as at order 0.
    Any,
}

/// A step and the rows of its operands.
#[derive(Clone, Copy, Debug)]
struct Step {
    way: Way,
    /// The row of the result, or the first row that is taken.
    row: u32,
    a: Source,
    b: Source,
    constant: f64,
}

impl Step {
    fn of(way: Way, row: u32, [a, mut b]: [Source; 2], constant: f64) -> Self {
        let way = match way {
            Way::Add | Way::Subtract if [a.factor, b.factor] != [1.0; 2] => {
                if let Way::Subtract = way {
                    b.factor = -b.factor;
                }
                Way::Combine
            }
            _ => way,
        };
        Step {
            way,
            row,
            a,
            b,
            constant,
        }
    }
}

/// The rows that hold a number's coefficients.
#[derive(Clone, Copy, Debug)]
struct Source {
    /// Row of the coefficient of order 0.
    first: u32,
    /// Row of the coefficients above order 0.
    above: u32,
    /// Factor on the coefficients above order 0.
    factor: f64,
}

impl Source {
    fn itself(row: u32) -> Self {
        Source {
            first: row,
            above: row,
            factor: 1.0,
        }
    }
}

#[derive(Debug, Default)]
pub(super) struct Steps(Vec<Step>);

/// What later steps need of a row.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Use {
    #[default]
    None,
    /// The newest coefficient, which may be computed on use.
    Newest,
    /// Its coefficients, from any row.
    Coefficients,
    /// The row itself.
    Row,
}

/// The kind of step for a call, its operand rows and its constant. `None` if the call is repeated
/// as at order 0.
fn way(call: &Call, is_constant: impl Fn(u32) -> bool) -> Option<(Way, [u32; 2], f64)> {
    use Operation as Op;
    use Place::{Line, Row};
    let sign = if call.operation == Op::Exceeds {
        1.0
    } else {
        -1.0
    };
    Some(match (call.operation, call.of) {
        (Op::Add, [Row(a), Row(b)]) => (Way::Add, [a, b], 0.0),
        (Op::Subtract, [Row(a), Row(b)]) => (Way::Subtract, [a, b], 0.0),
        (Op::Multiply, [Row(a), Row(b)]) => (Way::Multiply, [a, b], 0.0),
        (Op::Divide, [Row(a), Row(b)]) => (Way::Divide, [a, b], 0.0),
        (Op::Divide, [Line(a), Row(b)]) if is_constant(a) => (Way::Invert, [b; 2], 0.0),
        (Op::Add | Op::Subtract, [Row(a), Line(b)]) if is_constant(b) => (Way::Copy, [a; 2], 0.0),
        (Op::Add, [Line(a), Row(b)]) if is_constant(a) => (Way::Copy, [b; 2], 0.0),
        (Op::Subtract, [Line(a), Row(b)]) if is_constant(a) => (Way::Scale, [b; 2], -1.0),
        (Op::Add, [Row(a), Line(b)] | [Line(b), Row(a)]) => (Way::AddLine(b), [a; 2], 1.0),
        (Op::Subtract, [Row(a), Line(b)]) => (Way::AddLine(b), [a; 2], -1.0),
        (Op::Subtract, [Line(a), Row(b)]) => (Way::SubtractFromLine(a), [b; 2], 0.0),
        (Op::AddConstant | Op::SubtractConstant, [Row(a), _]) => (Way::Copy, [a; 2], 0.0),
        (Op::Negate, [Row(a), _]) => (Way::Scale, [a; 2], -1.0),
        (Op::MultiplyConstant, [Row(a), _]) => (Way::Scale, [a; 2], call.constant()),
        (Op::DivideByConstant, [Row(a), _]) => (Way::Scale, [a; 2], 1.0 / call.constant()),
        (Op::Exponential, [Row(a), _]) => (Way::Exponential, [a; 2], 0.0),
        (Op::Exceeds | Op::ExceedsNot, [Row(a), Row(b)]) => (Way::Ahead, [a, b], sign),
        (Op::Exceeds | Op::ExceedsNot, [Row(a), Line(b)]) if is_constant(b) => {
            (Way::AheadOfConstant, [a; 2], sign)
        }
        (Op::Exceeds | Op::ExceedsNot, [Line(a), Row(b)]) if is_constant(a) => {
            (Way::AheadOfConstant, [b; 2], -sign)
        }
        _ => return None,
    })
}

impl Steps {
    /// Builds the steps of calls that took `rows`, if the numbers at the places `wanted` are
    /// needed.
    pub(super) fn make(
        &mut self,
        calls: &[Made],
        wanted: impl Iterator<Item = Place>,
        is_constant: impl Fn(u32) -> bool,
        rows: usize,
    ) {
        let uses = uses(calls, wanted, &is_constant, rows);
        let mut rows: Vec<Source> = (0..rows as u32).map(Source::itself).collect();
        self.0.clear();
        for (i, made) in calls.iter().enumerate() {
            if !is_used(made, &uses) {
                continue;
            }
            let row = made.result.map_or(made.first, Place::number);
            let step = match way(&made.call, &is_constant) {
                Some((way, of, constant)) => {
                    let [a, b] = of.map(|row| rows[row as usize]);
                    let first = row;
                    let is_exact = constant.abs() == 1.0 || a.factor.abs() == 1.0;
                    match way {
                        Way::Copy if uses[row as usize] < Use::Row => {
                            rows[row as usize] = Source { first, ..a };
                            continue;
                        }
                        Way::Scale if uses[row as usize] == Use::Newest && is_exact => {
                            let factor = constant * a.factor;
                            rows[row as usize] = Source { first, factor, ..a };
                            continue;
                        }
                        _ => {}
                    }
                    Step::of(way, row, [a, b], constant)
                }
                None => {
                    let (way, number) = match made.call {
                        Call {
                            operation: Operation::SineCosine,
                            of: [Place::Line(line), _],
                            ..
                        } => (Way::SineCosine, line),
                        _ => (Way::Any, i as u32),
                    };
                    Step::of(way, made.first, [Source::itself(number); 2], 0.0)
                }
            };
            self.0.push(step);
        }
    }

    /// Performs all steps at one order.
    #[inline(always)]
    pub(super) fn repeat<const L: usize>(
        &self,
        replay: &Replay<'_, L>,
        rows: Rows<'_, L>,
        order: usize,
    ) {
        // The bound spares the checks of every access to a row.
        let order = order.min(MOST_ORDER);
        let mut at_order = AtOrder {
            rows,
            order,
            choices: 0,
        };
        for step in &self.0 {
            // No row is missing: the first pass has made room.
            let _ = at_order.perform(step, replay);
        }
    }
}

/// The steps at one order.
struct AtOrder<'r, const L: usize> {
    rows: Rows<'r, L>,
    order: usize,
    /// Number of comparisons so far.
    choices: usize,
}

impl<const L: usize> AtOrder<'_, L> {
    #[inline(always)]
    fn row(&self, row: u32) -> Option<&Row<L>> {
        self.rows.all.get(row as usize)
    }

    /// The newest coefficient.
    #[inline(always)]
    fn newest(&self, of: Source) -> Option<Lanes<L>> {
        Some(self.row(of.above)?.at(self.order))
    }

    /// The same times its factor.
    #[inline(always)]
    fn scaled(&self, of: Source) -> Option<Lanes<L>> {
        Some(lanes_of(self.newest(of)?, |a| of.factor * a))
    }

    /// The coefficient of order 0 and the newest one.
    #[inline(always)]
    fn ends(&self, of: Source) -> Option<(Lanes<L>, Lanes<L>)> {
        Some((self.row(of.first)?.at(0), self.newest(of)?))
    }

    /// The newest coefficient of an integral.
    #[inline(always)]
    fn integral(&self, slope: Lanes<L>) -> Lanes<L> {
        lanes_of(slope, |slope| slope * inverse(self.order))
    }

    /// As [`super::pass::Pass::choose`].
    #[inline(always)]
    fn choose(&mut self, ahead: Lanes<L>) {
        if let Some(row) = self.rows.all.iter().nth_back(self.choices) {
            row.set(self.order, ahead);
        }
        self.choices += 1;
    }

    /// Performs a step. `None` if a row is missing. Each arm looks up only the rows that it needs,
    /// since a look-up takes as long as an addition.
    #[inline(always)]
    fn perform(&mut self, step: &Step, replay: &Replay<'_, L>) -> Option<()> {
        let Step {
            way,
            row,
            a,
            b,
            constant,
        } = *step;
        let order = self.order;
        match way {
            Way::Copy => self.row(row)?.set(order, self.newest(a)?),
            Way::Scale => {
                let newest = lanes_of(self.scaled(a)?, |a| a * constant);
                self.row(row)?.set(order, newest);
            }
            Way::Combine => {
                let (a, b) = (self.scaled(a)?, self.scaled(b)?);
                self.row(row)?.set(order, lanes(|l| a[l] + b[l]));
            }
            Way::Add => {
                let (a, b) = (self.newest(a)?, self.newest(b)?);
                self.row(row)?.set(order, lanes(|l| a[l] + b[l]));
            }
            Way::Subtract => {
                let (a, b) = (self.newest(a)?, self.newest(b)?);
                self.row(row)?.set(order, lanes(|l| a[l] - b[l]));
            }
            Way::AddLine(line) => {
                let (a, line) = (self.scaled(a)?, replay.line(line).coefficient(order));
                self.row(row)?
                    .set(order, lanes(|l| a[l] + constant * line[l]));
            }
            Way::SubtractFromLine(line) => {
                let (a, line) = (self.scaled(a)?, replay.line(line).coefficient(order));
                self.row(row)?.set(order, lanes(|l| line[l] - a[l]));
            }
            Way::Multiply => {
                let (of_a, of_b) = (self.row(a.above)?, self.row(b.above)?);
                let inner = if a.above == b.above {
                    of_a.square(order)
                } else {
                    of_a.convolution(of_b, order)
                };
                let newest = product(inner, self.ends(a)?, self.ends(b)?);
                self.row(row)?.set(order, newest);
            }
            Way::Divide => {
                let into = self.row(row)?;
                let inner = self.row(b.above)?.convolution(into, order);
                let newest = quotient(inner, self.scaled(a)?, self.ends(b)?, into.at(0));
                into.set(order, newest);
            }
            Way::Invert => {
                let into = self.row(row)?;
                let inner = self.row(b.above)?.convolution(into, order);
                let newest = quotient(inner, [0.0; L], self.ends(b)?, into.at(0));
                into.set(order, newest);
            }
            Way::Exponential => {
                let (slopes, into) = (self.row(row - 1)?, self.row(row)?);
                let slope = lanes_of(self.scaled(a)?, |a| a * order as f64);
                slopes.set(order, slope);
                let (inner, e0) = (slopes.convolution(into, order), into.at(0));
                let newest = self.integral(lanes(|l| inner[l] + slope[l] * e0[l]));
                into.set(order, unless_overflowed(newest, e0));
            }
            Way::SineCosine => {
                let slope = replay.line(a.above).slope;
                let (sine, cosine) = (self.row(row)?, self.row(row + 1)?);
                let (s, c) = (sine.at(order - 1), cosine.at(order - 1));
                sine.set(order, self.integral(lanes(|l| slope[l] * c[l])));
                cosine.set(order, self.integral(lanes(|l| -slope[l] * s[l])));
            }
            Way::Ahead => {
                let (a, b) = (self.scaled(a)?, self.scaled(b)?);
                self.choose(lanes(|l| constant * (a[l] - b[l])));
            }
            Way::AheadOfConstant => {
                let a = self.scaled(a)?;
                self.choose(lanes_of(a, |a| constant * a));
            }
            Way::Any => {
                let taken = (row as usize, self.choices);
                self.choices = replay.repeat_call(a.above as usize, self.rows, order, taken);
            }
        }
        Some(())
    }
}

/// Whether the result of a call is used.
fn is_used(made: &Made, uses: &[Use]) -> bool {
    match made.result {
        // The other checks concern the value alone.
        None => matches!(
            made.call.operation,
            Operation::Exceeds | Operation::ExceedsNot
        ),
        Some(Place::Line(_)) => false,
        Some(Place::Row(row)) => {
            let is_pair = made.call.operation == Operation::SineCosine;
            let mut rows = row as usize..=row as usize + usize::from(is_pair);
            rows.any(|row| uses[row] > Use::None)
        }
    }
}

/// How each row is used.
fn uses(
    calls: &[Made],
    wanted: impl Iterator<Item = Place>,
    is_constant: &impl Fn(u32) -> bool,
    rows: usize,
) -> Vec<Use> {
    let mut uses = vec![Use::None; rows];
    for place in wanted {
        raise(&mut uses, place, Use::Row);
    }
    for made in calls.iter().rev() {
        if !is_used(made, &uses) {
            continue;
        }
        let Some((way, of, _)) = way(&made.call, is_constant) else {
            for place in made.call.of {
                raise(&mut uses, place, Use::Row);
            }
            continue;
        };
        let to = match way {
            Way::Copy => {
                let of_copy = made.result.map_or(0, Place::number);
                [uses[of_copy as usize].min(Use::Coefficients); 2]
            }
            Way::Multiply | Way::Invert => [Use::Coefficients; 2],
            Way::Divide => [Use::Newest, Use::Coefficients],
            _ => [Use::Newest; 2],
        };
        for (row, to) in of.into_iter().zip(to) {
            raise(&mut uses, Place::Row(row), to);
        }
    }
    uses
}

/// Raises the use of a row to at least this one.
fn raise(uses: &mut [Use], place: Place, to: Use) {
    if let Place::Row(row) = place
        && uses[row as usize] < to
    {
        uses[row as usize] = to;
    }
}
