//! One orbit on the way to its attractor: what is recorded of it, and when that suffices.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use super::drawn_in::Trap;
use super::history::History;
use super::nearness::{Extent, Nearness};
use super::reached::{Kind, Reached};
use super::recurrence::{Pattern, Recurrence};
use super::rest::{kind_of_rest, rest_at};
use super::{RecurrenceSettings, recurrent};
use crate::dynamics::{
    Dynamics, Happening, Modes, Moment, OrbitUnderWay, Section, Summary, Transition, Vector,
};
use crate::error::Error;
use crate::filippov::{Options, TransitionKind};
use crate::orbit::Ending;

/// Steps without a transition after which the extrema of the first state are recorded.
const QUIET: usize = 100;

/// Steps without a transition after which a trapping equilibrium is sought. The number then grows
/// by half each time, so that a cycle with long phases is tested only a few times.
const CALM: usize = 12;

/// Longest delay, in steps, before an equilibrium is sought again.
const MOST_PATIENT: usize = 64;

/// Phases that are kept for each return of the longest pattern.
const PHASES: usize = 4;

/// Source of the section points.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    /// The transitions of the orbit.
    Transitions,
    /// A section given by the user.
    Events,
}

/// The record of an orbit.
pub(super) struct Search<'a> {
    system: &'a dyn Dynamics,
    settings: &'a RecurrenceSettings,
    near: Nearness,
    by: By,
    by_transition: Recurrence,
    by_event: Recurrence,
    history: History,
    /// Counts since the last point of either kind.
    tag: DefaultHasher,
    /// The range of the orbit since the last point, and since its start.
    lately: Extent,
    ever: Extent,
    /// State at the previous step.
    before: Vector,
    /// Steps since the last transition.
    quiet: usize,
    /// Whether the extrema of the first state are recorded once there has been no event for long.
    may_be_quiet: bool,
    /// Delay in steps before an equilibrium is sought again, and what remains of it.
    patience: (usize, usize),
    /// Steps since the last transition at which a trap is sought next.
    asked_at: usize,
    /// The trap located in this phase.
    trap: Option<Trap>,
    escape: f64,
    /// The reported end of the orbit, if it is not the present state.
    left_at: Option<(Moment, Modes)>,
    /// Uncertainty of the period.
    uncertainty: f64,
}

impl<'a> Search<'a> {
    pub fn new(
        system: &'a dyn Dynamics,
        x: &Vector,
        section: &Section,
        settings: &'a RecurrenceSettings,
        options: &Options,
    ) -> Self {
        let near = Nearness {
            closeness: settings.closeness,
            rtol: options.rtol,
            atol: options.atol,
        };
        let most = settings.most_returns;
        let (states, limits) = (x.len(), (most, settings.kept));
        let recurrence = || Recurrence::new(states, near, settings.forcing, limits);
        Search {
            system,
            settings,
            near,
            by: match section {
                Section::None => By::Transitions,
                _ => By::Events,
            },
            by_transition: recurrence(),
            by_event: recurrence(),
            history: History::of(PHASES * most.max(settings.kept)),
            tag: DefaultHasher::new(),
            lately: Extent::of(x.as_slice()),
            ever: Extent::of(x.as_slice()),
            before: x.clone(),
            quiet: 0,
            may_be_quiet: *section == Section::None && settings.forcing.is_none(),
            patience: (1, 0),
            asked_at: CALM,
            trap: None,
            escape: options.escape,
            left_at: None,
            uncertainty: 0.0,
        }
    }

    /// Records what happens to the orbit next. Returns the outcome once it is known.
    pub fn hear(
        &mut self,
        happened: Result<Happening, Error>,
        orbit: &mut dyn OrbitUnderWay,
    ) -> Option<Reached> {
        let done = match happened {
            Ok(Happening::Passage(at)) => self.event(Moment { t: at.t, x: at.x }, at.mode),
            Ok(Happening::Step) => {
                self.quiet += 1;
                if self.may_be_quiet && self.quiet > QUIET {
                    // There has been no event for long.
                    self.may_be_quiet = false;
                    orbit.watch(&Section::Turning);
                    return None;
                }
                self.step(orbit.mode(), orbit.t(), orbit.x())
            }
            Ok(Happening::PhaseEnd(phase)) => {
                self.history.phase(phase);
                None
            }
            Ok(Happening::Kink(_)) => None,
            Ok(Happening::Transition(at)) => self.transition(&at),
            Ok(Happening::End(summary)) => Some(self.ended(summary, orbit.mode())),
            Err(error) => Some(self.failed(error, orbit)),
        };
        done.map(|(kind, points)| self.reached(kind, points, orbit))
    }

