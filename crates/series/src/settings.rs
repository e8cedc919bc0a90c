//! Settings with which a spectrum is estimated.

use super::error::DataError;
use super::least_squares::RANK_TOLERANCE;
use super::series::Series;

/// Degree of local maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degree {
    /// Linear maps.
    Linear,
    /// Linear maps plus quadratic forms of the widest directions.
    Quadratic,
}

impl Degree {
    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Degree::Linear => "linear",
            Degree::Quadratic => "quadratic",
        }
    }
}

/// Choice of the points that count as neighbours of a reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Neighbourhood {
    /// Points in a ball.
    Ball {
        /// Radius, as a fraction of the signal's spread `√Σ var`.
        eps: f64,
        /// Least number of points. If the ball holds fewer, this many nearest points are taken, and
        /// the reference point counts as starved. Where exponents are extrapolated it does if the
        /// smaller of the two neighbourhoods reaches farther than one and a half times the radius.
        min: usize,
        /// Largest number of points. If the ball holds more, only this many nearest ones are taken.
        max: usize,
    },
    /// Number of nearest points, at any distance.
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

/// Estimator that is applied to the local maps.
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

/// Fewest reference points of a block. Chosen: means of shorter blocks are correlated.
pub(crate) const SHORTEST_BLOCK: usize = 10;
/// Fewest reference points: two blocks of time, without which there is no standard error.
pub const FEWEST_REFERENCES: usize = 2 * SHORTEST_BLOCK;

/// Fewest reference points among delayed values, in a series that has as many. Chosen.
const DELAYED_REFERENCES: usize = 1500;
/// One in at most this many delayed vectors is a reference point.
const POINTS_PER_REFERENCE: usize = 3;
/// Neighbours of a vector of delayed values, in a series that is long enough. Chosen: each value
/// brings noise of its own, and a dozen are too few ([`DataSettings::delayed`]).
const DELAYED_NEIGHBOURS: usize = 40;
/// Points of the series for each neighbour of a delayed vector.
const POINTS_PER_DELAYED_NEIGHBOUR: usize = 100;
/// Fewest neighbours for each value of a vector.
const NEIGHBOURS_PER_VALUE: usize = 4;

/// Settings of [`super::data_spectrum`]. The defaults suit noise-free series of some ten thousand
/// points. A dozen neighbours keep the bias small, and the radius bounds what is local. Noisy
/// series need more neighbours.
///
/// The number of points in a ball can be estimated beforehand. Of n points on a surface of area S
/// it holds about n π (eps · spread)² / S. An example is the torus (cos a, sin a, cos b, sin b),
/// with spread √2 and area 4π². Of 45001 points there a ball of `eps` 0.02 holds 2.9. A dozen
/// neighbours need an `eps` of 0.04.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSettings {
    /// Estimator that is applied to the local maps.
    pub estimator: Estimator,
    /// Choice of the neighbours. An extrapolation comes from the nearest points,
    /// [`Neighbourhood::fewest`] or more of them.
    pub neighbours: Neighbourhood,
    /// Theiler window, in points: `k` is no neighbour of `j` if `|k − j|` is at most this. Points
    /// that follow one another are near for no other reason. `None` takes the time in which the
    /// autocorrelation of the series falls below 1/e.
    pub theiler: Option<usize>,
    /// `d` of Eq. (25): a map takes `x_j` to `x_{j+d}`.
    pub step: usize,
    /// Fits `y' = A y + b` instead of `y' = A y`.
    pub affine: bool,
    /// Singular values of the neighbour matrix below this fraction of the largest are zero.
    /// Contractions within one step below this fraction of the map's norm are annihilations.
    /// Rounding of the data is a second bound.
    pub rank_tolerance: f64,
    /// Tikhonov regularisation, as a fraction of the largest singular value: `s⁻¹` becomes `s/(s² +
    /// ridge² s_1²)`. 0 is none.
    pub ridge: f64,
    /// Rank of the second fit; `None` takes the number of tangent directions found.
    pub fixed_rank: Option<usize>,
    /// Reference points are 0, `stride`, 2·`stride`, … below `step`, and those one, two, … steps
    /// later. The image of a reference point is one again. With 1 all points are reference points.
    pub stride: usize,
    /// Uses only this many first reference points, at least [`FEWEST_REFERENCES`].
    pub references: Option<usize>,
    /// Estimates a second time from neighbourhoods of twice the size, to measure how the result
    /// depends on them. This doubles the time. Without it no `eps_sensitivity` is known and no
    /// exponent is called unstable. [`Estimator::Extrapolated`] has two sizes anyhow.
    pub sensitivity: bool,
}

/// Settings that are wanted as they are, also for delayed values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Given {
    /// [`DataSettings::neighbours`].
    pub neighbours: bool,
    /// [`DataSettings::step`].
    pub step: bool,
    /// [`DataSettings::stride`].
    pub stride: bool,
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
            rank_tolerance: RANK_TOLERANCE,
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
    /// [`DataSettings::delayed`], with these settings as they are.
    pub fn delayed_but(&self, delay: usize, vectors: &Series, given: Given) -> Self {
        let mut delayed = self.clone().delayed(delay, vectors);
        if given.neighbours {
            delayed.neighbours = self.neighbours;
        }
        if given.step {
            (delayed.step, delayed.stride) = (self.step, 1);
        }
        if given.stride {
            delayed.stride = self.stride;
        }
        delayed
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

    /// Number of reference points before point `end`.
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

    /// Adds the settings that the delayed values `embedded` need beyond those of states.
    /// * Maps are affine and over the `delay`: all but the last value of an image are known.
    /// * There are 40 neighbours, but at most a hundredth of the points and at least four for each
    ///   value. More that are set already stay; a ball takes as many and no more. Each value brings
    ///   noise of its own. With a dozen neighbours 2000 points of Lorenz' x have an exponent three
    ///   errors off that is called [`super::Status::Ok`].
    /// * A third of the points of a flow, and at least 1500, are reference points. Those in between
    ///   lie on the same orbit and have the same neighbours.
    ///
    /// Step, stride and affine maps are overwritten.
    pub fn delayed(mut self, delay: usize, embedded: &Series) -> Self {
        self.step = delay;
        let enough = DELAYED_REFERENCES.max(embedded.len() / POINTS_PER_REFERENCE);
        self.stride = longest_stride(delay, embedded.len(), enough);
        self.affine = true;
        let wanted = DELAYED_NEIGHBOURS
            .min(embedded.len() / POINTS_PER_DELAYED_NEIGHBOUR)
            .max(NEIGHBOURS_PER_VALUE * embedded.columns());
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
