//! How far a program is: drawn on standard error, only if that is a terminal, and gone before anything is printed.

use std::cell::OnceCell;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// What is drawn while a program computes.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// Something that moves, with a message, where nothing can be counted.
    pub(crate) fn spinner(message: String) -> Self {
        Self(ProgressBar::new_spinner().with_message(message)).ticking(Duration::from_millis(120))
    }

    /// A bar for a count from `done` to `total`, followed by `text`, in which the drawing library's placeholders can be used.
    pub(crate) fn bar(done: usize, total: usize, text: &str) -> Self {
        let bar = ProgressBar::new(total as u64).with_position(done as u64);
        Self(
            match ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}}{text}")) {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            },
        )
    }

    /// Draws anew in such intervals, also if nothing is counted, so that the time shown goes on.
    pub(crate) fn ticking(self, interval: Duration) -> Self {
        self.0.enable_steady_tick(interval);
        self
    }

    /// The count is `done`.
    pub(crate) fn set(&self, done: usize) {
        self.0.set_position(done as u64);
    }

    /// One more is done.
    pub(crate) fn advance(&self) {
        self.0.inc(1);
    }

    /// Takes it off the terminal.
    pub(crate) fn clear(&self) {
        self.0.finish_and_clear();
    }
}

/// Only computations longer than this show how far they are.
const PATIENCE: Duration = Duration::from_secs(2);

/// Runs `work` with a report of what is done and of how much, that shows up as a bar once it has taken a while.
pub(crate) fn patiently<T>(text: &str, work: impl FnOnce(&dyn Fn(usize, usize)) -> T) -> T {
    let begin = Instant::now();
    let shown: OnceCell<Progress> = OnceCell::new();
    let outcome = work(&|done, total| {
        if begin.elapsed() >= PATIENCE {
            shown
                .get_or_init(|| Progress::bar(0, total, text))
                .set(done);
        }
    });
    if let Some(bar) = shown.get() {
        bar.clear();
    }
    outcome
}
