//! Event-exact integration of dry-friction (Filippov) systems.

pub mod analysis;
pub mod error;
pub mod filippov;
mod interval;
pub mod math;
pub mod models;
pub mod ode;
pub mod orbit;
pub mod scalar;
pub mod system;
mod taylor;

/// The crate whose vectors and matrices appear in signatures; use this one, so that the versions agree.
pub use nalgebra;

pub use error::Error;
pub use filippov::{
    AtRepelling, Failure, Fate, Integration, Locator, Method, Observer, Options, Phase, Progress,
    Start, StepRecord, Summary, Transition, TransitionKind, ensemble, fate, run, solve,
};
pub use orbit::{Counters, Ending, Orbit};
pub use scalar::Scalar;
pub use system::{Filippov, Mode, Side, State};

/// The READMEs' examples are compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
