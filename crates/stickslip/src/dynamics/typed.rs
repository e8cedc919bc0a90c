//! A system whose numbers of states and contacts are in its type, as [`Dynamics`].

use std::borrow::Borrow;
use std::cell::OnceCell;
use std::marker::PhantomData;

use super::{
    Carrying, Dynamics, Guard, Happening, Modes, Moment, OrbitUnderWay, Passage, Phase, Section,
    SmoothFlow, Solution, Step, Summary, Transition, Vector,
};
use crate::dual::Dual;
use crate::error::Error;
use crate::filippov::{
    Direction, EventFunctions, EventOf, EventRecord, EventSearch, Flow, GuardGradient, Integration,
    Method, Observer, Options, PhaseOf, Progress, Settled, SummaryOf, Switched, TransitionOf,
    UseFlow, Velocity, gradient, tell,
};
use crate::interval::Interval;
use crate::ode::control::squared_error;
use crate::ode::{Dop853, Rk4, RungeKutta, Stages, Timed, Tolerance, stages};
use crate::orbit::Counters;
use crate::scalar::Scalar;
use crate::system::{State, components};

/// An event function of no system's own.
#[derive(Clone, Copy, Debug)]
pub struct NoSection;

impl<const N: usize> EventFunctions<N, 1> for NoSection {
    #[inline(always)]
    fn values<T: Scalar>(&self, _t: T, _x: &[T; N]) -> [T; 1] {
        [T::one()]
    }
}

/// A typed system, owned or borrowed, with an event function of its own.
///
/// The type may have room for more states and contacts than the system has. The other states are
/// zero and stay so; the other contacts slip above and are never at zero.
pub struct Typed<T, S, V, const N: usize, const G: usize> {
    system: T,
    section: V,
    states: usize,
    contacts: usize,
    kind: PhantomData<fn() -> S>,
}

impl<T, S, const N: usize, const G: usize> Typed<T, S, NoSection, N, G>
where
    T: Borrow<S>,
    S: Switched<N, G>,
{
    /// The system with all states and contacts of its type.
    pub fn new(system: T) -> Self {
        Typed::with_section(system, NoSection)
    }
}

impl<T, S, V, const N: usize, const G: usize> Typed<T, S, V, N, G>
where
    T: Borrow<S>,
    S: Switched<N, G>,
{
    /// The system with an event function of its own.
    pub fn with_section(system: T, section: V) -> Self {
        Typed::padded((system, section), N, S::CONTACTS)
    }

    /// A system and its own event function, of fewer states and contacts than the type has room
    /// for: the first ones count.
    pub fn padded((system, section): (T, V), states: usize, contacts: usize) -> Self {
        Typed {
            system,
            section,
            states: states.min(N),
            contacts: contacts.min(S::CONTACTS),
            kind: PhantomData,
        }
    }

    fn view(&self) -> View<'_, S, V, N, G> {
        View {
            system: self.system.borrow(),
            own: &self.section,
            states: self.states,
            contacts: self.contacts,
        }
    }
}

/// A typed system as it is seen from outside: conversions there and back.
struct View<'a, S, V, const N: usize, const G: usize> {
    system: &'a S,
    own: &'a V,
    states: usize,
    contacts: usize,
}

impl<S, V, const N: usize, const G: usize> Clone for View<'_, S, V, N, G> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, V, const N: usize, const G: usize> Copy for View<'_, S, V, N, G> {}

impl<'a, S: Switched<N, G>, V, const N: usize, const G: usize> View<'a, S, V, N, G> {
    /// Of a wrong number of components none is a number, which every run refuses.
    fn state(&self, x: &[f64]) -> State<N> {
        let is_right = x.len() == self.states;
        State::from_fn(|i, _| match x.get(i) {
            _ if i >= self.states => 0.0,
            Some(value) if is_right => *value,
            _ => f64::NAN,
        })
    }

    fn timed(&self, at: &Moment) -> Timed<N> {
        Timed {
            t: at.t,
            x: self.state(at.x.as_slice()),
        }
    }

    fn vector(&self, x: &State<N>) -> Vector {
        Vector::from_column_slice(&x.as_slice()[..self.states])
    }

    fn modes(&self, mode: S::Mode) -> Modes {
        S::erased(mode, self.contacts)
    }

