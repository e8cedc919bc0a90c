//! Optimized steps of a recording for the orders above 0.
//!
//! Constants have no coefficients at these orders. A sum with a constant equals the other summand
//! and is skipped, unless its row is needed. Unused results are omitted.

use super::functions::unless_overflowed;
use super::recording::{Instruction, Location, Operation, RecordedInstruction, Recording, Replay};
use super::row::{CoefficientRow, Lanes, lanes, lanes_of, product, quotient};
use super::sweep::CoefficientRows;
use super::{MAX_ORDER, inverse};

/// The kinds of steps at each order.
#[derive(Clone, Copy, Debug)]
enum StepKind {
    Copy,
    /// `a` times the constant.
    Scale,
    Add,
    Subtract,
    /// The sum of `a` and `b`, each times its factor.
    Combine,
    /// The sum of `a` and this linear number times the constant.
    AddLinear(u32),
    /// Subtracts `a` from this linear number.
    SubtractFromLinear(u32),
    Multiply,
    /// `a` times this linear number, which is constant.
    ScaleByLinear(u32),
    /// `a` over this linear number, which is constant.
    DivideByLinear(u32),
    Divide,
    /// A constant over `b`.
    Invert,
    /// The row before it holds the slope of the argument.
    Exponential,
    /// Sine and cosine of the linear number `a`.
    SineCosine,
    /// The difference of `a` and `b` in a comparison, times the constant, which is a sign.
    Ahead,
    /// The difference in a comparison with a constant.
    AheadOfConstant,
    /// The instruction `a`, evaluated as at order 0.
    Any,
}

/// A step and the rows of its operands.
#[derive(Clone, Copy, Debug)]
struct RecordedStep {
    kind: StepKind,
    /// The row of the result, or the first row that is taken.
    row: u32,
    a: RowSource,
    b: RowSource,
    constant: f64,
}

impl RecordedStep {
    fn of(kind: StepKind, row: u32, [a, mut b]: [RowSource; 2], constant: f64) -> Self {
        let kind = match kind {
            StepKind::Add | StepKind::Subtract if [a.factor, b.factor] != [1.0; 2] => {
                if let StepKind::Subtract = kind {
                    b.factor = -b.factor;
                }
                StepKind::Combine
            }
            _ => kind,
        };
        RecordedStep {
            kind,
            row,
            a,
            b,
            constant,
        }
    }
}

/// The rows that hold a number's coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RowSource {
    /// Row of the coefficient of order 0.
    pub first: u32,
    /// Row of the coefficients above order 0.
    pub higher: u32,
    /// Factor on the coefficients above order 0.
    pub factor: f64,
}

impl RowSource {
    fn itself(row: u32) -> Self {
        RowSource {
            first: row,
            higher: row,
            factor: 1.0,
        }
    }
}

#[derive(Debug)]
pub(super) struct Steps(Vec<RecordedStep>);

/// Use of a row by later steps.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Use {
    #[default]
    None,
    /// The newest coefficient, which may be computed on use.
    Newest,
    /// Coefficients, from any row.
    Coefficients,
    /// The row itself.
    Row,
}

