//! Branches of periodic orbits along a parameter, in the time and the states of the system's file.

use std::num::NonZeroUsize;

use rayon::prelude::*;
use stickslip::analysis::{
    Branch, BranchPoint, ContinuationSettings, Curve, CycleBifurcation, EquilibriumBranch,
    PeriodicOrbit, SpecialPoint, Stop, SwitchedBranch,
};
use stickslip::dynamics::{DynamicsRef, Summary, Vector};
use stickslip::{Ending, Error, Options};

use super::{EquilibriaOfBranch, extremes};
use crate::file::{SettingError, System};
use crate::kernel::{follow, ignore};

/// A system along one of its parameters.
pub struct ParameterLine<'a> {
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
    /// Uncertainty of each multiplier, as [`ParameterLine::find_uncertainties`] computes it; NaN
    /// before.
    pub uncertainties: Vec<f64>,
}

/// A branch in both directions, from its lower to its upper end.
pub struct TwoSidedBranch {
    /// The orbits.
    pub points: Vec<BranchOrbit>,
    /// The special orbits, in the same order.
    pub special: Vec<SpecialPoint>,
    /// Index of the orbit from which the branch was started.
    pub first: usize,
    /// Reasons for the ends of the branch, downwards and upwards.
    pub stops: [Stop; 2],
    /// Dimension of the family to which its orbits belong: [`Branch::family`].
    pub family: usize,
}

/// A special solution on one of two directions of a branch from its first one.
pub(super) struct BesideFirst {
    pub name: String,
    pub parameter: f64,
    pub uncertainty: f64,
    /// Number of solutions before it, with the first.
    pub behind: usize,
}

/// Number of special solutions that both directions of a branch find in their first steps: the
/// first solution may be one.
pub(super) fn found_twice<T>([down, up]: [&[T]; 2], of: impl Fn(&T) -> BesideFirst) -> usize {
    let pairs = down
        .iter()
        .zip(up)
        .map(|(one, other)| [one, other].map(&of));
    let same = pairs.take_while(|[one, other]| {
        let known = one.uncertainty + other.uncertainty;
        let is_near = (one.parameter - other.parameter).abs() <= known;
        one.behind.max(other.behind) <= 1 && is_near && one.name == other.name
    });
    same.count()
}

/// A branch that begins at a special orbit of another one.
pub struct SideBranch {
    /// Number of the branch on which it begins: 0 for the first, then those of
    /// [`ParameterLine::side_branches`] in their order, from 1.
    pub parent: usize,
    /// Index of the special orbit of that branch at which it begins.
    pub from: usize,
    /// Index of the other flip of that branch in which it ends: the orbits are a bubble between
    /// both.
    pub to: Option<usize>,
    /// The branch.
    pub branch: TwoSidedBranch,
}

/// A special orbit or an end that is followed in two parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Followed {
    /// A special orbit, by its index.
    Special(usize),
    /// An end of the branch.
    End {
        /// Whether it is the upper one.
        upwards: bool,
    },
}

impl<'a> ParameterLine<'a> {
    /// A system along the named parameter, in a range.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown parameter, or if the system cannot be evaluated at an end of
    /// the range.
    pub fn new(system: &'a System, name: &'a str, range: (f64, f64)) -> Result<Self, SettingError> {
        let range = (range.0.min(range.1), range.0.max(range.1));
        let number = system.file.parameter(name)?;
        for end in [range.0, range.1] {
            system.driven_with(&[(name, end)])?;
        }
        Ok(ParameterLine {
            system,
            number,
            name,
            range,
            value: system.values[number],
            dynamics: system.with_states_of(&[number])?,
        })
    }

    /// Settings and start of a continuation from an orbit: a state at a multiple of its period,
    /// then the other parameter, if there is one, and the parameter.
    ///
    /// # Errors
    /// [`Error::NotFound`] if a jump stops the orbit; those of [`stickslip::run`].
    pub fn start(
        &self,
        orbit: &PeriodicOrbit,
        settings: &ContinuationSettings,
        options: &Options,
        other: Option<f64>,
    ) -> Result<(ContinuationSettings, Vector), Error> {
        let is_driven = self.system.built.depends_on_time;
        let settings = ContinuationSettings {
            forced: is_driven.then_some(orbit.period),
            ..*settings
        };
        let parameters = other.into_iter().chain([self.value]);
        let mut x = self.at_zero(orbit, options)?;
        x.extend(parameters);
        Ok((settings, x))
    }

