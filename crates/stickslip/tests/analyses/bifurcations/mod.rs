//! Bifurcations located in a parameter, against their closed forms.

mod branches;
mod on_the_boundary;
mod several;
mod sweeps;
pub mod systems;
