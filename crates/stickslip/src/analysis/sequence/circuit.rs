//! One period of a periodic orbit: its phases, and how far each event function is from a change of them.

use super::margin::{Key, Margin, Site, landing};
use super::minima::minima;
use crate::analysis::anchor::Anchor;
use crate::error::Error;
use crate::filippov::{Options, Phase, Summary, Switched, Transition, TransitionKind, run, solve};
use crate::ode::Timed;
use crate::orbit::{Ending, Orbit};
use crate::system::State;

/// A part of the period between two transitions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part<const N: usize, K> {
    pub mode: K,
    /// What it begins with; the whole period begins with nothing where there is no transition.
    pub first: Option<Transition<N, K>>,
    pub duration: f64,
}

impl<const N: usize, K> Part<N, K> {
    /// The state in its middle, on the boundary of what sticks, of an orbit that is followed from somewhere within a period before it.
    fn middle<S: Switched<N, G, Mode = K>, const G: usize>(
        &self,
        system: &S,
        from: &Timed<N>,
        period: f64,
        options: &Options,
    ) -> Result<Anchor<N, K>, Error>
    where
        K: Copy,
    {
        let t = self.first.as_ref().map_or(from.t, |at| at.t) + 0.5 * self.duration;
        let x = run(system, from.t, from.x, t, options, &mut ())?.x;
        // A period earlier it is the same.
        let before = t - from.t > 0.5 * period;
        let t = if before { t - period } else { t };
        Ok(Anchor::of(&Timed { t, x }, self.mode).settled(system))
    }
}

/// What a part is, apart from its length: sequences of these are compared.
pub(crate) type Kind<K> = (K, Option<(TransitionKind, usize)>);

/// One period.
#[derive(Clone, Debug)]
pub(crate) struct Circuit<const N: usize, K> {
    /// The parts in order of time; the start lies in the last one.
    pub parts: Vec<Part<N, K>>,
    pub margins: Vec<Margin<N, K>>,
    /// The state in the middle of the part that the start lies in.
    pub anchor: Anchor<N, K>,
    pub period: f64,
    /// By how much the component that moves most does so.
    pub extent: f64,
    /// By how much each does.
    pub sizes: State<N>,
    /// Whether its phases are the same wherever its state may be, for all that rounding and the tolerances leave open.
    pub is_certain: bool,
}

impl<const N: usize, K: Copy + PartialEq> Circuit<N, K> {
    /// Follows the orbit from `start`, in the middle of a phase, for a period. Where that phase is so short that the start, as well as it is
    /// known, lies in the one beside it, the orbit is followed from the middle of that phase; where the start cuts one that begins just there,
    /// from the middle of the longest.
    ///
    /// # Errors
    /// Those of [`solve`]; [`Error::NoUniqueFuture`].
    pub fn follow<S: Switched<N, G, Mode = K>, const G: usize>(
        system: &S,
        start: &Anchor<N, K>,
        period: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let found = Circuit::from(system, &start.at(), period, options)?;
        let Some(part) = found.beside(start.mode).or_else(|| found.beside_cut()) else {
            return Ok(found);
        };
        let middle = part.middle(system, &start.at(), period, options)?;
        Circuit::from(system, &middle.at(), period, options)
    }

