//! Event-exact integration of dry-friction (Filippov) systems, and the replication of one paper with it.

pub mod analysis;
pub mod error;
pub mod figures;
pub mod filippov;
mod interval;
pub mod math;
pub mod models;
pub mod ode;
pub mod orbit;
pub mod paper;
pub mod peers;
pub mod readings;
pub mod report;
pub mod scalar;
pub mod spectrum_cli;
pub mod system;
mod taylor;
mod terminal;

pub use error::Error;
pub use filippov::{
    AtRepelling, Failure, Fate, Locator, Method, Observer, Options, Phase, Start, StepRecord,
    Summary, Transition, TransitionKind, ensemble, fate, run, solve,
};
pub use orbit::{Counters, Ending, Orbit};
pub use scalar::Scalar;
pub use system::{Filippov, Mode, Side, State};

/// The README's example is compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
