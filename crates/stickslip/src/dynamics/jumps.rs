//! Jumps: maps of the state at zeros of functions of the state.

use super::Vector;
use crate::filippov::{Direction, Options, gradient};
use crate::ode::Timed;
use crate::scalar::Scalar;
use crate::system::{State, components};

/// The jumps of a system of `N` states, and its inputs that kink at known times.
///
/// A jump occurs where its function passes through zero in the required direction, by the motion,
/// by another jump or by a kink. A function that the jump itself leaves at zero triggers no other
/// jump before it has left zero. Simultaneous jumps are carried out in their order. A function of
/// the state that is zero at a start and goes in that direction makes its jump there.
///
/// ```
/// use stickslip::dynamics::{AsDynamics, Jumps, Moment, OrbitProgress, Section, WithJumps};
/// use stickslip::{Direction, Filippov, Options, Scalar, Side, TransitionKind};
///
/// /// A ball that falls, far from a boundary that does nothing.
/// struct Fall;
/// impl Filippov<2> for Fall {
///     fn field<T: Scalar>(&self, _: Side, _t: T, x: &[T; 2]) -> [T; 2] {
///         [x[1], T::constant(-9.81)]
///     }
///     fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 2]) -> T {
///         T::one()
///     }
/// }
/// /// It comes back from the ground with half its speed.
/// struct Bounce;
/// impl Jumps<2> for Bounce {
///     fn count(&self) -> usize {
///         1
///     }
///     fn direction(&self, _: usize) -> Direction {
///         Direction::Falling
///     }
///     fn when<T: Scalar>(&self, _: usize, _t: T, x: &[T; 2]) -> T {
///         x[0]
///     }
///     fn set<T: Scalar>(&self, _: usize, _t: T, x: &[T; 2]) -> [T; 2] {
///         [T::zero(), x[1] * -0.5]
///     }
/// }
/// let ball = WithJumps { system: Fall, jumps: Bounce };
/// let dynamics = ball.dynamics();
/// let start = Moment { t: 0.0, x: vec![1.0, 0.0].into() };
/// let mut orbit = dynamics.begin(&start, 1.0, &Options::default(), &[])?;
/// let first = loop {
///     if let OrbitProgress::Transition(at) = orbit.step()? {
///         break at;
///     }
/// };
/// assert_eq!(first.kind, TransitionKind::Jump);
/// assert!((first.t - (2.0_f64 / 9.81).sqrt()).abs() < 1e-12);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub trait Jumps<const N: usize> {
    /// Number of jumps.
    fn count(&self) -> usize;

    /// The direction in which the function passes through zero at a jump.
    fn direction(&self, _jump: usize) -> Direction {
        Direction::Both
    }

    /// The function at whose zero the jump occurs.
    fn when<T: Scalar>(&self, jump: usize, t: T, x: &[T; N]) -> T;

    /// The state after a jump, from that before it.
    fn set<T: Scalar>(&self, jump: usize, t: T, x: &[T; N]) -> [T; N];

    /// Whether a jump whose function is zero happens, judged once on the state before it. Where it
    /// does not, the orbit goes on as if its function had no zero there. By default it does.
    fn happens(&self, _jump: usize, _t: f64, _x: &[f64; N]) -> bool {
        true
    }

    /// Whether a jump may not happen at a zero of its function. Branches then do not watch the
    /// function within a phase: a zero there says nothing.
    fn is_conditional(&self, _jump: usize) -> bool {
        false
    }

    /// Whether error control resolves the function over a step as it does the state; see
    /// [`crate::EventFunctions::is_as_smooth_as_state`].
    fn is_as_smooth_as_state(&self, _jump: usize) -> bool {
        false
    }

    /// Whether the function is affine; see [`crate::EventFunctions::is_affine`].
    fn is_affine(&self, _jump: usize) -> bool {
        false
    }

    /// Number of occurrences of a jump that ends the run; `None` by default.
    fn most(&self, _jump: usize) -> Option<u64> {
        None
    }

    /// Whether the search looks for the function's zeros. A jump that it does not look for follows
    /// others: see [`Jumps::rests`].
    fn is_searched(&self, _jump: usize) -> bool {
        true
    }

    /// The jump that is carried out where occurrences of this one accumulate, such as an impact's
    /// landing. Its function is the rate of this one's, so that it also follows where that is zero.
    /// By default there is none, and a run that accumulates ends.
    fn rests(&self, _jump: usize) -> Option<usize> {
        None
    }

    /// Whether a jump leaves a function exactly at zero, from where it rises: a body that lifts off
    /// leaves the gap of its stop so.
    fn leaves_at_zero(&self, _jump: usize, _function: usize) -> bool {
        false
    }

    /// Whether the function of a jump is never negative, such as the gap of a stop. No run starts
    /// behind it.
    fn is_never_negative(&self, _jump: usize) -> bool {
        false
    }

    /// The value that the motion from a state keeps for the function of a jump: a stop that carries
    /// keeps its gap closed, and the rate of that zero. By default it keeps none.
    fn kept(&self, _jump: usize, _x: &[f64]) -> Option<f64> {
        None
    }

    /// Whether a choice of this jump hangs on numbers that are equal to rounding, so that a small
    /// change of state or time decides it. By default none does.
    fn is_tied(&self, _jump: usize, _t: f64, _x: &[f64; N]) -> bool {
        false
    }

    /// The comparisons of numbers on which this jump hangs: whether it happens, and what it sets.
    /// By default there are none.
    fn comparisons(&self, _jump: usize, _t: f64, _x: &[f64; N]) -> Vec<Comparison> {
        Vec::new()
    }

    /// The value in a state that says whether a stop carries, if it is neither 0 nor 1 within an
    /// error. By default there are no stops.
    fn half_carried(&self, _x: &[f64], _within: f64) -> Option<f64> {
        None
    }

    /// Opens all stops in a state, whether they carry there or not. A start at rest on one closes
    /// it again. By default there are none.
    fn open(&self, _x: &mut [f64]) {}

    /// Whether the function of a jump is a reaction, which only pushes: a run that starts where it
    /// pulls begins with this jump.
    fn is_reaction(&self, _jump: usize) -> bool {
        false
    }

    /// Whether a reaction whose jump is due ends, from a moment and state that moves with this
    /// velocity. Where several vanish or pull in one instant, the end of one may let another push
    /// again. A reaction that is no larger than `left` is at the zero where it was located. By
    /// default it ends.
    fn lets_go(
        &self,
        _jump: usize,
        _at: (f64, &[f64; N]),
        _velocity: &[f64; N],
        _left: f64,
    ) -> bool {
        true
    }

    /// Whether a component of the state takes discrete values, which jumps set. Tangent vectors
    /// have no component along it.
    fn is_discrete(&self, _state: usize) -> bool {
        false
    }

    /// Whether jumps alone change a component of the state. An equilibrium is sought at its present
    /// value.
    fn is_constant_between_jumps(&self, state: usize) -> bool {
        self.is_discrete(state)
    }

    /// The next time after `t` at which an input may kink; infinite, or after `t_end`, if none does
    /// before that.
    fn next_kink(&self, _t: f64, _x: &[f64], _t_end: f64) -> f64 {
        f64::INFINITY
    }

    /// Number of inputs.
    fn inputs(&self) -> usize {
        0
    }

    /// Whether an input kinks at a time.
    fn kinks(&self, _input: usize, _t: f64, _x: &[f64]) -> bool {
        false
    }

    /// The function of time that decides when an input kinks.
    fn clock<T: Scalar>(&self, _input: usize, t: T, _x: &[T; N]) -> T {
        t
    }

    /// Sets the components of the state that an input holds from `t` to its next kink; to NaN where
    /// its clock is undefined.
    fn hold(&self, _input: usize, _t: f64, _x: &mut [f64]) {}
}

