//! Fig. 7: the transition function `σ`, its oscillating zeros, and their bifurcation with `μ₀`.

mod compute;
mod draw;

use super::FigureSpec;
use crate::figures::rows::Row;
use crate::paper::claim_id::ClaimId;
use crate::paper::reading::Reading::Exact;
use compute::compute;
pub use compute::{Branches, Data, SigmaGraph, TangentPointMotion};
use draw::draw;

/// Fig. 7.
pub const FIG07: FigureSpec<Data> = FigureSpec {
    name: "fig07",
    title: "Fig. 7: tangent points, their oscillation and bifurcation",
    about: "Draws (a) the transition function sigma(z) of Eq. (19) for mu0 = 0 and mu0 = 2 \
        sqrt(3)/9, (b) the six tangent points z_k + A sin(omega t) over two forcing periods with \
        the parameters of Fig. 8, (c) the tangent points against mu0 from 0 to 4 sqrt(3)/9. \
        Reports the critical points of Eq. (22) and the critical friction of Eq. (23) for k1 = 3, \
        k2 = 12, found by a root search and held against the printed formulas.",
    compute,
    numbers,
    draw,
};

/// All rows.
fn numbers(data: &Data) -> Vec<Row> {
    // Eq. (23): the friction that makes σ zero at each stationary point.
    let stationary = data.stationary.iter();
    let forces: Vec<f64> = stationary.map(|z| data.unequal.force(*z)).collect();
    let mut rows = Row::members(ClaimId::Eq22CriticalPoints, Exact, &data.stationary, "m");
    rows.extend(Row::members(ClaimId::Eq23CriticalMu0, Exact, &forces, "N"));
    rows.extend(limits(data));
    rows.extend(tangency(data));
    rows.extend(oscillation(data));
    rows.extend(branches(data));
    rows
}

/// The statements of Sect. 2 on the two limits of `μ₀`.
fn limits(data: &Data) -> Vec<Row> {
    let none = data.without_friction.zones.is_empty();
    let degenerate = [
        ("there is no stick zone at mu0 = 0", none),
        (
            "three tangent points remain",
            data.without_friction.zeros.len() == 3,
        ),
    ];
    let continuous = [(
        "there is one stick zone at mu0 = 2/(3√3)",
        data.with_critical.zones.len() == 1,
    )];
    let mut rows = vec![
        Row::statement(ClaimId::S2DegenerateZone, Exact, degenerate),
        Row::statement(ClaimId::S2ContinuousZone, Exact, continuous),
    ];
    let zones = data.with_critical.zones.iter();
    let ends: Vec<f64> = zones.flat_map(|&(low, high)| [high, low]).collect();
    let id = ClaimId::S2BoundaryTangentPoints;
    rows.extend(Row::members(id, Exact, &ends, "m"));
    rows
}

/// Fig. 7a: the side from which `σ` touches the axis, decided by its sign beside each double zero.
fn tangency(data: &Data) -> Vec<Row> {
    let above = touching(data, &data.without_friction, 1.0);
    let below = touching(data, &data.with_critical, -1.0);
    let parts = [
        (
            "sigma touches the axis from above in three points at mu0 = 0",
            above == 3,
        ),
        (
            "sigma touches it from below in two points at mu0 = 2√3/9",
            below == 2,
        ),
    ];
    let detail = |name: &str, count| detail(ClaimId::Fig07aTangency, name, count);
    vec![
        Row::statement(ClaimId::Fig07aTangency, Exact, parts),
        detail("touching_from_above", above),
        detail("touching_from_below", below),
    ]
}

fn touching(data: &Data, transition: &SigmaGraph, side: f64) -> usize {
    /// Distance (m) at which the sign is evaluated: far above rounding, far below the distance of
    /// zeros.
    const SIGN_OFFSET: f64 = 1e-3;
    let beside = |z: f64| side * data.spring.sigma(z, transition.mu0, 1.0) > 0.0;
    let touches = |z: f64| beside(z - SIGN_OFFSET) && beside(z + SIGN_OFFSET);
    let zeros = transition.zeros.iter();
    zeros.filter(|zero| touches(zero.z)).count()
}

/// Fig. 7b: the data of the curves. The report computes whether they bound the stick zones.
fn oscillation(data: &Data) -> Vec<Row> {
    let TangentPointMotion { model, points, .. } = &data.oscillation;
    let mut rows = vec![
        Row::number("fig07b.amplitude", Exact, model.amplitude, "m"),
        Row::number("fig07b.period", Exact, model.period(), "s"),
    ];
    for (i, pair) in points.chunks_exact(2).enumerate() {
        let name = format!("fig07b.zone_width.{}", i + 1);
        rows.push(Row::number(name, Exact, pair[0] - pair[1], "m"));
    }
    rows
}

/// Fig. 7c: the number of tangent points in each range.
fn branches(data: &Data) -> Vec<Row> {
    let outer = data.branches.above.first().and_then(|branch| branch.last());
    let end = outer.map_or(f64::NAN, |point| point.1);
    let [zero, below, at, above] = data.branches.counts;
    let parts = [
        ("six branches below the critical mu0", below == 6),
        ("two branches above it", above == 2),
    ];
    let detail = |name: &str, count| detail(ClaimId::Fig07cBranches, name, count);
    vec![
        Row::statement(ClaimId::Fig07cBranches, Exact, parts),
        detail("points_without_friction", zero),
        detail("points_below_critical", below),
        detail("points_at_critical", at),
        detail("points_above_critical", above),
        Row::number("fig07c.outer_point_at_end", Exact, end, "m"),
    ]
}

fn detail(id: ClaimId, name: &str, count: usize) -> Row {
    Row::count(format!("{id}.{name}"), Exact, count)
}
