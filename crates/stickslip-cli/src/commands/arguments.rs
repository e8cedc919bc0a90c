//! Arguments that several commands share.

use std::num::NonZeroUsize;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use stickslip::{AbsoluteTolerance, AtPileUp, AtRepelling, Method, Options};

use crate::failure::Failure;
use crate::render::{CommandOutput, OutputArguments, Report};
use stickslip_model::expression::normal;
use stickslip_model::file::{System, SystemFile, did_you_mean, number};

/// Parses the value of an option that is a count.
pub(super) fn count(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.parse();
    number.map_err(|_| "a whole number is expected, 1 at least".to_owned())
}

/// Parses the value of an option that is a seed of random numbers.
pub(super) fn seed(text: &str) -> Result<u64, String> {
    let number = text.parse();
    number.map_err(|_| "a whole number is expected, 0 at least".to_owned())
}

/// The system and the values of its parameters.
#[derive(Debug, Args)]
pub(super) struct SystemArguments {
    /// File of the system, or name of a shipped model
    #[arg(value_name = "FILE")]
    file: String,

    /// Set a parameter to a number or an expression of numbers; can be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
}

impl SystemArguments {
    pub(super) fn system(&self) -> Result<System, Failure> {
        let file = SystemFile::open(&self.file)?;
        let settings = self.set.iter().map(|setting| assignment("--set", setting));
        Ok(file.with(&settings.collect::<Result<Vec<_>, _>>()?)?)
    }

    /// Whether this parameter is set.
    pub(super) fn sets(&self, parameter: &str) -> bool {
        is_given(&self.set, parameter)
    }
}

/// Whether one of the texts `name=value` has this name.
fn is_given(texts: &[String], wanted: &str) -> bool {
    let mut given = texts.iter().filter_map(|text| text.split_once('='));
    given.any(|(name, _)| normal(name.trim()) == wanted)
}

/// Splits `name=value` into a name and a number.
pub(super) fn assignment(option: &str, text: &str) -> Result<(String, f64), Failure> {
    let Some((name, value)) = text.split_once('=') else {
        let example = if option == "--start" {
            "x=0.5"
        } else {
            "mu0=0.4"
        };
        return Err(Failure::Usage(format!(
            "{option} {text}: a name, `=` and a value are expected, as in {option} {example}"
        )));
    };
    let value = number(value).map_err(|message| {
        Failure::Usage(format!(
            "{option} {text}: the value is no number: {message}"
        ))
    })?;
    Ok((name.trim().to_owned(), value))
}

/// Shortest period of a drive with which the default times apply. 2000 units of time are 10 000
/// such periods.
const REFERENCE_PERIOD: f64 = 0.2;

/// Returns the given time, or else the default. For a drive of a shorter period than
/// [`REFERENCE_PERIOD`] the default is reduced in proportion.
pub(super) fn time_or(given: Option<f64>, default: f64, system: &System) -> f64 {
    let period = system.built.period.filter(|_| system.built.depends_on_time);
    let part = period.map_or(1.0, |period| (period / REFERENCE_PERIOD).min(1.0));
    given.unwrap_or(default * part)
}

/// Position of a name among the existing names.
pub(super) fn position<'a>(
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, Failure> {
    let plain = normal(name);
    let position = known.clone().position(|known| known == plain);
    position.ok_or_else(|| {
        let all: Vec<&str> = known.clone().collect();
        let help = did_you_mean(name, known)
            .unwrap_or_else(|| format!("the {what}s are {}", all.join(", ")));
        Failure::Usage(format!("there is no {what} `{name}`; {help}"))
    })
}

/// The start of an orbit.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub(super) struct StartArguments {
    /// Set the start value of a state; can be repeated
    #[arg(long, value_name = "STATE=VALUE")]
    start: Vec<String>,

    /// Time at the start; default as in the file, or 0
    #[arg(long, value_name = "TIME")]
    t_start: Option<f64>,
}

impl StartArguments {
    /// Whether nothing is given.
    pub(super) fn is_default(&self) -> bool {
        self.start.is_empty() && self.t_start.is_none()
    }

    /// Whether the start value of this state is given.
    pub(super) fn sets(&self, state: &str) -> bool {
        is_given(&self.start, state)
    }

    /// Start values that are given.
    pub(super) fn assignments(&self) -> Result<Vec<(String, f64)>, Failure> {
        let given = self.start.iter();
        given.map(|text| assignment("--start", text)).collect()
    }

    /// Start time, if it is given.
    pub(super) fn time(&self) -> Option<f64> {
        self.t_start
    }

    /// Start time and start state.
    pub(super) fn of(&self, system: &System) -> Result<(f64, Vec<f64>), Failure> {
        self.except(system, &[])
    }

