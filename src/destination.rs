//! The long-term behaviour of an orbit of a periodically forced system.

use stickslip::dynamics::{
    AsDynamics, Components, Dynamics, Moment, OrbitProgress, Summary, Vector,
};
use stickslip::error::Point;
use stickslip::{Ending, Error, Options};

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
/// Those of [`stickslip::run`] except [`Error::Escaped`]; [`Error::NoUniqueFuture`] where Σ repels,
/// and at a two-fold.
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
        Ok(Summary { ending, t, x, .. }) if ending.is_final() => {
            let x = Point(x.iter().copied().collect());
            Err(match ending {
                Ending::Shrunk => Error::Shrunk { t, x },
                _ => Error::NoUniqueFuture { t, x },
            })
        }
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
        let mut orbit = system.begin(start, t_end, options, &[])?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use stickslip::analysis::PeriodicOrbit;
    use stickslip::{Filippov, Scalar, Side, solve};

    enum Tested {
        /// `x'' = -x - S sgn x' + cos Ωt`. Den Hartog (1930) gives the amplitude without stick.
        DenHartog { frequency: f64, friction: f64 },
        /// `x' = -a sgn(x - sin t)`, which sticks to its boundary while `|cos t| < a`.
        MovingLine { a: f64 },
        /// Both fields lead away from the boundary.
        Apart,
    }

    impl Filippov<2> for Tested {
        fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
            let none = T::constant(0.0);
            match *self {
                Tested::DenHartog {
                    frequency,
                    friction,
                } => [x[1], (t * frequency).cos() - friction * side.sign() - x[0]],
                Tested::MovingLine { a } => [T::constant(-a * side.sign()), none],
                Tested::Apart => [T::constant(side.sign()), none],
            }
        }
        fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
            match self {
                Tested::DenHartog { .. } => x[1],
                Tested::MovingLine { .. } => x[0] - t.sin(),
                Tested::Apart => x[0],
            }
        }
    }

    #[test]
    fn a_forced_orbit_comes_to_den_hartog_s_in_one_period() {
        let frequency = 0.7;
        let system = Tested::DenHartog {
            frequency,
            friction: 0.2,
        };
        let period = 2.0 * PI / frequency;
        let options = Options::tol(1e-12);
        // The start is not at time zero: the compared states are whole periods after it.
        let t0 = 0.3;
        let found = destination(&system, (t0, [1.0, 0.0]), period, 200, 1e-6, &options).unwrap();
        let Destination::Periodic {
            period: 1,
            sticks: 0,
            x,
        } = found
        else {
            panic!("{found:?}");
        };
        let cycle = PeriodicOrbit::near_forced(&system, t0, &x, period, &options).unwrap();
        assert!((&cycle.x - &x).amax() < 1e-5, "{} {x}", cycle.x);
        let turn = solve(&system, t0, [x[0], x[1]], t0 + period, &options).unwrap();
        for turned in &turn.transitions {
            assert!((turned.x[0].abs() - 1.927_774_517_9).abs() < 1e-4);
        }
    }

    #[test]
    fn sticks_within_one_pattern_are_counted_and_repelling_has_no_destination() {
        // It sticks to the line while |cos t| < 0.9 and is released after each turn of it, twice in
        // a period.
        let line = Tested::MovingLine { a: 0.9 };
        let (start, period, options) = ((0.3, [0.1, 0.0]), 2.0 * PI, Options::default());
        let found = destination(&line, start, period, 12, 1e-9, &options).unwrap();
        let Destination::Periodic {
            period: 1,
            sticks: 2,
            ..
        } = found
        else {
            panic!("{found:?}");
        };
        let start = (2.0, [0.0, 0.0]);
        let error = destination(&Tested::Apart, start, 1.0, 12, 1e-9, &options).unwrap_err();
        assert!(
            matches!(error, Error::NoUniqueFuture { t: 2.0, .. }),
            "{error}"
        );
    }
}
