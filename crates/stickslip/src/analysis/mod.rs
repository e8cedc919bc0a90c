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
mod least_squares;
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

pub use attractors::{
    Attractor, AttractorKind, Attractors, RecurrenceSettings, attractor, attractor_by_shooting,
    attractor_of_many, attractors_of_many,
};
pub use basin::{
    Basin, BasinEntropy, EdgeKind, EdgeSettings, EdgeState, Push, PushSettings, Share, SharesAt,
    UncertaintyExponent, basin, basin_entropy, basin_while, edge_state, least_pushes, return_time,
    shares_along, shares_at, uncertainty_exponent,
};
pub use bifurcation::{
    AttractorChange, NotFollowed, SweepPoint, SweepSettings, WhatChanges, carried_on, is_change,
    locate_changes, locate_changes_within, sweep,
};
pub use continuation::{
    Branch, BranchPoint, ContinuationSettings, Curve, CurveBifurcation, CurvePoint,
    CurveSpecialPoint, CurveStop, CycleBifurcation, EquilibriumBifurcation, EquilibriumBranch,
    EquilibriumCurve, EquilibriumCurveBifurcation, EquilibriumCurvePoint, EquilibriumCurveSpecial,
    EquilibriumPoint, PartialBranch, SpecialEquilibrium, SpecialPoint, Stop, SwitchedBranch,
    continue_change, continue_end, continue_equilibrium, continue_periodic_orbit,
    continue_special_equilibrium, switch_branches, switch_branches_to,
};
pub use cycle::{SequenceBifurcation, SequenceChange, StepBudget};
pub use derivatives::{
    Differentiated, EventDerivatives, OrbitDerivatives, OrbitTangents, Variable, orbit_derivatives,
    orbit_derivatives_of,
};
pub use least_squares::{
    LeastSquares, LeastSquaresEnd, LeastSquaresSettings, Loss, Residuals,
    constrained_least_squares, least_squares, null_space,
};
pub use lyapunov::{
    Exponent, Running, Spectrum, SpectrumOptions, largest_exponent, lyapunov_spectrum,
    lyapunov_spectrum_watched,
};
pub use monodromy::{Monodromy, monodromy};
pub use multipliers::multipliers;
pub use normal_form::{Criticality, NormalForm};
pub use periodic::{
    PeriodicOrbit, branch_multiplier_uncertainties, find_periodic_orbit, multiplier_uncertainties,
    periodic_orbit, periodic_orbit_forced, with_shortest_period,
};
pub use periodic_derivatives::{ExtremeDerivatives, PeriodicDerivatives, periodic_derivatives};
pub use poincare::{PoincareMap, Return};
pub use stability::Stability;
