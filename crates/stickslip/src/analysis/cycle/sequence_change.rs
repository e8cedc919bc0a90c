//! A change of the phases, named by the event function that vanishes.

use std::fmt;

use super::Cycle;
use super::margin::{Margin, MarginKind, rates};
use crate::dynamics::{Dynamics, Modes, Vector};
use crate::system::Mode;

/// A change of the phases of a periodic orbit at a zero of one of its event functions.
///
/// The four sliding bifurcations are those of di Bernardo, Budd, Champneys & Kowalczyk,
/// *Piecewise-smooth Dynamical Systems* (2008), Ch. 8. At each the orbit meets an edge of the
/// sliding region, where the field of one side is tangent to the boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SequenceBifurcation {
    /// A slip ends where the other side's field is tangent to the boundary and leads away from it.
    /// On one side of the change the orbit crosses; on the other it slides briefly and then leaves.
    CrossingSliding,
    /// A slip touches the boundary where the other side's field points to it. On one side of the
    /// change the orbit stays off; on the other it slides briefly. With static friction above the
    /// kinetic, it slides until that releases it.
    GrazingSliding,
    /// A slip ends where the other side's field is tangent to the boundary and leads back to it. On
    /// one side of the change the orbit slides at once; on the other it first crosses briefly.
    SwitchingSliding,
    /// A stick touches the edge from inside. On one side of the change it lasts; on the other the
    /// orbit leaves briefly.
    AddingSliding,
    /// A slip touches the boundary where the other side's field points away from it. On one side of
    /// the change the orbit stays off; on the other it crosses briefly.
    Grazing,
    /// The contact function reaches zero. On one side of the change contact lasts; on the other it
    /// is lost briefly.
    ContactGrazing,
    /// Two contacts change in the same instant, and their order differs between the sides. Nothing
    /// else changes if the contacts do not act on each other.
    Coincidence,
    /// The function of a jump touches zero (Nordmark 1991). On one side of the change the state
    /// does not jump. On the other it does, with a derivative that grows without bound towards the
    /// graze.
    JumpGrazing,
    /// The reaction of a stop comes to zero. On one side of the change the stop carries, and on the
    /// other the body lifts off. Where the reaction is constant, it does so for good.
    LiftOff,
    /// A comparison in the condition of a jump, or in a choice of what it sets, is between equal
    /// numbers. On one side of the change it holds; on the other it does not.
    Choice,
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
            SequenceBifurcation::LiftOff => "lift-off",
            SequenceBifurcation::Choice => "equality in a condition",
        })
    }
}

/// A change of the phases of a periodic orbit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SequenceChange {
    /// The parameter: where the event function is zero.
    pub parameter: f64,
    /// Uncertainty of the parameter: the residual of the event function with its rounding error,
    /// over its slope along the branch. It includes the error of integration, estimated from the
    /// same orbit with half the steps.
    pub uncertainty: f64,
    /// The name of the change.
    pub bifurcation: SequenceBifurcation,
    /// The contacts whose event function vanishes, counted from 0: two at a coincidence, otherwise
    /// one.
    pub contacts: Vec<usize>,
    /// State on the orbit, on the boundary to rounding.
    pub x: Vector,
    /// The event function on the orbit from which the change was located, relative to its size on
    /// this orbit.
    pub residual: f64,
    /// First and second time derivative of the contact's distance from the boundary there, along
    /// the field of the incoming orbit; NaN where it arrives in stick. At a graze the first is
    /// zero.
    pub own: [f64; 2],
    /// Rates along the other side's field, positive towards that side. At a crossing- or
    /// switching-sliding the first is zero, and the sign of the second tells them apart.
    pub other: [f64; 2],
    /// Period of the orbit.
    pub period: f64,
    /// The modes before it: on the side from which the branch was followed; in a sweep, on the side
    /// of the previous value. `None` where the orbit was followed from the other side and none
    /// could be computed on this one.
    pub before: Vec<Modes>,
    /// The modes behind it, from the orbit computed next to it. The orbit becomes that one or,
    /// where the branch turns back, meets it. `None` where none could be computed.
    pub after: Vec<Modes>,
}

/// Relative difference of their rates below which the fields of both sides agree. Chosen: the
/// square root of the tolerances at which changes are located, since at a graze rates are that
/// accurate.
const FIELDS_AGREE: f64 = 1e-6;

/// The name, and the first and second rates of the contact's distance along the fields of both
/// sides.
fn name(system: &dyn Dynamics, margin: &Margin) -> (SequenceBifurcation, [[f64; 2]; 2]) {
    let none = [[f64::NAN; 2]; 2];
    if margin.other.is_some() {
        return (SequenceBifurcation::Coincidence, none);
    }
    if let MarginKind::Choice(_) | MarginKind::Passed(_) = margin.kind {
        return (SequenceBifurcation::Choice, none);
    }
    if margin.is_reaction {
        return (SequenceBifurcation::LiftOff, none);
    }
    if margin.is_of_jump {
        return (SequenceBifurcation::JumpGrazing, none);
    }
    if margin.is_contact_function {
        return (SequenceBifurcation::ContactGrazing, none);
    }
    let Mode::Slip(side) = margin.incoming.get(margin.contact) else {
        return (SequenceBifurcation::AddingSliding, none);
    };
    let slip = (margin.incoming, margin.contact, side);
    let rates = rates(system, slip, &margin.at);
    let [[own, _], [other, second]] = rates;
    let is_tangent = match margin.kind {
        MarginKind::Minimum(_)
        | MarginKind::Arrival
        | MarginKind::Choice(_)
        | MarginKind::Passed(_) => true,
        // Where the fields agree, both are tangent. Those at ends of phases are coincidences.
        MarginKind::Landing
        | MarginKind::Duration
        | MarginKind::Rest
        | MarginKind::End(_)
        | MarginKind::Begin(_) => own.abs() <= (1.0 + FIELDS_AGREE) * other.abs(),
    };
    // Where the fields agree, rounding decides the signs of both rates. The distance on one side is
    // the negative of that on the other.
    let differ = (own + other).abs() > FIELDS_AGREE * (own.abs() + other.abs());
    let name = match is_tangent {
        true if other < 0.0 && differ => SequenceBifurcation::GrazingSliding,
        true => SequenceBifurcation::Grazing,
        false if second > 0.0 => SequenceBifurcation::CrossingSliding,
        false => SequenceBifurcation::SwitchingSliding,
    };
    (name, rates)
}

/// Describes the change at an orbit with a vanishing margin, at a parameter with an uncertainty.
pub(crate) fn describe(
    system: &dyn Dynamics,
    (at, margin): (&Cycle, &Margin),
    (parameter, uncertainty): (f64, f64),
    [before, after]: [Vec<Modes>; 2],
) -> SequenceChange {
    let (bifurcation, [own, other]) = name(system, margin);
    let contacts = [margin.contact].into_iter().chain(margin.other);
    SequenceChange {
        parameter,
        uncertainty,
        bifurcation,
        contacts: contacts.collect(),
        x: margin.at.x.clone(),
        residual: margin.relative().abs(),
        own,
        other,
        period: at.period,
        before,
        after,
    }
}