    fn phase(&self, phase: &PhaseOf<State<N>, S::Mode>) -> Phase {
        Phase {
            mode: self.modes(phase.mode),
            t_start: phase.t_start,
            t_end: phase.t_end,
            x_start: self.vector(&phase.x_start),
            x_end: self.vector(&phase.x_end),
        }
    }

    fn transition(&self, at: &TransitionOf<State<N>, S::Mode>) -> Transition {
        Transition {
            t: at.t,
            x: self.vector(&at.x),
            kind: at.kind,
            from: self.modes(at.from),
            to: self.modes(at.to),
            contact: at.contact,
            residual: at.residual,
        }
    }

    fn typed_transition(&self, at: &Transition) -> TransitionOf<State<N>, S::Mode> {
        TransitionOf {
            t: at.t,
            x: self.state(at.x.as_slice()),
            kind: at.kind,
            from: S::restored(at.from),
            to: S::restored(at.to),
            contact: at.contact,
            residual: at.residual,
        }
    }

    fn passage(&self, at: &EventRecord<N, S::Mode>) -> Passage {
        EventOf {
            number: at.number,
            t: at.t,
            x: self.vector(&at.x),
            mode: self.modes(at.mode),
            direction: at.direction,
            rate: at.rate,
        }
    }

    fn summary(&self, summary: &SummaryOf<State<N>>) -> Summary {
        Summary {
            ending: summary.ending,
            t: summary.t,
            x: self.vector(&summary.x),
            counters: summary.counters,
        }
    }

    fn section(&self, section: &Section) -> TypedSection<'a, S, V, N, G> {
        let what = match section {
            Section::None => What::Nothing,
            Section::Plane {
                point,
                normal,
                direction,
            } => What::Plane {
                point: self.state(point.as_slice()),
                normal: self.state(normal.as_slice()),
                direction: *direction,
            },
            Section::Strobe(strobe) => What::Strobe(*strobe),
            Section::Turning => What::Turning,
            Section::Own => What::Own,
        };
        TypedSection {
            system: self.system,
            own: self.own,
            what,
        }
    }
}

impl<T, S, V, const N: usize, const G: usize> Dynamics for Typed<T, S, V, N, G>
where
    T: Borrow<S> + Send + Sync,
    S: Switched<N, G>,
    V: EventFunctions<N, 1> + Send + Sync,
{
    fn states(&self) -> usize {
        self.states
    }

    fn contacts(&self) -> usize {
        self.contacts
    }

    fn begin<'a>(
        &'a self,
        start: &Moment,
        t_end: f64,
        options: &Options,
        section: &Section,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        self.view().begin(start, t_end, options, section)
    }

    fn flow<'a>(&'a self, mode: Modes, at: &Moment) -> Box<dyn SmoothFlow + 'a> {
        let of = self.view();
        Box::new(TypedFlow {
            of,
            mode: S::restored(mode),
            at: of.timed(at),
            branch: OnceCell::new(),
        })
    }

    fn mode_by_side(&self, at: &Moment) -> Modes {
        let of = self.view();
        let Timed { t, x } = of.timed(at);
        of.modes(of.system.mode_by_side(t, &x))
    }

    fn normals(&self, mode: Modes, at: &Moment) -> Vec<(usize, Vector)> {
        if !mode.any_sticks() {
            return Vec::new();
        }
        let of = self.view();
        let normals = of.system.normals(S::restored(mode), &of.timed(at));
        let normals = normals.into_iter();
        normals.map(|(i, normal)| (i, of.vector(&normal))).collect()
    }

    fn jumps_at(&self, at: &Transition) -> Option<usize> {
        let of = self.view();
        of.system.jumps_at(&of.typed_transition(at))
    }

    fn is_one_at_a_time(&self, at: &Transition) -> bool {
        let of = self.view();
        of.system.is_one_at_a_time(&of.typed_transition(at))
    }

    fn undecided(&self) -> Modes {
        self.view().modes(S::UNDECIDED)
    }

    fn section_gradient(&self, section: &Section, at: &Moment) -> (Vector, f64) {
        let of = self.view();
        let section = of.section(section);
        let (normal, in_time) = gradient(|t, x| section.values(t, x)[0], &of.timed(at));
        (of.vector(&normal), in_time)
    }
}