/// The kind of step for an instruction, its operand rows and its constant. `None` if the
/// instruction is repeated as at order 0.
fn step_kind(
    instruction: &Instruction,
    is_constant: impl Fn(u32) -> bool,
) -> Option<(StepKind, [u32; 2], f64)> {
    use Location::{InRow, Linear};
    use Operation as Op;
    let sign = if instruction.operation == Op::Exceeds {
        1.0
    } else {
        -1.0
    };
    Some(match (instruction.operation, instruction.of) {
        (Op::Add, [InRow(a), InRow(b)]) => (StepKind::Add, [a, b], 0.0),
        (Op::Subtract, [InRow(a), InRow(b)]) => (StepKind::Subtract, [a, b], 0.0),
        (Op::Multiply, [InRow(a), InRow(b)]) => (StepKind::Multiply, [a, b], 0.0),
        (Op::Multiply, [InRow(a), Linear(b)] | [Linear(b), InRow(a)]) if is_constant(b) => {
            (StepKind::ScaleByLinear(b), [a; 2], 0.0)
        }
        (Op::Divide, [InRow(a), Linear(b)]) if is_constant(b) => {
            (StepKind::DivideByLinear(b), [a; 2], 0.0)
        }
        (Op::Divide, [InRow(a), InRow(b)]) => (StepKind::Divide, [a, b], 0.0),
        (Op::Divide, [Linear(a), InRow(b)]) if is_constant(a) => (StepKind::Invert, [b; 2], 0.0),
        (Op::Add | Op::Subtract, [InRow(a), Linear(b)]) if is_constant(b) => {
            (StepKind::Copy, [a; 2], 0.0)
        }
        (Op::Add, [Linear(a), InRow(b)]) if is_constant(a) => (StepKind::Copy, [b; 2], 0.0),
        (Op::Subtract, [Linear(a), InRow(b)]) if is_constant(a) => (StepKind::Scale, [b; 2], -1.0),
        (Op::Add, [InRow(a), Linear(b)] | [Linear(b), InRow(a)]) => {
            (StepKind::AddLinear(b), [a; 2], 1.0)
        }
        (Op::Subtract, [InRow(a), Linear(b)]) => (StepKind::AddLinear(b), [a; 2], -1.0),
        (Op::Subtract, [Linear(a), InRow(b)]) => (StepKind::SubtractFromLinear(a), [b; 2], 0.0),
        (Op::AddConstant | Op::SubtractConstant, [InRow(a), _]) => (StepKind::Copy, [a; 2], 0.0),
        (Op::Negate, [InRow(a), _]) => (StepKind::Scale, [a; 2], -1.0),
        (Op::MultiplyConstant, [InRow(a), _]) => (StepKind::Scale, [a; 2], instruction.constant()),
        (Op::DivideByConstant, [InRow(a), _]) => {
            (StepKind::Scale, [a; 2], 1.0 / instruction.constant())
        }
        (Op::Exponential, [InRow(a), _]) => (StepKind::Exponential, [a; 2], 0.0),
        (Op::Exceeds | Op::ExceedsNot, [InRow(a), InRow(b)]) => (StepKind::Ahead, [a, b], sign),
        (Op::Exceeds | Op::ExceedsNot, [InRow(a), Linear(b)]) if is_constant(b) => {
            (StepKind::AheadOfConstant, [a; 2], sign)
        }
        (Op::Exceeds | Op::ExceedsNot, [Linear(a), InRow(b)]) if is_constant(a) => {
            (StepKind::AheadOfConstant, [b; 2], -sign)
        }
        _ => return None,
    })
}

impl Steps {
    /// The steps of a recording that took `rows`, if the numbers at the locations `wanted` are
    /// needed in their rows.
    pub(super) fn of(
        recording: &Recording,
        wanted: impl Iterator<Item = Location>,
        rows: usize,
    ) -> Self {
        Steps::used_by(recording, (wanted, Use::Row), rows).0
    }

    /// The steps of a recording of which the numbers at the locations `wanted` need coefficients.
    /// The rows hold those of each number.
    pub(super) fn with_sources(
        recording: &Recording,
        wanted: impl Iterator<Item = Location>,
        rows: usize,
    ) -> (Self, Vec<RowSource>) {
        Steps::used_by(recording, (wanted, Use::Coefficients), rows)
    }

    fn used_by(
        recording: &Recording,
        wanted: (impl Iterator<Item = Location>, Use),
        rows: usize,
    ) -> (Self, Vec<RowSource>) {
        let instructions = &recording.instructions;
        let is_constant = |linear: u32| recording.linear_numbers[linear as usize].is_constant;
        let uses = uses(instructions, wanted, &is_constant, rows);
        let mut rows: Vec<RowSource> = (0..rows as u32).map(RowSource::itself).collect();
        let mut steps = Vec::new();
        for (i, recorded) in instructions.iter().enumerate() {
            if !is_used(recorded, &uses, &is_constant) {
                continue;
            }
            let row = recorded.result.map_or(recorded.first, Location::number);
            let step = match step_kind(&recorded.instruction, is_constant) {
                Some((kind, of, constant)) => {
                    let [a, b] = of.map(|row| rows[row as usize]);
                    let first = row;
                    let is_exact = constant.abs() == 1.0 || a.factor.abs() == 1.0;
                    match kind {
                        StepKind::Copy if uses[row as usize] < Use::Row => {
                            rows[row as usize] = RowSource { first, ..a };
                            continue;
                        }
                        StepKind::Scale if uses[row as usize] == Use::Newest && is_exact => {
                            let factor = constant * a.factor;
                            rows[row as usize] = RowSource { first, factor, ..a };
                            continue;
                        }
                        _ => {}
                    }
                    RecordedStep::of(kind, row, [a, b], constant)
                }
                None => {
                    let (kind, number) = match recorded.instruction {
                        Instruction {
                            operation: Operation::SineCosine,
                            of: [Location::Linear(linear), _],
                            ..
                        } => (StepKind::SineCosine, linear),
                        _ => (StepKind::Any, i as u32),
                    };
                    RecordedStep::of(kind, recorded.first, [RowSource::itself(number); 2], 0.0)
                }
            };
            steps.push(step);
        }
        (Steps(steps), rows)
    }

