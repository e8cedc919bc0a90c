//! Derivatives of an orbit by names of parameters and states.

use stickslip::analysis::{
    Differentiated, EventDerivatives, OrbitDerivatives, Variable, orbit_derivatives_of,
};
use stickslip::dynamics::{DynamicsRef, Matrix, Moment, Section, Vector};
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
        let extended = match self.parameters[..] {
            [] => DynamicsRef::Borrowed(&**system.dynamics()),
            _ => system.with_states_of(&self.parameters)?,
        };
        let values = self.parameters.iter().map(|&number| system.values[number]);
        let values: Vec<f64> = values.collect();
        let with = (&*extended, &values[..]);
        let of = Differentiated::with_parameters(&**system.dynamics(), with, &self.by);
        let x = Vector::from_column_slice(x);
        let start = Moment { t, x };
        let mut found = orbit_derivatives_of(of, start, t_end, times, sections, options)?;
        let states = |of: &mut Matrix| *of = of.rows(0, system.states()).into_owned();
        found.states.iter_mut().for_each(states);
        let passages = found.passages.iter_mut().map(|(_, event)| event);
        for event in found.transitions.iter_mut().chain(passages) {
            states(&mut event.before);
            states(&mut event.after);
            let point = |of: &mut Vector| *of = of.rows(0, system.states()).into_owned();
            event.points.iter_mut().for_each(point);
        }
        Ok(found)
    }

    /// Fits derivatives to the transitions of the run itself, at these times. The run with
    /// parameters as states takes the same steps, but its rounding may decide otherwise; then
    /// nothing is known from there on.
    pub fn fit(
        &self,
        system: &System,
        found: &mut OrbitDerivatives,
        times: impl ExactSizeIterator<Item = f64>,
    ) {
        // Chosen far above the error of a located event, and far below the time between two.
        const SAME_TIME: f64 = 1e-7;
        let count = times.len();
        let none = Matrix::repeat(system.states(), self.names.len(), f64::NAN);
        for (k, t) in times.enumerate() {
            let is_same =
                |own: &EventDerivatives| (own.at - t).abs() <= SAME_TIME * t.abs().max(1.0);
            if found.transitions.get(k).is_some_and(is_same) {
                continue;
            }
            // Where several contacts change at one instant, each has a row.
            let last = k
                .checked_sub(1)
                .and_then(|last| found.transitions.get(last));
            if let Some(same) = last.filter(|last| is_same(last)).cloned() {
                let before = same.after.clone();
                found
                    .transitions
                    .insert(k, EventDerivatives { before, ..same });
                continue;
            }
            let nothing = EventDerivatives {
                at: t,
                t: vec![f64::NAN; self.names.len()],
                points: [(); 2].map(|()| Vector::repeat(system.states(), f64::NAN)),
                before: none.clone(),
                after: none.clone(),
            };
            found.transitions.truncate(k);
            found.transitions.resize(count, nothing);
            let what = "the same transition in the run with derivatives";
            found
                .lost
                .get_or_insert(Error::NotFound { what, t, span: 0.0 });
            return;
        }
        found.transitions.truncate(count);
    }
}
