//! Recording of interpreted functions: their operations, recorded once and repeated for every
//! order.
//!
//! A compiled function needs no recording: the compiler knows the kind and place of every number in
//! it. An interpreted function is looked up again at every call, which takes longer than its
//! arithmetic. So it is called once for many series, and its operations on numbers that are not
//! constant are recorded. Zeros, comparisons and dual numbers are resolved, and common
//! subexpressions are shared. Every order of every series repeats the recording until a comparison
//! changes its result. The call has one lane; several lanes repeat it together if their
//! comparisons agree.

use std::collections::BTreeMap;

use super::functions::Flat;
use super::jet::{Jet, Straight};
use super::pass::{Pass, Rows};
use super::recorded::Recorded;
use super::row::{Lanes, Row};
use super::steps::Steps;
use crate::scalar::Scalar;

/// Where a number is: in a row, or among the lines, which are linear in time or constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Place {
    Row(u32),
    Line(u32),
}

impl Place {
    pub(super) fn number(self) -> u32 {
        match self {
            Place::Row(number) | Place::Line(number) => number,
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
    HyperbolicSine,
    HyperbolicCosine,
    HyperbolicTangent,
    Power,
    Root,
    Exponential,
    Logarithm,
    /// These have no number as result. They check that the first number exceeds the second, that it
    /// does not, that it is not zero, and that a function of it is not flat there.
    Exceeds,
    ExceedsNot,
    IsNotZero,
    IsSteep(Flat),
}

/// An operation and its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Call {
    pub(super) operation: Operation,
    pub(super) of: [Place; 2],
    /// The bits of the constant operand.
    constant: u64,
}

impl Call {
    pub(super) fn constant(&self) -> f64 {
        f64::from_bits(self.constant)
    }
}

/// A call, the first row that it takes, and the place of its result, if it has one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Made {
    pub(super) call: Call,
    pub(super) first: u32,
    pub(super) result: Option<Place>,
    /// Whether the result is linear in state and time.
    is_linear: bool,
}

/// A number that is linear in time, or constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line<const L: usize> {
    pub(super) value: Lanes<L>,
    pub(super) slope: Lanes<L>,
    pub(super) is_constant: bool,
}

/// The recorded operations.
#[derive(Debug, Default)]
pub(crate) struct Recording {
    calls: Vec<Made>,
    /// Index into `calls` for every call that has a result.
    known: BTreeMap<Call, usize>,
    /// Time is the first entry.
    lines: Vec<Line<1>>,
    /// Steps for the orders above 0.
    steps: Steps,
    is_complete: bool,
}

/// A recording as it is repeated in `L` lanes, with its lines there.
#[derive(Clone, Copy)]
pub(super) struct Replay<'r, const L: usize> {
    pub(super) recording: &'r Recording,
    pub(super) lines: &'r [Line<L>],
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
            Operation::HyperbolicSine => a.sinh_cosh_alone().0,
            Operation::HyperbolicCosine => a.sinh_cosh_alone().1,
            Operation::HyperbolicTangent => a.tanh_alone(),
            Operation::Power => a.powf(constant),
            Operation::Root => a.sqrt(),
            Operation::Exponential => a.exp_alone(),
            Operation::Logarithm => a.ln(),
            Operation::Exceeds | Operation::ExceedsNot => {
                a.choose(b, self == Operation::Exceeds);
                Jet::Zero
            }
            Operation::IsNotZero | Operation::IsSteep(_) => Jet::Zero,
        }
    }
}

