//! What an orbit has come to, on disk.

use serde::{Deserialize, Serialize};
use stickslip::analysis::{Attractors, Kind, Reached};
use stickslip::dynamics::{Modes, Moment, Phase, Vector};
use stickslip::{Error, TransitionKind};

/// What kind of motion an orbit has come to: as [`stickslip::analysis::Kind`], which says more of
/// each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// An equilibrium.
    Equilibrium,
    /// One of a whole set of equilibria.
    EquilibriumSet,
    /// A periodic orbit.
    Periodic {
        /// Points of the section in a period.
        returns: usize,
        /// Period.
        period: f64,
    },
    /// Quasi-periodic or chaotic.
    Recurrent,
    /// A component passed the escape bound.
    Escape,
    /// An end where the boundary repels.
    Repelling,
    /// An end at a two-fold.
    TwoFold,
    /// The integration failed, and how.
    Failure(String),
    /// None of these within the longest time.
    Undecided,
}

impl Motion {
    fn of(kind: &Kind, told: &dyn Fn(&Error) -> String) -> Self {
        match kind {
            Kind::Equilibrium => Motion::Equilibrium,
            Kind::EquilibriumSet => Motion::EquilibriumSet,
            &Kind::Periodic { returns, period } => Motion::Periodic { returns, period },
            Kind::Recurrent => Motion::Recurrent,
            Kind::Escape => Motion::Escape,
            Kind::Repelling => Motion::Repelling,
            Kind::TwoFold(_) => Motion::TwoFold,
            Kind::Failure(error) => Motion::Failure(told(error)),
            Kind::Undecided => Motion::Undecided,
        }
    }

    /// The library's kind, if it is one whose points tell one from another.
    fn kind(&self) -> Option<Kind> {
        match *self {
            Motion::Equilibrium => Some(Kind::Equilibrium),
            Motion::EquilibriumSet => Some(Kind::EquilibriumSet),
            Motion::Periodic { returns, period } => Some(Kind::Periodic { returns, period }),
            Motion::Recurrent => Some(Kind::Recurrent),
            _ => None,
        }
    }

    /// Whether it is an attractor, and not an orbit that has come to none: that escapes, ends,
    /// fails, or is undecided.
    pub fn is_attractor(&self) -> bool {
        self.kind().is_some()
    }

    /// A word for tables.
    pub fn word(&self) -> &'static str {
        match self {
            Motion::Equilibrium => "equilibrium",
            Motion::EquilibriumSet => "set of equilibria",
            Motion::Periodic { .. } => "periodic",
            Motion::Recurrent => "recurrent",
            Motion::Escape => "escape",
            Motion::Repelling => "end where the boundary repels",
            Motion::TwoFold => "end at a two-fold",
            Motion::Failure(_) => "failure",
            Motion::Undecided => "undecided",
        }
    }
}

/// A transition between phases of an attractor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TransitionThere {
    /// What happened.
    #[serde(with = "KindOnDisk")]
    pub kind: TransitionKind,
    /// At which contact.
    pub contact: usize,
}

/// How the kinds of transitions are written; the compiler keeps it like the library's.
#[derive(Serialize, Deserialize)]
#[serde(remote = "TransitionKind", rename_all = "kebab-case")]
enum KindOnDisk {
    Crossing,
    StickEntry,
    StickExit,
    Touch,
    ContactLoss,
    ContactGain,
    Jump,
}

/// A phase of an attractor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseThere {
    /// Modes in it.
    pub modes: Modes,
    /// Time at the start.
    pub t_start: f64,
    /// Time at the end.
    pub t_end: f64,
    /// State at the start.
    pub x_start: Vec<f64>,
    /// State at the end.
    pub x_end: Vec<f64>,
}

