//! Periodic orbits on which a contact always sticks, on a curved boundary.

use std::f64::consts::PI;

use crate::is_same_cycle;
use stickslip::analysis::{
    AttractorKind, ContinuationSettings, CycleBifurcation, PeriodicOrbit, RecurrenceSettings,
    SequenceBifurcation, Stop, WhatChanges, continue_periodic_orbit, multipliers,
};
use stickslip::{Method, Mode, Options, Side, math};

use super::branches::{accuracies, is_hopf_at_zero, is_within, square_of_radius};
use super::sweeps::{leaked, swept};
use super::systems::{AtParameter, Pulse, Shaken, Sheet, SheetVariant};
use crate::compiled::Compiled;

const PULLED: Sheet = Sheet {
    variant: SheetVariant::Pulled,
};

/// A long and a short step, at each accuracy.
fn steps() -> impl Iterator<Item = (f64, (f64, Options))> {
    let steps = [0.02, 0.005].into_iter();
    steps.flat_map(|step| accuracies().map(move |at| (step, at)))
}

#[test]
fn an_orbit_that_never_slips_is_found_with_its_multipliers() {
    let system = AtParameter {
        system: PULLED,
        value: 2.0,
    };
    for (start, tolerance) in [([0.3, 0.4, 3.0], 1e-12), ([-2.0, 0.1, -1.0], 1e-9)] {
        let options = Options::tol(tolerance);
        let cycle =
            PeriodicOrbit::approached(&system.dynamics(), start, 3.0, 30.0, &options).unwrap();
        let near = 1e3 * tolerance;
        assert!((cycle.period - 2.0 * PI).abs() < near, "{}", cycle.period);
        assert!((cycle.x.rows(0, 2).norm() - 1.0).abs() < near);
        assert!((cycle.x[2] - cycle.x[0] * cycle.x[0]).abs() < 1e-15);
        let found = multipliers(&cycle.monodromy);
        let [along, inwards, across] = found[..] else {
            panic!("{found:?}");
        };
        assert!((along.re - 1.0).abs() < 1e3 * near);
        // d(r - r³)/dr = -2, and stick annihilates the direction across the boundary.
        assert!((inwards.re - math::exp(-4.0 * PI)).abs() < 1e3 * near);
        assert!(across.norm() < 1e-12, "{across}");
    }
}

/// Among many returns that all close to rounding, the first gives the period.
#[test]
fn a_strongly_attracting_orbit_is_not_found_with_several_times_its_period() {
    let system = AtParameter {
        system: Sheet {
            variant: SheetVariant::Growing,
        },
        value: -0.1,
    };
    for method in [Method::Taylor, Method::Dop853] {
        for tolerance in [1e-9, 1e-10, 1e-11, 1e-12] {
            let (start, options) = ([1.0, 0.0, 0.0], Options::tol(tolerance).method(method));
            let cycle =
                PeriodicOrbit::approached(&system.dynamics(), start, 200.0, 100.0, &options)
                    .unwrap();
            assert!((cycle.period - PI).abs() < 1e-7, "{}", cycle.period);
        }
    }
}

#[test]
fn it_is_followed_round_a_fold_on_a_boundary_that_moves_with_the_parameter() {
    let system = Sheet {
        variant: SheetVariant::Folded,
    };
    for (tolerance, options) in accuracies() {
        let settings = ContinuationSettings::over(-1.5, 0.5);
        let p: f64 = -0.5;
        let x = (1.0 + (1.0 + p).sqrt()).sqrt();
        let start = [x, 0.0, x * x + p, p];
        let found =
            continue_periodic_orbit(&system.dynamics(), start, 6.2, false, &settings, &options)
                .unwrap();
        let [fold] = found.special.as_slice() else {
            panic!("{:?}", found.special);
        };
        assert_eq!(fold.what, CycleBifurcation::Fold);
        // The focus in the sliding field to which the inner cycle shrinks. The boundary is
        // elsewhere at every parameter.
        is_hopf_at_zero(found.stop);
        is_within(fold.parameter + 1.0, fold.uncertainty, tolerance);
        for (k, point) in found.points.iter().enumerate() {
            let [x, y, z, p] = [0, 1, 2, 3].map(|i| point.x[i]);
            let square = x * x + y * y;
            let exact = square_of_radius(k < fold.behind, p);
            assert!(
                (square - exact).abs() < 1e4 * tolerance,
                "{k}: {square} for {exact}"
            );
            assert!((z - x * x - p).abs() < 1e-14);
            assert_eq!(point.sequence, [Mode::Stick]);
            let multiplier = math::exp(8.0 * PI * square * (1.0 - square));
            let [inwards, across] = point.multipliers.as_slice() else {
                panic!("{:?}", point.multipliers);
            };
            assert!(
                (inwards.re - multiplier).abs() < 1e5 * tolerance * multiplier.max(1.0),
                "{k} {inwards} {across} {multiplier}"
            );
            assert!(across.norm() < 1e-10, "{across}");
        }
    }
}

