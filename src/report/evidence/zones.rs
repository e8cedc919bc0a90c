//! The stick zones of model 2: the parameters on which their location depends, and their motion.

use rayon::prelude::*;

use super::stick_phases::TangentSet;
use crate::figures::rows::Value;
use crate::numbers::{ROUNDING, change_points, extent, largest};
use crate::paper::models::ForcedOscillator;
use crate::paper::reading::Reading::Exact;
use crate::report::digits::small;
use crate::report::errata::Proof;
use crate::report::finding::{Finding, statement};
use crate::report::scan::PARAMETERS;
use crate::text::joined;
use numerics::bisect;
use stickslip::{Fate, Filippov, State, fate};

/// Range of positions relative to the support (m): half as far again as the outermost tangent
/// point.
const POSITION_RANGE: f64 = 1.6;
/// Number of positions tested in that range: a hundred in the narrowest zone.
const POSITIONS_TESTED: u32 = 1600;

/// Positions x1 (m), ascending, at which stick begins or ends along Σ at time `t` (s).
fn stick_ends(model: &ForcedOscillator, t: f64) -> Vec<f64> {
    let sticks = |x1: f64| fate(model, t, &State::from([x1, model.belt_speed])) == Fate::Stick;
    // Off round numbers, at which zones end for round parameters.
    let position =
        |k: u32| POSITION_RANGE * (2.0 * f64::from(k) / f64::from(POSITIONS_TESTED) - 1.0) + 1.3e-4;
    let offset = model.support(t);
    change_points((0..=POSITIONS_TESTED).map(|k| offset + position(k)), sticks)
}

/// Factor by which [`location`] changes each parameter.
const PARAMETER_FACTOR: f64 = 1.05;
const NAMED: [&str; 3] = ["k1", "k2", "mu0"];
const OTHERS: [&str; 3] = ["m", "vp", "delta"];

/// Smallest and largest displacement (m) of the ends when each parameter is changed. It is infinite
/// if the number of zones changes.
fn shifts(model: &ForcedOscillator, of: [&'static str; 3]) -> [(&'static str, (f64, f64)); 3] {
    let ends = stick_ends(model, 0.0);
    of.map(|name| {
        let mut other = *model;
        for (_, _, of) in PARAMETERS.iter().filter(|one| one.0 == name) {
            *of(&mut other) *= PARAMETER_FACTOR;
        }
        let others = stick_ends(&other, 0.0);
        if others.len() != ends.len() {
            return (name, (f64::INFINITY, f64::INFINITY));
        }
        let shifts = ends.iter().zip(&others).map(|(a, b)| (a - b).abs());
        (name, extent(shifts))
    })
}

/// `s4.zone_location`: the parameters on which the location of the stick zones depends.
pub(super) fn location(model: &ForcedOscillator) -> Vec<Finding> {
    let ends = stick_ends(model, 0.0).len();
    let (named, others) = (shifts(model, NAMED), shifts(model, OTHERS));
    let moves = named.iter().all(|(_, (least, _))| *least > ROUNDING);
    let what = "the location of the stick zones depends on k1, k2 and mu0";
    let each = |(name, (_, most)): (&str, (f64, f64))| format!("{name} {}", small(most));
    let [named, others] = [named, others].map(|of| joined(of.map(each), ", "));
    let percent = 100.0 * (PARAMETER_FACTOR - 1.0);
    let line = format!(
        "each parameter {percent:.0} % larger moves the {ends} ends of the zones by up to (m): \
            {named}; those that the paper does not name: {others}"
    );
    vec![statement(Exact, [(what, ends > 0 && moves)], line)]
}

/// Times in one forcing period, including a quarter and three quarters of it.
const TIMES_IN_PERIOD: u32 = 48;

/// Motion of the stick zone over a forcing period.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneMotion {
    /// Whether the zone has six ends at all times.
    six_ends: bool,
    /// Largest difference of an end, bisected along Σ by the test for sticking, from `z_k + A
    /// sin(ωt)` (m).
    largest_difference: f64,
    /// The ends at time 0 (m), ascending. The support then has no displacement.
    pub at_rest: Vec<f64>,
    /// Travel of the uppermost end along x1 (m), and twice the amplitude A of the support (m).
    travel_x1: f64,
    twice_amplitude: f64,
    /// Travel of Σ, and of the zone in it, along x2 (m/s): the velocity at which the boundary
    /// function vanishes at the zone's ends.
    travel_x2: f64,
}

