//! Integration and estimation for each configuration.

use super::orbit::{Outcome, follow};
use super::plan::{self, Group, PartSetting, Plan};
use super::scoring::scores;
use super::settings::{Setting, Unit};
use super::table::{self, ConfigurationRow, OrbitVerdict};
use crate::figures::block_and_bracket::DT;
use crate::numbers::extent;
use crate::paper::models::Caption;
use stickslip_series::{DataExponent, Neighbourhood, Series, data_spectrum};

/// A series with its spread `√Σ var`, and the same with every column scaled by its range.
pub struct Scaled {
    plain: (Series, f64),
    by_range: (Series, f64),
}

impl Scaled {
    /// Scaled states at equal intervals; `None` if there is no series of them.
    pub fn of(rows: &[[f64; 4]]) -> Option<Scaled> {
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

fn with_spread(rows: &[[f64; 4]]) -> Option<(Series, f64)> {
    let n = rows.len() as f64;
    let means = [0, 1, 2, 3].map(|c| rows.iter().map(|x| x[c]).sum::<f64>() / n);
    let square =
        |x: &[f64; 4]| -> f64 { (0..4).map(|c| (x[c] - means[c]) * (x[c] - means[c])).sum() };
    let variance = rows.iter().map(square).sum::<f64>() / n;
    Some((
        Series::from_rows(rows.iter().copied(), DT).ok()?,
        variance.sqrt(),
    ))
}

/// The rows of a group under some settings. A figure's exponents are estimated only if they can
/// count. Either the reading keeps all three motions, or this motion is of the published kind.
pub fn rows(plan: &Plan, group: &Group, settings: &[PartSetting]) -> Vec<ConfigurationRow> {
    let outcomes = Caption::ALL.map(|caption| follow(group, &caption, plan));
    let classes = outcomes.each_ref().map(Outcome::verdict);
    let kept = classes.iter().all(|class| class.is_bounded());
    let (mut sizes, mut series) = ([[f64::NAN; 2]; 3], [const { Err(table::NO_SERIES) }; 3]);
    for (figure, outcome) in outcomes.iter().enumerate() {
        let Outcome::Bounded(motion) = outcome else {
            continue;
        };
        sizes[figure] = [motion.amplitude, motion.dimension];
        series[figure] = match kept || classes[figure].is_of_kind(figure) {
            true => Scaled::of(&motion.series).ok_or(table::NO_ESTIMATE),
            false => Err(table::READING_LOST),
        };
    }
    let row = |setting: &PartSetting| {
        let mut row = ConfigurationRow {
            classes,
            sizes,
            ..ConfigurationRow::empty(plan::key(group, setting))
        };
        for (figure, series) in series.iter().enumerate() {
            (row.exponents[figure], row.statuses[figure]) = match series {
                Ok(series) => spectrum(series, &setting.1),
                Err(why) => none(why),
            };
        }
        row.scores = scores(&row.exponents, &plan.target);
        row
    };
    settings.iter().map(row).collect()
}

/// The three motions of a row in words. The table does not have the time of an escape, so the orbit
/// is recomputed up to it, which is cheap.
pub fn motions(plan: &Plan, row: &ConfigurationRow) -> [String; 3] {
    let group = plan.groups.iter().find(|group| group.has(row));
    let mut motions = row.motions();
    for (figure, caption) in Caption::ALL.iter().enumerate() {
        let again = group.filter(|_| row.classes[figure] == OrbitVerdict::Escaped);
        if let Some(Outcome::Escaped(t)) = again.map(|group| follow(group, caption, plan)) {
            motions[figure] = format!("escaped at t = {t:.1}");
        }
    }
    motions
}

type FourExponents = ([f64; 4], [&'static str; 4]);

fn none(why: &'static str) -> FourExponents {
    ([f64::NAN; 4], [why; 4])
}

/// Exponents in descending order, as the paper prints them, whatever their status.
fn spectrum(scaled: &Scaled, setting: &Setting) -> FourExponents {
    let (mut values, mut statuses) = none(table::NO_ESTIMATE);
    for (k, exponent) in estimate(scaled, setting).iter().take(4).enumerate() {
        (values[k], statuses[k]) = (exponent.value, exponent.status.word());
    }
    (values, statuses)
}

/// Exponents with their errors; none if the estimator gives none.
pub fn estimate(scaled: &Scaled, (unit, settings): &Setting) -> Vec<DataExponent> {
    let (series, unit) = match unit {
        Unit::Spread => (&scaled.plain.0, 1.0),
        Unit::Absolute => (&scaled.plain.0, scaled.plain.1),
        Unit::Ranges => (&scaled.by_range.0, scaled.by_range.1),
    };
    let mut settings = settings.clone();
    if let Neighbourhood::Ball { eps, .. } = &mut settings.neighbours {
        *eps /= unit;
    }
    let spectrum = data_spectrum(series, &settings);
    let mut exponents = spectrum.map_or_else(|_| Vec::new(), |spectrum| spectrum.exponents);
    // NaN comes last.
    let rank = |value: f64| value.max(f64::NEG_INFINITY);
    exponents.sort_by(|one, other| rank(other.value).total_cmp(&rank(one.value)));
    exponents
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::settings::everywhere;
    use approx::relative_eq;
    use numerics::SplitMix;
    use rayon::prelude::*;
    use stickslip::math;

    /// A torus with two incommensurate frequencies, one of them in columns of another scale.
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

    fn found(rows: &[[f64; 4]], unit: Unit, eps: f64) -> FourExponents {
        let data = stickslip_series::DataSettings {
            neighbours: Neighbourhood::Ball {
                eps,
                min: 12,
                max: 200,
            },
            ..everywhere(1)
        };
        spectrum(&Scaled::of(rows).unwrap(), &(unit, data))
    }

    /// Three rows for each figure with exponents, chosen by a fixed seed. The shortest steps,
    /// twelve million for each orbit, are left to `make readings`.
    #[test]
    fn rows_of_the_committed_table_come_out_again() {
        let plan = Plan::full().unwrap();
        let table = include_str!("../../golden/readings.csv");
        let rows: Vec<ConfigurationRow> =
            table.lines().filter_map(ConfigurationRow::parse).collect();
        let mut random = SplitMix::new(61);
        let mut chosen = Vec::new();
        for figure in 0..3 {
            let has = |row: &&ConfigurationRow| {
                let exponents = row.exponents[figure];
                exponents.iter().all(|v| v.is_finite()) && row.key[2] != "in-place h=0.001"
            };
            let rows: Vec<&ConfigurationRow> = rows.iter().filter(has).collect();
            let mut draw = || rows[random.between(0.0, rows.len() as f64) as usize];
            chosen.extend([draw(), draw(), draw()].map(|row| (figure, row)));
        }
        chosen
            .into_par_iter()
            .with_max_len(1)
            .for_each(|(figure, row)| {
                let group = plan.groups.iter().find(|group| group.has(row)).unwrap();
                let settings = plan.settings_of(group);
                let of_row = |one: &&PartSetting| plan::key(group, one) == row.key;
                let (_, setting) = settings.iter().find(of_row).unwrap();
                let outcome = follow(group, &Caption::ALL[figure], &plan);
                let what = format!("Fig. {}, {:?}", figure + 10, row.key);
                assert_eq!(outcome.verdict(), row.classes[figure], "{what}");
                let Outcome::Bounded(motion) = outcome else {
                    panic!("{what}");
                };
                let close = |found: f64, golden: f64| {
                    let same = found.is_nan() && golden.is_nan();
                    assert!(
                        same || relative_eq!(found, golden, max_relative = 1e-10),
                        "{what}"
                    );
                };
                close(motion.amplitude, row.sizes[figure][0]);
                close(motion.dimension, row.sizes[figure][1]);
                let (values, statuses) = spectrum(&Scaled::of(&motion.series).unwrap(), setting);
                assert_eq!(statuses, row.statuses[figure], "{what}");
                for (found, golden) in values.into_iter().zip(row.exponents[figure]) {
                    close(found, golden);
                }
            });
    }

    #[test]
    fn a_radius_is_measured_in_its_unit() {
        let (plain, stretched) = (torus(1.0), torus(4.0));
        // The spread of this torus is √2.
        let root = std::f64::consts::SQRT_2;
        assert_eq!(
            found(&plain, Unit::Absolute, 0.3),
            found(&plain, Unit::Spread, 0.3 / root)
        );
        // The same in ranges, with columns scaled by them.
        let ranges = [0, 1, 2, 3].map(|c| {
            let (low, high) = extent(plain.iter().map(|x| x[c]));
            high - low
        });
        let scaled = plain.iter().map(|x| [0, 1, 2, 3].map(|c| x[c] / ranges[c]));
        let scaled: Vec<[f64; 4]> = scaled.collect();
        assert_eq!(
            found(&plain, Unit::Ranges, 0.2),
            found(&scaled, Unit::Absolute, 0.2)
        );
        // Rescaling a column changes nothing in units of its range, and changes the result in other
        // units.
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
