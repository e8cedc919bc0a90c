//! Systems whose numbers of states and contacts are part of their type, as [`Dynamics`].

use std::borrow::Borrow;
use std::cell::RefCell;
use std::marker::PhantomData;
use std::sync::Arc;

use super::batch::{BatchOrbit, Listener, one_by_one};
use super::event_maps::EventMaps;
use super::flow::TypedFlow;
use super::interrupt::Interrupt;
use super::jumps::{JumpDecision, Jumps, NoJumps, Reset};
use super::section::NoSection;
use super::view::View;
use super::{
    Dynamics, KinkShift, Modes, Moment, OrbitUnderWay, RunMemory, Section, SmoothFlow, Step,
    Transition, Vector, Watching,
};
use crate::dual::Dual;
use crate::error::Error;
use crate::filippov::{EventFunctions, Method, Options, Switched, side_by_side};
use crate::ode::Timed;
use crate::system::components;

/// A typed system and its jumps, owned or borrowed, with its own event function.
///
/// The type may have room for more states and contacts than the system has. The spare states are
/// constant zero; the spare contacts slip above and never reach zero.
pub struct Typed<T, S, V, U, J, const N: usize, const G: usize> {
    pub(super) system: T,
    pub(super) section: V,
    jumps: U,
    pub(super) states: usize,
    pub(super) contacts: usize,
    interrupt: Option<Arc<Interrupt>>,
    kind: PhantomData<fn() -> (S, J)>,
}

impl<T, S, const N: usize, const G: usize> Typed<T, S, NoSection, NoJumps, NoJumps, N, G>
where
    T: Borrow<S>,
    S: Switched<N, G>,
{
    /// The system with all states and contacts of its type.
    pub fn new(system: T) -> Self {
        Typed::with_section(system, NoSection)
    }
}

impl<T, S, V, const N: usize, const G: usize> Typed<T, S, V, NoJumps, NoJumps, N, G>
where
    T: Borrow<S>,
    S: Switched<N, G>,
{
    /// The system with its own event function.
    pub fn with_section(system: T, section: V) -> Self {
        Typed::padded((system, section, NoJumps), N, S::CONTACTS)
    }
}

impl<T, S, V, U, J, const N: usize, const G: usize> Typed<T, S, V, U, J, N, G>
where
    T: Borrow<S>,
    S: Switched<N, G>,
    U: Borrow<J>,
{
    /// A system, its own event function and its jumps, with fewer states and contacts than the type
    /// has room for: the first ones are used.
    pub fn padded((system, section, jumps): (T, V, U), states: usize, contacts: usize) -> Self {
        Typed {
            system,
            section,
            jumps,
            states: states.min(N),
            contacts: contacts.min(S::CONTACTS),
            interrupt: None,
            kind: PhantomData,
        }
    }

    /// The system, with orbits that end when the flag, if there is one, is raised.
    pub fn interrupted_by(self, interrupt: Option<Arc<Interrupt>>) -> Self {
        Typed { interrupt, ..self }
    }

    fn view(&self) -> View<'_, S, V, J, N, G> {
        View {
            system: self.system.borrow(),
            own: &self.section,
            jumps: self.jumps.borrow(),
            states: self.states,
            contacts: self.contacts,
            interrupt: self.interrupt.as_deref(),
            held: None,
        }
    }
}

