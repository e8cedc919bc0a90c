//! Boundary-equilibrium bifurcations: an equilibrium reaches the edge of its mode's domain (di
//! Bernardo, Budd, Champneys & Kowalczyk 2008, Ch. 5).

use super::attractors::equilibrium::{equilibrium_near, least_guard};
use super::critical::zero_between;
use super::cycle::Cycle;
use crate::dynamics::{Dynamics, Modes, Moment, Vector};

/// Largest distance of an orbit from the equilibrium in which it ends, as a fraction of the extent
/// of a wider orbit. Chosen.
const LARGEST_DISTANCE: f64 = 1e-2;

/// Largest distance of that equilibrium at the end, in extents of the last orbit. Chosen.
const LARGEST_SHIFT: f64 = 10.0;

/// Least relative decrease of the distance between two orbits that is extrapolated. The
/// extrapolated parameter is then at most a thousand steps away.
const LEAST_DECREASE: f64 = 1e-3;

/// The equilibrium of a mode, and the smallest guard of that mode there: positive where the mode
/// holds.
pub(super) struct ModeEquilibrium {
    pub x: Vector,
    pub guard: f64,
}

impl ModeEquilibrium {
    /// The equilibrium near a state, of which the first `free` components are states.
    pub fn near(system: &dyn Dynamics, mode: Modes, x: &Vector, free: usize) -> Option<Self> {
        let x = equilibrium_near(system, mode, 0.0, x, free)?.x;
        let at = Moment { t: 0.0, x };
        let guard = least_guard(system, mode, &at);
        Some(ModeEquilibrium { x: at.x, guard })
    }
}

/// A periodic orbit that approaches an equilibrium.
pub(super) struct Approach {
    pub parameter: f64,
    pub modes: Vec<Modes>,
    /// The states at which the phases begin.
    pub begins: Vec<Vector>,
    pub extent: f64,
}

impl Approach {
    pub fn of(parameter: f64, cycle: &Cycle) -> Self {
        Approach {
            parameter,
            modes: cycle.outline.modes(),
            begins: cycle.begins.iter().map(|at| at.x.clone()).collect(),
            extent: cycle.extent,
        }
    }
}

/// The parameter at which periodic orbits end in an equilibrium of one mode, and that equilibrium.
/// Their transitions approach it while it approaches the edge of its mode's domain. The orbits
/// shrink to it, or pass it ever more slowly.
///
/// The orbits are in order. `equilibrium` returns that of a mode near a state at a parameter; the
/// first `free` components are states. `widest` is the extent of an orbit that is not near.
pub(super) fn ends_in(
    orbits: &[Approach],
    widest: f64,
    free: usize,
    equilibrium: impl Fn(f64, Modes, &Vector) -> Option<ModeEquilibrium>,
) -> Option<(f64, Vector)> {
    let modes = &orbits.first()?.modes;
    if modes.len() < 2 {
        return None;
    }
    modes.iter().find_map(|&mode| {
        // The distance, and the state there.
        let near = |one: &Approach| {
            let distance = |x: &Vector| {
                let equilibrium = equilibrium(one.parameter, mode, x)?.x;
                Some(((equilibrium - x).rows(0, free).amax(), x.clone()))
            };
            let nearest = one.begins.iter().filter_map(distance);
            nearest.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        // The last ones may be as near to it as they can be computed.
        let is_near = |one: &Approach| near(one).is_some_and(|at| at.0 < LARGEST_DISTANCE * widest);
        let number = orbits.iter().position(is_near)?.max(1);
        let (before, last) = (orbits.get(number - 1)?, orbits.get(number)?);
        let ((further, _), (distance, mut x)) = (near(before)?, near(last)?);
        let here = last.parameter;
        let ahead = (here - before.parameter) * distance / (further - distance);
        if distance * (1.0 + LEAST_DECREASE) >= further
            || distance >= LARGEST_DISTANCE * widest
            || ahead == 0.0
        {
            return None;
        }
        let start = x.clone();
        let mut guard = |parameter: f64| {
            let next = equilibrium(parameter, mode, &x)?;
            x = next.x;
            Some(next.guard)
        };
        let beyond = here + 2.0 * ahead;
        let [one, other] = [guard(here)?, guard(beyond)?];
        if one * other > 0.0 {
            return None;
        }
        let end = zero_between((here, one), (beyond, other), &mut guard)?;
        guard(end)?;
        let shift = (&x - start).rows(0, free).amax();
        (shift <= LARGEST_SHIFT * last.extent).then_some((end, x))
    })
}
