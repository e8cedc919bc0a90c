//! The rows of Fig. 7.

use std::f64::consts::PI;

use super::{Data, Oscillation, Transition};
use crate::figures::rows::Row;
use stickslip::math;
use stickslip::models::cubic::Cubic;

const READING: &str = "exact";

/// A value agrees with a closed form if they differ by rounding only.
const ROUNDING: f64 = 1e-15;

/// All rows.
pub(super) fn rows(data: &Data) -> Vec<Row> {
    let mut rows = critical_points(data);
    rows.extend(critical_friction(data));
    rows.extend(six_points("eq16.tangent_points", &data.oscillation.points));
    rows.extend(six_points("eq24.tangent_points", &data.oscillation.points));
    rows.extend(limits(data));
    rows.extend(tangency(data));
    rows.extend(oscillation(&data.spring, &data.oscillation));
    rows.extend(branches(data));
    rows
}

/// A computed number beside a closed form.
fn closed(id: &str, value: f64, form: &str, expected: f64, unit: &str) -> Row {
    let agrees = (value - expected).abs() <= ROUNDING * expected.abs().max(1.0);
    Row::number(id, READING, value, unit).published(form, agrees)
}

/// A statement that was tested.
fn statement(id: &str, claim: &str, holds: bool) -> Row {
    let word = if holds { "holds" } else { "does not hold" };
    Row::word(id, READING, word).published(claim, holds)
}

/// Eq. (22) against the zeros of `∂σ/∂z` found by bisection.
fn critical_points(data: &Data) -> Vec<Row> {
    const FORMS: [&str; 5] = [
        "0",
        "√(k1/k2)",
        "-√(k1/k2)",
        "√(k1/(3 k2))",
        "-√(k1/(3 k2))",
    ];
    let count = data.stationary.len();
    let mut rows = vec![
        Row::count("eq22.critical_points.count", READING, count as u64).published("5", count == 5),
    ];
    for (i, (form, expected)) in FORMS.iter().zip(data.spring.critical_points()).enumerate() {
        let id = format!("eq22.critical_points.{}", i + 1);
        rows.extend(
            nearest(&data.stationary, expected).map(|z| closed(&id, z, form, expected, "m")),
        );
    }
    rows
}

/// Eq. (23) against the spring force where `∂σ/∂z` was found to vanish: the friction that makes `σ` zero there.
fn critical_friction(data: &Data) -> Vec<Row> {
    const FORMS: [&str; 3] = ["0", "(2 k1/3) √(k1/(3 k2))", "-(2 k1/3) √(k1/(3 k2))"];
    let forces: Vec<f64> = data
        .stationary
        .iter()
        .map(|z| data.spring.force(*z))
        .collect();
    let formula = data.spring.critical_mu0();
    FORMS
        .iter()
        .zip(formula)
        .enumerate()
        .filter_map(|(i, (form, expected))| {
            let id = format!("eq23.mu0_critical.{}", i + 1);
            nearest(&forces, expected).map(|force| closed(&id, force, form, expected, "N"))
        })
        .collect()
}

