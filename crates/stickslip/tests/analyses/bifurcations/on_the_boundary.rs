//! Periodic orbits on which a contact sticks all the time, on a curved boundary.

use std::f64::consts::PI;

use stickslip::analysis::{
    ContinuationSettings, Kind, SequenceBifurcation, Special, Stop, SweepSettings, WhatChanges,
    continue_periodic_orbit, find_periodic_orbit, is_same_cycle, multipliers, sweep,
};
use stickslip::{Mode, Options, Side, math};

use super::systems::{AtParameter, Lies, Shaken, Sheet};
use crate::listed::Listed;

const PULLED: Sheet = Sheet { lies: Lies::Pulled };

#[test]
fn an_orbit_that_never_slips_is_found_with_its_multipliers() {
    let system = AtParameter {
        system: PULLED,
        value: 2.0,
    };
    // Of many returns, all of them back to what rounding leaves, the first is the period.
    let starts = [
        ([0.3, 0.4, 3.0], 1e-12, 30.0),
        ([-2.0, 0.1, -1.0], 1e-9, 30.0),
        ([0.3, 0.4, 3.0], 1e-9, 500.0),
    ];
    for (start, tolerance, longest) in starts {
        let options = Options::tol(tolerance);
        let cycle = find_periodic_orbit(&system.any(), start, 3.0, longest, &options).unwrap();
        let near = 1e3 * tolerance;
        assert!((cycle.period - 2.0 * PI).abs() < near, "{}", cycle.period);
        assert!((cycle.x.xy().norm() - 1.0).abs() < near);
        assert!((cycle.x[2] - cycle.x[0] * cycle.x[0]).abs() < 1e-15);
        let [along, inwards, across] = multipliers(&cycle.monodromy);
        assert!((along.re - 1.0).abs() < 1e3 * near);
        // d(r - r³)/dr = -2, and stick forgets what was across the boundary.
        assert!((inwards.re - math::exp(-4.0 * PI)).abs() < 1e3 * near);
        assert!(across.norm() < 1e-12, "{across}");
    }
}

#[test]
fn it_is_followed_round_a_fold_on_a_boundary_that_moves_with_the_parameter() {
    let system = Sheet { lies: Lies::Folded };
    let settings = ContinuationSettings::over(-1.5, 0.5);
    let p: f64 = -0.5;
    let x = (1.0 + (1.0 + p).sqrt()).sqrt();
    let start = [x, 0.0, x * x + p, p];
    let options = Options::tol(1e-13);
    let found =
        continue_periodic_orbit(&system.any(), start, 6.2, false, &settings, &options).unwrap();
    let [fold] = found.special.as_slice() else {
        panic!("{:?}", found.special);
    };
    assert_eq!(fold.what, Special::Fold);
    // The focus in the sliding field that the inner cycle shrinks to; the boundary is elsewhere at every parameter.
    let Stop::Equilibrium {
        parameter,
        frequency,
    } = found.stop
    else {
        panic!("{:?}", found.stop);
    };
    assert!(
        parameter.abs() < 1e-9 && (frequency - 1.0).abs() < 1e-9,
        "{parameter:e} {frequency}"
    );
    assert!((fold.parameter + 1.0).abs() < 1e-9, "{}", fold.parameter);
    for (k, point) in found.points.iter().enumerate() {
        let [x, y, z, p] = [0, 1, 2, 3].map(|i| point.x[i]);
        let square = x * x + y * y;
        let root = (1.0 + p).max(0.0).sqrt();
        let exact = if k < fold.behind {
            1.0 + root
        } else {
            1.0 - root
        };
        assert!((square - exact).abs() < 1e-6, "{k}: {square} for {exact}");
        assert!((z - x * x - p).abs() < 1e-14);
        assert_eq!(point.sequence, [Mode::Stick]);
        let multiplier = math::exp(8.0 * PI * square * (1.0 - square));
        let [inwards, across] = point.multipliers.as_slice() else {
            panic!("{:?}", point.multipliers);
        };
        assert!((inwards.re - multiplier).abs() < 1e-7 * multiplier.max(1.0));
        assert!(across.norm() < 1e-10, "{across}");
    }
}

