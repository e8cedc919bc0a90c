//! What a run tells while it goes: steps, transitions, phases.

use std::ops::{ControlFlow, Sub};

use super::switch::kind;
use crate::ode::Dense;
use crate::system::{Mode, State};

/// A part of an orbit in one mode, between two transitions, of a system of `N` states.
pub type Phase<const N: usize, K = Mode> = PhaseOf<State<N>, K>;

/// A part of an orbit in one mode, between two transitions; `X` is a state, `K` what says the mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseOf<X, K> {
    /// Slip below, slip above, or stick; of several contacts, each one's.
    pub mode: K,
    /// Time at the start.
    pub t_start: f64,
    /// Time at the end.
    pub t_end: f64,
    /// State at the start.
    pub x_start: X,
    /// State at the end.
    pub x_end: X,
}

impl<X, K> PhaseOf<X, K> {
    /// Length in time.
    pub fn duration(&self) -> f64 {
        self.t_end - self.t_start
    }

    /// Change of the state over the phase. For a body on a belt of speed `vp` the position's change in
    /// a stick phase is `vp · duration`.
    pub fn displacement(&self) -> X
    where
        for<'x> &'x X: Sub<Output = X>,
    {
        &self.x_end - &self.x_start
    }
}

/// What happened at a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransitionKind {
    /// From slip on one side through Σ to slip on the other: the orbit kinks.
    Crossing,
    /// From slip to stick.
    StickEntry,
    /// From stick to slip: at a tangent point, or across Σ where static friction is more than kinetic.
    StickExit,
    /// Slip touches Σ, or a guard of the stick phase touches zero, and the contact goes on as before. Of several contacts others may
    /// change their mode there.
    Touch,
    /// The contact function ([`crate::Filippov::contact`]) falls below zero; the mode goes on.
    ContactLoss,
    /// The contact function rises above zero again; the mode goes on.
    ContactGain,
    /// The state is mapped: [`crate::dynamics::Jumps`]. The transition tells the state before, and
    /// in place of a contact the number of the jump, behind those of the contacts.
    Jump,
}

impl TransitionKind {
    /// What a change of one contact's mode is called. At a transition of several contacts others
    /// may be let go, or stop, too.
    pub fn between(from: Mode, to: Mode) -> Self {
        kind(from, to)
    }
}

/// A transition on Σ, of a system of `N` states.
pub type Transition<const N: usize, K = Mode> = TransitionOf<State<N>, K>;

/// A transition on Σ; `X` is a state, `K` what says the mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransitionOf<X, K> {
    /// Time.
    pub t: f64,
    /// State, on Σ.
    pub x: X,
    /// What happened.
    pub kind: TransitionKind,
    /// Mode before.
    pub from: K,
    /// Mode after.
    pub to: K,
    /// Which contact it began at; 0 where there is one.
    pub contact: usize,
    /// What is left at `(t, x)` of the function whose zero was sought: of the boundary function at the end of a slip, of
    /// the normal component at the end of a stick; of several contacts, of `w (1 − w)` there, with `w` the share of the field above.
    pub residual: f64,
}

/// An accepted step, or the part of one up to an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRecord<const N: usize, K = Mode> {
    /// Mode during the step.
    pub mode: K,
    /// Time at the start.
    pub t_start: f64,
    /// Time at the end.
    pub t_end: f64,
    /// State at the start.
    pub x_start: State<N>,
    /// State at the end.
    pub x_end: State<N>,
    /// The solution in between; good from `t_start` to `t_end`.
    pub dense: Dense<N>,
}

/// Told of everything as it happens, in order of time; memory need not grow with the length of the run.
///
/// Each method may end the run by returning [`ControlFlow::Break`].
///
/// ```
/// use std::ops::ControlFlow;
/// use stickslip::{models::BeltOscillator, run, Observer, Options, State, Transition};
///
/// struct Count(usize);
/// impl Observer<2> for Count {
///     fn transition(&mut self, _: &Transition<2>) -> ControlFlow<()> {
///         self.0 += 1;
///         if self.0 < 5 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
///     }
/// }
/// let mut count = Count(0);
/// run(&BeltOscillator::default(), 0.0, State::from([0.5, 1.5]), 1e9, &Options::default(), &mut count)?;
/// assert_eq!(count.0, 5);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub trait Observer<const N: usize, K = Mode> {
    /// After every accepted step (cut short at an event).
    fn step(&mut self, _step: &StepRecord<N, K>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Whether it is told of steps; by default it is. It may be asked more than once for a step and then answers alike. Where the answer
    /// is no, [`crate::Method::Dop853`] need not make the dense output of steps far from all events, which is a fifth of their calls of the
    /// field, and an ensemble by [`crate::Method::Taylor`] no coefficients of such steps. The orbit is the same either way, but where the field is
    /// not defined at a place that dense output alone asks for: then the step is made shorter.
    fn watches_steps(&self) -> bool {
        true
    }
    /// At every transition, after the steps up to it.
    fn transition(&mut self, _transition: &Transition<N, K>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// After every phase, before the transition that ends it.
    fn phase(&mut self, _phase: &Phase<N, K>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl<O: Observer<N, K> + ?Sized, const N: usize, K> Observer<N, K> for &mut O {
    fn step(&mut self, step: &StepRecord<N, K>) -> ControlFlow<()> {
        (**self).step(step)
    }
    fn watches_steps(&self) -> bool {
        (**self).watches_steps()
    }
    fn transition(&mut self, transition: &Transition<N, K>) -> ControlFlow<()> {
        (**self).transition(transition)
    }
    fn phase(&mut self, phase: &Phase<N, K>) -> ControlFlow<()> {
        (**self).phase(phase)
    }
}

/// Watches nothing.
impl<const N: usize, K> Observer<N, K> for () {
    fn watches_steps(&self) -> bool {
        false
    }
}
