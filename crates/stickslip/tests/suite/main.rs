//! The tests of the solver and of analyses of one orbit, in one binary.

#![allow(
    clippy::duplicate_mod,
    reason = "the solver's tests run by slopes and by series, over one copy of the systems"
)]

mod any_system;
mod blocks;
#[path = "../common/compiled.rs"]
mod compiled;
#[path = "../common/constant_fields.rs"]
mod constant_fields;
mod corners;
#[path = "../common/den_hartog.rs"]
mod den_hartog;
mod endings;
mod ensemble;
mod family;
mod flat;
mod front_page;
mod grazes;
mod lyapunov_equations;
mod no_allocation;
mod periodic;
mod pulses;
mod roots;
mod sections;
#[path = "../common/smooth.rs"]
mod smooth;
mod solver;
mod taylor;
mod two_folds;
