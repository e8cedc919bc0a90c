//! The branch through an orbit in both directions, and the curves and branches that begin on it.

use std::num::NonZeroUsize;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use serde_json::json;
use stickslip::Options;
use stickslip::analysis::{
    Branch, ContinuationSettings, Curve, PartialBranch, PeriodicOrbit, SpecialPoint,
};
use stickslip::dynamics::DynamicsRef;
use stickslip_model::file::System;
use stickslip_model::study::{Followed, ParameterLine, SideBranch, TwoSidedBranch};

use super::super::range::ParameterRange;
use super::Arguments;
use super::saving::{BranchSaver, saved, saved_or_computed};
use crate::failure::Failure;
use crate::sweep::Writer;
use output::terminal::Status;

/// The first blocks behind those of both directions. For each special orbit there are two: its
/// curve in two parameters, and the branches that begin there. Those of the ends follow.
const CURVES: usize = super::DIRECTIONS.get();
const BRANCHES: usize = CURVES + 1;

/// A second parameter, for curves of special orbits.
pub(super) struct SecondParameter {
    pub(super) range: ParameterRange,
    /// Value on the branch.
    pub(super) value: f64,
    /// The system with both parameters as states.
    pub(super) both: DynamicsRef<'static>,
}

/// A system, and the parameter along which its orbits are continued.
pub(super) struct BranchStart<'a> {
    system: &'a System,
    range: &'a ParameterRange,
    pub(super) along: ParameterLine<'a>,
}

impl<'a> BranchStart<'a> {
    pub(super) fn at(system: &'a System, range: &'a ParameterRange) -> Result<Self, Failure> {
        let along = ParameterLine::new(system, &range.name, (range.low, range.high))?;
        let value = along.value;
        if !(range.low..=range.high).contains(&value) {
            return Err(Failure::Usage(format!(
                "{name} = {value} is not in the range from {} to {}: the branch begins at the \
                 parameter's value; choose it with --set {name}=…, or another range",
                range.low,
                range.high,
                name = range.name
            )));
        }
        Ok(BranchStart {
            system,
            range,
            along,
        })
    }

    /// The branch through an orbit.
    pub(super) fn branch(
        &self,
        orbit: &PeriodicOrbit,
        settings: &ContinuationSettings,
        options: &Options,
        (writer, status): (&Writer, &Status),
    ) -> Result<TwoSidedBranch, Failure> {
        let (settings, x) = self.along.start(orbit, settings, options, None)?;
        let far = Mutex::new([(0_usize, self.along.value); 2]);
        let way = |upwards| {
            let mut saving = BranchSaver::of(writer, usize::from(upwards));
            let observe = |branch: &PartialBranch| {
                let mut far = far.lock().unwrap_or_else(PoisonError::into_inner);
                let points = branch.points();
                let place = points.last().map_or(self.along.value, |at| at.parameter);
                far[usize::from(upwards)] = (points.len(), place);
                let [down, up] = far.map(|(orbits, place)| format!("{orbits} to {place:.6}"));
                status.set(format!(
                    "following the branch, orbits to {}: down {down}, up {up}",
                    self.range.name
                ));
                saving.observe(branch)
            };
            let (along, period) = (&self.along.dynamics, orbit.period);
            let begun = match saved(writer, usize::from(upwards))? {
                Some(begun) => begun,
                None => PartialBranch::begin(along, &x, period, upwards, &settings, options)?,
            };
            let followed = begun.follow(along, &settings, options, observe)?;
            saving.finish()?;
            Ok::<Branch, Failure>(followed)
        };
        let (down, up) = rayon::join(|| way(false), || way(true));
        let mut branch = self.along.joined::<Failure>([down?, up?], options)?;
        self.along.find_uncertainties(&mut branch, options);
        Ok(branch)
    }

    /// The second parameter of `--also`, if it is given.
    pub(super) fn also(&self, arguments: &Arguments) -> Result<Option<SecondParameter>, Failure> {
        let also = arguments.also.as_deref();
        let also = also.map(|text| ParameterRange::new("--also", text, self.system));
        let also = also.transpose()?;
        also.map(|other| self.second_parameter(other)).transpose()
    }

    /// The system with a second parameter as a state.
    fn second_parameter(&self, range: ParameterRange) -> Result<SecondParameter, Failure> {
        let (other, own) = (self.system.file.parameter(&range.name)?, self.along.number);
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
        let both = self.system.with_states_of(&[other, own])?;
        Ok(SecondParameter { range, value, both })
    }

    /// Follows each special orbit on the branch in two parameters, except branch points, and its
    /// homoclinic and two-fold ends. `None` if no curve continues from it.
    pub(super) fn curves(
        &self,
        also: &SecondParameter,
        orbit: &PeriodicOrbit,
        branch: &TwoSidedBranch,
        (settings, options): (&ContinuationSettings, &Options),
        writer: &Writer,
    ) -> Result<Vec<(SpecialPoint, Option<Curve>)>, Failure> {
        let (settings, x) = self
            .along
            .start(orbit, settings, options, Some(also.value))?;
        let by = json!(also.range).to_string();
        let curve = |(which, at): (Followed, SpecialPoint)| {
            let range = (also.range.low, also.range.high);
            let (both, from) = ((&also.both, range), (orbit.period, &x));
            // The ends count behind the special orbits.
            let number = match which {
                Followed::Special(number) => number,
                Followed::End { upwards } => branch.special.len() + usize::from(upwards),
            };
            let curve = saved_or_computed(writer, (CURVES + 2 * number, &by), || {
                let along = &self.along;
                let curve = along.curve(both, from, (branch, which), &settings, options);
                Ok(curve?)
            })?;
            Ok((at, curve))
        };
        branch.followed().into_par_iter().map(curve).collect()
    }

    /// The branches that begin at flips and branch points of a branch, and at their flips to a
    /// depth.
    pub(super) fn side_branches(
        &self,
        orbit: &PeriodicOrbit,
        branch: &TwoSidedBranch,
        (settings, depth, options): (&ContinuationSettings, NonZeroUsize, &Options),
        writer: &Writer,
    ) -> Result<Vec<SideBranch>, Failure> {
        let (settings, x) = self.along.start(orbit, settings, options, None)?;
        let junctions: Vec<usize> = branch.junctions().map(|(from, _)| from).collect();
        let by = depth.to_string();
        let switched = |(k, &from): (usize, &usize)| {
            let switched = saved_or_computed(writer, (BRANCHES + 2 * from, &by), || {
                let (along, begin) = (&self.along, (orbit.period, &x));
                let how = (&settings, depth);
                Ok(along.switched(begin, (branch, k), how, options)?)
            })?;
            Ok(switched.map(|switched| (from, switched)))
        };
        let junctions = junctions.par_iter().enumerate();
        let switched: Result<Vec<_>, Failure> = junctions.map(switched).collect();
        let switched = switched?.into_iter().flatten().collect();
        self.along.side_branches(branch, switched, options)
    }
}
