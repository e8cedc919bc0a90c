//! A system whose numbers of states and contacts are in its type, as [`Dynamics`].

use std::borrow::Borrow;
use std::collections::VecDeque;
use std::marker::PhantomData;

use super::flow::TypedFlow;
use super::jumps::{Jumping, Jumps, NoJumps, Reset};
use super::{
    Dynamics, Happening, Matrix, Modes, Moment, OrbitUnderWay, Passage, Phase, Section, SmoothFlow,
    Solution, Step, Summary, Transition, Vector,
};
use crate::dual::Dual;
use crate::error::Error;
use crate::filippov::{
    Direction, EventFunctions, EventOf, EventRecord, EventSearch, Integration, Observer, Options,
    PhaseOf, Progress, Stepper, Strobe, SummaryOf, Switched, TransitionKind, TransitionOf,
    Velocity, gradient, tell,
};
use crate::ode::Timed;
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
pub struct Typed<T, S, V, J, const N: usize, const G: usize> {
    system: T,
    section: V,
    jumps: J,
    states: usize,
    contacts: usize,
    kind: PhantomData<fn() -> S>,
}

impl<T, S, const N: usize, const G: usize> Typed<T, S, NoSection, NoJumps, N, G>
where
    T: Borrow<S>,
    S: Switched<N, G>,
{
    /// The system with all states and contacts of its type.
    pub fn new(system: T) -> Self {
        Typed::with_section(system, NoSection)
    }
}

impl<T, S, V, const N: usize, const G: usize> Typed<T, S, V, NoJumps, N, G>
where
    T: Borrow<S>,
    S: Switched<N, G>,
{
    /// The system with an event function of its own.
    pub fn with_section(system: T, section: V) -> Self {
        Typed::padded((system, section, NoJumps), N, S::CONTACTS)
    }
}

impl<T, S, V, J, const N: usize, const G: usize> Typed<T, S, V, J, N, G>
where
    T: Borrow<S>,
    S: Switched<N, G>,
{
    /// A system, its own event function and its jumps, of fewer states and contacts than the type
    /// has room for: the first ones count.
    pub fn padded((system, section, jumps): (T, V, J), states: usize, contacts: usize) -> Self {
        Typed {
            system,
            section,
            jumps,
            states: states.min(N),
            contacts: contacts.min(S::CONTACTS),
            kind: PhantomData,
        }
    }

    fn view(&self) -> View<'_, S, V, J, N, G> {
        View {
            system: self.system.borrow(),
            own: &self.section,
            jumps: &self.jumps,
            states: self.states,
            contacts: self.contacts,
        }
    }
}

/// A typed system as it is seen from outside: conversions there and back.
pub(super) struct View<'a, S, V, J, const N: usize, const G: usize> {
    pub(super) system: &'a S,
    own: &'a V,
    pub(super) jumps: &'a J,
    pub(super) states: usize,
    pub(super) contacts: usize,
}

impl<S, V, J, const N: usize, const G: usize> Clone for View<'_, S, V, J, N, G> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, V, J, const N: usize, const G: usize> Copy for View<'_, S, V, J, N, G> {}

impl<'a, S, V, J, const N: usize, const G: usize> View<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    J: Jumps<N>,
{
    /// Of a wrong number of components none is a number, which every run refuses.
    pub(super) fn state(&self, x: &[f64]) -> State<N> {
        let is_right = x.len() == self.states;
        State::from_fn(|i, _| match x.get(i) {
            _ if i >= self.states => 0.0,
            Some(value) if is_right => *value,
            _ => f64::NAN,
        })
    }

    /// With what inputs hold at that time.
    pub(super) fn timed(&self, at: &Moment) -> Timed<N> {
        let (t, mut x) = (at.t, self.state(at.x.as_slice()));
        self.jumps.hold(t, x.as_mut_slice());
        Timed { t, x }
    }

    pub(super) fn vector(&self, x: &State<N>) -> Vector {
        Vector::from_column_slice(&x.as_slice()[..self.states])
    }

    fn modes(&self, mode: S::Mode) -> Modes {
        S::erased(mode, self.contacts)
    }

    pub(super) fn phase(&self, phase: &PhaseOf<State<N>, S::Mode>) -> Phase {
        Phase {
            mode: self.modes(phase.mode),
            t_start: phase.t_start,
            t_end: phase.t_end,
            x_start: self.vector(&phase.x_start),
            x_end: self.vector(&phase.x_end),
        }
    }

    pub(super) fn transition(&self, at: &TransitionOf<State<N>, S::Mode>) -> Transition {
        Transition {
            t: at.t,
            x: self.vector(&at.x),
            kind: at.kind,
            from: self.modes(at.from),
            to: self.modes(at.to),
            contact: match at.kind {
                TransitionKind::Jump => self.contacts + at.contact,
                _ => at.contact,
            },
            residual: at.residual,
        }
    }

