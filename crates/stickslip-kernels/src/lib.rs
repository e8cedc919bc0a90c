//! Systems that are known at run time only: files, their expressions, and the solver compiled for
//! them.
//!
//! This is a package of its own because of its compile time: the solver is compiled in it for eight
//! sizes of systems, which takes about a minute. What has options and makes figures
//! (`stickslip-cli`) is compiled without that.

pub mod expression;
pub mod file;
pub mod kernel;
pub mod study;
pub mod trace;
