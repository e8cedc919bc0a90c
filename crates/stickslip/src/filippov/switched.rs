//! The interface between a system and the integration: one smooth flow for each mode, and the mode
//! that follows the end of a flow.

use std::fmt::Debug;
use std::hash::Hash;

use super::flow::{Called, Flow, gradient};
use super::guard::Event;
use super::observer::{Transition, TransitionKind};
use super::options::Options;
use super::run::StepState;
use super::uncertainty::uncertainty;
use crate::dual::Dual;
use crate::dynamics::Modes;
use crate::error::Error;
use crate::interval::Interval;
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::scalar::Scalar;
use crate::system::{Mode, State};

/// A switched system: what [`crate::solve`] and [`crate::run`] take. [`crate::Filippov`] systems
/// are switched systems of one contact, and [`crate::Several`] of several. The trait is sealed.
///
/// `N` is the number of states. `G` is the number of guards, whose zeros end a mode: 3 for a
/// [`crate::Filippov`] system, the number of contacts for [`crate::Several`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no system",
    note = "implement `Filippov` for a system of one boundary; one that implements `Contacts` goes \
        in as `Several(system)`"
)]
pub trait Switched<const N: usize, const G: usize> {
    /// The mode: [`crate::Mode`] for one contact, an array of it for several.
    type Mode: Copy + Debug + PartialEq + Eq + Hash + Send + Sync;

    /// Choice of the flow besides the mode.
    #[doc(hidden)]
    type Branch: Copy + Default + PartialEq + Debug + Send + Sync + Into<f64>;

    /// Whether the user's functions are interpreted.
    #[doc(hidden)]
    const INTERPRETED: bool;

    /// Whether a run can begin.
    #[doc(hidden)]
    fn check(&self, start: &Timed<N>, t_end: f64, options: &Options) -> Result<(), Error>;

    /// The branch of a mode at a point.
    #[doc(hidden)]
    fn branch(&self, mode: Self::Mode, at: &Timed<N>) -> Self::Branch;

    /// The branch from its number.
    #[doc(hidden)]
    fn restored_branch(number: f64) -> Self::Branch;

    /// The branch for the field alone. The field of one contact does not depend on it.
    #[doc(hidden)]
    #[inline(always)]
    fn branch_of_field(&self, mode: Self::Mode, at: &Timed<N>) -> Self::Branch {
        if Self::CONTACTS > 1 {
            self.branch(mode, at)
        } else {
            Self::Branch::default()
        }
    }

    /// Number of components of the state that move, as [`crate::Filippov::dimension`].
    #[doc(hidden)]
    fn dimension(&self) -> usize;

    /// The period of the drive, as [`crate::Filippov::period`].
    #[doc(hidden)]
    fn period(&self, x: &[Dual<f64>; N]) -> Option<Dual<f64>>;

    /// Passes the flow of a mode to `work`.
    #[doc(hidden)]
    fn with_flow<U: UseFlow<N>>(
        &self,
        mode: Self::Mode,
        branch: Self::Branch,
        user: U,
    ) -> U::Output;

    /// The field of a mode in which all contacts slip. It compiles quickly for a further number
    /// type.
    #[doc(hidden)]
    fn slip_field<T: Scalar>(&self, mode: Self::Mode, t: T, x: &[T; N]) -> Option<[T; N]>;

    /// The mode at a start.
    #[doc(hidden)]
    fn first_mode(&self, run: &mut StepState<N, G>) -> Result<Next<Self::Mode, G>, Error>;

    /// The kind of an event that does not end the mode; the branch may change. `None` if the event
    /// ends the mode.
    #[doc(hidden)]
    fn event_within_mode(&self, guard: usize, branch: &mut Self::Branch) -> Option<TransitionKind>;

    /// The mode that follows the end of a mode; the branch may change.
    #[doc(hidden)]
    fn switch(
        &self,
        run: &mut StepState<N, G>,
        from: Self::Mode,
        branch: &mut Self::Branch,
        event: &Event<N>,
    ) -> Result<Next<Self::Mode, G>, Error>;

    /// The guard whose zero made a step too short for the time, if one did.
    #[doc(hidden)]
    fn guard_at_collapse(&self, _run: &StepState<N, G>, _mode: Self::Mode) -> Option<usize> {
        None
    }

    /// The ending in which transitions pile up, if the system has one of its own.
    #[doc(hidden)]
    fn ending_of_pile_up(&self, _run: &StepState<N, G>, _mode: Self::Mode) -> Option<Ending> {
        None
    }

    /// Continues the run from near the point `at`, where transitions of these contacts accumulate,
    /// with all of them in stick. `None` if they cannot all hold there.
    #[doc(hidden)]
    fn stick_at_accumulation(
        &self,
        run: &mut StepState<N, G>,
        mode: Self::Mode,
        contacts: &[usize],
        at: &Timed<N>,
    ) -> Option<StickingPoint<Self::Mode, Self::Branch, N, G>>;

    /// The guard whose zero is the transition, if the field jumps there: then the transition
    /// changes tangent vectors.
    #[doc(hidden)]
    fn discontinuity_guard(&self, at: &Transition<N, Self::Mode>) -> Option<usize>;

