//! The branch through an orbit, in both directions.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use stickslip::analysis::{
    Branch as Way, BranchPoint, ContinuationSettings, Curve, EquilibriumBranch, PartialBranch,
    PeriodicOrbit, Special, SpecialPoint, Stop, SwitchedBranch, continue_change,
    continue_equilibrium, switch_branches,
};
use stickslip::dynamics::{DynamicsRef, Section, Summary, Vector};
use stickslip::{Ending, Error, Options};
use stickslip_kernels::kernel::{Run, Watcher, follow};

use super::super::extremes::Extremes;
use super::super::range::{ParameterRange, with_values};
use super::saving::{Saving, saved};
use crate::failure::Failure;
use crate::sweep::Writer;
use crate::terminal::Status;
use stickslip_kernels::file::System;

/// An orbit of the branch.
pub(super) struct Point {
    pub(super) orbit: BranchPoint,
    /// Minimum and maximum of each state on the orbit.
    pub(super) extremes: Vec<(f64, f64)>,
}

/// A whole branch, from its lower to its upper end.
pub(super) struct Branch {
    pub(super) points: Vec<Point>,
    /// The special orbits, in the same order.
    pub(super) special: Vec<SpecialPoint>,
    /// Index of the orbit from which the branch was started.
    pub(super) first: usize,
    /// Why the branch ends, downwards and upwards.
    pub(super) stops: [Stop; 2],
}

/// A branch that begins at a special orbit of another one.
pub(super) struct Other {
    /// Index of that orbit among the special ones, from 0.
    pub(super) from: usize,
    pub(super) branch: Branch,
}

/// A second parameter.
pub(super) struct Also {
    pub(super) range: ParameterRange,
    /// Its value on the branch.
    value: f64,
    /// The system with both parameters as states.
    both: DynamicsRef<'static>,
}

/// A system, and the parameter along which its orbits are continued.
pub(super) struct Begin<'a> {
    system: &'a System,
    range: &'a ParameterRange,
    /// The parameter's value.
    value: f64,
    /// The system with the parameter as a state.
    along: DynamicsRef<'static>,
}

impl<'a> Begin<'a> {
    pub(super) fn at(system: &'a System, range: &'a ParameterRange) -> Result<Self, Failure> {
        let parameters = system.file.parameters.iter();
        let number = parameters
            .map(|one| &one.name)
            .position(|name| *name == range.name);
        let Some(number) = number else {
            return Err(Failure::Usage(format!(
                "there is no parameter `{}`",
                range.name
            )));
        };
        let value = system.values[number];
        if !(range.low..=range.high).contains(&value) {
            return Err(Failure::Usage(format!(
                "{name} = {value} is not in the range from {} to {}: the branch begins at the \
                 parameter's value; choose it with --set {name}=…, or another range",
                range.low,
                range.high,
                name = range.name
            )));
        }
        // A system that cannot be evaluated at the ends should be reported now.
        for end in [range.low, range.high] {
            range.system(system, end)?;
        }
        let along = system.along(number)?;
        Ok(Begin {
            system,
            range,
            value,
            along,
        })
    }

    /// The branch through an orbit. `periods` is the number of periods of the drive in it, if there
    /// is a drive.
    pub(super) fn branch(
        &self,
        (orbit, periods): (&PeriodicOrbit, Option<u32>),
        settings: &ContinuationSettings,
        options: &Options,
        (writer, status): (&Writer, &Status),
    ) -> Result<Branch, Failure> {
        let settings = ContinuationSettings {
            forced: periods.map(|_| orbit.period),
            ..*settings
        };
        let x = self.at_zero(orbit, options)?;
        let x = [x.as_slice(), &[self.value]].concat();
        let far = Mutex::new([(0_usize, self.value); 2]);
        let way = |upwards| {
            let mut saving = Saving::of(writer, usize::from(upwards));
            let observe = |branch: &PartialBranch| {
                let mut far = far.lock().unwrap_or_else(PoisonError::into_inner);
                let points = branch.points();
                let place = points.last().map_or(self.value, |at| at.parameter);
                far[usize::from(upwards)] = (points.len(), place);
                let [down, up] = far.map(|(orbits, place)| format!("{orbits} to {place:.6}"));
                status.set(format!(
                    "following the branch, orbits to {}: down {down}, up {up}",
                    self.range.name
                ));
                saving.observe(branch)
            };
            let (along, period) = (&self.along, orbit.period);
            let begun = match saved(writer, usize::from(upwards))? {
                Some(begun) => begun,
                None => PartialBranch::begin(along, &*x, period, upwards, &settings, options)?,
            };
            let followed = begun.follow(along, &settings, options, observe)?;
            saving.finish()?;
            Ok::<Way, Failure>(followed)
        };
        let (down, up) = rayon::join(|| way(false), || way(true));
        let (mut down, mut up) = (down?, up?);
        // A closed branch is the same in the other direction.
        if down.stop == Stop::Closed {
            only_begun(&mut up);
        } else if up.stop == Stop::Closed {
            only_begun(&mut down);
        }
        self.joined(down, up, options)
    }

