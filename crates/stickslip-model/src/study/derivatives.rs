//! Derivatives of an orbit by names of parameters and states.

use stickslip::analysis::{
    Differentiated, EventDerivatives, OrbitDerivatives, OrbitTangents, Variable,
};
use stickslip::dynamics::{
    DynamicsRef, Matrix, Moment, OrbitProgress, OrbitUnderWay, RecordedOrbit, Section, Vector,
};
use stickslip::{Error, Options};

use crate::file::{MOST_FREE, Meaning, SettingError, System, did_you_mean};

/// Name of the time of the start as a variable.
pub const START_TIME: &str = "t0";

/// Variables by which an orbit of a system is differentiated.
#[derive(Clone, Debug)]
pub struct Variables {
    /// Names as they were given.
    pub names: Vec<String>,
    parameters: Vec<usize>,
    by: Vec<Variable>,
}

/// A name that is no variable, or one too many.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoVariable(String);

/// Reason for which no derivatives could be computed.
#[derive(Debug, thiserror::Error)]
pub enum DerivativeError {
    /// The system cannot have these parameters as states.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The run cannot begin, or an orbit has no derivative.
    #[error(transparent)]
    Run(#[from] Error),
    /// The period of a drive is a number that may hide a parameter.
    #[error(
        "a driven orbit has derivatives where the system gives the period of its drive: add it, as \
         a formula of the parameters"
    )]
    NoPeriod,
    /// The drive has another period beside the present value of a parameter.
    #[error(
        "with `{name}` the drive changes its period, but the period that the system gives stays: \
         write it as a formula of `{name}`"
    )]
    OtherPeriod {
        /// Name of the parameter.
        name: String,
    },
}

impl NoVariable {
    pub(super) fn new(words: String) -> Self {
        NoVariable(words)
    }
}

