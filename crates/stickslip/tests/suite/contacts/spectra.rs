//! Tangent vectors through several contacts.

use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum, monodromy, periodic_orbit_forced};
use stickslip::nalgebra::SMatrix;
use stickslip::{Mode, Options, Several, State, solve};

use super::references::stacked;
use super::rig::Rig;

/// The monodromy matrix against differences over five points.
fn agrees_with_differences(rig: &Rig<3>, start: [f64; 6], t_end: f64) -> (SMatrix<f64, 6, 6>, Vec<[Mode; 3]>) {
    let options = Options::tol(1e-13);
    let system = Several(rig);
    let found = monodromy(&system, 0.0, start, t_end, &options).unwrap();
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
    // The third block stands still; a change of its velocity would make it slip.
    for j in [0, 1, 3, 4] {
        let off = (found.matrix.column(j) - difference(j)).amax();
        assert!(off < 1e-6, "column {j}: off by {off:e}");
    }
    let orbit = solve(&system, 0.0, start, t_end, &options).unwrap();
    (found.matrix, orbit.phases.iter().map(|phase| phase.mode).collect())
}

#[test]
fn saltation_of_several_contacts_is_the_derivative_of_the_flow() {
    let rig = stacked();
    let start = [0.3, -0.2, 0.0, 0.5, 0.9, 0.0];
    // Through entries, exits, crossings, and crossings that release the other contact.
    let (_, modes) = agrees_with_differences(&rig, start, 20.5);
    assert!(modes.len() > 10);
    let mut rough = rig.clone();
    rough.ratio = 1.5;
    let (_, modes) = agrees_with_differences(&rough, start, 15.0);
    assert!(modes.len() > 6);
}

#[test]
fn spectra_of_oscillators_apart_are_the_union_of_each_ones() {
    let mut rig = Rig::at_rest();
    for (i, k) in [1.0, 2.5, 0.4].into_iter().enumerate() {
        rig.spring(k, i, None);
    }
    // The first slips all the time, the second sticks in every period, the third always.
    (rig.forcing, rig.omega) = ([3.0, 0.9, 0.0], 0.7);
    rig.friction = [0.1, 0.5, 0.7];
    let settings = SpectrumOptions {
        transient: 200.0,
        duration: 400.0,
        ..SpectrumOptions::default()
    };
    let finite = |active: [bool; 3]| {
        let mut rig = rig.clone();
        for i in 0..3 {
            if !active[i] {
                rig.forcing[i] = 0.0;
                rig.friction[i] = 10.0;
            }
        }
        let x = [0.5 * f64::from(u8::from(active[0])), 0.3 * f64::from(u8::from(active[1])), 0.0];
        let start = [x[0], x[1], x[2], 0.0, 0.0, 0.0];
        let spectrum = lyapunov_spectrum(&Several(&rig), (0.0, start), &settings).unwrap();
        let annihilated = spectrum
            .exponents
            .iter()
            .filter(|exponent| **exponent == Exponent::Annihilated)
            .count();
        // A position that sticks for good neither grows nor shrinks.
        let mut values: Vec<f64> = spectrum.exponents.iter().map(Exponent::value).collect();
        values.retain(|value| value.is_finite());
        assert!(spectrum.defect().abs() < 1e-6, "{}", spectrum.defect());
        (annihilated, values)
    };
    let (both, first, second) = (
        finite([true, true, false]),
        finite([true, false, false]),
        finite([false, true, false]),
    );
    // One direction is annihilated for each contact that holds at some time.
    assert_eq!((both.0, first.0, second.0), (2, 2, 3));
    let mut union: Vec<f64> = first.1.iter().chain(&second.1).copied().collect();
    // Each alone has the positions of those that stand still, with exponent zero, as well.
    for _ in 0..3 {
        let zero = union.iter().position(|value| value.abs() < 1e-9).unwrap();
        union.remove(zero);
    }
    union.sort_by(|a, b| b.total_cmp(a));
    assert_eq!(both.1.len(), union.len(), "{both:?} {union:?}");
    for (found, expected) in both.1.iter().zip(&union) {
        assert!((found - expected).abs() < 1e-3, "{both:?} {union:?}");
    }
}

#[test]
fn a_forced_orbit_of_two_blocks_is_found_by_shooting() {
    let rig = stacked();
    let period = std::f64::consts::TAU / rig.omega;
    let options = Options::tol(1e-12);
    let settled = solve(&Several(&rig), 0.0, [0.0; 6], 40.0 * period, &options).unwrap();
    let found = periodic_orbit_forced(&Several(&rig), 0.0, settled.x_end, period, &options).unwrap();
    let again = solve(&Several(&rig), 0.0, found.x, period, &options).unwrap();
    assert!((again.x_end - found.x).amax() < 1e-9);
    assert!((found.x - settled.x_end).amax() < 1e-3);
}
