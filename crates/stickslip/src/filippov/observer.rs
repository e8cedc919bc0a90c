//! Reports of a run to an observer: steps, transitions, phases.

use std::ops::{ControlFlow, Sub};

use crate::ode::Dense;
use crate::system::{Mode, State};

/// A part of an orbit in one mode, between two transitions, of a system of `N` states.
pub type Phase<const N: usize, K = Mode> = PhaseOf<State<N>, K>;

/// A part of an orbit in one mode, between two transitions. `X` is a state, `K` a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PhaseOf<X, K> {
    /// Slip below, slip above, or stick; for several contacts, each one's.
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

    /// Change of the state over the phase. For a body on a belt of speed `vp` the position's change
    /// in a stick phase is `vp · duration`.
    pub fn displacement(&self) -> X
    where
        for<'x> &'x X: Sub<Output = X>,
    {
        &self.x_end - &self.x_start
    }
}

/// Kind of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TransitionKind {
    /// Slip on one side passes through Σ to slip on the other: the orbit kinks.
    Crossing,
    /// Slip becomes stick.
    StickEntry,
    /// Stick becomes slip: at a tangent point, or across Σ where static friction is more than
    /// kinetic.
    StickExit,
    /// Slip touches Σ, or a guard of the stick phase touches zero, and the contact's mode remains.
    /// Other contacts may change their mode there.
    Touch,
    /// The contact function ([`crate::Filippov::contact`]) falls below zero; the mode remains.
    ContactLoss,
    /// The contact function rises above zero again; the mode remains.
    ContactGain,
    /// The state is mapped: [`crate::dynamics::Jumps`]. The transition has the state before the
    /// jump. In place of a contact it has the number of the jump plus the number of contacts.
    Jump,
}

impl TransitionKind {
    /// Name, for tables.
    pub fn name(self) -> &'static str {
        match self {
            TransitionKind::Crossing => "crossing",
            TransitionKind::StickEntry => "stick entry",
            TransitionKind::StickExit => "stick exit",
            TransitionKind::Touch => "touch",
            TransitionKind::ContactLoss => "contact loss",
            TransitionKind::ContactGain => "contact gain",
            TransitionKind::Jump => "jump",
        }
    }

    /// Kind of a change of one contact's mode. At a transition of several contacts, others may be
    /// released or stop, too.
    pub fn between(from: Mode, to: Mode) -> Self {
        match (from, to) {
            (Mode::Slip(before), Mode::Slip(after)) if before != after => TransitionKind::Crossing,
            (Mode::Slip(_), Mode::Stick) => TransitionKind::StickEntry,
            (Mode::Stick, Mode::Slip(_)) => TransitionKind::StickExit,
            _ => TransitionKind::Touch,
        }
    }
}

/// A transition on Σ, of a system of `N` states.
pub type Transition<const N: usize, K = Mode> = TransitionOf<State<N>, K>;

/// A transition on Σ. `X` is a state, `K` a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransitionOf<X, K> {
    /// Time.
    pub t: f64,
    /// State, on Σ.
    pub x: X,
    /// Kind of the transition.
    pub kind: TransitionKind,
    /// Mode before.
    pub from: K,
    /// Mode after.
    pub to: K,
    /// The contact at which it began; 0 if there is one.
    pub contact: usize,
    /// Residual at `(t, x)` of the function whose zero was located. It is the boundary function at
    /// the end of a slip, and the normal component at the end of a stick. With several contacts it
    /// is `w (1 − w)` at the end of a stick, with `w` the weight of the field above.
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
    /// The solution in between, valid from `t_start` to `t_end`.
    pub dense: Dense<N>,
}

/// Receives everything as it happens, in order of time. Memory need not grow with the length of the
/// run.
///
/// Each method may end the run by returning [`ControlFlow::Break`].
///
/// ```
#[doc = include_str!("../../examples/common/belt.rs")]
/// use std::ops::ControlFlow;
/// use stickslip::{Observer, Options, State, Transition, run};
///
/// struct Count(usize);
/// impl Observer<2> for Count {
///     fn transition(&mut self, _: &Transition<2>) -> ControlFlow<()> {
///         self.0 += 1;
///         if self.0 < 5 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
///     }
/// }
/// let mut count = Count(0);
/// let (belt, start) = (Belt { speed: 1.0 }, State::from([0.5, 1.5]));
/// run(&belt, 0.0, start, 1e9, &Options::default(), &mut count)?;
/// assert_eq!(count.0, 5);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub trait Observer<const N: usize, K = Mode> {
    /// Called after every accepted step (cut short at an event).
    fn step(&mut self, _step: &StepRecord<N, K>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Whether it wants steps; by default it does. The answer must not change within a step.
    /// Without observed steps, [`crate::Method::Dop853`] omits the dense output of steps far from
    /// all events, a fifth of the calls of the field. An ensemble with [`crate::Method::Taylor`]
    /// omits the coefficients of such steps. The orbit is the same, except where the field is
    /// undefined at a point that only dense output evaluates: then the step is shortened.
    fn watches_steps(&self) -> bool {
        true
    }
    /// Called at every transition, after the steps up to it.
    fn transition(&mut self, _transition: &Transition<N, K>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Called after every phase, before the transition that ends it.
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

/// Observes nothing.
impl<const N: usize, K> Observer<N, K> for () {
    fn watches_steps(&self) -> bool {
        false
    }
}
