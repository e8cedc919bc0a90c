//! Runs and analyses of systems given as text, with the defaults of the program.

use std::ops::ControlFlow;

use stickslip::analysis::{
    ContinuationSettings, CycleBifurcation, PeriodicOrbit, SpecialPoint, continue_periodic_orbit,
    multipliers,
};
use stickslip::dynamics::{OrbitProgress, OrbitUnderWay, Passage, Summary};
use stickslip::{Ending, Error, Method, Options};
use stickslip_model::file::{InputShape, Interface, Source, System, SystemFile};
use stickslip_model::kernel::follow;
use stickslip_model::study::{ParameterLine, PeriodicSearch, TwoSidedBranch};

pub const METHODS: [&str; 2] = ["taylor", "dop853"];

pub fn parsed(text: &str) -> SystemFile {
    let (name, text) = ("system.toml".to_owned(), text.to_owned());
    SystemFile::parse(Source { name, text }).unwrap_or_else(|error| panic!("{error}"))
}

pub fn system(text: &str) -> System {
    with(text, &[])
}

/// The system with other values of some parameters.
pub fn with(text: &str, settings: &[(&str, f64)]) -> System {
    let settings = settings
        .iter()
        .map(|(name, value)| ((*name).to_owned(), *value));
    parsed(text).with(&settings.collect::<Vec<_>>()).unwrap()
}

pub fn options(method: &str) -> Options {
    let method = match method {
        "taylor" => Method::Taylor,
        _ => Method::Dop853,
    };
    let most_events = 200_000;
    Options {
        most_events,
        ..Options::tol(1e-12)
    }
    .method(method)
    .escape(1e6)
}

/// Time, kind, and name of the contact, jump or input.
pub type Transition = (f64, &'static str, String);

/// A recorded run.
pub struct Run {
    pub system: System,
    pub ended: Result<Summary, Error>,
    pub transitions: Vec<Transition>,
    pub passages: Vec<Passage>,
}

impl Run {
    /// Follows the orbit from the start of the file to a time, or to the end in the file.
    pub fn of(system: System, options: &Options, t_end: Option<f64>) -> Run {
        let start = (system.built.t_start, system.start().unwrap());
        let t_end = t_end.or(system.built.t_end).unwrap();
        Run::from(system, options, (start, t_end))
    }

    /// Follows the orbit from a time and state to a time.
    pub fn from(system: System, options: &Options, ((t, x), t_end): ((f64, Vec<f64>), f64)) -> Run {
        let (mut transitions, mut passages) = (Vec::new(), Vec::new());
        let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
            match progress {
                OrbitProgress::Transition(at) => {
                    transitions.push((at.t, at.kind.name(), system.contact_name(at.contact)));
                }
                OrbitProgress::Kink(at) => {
                    let input = &system.file.inputs[at.input];
                    let kind = match input.shape {
                        InputShape::Switch(_) => "switch",
                        _ => "kink",
                    };
                    transitions.push((at.t, kind, input.name.clone()));
                }
                OrbitProgress::Passage(at) => passages.push(at),
                _ => {}
            }
            ControlFlow::Continue(())
        };
        let start = (t, &x[..]);
        let (dynamics, sections) = (system.dynamics(), system.sections());
        let ended = follow(dynamics, start, t_end, options, &sections, &mut watcher);
        Run {
            system,
            ended,
            transitions,
            passages,
        }
    }

    pub fn ending(&self) -> Ending {
        self.ended.as_ref().unwrap().ending
    }

    /// A state at the end.
    pub fn end(&self, state: &str) -> f64 {
        let all = &self.system.file.states;
        let number = all.iter().position(|one| one.name == state).unwrap();
        self.ended.as_ref().unwrap().x[number]
    }

    /// The message of a run that fails.
    pub fn words(&self) -> String {
        Names.words(self.ended.as_ref().unwrap_err(), Some(&self.system))
    }
}

/// Options by their names in the library.
pub struct Names;

