//! Periodic orbits as segments with a given sequence of modes.
//!
//! Each segment ends where its own event function vanishes. The unknowns are the state and the time
//! at which the first segment begins, and the durations. The equations are that the orbit closes
//! and that the event functions vanish (Thota & Dankowicz 2008; Dankowicz & Schilder 2013). The
//! sequence does not react to the guards. So the orbit continues smoothly where it touches a
//! boundary, and a change of its phases is the zero of a margin along the branch.

mod equations;
mod jacobian;
mod margin;
mod minima;
mod newton;
mod outline;
mod path;
mod pieces;
mod sequence_change;
mod shooting;
mod step_budget;

use super::Stability;
use super::multipliers::eigenvalues;
use crate::dynamics::{Dynamics, Matrix, Moment, Vector};
use crate::filippov::Options;
pub(super) use jacobian::Jacobian;
pub(super) use margin::{Margin, MarginKind};
pub(super) use outline::OrbitGuess;
pub(super) use outline::SegmentEnd;
use outline::{Segment, SegmentKind, ShootingNodes, segment_to_cut};
pub(super) use path::{
    AT_ZERO, LocatedZero, SAFETY, SolutionFunction, SolutionsOnLine, with_last_digits,
};
use pieces::across;
pub(super) use sequence_change::describe;
pub use sequence_change::{SequenceBifurcation, SequenceChange};
pub use step_budget::StepBudget;

/// Number of tolerances within which an orbit closes and its event functions vanish: an allowance
/// for the errors of about as many steps.
const TOLERANCES: f64 = 100.0;

/// Units in the last place that a step may leave in a residual: about one for each stage.
pub(super) const ULPS: f64 = 16.0;

/// Relative error within which an orbit closes and its event functions vanish.
pub(super) fn closeness(options: &Options) -> f64 {
    error_of(options.coarsest())
}

/// Error of an orbit with this error of a step.
pub(super) fn error_of(allowed: f64) -> f64 {
    TOLERANCES * allowed
}

/// Smallest length that orbits resolve with this error of a step: a hundred times the residual in
/// which they close.
pub(super) fn resolved(allowed: f64) -> f64 {
    TOLERANCES * error_of(allowed)
}

/// The equations for a periodic orbit of a system.
#[derive(Clone, Copy)]
pub(crate) struct Shooting<'a> {
    pub system: &'a dyn Dynamics,
    /// Number of components that are states; parameters follow them.
    pub states: usize,
    /// Number of the drive's periods in that of the orbit, where it prescribes that. The drive's
    /// period counts as 1 where the system does not tell it.
    pub forced: Option<f64>,
    /// Extent of the widest orbit so far.
    pub extent: f64,
    /// Dimension of the families to which the orbits belong.
    pub family: usize,
    /// An additional equation where two parameters are unknown: the product of the unknowns with a
    /// row has a given value.
    pub plane: Option<(&'a Vector, f64)>,
    pub options: &'a Options,
    /// Whether every step, and every piece that carries tangent vectors, is taken in two halves. So
    /// the result differs by nearly the whole error, whatever decides the steps.
    pub is_finer: bool,
    /// Steps that the orbits may take; `None` for any number.
    pub budget: Option<&'a StepBudget>,
}

/// A vector of this length with a 1 at a place.
pub(crate) fn unit(count: usize, place: usize) -> Vector {
    Vector::from_fn(count, |i, _| f64::from(u8::from(i == place)))
}

/// A computed periodic orbit.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Cycle {
    pub outline: OrbitGuess,
    /// Start of each segment.
    pub begins: Vec<Moment>,
    pub period: f64,
    /// The derivative of the equations by the unknowns.
    pub jacobian: Jacobian,
    /// The derivative of the flow map of the states over the period from the cut, with saltation at
    /// every event; in an autonomous system, transverse to the flow. It is not finite where an
    /// event has no speed: the flow map has no derivative at a graze, while the equations do.
    pub monodromy: Matrix,
    /// The margins to each change of its phases.
    pub margins: Vec<Margin>,
    /// The largest range of a component; of an orbit that does not move, the size of its state, or
    /// 1 if that is zero.
    pub extent: f64,
    /// The range of each state.
    pub ranges: Vector,
    /// The middle of the segment that is cut there.
    pub anchor: Moment,
    /// Residual allowed in its equations, in the unit of the states.
    pub closes_to: f64,
    /// Number of steps.
    pub steps: usize,
    /// Number of Newton iterations.
    pub iterations: usize,
    /// Dimension of the family of orbits to which it belongs.
    pub family: usize,
    /// The flights before impacts that accumulate: segment, and time to the first impact.
    pub flights: Vec<(usize, f64)>,
}

impl Cycle {
    /// Directions of the states, a column for each of [`Cycle::Monodromy::of`]: the axes or, in an
    /// autonomous system, a basis across the flow.
    pub fn directions(&self, system: &dyn Dynamics) -> Matrix {
        let n = self.ranges.len();
        if self.monodromy.ncols() == n {
            return Matrix::identity(n, n);
        }
        let cut = self.outline.cut.as_ref().map_or(0, |cut| cut.number);
        let segment = &self.outline.segments[cut];
        let velocity = system.flow(segment.mode, &segment.inside);
        let velocity = velocity.velocity(&self.anchor);
        across(&velocity.rows(0, n).into_owned())
    }

    /// Whether the flow map has a derivative at the orbit.
    pub fn is_differentiable(&self) -> bool {
        self.monodromy.iter().all(|entry| entry.is_finite())
    }

    /// Whether all its multipliers lie inside the unit circle, as [`Stability`] counts it.
    pub fn is_stable(&self) -> bool {
        Stability::of(&eigenvalues(&self.monodromy)) == Stability::Stable
    }