impl<'a, S, V, const N: usize, const G: usize> View<'a, S, V, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
{
    fn begin(
        self,
        start: &Moment,
        t_end: f64,
        options: &Options,
        section: &Section,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        let mut run = self.run(start, t_end, options)?;
        run.watch(section);
        Ok(Box::new(run))
    }

    fn run(
        self,
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Run<'a, S, V, N, G>, Error> {
        let Timed { t, x } = self.timed(start);
        Ok(Run {
            of: self,
            integration: Integration::new(self.system, t, x, t_end, options)
                .map_err(|error| error.of_states(self.states))?
                .of_states(self.states),
            options: *options,
            search: None,
            reported: 0,
            observer: None,
            unobserved: None,
            is_stopping: false,
        })
    }
}

/// An orbit of a borrowed system that an observer is told of as well; of each thing when the next
/// one is asked for.
pub(crate) fn observed<'a, S, const N: usize, const G: usize>(
    system: &'a S,
    (start, t_end): (&Moment, f64),
    options: &Options,
    observer: &'a mut dyn Observer<N, S::Mode>,
) -> Result<Box<dyn OrbitUnderWay + 'a>, Error>
where
    S: Switched<N, G>,
{
    let view = View {
        system,
        own: &NoSection,
        states: N,
        contacts: S::CONTACTS,
    };
    let mut run = view.run(start, t_end, options)?;
    run.observer = Some(observer);
    Ok(Box::new(run))
}

/// An orbit of a borrowed system, of which the passages of a section of its own are reported.
pub(crate) fn watched<'a, S, V, const N: usize, const G: usize>(
    of: &Typed<&'a S, S, &'a V, N, G>,
    start: &Moment,
    options: &Options,
) -> Result<Box<dyn OrbitUnderWay + 'a>, Error>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
{
    let view = View {
        system: of.system,
        own: of.section,
        states: of.states,
        contacts: of.contacts,
    };
    view.begin(start, f64::MAX, options, &Section::Own)
}

/// A section over typed states.
struct TypedSection<'a, S, V, const N: usize, const G: usize> {
    system: &'a S,
    own: &'a V,
    what: What<N>,
}

#[derive(Clone, Copy)]
enum What<const N: usize> {
    Nothing,
    Plane {
        point: State<N>,
        normal: State<N>,
        direction: Direction,
    },
    Strobe(crate::filippov::Strobe),
    Turning,
    Own,
}

impl<S, V, const N: usize, const G: usize> EventFunctions<N, 1> for TypedSection<'_, S, V, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
{
    #[inline(always)]
    fn values<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; 1] {
        match self.what {
            What::Nothing => [T::one()],
            What::Plane { point, normal, .. } => {
                let height = |sum: T, i: usize| sum + (x[i] - point[i]) * normal[i];
                [(0..N).fold(T::zero(), height)]
            }
            What::Strobe(strobe) => strobe.values(t, x),
            What::Turning => {
                let state = State::from(x.map(Scalar::value));
                let mode = self.system.mode_by_side(t.value(), &state);
                let branch = S::Branch::default();
                let velocity = self.system.with_flow(mode, branch, Velocity(t, x));
                [velocity[0]]
            }
            What::Own => self.own.values(t, x),
        }
    }

    fn direction(&self, number: usize) -> Direction {
        match self.what {
            What::Plane { direction, .. } => direction,
            What::Turning => Direction::Falling,
            What::Nothing | What::Strobe(_) => Direction::Both,
            What::Own => self.own.direction(number),
        }
    }
}

/// An integration under way, with the search for passages of a section.
struct Run<'a, S: Switched<N, G>, V, const N: usize, const G: usize> {
    of: View<'a, S, V, N, G>,
    integration: Integration<'a, S, N, G>,
    options: Options,
    search: Option<EventSearch<'a, S, TypedSection<'a, S, V, N, G>, N, 1, G>>,
    /// How many passages of the last step have been reported.
    reported: usize,
    observer: Option<&'a mut dyn Observer<N, S::Mode>>,
    /// What the observer has yet to be told.
    unobserved: Option<Progress<N, S::Mode>>,
    is_stopping: bool,
}

