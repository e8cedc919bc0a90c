//! The report: what becomes of every claim of the paper, by computation, and why.
//!
//! [`ledger::Ledger::compute`] makes all of it; everything else here is a part of that: what readings give for a claim ([`finding`]) and what
//! that comes to ([`verdict`]), evidence for statements ([`evidence`], [`accuracy`]), the cause of Fig. 8's numbers ([`cause`], [`matrix`],
//! [`convergence`], [`injection`]), the search for what Fig. 8 shows in the stated model ([`scan`]), the estimator's spread in Figs. 10–12
//! ([`spread`]) and the misprints ([`errata`]). [`page`] and [`readme`] show it.

pub mod accuracy;
pub mod cause;
pub mod cli;
pub mod convergence;
pub mod correction;
pub mod digits;
mod draw_convergence;
mod draw_scan;
pub mod errata;
mod error;
pub mod evidence;
pub mod figures;
pub mod finding;
pub mod injection;
pub mod ledger;
pub mod matrix;
pub mod page;
pub mod readme;
pub mod remark;
pub mod scan;
mod sentences;
pub mod spread;
pub mod tables;
pub mod verdict;

pub use error::ReportError;