    fn typed_transition(&self, at: &Transition) -> TransitionOf<State<N>, S::Mode> {
        TransitionOf {
            t: at.t,
            x: self.timed(&at.moment()).x,
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

    fn section(&self, section: &Section) -> TypedSection<'a, S, V, J, N, G> {
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
        self.function(what)
    }

    fn function(&self, what: What<N>) -> TypedSection<'a, S, V, J, N, G> {
        TypedSection {
            system: self.system,
            own: self.own,
            jumps: self.jumps,
            what,
        }
    }

    /// The function of a jump.
    pub(super) fn when(&self, jump: usize) -> TypedSection<'a, S, V, J, N, G> {
        self.function(What::Jump(jump))
    }
}

impl<T, S, V, J, const N: usize, const G: usize> Dynamics for Typed<T, S, V, J, N, G>
where
    T: Borrow<S> + Send + Sync,
    S: Switched<N, G>,
    V: EventFunctions<N, 1> + Send + Sync,
    J: Jumps<N> + Send + Sync,
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
        let start = (of.timed(start), of.states);
        let integration = Integration::held(of.system, held, start, t_end, options);
        Ok(Box::new(of.run(integration, t_end, options)?))
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

    fn jumps(&self) -> usize {
        self.jumps.count()
    }

    fn is_discrete(&self, state: usize) -> bool {
        self.jumps.is_discrete(state)
    }

    fn kink(&self, at: &Moment) -> Option<usize> {
        let Timed { t, x } = self.view().timed(at);
        self.jumps.kinked(t, components(&x))
    }

    fn clock(&self, input: usize, at: &Moment) -> (f64, Vector, f64) {
        let (of, at) = (self.view(), self.view().timed(at));
        let (slopes, in_time) = gradient(|t, x| self.jumps.clock(input, t, x), &at);
        let value = self.jumps.clock(input, at.t, components(&at.x));
        (value, of.vector(&slopes), in_time)
    }

    fn reset(&self, number: usize, at: &Moment) -> Reset {
        let (of, jump) = (self.view(), number - self.contacts);
        let Timed { t, x } = of.timed(at);
        let states = self.states;
        // Column `states` is the derivative by time.
        let along = |k: usize| {
            let seed = |is_it: bool| f64::from(u8::from(is_it));
            let x = std::array::from_fn(|i| Dual::new(x[i], seed(i == k)));
            self.jumps.set(jump, Dual::new(t, seed(k == states)), &x)
        };
        let by_state = (0..states).map(along);
        let columns: Vec<Vector> = by_state
            .chain([along(states)])
            .map(|column| Vector::from_fn(states, |i, _| column[i].eps))
            .collect();
        let (gradient, in_time) = match self.jumps.kinked(t, components(&x)) {
            Some(input) => gradient(|t, x| self.jumps.clock(input, t, x), &Timed { t, x }),
            None => gradient(|t, x| self.jumps.when(jump, t, x), &Timed { t, x }),
        };
        Reset {
            after: of.vector(&self.jumps.set(jump, t, components(&x)).into()),
            by_state: Matrix::from_fn(states, states, |i, j| columns[j][i]),
            by_time: columns[states].clone(),
            value: self.jumps.when(jump, t, components(&x)),
            gradient: of.vector(&gradient),
            in_time,
        }
    }

    fn section_gradient(&self, section: &Section, at: &Moment) -> (Vector, f64) {
        let of = self.view();
        let section = of.section(section);
        let (normal, in_time) = gradient(|t, x| section.values(t, x)[0], &of.timed(at));
        (of.vector(&normal), in_time)
    }
}

impl<'a, S, V, J, const N: usize, const G: usize> View<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
    J: Jumps<N>,
{
    fn begin(
        self,
        start: &Moment,
        t_end: f64,
        options: &Options,
        section: &Section,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        let integration = self.integration(start, t_end, options);
        let mut run = self.run(integration, t_end, options)?;
        run.watch(section);
        Ok(Box::new(run))
    }

    fn integration(
        self,
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Integration<'a, S, N, G>, Error> {
        let (start, stepper) = (self.timed(start), Stepper::new(options));
        Integration::with_stepper(self.system, (start, self.states), t_end, options, stepper)
    }

    fn run(
        self,
        integration: Result<Integration<'a, S, N, G>, Error>,
        t_end: f64,
        options: &Options,
    ) -> Result<Run<'a, S, V, J, N, G>, Error> {
        let mut integration = integration.map_err(|error| error.of_states(self.states))?;
        Ok(Run {
            of: self,
            jumping: Jumping::of(&self, &mut integration, options, t_end),
            told: VecDeque::new(),
            integration,
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
        jumps: &NoJumps,
        states: N,
        contacts: S::CONTACTS,
    };
    let mut run = view.run(view.integration(start, t_end, options), t_end, options)?;
    run.observer = Some(observer);
    Ok(Box::new(run))
}

/// An orbit of a borrowed system, of which the passages of a section of its own are reported.
pub(crate) fn watched<'a, S, V, const N: usize, const G: usize>(
    of: &Typed<&'a S, S, &'a V, NoJumps, N, G>,
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
        jumps: &NoJumps,
        states: of.states,
        contacts: of.contacts,
    };
    view.begin(start, f64::MAX, options, &Section::Own)
}

