//! One period of a periodic orbit: its phases, and how far each event function is from a change of them.

use super::margin::{Key, Margin, Site, landing};
use super::minima::minima;
use crate::analysis::anchor::Anchor;
use crate::dynamics::{Dynamics, Modes, Moment, Orbit, Phase, Transition, Vector, run};
use crate::error::Error;
use crate::filippov::{Options, TransitionKind};
use crate::orbit::Ending;

/// A part of the period between two transitions.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub mode: Modes,
    /// What it begins with; the whole period begins with nothing where there is no transition.
    pub first: Option<Transition>,
    pub duration: f64,
}

impl Part {
    /// The state in its middle, on the boundary of what sticks, of an orbit that is followed from somewhere within a period before it.
    fn middle(
        &self,
        system: &dyn Dynamics,
        from: &Moment,
        period: f64,
        options: &Options,
    ) -> Result<Anchor, Error> {
        let t = self.first.as_ref().map_or(from.t, |at| at.t) + 0.5 * self.duration;
        let x = run(system, from, t, options)?.x;
        // A period earlier it is the same.
        let before = t - from.t > 0.5 * period;
        let t = if before { t - period } else { t };
        Ok(Anchor::new(t, x, self.mode).settled(system))
    }
}

/// What a part is, apart from its length: sequences of these are compared.
pub(crate) type Kind = (Modes, Option<(TransitionKind, usize)>);

/// One period.
#[derive(Clone, Debug)]
pub(crate) struct Circuit {
    /// The parts in order of time; the start lies in the last one.
    pub parts: Vec<Part>,
    pub margins: Vec<Margin>,
    /// The state in the middle of the part that the start lies in.
    pub anchor: Anchor,
    pub period: f64,
    /// By how much the component that moves most does so.
    pub extent: f64,
    /// By how much each does.
    pub sizes: Vector,
    /// Whether its phases are the same wherever its state may be, for all that rounding and the tolerances leave open.
    pub is_certain: bool,
}

impl Circuit {
    /// Follows the orbit from `start`, in the middle of a phase, for a period. Where that phase is so short that the start, as well as it is
    /// known, lies in the one beside it, the orbit is followed from the middle of that phase; where the start cuts one that begins just there,
    /// from the middle of the longest.
    ///
    /// # Errors
    /// Those of [`crate::solve`]; [`Error::NoUniqueFuture`].
    pub fn follow(
        system: &dyn Dynamics,
        start: &Anchor,
        period: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let found = Circuit::from(system, start, period, options)?;
        let Some(part) = found.beside(start.mode).or_else(|| found.beside_cut()) else {
            return Ok(found);
        };
        let middle = part.middle(system, start, period, options)?;
        Circuit::from(system, &middle, period, options)
    }

    /// The number of the part that it would better be anchored in, if there is one: of the parts that last, the longest of those in which the
    /// fewest contacts stick. Left is one in which more do, or that is about to vanish.
    pub fn better_part(&self, system: &dyn Dynamics) -> Option<usize> {
        const LASTING: f64 = 0.1;
        const BRIEF: f64 = 0.01;
        let durations = self.parts.iter().map(|part| part.duration);
        let most = durations.fold(0.0, f64::max);
        let stick = |part: &Part| {
            let at = part.first.as_ref()?;
            let at = at.moment();
            Some(system.normals(part.mode, &at).len())
        };
        let lasting = self.parts.iter().enumerate();
        let lasting = lasting.filter(|(_, part)| part.duration >= LASTING * most);
        let (number, fewest, longest) = lasting
            .filter_map(|(number, part)| Some((number, stick(part)?, part.duration)))
            .min_by(|(_, a, long), (_, b, longer)| a.cmp(b).then(longer.total_cmp(long)))?;
        let own = self.parts.last()?;
        let is_freer = fewest < stick(own)? && longest > own.duration;
        let is_better = is_freer || own.duration < BRIEF * most;
        is_better.then_some(number)
    }

