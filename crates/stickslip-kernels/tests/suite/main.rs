//! Tests of expressions and of systems from files.

mod extremes;
mod friction;
mod inputs;
mod long_formulas;
mod parse;
mod sizes;
mod tape;
