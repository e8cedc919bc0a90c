//! Orbits that shrink to an equilibrium on the discontinuity boundary.

use std::f64::consts::PI;

use stickslip::analysis::{
    AttractorKind, ContinuationSettings, RecurrenceSettings, Stop, WhatChanges, attractor,
    continue_periodic_orbit,
};
use stickslip::{Fate, Filippov, Mode, Options, Scalar, Side, State, fate, math, solve};

use super::branches::accuracies;
use super::sweeps::{leaked, swept};
use super::systems::{AtParameter, Focus, Lags, Persists};
use crate::compiled::{Compiled, traced};

const ONE: Lags = Lags { unit: 1.0 };

/// The equilibrium of either side is on the boundary where the threshold equals its state, in any
/// unit of the threshold.
#[test]
fn the_end_of_a_branch_is_known_to_rounding() {
    let units = [1.0, 1e-3, 1e6].into_iter();
    for (unit, (_, options)) in units.flat_map(|unit| accuracies().map(move |at| (unit, at))) {
        let settings = ContinuationSettings::over(-2.0 / unit, 2.0 / unit);
        for (upwards, exact) in [(false, -1.0), (true, 1.0)] {
            let (system, start) = (Lags { unit }, [-0.7, -0.1, 0.1, 0.0]);
            let settled = solve(&system.any(), 0.0, start, 200.0, &options).unwrap();
            let x = settled.x_end;
            let found =
                continue_periodic_orbit(&system.dynamics(), x, 3.67, upwards, &settings, &options);
            let found = found.unwrap();
            let Stop::BoundaryEquilibrium { parameter } = found.stop else {
                panic!("{unit}: {:?}", found.stop);
            };
            assert!((parameter * unit - exact).abs() < 1e-12, "{parameter}");
            assert_eq!(found.special, []);
        }
    }
}

/// If the range ends earlier, the branch ends at the end of the range.
#[test]
fn one_beyond_the_range_is_none() {
    let options = Options::tol(1e-12);
    let start = [-0.7, -0.1, 0.1, 0.0];
    let x = solve(&ONE.any(), 0.0, start, 200.0, &options)
        .unwrap()
        .x_end;
    let settings = ContinuationSettings::over(-2.0, 0.999999);
    let found =
        continue_periodic_orbit(&ONE.dynamics(), x, 3.67, true, &settings, &options).unwrap();
    assert_eq!(found.stop, Stop::Range);
    let last = found.points.last().unwrap();
    assert!((last.parameter - 0.999999).abs() < 1e-12);
}

/// Also if a value of the sweep hits it.
#[test]
fn a_sweep_finds_it_from_the_side_of_the_equilibrium_or_from_that_of_the_orbit() {
    for values in [[0.9, 1.1], [1.1, 0.9], [0.9, 1.0], [1.0, 1.2]] {
        let family = |value| leaked(AtParameter { system: ONE, value }).dynamics();
        let start = [0.5, 0.1, 0.3];
        let settings = RecurrenceSettings::within(300.0);
        let any = ONE.dynamics();
        for (_, options) in accuracies() {
            let found = swept((family, &any), values, start, &settings, &options);
            let at: Vec<_> = found.changes.iter().map(|change| &change.what).collect();
            // The equilibrium on the boundary is the same attractor as the one beside it.
            if values[0] == 1.0 {
                assert!(at.is_empty(), "{at:?}");
                continue;
            }
            let [WhatChanges::BoundaryEquilibrium { parameter, x }] = at.as_slice() else {
                panic!("{values:?}: {at:?}");
            };
            assert!((parameter - 1.0).abs() < 1e-12, "{values:?}: {parameter}");
            assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-12), "{values:?}: {x}");
        }
    }
}

/// Where the focus comes to the boundary, the equilibrium of the sliding field replaces it.
#[test]
fn an_equilibrium_that_goes_over_into_sliding_is_located_there() {
    for values in [[-0.3, 0.5], [0.5, -0.3]] {
        let family = |value| {
            leaked(AtParameter {
                system: Persists,
                value,
            })
            .dynamics()
        };
        let settings = RecurrenceSettings::within(300.0);
        let (any, start) = (Persists.dynamics(), [-0.4, 0.1]);
        for (_, options) in accuracies() {
            let found = swept((family, &any), values, start, &settings, &options);
            let [change] = found.changes.as_slice() else {
                panic!("{:?}", found.changes);
            };
            let WhatChanges::BoundaryEquilibrium { parameter, x } = change.what.clone() else {
                panic!("{change:?}");
            };
            assert!(
                parameter.abs() < 1e-12 && x.amax() < 1e-12,
                "{parameter}: {x}"
            );
            let modes = found.points.iter().map(|point| point.reached.mode);
            let slips = modes
                .filter(|mode| *mode == Mode::Slip(Side::Below))
                .count();
            assert_eq!(slips, 1);
        }
    }
}

