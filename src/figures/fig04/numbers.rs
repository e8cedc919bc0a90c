//! The rows of Fig. 4.

use super::compute::Data;
use crate::figures::rows::{Part, Quantity, Row};
use crate::paper::claim_id::ClaimId;
use crate::paper::reading::Reading::Exact;
use stickslip::analysis::Visibility;

pub(super) fn numbers(data: &Data) -> Vec<Row> {
    let positions: Vec<f64> = data.tangents.iter().map(|tangent| tangent.x1).collect();
    let mut rows = Row::members(ClaimId::Eq12CriticalPoints, Exact, &data.stationary, "m");
    rows.extend(Row::members(
        ClaimId::Eq13CriticalMu0,
        Exact,
        &data.critical_mu0,
        "N",
    ));
    rows.extend(Row::members(
        ClaimId::Eq16TangentPoints,
        Exact,
        &positions,
        "m",
    ));
    rows.extend((1..).zip(&data.tangents).map(|(k, tangent): (usize, _)| {
        let quantity = Quantity::Detail(ClaimId::Fig04Visibility, k.to_string());
        Row::word(quantity, Exact, kind(tangent.visibility))
    }));
    rows.extend(limit_cycle(data));
    rows.extend(statements(data));
    rows
}

/// The name of a kind, as the caption has it.
fn kind(visibility: Visibility) -> &'static str {
    match visibility {
        Visibility::Visible => "visible",
        Visibility::Invisible => "invisible",
        Visibility::Degenerate => "degenerate",
    }
}

fn limit_cycle(data: &Data) -> Vec<Row> {
    let cycle = &data.cycle;
    let number = |name: &str, value, unit| {
        Row::number(format!("fig04.limit_cycle.{name}"), Exact, value, unit)
    };
    vec![
        number("crossing.left", cycle.left, "m"),
        number("crossing.right", cycle.right, "m"),
        number("period", cycle.period, "s"),
        number("multiplier", cycle.multiplier, "1"),
        number("kink.below", cycle.kink[0], "m/s²"),
        number("kink.above", cycle.kink[1], "m/s²"),
        Row::count("fig04.sticks_per_period", Exact, cycle.sticks as u64),
        Row::count("fig04.orbits", Exact, data.orbits.len() as u64),
        Row::count("fig04.orbits_that_stick", Exact, data.sticking as u64),
    ]
}

impl Data {
    /// Which of the numbered tangent points are of which kind, as the caption has it.
    pub(super) fn kinds(&self) -> String {
        let listed = |wanted| {
            let numbers: Vec<String> = (1..)
                .zip(&self.tangents)
                .filter(|(_, tangent)| tangent.visibility == wanted)
                .map(|(k, _): (usize, _)| k.to_string())
                .collect();
            numbers.join(",")
        };
        format!(
            "{} {}; {} {}",
            kind(Visibility::Visible),
            listed(Visibility::Visible),
            kind(Visibility::Invisible),
            listed(Visibility::Invisible)
        )
    }
}

/// The captions' statements, decided from the numbers.
fn statements(data: &Data) -> Vec<Row> {
    let distance = |k: usize| (data.tangents[k].x1 - data.cycle.left).abs();
    let nearest = (0..data.tangents.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let deflection = vec![
        Part {
            what: "the cycle's left crossing of Σ is nearest to the third tangent point",
            holds: nearest == Some(2),
        },
        Part {
            what: "the slope of the orbit jumps there",
            holds: data.cycle.kink[0] != data.cycle.kink[1],
        },
    ];
    let no_stick = vec![
        Part {
            what: "the limit cycle has no stick phase",
            holds: data.cycle.sticks == 0,
        },
        Part {
            what: "nor has an orbit of the figure that leads to it",
            holds: data.sticking == 0,
        },
    ];
    vec![
        Row::word(ClaimId::Fig04Visibility, Exact, &data.kinds()),
        Row::statement(ClaimId::Fig04NoStick, Exact, no_stick),
        Row::statement(ClaimId::Fig04Deflection, Exact, deflection),
    ]
}