    /// Start time and start state; the states `replaced` need no value.
    pub(super) fn except(
        &self,
        system: &System,
        replaced: &[usize],
    ) -> Result<(f64, Vec<f64>), Failure> {
        let names = || system.file.states.iter().map(|state| state.name.as_str());
        let mut given = system.built.starts.clone();
        for &state in replaced {
            given[state].get_or_insert(0.0);
        }
        let mut is_set = vec![false; given.len()];
        for text in &self.start {
            let (name, value) = assignment("--start", text)?;
            let number = position("state", &name, names())?;
            if std::mem::replace(&mut is_set[number], true) {
                return Err(Failure::Usage(format!(
                    "--start {text}: the state `{}` is set twice; set it once",
                    normal(&name)
                )));
            }
            given[number] = Some(value);
        }
        let start = names().zip(given).map(|(name, value)| {
            value.ok_or_else(|| {
                Failure::Usage(format!(
                    "the start has no value of `{name}`; add [start] to the file, or --start \
                        {name}=0"
                ))
            })
        });
        let t = self.t_start.unwrap_or(system.built.t_start);
        Ok((t, start.collect::<Result<_, _>>()?))
    }

    /// Start state of a computation that begins at time 0, such as the search for attractors. The
    /// computation replaces the values of the states `replaced`.
    pub(super) fn at_zero(&self, system: &System, replaced: &[usize]) -> Result<Vec<f64>, Failure> {
        match self.except(system, replaced)? {
            (t, _) if t != 0.0 && system.built.depends_on_time => Err(Failure::Usage(format!(
                "the start is at t = {t}, but attractors are computed from t = 0 on; give \
                    --t-start 0"
            ))),
            (_, start) => Ok(start),
        }
    }
}

/// The integration method.
#[derive(Clone, Copy, Debug, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum MethodName {
    /// Taylor series of the solution: the fastest for tolerances of 1e-9 and less
    #[default]
    Taylor,
    /// Dormand and Prince's Runge-Kutta method of order 8
    Dop853,
}

/// Choice where the future is not unique.
#[derive(Clone, Copy, Debug, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Repelling {
    /// End the run
    #[default]
    Stop,
    /// Go on below the boundary
    Below,
    /// Go on above the boundary
    Above,
}

/// Choice where transitions accumulate.
#[derive(Clone, Copy, Debug, Default, PartialEq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum PileUp {
    /// End the run
    #[default]
    Stop,
    /// Go on with all contacts that pile up in stick, where friction can hold them
    Rest,
}

impl PileUp {
    fn is_default(&self) -> bool {
        *self == PileUp::default()
    }
}

/// Parses a bound on a size. Infinity becomes the largest finite number: no state exceeds it, and a
/// manifest cannot hold infinity.
fn bound(text: &str) -> Result<f64, std::num::ParseFloatError> {
    let bound = text.parse()?;
    Ok(if bound == f64::INFINITY {
        f64::MAX
    } else {
        bound
    })
}

/// `--atol` in manifests: nothing, one number for all states, or the texts that are given.
mod absolute {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    enum Given {
        Nothing,
        All(f64),
        Each(Vec<String>),
    }

    pub(super) fn serialize<S: Serializer>(
        given: &[String],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let number = |text: &String| text.parse::<f64>().ok().filter(|value| value.is_finite());
        let given = match given {
            [] => Given::Nothing,
            [one] => number(one).map_or_else(|| Given::Each(vec![one.clone()]), Given::All),
            each => Given::Each(each.to_vec()),
        };
        given.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<String>, D::Error> {
        Ok(match Given::deserialize(deserializer)? {
            Given::Nothing => Vec::new(),
            Given::All(value) => vec![format!("{value:?}")],
            Given::Each(each) => each,
        })
    }
}

/// Options of the integration.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub(super) struct SolverArguments {
    /// Relative and absolute tolerance of each step, between 1e-15 and 0.1
    #[arg(long, value_name = "ERROR", default_value = "1e-12")]
    tol: f64,

    /// Absolute tolerance, for states near zero, of all states or of one; can be repeated; default
    /// as in the file, or as --tol
    #[arg(long, value_name = "[STATE=]ERROR")]
    #[serde(with = "absolute")]
    atol: Vec<String>,

    /// Integration method
    #[arg(long, value_enum, default_value_t)]
    method: MethodName,

    /// Longest step; default unbounded
    #[arg(long, value_name = "TIME")]
    longest_step: Option<f64>,

    /// Bound on the size of each state; an orbit beyond it has escaped
    #[arg(long, value_name = "BOUND", default_value = "1e6", value_parser = bound)]
    escape: f64,

    /// A run with more transitions than this ends with an error
    #[arg(long, value_name = "COUNT", default_value = "200000", value_parser = count)]
    most_events: NonZeroUsize,

    /// A run with more steps than this ends with an error
    #[arg(long, value_name = "COUNT", default_value = "10000000", value_parser = count)]
    most_steps: NonZeroUsize,

    /// Choice where both fields lead away from the boundary
    #[arg(long, value_enum, default_value_t)]
    at_repelling: Repelling,