impl<S, V, const N: usize, const G: usize> OrbitUnderWay for Run<'_, S, V, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
{
    fn step(&mut self) -> Result<Happening, Error> {
        if let Some(search) = &self.search
            && let Some(passage) = search.found().get(self.reported)
        {
            self.reported += 1;
            return Ok(Happening::Passage(self.of.passage(passage)));
        }
        if let (Some(observer), Some(progress)) = (&mut self.observer, self.unobserved.take()) {
            let (integration, is_stopping) = (&mut self.integration, &mut self.is_stopping);
            let told = tell(integration, &progress, *observer, is_stopping);
            if let Some(summary) = told.map_err(|error| error.of_states(self.of.states))? {
                return Ok(Happening::End(self.of.summary(&summary)));
            }
        }
        let progress = self.integration.step();
        let progress = progress.map_err(|error| error.of_states(self.of.states))?;
        self.unobserved = self.observer.is_some().then_some(progress);
        Ok(match &progress {
            Progress::Step => {
                if let Some(search) = &mut self.search {
                    search.in_step(&self.integration.last_step());
                    self.reported = 0;
                }
                Happening::Step
            }
            Progress::PhaseEnd(phase) => Happening::PhaseEnd(self.of.phase(phase)),
            Progress::Transition(at) => Happening::Transition(self.of.transition(at)),
            Progress::End(summary) => Happening::End(self.of.summary(summary)),
        })
    }

    fn watch(&mut self, section: &Section) {
        self.reported = 0;
        self.search = (*section != Section::None)
            .then(|| EventSearch::new(self.of.system, self.of.section(section), &self.options));
    }

    fn t(&self) -> f64 {
        self.integration.t()
    }

    fn x(&self) -> &[f64] {
        &self.integration.x().as_slice()[..self.of.states]
    }

    fn mode(&self) -> Modes {
        self.of.modes(self.integration.mode())
    }

    fn phase(&self) -> Option<Phase> {
        let phase = self.integration.phase()?;
        Some(self.of.phase(&phase))
    }

    fn counters(&self) -> Counters {
        *self.integration.counters()
    }

    fn last_step(&mut self) -> Step {
        let step = self.integration.last_step();
        Step {
            mode: self.of.modes(step.mode),
            t_start: step.t_start,
            t_end: step.t_end,
            x_start: self.of.vector(&step.x_start),
            x_end: self.of.vector(&step.x_end),
        }
    }

    fn solution(&mut self) -> Solution {
        let dense = self.integration.last_step().dense;
        let states = self.of.states;
        Box::new(move |t| Vector::from_column_slice(&dense.at_time(t).as_slice()[..states]))
    }
}

/// The flow of one mode of a typed system.
struct TypedFlow<'a, S: Switched<N, G>, V, const N: usize, const G: usize> {
    of: View<'a, S, V, N, G>,
    mode: S::Mode,
    /// Where contact is asked for.
    at: Timed<N>,
    branch: OnceCell<S::Branch>,
}

impl<S, V, const N: usize, const G: usize> TypedFlow<'_, S, V, N, G>
where
    S: Switched<N, G>,
{
    /// The velocity depends on no branch.
    fn of_field<U: UseFlow<N>>(&self, user: U) -> U::Output {
        let branch = S::Branch::default();
        self.of.system.with_flow(self.mode, branch, user)
    }

    fn of_guards<U: UseFlow<N>>(&self, user: U) -> U::Output {
        let system = self.of.system;
        let branch = *self.branch.get_or_init(|| system.branch(&self.at));
        system.with_flow(self.mode, branch, user)
    }

    /// Ranges of all components of the type's state.
    fn ranges(&self, x: &[Interval]) -> [Interval; N] {
        let zero = Interval::around(0.0, 0.0);
        std::array::from_fn(|i| x.get(i).copied().unwrap_or(zero))
    }
}

