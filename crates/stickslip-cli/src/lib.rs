//! Systems from files, and what the program `stickslip` does with them.

pub mod commands;
pub mod file;
pub mod output;
pub mod problem;
pub mod shipped;
pub mod sweep;
pub mod system;
pub mod table;
pub mod tangents;
mod terminal;
