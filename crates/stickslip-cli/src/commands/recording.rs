//! Recording of an orbit for a command.

use std::ops::ControlFlow;

use stickslip::dynamics::{
    Kink, Modes, Moment, OrbitProgress, OrbitUnderWay, Passage, Phase, Summary, Transition, Vector,
};
use stickslip::{Direction, Error, Mode, Options, TransitionKind};

use crate::render::input_name;
use crate::terminal::DelayedProgressBar;
use stickslip_kernels::file::{InputShape, System};
use stickslip_kernels::kernel::follow;
use stickslip_kernels::study::FrictionWatch;

/// Minimum number of parts of a step for a curve through the orbit. Steps of high order are long,
/// so that a curve through their ends alone would be a polygon.
const PARTS_PER_STEP: u32 = 16;

/// A part is halved if its midpoint is off the straight line by more than this fraction of the
/// extent of the orbit so far. The next constant limits the number of halvings.
const CHORD_TOLERANCE: f64 = 1e-3;
const MOST_HALVINGS: u32 = 6;

/// Relative differences up to this may be rounding.
const ROUNDING: f64 = 1e-9;

/// Number of steps of the progress bar.
const FINENESS: f64 = 1000.0;

/// A point of the orbit.
pub(super) struct Point {
    pub(super) t: f64,
    pub(super) x: Vector,
    /// Whether the point is the end of a step, or the state behind a jump.
    pub(super) ends_step: bool,
}

/// An event at one time of an orbit.
pub(super) enum Occurrence {
    /// A mode changes, a boundary is touched, or the state jumps.
    Transition(Transition),
    /// An input has a kink, or a switch changes its sign.
    Kink(Kink),
}

impl Occurrence {
    pub(super) fn t(&self) -> f64 {
        match self {
            Occurrence::Transition(at) => at.t,
            Occurrence::Kink(at) => at.t,
        }
    }

    pub(super) fn x(&self) -> &Vector {
        match self {
            Occurrence::Transition(at) => &at.x,
            Occurrence::Kink(at) => &at.x,
        }
    }

    fn is_jump(&self) -> bool {
        matches!(self, Occurrence::Transition(at) if at.kind == TransitionKind::Jump)
    }

    /// The modes before and after it.
    pub(super) fn modes(&self) -> [Modes; 2] {
        match self {
            Occurrence::Transition(at) => [at.from, at.to],
            Occurrence::Kink(at) => [at.mode; 2],
        }
    }

    /// Name of the event in tables.
    pub(super) fn kind(&self, system: &System) -> &'static str {
        match self {
            Occurrence::Transition(at) => at.kind.name(),
            Occurrence::Kink(at) => match system.file.inputs[at.input].shape {
                InputShape::Switch(_) => "switch",
                _ => "kink",
            },
        }
    }

    /// Name of the contact, jump or input of the event.
    pub(super) fn of(&self, system: &System) -> String {
        match self {
            Occurrence::Transition(at) => system.contact_name(at.contact),
            Occurrence::Kink(at) => input_name(system, at.input),
        }
    }
}

/// Points, events and phases of an orbit.
pub(super) struct Recording {
    pub(super) phases: Vec<Phase>,
    pub(super) transitions: Vec<Occurrence>,
    pub(super) passages: Vec<Passage>,
    pub(super) points: Vec<Point>,
    /// Minimum and maximum of each state at the ends of steps so far.
    extent: Vec<(f64, f64)>,
    span: (f64, f64),
    /// What looks wrong with the run.
    pub(super) doubt: Option<String>,
    progress: DelayedProgressBar,
}

