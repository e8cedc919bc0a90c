//! A branch of periodic orbits, without the number of states and contacts in its type.

use stickslip::analysis::{Branch, Special, Stability, Stop};
use stickslip::nalgebra::Complex;

use super::change::Change;
use stickslip::dynamics::Modes;

/// A periodic orbit on a branch: as [`stickslip::analysis::BranchPoint`], the parameter being the last component of `x`.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitThere {
    /// The parameter.
    pub parameter: f64,
    /// Time at which the orbit is at `x`.
    pub t: f64,
    /// A state on it.
    pub x: Vec<f64>,
    /// Period.
    pub period: f64,
    /// Floquet multipliers by falling size, without the trivial one of a system that does not depend on time.
    pub multipliers: Vec<Complex<f64>>,
    /// What they say of it.
    pub stability: Stability,
    /// The modes gone through in one period.
    pub phases: Vec<Modes>,
}

/// What is special about an orbit: as [`stickslip::analysis::Special`].
#[derive(Clone, Debug, PartialEq)]
pub enum SpecialKind {
    /// The branch turns back.
    Fold,
    /// Another branch meets it.
    BranchPoint,
    /// The period doubles.
    Flip,
    /// A torus is shed.
    NeimarkSacker {
        /// Angle of the pair of multipliers, in radians.
        angle: f64,
    },
    /// The phases change.
    Sequence(Change),
}

/// A special orbit between two of a branch.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecialThere {
    /// The parameter.
    pub parameter: f64,
    /// By how much that may be off.
    pub uncertainty: f64,
    /// What is special.
    pub what: SpecialKind,
    /// Behind how many orbits of the branch it lies.
    pub behind: usize,
    /// A state on the orbit.
    pub x: Vec<f64>,
    /// Period.
    pub period: f64,
}

/// A branch of periodic orbits.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchFound {
    /// The orbits, from the first one on.
    pub points: Vec<OrbitThere>,
    /// The special ones between them.
    pub special: Vec<SpecialThere>,
    /// Why there are no more.
    pub stop: Stop,
}

impl BranchFound {
    pub(super) fn of(branch: &Branch) -> Self {
        let points = branch.points.iter().map(|at| OrbitThere {
            parameter: at.parameter,
            t: at.t,
            x: at.x.as_slice().to_vec(),
            period: at.period,
            multipliers: at.multipliers.clone(),
            stability: at.stability(),
            phases: at.sequence.clone(),
        });
        let special = branch.special.iter().map(|at| SpecialThere {
            parameter: at.parameter,
            uncertainty: at.uncertainty,
            what: match &at.what {
                Special::Fold => SpecialKind::Fold,
                Special::BranchPoint => SpecialKind::BranchPoint,
                Special::Flip => SpecialKind::Flip,
                Special::NeimarkSacker { angle } => SpecialKind::NeimarkSacker { angle: *angle },
                Special::Sequence(change) => SpecialKind::Sequence(Change::of_sequence(change)),
            },
            behind: at.behind,
            x: at.x.as_slice().to_vec(),
            period: at.period,
        });
        BranchFound {
            points: points.collect(),
            special: special.collect(),
            stop: branch.stop.clone(),
        }
    }
}
