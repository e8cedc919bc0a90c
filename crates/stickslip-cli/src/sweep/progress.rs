//! How far a sweep is and how long it will take: drawn on standard error, only if that is a terminal, and only if it takes a while.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Only sweeps longer than this show how far they are.
const PATIENCE: Duration = Duration::from_secs(2);

/// What is drawn while a sweep is computed.
#[derive(Debug)]
pub struct Progress {
    begin: Instant,
    bar: OnceLock<ProgressBar>,
}

impl Progress {
    /// Begins to count the time.
    pub fn begin() -> Self {
        Self {
            begin: Instant::now(),
            bar: OnceLock::new(),
        }
    }

    /// So many of all blocks are done.
    pub fn set(&self, done: usize, all: usize) {
        if self.begin.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_init(|| {
            let bar = ProgressBar::new(all as u64)
                .with_position(done as u64)
                .with_elapsed(self.begin.elapsed());
            let template = "{bar:40} {pos}/{len} blocks, {elapsed} gone, {eta} to go";
            let bar = match ProgressStyle::with_template(template) {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            };
            // Blocks that were on disk before took no time: the time to come is reckoned from here on.
            bar.tick();
            bar.reset_eta();
            bar.enable_steady_tick(Duration::from_secs(1));
            bar
        });
        bar.set_position(done as u64);
    }

    /// Takes it off the terminal.
    pub fn clear(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}
