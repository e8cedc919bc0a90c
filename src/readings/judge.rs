//! How near rows come to the published exponents, how near to other targets, and how many of them
//! bear out what is published.

use std::collections::BTreeSet;

use super::plan::{CAP, FLOOR, Group, Part};
use super::table::{Row, Twelve, Verdict};
use crate::paper::claim_id::SpectrumFigure;
use crate::paper::published::{Claim, Claims, PublishedError};
use stickslip::math;
use stickslip::statistics::SplitMix;
use stickslip_series::Status;
use stickslip_series::statistics::middle_two;

/// The published exponents of Figs. 10–12, the largest first.
pub type Exponents = [[Claim; 4]; 3];

/// From the table of claims.
///
/// # Errors
/// [`PublishedError`] if one is missing.
pub fn exponents() -> Result<Exponents, PublishedError> {
    let claims = Claims::committed()?;
    Ok(SpectrumFigure::ALL.map(|figure| figure.exponents().map(|id| claims.of(id).clone())))
}

/// Their values.
///
/// # Errors
/// [`PublishedError`] if the table of claims lacks one.
pub fn target() -> Result<Twelve, PublishedError> {
    let claims = Claims::committed()?;
    Ok(SpectrumFigure::ALL.map(|figure| figure.exponents().map(|id| claims.value(id))))
}

/// Root mean square of the differences of some figures (0, 1, 2).
pub fn distance(found: &Twelve, wanted: &Twelve, figures: &[usize]) -> f64 {
    let square = |(value, wanted): (&f64, &f64)| {
        let difference = (value - wanted).abs() / (wanted.abs() + FLOOR);
        let bounded = difference.min(CAP);
        bounded * bounded
    };
    let of_figure = |&f: &usize| found[f].iter().zip(&wanted[f]).map(square).sum::<f64>();
    let sum: f64 = figures.iter().map(of_figure).sum();
    (sum / (4 * figures.len()) as f64).sqrt()
}

/// Distances of the three figures, and of all.
pub fn scores(found: &Twelve, wanted: &Twelve) -> [f64; 4] {
    [&[0][..], &[1], &[2], &[0, 1, 2]].map(|figures| distance(found, wanted, figures))
}

/// Rows of a search, by what they count for.
pub struct Rows<'a> {
    /// Those that compete.
    pub search: Vec<&'a Row>,
    /// Of these the ones whose reading keeps all three motions.
    pub kept: Vec<&'a Row>,
    /// Of these the ones with all three kinds of motion: no other is ranked.
    pub ranked: Vec<&'a Row>,
    /// One for each pair of reading and integrator: its motions do not depend on the estimator.
    pub pairs: Vec<&'a Row>,
    /// The recommended reading under all settings.
    pub recommended: Vec<&'a Row>,
}

impl<'a> Rows<'a> {
    /// All of a table, in its order.
    pub fn of(rows: &'a [Row]) -> Rows<'a> {
        let of = |is: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| is(row)).collect();
        let competes = |row: &Row| row.key[0] == Part::Search.name();
        let search: Vec<&Row> = of(&competes);
        let mut pairs = search.clone();
        pairs.dedup_by(|one, other| one.key[1..3] == other.key[1..3]);
        Rows {
            kept: of(&|row| competes(row) && row.keeps_all()),
            ranked: of(&|row| competes(row) && row.is_ranked()),
            recommended: of(&|row| Group::recommended().has(row)),
            search,
            pairs,
        }
    }
}

/// A vanishing exponent may be printed as anything between minus this and this; drawn evenly.
pub const ZERO: f64 = 0.002;
/// Least and largest size of a negative exponent; its logarithm is drawn evenly.
pub const NEGATIVE: (f64, f64) = (0.003, 1.0);
/// Least and largest positive exponent; its logarithm is drawn evenly.
pub const POSITIVE: (f64, f64) = (0.001, 0.05);
/// A match is rare if no more than this share of either kind of targets is met as well (%).
const RARE: f64 = 5.0;

/// Every run draws the same targets.
const SEED: u64 = 0x2013_0073_0723_0736;

/// Draws targets.
struct Targets(SplitMix);

impl Targets {
    fn new() -> Targets {
        Targets(SplitMix::new(SEED))
    }

    /// With evenly distributed logarithm.
    fn logarithmic(&mut self, least: f64, most: f64) -> f64 {
        math::exp(math::ln(least) + self.0.uniform() * math::ln(most / least))
    }

    fn zero(&mut self) -> f64 {
        ZERO * (2.0 * self.0.uniform() - 1.0)
    }

