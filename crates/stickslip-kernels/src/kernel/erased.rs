//! What a kernel tells, without the number of states and contacts in its type.

use std::ops::ControlFlow;

use stickslip::analysis::Exponent;
use stickslip::dynamics::Modes;
use stickslip::nalgebra::Complex;
use stickslip::{Counters, Direction, Ending, TransitionKind};

/// An accepted step.
pub struct StepView<'a> {
    /// Modes during the step.
    pub modes: Modes,
    /// Time at the start.
    pub t_start: f64,
    /// Time at the end.
    pub t_end: f64,
    /// State at the end.
    pub x_end: &'a [f64],
    pub(super) sample: &'a dyn Fn(f64, &mut [f64]),
}

impl StepView<'_> {
    /// Writes the state at a time of the step into `x`.
    pub fn at(&self, t: f64, x: &mut [f64]) {
        (self.sample)(t, x);
    }
}

/// A phase: part of an orbit between two transitions.
#[derive(Clone, Copy, Debug)]
pub struct PhaseView<'a> {
    /// Modes in it.
    pub modes: Modes,
    /// Time at the start.
    pub t_start: f64,
    /// Time at the end.
    pub t_end: f64,
    /// State at the start.
    pub x_start: &'a [f64],
    /// State at the end.
    pub x_end: &'a [f64],
}

/// A transition.
#[derive(Clone, Copy, Debug)]
pub struct TransitionView<'a> {
    /// What happened.
    pub kind: TransitionKind,
    /// At which contact, counted from 0.
    pub contact: usize,
    /// Modes before.
    pub from: Modes,
    /// Modes after.
    pub to: Modes,
    /// Time.
    pub t: f64,
    /// State.
    pub x: &'a [f64],
    /// What is left of the function whose zero was sought.
    pub residual: f64,
}

impl TransitionView<'_> {
    /// Tells of it, and of what happens to each other contact whose mode changes in the same
    /// instant.
    pub(super) fn tell(&self, watcher: &mut dyn Watcher) -> ControlFlow<()> {
        watcher.transition(self)?;
        let modes = self.from.iter().zip(self.to.iter());
        for (contact, (from, to)) in modes.enumerate() {
            if contact != self.contact && from != to {
                let kind = TransitionKind::between(from, to);
                watcher.transition(&TransitionView {
                    kind,
                    contact,
                    ..*self
                })?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// A passage of the section.
#[derive(Clone, Copy, Debug)]
pub struct Passage<'a> {
    /// Time.
    pub t: f64,
    /// State.
    pub x: &'a [f64],
    /// Modes there.
    pub modes: Modes,
    /// Which way.
    pub direction: Direction,
}

/// Told of an orbit as it is made, in order of time. Each method may end the run.
pub trait Watcher {
    /// Whether it is told of steps; where it is not, a part of the work can be left out.
    fn watches_steps(&self) -> bool {
        false
    }
    /// After every step.
    fn step(&mut self, _step: &StepView<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// After every phase.
    fn phase(&mut self, _phase: &PhaseView<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// At every transition, after the phase that it ends.
    fn transition(&mut self, _at: &TransitionView<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// At every passage of the section.
    fn passage(&mut self, _at: &Passage<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Watches nothing.
impl Watcher for () {}

/// How and where a run ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// Why.
    pub ending: Ending,
    /// Last time.
    pub t: f64,
    /// Last state.
    pub x: Vec<f64>,
    /// Work done.
    pub counters: Counters,
}

/// A periodic orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct Periodic {
    /// Time at which it is at `x`.
    pub t: f64,
    /// A state on it.
    pub x: Vec<f64>,
    /// Period.
    pub period: f64,
    /// Largest component of what is left of `x(t + period) − x`.
    pub residual: f64,
    /// Floquet multipliers, the one nearest to 1 first.
    pub multipliers: Vec<Complex<f64>>,
    /// Dimension of the family of periodic orbits that it is one of; 0 where it is isolated.
    pub family: usize,
}

/// A Lyapunov spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumFound {
    /// The exponents in descending order, annihilated ones last.
    pub exponents: Vec<Exponent>,
    /// The exponents as they stood at times since measuring began.
    pub convergence: Vec<(f64, Vec<f64>)>,
    /// What the sum of the finite ones differs from the rate of volumes.
    pub defect: f64,
    /// Entries into stick while measuring.
    pub stick_entries: usize,
    /// Part of the measured time in stick, of any contact.
    pub stick_fraction: f64,
    /// Time measured.
    pub duration: f64,
}
