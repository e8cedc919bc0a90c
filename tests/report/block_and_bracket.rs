//! Figs. 10, 11 and 12: the published classes, the spectra compared with closed statements, and
//! exponents from data compared with those from the equations.
//!
//! Every check takes the figure's data, so that they are computed once.

use super::with;
use approx::assert_abs_diff_eq;
use replication::figures::block_and_bracket::{Data, compare};
use replication::motion::Class;
use stickslip::analysis::{Exponent, PeriodicOrbit};
use stickslip::{Options, State, math};

#[test]
fn set_1_is_periodic() {
    with(|report| periodic(&report.ledger.computed.bracket[0]));
}

#[test]
fn set_2_is_quasi_periodic() {
    with(|report| quasi_periodic(&report.ledger.computed.bracket[1]));
}

#[test]
fn set_3_is_chaotic_and_lifts_off() {
    with(|report| chaotic(&report.ledger.computed.bracket[2]));
}

#[test]
fn exponents_from_data_are_those_of_the_equations_where_the_data_determine_them() {
    with(|report| {
        let [first, second, third] = &report.ledger.computed.bracket;
        data_against_equations(&[("fig10", first), ("fig11", second), ("fig12", third)]);
    });
}

/// End effects over 9000 time units. A vector's growth over an incomplete period and the rotation
/// of a pair's plane are both factors below 30.
fn end_effects() -> f64 {
    math::ln(30.0) / 9000.0
}

/// Common to all three: stick annihilates one direction, and the exponents add up to the mean
/// divergence.
fn spectrum_holds(data: &Data) {
    let spectrum = &data.exact.spectrum;
    assert_eq!(spectrum.exponents[3], Exponent::Annihilated);
    // The clip at N = 0 is a kink in the field. Steps cross it with their tolerance of 1e-10.
    assert!(spectrum.defect().abs() < 1e-7, "{}", spectrum.defect());
}

/// Fig. 10: one loop, with the exponents of its Floquet multipliers.
pub fn periodic(data: &Data) {
    spectrum_holds(data);
    let (spectrum, evidence) = (&data.exact.spectrum, &data.exact.evidence);
    let period = evidence.return_time;
    assert_abs_diff_eq!(period, 8.51, epsilon = 5e-3);
    // One stick phase per period, and all turning points at the same state.
    assert_eq!(spectrum.stick_entries as u64, (9000.0 / period) as u64);
    assert_eq!(evidence.distinct, 1);
    let turn = State::from(data.section[0]);
    assert!(data.section.len() > 15);
    for other in &data.section[..16] {
        assert!((State::from(*other) - turn).amax() < 1e-7);
    }
    assert!((0.0015..0.0025).contains(&spectrum.stick_fraction));
    // Floquet multipliers from the turning point, which is off Σ.
    let cycle = PeriodicOrbit::near(&data.model, turn, period, &Options::tol(1e-12)).unwrap();
    let mut multipliers: Vec<f64> =
        nalgebra::DMatrix::from_column_slice(4, 4, cycle.monodromy.as_slice())
            .complex_eigenvalues()
            .iter()
            .map(|m| math::hypot(m.re, m.im))
            .collect();
    multipliers.sort_by(|a, b| b.total_cmp(a));
    assert_abs_diff_eq!(multipliers[0], 1.0, epsilon = 1e-8);
    // A pair of equal moduli (complex), and the direction that stick annihilates.
    assert_abs_diff_eq!(multipliers[1], multipliers[2], epsilon = 1e-8);
    assert!(multipliers[3] < 1e-8);
    let pair = math::ln(multipliers[1]) / cycle.period;
    assert_abs_diff_eq!(pair, -0.0115, epsilon = 5e-5);
    assert_abs_diff_eq!(spectrum.exponents[0].value(), 0.0, epsilon = end_effects());
    assert_abs_diff_eq!(spectrum.exponents[1].value(), pair, epsilon = end_effects());
    assert_abs_diff_eq!(spectrum.exponents[2].value(), pair, epsilon = end_effects());
}