    /// The number of the part that it would better be anchored in, if there is one: of the parts that last, the longest of those in which the
    /// fewest contacts stick. Left is one in which more do, or that is about to vanish.
    pub fn better_part<S: Switched<N, G, Mode = K>, const G: usize>(
        &self,
        system: &S,
    ) -> Option<usize> {
        const LASTING: f64 = 0.1;
        const BRIEF: f64 = 0.01;
        let durations = self.parts.iter().map(|part| part.duration);
        let most = durations.fold(0.0, f64::max);
        let stick = |part: &Part<N, K>| {
            let at = part.first.as_ref()?;
            let at = Timed { t: at.t, x: at.x };
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
    pub fn anchor_in<S: Switched<N, G, Mode = K>, const G: usize>(
        &self,
        system: &S,
        part: usize,
        options: &Options,
    ) -> Option<Anchor<N, K>> {
        let part = self.parts.get(part)?;
        part.middle(system, &self.anchor.at(), self.period, options)
            .ok()
    }

    /// The phase next to the start, where that is in this mode and the start is not.
    fn beside(&self, mode: K) -> Option<&Part<N, K>> {
        let (last, others) = self.parts.split_last()?;
        let is_meant = |part: &&Part<N, K>| part.mode == mode && last.mode != mode;
        let beside = [others.first()?, others.last()?];
        beside.into_iter().find(is_meant)
    }

    /// The longest phase, where one begins in a mode that the one before it does not have: the cut at the start is within rounding of
    /// a transition.
    fn beside_cut(&self) -> Option<&Part<N, K>> {
        let before = self
            .parts
            .iter()
            .cycle()
            .skip(self.parts.len().checked_sub(1)?);
        let is_cut = |(before, part): (&Part<N, K>, &Part<N, K>)| {
            part.first.is_some_and(|at| at.from != before.mode)
        };
        let longest = || {
            let parts = self.parts.iter();
            parts.max_by(|a, b| a.duration.total_cmp(&b.duration))
        };
        before.zip(&self.parts).any(is_cut).then(longest)?
    }

    fn from<S: Switched<N, G, Mode = K>, const G: usize>(
        system: &S,
        start: &Timed<N>,
        period: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let orbit = whole(system, start, period, options)?;
        let turns: Vec<_> = transitions(&orbit).copied().collect();
        let mut parts: Vec<Part<N, K>> = Vec::with_capacity(turns.len().max(1));
        for (k, at) in turns.iter().enumerate() {
            let next = turns.get(k + 1);
            let end = next.map_or_else(|| turns[0].t + period, |next| next.t);
            parts.push(Part {
                mode: at.to,
                first: Some(*at),
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
                    at: Timed { t: at.t, x: at.x },
                    is_contact_function: is_of_contact(at.kind),
                });
            }
        }
        let middle = middle(&orbit, &turns, start, period)?;
        let mode = parts.last().map_or(S::UNDECIDED, |part| part.mode);
        let sizes = sizes(&orbit);
        let anchor = Anchor::of(&middle, mode).settled(system);
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
    pub fn sequence(&self) -> Vec<Kind<K>> {
        let kind = |part: &Part<N, K>| (part.mode, part.first.map(|at| (at.kind, at.contact)));
        self.parts.iter().map(kind).collect()
    }

    /// The modes gone through.
    pub fn modes(&self) -> Vec<K> {
        self.parts.iter().map(|part| part.mode).collect()
    }

    /// The margin of the same kind as one of another orbit near by, at about the same time: rounding may see one of several minima twice, or not.
    pub fn margin_like(&self, other: &Margin<N, K>) -> Option<&Margin<N, K>> {
        const SAME_TIME: f64 = 1e-3;
        let kind = |key: &Key| (key.part, key.site);
        let off = |margin: &&Margin<N, K>| {
            let way = (margin.at.t - other.at.t) / self.period;
            (way - way.round()).abs()
        };
        let alike = self.margins.iter();
        let alike = alike.filter(|margin| kind(&margin.key) == kind(&other.key));
        let nearest = alike.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) <= SAME_TIME).then_some(nearest)
    }

    /// The margin with this key.
    pub fn margin(&self, key: Key) -> Option<&Margin<N, K>> {
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
pub(crate) fn anchor<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    start: &Timed<N>,
    period: f64,
    options: &Options,
) -> Result<(Anchor<N, S::Mode>, f64), Error> {
    let orbit = whole(system, start, period, options)?;
    let durations = orbit.phases.iter().map(Phase::duration);
    let longest = durations.fold(0.0, f64::max);
    let mut best: Option<(usize, &Phase<N, S::Mode>)> = None;
    for phase in &orbit.phases {
        let end = Timed {
            t: phase.t_end,
            x: phase.x_end,
        };
        let stick = system.normals(phase.mode, &end).len();
        let is_better = |(least, before): (usize, &Phase<N, S::Mode>)| {
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
    let middle = Anchor::of(&Timed { t, x: orbit.at(t)? }, phase.mode);
    Ok((middle.settled(system), sizes(&orbit).amax()))
}

fn whole<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    start: &Timed<N>,
    period: f64,
    options: &Options,
) -> Result<Orbit<N, S::Mode>, Error> {
    let orbit = solve(system, start.t, start.x, start.t + period, options)?;
    if orbit.ending == Ending::EndTime {
        return Ok(orbit);
    }
    let end = Summary {
        ending: orbit.ending,
        t: orbit.t_end,
        x: orbit.x_end,
        counters: orbit.counters,
    };
    Err(end.goes_no_further())
}

fn transitions<const N: usize, K>(orbit: &Orbit<N, K>) -> impl Iterator<Item = &Transition<N, K>> {
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
fn middle<const N: usize, K>(
    orbit: &Orbit<N, K>,
    turns: &[Transition<N, K>],
    start: &Timed<N>,
    period: f64,
) -> Result<Timed<N>, Error> {
    let (Some(first), Some(last)) = (turns.first(), turns.last()) else {
        return Ok(*start);
    };
    // By the forcing's period it may be taken to lie before the start.
    let t = 0.5 * (first.t + last.t - period);
    let inside = if t < orbit.t_start { t + period } else { t };
    let x: State<N> = orbit.at(inside.min(orbit.t_end))?;
    Ok(Timed { t, x })
}

/// How far the components go, at the ends of steps.
fn sizes<const N: usize, K>(orbit: &Orbit<N, K>) -> State<N> {
    let (mut low, mut high) = (orbit.x_start, orbit.x_start);
    for step in &orbit.steps {
        for i in 0..N {
            low[i] = low[i].min(step.x_end[i]);
            high[i] = high[i].max(step.x_end[i]);
        }
    }
    high - low
}
