//! Branches of periodic orbits along a parameter, in the time and the states of the system's file.

use std::f64::consts::TAU;

use stickslip::analysis::{
    Branch, BranchPoint, CycleBifurcation, PeriodicOrbit, SpecialPoint, Stop,
};
use stickslip::dynamics::{DynamicsRef, Section, Summary, Vector};
use stickslip::{Ending, Error, Options};

use super::Extremes;
use crate::file::{SettingError, System};
use crate::kernel::{Run, Watcher, follow};

/// A system along one of its parameters. In the time of [`Along::dynamics`], a period that depends
/// on the parameter is constant.
pub struct Along<'a> {
    system: &'a System,
    /// Number of the parameter.
    pub number: usize,
    name: &'a str,
    range: (f64, f64),
    /// Present value of the parameter.
    pub value: f64,
    /// The system with the parameter as a last state.
    pub dynamics: DynamicsRef<'static>,
}

/// An orbit of a branch.
pub struct BranchOrbit {
    /// The orbit.
    pub orbit: BranchPoint,
    /// Minimum and maximum of each state on the orbit.
    pub extremes: Vec<(f64, f64)>,
}

/// A branch in one direction, with minimum and maximum of each state on each orbit.
pub type DirectedBranch = (Branch, Vec<Vec<(f64, f64)>>);

/// A branch in both directions, from its lower to its upper end.
pub struct WholeBranch {
    /// The orbits.
    pub points: Vec<BranchOrbit>,
    /// The special orbits, in the same order.
    pub special: Vec<SpecialPoint>,
    /// Index of the orbit from which the branch was started.
    pub first: usize,
    /// Why the branch ends, downwards and upwards.
    pub stops: [Stop; 2],
}

impl<'a> Along<'a> {
    /// A system along the named parameter, in a range.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown parameter, or if the system cannot be evaluated at an end of
    /// the range.
    pub fn new(system: &'a System, name: &'a str, range: (f64, f64)) -> Result<Self, SettingError> {
        let range = (range.0.min(range.1), range.0.max(range.1));
        let number = system.file.parameter(name)?;
        for end in [range.0, range.1] {
            system.with_values(&[(name, end)])?;
        }
        Ok(Along {
            system,
            number,
            name,
            range,
            value: system.values[number],
            dynamics: system.along(number)?,
        })
    }

    /// A state of the orbit at a multiple of its period, where the time of the branch begins.
    ///
    /// # Errors
    /// [`Error::NotFound`] if the orbit of a driven system rests, since steps along the branch are
    /// measured by its size; those of [`stickslip::run`].
    pub fn at_zero(&self, orbit: &PeriodicOrbit, options: &Options) -> Result<Vector, Error> {
        let behind = orbit.t.rem_euclid(orbit.period);
        let t_end = orbit.t + (orbit.period - behind);
        // By rounding, the remainder may be a whole period or zero.
        if !self.system.built.depends_on_time || behind == 0.0 || t_end <= orbit.t {
            return Ok(orbit.x.clone());
        }
        let run = Run {
            t: orbit.t,
            x: orbit.x.as_slice(),
            t_end,
            options,
        };
        let ended = follow_period(self.system, &run, orbit.period, &mut ())?;
        Ok(ended.x)
    }

    /// Minimum and maximum of each state along an orbit of the branch.
    ///
    /// # Errors
    /// Those of [`stickslip::run`] and of the parameter.
    pub fn extremes<E: From<Error> + From<SettingError>>(
        &self,
        orbit: &BranchPoint,
        options: &Options,
    ) -> Result<Vec<(f64, f64)>, E> {
        let orbit = self.in_file(orbit.clone())?;
        let system = self.system.with_values(&[(self.name, orbit.parameter)])?;
        let once = Run {
            t: orbit.t,
            x: orbit.x.as_slice(),
            t_end: orbit.t + orbit.period,
            options,
        };
        let mut extremes = Extremes::from(once.x);
        follow_period(&system, &once, orbit.period, &mut extremes)?;
        Ok(extremes.ranges())
    }

    /// Joins both directions, each with the extremes of its orbits.
    ///
    /// # Errors
    /// Those of the parameter.
    pub fn joined(
        &self,
        [(down, low), (up, high)]: [DirectedBranch; 2],
    ) -> Result<WholeBranch, SettingError> {
        // Both directions contain the first orbit.
        let first = down.points.len().saturating_sub(1);
        let below = down.points.into_iter().zip(low).skip(1).rev();
        let points = below.chain(up.points.into_iter().zip(high));
        let points = points.map(|(orbit, extremes)| {
            let orbit = self.in_file(orbit)?;
            Ok(BranchOrbit { orbit, extremes })
        });
        let below = down.special.into_iter().rev().map(|mut at| {
            at.behind = (first + 1).saturating_sub(at.behind);
            if let CycleBifurcation::Sequence(change) = &mut at.what {
                std::mem::swap(&mut change.before, &mut change.after);
            }
            at
        });
        let above = up.special.into_iter().map(|at| SpecialPoint {
            behind: at.behind + first,
            ..at
        });
        let special = below.chain(above).map(|mut at| {
            at.parameter = self.within(at.parameter);
            let pace = self.pace(&[(self.name, at.parameter)])?;
            at.period *= pace;
            at.x = self.states_of(&at.x);
            if let CycleBifurcation::Sequence(change) = &mut at.what {
                change.period *= pace;
                change.x = self.states_of(&change.x);
            }
            Ok(at)
        });
        Ok(WholeBranch {
            points: points.collect::<Result<_, SettingError>>()?,
            special: special.collect::<Result<_, SettingError>>()?,
            first,
            stops: [down.stop, up.stop],
        })
    }

