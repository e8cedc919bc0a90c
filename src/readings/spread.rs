//! How far settings of the estimator that the paper does not state move an exponent: which settings, and what they make of it.
//!
//! This is the one such analysis. It has the rows of part `spread`, which are made for it, and the
//! search's rows of the same reading and integrator; the report takes them from there.

use super::counts::Exponents;
use super::plan::{MANY, everywhere};
use super::row::Row;
use stickslip_series::statistics::middle_two;
use stickslip_series::{DataSettings, Neighbourhood, Status};

/// Neighbourhoods by count and by radius, none so small that it starves. A radius is a fraction of the signal's spread.
const NEIGHBOURHOODS: [Neighbourhood; 5] = [
    Neighbourhood::Nearest(12),
    Neighbourhood::Nearest(40),
    Neighbourhood::Nearest(120),
    Neighbourhood::Ball {
        eps: 0.1,
        min: 12,
        max: MANY,
    },
    Neighbourhood::Ball {
        eps: 0.2,
        min: 40,
        max: 2 * MANY,
    },
];
/// `d` of Eq. (25).
const STEPS: [usize; 3] = [1, 3, 5];
/// Regularisations of the inverse in Eq. (25).
const RIDGES: [f64; 2] = [0.0, 1e-3];

/// What a reasonable reader of Eq. (25) could have chosen: all combinations of neighbourhoods, steps and regularisations, with affine
/// maps and reference points all over the series.
pub fn spread_settings() -> Vec<DataSettings> {
    let mut all = Vec::new();
    for neighbours in NEIGHBOURHOODS {
        for step in STEPS {
            for ridge in RIDGES {
                all.push(DataSettings {
                    neighbours,
                    ridge,
                    affine: true,
                    ..everywhere(step)
                });
            }
        }
    }
    all
}

/// The settings in words.
pub fn described() -> String {
    let (mut nearest, mut balls) = (Vec::new(), Vec::new());
    for one in NEIGHBOURHOODS {
        match one {
            Neighbourhood::Nearest(k) => nearest.push(k.to_string()),
            Neighbourhood::Ball { eps, min, max } => {
                balls.push(format!("eps {eps} with {min} to {max}"))
            }
        }
    }
    format!(
        "the nearest {} neighbours or {}; d = {}; ridge {}; affine maps",
        nearest.join(", "),
        balls.join(", "),
        STEPS.map(|step| step.to_string()).join(", "),
        RIDGES.map(|ridge| ridge.to_string()).join(", ")
    )
}

/// What all settings make of one exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentSpread {
    /// The finite values of the settings that identify it; nothing if there is none.
    pub values: Option<Values>,
    /// Settings tried.
    pub settings: usize,
    /// In how many the neighbours do not span the direction: the exponent is [`Status::Unidentified`].
    pub unidentified: usize,
    /// In how many it is [`Status::Starved`] or [`Status::Unpredictable`].
    pub doubtful: usize,
    /// How many give the published digits, identified or not.
    pub met: usize,
}

/// Finite values of an exponent (1/t).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// The least.
    pub least: f64,
    /// The median: of an even count the mean of the middle two.
    pub median: f64,
    /// The largest.
    pub largest: f64,
}

impl ExponentSpread {
    /// Of exponent `k` of a figure, both from 0.
    pub(super) fn of(
        rows: &[&Row],
        (figure, k): (usize, usize),
        published: &Exponents,
    ) -> ExponentSpread {
        let identified =
            |row: &&&Row| row.statuses[figure][k].as_str() != Status::Unidentified.word();
        let of = |row: &&Row| row.exponents[figure][k];
        let mut finite: Vec<f64> = rows
            .iter()
            .filter(identified)
            .map(of)
            .filter(|value| value.is_finite())
            .collect();
        finite.sort_by(f64::total_cmp);
        let having = |statuses: &[Status]| {
            let words: Vec<&str> = statuses.iter().map(|status| status.word()).collect();
            let has = |row: &&&Row| words.contains(&row.statuses[figure][k].as_str());
            rows.iter().filter(has).count()
        };
        let values = || {
            Some(Values {
                least: *finite.first()?,
                median: median(&finite)?,
                largest: *finite.last()?,
            })
        };
        ExponentSpread {
            values: values(),
            settings: rows.len(),
            unidentified: having(&[Status::Unidentified]),
            doubtful: having(&[Status::Starved, Status::Unpredictable]),
            met: rows
                .iter()
                .filter(|row| published[figure][k].agrees(of(row)))
                .count(),
        }
    }
}

/// Median of some values: of an even count the mean of the middle two.
pub(super) fn median(values: &[f64]) -> Option<f64> {
    middle_two(values.iter().copied()).map(|[lower, upper]| 0.5 * (lower + upper))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_count_lies_between_the_middle_two() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[1.0, 2.0, 5.0]), Some(2.0));
        assert_eq!(median(&[1.0, 2.0, 5.0, 9.0]), Some(3.5));
    }
}