    fn negative(&mut self) -> f64 {
        -self.logarithmic(NEGATIVE.0, NEGATIVE.1)
    }

    /// A spectrum of each of the published classes.
    fn target(&mut self) -> Twelve {
        let mut draw = |sign| match sign {
            b'0' => self.zero(),
            b'-' => self.negative(),
            _ => self.logarithmic(POSITIVE.0, POSITIVE.1),
        };
        let mut all = [*b"0---", *b"00--", *b"+0--"].map(|signs| signs.map(&mut draw));
        for row in &mut all {
            row.sort_by(|one, other| other.total_cmp(one));
        }
        all
    }
}

/// The nearest row to a target in some of the figures (0, 1, 2), and its distance.
pub fn nearest<'a>(
    rows: impl IntoIterator<Item = &'a Row>,
    target: &Twelve,
    figures: &[usize],
) -> Option<(&'a Row, f64)> {
    rows.into_iter()
        .map(|row| (row, distance(&row.exponents, target, figures)))
        .min_by(|one, other| one.1.total_cmp(&other.1))
}

/// How many targets are met as well as the published exponents, or better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Targets met.
    pub met: usize,
    /// Targets tried.
    pub of: usize,
}

impl Share {
    fn count(met: impl Iterator<Item = bool>) -> Share {
        let mut share = Share { met: 0, of: 0 };
        for one in met {
            share.met += usize::from(one);
            share.of += 1;
        }
        share
    }

    /// In per cent.
    pub fn percent(&self) -> f64 {
        100.0 * self.met as f64 / self.of.max(1) as f64
    }

    /// The chance, in per cent, that the best of three figures is met so well (Šidák 1967).
    pub fn best_of_three(&self) -> f64 {
        let missed = 1.0 - self.percent() / 100.0;
        100.0 * (1.0 - missed * missed * missed)
    }
}

/// How near the rows come to the published exponents of some figures, and how near they come to
/// other targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Distance of the nearest row to the published exponents.
    pub published: f64,
    /// Random targets of the published classes.
    pub random: Share,
    /// Spectra with the published pattern of signs, each met by rows of other readings than its
    /// own. A reading that gives the same spectrum to the last bit is its own by another name, and
    /// a target that leaves no other reading is none.
    pub readings: Share,
}

impl Level {
    /// Of some rows, in some of the figures; `spectra` are the rows that give targets.
    pub fn of(
        rows: &[&Row],
        spectra: &[&Row],
        (target, figures): (&Twelve, &[usize]),
        draws: usize,
    ) -> Level {
        let distance = |nearest: Option<(&Row, f64)>| nearest.map_or(f64::INFINITY, |one| one.1);
        let published = distance(nearest(rows.iter().copied(), target, figures));
        let mut targets = Targets::new();
        let near_random = |_| {
            let target = targets.target();
            distance(nearest(rows.iter().copied(), &target, figures)) <= published
        };
        let near_reading = |one: &&Row| {
            let same = |row: &&&Row| {
                figures
                    .iter()
                    .all(|&f| row.exponents[f] == one.exponents[f])
            };
            let twins: Vec<&str> = spectra
                .iter()
                .filter(same)
                .map(|row| &*row.key[1])
                .collect();
            let others = rows
                .iter()
                .copied()
                .filter(|row| !twins.contains(&&*row.key[1]));
            nearest(others, &one.exponents, figures).map(|(_, near)| near <= published)
        };
        let alike = |row: &&&Row| has_signs_of(row, target, figures);
        Level {
            published,
            random: Share::count((0..draws).map(near_random)),
            readings: Share::count(spectra.iter().filter(alike).filter_map(near_reading)),
        }
    }

    /// Whether the published exponents are met better than nearly all other targets, one or three
    /// figures having been looked at.
    pub fn is_rare(&self, looks: usize) -> bool {
        let random = match looks {
            3 => self.random.best_of_three(),
            _ => self.random.percent(),
        };
        random <= RARE && self.readings.of > 0 && self.readings.percent() <= RARE
    }
}

/// Whether the exponents have the signs of the target's. One of a size up to [`ZERO`] counts as
/// zero, and its sign means nothing.
fn has_signs_of(row: &Row, target: &Twelve, figures: &[usize]) -> bool {
    figures.iter().all(|&f| {
        let mut pairs = row.exponents[f].iter().zip(&target[f]);
        pairs.all(|(found, wanted)| {
            found.is_finite() && (wanted.abs() <= ZERO || found * wanted > 0.0)
        })
    })
}