    fn step(&mut self, mode: Modes, t: f64, x: &[f64]) -> Option<(Kind, Vec<Moment>)> {
        self.lately.include(x);
        self.ever.include(x);
        let stays =
            |i: usize| (x[i] - self.before[i]).abs() <= self.near.allowed(self.ever.size(i));
        let has_stayed = (0..x.len()).all(stays);
        self.before.copy_from_slice(x);
        if self.settings.forcing.is_some() {
            return None;
        }
        let here = || Moment {
            t,
            x: Vector::from_column_slice(x),
        };
        if self.quiet >= self.asked_at {
            self.asked_at += self.asked_at / 2;
            let at = here();
            if !self.trap.as_ref().is_some_and(|trap| trap.draws(&at.x)) {
                self.trap = Trap::near(self.system, mode, &at, self.escape);
            }
        }
        if let Some(trap) = &self.trap {
            let at = here();
            if trap.holds(&at.x) {
                let left = self.near_to(&trap.x, &at.x);
                let x = trap.x.clone();
                self.left_at = Some((Moment { t, x: left }, mode));
                return Some((Kind::Equilibrium, vec![Moment { t, x }]));
            }
        }
        if !has_stayed {
            return None;
        }
        let (patience, left) = &mut self.patience;
        if *left > 0 {
            *left -= 1;
            return None;
        }
        // A step may be short for another reason: the next search comes after twice as many.
        *left = *patience;
        *patience = (2 * *patience).min(MOST_PATIENT);
        let scale = |i| self.ever.size(i);
        let (kind, x) = rest_at(self.system, mode, &here(), scale, &self.near)?;
        Some((kind, vec![Moment { t, x }]))
    }

    /// The state between `x` and an equilibrium at which the two count as the same.
    fn near_to(&self, equilibrium: &Vector, x: &Vector) -> Vector {
        let away = x - equilibrium;
        let parts = (0..x.len()).map(|i| self.near.allowed(self.ever.size(i)) / away[i].abs());
        let part = parts.fold(1.0, f64::min);
        equilibrium + away * part
    }

    fn transition(&mut self, at: &Transition) -> Option<(Kind, Vec<Moment>)> {
        if at.kind == TransitionKind::Touch {
            return None;
        }
        self.quiet = 0;
        self.trap = None;
        self.patience = (1, 0);
        self.history.transition(at);
        (at.kind, at.from, at.to, at.contact).hash(&mut self.tag);
        if self.by == By::Events {
            return None;
        }
        // Extrema count where there has long been nothing else.
        self.by_event.clear();
        let (tag, extent) = self.since_last(at.x.as_slice());
        let at = at.moment();
        let found = self
            .by_transition
            .pass(at, tag, self.history.count(), extent);
        self.closes(found, By::Transitions)
    }

    fn event(&mut self, at: Moment, mode: Modes) -> Option<(Kind, Vec<Moment>)> {
        if self.by == By::Transitions && self.quiet <= QUIET {
            return None;
        }
        let (tag, extent) = self.since_last(at.x.as_slice());
        let count = self.history.count();
        let found = self.by_event.pass(at.clone(), tag, count, extent);
        let is_held = found
            .as_ref()
            .is_some_and(|pattern| self.rests(pattern, mode));
        if is_held && let Some(kind) = kind_of_rest(self.system, mode, &at) {
            return Some((kind, vec![at]));
        }
        self.closes(found, By::Events)
    }

    /// Whether friction has held the orbit in one place through a whole period of the drive: then
    /// it does so for ever.
    fn rests(&self, pattern: &Pattern, mode: Modes) -> bool {
        let Pattern { extent, counts, .. } = pattern;
        let stays = |i: usize| extent.high[i] - extent.low[i] <= self.near.rounding(extent.size(i));
        let is_held = mode.any_sticks() && counts.0.transitions == counts.1.transitions;
        self.settings.forcing.is_some() && is_held && (0..extent.low.len()).all(stays)
    }

