//! The needs of the analyses besides runs: the linear maps of steps, events and jumps.

use super::jumps::{JumpDecision, KinkShift, Reset};
use super::{Modes, Moment, OrbitUnderWay, Section, SmoothFlow, Step, Transition, Vector};
use crate::error::Error;
use crate::filippov::{Method, Options};
use crate::interval::Interval;

/// The maps of events of a system, with their derivatives.
pub trait EventMaps {
    /// Begins an orbit that stays in a mode to its end regardless of the guards, with contact lost
    /// or kept as at `inside`.
    ///
    /// # Errors
    /// Those of [`crate::Integration::new`].
    fn begin_in<'a>(
        &'a self,
        mode: (Modes, &Moment),
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error>;

    /// The smooth flow of a mode, with the values that inputs hold from the time `held` on.
    fn flow_held<'a>(&'a self, mode: Modes, at: &Moment, held: f64) -> Box<dyn SmoothFlow + 'a>;

    /// The contacts that stick in a mode, with the gradients of their boundary functions.
    fn normals(&self, mode: Modes, at: &Moment) -> Vec<(usize, Vector)>;

    /// The functions that the motion keeps besides those of contacts that stick: the gaps of stops
    /// that carry, and their rates. What each is off, with its gradient.
    fn kept(&self, at: &Moment) -> Vec<(f64, Vector)>;

    /// The numbers of the jumps that put a state on the stops that carry there.
    fn landings(&self, at: &Moment) -> Vec<usize>;

    /// The guard whose zero a transition is, where the field jumps there.
    fn discontinuity_guard(&self, at: &Transition) -> Option<usize>;

    /// Whether no second contact comes to zero in the same instant.
    fn is_one_at_a_time(&self, at: &Transition) -> bool;

    /// The period of the drive with its gradient in the state, where it depends on that.
    fn period(&self, x: &Vector) -> Option<(f64, Vector)>;

    /// Whether jumps alone change a component of the state.
    fn is_constant_between_jumps(&self, state: usize) -> bool;

    /// The first input that kinks at a moment, if one does.
    fn kink(&self, at: &Moment) -> Option<usize> {
        self.kinks(at).first().copied()
    }

    /// The inputs that kink at a moment.
    fn kinks(&self, at: &Moment) -> Vec<usize>;

    /// The effect of kinks of inputs at the end of a step on tangent vectors; none where no clock
    /// depends on the state.
    fn kink_shifts(&self, step: &Step) -> Vec<KinkShift>;

    /// The clock that decides when an input kinks: value, gradient in the state, time derivative.
    fn clock(&self, input: usize, at: &Moment) -> (f64, Vector, f64);

    /// The effect of a jump at a moment before it. Its number is counted after those of the
    /// contacts, as in its transitions.
    fn reset(&self, number: usize, at: &Moment) -> Reset {
        self.reset_held(number, at, at.t)
    }

    /// The effect of a jump, with the values that inputs hold from the time `held` on.
    fn reset_held(&self, number: usize, at: &Moment, held: f64) -> Reset;

    /// The effect of a jump at a moment, whether or not its condition holds there.
    fn map(&self, number: usize, at: &Moment) -> Reset;

    /// The decision about a jump at a moment. Its number is counted after those of the contacts.
    fn decision(&self, number: usize, at: &Moment) -> JumpDecision;

    /// The state with all stops open. A run from there decides anew which of them carry, as is
    /// needed where a state is moved by hand.
    fn opened(&self, x: Vector) -> Vector;

    /// The jump that follows where occurrences of a jump accumulate, such as the landing of a stop
    /// for its impact. Both numbers are counted after those of the contacts.
    fn rest_after(&self, number: usize) -> Option<usize>;

    /// Gradient of a section's function in the state, and its time derivative.
    fn section_gradient(&self, section: &Section, at: &Moment) -> (Vector, f64);
}

/// Settings for carrying tangent vectors over a step.
#[derive(Clone, Copy, Debug)]
pub struct Carrying {
    /// Method of the run.
    pub method: Method,
    /// Target error in a step, relative to the vector's size.
    pub tolerance: f64,
}

/// The flow of tangent vectors, and bounds of the flow.
pub trait TangentFlow {
    /// Number of components that move, the first ones. Corrections move no others.
    fn moving(&self) -> usize;

    /// The derivative of the velocity along a vector of the state space, at a fixed time.
    fn derivative(&self, at: &Moment, along: &Vector) -> Vector;

    /// The divergence of the velocity, the trace of its derivative.
    fn divergence(&self, at: &Moment) -> f64;

    /// The state, corrected for the rounding that displaces it from the invariant set of the flow.
    fn projected(&self, at: &Moment) -> Vector;

    /// Gradient of a guard in the state, and its time derivative.
    fn guard_gradient(&self, number: usize, at: &Moment) -> (Vector, f64);

    /// Tangent vectors at the end of a step, from those at its start. Each has the bits that it has
    /// alone; together they share the values of the field.
    fn transport(&self, step: &Step, vectors: &[Vector], how: Carrying) -> Vec<Vector>;

    /// Whether all guards are certain to stay positive over intervals of times and states.
    fn is_clear(&self, t: Interval, x: &[Interval]) -> bool;

    /// Bounds of the velocity over intervals of times and states; `None` where a contact sticks, or
    /// where the intervals do not decide a branch of the field.
    fn velocity_over(&self, t: Interval, x: &[Interval]) -> Option<Vec<Interval>>;

    /// Bounds of the velocity's derivative by one component of the state; `None` as before.
    fn derivative_over(&self, t: Interval, x: &[Interval], by: usize) -> Option<Vec<Interval>>;
}
