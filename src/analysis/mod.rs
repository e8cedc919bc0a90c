//! Analyses of systems and orbits: tangent points, monodromy by saltation, periodic orbits, attractors.

mod destination;
mod monodromy;
mod periodic;
mod tangency;
mod tangent;

pub use destination::{Destination, destination};
pub use monodromy::{Monodromy, monodromy};
pub use periodic::{PeriodicOrbit, periodic_orbit, periodic_orbit_forced, planar_multipliers};
pub(crate) use tangency::visibility;
pub use tangency::{Visibility, tangency};
pub use tangent::saltation;
