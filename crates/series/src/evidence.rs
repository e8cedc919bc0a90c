//! The evidence for and against an exponent.

use super::averages::Average;
use super::extrapolation::Extrapolated;
use super::matrix::Matrix;
use super::result::{CHANGE_ERRORS, DataExponent, OK_ERRORS, Status};

/// Fraction of the reference points that may fail to determine a direction that still counts as
/// determined. Chosen.
const UNDETERMINED: f64 = 0.01;
/// An estimate is starved if more than this fraction of the reference points is. Most of it then
/// comes from other neighbourhoods than the requested ones.
const STARVED: f64 = 0.5;
/// The maps do not predict the series if the residual ratio is above this value: at most a third of
/// the variance is then explained. Chosen.
const UNPREDICTABLE: f64 = 0.8;
/// A change of an estimate by at most this fraction of its value is no instability. Chosen.
const STABLE_CHANGE: f64 = 0.05;

/// Mean cosine of the angle between successive steps of a series above which it is one of a flow.
/// Steps of a map turn by any angle. Chosen.
const GOES_ON: f64 = 0.5;
/// A tangent exponent of a flow is near zero if it is at most this fraction of the largest. Chosen:
/// errors do not contain the bias of finite neighbourhoods.
const ZERO_BIAS: f64 = 0.25;
/// An exponent is near zero, too, if the stretching per map differs from 1 by at most this. Chosen.
const ZERO_STRETCHING: f64 = 0.01;

/// Evidence common to all exponents.
pub(crate) struct Evidence {
    pub(crate) dimension: usize,
    pub(crate) references: usize,
    pub(crate) starved: usize,
    pub(crate) residual_ratio: f64,
    /// Time that a map takes.
    pub(crate) tau: f64,
}

impl Evidence {
    /// Assembles the result for exponent `i`. `wide` is its estimate from neighbourhoods of twice
    /// the size, if there is one.
    pub(crate) fn exponent(
        &self,
        i: usize,
        full: &Average,
        fixed: Option<&Average>,
        wide: Option<&Average>,
        corrected: Option<&Extrapolated>,
    ) -> DataExponent {
        let corrected = corrected.filter(|_| i < self.dimension);
        let best = corrected.map_or(*full, Extrapolated::best);
        let mut eps_sensitivity = match corrected {
            Some(corrected) => corrected.eps_sensitivity,
            None => wide.map_or(f64::NAN, |wide| wide.mean - full.mean),
        };
        let status = self.status(i, full, &best, eps_sensitivity, corrected);
        let is_annihilated = status == Status::Annihilated;
        if is_annihilated {
            eps_sensitivity = f64::NAN;
        }
        let of = |average: &Average| {
            if is_annihilated {
                (f64::NEG_INFINITY, f64::NAN)
            } else {
                (average.mean, average.stderr)
            }
        };
        let (value, stderr) = of(&best);
        DataExponent {
            sano_sawada: of(full),
            value,
            stderr,
            eps_sensitivity,
            status,
            fixed_rank: fixed.map(of),
            collapses: full.collapses,
            undetermined: best.undetermined,
        }
    }

    /// Marks the exponents that have the status `Ok` though the series is one of a flow without an
    /// exponent near zero.
    pub(crate) fn require_zero(&self, exponents: &mut [DataExponent], points: &Matrix) {
        let tangent = &exponents[..self.dimension];
        let largest = tangent
            .iter()
            .map(|one| one.value.abs())
            .fold(0.0, f64::max);
        let bias = (ZERO_BIAS * largest).max(ZERO_STRETCHING / self.tau);
        let is_near_zero =
            |one: &DataExponent| one.value.abs() <= bias.max(CHANGE_ERRORS * one.stderr);
        if tangent.iter().any(is_near_zero) || !goes_on(points) {
            return;
        }
        for exponent in exponents.iter_mut().filter(|one| one.status == Status::Ok) {
            exponent.status = Status::WithoutZero;
        }
    }