impl<S, V, const N: usize, const G: usize> SmoothFlow for TypedFlow<'_, S, V, N, G>
where
    S: Switched<N, G>,
{
    fn velocity(&self, at: &Moment) -> Vector {
        let Timed { t, x } = self.of.timed(at);
        let velocity = self.of_field(Velocity(t, components(&x)));
        self.of.vector(&State::from(velocity))
    }

    fn derivative(&self, at: &Moment, along: &Vector) -> Vector {
        let Timed { t, x } = self.of.timed(at);
        let along = self.of.state(along.as_slice());
        let seeded: [_; N] = std::array::from_fn(|i| Dual::new(x[i], along[i]));
        let velocity = self.of_field(Velocity(Dual::new(t, 0.0), &seeded));
        Vector::from_fn(self.of.states, |i, _| velocity[i].eps)
    }

    fn settled(&self, at: &Moment) -> Vector {
        let settled = self.of_field(Settled(self.of.timed(at)));
        self.of.vector(&settled)
    }

    fn guards(&self) -> Vec<Guard> {
        let system = self.of.system;
        let guard = |number: usize| Guard {
            number,
            contact: S::contact_of(number),
            goes_on: system.passed(number, &mut S::Branch::default()).is_some(),
        };
        let guards = self.of_field(Guards).iter().copied().map(guard);
        guards
            .filter(|guard| guard.contact < self.of.contacts)
            .collect()
    }

    fn guard(&self, number: usize, at: &Moment) -> f64 {
        self.of_guards(Value(number, self.of.timed(at)))
    }

    fn guard_gradient(&self, number: usize, at: &Moment) -> (Vector, f64) {
        let (gradient, in_time) = self.of_guards(GuardGradient(number, self.of.timed(at)));
        (self.of.vector(&gradient), in_time)
    }

    fn guard_jet(&self, number: usize, at: &Moment) -> [f64; 4] {
        self.of_guards(Jet(number, self.of.timed(at)))
    }

    fn carried(&self, step: &Step, vector: &Vector, how: Carrying) -> Vector {
        let piece = Piece {
            t: step.t_start,
            x: self.of.state(step.x_start.as_slice()),
            h: step.t_end - step.t_start,
            states: self.of.states,
        };
        let vector = self.of.state(vector.as_slice());
        let tolerance = how.tolerance;
        // A Taylor step is longer than DOP853's would be: halving takes care of that as well.
        // A fixed step stays as it is.
        let carried = match how.method {
            Method::Dop853 | Method::Taylor => self.of_field(Carried::<Dop853, N>::new(
                piece,
                vector,
                MOST_HALVINGS,
                tolerance,
            )),
            Method::Dop853Fixed { .. } => {
                self.of_field(Carried::<Dop853, N>::new(piece, vector, 0, tolerance))
            }
            Method::Rk4 { .. } => {
                self.of_field(Carried::<Rk4, N>::new(piece, vector, 0, tolerance))
            }
        };
        self.of.vector(&carried)
    }

    fn is_clear(&self, t: Interval, x: &[Interval]) -> bool {
        self.of_guards(StaysClear(t, &self.ranges(x)))
    }

    fn velocity_over(&self, t: Interval, x: &[Interval]) -> Option<Vec<Interval>> {
        let x = self.ranges(x);
        let velocity = || self.of.system.slip_field(self.mode, t, &x);
        let mut velocity = Vec::from(Interval::decided(velocity).flatten()?);
        velocity.truncate(self.of.states);
        Some(velocity)
    }

    fn derivative_over(&self, t: Interval, x: &[Interval], by: usize) -> Option<Vec<Interval>> {
        let x = self.ranges(x);
        let [zero, one] = [0.0, 1.0].map(|value| Interval::around(value, 0.0));
        let seeded = std::array::from_fn(|i| Dual::new(x[i], if i == by { one } else { zero }));
        let time = Dual::new(t, zero);
        let velocity = || self.of.system.slip_field(self.mode, time, &seeded);
        let velocity = Interval::decided(velocity).flatten()?;
        let derivatives = velocity.iter().take(self.of.states);
        Some(derivatives.map(|component| component.eps).collect())
    }
}

/// The numbers of the guards.
struct Guards;

impl<const N: usize> UseFlow<N> for Guards {
    type Output = &'static [usize];

    fn with<F: Flow<N>>(self, _flow: &F) -> &'static [usize] {
        F::GUARDS
    }
}

/// The value of a guard.
struct Value<const N: usize>(usize, Timed<N>);

impl<const N: usize> UseFlow<N> for Value<N> {
    type Output = f64;

