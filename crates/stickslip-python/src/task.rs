//! Computations that Ctrl-C can end, with progress reports.
//!
//! An analysis runs on separate threads, on a system whose orbits can be stopped. Meanwhile the
//! thread that Python called from checks for signals.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;
use stickslip::dynamics::Interrupt;
use stickslip_model::file::{SettingError, System};

/// Interval at which a computation checks for interruptions.
pub(crate) const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// Callback for progress: the number of finished items, or a time.
pub(crate) type Report = Option<Py<PyAny>>;

/// A computation under way.
pub(crate) struct Task {
    interrupt: Arc<Interrupt>,
    done: AtomicUsize,
}

impl Task {
    /// Whether the computation must end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.interrupt.is_raised()
    }

    /// The flag that ends its orbits.
    pub(crate) fn interrupt(&self) -> Arc<Interrupt> {
        self.interrupt.clone()
    }

    /// Counts one more finished item.
    pub(crate) fn count(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Sets the number of finished items.
    pub(crate) fn set_done(&self, done: usize) {
        self.done.store(done, Ordering::Relaxed);
    }

    /// The system, with orbits that end when the task is stopped.
    pub(crate) fn system(&self, of: &System) -> Result<System, SettingError> {
        of.interrupted_by(self.interrupt.clone())
    }
}

/// Kind of progress that a computation reports.
#[derive(Clone, Copy)]
pub(crate) enum ProgressKind {
    Count,
    Time,
}

/// Result of a computation, and the exception that ended it early.
pub(crate) struct Outcome<T> {
    pub(crate) found: T,
    pub(crate) raised: Option<PyErr>,
}

impl<T, E> Outcome<(T, Result<(), E>)> {
    /// Results until the computation ended, and the exception that ended it early.
    pub(crate) fn partial(self, failed: impl FnOnce(E) -> PyErr) -> PyResult<(T, Option<PyErr>)> {
        let (found, ended) = self.found;
        match (self.raised, ended) {
            (None, Err(error)) => Err(failed(error)),
            (raised, _) => Ok((found, raised)),
        }
    }
}

impl<T, E> Outcome<Result<T, E>> {
    /// The result, of what an interruption left, and the exception that ended it early.
    pub(crate) fn kept(self, failed: impl FnOnce(E) -> PyErr) -> PyResult<(T, Option<PyErr>)> {
        match self.found {
            Ok(found) => Ok((found, self.raised)),
            Err(error) => Err(self.raised.unwrap_or_else(|| failed(error))),
        }
    }

    /// The result of a computation that returns nothing when interrupted.
    pub(crate) fn whole(self, failed: impl FnOnce(E) -> PyErr) -> PyResult<T> {
        match self.kept(failed)? {
            (found, None) => Ok(found),
            (_, Some(raised)) => Err(raised),
        }
    }
}

/// Checks for signals, and calls the progress callback.
pub(crate) fn check_signals(report: &Report, at: f64) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        match report {
            Some(report) => report.call1(py, (at,)).map(|_| ()),
            None => Ok(()),
        }
    })
}

/// Computes without the interpreter's lock, on as many threads as are given, 0 for all. The pool of
/// threads ends with the computation, so that a process can fork afterwards.
pub(crate) fn computed<T: Send>(
    py: Python<'_>,
    workers: usize,
    (report, kind): (&Report, ProgressKind),
    compute: impl FnOnce(&Task) -> T + Send,
) -> PyResult<Outcome<T>> {
    let task = Task {
        interrupt: Arc::new(match kind {
            ProgressKind::Time => Interrupt::with_time(),
            ProgressKind::Count => Interrupt::default(),
        }),
        done: AtomicUsize::new(0),
    };
    let builder = rayon::ThreadPoolBuilder::new().num_threads(workers);
    let pool = builder.build().map_err(|error| {
        pyo3::exceptions::PyRuntimeError::new_err(format!("cannot start threads: {error}"))
    })?;
    let mut raised = None;
    let outcome = py.detach(|| {
        std::thread::scope(|scope| {
            let task = &task;
            let (done, wait) = channel();
            let computation = scope.spawn(move || {
                let outcome = pool.install(|| compute(task));
                // The waiting thread also detects the end of this thread, so a failed message is
                // ignored.
                let _ = done.send(());
                outcome
            });
            while let Err(RecvTimeoutError::Timeout) = wait.recv_timeout(SIGNAL_INTERVAL) {
                let at = match kind {
                    ProgressKind::Time => task.interrupt.time(),
                    ProgressKind::Count => task.done.load(Ordering::Relaxed) as f64,
                };
                if raised.is_none()
                    && let Err(error) = check_signals(report, at)
                {
                    raised = Some(error);
                    task.interrupt.raise();
                }
            }
            computation.join()
        })
    });
    match outcome {
        Ok(found) => Ok(Outcome { found, raised }),
        // A panic of the computation continues in this call.
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

/// A computation with a defect, for the tests: it unwinds as a panic does.
#[pyfunction]
#[pyo3(name = "_unwind")]
pub(crate) fn unwind(py: Python<'_>) -> PyResult<()> {
    let report = (&None, ProgressKind::Count);
    let outcome = computed(py, 1, report, |_| -> PyResult<()> {
        std::panic::resume_unwind(Box::new("on purpose"))
    })?;
    outcome.whole(|error| error)
}
