//! Systems defined at run time: files, their expressions, and the solver compiled for them.
//!
//! This is a separate crate because of its compile time. The solver is compiled in it for eight
//! system sizes, which takes about a minute. `stickslip-cli`, with its options and figures, is
//! compiled without that.

pub mod expression;
pub mod file;
pub mod kernel;
pub mod study;
pub mod text_table;
pub mod trace;