    /// The first reason against an exponent, in order of severity: it is not of the system, not of
    /// the data, or not of small neighbourhoods.
    fn status(
        &self,
        i: usize,
        full: &Average,
        best: &Average,
        eps_sensitivity: f64,
        corrected: Option<&Extrapolated>,
    ) -> Status {
        let is_undetermined =
            |average: &Average| average.undetermined as f64 > UNDETERMINED * average.steps as f64;
        let is_flattened =
            |corrected: &Extrapolated| corrected.noise / self.tau > OK_ERRORS * best.stderr;
        let is_small = |change: f64, errors: f64, scatter: f64, value: f64| {
            change.abs() <= (errors * scatter).max(STABLE_CHANGE * value.abs())
        };
        let moves = match corrected {
            // The change to the larger size, and the distance from the maps that linear ones are
            // compared with, if these exist. The error contains the step to size zero.
            Some(corrected) => !corrected.changes.iter().all(|change| {
                let scatter = corrected.zero.scatter;
                is_small(*change, OK_ERRORS, scatter, best.mean)
            }),
            // Without a second estimate there is no change.
            None => {
                !eps_sensitivity.is_nan()
                    && !is_small(eps_sensitivity, CHANGE_ERRORS, full.scatter, full.mean)
            }
        };
        let is_starved = self.starved as f64 > STARVED * self.references as f64;
        let reasons = [
            (
                i >= self.dimension || is_undetermined(full),
                Status::Unidentified,
            ),
            (full.collapses > 0, Status::Annihilated),
            (self.residual_ratio > UNPREDICTABLE, Status::Unpredictable),
            (is_starved, Status::Starved),
            (
                corrected.is_some() && is_undetermined(best),
                Status::Undetermined,
            ),
            (corrected.is_some_and(is_flattened), Status::Noisy),
            (moves, Status::Unstable),
        ];
        let reason = reasons.iter().find(|(holds, _)| *holds);
        reason.map_or(Status::Ok, |(_, status)| *status)
    }
}

/// Whether successive steps between points go on in about the same direction.
fn goes_on(points: &Matrix) -> bool {
    let (mut sum, mut count) = (0.0, 0.0);
    for ((one, two), three) in points
        .rows()
        .zip(points.rows().skip(1))
        .zip(points.rows().skip(2))
    {
        let parts = one.iter().zip(two).zip(three);
        let parts = parts.map(|((one, two), three)| (two - one, three - two));
        let [product, first, second] = parts.fold([0.0; 3], |[product, first, second], (a, b)| {
            [product + a * b, first + a * a, second + b * b]
        });
        if first > 0.0 && second > 0.0 {
            sum += product / (first * second).sqrt();
            count += 1.0;
        }
    }
    sum > GOES_ON * count
}

#[cfg(test)]
mod tests {
    use super::*;

    const EVIDENCE: Evidence = Evidence {
        dimension: 1,
        references: 1000,
        starved: 0,
        residual_ratio: 0.1,
        tau: 1.0,
    };

    /// An average of so few blocks that Student's error is five times the scatter.
    fn from_few_blocks(mean: f64) -> Average {
        Average {
            mean,
            stderr: 0.05,
            scatter: 0.01,
            steps: 1000,
            collapses: 0,
            undetermined: 0,
        }
    }

    #[test]
    fn few_blocks_make_the_error_wider_and_allow_for_no_more_bias() {
        let full = from_few_blocks(0.1);
        // Four times the scatter.
        let status = |change| EVIDENCE.status(0, &full, &full, change, None);
        assert_eq!(status(0.039), Status::Ok);
        assert_eq!(status(0.041), Status::Unstable);
        // Twice, for the step from the larger size to zero.
        for (change, status) in [(0.019, Status::Ok), (0.021, Status::Unstable)] {
            let corrected = Extrapolated {
                zero: full,
                eps_sensitivity: f64::NAN,
                changes: [change, 0.0],
                noise: 0.0,
            };
            let best = corrected.best();
            let found = EVIDENCE.status(0, &full, &best, f64::NAN, Some(&corrected));
            assert_eq!(found, status);
            let total = (0.05_f64 * 0.05 + change * change).sqrt();
            assert!((best.stderr - total).abs() < 1e-15);
        }
    }

    #[test]
    fn a_flow_without_an_exponent_near_zero_has_none_that_is_ok() {
        let points = |turn: f64| {
            let angles = (0..200).map(|k| turn * f64::from(k));
            let points = angles.flat_map(|angle| [libm::cos(angle), libm::sin(angle)]);
            Matrix::new(points.collect(), 2)
        };
        let evidence = Evidence {
            dimension: 2,
            tau: 0.2,
            ..EVIDENCE
        };
        let statuses = |values: [f64; 2], turn: f64| {
            let mut exponents = values.map(|value| {
                let average = from_few_blocks(value);
                evidence.exponent(0, &average, None, None, None)
            });
            evidence.require_zero(&mut exponents, &points(turn));
            exponents.map(|one| one.status)
        };
        assert_eq!(statuses([1.1, -0.6], 0.3), [Status::WithoutZero; 2]);
        // Within four errors, or a quarter of the first.
        for second in [0.19, -0.19, 0.27, -0.27] {
            assert_eq!(statuses([1.1, second], 0.3), [Status::Ok; 2]);
        }
        assert_eq!(statuses([0.1, -0.6], 0.3), [Status::Ok; 2]);
        // A map turns further in a step, and needs no zero.
        assert_eq!(statuses([1.1, -0.6], 2.4), [Status::Ok; 2]);
    }
}
