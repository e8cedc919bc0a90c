//! The report.
pub mod accuracy;
pub mod convergence;
pub mod digits;
pub mod injection;
pub mod matrix;
pub mod scan;
pub mod spread;