    /// The anchor in the middle of a part.
    pub fn anchor_in(
        &self,
        system: &dyn Dynamics,
        part: usize,
        options: &Options,
    ) -> Option<Anchor> {
        let part = self.parts.get(part)?;
        part.middle(system, &self.anchor, self.period, options).ok()
    }

    /// The phase next to the start, where that is in this mode and the start is not.
    fn beside(&self, mode: Modes) -> Option<&Part> {
        let (last, others) = self.parts.split_last()?;
        let is_meant = |part: &&Part| part.mode == mode && last.mode != mode;
        let beside = [others.first()?, others.last()?];
        beside.into_iter().find(is_meant)
    }

    /// The longest phase, where one begins in a mode that the one before it does not have: the cut at the start is within rounding of
    /// a transition.
    fn beside_cut(&self) -> Option<&Part> {
        let before = self
            .parts
            .iter()
            .cycle()
            .skip(self.parts.len().checked_sub(1)?);
        let is_cut = |(before, part): (&Part, &Part)| {
            let first = part.first.as_ref();
            first.is_some_and(|at| at.from != before.mode)
        };
        let longest = || {
            let parts = self.parts.iter();
            parts.max_by(|a, b| a.duration.total_cmp(&b.duration))
        };
        before.zip(&self.parts).any(is_cut).then(longest)?
    }

    fn from(
        system: &dyn Dynamics,
        start: &Moment,
        period: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let orbit = whole(system, start, period, options)?;
        let turns: Vec<_> = transitions(&orbit).cloned().collect();
        let mut parts: Vec<Part> = Vec::with_capacity(turns.len().max(1));
        for (k, at) in turns.iter().enumerate() {
            let next = turns.get(k + 1);
            let end = next.map_or_else(|| turns[0].t + period, |next| next.t);
            parts.push(Part {
                mode: at.to,
                first: Some(at.clone()),
                duration: end - at.t,
            });
        }
        if let (true, Some(phase)) = (parts.is_empty(), orbit.phases.first()) {
            parts.push(Part {
                mode: phase.mode,
                first: None,
                duration: period,
            });
        }
        let mut margins = minima(system, &orbit, &turns);
        for (k, at) in turns.iter().enumerate() {
            margins.extend(landing(system, k, at).into_iter().flatten());
            // Whether a contact is lost or gained changes no mode: the part goes on.
            if turns.len() > 1 {
                let site = Site::Duration;
                let next = turns[(k + 1) % turns.len()].contact;
                let key = Key {
                    part: k,
                    site,
                    count: 0,
                };
                margins.push(Margin {
                    key,
                    value: parts[k].duration,
                    scale: period,
                    by_rounding: 0.0,
                    off: 0.0,
                    incoming: at.from,
                    contact: at.contact,
                    other: (next != at.contact).then_some(next),
                    at: at.moment(),
                    is_contact_function: is_of_contact(at.kind),
                });
            }
        }
        let middle = middle(&orbit, &turns, start, period)?;
        let mode = parts.last().map_or(system.undecided(), |part| part.mode);
        let sizes = sizes(&orbit);
        let anchor = Anchor { at: middle, mode }.settled(system);
        Ok(Circuit {
            parts,
            margins,
            anchor,
            period,
            extent: sizes.amax(),
            sizes,
            is_certain: true,
        })
    }

    /// What the parts are.
    pub fn sequence(&self) -> Vec<Kind> {
        let kind = |part: &Part| {
            let first = part.first.as_ref();
            (part.mode, first.map(|at| (at.kind, at.contact)))
        };
        self.parts.iter().map(kind).collect()
    }

    /// The modes gone through.
    pub fn modes(&self) -> Vec<Modes> {
        self.parts.iter().map(|part| part.mode).collect()
    }

