//! Filippov systems: the switching rules on Σ, event location, and the integration that yields steps, phases and transitions.

mod batch;
mod check;
mod ensemble;
mod event;
mod flow;
mod guard;
mod integration;
mod leaving;
mod locate;
mod observer;
mod options;
mod pile_up;
mod rules;
mod run;
mod scan;
mod slopes;
mod solve;
mod stepper;
mod switch;
mod taylor;
mod uncertainty;

pub use ensemble::{Start, ensemble};
pub use flow::{boundary_gradient, normal_component, sliding_field};
pub use integration::{Integration, Progress};
pub use observer::{Observer, Phase, StepRecord, Transition, TransitionKind};
pub use options::{AtRepelling, Locator, Method, Options};
pub(crate) use rules::LieDerivatives;
pub use rules::{Fate, fate};
pub use scan::first_zero;
pub(crate) use solve::tell;
pub use solve::{Failure, Summary, run, solve};
