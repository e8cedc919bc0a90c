//! The search for the attractor of one orbit, from what the orbit reports.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use super::attractor::{Attractor, AttractorKind};
use super::equilibrium::{attracting_equilibrium, kind_of_equilibrium};
use super::history::History;
use super::recurrence::{Pattern, Recurrence};
use super::tolerance::{Extent, SameWithin};
use super::trap::Trap;
use super::{RecurrenceSettings, recurrent};
use crate::dynamics::{
    Dynamics, Modes, Moment, OrbitProgress, OrbitUnderWay, Phase, Section, Summary, Transition,
    Vector,
};
use crate::error::Error;
use crate::filippov::{Options, TransitionKind};
use crate::orbit::Ending;

/// Steps without a transition after which the extrema of the first state are recorded. Chosen.
const STEPS_BEFORE_EXTREMA: usize = 100;

/// Steps without a transition after which a trapping equilibrium is sought. The number then grows
/// by half each time, so that a cycle with long phases is tested only a few times. Chosen.
const STEPS_BEFORE_TRAP: usize = 12;

/// Longest delay, in steps, of the next search for an equilibrium after one without success.
/// Chosen, to bound the time of the searches.
const LONGEST_DELAY: usize = 64;

/// Phases that are stored for each return of the longest pattern. Chosen, to bound the memory.
const PHASES_PER_RETURN: usize = 4;

/// Source of the section points.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum PointSource {
    /// The transitions of the orbit.
    Transitions,
    /// A section given by the user.
    Events,
}

/// The record of an orbit, until it shows the attractor.
pub(super) struct Search<'a> {
    system: &'a dyn Dynamics,
    settings: &'a RecurrenceSettings,
    tolerance: SameWithin,
    source: PointSource,
    at_transitions: Recurrence,
    at_events: Recurrence,
    history: History,
    /// Hash of the transitions since the last point of either kind.
    tag: DefaultHasher,
    /// The range of the orbit since the last point and since its start.
    extent_since_point: Extent,
    extent: Extent,
    /// State at the previous step.
    previous: Vector,
    /// Steps since the last transition.
    steps_since_transition: usize,
    /// Whether the extrema of the first state are recorded once there has been no event for long.
    may_use_extrema: bool,
    /// Delay of the next search for an equilibrium, in steps, and what remains of it.
    newton_delay: (usize, usize),
    /// Number of steps since the last transition at which a trap is sought next.
    next_trap_search: usize,
    /// The trap located in this phase.
    trap: Option<Trap>,
    escape: f64,
    /// The state from which the orbit is continued, if it is not the present one.
    resume_at: Option<(Moment, Modes)>,
    /// Uncertainty of the period.
    period_uncertainty: f64,
}

impl<'a> Search<'a> {
    pub fn new(
        system: &'a dyn Dynamics,
        x: &Vector,
        sections: &[Section],
        settings: &'a RecurrenceSettings,
        options: &Options,
    ) -> Self {
        let tolerance = SameWithin {
            closeness: settings.closeness,
            rtol: options.rtol,
            atol: options.atol,
        };
        let most = settings.most_returns;
        let (states, limits) = (x.len(), (most, settings.kept));
        let recurrence = || Recurrence::new(states, tolerance, settings.forcing, limits);
        Search {
            system,
            settings,
            tolerance,
            source: match sections {
                [] => PointSource::Transitions,
                _ => PointSource::Events,
            },
            at_transitions: recurrence(),
            at_events: recurrence(),
            history: History::of(PHASES_PER_RETURN * most.max(settings.kept)),
            tag: DefaultHasher::new(),
            extent_since_point: Extent::of(x.as_slice()),
            extent: Extent::of(x.as_slice()),
            previous: x.clone(),
            steps_since_transition: 0,
            may_use_extrema: sections.is_empty() && settings.forcing.is_none(),
            newton_delay: (1, 0),
            next_trap_search: STEPS_BEFORE_TRAP,
            trap: None,
            escape: options.escape,
            resume_at: None,
            period_uncertainty: 0.0,
        }
    }

