//! The class of the motion a run settled on.

use std::fmt;

use super::{Run, Sample, Setup};

/// The motion a run settled on, decided from the run itself.
///
/// The states at whole multiples of the forcing period are compared: a pattern of `p` periods has
/// repeated when, over the last `max(2p, 6)` of them, each is within twenty steps' way (`20·h`, in
/// metres and metres per second) of the one `p` periods earlier. The steps do not fit the forcing
/// period, so a periodic motion is met with an error of some steps' way and no closer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Motion {
    /// Periodic with stick phases.
    StickSlip {
        /// Stick phases in one pattern.
        sticks: usize,
        /// Length of the pattern in forcing periods, the smallest that repeats.
        period: usize,
    },
    /// Periodic, without stick.
    SlipOnly {
        /// Length of the pattern in forcing periods, the smallest that repeats.
        period: usize,
    },
    /// The clock stands: over the second half of the passes it gained less than a tenth of what its
    /// steps give, because the corrections at the ends of stick and slip phases take back what the
    /// steps add.
    Stalled {
        /// Where it stands, in seconds.
        t: f64,
    },
    /// The body went so far out that the softening spring drives it away for good.
    Escaped {
        /// When, in seconds.
        t: f64,
    },
    /// The state stopped being a number: a Hénon step divided by an acceleration of zero.
    BrokenDown {
        /// The last time with a state, in seconds.
        t: f64,
    },
    /// No pattern of up to [`Motion::LONGEST_PATTERN`] forcing periods repeats at the end of the
    /// run.
    NotSettled,
}

impl fmt::Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Motion::StickSlip { sticks, period } => {
                let plural = if *period == 1 { "" } else { "s" };
                write!(
                    f,
                    "stick–slip, {sticks} stick phases in {period} forcing period{plural}"
                )
            }
            Motion::SlipOnly { period } => write!(f, "slip only, period {period}"),
            Motion::Stalled { t } => write!(f, "hangs: the clock stands at {t:.4} s"),
            Motion::Escaped { t } => write!(f, "escapes at {t:.4} s"),
            Motion::BrokenDown { t } => write!(f, "breaks down at {t:.4} s"),
            Motion::NotSettled => f.write_str("no pattern repeats"),
        }
    }
}

impl Motion {
    /// Patterns longer than this many forcing periods are not looked for: the paper's run has 38
    /// periods.
    pub const LONGEST_PATTERN: usize = 8;

    /// What Sect. 4.2 says of Fig. 8: two stick phases in two forcing periods.
    pub const PUBLISHED: Motion = Motion::StickSlip {
        sticks: 2,
        period: 2,
    };
}

/// How closely a pattern has to repeat, in steps.
const TOLERANCE_STEPS: f64 = 20.0;
/// States compared at least before a pattern counts as repeating.
const LEAST_COMPARED: usize = 6;
/// A clock that gains less than this part of its steps stands.
const STALLED_RATE: f64 = 0.1;

/// The states at whole multiples of the forcing period, and how the clock fares.
pub(super) struct Strobe {
    h: f64,
    period: f64,
    middle: u64,
    next: f64,
    at_middle: Option<Sample>,
    last: Option<Sample>,
    states: Vec<[f64; 2]>,
}

impl Strobe {
    pub(super) fn new(setup: &Setup) -> Self {
        let period = setup.params.period();
        Strobe {
            h: setup.h,
            period,
            middle: setup.last_step() / 2,
            next: (setup.params.t0 / period).ceil(),
            at_middle: None,
            last: None,
            states: Vec::new(),
        }
    }

    pub(super) fn take(&mut self, sample: &Sample) {
        let due = self.next * self.period;
        if let Some(last) = self.last
            && sample.t >= due
        {
            let span = sample.t - last.t;
            let part = if span > 0.0 {
                (due - last.t) / span
            } else {
                1.0
            };
            let between = |from: f64, to: f64| from + part * (to - from);
            let state = [between(last.x1, sample.x1), between(last.x2, sample.x2)];
            self.states.push(state);
            self.next += 1.0;
        }
        if sample.step == self.middle {
            self.at_middle = Some(*sample);
        }
        self.last = Some(*sample);
    }

    /// The smallest number of forcing periods after which the states repeat.
    fn pattern(&self) -> Option<usize> {
        let tolerance = TOLERANCE_STEPS * self.h;
        let same = |(later, earlier): (&[f64; 2], &[f64; 2])| {
            let mut pairs = later.iter().zip(earlier);
            pairs.all(|(later, earlier)| (later - earlier).abs() <= tolerance)
        };
        (1..=Motion::LONGEST_PATTERN).find(|&p| {
            let compared = (2 * p).max(LEAST_COMPARED);
            let states = self.states.iter().rev();
            let mut pairs = states.clone().zip(states.skip(p)).take(compared);
            self.states.len() >= compared + p && pairs.all(same)
        })
    }

    fn stalled(&self) -> Option<f64> {
        let (middle, last) = (self.at_middle?, self.last?);
        let due = (last.step - middle.step) as f64 * self.h;
        (last.t - middle.t < STALLED_RATE * due).then_some(last.t)
    }
}

/// The class of a run that came to its end.
pub(super) fn classify(run: &Run, strobe: &Strobe) -> Motion {
    if let Some(t) = strobe.stalled() {
        return Motion::Stalled { t };
    }
    let (Some(period), Some(end)) = (strobe.pattern(), strobe.last) else {
        return Motion::NotSettled;
    };
    // A pattern with stick ends a phase in every `period` forcing periods; half a one is for the
    // jitter.
    let oldest = end.t - (period as f64 + 0.5) * strobe.period;
    if run
        .phases
        .last()
        .is_some_and(|phase| phase.stick.exit.t > oldest)
    {
        Motion::StickSlip {
            sticks: run.phases_in_last(period).len(),
            period,
        }
    } else {
        Motion::SlipOnly { period }
    }
}