impl<T, S, V, U, J, const N: usize, const G: usize> Dynamics for Typed<T, S, V, U, J, N, G>
where
    T: Borrow<S> + Send + Sync,
    S: Switched<N, G>,
    V: EventFunctions<N> + Send + Sync,
    U: Borrow<J> + Send + Sync,
    J: Jumps<N>,
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
        sections: &[Section],
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        self.view().begin(start, t_end, options, sections)
    }

    fn resume<'a>(
        &'a self,
        from: &RunMemory,
        t_end: f64,
        options: &Options,
        sections: &[Section],
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        self.view().resume(from, t_end, options, sections)
    }

    fn follow_all(
        &self,
        starts: &[Moment],
        t_end: f64,
        options: &Options,
        Watching {
            sections,
            solutions,
        }: Watching<'_>,
        listener: &mut Listener<'_>,
    ) -> Vec<Result<(), Error>> {
        let of = self.view();
        // Compiled functions would be compiled once more for the lanes. Jumps and inputs need the
        // solution over every step, so that lanes do not pay.
        let has_jumps = of.jumps.count() + of.jumps.inputs() > 0;
        if const { !S::INTERPRETED } || has_jumps || options.method != Method::Taylor {
            let begin = |start: &Moment| of.begin(start, t_end, options, sections);
            return one_by_one(begin, starts, listener);
        }
        let listener = &RefCell::new(listener);
        let begin = |(number, start): (usize, &Moment), stepper| {
            let run = of.start_run(start, t_end, options, (sections, stepper));
            let mut run = run.map_err(Err)?;
            run.keep_solutions(solutions);
            Ok(BatchOrbit {
                number,
                run,
                listener,
            })
        };
        // All have one system.
        let starts = starts.iter().enumerate().map(|start| (0, start));
        side_by_side(starts, begin, options)
    }

    fn is_discrete(&self, state: usize) -> bool {
        self.view().jumps.is_discrete(state)
    }

    fn admitted(&self, at: &Moment) -> Moment {
        let of = self.view();
        let Timed { t, x } = of.admitted(of.timed(at));
        Moment {
            t,
            x: of.vector(&x),
        }
    }
}

