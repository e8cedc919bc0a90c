//! Margins: how far a periodic orbit is from each change of its phases.

use super::pieces::Piece;
use super::{OrbitGuess, SegmentKind, closeness};
use crate::dynamics::{Comparison, Dynamics, Modes, Moment, instant};
use crate::filippov::Options;
use crate::system::{Mode, Side};

/// Ways in which a change of the phases of an orbit begins.
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
    /// A phase at rest, which a landing begins, is short.
    Rest,
    /// A comparison on which the jump before a phase hangs is between equal numbers; its number
    /// among those of the jump.
    Choice(usize),
    /// A guard comes to zero within a phase, and the condition of its jump does not hold. A
    /// comparison in it is between equal numbers.
    Passed(usize),
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
    /// Error of a guard's value by that of the orbit's states; 0 for other functions.
    pub error: f64,
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
    /// Whether it is the reaction of a stop.
    pub is_reaction: bool,
}

impl Margin {
    /// Value as a fraction of its scale.
    pub fn relative(&self) -> f64 {
        self.value / self.scale
    }

    /// Whether it is below zero by more than the tolerances and the error of the states allow.
    pub fn is_violated(&self, options: &Options) -> bool {
        self.value < -self.error.max(closeness(options) * self.scale)
    }
}

/// First and second time derivative of a contact's distance from the boundary where a slip on
/// `side` reaches it. The first is along the field of this side, the second along that of the
/// other. On each side the distance is positive.
pub(super) fn rates(
    system: &dyn Dynamics,
    (mode, contact, side): (Modes, usize, Side),
    at: &Moment,
) -> [[f64; 2]; 2] {
    [side, side.opposite()].map(|side| {
        let mode = mode.with(contact, Mode::Slip(side));
        let [_, first, second, _] = system.flow(mode, at).guard_jet(contact, at);
        [first, second]
    })
}

/// The margins at the events: whether a slip that ends on the boundary sticks there, its speed of
/// arrival, the comparisons that decide at a jump, and the duration of each segment. `error` is
/// that of the states.
pub(super) fn at_events(
    system: &dyn Dynamics,
    outline: &OrbitGuess,
    pieces: &[Piece],
    error: f64,
) -> Vec<Margin> {
    let mut margins = Vec::new();
    let count = outline.segments.len();
    for (part, (segment, piece)) in outline.segments.iter().zip(pieces).enumerate() {
        let before = outline.before(part);
        if let (SegmentKind::Chatter { landing, .. }, Some(end), Some((_, landed))) =
            (segment.kind, segment.end, piece.jumps.last())
        {
            margins.push(Margin {
                part,
                kind: MarginKind::Rest,
                value: piece.end.t - landed.t,
                scale: outline.period(),
                error: 0.0,
                incoming: segment.mode,
                contact: landing,
                other: Some(end.contact),
                at: landed.moment(),
                is_contact_function: false,
                is_of_jump: true,
                is_reaction: false,
            });
        }
        let Some(begin) = before.end else {
            continue;
        };
        let at = &piece.begin;
        let margin = |kind, value, scale| Margin {
            part,
            kind,
            value,
            scale,
            error: 0.0,
            incoming: before.mode,
            contact: begin.contact,
            other: None,
            at: at.clone(),
            is_contact_function: begin.is_of_contact,
            is_of_jump: begin.is_of_jump,
            is_reaction: false,
        };
        // Loss or gain of contact changes no mode: the segment continues.
        if let Some(end) = segment.end.filter(|_| count > 1) {
            let other = (end.contact != begin.contact).then_some(end.contact);
            margins.push(Margin {
                other,
                ..margin(MarginKind::Duration, segment.duration, outline.period())
            });
        }
        if begin.is_of_jump {
            let at = &pieces[(part + count - 1) % count].end;
            let comparisons = system.decision(begin.contact, at).comparisons.into_iter();
            // Those beyond the last bit are not known.
            let known = |one: &Comparison| one.number < u64::BITS as usize;
            for one in comparisons.filter(|one| one.decides && known(one)) {
                let sign = if begin.holds(one.number) { 1.0 } else { -1.0 };
                margins.push(Margin {
                    at: at.clone(),
                    error: one.slope * error,
                    ..margin(MarginKind::Choice(one.number), sign * one.lead, one.size)
                });
            }
        }
        // A reaction that pulls only behind the kink of an input lifts the body off at that. Of
        // several events in one instant, another one may decide.
        let guards = || system.flow(before.mode, at).guards().into_iter();
        let is_reaction = || guards().any(|one| one.number == begin.guard && one.is_reaction);
        let lasts = before.duration > instant(at.t);
        if begin.at_kink.is_some() && lasts && begin.is_of_jump && is_reaction() {
            let at = &pieces[(part + count - 1) % count].end;
            let [force, behind] = [at.t - instant(at.t), at.t + instant(at.t)].map(|held| {
                system
                    .flow_held(before.mode, at, held)
                    .guard(begin.guard, at)
            });
            let (pull, scale) = (-behind, force.abs() + behind.abs());
            margins.push(Margin {
                at: at.clone(),
                is_reaction: true,
                ..margin(MarginKind::Arrival, pull, scale)
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
            let stuck = system.flow(before.mode.with(begin.contact, Mode::Stick), at);
            let guards = stuck.guards().into_iter();
            let own =
                guards.filter(|guard| guard.contact == begin.contact && !guard.continues_phase);
            let values = own.map(|guard| stuck.guard(guard.number, at));
            // Positive where it would stick.
            let least = values.min_by(f64::total_cmp).unwrap_or(f64::NAN);
            let sticks = segment.mode.get(begin.contact) == Mode::Stick;
            let [[own, _], [other, _]] = rates(system, (before.mode, begin.contact, side), at);
            let scale = own.abs() + other.abs();
            let landing = if sticks { least } else { -least };
            // Where the fields of both sides agree, no holding force is determined.
            if landing.is_finite() {
                margins.push(margin(MarginKind::Landing, landing, scale));
            }
            margins.push(margin(MarginKind::Arrival, -own, scale));
        }
    }
    margins
}
