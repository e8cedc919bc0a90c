//! The spectrum and the evidence for it.

use super::directions::Direction;
use super::extrapolation::Sizes;
use super::settings::DataSettings;

/// Whether the series determines an exponent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Belongs to a direction in which the points spread, and there is no sign of an error
    /// beyond the standard error.
    Ok,
    /// Belongs to such a direction, but depends on the size of the neighbourhoods, by the
    /// curvature of map and attractor. An extrapolated exponent at size zero differs from that at
    /// the larger size by more than two statistical errors and 5 %. Or requested linear maps differ
    /// from quadratic ones by as much. With [`super::Estimator::SanoSawada`], neighbourhoods of
    /// twice the size change it by more than four standard errors and 5 %.
    Unstable,
    /// Belongs to such a direction, but at more than half of the reference points the ball held
    /// too few neighbours. The nearest points were taken there, at any distance. This is not the
    /// requested estimate.
    Starved,
    /// Belongs to such a direction, but the maps that are extrapolated are often undetermined:
    /// at more than 1 % of the reference points ([`DataExponent::undetermined`]). Values on a grid
    /// are an example.
    Undetermined,
    /// Belongs to such a direction, but noise may flatten the maps that are extrapolated by more
    /// than two errors. What they leave unpredicted of the images is taken for noise, the same in
    /// all columns, of images and points. Slopes, and logarithms of stretchings, are too small by
    /// its fraction of the neighbours' variance in a direction. The first exponent is compared with
    /// the widest direction, and so on. Many exponents with this status are within two errors
    /// nevertheless.
    Noisy,
    /// The points follow a flow, each step in about the direction of the one before, and no tangent
    /// exponent is near zero. A flow has an exponent zero along itself. So neighbours are none, or
    /// a direction is missing, as of a column that is not embedded in enough values.
    WithoutZero,
    /// The maps do not predict where neighbours go ([`DataSpectrum::residual_ratio`] above 0.8).
    /// The points are not states of a deterministic system, or noise is as large as the
    /// neighbourhoods.
    Unpredictable,
    /// The series has no points in that direction. The value comes from curvature, noise or the
    /// regularisation and is no property of the system.
    Unidentified,
    /// The direction is lost: maps that the data do determine take it to nothing. The exponent is
    /// minus infinity.
    Annihilated,
}

impl Status {
    /// All of them.
    pub const ALL: [Status; 9] = [
        Status::Ok,
        Status::Unstable,
        Status::Starved,
        Status::Undetermined,
        Status::Noisy,
        Status::WithoutZero,
        Status::Unpredictable,
        Status::Unidentified,
        Status::Annihilated,
    ];

    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Unstable => "unstable",
            Status::Starved => "starved",
            Status::Undetermined => "undetermined",
            Status::Noisy => "noisy",
            Status::WithoutZero => "without-zero",
            Status::Unpredictable => "unpredictable",
            Status::Unidentified => "unidentified",
            Status::Annihilated => "annihilated",
        }
    }
}

/// An exponent estimated from a series.
#[derive(Clone, Debug, PartialEq)]
pub struct DataExponent {
    /// Exponent per unit of time, by the estimator of the settings. With [`Status::Unidentified`]
    /// it is that of an uncertain fit, or NaN if no reference point determines it. With
    /// [`Status::Annihilated`] it is minus infinity.
    pub value: f64,
    /// Standard error. With [`super::Estimator::SanoSawada`] it is that of the mean, from the
    /// scatter between blocks of time; it is statistical only and excludes bias.
    /// [`super::Estimator::Extrapolated`] adds, in squares, the step from the larger size to zero
    /// and the distance of requested linear maps from quadratic ones. A block has ten reference
    /// points at least. With fewer than 32 blocks, a quotient of Student's quantiles widens the
    /// error, so that two errors hold as much. NaN where nothing determines the value.
    pub stderr: f64,
    /// The exponent by Eqs. (25) and (26), with its statistical error: the value itself with
    /// [`super::Estimator::SanoSawada`].
    pub sano_sawada: (f64, f64),
    /// Change of the value with neighbourhoods of twice the size. For
    /// [`super::Estimator::SanoSawada`] radius and counts are doubled; `stderr` does not contain
    /// that bias. Otherwise the change is from the smaller to the larger of
    /// [`DataSpectrum::sizes`]. NaN for [`Status::Annihilated`] and where one of the two does not
    /// exist.
    pub eps_sensitivity: f64,
    /// Whether the value is meaningful.
    pub status: Status,
    /// The exponent by the fit of fixed rank, with its standard error; nothing beyond that rank.
    pub fixed_rank: Option<(f64, f64)>,
    /// Reference points at which the direction was annihilated.
    pub collapses: usize,
    /// Reference points whose neighbours do not determine it, by the maps that `value` comes from.
    pub undetermined: usize,
}

