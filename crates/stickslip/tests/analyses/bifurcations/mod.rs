//! Bifurcations located in a parameter, against their closed forms.

mod branches;
mod several;
mod sweeps;
pub mod systems;
