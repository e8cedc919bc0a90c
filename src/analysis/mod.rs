//! Analyses of systems and orbits: tangent points, monodromy by saltation, periodic orbits, attractors.

mod monodromy;
mod periodic;
mod tangency;

pub use monodromy::{Monodromy, monodromy, saltation};
pub use periodic::{PeriodicOrbit, periodic_orbit, periodic_orbit_forced, planar_multipliers};
pub use tangency::{Visibility, tangency};
