//! What a change of the phases is called, by the event function that vanishes.

use std::fmt;

use super::Cycle;
use super::margin::{Margin, MarginKind, Rates};
use crate::dynamics::{Dynamics, Modes, Vector};
use crate::system::Mode;

/// A change of the phases of a periodic orbit where one of its event functions comes to zero.
///
/// The four sliding bifurcations are those of di Bernardo, Budd, Champneys & Kowalczyk,
/// *Piecewise-smooth Dynamical Systems* (2008), Ch. 8. At each the orbit meets an edge of the part
/// of the boundary that is slid on, where the field of one side is tangent to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SequenceBifurcation {
    /// A slip ends where the other side's field is tangent to the boundary and leads away from it:
    /// to one side the orbit crosses, to the other it slides for a short time and then leaves.
    CrossingSliding,
    /// A slip touches the boundary where the other side's field pushes to it: to one side the orbit
    /// stays off, to the other it slides for a short time; with static friction above the kinetic,
    /// until that lets go.
    GrazingSliding,
    /// A slip ends where the other side's field is tangent to the boundary and leads back to it: to
    /// one side the orbit slides at once, to the other it first crosses for a short time.
    SwitchingSliding,
    /// A stick touches the edge from inside: to one side it lasts, to the other the orbit leaves
    /// for a short time.
    AddingSliding,
    /// A slip touches the boundary where the other side's field leads away from it: to one side the
    /// orbit stays off, to the other it crosses for a short time.
    Grazing,
    /// The contact function comes to zero: to one side contact lasts, to the other it is lost for a
    /// short time.
    ContactGrazing,
    /// Two contacts change in the same instant: to one side one of them does so first, to the other
    /// the other. Of contacts that do not act on each other nothing else changes.
    Coincidence,
    /// The function of a jump touches zero (Nordmark 1991): to one side the state does not jump, to
    /// the other it does, with a derivative that grows without bound towards the graze.
    JumpGrazing,
    /// None of the event functions explains it.
    Unnamed,
}

impl fmt::Display for SequenceBifurcation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SequenceBifurcation::CrossingSliding => "crossing-sliding",
            SequenceBifurcation::GrazingSliding => "grazing-sliding",
            SequenceBifurcation::SwitchingSliding => "switching-sliding",
            SequenceBifurcation::AddingSliding => "adding-sliding",
            SequenceBifurcation::Grazing => "grazing",
            SequenceBifurcation::ContactGrazing => "grazing of the contact function",
            SequenceBifurcation::Coincidence => "coincidence",
            SequenceBifurcation::JumpGrazing => "grazing of a jump",
            SequenceBifurcation::Unnamed => "unnamed",
        })
    }
}

/// A change of the phases of a periodic orbit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SequenceChange {
    /// The parameter: where the event function is zero.
    pub parameter: f64,
    /// By how much that may be off: what the event function lacks of zero there and what rounding
    /// leaves of it, over its slope along the branch. What the tolerances have it off by is in it,
    /// as another orbit with a tenth of them tells; of methods with fixed steps nothing does.
    pub uncertainty: f64,
    /// What it is called.
    pub bifurcation: SequenceBifurcation,
    /// The contacts whose event function vanishes, counted from 0: two at a coincidence, none where
    /// the change has no name, or else one.
    pub contacts: Vec<usize>,
    /// Where on the orbit, on the boundary to rounding.
    pub x: Vector,
    /// The event function there on the orbit that it was located from, in units of the size that it
    /// has on this orbit.
    pub residual: f64,
    /// First and second derivative in time of the contact's distance from the boundary there, along
    /// the field that the orbit comes by; not numbers where it comes by stick. At a graze the first
    /// is zero.
    pub own: [f64; 2],
    /// The same, positive on the other side, along that side's field. At a crossing- or
    /// switching-sliding the first is zero, and the sign of the second tells them apart.
    pub other: [f64; 2],
    /// Period of the orbit.
    pub period: f64,
    /// The modes before it: coming from where the branch was followed; of a sweep, on the side of
    /// the value before. None where the orbit was followed from the other side and none was found
    /// on this one.
    pub before: Vec<Modes>,
    /// The modes behind it, of the orbit that was found next to it: the one that it becomes there,
    /// or, where the branch turns back, the one that it meets; none where none was found.
    pub after: Vec<Modes>,
}

/// Fields that differ by less than this part agree.
const AGREE: f64 = 1e-6;

/// The name, and the first and second rates of the contact's distance along the fields of both
/// sides.
fn name(system: &dyn Dynamics, margin: &Margin) -> (SequenceBifurcation, Rates) {
    if margin.other.is_some() {
        return (SequenceBifurcation::Coincidence, Rates::none());
    }
    if margin.is_of_jump {
        return (SequenceBifurcation::JumpGrazing, Rates::none());
    }
    if margin.is_contact_function {
        return (SequenceBifurcation::ContactGrazing, Rates::none());
    }
    let Mode::Slip(side) = margin.incoming.get(margin.contact) else {
        return (SequenceBifurcation::AddingSliding, Rates::none());
    };
    let rates = Rates::at(system, margin.incoming, margin.contact, side, &margin.at);
    let is_tangent = match margin.key.kind {
        MarginKind::Minimum(_) | MarginKind::Arrival => true,
        // Where the fields agree, both are tangent. The last two are coincidences.
        MarginKind::Landing | MarginKind::Duration | MarginKind::End(_) | MarginKind::Begin(_) => {
            rates.own[0].abs() <= (1.0 + AGREE) * rates.other[0].abs()
        }
    };
    // Fields that agree are both tangent to rounding, which has either sign; what is a distance to
    // one side is the opposite to the other.
    let [own, other] = [rates.own[0], rates.other[0]];
    let differ = (own + other).abs() > AGREE * (own.abs() + other.abs());
    let name = match (is_tangent, rates.other) {
        (true, [rate, _]) if rate < 0.0 && differ => SequenceBifurcation::GrazingSliding,
        (true, _) => SequenceBifurcation::Grazing,
        (false, [_, second]) if second > 0.0 => SequenceBifurcation::CrossingSliding,
        (false, _) => SequenceBifurcation::SwitchingSliding,
    };
    (name, rates)
}

/// Describes the change at an orbit at which a margin vanishes, to an uncertainty.
pub(crate) fn describe(
    system: &dyn Dynamics,
    (at, margin): (&Cycle, &Margin),
    (parameter, uncertainty): (f64, f64),
    [before, after]: [Vec<Modes>; 2],
) -> SequenceChange {
    let (bifurcation, rates) = name(system, margin);
    let is_named = bifurcation != SequenceBifurcation::Unnamed;
    let contacts = [margin.contact].into_iter().chain(margin.other);
    SequenceChange {
        parameter,
        uncertainty,
        bifurcation,
        contacts: contacts.filter(|_| is_named).collect(),
        x: margin.at.x.clone(),
        residual: margin.relative().abs(),
        own: rates.own,
        other: rates.other,
        period: at.period,
        before,
        after,
    }
}
