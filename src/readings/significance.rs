//! Distances of rows from the published exponents, compared with distances from other targets.

use super::plan::ZERO_SIZE;
use super::scoring::distance;
use super::table::{ConfigurationRow, Twelve};
use crate::paper::published::HALF_DIGIT;
use numerics::SplitMix;
use stickslip::math;

/// Smallest and largest size of a random negative exponent, a little wider than the published
/// range. Its logarithm is uniform.
pub const NEGATIVE_SIZES: (f64, f64) = (0.003, 1.0);
/// Smallest and largest random positive exponent, around the published one. Its logarithm is
/// uniform.
pub const POSITIVE_SIZES: (f64, f64) = (0.001, 0.05);
/// Significance level (%). A match is rare if at most this share of either kind of targets is
/// matched as well.
const SIGNIFICANCE_LEVEL: f64 = 5.0;

/// Seed of the random targets, the same in every run: the paper's year, volume and pages.
const SEED: u64 = 0x2013_0073_0723_0736;

/// Generator of random targets.
struct Targets(SplitMix);

impl Targets {
    fn new() -> Targets {
        Targets(SplitMix::new(SEED))
    }

    /// A number with uniform logarithm.
    fn logarithmic(&mut self, least: f64, most: f64) -> f64 {
        math::exp(math::ln(least) + self.0.uniform() * math::ln(most / least))
    }

    /// A spectrum of each of the published classes.
    fn target(&mut self) -> Twelve {
        let mut draw = |sign| match sign {
            b'0' => ZERO_SIZE * (2.0 * self.0.uniform() - 1.0),
            b'-' => -self.logarithmic(NEGATIVE_SIZES.0, NEGATIVE_SIZES.1),
            _ => self.logarithmic(POSITIVE_SIZES.0, POSITIVE_SIZES.1),
        };
        let mut all = [*b"0---", *b"00--", *b"+0--"].map(|signs| signs.map(&mut draw));
        for row in &mut all {
            row.sort_by(|one, other| other.total_cmp(one));
        }
        all
    }
}

/// The row nearest to a target in some of the figures (0, 1, 2), and its distance.
pub fn nearest<'a>(
    rows: impl IntoIterator<Item = &'a ConfigurationRow>,
    target: &Twelve,
    figures: &[usize],
) -> Option<(&'a ConfigurationRow, f64)> {
    rows.into_iter()
        .map(|row| (row, distance(&row.exponents, target, figures)))
        .min_by(|one, other| one.1.total_cmp(&other.1))
}

/// Number of targets matched at least as well as the published exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Targets matched.
    pub matched: usize,
    /// Targets tried.
    pub of: usize,
}

impl Share {
    fn count(matched: impl Iterator<Item = bool>) -> Share {
        let all: Vec<bool> = matched.collect();
        let matched = all.iter().filter(|one| **one).count();
        Share {
            matched,
            of: all.len(),
        }
    }

    /// Share in per cent.
    pub fn percent(&self) -> f64 {
        100.0 * self.matched as f64 / self.of.max(1) as f64
    }

    /// The probability, in per cent, that the best of three figures is matched so well (Šidák
    /// 1967).
    pub fn best_of_three(&self) -> f64 {
        let missed = 1.0 - self.percent() / 100.0;
        100.0 * (1.0 - missed * missed * missed)
    }
}

/// Distance of the rows from the published exponents of some figures, compared with their distances
/// from other targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchLevel {
    /// Distance of the nearest row from the published exponents.
    pub published: f64,
    /// Random targets of the published classes.
    pub random: Share,
    /// Spectra of other readings as targets: those with the published pattern of signs, each
    /// matched by rows of other readings. A reading that gives the same spectrum to the last bit
    /// counts as the same reading. A target without rows of other readings is skipped.
    pub readings: Share,
}

impl MatchLevel {
    /// Level of some rows, in some of the figures. The rows `spectra` give the targets.
    pub fn of(
        rows: &[&ConfigurationRow],
        spectra: &[&ConfigurationRow],
        (target, figures): (&Twelve, &[usize]),
        draws: usize,
    ) -> MatchLevel {
        let distance =
            |nearest: Option<(&ConfigurationRow, f64)>| nearest.map_or(f64::INFINITY, |one| one.1);
        let published = distance(nearest(rows.iter().copied(), target, figures));
        let mut targets = Targets::new();
        let near_random = |_| {
            let target = targets.target();
            distance(nearest(rows.iter().copied(), &target, figures)) <= published
        };
        let near_reading = |one: &&ConfigurationRow| {
            let same_in =
                |row: &ConfigurationRow, f: &usize| row.exponents[*f] == one.exponents[*f];
            let same = |row: &&&ConfigurationRow| figures.iter().all(|f| same_in(row, f));
            let twins = spectra.iter().filter(same).map(|row| row.reading());
            let twins: Vec<&str> = twins.collect();
            let others = rows.iter().copied();
            let others = others.filter(|row| !twins.contains(&row.reading()));
            nearest(others, &one.exponents, figures).map(|(_, near)| near <= published)
        };
        let alike = |row: &&&ConfigurationRow| has_signs_of(row, target, figures);
        MatchLevel {
            published,
            random: Share::count((0..draws).map(near_random)),
            readings: Share::count(spectra.iter().filter(alike).filter_map(near_reading)),
        }
    }

