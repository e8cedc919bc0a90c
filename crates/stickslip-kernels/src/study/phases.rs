//! The phases of a periodic orbit.

use std::ops::ControlFlow;

use stickslip::dynamics::{Modes, Phase};

use crate::kernel::Watcher;

/// The phases of a run over one period.
#[derive(Clone, Debug, Default)]
pub struct PhasesOfPeriod {
    /// The modes in order.
    modes: Vec<Modes>,
    /// Time in which any contact sticks.
    pub stick: f64,
}

impl PhasesOfPeriod {
    /// Those of a recorded period.
    pub fn of<'a>(phases: impl IntoIterator<Item = &'a Phase>) -> Self {
        let mut found = PhasesOfPeriod::default();
        phases.into_iter().for_each(|phase| found.add(phase));
        found
    }

    fn add(&mut self, phase: &Phase) {
        self.modes.push(phase.mode);
        if phase.mode.any_sticks() {
            self.stick += phase.duration();
        }
    }

    /// The modes as [`Modes::cycle`]. A run begins in the middle of a phase, and both parts of that
    /// phase count as one.
    pub fn cycle(mut self) -> Vec<Modes> {
        if let [first, .., last] = self.modes[..]
            && first.until(None) == last
        {
            self.modes.pop();
        }
        Modes::cycle(self.modes)
    }
}

impl Watcher for PhasesOfPeriod {
    fn phase(&mut self, phase: Phase) -> ControlFlow<()> {
        self.add(&phase);
        ControlFlow::Continue(())
    }
}
