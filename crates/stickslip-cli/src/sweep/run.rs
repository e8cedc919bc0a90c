//! Computes the blocks of a share that are not on disk yet.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::error::{BlockError, SweepError};
use super::plan::{Plan, Share};
use super::store::{Store, Writer};

/// A computation and the place to store it.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The sweep.
    pub plan: &'a Plan,
    /// Folder, created if missing.
    pub folder: &'a Path,
    /// The share to compute.
    pub share: Share,
    /// Number of threads; one for each core if not given.
    pub threads: Option<NonZeroUsize>,
}

/// Result of a run.
#[derive(Debug)]
pub struct Computed {
    /// The folder, ready to be read. It is complete if the share is the whole sweep.
    pub store: Store,
    /// Number of blocks that were computed.
    pub new: usize,
    /// Number of blocks that were on disk already.
    pub old: usize,
    /// Damaged blocks that were recomputed, each with what was wrong.
    pub repaired: Vec<(usize, &'static str)>,
}

/// State of a block: absent, complete or damaged.
type BlockState = Option<Result<(), &'static str>>;

/// Computes the missing blocks of a share, on all threads. `compute` receives the index of a block
/// and, within a chain, the bytes of the block before it. It returns the bytes of the block, which
/// must depend on nothing else. `report` is called with the number of finished blocks and of all
/// blocks, first with the blocks that were on disk.
///
/// A block is written as soon as it is finished, either completely or not at all. Only unfinished
/// blocks are held in memory.
///
/// # Errors
/// [`SweepError::Block`] with the first error of `compute`; those of the folder. Blocks that were
/// finished before stay on disk.
pub fn run<F>(
    task: &Task<'_>,
    report: &(dyn Fn(usize, usize) + Sync),
    compute: F,
) -> Result<Computed, SweepError>
where
    F: Fn(usize, Option<&[u8]>) -> Result<Vec<u8>, BlockError> + Sync,
{
    let threads = task.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| SweepError::Threads {
            reason: error.to_string(),
        })?;
    let writer = Writer::open(task.folder, task.plan, task.share)?;
    let chains: Vec<Range<usize>> = task.share.chains(task.plan).collect();
    // State of each block before the run. Contents are read again where needed.
    let inspect = |chain: &Range<usize>| -> Result<Vec<BlockState>, SweepError> {
        let states = chain.clone().map(|block| writer.store.find(block));
        let states = states.map(|found| Ok(found?.map(|whole| whole.map(drop))));
        states.collect()
    };
    let inspected: Result<Vec<_>, SweepError> =
        pool.install(|| chains.par_iter().map(inspect).collect());
    let inspected = inspected?;
    let states = || inspected.iter().flatten();
    let old = states().filter(|state| **state == Some(Ok(()))).count();
    let all = states().count();
    let done = AtomicUsize::new(old);
    report(old, all);
    let work = |(chain, states): (&Range<usize>, &Vec<BlockState>)| -> Result<(), SweepError> {
        let mut before: Option<Vec<u8>> = None;
        for (block, state) in chain.clone().zip(states) {
            let last = before.take();
            if *state == Some(Ok(())) {
                continue;
            }
            let last = match (task.plan.before(block), last) {
                (Some(index), None) => Some(writer.store.block(index)?),
                (before, last) => last.filter(|_| before.is_some()),
            };
            let content = compute(block, last.as_deref())
                .map_err(|source| SweepError::Block { block, source })?;
            writer.put(block, &content)?;
            before = Some(content);
            report(done.fetch_add(1, Ordering::Relaxed) + 1, all);
        }
        Ok(())
    };
    let each = chains.par_iter().zip(&inspected);
    // Chains are distributed one at a time, so that short and long ones are balanced.
    pool.install(|| each.with_max_len(1).try_for_each(work))?;

    let blocks = chains.iter().cloned().flatten().zip(states());
    let damaged = |(block, state): (usize, &BlockState)| match state {
        Some(Err(damage)) => Some((block, *damage)),
        _ => None,
    };
    let repaired = blocks.filter_map(damaged).collect();
    Ok(Computed {
        store: writer.store,
        new: all - old,
        old,
        repaired,
    })
}
