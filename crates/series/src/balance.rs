//! The sum of the exponents against the divergence of the system, where the user knows it.

use super::result::DataSpectrum;

/// The sums differ if they are apart by more than so many standard errors,
const STANDARD_ERRORS: f64 = 2.0;
/// and by more than this part of the divergence: it is given in a few digits.
const ROUNDING: f64 = 5e-4;

/// What a known divergence says of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Balance {
    /// The series has points in all directions: its exponents must add up to the divergence.
    Whole {
        /// Sum of the exponents less the divergence.
        excess: f64,
        /// Standard error of the sum.
        stderr: f64,
        /// Whether the two agree within two standard errors.
        agrees: bool,
    },
    /// The series tells only some of the exponents: what the others must add up to.
    Rest {
        /// How many others there are; with one, `sum` is that exponent.
        exponents: usize,
        /// Their sum.
        sum: f64,
        /// Its standard error.
        stderr: f64,
    },
    /// No sum is known: no exponent is, or one is minus infinity.
    Unknown,
}

impl DataSpectrum {
    /// Holds the sum of the exponents against the mean divergence of the system, per unit of time: the trace of the Jacobian of a
    /// flow, `ln |det J|` of a map, over `dt` for the step between two points. The columns must be the states of the system, no more and
    /// no fewer.
    pub fn balance(&self, divergence: f64) -> Balance {
        let (sum, stderr) = self.sum;
        if !sum.is_finite() || self.dimension == 0 {
            return Balance::Unknown;
        }
        let excess = sum - divergence;
        match self.exponents.len() - self.dimension {
            0 => Balance::Whole {
                excess,
                stderr,
                agrees: excess.abs() <= (STANDARD_ERRORS * stderr).max(ROUNDING * divergence.abs()),
            },
            exponents => Balance::Rest {
                exponents,
                sum: -excess,
                stderr,
            },
        }
    }
}
