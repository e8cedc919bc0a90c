//! A system with its solver, with any number of states and contacts: the interface of the analyses.
//!
//! Typed systems ([`Filippov`] or [`Several`]) and systems known only at run time are both
//! [`Dynamics`]. The cost is one virtual call per step, not one per evaluation of the field.

mod batch;
mod carried;
mod event_maps;
mod flow;
mod interrupt;
mod jump_search;
mod jumps;
mod kinds;
mod memory;
mod modes;
mod recorded;
mod run;
mod section;
mod typed;
mod view;

use nalgebra::{DMatrix, DVector};

use crate::error::{Error, Point};
use crate::filippov::{Contacts, Direction, Options, Several};
use crate::filippov::{EventOf, PhaseOf, TransitionOf};
use crate::orbit::{Counters, SummaryOf};
use crate::system::{Filippov, State};

pub use batch::Listener;
pub(crate) use carried::TANGENT_ERROR;
pub(crate) use event_maps::{Carrying, EventMaps, TangentFlow};
pub use interrupt::Interrupt;
pub use jumps::{Comparison, Jumps, WithJumps};
pub(crate) use jumps::{KinkShift, Reset};
use kinds::{AtRunTime, OneContact, OneContactAndJumps, SeveralContacts, SeveralContactsAndJumps};
pub use memory::RunMemory;
pub use modes::Modes;
pub use recorded::{OrbitEvent, RecordedOrbit, Sampling};
pub(crate) use run::observed;
use section::NoSection;
pub use typed::Typed;
pub(crate) use typed::watched;

/// A vector of run-time length: a state, a direction, a gradient.
pub type Vector = DVector<f64>;

/// A matrix of run-time size.
pub type Matrix = DMatrix<f64>;

/// A time and the state at that time.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Moment {
    /// Time.
    pub t: f64,
    /// State.
    pub x: Vector,
}

impl Moment {
    fn new(t: f64, x: &Vector) -> Self {
        Moment { t, x: x.clone() }
    }
}

/// Times of one instant differ by no more, relative to their size. It is the rounding of the time
/// of a kink, which follows from a clock by a difference and a quotient.
const INSTANT: f64 = 1024.0 * f64::EPSILON;

/// The longest time between two events of one instant.
pub(crate) fn instant(t: f64) -> f64 {
    INSTANT * t.abs().max(f64::MIN_POSITIVE / f64::EPSILON)
}

/// Part of an orbit in one mode, between two transitions; its mode includes the jump that ends it.
pub type Phase = PhaseOf<Vector, Modes>;

/// A change of mode, a touch of a boundary, or a loss or gain of contact.
pub type Transition = TransitionOf<Vector, Modes>;

/// A time at which an input kinks, or a time-dependent switch changes its sign.
#[derive(Clone, Debug, PartialEq)]
pub struct Kink {
    /// Time.
    pub t: f64,
    /// State.
    pub x: Vector,
    /// Mode before it.
    pub mode: Modes,
    /// The input, counted from 0.
    pub input: usize,
}

/// A passage of a section.
pub type Passage = EventOf<Vector, Modes>;

/// End of a run, and its work.
pub type Summary = SummaryOf<Vector>;

impl Transition {
    /// Time and state.
    pub fn moment(&self) -> Moment {
        Moment::new(self.t, &self.x)
    }
}

impl Passage {
    /// Time and state.
    pub fn moment(&self) -> Moment {
        Moment::new(self.t, &self.x)
    }
}

/// An accepted step, or the part of one up to an event.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Modes during the step.
    pub mode: Modes,
    /// Time at the start.
    pub t_start: f64,
    /// Time at the end.
    pub t_end: f64,
    /// State at the start.
    pub x_start: Vector,
    /// State at the end.
    pub x_end: Vector,
}

impl Step {
    /// Cuts the step at a moment inside it: returns the part before, and keeps the part after.
    pub(crate) fn cut(&mut self, at: &Moment) -> Step {
        let before = Step {
            t_end: at.t,
            x_end: at.x.clone(),
            ..self.clone()
        };
        (self.t_start, self.x_start) = (at.t, at.x.clone());
        before
    }

