//! Saves a branch while it is followed, so that the computation resumes after a kill.

use std::ops::ControlFlow;
use std::time::Instant;

use stickslip::analysis::PartialBranch;

use super::super::sweeping::{from_content, to_content};
use crate::sweep::{SweepError, Writer};

/// Reads what was saved in a block. `None` if there is no complete block.
pub(super) fn saved(writer: &Writer, block: usize) -> Result<Option<PartialBranch>, SweepError> {
    let failed = |source| SweepError::Block { block, source };
    match writer.store.find(block)? {
        Some(Ok(content)) => from_content(&content).map(Some).map_err(failed),
        _ => Ok(None),
    }
}

/// Saves one direction along a branch in a block.
pub(super) struct Saving<'a> {
    writer: &'a Writer,
    block: usize,
    /// Time of the next save.
    due: Instant,
    unsaved: Option<PartialBranch>,
    outcome: Result<(), SweepError>,
}

impl<'a> Saving<'a> {
    pub(super) fn of(writer: &'a Writer, block: usize) -> Self {
        Saving {
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
        /// Time between two saves, in units of the duration of a save.
        const TIMES: u32 = 20;
        let block = self.block;
        let begun = Instant::now();
        let content = to_content(branch).map_err(|source| SweepError::Block { block, source })?;
        self.writer.put(block, &content)?;
        self.due = Instant::now() + TIMES * begun.elapsed();
        Ok(())
    }
}
