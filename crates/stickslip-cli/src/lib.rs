//! Implementation of the program `stickslip`, for systems from files and for measured series.

pub mod commands;
mod failure;
mod render;
pub mod sweep;
pub mod table;
