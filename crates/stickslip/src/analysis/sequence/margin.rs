//! How far the event functions of a periodic orbit are from a change of its phases.

use super::circuit::is_of_contact;
use super::locate::VANISHING;
use crate::dynamics::{Dynamics, Modes, Moment, Transition};
use crate::filippov::TransitionKind;
use crate::system::{Mode, Side};

/// Where on an orbit a change of its phases may begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Site {
    /// A guard is smallest within a phase.
    Minimum(usize),
    /// A guard is smallest at the end of a phase, which another contact ends.
    End(usize),
    /// A guard is smallest at the beginning of a phase, which begins with another contact.
    Begin(usize),
    /// A slip ends on the boundary, near to where stick begins or no longer does.
    Landing,
    /// A slip ends on the boundary ever more along it, until it passes by.
    Arrival,
    /// A phase is short.
    Duration,
}

/// What tells a margin from the others of the orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    pub part: usize,
    pub site: Site,
    /// Which of its kind in the part.
    pub count: usize,
}

/// The value of an event function that a change of the phases would make zero.
#[derive(Clone, Debug)]
pub(crate) struct Margin {
    pub key: Key,
    pub value: f64,
    /// Size that such values have on this orbit.
    pub scale: f64,
    /// By how much it may be off because rounding leaves the orbit's state open; and with what the tolerances do.
    pub by_rounding: f64,
    pub off: f64,
    /// Mode before.
    pub incoming: Modes,
    pub contact: usize,
    /// The contact that ends a part, where it is not the one that begins it; or beside whose transition a guard is smallest.
    pub other: Option<usize>,
    pub at: Moment,
    pub is_contact_function: bool,
}

impl Margin {
    /// Part of its scale.
    pub fn relative(&self) -> f64 {
        self.value.abs() / self.scale
    }

    /// Whether it is about to vanish, as far as orbits can be computed next to where it does.
    pub fn vanishes(&self) -> bool {
        self.value.abs() <= (VANISHING * self.scale).max(self.most_off())
    }

    /// By how much it may be off at most.
    pub fn most_off(&self) -> f64 {
        // It is told by displacements each of which is twice the one before.
        const TIMES: f64 = 3.0;
        TIMES * self.off
    }
}

/// First and second derivative in time of a contact's distance from the boundary (positive on the side in question) along the fields of both
/// sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rates {
    /// Of the side that the orbit comes from.
    pub own: [f64; 2],
    /// Of the other side.
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

    /// At a point of the boundary that a slip on `side` comes to.
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

/// Where a slip ends on the boundary: whether it sticks there, and how fast it comes.
pub(super) fn landing(system: &dyn Dynamics, part: usize, at: &Transition) -> Option<[Margin; 2]> {
    let (Mode::Slip(side), TransitionKind::Crossing | TransitionKind::StickEntry) =
        (at.from.get(at.contact), at.kind)
    else {
        return None;
    };
    let here = at.moment();
    let stuck = at.from.with(at.contact, Mode::Stick);
    // The smallest of the contact's guards of stick: positive where it would stick.
    let flow = system.flow(stuck, &here);
    let guards = flow.guards().into_iter();
    let of_contact = guards.filter(|guard| guard.contact == at.contact && !guard.goes_on);
    let values = of_contact.map(|guard| flow.guard(guard.number, &here));
    let value = values.fold(f64::INFINITY, f64::min);
    let rates = Rates::at(system, at.from, at.contact, side, &here);
    let margin = |site, value| Margin {
        key: Key {
            part,
            site,
            count: 0,
        },
        value,
        scale: rates.own[0].abs() + rates.other[0].abs(),
        by_rounding: 0.0,
        off: 0.0,
        incoming: at.from,
        contact: at.contact,
        other: None,
        at: here.clone(),
        is_contact_function: is_of_contact(at.kind),
    };
    Some([
        margin(Site::Landing, value),
        margin(Site::Arrival, rates.own[0]),
    ])
}
