//! Computes the blocks of a share that are not on disk yet.

use std::fs::File;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::block::Found;
use super::error::{BlockError, SweepError};
use super::plan::{Chain, Plan};
use super::share::Share;
use super::store::{Store, Writer};

/// What is to be computed, and where it goes.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The sweep.
    pub plan: &'a Plan,
    /// Its folder, made if it is missing.
    pub folder: &'a Path,
    /// What of it.
    pub share: Share,
    /// Number of threads; one for each core if not given.
    pub threads: Option<NonZeroUsize>,
}

/// What a run has done.
#[derive(Debug)]
pub struct Computed {
    /// The folder, ready to be read. It is complete if the share is the whole.
    pub store: Store,
    /// Blocks that were computed.
    pub new: usize,
    /// Blocks that were on disk already.
    pub old: usize,
    /// Blocks that were on disk and damaged, and were computed anew, each with what was wrong.
    pub repaired: Vec<(usize, &'static str)>,
    // Held until all is written that is made of the blocks.
    _lock: File,
}

/// Computes what is missing of a share, on all threads. `compute` gets the index of a block and, in a chain, the bytes of the block
/// before it, and gives the bytes of the block: they must depend on nothing else. `report` is called with the number of blocks done
/// and of all blocks, at first with those that were there.
///
/// A block is on disk as soon as it is done, whole or not at all. Only blocks in flight are held in memory.
///
/// # Errors
/// [`SweepError::Block`] with the first error of `compute`; those of the folder. Blocks that were finished before stay on disk.
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
    let chains: Vec<Chain> = task.share.chains(task.plan).collect();
    let inspect = |chain: &Chain| inspect(&writer.store, chain);
    let inspected: Result<Vec<_>, SweepError> =
        pool.install(|| chains.par_iter().map(inspect).collect());
    let inspected = inspected?;

    let state = |wanted: fn(&State) -> bool| {
        let states = inspected.iter().flatten();
        states.filter(|state| wanted(state)).count()
    };
    let old = state(|state| matches!(state, State::Whole));
    let all = state(|_| true);
    let done = AtomicUsize::new(old);
    report(old, all);
    let work = |(chain, states): (&Chain, &Vec<State>)| -> Result<(), SweepError> {
        let mut before: Option<Vec<u8>> = None;
        for (block, state) in chain.blocks().zip(states) {
            let last = before.take();
            if matches!(state, State::Whole) {
                continue;
            }
            let last = match (task.plan.before(block), last) {
                (None, _) => None,
                (Some(_), Some(last)) => Some(last),
                (Some(index), None) => Some(writer.store.block(index)?),
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
    // One at a time, so that short and long ones spread evenly.
    pool.install(|| each.with_max_len(1).try_for_each(work))?;

    let mut repaired = Vec::new();
    for (chain, states) in chains.iter().zip(&inspected) {
        for (block, state) in chain.blocks().zip(states) {
            if let State::Damaged(damage) = state {
                repaired.push((block, *damage));
            }
        }
    }
    Ok(Computed {
        store: writer.store,
        _lock: writer.lock,
        new: all - old,
        old,
        repaired,
    })
}

/// What there is of a block before the run.
enum State {
    Whole,
    Missing,
    Damaged(&'static str),
}

fn inspect(store: &Store, chain: &Chain) -> Result<Vec<State>, SweepError> {
    let state = |block| match store.find(block)? {
        Some(Found::Whole(_)) => Ok(State::Whole),
        None => Ok(State::Missing),
        Some(Found::Damaged(damage)) => Ok(State::Damaged(damage)),
        Some(Found::Stranger) => Err(SweepError::Stranger {
            path: store.path(block),
        }),
    };
    chain.blocks().map(state).collect()
}
