//! The arithmetic of the Appendix's Listing 1, each of its defects a switch.
//!
//! The listing integrates the forced oscillator on a belt, Eq. (17),
//!
//! ```text
//! x1' = x2
//! x2' = (1/m)·(k2 z³ − k1 z − T(x2 − vp)),   z = x1 − A sin(ωt),   T(v) = μ0 sign(v)/(1 + |v|)
//! ```
//!
//! It is meant to use classical Runge–Kutta steps. A Hénon step (velocity as the independent
//! variable) is meant to end each slip phase on the line `x2 = vp`. What it computes differs,
//! mostly because a Python list is a reference. After `xn = x` both names denote the same list, and
//! every write to `xn` is a write to `x`. [`Defects`] lists the consequences and six other errors.
//! With [`Defects::AS_PRINTED`] the operations here are the listing's, in its order. Each defect
//! can be mended alone. A mended run is still the listing's method, not an event-exact one.
//!
//! Two parts of the listing have no counterpart here because no result depends on them. `hs` is a
//! second record of the step, assigned in every branch and never read; `r = 4` is unused. The lines
//! that save a state and increment `i` are missing in print. Both are assumed to run once per pass.
//!
//! A literal transcription into Python agrees with this module in every bit of all 633 001 steps.
//! That holds if both use the same sine, cosine and power. With those of [`stickslip::math`] the
//! states differ by less than 1e-15, and the four numbers of the settled motion are equal.
//!
//! ```
//! use replication::paper::listing::{run, Setup};
//!
//! let quick = Setup { h: 1e-3, ..Setup::default() };
//! let outcome = run(&quick);
//! println!("{:?}: {:?}", outcome.motion, outcome.stick_numbers());
//! ```

mod defects;
mod record;
mod regime;
mod setup;
mod step;

pub use defects::{Defect, Defects};
pub use record::{Crossing, Instant, Motion, Run, Sample, Stick, StickPhase, Zone, ZoneEnd};
pub(super) use record::{LEAST_COMPARED, pattern_begin};
pub use setup::{END, PRINTED_STEP, Setup};

use regime::Strobe;
use step::{Event, Machine};
use stickslip::Mode;

/// Runs the listing and keeps phases, crossings and the class of motion, but no trajectory. A
/// motion that escapes or breaks down is also a result: see [`Motion`].
pub fn run(setup: &Setup) -> Run {
    run_with(setup, |_| {})
}

/// Runs the listing and calls `observe` with every step's [`Sample`], in order, from the first
/// pass.
///
/// Samples are not stored. A plot keeps those whose `in_window` is set, thinned as needed.
pub fn run_with(setup: &Setup, mut observe: impl FnMut(&Sample)) -> Run {
    let last = setup.last_step();
    let first_in_window = setup.first_window_step();
    let mut machine = Machine::start(setup);
    let mut recorder = Recorder::new(setup, &machine);
    for i in 0..=last {
        let before = machine.instant().t;
        let event = machine.advance();
        if let Some(end) = machine.breakdown(before) {
            return recorder.finish(Some(end));
        }
        let sample = machine.sample(i, i >= first_in_window);
        recorder.take(&sample, event);
        observe(&sample);
    }
    recorder.finish(None)
}

/// Builds a [`Run`] from the passes of the loop. It keeps events and one sample per forcing period.
struct Recorder {
    run: Run,
    strobe: Strobe,
    after_exit: bool,
}

impl Recorder {
    fn new(setup: &Setup, machine: &Machine) -> Self {
        let sticks = machine.mode == Mode::Stick;
        let run = Run {
            phases: Vec::new(),
            unfinished: sticks.then(|| (machine.instant(), machine.zone)),
            crossings: Vec::new(),
            motion: Motion::NotSettled,
            forcing_period: setup.model.period(),
        };
        Recorder {
            run,
            strobe: Strobe::new(setup),
            after_exit: false,
        }
    }

    fn take(&mut self, sample: &Sample, event: Option<Event>) {
        let at = Instant {
            t: sample.t,
            x1: sample.x1,
        };
        match event {
            Some(Event::Entry(zone)) => self.run.unfinished = Some((at, zone)),
            Some(Event::Exit(end)) => {
                if let Some((entry, zone)) = self.run.unfinished.take() {
                    let stick = Stick { entry, exit: at };
                    self.run.phases.push(StickPhase { stick, zone, end });
                }
            }
            Some(Event::Crossing(to)) => self.run.crossings.push(Crossing {
                at,
                to,
                after_exit: self.after_exit,
            }),
            None => {}
        }
        self.after_exit = matches!(event, Some(Event::Exit(_)));
        self.strobe.take(sample);
    }

    /// The outcome. `end` says how the run broke off, if it did.
    fn finish(mut self, end: Option<Motion>) -> Run {
        let motion = end.unwrap_or_else(|| regime::classify(&self.run, &self.strobe));
        self.run.motion = motion;
        self.run
    }
}
