//! How well targets are met that have nothing to do with the model.

use super::row::Row;
use super::score::{self, Twelve};
use super::spread::median;
use stickslip::math;
use stickslip::statistics::SplitMix;

/// A vanishing exponent may be printed as anything between minus this and this; drawn evenly.
pub const ZERO: f64 = 0.002;
/// Least and largest size of a negative exponent; its logarithm is drawn evenly.
pub const NEGATIVE: (f64, f64) = (0.003, 1.0);
/// Least and largest positive exponent; its logarithm is drawn evenly.
pub const POSITIVE: (f64, f64) = (0.001, 0.05);

/// Every run draws the same targets.
const SEED: u64 = 0x2013_0073_0723_0736;

/// Draws targets.
struct Targets(SplitMix);

impl Targets {
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
        let mut all = [
            [
                self.zero(),
                self.negative(),
                self.negative(),
                self.negative(),
            ],
            [self.zero(), self.zero(), self.negative(), self.negative()],
            [
                self.logarithmic(POSITIVE.0, POSITIVE.1),
                self.zero(),
                self.negative(),
                self.negative(),
            ],
        ];
        for row in &mut all {
            row.sort_by(|one, other| other.total_cmp(one));
        }
        all
    }
}

/// Distance of the nearest row.
pub fn nearest(rows: &[&Row], target: &Twelve) -> f64 {
    let distance = |row: &&Row| score::all_figures(&row.exponents, target);
    rows.iter().map(distance).fold(f64::INFINITY, f64::min)
}

/// Orders of the columns other than the published one.
pub const ORDERS: [[usize; 3]; 5] = [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// Rows with most of the kinds of motion wanted of the three figures, given by the figure that has them published, and how many
/// those are.
pub fn by_kind<'a>(rows: &[&'a Row], wanted: [usize; 3]) -> (usize, Vec<&'a Row>) {
    let right = |row: &Row| {
        (0..3)
            .filter(|&f| row.classes[f].is_of_kind(wanted[f]))
            .count()
    };
    let most = rows.iter().map(|row| right(row)).max().unwrap_or(0);
    let kept = rows.iter().copied().filter(|row| right(row) == most);
    (most, kept.collect())
}

/// Of the 27 ways to give each figure one of the three kinds of motion, how many some row has entirely.
pub fn assignments_met(rows: &[&Row]) -> usize {
    let every = (0..27).map(|i| [i / 9, i / 3 % 3, i % 3]);
    every.filter(|&wanted| by_kind(rows, wanted).0 == 3).count()
}

/// How well random targets are met, beside the published exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Distance of the nearest row to the published exponents.
    pub published: f64,
    /// Least of the distances of the nearest rows to the random targets.
    pub least: f64,
    /// Their median.
    pub median: f64,
    /// Random targets that are met as well as the published exponents, or better.
    pub as_near: usize,
    /// Random targets drawn.
    pub draws: usize,
}

impl Level {
    /// With all rows, whatever their motions.
    pub(super) fn exponents_only(search: &[&Row], target: &Twelve, draws: usize) -> Level {
        Level::of(search, target, draws)
    }

    /// With the rows that have most of the published kinds of motion.
    pub(super) fn kinds_first(search: &[&Row], target: &Twelve, draws: usize) -> Level {
        Level::of(&by_kind(search, [0, 1, 2]).1, target, draws)
    }

    fn of(rows: &[&Row], target: &Twelve, draws: usize) -> Level {
        let published = nearest(rows, target);
        let random = random(rows, draws);
        Level {
            published,
            least: random.first().copied().unwrap_or(f64::NAN),
            median: median(&random).unwrap_or(f64::NAN),
            as_near: random.iter().filter(|&&one| one <= published).count(),
            draws: random.len(),
        }
    }

    /// Random targets that are met as well as the published exponents, in per cent of all.
    pub fn percent(&self) -> f64 {
        100.0 * self.as_near as f64 / self.draws.max(1) as f64
    }
}

/// Distances of the nearest rows to random targets of the published classes, ascending.
fn random(rows: &[&Row], draws: usize) -> Vec<f64> {
    let mut generator = Targets(SplitMix::new(SEED));
    let mut all: Vec<f64> = (0..draws)
        .map(|_| nearest(rows, &generator.target()))
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_have_the_signs_of_their_class() {
        let mut generator = Targets(SplitMix::new(SEED));
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
}
