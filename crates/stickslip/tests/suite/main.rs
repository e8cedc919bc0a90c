//! The tests of the library, in one binary.

#![allow(
    clippy::duplicate_mod,
    reason = "the solver's tests run by slopes and by series, over one copy of the systems"
)]

mod any_system;
mod attractors;
mod bifurcations;
mod contacts;
#[cfg(feature = "data")]
mod data_spectrum;
mod ensemble;
mod grazes;
mod lyapunov_equations;
mod models;
mod no_allocation;
mod periodic;
mod sections;
mod solver;
mod taylor;
mod two_folds;