    /// Counts since the last point, and the range of the orbit; both are reset here.
    fn since_last(&mut self, x: &[f64]) -> (u64, Extent) {
        let tag = self.tag.finish();
        self.tag = DefaultHasher::new();
        let mut extent = std::mem::replace(&mut self.lately, Extent::of(x));
        extent.include(x);
        (tag, extent)
    }

    fn closes(&mut self, found: Option<Pattern>, by: By) -> Option<(Kind, Vec<Moment>)> {
        let pattern = found?;
        let recurrence = match by {
            By::Transitions => &self.by_transition,
            By::Events => &self.by_event,
        };
        let points = recurrence.last(pattern.returns);
        self.history.keep(&pattern.counts);
        // The end of a stick phase is a bad place to continue from: at another parameter, an orbit
        // from there may miss the stick phase.
        let ended = self.history.last_phase().filter(|_| by == By::Transitions);
        self.left_at = ended.and_then(|last| {
            let begin = Moment {
                t: last.t_start,
                x: last.x_start.clone(),
            };
            last.mode.any_sticks().then_some((begin, last.mode))
        });
        self.uncertainty = pattern.uncertainty;
        let kind = Kind::Periodic {
            returns: pattern.returns,
            period: pattern.period,
        };
        Some((kind, points))
    }

    fn ended(&mut self, summary: Summary, mode: Modes) -> (Kind, Vec<Moment>) {
        let Summary { t, x, ending, .. } = summary;
        let kind = match ending {
            Ending::Repelling => Kind::Repelling,
            Ending::TwoFold(which) => Kind::TwoFold(which),
            Ending::Shrunk => {
                let at = Moment { t, x };
                let rest = self.rest_on_boundary(mode, &at);
                let (kind, x) = rest.unwrap_or((Kind::Equilibrium, at.x));
                return (kind, vec![Moment { t, x }]);
            }
            Ending::EndTime | Ending::Stopped | Ending::Failed => return self.open(),
        };
        (kind, vec![Moment { t, x }])
    }

    /// The equilibrium at a point of the boundary. Its rounding may lie on either side, so the
    /// modes of the last phases are tried, too.
    fn rest_on_boundary(&self, mode: Modes, at: &Moment) -> Option<(Kind, Vector)> {
        let scale = |i| self.ever.size(i);
        let mut modes = [mode].into_iter().chain(self.history.modes());
        modes.find_map(|mode| rest_at(self.system, mode, at, scale, &self.near))
    }

    /// No pattern has closed within the longest time.
    fn open(&mut self) -> (Kind, Vec<Moment>) {
        let uses_events = self.by == By::Events || self.quiet > QUIET;
        let recurrence = if uses_events {
            &self.by_event
        } else {
            &self.by_transition
        };
        let points = recurrence.last(self.settings.kept);
        let kind = if points.len() >= self.settings.kept
            && recurrent::returns_everywhere(&points)
            && !recurrence.still_moves(recurrent::PART)
        {
            Kind::Recurrent
        } else {
            Kind::Undecided
        };
        (kind, points)
    }

    fn failed(&mut self, error: Error, orbit: &dyn OrbitUnderWay) -> (Kind, Vec<Moment>) {
        match error {
            Error::Escaped { .. } => (Kind::Escape, Vec::new()),
            Error::EventPileUp { .. } if self.settings.forcing.is_none() => {
                let at = orbit.now();
                match self.rest_on_boundary(orbit.mode(), &at) {
                    Some((kind, x)) => (kind, vec![Moment { t: at.t, x }]),
                    None => (Kind::Failure(error), Vec::new()),
                }
            }
            other => (Kind::Failure(other), Vec::new()),
        }
    }

    fn reached(&mut self, kind: Kind, points: Vec<Moment>, orbit: &dyn OrbitUnderWay) -> Reached {
        let left_at = self.left_at.take();
        let (left, mode) = left_at.unwrap_or_else(|| (orbit.now(), orbit.mode()));
        let rests = matches!(kind, Kind::Equilibrium | Kind::EquilibriumSet);
        let by_phases = self.history.in_stick(|mode| mode.any_sticks());
        let in_stick = by_phases
            .filter(|_| !rests)
            .unwrap_or_else(|| f64::from(u8::from(mode.any_sticks())));
        let (phases, transitions) = self.history.take();
        Reached {
            kind,
            period_uncertainty: self.uncertainty,
            family: None,
            points,
            phases,
            transitions,
            in_stick,
            mode,
            t: left.t,
            x: left.x,
        }
    }
}
