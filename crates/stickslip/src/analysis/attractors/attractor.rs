//! Long-term behaviour of an orbit, or its end.

use std::fmt;

use crate::dynamics::{Modes, Moment, Phase, Vector};
use crate::error::Error;
use crate::filippov::TransitionKind;
use crate::orbit::TwoFold;

/// Long-term behaviour of an orbit, or its end.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AttractorKind {
    /// An equilibrium of slip, or of the sliding field in stick, that attracts all nearby states of
    /// its set.
    Equilibrium,
    /// An equilibrium of a continuous set of them, as for a block that friction holds on a floor.
    EquilibriumSet,
    /// A periodic orbit.
    Periodic {
        /// Number of section points after which it closes.
        returns: usize,
        /// Period.
        period: f64,
    },
    /// Quasi-periodic or chaotic: the section points return to every region visited before, and no
    /// pattern of them repeats. [`crate::analysis::lyapunov_spectrum`] distinguishes the two.
    Recurrent,
    /// A component passed the escape bound of the options.
    Escape,
    /// The orbit has reached a repelling part of Σ, and its future is not unique.
    Repelling,
    /// The orbit has reached a two-fold, and its future is not unique.
    TwoFold(TwoFold),
    /// The integration failed.
    Failure(Error),
    /// No decision was possible within the longest time.
    Undecided,
    /// The orbit lies on an unstable periodic orbit, exactly or on its stable manifold. Neighbours
    /// leave it. [`super::Attractors::number`] tells it from an attractor.
    Unstable,
}

impl AttractorKind {
    /// The kind in a word, for tables.
    pub fn word(&self) -> &'static str {
        match self {
            AttractorKind::Equilibrium => "equilibrium",
            AttractorKind::EquilibriumSet => "set of equilibria",
            AttractorKind::Periodic { .. } => "periodic",
            AttractorKind::Recurrent => "recurrent",
            AttractorKind::Escape => "escape",
            AttractorKind::Repelling => "end where the boundary repels",
            AttractorKind::TwoFold(_) => "end at a two-fold",
            AttractorKind::Failure(_) => "failure",
            AttractorKind::Undecided => "undecided",
            AttractorKind::Unstable => "on an unstable orbit",
        }
    }

    /// Whether it is an attractor. Orbits that escape, end, fail, are undecided or
    /// lie on an unstable orbit have reached none.
    pub fn is_attractor(&self) -> bool {
        matches!(
            self,
            AttractorKind::Equilibrium
                | AttractorKind::EquilibriumSet
                | AttractorKind::Periodic { .. }
                | AttractorKind::Recurrent
        )
    }
}

impl fmt::Display for AttractorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())?;
        match self {
            AttractorKind::Periodic { returns, period } => {
                write!(f, ", {returns} returns, period {period}")
            }
            AttractorKind::Recurrent => f.write_str(", not periodic"),
            AttractorKind::Failure(error) => write!(f, ": {error}"),
            _ => Ok(()),
        }
    }
}

/// Long-term behaviour of an orbit, or how it ends, with the evidence.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Attractor {
    /// The kind of motion.
    pub kind: AttractorKind,
    /// Uncertainty of a periodic orbit's period, from the differences of the last periods; zero for
    /// other motions.
    pub period_uncertainty: f64,
    /// Dimension of the family to which a numbered periodic orbit belongs; see
    /// [`super::Attractors::number`] and [`super::Attractors::family`].
    pub family: Option<usize>,
    /// Section points in one period of a periodic orbit; for an equilibrium, that point
    /// alone, refined; otherwise the last points.
    pub points: Vec<Moment>,
    /// Phases that ended in one period of a periodic orbit, in order of time; otherwise the
    /// last phases.
    pub phases: Vec<Phase>,
    /// The transitions of these phases with the contact at which each begins. With several
    /// contacts, or with contact lost and gained, they say more than the modes.
    pub transitions: Vec<(TransitionKind, usize)>,
    /// Fraction of the duration of these phases in which a contact sticks. At an equilibrium, and
    /// without phases, it is 1 or 0 by the mode at the end.
    pub in_stick: f64,
    /// Number of integration steps after which it was decided.
    pub steps: u64,
    /// Mode at the end time.
    pub mode: Modes,
    /// Time at which integration stopped. If a contact stuck in the phase that ended then, it is
    /// the beginning of that phase, from where an orbit is better continued.
    pub t: f64,
    /// State at that time. If the orbit is certain to converge to an equilibrium from which it is
    /// still far, the state is moved there to within
    /// [`crate::analysis::RecurrenceSettings::closeness`].
    pub x: Vector,
}

impl Attractor {
    /// The modes of the phases as [`Modes::cycle`]; where no phase ended, the mode at the end.
    pub fn sequence(&self) -> Vec<Modes> {
        if self.phases.is_empty() {
            return vec![self.mode];
        }
        Modes::cycle(self.phases.iter().map(|phase| phase.mode))
    }

    /// The period of a periodic orbit; zero of other kinds of motion.
    pub(super) fn period(&self) -> f64 {
        match self.kind {
            AttractorKind::Periodic { period, .. } => period,
            _ => 0.0,
        }
    }

    /// The second half of a period, as a period of its own; `None` where the halves have different
    /// phases or transitions.
    pub(super) fn half(&self) -> Option<Self> {
        let AttractorKind::Periodic { returns, period } = self.kind else {
            return None;
        };
        let points = second_half(&self.points, |_, _| true)?;
        let phases = second_half(&self.phases, |one, other| one.mode == other.mode)?;
        let transitions = second_half(&self.transitions, |one, other| one == other)?;
        let kind = AttractorKind::Periodic {
            returns: returns / 2,
            period: 0.5 * period,
        };
        Some(Attractor {
            kind,
            period_uncertainty: 0.5 * self.period_uncertainty,
            points: points.to_vec(),
            phases: phases.to_vec(),
            transitions: transitions.to_vec(),
            ..self.clone()
        })
    }

    /// Whether two periodic orbits have the same cycle of phases and transitions.
    pub fn has_sequence_of(&self, other: &Self) -> bool {
        self.sequence() == other.sequence() && is_same_cycle(&self.transitions, &other.transitions)
    }
}

/// All cyclic shifts by which `other` has the elements of `one`.
pub(in crate::analysis) fn shifts<'a, A, B>(
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

/// The second half of a sequence whose halves are alike.
fn second_half<A>(of: &[A], same: impl Fn(&A, &A) -> bool) -> Option<&[A]> {
    let (one, other) = of.split_at(of.len() / 2);
    let mut pairs = one.iter().zip(other);
    (one.len() == other.len() && pairs.all(|(a, b)| same(a, b))).then_some(other)
}

/// Whether two sequences are equal up to a cyclic shift.
fn is_same_cycle<A: PartialEq<B>, B>(one: &[A], other: &[B]) -> bool {
    one.is_empty() && other.is_empty() || shifts(one, other, |a, b| a == b).next().is_some()
}
