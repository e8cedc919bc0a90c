//! How a spectrum is estimated.

use super::error::DataError;
use super::polynomial::Degree;
use super::series::Series;

/// Which points count as neighbours of a reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Neighbourhood {
    /// Those in a ball.
    Ball {
        /// Radius, as a fraction of the signal's spread `√Σ var`.
        eps: f64,
        /// With fewer points than this in the ball, this many nearest points are taken, and the
        /// reference point counts as starved. Where exponents are extrapolated it does if the
        /// smaller of the two neighbourhoods reaches farther than one and a half times the radius.
        min: usize,
        /// With more points than this in the ball, only this many nearest points are taken.
        max: usize,
    },
    /// This many nearest points, at any distance.
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

    /// Most neighbours that are taken.
    pub(crate) fn most(&self) -> usize {
        match *self {
            Neighbourhood::Ball { max, .. } => max,
            Neighbourhood::Nearest(k) => k,
        }
    }
}

/// What is made of the local maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// Sano and Sawada's: linear maps of one neighbourhood, Eqs. (25) and (26) of the paper as they
    /// stand. Its error is statistical only.
    SanoSawada,
    /// Maps from neighbourhoods of two sizes, extrapolated to size zero. The error includes that of
    /// the extrapolation.
    Extrapolated {
        /// Degree of the maps; `None` takes quadratic ones where the series is long enough.
        degree: Option<Degree>,
    },
}

impl Estimator {
    /// Words for tables.
    pub fn words(self) -> &'static str {
        match self {
            Estimator::SanoSawada => "Sano-Sawada",
            Estimator::Extrapolated { .. } => "extrapolated",
        }
    }
}

/// Fewest reference points: fewer do not form two blocks of time, so that there is no standard
/// error.
pub const FEWEST_REFERENCES: usize = 20;

/// Reference points among delayed values that are enough,
const REFERENCES: usize = 1500;
/// and this part of the points.
const REFERENCES_PART: usize = 3;
/// Neighbours of a vector of delayed values, where there are points enough;
const DELAYED_NEIGHBOURS: usize = 40;
/// not more than this part of the points,
const PART: usize = 100;
/// nor fewer than so many for each value.
const FOR_EACH_VALUE: usize = 4;

/// Settings of [`super::data_spectrum`]. The defaults suit noise-free series of some ten thousand
/// points: the nearest dozen, which keeps the bias small, and a radius beyond which a neighbourhood
/// is not local. Noisy series need more neighbours.
///
/// How many points a ball holds can be estimated beforehand: of n points on a surface of area S it
/// holds about n π (eps · spread)² / S. For 45001 points on the torus (cos a, sin a, cos b, sin b)
/// with its spread √2 and its area 4π² and `eps` 0.02 these are 2.9: such a series needs an `eps`
/// of 0.04 for a dozen.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSettings {
    /// What is made of the local maps.
    pub estimator: Estimator,
    /// Which points are neighbours. What is extrapolated comes from the nearest points,
    /// [`Neighbourhood::fewest`] or more of them.
    pub neighbours: Neighbourhood,
    /// Theiler window, in points: `k` is no neighbour of `j` where `|k − j|` is not above it, since
    /// points that follow one another are near for no other reason. `None` takes the time in which
    /// the autocorrelation of the series falls below 1/e.
    pub theiler: Option<usize>,
    /// `d` of Eq. (25): a map takes `x_j` to `x_{j+d}`.
    pub step: usize,
    /// Fits `y' = A y + b` instead of `y' = A y`.
    pub affine: bool,
    /// Singular values of the neighbour matrix below this fraction of the largest are taken for
    /// zero, and contractions within one step below this fraction of the map's norm for
    /// annihilation. Rounding of the data is a second bound.
    pub rank_tolerance: f64,
    /// Tikhonov regularisation, as a fraction of the largest singular value: `s⁻¹` becomes `s/(s² +
    /// ridge² s_1²)`. 0 is none.
    pub ridge: f64,
    /// Rank of the second fit; `None` takes the number of tangent directions found.
    pub fixed_rank: Option<usize>,
    /// Reference points are 0, `stride`, 2·`stride`, … below `step`, and those one step later, two
    /// steps, …, so that the point a reference point moves to is one again: as many interleaved
    /// chains as there are below `step`. With 1 all points are reference points.
    pub stride: usize,
    /// Uses only this many first reference points, at least [`FEWEST_REFERENCES`].
    pub references: Option<usize>,
    /// Estimates a second time from neighbourhoods of twice the size, to measure how the result
    /// depends on them. This doubles the time. Without it no `eps_sensitivity` is known and no
    /// exponent is called unstable. [`Estimator::Extrapolated`] has two sizes anyhow.
    pub sensitivity: bool,
}

