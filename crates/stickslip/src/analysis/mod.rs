//! Analyses of systems and orbits: monodromy by saltation, periodic orbits and their branches,
//! attractors and basins, bifurcations, Lyapunov spectra.

mod attractors;
mod basin;
mod bifurcation;
mod continuation;
mod critical;
mod cycle;
mod derivatives;
mod elimination;
mod graze;
mod instant;
mod lagrange;
mod lyapunov;
mod monodromy;
mod multipliers;
mod normal_form;
mod passages;
mod periodic;
mod periodic_derivatives;
mod poincare;
mod simultaneous;
mod stability;
mod tangent;

pub use attractors::{Attractor, AttractorKind, Attractors, RecurrenceSettings, attractor};
pub use basin::{
    Basin, BasinEntropy, EdgeKind, EdgeSettings, EdgeState, Push, PushSettings, Share, SharesAt,
    UncertaintyExponent, basin,
};
pub use bifurcation::{
    AttractorChange, NotFollowed, SweepPoint, WhatChanges, locate_changes, sweep,
};
pub use continuation::{
    Branch, BranchPoint, ContinuationSettings, Curve, CurveBifurcation, CurvePoint,
    CurveSpecialPoint, CurveStop, CycleBifurcation, EquilibriumBifurcation, EquilibriumBranch,
    EquilibriumCurve, EquilibriumCurveBifurcation, EquilibriumCurvePoint, EquilibriumCurveSpecial,
    EquilibriumPoint, PartialBranch, SpecialEquilibrium, SpecialPoint, Stop, SwitchedBranch,
    continue_periodic_orbit,
};
pub use cycle::{SequenceBifurcation, SequenceChange, StepBudget};
pub use derivatives::{
    Differentiated, EventDerivatives, OrbitDerivatives, OrbitTangents, Variable,
};
pub use lyapunov::{Exponent, Running, Spectrum, SpectrumOptions, lyapunov_spectrum};
pub use monodromy::Monodromy;
pub use multipliers::multipliers;
pub use normal_form::{Criticality, NormalForm};
pub use periodic::PeriodicOrbit;
pub use periodic_derivatives::{ExtremeDerivatives, PeriodicDerivatives};
pub use poincare::PoincareMap;
pub use stability::Stability;
