//! Recording of interpreted functions: their operations, recorded once and repeated for every
//! order.
//!
//! A compiled function needs no recording: the compiler knows the kind and location of every number
//! in it. An interpreted function is looked up again at every call, which takes longer than its
//! arithmetic. So it is called once for many series, and its operations on numbers that are not
//! constant are recorded. Zeros, comparisons and dual numbers are resolved, and common
//! subexpressions are shared. Every order of every series repeats the recording until a comparison
//! changes its result. The call has one lane; several lanes repeat it together if their
//! comparisons agree.

use std::collections::BTreeMap;

use super::functions::Flat;
use super::jet::{Jet, LinearJet};
use super::row::{CoefficientRow, Lanes};
use super::sweep::{CoefficientRows, Sweep};
use crate::scalar::Scalar;

/// Place of a number: in a row, or among the linear numbers, which are linear in time or constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Location {
    InRow(u32),
    Linear(u32),
}

impl Location {
    pub(super) fn number(self) -> u32 {
        match self {
            Location::InRow(number) | Location::Linear(number) => number,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Operation {
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    AddConstant,
    SubtractConstant,
    MultiplyConstant,
    DivideByConstant,
    /// The cosine is in the row after the sine's.
    SineCosine,
    Tangent,
    ArcTangent,
    ErrorFunction,
    HyperbolicSine,
    HyperbolicCosine,
    HyperbolicTangent,
    Power,
    Root,
    Exponential,
    Logarithm,
    /// Conditions, which have no number as result: the first number exceeds the second, does not
    /// exceed it, is not zero, or lies where a function of it is not flat.
    Exceeds,
    ExceedsNot,
    IsNotZero,
    IsSteep(Flat),
}

/// An operation and its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Instruction {
    pub(super) operation: Operation,
    pub(super) of: [Location; 2],
    /// The bits of the constant operand.
    pub(super) constant: u64,
}

impl Instruction {
    pub(super) fn constant(&self) -> f64 {
        f64::from_bits(self.constant)
    }
}

/// An instruction, the first row that it takes, and the location of its result, if it has one.
#[derive(Clone, Copy, Debug)]
pub(super) struct RecordedInstruction {
    pub(super) instruction: Instruction,
    pub(super) first: u32,
    pub(super) result: Option<Location>,
    /// Whether the result is linear in state and time.
    is_linear: bool,
}

/// A number that is linear in time, or constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinearNumber<const L: usize> {
    pub(super) value: Lanes<L>,
    pub(super) slope: Lanes<L>,
    pub(super) is_constant: bool,
}

/// The recorded operations.
#[derive(Debug, Default)]
pub(super) struct Recording {
    pub(super) instructions: Vec<RecordedInstruction>,
    /// Index into `instructions` for every instruction that has a result.
    results: BTreeMap<Instruction, usize>,
    /// Time is the first entry, the held components of the state follow.
    pub(super) linear_numbers: Vec<LinearNumber<1>>,
    /// Indices of the linear numbers that are constants of the functions.
    constants: Vec<usize>,
    /// Number of held components.
    held: usize,
}

/// A recording as it is repeated in `L` lanes, with its linear numbers there.
#[derive(Clone, Copy)]
pub(super) struct Replay<'r, const L: usize> {
    pub(super) recording: &'r Recording,
    pub(super) linear_numbers: &'r [LinearNumber<L>],
}

impl Operation {
    /// The result; the sine for the pair of sine and cosine.
    #[inline(always)]
    pub(super) fn of<'a, const L: usize>(
        self,
        a: Jet<'a, L>,
        b: Jet<'a, L>,
        constant: f64,
    ) -> Jet<'a, L> {
        match self {
            Operation::Add => a + b,
            Operation::Subtract => a - b,
            Operation::Multiply => a * b,
            Operation::Divide => a / b,
            Operation::Negate => -a,
            Operation::AddConstant => a + constant,
            Operation::SubtractConstant => a - constant,
            Operation::MultiplyConstant => a * constant,
            Operation::DivideByConstant => a / constant,
            Operation::SineCosine => a.sin_cos().0,
            Operation::Tangent => a.tan(),
            Operation::ArcTangent => a.atan(),
            Operation::ErrorFunction => a.erf_unchecked(),
            Operation::HyperbolicSine => a.sinh_cosh_unchecked().0,
            Operation::HyperbolicCosine => a.sinh_cosh_unchecked().1,
            Operation::HyperbolicTangent => a.tanh_unchecked(),
            Operation::Power => a.powf(constant),
            Operation::Root => a.sqrt(),
            Operation::Exponential => a.exp_unchecked(),
            Operation::Logarithm => a.ln(),
            Operation::Exceeds | Operation::ExceedsNot => {
                a.choose(b, self == Operation::Exceeds);
                Jet::Zero
            }
            Operation::IsNotZero | Operation::IsSteep(_) => Jet::Zero,
        }
    }
}

