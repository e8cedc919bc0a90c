//! Classification of the motion that a run settled on.

use super::record::{LEAST_COMPARED, Motion, Run, Sample};
use super::setup::Setup;

/// Tolerance for a repeating pattern, in steps. The steps do not divide the forcing period, so a
/// periodic motion repeats only to within the travel of some steps.
const TOLERANCE_STEPS: f64 = 20.0;
/// A clock that advances by less than this fraction of its steps is stalled. A running clock
/// advances by most of them.
const STALLED_RATE: f64 = 0.1;

/// The states at whole multiples of the forcing period, and the progress of the clock.
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
        let period = setup.model.period();
        Strobe {
            h: setup.h,
            period,
            middle: setup.last_step() / 2,
            next: (setup.start[0] / period).ceil(),
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

/// The class of a complete run.
pub(super) fn classify(run: &Run, strobe: &Strobe) -> Motion {
    if let Some(t) = strobe.stalled() {
        return Motion::Stalled { t };
    }
    let (Some(period), Some(end)) = (strobe.pattern(), strobe.last) else {
        return Motion::NotSettled;
    };
    // A pattern with stick ends a phase in every `period` forcing periods. Half a period more
    // allows for jitter.
    let oldest = end.t - (period as f64 + 0.5) * strobe.period;
    match run.phases.last() {
        Some(last) if last.stick.exit.t > oldest => Motion::StickSlip {
            sticks: run.phases_in_last(period).len(),
            period,
        },
        _ => Motion::SlipOnly { period },
    }
}
