//! Analyses of systems and orbits: tangent points, monodromy by saltation, periodic orbits, attractors.

pub mod data_spectrum;
mod destination;
mod monodromy;
mod periodic;
mod tangency;

pub use destination::{Destination, destination};
pub use monodromy::{Monodromy, monodromy, saltation};
pub use periodic::{PeriodicOrbit, periodic_orbit, periodic_orbit_forced, planar_multipliers};
pub(crate) use tangency::visibility;
pub use tangency::{Visibility, tangency};