/// Fig. 11: a torus that never loses contact.
pub fn quasi_periodic(data: &Data) {
    spectrum_holds(data);
    let (spectrum, evidence) = (&data.exact.spectrum, &data.exact.evidence);
    assert!(data.exact.least_force > 0.2, "{}", data.exact.least_force);
    assert!((0.05..0.065).contains(&spectrum.stick_fraction));
    // Turning points fill a curve: hardly two of them coincide.
    assert!(evidence.distinct > evidence.returns / 2, "{evidence:?}");
    assert_abs_diff_eq!(spectrum.exponents[0].value(), 0.0, epsilon = end_effects());
    assert_abs_diff_eq!(spectrum.exponents[1].value(), 0.0, epsilon = end_effects());
    assert_abs_diff_eq!(
        spectrum.exponents[2].value(),
        -0.0079,
        epsilon = end_effects()
    );
}

/// Fig. 12: one positive exponent, and contact is lost.
pub fn chaotic(data: &Data) {
    spectrum_holds(data);
    assert!(data.exact.least_force < -1.0, "{}", data.exact.least_force);
    let [first, second, third, _] = data.exact.spectrum.exponents[..] else {
        panic!("four exponents");
    };
    // Twenty standard errors from zero; eight are required.
    let error = first.std_error().unwrap();
    assert!(first.value() > 8.0 * error);
    assert_abs_diff_eq!(first.value(), 0.015, epsilon = 4.0 * error);
    assert_abs_diff_eq!(second.value(), 0.0, epsilon = 1e-3);
    assert_abs_diff_eq!(
        third.value(),
        -0.038,
        epsilon = 4.0 * third.std_error().unwrap()
    );
}

/// An exponent with the status `ok` agrees with the equations within errors known independently.
/// The second exponent of Fig. 12, which is zero, uses nearly all of the allowed difference. The
/// data give 0.004, which doubling the neighbourhoods hardly changes. Another chaotic orbit may
/// exceed the allowed difference; its row then reports that.
pub fn data_against_equations(figures: &[(&str, &Data)]) {
    let mut off = Vec::new();
    let mut compared = 0;
    for (figure, data) in figures {
        let equations = &data.exact.spectrum.exponents;
        for (reading, spectrum) in [
            ("corrected/data", &data.from_data),
            ("best-of-readings", &data.best_of_readings),
        ] {
            for one in compare(spectrum, equations) {
                compared += 1;
                println!(
                    "{figure}.lambda.{} {reading}: data {:.6}, equations {:.6}, off by {:.6}, \
                        allowed {:.6}",
                    one.index + 1,
                    one.from_data,
                    one.from_equations,
                    one.difference(),
                    one.allowed
                );
                if !one.agrees() {
                    off.push(format!("{figure}.lambda.{} {reading}", one.index + 1));
                }
            }
        }
    }
    // One exponent of a cycle, two of a torus, three of a chaotic motion with stick, each by two
    // settings. The second settings call the first of the torus unstable.
    assert_eq!(compared, 2 * (1 + 2 + 3) - 1);
    assert_eq!(off, Vec::<String>::new());
}

#[test]
fn another_figures_exponents_do_not_confirm_a_section() {
    with(|report| {
        let [first, second, third] = report.ledger.statements.shapes.0;
        for (one, other) in [(first, second), (second, first), (third, first)] {
            let mut mixed = one;
            (mixed.zeros, mixed.positive) = (other.zeros, other.positive);
            assert!(one.confirmed() && !mixed.confirmed(), "{mixed:?}");
        }
    });
}

#[test]
fn the_procedure_of_sect_3_gives_two_captioned_classes_with_the_signs_corrected_alone() {
    with(|report| {
        let found = &report.ledger.statements.by_procedure;
        // Fig. 10 closes after one loop; its caption says two.
        let classes = [Class::Periodic(1), Class::QuasiPeriodic, Class::Chaotic];
        assert_eq!(found.corrected, classes.map(Some));
        assert_eq!(found.as_printed, [None; 3]);
    });
}
