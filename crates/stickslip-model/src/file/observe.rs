//! Formulas of what is measured, and names that only these have.

use stickslip::dynamics::Modes;
use stickslip::scalar::Dual;
use stickslip::{Mode, Scalar, Side};

use super::build;
use super::builder::Freed;
use super::formulas::FormulaKey;
use super::names::Meaning;
use super::problem::Problem;
use super::{FileError, Formula, Parameter, Source, System, SystemFile};
use crate::expression::Tape;
use crate::kernel::{HELD_PER_INPUT, Switching};

/// A formula of time, states, inputs and parameters, some of which are variables. In a system of
/// one contact it may have the friction force of that contact.
#[derive(Clone, Debug)]
pub struct Observed {
    /// One tape, or one in each of the modes [`MODES`].
    tapes: Vec<Tape>,
    switching: Switching,
}

/// The modes of one contact.
const MODES: [Mode; 3] = [
    Mode::Slip(Side::Below),
    Mode::Slip(Side::Above),
    Mode::Stick,
];

impl Observed {
    /// Whether it depends on the mode: it has the friction force of the contact.
    pub fn has_force(&self) -> bool {
        self.tapes.len() > 1
    }

    /// The value at a time in a mode of the contacts, from the states and the parameters that are
    /// variables behind them. An input has the value that it has from that time on.
    pub fn value<T: Scalar>(&self, modes: Modes, t: f64, x: &[T]) -> T {
        let mut out = [T::zero()];
        let x = self.switching.extended(t, x);
        let number = match self.tapes.len() {
            1 => Some(0),
            _ => MODES.iter().position(|mode| *mode == modes.get(0)),
        };
        if let Some(tape) = number.and_then(|number| self.tapes.get(number)) {
            tape.evaluate(T::constant(t), &x, &mut out);
        }
        out[0]
    }
}

impl SystemFile {
    /// The file with further parameters, as for formulas of what is measured.
    ///
    /// # Errors
    /// [`FileError::Wrong`] for a name that is taken, or none.
    pub fn with_parameters(&self, further: &[(&str, f64)]) -> Result<SystemFile, FileError> {
        let mut file = self.clone();
        for &(name, value) in further {
            let meaning = Meaning::Parameter(file.parameters.len());
            let name = file.names.add(name, 0..0, meaning).map_err(|problem| {
                let source = Source {
                    name: "extra parameter".to_owned(),
                    text: name.to_owned(),
                };
                FileError::wrong(problem, source)
            })?;
            file.parameters.push(Parameter {
                name,
                value,
                unit: String::new(),
                meaning: None,
                range: None,
                place: 0..0,
            });
        }
        Ok(file)
    }
}

impl System {
    /// A formula of time, states, inputs and parameters, of which `variables` are variables.
    ///
    /// # Errors
    /// [`FileError::Wrong`] with the fault of the formula.
    pub fn observed(&self, text: &str, variables: &[usize]) -> Result<Observed, FileError> {
        let source = Source {
            name: "observable".to_owned(),
            text: text.to_owned(),
        };
        let free = Freed::of(variables);
        let made = Formula::parsed(text, 0..text.len(), &source).and_then(|formula| {
            let is_friction = |meaning| matches!(meaning, Meaning::Friction(_));
            let has_force = build::has_name(&self.file, &formula.tree, &is_friction);
            match has_force && self.contacts() == 1 {
                true => MODES
                    .iter()
                    .map(|mode| self.observed_in(*mode, free, &formula))
                    .collect(),
                false => Ok(vec![self.observed_tape(free, &formula)?]),
            }
        });
        let tapes = made.map_err(|problem| FileError::wrong(problem, source))?;
        let switching = self.switching_with(free)?;
        Ok(Observed { tapes, switching })
    }

    /// The tape of [`System::observed_tape`] in a mode of the only contact, whose friction force
    /// may stand in the formula.
    fn observed_in(&self, mode: Mode, free: Freed, formula: &Formula) -> Result<Tape, Problem> {
        let build = || build::formula_in_mode(&self.file, &self.values, free, (formula, mode));
        let key = FormulaKey::ObservedInMode(formula.text.clone(), Box::new(free), mode);
        self.formula_tape(key, build)
    }

    /// The tape of a formula of time, states and inputs; the free parameters are states behind.
    fn observed_tape(&self, free: Freed, formula: &Formula) -> Result<Tape, Problem> {
        let build = || build::formula(&self.file, &self.values, free, formula);
        self.formula_tape(
            FormulaKey::Observed(formula.text.clone(), Box::new(free)),
            build,
        )
    }

    /// The start time and the start of each state as formulas of the parameters `variables`, where
    /// the file has them. The parameters stand behind the states.
    ///
    /// # Errors
    /// [`FileError::Wrong`] with the fault of a formula.
    pub fn free_starts(&self, variables: &[usize]) -> Result<FreeStarts, FileError> {
        let free = Freed::of(variables);
        let tape = |formula: &Formula| self.observed_tape(free, formula);
        let wrong = |problem| FileError::wrong(problem, self.file.source.clone());
        let states = self.file.states.iter().map(|state| &state.start);
        let states = states.map(|start| start.as_ref().map(tape).transpose());
        Ok(FreeStarts {
            states: states.collect::<Result<_, _>>().map_err(wrong)?,
            time: self
                .file
                .time
                .start
                .as_ref()
                .map(tape)
                .transpose()
                .map_err(wrong)?,
        })
    }

    /// A formula of the parameters `variables` alone, such as one of [`System::free_starts`], at
    /// their `values`, with its derivative by the parameter `by`.
    pub fn of_parameters(
        &self,
        tape: &Tape,
        (variables, values): (&[usize], &[f64]),
        by: Option<usize>,
    ) -> Dual<f64> {
        let mut all = vec![Dual::constant(0.0); self.states()];
        all.extend(variables.iter().zip(values).map(|(variable, value)| {
            let slope = if by == Some(*variable) { 1.0 } else { 0.0 };
            Dual::new(*value, slope)
        }));
        // Such formulas have no inputs, but tapes have room for them.
        let room = HELD_PER_INPUT * self.file.inputs.len();
        all.resize(all.len() + room, Dual::constant(0.0));
        let mut out = [Dual::constant(0.0)];
        tape.evaluate(Dual::constant(0.0), &all, &mut out);
        out[0]
    }

    /// Times that the tables of measured inputs cover; none without tables.
    pub fn covered(&self) -> Option<(f64, f64)> {
        let tables = self
            .file
            .inputs
            .iter()
            .filter_map(|input| match &input.shape {
                super::InputShape::Table { pieces, .. } => Some(pieces),
                _ => None,
            });
        tables
            .map(|pieces| {
                let times = pieces.iter().map(|piece| piece.from);
                let times = times.filter(|from| from.is_finite());
                times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| {
                    (low.min(t), high.max(t))
                })
            })
            .reduce(|one, other| (one.0.max(other.0), one.1.min(other.1)))
    }
}

/// Formulas of starts, as [`System::free_starts`] makes them.
#[derive(Clone, Debug)]
pub struct FreeStarts {
    /// Formula of each state's start.
    pub states: Vec<Option<Tape>>,
    /// Formula of the start's time.
    pub time: Option<Tape>,
}
