//! The report: what becomes of every claim of the paper, by computation, and why.
//!
//! [`ledger::Ledger::compute`] makes all of it; everything else here is a part of that: the figures' tables set against the claims
//! ([`figures`]), verdicts ([`entry`]), the cause of Fig. 8's numbers ([`matrix`], [`convergence`], [`injection`]), the search for
//! what Fig. 8 shows in the stated model ([`scan`]), the Hénon step's accuracy ([`accuracy`]), the estimator's spread in Figs. 10–12
//! ([`spread`]) and the misprints ([`errata`]). [`page`] and [`readme`] show it.

pub mod accuracy;
mod checks;
pub mod cli;
pub mod convergence;
pub mod digits;
mod draw_convergence;
mod draw_scan;
pub mod entry;
pub mod errata;
pub mod figures;
pub mod injection;
pub mod ledger;
pub mod matrix;
mod origin;
pub mod page;
pub mod readme;
pub mod scan;
pub mod spread;
pub mod tables;
