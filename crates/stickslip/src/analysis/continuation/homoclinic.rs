//! Ends at a homoclinic orbit: the orbits pass ever nearer to an equilibrium, and the period grows
//! without bound.

use std::num::NonZeroUsize;

use super::steps::Continuation;
use super::steps::RESOLUTION;
use super::{BranchPoint, Stop};
use crate::analysis::attractors::equilibrium::{ZERO, equilibrium_near, holds};
use crate::analysis::monodromy::velocity_in;
use crate::analysis::multipliers::eigenvalues;
use crate::dynamics::{Modes, Moment, OrbitProgress, Vector};
use crate::math;

/// Speed below which an equilibrium is looked for, in extents of the orbit per period. Chosen: far
/// below the mean speed, which is about 2.
const SLOW: f64 = 1e-1;

/// Largest distance of an equilibrium that the orbit passes, as a fraction of its extent. Chosen:
/// there the flow is that of the linearised field, by which the end is extrapolated.
const CLOSE: f64 = 1e-2;

/// An equilibrium that an orbit passes.
struct PassedEquilibrium {
    x: Vector,
    /// The slowest rate at which orbits leave it. Infinite at an equilibrium that attracts: only an
    /// event next to it ends the passage.
    leaves: f64,
    /// The slowest rate at which orbits approach it, negative.
    comes: f64,
}

impl Continuation<'_> {
    /// The end at which the period is infinite, if the branch approaches one. The last orbit then
    /// takes longer than the one before it, and is close to saddles, or to an equilibrium next to
    /// an event.
    pub(super) fn homoclinic_end(&self) -> Option<Stop> {
        if self.settings.forced.is_some() || self.branch.last.period <= self.branch.before.period {
            return None;
        }
        let equilibria = self.equilibria()?;
        // The time of a passage is the logarithm of the distance over the slower rate.
        let times = equilibria
            .iter()
            .map(|one| one.leaves.min(-one.comes).recip());
        let (parameter, uncertainty) = self.at_infinity(times.sum::<f64>().recip());
        if equilibria.iter().any(|one| one.leaves.is_infinite()) {
            return Some(Stop::BoundaryEquilibrium { parameter });
        }
        let leaves = equilibria.iter().map(|one| one.leaves);
        let comes = equilibria.iter().map(|one| one.comes);
        Some(Stop::Homoclinic {
            parameter,
            uncertainty,
            saddles: NonZeroUsize::new(equilibria.len())?,
            leaves: leaves.fold(f64::INFINITY, f64::min),
            comes: comes.fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// The parameter at which the period is infinite, which the orbits approach like `e^(-rate T)`
    /// or nearly so, and the distance of the last one from it.
    fn at_infinity(&self, rate: f64) -> (f64, f64) {
        let here = self.parameter();
        let period = self.branch.last.period;
        // Extrapolated from an orbit that is twice as far away or more.
        let twice = math::ln(2.0);
        let is_further = |point: &&BranchPoint| rate * (period - point.period) >= twice;
        let Some(other) = self.branch.points.iter().rev().find(is_further) else {
            return (here, f64::NAN);
        };
        let ratio = math::exp(rate * (period - other.period));
        let distance = (here - other.parameter) / (ratio - 1.0);
        (
            here + distance,
            distance.abs().max(RESOLUTION * self.branch.units.width),
        )
    }

    /// The equilibria that the last orbit passes slowly.
    fn equilibria(&self) -> Option<Vec<PassedEquilibrium>> {
        let cycle = &self.branch.last;
        let (system, options) = (self.shooting.system, self.shooting.options);
        let slow = SLOW * cycle.extent / cycle.period;
        let near = CLOSE * cycle.extent;
        let start = &cycle.anchor;
        let t_end = start.t + cycle.period;
        let mut orbit = system.begin(start, t_end, options, &[]).ok()?;
        let mut equilibria: Vec<PassedEquilibrium> = Vec::new();
        loop {
            match orbit.step().ok()? {
                OrbitProgress::Step => {
                    let (mode, at) = (orbit.mode(), orbit.now());
                    let away = |one: &PassedEquilibrium| (&one.x - &at.x).norm();
                    if velocity_in(system, mode, &at).norm() < slow
                        && equilibria.iter().all(|one| away(one) > 2.0 * near)
                        && let Some(equilibrium) = self.equilibrium_near(mode, &at)
                        && away(&equilibrium) <= near
                    {
                        equilibria.push(equilibrium);
                    }
                }
                OrbitProgress::Transition(_)
                | OrbitProgress::PhaseEnd(_)
                | OrbitProgress::Passage(_)
                | OrbitProgress::Kink(_) => {}
                OrbitProgress::End(_) => return Some(equilibria),
            }
        }
    }

    /// The equilibrium of a mode near a state, if the mode holds there and orbits approach it.
    fn equilibrium_near(&self, mode: Modes, at: &Moment) -> Option<PassedEquilibrium> {
        let system = self.shooting.system;
        let free = self.shooting.states;
        let found = equilibrium_near(system, mode, at.t, &at.x, free)?;
        let jacobian = found.jacobian.view((0, 0), (free, free)).into_owned();
        let there = Moment {
            t: at.t,
            x: found.x,
        };
        if !holds(system, mode, &there) {
            return None;
        }
        let values = eigenvalues(&jacobian);
        let zero = ZERO * jacobian.amax();
        let nearest = |sign: f64| {
            let rates = values.iter().map(|value| sign * value.re);
            rates.filter(|&rate| rate > zero).min_by(f64::total_cmp)
        };
        let (leaves, comes) = match (nearest(1.0), nearest(-1.0)) {
            (leaves, Some(rate)) => (leaves.unwrap_or(f64::INFINITY), -rate),
            // On the boundary, orbits reach it from across in finite time.
            (Some(leaves), None) if mode.any_sticks() => (leaves, f64::NEG_INFINITY),
            _ => return None,
        };
        Some(PassedEquilibrium {
            x: there.x,
            leaves,
            comes,
        })
    }
}