impl Variables {
    /// The variables with these names: parameters, states (for their start values), and
    /// [`START_TIME`].
    ///
    /// # Errors
    /// [`NoVariable`] for the first name that is none of these.
    pub fn named<'n>(
        system: &System,
        names: impl IntoIterator<Item = &'n str>,
    ) -> Result<Self, NoVariable> {
        let mut variables = Variables {
            names: Vec::new(),
            parameters: Vec::new(),
            by: Vec::new(),
        };
        for name in names {
            let by = match system.file.names.get(name) {
                _ if name.is_empty() => {
                    return Err(NoVariable(
                        "a name is empty: name parameters, states or t0".to_owned(),
                    ));
                }
                _ if variables.names.iter().any(|known| known == name) => {
                    return Err(NoVariable(format!("`{name}` is given twice")));
                }
                Some(Meaning::Parameter(number)) => {
                    variables.parameters.push(number);
                    Variable::Start(system.states() + variables.parameters.len() - 1)
                }
                Some(Meaning::State(state)) if system.dynamics().is_discrete(state) => {
                    return Err(NoVariable(format!(
                        "`{name}` is a discrete state, by which there is no derivative"
                    )));
                }
                Some(Meaning::State(state)) => Variable::Start(state),
                None if name == START_TIME => Variable::StartTime,
                _ => return Err(Self::unknown(system, name)),
            };
            variables.names.push(name.to_owned());
            variables.by.push(by);
        }
        let count = variables.parameters.len();
        if count > MOST_FREE {
            return Err(NoVariable(format!(
                "{count} parameters are more than {MOST_FREE}; take some of them in a second run"
            )));
        }
        Ok(variables)
    }

    fn unknown(system: &System, name: &str) -> NoVariable {
        let parameters = system.file.parameters.iter().map(|one| one.name.as_str());
        let states = system.file.states.iter().map(|one| one.name.as_str());
        let all: Vec<&str> = parameters.chain(states).chain([START_TIME]).collect();
        let help = did_you_mean(name, all.iter().copied())
            .unwrap_or_else(|| format!("there are {}", all.join(", ")));
        NoVariable(format!(
            "`{name}` is neither a parameter nor a state: {help}"
        ))
    }

    /// Derivatives of the orbit from a time and state, of states at `times`, transitions and, if
    /// wanted, passages of the sections. Start values do not depend on parameters here. Rows are
    /// the states.
    ///
    /// # Errors
    /// [`DerivativeError`].
    pub fn along(
        &self,
        system: &System,
        ((t, x), t_end): ((f64, &[f64]), f64),
        (times, sections): (&[f64], &[Section]),
        options: &Options,
    ) -> Result<OrbitDerivatives, DerivativeError> {
        let varied = self.of(system)?;
        let x = Vector::from_column_slice(x);
        let start = Moment { t, x };
        let found = varied.forms.iter().map(|form| {
            let of = form.of(system);
            let found = of.derivatives(start.clone(), t_end, times, sections, options)?;
            Ok((found, &form.columns[..]))
        });
        let found = found.collect::<Result<Vec<_>, DerivativeError>>()?;
        Ok(joined(found))
    }

    /// A system with these variables, for derivatives beside its orbits.
    ///
    /// # Errors
    /// [`SettingError`] where the system cannot have these parameters as states.
    pub fn of<'s>(&self, system: &'s System) -> Result<VariedSystem<'s>, SettingError> {
        let room = match COMMON_ROOM.saturating_sub(system.states()) {
            0 => MOST_FREE,
            room => room,
        };
        let mut groups = self.parameters.chunks(room);
        let mut forms = Vec::new();
        let mut first = 0;
        loop {
            let group = groups.next().unwrap_or_default();
            let mut form = Form {
                extended: match group {
                    [] => DynamicsRef::Borrowed(&**system.dynamics()),
                    _ => system.with_states_of(group)?,
                },
                parameters: group.iter().map(|&number| system.values[number]).collect(),
                by: Vec::new(),
                columns: Vec::new(),
            };
            for (column, by) in self.by.iter().enumerate() {
                let by = match *by {
                    Variable::Start(state) if state >= system.states() => {
                        let number = state - system.states();
                        let own = (first..first + group.len()).contains(&number);
                        own.then(|| Variable::Start(state - first))
                    }
                    other => forms.is_empty().then_some(other),
                };
                form.columns.extend(by.map(|_| column));
                form.by.extend(by);
            }
            forms.push(form);
            first += group.len();
            if first == self.parameters.len() {
                return Ok(VariedSystem { system, forms });
            }
        }
    }
}

/// Most states, with parameters among them, for which the solver is compiled in a size that fits.
/// More parameters are states of several forms of a system.
const COMMON_ROOM: usize = 8;

/// A system, and forms of it with the variables of its derivatives as states.
pub struct VariedSystem<'s> {
    system: &'s System,
    forms: Vec<Form<'s>>,
}

/// A form of a system with some parameters as states.
struct Form<'s> {
    extended: DynamicsRef<'s>,
    parameters: Vec<f64>,
    by: Vec<Variable>,
    /// Places of these variables among all.
    columns: Vec<usize>,
}

impl Form<'_> {
    fn of<'a>(&'a self, system: &'a System) -> Differentiated<'a> {
        let with = (&*self.extended, &self.parameters[..]);
        Differentiated::with_parameters(&**system.dynamics(), with, &self.by)
    }
}

impl VariedSystem<'_> {
    /// Tangent vectors beside an orbit of the system, which watches these sections and has taken no
    /// step.
    ///
    /// # Errors
    /// As [`OrbitTangents::new`].
    pub fn tangents<'a>(
        &'a self,
        at_start: (&dyn OrbitUnderWay, &Moment),
        sections: &'a [Section],
        options: &Options,
    ) -> Result<VariedTangents<'a>, Error> {
        let parts = self.forms.iter().map(|form| {
            let of = form.of(self.system);
            let tangents = OrbitTangents::new(of, at_start, sections, options)?;
            Ok((tangents, &form.columns[..]))
        });
        let parts = parts.collect::<Result<_, Error>>()?;
        Ok(VariedTangents { parts })
    }
}