    /// Records what happens to the orbit next. Returns the attractor as soon as it is certain.
    pub fn record(
        &mut self,
        progress: Result<OrbitProgress, Error>,
        orbit: &mut dyn OrbitUnderWay,
    ) -> Option<Attractor> {
        let mut is_jump = false;
        let done = match progress {
            Ok(OrbitProgress::Passage(at)) => self.event(Moment { t: at.t, x: at.x }, at.mode),
            Ok(OrbitProgress::Step) => {
                self.steps_since_transition += 1;
                if self.may_use_extrema && self.steps_since_transition > STEPS_BEFORE_EXTREMA {
                    self.may_use_extrema = false;
                    orbit.watch(&[Section::MaximaOfFirstState]);
                    return None;
                }
                self.step(orbit.mode(), orbit.t(), orbit.x())
            }
            Ok(OrbitProgress::PhaseEnd(phase)) => {
                self.history.phase(phase);
                None
            }
            Ok(OrbitProgress::Kink(_)) => None,
            Ok(OrbitProgress::Transition(at)) => {
                is_jump = at.kind == TransitionKind::Jump;
                self.transition(&at, orbit.x())
            }
            Ok(OrbitProgress::End(summary)) => Some(self.ended(summary, orbit.mode())),
            Err(error) => Some(self.failed(error, orbit)),
        };
        let steps = orbit.counters().steps;
        if is_jump && done.is_some() {
            self.pass_instant(orbit);
        }
        done.map(|(kind, points)| self.attractor(kind, points, (orbit, steps)))
    }

    /// A run goes on from the attractor behind all jumps of an instant: from between them, what
    /// sets off the next one is not known.
    fn pass_instant(&mut self, orbit: &mut dyn OrbitUnderWay) {
        let mut last = (orbit.now(), orbit.mode());
        loop {
            match orbit.step() {
                Ok(OrbitProgress::PhaseEnd(phase)) if phase.t_end == last.0.t => {}
                Ok(OrbitProgress::Transition(next)) if next.t == last.0.t => {
                    last = (orbit.now(), orbit.mode());
                }
                _ => break,
            }
        }
        self.resume_at.get_or_insert(last);
    }

    fn step(&mut self, mode: Modes, t: f64, x: &[f64]) -> Option<(AttractorKind, Vec<Moment>)> {
        self.extent_since_point.include(x);
        self.extent.include(x);
        let stays = |i: usize| {
            (x[i] - self.previous[i]).abs() <= self.tolerance.allowed(i, self.extent.size(i))
        };
        let has_stayed = (0..x.len()).all(stays);
        self.previous.copy_from_slice(x);
        if self.settings.forcing.is_some() {
            return None;
        }
        let now = || Moment {
            t,
            x: Vector::from_column_slice(x),
        };
        if self.steps_since_transition >= self.next_trap_search {
            self.next_trap_search += self.next_trap_search / 2;
            let at = now();
            if !self
                .trap
                .as_ref()
                .is_some_and(|trap| trap.is_closer_than_at_start(&at.x))
            {
                self.trap = Trap::near(self.system, mode, &at, self.escape);
            }
        }
        if let Some(trap) = &self.trap {
            let at = now();
            if trap.contains(&at.x) {
                let close = self.close_to(&trap.x, &at.x);
                let x = trap.x.clone();
                self.resume_at = Some((Moment { t, x: close }, mode));
                return Some((AttractorKind::Equilibrium, vec![Moment { t, x }]));
            }
        }
        if !has_stayed {
            return None;
        }
        let (delay, remaining) = &mut self.newton_delay;
        if *remaining > 0 {
            *remaining -= 1;
            return None;
        }
        // A step may be short for another reason: the next search comes after twice as many.
        *remaining = *delay;
        *delay = (2 * *delay).min(LONGEST_DELAY);
        let scale = |i| self.extent.size(i);
        let (kind, x) = attracting_equilibrium(self.system, mode, &now(), scale, &self.tolerance)?;
        Some((kind, vec![Moment { t, x }]))
    }

    /// The state between `x` and an equilibrium at which the two count as the same.
    fn close_to(&self, equilibrium: &Vector, x: &Vector) -> Vector {
        let away = x - equilibrium;
        let parts =
            (0..x.len()).map(|i| self.tolerance.allowed(i, self.extent.size(i)) / away[i].abs());
        let part = parts.fold(1.0, f64::min);
        equilibrium + away * part
    }

