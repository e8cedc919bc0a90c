//! The spectrum and the evidence for it.

use super::directions::Direction;
use super::settings::DataSettings;

/// Whether an exponent can be had from the series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It belongs to a direction that the series has points in.
    Ok,
    /// The series has no points in that direction. The value comes from curvature, noise or the regularisation and is no
    /// property of the system.
    Unidentified,
    /// The direction is lost: maps that the data do determine take it to nothing. The exponent is minus infinity.
    Annihilated,
}

impl Status {
    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Unidentified => "unidentified",
            Status::Annihilated => "annihilated",
        }
    }
}

/// An exponent estimated from a series.
#[derive(Clone, Debug, PartialEq)]
pub struct DataExponent {
    /// Per unit of time, by the fit of full rank, Eq. (25). For [`Status::Unidentified`] what that fit happens to give, or NaN if
    /// no reference point determines it; for [`Status::Annihilated`] minus infinity.
    pub value: f64,
    /// Standard error of the mean from the scatter between blocks of time; it knows nothing of bias. NaN for too short a
    /// series.
    pub stderr: f64,
    /// Whether the value means something.
    pub status: Status,
    /// The exponent by the fit of fixed rank, with its standard error; nothing beyond that rank.
    pub fixed_rank: Option<(f64, f64)>,
    /// Reference points at which the direction was annihilated.
    pub collapses: usize,
    /// Reference points whose neighbours do not determine it.
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

/// What [`super::data_spectrum`] finds.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSpectrum {
    /// The exponents, in the order the chain finds them: descending, but for differences within the error.
    pub exponents: Vec<DataExponent>,
    /// Number of tangent directions: so many exponents the series can tell.
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
    /// Reference points whose ball held fewer neighbours than asked for.
    pub starved: usize,
    /// Running means of the exponents, some 400 rows.
    pub convergence: Vec<Running>,
    /// The settings, with what was left to the estimator filled in.
    pub settings: DataSettings,
}
