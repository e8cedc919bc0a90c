//! One orbit on its way to its attractor: what is noted of it, and when that is enough.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use super::drawn_in::Trap;
use super::history::History;
use super::nearness::{Extent, Nearness};
use super::reached::{Kind, Reached, SectionPoint};
use super::recurrence::{Pattern, Recurrence};
use super::rest::{kind_of_rest, rest_at};
use super::{RecurrenceSettings, recurrent, turning::Turning};
use crate::error::Error;
use crate::filippov::{
    EventFunctions, Happening, Integration, Options, Progress, Summary, Switched, Transition,
    TransitionKind, Watched,
};
use crate::dynamics::Moment;
use crate::orbit::Ending;
use crate::system::State;

/// Steps without a transition after which the turning points of the first state are watched.
const QUIET: usize = 100;

/// Steps without a transition after which an equilibrium is looked for that the orbit may be drawn to. Then half as many more are needed, and so
/// on: a cycle with long phases is asked a few times in all.
const CALM: usize = 12;

/// A look for a point of rest is put off by no more steps than this.
const MOST_PATIENT: usize = 64;

/// Phases that are kept for each return of the longest pattern.
const PHASES: usize = 4;

/// What makes the points of the section.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    /// The events' own transitions.
    Transitions,
    /// A section of the user's.
    Events,
}

/// How far one stage has brought it.
enum Stage {
    /// Nothing has happened for long.
    Quiet,
    /// It is known, or the run is over.
    Done(Kind, Vec<SectionPoint>),
}

/// What is noted of an orbit.
pub(super) struct Search<'a> {
    system: &'a dyn Dynamics,
    settings: &'a RecurrenceSettings,
    near: Nearness,
    by: By,
    by_transition: Recurrence,
    by_event: Recurrence,
    history: History,
    /// What has happened since the last point of either kind.
    tag: DefaultHasher,
    /// Where the orbit has been since the last point, and since its start.
    lately: Extent,
    ever: Extent,
    /// State at the step before.
    before: Vector,
    /// Steps since the last transition.
    quiet: usize,
    /// How many steps a look for a point of rest is put off, and how many are left of that.
    patience: (usize, usize),
    /// Steps since the last transition at which a trap is looked for next.
    asked_at: usize,
    /// The one that was found in this phase.
    trap: Option<Trap>,
    escape: f64,
    /// Where it is said to be left, if not where it is.
    left_at: Option<(Moment, Modes)>,
    /// By how much the period that was found may be off.
    uncertainty: f64,
}

impl<'a> Search<'a> {
    pub fn new(
        system: &'a dyn Dynamics,
        x: &Vector,
        by: By,
        settings: &'a RecurrenceSettings,
        options: &Options,
    ) -> Self {
        let near = Nearness {
            closeness: settings.closeness,
            rtol: options.rtol,
            atol: options.atol,
        };
        let most = settings.most_returns;
        let recurrence = || Recurrence::new(near, settings.forcing, most, settings.kept);
        Search {
            system,
            settings,
            near,
            by,
            by_transition: recurrence(),
            by_event: recurrence(),
            history: History::of(PHASES * most.max(settings.kept)),
            tag: DefaultHasher::new(),
            lately: Extent::of(x),
            ever: Extent::of(x),
            before: *x,
            quiet: 0,
            patience: (1, 0),
            asked_at: CALM,
            trap: None,
            escape: options.escape,
            left_at: None,
            uncertainty: 0.0,
        }
    }

    /// Follows the orbit to the end.
    pub fn follow<V: EventFunctions<N, E>, const E: usize>(
        mut self,
        integration: Integration<'a>,
        section: &V,
    ) -> Reached {
        let mut watched = Watched::new(integration, section).endless();
        let may_be_quiet = E == 0 && self.settings.forcing.is_none();
        match self.stage(&mut watched, may_be_quiet) {
            Stage::Done(kind, points) => self.reached(kind, points, watched.integration()),
            Stage::Quiet => {
                let turning = Turning::of(self.system);
                let mut watched = Watched::new(watched.into_integration(), &turning).endless();
                match self.stage(&mut watched, false) {
                    Stage::Done(kind, points) => self.reached(kind, points, watched.integration()),
                    Stage::Quiet => {
                        self.reached(Kind::Undecided, Vec::new(), watched.integration())
                    }
                }
            }
        }
    }

