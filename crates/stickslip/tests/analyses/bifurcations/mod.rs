//! Bifurcations in one parameter, compared with closed forms.

mod boundary_equilibria;
mod branches;
mod curves;
mod curves_of_ends;
mod equilibria;
mod equilibrium_curves;
mod on_the_boundary;
mod several;
mod static_friction;
mod sweeps;
mod switching;
pub mod systems;
