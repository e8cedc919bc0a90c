//! Sweeps and their commands: the same bits however they are computed, and no loss. They are
//! separate from the other tests, which compile the solver into them.

mod basin_measures;
mod basins;
mod bifurcations;
mod common;
mod folders;
mod kill;
mod maps;
mod merge;
mod same_bits;
