//! Filippov systems: the switching rules on Σ, event location, and the integration that yields
//! steps, phases and transitions.

mod absolute;
mod accumulation;
mod batch;
mod check;
mod contacts;
mod deflation;
mod ensemble;
mod flow;
mod guard;
mod integration;
mod locate;
mod memory;
mod observer;
mod one_contact;
mod options;
mod pile_up;
mod recordings;
mod restart;
mod root_law;
mod rules;
mod run;
mod runge_kutta;
mod scan;
mod sections;
mod solve;
mod stepper;
mod switched;
mod taylor;
mod two_fold;
mod uncertainty;

pub use absolute::AbsoluteTolerance;
pub(crate) use batch::{BatchMember, side_by_side};
pub use contacts::{Contacts, Several};
pub(crate) use ensemble::{ORBITS_AT_ONCE, task_size};
pub use ensemble::{Start, ensemble};
pub(crate) use flow::{Flow, gradient, seeded};
pub use integration::{Integration, Progress};
pub(crate) use memory::StepMemory;
pub use observer::{
    Observer, Phase, PhaseOf, StepRecord, Transition, TransitionKind, TransitionOf,
};
pub use options::{AtPileUp, AtRepelling, Locator, Method, Options};
pub(crate) use options::{MIN_ABSOLUTE, MIN_TOLERANCE};
pub use rules::{Fate, Visibility, fate};
pub(crate) use run::TIME_ROUNDING;
pub use scan::first_zero;
pub use sections::{
    Direction, EventFunctions, EventOf, EventRecord, EventSearch, solve_with_events,
};
pub(crate) use sections::{Plane, SearchMemory, Strobe, TOLERATED};
pub(crate) use solve::notify;
pub use solve::{Failure, run, solve};
pub(crate) use stepper::Stepper;
pub use switched::Switched;
pub(crate) use switched::{GuardGradient, Settled, UseFlow, Velocity};
pub(crate) use uncertainty::{EVENT_PRECISION, RELATIVE_ROUNDING};
