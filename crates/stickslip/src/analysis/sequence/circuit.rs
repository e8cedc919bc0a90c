//! One period of a periodic orbit: its phases, and how far each event function is from a change of them.

use super::margin::{Key, Margin, Site, landing};
use super::minima::minima;
use crate::error::Error;
use crate::filippov::{Options, Switched, Transition, TransitionKind, solve};
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

/// What a part is, apart from its length: sequences of these are compared.
pub(crate) type Kind<K> = (K, Option<(TransitionKind, usize)>);

/// One period.
#[derive(Clone, Debug)]
pub(crate) struct Circuit<const N: usize, K> {
    /// The parts in order of time; the start lies in the last one.
    pub parts: Vec<Part<N, K>>,
    pub margins: Vec<Margin<N, K>>,
    /// The state in the middle of the part that the start lies in.
    pub anchor: Timed<N>,
    pub period: f64,
    /// By how much the component that moves most does so.
    pub extent: f64,
}

impl<const N: usize, K: Copy + PartialEq> Circuit<N, K> {
    /// Follows the orbit from `start`, in the middle of a slip, for a period.
    ///
    /// # Errors
    /// Those of [`solve`]; [`Error::NoUniqueFuture`].
    pub fn follow<S: Switched<N, G, Mode = K>, const G: usize>(
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
                    incoming: at.from,
                    contact: at.contact,
                    other: (next != at.contact).then_some(next),
                    at: Timed { t: at.t, x: at.x },
                    is_contact_function: is_of_contact(at.kind),
                });
            }
        }
        let anchor = middle(&orbit, &turns, start, period)?;
        Ok(Circuit {
            parts,
            margins,
            anchor,
            period,
            extent: extent(&orbit),
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

    /// The margin with this key.
    pub fn margin(&self, key: Key) -> Option<&Margin<N, K>> {
        self.margins.iter().find(|margin| margin.key == key)
    }
}

/// A state in the middle of the longest slip of a period from `start`, which may lie anywhere on the orbit, and how far the component goes that goes
/// farthest.
///
/// # Errors
/// As [`Circuit::follow`]; [`Error::NotFound`] where a contact sticks all the time.
pub(crate) fn anchor<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    start: &Timed<N>,
    period: f64,
    options: &Options,
) -> Result<(Timed<N>, f64), Error> {
    let orbit = whole(system, start, period, options)?;
    let slips = orbit
        .phases
        .iter()
        .filter(|phase| !S::any_sticks(phase.mode));
    let longest = slips.max_by(|a, b| a.duration().total_cmp(&b.duration()));
    let Some(phase) = longest else {
        return Err(Error::NotFound {
            what: "a slip on the periodic orbit",
            t: start.t,
            span: period,
        });
    };
    let t = phase.t_start + 0.5 * phase.duration();
    Ok((Timed { t, x: orbit.at(t)? }, extent(&orbit)))
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
    Err(Error::NoUniqueFuture {
        t: orbit.t_end,
        x: (&orbit.x_end).into(),
    })
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

/// How far the component goes, at the ends of steps, that goes farthest.
fn extent<const N: usize, K>(orbit: &Orbit<N, K>) -> f64 {
    let (mut low, mut high) = (orbit.x_start, orbit.x_start);
    for step in &orbit.steps {
        for i in 0..N {
            low[i] = low[i].min(step.x_end[i]);
            high[i] = high[i].max(step.x_end[i]);
        }
    }
    (high - low).amax()
}