    /// Whether the cut segment has become much shorter than the longest one, or the end of a
    /// segment in flight has come near to an impact.
    pub fn is_badly_cut(&self) -> bool {
        // Fraction of the longest segment, and of a flight on either side of where it is cut.
        // Chosen: below 1, so that two segments that are about equally long do not alternate.
        const SHORTENED: f64 = 0.3;
        let is_near_end = |&(number, lasts): &(usize, f64)| {
            let part = self.outline.segments[number].duration / lasts;
            !(SHORTENED..=1.0 - SHORTENED).contains(&part)
        };
        if self.flights.iter().any(is_near_end) {
            return true;
        }
        let segments = &self.outline.segments;
        let cuttable = segments.iter().filter(|one| one.is_cuttable());
        let longest = cuttable.map(|one| one.duration).fold(0.0, f64::max);
        let cut = self.outline.cut.as_ref();
        cut.is_none_or(|cut| segments[cut.number].duration < SHORTENED * longest)
    }

    /// The outline with flights cut in their middle, and no states at its cuts.
    pub fn without_cut(&self) -> OrbitGuess {
        let mut outline = self.outline.clone();
        outline.cut = None;
        for &(number, lasts) in &self.flights {
            if let [flight, rest, ..] = &mut outline.segments[number..] {
                let total = flight.duration + rest.duration;
                flight.duration = 0.5 * lasts;
                rest.duration = total - flight.duration;
                let share = flight.duration / total;
                flight.kind = SegmentKind::Flight { share };
            }
        }
        outline
    }

    /// Whether a segment between two events of one contact has vanished to within the tolerances.
    /// If both are zeros of one function, the second one repeats the first. That solves the
    /// equations wherever the orbit without the segment does, on either side of the change at which
    /// it begins.
    pub fn repeats_event(&self, options: &Options) -> bool {
        let mut durations = self.margins.iter().filter(|margin| {
            let is_of_one = margin.other.is_none();
            margin.kind == MarginKind::Duration && is_of_one
        });
        durations.any(|margin| margin.relative() <= closeness(options))
    }

    /// Whether the orbit is half of it run through twice, where its halves have the same phases.
    /// Halves part as the root of the distance from a flip, so that up to the root of the closing
    /// error they are one.
    pub fn is_half_twice(&self) -> Option<bool> {
        let apart = self.halves()?.amax();
        Some(apart * apart <= self.closes_to * self.extent)
    }

    /// The difference between the two halves of the orbit, where they have the same phases. It is
    /// that of the states at which these begin and, in units of the states, of the times.
    pub fn halves(&self) -> Option<Vector> {
        let outline = &self.outline;
        if let ([_], Some(cut)) = (outline.segments.as_slice(), &outline.cut) {
            let half = cut.states.first()? - &outline.begin.x;
            return outline.segments[0].end.is_none().then_some(half);
        }
        let half = outline.segments.len() / 2;
        let (one, other) = outline.segments.split_at(half);
        // The clock of a kink has gone on in the second half.
        let event = |one: &Segment| {
            let end = one.end?;
            Some((end.guard, end.contact, end.at_kink.map(|kink| kink.0)))
        };
        let is_alike = |(a, b): (&Segment, &Segment)| (a.mode, event(a)) == (b.mode, event(b));
        if half == 0 || one.len() != other.len() || !one.iter().zip(other).all(is_alike) {
            return None;
        }
        let by_time = self.extent / self.period;
        let parts = self.begins.iter().zip(self.begins.get(half..)?);
        let parts = parts.take(half).flat_map(|(one, other)| {
            let later = other.t - one.t - 0.5 * self.period;
            let apart = (&other.x - &one.x).push(later * by_time);
            apart.iter().copied().collect::<Vec<f64>>()
        });
        Some(Vector::from_vec(parts.collect()))
    }

    /// The margin of the same kind as one of a nearby orbit, at about the same time.
    pub fn margin_like(&self, other: &Margin) -> Option<&Margin> {
        // Fraction of the period. Chosen: in one step of a branch, times move by less.
        const SAME_TIME: f64 = 0.1;
        let off = |margin: &&Margin| {
            let way = (margin.at.t - other.at.t) / self.period;
            (way - way.round()).abs()
        };
        let is_alike = |margin: &&Margin| (margin.part, margin.kind) == (other.part, other.kind);
        let alike = self.margins.iter().filter(is_alike);
        let nearest = alike.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) <= SAME_TIME).then_some(nearest)
    }

    /// Second time derivative of the function whose zero ends the segment before that of a margin,
    /// at the margin's moment.
    pub fn acceleration_at(&self, system: &dyn Dynamics, margin: &Margin) -> Option<f64> {
        let margin = self.margin_like(margin)?;
        let before = self.outline.before(margin.part);
        let flow = system.flow(before.mode, &before.inside);
        let [_, _, second, _] = flow.guard_jet(before.end?.guard, &margin.at);
        Some(second)
    }

    /// The margin nearest to zero, among those at the times of some segments of another orbit.
    pub fn margin_near(&self, other: &Cycle, numbers: &[usize]) -> Option<&Margin> {
        // Fraction of the period by which times on both orbits may differ. Chosen: the orbits are
        // less than a step apart.
        const SHIFT: f64 = 1e-2;
        let near = self.margins.iter().filter(|margin| {
            let is_near = |&k: &usize| {
                let lasts = other.outline.segments[k].duration;
                let middle = other.begins[k].t + 0.5 * lasts;
                let way = (margin.at.t - middle) / other.period;
                (way - way.round()).abs() <= lasts / other.period + SHIFT
            };
            margin.kind != MarginKind::Duration && numbers.iter().any(is_near)
        });
        let off = |margin: &Margin| margin.relative().abs();
        near.min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}
