//! Tangent vectors with several contacts.

use stickslip::analysis::{Exponent, Monodromy, PeriodicOrbit, SpectrumOptions, lyapunov_spectrum};
use stickslip::dynamics::Matrix;
use stickslip::{Error, IntoState, Mode, Options, Several, State, solve};

use super::apart::{START, SingleOscillator, three};
use super::references::stacked;
use super::rig::Rig;

/// The monodromy matrix compared with differences over five points.
fn agrees_with_differences(rig: &Rig<3>, start: [f64; 6], t_end: f64) -> (Matrix, Vec<[Mode; 3]>) {
    let options = Options::tol(1e-13);
    let system = Several(rig);
    let found = Monodromy::of(&system, 0.0, start, t_end, &options).unwrap();
    let end = |j: usize, by: f64| {
        let mut x = State::from(start);
        x[j] += by;
        solve(&system, 0.0, x, t_end, &options).unwrap().x_end
    };
    const CHANGE: f64 = 1e-5;
    let difference = |j: usize| {
        let near = end(j, CHANGE) - end(j, -CHANGE);
        let far = end(j, 2.0 * CHANGE) - end(j, -2.0 * CHANGE);
        (near * 8.0 - far) / (12.0 * CHANGE)
    };
    // The third block does not move; a change of its velocity would make it slip.
    for j in [0, 1, 3, 4] {
        let off = (found.matrix.column(j) - difference(j)).amax();
        assert!(off < 1e-6, "column {j}: off by {off:e}");
    }
    let orbit = solve(&system, 0.0, start, t_end, &options).unwrap();
    (
        found.matrix.clone(),
        orbit.phases.iter().map(|phase| phase.mode).collect(),
    )
}

#[test]
fn saltation_of_several_contacts_is_the_derivative_of_the_flow() {
    let rig = stacked();
    let start = [0.3, -0.2, 0.0, 0.5, 0.9, 0.0];
    // With entries, exits, crossings, and crossings that release the other contact.
    let (_, modes) = agrees_with_differences(&rig, start, 20.5);
    assert!(modes.len() > 10);
    let mut rough = rig.clone();
    rough.ratio = 1.5;
    let (_, modes) = agrees_with_differences(&rough, start, 15.0);
    assert!(modes.len() > 6);
}

#[test]
fn the_spectrum_of_oscillators_apart_is_the_union_of_each_ones() {
    let mut rig = three();
    // The first contact always slips; the others stick in every period.
    (rig.forcing, rig.friction) = ([3.0, 0.9, 1.1], [0.3, 0.5, 0.95]);
    let settings = SpectrumOptions {
        transient: 200.0,
        duration: 1500.0,
        ..SpectrumOptions::default()
    };
    let sorted = |exponents: Vec<Exponent>| {
        let mut values: Vec<f64> = exponents.iter().map(Exponent::value).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        values
    };
    let together = lyapunov_spectrum(&Several(&rig), (0.0, START), &settings).unwrap();
    let alone = (0..3).flat_map(|i| {
        let start = [START[i], START[3 + i]];
        let spectrum =
            lyapunov_spectrum(&SingleOscillator(&rig, i), (0.0, start), &settings).unwrap();
        spectrum.exponents
    });
    let (found, expected) = (sorted(together.exponents.to_vec()), sorted(alone.collect()));
    // One direction is annihilated for each contact that holds at some time.
    let annihilated = |values: &[f64]| values.iter().filter(|value| value.is_infinite()).count();
    assert_eq!(
        (annihilated(&found), annihilated(&expected)),
        (2, 2),
        "{found:?} {expected:?}"
    );
    for (found, expected) in found.iter().zip(&expected).take(4) {
        // Vectors converge within a time of one over the differences of the exponents.
        assert!((found - expected).abs() < 3e-3, "{found} {expected}");
    }
    assert!(expected[0] < -0.01 && expected[3] < -0.1, "{expected:?}");
    // The sum of the remaining exponents, compared with divergence and saltation.
    assert!(together.defect().abs() < 1e-6, "{}", together.defect());
}

#[test]
fn two_contacts_that_come_to_rest_in_the_same_instant_have_no_derivative() {
    // Equal blocks with equal starts stop together. A change decides which one stops first, and so
    // the outcome.
    let mut rig = three();
    (rig.forcing, rig.stiffness[1][1]) = ([0.0; 3], rig.stiffness[0][0]);
    rig.friction[1] = rig.friction[0];
    let start = [2.0, 2.0, -1.5, 0.0, 0.0, 0.0];
    let error = Monodromy::of(&Several(&rig), 0.0, start, 15.0, &Options::tol(1e-12)).unwrap_err();
    assert!(matches!(error, Error::TangentSingular { .. }), "{error}");
}

#[test]
fn two_contacts_that_give_way_in_the_same_instant_have_no_derivative() {
    // Two equal blocks that are pulled equally. The second one is released by its own limit, not by
    // the first one.
    let mut rig = Rig::<3>::at_rest();
    (rig.pull, rig.ratio) = ([1.0, 1.0, 0.0], 1.5);
    let run = |rig: &Rig<3>| Monodromy::of(&Several(rig), 0.0, [0.0; 6], 3.0, &Options::tol(1e-12));
    let error = run(&rig).unwrap_err();
    assert!(matches!(error, Error::TangentSingular { .. }), "{error}");
    // One after the other they have a derivative.
    rig.pull[1] = 1.25;
    assert!(run(&rig).is_ok());
    // With equal static and kinetic friction the fields agree where the blocks begin to slip, and
    // nothing jumps.
    (rig.pull[1], rig.ratio) = (1.0, 1.0);
    assert!(run(&rig).is_ok());
}

#[test]
fn a_forced_orbit_of_three_blocks_is_found_by_shooting() {
    let mut rig = stacked();
    // The third block moves, too: at rest it would satisfy this anywhere.
    rig.spring(0.4, 2, None);
    (rig.forcing[2], rig.friction[2]) = (1.1, 0.1);
    let period = std::f64::consts::TAU / rig.omega;
    let options = Options::tol(1e-12);
    let settled = solve(&Several(&rig), 0.0, [0.0; 6], 40.0 * period, &options).unwrap();
    let found =
        PeriodicOrbit::near_forced(&Several(&rig), 0.0, settled.x_end, period, &options).unwrap();
    let again = solve(&Several(&rig), 0.0, &found.x, period, &options).unwrap();
    let found: State<6> = found.x.into_state();
    assert!((again.x_end - found).amax() < 1e-9);
}