impl Interface for Names {
    fn name(&self, option: &str) -> String {
        option.to_owned()
    }

    fn choice(&self, option: &str, words: &[&str]) -> String {
        format!("{option} = {}", words.join(" or "))
    }

    fn value(&self, option: &str, value: f64) -> String {
        format!("{option} = {value}")
    }

    fn nearer(&self) -> &'static str {
        ""
    }
}

/// A run from the start of the file, and its transitions without the kinks of inputs.
pub fn simulated(
    text: &str,
    method: &str,
    t_end: impl Into<Option<f64>>,
) -> (Run, Vec<Transition>) {
    simulated_by(text, &options(method), t_end)
}

/// Result of [`simulated`], with options.
pub fn simulated_by(
    text: &str,
    options: &Options,
    t_end: impl Into<Option<f64>>,
) -> (Run, Vec<Transition>) {
    let run = Run::of(system(text), options, t_end.into());
    run.ended
        .as_ref()
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    let mut transitions = run.transitions.clone();
    transitions.retain(|(_, kind, _)| *kind != "kink" && *kind != "switch");
    (run, transitions)
}

pub fn end(run: &Run, state: &str) -> f64 {
    run.end(state)
}

/// The message of a run that fails.
pub fn failed(text: &str, options: &Options) -> String {
    Run::of(system(text), options, None).words()
}

pub const SEARCH: PeriodicSearch = PeriodicSearch {
    transient: None,
    period: None,
    longest: 100.0,
    periods: None,
};

/// The periodic orbit that the run from the start of the file approaches.
pub fn orbit(system: &System, options: &Options) -> PeriodicOrbit {
    orbit_from(system, system.built.t_start, &SEARCH, options)
}

/// Result of [`orbit`], from another time.
pub fn orbit_from(
    system: &System,
    t: f64,
    search: &PeriodicSearch,
    options: &Options,
) -> PeriodicOrbit {
    let x = system.start().unwrap();
    search.orbit(system, (t, &x), options).unwrap().0
}

/// Sum and product of the multipliers of a periodic orbit in the plane.
pub fn trace_and_determinant(orbit: &PeriodicOrbit) -> (f64, f64) {
    (orbit.monodromy.trace(), orbit.monodromy.determinant())
}

/// Real parts of the multipliers, the largest first.
pub fn real_multipliers(orbit: &PeriodicOrbit) -> Vec<f64> {
    multipliers(&orbit.monodromy)
        .iter()
        .map(|one| one.re)
        .collect()
}

/// The branch of an orbit along a parameter, in both directions.
pub fn branch(
    system: &System,
    (parameter, low, high): (&str, f64, f64),
    options: &Options,
) -> TwoSidedBranch {
    let orbit = orbit(system, options);
    branch_through(system, &orbit, (parameter, low, high), 0.02, options)
}

/// Result of [`branch`], through an orbit that is known.
pub fn branch_through(
    system: &System,
    orbit: &PeriodicOrbit,
    (parameter, low, high): (&str, f64, f64),
    step: f64,
    options: &Options,
) -> TwoSidedBranch {
    let along = ParameterLine::new(system, parameter, (low, high)).unwrap();
    let settings = ContinuationSettings {
        step,
        ..ContinuationSettings::over(low, high)
    };
    let (settings, x) = along.start(orbit, &settings, options, None).unwrap();
    let way = |upwards| {
        let (system, x) = (&along.dynamics, x.as_slice());
        continue_periodic_orbit(system, x, orbit.period, upwards, &settings, options).unwrap()
    };
    let ways = [way(false), way(true)];
    along
        .joined::<Box<dyn std::error::Error + Send + Sync>>(ways, options)
        .unwrap()
}

/// The flips on a branch.
pub fn flips(branch: &TwoSidedBranch) -> Vec<&SpecialPoint> {
    let is_flip = |at: &&SpecialPoint| at.what == CycleBifurcation::Flip;
    branch.special.iter().filter(is_flip).collect()
}