/// The jumps whose functions the motion from a state keeps, with what is off.
pub(super) fn kept<J: Jumps<N>, const N: usize>(
    jumps: &J,
    Timed { t, x }: Timed<N>,
) -> impl Iterator<Item = (usize, f64)> {
    (0..jumps.count()).filter_map(move |jump| {
        let kept = jumps.kept(jump, x.as_slice())?;
        Some((jump, jumps.when(jump, t, components(&x)) - kept))
    })
}

/// Largest change of a jump's function by errors of the first states within the tolerance.
pub(super) fn allowed<J: Jumps<N>, const N: usize>(
    jumps: &J,
    jump: usize,
    at: &Timed<N>,
    (states, options): (usize, &Options),
) -> f64 {
    let (slopes, _) = gradient(|t, x| jumps.when(jump, t, x), at, states);
    let error = State::from_fn(|i, _| options.allowed(i, at.x[i].abs()));
    slopes.abs().dot(&error)
}

/// The state on the stops that carry at a moment, by their landings.
pub(super) fn landed<J: Jumps<N>, const N: usize>(jumps: &J, at: Timed<N>) -> State<N> {
    let landings = kept(jumps, at).filter_map(|(jump, _)| jumps.rests(jump));
    landings.fold(at.x, |x, landing| {
        jumps.set(landing, at.t, components(&x)).into()
    })
}