    /// The margin of the same kind as one of another orbit near by, at about the same time: rounding may see one of several minima twice, or not.
    pub fn margin_like(&self, other: &Margin) -> Option<&Margin> {
        const SAME_TIME: f64 = 1e-3;
        let kind = |key: &Key| (key.part, key.site);
        let off = |margin: &&Margin| {
            let way = (margin.at.t - other.at.t) / self.period;
            (way - way.round()).abs()
        };
        let alike = self.margins.iter();
        let alike = alike.filter(|margin| kind(&margin.key) == kind(&other.key));
        let nearest = alike.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) <= SAME_TIME).then_some(nearest)
    }

    /// The margin with this key.
    pub fn margin(&self, key: Key) -> Option<&Margin> {
        self.margins.iter().find(|margin| margin.key == key)
    }
}

/// A phase shorter than this part of the longest one is no good start: it may be there by rounding alone.
const SHORT: f64 = 1e-6;

/// A state in the middle of a phase of a period from `start`, which may lie anywhere on the orbit, and how far the component goes that goes
/// farthest. It is the longest of the phases in which the fewest contacts stick, for stick forgets what came before, and with it by how much a
/// start is off.
///
/// # Errors
/// As [`Circuit::follow`]; [`Error::NotFound`] where there is no phase.
pub(crate) fn anchor(
    system: &dyn Dynamics,
    start: &Moment,
    period: f64,
    options: &Options,
) -> Result<(Anchor, f64), Error> {
    let orbit = whole(system, start, period, options)?;
    let durations = orbit.phases.iter().map(Phase::duration);
    let longest = durations.fold(0.0, f64::max);
    let mut best: Option<(usize, &Phase)> = None;
    for phase in &orbit.phases {
        let end = Moment {
            t: phase.t_end,
            x: phase.x_end.clone(),
        };
        let stick = system.normals(phase.mode, &end).len();
        let is_better = |(least, before): (usize, &Phase)| {
            stick < least || stick == least && phase.duration() >= before.duration()
        };
        if phase.duration() >= SHORT * longest && best.is_none_or(is_better) {
            best = Some((stick, phase));
        }
    }
    let (_, phase) = best.ok_or(Error::NotFound {
        what: "a phase on the periodic orbit",
        t: start.t,
        span: period,
    })?;
    let t = phase.t_start + 0.5 * phase.duration();
    let middle = Anchor::new(t, orbit.at(t)?, phase.mode);
    Ok((middle.settled(system), sizes(&orbit).amax()))
}

fn whole(
    system: &dyn Dynamics,
    start: &Moment,
    period: f64,
    options: &Options,
) -> Result<Orbit, Error> {
    let orbit = Orbit::solve(system, start, start.t + period, options)?;
    if orbit.end.ending == Ending::EndTime {
        return Ok(orbit);
    }
    Err(orbit.end.goes_no_further())
}

fn transitions(orbit: &Orbit) -> impl Iterator<Item = &Transition> {
    let all = orbit.transitions.iter();
    all.filter(|at| at.kind != TransitionKind::Touch)
}

pub(super) fn is_of_contact(kind: TransitionKind) -> bool {
    matches!(
        kind,
        TransitionKind::ContactLoss | TransitionKind::ContactGain
    )
}

/// The middle of the part that the start lies in.
fn middle(
    orbit: &Orbit,
    turns: &[Transition],
    start: &Moment,
    period: f64,
) -> Result<Moment, Error> {
    let (Some(first), Some(last)) = (turns.first(), turns.last()) else {
        return Ok(start.clone());
    };
    // By the forcing's period it may be taken to lie before the start.
    let t = 0.5 * (first.t + last.t - period);
    let inside = if t < orbit.start.t { t + period } else { t };
    let x = orbit.at(inside.min(orbit.end.t))?;
    Ok(Moment { t, x })
}

/// How far the components go, at the ends of steps.
fn sizes(orbit: &Orbit) -> Vector {
    let (mut low, mut high) = (orbit.start.x.clone(), orbit.start.x.clone());
    for (step, _) in &orbit.steps {
        for i in 0..low.len() {
            low[i] = low[i].min(step.x_end[i]);
            high[i] = high[i].max(step.x_end[i]);
        }
    }
    high - low
}
