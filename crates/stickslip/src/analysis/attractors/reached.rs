//! What an orbit has come to.

use std::fmt;

use crate::dynamics::{Modes, Moment, Phase, Vector};
use crate::error::Error;
use crate::filippov::{TransitionKind, TwoFold};

/// What kind of motion an orbit has come to.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// An equilibrium of slip, or of the sliding field in stick, that attracts all around it on its
    /// set.
    Equilibrium,
    /// Rest at one of a whole set of equilibria, as a block that friction holds on a floor.
    EquilibriumSet,
    /// A periodic orbit.
    Periodic {
        /// After how many points of the section it closes.
        returns: usize,
        /// Period.
        period: f64,
    },
    /// Quasi-periodic or chaotic: the points of the section return to everywhere that they have
    /// been, and no pattern of them repeats. Which of the two it is, exponents tell
    /// ([`crate::analysis::motion`]).
    Recurrent,
    /// A component passed the escape bound of the options.
    Escape,
    /// It has come to where Σ repels, and its future is not unique.
    Repelling,
    /// It has come to a two-fold, and its future is not unique.
    TwoFold(TwoFold),
    /// The integration failed.
    Failure(Error),
    /// None of these could be told within the longest time.
    Undecided,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::Equilibrium => f.write_str("equilibrium"),
            Kind::EquilibriumSet => f.write_str("set of equilibria"),
            Kind::Periodic { returns, period } => {
                write!(f, "periodic, {returns} returns, period {period}")
            }
            Kind::Recurrent => f.write_str("recurrent, not periodic"),
            Kind::Escape => f.write_str("escape"),
            Kind::Repelling => f.write_str("end where the boundary repels"),
            Kind::TwoFold(_) => f.write_str("end at a two-fold"),
            Kind::Failure(error) => write!(f, "failure: {error}"),
            Kind::Undecided => f.write_str("undecided"),
        }
    }
}

/// What an orbit has come to, with the evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// The kind of motion.
    pub kind: Kind,
    /// By how much the period of a periodic orbit may be off, by how the last periods differ; zero
    /// of other motions.
    pub period_uncertainty: f64,
    /// Of a periodic orbit that has a number, the dimension of the family that it is one of; see
    /// [`super::Attractors::number`] and [`super::Attractors::family`].
    pub family: Option<usize>,
    /// Of a periodic orbit the points of the section in one period; of an equilibrium that point
    /// alone, refined; otherwise the last points.
    pub points: Vec<Moment>,
    /// Of a periodic orbit the phases that ended in one period, in order of time; otherwise the
    /// last phases.
    pub phases: Vec<Phase>,
    /// The transitions of these phases with the contact that each begins at; in several contacts,
    /// and where contact is lost and gained, there is more to them than to the modes.
    pub transitions: Vec<(TransitionKind, usize)>,
    /// Part of the time of these phases in which a contact sticks; at rest, and without phases, 1
    /// or 0 by the mode at the end.
    pub in_stick: f64,
    /// Mode at that time.
    pub mode: Modes,
    /// Time at which the orbit was left; where the phase that ended then is one in which a contact
    /// sticks, that of its beginning, from which it is better to go on.
    pub t: f64,
    /// State at that time. Where it is certain that the orbit comes to an equilibrium which it is
    /// still far from, it is moved there but for
    /// [`crate::analysis::RecurrenceSettings::closeness`].
    pub x: Vector,
}

impl Reached {
    /// The modes gone through in the phases; where none ended, the mode at the end alone.
    pub fn sequence(&self) -> Vec<Modes> {
        if self.phases.is_empty() {
            return vec![self.mode];
        }
        self.phases.iter().map(|phase| phase.mode).collect()
    }

    /// The period of a periodic orbit; zero of other kinds of motion.
    pub(super) fn period(&self) -> f64 {
        match self.kind {
            Kind::Periodic { period, .. } => period,
            _ => 0.0,
        }
    }

    /// Whether two periodic orbits have the same cycle of phases and transitions.
    pub fn has_sequence_of(&self, other: &Self) -> bool {
        is_same_cycle(&self.sequence(), &other.sequence())
            && is_same_cycle(&self.transitions, &other.transitions)
    }
}

/// By how many places `other` must be turned to have the elements of `one`, for every way that
/// there is.
pub(crate) fn turns<'a, A, B>(
    one: &'a [A],
    other: &'a [B],
    same: impl Fn(&A, &B) -> bool + 'a,
) -> impl Iterator<Item = usize> + 'a {
    let length = if one.len() == other.len() {
        one.len()
    } else {
        0
    };
    (0..length).filter(move |by| (0..length).all(|i| same(&one[i], &other[(i + by) % length])))
}

/// Whether two sequences are the same but for where they begin.
pub fn is_same_cycle<A: PartialEq<B>, B>(one: &[A], other: &[B]) -> bool {
    one.is_empty() && other.is_empty() || turns(one, other, |a, b| a == b).next().is_some()
}