impl<const L: usize> Line<L> {
    #[inline(always)]
    fn of(number: Jet<'_, L>) -> Self {
        let Straight { value, slope, pass } = number.line();
        Line {
            value,
            slope,
            is_constant: pass.is_none(),
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
    /// Begins a recording. Time is the first line, and the state's components have the first rows.
    pub(super) fn begin(time: Jet<'_, 1>) -> Self {
        Recording {
            lines: vec![Line::of(time)],
            ..Recording::default()
        }
    }

    /// Whether the recording can be repeated.
    pub(super) fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// The place of a number. A constant is added to the lines unless it is there already.
    pub(super) fn place(&mut self, number: Recorded<'_>) -> Place {
        if let Some(place) = number.place() {
            return place;
        }
        let line = Line::of(number.number);
        let known = self.lines.iter().position(|known| *known == line);
        let place = known.unwrap_or_else(|| self.push(line));
        Place::Line(place as u32)
    }

    fn push(&mut self, line: Line<1>) -> usize {
        self.lines.push(line);
        self.lines.len() - 1
    }

    /// Performs an operation and records it. The result of an operation recorded before is reused.
    pub(super) fn record<'a>(
        &mut self,
        operation: Operation,
        [a, b]: [Recorded<'a>; 2],
        constant: f64,
        pass: &'a Pass<'a, 1>,
    ) -> Recorded<'a> {
        let of = [self.place(a), self.place(b)];
        let bits = constant.to_bits();
        let call = Call {
            operation,
            of,
            constant: bits,
        };
        if let Some(&known) = self.known.get(&call)
            && let Made {
                result: Some(place),
                is_linear,
                ..
            } = self.calls[known]
        {
            let number = number_at(place, &self.lines, pass).linear(is_linear);
            return Recorded::at(place, number, pass);
        }
        let first = pass.next();
        let number = operation.of(a.number, b.number, constant);
        let place = match number {
            Jet::Series(series) => Place::Row(series.row as u32),
            Jet::Line(Straight { pass: Some(_), .. }) => {
                Place::Line(self.push(Line::of(number)) as u32)
            }
            Jet::Zero | Jet::One | Jet::Line(_) => return Recorded::constant_of(number),
        };
        // A result that is one of the operands is not a new number.
        let is_new = !matches!(number, Jet::Series(series) if series.row < first);
        if is_new {
            number.keep();
            self.known.insert(call, self.calls.len());
            self.calls.push(Made {
                call,
                first: first as u32,
                result: Some(place),
                is_linear: number.is_linear(),
            });
        }
        Recorded::at(place, number, pass)
    }

    /// Records the result of a comparison.
    pub(super) fn check(
        &mut self,
        operation: Operation,
        of: [Recorded<'_>; 2],
        pass: &Pass<'_, 1>,
    ) {
        let of = of.map(|number| self.place(number));
        let call = Call {
            operation,
            of,
            constant: 0,
        };
        self.calls.push(Made {
            call,
            first: pass.next() as u32,
            result: None,
            is_linear: false,
        });
    }

    /// Completes the recording; the numbers at the places `wanted` are needed.
    pub(super) fn end(&mut self, wanted: impl Iterator<Item = Place>, pass: &Pass<'_, 1>) {
        let is_constant = |line: u32| self.lines[line as usize].is_constant;
        self.steps
            .make(&self.calls, wanted, is_constant, pass.next());
        self.is_complete = !pass.value_read.get();
    }

    /// The lines in `L` lanes. Constants are set; [`Recording::repeat_first`] computes the others.
    pub(super) fn spread<const L: usize>(&self, lines: &mut Vec<Line<L>>) {
        lines.clear();
        lines.extend(self.lines.iter().map(|line| Line {
            value: [line.value[0]; L],
            slope: [line.slope[0]; L],
            is_constant: line.is_constant,
        }));
    }

    /// Repeats order 0 at another time and state. Returns whether all comparisons gave the recorded
    /// results. Not inlined: all operations are in it.
    #[inline(never)]
    pub(super) fn repeat_first<'a, const L: usize>(
        &self,
        lines: &mut [Line<L>],
        time: Jet<'_, L>,
        pass: &'a Pass<'a, L>,
    ) -> bool {
        lines[0] = Line::of(time);
        for made in &self.calls {
            let Made {
                call,
                first,
                result,
                ..
            } = *made;
            let [a, b] = call.of.map(|place| number_at(place, lines, pass));
            pass.taken.set(first as usize);
            let is_alike = match call.operation {
                Operation::Exceeds => a.exceeds(b),
                Operation::ExceedsNot => !a.exceeds(b),
                Operation::IsNotZero => !a.is_zero(),
                Operation::IsSteep(flat) => a.bound_before(flat).is_none(),
                _ => {
                    let number = call.operation.of(a, b, call.constant());
                    number.keep();
                    if let Some(Place::Line(line)) = result {
                        lines[line as usize] = Line::of(number);
                    }
                    true
                }
            };
            if !is_alike {
                return false;
            }
        }
        true
    }

    /// The same in one lane, with the recording's own lines.
    pub(super) fn repeat_first_alone<'a>(
        &mut self,
        time: Jet<'_, 1>,
        pass: &'a Pass<'a, 1>,
    ) -> bool {
        let mut lines = std::mem::take(&mut self.lines);
        let is_alike = self.repeat_first(&mut lines, time, pass);
        self.lines = lines;
        is_alike
    }

    /// The recording as one lane repeats it.
    pub(super) fn alone(&self) -> Replay<'_, 1> {
        Replay {
            recording: self,
            lines: &self.lines,
        }
    }
}

/// The number at a place, for a pass that has computed it.
#[inline(always)]
fn number_at<'a, const L: usize>(
    place: Place,
    lines: &[Line<L>],
    pass: &'a Pass<'a, L>,
) -> Jet<'a, L> {
    match place {
        Place::Row(row) => pass.known(row as usize),
        Place::Line(line) => {
            let Line {
                value,
                slope,
                is_constant,
            } = lines[line as usize];
            let pass = (!is_constant).then_some(pass);
            Jet::Line(Straight { value, slope, pass })
        }
    }
}

impl<const L: usize> Replay<'_, L> {
    /// The number at a place, for a pass that has computed it.
    #[inline(always)]
    pub(super) fn number<'a>(&self, place: Place, pass: &'a Pass<'a, L>) -> Jet<'a, L> {
        number_at(place, self.lines, pass)
    }

    /// Coefficient `k` of the number at a place, if it is computed.
    #[inline(always)]
    pub(super) fn coefficient(&self, place: Place, k: usize, rows: &[Row<L>]) -> Lanes<L> {
        match place {
            Place::Row(row) => rows
                .get(row as usize)
                .map_or([f64::NAN; L], |row| row.at(k)),
            Place::Line(line) => self.lines[line as usize].coefficient(k),
        }
    }

    /// The line with an index.
    #[inline(always)]
    pub(super) fn line(&self, line: u32) -> &Line<L> {
        &self.lines[line as usize]
    }

    /// Repeats an order above 0.
    #[inline(always)]
    pub(super) fn repeat(&self, rows: Rows<'_, L>, order: usize) {
        self.recording.steps.repeat(self, rows, order);
    }

    /// Repeats one call at an order above 0. So many rows and comparisons come before it. Returns
    /// the number of comparisons up to its end.
    #[inline(never)]
    pub(super) fn repeat_call(
        &self,
        call: usize,
        rows: Rows<'_, L>,
        order: usize,
        (taken, choices): (usize, usize),
    ) -> usize {
        let pass = Pass::new(rows, order);
        pass.taken.set(taken);
        pass.choices.set(choices);
        let call = self.recording.calls[call].call;
        let [a, b] = call.of.map(|place| self.number(place, &pass));
        call.operation.of(a, b, call.constant()).keep();
        pass.choices.get()
    }
}
