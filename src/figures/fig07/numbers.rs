//! The rows of Fig. 7.

use std::f64::consts::PI;

use super::{Data, Transition};
use crate::figures::rows::{Part, Quantity, Row};
use crate::paper::claim_id::ClaimId;
use crate::paper::reading::Reading::Exact;

/// All rows.
pub(super) fn rows(data: &Data) -> Vec<Row> {
    // Eq. (23): the friction that makes σ zero where its slope was found to vanish.
    let forces: Vec<f64> = data
        .stationary
        .iter()
        .map(|z| data.unequal.force(*z))
        .collect();
    let mut rows = Row::members(ClaimId::Eq22CriticalPoints, Exact, &data.stationary, "m");
    rows.extend(Row::members(ClaimId::Eq23CriticalMu0, Exact, &forces, "N"));
    rows.extend(limits(data));
    rows.extend(tangency(data));
    rows.extend(oscillation(data));
    rows.extend(branches(data));
    rows
}

/// Sect. 2 on the two limits of `μ₀`.
fn limits(data: &Data) -> Vec<Row> {
    let degenerate = vec![
        Part {
            what: "there is no stick zone at mu0 = 0",
            holds: data.without.zones.is_empty(),
        },
        Part {
            what: "three tangent points remain",
            holds: data.without.zeros.len() == 3,
        },
    ];
    let continuous = vec![Part {
        what: "there is one stick zone at mu0 = 2/(3√3)",
        holds: data.with_critical.zones.len() == 1,
    }];
    let mut rows = vec![
        Row::statement(ClaimId::S2DegenerateZone, Exact, degenerate),
        Row::statement(ClaimId::S2ContinuousZone, Exact, continuous),
    ];
    let ends: Vec<f64> = data
        .with_critical
        .zones
        .iter()
        .flat_map(|&(low, high)| [high, low])
        .collect();
    rows.extend(Row::members(
        ClaimId::S2BoundaryTangentPoints,
        Exact,
        &ends,
        "m",
    ));
    rows
}

/// Fig. 7a: from which side `σ` touches the axis, looked up beside each double zero.
fn tangency(data: &Data) -> Vec<Row> {
    let above = touching(data, &data.without, 1.0);
    let below = touching(data, &data.with_critical, -1.0);
    let parts = vec![
        Part {
            what: "sigma touches the axis from above in three points at mu0 = 0",
            holds: above == 3,
        },
        Part {
            what: "and from below in two at mu0 = 2√3/9",
            holds: below == 2,
        },
    ];
    let detail = |name: &str, count| {
        let quantity = Quantity::Detail(ClaimId::Fig07aTangency, name.to_owned());
        Row::count(quantity, Exact, count)
    };
    vec![
        Row::statement(ClaimId::Fig07aTangency, Exact, parts),
        detail("touching_from_above", above),
        detail("touching_from_below", below),
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

/// Fig. 7b: what the curves are drawn with. Whether they bound the stick zones is computed by the report.
fn oscillation(data: &Data) -> Vec<Row> {
    let oscillation = &data.oscillation;
    let mut rows = vec![
        Row::number("fig07b.amplitude", Exact, oscillation.amplitude, "m"),
        Row::number("fig07b.period", Exact, 2.0 * PI / oscillation.omega, "s"),
    ];
    for (i, pair) in oscillation.points.chunks_exact(2).enumerate() {
        let name = format!("fig07b.zone_width.{}", i + 1);
        rows.push(Row::number(name, Exact, pair[0] - pair[1], "m"));
    }
    rows
}

/// Fig. 7c: the number of tangent points in each regime.
fn branches(data: &Data) -> Vec<Row> {
    let [zero, below, at, above] = data.branches.counts.map(|count| count as u64);
    let parts = vec![
        Part {
            what: "six branches below the critical mu0",
            holds: below == 6,
        },
        Part {
            what: "two above it",
            holds: above == 2,
        },
    ];
    let detail = |name: &str, count| {
        let quantity = Quantity::Detail(ClaimId::Fig07cBranches, name.to_owned());
        Row::count(quantity, Exact, count)
    };
    vec![
        Row::statement(ClaimId::Fig07cBranches, Exact, parts),
        detail("points_without_friction", zero),
        detail("points_below_critical", below),
        detail("points_at_critical", at),
        detail("points_above_critical", above),
        Row::number(
            "fig07c.outer_point_at_end",
            Exact,
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
