//! The coefficients of the methods: order conditions that need no orbit.

use stickslip::math::powi;
use stickslip::ode::{Dop853, Rk4, RungeKutta};

/// Rounding bound of sums of sixteen products of size up to 50.
const ROUNDING: f64 = 1e-13;

fn sum(f: impl Fn(usize) -> f64) -> f64 {
    (0..16).map(f).sum()
}

fn assert_rows_sum_to_nodes<M: RungeKutta>() {
    let m = &M::COEFFICIENTS;
    for i in 0..m.stages + 1 + m.dense_stages {
        // Row `stages` is the end of the step itself.
        if i != m.stages {
            let error = sum(|j| m.a[i][j]) - m.c[i];
            assert!(error.abs() < 2e-14, "{} row {i}: {error}", M::NAME);
        }
        assert!((i..16).all(|j| m.a[i][j] == 0.0), "{} is explicit", M::NAME);
    }
    assert!((m.stages..16).all(|j| m.b[j] == 0.0));
}

/// Whether the conditions `Σ b c^k = 1/(k+1)` and `Σ b_i c_i^k a_ij c_j^l = 1/((l+1)(k+l+2))` hold
/// up to `order`.
fn assert_weights<M: RungeKutta>(b: &[f64; 16], order: i32) {
    let m = &M::COEFFICIENTS;
    for k in 0..order {
        let error = sum(|i| b[i] * powi(m.c[i], k)) - 1.0 / f64::from(k + 1);
        assert!(error.abs() < 1e-14, "{} order {}: {error}", M::NAME, k + 1);
    }
    for k in 0..order - 1 {
        for l in 1..order - 1 - k {
            let inner = |i: usize| sum(|j| m.a[i][j] * powi(m.c[j], l));
            let found = sum(|i| b[i] * powi(m.c[i], k) * inner(i));
            let error = found - 1.0 / f64::from((l + 1) * (k + l + 2));
            assert!(
                error.abs() < ROUNDING,
                "{} k = {k}, l = {l}: {error}",
                M::NAME
            );
        }
    }
}

#[test]
fn rows_sum_to_nodes() {
    assert_rows_sum_to_nodes::<Rk4>();
    assert_rows_sum_to_nodes::<Dop853>();
}

#[test]
fn weights_meet_the_conditions_up_to_the_order_and_not_beyond() {
    assert_weights::<Rk4>(&Rk4::COEFFICIENTS.b, 4);
    assert_weights::<Dop853>(&Dop853::COEFFICIENTS.b, 8);
    let embedded = Dop853::EMBEDDED.expect("adaptive");
    assert_weights::<Dop853>(&embedded.third_order, 3);
    for m in [Rk4::COEFFICIENTS, Dop853::COEFFICIENTS] {
        let order = if m.stages == 4 { 4 } else { 8 };
        let next = sum(|i| m.b[i] * powi(m.c[i], order)) - 1.0 / f64::from(order + 1);
        assert!(next.abs() > 1e-8, "one order more than stated: {next}");
    }
}

#[test]
fn the_error_estimate_of_order_five_vanishes_up_to_order_five_and_not_beyond() {
    let m = &Dop853::COEFFICIENTS;
    let e5 = Dop853::EMBEDDED.expect("adaptive").e5;
    for k in 0..5 {
        let rest = sum(|i| e5[i] * powi(m.c[i], k));
        assert!(rest.abs() < 1e-14, "order {}: {rest}", k + 1);
    }
    assert!(sum(|i| e5[i] * powi(m.c[i], 5)).abs() > 1e-6);
}
