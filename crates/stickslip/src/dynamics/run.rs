//! An orbit of a typed system under way.

use std::collections::VecDeque;

use super::jump_search::{JumpMemory, JumpSearch};
use super::jumps::{Jumps, NoJumps};
use super::memory::Repeated;
use super::section::{NoSection, TypedFunctions};
use super::view::View;
use super::{
    Modes, Moment, OrbitProgress, OrbitUnderWay, Phase, RunMemory, Section, Solution, Step, Vector,
};
use crate::error::{Error, Point};
use crate::filippov::{
    EventFunctions, EventSearch, Integration, Observer, Options, Progress, StepMemory, Stepper,
    Switched, notify,
};
use crate::orbit::Counters;

impl<'a, S, V, J, const N: usize, const G: usize> View<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
    J: Jumps<N>,
{
    pub(super) fn begin(
        self,
        start: &Moment,
        t_end: f64,
        options: &Options,
        sections: &[Section],
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        let with = (sections, Stepper::new(options));
        Ok(Box::new(self.start_run(start, t_end, options, with)?))
    }

    /// An orbit at its start. The stepper may have served another orbit.
    pub(super) fn start_run(
        self,
        start: &Moment,
        t_end: f64,
        options: &Options,
        (sections, stepper): (&[Section], Stepper<N, G>),
    ) -> Result<Run<'a, S, V, J, N, G>, Error> {
        let start = self.timed(start);
        let checked = self.check_inputs(&start);
        let settled = checked.and_then(|()| self.settled(start, options));
        let integration = settled.and_then(|start| {
            Integration::with_stepper(self.system, start, t_end, options, stepper)
        });
        let mut run = self.run(integration, t_end, options)?;
        run.watch(sections);
        Ok(run)
    }

    pub(super) fn begin_in(
        self,
        (mode, inside): (Modes, &Moment),
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        let in_mode = (S::restored(mode), &self.timed(inside));
        let start = self.landed(self.timed(start));
        let integration = Integration::in_mode(self.system, in_mode, start, t_end, options);
        Ok(Box::new(self.run(integration, t_end, options)?))
    }

    pub(super) fn resume(
        self,
        from: &RunMemory,
        t_end: f64,
        options: &Options,
        sections: &[Section],
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        let of_another_system = || Error::Memory { t: from.t };
        if from.x.len() != self.states {
            return Err(of_another_system());
        }
        if t_end <= from.t || t_end.is_nan() {
            return Err(Error::Interval { t0: from.t, t_end });
        }
        let integration = Integration::resumed(self.system, &from.step, t_end, options)
            .ok_or_else(of_another_system)?;
        let mut run = self.run(integration, t_end, options)?;
        let is_same = match (&mut run.jump_search, &from.jumps) {
            (Some(search), Some(memory)) => search.restore(memory),
            // Without jumps, a search is for the kinks that a run reaches.
            (_, None) => self.jumps.count() == 0,
            (None, Some(memory)) => memory.has_no_jumps(),
        };
        if !is_same {
            return Err(of_another_system());
        }
        run.watch(sections);
        run.repeated = Some(Repeated {
            t: from.t,
            x: from.x.clone(),
            items: from.items,
        });
        Ok(Box::new(run))
    }

    fn run(
        self,
        integration: Result<Integration<'a, S, N, G>, Error>,
        t_end: f64,
        options: &Options,
    ) -> Result<Run<'a, S, V, J, N, G>, Error> {
        let truncated = |error: Error| error.truncated(self.states);
        let mut integration = integration.map_err(truncated)?;
        let jump_search = JumpSearch::of(&self, &mut integration, options, t_end);
        Ok(Run {
            view: self,
            jump_search: jump_search.map_err(truncated)?,
            pending: VecDeque::new(),
            integration,
            options: *options,
            search: None,
            keeps_solutions: false,
            reported: 0,
            observer: None,
            unobserved: None,
            t_end,
            remembered: None,
            items: 0,
            repeated: None,
        })
    }
}

/// An orbit of a borrowed system with an observer, which receives each item when the next one is
/// requested.
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
        interrupt: None,
        held: None,
    };
    let with: (&[Section], _) = (&[], Stepper::new(options));
    let mut run = view.start_run(start, t_end, options, with)?;
    run.observer = Some(observer);
    Ok(Box::new(run))
}

/// An integration under way, with the search for passages of sections.
pub(super) struct Run<'a, S: Switched<N, G>, V, J, const N: usize, const G: usize> {
    view: View<'a, S, V, J, N, G>,
    integration: Integration<'a, S, N, G>,
    /// Search for jumps and kinks, if the system has any.
    jump_search: Option<JumpSearch<'a, S, V, J, N, G>>,
    /// Items to report before the run continues.
    pending: VecDeque<OrbitProgress>,
    options: Options,
    search: Option<EventSearch<'a, S, TypedFunctions<'a, S, V, J, N, G>, N, G>>,
    /// Whether the solution over each step is needed.
    keeps_solutions: bool,
    /// Number of passages of the last step that have been reported.
    reported: usize,
    observer: Option<&'a mut dyn Observer<N, S::Mode>>,
    /// Items that the observer has not received yet.
    unobserved: Option<Progress<N, S::Mode>>,
    /// End of the run.
    t_end: f64,
    /// The run before the first step that its end shortens, and the number of items reported since,
    /// up to the last transition.
    remembered: Option<(StepMemory, Option<JumpMemory>, usize)>,
    /// Number of items reported since.
    items: usize,
    /// Items that are not reported again.
    repeated: Option<Repeated>,
}

