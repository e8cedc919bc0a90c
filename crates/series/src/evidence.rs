//! What speaks for and against an exponent.

use super::averages::Average;
use super::extrapolation::Corrected;
use super::result::{DataExponent, Status};

/// Part of the reference points that may fail to determine a direction that counts as determined.
const UNDETERMINED: f64 = 0.01;
/// With a larger part of the reference points starved no estimate is the one asked for.
const STARVED: f64 = 0.5;
/// With a larger residual ratio the maps predict next to nothing: about a third of the variance.
const UNPREDICTABLE: f64 = 0.8;
/// Two estimates differ if they are apart by more than so many standard errors,
const STANDARD_ERRORS: f64 = 4.0;
/// and by more than this part of the value.
const PART: f64 = 0.05;
/// An extrapolation over more than so many standard errors, and more than that part of the value, is none from small sizes.
const RANGE: f64 = 2.0;

/// What is known of all exponents alike.
pub(crate) struct Evidence {
    pub(crate) dimension: usize,
    pub(crate) references: usize,
    pub(crate) starved: usize,
    pub(crate) residual_ratio: f64,
    /// Time that a map takes.
    pub(crate) tau: f64,
}

impl Evidence {
    /// Puts together what is known of exponent `i`. `wide` is its estimate from neighbourhoods of twice the size, if
    /// there is one.
    pub(crate) fn exponent<const N: usize>(
        &self,
        i: usize,
        full: &Average,
        fixed: Option<&Average>,
        wide: Option<&Average>,
        corrected: Option<&Corrected<N>>,
    ) -> DataExponent {
        let mut eps_sensitivity = match wide {
            Some(wide) => wide.mean - full.mean,
            None => f64::NAN,
        };
        let mut status = self.status(i, full, eps_sensitivity);
        let mut best = *full;
        if let Some(corrected) = corrected
            && i < self.dimension
        {
            eps_sensitivity = corrected.large[i].mean - corrected.small[i].mean;
            best = corrected.best(i);
            if status == Status::Ok {
                status = self.extrapolated(i, &best, corrected);
            }
        }
        let annihilated = status == Status::Annihilated;
        let of = |average: &Average| {
            if annihilated {
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
            eps_sensitivity: if annihilated {
                f64::NAN
            } else {
                eps_sensitivity
            },
            status,
            fixed_rank: fixed.map(of),
            collapses: full.collapses,
            undetermined: best.undetermined,
        }
    }

    /// Of an exponent that nothing speaks against before it is extrapolated, the `best` of its averages.
    fn extrapolated<const N: usize>(
        &self,
        i: usize,
        best: &Average,
        corrected: &Corrected<N>,
    ) -> Status {
        // To those at the larger size, and by the maps that judge linear ones.
        let ways = [corrected.range(i), corrected.gap(i)];
        // Two errors are to hold the true value.
        let flattened = corrected.noise[i] / self.tau > 2.0 * best.stderr;
        let tolerance = (RANGE * corrected.zero[i].scatter).max(PART * best.mean.abs());
        if best.undetermined as f64 > UNDETERMINED * corrected.counted as f64 {
            Status::Undetermined
        } else if flattened {
            Status::Noisy
        } else if ways.iter().all(|way| way.abs() <= tolerance) {
            Status::Ok
        } else {
            Status::Unstable
        }
    }

    fn status(&self, i: usize, full: &Average, eps_sensitivity: f64) -> Status {
        let references = self.references as f64;
        let tolerance = (STANDARD_ERRORS * full.scatter).max(PART * full.mean.abs());
        if i >= self.dimension || full.undetermined as f64 > UNDETERMINED * references {
            Status::Unidentified
        } else if full.collapses > 0 {
            Status::Annihilated
        } else if self.residual_ratio > UNPREDICTABLE {
            Status::Unpredictable
        } else if self.starved as f64 > STARVED * references {
            Status::Starved
        } else if eps_sensitivity.abs() > tolerance {
            Status::Unstable
        } else {
            Status::Ok
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extrapolation::Sizes;
    use crate::polynomial::Degree;

    const EVIDENCE: Evidence = Evidence {
        dimension: 1,
        references: 1000,
        starved: 0,
        residual_ratio: 0.1,
        tau: 1.0,
    };

    /// From so few blocks that Student's error is five times the scatter.
    fn from_few_blocks(mean: f64) -> Average {
        Average {
            mean,
            stderr: 0.05,
            scatter: 0.01,
            collapses: 0,
            undetermined: 0,
        }
    }

    #[test]
    fn few_blocks_make_the_error_wider_and_allow_for_no_more_bias() {
        let full = from_few_blocks(0.1);
        // Four times the scatter.
        assert_eq!(EVIDENCE.status(0, &full, 0.039), Status::Ok);
        assert_eq!(EVIDENCE.status(0, &full, 0.041), Status::Unstable);
        // Twice, on the way from the larger size to zero.
        for (way, status) in [(0.019, Status::Ok), (0.021, Status::Unstable)] {
            let corrected = Corrected {
                sizes: Sizes {
                    degree: Degree::Linear,
                    neighbours: [20, 40],
                    radius: [0.1, 0.2],
                },
                small: [full],
                large: [from_few_blocks(0.1 + way)],
                zero: [full],
                noise: [0.0],
                counted: 1000,
                judged: None,
                sum: full,
            };
            let best = corrected.best(0);
            assert_eq!(EVIDENCE.extrapolated(0, &best, &corrected), status);
            let whole = (0.05_f64 * 0.05 + way * way).sqrt();
            assert!((best.stderr - whole).abs() < 1e-15);
        }
    }
}
