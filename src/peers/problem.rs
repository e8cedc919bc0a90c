//! The problems that all solvers get. data/references/problems.json has the same numbers for the
//! other programs; a test compares them.

use std::ops::ControlFlow;

use super::event::{self, Event, EventKind};
use crate::paper::models::{BeltOscillator, BlockAndBracket, Caption, ForcedOscillator, Reading};
use crate::terminal::ProgramError;
use crate::text::joined;
use stickslip::dynamics::{DynamicsRef, OrbitProgress, OrbitUnderWay, Section};
use stickslip::{
    Filippov, Method, Observer, Options, Scalar, Side, State, Transition, TransitionKind, run,
};
use stickslip_kernels::kernel::{Equations, Switching, dynamics, follow};
use stickslip_kernels::trace::trace;

/// Problem with a moving boundary: `x' = a` below, `−a` above, boundary `x − sin t`. Between events
/// the solution has a closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingBoundary {
    /// Speed a on either side (1/s), between 0 and 1.
    pub speed: f64,
}

impl Filippov<1> for MovingBoundary {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(-self.speed * side.sign())]
    }

    #[inline(always)]
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        x[0] - t.sin()
    }
}

/// A system with its parameters and its start.
#[derive(Clone, Copy, Debug)]
pub enum System {
    /// Model 1.
    Belt(BeltOscillator, [f64; 2]),
    /// Model 2.
    Forced(ForcedOscillator, [f64; 2]),
    /// A boundary that moves.
    Moving(MovingBoundary, [f64; 1]),
    /// Model 3.
    Bracket(BlockAndBracket, [f64; 4]),
}

/// A problem: everything that a solver needs except its tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Problem {
    /// Name, also of its reference file.
    pub name: &'static str,
    /// Heading of its panel, in markup.
    pub title: &'static str,
    /// System and start.
    pub system: System,
    /// First time.
    pub t_start: f64,
    /// Last time.
    pub t_end: f64,
    /// The reference file.
    pub(super) reference: &'static str,
}

macro_rules! problem {
    ($name:literal, $title:literal, $system:expr, $t_end:expr) => {
        Problem {
            name: $name,
            title: $title,
            system: $system,
            t_start: 0.0,
            t_end: $t_end,
            reference: include_str!(concat!("../../data/references/", $name, ".csv")),
        }
    };
}

/// All problems, in the order of the figure's panels.
///
/// # Errors
/// [`stickslip::Error::Parameter`], if a caption had a parameter that is not allowed.
pub fn problems() -> Result<Vec<Problem>, stickslip::Error> {
    let belt = BeltOscillator {
        belt_speed: 0.4,
        ..BeltOscillator::default()
    };
    let decay = BeltOscillator {
        k1: -1.0,
        k2: 0.0,
        mu0: 1.0,
        belt_speed: 0.2,
        ..belt
    };
    let forced = ForcedOscillator::default();
    let bracket = BlockAndBracket::from_caption(&Caption::FIG11, &Reading::exact())?;
    Ok(vec![
        problem!(
            "belt_sensitive",
            "model 1, sensitive start",
            System::Belt(belt, [0.5, 1.5]),
            30.0
        ),
        problem!(
            "belt_periodic",
            "model 1, to its stick-slip cycle",
            System::Belt(belt, [0.1, 0.0]),
            30.0
        ),
        problem!(
            "belt_grazing",
            "model 1, stick of 0.13 ms by grazing",
            System::Belt(belt, [0.483, 0.0]),
            30.0
        ),
        problem!(
            "decay",
            "linear spring, decaying friction",
            System::Belt(decay, [0.04, -0.01]),
            40.0
        ),
        problem!(
            "forced",
            "model 2, 100 forcing periods",
            System::Forced(forced, [0.0, 0.0]),
            100.0 * forced.period()
        ),
        Problem {
            t_start: std::f64::consts::FRAC_PI_2,
            ..problem!(
                "moving",
                "moving boundary",
                System::Moving(MovingBoundary { speed: 0.5 }, [1.0]),
                40.0
            )
        },
        problem!(
            "bracket",
            "model 3, quasi-periodic set",
            System::Bracket(bracket, [-0.5, -0.5, 0.5, 0.3]),
            60.0
        ),
    ])
}

impl Problem {
    /// The problem with this name.
    ///
    /// # Errors
    /// A message, if there is none.
    pub fn named(name: &str) -> Result<Problem, String> {
        let problems = problems().map_err(|error| error.to_string())?;
        find_by_name(&problems, |one| one.name, name).copied()
    }

    /// The events of its reference, which has thirty digits.
    ///
    /// # Errors
    /// A message with the line that is wrong.
    pub fn reference(&self) -> Result<Vec<Event>, String> {
        event::parse(self.name, self.reference)
    }

    /// Computes the events up to the end time. `events` is cleared first, and its memory is reused.
    ///
    /// # Errors
    /// The solver's error, with the problem and the tolerance.
    pub fn solve(&self, options: &Options, events: &mut Vec<Event>) -> Result<(), ProgramError> {
        events.clear();
        let result = match self.system {
            System::Belt(system, start) => self.events(&system, start, options, events),
            System::Forced(system, start) => self.events(&system, start, options, events),
            System::Moving(system, start) => self.events(&system, start, options, events),
            System::Bracket(system, start) => self.events(&system, start, options, events),
        };
        result.map_err(|error| self.unsolved(options, error))
    }

    fn unsolved(&self, options: &Options, error: stickslip::Error) -> ProgramError {
        format!("{} at tolerance {:e}: {error}", self.name, options.rtol).into()
    }

