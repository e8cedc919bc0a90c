//! What the program `stickslip` does with systems from files, and with measured series.

pub mod commands;
mod failure;
mod render;
pub mod sweep;
pub mod table;
pub mod tangents;
mod terminal;
