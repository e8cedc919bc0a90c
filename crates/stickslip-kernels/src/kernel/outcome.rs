//! The outcome of an orbit, in the form stored on disk.

use serde::{Deserialize, Serialize};
use stickslip::analysis::{Attractor, AttractorKind, Attractors};
use stickslip::dynamics::{Modes, Moment, Phase, Vector};
use stickslip::{Error, TransitionKind};

/// The kind of motion that an orbit reaches; see [`stickslip::analysis::AttractorKind`] for
/// details.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// An equilibrium.
    Equilibrium,
    /// One of a continuous set of equilibria.
    EquilibriumSet,
    /// A periodic orbit.
    Periodic {
        /// Crossings of the section per period.
        returns: usize,
        /// Period.
        period: f64,
    },
    /// Quasi-periodic or chaotic.
    Recurrent,
    /// A component exceeded the escape bound.
    Escape,
    /// The orbit ended where the boundary repels.
    Repelling,
    /// The orbit ended at a two-fold.
    TwoFold,
    /// The integration failed; the message says why.
    Failure(String),
    /// None of these within the longest time.
    Undecided,
}

impl Motion {
    fn of(kind: &AttractorKind, describe: &dyn Fn(&Error) -> String) -> Self {
        match kind {
            AttractorKind::Equilibrium => Motion::Equilibrium,
            AttractorKind::EquilibriumSet => Motion::EquilibriumSet,
            &AttractorKind::Periodic { returns, period } => Motion::Periodic { returns, period },
            AttractorKind::Recurrent => Motion::Recurrent,
            AttractorKind::Escape => Motion::Escape,
            AttractorKind::Repelling => Motion::Repelling,
            AttractorKind::TwoFold(_) => Motion::TwoFold,
            AttractorKind::Failure(error) => Motion::Failure(describe(error)),
            AttractorKind::Undecided => Motion::Undecided,
        }
    }

    /// The library's kind, for kinds that are distinguished by points.
    fn kind(&self) -> Option<AttractorKind> {
        match *self {
            Motion::Equilibrium => Some(AttractorKind::Equilibrium),
            Motion::EquilibriumSet => Some(AttractorKind::EquilibriumSet),
            Motion::Periodic { returns, period } => {
                Some(AttractorKind::Periodic { returns, period })
            }
            Motion::Recurrent => Some(AttractorKind::Recurrent),
            _ => None,
        }
    }

    /// Whether it is an attractor. Orbits that escape, end, fail or are undecided have reached
    /// none.
    pub fn is_attractor(&self) -> bool {
        self.kind().is_some()
    }

    /// One word for tables.
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

/// A transition between two phases of an attractor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AttractorTransition {
    /// Kind of transition.
    #[serde(with = "StoredTransitionKind")]
    pub kind: TransitionKind,
    /// Contact.
    pub contact: usize,
}

/// Serialized form of the kinds of transitions; the compiler checks that it matches the library's.
#[derive(Serialize, Deserialize)]
#[serde(remote = "TransitionKind", rename_all = "kebab-case")]
enum StoredTransitionKind {
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
pub struct AttractorPhase {
    /// Modes of the phase.
    pub modes: Modes,
    /// Start time.
    pub t_start: f64,
    /// End time.
    pub t_end: f64,
    /// Initial state.
    pub x_start: Vec<f64>,
    /// Final state.
    pub x_end: Vec<f64>,
}

/// The outcome of an orbit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The kind of motion.
    pub motion: Motion,
    /// Uncertainty of the period; zero if there is none.
    pub period_uncertainty: f64,
    /// Dimension of the family of periodic orbits that contains it, if known.
    pub family: Option<usize>,
    /// Time and state at the points of the section, or at the equilibrium. Empty for kinds that are
    /// not distinguished by points.
    pub points: Vec<(f64, Vec<f64>)>,
    /// The phases that end in one period. Empty for kinds that are not distinguished by points.
    pub phases: Vec<AttractorPhase>,
    /// The transitions of these phases.
    pub transitions: Vec<AttractorTransition>,
    /// Fraction of the time in which a contact sticks.
    pub in_stick: f64,
    /// Modes at the end of the computation.
    pub modes: Modes,
    /// Time and state at the end of the computation; not stored on disk.
    #[serde(skip)]
    pub left_at: (f64, Vec<f64>),
}

impl Outcome {
    /// The modes of the phases as [`Modes::cycle`], or the final modes if no phase ended.
    pub fn sequence(&self) -> Vec<Modes> {
        if self.phases.is_empty() {
            return vec![self.modes];
        }
        Modes::cycle(self.phases.iter().map(|phase| phase.modes))
    }

    /// Converts the library's result. `describe` formats the error of a failed integration.
    pub fn of(reached: &Attractor, describe: &dyn Fn(&Error) -> String) -> Self {
        let motion = Motion::of(&reached.kind, describe);
        let has_points = motion.kind().is_some();
        let points = reached.points.iter().filter(|_| has_points);
        let phases = reached.phases.iter().filter(|_| has_points);
        let transitions = reached.transitions.iter().filter(|_| has_points);
        let phase = |phase: &Phase| AttractorPhase {
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
                .map(|&(kind, contact)| AttractorTransition { kind, contact })
                .collect(),
            in_stick: reached.in_stick,
            modes: reached.mode,
            left_at: (reached.t, reached.x.as_slice().to_vec()),
        }
    }

    /// Dimension of the family of periodic orbits that contains it.
    pub fn family(&self, attractors: &Attractors<'_>) -> usize {
        let kind = self.motion.kind();
        kind.map_or(0, |kind| attractors.family(&self.restored(kind)))
    }

    fn restored(&self, kind: AttractorKind) -> Attractor {
        let phase = |phase: &AttractorPhase| Phase {
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
        Attractor {
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

    /// Whether both are the same attractor of the system.
    pub fn is_same(&self, other: &Outcome, attractors: &Attractors<'_>) -> bool {
        match (self.motion.kind(), other.motion.kind()) {
            (Some(one), Some(two)) => attractors.is_same(&self.restored(one), &other.restored(two)),
            (None, None) => self.motion.word() == other.motion.word(),
            _ => false,
        }
    }
}
