//! Tests of expressions and of systems from files.

mod extremes;
mod orbits;
mod parse;
mod sizes;
mod tape;