/// On the way from here up or down: where the pull `x + 1/10` is no more than `p` at x = 1, and where `-x - 1/10` is not at x = -1.
#[test]
fn where_it_begins_to_slip_is_located_from_both_sides() {
    let (exact, options) = (1.1, Options::tol(1e-13));
    for (from, upwards) in [(1.5, false), (0.7, true)] {
        let system = AtParameter {
            system: PULLED,
            value: from,
        };
        let cycle = find_periodic_orbit(&system.any(), [0.9, 0.0, 0.8], 20.0, 30.0, &options);
        let cycle = cycle.unwrap();
        let start = [cycle.x[0], cycle.x[1], cycle.x[2], from];
        for step in [0.02, 0.007] {
            let settings = ContinuationSettings {
                step,
                ..ContinuationSettings::over(0.7, 1.5)
            };
            let of = (start, cycle.period, upwards);
            let found =
                continue_periodic_orbit(&PULLED.any(), of.0, of.1, of.2, &settings, &options)
                    .unwrap();
            assert_eq!(found.stop, Stop::Range, "{:?}", found.special);
            let places = if upwards { [0.9, 1.1] } else { [1.1, 0.9] };
            assert_eq!(found.special.len(), places.len(), "{:?}", found.special);
            for (special, exact) in found.special.iter().zip(places) {
                let Special::Sequence(change) = &special.what else {
                    panic!("{special:?}");
                };
                assert_eq!(change.bifurcation, SequenceBifurcation::AddingSliding);
                let error = (change.parameter - exact).abs();
                assert!(
                    error < 1e-9 && change.uncertainty < 1e-9 && error <= 3.0 * change.uncertainty,
                    "from {from} by {step}: {error:e} {change:?}"
                );
                let more = [&change.before, &change.after].map(|modes| modes.len());
                let [stuck, slips] = if upwards { [1, 0] } else { [0, 1] }.map(|i: usize| more[i]);
                assert!(
                    slips == stuck + if stuck == 1 { 1 } else { 2 },
                    "{change:?}"
                );
            }
            let stuck = found
                .points
                .iter()
                .filter(|at| at.sequence == [Mode::Stick]);
            assert!(stuck.count() > 3);
        }
    }
    for ends in [[1.3, 1.0], [1.0, 1.3]] {
        let family = |value| {
            let system = AtParameter {
                system: PULLED,
                value,
            };
            Box::leak(Box::new(system)).any()
        };
        let settings = SweepSettings::within(400.0);
        let found = sweep(
            family,
            ends,
            [0.9, 0.0, 0.8],
            &settings,
            &Options::tol(1e-11),
        )
        .unwrap();
        let is_periodic = |kind: &Kind| matches!(kind, Kind::Periodic { .. });
        assert!(
            found
                .points
                .iter()
                .all(|point| is_periodic(&point.reached.kind))
        );
        let [change] = found.changes.as_slice() else {
            panic!("{:?}", found.changes);
        };
        let WhatChanges::Sequence(change) = &change.what else {
            panic!("{change:?}");
        };
        assert_eq!(change.bifurcation, SequenceBifurcation::AddingSliding);
        let error = (change.parameter - exact).abs();
        assert!(error < 1e-9 && change.uncertainty < 1e-9, "{change:?}");
        // In the order of the sweep.
        let stuck = if ends[0] > exact {
            &change.before
        } else {
            &change.after
        };
        assert_eq!(stuck.as_slice(), [Mode::Stick], "{ends:?}");
    }
}

/// Here the section that the sweep sees an orbit by lies where the first slip begins.
#[test]
fn the_phases_on_both_sides_are_told_where_slip_begins_at_the_start() {
    for ends in [[1.05, 1.15], [1.15, 1.05]] {
        let family = |value| {
            let system = AtParameter {
                system: PULLED,
                value,
            };
            Box::leak(Box::new(system)).any()
        };
        let settings = SweepSettings::within(2000.0);
        let start = [1.0, 0.0, 1.0];
        let found = sweep(family, ends, start, &settings, &Options::tol(1e-10)).unwrap();
        let [change] = found.changes.as_slice() else {
            panic!("{:?}", found.changes);
        };
        let WhatChanges::Sequence(change) = &change.what else {
            panic!("{change:?}");
        };
        assert!((change.parameter - 1.1).abs() < 1e-9, "{change:?}");
        let [one, other] = [&change.before, &change.after];
        let [stuck, slips] = if ends[0] > 1.1 {
            [one, other]
        } else {
            [other, one]
        };
        let slip = Mode::Slip(Side::Above);
        assert_eq!(stuck.as_slice(), [Mode::Stick], "{ends:?}");
        assert!(
            is_same_cycle(slips, &[slip, Mode::Stick]),
            "{ends:?} {slips:?}"
        );
    }
}

/// `v' = -p sgn(v - V(t))` on a belt of speed `V = (3/2) sin t`: what friction can give is enough for `p > 3/2`, in the same two instants of a period up
/// and down.
#[test]
fn on_a_belt_that_shakes_the_block_sticks_for_ever_from_a_known_friction_on() {
    let options = Options::tol(1e-13);
    for (from, upwards) in [(2.5, false), (1.4, true)] {
        for step in [0.02, 0.005] {
            let settings = ContinuationSettings {
                step,
                ..ContinuationSettings::over(1.4, 2.5).forced(2.0 * PI)
            };
            let start = [0.0, from];
            let found =
                continue_periodic_orbit(&Shaken.any(), start, 6.3, upwards, &settings, &options);
            let found = found.unwrap();
            let [change] = found.special.as_slice() else {
                panic!("{:?}", found.special);
            };
            let Special::Sequence(change) = &change.what else {
                panic!("{change:?}");
            };
            assert_eq!(change.bifurcation, SequenceBifurcation::AddingSliding);
            let error = (change.parameter - 1.5).abs();
            assert!(
                error < 1e-9 && error <= 3.0 * change.uncertainty,
                "from {from} by {step}: {error:e} {change:?}"
            );
            if !upwards {
                assert_eq!(change.before, [Mode::Stick]);
            }
        }
    }
}