fn nearest(values: &[f64], to: f64) -> Option<f64> {
    let distance = |v: &f64| (v - to).abs();
    values
        .iter()
        .copied()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Eq. (16) and (24): the same six points, once for each model.
fn six_points(id: &str, points: &[f64]) -> Vec<Row> {
    let forms = [
        ("(2/√3) cos(π/9)", math::cos(PI / 9.0)),
        ("(2/√3) cos(2π/9)", math::cos(2.0 * PI / 9.0)),
        ("(2/√3) sin(π/18)", math::sin(PI / 18.0)),
        ("-(2/√3) sin(π/18)", -math::sin(PI / 18.0)),
        ("-(2/√3) cos(2π/9)", -math::cos(2.0 * PI / 9.0)),
        ("-(2/√3) cos(π/9)", -math::cos(PI / 9.0)),
    ];
    points
        .iter()
        .zip(forms)
        .enumerate()
        .map(|(i, (z, (form, w)))| {
            closed(
                &format!("{id}.{}", i + 1),
                *z,
                form,
                2.0 / 3f64.sqrt() * w,
                "m",
            )
        })
        .collect()
}

/// Sect. 2 on the two limits of `μ₀`.
fn limits(data: &Data) -> Vec<Row> {
    let degenerate = data.without.zeros.len() == 3 && data.without.zones.is_empty();
    let mut rows = vec![statement(
        "s2.degenerate_zone",
        "three tangent points and no stick zone at μ0 = 0",
        degenerate,
    )];
    let outer = 2.0 / 3f64.sqrt();
    if let [(low, high)] = data.with_critical.zones[..] {
        rows.push(statement(
            "s2.continuous_zone",
            "one stick zone between the outer tangent points at μ0 = 2/(3√3)",
            true,
        ));
        rows.push(closed(
            "s2.boundary_tangent_points.1",
            high,
            "2/√3",
            outer,
            "m",
        ));
        rows.push(closed(
            "s2.boundary_tangent_points.2",
            low,
            "-2/√3",
            -outer,
            "m",
        ));
    } else {
        rows.push(statement(
            "s2.continuous_zone",
            "one stick zone between the outer tangent points at μ0 = 2/(3√3)",
            false,
        ));
    }
    rows
}

/// Fig. 7a: from which side `σ` touches the axis, looked up beside each double zero.
fn tangency(data: &Data) -> Vec<Row> {
    let above = touching(data, &data.without, 1.0);
    let below = touching(data, &data.with_critical, -1.0);
    vec![
        statement(
            "fig07a.tangency",
            "from above at μ0 = 0, from below at μ0 = 2√3/9",
            above == 3 && below == 2,
        ),
        Row::count("fig07a.touching_from_above", READING, above),
        Row::count("fig07a.touching_from_below", READING, below),
    ]
}

fn touching(data: &Data, transition: &Transition, side: f64) -> u64 {
    const BESIDE: f64 = 1e-3;
    let beside = |z: f64| side * data.spring.sigma(z, transition.mu0, 1.0) > 0.0;
    let touches = transition
        .zeros
        .iter()
        .filter(|zero| beside(zero.z - BESIDE) && beside(zero.z + BESIDE));
    touches.count() as u64
}

/// Fig. 7b: `σ` of the distance to the moving end of the spring stays zero along the curves drawn.
fn oscillation(spring: &Cubic, data: &Oscillation) -> Vec<Row> {
    let mut largest: f64 = 0.0;
    for positions in &data.positions {
        for (t, x1) in data.times.iter().zip(positions) {
            let z = x1 - data.amplitude * math::sin(data.omega * t);
            largest = largest.max(spring.sigma(z, data.mu0, 1.0).abs());
        }
    }
    let mut rows = vec![
        statement("fig07b.oscillation", "z_k + A sin(ωt)", largest <= ROUNDING),
        Row::number("fig07b.amplitude", READING, data.amplitude, "m"),
        Row::number("fig07b.period", READING, 2.0 * PI / data.omega, "s"),
    ];
    for (i, pair) in data.points.chunks_exact(2).enumerate() {
        let id = format!("fig07b.zone_width.{}", i + 1);
        rows.push(Row::number(&id, READING, pair[0] - pair[1], "m"));
    }
    rows
}

/// Fig. 7c: the number of tangent points in each regime.
fn branches(data: &Data) -> Vec<Row> {
    let [zero, below, at, above] = data.branches.counts.map(|count| count as u64);
    vec![
        statement(
            "fig07c.branches",
            "branches for μ0 in [0, 4√3/9]",
            below == 6 && above == 2,
        ),
        Row::count("fig07c.points_without_friction", READING, zero).published("3", zero == 3),
        Row::count("fig07c.points_below_critical", READING, below).published("6", below == 6),
        Row::count("fig07c.points_at_critical", READING, at),
        Row::count("fig07c.points_above_critical", READING, above),
        Row::number(
            "fig07c.outer_point_at_end",
            READING,
            end(&data.branches.above),
            "m",
        ),
    ]
}

/// The outermost tangent point at the right border, m.
fn end(branches: &[Vec<(f64, f64)>]) -> f64 {
    branches
        .first()
        .and_then(|branch| branch.last())
        .map_or(f64::NAN, |point| point.1)
}
