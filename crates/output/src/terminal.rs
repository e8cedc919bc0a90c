//! Output of programs: results, errors and progress.

use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Prints a program's result, then what failed, if anything, as `error: …` on standard error.
///
/// The exit code is that of the failure, 1 if the result cannot be printed, and 0 otherwise.
pub fn finish(text: &str, failure: Option<(&dyn Display, u8)>) -> ExitCode {
    end_of_print(print(text), failure)
}

fn end_of_print(printed: io::Result<()>, failure: Option<(&dyn Display, u8)>) -> ExitCode {
    let failed = |error: &dyn Display, code: u8| {
        note(&format!("error: {error}"));
        ExitCode::from(code)
    };
    match (printed, failure) {
        (_, Some((failure, code))) => failed(failure, code),
        // The reader may close the pipe; the files have been written regardless.
        (Err(error), None) if error.kind() != io::ErrorKind::BrokenPipe => {
            failed(&format!("cannot print: {error}"), 1)
        }
        _ => ExitCode::SUCCESS,
    }
}

fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()
}

/// Prints a line on standard error. Errors are ignored: if standard error is closed, nobody reads
/// it.
pub fn note(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Computations that take longer than this show their progress.
const PROGRESS_DELAY: Duration = Duration::from_secs(2);

/// A progress bar on standard error, if that is a terminal. It appears after a delay.
pub struct DelayedProgressBar {
    begin: Instant,
    template: String,
    bar: OnceLock<ProgressBar>,
    counted: AtomicU64,
}

impl DelayedProgressBar {
    /// A bar with this template of [`ProgressStyle`].
    pub fn new(template: impl Into<String>) -> Self {
        DelayedProgressBar {
            begin: Instant::now(),
            template: template.into(),
            bar: OnceLock::new(),
            counted: AtomicU64::new(0),
        }
    }

    /// Reports that `done` of `all` is finished.
    pub fn done(&self, done: u64, all: u64) {
        if self.begin.elapsed() < PROGRESS_DELAY {
            return;
        }
        let bar = self.bar.get_or_init(|| {
            let bar = ProgressBar::new(all)
                .with_position(done)
                .with_elapsed(self.begin.elapsed());
            let style = ProgressStyle::with_template(&self.template);
            let bar = bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            // Work that was done before took no time here, so the remaining time is estimated from
            // this point.
            bar.tick();
            bar.reset_eta();
            bar.enable_steady_tick(Duration::from_secs(1));
            bar
        });
        bar.set_position(done);
    }

    /// Reports that one more of `all` is finished.
    pub fn one_more(&self, all: u64) {
        self.done(self.counted.fetch_add(1, Ordering::Relaxed) + 1, all);
    }

    /// Removes the bar from the terminal.
    pub fn clear(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

/// The status line of a computation of unknown length.
pub struct Status(ProgressBar);

impl Status {
    /// Sets the text of the line.
    pub fn set(&self, words: String) {
        self.0.set_message(words);
    }
}

/// Runs a computation of unknown length, with a spinner after a delay.
pub fn with_spinner<T: Send>(what: &str, work: impl FnOnce(&Status) -> T + Send) -> T {
    const TICK: Duration = Duration::from_millis(120);
    let status = Status(ProgressBar::new_spinner().with_message(what.to_owned()));
    status.0.set_draw_target(ProgressDrawTarget::hidden());
    std::thread::scope(|scope| {
        let (done, wait) = std::sync::mpsc::channel::<()>();
        let spinner = status.0.clone();
        scope.spawn(move || {
            // The end of the work closes the channel.
            if wait.recv_timeout(PROGRESS_DELAY) == Err(RecvTimeoutError::Timeout) {
                spinner.set_draw_target(ProgressDrawTarget::stderr());
                spinner.enable_steady_tick(TICK);
                let _ = wait.recv();
                spinner.finish_and_clear();
            }
        });
        let result = work(&status);
        drop(done);
        result
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn same(one: ExitCode, other: u8) {
        // Exit codes can be formatted but not compared.
        assert_eq!(format!("{one:?}"), format!("{:?}", ExitCode::from(other)));
    }

    #[test]
    fn the_exit_code_says_whether_something_failed() {
        same(finish("", None), 0);
        same(finish("", Some((&"no such thing", 1))), 1);
        same(finish("", Some((&"a wrong command line", 2))), 2);
    }

    #[test]
    fn a_reader_who_stops_reading_is_no_failure() {
        let of = |kind: io::ErrorKind| end_of_print(Err(kind.into()), None);
        same(of(io::ErrorKind::BrokenPipe), 0);
        same(of(io::ErrorKind::StorageFull), 1);
    }
}
