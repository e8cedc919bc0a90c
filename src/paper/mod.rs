//! What the paper printed: the program of its Appendix, and the published values.
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
pub mod pattern;
pub mod published;
pub mod reading;
pub mod slip_times_three;
mod stages;

use stickslip::Options;

/// Options for a run of model 2. Beyond 10 m or 10 m/s its softening spring drives the body away
/// for good.
pub(crate) fn bounded(tolerance: f64) -> Options {
    Options::tol(tolerance).escape(ESCAPE)
}

/// See [`bounded`].
pub(crate) const ESCAPE: f64 = 10.0;
