//! Filippov systems: the switching rules on Σ, event location, and the driver that yields phases and transitions.

mod driver;
mod ensemble;
mod flow;
mod journey;
mod leaving;
mod locate;
mod march;
mod observer;
mod options;
mod pile_up;
mod rules;
mod scan;
mod stepper;
mod taylor;

pub use driver::{Failure, Summary, run, solve};
pub use ensemble::{Start, ensemble};
pub use flow::{boundary_gradient, normal_component, sliding_field};
pub use observer::{Observer, Phase, StepRecord, Transition, TransitionKind};
pub use options::{AtRepelling, Locator, Method, Options};
pub(crate) use rules::LieDerivatives;
pub use rules::{Fate, fate};
pub use scan::first_zero;