/// Each figure by itself, exponents alone: its level among all rows, and the nearest of them.
/// Nothing without rows.
pub fn alone<'a>(
    search: &[&'a Row],
    target: &Twelve,
    draws: usize,
) -> Option<[(Level, &'a Row); 3]> {
    let of = |figure: usize| {
        let (row, _) = nearest(search.iter().copied(), target, &[figure])?;
        Some((Level::of(search, search, (target, &[figure]), draws), row))
    };
    Some([of(0)?, of(1)?, of(2)?])
}

/// Half a unit of the last printed digit.
const HALF_UNIT: f64 = 5e-5;

/// Of the targets drawn for exponent `k` of a figure, how many are met to the printed digits by as
/// many rows as `wanted`, or more.
pub fn digits(rows: &[&Row], (figure, k): (usize, usize), wanted: usize, draws: usize) -> Share {
    let mut targets = Targets::new();
    Share::count((0..draws).map(|_| {
        let target = targets.target()[figure][k];
        let near = |row: &&&Row| (row.exponents[figure][k] - target).abs() <= HALF_UNIT;
        rows.iter().filter(near).count() >= wanted
    }))
}

/// From how many readings, integrators and settings rows come.
pub fn sources(rows: &[&Row]) -> [usize; 3] {
    [1, 2, 3].map(|part| {
        let names: BTreeSet<&str> = rows.iter().map(|row| &*row.key[part]).collect();
        names.len()
    })
}

/// In words.
pub fn sources_in_words([readings, integrators, settings]: [usize; 3]) -> String {
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    format!(
        "{readings} reading{}, {integrators} integrator{}, {settings} setting{} of the estimator",
        plural(readings),
        plural(integrators),
        plural(settings)
    )
}

/// Of the settings tried for the recommended reading, how many bear out what Sect. 5.2 says of
/// exponents. One of a size up to [`ZERO`] passes for zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BorneOut {
    /// Each figure has an exponent that is zero.
    pub zero: usize,
    /// The first two of Fig. 11 are.
    pub two_zeros: usize,
    /// The first of Fig. 12 is positive.
    pub positive: usize,
}

impl BorneOut {
    /// Of some rows.
    pub fn count(rows: &[&Row]) -> BorneOut {
        let with =
            |is: &dyn Fn(&Twelve) -> bool| rows.iter().filter(|row| is(&row.exponents)).count();
        let zero = |value: &f64| value.abs() <= ZERO;
        BorneOut {
            zero: with(&|all| all.iter().all(|four| four.iter().any(zero))),
            two_zeros: with(&|all| all[1][..2].iter().all(zero)),
            positive: with(&|all| all[2][0] > ZERO),
        }
    }
}

/// Pairs of reading and integrator. Each has one class for each figure, whatever the estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// All.
    pub all: usize,
    /// Those whose three motions stay bounded and can be followed.
    pub kept: usize,
    /// Those with the captioned class of each figure; for Fig. 10 that is two-periodic.
    pub class: [usize; 3],
    /// Those with all three captioned classes.
    pub classes: usize,
    /// Those with the captioned kind of motion of each figure: for Fig. 10 periodic with any number
    /// of loops.
    pub kind: [usize; 3],
    /// Those with all three captioned kinds.
    pub kinds: usize,
}

impl Pairs {
    /// Of one row for each pair.
    pub fn count(pairs: &[&Row]) -> Pairs {
        let with = |has: &dyn Fn(&Row) -> bool| pairs.iter().filter(|row| has(row)).count();
        Pairs {
            all: pairs.len(),
            kept: with(&Row::keeps_all),
            class: [0, 1, 2].map(|f| with(&|row| row.classes[f].is_published(f))),
            classes: with(&|row| row.right(Verdict::is_published) == 3),
            kind: [0, 1, 2].map(|f| with(&|row| row.classes[f].is_of_kind(f))),
            kinds: with(&Row::is_ranked),
        }
    }
}

/// How often each published exponent is met to all printed digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DigitsMet {
    /// By how many configurations each exponent of each figure is.
    pub by: [[usize; 4]; 3],
    /// The most exponents of the twelve that one configuration meets.
    pub most: usize,
}

impl DigitsMet {
    /// Of some rows.
    pub fn count(rows: &[&Row], published: &Exponents) -> DigitsMet {
        let mut met = DigitsMet::default();
        for row in rows {
            let mut of_row = 0;
            let values = row.exponents.as_flattened();
            let claims = published.as_flattened().iter().zip(values);
            for (by, (claim, value)) in met.by.as_flattened_mut().iter_mut().zip(claims) {
                let agrees = usize::from(claim.agrees(*value));
                *by += agrees;
                of_row += agrees;
            }
            met.most = met.most.max(of_row);
        }
        met
    }
}