    fn stage<'w, V: EventFunctions<N, E>, const E: usize>(
        &mut self,
        watched: &mut Watched<'w, S, V, N, E, G>,
        may_be_quiet: bool,
    ) -> Stage {
        loop {
            let happening = match watched.step() {
                Ok(happening) => happening,
                Err(error) => return self.failed(error, watched.integration()),
            };
            let done = match happening {
                Happening::Event(event) => {
                    let at = SectionPoint {
                        t: event.t,
                        x: event.x,
                    };
                    self.event(at, event.mode)
                }
                Happening::Progress(Progress::Step) => {
                    let integration = watched.integration();
                    let mode = integration.mode();
                    let at = Moment {
                        t: integration.t(),
                        x: *integration.x(),
                    };
                    self.quiet += 1;
                    if may_be_quiet && self.quiet > QUIET {
                        return Stage::Quiet;
                    }
                    self.step(mode, &at)
                }
                Happening::Progress(Progress::PhaseEnd(phase)) => {
                    self.history.phase(phase);
                    None
                }
                Happening::Progress(Progress::Transition(at)) => self.transition(&at),
                Happening::Progress(Progress::End(summary)) => {
                    let mode = watched.integration().mode();
                    Some(self.ended(&summary, mode))
                }
            };
            if let Some((kind, points)) = done {
                return Stage::Done(kind, points);
            }
        }
    }

    fn step(&mut self, mode: Modes, at: &Moment) -> Option<(Kind, Vec<SectionPoint>)> {
        self.lately.include(&at.x);
        self.ever.include(&at.x);
        let moved = at.x - self.before;
        self.before = at.x;
        if self.settings.forcing.is_none() && self.quiet >= self.asked_at {
            self.asked_at += self.asked_at / 2;
            if !self.trap.as_ref().is_some_and(|trap| trap.draws(&at.x)) {
                self.trap = Trap::near(self.system, mode, at, self.escape);
            }
        }
        if let Some(trap) = &self.trap
            && trap.holds(&at.x)
        {
            let x = trap.x;
            let left = Moment {
                t: at.t,
                x: self.near_to(&x, &at.x),
            };
            self.left_at = Some((left, mode));
            return Some((Kind::Equilibrium, vec![SectionPoint { t: at.t, x }]));
        }
        let scale = State::from_fn(|i, _| self.ever.size(i));
        let stays = |i: usize| moved[i].abs() <= self.near.allowed(scale[i]);
        if self.settings.forcing.is_some() || !(0..N).all(stays) {
            return None;
        }
        let (patience, left) = &mut self.patience;
        if *left > 0 {
            *left -= 1;
            return None;
        }
        // A step may be short for another reason: the next look comes after twice as many.
        *left = *patience;
        *patience = (2 * *patience).min(MOST_PATIENT);
        let (kind, x) = rest_at(self.system, mode, at, &scale, &self.near)?;
        Some((kind, vec![SectionPoint { t: at.t, x }]))
    }

    /// The state on the way from `x` to an equilibrium at which the two count as the same.
    fn near_to(&self, equilibrium: &Vector, x: &Vector) -> Vector {
        let away = x - equilibrium;
        let parts = (0..N).map(|i| self.near.allowed(self.ever.size(i)) / away[i].abs());
        equilibrium + away * parts.fold(1.0, f64::min)
    }

    fn transition(&mut self, at: &Transition) -> Option<(Kind, Vec<SectionPoint>)> {
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
        // Turning points count where there is nothing else for long.
        self.by_event.clear();
        let (tag, extent) = self.since_last(&at.x);
        let at = SectionPoint { t: at.t, x: at.x };
        let found = self
            .by_transition
            .pass(at, tag, self.history.count(), extent);
        self.closes(found, By::Transitions)
    }

    fn event(
        &mut self,
        at: SectionPoint,
        mode: Modes,
    ) -> Option<(Kind, Vec<SectionPoint>)> {
        if self.by == By::Transitions && self.quiet <= QUIET {
            return None;
        }
        let (tag, extent) = self.since_last(&at.x);
        let found = self.by_event.pass(at, tag, self.history.count(), extent);
        let is_held = found.is_some_and(|pattern| self.rests(&pattern, mode));
        let here = Moment { t: at.t, x: at.x };
        if is_held && let Some(kind) = kind_of_rest(self.system, mode, &here) {
            return Some((kind, vec![at]));
        }
        self.closes(found, By::Events)
    }

    /// Whether friction has held the orbit in one place while the drive went through its period: then it does so for ever.
    fn rests(&self, pattern: &Pattern, mode: Modes) -> bool {
        let Pattern { extent, counts, .. } = pattern;
        let moves = extent.high - extent.low;
        let stays = |i: usize| moves[i] <= self.near.rounding(extent.size(i));
        let is_held = mode.any_sticks() && counts.0.transitions == counts.1.transitions;
        self.settings.forcing.is_some() && is_held && (0..N).all(stays)
    }

    /// What has happened since the last point, and where the orbit has been; from here it counts anew.
    fn since_last(&mut self, x: &Vector) -> (u64, Extent) {
        let tag = self.tag.finish();
        self.tag = DefaultHasher::new();
        let mut extent = self.lately;
        extent.include(x);
        self.lately = Extent::of(x);
        (tag, extent)
    }

    fn closes(
        &mut self,
        found: Option<Pattern>,
        by: By,
    ) -> Option<(Kind, Vec<SectionPoint>)> {
        let pattern = found?;
        let recurrence = match by {
            By::Transitions => &self.by_transition,
            By::Events => &self.by_event,
        };
        let points = recurrence.last(pattern.returns);
        self.history.keep(&pattern.counts);
        // Where stick may have ended is a bad place to go on from: at another parameter an orbit from there may miss the stick that is still to
        // come.
        let ended = self.history.last_phase().filter(|_| by == By::Transitions);
        self.left_at = ended.and_then(|last| {
            let begin = Moment {
                t: last.t_start,
                x: last.x_start,
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

    fn ended(&mut self, summary: &dyn Dynamicsummary, mode: Modes) -> (Kind, Vec<SectionPoint>) {
        let Summary { t, x, .. } = *summary;
        let kind = match summary.ending {
            Ending::Repelling => Kind::Repelling,
            Ending::TwoFold(which) => Kind::TwoFold(which),
            Ending::Shrunk => {
                let rest = self.rest_on_boundary(mode, &Moment { t, x });
                let (kind, x) = rest.unwrap_or((Kind::Equilibrium, x));
                return (kind, vec![SectionPoint { t, x }]);
            }
            Ending::EndTime | Ending::Stopped | Ending::Failed => return self.open(),
        };
        (kind, vec![SectionPoint { t, x }])
    }

    /// The equilibrium at a point of the boundary. Its rounding is on either side, and of neither
    /// side's is it said which the last phase was beside.
    fn rest_on_boundary(&self, mode: Modes, at: &Moment) -> Option<(Kind, Vector)> {
        let scale = State::from_fn(|i, _| self.ever.size(i));
        let mut modes = [mode].into_iter().chain(self.history.modes());
        modes.find_map(|mode| rest_at(self.system, mode, at, &scale, &self.near))
    }

    /// Nothing has closed in the longest time.
    fn open(&mut self) -> (Kind, Vec<SectionPoint>) {
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

    fn failed(&mut self, error: Error, integration: &Integration<'_>) -> Stage {
        match error {
            Error::Escaped { .. } => Stage::Done(Kind::Escape, Vec::new()),
            Error::EventPileUp { .. } if self.settings.forcing.is_none() => {
                let at = Moment {
                    t: integration.t(),
                    x: *integration.x(),
                };
                match self.rest_on_boundary(integration.mode(), &at) {
                    Some((kind, x)) => Stage::Done(kind, vec![SectionPoint { t: at.t, x }]),
                    None => Stage::Done(Kind::Failure(error), Vec::new()),
                }
            }
            other => Stage::Done(Kind::Failure(other), Vec::new()),
        }
    }

    fn reached(
        self,
        kind: Kind,
        points: Vec<SectionPoint>,
        integration: &Integration<'_>,
    ) -> Reached {
        let now = Moment {
            t: integration.t(),
            x: *integration.x(),
        };
        let (left, mode) = self.left_at.unwrap_or((now, integration.mode()));
        let rests = matches!(kind, Kind::Equilibrium | Kind::EquilibriumSet);
        let by_phases = self.history.in_stick(S::any_sticks);
        let in_stick = by_phases
            .filter(|_| !rests)
            .unwrap_or_else(|| f64::from(u8::from(mode.any_sticks())));
        let (phases, transitions) = self.history.into_parts();
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
