//! The tests of the library, in one binary.

mod data_spectrum;
mod ensemble;
mod grazes;
mod lyapunov_equations;
mod no_allocation;
mod solver;
mod taylor;
