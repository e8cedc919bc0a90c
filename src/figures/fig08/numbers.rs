//! The rows of Fig. 8.

use super::compute::Data;
use crate::figures::rows::Row;
use crate::paper::claim_id::ClaimId;
use crate::paper::pattern::Pattern;
use crate::paper::reading::Reading::{self, AsPrinted, Exact, SlipTimesThree};

pub(super) fn numbers(data: &Data) -> Vec<Row> {
    let mut rows = Vec::new();
    for (reading, pattern) in [
        (AsPrinted, &data.as_printed.pattern),
        (SlipTimesThree, &data.slip_times_three),
        (Exact, &data.exact.pattern),
    ] {
        rows.extend(four(reading, pattern));
        let deflections = pattern.deflections().len() as u64;
        rows.push(Row::count(ClaimId::Fig08Deflections, reading, deflections));
    }
    rows.extend(two_periodic(data));
    rows.extend(as_printed(data));
    rows.extend(exact(data));
    rows.extend(shares(data));
    rows
}

/// Lengths and durations, or how many stick phases there are instead of two.
fn four(reading: Reading, pattern: &Pattern) -> Vec<Row> {
    let found = pattern.four_numbers();
    (0..4)
        .map(|i| {
            let (id, unit) = (ClaimId::FOUR[i], ["m", "m", "s", "s"][i]);
            match found {
                Some(values) => Row::number(id, reading, values[i], unit),
                None => {
                    let count = pattern.sticks_of_one().count();
                    Row::word(id, reading, &format!("{count} stick phases"))
                }
            }
        })
        .collect()
}

fn two_periodic(data: &Data) -> Vec<Row> {
    let of_motion =
        "the settled motion sticks and repeats after two forcing periods and not after one";
    // Any attractor that the grid of starts finds may be the caption's.
    let of_grid = "a start of the grid leads to a motion that sticks and repeats after two forcing periods and not after one";
    let printed = data.as_printed.pattern.two_periodic();
    let limit = data.slip_times_three.two_periodic();
    [
        (AsPrinted, of_motion, printed),
        (SlipTimesThree, of_motion, limit),
        (Exact, of_grid, data.shares.stick_slip_two > 0.0),
    ]
    .map(|(reading, what, holds)| {
        Row::statement(ClaimId::Fig08TwoPeriodic, reading, [(what, holds)])
    })
    .into()
}

fn as_printed(data: &Data) -> Vec<Row> {
    let found = &data.as_printed;
    let sticks = found.pattern.sticks_of_one().count() as u64;
    let outside = "fig08.stick_time_outside_zones";
    vec![
        Row::count("fig08.sticks_per_pattern", AsPrinted, sticks),
        Row::number(outside, AsPrinted, found.outside_zones, "1"),
    ]
}

fn exact(data: &Data) -> Vec<Row> {
    let exact = &data.exact;
    let sticks = exact.pattern.sticks_of_one().count() as u64;
    let number = |name: &str, value, unit| Row::number(format!("fig08.{name}"), Exact, value, unit);
    vec![
        Row::count("fig08.sticks_per_period", Exact, sticks),
        number("slip_duration.below", exact.below, "s"),
        number("slip_duration.above", exact.above, "s"),
        number("crossing.left", exact.left, "m"),
        number("crossing.right", exact.right, "m"),
        number("multiplier.modulus.1", exact.multipliers[0], "1"),
        number("multiplier.modulus.2", exact.multipliers[1], "1"),
    ]
}

fn shares(data: &Data) -> Vec<Row> {
    let shares = &data.shares;
    let share = |name: &str, value| Row::number(format!("fig08.share.{name}"), Exact, value, "1");
    vec![
        Row::count("fig08.share.starts", Exact, shares.starts as u64),
        share("slip_only_period_one", shares.slip_only),
        share("slip_only_longer_period", shares.other),
        share("stick_slip", shares.stick_slip),
        share("stick_slip_period_two", shares.stick_slip_two),
        share("escapes", shares.escapes),
        share("unsettled", shares.unsettled),
    ]
}
