//! Bifurcations located in a parameter, against their closed forms.

mod branches;
mod sweeps;
pub mod systems;
