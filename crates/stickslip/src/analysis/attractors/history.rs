//! The last phases and transitions of an orbit.

use std::collections::VecDeque;

use super::recurrence::Counts;
use crate::dynamics::{Modes, Phase, Transition};
use crate::filippov::TransitionKind;

/// The most recent elements that fit, and how many there have been in all.
pub(super) struct History {
    phases: VecDeque<Phase>,
    transitions: VecDeque<(TransitionKind, usize)>,
    most: usize,
    counts: Counts,
}

impl History {
    /// A history with room for so many of each.
    pub fn of(most: usize) -> Self {
        History {
            phases: VecDeque::new(),
            transitions: VecDeque::new(),
            most,
            counts: Counts::default(),
        }
    }

    pub fn counts(&self) -> Counts {
        self.counts
    }

    pub fn phase(&mut self, phase: Phase) {
        push(&mut self.phases, phase, self.most);
        self.counts.phases += 1;
    }

    pub fn transition(&mut self, at: &Transition) {
        push(&mut self.transitions, (at.kind, at.contact), self.most);
        self.counts.transitions += 1;
    }

    pub fn last_phase(&self) -> Option<&Phase> {
        self.phases.back()
    }

    /// The modes of the last four phases, the latest first.
    pub fn last_modes(&self) -> impl Iterator<Item = Modes> {
        self.phases.iter().rev().take(4).map(|phase| phase.mode)
    }

    /// Keeps what lies between two counts; the second is the present one.
    pub fn keep(&mut self, (from, to): &(Counts, Counts)) {
        keep_last(&mut self.phases, to.phases - from.phases);
        keep_last(&mut self.transitions, to.transitions - from.transitions);
    }

    /// Fraction of the duration of the phases that is spent in stick; none without phases.
    pub fn in_stick(&self) -> Option<f64> {
        let (mut total, mut in_stick) = (0.0, 0.0);
        for phase in &self.phases {
            total += phase.duration();
            if phase.mode.any_sticks() {
                in_stick += phase.duration();
            }
        }
        (total > 0.0).then_some(in_stick / total)
    }

    /// Takes the phases and transitions out.
    pub fn take(&mut self) -> (Vec<Phase>, Vec<(TransitionKind, usize)>) {
        let phases = std::mem::take(&mut self.phases);
        (exact(phases), exact(std::mem::take(&mut self.transitions)))
    }
}

/// Allocates no spare room: thousands of starts hold theirs at the same time.
fn exact<T>(of: VecDeque<T>) -> Vec<T> {
    let mut all = Vec::from(of);
    all.shrink_to_fit();
    all
}

/// Appends one, and drops the oldest where there are too many.
fn push<T>(into: &mut VecDeque<T>, one: T, most: usize) {
    if into.len() == most {
        into.pop_front();
    }
    into.push_back(one);
}

fn keep_last<T>(of: &mut VecDeque<T>, count: u64) {
    let too_many = of.len().saturating_sub(count as usize);
    of.drain(..too_many);
}