impl<'a, S, V, J, const N: usize, const G: usize> Run<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
    J: Jumps<N>,
{
    pub(super) fn integration(&mut self) -> &mut Integration<'a, S, N, G> {
        &mut self.integration
    }

    /// Whether the solution over a step is needed, not only its end.
    pub(super) fn watches_steps(&self) -> bool {
        self.keeps_solutions || self.search.is_some() || self.jump_search.is_some()
    }

    /// Makes the solution over each step available, if it is wanted.
    pub(super) fn keep_solutions(&mut self, wanted: bool) {
        self.keeps_solutions = wanted;
    }

    /// Takes the step that was prepared, if there is one, or continues until the next one is
    /// prepared. Returns what is to be reported, or `None` if a step was prepared.
    pub(super) fn go_on(&mut self) -> Option<Result<OrbitProgress, Error>> {
        let happened = self.go_on_from_start()?;
        Some(match happened {
            Ok(progress) => Ok(self.counted(progress)?),
            Err(error) => Err(error),
        })
    }

    /// Counts what is reported. Returns what the run before a resumed one has not reported.
    fn counted(&mut self, mut progress: OrbitProgress) -> Option<OrbitProgress> {
        let is_change = matches!(
            progress,
            OrbitProgress::Transition(_) | OrbitProgress::Kink(_)
        );
        let is_item = is_change || matches!(progress, OrbitProgress::PhaseEnd(_));
        if let Some((.., items)) = &mut self.remembered {
            self.items += usize::from(is_item);
            if is_change {
                *items = self.items;
            }
        }
        let Some(repeated) = &mut self.repeated else {
            return Some(progress);
        };
        // The run before has reported the part before its end.
        if let OrbitProgress::PhaseEnd(phase) = &mut progress
            && phase.t_start < repeated.t
        {
            (phase.t_start, phase.x_start) = (repeated.t, repeated.x.clone());
        }
        let is_new = match &progress {
            OrbitProgress::Step => self.integration.t() > repeated.t,
            OrbitProgress::Passage(at) => at.t > repeated.t,
            OrbitProgress::End(_) => true,
            _ => repeated.items == 0,
        };
        if is_item && !is_new {
            repeated.items -= 1;
        }
        is_new.then_some(progress)
    }

    fn go_on_from_start(&mut self) -> Option<Result<OrbitProgress, Error>> {
        let happened = match self.view.interrupt {
            Some(interrupt) if interrupt.is_raised() => Err(Error::Interrupted {
                t: self.integration.t(),
                x: Point::from(self.integration.x()),
            }),
            Some(interrupt) => {
                let happened = self.next();
                interrupt.note_time(self.integration.t());
                happened
            }
            None => self.next(),
        };
        let happened = happened.transpose()?;
        Some(happened.map_err(|error| error.truncated(self.view.states)))
    }

    fn next(&mut self) -> Result<Option<OrbitProgress>, Error> {
        if !self.integration.is_ready()
            && let Some(progress) = self.before_step()?
        {
            return Ok(Some(progress));
        }
        let progress = self.integration.go_on()?;
        if self.integration.is_before_end() {
            let jumps = self.jump_search.as_ref().map(JumpSearch::memory);
            self.remembered = Some((self.integration.memory(), jumps, 0));
        }
        let Some(progress) = progress else {
            return Ok(None);
        };
        self.unobserved = self.observer.is_some().then_some(progress);
        Ok(Some(match &progress {
            Progress::Step => {
                match &mut self.jump_search {
                    // All jumps on the way are part of the accumulation.
                    Some(jump_search) if self.integration.accumulates() => {
                        jump_search.begin_at(&self.integration);
                        if let Some(landings) = self.integration.take_landing() {
                            jump_search.follow(&landings);
                        }
                    }
                    Some(jump_search) => jump_search.shorten_step(&mut self.integration)?,
                    None => {}
                }
                if let Some(search) = &mut self.search {
                    search.in_step(&self.integration.last_step());
                    self.reported = 0;
                }
                OrbitProgress::Step
            }
            Progress::PhaseEnd(phase) => {
                let until = self.jump_search.as_ref().and_then(JumpSearch::due);
                OrbitProgress::PhaseEnd(self.view.phase(phase, until))
            }
            Progress::Transition(at) => OrbitProgress::Transition(self.view.transition(at)),
            Progress::End(summary) => OrbitProgress::End(self.view.summary(summary)),
        }))
    }

    /// Item to report before the integration continues.
    fn before_step(&mut self) -> Result<Option<OrbitProgress>, Error> {
        if let Some(search) = &self.search
            && let Some(passage) = search.last_events().get(self.reported)
            && !self.is_settling(passage.t)
        {
            self.reported += 1;
            let mut passage = *passage;
            if passage.t == self.integration.t() && self.has_kinked(passage.t) {
                (passage.x, passage.mode) = (*self.integration.x(), self.integration.mode());
            }
            return Ok(Some(OrbitProgress::Passage(self.view.passage(&passage))));
        }
        if let (Some(observer), Some(progress)) = (&mut self.observer, self.unobserved.take())
            && let Some(summary) = notify(&mut self.integration, &progress, *observer)?
        {
            return Ok(Some(OrbitProgress::End(self.view.summary(&summary))));
        }
        self.process_jumps()
    }

    fn has_kinked(&self, t: f64) -> bool {
        let jump_search = self.jump_search.as_ref();
        jump_search.is_some_and(|jump_search| jump_search.has_kinked(t))
    }

    /// Whether an input kinks here with its consequences still pending. The state at such a time is
    /// that after the kink, from which a run continues.
    fn is_settling(&self, t: f64) -> bool {
        let is_here = |jump_search: &JumpSearch<'_, S, V, J, N, G>| {
            let is_under_way = jump_search.has_kinked(t) && jump_search.is_due();
            t == self.integration.t() && (jump_search.is_at_kink(&self.integration) || is_under_way)
        };
        self.jump_search.as_ref().is_some_and(is_here) || !self.pending.is_empty()
    }

    /// Carries out what is due between two steps of a run with jumps or inputs.
    fn process_jumps(&mut self) -> Result<Option<OrbitProgress>, Error> {
        let Some(jump_search) = &mut self.jump_search else {
            return Ok(None);
        };
        while self.pending.is_empty() {
            if jump_search.is_due() {
                // The phase before it is reported first.
                if self.integration.ends_phase() {
                    return Ok(None);
                }
                if jump_search.has_reached_kink(&self.integration) {
                    jump_search.pass_kink(&mut self.integration, &self.view, &mut self.pending)?;
                    continue;
                }
                if jump_search.takes_empty_phase() {
                    let phase = self
                        .view
                        .phase(&self.integration.phase_so_far(), jump_search.due());
                    return Ok(Some(OrbitProgress::PhaseEnd(phase)));
                }
                let jump = jump_search.jump(&mut self.integration)?;
                if let Some(search) = &mut self.search {
                    search.set_sides(0.0);
                }
                return Ok(jump.map(|at| OrbitProgress::Transition(self.view.transition(&at))));
            }
            if !jump_search.is_at_kink(&self.integration) {
                return Ok(None);
            }
            jump_search.pass_kink(&mut self.integration, &self.view, &mut self.pending)?;
        }
        Ok(self.pending.pop_front())
    }
}