/// Tangent vectors for all variables beside one orbit: [`OrbitTangents`] of each form.
pub struct VariedTangents<'a> {
    parts: Vec<(OrbitTangents<'a>, &'a [usize])>,
}

impl VariedTangents<'_> {
    /// [`OrbitTangents::step`] of all parts, at the points of a record without derivatives.
    pub fn step(&mut self, record: &RecordedOrbit, orbit: &mut dyn OrbitUnderWay) {
        let step = orbit.last_step();
        for (tangents, _) in &mut self.parts {
            let points = record.points_from(tangents.recorded());
            let times: Vec<f64> = points.map(|(t, _)| t).collect();
            tangents.step(&step, &times, orbit);
        }
    }

    /// [`OrbitTangents::event`] of all parts.
    pub fn event(&mut self, progress: &OrbitProgress) {
        for (tangents, _) in &mut self.parts {
            tangents.event(progress);
        }
    }

    /// [`OrbitTangents::finish`] of all parts.
    pub fn finish<T>(self, record: &RecordedOrbit, ended: &Result<T, Error>) -> OrbitDerivatives {
        let parts = self.parts.into_iter();
        joined(
            parts
                .map(|(tangents, columns)| (tangents.finish(record, ended), columns))
                .collect(),
        )
    }
}

/// Derivatives along one orbit by all variables, from those by the variables at some places. What
/// one part has lost is lost.
fn joined(mut parts: Vec<(OrbitDerivatives, &[usize])>) -> OrbitDerivatives {
    if let [_] = parts[..]
        && let Some((found, _)) = parts.pop()
    {
        return found;
    }
    let count = parts.iter().map(|(_, columns)| columns.len()).sum();
    let matrix = |of: &dyn Fn(&OrbitDerivatives) -> Matrix| {
        let each = parts.iter().map(|(found, columns)| (of(found), columns));
        let each: Vec<(Matrix, &&[usize])> = each.collect();
        let rows = each.first().map_or(0, |(part, _)| part.nrows());
        let mut all = Matrix::zeros(rows, count);
        for (part, columns) in &each {
            if !part.is_empty() && part.iter().all(|slope| slope.is_nan()) {
                return Matrix::repeat(rows, count, f64::NAN);
            }
            for (k, &column) in columns.iter().enumerate() {
                all.set_column(column, &part.column(k));
            }
        }
        all
    };
    let event = |own: &EventDerivatives, of: &dyn Fn(&OrbitDerivatives) -> &EventDerivatives| {
        let times = matrix(&|found| Matrix::from_row_slice(1, of(found).t.len(), &of(found).t));
        EventDerivatives {
            at: own.at,
            points: own.points.clone(),
            t: times.iter().copied().collect(),
            before: matrix(&|found| of(found).before.clone()),
            after: matrix(&|found| of(found).after.clone()),
        }
    };
    let Some((first, _)) = parts.first() else {
        return OrbitDerivatives::default();
    };
    let states = (0..first.states.len()).map(|k| matrix(&|found| found.states[k].clone()));
    let transitions = first.transitions.iter().enumerate();
    let transitions = transitions.map(|(k, own)| event(own, &|found| &found.transitions[k]));
    let passages = first.passages.iter().enumerate();
    let passages = passages.map(|(k, (number, own))| {
        let of = event(own, &|found| &found.passages[k].1);
        (*number, of)
    });
    let mut lost = parts.iter().filter_map(|(found, _)| found.lost.as_ref());
    OrbitDerivatives {
        states: states.collect(),
        transitions: transitions.collect(),
        passages: passages.collect(),
        points: first.points.clone(),
        phases: first.phases.clone(),
        lost: lost.next().cloned(),
    }
}
