//! An orbit as a command keeps it.

use std::ops::ControlFlow;

use stickslip::{Direction, Mode, TransitionKind};

use crate::terminal::Patience;
use stickslip_kernels::kernel::{Modes, Passage, PhaseView, StepView, TransitionView, Watcher};

/// Parts of a step for a curve through the orbit, at least: a step of high order is long, and a curve through its ends alone would be a polygon.
const PER_STEP: u32 = 16;

/// A part is halved where its middle is off the straight line by more than this part of what the orbit has covered, so many times at most.
const STRAIGHT: f64 = 1e-3;
const MOST_HALVINGS: u32 = 6;

/// What differs by this part of its size may be rounding.
const ROUNDING: f64 = 1e-9;

/// Steps of the bar that shows how far a run is.
const FINENESS: f64 = 1000.0;

/// A phase.
pub(super) struct Phase {
    pub(super) modes: Modes,
    pub(super) t_start: f64,
    pub(super) t_end: f64,
    pub(super) x_start: Vec<f64>,
    pub(super) x_end: Vec<f64>,
}

impl Phase {
    pub(super) fn duration(&self) -> f64 {
        self.t_end - self.t_start
    }
}

/// A transition.
pub(super) struct Transition {
    pub(super) kind: TransitionKind,
    pub(super) contact: usize,
    pub(super) from: Modes,
    pub(super) to: Modes,
    pub(super) t: f64,
    pub(super) x: Vec<f64>,
    pub(super) residual: f64,
}

/// A passage of the section.
pub(super) struct Crossed {
    pub(super) t: f64,
    pub(super) x: Vec<f64>,
    pub(super) direction: Direction,
}

/// A point of the orbit.
pub(super) struct Point {
    pub(super) t: f64,
    pub(super) x: Vec<f64>,
    /// Whether it is the end of a step and not between.
    pub(super) ends_step: bool,
}

/// All of an orbit.
pub(super) struct Recording {
    pub(super) phases: Vec<Phase>,
    pub(super) transitions: Vec<Transition>,
    pub(super) passages: Vec<Crossed>,
    pub(super) points: Vec<Point>,
    /// Least and greatest value of each state at the ends of steps so far.
    extent: Vec<(f64, f64)>,
    span: (f64, f64),
    patience: Patience,
}

impl Recording {
    pub(super) fn new(t: f64, x: &[f64], t_end: f64) -> Self {
        Recording {
            phases: Vec::new(),
            transitions: Vec::new(),
            passages: Vec::new(),
            points: vec![Point {
                t,
                x: x.to_vec(),
                ends_step: true,
            }],
            extent: x.iter().map(|&x| (x, x)).collect(),
            span: (t, t_end),
            patience: Patience::new("following {bar:40} {percent} %, {eta} to go"),
        }
    }

    /// Keeps the points of a step between two, and the second one.
    fn part(
        &mut self,
        step: &StepView<'_>,
        from: &(f64, Vec<f64>),
        to: (f64, Vec<f64>),
        deep: u32,
    ) {
        let t = 0.5 * (from.0 + to.0);
        if deep > 0 {
            let middle = within(step, t);
            let ends = from.1.iter().zip(&to.1);
            let mut states = middle.iter().zip(ends).zip(&self.extent);
            let is_bent = states.any(|((x, (a, b)), &(low, high))| {
                let rounding = ROUNDING * low.abs().max(high.abs());
                (x - 0.5 * (a + b)).abs() > STRAIGHT * (high - low) + rounding
            });
            if is_bent {
                let middle = (t, middle);
                self.part(step, from, middle.clone(), deep - 1);
                return self.part(step, &middle, to, deep - 1);
            }
        }
        self.points.push(Point {
            t: to.0,
            x: to.1,
            ends_step: false,
        });
    }

    /// Takes off the terminal how far the run is.
    pub(super) fn close(&self) {
        self.patience.clear();
    }

    /// From when to when a contact sticks, whatever the others do meanwhile.
    pub(super) fn sticks_of(&self, contact: usize) -> Vec<(f64, f64)> {
        let mut sticks: Vec<(f64, f64)> = Vec::new();
        for phase in &self.phases {
            if phase.modes.to_vec().get(contact) != Some(&Mode::Stick) {
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

impl Watcher for Recording {
    fn watches_steps(&self) -> bool {
        true
    }

    fn step(&mut self, step: &StepView<'_>) -> ControlFlow<()> {
        for ((low, high), &x) in self.extent.iter_mut().zip(step.x_end) {
            (*low, *high) = (low.min(x), high.max(x));
        }
        let mut from = (step.t_start, within(step, step.t_start));
        for k in 1..=PER_STEP {
            let part = f64::from(k) / f64::from(PER_STEP);
            let to = if k == PER_STEP {
                (step.t_end, step.x_end.to_vec())
            } else {
                let t = step.t_start + part * (step.t_end - step.t_start);
                (t, within(step, t))
            };
            self.part(step, &from, to.clone(), MOST_HALVINGS);
            from = to;
        }
        if let Some(last) = self.points.last_mut() {
            last.ends_step = true;
        }
        let (from, to) = self.span;
        let part = ((step.t_end - from) / (to - from)).clamp(0.0, 1.0);
        self.patience
            .done((part * FINENESS) as u64, FINENESS as u64);
        ControlFlow::Continue(())
    }

    fn phase(&mut self, phase: &PhaseView<'_>) -> ControlFlow<()> {
        self.phases.push(Phase {
            modes: phase.modes,
            t_start: phase.t_start,
            t_end: phase.t_end,
            x_start: phase.x_start.to_vec(),
            x_end: phase.x_end.to_vec(),
        });
        ControlFlow::Continue(())
    }

    fn transition(&mut self, at: &TransitionView<'_>) -> ControlFlow<()> {
        self.transitions.push(Transition {
            kind: at.kind,
            contact: at.contact,
            from: at.from,
            to: at.to,
            t: at.t,
            x: at.x.to_vec(),
            residual: at.residual,
        });
        ControlFlow::Continue(())
    }

    fn passage(&mut self, at: &Passage<'_>) -> ControlFlow<()> {
        self.passages.push(Crossed {
            t: at.t,
            x: at.x.to_vec(),
            direction: at.direction,
        });
        ControlFlow::Continue(())
    }
}

/// The state at a time within a step.
fn within(step: &StepView<'_>, t: f64) -> Vec<f64> {
    let mut x = vec![0.0; step.x_end.len()];
    step.at(t, &mut x);
    x
}

/// A kind of transition in a table.
pub(super) fn kind_name(kind: TransitionKind) -> &'static str {
    match kind {
        TransitionKind::Crossing => "crossing",
        TransitionKind::StickEntry => "stick entry",
        TransitionKind::StickExit => "stick exit",
        TransitionKind::Touch => "touch",
        TransitionKind::ContactLoss => "contact loss",
        TransitionKind::ContactGain => "contact gain",
    }
}

/// A direction in a table.
pub(super) fn direction_name(direction: Direction) -> &'static str {
    match direction {
        Direction::Rising => "rising",
        Direction::Falling => "falling",
        Direction::Both => "both",
    }
}