impl<S, V, J, const N: usize, const G: usize> OrbitUnderWay for Run<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
    J: Jumps<N>,
{
    fn step(&mut self) -> Result<OrbitProgress, Error> {
        loop {
            if let Some(progress) = self.go_on() {
                return progress;
            }
        }
    }

    fn watch(&mut self, sections: &[Section]) {
        self.reported = 0;
        let search = || {
            EventSearch::new(
                self.view.system,
                self.view.sections(sections),
                &self.options,
            )
        };
        self.search = (!sections.is_empty()).then(search);
    }

    fn remember(&mut self) {
        self.integration.wait_before(self.t_end);
    }

    fn memory(&self) -> Option<RunMemory> {
        let (step, jumps, items) = self.remembered.as_ref()?;
        (self.integration.has_ended() && self.integration.t() == self.t_end).then(|| RunMemory {
            t: self.t_end,
            x: self.view.vector(self.integration.x()),
            items: *items,
            step: step.clone(),
            jumps: jumps.clone(),
        })
    }

    fn t(&self) -> f64 {
        self.integration.t()
    }

    fn x(&self) -> &[f64] {
        &self.integration.x().as_slice()[..self.view.states]
    }

    fn mode(&self) -> Modes {
        self.view.modes(self.integration.mode())
    }

    fn phase(&self) -> Option<Phase> {
        let phase = self.integration.phase()?;
        Some(self.view.phase(&phase, None))
    }

    fn counters(&self) -> Counters {
        *self.integration.counters()
    }

    fn last_step(&mut self) -> Step {
        let (mode, [from, to]) = self.integration.last_ends();
        let mut step = Step {
            mode: self.view.modes(mode),
            t_start: from.t,
            t_end: to.t,
            x_start: self.view.vector(&from.x),
            x_end: self.view.vector(&to.x),
        };
        // The run before has reported the part before its end.
        if let Some(repeated) = self.repeated.as_ref()
            && step.t_start < repeated.t
        {
            (step.t_start, step.x_start) = (repeated.t, repeated.x.clone());
        }
        step
    }

    fn solution(&mut self) -> Solution {
        let dense = self.integration.last_step().dense;
        let states = self.view.states;
        Box::new(move |t| Vector::from_column_slice(&dense.at_time(t).as_slice()[..states]))
    }
}
