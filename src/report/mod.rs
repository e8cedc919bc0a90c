//! The report.
pub mod convergence;
pub mod digits;
pub mod matrix;
pub mod scan;