/// A section over typed states.
pub(super) struct TypedSection<'a, S, V, J, const N: usize, const G: usize> {
    system: &'a S,
    own: &'a V,
    jumps: &'a J,
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
    Jump(usize),
}

impl<S, V, J, const N: usize, const G: usize> EventFunctions<N, 1>
    for TypedSection<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
    J: Jumps<N>,
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
            What::Jump(number) => [self.jumps.when(number, t, x)],
        }
    }

    fn direction(&self, number: usize) -> Direction {
        match self.what {
            What::Plane { direction, .. } => direction,
            What::Turning => Direction::Falling,
            What::Nothing | What::Strobe(_) => Direction::Both,
            What::Own => self.own.direction(number),
            What::Jump(number) => self.jumps.direction(number),
        }
    }
}

/// An integration under way, with the search for passages of a section.
struct Run<'a, S: Switched<N, G>, V, J, const N: usize, const G: usize> {
    of: View<'a, S, V, J, N, G>,
    integration: Integration<'a, S, N, G>,
    /// Of a system with jumps or inputs.
    jumping: Option<Jumping<'a, S, V, J, N, G>>,
    /// What is reported before the run goes on.
    told: VecDeque<Happening>,
    options: Options,
    search: Option<EventSearch<'a, S, TypedSection<'a, S, V, J, N, G>, N, 1, G>>,
    /// How many passages of the last step have been reported.
    reported: usize,
    observer: Option<&'a mut dyn Observer<N, S::Mode>>,
    /// What the observer has yet to be told.
    unobserved: Option<Progress<N, S::Mode>>,
    is_stopping: bool,
}

impl<S, V, J, const N: usize, const G: usize> Run<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
    J: Jumps<N>,
{
    fn has_kinked(&self, t: f64) -> bool {
        let jumping = self.jumping.as_ref();
        jumping.is_some_and(|jumping| jumping.has_kinked(t))
    }

    /// Whether an input kinks here and what it sets off is not done yet. The state at such a time is
    /// that behind it, from which a run goes on.
    fn is_settling(&self, t: f64) -> bool {
        let is_here = |jumping: &Jumping<'_, S, V, J, N, G>| {
            let is_under_way = jumping.has_kinked(t) && jumping.is_due();
            t == self.integration.t() && (jumping.is_at_kink(&self.integration) || is_under_way)
        };
        self.jumping.as_ref().is_some_and(is_here) || !self.told.is_empty()
    }

    /// Does what is due between two steps of a run with jumps or inputs.
    fn leap(&mut self) -> Result<Option<Happening>, Error> {
        let Some(jumping) = &mut self.jumping else {
            return Ok(None);
        };
        while self.told.is_empty() {
            if jumping.is_due() {
                // The phase before it is reported first.
                if self.integration.ends_phase() {
                    return Ok(None);
                }
                let jump = jumping.jump(&mut self.integration)?;
                if let Some(search) = &mut self.search {
                    search.set_side(0.0);
                }
                return Ok(jump.map(|at| Happening::Transition(self.of.transition(&at))));
            }
            if !jumping.is_at_kink(&self.integration) {
                return Ok(None);
            }
            jumping.pass_kink(&mut self.integration, &self.of, &mut self.told)?;
        }
        Ok(self.told.pop_front())
    }
}

impl<S, V, J, const N: usize, const G: usize> OrbitUnderWay for Run<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
    J: Jumps<N>,
{
    fn step(&mut self) -> Result<Happening, Error> {
        if let Some(search) = &self.search
            && let Some(passage) = search.found().get(self.reported)
            && !self.is_settling(passage.t)
        {
            self.reported += 1;
            let mut passage = *passage;
            if passage.t == self.integration.t() && self.has_kinked(passage.t) {
                (passage.x, passage.mode) = (*self.integration.x(), self.integration.mode());
            }
            return Ok(Happening::Passage(self.of.passage(&passage)));
        }
        if let (Some(observer), Some(progress)) = (&mut self.observer, self.unobserved.take()) {
            let (integration, is_stopping) = (&mut self.integration, &mut self.is_stopping);
            let told = tell(integration, &progress, *observer, is_stopping);
            if let Some(summary) = told.map_err(|error| error.of_states(self.of.states))? {
                return Ok(Happening::End(self.of.summary(&summary)));
            }
        }
        if let Some(happening) = self
            .leap()
            .map_err(|error| error.of_states(self.of.states))?
        {
            return Ok(happening);
        }
        let progress = self.integration.step();
        let progress = progress.map_err(|error| error.of_states(self.of.states))?;
        self.unobserved = self.observer.is_some().then_some(progress);
        Ok(match &progress {
            Progress::Step => {
                if let Some(jumping) = &mut self.jumping {
                    jumping.look(&mut self.integration);
                }
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
