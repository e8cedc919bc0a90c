//! The long-term behaviour of an orbit of a periodically forced system.

use crate::dynamics::{
    AsDynamics, Components, Dynamics, Moment, OrbitProgress, Section, Summary, Vector,
};
use crate::error::Error;
use crate::filippov::Options;

/// The long-term behaviour from a start.
#[derive(Clone, Debug, PartialEq)]
pub enum Destination {
    /// A component passed the escape bound of the options.
    Escapes {
        /// Time of the escape.
        t: f64,
    },
    /// The states at whole forcing periods repeat.
    Periodic {
        /// Smallest number of forcing periods after which it closes.
        period: usize,
        /// Stick phases that end within one such pattern.
        sticks: usize,
        /// The last state at a whole forcing period.
        x: Vector,
    },
    /// Nothing repeats within eight forcing periods.
    Unsettled,
}

/// Longest pattern that is sought, in forcing periods: that of [`Destination::Unsettled`].
const LONGEST_PATTERN: usize = 8;

/// Follows the orbit from `(t0, x0)` over `periods` forcing periods of length `period` and
/// classifies its long-term behaviour. Two states one pattern apart count as equal if they differ
/// by at most `closeness` in every component.
///
/// The escape bound in `options` decides what counts as escaping.
///
/// # Errors
/// Those of [`crate::run`] except [`Error::Escaped`]; [`Error::NoUniqueFuture`] where Σ repels, and
/// at a two-fold.
pub fn destination<Kind>(
    system: &impl AsDynamics<Kind>,
    (t0, x0): (f64, impl Components),
    period: f64,
    periods: usize,
    closeness: f64,
    options: &Options,
) -> Result<Destination, Error> {
    let start = Moment {
        t: t0,
        x: x0.vector(),
    };
    let mut strobe = Strobe {
        t0,
        period,
        states: Vec::with_capacity(periods + 1),
        stick_ends: Vec::new(),
    };
    strobe.states.push(start.x.clone());
    // A little more than the last period, so that rounding cannot omit its end.
    let t_end = t0 + (periods as f64 + 1e-6) * period;
    match strobe.follow(&*system.dynamics(), &start, t_end, options) {
        Ok(summary) if summary.ending.is_final() => Err(summary.no_future_error()),
        Ok(_) => Ok(strobe.destination(closeness)),
        Err(Error::Escaped { t, .. }) => Ok(Destination::Escapes { t }),
        Err(error) => Err(error),
    }
}

/// States at whole forcing periods, and when stick phases ended.
struct Strobe {
    t0: f64,
    period: f64,
    states: Vec<Vector>,
    stick_ends: Vec<f64>,
}

impl Strobe {
    fn due(&self) -> f64 {
        self.t0 + self.states.len() as f64 * self.period
    }

    fn follow(
        &mut self,
        system: &dyn Dynamics,
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Summary, Error> {
        let mut orbit = system.begin(start, t_end, options, &Section::None)?;
        loop {
            match orbit.step()? {
                OrbitProgress::Step if self.due() <= orbit.t() => {
                    let solution = orbit.solution();
                    while self.due() <= orbit.t() {
                        self.states.push(solution(self.due()));
                    }
                }
                OrbitProgress::PhaseEnd(phase) if phase.mode.any_sticks() => {
                    self.stick_ends.push(phase.t_end);
                }
                OrbitProgress::End(summary) => return Ok(summary),
                _ => {}
            }
        }
    }

    fn destination(&self, closeness: f64) -> Destination {
        let states = &self.states;
        let repeats = |&p: &usize| {
            // Two repetitions, so that a coincidence does not count.
            states.len() > 2 * p
                && (0..p).all(|k| {
                    let last = states.len() - 1 - k;
                    (&states[last] - &states[last - p]).amax() <= closeness
                })
        };
        match (1..=LONGEST_PATTERN).find(repeats) {
            None => Destination::Unsettled,
            Some(period) => {
                let end = self.t0 + (states.len() - 1) as f64 * self.period;
                let from = end - period as f64 * self.period;
                let within = |t: &&f64| **t > from && **t <= end;
                Destination::Periodic {
                    period,
                    sticks: self.stick_ends.iter().filter(within).count(),
                    x: states[states.len() - 1].clone(),
                }
            }
        }
    }
}