    /// Performs all steps at one order.
    #[inline(always)]
    pub(super) fn repeat<const L: usize>(
        &self,
        replay: &Replay<'_, L>,
        rows: CoefficientRows<'_, L>,
        order: usize,
    ) {
        // The bound spares the checks of every access to a row.
        let order = order.min(MAX_ORDER);
        let mut at_order = AtOrder {
            rows,
            order,
            choices: 0,
        };
        for step in &self.0 {
            // No row is missing: the first sweep has made room.
            let _ = at_order.perform(step, replay);
        }
    }
}

/// The steps at one order.
struct AtOrder<'r, const L: usize> {
    rows: CoefficientRows<'r, L>,
    order: usize,
    /// Number of comparisons so far.
    choices: usize,
}

impl<const L: usize> AtOrder<'_, L> {
    #[inline(always)]
    fn row(&self, row: u32) -> Option<&CoefficientRow<L>> {
        self.rows.all.get(row as usize)
    }

    /// The newest coefficient.
    #[inline(always)]
    fn newest(&self, of: RowSource) -> Option<Lanes<L>> {
        Some(self.row(of.higher)?.at(self.order))
    }

    /// Coefficient times its factor.
    #[inline(always)]
    fn scaled(&self, of: RowSource) -> Option<Lanes<L>> {
        Some(lanes_of(self.newest(of)?, |a| of.factor * a))
    }

    /// The coefficient of order 0 and the newest one.
    #[inline(always)]
    fn ends(&self, of: RowSource) -> Option<(Lanes<L>, Lanes<L>)> {
        Some((self.row(of.first)?.at(0), self.newest(of)?))
    }

    /// The newest coefficient of an integral.
    #[inline(always)]
    fn integral(&self, slope: Lanes<L>) -> Lanes<L> {
        lanes_of(slope, |slope| slope * inverse(self.order))
    }

    /// Chooses as [`super::sweep::Sweep::choose`] does.
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
    fn perform(&mut self, step: &RecordedStep, replay: &Replay<'_, L>) -> Option<()> {
        let RecordedStep {
            kind,
            row,
            a,
            b,
            constant,
        } = *step;
        let order = self.order;
        match kind {
            StepKind::Copy => self.row(row)?.set(order, self.newest(a)?),
            StepKind::Scale => {
                let newest = lanes_of(self.scaled(a)?, |a| a * constant);
                self.row(row)?.set(order, newest);
            }
            StepKind::Combine => {
                let (a, b) = (self.scaled(a)?, self.scaled(b)?);
                self.row(row)?.set(order, lanes(|l| a[l] + b[l]));
            }
            StepKind::Add => {
                let (a, b) = (self.newest(a)?, self.newest(b)?);
                self.row(row)?.set(order, lanes(|l| a[l] + b[l]));
            }
            StepKind::Subtract => {
                let (a, b) = (self.newest(a)?, self.newest(b)?);
                self.row(row)?.set(order, lanes(|l| a[l] - b[l]));
            }
            StepKind::AddLinear(linear) => {
                let (a, linear) = (
                    self.scaled(a)?,
                    replay.linear_number(linear).coefficient(order),
                );
                self.row(row)?
                    .set(order, lanes(|l| a[l] + constant * linear[l]));
            }
            StepKind::SubtractFromLinear(linear) => {
                let (a, linear) = (
                    self.scaled(a)?,
                    replay.linear_number(linear).coefficient(order),
                );
                self.row(row)?.set(order, lanes(|l| linear[l] - a[l]));
            }
            StepKind::Multiply => {
                let (of_a, of_b) = (self.row(a.higher)?, self.row(b.higher)?);
                let inner = if a.higher == b.higher {
                    of_a.square(order)
                } else {
                    of_a.convolution(of_b, order)
                };
                let newest = product(inner, self.ends(a)?, self.ends(b)?);
                self.row(row)?.set(order, newest);
            }
            StepKind::ScaleByLinear(linear) => {
                let (a, by) = (self.scaled(a)?, replay.linear_number(linear).value);
                self.row(row)?.set(order, lanes(|l| a[l] * by[l]));
            }
            StepKind::DivideByLinear(linear) => {
                let (a, by) = (self.scaled(a)?, replay.linear_number(linear).value);
                self.row(row)?.set(order, lanes(|l| a[l] * (1.0 / by[l])));
            }
            StepKind::Divide => {
                let into = self.row(row)?;
                let inner = self.row(b.higher)?.convolution(into, order);
                let newest = quotient(inner, self.scaled(a)?, self.ends(b)?, into.at(0));
                into.set(order, newest);
            }
            StepKind::Invert => {
                let into = self.row(row)?;
                let inner = self.row(b.higher)?.convolution(into, order);
                let newest = quotient(inner, [0.0; L], self.ends(b)?, into.at(0));
                into.set(order, newest);
            }
            StepKind::Exponential => {
                let (slopes, into) = (self.row(row - 1)?, self.row(row)?);
                let slope = lanes_of(self.scaled(a)?, |a| a * order as f64);
                slopes.set(order, slope);
                let (inner, e0) = (slopes.convolution(into, order), into.at(0));
                let newest = self.integral(lanes(|l| inner[l] + slope[l] * e0[l]));
                into.set(order, unless_overflowed(newest, e0));
            }
            StepKind::SineCosine => {
                let slope = replay.linear_number(a.higher).slope;
                let (sine, cosine) = (self.row(row)?, self.row(row + 1)?);
                let (s, c) = (sine.at(order - 1), cosine.at(order - 1));
                sine.set(order, self.integral(lanes(|l| slope[l] * c[l])));
                cosine.set(order, self.integral(lanes(|l| -slope[l] * s[l])));
            }
            StepKind::Ahead => {
                let (a, b) = (self.scaled(a)?, self.scaled(b)?);
                self.choose(lanes(|l| constant * (a[l] - b[l])));
            }
            StepKind::AheadOfConstant => {
                let a = self.scaled(a)?;
                self.choose(lanes_of(a, |a| constant * a));
            }
            StepKind::Any => {
                let taken = (row as usize, self.choices);
                self.choices =
                    replay.repeat_instruction(a.higher as usize, self.rows, order, taken);
            }
        }
        Some(())
    }
}

