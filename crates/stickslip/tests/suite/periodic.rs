//! Periodic orbits compared with closed forms: found without a guess, at any tolerance, with their
//! multipliers.

use std::f64::consts::PI;

use nalgebra::Matrix4;
use stickslip::analysis::multipliers;
use stickslip::dynamics::Matrix;
use stickslip::{Error, Method, Options, State, math};

use crate::any_system::{find_periodic_orbit, periodic_orbit_forced, run, solve};
use crate::compiled::Compiled;
use crate::den_hartog::DenHartog;
use crate::solver::systems::{Floor, TwiceRound, decaying_friction};

#[test]
fn the_cycle_with_stick_is_found_without_a_guess() {
    for method in [Method::Dop853, Method::Taylor] {
        let options = Options::tol(1e-13).method(method);
        let start = [0.04, -0.01];
        let cycle = find_periodic_orbit(&decaying_friction(), start, 20.0, 30.0, &options).unwrap();
        assert!((cycle.period - 9.230_770_458_082_98).abs() < 1e-11);
        let [along, across]: [_; 2] = multipliers(&cycle.monodromy).try_into().unwrap();
        assert!((along.re - 1.0).abs() < 1e-9 && across.norm() < 1e-9);
    }
}

#[test]
fn an_orbit_that_comes_to_rest_has_no_return() {
    let rest = find_periodic_orbit(&Floor, [3.0, 0.0], 20.0, 30.0, &Options::default());
    let error = rest.unwrap_err();
    assert!(
        matches!(
            error,
            Error::NotFound {
                t: 20.0,
                span: 30.0,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_return_later_than_what_is_allowed_is_not_found() {
    let start = [0.04, -0.01];
    let options = Options::default();
    let error = find_periodic_orbit(&decaying_friction(), start, 20.0, 5.0, &options).unwrap_err();
    assert!(
        matches!(error, Error::NotFound { span: 5.0, .. }),
        "{error}"
    );
}

#[test]
fn of_two_returns_in_a_turn_the_one_that_comes_back_is_the_period() {
    // After half a turn the third component has returned, and the other two are on the far side.
    // Less than two turns are integrated.
    let start = [1.0, 0.0, 0.0];
    let cycle = find_periodic_orbit(&TwiceRound, start, 20.0, 10.0, &Options::tol(1e-12)).unwrap();
    assert!((cycle.period - 2.0 * PI).abs() < 1e-9, "{}", cycle.period);
    // Along the cycle, across it in the plane, and towards 3 cos 2θ.
    let [along, across, towards]: [_; 3] = multipliers(&cycle.monodromy).try_into().unwrap();
    assert!((along.re - 1.0).abs() < 1e-8);
    assert!((across.re - math::exp(-4.0 * PI)).abs() < 1e-9 && towards.norm() < 1e-9);
}

#[test]
fn den_hartog_s_orbits_are_refined_to_what_rounding_allows() {
    for (frequency, friction) in [(0.7, 0.2), (0.6, 0.1), (1.4, 0.3), (0.8, 0.4), (1.7, 0.2)] {
        let system = DenHartog {
            frequency,
            friction,
        };
        // Den Hartog (1930): A² = V² − S² U².
        let v = 1.0 / (1.0 - frequency * frequency);
        let angle = PI / frequency;
        let u = math::sin(angle) / (frequency * (1.0 + math::cos(angle)));
        let exact = (v * v - friction * friction * u * u).sqrt();
        let period = 2.0 * PI / frequency;
        for method in [Method::Dop853, Method::Taylor] {
            for tolerance in [1e-15, 1e-13] {
                let options = Options::tol(tolerance).method(method);
                let start = State::from([exact, 0.0]);
                let settled = run(&system, 0.0, start, 40.0 * period, &options, &mut ()).unwrap();
                let cycle =
                    periodic_orbit_forced(&system, 0.0, settled.x, period, &options).unwrap();
                let turn = solve(&system, 0.0, &cycle.x, period, &options).unwrap();
                assert_eq!(turn.transitions.len(), 2);
                for turned in &turn.transitions {
                    let off = (turned.x[0].abs() - exact).abs();
                    assert!(
                        off < 2e-12 * exact.max(1.0),
                        "{frequency} {friction}: {off:e}"
                    );
                }
            }
        }
    }
}

/// At late times, a unit in the last place of the time exceeds the tolerance. The orbit closes to
/// within that unit.
#[test]
fn an_orbit_late_on_the_clock_closes_to_what_its_time_is_rounded_to() {
    let system = DenHartog {
        frequency: 0.6,
        friction: 0.3,
    };
    let v = 1.0 / (1.0 - 0.36);
    let angle = PI / 0.6;
    let u = math::sin(angle) / (0.6 * (1.0 + math::cos(angle)));
    let exact = (v * v - 0.09 * u * u).sqrt();
    let period = 2.0 * PI / 0.6;
    for method in [Method::Dop853, Method::Taylor] {
        for t0 in [0.0, 2e3, 5e3, 1e4] {
            for start in [[1.0, 0.0], [0.0, 0.0], [-1.0, 0.3]] {
                let options = Options::tol(1e-15).method(method);
                let t = t0 + 5.0 * period;
                let settled = run(&system, t0, start, t, &options, &mut ()).unwrap();
                let cycle = periodic_orbit_forced(&system, t, settled.x, period, &options).unwrap();
                let unit = f64::EPSILON * t;
                assert!(cycle.residual < 1e-13 + 8.0 * unit, "{:e}", cycle.residual);
                let turn = solve(&system, t, &cycle.x, t + period, &options).unwrap();
                assert_eq!(turn.transitions.len(), 2);
                for turned in &turn.transitions {
                    let off = (turned.x[0].abs() - exact).abs();
                    assert!(off < 2e-12 + 8.0 * unit, "{t0} {start:?}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn an_orbit_over_several_periods_of_the_drive_has_one() {
    let system = DenHartog {
        frequency: 0.7,
        friction: 0.2,
    };
    let (period, options) = (2.0 * PI / 0.7, Options::tol(1e-12));
    let settled = run(&system, 0.0, [1.0, 0.0], 40.0 * period, &options, &mut ()).unwrap();
    for periods in [1.0, 2.0, 6.0] {
        let orbit = || {
            let period = periods * period;
            periodic_orbit_forced(&system, 0.0, settled.x, period, &options).unwrap()
        };
        let by_drive =
            |drive| orbit().with_shortest_period(&system.dynamics(), Some(drive), &options);
        let shortest = by_drive(period).unwrap();
        assert!(
            (shortest.period - period).abs() < 1e-12,
            "{}",
            shortest.period
        );
        assert!((&shortest.x - orbit().x).amax() < 1e-9);
        for drive in [0.0, f64::NAN] {
            assert!(matches!(by_drive(drive), Err(Error::Parameter { .. })));
        }
    }
}

/// Far from the orbit the block turns back more often than twice a period.
#[test]
fn a_start_whose_run_has_other_phases_leads_to_the_orbit_too() {
    let system = DenHartog {
        frequency: 0.6,
        friction: 0.3,
    };
    let period = 2.0 * PI / 0.6;
    let options = Options::tol(1e-12);
    let start = [3.0, 1.0];
    let near = solve(&system, 0.0, start, 2.0 * period, &options).unwrap();
    assert_ne!(near.transitions.len(), 4);
    let cycle = periodic_orbit_forced(&system, 0.0, start, period, &options).unwrap();
    let turn = solve(&system, 0.0, &cycle.x, period, &options).unwrap();
    assert_eq!((turn.transitions.len(), turn.sticks().count()), (2, 0));
}

#[test]
fn the_multipliers_of_a_matrix_are_its_eigenvalues_the_nearest_to_1_first() {
    // Similar to a block with rotation, modulus 0.9, and 1.02 and -0.3.
    let (c, s) = (0.9 * math::cos(0.7), 0.9 * math::sin(0.7));
    #[rustfmt::skip]
    let blocks = Matrix4::new(
        c, -s, 0.0, 0.0,
        s, c, 0.0, 0.0,
        0.0, 0.0, -0.3, 0.0,
        0.0, 0.0, 0.0, 1.02,
    );
    let shear = Matrix4::from_fn(|i, j| {
        if i == j {
            1.0
        } else {
            0.2 * (i + 2 * j) as f64 - 0.5
        }
    });
    let matrix = shear * blocks * shear.try_inverse().unwrap();
    let matrix = Matrix::from_column_slice(4, 4, matrix.as_slice());
    let [first, second, third, fourth]: [_; 4] = multipliers(&matrix).try_into().unwrap();
    assert!((first - 1.02).norm() < 1e-12, "{first}");
    assert!((second.re - c).abs() < 1e-12 && (second.im.abs() - s).abs() < 1e-12);
    assert!((second - third.conj()).norm() < 1e-12);
    assert!((fourth + 0.3).norm() < 1e-12, "{fourth}");
    let [one, other]: [_; 2] =
        multipliers(&Matrix::from_row_slice(2, 2, &[c, -2.0 * s, 0.5 * s, c]))
            .try_into()
            .unwrap();
    assert!(
        (one.re - c).abs() < 1e-15 && (one.im.abs() - s).abs() < 1e-15,
        "{one}"
    );
    assert_eq!(other, one.conj());
    let none = Matrix::from_element(3, 3, f64::NAN);
    assert!(multipliers(&none).iter().all(|m| m.re.is_nan()));
}