    /// Records a transition, after which the orbit is at `after`: elsewhere, if it jumps.
    fn transition(
        &mut self,
        at: &Transition,
        after: &[f64],
    ) -> Option<(AttractorKind, Vec<Moment>)> {
        if at.kind == TransitionKind::Touch {
            return None;
        }
        self.steps_since_transition = 0;
        self.trap = None;
        self.newton_delay = (1, 0);
        self.history.transition(at);
        (at.kind, at.from, at.to, at.contact).hash(&mut self.tag);
        let mut pattern = None;
        if self.source == PointSource::Transitions {
            // Extrema are used only if there are no transitions for long.
            self.at_events.clear();
            let (tag, extent) = self.since_last(at.x.as_slice());
            let counts = self.history.counts();
            pattern = self.at_transitions.add(at.moment(), tag, counts, extent);
        }
        self.extent_since_point.include(after);
        self.extent.include(after);
        self.previous.copy_from_slice(after);
        self.close(pattern, PointSource::Transitions)
    }

    fn event(&mut self, at: Moment, mode: Modes) -> Option<(AttractorKind, Vec<Moment>)> {
        if self.source == PointSource::Transitions
            && self.steps_since_transition <= STEPS_BEFORE_EXTREMA
        {
            return None;
        }
        let (tag, extent) = self.since_last(at.x.as_slice());
        let counts = self.history.counts();
        let pattern = self.at_events.add(at.clone(), tag, counts, extent);
        let is_held = pattern
            .as_ref()
            .is_some_and(|pattern| self.is_held(pattern, mode));
        if is_held && let Some(kind) = kind_of_equilibrium(self.system, mode, &at) {
            return Some((kind, vec![at]));
        }
        self.close(pattern, PointSource::Events)
    }

    /// Whether friction has held the orbit in one place through a period of the drive. Then it does
    /// so for ever.
    fn is_held(&self, pattern: &Pattern, mode: Modes) -> bool {
        let Pattern { extent, counts, .. } = pattern;
        let stays =
            |i: usize| extent.high[i] - extent.low[i] <= self.tolerance.rounding(i, extent.size(i));
        let is_held = mode.any_sticks() && counts.0.transitions == counts.1.transitions;
        self.settings.forcing.is_some() && is_held && (0..extent.low.len()).all(stays)
    }

    /// The tag and range of the orbit since the last point; both are reset.
    fn since_last(&mut self, x: &[f64]) -> (u64, Extent) {
        let tag = self.tag.finish();
        self.tag = DefaultHasher::new();
        let mut extent = std::mem::replace(&mut self.extent_since_point, Extent::of(x));
        extent.include(x);
        (tag, extent)
    }

    fn close(
        &mut self,
        pattern: Option<Pattern>,
        source: PointSource,
    ) -> Option<(AttractorKind, Vec<Moment>)> {
        let pattern = pattern?;
        let recurrence = match source {
            PointSource::Transitions => &self.at_transitions,
            PointSource::Events => &self.at_events,
        };
        let points = recurrence.last(pattern.returns);
        self.history.keep(&pattern.counts);
        // An orbit is not continued from the end of a stick phase: at another parameter it may miss
        // that phase.
        let ended = self
            .history
            .last_phase()
            .filter(|_| source == PointSource::Transitions);
        self.resume_at = ended.and_then(|last| {
            let begin = Moment {
                t: last.t_start,
                x: last.x_start.clone(),
            };
            last.mode.any_sticks().then_some((begin, last.mode))
        });
        self.period_uncertainty = pattern.uncertainty;
        let kind = AttractorKind::Periodic {
            returns: pattern.returns,
            period: pattern.period,
        };
        Some((kind, points))
    }

    fn ended(&mut self, summary: Summary, mode: Modes) -> (AttractorKind, Vec<Moment>) {
        let Summary { t, x, ending, .. } = summary;
        let kind = match ending {
            Ending::Repelling => AttractorKind::Repelling,
            Ending::TwoFold(which) => AttractorKind::TwoFold(which),
            Ending::Shrunk => {
                let at = Moment { t, x };
                let equilibrium = self.equilibrium_on_boundary(mode, &at);
                let (kind, x) = equilibrium.unwrap_or((AttractorKind::Equilibrium, at.x));
                return (kind, vec![Moment { t, x }]);
            }
            Ending::EndTime | Ending::Stopped | Ending::Failed => return self.unclosed(),
        };
        (kind, vec![Moment { t, x }])
    }