    /// Whether no second contact reaches zero at the same time, so that the flow has a derivative.
    #[doc(hidden)]
    fn is_one_at_a_time(&self, _at: &Transition<N, Self::Mode>) -> bool {
        true
    }

    /// The contact that a guard belongs to.
    #[doc(hidden)]
    fn contact_of(_guard: usize) -> usize {
        0
    }

    /// The mode reported for a run that ends at its start because its future is not unique.
    #[doc(hidden)]
    const UNDECIDED: Self::Mode;

    /// The mode by the side that a point lies on; exactly on Σ, stick.
    #[doc(hidden)]
    fn mode_by_side(&self, t: f64, x: &State<N>) -> Self::Mode;

    /// The contacts that stick, and the gradients of their boundary functions in the first
    /// components of the state, whose number is given.
    #[doc(hidden)]
    fn normals(&self, mode: Self::Mode, at: &Timed<N>, states: usize) -> Vec<(usize, State<N>)>;

    /// Number of contacts.
    #[doc(hidden)]
    const CONTACTS: usize;

    /// The modes of the contacts.
    #[doc(hidden)]
    fn of_contacts(mode: &Self::Mode) -> &[Mode];

    /// The mode from the modes of contacts; contacts that are not listed slip above.
    #[doc(hidden)]
    fn restored(modes: Modes) -> Self::Mode;
}

/// Continuation after a start or the end of a mode.
pub enum Next<K, const G: usize> {
    /// A mode, and how many derivatives of each of its guards vanish.
    Mode(K, [usize; G]),
    /// Nothing: the future is not unique.
    End(Ending),
}

/// Newton steps from an extrapolated accumulation point onto the boundaries. Each squares the
/// distance: three reach rounding from a hundredth.
pub(crate) const PROJECTION_STEPS: usize = 3;

/// The point where transitions accumulate, with the contacts that hold there.
pub struct StickingPoint<K, B, const N: usize, const G: usize> {
    pub at: Timed<N>,
    pub to: K,
    pub branch: B,
    /// Number of derivatives of each guard of the mode that vanish.
    pub orders: [usize; G],
    /// The first of the contacts.
    pub contact: usize,
}

/// Work with the flow of a mode.
pub trait UseFlow<const N: usize> {
    type Output;

    /// The work itself, which [`UseFlow::use_flow`] starts.
    fn with<F: Flow<N>>(self, flow: &F) -> Self::Output;

    /// Works with the flow or, where its functions are interpreted, by calls of it.
    #[inline(always)]
    fn use_flow<F: Flow<N>>(self, flow: &F) -> Self::Output
    where
        Self: Sized,
    {
        if const { F::INTERPRETED } {
            self.with(&Called(flow))
        } else {
            self.with(flow)
        }
    }
}

/// The velocity at a point.
pub(crate) struct Velocity<'a, T, const N: usize>(pub T, pub &'a [T; N]);

impl<T: Scalar, const N: usize> UseFlow<N> for Velocity<'_, T, N> {
    type Output = [T; N];

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) -> [T; N] {
        flow.field(self.0, self.1)
    }
}

/// Whether time alone moves the state or a guard: at a point, from its time on.
pub(crate) struct IsDriven<'a, const N: usize>(pub &'a Timed<N>);

impl<const N: usize> UseFlow<N> for IsDriven<'_, N> {
    type Output = bool;

    fn with<F: Flow<N>>(self, flow: &F) -> bool {
        let Timed { t, x } = self.0;
        let x: [Interval; N] = std::array::from_fn(|i| Interval::new(x[i], x[i]));
        let over = |until: f64| {
            let times = Interval::new(*t, until);
            let guards = flow.guards().iter().map(|&i| flow.range(i, times, &x));
            let guards: Option<Vec<_>> = guards.collect();
            guards.zip(Interval::decided(|| flow.field(times, &x)))
        };
        over(f64::INFINITY).is_none_or(|ever| over(*t) != Some(ever))
    }
}

/// Projects a state onto the manifold of the flow.
pub(crate) struct Settled<const N: usize>(pub Timed<N>);

impl<const N: usize> UseFlow<N> for Settled<N> {
    type Output = State<N>;

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) -> State<N> {
        flow.settle(self.0.t, self.0.x)
    }
}

/// Whether the guard of an event vanishes there, as precisely as events are located. It does not
/// where the guard jumps, as at a kink of a boundary.
pub(crate) struct Vanishes<'a, const N: usize>(pub &'a Event<N>, pub &'a Options);

impl<const N: usize> UseFlow<N> for Vanishes<'_, N> {
    type Output = bool;

    fn with<F: Flow<N>>(self, flow: &F) -> bool {
        let Vanishes(event, options) = self;
        let blur = uncertainty(flow, event.guard, &event.at, &options.tolerance());
        event.residual <= blur.zero()
    }
}

/// Gradient of a guard in the first components of the state, whose number is given, and its time
/// derivative.
pub(crate) struct GuardGradient<const N: usize>(pub usize, pub Timed<N>, pub usize);

impl<const N: usize> UseFlow<N> for GuardGradient<N> {
    type Output = (State<N>, f64);

    fn with<F: Flow<N>>(self, flow: &F) -> (State<N>, f64) {
        let GuardGradient(i, at, states) = self;
        gradient(|t, x| flow.guard(i, t, x), &at, states)
    }
}
