//! Distances of rows from the published exponents, and counts of rows that confirm published
//! values.

use std::collections::BTreeSet;

use super::plan::{DIFFERENCE_CAP, Exponents, Group, SEARCH, ZERO_SIZE};
use super::table::{ConfigurationRow, OrbitVerdict, Twelve};
use crate::numbers::{extent, median};
use stickslip_series::Status;

/// Root mean square of the differences over some figures (0, 1, 2).
pub fn distance(values: &Twelve, wanted: &Twelve, figures: &[usize]) -> f64 {
    let square = |(value, wanted): (&f64, &f64)| {
        let difference = (value - wanted).abs() / (wanted.abs() + ZERO_SIZE);
        let bounded = difference.min(DIFFERENCE_CAP);
        bounded * bounded
    };
    let of_figure = |&f: &usize| values[f].iter().zip(&wanted[f]).map(square).sum::<f64>();
    let sum: f64 = figures.iter().map(of_figure).sum();
    (sum / (4 * figures.len()) as f64).sqrt()
}

/// Distances for each of the three figures, and for all.
pub fn scores(values: &Twelve, wanted: &Twelve) -> [f64; 4] {
    [&[0][..], &[1], &[2], &[0, 1, 2]].map(|figures| distance(values, wanted, figures))
}

/// Rows of a search, by role.
pub struct RowsByRole<'a> {
    /// Rows that compete.
    pub search: Vec<&'a ConfigurationRow>,
    /// Configurations among these whose reading keeps all three motions.
    pub kept: Vec<&'a ConfigurationRow>,
    /// Configurations among these with all three kinds of motion. No others are ranked.
    pub ranked: Vec<&'a ConfigurationRow>,
    /// One row for each pair of reading and integrator. Its motions do not depend on the estimator.
    pub pairs: Vec<&'a ConfigurationRow>,
    /// The recommended reading under all settings.
    pub recommended: Vec<&'a ConfigurationRow>,
}

impl<'a> RowsByRole<'a> {
    /// Sorts the rows of a table, in its order.
    pub fn of(rows: &'a [ConfigurationRow]) -> RowsByRole<'a> {
        let of =
            |is: &dyn Fn(&ConfigurationRow) -> bool| rows.iter().filter(|row| is(row)).collect();
        let competes = |row: &ConfigurationRow| row.key[0] == SEARCH;
        let search: Vec<&ConfigurationRow> = of(&competes);
        let mut recommended: Vec<&ConfigurationRow> = of(&|row| Group::recommended().has(row));
        // One of the settings belongs to the search and to the spread.
        let mut settings = BTreeSet::new();
        recommended.retain(|row| settings.insert(&*row.key[3]));
        let mut pairs = search.clone();
        pairs.dedup_by(|one, other| one.key[1..3] == other.key[1..3]);
        RowsByRole {
            kept: of(&|row| competes(row) && row.all_bounded()),
            ranked: of(&|row| competes(row) && row.is_ranked()),
            recommended,
            search,
            pairs,
        }
    }
}

/// Numbers of distinct readings, integrators and settings among the rows.
pub fn sources(rows: &[&ConfigurationRow]) -> [usize; 3] {
    [1, 2, 3].map(|part| {
        let names: BTreeSet<&str> = rows.iter().map(|row| &*row.key[part]).collect();
        names.len()
    })
}

/// Words for the numbers of readings, integrators and settings.
pub fn sources_in_words([readings, integrators, settings]: [usize; 3]) -> String {
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    format!(
        "{readings} reading{}, {integrators} integrator{}, {settings} setting{} of the estimator",
        plural(readings),
        plural(integrators),
        plural(settings)
    )
}

/// Number of settings, tried with the recommended reading, that confirm the statements of Sect. 5.2
/// on exponents. An exponent of size up to [`ZERO_SIZE`] counts as zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConfirmedStatements {
    /// Each figure has a zero exponent.
    pub zero: usize,
    /// The first two exponents of Fig. 11 are zero.
    pub two_zeros: usize,
    /// The first exponent of Fig. 12 is positive.
    pub positive: usize,
}

impl ConfirmedStatements {
    /// Counts over some rows.
    pub fn count(rows: &[&ConfigurationRow]) -> ConfirmedStatements {
        let with =
            |is: &dyn Fn(&Twelve) -> bool| rows.iter().filter(|row| is(&row.exponents)).count();
        let zero = |value: &f64| value.abs() <= ZERO_SIZE;
        ConfirmedStatements {
            zero: with(&|all| all.iter().all(|four| four.iter().any(zero))),
            two_zeros: with(&|all| all[1][..2].iter().all(zero)),
            positive: with(&|all| all[2][0] > ZERO_SIZE),
        }
    }
}