/// The two ends of permanent stick: where the pull `x + 1/10` reaches `p` at x = 1, and where `-x -
/// 1/10` does at x = -1.
#[test]
fn where_it_begins_to_slip_is_located_from_both_sides() {
    let both = [(1.5, false), (0.7, true)].into_iter();
    for ((from, upwards), (tolerance, options)) in
        both.flat_map(|one| accuracies().map(move |at| (one, at)))
    {
        let system = AtParameter {
            system: PULLED,
            value: from,
        };
        let cycle =
            PeriodicOrbit::approached(&system.dynamics(), [0.9, 0.0, 0.8], 20.0, 30.0, &options);
        let cycle = cycle.unwrap();
        let start = [cycle.x[0], cycle.x[1], cycle.x[2], from];
        for step in [0.02, 0.007] {
            let settings = ContinuationSettings {
                step,
                ..ContinuationSettings::over(0.7, 1.5)
            };
            let (any, period) = (PULLED.dynamics(), cycle.period);
            let found = continue_periodic_orbit(&any, start, period, upwards, &settings, &options);
            let found = found.unwrap();
            assert_eq!(found.stop, Stop::Range, "{:?}", found.special);
            let places = if upwards { [0.9, 1.1] } else { [1.1, 0.9] };
            assert_eq!(found.special.len(), places.len(), "{:?}", found.special);
            for (special, exact) in found.special.iter().zip(places) {
                let CycleBifurcation::Sequence(change) = &special.what else {
                    panic!("{special:?}");
                };
                assert_eq!(change.bifurcation, SequenceBifurcation::AddingSliding);
                is_within(change.parameter - exact, change.uncertainty, tolerance);
                let phases = [change.before.len(), change.after.len()];
                let mut wanted = if exact == 1.1 { [1, 2] } else { [2, 4] };
                if upwards {
                    wanted.reverse();
                }
                assert_eq!(phases, wanted, "{change:?}");
            }
            let stuck = found
                .points
                .iter()
                .filter(|at| at.sequence == [Mode::Stick]);
            assert!(stuck.count() > 3);
        }
    }
}

/// For the first pair one slip begins. For the second pair two slips begin at the same time in each
/// half turn, one of them at the section of the sweep.
#[test]
fn a_sweep_locates_it_and_tells_the_phases_on_both_sides() {
    let [below, above] = [Side::Below, Side::Above].map(Mode::Slip);
    let one = [above, Mode::Stick];
    let two = [above, Mode::Stick, below, Mode::Stick];
    let cases: [(SheetVariant, [f64; 2], f64, &[Mode]); 2] = [
        (SheetVariant::Pulled, [1.3, 1.0], 1.1, &one),
        (SheetVariant::Growing, [0.24, 0.26], 0.2541, &two),
    ];
    for (variant, [stuck, slipping], exact, cycle) in cases {
        for ends in [[stuck, slipping], [slipping, stuck]] {
            let family = |value| {
                let system = Sheet { variant };
                Box::leak(Box::new(AtParameter { system, value })).dynamics()
            };
            let settings = RecurrenceSettings::within(2000.0);
            let start = [0.9, 0.0, 0.0];
            let any = leaked(Sheet { variant }).dynamics();
            for (tolerance, options) in accuracies() {
                let found = swept((family, &any), ends, start, &settings, &options);
                for point in &found.points {
                    let kind = &point.reached.kind;
                    assert!(
                        matches!(kind, AttractorKind::Periodic { .. }),
                        "{ends:?}: {kind}"
                    );
                }
                let [change] = found.changes.as_slice() else {
                    panic!("{:?}", found.changes);
                };
                let WhatChanges::Sequence(change) = &change.what else {
                    panic!("{change:?}");
                };
                assert_eq!(change.bifurcation, SequenceBifurcation::AddingSliding);
                is_within(change.parameter - exact, change.uncertainty, tolerance);
                // In the order of the sweep.
                let (mut one, mut other) = (&change.before, &change.after);
                if ends[0] == slipping {
                    (one, other) = (other, one);
                }
                assert_eq!(one.as_slice(), [Mode::Stick], "{ends:?}");
                assert!(is_same_cycle(other, cycle), "{ends:?}: {other:?}");
            }
        }
    }
}

