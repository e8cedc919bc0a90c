//! Explicit Runge–Kutta integration of smooth systems: methods as data for one generic step,
//! step-size control, dense output, and the Hénon step.

pub(crate) mod control;
mod dense;
mod dop853;
mod henon;
mod linear;
mod rk4;
mod step;
mod tableau;

pub(crate) use control::Tolerance;
pub use dense::Dense;
pub(crate) use dense::{SolutionTerms, power_series};
pub use dop853::Dop853;
pub use henon::henon_step;
pub(crate) use linear::Linear;
pub use linear::Timed;
pub use rk4::Rk4;
pub use step::step_end;
pub(crate) use step::{Stages, dense_slopes, for_each_stage, further_slopes, stages};
pub(crate) use tableau::MAX_STAGES;
pub use tableau::RungeKutta;
