//! The result.

use crate::dynamics::Summary;
use crate::error::Error;
use crate::math;

/// Half-width of an exponent's confidence interval, in standard errors.
const UNCERTAINTY_ERRORS: f64 = 4.0;

/// Growth factor that a direction without exponential growth may show over a non-integer number of
/// turns. Across a family of orbits growth is proportional to time. After a transient of a tenth of
/// the measured time, that is a factor of 11.
const END_GROWTH: f64 = 30.0;

/// One Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Exponent {
    /// An exponential rate of growth.
    Finite {
        /// The exponent, per unit of time.
        value: f64,
        /// Standard error from the means of the blocks and their correlations; infinite when fewer
        /// than two were completed. It measures the fluctuation along a chaotic orbit, not the end
        /// effects of a
        /// non-integer number of periods of a periodic one.
        std_error: f64,
    },
    /// Stick or a jump takes the direction to zero in finite time: the exponent is −∞.
    Annihilated,
}

impl Exponent {
    /// The exponent, −∞ for an annihilated direction.
    pub fn value(&self) -> f64 {
        match *self {
            Exponent::Finite { value, .. } => value,
            Exponent::Annihilated => f64::NEG_INFINITY,
        }
    }

    /// Uncertainty of an exponent measured over this time: four standard errors, and at least the
    /// effect of a growth factor of 30. Undamped motion, whose exponents are zero, shows such
    /// growth. [`Spectrum::uncertainties`] also contain what other exponents and rounding do.
    pub fn uncertainty(&self, duration: f64) -> f64 {
        let scatter = UNCERTAINTY_ERRORS * self.std_error().unwrap_or(0.0);
        scatter.max(math::ln(END_GROWTH) / duration)
    }

    /// Standard error, if the exponent is finite.
    pub fn std_error(&self) -> Option<f64> {
        match *self {
            Exponent::Finite { std_error, .. } => Some(std_error),
            Exponent::Annihilated => None,
        }
    }
}

/// The exponents at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Running {
    /// Time since measuring began.
    pub elapsed: f64,
    /// Means over that time, in the order of the final exponents; −∞ after the entry into stick or
    /// the jump that annihilated the direction.
    pub exponents: Vec<f64>,
}

/// A Lyapunov spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// The exponents in descending order, annihilated ones last.
    pub exponents: Vec<Exponent>,
    /// Uncertainty of each exponent, zero for an annihilated one. It is [`Exponent::uncertainty`],
    /// or the following if that is larger. The exponents of a group are those that are equal within
    /// their uncertainties.
    /// - Rounding disturbs a frame. A second frame with larger disturbances bounds its effect, the
    ///   largest of a group for all of them: `ε^(1/m)` of their coupling in a chain of `m`.
    /// - In a chain of `m` equal exponents, vectors grow by a power of time up to `m − 1` as well,
    ///   which leaves `(m − 1) ln(t)/t`. Time is counted in transients, and in steps of the solver
    ///   without one; it is 30 at least.
    pub uncertainties: Vec<f64>,
    /// Error that ended the measurement before its duration; `None` if none did. The results are
    /// those of [`Spectrum::duration`].
    pub ended: Option<Error>,
    /// The running exponents, equally spaced in time as far as steps allow; the last entry is the
    /// result.
    pub convergence: Vec<Running>,
    /// Growth rate of the volume spanned by the surviving directions, from divergence and saltation
    /// instead of the frame's lengths; see [`Spectrum::defect`].
    pub volume_rate: f64,
    /// Mean divergence of the fields along the orbit, stick included. Without stick,
    /// `volume_rate` is this plus the mean of `ln|det S|` over the crossings.
    pub mean_divergence: f64,
    /// Entries into stick while measuring.
    pub stick_entries: usize,
    /// Collapses while measuring: directions of the kernels of singular saltation matrices. All
    /// entries into stick have one, except where the two fields agree (without normal force, say).
    /// A jump has one for each dimension that its map loses. Only those that meet a surviving
    /// direction annihilate it; [`Spectrum::annihilated`] counts those directions.
    pub collapses: usize,
    /// Fraction of the measured time spent in stick, of any contact.
    pub stick_fraction: f64,
    /// Time measured.
    pub duration: f64,
    /// End of the measured run, and its work. Where the absolute tolerance followed a decay to an
    /// equilibrium on a boundary, that is the work since it last did.
    pub summary: Summary,
}

/// The uncertainties of exponents in descending order, after a time of `span` units in which the
/// frame settled. `rounding` bounds its effect on the logarithms of growth.
pub(super) fn uncertainties(
    exponents: &[Exponent],
    rounding: &[f64],
    (duration, span): (f64, f64),
) -> Vec<f64> {
    let is_finite = |exponent: &&Exponent| **exponent != Exponent::Annihilated;
    let finite: Vec<&Exponent> = exponents.iter().take_while(is_finite).collect();
    let both = finite.iter().zip(rounding);
    let own = both.map(|(exponent, log)| exponent.uncertainty(duration).max(log / duration));
    let own: Vec<f64> = own.collect();
    let numbers: Vec<usize> = (0..finite.len()).collect();
    let is_one_group = |&i: &usize, &j: &usize| {
        let apart = finite[i].value() - finite[j].value();
        apart <= own[i] + own[j]
    };
    let mut all = Vec::with_capacity(exponents.len());
    for group in numbers.chunk_by(is_one_group) {
        let largest = group.iter().map(|&j| rounding[j]).fold(0.0, f64::max);
        let power = (group.len() - 1) as f64 * math::ln(span.max(END_GROWTH));
        all.extend(
            group
                .iter()
                .map(|&j| own[j].max(largest.max(power) / duration)),
        );
    }
    all.resize(exponents.len(), 0.0);
    all
}

impl Spectrum {
    /// Sum of the finite exponents.
    pub fn sum(&self) -> f64 {
        let finite = self.exponents.iter().map(Exponent::value);
        finite.filter(|value| value.is_finite()).sum()
    }

    /// Number of exponents that are −∞.
    pub fn annihilated(&self) -> usize {
        let dead = |exponent: &&Exponent| **exponent == Exponent::Annihilated;
        self.exponents.iter().filter(dead).count()
    }

    /// Difference between the sum of the finite exponents and the rate of volume, which is computed
    /// without them. It shows the error of integration and rounding, in the unit of an exponent. If
    /// it is large, the tolerance or the fixed step is too coarse.
    pub fn defect(&self) -> f64 {
        self.sum() - self.volume_rate
    }
}
