//! The rows of Fig. 8.

use super::compute::Data;
use crate::figures::rows::Row;
use crate::paper::listing::Motion;
use stickslip::analysis::Visibility;

const AS_PRINTED: &str = "as-printed";
const LIMIT: &str = "slip-times-three";
const EXACT: &str = "exact";

/// The four published numbers in the order in which the paper gives them.
const FOUR: [(&str, &str); 4] = [
    ("fig08.stick_length.1", "m"),
    ("fig08.stick_length.2", "m"),
    ("fig08.stick_duration.1", "s"),
    ("fig08.stick_duration.2", "s"),
];

pub(super) fn numbers(data: &Data) -> Vec<Row> {
    let mut rows = four(AS_PRINTED, data.as_printed.four_numbers);
    rows.extend(four(LIMIT, data.slip_times_three));
    rows.extend(as_printed(data));
    rows.extend(exact(data));
    rows.extend(shares(data));
    rows
}

fn four(reading: &str, found: Option<[f64; 4]>) -> Vec<Row> {
    FOUR.iter()
        .enumerate()
        .map(|(i, (id, unit))| match found {
            Some(values) => Row::number(id, reading, values[i], unit).against(id),
            None => Row::word(id, reading, "no two stick phases").against(id),
        })
        .collect()
}

fn as_printed(data: &Data) -> Vec<Row> {
    let found = &data.as_printed;
    let period_two = matches!(found.motion, Motion::StickSlip { period: 2, .. });
    let visible = !found.exits.is_empty()
        && found
            .exits
            .iter()
            .all(|exit| *exit == Some(Visibility::Visible));
    vec![
        Row::count(
            "fig08.sticks_per_pattern",
            AS_PRINTED,
            found.sticks.len() as u64,
        ),
        Row::statement("fig08.two_periodic", AS_PRINTED, period_two),
        Row::count(
            "fig08.deflections",
            AS_PRINTED,
            found.deflections.len() as u64,
        )
        .against("fig08.deflections"),
        Row::statement("fig08.exit_at_visible", AS_PRINTED, visible),
        Row::number(
            "fig08.stick_time_outside_zones",
            AS_PRINTED,
            found.outside_zones,
            "1",
        ),
    ]
}

fn exact(data: &Data) -> Vec<Row> {
    let exact = &data.exact;
    vec![
        // The settled orbit closes after one period; only another attractor could be stick–slip of period two.
        Row::statement("fig08.two_periodic", EXACT, data.shares.stick_slip > 0.0),
        Row::count("fig08.sticks_per_period", EXACT, exact.sticks as u64),
        Row::number("fig08.slip_duration.below", EXACT, exact.below, "s"),
        Row::number("fig08.slip_duration.above", EXACT, exact.above, "s"),
        Row::number("fig08.crossing.left", EXACT, exact.left, "m"),
        Row::number("fig08.crossing.right", EXACT, exact.right, "m"),
        Row::number(
            "fig08.multiplier.modulus.1",
            EXACT,
            exact.multipliers[0],
            "1",
        ),
        Row::number(
            "fig08.multiplier.modulus.2",
            EXACT,
            exact.multipliers[1],
            "1",
        ),
    ]
}

fn shares(data: &Data) -> Vec<Row> {
    let shares = &data.shares;
    let share = |name: &str, value| Row::number(&format!("fig08.share.{name}"), EXACT, value, "1");
    vec![
        Row::count("fig08.share.starts", EXACT, shares.starts as u64),
        share("slip_only_period_one", shares.slip_only),
        share("slip_only_longer_period", shares.other),
        share("stick_slip", shares.stick_slip),
        share("escapes", shares.escapes),
        share("unsettled", shares.unsettled),
    ]
}