/// `v' = -p sgn(v - V(t))` on a belt of speed V. Friction suffices where p exceeds |V'|. For `V =
/// (3/2) sin t` that fails first at the same two times of a period. The other V' is largest, 21/10,
/// only at t = π, where the period of an orbit that starts at 0 is cut.
#[test]
fn on_a_belt_that_shakes_the_block_sticks_for_ever_from_a_known_friction_on() {
    let both = Shaken { a: 1.5, b: 0.0 };
    let once = Shaken { a: -1.5, b: 0.3 };
    let cases = [
        (&both, 1.5, 2.5, false),
        (&both, 1.5, 1.4, true),
        (&once, 2.1, 2.5, false),
    ];
    for (shaken, exact, from, upwards) in cases {
        for (step, (tolerance, options)) in steps() {
            let settings = ContinuationSettings {
                step,
                ..ContinuationSettings::over(exact - 0.1, 2.5).forced(2.0 * PI)
            };
            let start = [0.0, from];
            let found = continue_periodic_orbit(
                &shaken.dynamics(),
                start,
                6.3,
                upwards,
                &settings,
                &options,
            );
            let found = found.unwrap();
            let [change] = found.special.as_slice() else {
                panic!("{:?}", found.special);
            };
            let CycleBifurcation::Sequence(change) = &change.what else {
                panic!("{change:?}");
            };
            assert_eq!(change.bifurcation, SequenceBifurcation::AddingSliding);
            is_within(change.parameter - exact, change.uncertainty, tolerance);
            if !upwards {
                assert_eq!(change.before, [Mode::Stick]);
            }
        }
    }
}

/// At `A` both slips begin. At `A/√(1 + π²/4)` both stick phases vanish, where the symmetric orbit
/// without stick crosses at zero rate. From above, the branch starts on an orbit that always
/// sticks, so that its first phase vanishes.
#[test]
fn a_branch_goes_on_where_two_slips_begin_at_once_and_where_two_sticks_end() {
    let adding = Pulse::amplitude();
    let crossing = adding / (1.0 + 0.25 * PI * PI).sqrt();
    let [below, above] = [Side::Below, Side::Above].map(Mode::Slip);
    let cycles: [&[Mode]; 3] = [
        &[below, above],
        &[below, Mode::Stick, above, Mode::Stick],
        &[Mode::Stick],
    ];
    for (step, (tolerance, options)) in steps() {
        for (from, upwards) in [(1.3, false), (0.4, true)] {
            let settings = ContinuationSettings {
                step,
                ..ContinuationSettings::over(0.3, 1.5).forced(PI)
            };
            let start = [0.0, 0.0, from];
            let found =
                continue_periodic_orbit(&Pulse.dynamics(), start, PI, upwards, &settings, &options);
            let found = found.unwrap();
            assert_eq!(found.stop, Stop::Range, "from {from} by {step}");
            let mut wanted = vec![
                (crossing, SequenceBifurcation::CrossingSliding, [0, 1]),
                (adding, SequenceBifurcation::AddingSliding, [1, 2]),
            ];
            if !upwards {
                wanted.reverse();
            }
            assert_eq!(found.special.len(), wanted.len(), "{:?}", found.special);
            for (special, (exact, name, mut sides)) in found.special.iter().zip(wanted) {
                let CycleBifurcation::Sequence(change) = &special.what else {
                    panic!("{special:?}");
                };
                assert_eq!(change.bifurcation, name);
                // The uncertainty is that of an error estimate, known to a tenth or so.
                is_within(
                    0.9 * (change.parameter - exact),
                    change.uncertainty,
                    tolerance,
                );
                if !upwards {
                    sides.reverse();
                }
                for (modes, side) in [&change.before, &change.after].into_iter().zip(sides) {
                    assert!(is_same_cycle(modes, cycles[side]), "{change:?}");
                }
            }
        }
    }
}
