//! Computations that report how far they are and can be stopped.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::error::DataError;

/// Receives at intervals how much is done and how much there is. Where it breaks, the computation
/// ends with [`DataError::Stopped`].
pub type Progress<'a> = &'a dyn Fn(usize, usize) -> ControlFlow<()>;

/// Progress without an observer.
pub fn unwatched(_done: usize, _total: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Reports progress.
///
/// # Errors
/// [`DataError::Stopped`].
pub(crate) fn report(progress: Progress<'_>, done: usize, total: usize) -> Result<(), DataError> {
    match progress(done, total) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(DataError::Stopped),
    }
}

/// Items computed in parallel between two calls of `goes_on`: some for each of many cores.
const ITEMS_PER_REPORT: usize = 64;

/// The results of `each` for the numbers below `count`, in order. `goes_on` is asked at intervals.
///
/// # Errors
/// Those of `goes_on`.
pub(crate) fn in_parallel<M, T: Send>(
    count: usize,
    goes_on: &dyn Fn() -> Result<(), DataError>,
    memory: impl Fn() -> M + Sync + Send,
    each: impl Fn(&mut M, usize) -> T + Sync + Send,
) -> Result<Vec<T>, DataError> {
    let mut results = Vec::with_capacity(count);
    while results.len() < count {
        goes_on()?;
        let until = (results.len() + ITEMS_PER_REPORT).min(count);
        let more = (results.len()..until).into_par_iter();
        let more: Vec<T> = more.map_init(&memory, &each).collect();
        results.extend(more);
    }
    Ok(results)
}