    fn with<F: Flow<N>>(self, flow: &F) -> f64 {
        flow.guard_at(self.0, self.1.t, &self.1.x)
    }
}

/// Value and derivatives in time of a guard.
struct Jet<const N: usize>(usize, Timed<N>);

impl<const N: usize> UseFlow<N> for Jet<N> {
    type Output = [f64; 4];

    fn with<F: Flow<N>>(self, flow: &F) -> [f64; 4] {
        flow.jet(self.0, self.1.t, &self.1.x)
    }
}

/// Whether no guard comes near zero in a box.
struct StaysClear<'a, const N: usize>(Interval, &'a [Interval; N]);

impl<const N: usize> UseFlow<N> for StaysClear<'_, N> {
    type Output = bool;

    fn with<F: Flow<N>>(self, flow: &F) -> bool {
        F::GUARDS.iter().all(|&i| flow.is_clear(i, self.0, self.1))
    }
}

/// Tolerances per step up to which a tangent vector may be off; a step that is right for the state
/// mostly leaves it within some ten.
const SLACK: f64 = 100.0;

/// Halvings of a step allowed for the sake of a tangent vector.
const MOST_HALVINGS: u32 = 30;

/// A piece of a step: start and length.
struct Piece<const N: usize> {
    t: f64,
    x: State<N>,
    h: f64,
    /// States of the system.
    states: usize,
}

/// A tangent vector to be carried over a piece by method `M`: the piece is run again on dual
/// numbers.
///
/// What the step-size control saw was the error of the state. Where that says nothing of the
/// vector's (a state near rest allows steps of any length) the piece is halved, up to so many
/// times, until the vector is accurate, too.
struct Carried<M, const N: usize> {
    piece: Piece<N>,
    vector: State<N>,
    halvings: u32,
    tolerance: f64,
    method: PhantomData<M>,
}

impl<M, const N: usize> Carried<M, N> {
    fn new(piece: Piece<N>, vector: State<N>, halvings: u32, tolerance: f64) -> Self {
        Carried {
            piece,
            vector,
            halvings,
            tolerance,
            method: PhantomData,
        }
    }
}

impl<M: RungeKutta, const N: usize> UseFlow<N> for Carried<M, N> {
    type Output = State<N>;

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) -> State<N> {
        let (piece, vector) = (&self.piece, &self.vector);
        advanced::<M, F, N>(flow, piece, vector, self.halvings, self.tolerance).1
    }
}

/// State and vector at the end of the piece, halved up to so many times.
fn advanced<M: RungeKutta, F: Flow<N>, const N: usize>(
    flow: &F,
    piece: &Piece<N>,
    vector: &State<N>,
    halvings: u32,
    tolerance: f64,
) -> (State<N>, State<N>) {
    let mut field = |t: Dual<f64>, x: &[Dual<f64>; N]| flow.field(t, x);
    let start: [_; N] = std::array::from_fn(|i| Dual::new(piece.x[i], vector[i]));
    let (t, h) = (Dual::new(piece.t, 0.0), Dual::new(piece.h, 0.0));
    let slope = field(t, &start);
    let step = stages::<M, _, _>(&mut field, t, &start, slope, h);
    let end = (
        State::from(step.end.map(|v| v.re)),
        State::from(step.end.map(|v| v.eps)),
    );
    // Where there is nothing to carry, or nothing finite, halving is of no use.
    let size = vector.norm();
    if halvings == 0 || size == 0.0 || !size.is_finite() {
        return end;
    }
    let of_vector = Stages {
        k: step.k.map(|k| State::from(k.map(|v| v.eps))),
        end: end.1,
    };
    let allowed = Tolerance {
        rtol: 0.0,
        atol: tolerance * size,
    };
    let error = squared_error::<M, N>(&of_vector, vector, piece.h, (&allowed, piece.states));
    // Not a number where the piece is so long that its stages overflow.
    if error <= SLACK * SLACK {
        return end;
    }
    let half = 0.5 * piece.h;
    let first = Piece { h: half, ..*piece };
    let (x, between) = advanced::<M, F, N>(flow, &first, vector, halvings - 1, tolerance);
    let second = Piece {
        t: piece.t + half,
        x,
        ..first
    };
    advanced::<M, F, N>(flow, &second, &between, halvings - 1, tolerance)
}