/// Neighbours per reference point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Fewest.
    pub min: usize,
    /// Median.
    pub median: usize,
    /// Most.
    pub max: usize,
}

/// A running mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Running {
    /// Time covered.
    pub t: f64,
    /// The exponents until then; NaN as long as nothing determines them.
    pub exponents: Vec<f64>,
}

/// The result of [`super::data_spectrum`].
#[derive(Clone, Debug, PartialEq)]
pub struct DataSpectrum {
    /// The exponents, in the order the chain finds them: descending, but for differences within the
    /// error.
    pub exponents: Vec<DataExponent>,
    /// Sum of the exponents of the tangent directions, with its standard error, which is smaller
    /// than theirs where what one gains the other loses. NaN where there is none; see
    /// [`DataSpectrum::balance`].
    pub sum: (f64, f64),
    /// Number of tangent directions: the number of exponents that the series can determine.
    pub dimension: usize,
    /// Rank of the second fit.
    pub fixed_rank: usize,
    /// The directions of the neighbourhoods, the widest first.
    pub directions: Vec<Direction>,
    /// Spread of the signal, `√Σ var`, in the unit of the data.
    pub spread: f64,
    /// Mean distance of the furthest neighbour used, in the unit of the data.
    pub mean_eps: f64,
    /// Neighbours per reference point.
    pub neighbours: Counts,
    /// Reference points.
    pub references: usize,
    /// Reference points whose ball held fewer neighbours than requested. Where exponents are
    /// extrapolated, those at which the smaller neighbourhood reaches farther than one and a half
    /// radii of the ball.
    pub starved: usize,
    /// Median over reference points of the part of the images' deviations that the local map does
    /// not predict (root mean square per degree of freedom). It is near 0 for states of a smooth
    /// deterministic system. It is near 1 for noise, and for a single column of a system of more
    /// dimensions. NaN if no neighbourhood has more points than its map has columns.
    pub residual_ratio: f64,
    /// Sizes from which the exponents were extrapolated; `None` with
    /// [`super::Estimator::SanoSawada`].
    pub sizes: Option<Sizes>,
    /// Running means of the exponents, some 400 rows.
    pub convergence: Vec<Running>,
    /// The settings, with the values chosen by the estimator filled in.
    pub settings: DataSettings,
}

/// Standard errors within which `ok` promises the truth: two hold 95 % of a normal distribution.
pub const OK_ERRORS: f64 = 2.0;
/// Standard errors by which two estimates of the same exponent may differ, as both have an error.
pub(crate) const CHANGE_ERRORS: f64 = 2.0 * OK_ERRORS;
/// Largest relative error of a divergence given to three digits or more.
const DIVERGENCE_ERROR: f64 = 5e-4;

/// Comparison of a spectrum with a known divergence.
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
    /// The series determines only some of the exponents: the sum of the others.
    Rest {
        /// Number of the others; if it is one, `sum` is that exponent.
        exponents: usize,
        /// Sum of the others.
        sum: f64,
        /// Standard error.
        stderr: f64,
    },
    /// No sum is known: no exponent is, or one is minus infinity.
    Unknown,
}

impl DataSpectrum {
    /// Compares the sum of the exponents with the mean divergence of the system, per unit of time.
    /// For a flow that is the trace of the Jacobian. For a map it is `ln |det J|`, over the `dt`
    /// between two points. The columns must be the states of the system, no more and no fewer.
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
                agrees: excess.abs()
                    <= (OK_ERRORS * stderr).max(DIVERGENCE_ERROR * divergence.abs()),
            },
            exponents => Balance::Rest {
                exponents,
                sum: -excess,
                stderr,
            },
        }
    }
}
