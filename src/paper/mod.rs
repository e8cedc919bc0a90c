//! Contents of the paper: the program of its Appendix, and the published values.
//!
//! P. Olejnik, J. Awrejcewicz, *Application of Hénon method in numerical estimation of the
//! stick–slip transitions existing in Filippov-type discontinuous dynamical systems with dry
//! friction*, Nonlinear Dynamics 73 (2013) 723–736, doi 10.1007/s11071-013-0826-7.
//!
//! These are not good ways to integrate a friction oscillator. They trace a published number to the
//! arithmetic that produced it.

pub mod claim_id;
pub mod in_place;
pub mod listing;
pub mod models;
pub mod pattern;
pub mod published;
pub mod reading;
pub mod slip_times_three;
mod stages;

use stickslip::Options;

/// Tolerance of accurate solutions: far below the printed digits, and some hundred times the
/// rounding of a double.
pub(crate) const TOLERANCE: f64 = 1e-13;
/// Tolerance of runs that only have to settle. Their states are compared to 1e-6 or more.
pub(crate) const SETTLING_TOLERANCE: f64 = 1e-9;
/// Displacement in m, or speed in m/s, beyond which model 2's softening spring drives the body away
/// for good.
pub(crate) const ESCAPE: f64 = 10.0;

/// Options for a run of model 2, which ends with an error where the body escapes.
pub(crate) fn bounded(tolerance: f64) -> Options {
    Options::tol(tolerance).escape(ESCAPE)
}
