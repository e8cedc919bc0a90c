//! Sweeps: the same bits however they are computed, and nothing lost.

mod common;
mod folders;
mod kill;
mod merge;
mod same_bits;