impl Default for DataSettings {
    fn default() -> Self {
        Self {
            estimator: Estimator::Extrapolated { degree: None },
            neighbours: Neighbourhood::Ball {
                eps: 0.1,
                min: 12,
                max: 12,
            },
            theiler: None,
            step: 1,
            affine: false,
            rank_tolerance: 1e-10,
            ridge: 0.0,
            fixed_rank: None,
            stride: 1,
            references: None,
            sensitivity: true,
        }
    }
}

/// The stride with the fewest chains that still have this many reference points among the rows, or
/// 1.
pub(crate) fn longest_stride(step: usize, rows: usize, references: usize) -> usize {
    let with_image = rows.saturating_sub(step).max(1);
    match references.saturating_mul(step).div_ceil(with_image) {
        0 | 1 => step.max(1),
        // With a longer one there are fewer chains.
        chains => (step.div_ceil(chains - 1) - 1).max(1),
    }
}

impl DataSettings {
    /// Interleaved chains of reference points.
    pub(crate) fn chains(&self) -> usize {
        self.step.div_ceil(self.stride)
    }

    /// Reference point `i`.
    pub(crate) fn reference(&self, i: usize) -> usize {
        let chains = self.chains();
        (i / chains)
            .saturating_mul(self.step)
            .saturating_add(i % chains * self.stride)
    }

    /// How many reference points there are before point `end`.
    pub(crate) fn references_before(&self, end: usize) -> usize {
        end / self.step * self.chains() + (end % self.step).div_ceil(self.stride)
    }
}

impl DataSettings {
    /// The estimator of the paper, Eqs. (25) and (26), without correction of bias; all else is the
    /// default.
    pub fn sano_sawada() -> Self {
        Self {
            estimator: Estimator::SanoSawada,
            ..Self::default()
        }
    }

    /// For the delayed values `embedded`, what they need beyond states: maps over the `delay`, of
    /// which all but the last value are known, affine ones, and more neighbours, since each value
    /// brings the noise of its own: with a dozen 2000 points of Lorenz' x have an exponent three
    /// errors off that is called [`super::Status::Ok`]. They are 40, but not more than a hundredth
    /// of the points, and four for each value at least, or those set already where these are more;
    /// a ball takes so many and no more.
    ///
    /// Not every point of a flow is a reference point, but every so many that a third of them is
    /// left, and 1500, or more: those in between lie on the same orbit and have the same
    /// neighbours. Step, stride and affine maps are overwritten.
    pub fn delayed(mut self, delay: usize, embedded: &Series) -> Self {
        self.step = delay;
        let enough = REFERENCES.max(embedded.len() / REFERENCES_PART);
        self.stride = longest_stride(delay, embedded.len(), enough);
        self.affine = true;
        let wanted = DELAYED_NEIGHBOURS
            .min(embedded.len() / PART)
            .max(FOR_EACH_VALUE * embedded.columns());
        match &mut self.neighbours {
            Neighbourhood::Ball { min, max, .. } => {
                *min = wanted.max(*min);
                *max = *min;
            }
            Neighbourhood::Nearest(k) => *k = wanted.max(*k),
        }
        self
    }

    /// The fewest states that an estimate with this Theiler window takes.
    pub(crate) fn fewest_points(&self, theiler: usize) -> usize {
        let neighbours = self.neighbours.fewest();
        let searched = [theiler.saturating_mul(2), 1, self.step];
        let searched = searched.into_iter().fold(neighbours, usize::saturating_add);
        let references = self.reference(FEWEST_REFERENCES - 1);
        searched.max(references.saturating_add(1).saturating_add(self.step))
    }

