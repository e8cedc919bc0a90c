//! Changes of the phases of a periodic orbit: where in a parameter, and at which event function.

pub(super) mod circuit;
pub(super) mod determined;
mod extrapolation;
pub(super) mod locate;
mod margin;
mod minima;
mod name;
mod tolerance;

use crate::dynamics::{Dynamics, Modes, Moment, Vector};
use crate::filippov::Options;
use circuit::Circuit;
use determined::LEAST;
use extrapolation::zero_beyond;
use locate::{Known, least, shortfall};
pub use name::SequenceBifurcation;
use tolerance::Near;
pub(super) use tolerance::of_tolerance;

/// A change of the phases of a periodic orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct SequenceChange {
    /// The parameter: where the event function is zero, if that could be sought from both sides, or of the last orbit before the change.
    pub parameter: f64,
    /// Between that orbit and the nearest parameter that was seen with other phases, or without such an orbit; or, where orbits could not be computed
    /// that near, how far behind the last of them its event function would be zero. What the tolerances have it off by is in it, as another orbit with a tenth of
    /// them tells; of methods with fixed steps nothing does.
    pub uncertainty: f64,
    /// What it is called.
    pub bifurcation: SequenceBifurcation,
    /// The contacts whose event function vanishes, counted from 0: two at a coincidence, none where the change has no name, or else one.
    pub contacts: Vec<usize>,
    /// Where on the orbit, on the boundary to rounding.
    pub x: Vector,
    /// The event function there on the orbit that it was located from, in units of the size that it has on this orbit.
    pub residual: f64,
    /// First and second derivative in time of the contact's distance from the boundary there, along the field that the orbit comes by; not
    /// numbers where it comes by stick. At a graze the first is zero.
    pub own: [f64; 2],
    /// The same, positive on the other side, along that side's field. At a crossing- or switching-sliding the first is zero, and the sign of
    /// the second tells them apart.
    pub other: [f64; 2],
    /// Period of the orbit.
    pub period: f64,
    /// The modes before it: coming from where the branch was followed; of a sweep, on the side of the value before. None where the orbit was
    /// followed from the other side and none was found on this one.
    pub before: Vec<Modes>,
    /// The modes behind it, of the orbit that was found next to it: the one that it becomes there, or, where the branch turns back, the one that it
    /// meets; none where none was found.
    pub after: Vec<Modes>,
}

/// Where a change was located on a branch.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// The parameter of the last orbit before it.
    pub parameter: f64,
    /// From that orbit to the nearest place that was seen to lie behind the change.
    pub bracket: f64,
    /// Parameter per place.
    pub scale: f64,
    /// The way back from it along the parameter; zero where that is not known.
    pub away: f64,
}

impl Place {
    /// Behind the last of some orbits whose places are the parameter.
    pub fn in_parameter<B>(good: &[Known<B>], bad: f64) -> Option<Self> {
        let (first, last) = (good.first()?, good.last()?);
        let away = first.s - last.s;
        Some(Place {
            parameter: last.s,
            bracket: (bad - last.s).abs(),
            scale: 1.0,
            away: if away == 0.0 { last.s - bad } else { away },
        })
    }
}

/// Periodic orbits about a change.
pub(super) trait Orbits<B> {
    /// The orbit at a parameter, which is its place; `new` have been found so already.
    fn at(&self, parameter: f64, new: &[Known<B>]) -> Option<Known<B>>;

    /// An orbit with a tenth of the tolerances, at the same parameter.
    fn finer(&self, orbit: &Known<B>) -> Option<Circuit>;
}

/// Describes the change behind the last orbit of `good`.
pub(super) fn describe<B: Clone>(
    system: &dyn Dynamics,
    good: &[Known<B>],
    after: Vec<Modes>,
    place: Place,
    orbits: &impl Orbits<B>,
) -> Option<SequenceChange> {
    let last = good.last()?;
    let margin = least(&last.circuit)?;
    let (bifurcation, rates) = name::name(system, margin);
    let is_named = bifurcation != SequenceBifurcation::Unnamed;
    let (mut parameter, mut uncertainty) = (place.parameter, place.scale * place.bracket);
    let mut x = margin.at.x.clone();
    // Where it has no name, no event function tells how far it is.
    if is_named {
        uncertainty = uncertainty.max(place.scale * shortfall(good, margin));
        let mut edge = last.clone();
        edge.s = parameter;
        let is_open = margin.off > LEAST * margin.scale && place.away != 0.0;
        let beyond = || zero_beyond(edge.clone(), margin.key, uncertainty, place.away, orbits);
        if let Some(zero) = is_open.then(beyond).flatten() {
            (parameter, uncertainty, x) = (zero.parameter, zero.uncertainty, zero.x);
        } else {
            let near = Near {
                last: &edge,
                margin,
                away: place.away,
                lacks: uncertainty,
                about: orbits,
            };
            parameter = near.passed().unwrap_or(parameter);
            uncertainty += near.shift_by_tolerances();
        }
    }
    Some(SequenceChange {
        parameter,
        uncertainty,
        bifurcation,
        contacts: if is_named {
            [margin.contact].into_iter().chain(margin.other).collect()
        } else {
            Vec::new()
        },
        x,
        residual: margin.relative(),
        own: rates.own,
        other: rates.other,
        period: last.circuit.period,
        before: last.circuit.modes(),
        after,
    })
}

/// The circuit of a periodic orbit through `start`, begun in the middle of its longest slip, or where the fewest contacts stick.
pub(super) fn circuit_from(
    system: &dyn Dynamics,
    start: &Moment,
    period: f64,
    options: &Options,
) -> Option<Circuit> {
    let (anchor, _) = circuit::anchor(system, start, period, options).ok()?;
    Circuit::follow(system, &anchor, period, options).ok()
}