    /// Whether the published exponents are matched better than nearly all other targets, when one
    /// or three figures were tried.
    pub fn is_rare(&self, looks: usize) -> bool {
        let random = match looks {
            3 => self.random.best_of_three(),
            _ => self.random.percent(),
        };
        random <= SIGNIFICANCE_LEVEL
            && self.readings.of > 0
            && self.readings.percent() <= SIGNIFICANCE_LEVEL
    }
}

/// Whether the exponents have the signs of the target's. One of size up to [`ZERO_SIZE`] counts as
/// zero and may have either sign.
fn has_signs_of(row: &ConfigurationRow, target: &Twelve, figures: &[usize]) -> bool {
    figures.iter().all(|&f| {
        let mut pairs = row.exponents[f].iter().zip(&target[f]);
        pairs.all(|(found, wanted)| {
            found.is_finite() && (wanted.abs() <= ZERO_SIZE || found * wanted > 0.0)
        })
    })
}

/// Level of each figure alone among all rows, and its nearest row. `None` without rows.
pub fn single_figure_levels<'a>(
    search: &[&'a ConfigurationRow],
    target: &Twelve,
    draws: usize,
) -> Option<[(MatchLevel, &'a ConfigurationRow); 3]> {
    let of = |figure: usize| {
        let (row, _) = nearest(search.iter().copied(), target, &[figure])?;
        Some((
            MatchLevel::of(search, search, (target, &[figure]), draws),
            row,
        ))
    };
    Some([of(0)?, of(1)?, of(2)?])
}

/// Number of random targets for exponent `k` of a figure that at least `wanted` rows match to the
/// printed digits.
pub fn digits_share(
    rows: &[&ConfigurationRow],
    (figure, k): (usize, usize),
    wanted: usize,
    draws: usize,
) -> Share {
    let mut targets = Targets::new();
    Share::count((0..draws).map(|_| {
        let target = targets.target()[figure][k];
        let near =
            |row: &&&ConfigurationRow| (row.exponents[figure][k] - target).abs() <= HALF_DIGIT;
        rows.iter().filter(near).count() >= wanted
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::plan::Plan;

    #[test]
    fn targets_have_the_signs_of_their_class() {
        let mut generator = Targets::new();
        for _ in 0..1000 {
            let [periodic, quasi, chaotic] = generator.target();
            assert!(periodic[0].abs() <= 0.002 && periodic[1] < -0.002);
            assert!(quasi[1].abs() <= 0.002 && quasi[2] < -0.002);
            assert!(chaotic[0] > -0.002 && chaotic[2] < -0.002);
            for row in [periodic, quasi, chaotic] {
                assert!(row.windows(2).all(|pair| pair[0] >= pair[1]));
            }
        }
    }

    #[test]
    fn a_target_that_another_reading_gives_counts_and_one_that_its_own_gives_does_not() {
        let target = Plan::full().unwrap().target;
        let row = |reading: &str, factor: f64| ConfigurationRow {
            exponents: target.map(|four| four.map(|v| factor * v)),
            ..ConfigurationRow::empty(["search", reading, "exact", "s"].map(str::to_owned))
        };
        // Nearer to each other than to the published exponents, from which they are 10 % off.
        let rows = [row("a", 0.9), row("b", 0.901), row("b", 0.901)];
        let all: Vec<&ConfigurationRow> = rows.iter().collect();
        let of = |rows: &[&ConfigurationRow]| {
            MatchLevel::of(rows, rows, (&target, &[0, 1, 2]), 10).readings
        };
        assert_eq!(of(&all), Share { matched: 3, of: 3 });
        // A single reading has no other reading to match it, so it is not a target.
        assert_eq!(of(&all[1..]), Share { matched: 0, of: 0 });
        // The same spectrum under another name is not another reading.
        let twin = row("c", 0.901);
        assert_eq!(of(&[&twin, all[1]]), Share { matched: 0, of: 0 });
        // A spectrum with another pattern of signs is not a target.
        let other = row("a", -0.9);
        assert_eq!(of(&[&other, all[1]]), Share { matched: 0, of: 1 });
    }

    #[test]
    fn three_looks_count_as_three() {
        let share = Share {
            matched: 1,
            of: 100,
        };
        assert!((share.best_of_three() - 2.9701).abs() < 1e-10);
        let level = |random, readings| MatchLevel {
            published: 0.1,
            random: Share {
                matched: random,
                of: 100,
            },
            readings: Share {
                matched: readings,
                of: 100,
            },
        };
        assert!(level(1, 5).is_rare(3) && level(5, 5).is_rare(1));
        assert!(!level(2, 5).is_rare(3) && !level(1, 6).is_rare(1));
        let without = Share { matched: 0, of: 0 };
        let untested = MatchLevel {
            readings: without,
            ..level(1, 0)
        };
        assert!(!untested.is_rare(1));
    }
}
