//! The replication of one paper with the library [`stickslip`]: its figures, its claims, its readings.

mod bisection;
pub mod figures;
mod marked;
pub mod paper;
pub mod peers;
pub mod readings;
pub mod report;
pub mod spectrum_cli;
mod terminal;
mod turns;

/// The README's example is compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
