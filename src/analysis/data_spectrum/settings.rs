//! How a spectrum is estimated.

use super::error::DataError;

/// Which points count as neighbours of a reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Neighbourhood {
    /// Those in a ball.
    Ball {
        /// Radius, as a fraction of the signal's spread `√Σ var`.
        eps: f64,
        /// With fewer than so many in the ball the reference point counts as starved, and the nearest so many are taken.
        min: usize,
        /// With more than so many in the ball the nearest so many are taken.
        max: usize,
    },
    /// The nearest so many, however far.
    Nearest(usize),
}

impl Neighbourhood {
    /// Fewest neighbours that are taken.
    pub fn fewest(&self) -> usize {
        match *self {
            Neighbourhood::Ball { min, .. } => min,
            Neighbourhood::Nearest(k) => k,
        }
    }
}

/// Settings of [`super::data_spectrum`]. The defaults suit noise-free series of some ten thousand points;
/// noise wants more neighbours and a larger radius.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSettings {
    /// Which points are neighbours.
    pub neighbours: Neighbourhood,
    /// Theiler window, in points: `k` is no neighbour of `j` where `|k − j|` is not above it, since points that follow
    /// one another are near for no other reason. `None` takes the time in which the autocorrelation of the series falls below
    /// 1/e.
    pub theiler: Option<usize>,
    /// `d` of Eq. (25): a map takes `x_j` to `x_{j+d}`.
    pub step: usize,
    /// Fits `y' = A y + b` instead of `y' = A y`.
    pub affine: bool,
    /// Singular values of the neighbour matrix below this fraction of the largest are taken for zero, and contractions
    /// within one step below this fraction of the map's norm for annihilation. Rounding of the data is a second bound.
    pub rank_tolerance: f64,
    /// Tikhonov regularisation, as a fraction of the largest singular value: `s⁻¹` becomes `s/(s² + ridge² s_1²)`. 0 is none.
    pub ridge: f64,
    /// Rank of the second fit; `None` takes the number of tangent directions found.
    pub fixed_rank: Option<usize>,
    /// Reference points are 0, `stride`, 2·`stride`, … It must divide `step`, so that the point a reference point moves to
    /// is one again; with 1 all points are reference points, chained in `step` interleaved chains.
    pub stride: usize,
    /// Uses only the first so many reference points.
    pub references: Option<usize>,
}

impl Default for DataSettings {
    fn default() -> Self {
        Self {
            neighbours: Neighbourhood::Ball {
                eps: 0.02,
                min: 12,
                max: 40,
            },
            theiler: None,
            step: 1,
            affine: false,
            rank_tolerance: 1e-10,
            ridge: 0.0,
            fixed_rank: None,
            stride: 1,
            references: None,
        }
    }
}

impl DataSettings {
    /// # Errors
    /// [`DataError::Setting`] with the first setting that is not allowed.
    pub(super) fn check(&self, columns: usize) -> Result<(), DataError> {
        let refuse = |name, value, bound| Err(DataError::Setting { name, value, bound });
        match self.neighbours {
            Neighbourhood::Ball { eps, min, max } => {
                if !(eps > 0.0 && eps.is_finite()) {
                    return refuse("eps", eps, "finite and > 0, a fraction of the spread");
                }
                if min <= columns {
                    return refuse("min", min as f64, "above the number of columns");
                }
                if max < min {
                    return refuse("max", max as f64, "at least min");
                }
            }
            Neighbourhood::Nearest(k) if k <= columns => {
                return refuse("neighbours", k as f64, "above the number of columns");
            }
            Neighbourhood::Nearest(_) => {}
        }
        if self.step == 0 {
            return refuse("step", 0.0, "at least 1");
        }
        if self.stride == 0 || !self.step.is_multiple_of(self.stride) {
            return refuse("stride", self.stride as f64, "a divisor of the step");
        }
        if !(0.0..1.0).contains(&self.rank_tolerance) {
            return refuse("rank_tolerance", self.rank_tolerance, "in [0, 1)");
        }
        if !(self.ridge >= 0.0 && self.ridge.is_finite()) {
            return refuse("ridge", self.ridge, "finite and >= 0");
        }
        if let Some(rank) = self.fixed_rank
            && !(1..=columns).contains(&rank)
        {
            return refuse("fixed_rank", rank as f64, "1 to the number of columns");
        }
        if self.references == Some(0) {
            return refuse("references", 0.0, "at least 1");
        }
        Ok(())
    }
}