/// There both fields are tangent, and the sliding field is undetermined. Sliding off in ever
/// shorter steps would be wrong.
#[test]
fn on_the_boundary_the_equilibrium_is_rested_in_and_nothing_sticks() {
    let system = AtParameter {
        system: ONE,
        value: 1.0,
    };
    let (start, options) = ([0.5, 0.1, 0.3], Options::tol(1e-10));
    let orbit = match solve(&system.any(), 0.0, start, 60.0, &options) {
        Ok(orbit) => orbit,
        // Rounding may move it to either side repeatedly.
        Err(failure) => *failure.partial,
    };
    assert!(orbit.t_end > 30.0);
    assert!(orbit.phases.iter().all(|phase| phase.mode != Mode::Stick));
    assert!(
        orbit.x_end.iter().all(|x| (x - 1.0).abs() < 1e-12),
        "{}",
        orbit.x_end
    );
    assert_eq!(
        fate(&system, 0.0, &State::from([1.0; 3])),
        Fate::Slip(Side::Below)
    );
    let settings = RecurrenceSettings::within(500.0);
    for start in [start, [1.2, 0.9, 0.4], [0.0; 3], [1.0, 1.0, 0.9]] {
        for tolerance in [1e-8, 1e-10, 1e-12] {
            let options = Options::tol(tolerance);
            let reached = attractor(&system.dynamics(), start, &settings, &options).unwrap();
            assert_eq!(
                reached.kind,
                AttractorKind::Equilibrium,
                "{start:?} {tolerance:e}"
            );
        }
    }
}

/// A tangency on both sides: below, orbits leave a tangent point along y = x⁴, where three
/// derivatives vanish. Above, they return to it.
struct Flat;

impl Filippov<2> for Flat {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, _]: &[T; 2]) -> [T; 2] {
        match side {
            Side::Below => [T::constant(1.0), x * x * x * 4.0],
            Side::Above => [T::constant(1.0), -x],
        }
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}

#[test]
fn what_moves_along_the_boundary_does_not_rest_on_it() {
    assert_eq!(fate(&Flat, 0.0, &State::from([0.0; 2])), Fate::Stick);
}

/// The slip from the tangent point, at the height of the growth, lands at the sliding field's
/// equilibrium.
#[test]
fn a_branch_ends_in_a_homoclinic_orbit_of_the_sliding_field() {
    // The orbit returns to the boundary, rotated by almost 3π/2 and grown, where 1 + r cos φ = 0
    // again.
    let landing = |grows: f64| {
        let (mut low, mut high) = (PI, 2.0 * PI);
        for _ in 0..60 {
            let t = 0.5 * (low + high);
            // At t = 0 it has the height `grows` and the distance 1 from the focus.
            let off = math::exp(grows * t) * (math::cos(t) - grows * math::sin(t));
            if off < 1.0 {
                low = t;
            } else {
                high = t;
            }
        }
        math::exp(grows * low) * (math::sin(low) + grows * math::cos(low))
    };
    let equilibrium = |grows: f64| (1.0 + Focus::ABOVE * grows) / (Focus::ABOVE - grows);
    let (mut low, mut high) = (0.1, 0.3);
    for _ in 0..60 {
        let grows = 0.5 * (low + high);
        if landing(grows) > equilibrium(grows) {
            low = grows;
        } else {
            high = grows;
        }
    }
    let settings = ContinuationSettings::over(0.05, 0.5);
    for (tolerance, options) in accuracies() {
        let start = [-1e-9, 0.1, 0.1];
        let found =
            continue_periodic_orbit(&Focus.dynamics(), start, 8.70, true, &settings, &options);
        let Stop::Homoclinic {
            parameter,
            uncertainty,
            comes,
            ..
        } = found.unwrap().stop
        else {
            panic!();
        };
        let off = (parameter - low).abs();
        assert!(
            off < tolerance && off <= uncertainty && uncertainty < 10.0 * tolerance + 1e-8,
            "{parameter} for {low}: {uncertainty:e} at {tolerance:e}"
        );
        assert_eq!(comes, f64::NEG_INFINITY);
    }
}

/// Two tangencies that coincide: below `y = 0` the field `(-1, 1/10 - x)`, above it
/// `(1, p - sin x - x²)`. Orbits cross and turn about the points where these are tangent, which
/// coincide at p = sin(1/10) + 1/100.
struct Turns;

traced!(3: Turns);

impl Filippov<3> for Turns {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, _, p]: &[T; 3]) -> [T; 3] {
        match side {
            Side::Below => [T::constant(-1.0), -x + 0.1, T::zero()],
            Side::Above => [T::constant(1.0), p - x.sin() - x * x, T::zero()],
        }
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1]
    }
}

#[test]
fn crossing_orbits_shrink_to_a_two_fold_at_a_known_parameter() {
    let exact = math::sin(0.1) + 0.01;
    let settings = ContinuationSettings::over(0.0, 0.5);
    for (tolerance, options) in accuracies() {
        let settled = solve(&Turns.any(), 0.0, [-0.9, 0.05, 0.3], 200.0, &options).unwrap();
        let crossings = settled.transitions.iter().rev();
        let mut upwards = crossings.filter(|at| at.to == Mode::Slip(Side::Above));
        let [last, before] = [upwards.next().unwrap().t, upwards.next().unwrap().t];
        let (start, period) = (settled.x_end, last - before);
        let found =
            continue_periodic_orbit(&Turns.dynamics(), start, period, false, &settings, &options);
        let found = found.unwrap();
        let Stop::TwoFold {
            parameter,
            uncertainty,
        } = found.stop
        else {
            panic!("{tolerance:e}: {:?}", found.stop);
        };
        // It is extrapolated until it is known to a billionth of the range.
        let off = (parameter - exact).abs();
        assert!(
            off <= uncertainty && uncertainty < 1e-9,
            "{tolerance:e}: {off:e} of {uncertainty:e}"
        );
    }
}
