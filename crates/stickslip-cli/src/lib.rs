//! Systems from files, and what the program `stickslip` does with them.

pub mod sweep;