impl ZoneMotion {
    /// Bisects along Σ at all times.
    pub(super) fn of(model: &ForcedOscillator, set: &TangentSet) -> ZoneMotion {
        let times = (0..TIMES_IN_PERIOD).into_par_iter();
        let over_time: Vec<(f64, Vec<f64>)> = times
            .map(|k| {
                let t = model.period() * f64::from(k) / f64::from(TIMES_IN_PERIOD);
                (t, stick_ends(model, t))
            })
            .collect();
        // Time, end, and tangent point.
        let mut ends = Vec::new();
        for (t, of_time) in &over_time {
            let numbered = of_time.iter().rev().zip(set.0);
            ends.extend(numbered.map(|(end, z)| (*t, *end, z)));
        }
        let travel = |(low, high): (f64, f64)| high - low;
        let last = over_time
            .iter()
            .filter_map(|(_, ends)| ends.last().copied());
        // The velocity (m/s) at which the boundary function vanishes for a position.
        let speed = |&(t, x1, _): &(f64, f64, f64)| {
            bisect(-10.0, 10.0, |x2| model.boundary(t, &[x1, x2]) >= 0.0)
        };
        let off = |&(t, end, z): &(f64, f64, f64)| (end - (z + model.support(t))).abs();
        ZoneMotion {
            six_ends: over_time.iter().all(|(_, ends)| ends.len() == 6),
            largest_difference: largest(ends.iter().map(off)),
            travel_x1: travel(extent(last)),
            twice_amplitude: 2.0 * model.amplitude,
            travel_x2: travel(extent(ends.iter().map(speed))),
            at_rest: over_time
                .into_iter()
                .next()
                .map_or_else(Vec::new, |one| one.1),
        }
    }

    /// `s4.zone_oscillates`.
    pub(super) fn zone(&self) -> Vec<Finding> {
        let ZoneMotion {
            travel_x1,
            travel_x2,
            twice_amplitude,
            ..
        } = self;
        let moves = self.six_ends && self.largest_difference <= ROUNDING && self.along_x1();
        let parts = [
            ("the tangent points move by A sin(ωt)", moves),
            ("the zone oscillates along x2", *travel_x2 > ROUNDING),
        ];
        let difference = small(self.largest_difference);
        let line = format!(
            "ends of the stick zone bisected along Σ at {TIMES_IN_PERIOD} times of a period: \
             within {difference} m of z_k + A sin(ωt); they travel {travel_x1:.4} m along x1, \
             twice A being {twice_amplitude:.4} m, and {travel_x2} m/s along x2"
        );
        vec![statement(Exact, parts, line)]
    }

    fn along_x1(&self) -> bool {
        (self.travel_x1 - self.twice_amplitude).abs() <= ROUNDING
    }

    /// `s6.oscillating_boundary`.
    pub(super) fn boundary(&self) -> Vec<Finding> {
        let (boundary, zone) = (self.travel_x2, self.travel_x1);
        let what = "the harmonic excitation moves the stick zone in it";
        let parts = [
            ("the boundary of discontinuity oscillates", boundary > 0.0),
            (what, zone > 0.0),
        ];
        let line = format!(
            "over a forcing period Σ travels {boundary} m/s along x2; the stick zone in it travels \
                {zone:.4} m along x1"
        );
        vec![statement(Exact, parts, line)]
    }

    /// The direction in which the zone is said to oscillate.
    pub(super) fn direction(&self) -> Proof {
        let (x1, x2) = (self.travel_x1, self.travel_x2);
        let which = match (x1 > 0.0, x2 > 0.0) {
            (true, true) => "both",
            (true, false) => "x1",
            (false, true) => "x2",
            (false, false) => "neither",
        };
        let travels = [x1, self.twice_amplitude, x2].map(Value::from);
        let shown = travels.into_iter().chain([which.into()]);
        Proof::new("direction", shown, self.along_x1() && x2 == 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::published::Claims;

    fn published() -> TangentSet {
        TangentSet::published(Claims::committed().unwrap())
    }

    /// Friction that drives the body.
    fn driving() -> ForcedOscillator {
        let model = ForcedOscillator::default();
        ForcedOscillator {
            mu0: -model.mu0,
            ..model
        }
    }

    #[test]
    fn springs_and_friction_move_the_zones_and_nothing_else_does() {
        let model = ForcedOscillator::default();
        assert_eq!(location(&model)[0].parts(), [true]);
        let others = shifts(&model, OTHERS);
        assert!(others.iter().all(|one| one.1.1 <= ROUNDING), "{others:?}");
        assert_eq!(stick_ends(&model, 0.0).len(), 6);
        assert_eq!(location(&driving())[0].parts(), [false]);
    }

    #[test]
    fn the_zone_moves_along_x1_and_not_along_x2() {
        let (model, set) = (ForcedOscillator::default(), published());
        let found = ZoneMotion::of(&model, &set);
        assert_eq!(found.zone()[0].parts(), [true, false], "{found:?}");
        assert_eq!(found.boundary()[0].parts(), [false, true]);
        assert!(found.direction().holds);
        let along_x2 = ZoneMotion {
            travel_x2: 0.1,
            ..found.clone()
        };
        assert!(!along_x2.direction().holds);
        let at_rest = ZoneMotion {
            travel_x1: 0.0,
            ..found
        };
        assert_eq!(at_rest.boundary()[0].parts(), [false, false]);
    }

    #[test]
    fn another_friction_or_a_displaced_point_fails() {
        let (model, mut set) = (ForcedOscillator::default(), published());
        let moves = |model: &ForcedOscillator, set: &TangentSet| {
            ZoneMotion::of(model, set).zone()[0].parts()[0]
        };
        let stronger = ForcedOscillator {
            mu0: 1.001 * model.mu0,
            ..model
        };
        assert!(!moves(&stronger, &set));
        assert!(!ZoneMotion::of(&driving(), &set).six_ends);
        set.0[3] += 1e-9;
        assert!(!moves(&model, &set));
    }
}