impl Recording {
    /// Records a run, and returns how it ended.
    pub(super) fn of(
        system: &System,
        start: (f64, &[f64]),
        t_end: f64,
        options: &Options,
    ) -> (Self, Result<Summary, Error>) {
        let (t, x) = (start.0, Vector::from_column_slice(start.1));
        let mut recording = Recording {
            phases: Vec::new(),
            transitions: Vec::new(),
            passages: Vec::new(),
            extent: x.iter().map(|&x| (x, x)).collect(),
            points: vec![Point {
                t,
                x,
                ends_step: true,
            }],
            span: (t, t_end),
            doubt: None,
            progress: DelayedProgressBar::new("following {bar:40} {percent} %, {eta} to go"),
        };
        let mut friction = FrictionWatch::new(system);
        let mut watcher = |progress, orbit: &mut dyn OrbitUnderWay| {
            match progress {
                OrbitProgress::Step => {
                    recording.step(orbit);
                    friction.step(orbit);
                }
                OrbitProgress::PhaseEnd(phase) => recording.phases.push(phase),
                OrbitProgress::Transition(at) => {
                    recording.transitions.push(Occurrence::Transition(at));
                }
                OrbitProgress::Kink(at) => recording.transitions.push(Occurrence::Kink(at)),
                OrbitProgress::Passage(at) => recording.passages.push(at),
                OrbitProgress::End(_) => {}
            }
            ControlFlow::Continue(())
        };
        let (dynamics, section) = (system.dynamics(), system.section());
        let ended = follow(dynamics, start, t_end, options, &section, &mut watcher);
        recording.progress.clear();
        recording.doubt = friction.warning();
        (recording, ended)
    }

    /// Records the points of a step.
    fn step(&mut self, orbit: &mut dyn OrbitUnderWay) {
        let (step, solution) = (orbit.last_step(), orbit.solution());
        for ((low, high), &x) in self.extent.iter_mut().zip(&step.x_end) {
            (*low, *high) = (low.min(x), high.max(x));
        }
        let at = |k: u32| {
            let part = f64::from(k) / f64::from(PARTS_PER_STEP);
            let t = step.t_start + part * (step.t_end - step.t_start);
            let x = solution(t);
            Moment { t, x }
        };
        let mut from = at(0);
        // Behind a jump the curve begins anew, so that its edge is vertical.
        let at_start = self.transitions.iter().rev();
        let mut at_start = at_start.take_while(|at| at.t() == step.t_start);
        if at_start.any(Occurrence::is_jump) {
            let (Moment { t, x }, ends_step) = (from.clone(), true);
            self.points.push(Point { t, x, ends_step });
        }
        let end = Moment {
            t: step.t_end,
            x: step.x_end,
        };
        for to in (1..PARTS_PER_STEP).map(at).chain([end]) {
            self.part(&*solution, &from, to.clone(), MOST_HALVINGS);
            from = to;
        }
        if let Some(last) = self.points.last_mut() {
            last.ends_step = true;
        }
        let (from, to) = self.span;
        let part = ((step.t_end - from) / (to - from)).clamp(0.0, 1.0);
        self.progress
            .done((part * FINENESS) as u64, FINENESS as u64);
    }

    /// Records the points of a step between two moments, and the second one.
    fn part(&mut self, solution: &dyn Fn(f64) -> Vector, from: &Moment, to: Moment, deep: u32) {
        let t = 0.5 * (from.t + to.t);
        if deep > 0 {
            let x = solution(t);
            let ends = from.x.iter().zip(&to.x);
            let mut states = x.iter().zip(ends).zip(&self.extent);
            let is_bent = states.any(|((x, (a, b)), &(low, high))| {
                let rounding = ROUNDING * low.abs().max(high.abs());
                (x - 0.5 * (a + b)).abs() > CHORD_TOLERANCE * (high - low) + rounding
            });
            if is_bent {
                let middle = Moment { t, x };
                self.part(solution, from, middle.clone(), deep - 1);
                return self.part(solution, &middle, to, deep - 1);
            }
        }
        let (Moment { t, x }, ends_step) = (to, false);
        self.points.push(Point { t, x, ends_step });
    }

    /// Intervals of time in which a contact sticks, independent of the other contacts.
    pub(super) fn sticks_of(&self, contact: usize) -> Vec<(f64, f64)> {
        let mut sticks: Vec<(f64, f64)> = Vec::new();
        for phase in &self.phases {
            if phase.mode.get(contact) != Mode::Stick {
                continue;
            }
            match sticks.last_mut() {
                Some(last) if last.1 == phase.t_start => last.1 = phase.t_end,
                _ => sticks.push((phase.t_start, phase.t_end)),
            }
        }
        sticks
    }
}

/// Names of transitions in tables, in the order in which they are counted.
pub(super) const KINDS: [&str; 9] = [
    "stick entry",
    "stick exit",
    "crossing",
    "touch",
    "contact loss",
    "contact gain",
    "jump",
    "switch",
    "kink",
];

/// Name of a direction in tables.
pub(super) fn direction_name(direction: Direction) -> &'static str {
    match direction {
        Direction::Rising => "rising",
        Direction::Falling => "falling",
        Direction::Both => "both",
    }
}