    /// Choice where infinitely many transitions accumulate in finite time (Zeno)
    #[arg(long, value_enum, default_value_t)]
    #[serde(default, skip_serializing_if = "PileUp::is_default")]
    at_pile_up: PileUp,
}

impl SolverArguments {
    /// Absolute tolerances of the states of a system.
    fn absolute(&self, system: &System) -> Result<AbsoluteTolerance, Failure> {
        let names = || system.file.states.iter().map(|state| state.name.as_str());
        let (mut common, mut each) = (None, vec![None; system.states()]);
        for text in &self.atol {
            let (place, value, what) = match text.contains('=') {
                true => {
                    let (name, value) = assignment("--atol", text)?;
                    let state = position("state", &name, names())?;
                    (
                        &mut each[state],
                        value,
                        format!("the state `{}`", normal(&name)),
                    )
                }
                false => {
                    let value = number(text).map_err(|message| {
                        let form = "a number is expected, or a state, `=` and a number";
                        Failure::Usage(format!("--atol {text}: {form}: {message}"))
                    })?;
                    (&mut common, value, "that of all states".to_owned())
                }
            };
            if place.replace(value).is_some() {
                return Err(Failure::Usage(format!(
                    "--atol {text}: {what} is set twice; set it once"
                )));
            }
        }
        if let Some(common) = common {
            each.iter_mut().for_each(|one| *one = one.or(Some(common)));
            // One number for all is no list.
            if self.atol.len() == 1 {
                return Ok(common.into());
            }
        }
        Ok(system.absolute_tolerance(self.tol, &each)?)
    }

    /// Options of the solver for a system.
    pub(super) fn options(&self, system: &System) -> Result<Options, Failure> {
        let options = Options {
            atol: self.absolute(system)?,
            longest_step: self.longest_step.unwrap_or(f64::INFINITY),
            most_events: self.most_events.get() as u64,
            most_steps: self.most_steps.get() as u64,
            ..Options::tol(self.tol)
        };
        let options = options
            .escape(self.escape)
            .method(match self.method {
                MethodName::Taylor => Method::Taylor,
                MethodName::Dop853 => Method::Dop853,
            })
            .at_repelling(match self.at_repelling {
                Repelling::Stop => AtRepelling::Stop,
                Repelling::Below => AtRepelling::GoBelow,
                Repelling::Above => AtRepelling::GoAbove,
            })
            .at_pile_up(match self.at_pile_up {
                PileUp::Stop => AtPileUp::Stop,
                PileUp::Rest => AtPileUp::Rest,
            });
        options.check()?;
        Ok(options)
    }
}

/// Arguments of every command that follows orbits. They stand last, so that help lists the
/// command's own options first.
#[derive(Debug, Args)]
pub(super) struct RunArguments {
    #[command(flatten)]
    pub(super) system: SystemArguments,
    #[command(flatten)]
    pub(super) start: StartArguments,
    #[command(flatten)]
    pub(super) solver: SolverArguments,
    #[command(flatten)]
    pub(super) output: OutputArguments,
}

/// A system, the start of its orbit, and the options of the solver.
pub(super) struct PreparedRun {
    pub(super) system: System,
    pub(super) options: Options,
    pub(super) t: f64,
    pub(super) x: Vec<f64>,
}

impl RunArguments {
    /// Returns the system if every option has an effect and every output can be written.
    pub(super) fn system(&self) -> Result<System, Failure> {
        self.output.check()?;
        let system = self.system.system()?;
        if system.contacts() > 1 && !matches!(self.solver.at_repelling, Repelling::Stop) {
            return Err(Failure::Usage(
                "--at-repelling has no effect on a system of several contacts: where its future is \
                    not unique, the run ends; leave it out"
                    .to_owned(),
            ));
        }
        Ok(system)
    }

    /// Reports errors before anything is computed.
    pub(super) fn prepared(&self) -> Result<PreparedRun, Failure> {
        let system = self.system()?;
        let options = self.solver.options(&system)?;
        let (t, x) = self.start.of(&system)?;
        Ok(PreparedRun {
            system,
            options,
            t,
            x,
        })
    }

    /// Runs a command and writes its files. Errors refer to contacts by name.
    pub(super) fn with_report(
        &self,
        find: impl FnOnce(&PreparedRun) -> Result<Report, Failure>,
    ) -> Result<CommandOutput, Failure> {
        self.with_report_of(&self.prepared()?, find)
    }

    /// Runs a command from a start that is prepared, and writes its files.
    pub(super) fn with_report_of(
        &self,
        prepared: &PreparedRun,
        find: impl FnOnce(&PreparedRun) -> Result<Report, Failure>,
    ) -> Result<CommandOutput, Failure> {
        let report = find(prepared).map_err(|failure| failure.of(&prepared.system))?;
        Ok(report.written(self.output.out.as_ref(), &self.output)?)
    }
}