    /// The moment at its start.
    pub(crate) fn start(&self) -> Moment {
        Moment::new(self.t_start, &self.x_start)
    }

    /// The moment at its end.
    pub(crate) fn end(&self) -> Moment {
        Moment::new(self.t_end, &self.x_end)
    }
}

/// Progress of an orbit under way; see [`OrbitUnderWay::step`].
#[derive(Clone, Debug, PartialEq)]
pub enum OrbitProgress {
    /// A step was taken.
    Step,
    /// A section was passed in the last step.
    Passage(Passage),
    /// An input kinks at the end of the last step; its consequences are reported afterwards.
    Kink(Kink),
    /// A phase has ended at the end of the last step, or between two jumps in the same instant.
    PhaseEnd(Phase),
    /// The mode changes, or a boundary was touched, at the end of the last step.
    Transition(Transition),
    /// The run has ended; further calls report the same.
    End(Summary),
}

/// A section of the state space whose passages are reported.
#[derive(Clone, Debug, PartialEq)]
pub enum Section {
    /// A plane: `normal · (x − point)` passes through zero.
    Plane {
        /// A state on it.
        point: Vector,
        /// A vector across it, of any length.
        normal: Vector,
        /// Direction of a passage.
        direction: Direction,
    },
    /// A strobe: the times `first`, `first + period`, `first + 2 period`, ….
    Strobe {
        /// Time of a flash.
        first: f64,
        /// Time between two flashes.
        period: f64,
    },
    /// The maxima of the first state, where its rate falls through zero.
    MaximaOfFirstState,
    /// An event function with which the dynamics was constructed, by its number.
    OfSystem(usize),
}

/// Needs of a listener of many orbits at every step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watching<'a> {
    /// Sections whose passages are reported, each by its index.
    pub sections: &'a [Section],
    /// Whether the solution over each step is needed, not only its end.
    pub solutions: bool,
}

/// A guard of a mode: a function that is positive while the mode holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Guard {
    /// Index among the guards of the system.
    pub number: usize,
    /// The contact to which it belongs; for a jump, its number counted after those of the contacts.
    pub contact: usize,
    /// Whether the mode continues after its zero, as where contact is lost.
    pub continues_phase: bool,
    /// Whether the state jumps at its zero.
    pub is_of_jump: bool,
    /// Whether a zero within a phase tells that the phase ends there. The function of a jump that
    /// only follows others, or that has a condition, may pass through zero without any effect.
    pub is_watched: bool,
    /// Whether the state is possible only where it is positive: a contact's guard, a gap, and a
    /// reaction.
    pub is_condition: bool,
    /// Whether it is the reaction of a stop, which lifts off where that would pull: also where it
    /// jumps below zero, or begins there.
    pub is_reaction: bool,
}

/// A system with its solver, with numbers of states and contacts known at run time.
///
/// Only the library's own types implement it: typed systems by [`AsDynamics`], and systems known at
/// run time by [`Typed::padded`].
pub trait Dynamics: EventMaps + Send + Sync {
    /// Number of states.
    fn states(&self) -> usize;

    /// Number of contacts.
    fn contacts(&self) -> usize;

    /// Begins an orbit that reports the passages of sections, each by its index.
    ///
    /// # Errors
    /// Those of [`crate::Integration::new`].
    fn begin<'a>(
        &'a self,
        start: &Moment,
        t_end: f64,
        options: &Options,
        sections: &[Section],
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error>;

    /// Goes on from the end of another run of the same system with the same options. The end has
    /// the bits of a single run, unless the other run ended so near before an event that rounding
    /// moves it. Transitions in the step that the other run's end has shortened are those of a
    /// single run to the tolerance.
    ///
    /// # Errors
    /// Those of [`crate::Integration::new`]; [`Error::Memory`] for a run of another system, and
    /// [`Error::Interval`] if the end is not later than that of the other run.
    fn resume<'a>(
        &'a self,
        from: &RunMemory,
        t_end: f64,
        options: &Options,
        sections: &[Section],
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error>;

