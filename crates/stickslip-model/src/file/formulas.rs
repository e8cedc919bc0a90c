//! Formulas that are built beside a system: what is observed, friction laws and reactions alone.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{PoisonError, RwLock};

use rustc_hash::FxHashMap;
use stickslip::Mode;

use super::build::TapeBuild;
use super::builder::Freed;
use super::problem::Problem;
use crate::expression::Tape;
use crate::kernel::Combination;

/// Most formulas that a family keeps, and most builds of one for different decisions. Chosen: a
/// study asks for a few. Those beyond are built anew when they are asked for again.
const MOST_FORMULAS: usize = 4096;
const MOST_BUILDS: usize = 8;

/// A set of formulas that one tape computes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum FormulaKey {
    /// The sizes of all frictions in a combination.
    Frictions(Combination),
    /// The reactions of all stops in a combination.
    Reactions(Combination),
    /// The friction forces of all contacts in a combination.
    FrictionForces(Combination),
    /// An expression in which reactions and friction forces are states behind all others.
    WithForces(String),
    /// An expression in which some parameters are states.
    Observed(String, Box<Freed>),
    /// An observable in a mode of the only contact, with its friction force.
    ObservedInMode(String, Box<Freed>, Mode),
}

/// The builds of formulas of one file.
#[derive(Debug, Default)]
pub(super) struct Formulas {
    known: RwLock<FxHashMap<FormulaKey, Vec<TapeBuild>>>,
    builds: AtomicUsize,
}

impl Formulas {
    /// Number of builds so far.
    pub(super) fn builds(&self) -> usize {
        self.builds.load(Ordering::Relaxed)
    }

    /// The tape of a formula for these values of the parameters. It is built if no build of it
    /// holds for them.
    pub(super) fn tape(
        &self,
        key: FormulaKey,
        values: &[f64],
        build: impl FnOnce() -> Result<TapeBuild, Problem>,
    ) -> Result<Tape, Problem> {
        // A thread that panicked left complete builds.
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let builds = known.get(&key).into_iter().flatten();
        if let Some(tape) = builds.rev().find_map(|build| build.bound(values)) {
            return Ok(tape);
        }
        drop(known);
        self.builds.fetch_add(1, Ordering::Relaxed);
        let build = build()?;
        let tape = build.tape.clone();
        let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= MOST_FORMULAS {
            known.clear();
        }
        let builds = known.entry(key).or_default();
        if builds.len() >= MOST_BUILDS {
            builds.remove(0);
        }
        builds.push(build);
        Ok(tape)
    }
}