    /// The branch of equilibria through the one near a state, downwards and upwards.
    pub(super) fn equilibria(
        &self,
        x: &[f64],
        settings: &ContinuationSettings,
        options: &Options,
    ) -> Result<[EquilibriumBranch; 2], Failure> {
        let x = [x, &[self.value]].concat();
        let way = |upwards| continue_equilibrium(&self.along, &*x, upwards, settings, options);
        Ok([way(false)?, way(true)?])
    }

    /// The system with a second parameter as a state.
    pub(super) fn also(&self, range: ParameterRange) -> Result<Also, Failure> {
        let parameters = self.system.file.parameters.iter();
        let names: Vec<&str> = parameters.map(|one| one.name.as_str()).collect();
        let place = |name: &str| names.iter().position(|one| *one == name);
        let (Some(other), Some(own)) = (place(&range.name), place(&self.range.name)) else {
            return Err(Failure::Usage(format!(
                "there is no parameter `{}`",
                range.name
            )));
        };
        let value = self.system.values[other];
        if other == own {
            return Err(Failure::Usage(format!(
                "--also is for another parameter than --parameter, and both are `{}`",
                range.name
            )));
        }
        if !(range.low..=range.high).contains(&value) {
            return Err(Failure::Usage(format!(
                "{name} = {value} is not in the range of --also from {} to {}: curves begin at its \
                 value; choose it with --set {name}=…, or another range",
                range.low,
                range.high,
                name = range.name
            )));
        }
        let both = self.system.along_both(other, own)?;
        Ok(Also { range, value, both })
    }

    /// Follows each special orbit on the branch in two parameters, except branch points. `None` if
    /// no curve continues from it.
    pub(super) fn curves(
        &self,
        also: &Also,
        (orbit, periods): (&PeriodicOrbit, Option<u32>),
        branch: &Branch,
        settings: &ContinuationSettings,
        options: &Options,
    ) -> Result<Vec<(SpecialPoint, Option<Curve>)>, Failure> {
        let settings = ContinuationSettings {
            forced: periods.map(|_| orbit.period),
            ..*settings
        };
        let x = self.at_zero(orbit, options)?;
        let x = [x.as_slice(), &[also.value, self.value]].concat();
        let is_above = |at: &SpecialPoint| at.behind > branch.first;
        let below = branch.special.iter().filter(|at| !is_above(at)).count();
        let curve = |(k, at): (usize, &SpecialPoint)| {
            // In each direction, orbits are counted from the one that the branch was started from.
            let upwards = is_above(at);
            let number = if upwards { k - below } else { below - 1 - k };
            let ranges = (&settings, (also.range.low, also.range.high));
            let way = (orbit.period, upwards, number);
            let found = continue_change(&also.both, &*x, way, ranges, options);
            let told = match found {
                Ok(mut curve) => {
                    for point in &mut curve.points {
                        let pace = self.pace_of(&[
                            (&also.range.name, point.parameters[0]),
                            (&self.range.name, point.parameters[1]),
                        ])?;
                        point.period *= pace;
                        point.t *= pace;
                    }
                    Some(curve)
                }
                Err(Error::NotFound { .. }) => None,
                Err(error) => return Err(Failure::from(error)),
            };
            Ok((at.clone(), told))
        };
        let followed = branch.special.iter().enumerate();
        let followed: Vec<_> = followed
            .filter(|(_, at)| at.what != Special::BranchPoint)
            .collect();
        followed.into_par_iter().map(curve).collect()
    }