    /// The branch of equilibria through the one near a state, in both directions.
    ///
    /// # Errors
    /// Those of [`EquilibriumBranch::through`].
    pub fn equilibria(
        &self,
        x: &[f64],
        settings: &ContinuationSettings,
        options: &Options,
    ) -> Result<EquilibriaOfBranch, Error> {
        let x = [x, &[self.value]].concat();
        let way =
            |upwards| EquilibriumBranch::through(&self.dynamics, &*x, upwards, settings, options);
        let (down, up) = rayon::join(|| way(false), || way(true));
        Ok(EquilibriaOfBranch::joined([down?, up?]))
    }

    /// The curve of a special orbit or end of a branch in two parameters. The system `both` has the
    /// second parameter, of some range, as the state before the own one, and `x` is the start of
    /// [`ParameterLine::start`] with its value. `None` if no curve continues from it.
    ///
    /// # Errors
    /// Those of [`Curve::of_special`] and [`Curve::of_end`].
    pub fn curve(
        &self,
        (both, range): (&DynamicsRef<'_>, (f64, f64)),
        (period, x): (f64, &Vector),
        (branch, which): (&TwoSidedBranch, Followed),
        settings: &ContinuationSettings,
        options: &Options,
    ) -> Result<Option<Curve>, Error> {
        let how = (settings, range);
        let curve = match which {
            Followed::Special(number) => {
                let special: Vec<&SpecialPoint> = branch.special.iter().collect();
                let (upwards, counted) = branch.counted(&special, number);
                Curve::of_special(both, x, (period, upwards, counted), how, options)
            }
            Followed::End { upwards } => Curve::of_end(both, x, (period, upwards), how, options),
        };
        match curve {
            Ok(curve) => Ok(Some(curve)),
            Err(Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The branches that begin at a flip or branch point of a branch. Branches from their flips
    /// follow, to a depth. `x` is the start of [`ParameterLine::start`]. `None` if none was found.
    ///
    /// # Errors
    /// Those of [`SwitchedBranch::of_special`].
    pub fn switched(
        &self,
        (period, x): (f64, &Vector),
        (branch, number): (&TwoSidedBranch, usize),
        (settings, depth): (&ContinuationSettings, NonZeroUsize),
        options: &Options,
    ) -> Result<Option<SwitchedBranch>, Error> {
        let junctions: Vec<&SpecialPoint> = branch.junctions().map(|(_, at)| at).collect();
        let (upwards, counted) = branch.counted(&junctions, number);
        let way = (period, upwards, counted);
        match SwitchedBranch::of_special(&self.dynamics, x, way, (settings, depth), options) {
            Err(Error::NotFound { .. }) => Ok(None),
            switched => Ok(Some(switched?)),
        }
    }

    /// The branches that were switched to at special orbits of a branch, each with the index of
    /// that orbit, and those that begin on them. No branch is there twice: one that ends in another
    /// flip is kept from the first of both. Downwards each ends with its first orbit.
    ///
    /// # Errors
    /// Those of [`ParameterLine::joined`].
    pub fn side_branches<E: From<Error> + From<SettingError> + Send>(
        &self,
        main: &TwoSidedBranch,
        switched: Vec<(usize, SwitchedBranch)>,
        options: &Options,
    ) -> Result<Vec<SideBranch>, E> {
        let mut all: Vec<SideBranch> = Vec::new();
        let mut level = vec![(0, switched)];
        // Those of one depth come before those of the next.
        while !level.is_empty() {
            let mut next = Vec::new();
            for (parent, switched) in level {
                let mut kept: Vec<&SwitchedBranch> = Vec::new();
                for (from, one) in &switched {
                    if kept.iter().any(|other| other.is_bubble_to(&one.at)) {
                        continue;
                    }
                    kept.push(one);
                    let special = match parent {
                        0 => &main.special,
                        number => &all[number - 1].branch.special,
                    };
                    let others = special.iter().enumerate();
                    let mut others = others.filter(|(k, at)| k != from && one.is_bubble_to(at));
                    let to = others.next().map(|(k, _)| k);
                    for (way, further) in one.branches.iter().zip(&one.further) {
                        let branch = self.side_branch::<E>(way.clone(), options)?;
                        let place = |of: &SwitchedBranch| {
                            let is_it = |at: &SpecialPoint| at.parameter == of.at.parameter;
                            Some((branch.special.iter().position(is_it)?, of.clone()))
                        };
                        let further: Vec<_> = further.iter().filter_map(place).collect();
                        all.push(SideBranch {
                            parent,
                            from: *from,
                            to,
                            branch,
                        });
                        if !further.is_empty() {
                            next.push((all.len(), further));
                        }
                    }
                }
            }
            level = next;
        }
        Ok(all)
    }

    /// A branch that was switched to, with the extremes of each orbit.
    fn side_branch<E: From<Error> + From<SettingError> + Send>(
        &self,
        way: Branch,
        options: &Options,
    ) -> Result<TwoSidedBranch, E> {
        let begin = Branch {
            points: way.points.iter().take(1).cloned().collect(),
            special: Vec::new(),
            stop: Stop::Points,
            family: way.family,
        };
        let mut branch = self.joined::<E>([begin, way], options)?;
        self.find_uncertainties(&mut branch, options);
        Ok(branch)
    }

    /// A state of the orbit at a multiple of its period, where the time of the branch begins.
    fn at_zero(&self, orbit: &PeriodicOrbit, options: &Options) -> Result<Vector, Error> {
        let behind = orbit.t.rem_euclid(orbit.period);
        let t_end = orbit.t + (orbit.period - behind);
        // By rounding, the remainder may be a whole period or zero.
        if !self.system.built.depends_on_time || behind == 0.0 || t_end <= orbit.t {
            return Ok(orbit.x.clone());
        }
        let (system, start) = (self.system.dynamics(), (orbit.t, orbit.x.as_slice()));
        let ended = follow(system, start, t_end, options, &[], &mut ignore)?;
        Ok(whole(ended, orbit.period)?.x)
    }

    /// An orbit with minimum and maximum of each state along it.
    fn described<E: From<Error> + From<SettingError>>(
        &self,
        orbit: BranchPoint,
        options: &Options,
    ) -> Result<BranchOrbit, E> {
        let orbit = BranchPoint {
            parameter: self.within(orbit.parameter),
            x: self.states_of(&orbit.x),
            ..orbit
        };
        let system = self.system.with_values(&[(self.name, orbit.parameter)])?;
        let (start, t_end) = ((orbit.t, orbit.x.as_slice()), orbit.t + orbit.period);
        let (extremes, ended) = extremes(system.dynamics(), start, t_end, options)?;
        whole(ended, orbit.period)?;
        Ok(BranchOrbit {
            uncertainties: vec![f64::NAN; orbit.multipliers.len()],
            orbit,
            extremes,
        })
    }

    /// Computes the uncertainties of the multipliers of all orbits of a branch. They stay NaN where
    /// an orbit is not found again, as after an interruption.
    pub fn find_uncertainties(&self, branch: &mut TwoSidedBranch, options: &Options) {
        let is_forced = self.system.built.depends_on_time;
        branch.points.par_iter_mut().for_each(|point| {
            let orbit = &point.orbit;
            // The value of the parameter was allowed before.
            if let Ok(system) = self.system.with_values(&[(self.name, orbit.parameter)]) {
                let dynamics = system.dynamics();
                point.uncertainties = orbit.multiplier_uncertainties(dynamics, is_forced, options);
            }
        });
    }

    /// Joins both directions, with the extremes of each orbit. Of a closed branch only one
    /// direction is kept.
    ///
    /// # Errors
    /// Those of [`stickslip::run`] and of the parameter.
    pub fn joined<E: From<Error> + From<SettingError> + Send>(
        &self,
        mut ways: [Branch; 2],
        options: &Options,
    ) -> Result<TwoSidedBranch, E> {
        only_once(&mut ways);
        let [mut down, up] = ways;
        let twice = found_twice([&down.special, &up.special], |one| BesideFirst {
            name: one.what.to_string(),
            parameter: one.parameter,
            uncertainty: one.uncertainty,
            behind: one.behind,
        });
        down.special.drain(..twice);
        // Both directions contain the first orbit.
        let first = down.points.len().saturating_sub(1);
        let below = down.points.into_iter().skip(1).rev();
        let points: Vec<BranchPoint> = below.chain(up.points).collect();
        let points = points.into_par_iter();
        let points = points.map(|orbit| self.described::<E>(orbit, options));
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
            at.x = self.states_of(&at.x);
            if let CycleBifurcation::Sequence(change) = &mut at.what {
                change.x = self.states_of(&change.x);
            }
            at
        });
        Ok(TwoSidedBranch {
            points: points.collect::<Result<_, E>>()?,
            special: special.collect(),
            first,
            stops: [down.stop, up.stop],
            family: down.family,
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
fn only_once([down, up]: &mut [Branch; 2]) {
    let same = match (&down.stop, &up.stop) {
        (Stop::Closed, _) => up,
        (_, Stop::Closed) => down,
        _ => return,
    };
    same.points.truncate(1);
    same.special.clear();
    same.stop = Stop::Closed;
}

/// The end of a run over a period, which it must have reached.
fn whole(ended: Summary, period: f64) -> Result<Summary, Error> {
    match ended.ending {
        Ending::EndTime => Ok(ended),
        _ => Err(Error::NotFound {
            what: "the end of the period",
            t: ended.t,
            span: period,
        }),
    }
}

impl TwoSidedBranch {
    /// The special orbits at which other branches begin: flips and branch points, each with its
    /// index among all special orbits.
    pub fn junctions(&self) -> impl Iterator<Item = (usize, &SpecialPoint)> {
        let special = self.special.iter().enumerate();
        special.filter(|(_, at)| {
            matches!(
                at.what,
                CycleBifurcation::Flip | CycleBifurcation::BranchPoint
            )
        })
    }

    /// The special orbits, except branch points, and the ends that have curves in two parameters,
    /// in the order of [`TwoSidedBranch::special_rows`].
    pub fn followed(&self) -> Vec<(Followed, SpecialPoint)> {
        let end = |upwards: bool, stop: &Stop, at: Option<&BranchOrbit>| {
            let at = &at?.orbit;
            let special = SpecialPoint {
                behind: if upwards { self.points.len() } else { 0 },
                ..stop.as_special(&at.x, at.period)?
            };
            Some((Followed::End { upwards }, special))
        };
        let [down, up] = &self.stops;
        let special = self.special.iter().cloned().enumerate();
        let special = special.filter(|(_, at)| at.what != CycleBifurcation::BranchPoint);
        let special = special.map(|(k, at)| (Followed::Special(k), at));
        let first = end(false, down, self.points.first());
        let last = end(true, up, self.points.last());
        first.into_iter().chain(special).chain(last).collect()
    }

    /// The row of [`TwoSidedBranch::special_rows`] of what is followed.
    pub fn row_of(&self, which: Followed) -> usize {
        let first = usize::from(self.ends()[0].bifurcation.is_some());
        match which {
            Followed::Special(number) => first + number,
            Followed::End { upwards: false } => 0,
            Followed::End { upwards: true } => first + self.special.len(),
        }
    }

    /// A special orbit among some of those of the branch: whether it lies upwards of the first
    /// orbit of the branch, and its number, counted in that direction.
    fn counted(&self, among: &[&SpecialPoint], k: usize) -> (bool, usize) {
        let is_above = |at: &SpecialPoint| at.behind > self.first;
        let below = among.iter().filter(|at| !is_above(at)).count();
        let upwards = is_above(among[k]);
        (upwards, if upwards { k - below } else { below - 1 - k })
    }
}
