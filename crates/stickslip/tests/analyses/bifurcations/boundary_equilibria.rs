//! Orbits that shrink to an equilibrium on the discontinuity boundary.

use stickslip::analysis::{
    ContinuationSettings, Kind, RecurrenceSettings, Stop, SweepSettings, WhatChanges, attractor,
    continue_periodic_orbit, sweep,
};
use stickslip::{Mode, Options, solve};

use super::sweeps::kept;
use super::systems::{AtParameter, Lags};
use crate::listed::Listed;

/// The equilibrium of either side is on the boundary where the threshold is the state that it rests at.
#[test]
fn the_end_of_a_branch_is_known_to_rounding() {
    let settings = ContinuationSettings::over(-2.0, 2.0);
    let options = Options::tol(1e-12);
    for (upwards, exact) in [(false, -1.0), (true, 1.0)] {
        let start = [-0.7, -0.1, 0.1, 0.0];
        let settled = solve(&Lags.any(), 0.0, start, 200.0, &options).unwrap();
        let x = settled.x_end;
        let found =
            continue_periodic_orbit(&Lags.any(), x, 3.67, upwards, &settings, &options).unwrap();
        let Stop::BoundaryEquilibrium { parameter } = found.stop else {
            panic!("{:?}", found.stop);
        };
        assert!((parameter - exact).abs() < 1e-12, "{parameter}");
        assert_eq!(found.special, []);
    }
}

/// Also where a value of the sweep hits it.
#[test]
fn a_sweep_finds_it_from_the_side_of_the_equilibrium_or_from_that_of_the_orbit() {
    for values in [[0.9, 1.1], [1.1, 0.9], [0.9, 1.0], [1.0, 1.2]] {
        let family = |value| {
            kept(AtParameter {
                system: Lags,
                value,
            })
            .any()
        };
        let start = [0.5, 0.1, 0.3];
        let settings = SweepSettings::within(300.0);
        let found = sweep(family, values, start, &settings, &Options::tol(1e-10)).unwrap();
        let at: Vec<_> = found.changes.iter().map(|change| &change.what).collect();
        match at.as_slice() {
            [WhatChanges::BoundaryEquilibrium { parameter, x }] => {
                assert!((parameter - 1.0).abs() < 1e-12, "{values:?}: {parameter}");
                assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-12), "{values:?}: {x}");
            }
            // What rests on the boundary is the same attractor as what rests beside it.
            [] => assert_eq!(values[0], 1.0),
            other => panic!("{values:?}: {other:?}"),
        }
    }
}

/// There both fields are tangent, and no sliding field is determined: it slid off, in ever shorter steps.
#[test]
fn on_the_boundary_the_equilibrium_is_rested_in_and_nothing_sticks() {
    let system = AtParameter {
        system: Lags,
        value: 1.0,
    };
    let (start, options) = ([0.5, 0.1, 0.3], Options::tol(1e-10));
    let orbit = match solve(&system.any(), 0.0, start, 60.0, &options) {
        Ok(orbit) => orbit,
        // Rounding may take it to either side again and again.
        Err(failure) => *failure.reached,
    };
    assert!(orbit.t_end > 30.0);
    assert!(orbit.phases.iter().all(|phase| phase.mode != Mode::Stick));
    assert!(
        orbit.x_end.iter().all(|x| (x - 1.0).abs() < 1e-12),
        "{}",
        orbit.x_end
    );
    let settings = RecurrenceSettings::within(500.0);
    let reached = attractor(&system.any(), start, &settings, &options).unwrap();
    assert_eq!(reached.kind, Kind::Equilibrium);
}
