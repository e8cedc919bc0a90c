//! Integrates and estimates.

use super::plan::{DT, Group, Plan};
use super::row::{self, Row};
use super::score::{self, Twelve};
use super::store;
use super::trajectory::{Outcome, follow};
use super::verdict::Verdict;
use stickslip::analysis::data_spectrum::{DataSettings, Series, data_spectrum};
use stickslip::models::Caption;

/// The captions of Figs. 10–12.
pub const CAPTIONS: [Caption; 3] = [Caption::FIG10, Caption::FIG11, Caption::FIG12];

/// All rows of a group.
pub fn group_rows(group: &Group, plan: &Plan, target: &Twelve) -> Vec<Row> {
    let outcomes = CAPTIONS.map(|caption| follow(group, &caption, plan));
    let classes = outcomes.each_ref().map(|outcome| match outcome {
        Outcome::Bounded(_, class) => Verdict::Motion(*class),
        Outcome::Escaped => Verdict::Escaped,
        Outcome::Failed => Verdict::Failed,
    });
    let series = outcomes.each_ref().map(|outcome| match outcome {
        Outcome::Bounded(series, _) => Series::from_rows(series.iter().copied(), DT).ok(),
        _ => None,
    });
    let mut rows = Vec::new();
    for (key, (_, settings)) in store::keys(plan, group)
        .into_iter()
        .zip(plan.settings_of(group))
    {
        let mut row = Row {
            key,
            classes,
            exponents: [[f64::NAN; 4]; 3],
            statuses: Default::default(),
            scores: [0.0; 4],
        };
        for figure in 0..3 {
            let (values, statuses) = match &series[figure] {
                Some(series) => spectrum(series, &settings),
                None => none(row::NO_SERIES),
            };
            row.exponents[figure] = values;
            row.statuses[figure] = statuses;
        }
        row.scores = score::scores(&row.exponents, target);
        rows.push(row);
    }
    rows
}

type Four = ([f64; 4], [String; 4]);

fn none(why: &str) -> Four {
    ([f64::NAN; 4], [(); 4].map(|()| why.to_owned()))
}

/// Exponents in descending order, as the paper prints them, whatever their status.
fn spectrum(series: &Series, settings: &DataSettings) -> Four {
    let Ok(spectrum) = data_spectrum(series, settings) else {
        return none(row::NO_ESTIMATE);
    };
    let mut found: Vec<(f64, &str)> = spectrum
        .exponents
        .iter()
        .map(|exponent| (exponent.value, exponent.status.word()))
        .collect();
    // Those without a value last.
    let rank = |value: f64| {
        if value.is_nan() {
            f64::NEG_INFINITY
        } else {
            value
        }
    };
    found.sort_by(|one, other| rank(other.0).total_cmp(&rank(one.0)));
    let (mut values, mut statuses) = none(row::NO_ESTIMATE);
    for (k, (value, status)) in found.into_iter().take(4).enumerate() {
        values[k] = value;
        statuses[k] = status.to_owned();
    }
    (values, statuses)
}