    /// Follows the orbit from each start, as [`Dynamics::begin`] begins it, and reports it to the
    /// listener. Items of one orbit come in order, between those of others. An orbit is at an end
    /// when the listener breaks. Returns the error of each orbit that cannot begin.
    ///
    /// With [`crate::Method::Taylor`], orbits of a system from formulas are computed side by side
    /// in vectors. Each is bit-for-bit the same as alone. The solution over a step is available to
    /// the listener where `watching` asks for solutions or has sections. Without it, steps are
    /// faster.
    fn follow_all(
        &self,
        starts: &[Moment],
        t_end: f64,
        options: &Options,
        watching: Watching<'_>,
        listener: &mut Listener<'_>,
    ) -> Vec<Result<(), Error>>;

    /// The smooth flow of a mode, with contact lost or kept as at a moment.
    fn flow<'a>(&'a self, mode: Modes, at: &Moment) -> Box<dyn SmoothFlow + 'a> {
        self.flow_held(mode, at, at.t)
    }

    /// Whether a component of the state takes discrete values, which jumps set.
    fn is_discrete(&self, state: usize) -> bool;

    /// The moment that stops admit next to one of an orbit at another parameter: on the stops that
    /// carry, and in front of the others.
    fn admitted(&self, at: &Moment) -> Moment;
}

impl dyn Dynamics + '_ {
    /// Marks the events of a cycle that are impacts that accumulate before a landing. Their number
    /// is that of the rounding, so that they count as part of the phase that the landing ends. The
    /// jump of each event is given, counted after the contacts.
    pub fn accumulating(&self, jumps: &[Option<usize>]) -> Vec<bool> {
        let count = jumps.len();
        let mut accumulating = vec![false; count];
        for landing in 0..count {
            for back in 1..count {
                let at = (landing + count - back) % count;
                let rest = jumps[at].and_then(|jump| self.rest_after(jump));
                if rest.is_none() || rest != jumps[landing] {
                    break;
                }
                accumulating[at] = true;
            }
        }
        accumulating
    }
}

/// The state at each time of a step.
pub type Solution = Box<dyn Fn(f64) -> Vector + Send + Sync>;

/// An orbit under way, integrated step by step.
pub trait OrbitUnderWay {
    /// Takes the next step and reports it, or reports a consequence of the last one. Each call
    /// reports one item, in order of time.
    ///
    /// # Errors
    /// Those of [`crate::Integration::step`].
    fn step(&mut self) -> Result<OrbitProgress, Error>;

    /// Reports the passages of these sections alone from here on, each by its index.
    fn watch(&mut self, sections: &[Section]);

    /// Keeps what another run needs to go on from the end of this one.
    fn remember(&mut self);

    /// Memory from which another run goes on from the end of this one: after
    /// [`OrbitUnderWay::remember`] before the first step, if this run has reached its end time.
    fn memory(&self) -> Option<RunMemory>;

    /// Present time.
    fn t(&self) -> f64;

    /// Present state.
    fn x(&self) -> &[f64];

    /// The modes of the next step.
    fn mode(&self) -> Modes;

    /// The phase under way so far; `None` between phases.
    fn phase(&self) -> Option<Phase>;

    /// The work done.
    fn counters(&self) -> Counters;

    /// The last step; of zero length before the first.
    fn last_step(&mut self) -> Step;

    /// The solution over the last step.
    fn solution(&mut self) -> Solution;
}

impl dyn OrbitUnderWay + '_ {
    /// Present time and state.
    pub fn now(&self) -> Moment {
        let x = Vector::from_column_slice(self.x());
        Moment { t: self.t(), x }
    }
}

/// The smooth flow of one mode, and the guards that end it.
pub trait SmoothFlow: TangentFlow {
    /// The velocity at a moment.
    fn velocity(&self, at: &Moment) -> Vector;

    /// The guards of the mode.
    fn guards(&self) -> Vec<Guard>;

    /// The value of a guard.
    fn guard(&self, number: usize, at: &Moment) -> f64;

    /// Value and first three time derivatives of a guard along the flow.
    fn guard_jet(&self, number: usize, at: &Moment) -> [f64; 4];
}