    /// The branches that begin at flips and branch points of a branch.
    pub(super) fn others(
        &self,
        (orbit, periods): (&PeriodicOrbit, Option<u32>),
        branch: &Branch,
        settings: &ContinuationSettings,
        options: &Options,
    ) -> Result<Vec<Other>, Failure> {
        let settings = ContinuationSettings {
            forced: periods.map(|_| orbit.period),
            ..*settings
        };
        let x = self.at_zero(orbit, options)?;
        let x = [x.as_slice(), &[self.value]].concat();
        let special = branch.special.iter().enumerate();
        let meets = |at: &SpecialPoint| matches!(at.what, Special::Flip | Special::BranchPoint);
        let junctions: Vec<_> = special.filter(|(_, at)| meets(at)).collect();
        let is_above = |at: &SpecialPoint| at.behind > branch.first;
        let below = junctions.iter().filter(|(_, at)| !is_above(at)).count();
        let switched = |(k, &(from, at)): (usize, &(usize, &SpecialPoint))| {
            let upwards = is_above(at);
            let number = if upwards { k - below } else { below - 1 - k };
            let way = (orbit.period, upwards, number);
            let found = match switch_branches(&self.along, &*x, way, &settings, options) {
                Ok(SwitchedBranch { branches, .. }) => branches,
                Err(Error::NotFound { .. }) => Vec::new(),
                Err(error) => return Err(Failure::from(error)),
            };
            // On one side, the branch ends with its first orbit.
            let begin = |way: &Way| Way {
                points: way.points.iter().take(1).cloned().collect(),
                special: Vec::new(),
                stop: Stop::Points,
            };
            let found = found.into_iter();
            let told = found.map(|way| {
                let branch = self.joined(begin(&way), way, options)?;
                Ok(Other { from, branch })
            });
            told.collect::<Result<Vec<Other>, Failure>>()
        };
        let junctions = junctions.par_iter().enumerate();
        let others: Result<Vec<_>, Failure> = junctions.map(switched).collect();
        Ok(others?.into_iter().flatten().collect())
    }

    /// A state of the orbit at a multiple of its period, where the time of the branch begins.
    fn at_zero(&self, orbit: &PeriodicOrbit, options: &Options) -> Result<Vector, Failure> {
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
        let ended = whole(self.system, &run, orbit.period, &mut ())?;
        Ok(ended.x)
    }

    /// Joins both directions, in the time of the file, with the extremes of each orbit.
    fn joined(&self, down: Way, up: Way, options: &Options) -> Result<Branch, Failure> {
        // Both directions contain the first orbit.
        let first = down.points.len().saturating_sub(1);
        let mut orbits: Vec<BranchPoint> = down.points.into_iter().skip(1).rev().collect();
        orbits.extend(up.points);
        let mut special: Vec<SpecialPoint> = down.special.into_iter().rev().collect();
        for at in &mut special {
            at.behind = (first + 1).saturating_sub(at.behind);
            if let Special::Sequence(change) = &mut at.what {
                std::mem::swap(&mut change.before, &mut change.after);
            }
        }
        special.extend(up.special.into_iter().map(|at| SpecialPoint {
            behind: at.behind + first,
            ..at
        }));
        // Newton's iteration reaches the ends of the range only up to rounding.
        let within = |parameter: f64| parameter.clamp(self.range.low, self.range.high);
        for orbit in &mut orbits {
            orbit.parameter = within(orbit.parameter);
        }
        for at in &mut special {
            at.parameter = within(at.parameter);
            let pace = self.pace(at.parameter)?;
            at.period *= pace;
            at.x = self.states_of(&at.x);
            if let Special::Sequence(change) = &mut at.what {
                change.period *= pace;
                change.x = self.states_of(&change.x);
            }
        }
        let points = orbits
            .into_par_iter()
            .map(|orbit| self.point(orbit, options));
        Ok(Branch {
            points: points.collect::<Result<_, Failure>>()?,
            special,
            first,
            stops: [down.stop, up.stop],
        })
    }

    /// Ratio of the time of the file to the time of the branch, at a value of the parameter.
    fn pace(&self, parameter: f64) -> Result<f64, Failure> {
        self.pace_of(&[(&self.range.name, parameter)])
    }

    fn pace_of(&self, values: &[(&str, f64)]) -> Result<f64, Failure> {
        let Some(here) = self.system.built.period else {
            return Ok(1.0);
        };
        let there = with_values(self.system, values)?;
        Ok(there.built.period.map_or(1.0, |there| there / here))
    }

    /// The states of the system, without the parameter that follows them.
    fn states_of(&self, x: &Vector) -> Vector {
        x.rows(0, self.system.states()).into_owned()
    }

    fn point(&self, orbit: BranchPoint, options: &Options) -> Result<Point, Failure> {
        let pace = self.pace(orbit.parameter)?;
        let orbit = BranchPoint {
            t: orbit.t * pace,
            x: self.states_of(&orbit.x),
            period: orbit.period * pace,
            ..orbit
        };
        let system = self.range.system(self.system, orbit.parameter)?;
        let t_end = orbit.t + orbit.period;
        let once = Run {
            t: orbit.t,
            x: orbit.x.as_slice(),
            t_end,
            options,
        };
        let mut extremes = Extremes::from(once.x);
        whole(&system, &once, orbit.period, &mut extremes)?;
        Ok(Point {
            extremes: extremes.ranges(),
            orbit,
        })
    }
}

/// Follows an orbit to the end of its period.
fn whole(
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

/// Keeps only the first orbit of a direction.
fn only_begun(way: &mut Way) {
    way.points.truncate(1);
    way.special.clear();
    way.stop = Stop::Closed;
}
