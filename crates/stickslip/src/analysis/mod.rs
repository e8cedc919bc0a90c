//! Analyses of systems and orbits: tangent points, monodromy by saltation, periodic orbits, attractors, Lyapunov spectra,
//! classes of motion.

mod attractors;
mod basin;
#[cfg(feature = "data")]
pub mod data_spectrum;
mod destination;
mod lyapunov;
mod monodromy;
pub mod motion;
mod multipliers;
mod periodic;
mod poincare;
mod tangency;
mod tangent;

pub use attractors::{
    Attractors, Kind, Reached, RecurrenceSettings, SectionPoint, attractor, attractor_on,
    is_same_cycle,
};
pub use basin::{Basin, Share, basin};
pub use destination::{Destination, destination};
pub use lyapunov::{
    Exponent, Growth, Running, Spectrum, SpectrumOptions, lyapunov_spectrum,
    lyapunov_spectrum_watched,
};
pub use monodromy::{Monodromy, monodromy};
pub use multipliers::multipliers;
pub use periodic::{PeriodicOrbit, find_periodic_orbit, periodic_orbit, periodic_orbit_forced};
pub use poincare::{PoincareMap, Return};
pub use tangency::{Visibility, tangency, visibility};
pub use tangent::saltation;
