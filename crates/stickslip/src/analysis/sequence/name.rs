//! What a change of the phases is called, by the event function that vanishes.

use std::fmt;

use super::margin::{Margin, Rates, Site};
use crate::dynamics::Dynamics;
use crate::system::Mode;

/// A change of the phases of a periodic orbit where one of its event functions comes to zero.
///
/// The four sliding bifurcations are those of di Bernardo, Budd, Champneys & Kowalczyk, *Piecewise-smooth Dynamical Systems* (2008), Ch. 8. At
/// each the orbit meets an edge of the part of the boundary that is slid on, where the field of one side is tangent to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SequenceBifurcation {
    /// A slip ends where the other side's field is tangent to the boundary and leads away from it: to one side the orbit crosses, to the other
    /// it slides for a short time and then leaves.
    CrossingSliding,
    /// A slip touches the boundary where the other side's field pushes to it: to one side the orbit stays off, to the other it slides for a
    /// short time; with static friction above the kinetic, until that lets go.
    GrazingSliding,
    /// A slip ends where the other side's field is tangent to the boundary and leads back to it: to one side the orbit slides at once, to the
    /// other it first crosses for a short time.
    SwitchingSliding,
    /// A stick touches the edge from inside: to one side it lasts, to the other the orbit leaves for a short time.
    AddingSliding,
    /// A slip touches the boundary where the other side's field leads away from it: to one side the orbit stays off, to the other it crosses for
    /// a short time.
    Grazing,
    /// The contact function comes to zero: to one side contact lasts, to the other it is lost for a short time.
    ContactGrazing,
    /// Two contacts change in the same instant: to one side one of them does so first, to the other the other. Of contacts that do not act on
    /// each other nothing else changes.
    Coincidence,
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
            SequenceBifurcation::Unnamed => "unnamed",
        })
    }
}

/// Fields that differ by less than this part agree.
const AGREE: f64 = 1e-6;

/// The name, and the first and second rates of the contact's distance along the fields of both sides.
pub(super) fn name(system: &dyn Dynamics, margin: &Margin) -> (SequenceBifurcation, Rates) {
    if !margin.vanishes() {
        return (SequenceBifurcation::Unnamed, Rates::none());
    }
    if margin.other.is_some() {
        return (SequenceBifurcation::Coincidence, Rates::none());
    }
    if margin.is_contact_function {
        return (SequenceBifurcation::ContactGrazing, Rates::none());
    }
    let Mode::Slip(side) = margin.incoming.get(margin.contact) else {
        return (SequenceBifurcation::AddingSliding, Rates::none());
    };
    let rates = Rates::at(system, margin.incoming, margin.contact, side, &margin.at);
    let is_tangent = match margin.key.site {
        Site::Minimum(_) | Site::Arrival => true,
        // Where the fields agree, both are tangent. The last two are coincidences.
        Site::Landing | Site::Duration | Site::End(_) | Site::Begin(_) => {
            rates.own[0].abs() <= (1.0 + AGREE) * rates.other[0].abs()
        }
    };
    // Fields that agree are both tangent to rounding, which has either sign; what is a distance to one side is the opposite to the other.
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