impl<const L: usize> LinearNumber<L> {
    #[inline(always)]
    fn of(number: Jet<'_, L>) -> Self {
        let LinearJet {
            value,
            slope,
            sweep,
        } = number.as_linear();
        LinearNumber {
            value,
            slope,
            is_constant: sweep.is_none(),
        }
    }

    #[inline(always)]
    pub(super) fn coefficient(&self, k: usize) -> Lanes<L> {
        match k {
            0 => self.value,
            1 => self.slope,
            _ => [0.0; L],
        }
    }
}

impl Recording {
    /// Begins a recording; see [`super::recorded::Recorder::new`].
    pub(super) fn begin(time: Jet<'_, 1>) -> Self {
        Recording {
            linear_numbers: vec![LinearNumber::of(time)],
            ..Recording::default()
        }
    }

    /// The location of a further held component of the state: it is constant along a solution, and
    /// each repetition has its own. Before the first operation.
    pub(super) fn hold(&mut self, number: Jet<'_, 1>) -> Location {
        self.held += 1;
        Location::Linear(self.push(LinearNumber::of(number)) as u32)
    }

    /// The location of a constant, which is added to the linear numbers unless it is there already.
    pub(super) fn constant(&mut self, number: Jet<'_, 1>) -> Location {
        let linear = LinearNumber::of(number);
        let mut known = self.constants.iter().copied();
        let known = known.find(|&known| self.linear_numbers[known] == linear);
        let location = known.unwrap_or_else(|| {
            self.constants.push(self.linear_numbers.len());
            self.push(linear)
        });
        Location::Linear(location as u32)
    }

    fn push(&mut self, linear: LinearNumber<1>) -> usize {
        self.linear_numbers.push(linear);
        self.linear_numbers.len() - 1
    }

    /// Performs an operation and records it; returns its result and the location of that, unless it
    /// is constant. A constant that follows from held numbers has a location, too. The result of an
    /// operation recorded before is reused.
    pub(super) fn record<'a>(
        &mut self,
        instruction: Instruction,
        ([a, b], of_held): ([Jet<'a, 1>; 2], bool),
        sweep: &'a Sweep<'a, 1>,
    ) -> (Jet<'a, 1>, Option<Location>) {
        if let Some(&known) = self.results.get(&instruction)
            && let RecordedInstruction {
                result: Some(location),
                is_linear,
                ..
            } = self.instructions[known]
        {
            let number = number_at(location, &self.linear_numbers, sweep).with_linearity(is_linear);
            return (number, Some(location));
        }
        let first = sweep.next_row();
        let number = instruction.operation.of(a, b, instruction.constant());
        let location = match number {
            Jet::Series(series) => Location::InRow(series.row as u32),
            Jet::Linear(LinearJet { sweep: Some(_), .. }) => {
                Location::Linear(self.push(LinearNumber::of(number)) as u32)
            }
            Jet::Linear(_) if of_held => {
                Location::Linear(self.push(LinearNumber::of(number)) as u32)
            }
            Jet::Zero | Jet::One | Jet::Linear(_) => return (number, None),
        };
        // A result that is one of the operands is not a new number.
        let is_new = !matches!(number, Jet::Series(series) if series.row < first);
        if is_new {
            number.store();
            self.results.insert(instruction, self.instructions.len());
            self.instructions.push(RecordedInstruction {
                instruction,
                first: first as u32,
                result: Some(location),
                is_linear: number.is_linear(),
            });
        }
        (number, Some(location))
    }

    /// Records the result of a comparison and the number of rows used before it.
    pub(super) fn check(&mut self, instruction: Instruction, rows: usize) {
        self.instructions.push(RecordedInstruction {
            instruction,
            first: rows as u32,
            result: None,
            is_linear: false,
        });
    }

    /// Number of conditions.
    pub(super) fn checks(&self) -> usize {
        let conditions = self.instructions.iter();
        conditions.filter(|one| one.result.is_none()).count()
    }

    /// Largest number of states, or of sines of them, that are multiplied in a number; `None` if it
    /// is not made by sums, products, sines and cosines alone.
    pub(super) fn factors(&self, of: Location) -> Option<u32> {
        let mut known = std::collections::BTreeMap::new();
        for one in &self.instructions {
            let Some(result) = one.result else { continue };
            let of = |of: &Location| known.get(of).copied().unwrap_or(Some(1_u32));
            let [a, b] = one.instruction.of.each_ref().map(of);
            let factors = match one.instruction.operation {
                Operation::Add | Operation::Subtract => a.zip(b).map(|(a, b)| a.max(b)),
                Operation::Multiply => a.zip(b).map(|(a, b)| a.saturating_add(b)),
                Operation::Negate
                | Operation::AddConstant
                | Operation::SubtractConstant
                | Operation::MultiplyConstant
                | Operation::DivideByConstant => a,
                Operation::SineCosine => {
                    if let Location::InRow(row) = result {
                        known.insert(Location::InRow(row + 1), a);
                    }
                    a
                }
                _ => None,
            };
            known.insert(result, factors);
        }
        known.get(&of).copied().unwrap_or(Some(1))
    }

    /// The linear numbers in `L` lanes. Constants are set; [`Recording::repeat_first`] computes the
    /// others.
    pub(super) fn spread<const L: usize>(&self, linear_numbers: &mut Vec<LinearNumber<L>>) {
        linear_numbers.clear();
        linear_numbers.extend(self.linear_numbers.iter().map(|linear| LinearNumber {
            value: [linear.value[0]; L],
            slope: [linear.slope[0]; L],
            is_constant: linear.is_constant,
        }));
    }

    /// Repeats order 0 at another time and state, whose last components are held. Returns whether
    /// all comparisons gave the recorded results. Not inlined: all operations are in it.
    #[inline(never)]
    pub(super) fn repeat_first<'a, const L: usize>(
        &self,
        linear_numbers: &mut [LinearNumber<L>],
        (time, x): (Jet<'_, L>, &[Lanes<L>]),
        sweep: &'a Sweep<'a, L>,
    ) -> bool {
        linear_numbers[0] = LinearNumber::of(time);
        let held = &x[x.len() - self.held..];
        for (linear, &value) in linear_numbers[1..].iter_mut().zip(held) {
            linear.value = value;
        }
        for recorded in &self.instructions {
            let RecordedInstruction {
                instruction,
                first,
                result,
                ..
            } = *recorded;
            let [a, b] = instruction
                .of
                .map(|location| number_at(location, linear_numbers, sweep));
            sweep.rows_taken.set(first as usize);
            let agrees = match instruction.operation {
                Operation::Exceeds => a.exceeds(b),
                Operation::ExceedsNot => !a.exceeds(b),
                Operation::IsNotZero => !a.is_zero(),
                Operation::IsSteep(flat) => a.bound_before(flat).is_none(),
                _ => {
                    let number = instruction.operation.of(a, b, instruction.constant());
                    number.store();
                    if let Some(Location::Linear(linear)) = result {
                        linear_numbers[linear as usize] = LinearNumber::of(number);
                    }
                    true
                }
            };
            if !agrees {
                return false;
            }
        }
        true
    }

    /// Repetition in one lane, with the recording's own linear numbers.
    pub(super) fn repeat_first_alone<'a>(
        &mut self,
        at: (Jet<'_, 1>, &[Lanes<1>]),
        sweep: &'a Sweep<'a, 1>,
    ) -> bool {
        let mut linear_numbers = std::mem::take(&mut self.linear_numbers);
        let agrees = self.repeat_first(&mut linear_numbers, at, sweep);
        self.linear_numbers = linear_numbers;
        agrees
    }

    /// The recording as one lane repeats it.
    pub(super) fn alone(&self) -> Replay<'_, 1> {
        Replay {
            recording: self,
            linear_numbers: &self.linear_numbers,
        }
    }
}

