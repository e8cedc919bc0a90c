//! Integrates and estimates.

use super::judge::scores;
use super::orbit::{Outcome, follow};
use super::plan::{self, CAPTIONS, DT, Group, Plan, Setting, Unit};
use super::table::{self, Row, Twelve, Verdict};
use crate::numbers::extent;
use stickslip_series::{Neighbourhood, Series, data_spectrum};

/// A series with its spread, and the same with every column scaled by its range.
struct Scaled {
    plain: (Series, f64),
    by_range: (Series, f64),
}

impl Scaled {
    fn of(rows: &[[f64; 4]]) -> Option<Scaled> {
        let with_spread = |rows: &[[f64; 4]]| {
            let n = rows.len() as f64;
            let mean = |c: usize| rows.iter().map(|x| x[c]).sum::<f64>() / n;
            let means = [0, 1, 2, 3].map(mean);
            let square = |x: &[f64; 4]| -> f64 {
                (0..4).map(|c| (x[c] - means[c]) * (x[c] - means[c])).sum()
            };
            let variance = rows.iter().map(square).sum::<f64>() / n;
            let series = Series::from_rows(rows.iter().copied(), DT).ok()?;
            Some((series, variance.sqrt()))
        };
        let ranges = [0, 1, 2, 3].map(|c| {
            let (low, high) = extent(rows.iter().map(|x| x[c]));
            high - low
        });
        let scaled = |x: &[f64; 4]| [0, 1, 2, 3].map(|c| x[c] / ranges[c]);
        let by_range: Vec<[f64; 4]> = rows.iter().map(scaled).collect();
        Some(Scaled {
            plain: with_spread(rows)?,
            by_range: with_spread(&by_range)?,
        })
    }
}

/// All rows of a group. A figure's exponents are estimated where they can count: the reading keeps
/// all three motions, or this one is of the published kind.
pub fn group_rows(group: &Group, plan: &Plan, target: &Twelve) -> Vec<Row> {
    let outcomes = CAPTIONS.map(|caption| follow(group, &caption, plan));
    let classes = outcomes.each_ref().map(Outcome::verdict);
    let kept = classes.iter().all(|class| class.stays());
    let (mut sizes, mut series) = ([[f64::NAN; 2]; 3], [const { Err(table::NO_SERIES) }; 3]);
    for (figure, outcome) in outcomes.iter().enumerate() {
        let Outcome::Bounded(motion) = outcome else {
            continue;
        };
        sizes[figure] = [motion.amplitude, motion.dimension];
        series[figure] = if kept || classes[figure].is_of_kind(figure) {
            Scaled::of(&motion.series).ok_or(table::NO_ESTIMATE)
        } else {
            Err(table::LOST)
        };
    }
    let mut rows = Vec::new();
    let keys = plan::keys(plan, group).into_iter();
    for (key, (_, settings)) in keys.zip(plan.settings_of(group)) {
        let mut row = Row {
            classes,
            sizes,
            ..Row::empty(key)
        };
        for figure in 0..3 {
            (row.exponents[figure], row.statuses[figure]) = match &series[figure] {
                Ok(series) => spectrum(series, &settings),
                Err(why) => none(why),
            };
        }
        row.scores = scores(&row.exponents, target);
        rows.push(row);
    }
    rows
}

/// The three motions of a row in words. When an escape comes the table does not say, and it is
/// cheap to follow the orbit that far once more.
pub fn motions(plan: &Plan, row: &Row) -> [String; 3] {
    let group = plan.groups.iter().find(|group| group.has(row));
    std::array::from_fn(|figure| {
        let again = group.filter(|_| row.classes[figure] == Verdict::Escaped);
        match again.map(|group| follow(group, &CAPTIONS[figure], plan)) {
            Some(Outcome::Escaped(t)) => format!("escaped at t = {t:.1}"),
            _ => row.classes[figure].to_string(),
        }
    })
}

type Four = ([f64; 4], [&'static str; 4]);

fn none(why: &'static str) -> Four {
    ([f64::NAN; 4], [why; 4])
}

/// Exponents in descending order, as the paper prints them, whatever their status.
fn spectrum(scaled: &Scaled, setting: &Setting) -> Four {
    let (series, unit) = match setting.unit {
        Unit::Spread => (&scaled.plain.0, 1.0),
        Unit::Absolute => (&scaled.plain.0, scaled.plain.1),
        Unit::Ranges => (&scaled.by_range.0, scaled.by_range.1),
    };
    let mut settings = setting.data.clone();
    if let Neighbourhood::Ball { eps, .. } = &mut settings.neighbours {
        *eps /= unit;
    }
    let Ok(spectrum) = data_spectrum(series, &settings) else {
        return none(table::NO_ESTIMATE);
    };
    let exponents = spectrum.exponents.iter();
    let mut found: Vec<_> = exponents
        .map(|one| (one.value, one.status.word()))
        .collect();
    let rank = |value: f64| {
        if value.is_nan() {
            f64::NEG_INFINITY
        } else {
            value
        }
    };
    found.sort_by(|one, other| rank(other.0).total_cmp(&rank(one.0)));
    let (mut values, mut statuses) = none(table::NO_ESTIMATE);
    for (k, found) in found.into_iter().take(4).enumerate() {
        (values[k], statuses[k]) = found;
    }
    (values, statuses)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::plan::everywhere;
    use stickslip::math;

    /// Two incommensurate turns, one of them in columns of another scale.
    fn torus(scale: f64) -> Vec<[f64; 4]> {
        (0..1500)
            .map(|k| {
                let (a, b) = (
                    0.2 * f64::from(k),
                    0.2 * std::f64::consts::SQRT_2 * f64::from(k),
                );
                [
                    math::sin(a),
                    math::cos(a),
                    scale * math::sin(b),
                    scale * math::cos(b),
                ]
            })
            .collect()
    }

    fn found(rows: &[[f64; 4]], unit: Unit, eps: f64) -> Four {
        let data = stickslip_series::DataSettings {
            neighbours: Neighbourhood::Ball {
                eps,
                min: 12,
                max: 200,
            },
            ..everywhere(1)
        };
        spectrum(&Scaled::of(rows).unwrap(), &Setting { unit, data })
    }

    #[test]
    fn a_radius_is_measured_in_its_unit() {
        let (plain, stretched) = (torus(1.0), torus(4.0));
        // The spread of this torus is the root of two.
        let root = std::f64::consts::SQRT_2;
        assert_eq!(
            found(&plain, Unit::Absolute, 0.3),
            found(&plain, Unit::Spread, 0.3 / root)
        );
        // A column of another scale is the same in its range and nowhere else.
        for (unit, same) in [
            (Unit::Ranges, true),
            (Unit::Absolute, false),
            (Unit::Spread, false),
        ] {
            let (one, other) = (found(&plain, unit, 0.2), found(&stretched, unit, 0.2));
            assert_eq!(one == other, same, "{unit:?}");
        }
    }
}
