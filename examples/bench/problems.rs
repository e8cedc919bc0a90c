//! The benchmark problems of `data/references/problems.json`, by the paper's models.

use std::ops::ControlFlow;

use replication::paper::models::{BeltOscillator, BlockAndBracket, ForcedOscillator};
use serde_json::Value;
use stickslip::{
    Filippov, Observer, Options, Scalar, Side, State, Transition, TransitionKind, run,
};

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

/// A system with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum System {
    /// Model 1.
    Belt(BeltOscillator),
    /// Model 2.
    Forced(ForcedOscillator),
    /// A boundary that moves.
    Moving(MovingBoundary),
    /// Model 3.
    Bracket(BlockAndBracket),
}

/// A problem: everything that a solver needs except its tolerance.
#[derive(Clone, Debug)]
pub struct Problem {
    /// System.
    pub system: System,
    /// Start, from the first time to the last.
    pub start: Vec<f64>,
    /// First time.
    pub t_start: f64,
    /// Last time.
    pub t_end: f64,
}

/// Kind and time of an event.
pub type Event = (&'static str, f64);

/// The description of the problems.
pub fn descriptions() -> Result<Value, String> {
    let text = include_str!("../../data/references/problems.json");
    serde_json::from_str(text).map_err(|error| format!("problems.json: {error}"))
}

impl Problem {
    /// The problem with this name.
    ///
    /// # Errors
    /// A message if there is none, or its description lacks a number.
    pub fn named(name: &str) -> Result<Problem, String> {
        let all = descriptions()?;
        let Some(described) = all.get(name) else {
            let names: Vec<&str> = all
                .as_object()
                .into_iter()
                .flatten()
                .map(|p| &**p.0)
                .collect();
            return Err(format!(
                "no problem '{name}'; there are {}",
                names.join(", ")
            ));
        };
        let number = |value: &Value, what: &str| {
            value
                .as_f64()
                .ok_or_else(|| format!("problems.json: {name} has no number '{what}'"))
        };
        let p = |what: &str| number(&described["parameters"][what], what);
        let system = match described["model"].as_str() {
            Some("belt") => System::Belt(BeltOscillator {
                mass: p("mass")?,
                k1: p("k1")?,
                k2: p("k2")?,
                mu0: p("mu0")?,
                delta: p("delta")?,
                belt_speed: p("belt_speed")?,
            }),
            Some("forced") => System::Forced(ForcedOscillator {
                mass: p("mass")?,
                k1: p("k1")?,
                k2: p("k2")?,
                mu0: p("mu0")?,
                delta: p("delta")?,
                belt_speed: p("belt_speed")?,
                amplitude: p("amplitude")?,
                omega: p("omega")?,
            }),
            Some("moving") => System::Moving(MovingBoundary { speed: p("speed")? }),
            Some("bracket") => System::Bracket(BlockAndBracket {
                coupling: p("coupling")?,
                coupling_damping: p("coupling_damping")?,
                mobility: p("mobility")?,
                bracket_stiffness: p("bracket_stiffness")?,
                bracket_damping: p("bracket_damping")?,
                mu0: p("mu0")?,
                unloading: p("unloading")?,
                unloading_rate: p("unloading_rate")?,
                delta: p("delta")?,
                belt_speed: p("belt_speed")?,
                displacement_sign: 1.0,
                friction_sign: 1.0,
                clipped: true,
            }),
            _ => return Err(format!("problems.json: {name} is of no known model")),
        };
        let start = described["start"].as_array().into_iter().flatten();
        Ok(Problem {
            system,
            start: start
                .map(|x| number(x, "start"))
                .collect::<Result<_, _>>()?,
            t_start: number(&described["t_start"], "t_start")?,
            t_end: number(&described["t_end"], "t_end")?,
        })
    }

    /// Computes the events up to the end time, and returns the number of steps. `events` is cleared
    /// first, and its memory is reused.
    ///
    /// # Errors
    /// The solver's error.
    pub fn solve(&self, options: &Options, events: &mut Vec<Event>) -> Result<u64, String> {
        events.clear();
        match &self.system {
            System::Belt(system) => self.events(system, options, events),
            System::Forced(system) => self.events(system, options, events),
            System::Moving(system) => self.events(system, options, events),
            System::Bracket(system) => self.events(system, options, events),
        }
    }

    fn events<S: Filippov<N>, const N: usize>(
        &self,
        system: &S,
        options: &Options,
        events: &mut Vec<Event>,
    ) -> Result<u64, String> {
        let start = <[f64; N]>::try_from(&self.start[..])
            .map_err(|_| format!("the start has {} numbers for {N} states", self.start.len()))?;
        let mut recorder = EventRecorder(events);
        let start = State::from(start);
        run(
            system,
            self.t_start,
            start,
            self.t_end,
            options,
            &mut recorder,
        )
        .map(|ended| ended.counters.steps)
        .map_err(|error| error.to_string())
    }
}

struct EventRecorder<'a>(&'a mut Vec<Event>);

impl<const N: usize> Observer<N> for EventRecorder<'_> {
    fn transition(&mut self, at: &Transition<N>) -> ControlFlow<()> {
        let kind = match at.kind {
            TransitionKind::Crossing => "crossing",
            TransitionKind::StickEntry => "entry",
            TransitionKind::StickExit => "exit",
            // Touches change no mode, and the peers do not report them.
            _ => return ControlFlow::Continue(()),
        };
        self.0.push((kind, at.t));
        ControlFlow::Continue(())
    }

    fn watches_steps(&self) -> bool {
        false
    }
}
