//! How far a program is: drawn on standard error, only if that is a terminal, and gone before anything is printed.

use std::time::Duration;

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

    /// One more is done.
    pub(crate) fn advance(&self) {
        self.0.inc(1);
    }

    /// Takes it off the terminal.
    pub(crate) fn clear(&self) {
        self.0.finish_and_clear();
    }
}
