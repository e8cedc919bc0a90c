//! What the program does on a terminal: the only place that prints, decides on an exit code and draws how far it is.

use std::cell::OnceCell;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::commands::Failure;

/// Prints what the program has to say, or its error.
///
/// Exit code 0 on success, 1 if something failed (`error: …` on standard error), 2 for a wrong command line or file.
pub(crate) fn finish(outcome: Result<Said, Failure>) -> ExitCode {
    match outcome {
        Ok(said) => {
            let printed = print(&said.text);
            if let Some(failure) = &said.failure {
                note(&format!("error: {failure}"));
                return ExitCode::FAILURE;
            }
            match printed {
                Ok(()) => ExitCode::SUCCESS,
                // Whoever reads may stop reading; files are written all the same.
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
                Err(error) => {
                    note(&format!("error: cannot print: {error}"));
                    ExitCode::FAILURE
                }
            }
        }
        Err(failure) => {
            note(&format!("error: {failure}"));
            ExitCode::from(if failure.is_usage() { 2 } else { 1 })
        }
    }
}

/// What a command has to say at its end.
pub(crate) struct Said {
    /// For standard output.
    pub text: String,
    /// What went wrong behind what was found all the same.
    pub failure: Option<String>,
}

fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()
}

/// A line on standard error; where nobody reads it any more, nothing is lost with it.
pub(crate) fn note(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Only computations longer than this show how far they are.
const PATIENCE: Duration = Duration::from_secs(2);

/// Steps of the bar.
const FINENESS: u64 = 1000;

/// How far a computation is: drawn on standard error, if that is a terminal, once it has taken a while.
pub(crate) struct Patience {
    begin: Instant,
    what: &'static str,
    bar: OnceCell<ProgressBar>,
}

impl Patience {
    pub(crate) fn new(what: &'static str) -> Self {
        Patience {
            begin: Instant::now(),
            what,
            bar: OnceCell::new(),
        }
    }

    /// So much is done, between 0 and 1.
    pub(crate) fn done(&self, part: f64) {
        if self.begin.elapsed() >= PATIENCE {
            let bar = self.bar.get_or_init(|| {
                let bar = ProgressBar::new(FINENESS).with_message(self.what);
                match ProgressStyle::with_template("{msg} {bar:40} {percent} %, {eta} to go") {
                    Ok(style) => bar.with_style(style),
                    Err(_) => bar,
                }
            });
            bar.set_position((part.clamp(0.0, 1.0) * FINENESS as f64) as u64);
        }
    }

    /// Takes it off the terminal.
    pub(crate) fn clear(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

/// What is told of a computation that cannot say how far it is.
pub(crate) struct Telling(Mutex<String>);

impl Telling {
    /// Tells this from now on.
    pub(crate) fn tell(&self, words: String) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = words;
    }

    fn told(&self) -> String {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

/// Runs what cannot say how far it is, under something that moves once it has taken a while.
pub(crate) fn patiently<T: Send>(what: &str, work: impl FnOnce(&Telling) -> T + Send) -> T {
    const TICK: Duration = Duration::from_millis(120);
    let telling = Telling(Mutex::new(what.to_owned()));
    std::thread::scope(|scope| {
        let (done, wait) = std::sync::mpsc::channel::<()>();
        let telling = &telling;
        scope.spawn(move || {
            // The end of the work closes the channel.
            if wait.recv_timeout(PATIENCE) != Err(RecvTimeoutError::Timeout) {
                return;
            }
            let spinner = ProgressBar::new_spinner();
            while wait.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                spinner.set_message(telling.told());
                spinner.tick();
            }
            spinner.finish_and_clear();
        });
        let result = work(telling);
        drop(done);
        result
    })
}
