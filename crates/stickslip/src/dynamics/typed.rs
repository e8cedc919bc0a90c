//! A system whose numbers of states and contacts are in its type, as [`Dynamics`].

use std::borrow::Borrow;
use std::marker::PhantomData;

use super::flow::TypedFlow;
use super::{
    Dynamics, Happening, Modes, Moment, OrbitUnderWay, Passage, Phase, Section, SmoothFlow,
    Solution, Step, Summary, Transition, Vector,
};
use crate::error::Error;
use crate::filippov::{
    Direction, EventFunctions, EventOf, EventRecord, EventSearch, Integration, Observer, Options,
    PhaseOf, Progress, Strobe, SummaryOf, Switched, TransitionOf, Velocity, gradient, tell,
};
use crate::ode::Timed;
use crate::orbit::Counters;
use crate::scalar::Scalar;
use crate::system::State;

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
pub(super) struct View<'a, S, V, const N: usize, const G: usize> {
    pub(super) system: &'a S,
    own: &'a V,
    pub(super) states: usize,
    pub(super) contacts: usize,
}

impl<S, V, const N: usize, const G: usize> Clone for View<'_, S, V, N, G> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, V, const N: usize, const G: usize> Copy for View<'_, S, V, N, G> {}

impl<'a, S: Switched<N, G>, V, const N: usize, const G: usize> View<'a, S, V, N, G> {
    /// Of a wrong number of components none is a number, which every run refuses.
    pub(super) fn state(&self, x: &[f64]) -> State<N> {
        let is_right = x.len() == self.states;
        State::from_fn(|i, _| match x.get(i) {
            _ if i >= self.states => 0.0,
            Some(value) if is_right => *value,
            _ => f64::NAN,
        })
    }

    pub(super) fn timed(&self, at: &Moment) -> Timed<N> {
        Timed {
            t: at.t,
            x: self.state(at.x.as_slice()),
        }
    }

    pub(super) fn vector(&self, x: &State<N>) -> Vector {
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

    fn begin_in<'a>(
        &'a self,
        (mode, inside): (Modes, &Moment),
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        let of = self.view();
        let held = (S::restored(mode), &of.timed(inside));
        let start = of.timed(start);
        let integration = Integration::held(of.system, held, start, t_end, options);
        Ok(Box::new(of.run(integration, options)?))
    }

    fn flow<'a>(&'a self, mode: Modes, at: &Moment) -> Box<dyn SmoothFlow + 'a> {
        Box::new(TypedFlow::new(self.view(), mode, at))
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
        let mut run = self.run(self.integration(start, t_end, options), options)?;
        run.watch(section);
        Ok(Box::new(run))
    }

    fn integration(
        self,
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Integration<'a, S, N, G>, Error> {
        let Timed { t, x } = self.timed(start);
        Integration::new(self.system, t, x, t_end, options)
    }

    fn run(
        self,
        integration: Result<Integration<'a, S, N, G>, Error>,
        options: &Options,
    ) -> Result<Run<'a, S, V, N, G>, Error> {
        let integration = integration.map_err(|error| error.of_states(self.states))?;
        Ok(Run {
            of: self,
            integration: integration.of_states(self.states),
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
    let mut run = view.run(view.integration(start, t_end, options), options)?;
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
    Strobe(Strobe),
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
