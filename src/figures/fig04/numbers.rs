//! The rows of Fig. 4.

use super::compute::Data;
use crate::figures::rows::Row;
use crate::paper::published::published;
use stickslip::analysis::Visibility;

const READING: &str = "exact";

pub(super) fn numbers(data: &Data) -> Vec<Row> {
    let mut rows = set("eq12.critical_points", &data.stationary, "m");
    rows.extend(set("eq13.mu0_critical", &data.critical_mu0, "N"));
    rows.extend(tangent_points(data));
    rows.extend(limit_cycle(data));
    rows.extend(statements(data));
    rows
}

/// The members of a published set, each with the computed value nearest to it.
fn set(id: &str, found: &[f64], unit: &str) -> Vec<Row> {
    let members = published(id)
        .map(|claim| claim.values())
        .unwrap_or_default();
    (1..)
        .zip(members)
        .filter_map(|(k, member)| {
            let distance = |value: &f64| (value - member).abs();
            let nearest = found
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            Some(Row::number(&format!("{id}.{k}"), READING, *nearest, unit).member_of(id, k))
        })
        .collect()
}

/// The name of a kind, as the caption has it.
fn kind(visibility: Visibility) -> &'static str {
    match visibility {
        Visibility::Visible => "visible",
        Visibility::Invisible => "invisible",
        Visibility::Degenerate => "degenerate",
    }
}

fn tangent_points(data: &Data) -> Vec<Row> {
    let mut rows = Vec::new();
    for (k, tangent) in (1..).zip(&data.tangents) {
        let id = format!("fig04.tangent_point.{k}");
        rows.push(Row::number(&id, READING, tangent.x1, "m").member_of("eq16.tangent_points", k));
    }
    for (k, tangent) in (1..).zip(&data.tangents) {
        let published = if k % 2 == 1 { "visible" } else { "invisible" };
        let found = kind(tangent.visibility);
        rows.push(
            Row::word(&format!("fig04.tangent_point.{k}.kind"), READING, found)
                .published(published, found == published),
        );
    }
    rows
}

fn limit_cycle(data: &Data) -> Vec<Row> {
    let cycle = &data.cycle;
    let number = |name: &str, value, unit| {
        Row::number(&format!("fig04.limit_cycle.{name}"), READING, value, unit)
    };
    vec![
        number("crossing.left", cycle.left, "m"),
        number("crossing.right", cycle.right, "m"),
        number("period", cycle.period, "s"),
        number("multiplier", cycle.multiplier, "1"),
        number("kink.below", cycle.kink[0], "m/s²"),
        number("kink.above", cycle.kink[1], "m/s²"),
        Row::count("fig04.sticks_per_period", READING, cycle.sticks as u64),
    ]
}

/// The captions' statements, decided from the numbers.
fn statements(data: &Data) -> Vec<Row> {
    let listed = |wanted| {
        let numbers: Vec<String> = (1..)
            .zip(&data.tangents)
            .filter(|(_, tangent)| tangent.visibility == wanted)
            .map(|(k, _): (usize, _)| k.to_string())
            .collect();
        numbers.join(",")
    };
    let found = format!(
        "visible {}; invisible {}",
        listed(Visibility::Visible),
        listed(Visibility::Invisible)
    );
    let distance = |k: usize| (data.tangents[k].x1 - data.cycle.left).abs();
    let nearest = (0..data.tangents.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let kinks = data.cycle.kink[0] != data.cycle.kink[1];
    vec![
        Row::word("fig04.visibility", READING, &found).against("fig04.visibility"),
        Row::statement("fig04.no_stick", READING, data.cycle.sticks == 0),
        Row::statement("fig04.deflection", READING, nearest == Some(2) && kinks),
    ]
}