    /// # Errors
    /// [`DataError::Setting`] with the first setting that is not allowed.
    pub(crate) fn check(&self, columns: usize) -> Result<(), DataError> {
        let refuse = |name, value, bound: String| Err(DataError::Setting { name, value, bound });
        // With as many neighbours as unknowns the fit is exact, and there are no residuals to judge
        // it by.
        let unknowns = columns + usize::from(self.affine);
        let bound = if self.affine {
            format!("above the number of columns plus one for the affine fit, {unknowns}")
        } else {
            format!("above the number of columns, {unknowns}")
        };
        match self.neighbours {
            Neighbourhood::Ball { eps, min, max } => {
                if !(eps > 0.0 && eps.is_finite()) {
                    let bound = "finite and > 0, a fraction of the spread";
                    return refuse("eps", eps, bound.into());
                }
                if min <= unknowns {
                    return refuse("min", min as f64, bound);
                }
                if max < min {
                    return refuse("max", max as f64, format!("at least the minimum, {min}"));
                }
            }
            Neighbourhood::Nearest(k) if k <= unknowns => {
                return refuse("neighbours", k as f64, bound);
            }
            Neighbourhood::Nearest(_) => {}
        }
        if self.step == 0 {
            return refuse("step", 0.0, "at least 1".into());
        }
        if !(1..=self.step).contains(&self.stride) {
            let bound = format!("1 to the step, {}", self.step);
            return refuse("stride", self.stride as f64, bound);
        }
        if !(0.0..1.0).contains(&self.rank_tolerance) {
            return refuse("rank_tolerance", self.rank_tolerance, "in [0, 1)".into());
        }
        if !(self.ridge >= 0.0 && self.ridge.is_finite()) {
            return refuse("ridge", self.ridge, "finite and >= 0".into());
        }
        if let Some(rank) = self.fixed_rank
            && !(1..=columns).contains(&rank)
        {
            let bound = format!("1 to the number of columns, {columns}");
            return refuse("fixed_rank", rank as f64, bound);
        }
        if let Some(references) = self.references
            && references < FEWEST_REFERENCES
        {
            let bound = format!("at least {FEWEST_REFERENCES}, as fewer give no standard error");
            return refuse("references", references as f64, bound);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stride_leaves_enough_points_in_chains_that_lie_evenly() {
        for (step, rows, wanted) in (1..40).flat_map(|step| {
            let rows = [100, 2000, 5000, 20_000];
            rows.into_iter()
                .flat_map(move |rows| [20, 1000, 1500].map(|wanted| (step, rows, wanted)))
        }) {
            let of = |stride| {
                let settings = DataSettings {
                    step,
                    stride,
                    ..DataSettings::default()
                };
                settings.references_before(rows - step)
            };
            let stride = longest_stride(step, rows, wanted);
            // In the last, incomplete step some chains lack a point.
            assert!(
                of(stride) + step > wanted.min(rows - step),
                "{step} {rows} {wanted}"
            );
            assert!(
                stride == step || of(stride + 1) < wanted + step,
                "{step} {rows} {wanted}"
            );
        }
        assert_eq!(longest_stride(13, 5000, 1500), 4);
        assert_eq!(longest_stride(12, 50_000, 1000), 12);
        assert_eq!(longest_stride(1, 50_000, 1000), 1);
        assert_eq!(longest_stride(12, 500, 1000), 1);
        assert_eq!(longest_stride(12, 5, 1000), 1);
    }

    #[test]
    fn a_step_takes_reference_points_to_reference_points() {
        for (step, stride, wanted) in [
            (4, 2, [0, 2, 4, 6, 8, 10]),
            (5, 2, [0, 2, 4, 5, 7, 9]),
            (7, 7, [0, 7, 14, 21, 28, 35]),
            (1, 1, [0, 1, 2, 3, 4, 5]),
        ] {
            let settings = DataSettings {
                step,
                stride,
                ..DataSettings::default()
            };
            let found: Vec<usize> = (0..6).map(|i| settings.reference(i)).collect();
            assert_eq!(found, wanted);
            for (i, j) in wanted.into_iter().enumerate() {
                assert_eq!(settings.references_before(j), i);
                assert_eq!(settings.references_before(j + 1), i + 1);
            }
        }
    }
}