    /// The problem by its formulas, as a system from a file is.
    ///
    /// # Errors
    /// A message if they branch on values.
    fn by_formulas(&self) -> Result<PreparedProblem<'_>, String> {
        fn traced<S: Filippov<N>, const N: usize>(
            system: &S,
            start: [f64; N],
        ) -> Option<(DynamicsRef<'static>, Vec<f64>)> {
            let equations = Equations::OneContact(Box::new(trace(system)?));
            let system = dynamics(equations, None, Switching::none(N), (N, 1), None)?;
            Some((system, start.to_vec()))
        }
        let traced = match &self.system {
            System::Belt(system, start) => traced(system, *start),
            System::Forced(system, start) => traced(system, *start),
            System::Moving(system, start) => traced(system, *start),
            System::Bracket(system, start) => traced(system, *start),
        };
        let branches = "branches on values, which formulas cannot say";
        let (system, start) = traced.ok_or_else(|| format!("problem {} {branches}", self.name))?;
        Ok(PreparedProblem::ByFormulas(self, system, start))
    }

    fn events<S: Filippov<N>, const N: usize>(
        &self,
        system: &S,
        start: [f64; N],
        options: &Options,
        events: &mut Vec<Event>,
    ) -> Result<(), stickslip::Error> {
        let start = State::from(start);
        let mut notes = EventRecorder(events);
        run(system, self.t_start, start, self.t_end, options, &mut notes)?;
        Ok(())
    }
}

/// A problem that can be solved any number of times.
pub enum PreparedProblem<'a> {
    /// By its compiled functions.
    Compiled(&'a Problem),
    /// By its formulas, from a start.
    ByFormulas(&'a Problem, DynamicsRef<'static>, Vec<f64>),
}

impl PreparedProblem<'_> {
    /// As [`Problem::solve`].
    ///
    /// # Errors
    /// As [`Problem::solve`].
    pub fn solve(&self, options: &Options, events: &mut Vec<Event>) -> Result<(), ProgramError> {
        let (problem, system, x) = match self {
            PreparedProblem::Compiled(problem) => return problem.solve(options, events),
            PreparedProblem::ByFormulas(problem, system, x) => (problem, system, x),
        };
        events.clear();
        let (t, t_end) = (problem.t_start, problem.t_end);
        let mut recorder = EventRecorder(events);
        let mut watcher = |progress, _: &mut dyn OrbitUnderWay| match progress {
            OrbitProgress::Transition(at) => recorder.record(at.kind, at.t),
            _ => ControlFlow::Continue(()),
        };
        let ended = follow(system, (t, x), t_end, options, &Section::None, &mut watcher);
        let ended = ended.map(drop);
        ended.map_err(|error| problem.unsolved(options, error))
    }
}

struct EventRecorder<'a>(&'a mut Vec<Event>);

impl EventRecorder<'_> {
    fn record(&mut self, kind: TransitionKind, t: f64) -> ControlFlow<()> {
        let kind = match kind {
            TransitionKind::Crossing => EventKind::Crossing,
            TransitionKind::StickEntry => EventKind::Entry,
            TransitionKind::StickExit => EventKind::Exit,
            // Touches change no mode, and the peers do not report them.
            TransitionKind::Touch
            | TransitionKind::ContactLoss
            | TransitionKind::ContactGain
            | TransitionKind::Jump => return ControlFlow::Continue(()),
        };
        self.0.push(Event { kind, t });
        ControlFlow::Continue(())
    }
}

impl<const N: usize> Observer<N> for EventRecorder<'_> {
    fn transition(&mut self, at: &Transition<N>) -> ControlFlow<()> {
        self.record(at.kind, at.t)
    }
    fn watches_steps(&self) -> bool {
        false
    }
}

/// One of our solvers.
#[derive(Clone, Copy, Debug)]
pub struct Solver {
    /// Name in the report and in the figure.
    pub name: &'static str,
    /// Its integrator.
    pub method: Method,
    /// Whether it takes the problems by their formulas.
    pub by_formulas: bool,
    /// The tolerances for which it is run.
    pub tolerances: &'static [f64],
}

const TOLERANCES: [f64; 12] = [
    1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15,
];

/// The solvers.
pub const SOLVERS: &[Solver] = &[
    Solver {
        name: "stickslip Taylor",
        method: Method::Taylor,
        by_formulas: false,
        tolerances: &TOLERANCES,
    },
    Solver {
        name: "stickslip Dop853",
        method: Method::Dop853,
        by_formulas: false,
        // Rounding limits the accuracy of Runge–Kutta steps.
        tolerances: TOLERANCES.split_at(11).0,
    },
    Solver {
        name: "stickslip formulas",
        method: Method::Taylor,
        by_formulas: true,
        tolerances: &TOLERANCES,
    },
];

/// The item with this name.
fn find_by_name<'a, T>(all: &'a [T], name_of: fn(&T) -> &str, name: &str) -> Result<&'a T, String> {
    let named = all.iter().find(|one| name_of(one) == name);
    named.ok_or_else(|| format!("there are {}", joined(all.iter().map(name_of), ", ")))
}

impl Solver {
    /// The solver with this name.
    ///
    /// # Errors
    /// A message, if there is none.
    pub fn named(name: &str) -> Result<&'static Solver, String> {
        find_by_name(SOLVERS, |one| one.name, name)
    }

    /// A problem in the form that it takes.
    ///
    /// # Errors
    /// A message if it takes formulas and the problem has none.
    pub fn ready<'a>(&self, problem: &'a Problem) -> Result<PreparedProblem<'a>, String> {
        match self.by_formulas {
            true => problem.by_formulas(),
            false => Ok(PreparedProblem::Compiled(problem)),
        }
    }

    /// Its options for a tolerance.
    pub fn options(&self, tolerance: f64) -> Options {
        Options::tol(tolerance).method(self.method)
    }
}