/// An owned or borrowed dynamics.
pub enum DynamicsRef<'a> {
    /// Owned.
    Owned(Box<dyn Dynamics + 'a>),
    /// Borrowed.
    Borrowed(&'a dyn Dynamics),
}

impl<'a> std::ops::Deref for DynamicsRef<'a> {
    type Target = dyn Dynamics + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            DynamicsRef::Owned(dynamics) => &**dynamics,
            DynamicsRef::Borrowed(dynamics) => *dynamics,
        }
    }
}

/// The argument of an analysis: a [`Filippov`] system, [`Several`] contacts, either in
/// [`WithJumps`], or a [`DynamicsRef`]. They can be shared between threads. The parameter
/// distinguishes them, and is always inferred.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no system",
    note = "implement `Filippov` for a system of one boundary; one that implements `Contacts` goes \
        in as `Several(system)`"
)]
pub trait AsDynamics<Kind> {
    /// The dynamics.
    fn dynamics(&self) -> DynamicsRef<'_>;
}

impl<S: Filippov<N> + Send + Sync, const N: usize> AsDynamics<OneContact<N>> for S {
    fn dynamics(&self) -> DynamicsRef<'_> {
        DynamicsRef::Owned(Box::new(Typed::<&S, S, _, _, _, N, _>::new(self)))
    }
}

impl<S, const N: usize, const M: usize> AsDynamics<SeveralContacts<N, M>> for Several<S>
where
    S: Contacts<N, M> + Send + Sync,
{
    fn dynamics(&self) -> DynamicsRef<'_> {
        DynamicsRef::Owned(Box::new(Typed::<&Self, Self, _, _, _, N, M>::new(self)))
    }
}

impl<S, J, const N: usize> AsDynamics<OneContactAndJumps<N>> for WithJumps<S, J>
where
    S: Filippov<N> + Send + Sync,
    J: Jumps<N> + Send + Sync,
{
    fn dynamics(&self) -> DynamicsRef<'_> {
        let system = (&self.system, NoSection, &self.jumps);
        let typed = Typed::<&S, S, _, &J, J, N, _>::padded(system, N, 1);
        DynamicsRef::Owned(Box::new(typed))
    }
}

impl<S, J, const N: usize, const M: usize> AsDynamics<SeveralContactsAndJumps<N, M>>
    for WithJumps<Several<S>, J>
where
    S: Contacts<N, M> + Send + Sync,
    J: Jumps<N> + Send + Sync,
{
    fn dynamics(&self) -> DynamicsRef<'_> {
        let system = (&self.system, NoSection, &self.jumps);
        let typed = Typed::<_, Several<S>, _, &J, J, N, M>::padded(system, N, M);
        DynamicsRef::Owned(Box::new(typed))
    }
}

impl<'d> AsDynamics<AtRunTime> for DynamicsRef<'d> {
    fn dynamics(&self) -> DynamicsRef<'_> {
        DynamicsRef::Borrowed(&**self)
    }
}

/// The components of a state: an array, a slice, or a vector of fixed or run-time length.
pub trait Components {
    /// Components as a vector of run-time length.
    fn vector(self) -> Vector;
}

impl<const N: usize> Components for [f64; N] {
    fn vector(self) -> Vector {
        Vector::from_column_slice(&self)
    }
}

impl Components for &[f64] {
    fn vector(self) -> Vector {
        Vector::from_column_slice(self)
    }
}

impl<const N: usize> Components for State<N> {
    fn vector(self) -> Vector {
        Vector::from_column_slice(self.as_slice())
    }
}

impl Components for Vector {
    fn vector(self) -> Vector {
        self
    }
}

impl Components for &Vector {
    fn vector(self) -> Vector {
        self.clone()
    }
}

impl From<&Vector> for Point {
    fn from(x: &Vector) -> Self {
        Point(x.iter().copied().collect())
    }
}

/// Integrates an orbit to its end without reports.
///
/// # Errors
/// Those of [`crate::run`].
pub(crate) fn run(
    dynamics: &dyn Dynamics,
    start: &Moment,
    t_end: f64,
    options: &Options,
) -> Result<Summary, Error> {
    let mut orbit = dynamics.begin(start, t_end, options, &[])?;
    loop {
        if let OrbitProgress::End(summary) = orbit.step()? {
            return Ok(summary);
        }
    }
}