    /// The equilibrium at a point of the boundary. Its rounding may lie on either side, so the
    /// modes of the last phases are tried, too.
    fn equilibrium_on_boundary(&self, mode: Modes, at: &Moment) -> Option<(AttractorKind, Vector)> {
        let scale = |i| self.extent.size(i);
        let mut modes = [mode].into_iter().chain(self.history.last_modes());
        modes.find_map(|mode| attracting_equilibrium(self.system, mode, at, scale, &self.tolerance))
    }

    /// No pattern has closed within the longest time.
    fn unclosed(&mut self) -> (AttractorKind, Vec<Moment>) {
        let uses_events = self.source == PointSource::Events
            || self.steps_since_transition > STEPS_BEFORE_EXTREMA;
        let recurrence = if uses_events {
            &self.at_events
        } else {
            &self.at_transitions
        };
        let points = recurrence.last(self.settings.kept);
        let kind = if points.len() >= self.settings.kept
            && recurrent::returns_everywhere(&points)
            && !recurrence.still_moves(recurrent::NEAR_PART)
        {
            AttractorKind::Recurrent
        } else {
            AttractorKind::Undecided
        };
        (kind, points)
    }

    fn failed(&mut self, error: Error, orbit: &dyn OrbitUnderWay) -> (AttractorKind, Vec<Moment>) {
        match error {
            Error::Escaped { .. } => (AttractorKind::Escape, Vec::new()),
            Error::EventPileUp { .. } if self.settings.forcing.is_none() => {
                let at = orbit.now();
                match self.equilibrium_on_boundary(orbit.mode(), &at) {
                    Some((kind, x)) => (kind, vec![Moment { t: at.t, x }]),
                    None => (AttractorKind::Failure(error), Vec::new()),
                }
            }
            other => (AttractorKind::Failure(other), Vec::new()),
        }
    }

    fn attractor(
        &mut self,
        kind: AttractorKind,
        points: Vec<Moment>,
        (orbit, steps): (&dyn OrbitUnderWay, u64),
    ) -> Attractor {
        let resume_at = self.resume_at.take();
        let (last, mode) = resume_at.unwrap_or_else(|| (orbit.now(), orbit.mode()));
        let is_equilibrium = matches!(
            kind,
            AttractorKind::Equilibrium | AttractorKind::EquilibriumSet
        );
        let by_phases = self.history.in_stick();
        let in_stick = by_phases
            .filter(|_| !is_equilibrium)
            .unwrap_or_else(|| f64::from(u8::from(mode.any_sticks())));
        let (phases, transitions) = self.history.take();
        let (phases, transitions) = match kind {
            AttractorKind::Periodic { .. } => self.without_chatter(phases, transitions),
            _ => (phases, transitions),
        };
        Attractor {
            kind,
            period_uncertainty: self.period_uncertainty,
            family: None,
            points,
            phases,
            transitions,
            in_stick,
            steps,
            mode,
            t: last.t,
            x: last.x,
        }
    }

    /// The phases and transitions of a period without impacts that accumulate before a landing.
    /// They are part of the phase that this ends.
    fn without_chatter(
        &self,
        mut phases: Vec<Phase>,
        mut transitions: Vec<(TransitionKind, usize)>,
    ) -> (Vec<Phase>, Vec<(TransitionKind, usize)>) {
        let contacts = self.system.contacts();
        let of_phases: Vec<Option<usize>> = phases
            .iter()
            .map(|phase| Some(contacts + phase.mode.jump()?))
            .collect();
        let mut begin = None;
        let accumulating = self.system.accumulating(&of_phases);
        let merged = phases.drain(..).zip(accumulating);
        let merged = merged.filter_map(|(mut phase, accumulates)| {
            let (t, x) = begin
                .take()
                .unwrap_or_else(|| (phase.t_start, phase.x_start.clone()));
            if accumulates {
                begin = Some((t, x));
                return None;
            }
            (phase.t_start, phase.x_start) = (t, x);
            Some(phase)
        });
        let merged = merged.collect();
        let of_transitions: Vec<Option<usize>> = transitions
            .iter()
            .map(|(kind, of)| (*kind == TransitionKind::Jump).then_some(*of))
            .collect();
        let mut accumulating = self.system.accumulating(&of_transitions).into_iter();
        transitions.retain(|_| accumulating.next() == Some(false));
        (merged, transitions)
    }
}