/// No jumps.
#[derive(Clone, Copy, Debug)]
pub struct NoJumps;

impl<const N: usize> Jumps<N> for NoJumps {
    fn count(&self) -> usize {
        0
    }

    fn when<T: Scalar>(&self, _jump: usize, _t: T, _x: &[T; N]) -> T {
        T::one()
    }

    fn set<T: Scalar>(&self, _jump: usize, _t: T, x: &[T; N]) -> [T; N] {
        *x
    }
}

/// A system with jumps. Every analysis accepts it like the system alone.
#[derive(Clone, Copy, Debug)]
pub struct WithJumps<S, J> {
    /// The system between jumps.
    pub system: S,
    /// The jumps.
    pub jumps: J,
}

/// A comparison of two numbers on which a jump hangs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Number among those of the jump.
    pub number: usize,
    /// The lead of the number that is asked to be larger.
    pub lead: f64,
    /// Size of the terms of the lead.
    pub size: f64,
    /// Largest change of the lead with the states, per unit of their Euclidean distance.
    pub slope: f64,
    /// Whether the opposite result, with all others as they are, would change whether the jump
    /// happens or what it sets. It never is where only discrete states move the lead.
    pub decides: bool,
    /// Whether it is part of the condition of the jump, and not of a choice in what that sets.
    pub is_of_condition: bool,
}

/// The decision about a jump at a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpDecision {
    /// Whether it would happen at a zero of its function there.
    pub happens: bool,
    /// The comparisons on which it hangs.
    pub comparisons: Vec<Comparison>,
}

/// The effect of a jump at a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Reset {
    /// The state after it; not a number where the jump does not happen.
    pub after: Vector,
    /// The derivative of that state by the state before, square in the states.
    pub by_state: super::Matrix,
    /// The derivative of that state by time.
    pub by_time: Vector,
    /// The function that vanishes at it.
    pub value: f64,
    /// The gradient of that function in the state.
    pub gradient: Vector,
    /// The time derivative of that function.
    pub in_time: f64,
    /// The direction in which that function passes through zero at the jump.
    pub direction: Direction,
    /// Whether what it does hangs on numbers that are equal to rounding.
    pub is_tied: bool,
    /// Whether another jump follows where occurrences of this one accumulate.
    pub rests: bool,
    /// Whether it follows another jump in that way: its time is that of the accumulation.
    pub lands: bool,
}

/// The effect on tangent vectors of an input's kink at the end of a step. The time of the kink
/// depends on the state if its clock does.
#[derive(Clone, Debug, PartialEq)]
pub struct KinkShift {
    /// Field after the kink minus field before it.
    pub kick: Vector,
    /// Gradient of the clock in the state.
    pub gradient: Vector,
    /// Rate of the clock along the motion before the kink.
    pub rate: f64,
    /// The kick if the kinks of other inputs at the instant came after this one, minus that if they
    /// came before it. The flow has a derivative by the time between them where it vanishes.
    pub order: Vector,
}
