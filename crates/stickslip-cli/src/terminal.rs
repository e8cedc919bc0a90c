//! Terminal output. Only this module prints, sets the exit code and shows progress.

use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::OnceLock;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::failure::Failure;
use crate::render::CommandOutput;

/// Prints the output of the program, or its error.
///
/// Exit code 0 on success, 1 if something failed (`error: …` on standard error), 2 for a wrong
/// command line or file of a system.
pub(crate) fn finish(outcome: Result<CommandOutput, Failure>) -> ExitCode {
    let failed = |error: &dyn std::fmt::Display, code: u8| {
        note(&format!("error: {error}"));
        ExitCode::from(code)
    };
    let answer = match outcome {
        Ok(answer) => answer,
        Err(failure) => return failed(&failure, if failure.is_usage() { 2 } else { 1 }),
    };
    match (print(&answer.text), &answer.failure) {
        (_, Some(failure)) => failed(failure, 1),
        // The reader may close the pipe; the files have been written regardless.
        (Err(error), _) if error.kind() != io::ErrorKind::BrokenPipe => {
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
pub(crate) fn note(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Computations that take longer than this show their progress.
const PROGRESS_DELAY: Duration = Duration::from_secs(2);

/// A progress bar on standard error, if that is a terminal. It appears after [`PROGRESS_DELAY`].
pub(crate) struct DelayedProgressBar {
    begin: Instant,
    template: String,
    bar: OnceLock<ProgressBar>,
}

impl DelayedProgressBar {
    /// A bar with this template of [`ProgressStyle`].
    pub(crate) fn new(template: impl Into<String>) -> Self {
        DelayedProgressBar {
            begin: Instant::now(),
            template: template.into(),
            bar: OnceLock::new(),
        }
    }

    /// Reports that `done` of `all` is finished.
    pub(crate) fn done(&self, done: u64, all: u64) {
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

    /// Removes the bar from the terminal.
    pub(crate) fn clear(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

/// The status line of a computation of unknown length.
pub(crate) struct Status(ProgressBar);

impl Status {
    /// Sets the text of the line.
    pub(crate) fn set(&self, words: String) {
        self.0.set_message(words);
    }
}

/// Runs a computation of unknown length, with a spinner after [`PROGRESS_DELAY`].
pub(crate) fn with_spinner<T: Send>(what: &str, work: impl FnOnce(&Status) -> T + Send) -> T {
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