/// What all settings make of one exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentSpread {
    /// The finite values of the settings that identify it; nothing if there is none.
    pub values: Option<Values>,
    /// Settings tried.
    pub settings: usize,
    /// In how many the neighbours do not span the direction: the exponent is
    /// [`Status::Unidentified`].
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
    pub fn of(rows: &[&Row], (figure, k): (usize, usize), published: &Exponents) -> ExponentSpread {
        let status = |row: &&Row| row.statuses[figure][k];
        let value = |row: &&Row| row.exponents[figure][k];
        let having = |statuses: &[Status]| {
            let has = |row: &&&Row| statuses.iter().any(|one| one.word() == status(row));
            rows.iter().filter(has).count()
        };
        let identified = rows
            .iter()
            .filter(|row| status(row) != Status::Unidentified.word());
        let finite = identified.map(value).filter(|value| value.is_finite());
        let mut finite: Vec<f64> = finite.collect();
        finite.sort_by(f64::total_cmp);
        let values = || {
            Some(Values {
                least: *finite.first()?,
                median: median(&finite)?,
                largest: *finite.last()?,
            })
        };
        let agrees = |row: &&&Row| published[figure][k].agrees(value(row));
        ExponentSpread {
            values: values(),
            settings: rows.len(),
            unidentified: having(&[Status::Unidentified]),
            doubtful: having(&[Status::Starved, Status::Unpredictable]),
            met: rows.iter().filter(agrees).count(),
        }
    }
}

/// Median of some values: of an even count the mean of the middle two.
pub fn median(values: &[f64]) -> Option<f64> {
    middle_two(values.iter().copied()).map(|[lower, upper]| 0.5 * (lower + upper))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let target = target().unwrap();
        let row = |reading: &str, factor: f64| Row {
            exponents: target.map(|four| four.map(|v| factor * v)),
            ..Row::empty(["search", reading, "exact", "s"].map(str::to_owned))
        };
        // Nearer to each other than to the published, from which they are 10 % off.
        let rows = [row("a", 0.9), row("b", 0.901), row("b", 0.901)];
        let all: Vec<&Row> = rows.iter().collect();
        let of = |rows: &[&Row]| Level::of(rows, rows, (&target, &[0, 1, 2]), 10).readings;
        assert_eq!(of(&all), Share { met: 3, of: 3 });
        // The only reading has no other that could meet it, and is no target.
        assert_eq!(of(&all[1..]), Share { met: 0, of: 0 });
        // Nor is the same spectrum under another name another reading.
        let twin = row("c", 0.901);
        assert_eq!(of(&[&twin, all[1]]), Share { met: 0, of: 0 });
        // Of another pattern of signs it is no target.
        let other = row("a", -0.9);
        assert_eq!(of(&[&other, all[1]]), Share { met: 0, of: 1 });
    }

    #[test]
    fn three_looks_count_as_three() {
        let share = Share { met: 1, of: 100 };
        assert!((share.best_of_three() - 2.9701).abs() < 1e-10);
        let level = |random, readings| Level {
            published: 0.1,
            random: Share {
                met: random,
                of: 100,
            },
            readings: Share {
                met: readings,
                of: 100,
            },
        };
        assert!(level(1, 5).is_rare(3) && level(5, 5).is_rare(1));
        assert!(!level(2, 5).is_rare(3) && !level(1, 6).is_rare(1));
        let without = Share { met: 0, of: 0 };
        let untested = Level {
            readings: without,
            ..level(1, 0)
        };
        assert!(!untested.is_rare(1));
    }

    #[test]
    fn distances_are_those_of_the_formula_and_nothing_is_worse_than_the_cap() {
        let target = target().unwrap();
        // One exponent of twelve off by half its size with the floor: the root of 0.25/12.
        let mut off = target;
        off[2][0] += 0.5 * (target[2][0].abs() + FLOOR);
        let wanted = (0.25_f64 / 12.0).sqrt();
        assert!((distance(&off, &target, &[0, 1, 2]) - wanted).abs() < 1e-12);
        assert_eq!(distance(&off, &target, &[0, 1]), 0.0);
        let none = [[f64::NAN, f64::NEG_INFINITY, 1e9, -1e9]; 3];
        assert_eq!(distance(&none, &target, &[0, 1, 2]), CAP);
    }

    #[test]
    fn the_median_of_an_even_count_lies_between_the_middle_two() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[1.0, 2.0, 5.0]), Some(2.0));
        assert_eq!(median(&[1.0, 2.0, 5.0, 9.0]), Some(3.5));
    }
}
