//! What the program `stickslip` does with systems from files.

pub mod commands;
pub mod output;
pub mod sweep;
pub mod tangents;
mod terminal;