/// Whether the result of an instruction is used.
fn is_used(
    recorded: &RecordedInstruction,
    uses: &[Use],
    is_constant: &impl Fn(u32) -> bool,
) -> bool {
    let moves = |of: &Location| !matches!(of, Location::Linear(linear) if is_constant(*linear));
    match recorded.result {
        // The other checks concern the value alone, as one of two constants does.
        None => {
            let Instruction { operation, of, .. } = &recorded.instruction;
            matches!(operation, Operation::Exceeds | Operation::ExceedsNot) && of.iter().any(moves)
        }
        Some(Location::Linear(_)) => false,
        Some(Location::InRow(row)) => {
            let is_pair = recorded.instruction.operation == Operation::SineCosine;
            let mut rows = row as usize..=row as usize + usize::from(is_pair);
            rows.any(|row| uses[row] > Use::None)
        }
    }
}

/// Uses of each row.
fn uses(
    instructions: &[RecordedInstruction],
    (wanted, to): (impl Iterator<Item = Location>, Use),
    is_constant: &impl Fn(u32) -> bool,
    rows: usize,
) -> Vec<Use> {
    let mut uses = vec![Use::None; rows];
    for location in wanted {
        raise(&mut uses, location, to);
    }
    for recorded in instructions.iter().rev() {
        if !is_used(recorded, &uses, is_constant) {
            continue;
        }
        let Some((kind, of, _)) = step_kind(&recorded.instruction, is_constant) else {
            for location in recorded.instruction.of {
                raise(&mut uses, location, Use::Row);
            }
            continue;
        };
        let to = match kind {
            StepKind::Copy => {
                let of_copy = recorded.result.map_or(0, Location::number);
                [uses[of_copy as usize].min(Use::Coefficients); 2]
            }
            StepKind::Multiply | StepKind::Invert => [Use::Coefficients; 2],
            StepKind::Divide => [Use::Newest, Use::Coefficients],
            _ => [Use::Newest; 2],
        };
        for (row, to) in of.into_iter().zip(to) {
            raise(&mut uses, Location::InRow(row), to);
        }
    }
    uses
}

/// Raises the use of a row to at least this one.
fn raise(uses: &mut [Use], location: Location, to: Use) {
    if let Location::InRow(row) = location
        && uses[row as usize] < to
    {
        uses[row as usize] = to;
    }
}