/// The number at a location, for a sweep that has computed it.
#[inline(always)]
fn number_at<'a, const L: usize>(
    location: Location,
    linear_numbers: &[LinearNumber<L>],
    sweep: &'a Sweep<'a, L>,
) -> Jet<'a, L> {
    match location {
        Location::InRow(row) => sweep.stored_number(row as usize),
        Location::Linear(linear) => {
            let LinearNumber {
                value,
                slope,
                is_constant,
            } = linear_numbers[linear as usize];
            let sweep = (!is_constant).then_some(sweep);
            Jet::Linear(LinearJet {
                value,
                slope,
                sweep,
            })
        }
    }
}

impl<const L: usize> Replay<'_, L> {
    /// The number at a location, for a sweep that has computed it.
    #[inline(always)]
    pub(super) fn number<'a>(&self, location: Location, sweep: &'a Sweep<'a, L>) -> Jet<'a, L> {
        number_at(location, self.linear_numbers, sweep)
    }

    /// Coefficient `k` of the number at a location, if it is computed.
    #[inline(always)]
    pub(super) fn coefficient(
        &self,
        location: Location,
        k: usize,
        rows: &[CoefficientRow<L>],
    ) -> Lanes<L> {
        match location {
            Location::InRow(row) => rows
                .get(row as usize)
                .map_or([f64::NAN; L], |row| row.at(k)),
            Location::Linear(linear) => self.linear_numbers[linear as usize].coefficient(k),
        }
    }

    /// The linear number with an index.
    #[inline(always)]
    pub(super) fn linear_number(&self, number: u32) -> &LinearNumber<L> {
        &self.linear_numbers[number as usize]
    }

    /// Repeats one instruction at an order above 0. So many rows and comparisons come before it.
    /// Returns the number of comparisons up to its end.
    #[inline(never)]
    pub(super) fn repeat_instruction(
        &self,
        instruction: usize,
        rows: CoefficientRows<'_, L>,
        order: usize,
        (taken, choices): (usize, usize),
    ) -> usize {
        let sweep = Sweep::new(rows, order);
        sweep.rows_taken.set(taken);
        sweep.choices.set(choices);
        let instruction = self.recording.instructions[instruction].instruction;
        let [a, b] = instruction.of.map(|location| self.number(location, &sweep));
        instruction
            .operation
            .of(a, b, instruction.constant())
            .store();
        sweep.choices.get()
    }
}
