//! Saves a branch while it is followed, and the curves and branches that begin on it, so that the
//! computation resumes after a kill.

use std::ops::ControlFlow;
use std::time::Instant;

use serde::{Serialize, de::DeserializeOwned};
use stickslip::analysis::PartialBranch;

use super::super::sweeping::{from_content, to_content};
use crate::failure::Failure;
use crate::sweep::{SweepError, Writer};

/// Reads a saved block. `None` if there is no complete one.
pub(super) fn saved<T: DeserializeOwned>(
    writer: &Writer,
    block: usize,
) -> Result<Option<T>, SweepError> {
    let failed = |source| SweepError::Block { block, source };
    match writer.store.find(block)? {
        Some(Ok(content)) => from_content(&content).map(Some).map_err(failed),
        _ => Ok(None),
    }
}

/// A result, read from its block or computed and saved there. Besides the plan of the sweep it
/// depends on `by`: a saved result of another `by` is replaced.
pub(super) fn saved_or_computed<T: Serialize + DeserializeOwned>(
    writer: &Writer,
    (block, by): (usize, &str),
    compute: impl FnOnce() -> Result<T, Failure>,
) -> Result<T, Failure> {
    let saved = saved::<(String, T)>(writer, block)?;
    if let Some((_, result)) = saved.filter(|(of, _)| of == by) {
        return Ok(result);
    }
    let result = compute()?;
    // A branch whose end the solver refuses to follow is not written: a resumed run computes it.
    if let Ok(content) = to_content(&(by, &result)) {
        writer.put(block, &content)?;
    }
    Ok(result)
}

/// Saves one direction along a branch in a block.
pub(super) struct BranchSaver<'a> {
    writer: &'a Writer,
    block: usize,
    /// Time of the next save.
    due: Instant,
    unsaved: Option<PartialBranch>,
    outcome: Result<(), SweepError>,
}

impl<'a> BranchSaver<'a> {
    pub(super) fn of(writer: &'a Writer, block: usize) -> Self {
        BranchSaver {
            writer,
            block,
            due: Instant::now(),
            unsaved: None,
            outcome: Ok(()),
        }
    }

    /// Saves the branch, if that is due. Stops the continuation if saving fails.
    pub(super) fn observe(&mut self, branch: &PartialBranch) -> ControlFlow<()> {
        if Instant::now() < self.due {
            self.unsaved = Some(branch.clone());
            return ControlFlow::Continue(());
        }
        self.unsaved = None;
        self.outcome = self.save(branch);
        match self.outcome {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    }

    /// Saves the state at the start of the last step. The file is then the same however often the
    /// computation was interrupted.
    pub(super) fn finish(mut self) -> Result<(), SweepError> {
        if let Some(branch) = self.unsaved.take() {
            self.save(&branch)?;
        }
        self.outcome
    }

    fn save(&mut self, branch: &PartialBranch) -> Result<(), SweepError> {
        /// Time between two saves, in units of the duration of a save: saving takes a twentieth of
        /// the time at most.
        const TIMES: u32 = 20;
        let block = self.block;
        let begun = Instant::now();
        let content = to_content(branch).map_err(|source| SweepError::Block { block, source })?;
        self.writer.put(block, &content)?;
        self.due = Instant::now() + TIMES * begun.elapsed();
        Ok(())
    }
}