impl<T, S, V, U, J, const N: usize, const G: usize> EventMaps for Typed<T, S, V, U, J, N, G>
where
    T: Borrow<S> + Send + Sync,
    S: Switched<N, G>,
    V: EventFunctions<N> + Send + Sync,
    U: Borrow<J> + Send + Sync,
    J: Jumps<N>,
{
    fn begin_in<'a>(
        &'a self,
        mode: (Modes, &Moment),
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        self.view().begin_in(mode, start, t_end, options)
    }

    fn flow_held<'a>(&'a self, mode: Modes, at: &Moment, held: f64) -> Box<dyn SmoothFlow + 'a> {
        let held = Some(held).filter(|held| *held != at.t);
        let view = View {
            held,
            ..self.view()
        };
        Box::new(TypedFlow::new(view, mode, at))
    }

    fn normals(&self, mode: Modes, at: &Moment) -> Vec<(usize, Vector)> {
        if !mode.any_sticks() {
            return Vec::new();
        }
        let of = self.view();
        let normals = of
            .system
            .normals(S::restored(mode), &of.timed(at), self.states);
        let normals = normals.into_iter();
        normals.map(|(i, normal)| (i, of.vector(&normal))).collect()
    }

    fn kept(&self, at: &Moment) -> Vec<(f64, Vector)> {
        let of = self.view();
        let here = of.timed(at);
        let kept = of.kept(here).map(|(jump, off)| {
            let (slopes, _) = of.gradient(|t, x| of.jumps.when(jump, t, x), &here);
            let mut gradient = of.vector(&slopes);
            let discrete = (0..self.states).filter(|&state| of.jumps.is_discrete(state));
            discrete.for_each(|state| gradient[state] = 0.0);
            (off, gradient)
        });
        kept.collect()
    }

    fn landings(&self, at: &Moment) -> Vec<usize> {
        let of = self.view();
        let landings = of.landings(of.timed(at));
        landings.map(|jump| self.contacts + jump).collect()
    }

    fn discontinuity_guard(&self, at: &Transition) -> Option<usize> {
        let of = self.view();
        of.system.discontinuity_guard(&of.typed_transition(at))
    }

    fn is_one_at_a_time(&self, at: &Transition) -> bool {
        let of = self.view();
        of.system.is_one_at_a_time(&of.typed_transition(at))
    }

    fn period(&self, x: &Vector) -> Option<(f64, Vector)> {
        let (of, t) = (self.view(), 0.0);
        let x = of.state(x.as_slice());
        let period = |x: &_| of.system.period(x);
        let value = period(&components(&x).map(|x| Dual::new(x, 0.0)))?.re;
        let by_state = |_, x: &_| period(x).unwrap_or(Dual::new(0.0, 0.0));
        let (gradient, _) = of.gradient(by_state, &Timed { t, x });
        Some((value, of.vector(&gradient)))
    }

    fn is_constant_between_jumps(&self, state: usize) -> bool {
        self.view().jumps.is_constant_between_jumps(state)
    }

    fn kinks(&self, at: &Moment) -> Vec<usize> {
        self.view().kinked(&self.view().timed(at))
    }

    fn kink_shifts(&self, step: &Step) -> Vec<KinkShift> {
        let (of, t) = (self.view(), step.t_end);
        let mut shifts = Vec::new();
        let inputs = of.jumps.inputs();
        if inputs == 0 {
            return shifts;
        }
        let flow = TypedFlow::new(of, step.mode, &step.end());
        let start = of.with_inputs(step.t_start, of.state(step.x_end.as_slice()));
        let held = |input: usize, mut x: crate::system::State<N>| {
            of.jumps.hold(input, t, x.as_mut_slice());
            x
        };
        let kinked = (0..inputs).filter(|&input| held(input, start) != start);
        let kinked: Vec<usize> = kinked.collect();
        let end = kinked.iter().fold(start, |x, &input| held(input, x));
        let mut x = start;
        for &input in &kinked {
            let before = Timed { t, x };
            x = held(input, x);
            let (slopes, in_time) = of.gradient(|t, x| of.jumps.clock(input, t, x), &before);
            let gradient = of.vector(&slopes);
            let is_fixed = gradient.amax() == 0.0 && kinked.len() == 1;
            if is_fixed || in_time == 0.0 {
                continue;
            }
            let velocity = |x| flow.velocity_at(&Timed { t, x });
            let [from, to] = [before.x, x].map(velocity);
            let mut order = &from * 0.0;
            if kinked.len() > 1 {
                let others = kinked.iter().filter(|other| **other != input);
                let last = others.fold(start, |x, &other| held(other, x));
                let [first, last] = [[start, held(input, start)], [last, end]]
                    .map(|ends| ends.map(velocity))
                    .map(|[from, to]| to - from);
                order = first - last;
            }
            shifts.push(KinkShift {
                rate: in_time + gradient.dot(&from),
                kick: to - from,
                gradient,
                order,
            });
        }
        shifts
    }

    fn clock(&self, input: usize, at: &Moment) -> (f64, Vector, f64) {
        let (of, at) = (self.view(), self.view().timed(at));
        let (slopes, in_time) = of.gradient(|t, x| of.jumps.clock(input, t, x), &at);
        let value = of.jumps.clock(input, at.t, components(&at.x));
        (value, of.vector(&slopes), in_time)
    }

    fn reset_held(&self, number: usize, at: &Moment, held: f64) -> Reset {
        let of = View {
            held: Some(held),
            ..self.view()
        };
        let mut reset = of.map(number, at);
        let Timed { t, x } = of.timed(at);
        if !of.jumps.happens(number - self.contacts, t, components(&x)) {
            reset.after.fill(f64::NAN);
        }
        reset
    }

    fn map(&self, number: usize, at: &Moment) -> Reset {
        self.view().map(number, at)
    }

    fn decision(&self, number: usize, at: &Moment) -> JumpDecision {
        let of = self.view();
        let (jump, Timed { t, x }) = (number - self.contacts, of.timed(at));
        let x = components(&x);
        JumpDecision {
            happens: of.jumps.happens(jump, t, x),
            comparisons: of.jumps.comparisons(jump, t, x),
        }
    }

    fn opened(&self, mut x: Vector) -> Vector {
        self.view().jumps.open(x.as_mut_slice());
        x
    }

    fn rest_after(&self, number: usize) -> Option<usize> {
        let of = self.view();
        let jump = number.checked_sub(self.contacts)?;
        Some(self.contacts + of.jumps.rests(jump)?)
    }

    fn section_gradient(&self, section: &Section, at: &Moment) -> (Vector, f64) {
        let of = self.view();
        let section = of.sections(std::slice::from_ref(section));
        let (normal, in_time) = of.gradient(|t, x| section.value(0, t, x), &of.timed(at));
        (of.vector(&normal), in_time)
    }
}

/// An orbit of a borrowed system that reports the passages of its own section.
pub(crate) fn watched<'a, S, V, const N: usize, const G: usize>(
    of: &Typed<&'a S, S, &'a V, NoJumps, NoJumps, N, G>,
    start: &Moment,
    options: &Options,
) -> Result<Box<dyn OrbitUnderWay + 'a>, Error>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
{
    let view = View {
        system: of.system,
        own: of.section,
        jumps: &NoJumps,
        states: of.states,
        contacts: of.contacts,
        interrupt: None,
        held: None,
    };
    view.begin(start, f64::MAX, options, &[Section::OfSystem(0)])
}
