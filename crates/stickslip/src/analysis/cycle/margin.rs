//! Margins: how far a periodic orbit is from each change of its phases.

use super::Outline;
use super::pieces::Piece;
use super::shooting::TOLERANCES;
use crate::dynamics::{Dynamics, Modes, Moment, SmoothFlow};
use crate::filippov::Options;
use crate::system::{Mode, Side};

/// How a change of the phases of an orbit may begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum MarginKind {
    /// A guard has a minimum within a phase.
    Minimum(usize),
    /// A guard has a minimum at the end of a phase, which another contact ends.
    End(usize),
    /// A guard has a minimum at the beginning of a phase, which another contact begins.
    Begin(usize),
    /// A slip ends on the boundary near the edge of the sliding region.
    Landing,
    /// A slip comes to the boundary, or the function of a jump to zero, ever more tangentially,
    /// until it misses it.
    Arrival,
    /// A phase is short.
    Duration,
}

/// A function that vanishes at a change of the phases and is positive where the orbit has the
/// phases of its sequence.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Margin {
    /// The segment.
    pub part: usize,
    pub kind: MarginKind,
    pub value: f64,
    /// Typical size of the function on this orbit.
    pub scale: f64,
    /// The mode before the change.
    pub incoming: Modes,
    pub contact: usize,
    /// A second contact: the one that ends a short segment, where another one begins it; or the one
    /// at whose transition a guard is smallest.
    pub other: Option<usize>,
    pub at: Moment,
    pub is_contact_function: bool,
    /// Whether it belongs to the function of a jump.
    pub is_of_jump: bool,
}

impl Margin {
    /// Value as a fraction of its scale.
    pub fn relative(&self) -> f64 {
        self.value / self.scale
    }

    /// Whether it is below zero by more than the tolerances allow.
    pub fn is_violated(&self, options: &Options) -> bool {
        self.relative() < -TOLERANCES * options.rtol.max(options.atol)
    }

    /// The margin of the same kind at about the same time, among those of an orbit with a period.
    pub fn like<'m>(&self, margins: &'m [Margin], period: f64) -> Option<&'m Margin> {
        // Fraction of the period. Chosen: in one step of a branch, times move by less.
        const SAME_TIME: f64 = 0.1;
        let off = |margin: &&Margin| {
            let way = (margin.at.t - self.at.t) / period;
            (way - way.round()).abs()
        };
        let is_alike = |margin: &&Margin| (margin.part, margin.kind) == (self.part, self.kind);
        let alike = margins.iter().filter(is_alike);
        let nearest = alike.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) <= SAME_TIME).then_some(nearest)
    }

    /// At the end of a slip: the flow in which the contact would stick, and the smallest of its
    /// guards there.
    pub fn landing<'s>(
        &self,
        system: &'s dyn Dynamics,
    ) -> Option<(Box<dyn SmoothFlow + 's>, usize)> {
        let flow = system.flow(self.incoming.with(self.contact, Mode::Stick), &self.at);
        let guards = flow.guards().into_iter();
        let own = guards.filter(|guard| guard.contact == self.contact && !guard.goes_on);
        let value = |number: usize| flow.guard(number, &self.at);
        let least = own.min_by(|a, b| value(a.number).total_cmp(&value(b.number)))?;
        Some((flow, least.number))
    }
}

/// First and second time derivative of a contact's distance from the boundary, along the fields of
/// both sides. On each side the distance is positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rates {
    /// On the side from which the orbit comes.
    pub own: [f64; 2],
    /// On the other side.
    pub other: [f64; 2],
}

impl Rates {
    pub fn none() -> Self {
        let none = [f64::NAN; 2];
        Rates {
            own: none,
            other: none,
        }
    }

    /// At a point where a slip on `side` reaches the boundary.
    pub fn at(system: &dyn Dynamics, mode: Modes, contact: usize, side: Side, at: &Moment) -> Self {
        let of = |side| {
            let mode = mode.with(contact, Mode::Slip(side));
            let [_, first, second, _] = system.flow(mode, at).guard_jet(contact, at);
            [first, second]
        };
        Rates {
            own: of(side),
            other: of(side.opposite()),
        }
    }
}

/// The margins at the events: whether a slip that ends on the boundary sticks there, its speed of
/// arrival, and the duration of each segment.
pub(super) fn at_events(system: &dyn Dynamics, outline: &Outline, pieces: &[Piece]) -> Vec<Margin> {
    let mut margins = Vec::new();
    let count = outline.segments.len();
    for (part, (segment, piece)) in outline.segments.iter().zip(pieces).enumerate() {
        let before = outline.before(part);
        let (Some(begin), Some(end)) = (before.end, segment.end) else {
            continue;
        };
        let at = &piece.begin;
        let margin = |kind, value, scale| Margin {
            part,
            kind,
            value,
            scale,
            incoming: before.mode,
            contact: begin.contact,
            other: None,
            at: at.clone(),
            is_contact_function: begin.is_of_contact,
            is_of_jump: begin.is_of_jump,
        };
        // Loss or gain of contact changes no mode: the segment continues.
        if count > 1 {
            let other = (end.contact != begin.contact).then_some(end.contact);
            margins.push(Margin {
                other,
                ..margin(MarginKind::Duration, segment.duration, outline.period())
            });
        }
        if begin.is_of_jump && begin.at_kink.is_none() {
            let at = &pieces[(part + count - 1) % count].end;
            let flow = system.flow(before.mode, &before.inside);
            let [_, rate, second, _] = flow.guard_jet(begin.guard, at);
            let scale = rate.abs() + second.abs() * outline.period();
            margins.push(Margin {
                at: at.clone(),
                ..margin(MarginKind::Arrival, -rate, scale)
            });
        }
        if let (Mode::Slip(side), false) = (before.mode.get(begin.contact), begin.is_of_contact) {
            let stuck = margin(MarginKind::Landing, 0.0, 0.0).landing(system);
            // Positive where it would stick.
            let least = stuck.map_or(f64::NAN, |(flow, guard)| flow.guard(guard, at));
            let sticks = segment.mode.get(begin.contact) == Mode::Stick;
            let rates = Rates::at(system, before.mode, begin.contact, side, at);
            let scale = rates.own[0].abs() + rates.other[0].abs();
            let landing = if sticks { least } else { -least };
            // Where the fields of both sides agree, no holding force is determined.
            if landing.is_finite() {
                margins.push(margin(MarginKind::Landing, landing, scale));
            }
            margins.push(margin(MarginKind::Arrival, -rates.own[0], scale));
        }
    }
    margins
}
