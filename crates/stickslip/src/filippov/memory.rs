//! Memory of a run between two steps: enough to go on with the same bits.

use super::integration::{Due, Integration};
use super::options::Options;
use super::pile_up::{PileUpDetector, PileUpMemory};
use super::stepper::Stepper;
use super::switched::Switched;
use crate::dynamics::{Modes, Vector};
use crate::error::Error;
use crate::ode::Timed;
use crate::system::State;

/// A run between two steps.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct StepMemory {
    t: f64,
    x: Vector,
    t_remainder: f64,
    x_remainder: Vector,
    /// Length of the next step to try; 0 if it is to be chosen.
    h: f64,
    tie_step: f64,
    phase_t: f64,
    phase_x: Vector,
    modes: Modes,
    branch: f64,
    orders: Vec<usize>,
    pile_up: PileUpMemory,
}

fn vector<const N: usize>(x: &State<N>) -> Vector {
    Vector::from_column_slice(x.as_slice())
}

/// A state; `None` if the number of components is another one.
pub(crate) fn state<const N: usize>(x: &Vector) -> Option<State<N>> {
    (x.len() == N).then(|| State::from_column_slice(x.as_slice()))
}

impl<'a, S: Switched<N, G>, const N: usize, const G: usize> Integration<'a, S, N, G> {
    /// Waits once before the first step that this end of the run shortens.
    pub(crate) fn wait_before(&mut self, t_end: f64) {
        self.run.waits_before = Some(t_end);
    }

    /// Whether it waits there. Asked again, it goes on.
    pub(crate) fn is_before_end(&mut self) -> bool {
        std::mem::take(&mut self.is_before_end)
    }

    /// The run before its next step.
    pub(crate) fn memory(&self) -> StepMemory {
        let run = &self.run;
        let nothing = Timed {
            t: 0.0,
            x: State::zeros(),
        };
        let (h, remainder, tie_step) = match &self.stepper {
            Stepper::Taylor(series) => series.memory(),
            Stepper::Dop853(_) | Stepper::Rk4(_) => (run.h, &nothing, 0.0),
        };
        StepMemory {
            t: run.at.t,
            x: vector(&run.at.x),
            t_remainder: remainder.t,
            x_remainder: vector(&remainder.x),
            // The first step follows from the length of the run.
            h: match run.counters.steps == 0 && !self.is_resumed {
                true => 0.0,
                false => h,
            },
            tie_step,
            phase_t: run.from.t,
            phase_x: vector(&run.from.x),
            modes: Modes::new(S::of_contacts(&self.mode)),
            branch: self.branch.into(),
            orders: run.orders.to_vec(),
            pile_up: self.pile_up.memory(),
        }
    }

    /// Goes on from a memory of the same system with the same options; `None` if it is of another.
    ///
    /// # Errors
    /// Those of [`Integration::new`].
    pub(crate) fn resumed(
        system: &'a S,
        memory: &StepMemory,
        t_end: f64,
        options: &Options,
    ) -> Option<Result<Self, Error>> {
        let [x, from, remainder] =
            [&memory.x, &memory.phase_x, &memory.x_remainder].map(state::<N>);
        let at = Timed { t: memory.t, x: x? };
        let from = Timed {
            t: memory.phase_t,
            x: from?,
        };
        let remainder = Timed {
            t: memory.t_remainder,
            x: remainder?,
        };
        let orders: [usize; G] = memory.orders.as_slice().try_into().ok()?;
        let mode = S::restored(memory.modes);
        let pile_up = PileUpDetector::restored(&memory.pile_up, S::restored, S::of_contacts)?;
        Some(
            Self::new_in(system, (mode, &at), at, t_end, options).map(|begun| {
                let mut resumed = begun;
                resumed.branch = S::restored_branch(memory.branch);
                (resumed.run.h, resumed.run.from, resumed.run.orders) = (memory.h, from, orders);
                (resumed.pile_up, resumed.is_resumed) = (pile_up, memory.h > 0.0);
                // The state lies on the manifold of its mode already.
                resumed.due = Due::Step;
                if let Stepper::Taylor(series) = &mut resumed.stepper {
                    series.restore(&at, (memory.h, remainder, memory.tie_step));
                }
                resumed
            }),
        )
    }
}