/// Pairs of reading and integrator. Each pair has one class for each figure, whatever the
/// estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairCounts {
    /// Number of pairs.
    pub all: usize,
    /// Pairs whose three motions stay bounded and can be integrated.
    pub kept: usize,
    /// Pairs with the captioned class, for each figure; for Fig. 10 that is two-periodic.
    pub class: [usize; 3],
    /// Pairs with all three captioned classes.
    pub classes: usize,
    /// Pairs with the captioned kind of motion, for each figure. For Fig. 10 that is periodic with
    /// any number of loops.
    pub kind: [usize; 3],
    /// Pairs with all three captioned kinds.
    pub kinds: usize,
}

impl PairCounts {
    /// Counts over one row for each pair.
    pub fn count(pairs: &[&ConfigurationRow]) -> PairCounts {
        let with =
            |has: &dyn Fn(&ConfigurationRow) -> bool| pairs.iter().filter(|row| has(row)).count();
        PairCounts {
            all: pairs.len(),
            kept: with(&ConfigurationRow::all_bounded),
            class: [0, 1, 2].map(|f| with(&|row| row.classes[f].is_published(f))),
            classes: with(&|row| row.right(OrbitVerdict::is_published) == 3),
            kind: [0, 1, 2].map(|f| with(&|row| row.classes[f].is_of_kind(f))),
            kinds: with(&ConfigurationRow::is_ranked),
        }
    }
}

/// Number of rows that give the printed digits of exponent `k` of a figure, both from 0.
pub fn count_matching(
    rows: &[&ConfigurationRow],
    (figure, k): (usize, usize),
    published: &Exponents,
) -> usize {
    let agrees = |row: &&&ConfigurationRow| published[figure][k].agrees(row.exponents[figure][k]);
    rows.iter().filter(agrees).count()
}

/// One value for each exponent of each figure.
pub fn for_each_exponent<T>(of: impl Fn((usize, usize)) -> T) -> [[T; 4]; 3] {
    [0, 1, 2].map(|figure| [0, 1, 2, 3].map(|k| of((figure, k))))
}

/// The results of all settings for one exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentSpread {
    /// The finite values from settings that identify it; `None` if there is none.
    pub values: Option<ValueRange>,
    /// Number of settings.
    pub settings: usize,
    /// Settings whose neighbours do not span the direction: the exponent is
    /// [`Status::Unidentified`].
    pub unidentified: usize,
    /// Settings for which it is [`Status::Starved`] or [`Status::Unpredictable`].
    pub doubtful: usize,
    /// Settings that give the published digits, identified or not.
    pub agreeing: usize,
}

/// Finite values of an exponent (1/t).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueRange {
    /// Minimum.
    pub least: f64,
    /// Median; for an even count, the mean of the middle two.
    pub median: f64,
    /// Maximum.
    pub largest: f64,
}

impl ExponentSpread {
    /// Spread of exponent `k` of a figure, both from 0.
    pub fn of(
        rows: &[&ConfigurationRow],
        (figure, k): (usize, usize),
        published: &Exponents,
    ) -> ExponentSpread {
        let having = |statuses: &[Status]| {
            let has = |row: &&&ConfigurationRow| {
                statuses.iter().any(|s| s.word() == row.statuses[figure][k])
            };
            rows.iter().filter(has).count()
        };
        let unidentified = Status::Unidentified.word();
        let identified = rows
            .iter()
            .filter(|row| row.statuses[figure][k] != unidentified);
        let finite = identified.map(|row| row.exponents[figure][k]);
        let finite: Vec<f64> = finite.filter(|value| value.is_finite()).collect();
        let (least, largest) = extent(finite.iter().copied());
        ExponentSpread {
            values: median(&finite).map(|median| ValueRange {
                least,
                median,
                largest,
            }),
            settings: rows.len(),
            unidentified: having(&[Status::Unidentified]),
            doubtful: having(&[Status::Starved, Status::Unpredictable]),
            agreeing: count_matching(rows, (figure, k), published),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::plan::Plan;

    #[test]
    fn distances_are_those_of_the_formula_and_nothing_is_worse_than_the_cap() {
        let target = Plan::full().unwrap().target;
        // One exponent of twelve is off by half its size with the floor: the root of 0.25/12.
        let mut off = target;
        off[2][0] += 0.5 * (target[2][0].abs() + ZERO_SIZE);
        let wanted = (0.25_f64 / 12.0).sqrt();
        assert!((distance(&off, &target, &[0, 1, 2]) - wanted).abs() < 1e-12);
        assert_eq!(distance(&off, &target, &[0, 1]), 0.0);
        let none = [[f64::NAN, f64::NEG_INFINITY, 1e9, -1e9]; 3];
        assert_eq!(distance(&none, &target, &[0, 1, 2]), DIFFERENCE_CAP);
    }
}