/// What an orbit has come to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The kind of motion.
    pub motion: Motion,
    /// By how much its period may be off; zero where it has none.
    pub period_uncertainty: f64,
    /// Dimension of the family of periodic orbits that it is one of, where that is known.
    pub family: Option<usize>,
    /// Time and state at the points of the section, or at the equilibrium. Kinds that points do not
    /// tell apart have none.
    pub points: Vec<(f64, Vec<f64>)>,
    /// The phases that ended in one period. Kinds that points do not tell apart have none.
    pub phases: Vec<PhaseThere>,
    /// The transitions of these phases.
    pub transitions: Vec<TransitionThere>,
    /// Part of the time in which a contact sticks.
    pub in_stick: f64,
    /// Modes where the orbit was left.
    pub modes: Modes,
    /// Time and state where the orbit was left; not kept on disk.
    #[serde(skip)]
    pub left_at: (f64, Vec<f64>),
}

impl Outcome {
    /// The modes gone through in the phases; where none ended, those at the end alone.
    pub fn sequence(&self) -> Vec<Modes> {
        if self.phases.is_empty() {
            vec![self.modes]
        } else {
            self.phases.iter().map(|phase| phase.modes).collect()
        }
    }

    /// What the library has found; `told` puts into words what an integration failed with.
    pub fn of(reached: &Reached, told: &dyn Fn(&Error) -> String) -> Self {
        let motion = Motion::of(&reached.kind, told);
        let told_by_points = motion.kind().is_some();
        let points = reached.points.iter().filter(|_| told_by_points);
        let phases = reached.phases.iter().filter(|_| told_by_points);
        let transitions = reached.transitions.iter().filter(|_| told_by_points);
        let phase = |phase: &Phase| PhaseThere {
            modes: phase.mode,
            t_start: phase.t_start,
            t_end: phase.t_end,
            x_start: phase.x_start.as_slice().to_vec(),
            x_end: phase.x_end.as_slice().to_vec(),
        };
        Self {
            motion,
            period_uncertainty: reached.period_uncertainty,
            family: reached.family,
            points: points.map(|at| (at.t, at.x.as_slice().to_vec())).collect(),
            phases: phases.map(phase).collect(),
            transitions: transitions
                .map(|&(kind, contact)| TransitionThere { kind, contact })
                .collect(),
            in_stick: reached.in_stick,
            modes: reached.mode,
            left_at: (reached.t, reached.x.as_slice().to_vec()),
        }
    }

    /// Dimension of the family of periodic orbits that it is one of.
    pub fn family(&self, known: &Attractors<'_>) -> usize {
        let kind = self.motion.kind();
        kind.map_or(0, |kind| known.family(&self.restored(kind)))
    }

    fn restored(&self, kind: Kind) -> Reached {
        let phase = |phase: &PhaseThere| Phase {
            mode: phase.modes,
            t_start: phase.t_start,
            t_end: phase.t_end,
            x_start: Vector::from_column_slice(&phase.x_start),
            x_end: Vector::from_column_slice(&phase.x_end),
        };
        let point = |(t, x): &(f64, Vec<f64>)| Moment {
            t: *t,
            x: Vector::from_column_slice(x),
        };
        let transitions = self.transitions.iter();
        Reached {
            kind,
            period_uncertainty: self.period_uncertainty,
            family: self.family,
            points: self.points.iter().map(point).collect(),
            phases: self.phases.iter().map(phase).collect(),
            transitions: transitions.map(|at| (at.kind, at.contact)).collect(),
            in_stick: self.in_stick,
            mode: self.modes,
            t: self.left_at.0,
            x: Vector::from_column_slice(&self.left_at.1),
        }
    }

    /// Whether it is the same attractor of the system as the other.
    pub fn is_same(&self, other: &Outcome, known: &Attractors<'_>) -> bool {
        match (self.motion.kind(), other.motion.kind()) {
            (Some(one), Some(two)) => known.is_same(&self.restored(one), &other.restored(two)),
            (None, None) => self.motion.word() == other.motion.word(),
            _ => false,
        }
    }
}
