//! Fig. 8: the stick–slip trajectory of the listing as printed, and the motion of the stated model.

mod compute;
mod draw;

use super::FigureSpec;
use crate::figures::rows::Row;
use crate::paper::claim_id::ClaimId;
use crate::paper::pattern::Pattern;
use crate::paper::reading::Reading;
use crate::paper::slip_times_three::converged;
use compute::compute;
pub(crate) use compute::starts;
pub use compute::{Data, ListingMotion, PERIODS_FOLLOWED, START_RANGE, Shares, StatedMotion};
use draw::draw;

/// Fig. 8.
pub const FIG08: FigureSpec<Data> = FigureSpec {
    name: "fig08",
    title: "Stick–slip of the forced oscillator: as printed, and exact (Fig. 8)",
    about: "Left: the Appendix's listing run as printed, at its own step: its settled trajectory \
        with its stick phases and deflections. Right: the stated model, Eq. (17), with the same \
        parameters, solved accurately, from the listing's start. Below each, position against time \
        with the oscillating stick zones. Numbers: stick lengths and durations as printed and for \
        the listing's limit (slip three times too fast, exit tested at one end), the exact orbit's \
        crossings and slip durations, and where a grid of starts ends up.",
    compute,
    numbers,
    draw,
};

fn numbers(data: &Data) -> Vec<Row> {
    let mut rows = Vec::new();
    for (reading, pattern) in [
        (Reading::AsPrinted, &data.as_printed.pattern),
        (Reading::SlipTimesThree, &data.slip_times_three),
        (Reading::Exact, &data.exact.pattern),
    ] {
        rows.extend(stick_numbers(reading, pattern));
        let sticks = pattern.pattern_sticks().count();
        rows.push(Row::count(ClaimId::Fig08StickModes, reading, sticks));
        let deflections = pattern.deflections().len();
        rows.push(Row::count(ClaimId::Fig08Deflections, reading, deflections));
    }
    rows.extend(two_periodic(data));
    rows.extend(as_printed(data));
    rows.extend(exact(data));
    rows.extend(shares(data));
    rows
}

/// Lengths and durations of two stick phases; the number of stick phases if there are not two.
fn stick_numbers(reading: Reading, pattern: &Pattern) -> Vec<Row> {
    let numbers = pattern.stick_numbers();
    let row = |(i, unit): (usize, &'static str)| match numbers {
        Some(values) => {
            let value = match reading {
                Reading::SlipTimesThree => converged(values[i]),
                _ => values[i],
            };
            Row::number(ClaimId::STICK_NUMBERS[i], reading, value, unit)
        }
        None => {
            let count = pattern.pattern_sticks().count();
            Row::word(
                ClaimId::STICK_NUMBERS[i],
                reading,
                &format!("{count} stick phases"),
            )
        }
    };
    ["m", "m", "s", "s"]
        .into_iter()
        .enumerate()
        .map(row)
        .collect()
}

fn two_periodic(data: &Data) -> Vec<Row> {
    let of_motion =
        "the settled motion sticks and repeats after two forcing periods and not after one";
    // Any attractor of the grid of starts may be the caption's.
    let of_grid = "a start of the grid leads to a motion that sticks and repeats after two forcing \
        periods and not after one";
    let printed = data.as_printed.pattern.two_periodic();
    let limit = data.slip_times_three.two_periodic();
    [
        (Reading::AsPrinted, of_motion, printed),
        (Reading::SlipTimesThree, of_motion, limit),
        (Reading::Exact, of_grid, data.shares.stick_slip_two > 0.0),
    ]
    .map(|(reading, what, holds)| {
        Row::statement(ClaimId::Fig08TwoPeriodic, reading, [(what, holds)])
    })
    .into()
}

fn as_printed(data: &Data) -> Vec<Row> {
    let outside = "fig08.stick_time_outside_zones";
    let value = data.as_printed.outside_zones;
    vec![Row::number(outside, Reading::AsPrinted, value, "1")]
}

fn exact(data: &Data) -> Vec<Row> {
    let exact = &data.exact;
    let number =
        |name: &str, value, unit| Row::number(format!("fig08.{name}"), Reading::Exact, value, unit);
    vec![
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
    let share =
        |name: &str, value| Row::number(format!("fig08.share.{name}"), Reading::Exact, value, "1");
    vec![
        Row::count("fig08.share.starts", Reading::Exact, shares.starts),
        share("slip_only_period_one", shares.slip_only),
        share("slip_only_longer_period", shares.other),
        share("stick_slip", shares.stick_slip),
        share("stick_slip_period_two", shares.stick_slip_two),
        share("escapes", shares.escapes),
        share("unsettled", shares.unsettled),
    ]
}