    /// Ratio of the time of the file to the time of the branch, at values of parameters.
    ///
    /// # Errors
    /// Those of the parameters.
    pub fn pace(&self, values: &[(&str, f64)]) -> Result<f64, SettingError> {
        let Some(here) = self.system.built.period else {
            return Ok(1.0);
        };
        let there = self.system.with_values(values)?;
        Ok(there.built.period.map_or(1.0, |there| there / here))
    }

    fn in_file(&self, orbit: BranchPoint) -> Result<BranchPoint, SettingError> {
        let parameter = self.within(orbit.parameter);
        let pace = self.pace(&[(self.name, parameter)])?;
        Ok(BranchPoint {
            parameter,
            t: orbit.t * pace,
            x: self.states_of(&orbit.x),
            period: orbit.period * pace,
            ..orbit
        })
    }

    /// Newton's iteration reaches the ends of the range only up to rounding.
    fn within(&self, parameter: f64) -> f64 {
        parameter.clamp(self.range.0, self.range.1)
    }

    /// The states of the system, without the parameter that follows them.
    fn states_of(&self, x: &Vector) -> Vector {
        x.rows(0, self.system.states()).into_owned()
    }
}

/// A closed branch is the same in the other direction, of which only the first orbit is kept.
pub fn only_once(down: &mut Branch, up: &mut Branch) {
    let same = match (&down.stop, &up.stop) {
        (Stop::Closed, _) => up,
        (_, Stop::Closed) => down,
        _ => return,
    };
    same.points.truncate(1);
    same.special.clear();
    same.stop = Stop::Closed;
}

/// Follows an orbit to the end of its period.
fn follow_period(
    system: &System,
    run: &Run<'_>,
    period: f64,
    watcher: &mut dyn Watcher,
) -> Result<Summary, Error> {
    let ended = follow(system.dynamics(), run, &Section::None, watcher)?;
    match ended.ending {
        Ending::EndTime => Ok(ended),
        _ => Err(Error::NotFound {
            what: "the end of the period",
            t: ended.t,
            span: period,
        }),
    }
}

/// The end of a branch, for programs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BranchEnd {
    /// Why it ends.
    pub word: &'static str,
    /// The bifurcation in which it ends, if it does.
    pub bifurcation: Option<EndBifurcation>,
}

/// A bifurcation at the end of a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndBifurcation {
    /// Its name.
    pub name: &'static str,
    /// The parameter.
    pub parameter: f64,
    /// Its uncertainty, if it is known.
    pub uncertainty: Option<f64>,
    /// The period there, if it is finite and known.
    pub period: Option<f64>,
}

impl From<&Stop> for BranchEnd {
    fn from(stop: &Stop) -> Self {
        let plain = |word| BranchEnd {
            word,
            bifurcation: None,
        };
        let located = |word, name, parameter, uncertainty, period| BranchEnd {
            word,
            bifurcation: Some(EndBifurcation {
                name,
                parameter,
                uncertainty,
                period,
            }),
        };
        match *stop {
            Stop::Range => plain("range"),
            Stop::Points => plain("points"),
            Stop::Closed => plain("closed"),
            Stop::Rest => plain("rest"),
            Stop::Refused(_) => plain("friction"),
            Stop::SequenceEnds => plain("sequence ends"),
            Stop::NoConvergence => plain("no convergence"),
            Stop::Flip {
                parameter,
                uncertainty,
            } => located("flip", "flip", parameter, Some(uncertainty), None),
            Stop::Equilibrium {
                parameter,
                frequency,
            } => located(
                "equilibrium",
                "Hopf",
                parameter,
                None,
                Some(TAU / frequency),
            ),
            Stop::BoundaryEquilibrium { parameter } => {
                let word = "boundary equilibrium";
                located(word, word, parameter, None, None)
            }
            Stop::TwoFold {
                parameter,
                uncertainty,
            } => located("two-fold", "two-fold", parameter, Some(uncertainty), None),
            Stop::Homoclinic {
                parameter,
                uncertainty,
                saddles,
                ..
            } => {
                let name = match saddles.get() {
                    1 => "homoclinic",
                    _ => "heteroclinic",
                };
                located("homoclinic", name, parameter, Some(uncertainty), None)
            }
        }
    }
}
