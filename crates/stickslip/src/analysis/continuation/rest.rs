//! Where a branch of periodic orbits ends at an equilibrium: the orbits shrink to one, or pass ever
//! nearer to one.

use std::num::NonZeroUsize;

use super::walk::Walk;
use super::{BranchPoint, EquilibriumBifurcation, Stop, continue_equilibrium};
use crate::analysis::attractors::equilibrium::{ZERO, equilibrium_near, holds};
use crate::analysis::monodromy::velocity_in;
use crate::analysis::multipliers::eigenvalues;
use crate::dynamics::{DynamicsRef, Happening, Modes, Moment, Section, Vector};
use crate::math;

/// An orbit passes an equilibrium if it moved by this fraction of its extent in a period at its
/// least speed.
const SLOW: f64 = 1e-1;

/// Largest distance of the equilibrium, as a fraction of the orbit's extent.
const CLOSE: f64 = 1e-2;

/// Best precision of a homoclinic orbit's parameter, as a fraction of the range.
const RESOLUTION: f64 = 1e-11;

/// An equilibrium that an orbit passes, and the slowest rates at which orbits leave and approach
/// it.
struct Equilibrium {
    x: Vector,
    /// Infinite at an equilibrium that attracts: only an event next to it ends the passage.
    leaves: f64,
    comes: f64,
}

impl Walk<'_> {
    /// The nearest Hopf bifurcation of the equilibrium inside the last orbit.
    pub(super) fn hopf(&self) -> Option<Stop> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        let system = DynamicsRef::Borrowed(system);
        let branch = |upwards| {
            let x = self.branch.last.anchor.x.clone();
            continue_equilibrium(&system, x, upwards, self.settings, options).ok()
        };
        let special = [false, true].into_iter().filter_map(branch);
        let special = special.flat_map(|branch| branch.special);
        let stops = special.filter_map(|at| match at.what {
            EquilibriumBifurcation::Hopf { frequency } => Some((at.parameter, frequency)),
            _ => None,
        });
        let off = |stop: &(f64, f64)| (stop.0 - self.parameter()).abs();
        let (parameter, frequency) = stops.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some(Stop::Equilibrium {
            parameter,
            frequency,
        })
    }

    /// Whether the period is about to grow without bound: the last orbit is slower than the one
    /// before it, and close to one or several saddles, or to an equilibrium that reaches an event.
    pub(super) fn slow_end(&self) -> Option<Stop> {
        if self.settings.forced.is_some() || self.branch.last.period <= self.branch.before.period {
            return None;
        }
        let equilibria = self.equilibria()?;
        // The time of a passage is the logarithm of the distance over the slower of its
        // rates.
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
        // Extrapolated from an orbit about twice as far away.
        const TIMES: f64 = 2.0;
        let here = self.parameter();
        let period = self.branch.last.period;
        let is_further = |point: &&BranchPoint| rate * (period - point.period) >= math::ln(TIMES);
        let Some(other) = self.branch.points.iter().rev().find(is_further) else {
            return (here, f64::NAN);
        };
        let further = math::exp(rate * (period - other.period));
        let way = (here - other.parameter) / (further - 1.0);
        (
            here + way,
            way.abs().max(RESOLUTION * self.branch.units.width),
        )
    }

    /// The equilibria that the last orbit passes slowly.
    fn equilibria(&self) -> Option<Vec<Equilibrium>> {
        let cycle = &self.branch.last;
        let (system, options) = (self.shooting.system, self.shooting.options);
        let slow = SLOW * cycle.extent / cycle.period;
        let near = CLOSE * cycle.extent;
        let start = &cycle.anchor;
        let t_end = start.t + cycle.period;
        let mut orbit = system.begin(start, t_end, options, &Section::None).ok()?;
        let mut equilibria: Vec<Equilibrium> = Vec::new();
        loop {
            match orbit.step().ok()? {
                Happening::Step => {
                    let (mode, at) = (orbit.mode(), orbit.now());
                    let away = |one: &Equilibrium| (&one.x - &at.x).norm();
                    if velocity_in(system, mode, &at).norm() < slow
                        && equilibria.iter().all(|one| away(one) > 2.0 * near)
                        && let Some(equilibrium) = self.equilibrium_near(mode, &at)
                        && away(&equilibrium) <= near
                    {
                        equilibria.push(equilibrium);
                    }
                }
                Happening::Transition(_)
                | Happening::PhaseEnd(_)
                | Happening::Passage(_)
                | Happening::Kink(_) => {}
                Happening::End(_) => return Some(equilibria),
            }
        }
    }

    /// The equilibrium of a mode near a state, if the mode holds there and orbits approach it.
    fn equilibrium_near(&self, mode: Modes, at: &Moment) -> Option<Equilibrium> {
        let system = self.shooting.system;
        let free = at.x.len() - 1;
        let rest = equilibrium_near(system, mode, at.t, &at.x, free)?;
        let jacobian = rest.jacobian.view((0, 0), (free, free)).into_owned();
        let there = Moment { t: at.t, x: rest.x };
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
        Some(Equilibrium {
            x: there.x,
            leaves,
            comes,
        })
    }
}
