//! The estimate from neighbourhoods of two sizes, extrapolated to size zero.
//!
//! The bias of local polynomials of degree p falls as `r^(p + 1)` where neighbourhoods are
//! symmetric on average. It falls as `r²` for linear maps, and at least as `r²` for quadratic ones.
//! From the exponents λ₁ at radius r₁ and λ₂ at r₂ the one at zero is `λ₀ = λ₁ + w (λ₁ − λ₂)` with
//! `w = r₁²/(r₂² − r₁²)`. The same combination of the stretchings is formed at every point, so that
//! the scatter of its block means contains their correlation. The whole of `λ₀ − λ₂` is added as an
//! error: the power law holds for small r, and r need not be small.
//!
//! Linear maps show why. For one column of Hénon's map their second exponent is off by 0.09. It
//! hardly changes with the size, since they fit the folds badly at any size. Where linear maps are
//! requested and the points suffice, quadratic ones are fitted as well. The distance between the
//! two is added to the error.

use super::averages::{Average, average, running, volume};
use super::chain::{Chains, Stretch};
use super::cloud::Cloud;
use super::fit::LocalMap;
use super::least_squares::LeastSquares;
use super::matrix::{Matrix, Row};
use super::neighbours::POINTS_PER_NEIGHBOUR;
use super::polynomial::Polynomial;
use super::settings::DataSettings;
use super::settings::Degree;
use super::tree::Neighbour;
use numerics::upper_median;

/// Neighbours at the smaller size for each unknown. Chosen: fewer leave noise in the maps, and
/// more make neighbourhoods larger.
const NEIGHBOURS_PER_UNKNOWN: usize = 3;
/// One in this many points of a chain is discarded at its beginning: the vectors begin with the
/// directions of a neighbourhood and converge first. The loss widens errors by 3 %.
const POINTS_PER_SETTLING: usize = 20;

/// The sizes and the degree of the maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Degree of the maps.
    pub degree: Degree,
    /// Neighbours of the smaller and the larger size.
    pub neighbours: [usize; 2],
    /// Mean distance of the furthest of them, in the unit of the data.
    pub radius: [f64; 2],
}

/// A plan for sizes and maps.
pub(crate) struct Plan {
    degree: Degree,
    polynomial: Polynomial,
    pub(crate) neighbours: [usize; 2],
    /// The polynomial that linear maps are compared with, and its number of neighbours.
    judge: Option<(Polynomial, usize)>,
}

impl Plan {
    /// Chooses quadratic maps where the points suffice or they are requested, and linear ones
    /// elsewhere. Requested linear maps are compared with quadratic ones if the points suffice.
    pub(crate) fn new(
        cloud: &Cloud,
        settings: &DataSettings,
        degree: Option<Degree>,
        tangent: usize,
    ) -> Self {
        let columns = cloud.points.columns();
        let linear = Polynomial::linear(settings.affine, settings.step, tangent, cloud.rounding);
        let quadratic = linear.quadratic(columns);
        let fewest = settings.neighbours.fewest();
        let needed = fewest.max(NEIGHBOURS_PER_UNKNOWN * quadratic.terms.unknowns(columns));
        let are_enough = 2 * needed <= cloud.points.len() / POINTS_PER_NEIGHBOUR;
        let is_quadratic = match degree {
            Some(degree) => degree == Degree::Quadratic,
            None => are_enough,
        };
        let (degree, polynomial, neighbours) = if is_quadratic {
            (Degree::Quadratic, quadratic, needed)
        } else {
            (Degree::Linear, linear, fewest)
        };
        Self {
            degree,
            polynomial,
            neighbours: [neighbours, 2 * neighbours],
            judge: (!is_quadratic && are_enough).then_some((quadratic, needed)),
        }
    }

    /// Number of points of the largest neighbourhood.
    pub(crate) fn furthest(&self) -> usize {
        let judge = self.judge.map_or(0, |(_, neighbours)| neighbours);
        self.neighbours[1].max(judge)
    }

    /// The maps around point `j` from its nearest neighbours; `directions` are those of the
    /// neighbourhood, the widest first.
    pub(crate) fn maps(
        &self,
        fit: &mut LeastSquares<'_>,
        j: usize,
        nearest: &[Neighbour],
        directions: &Matrix,
    ) -> Maps {
        let first = |count: usize| &nearest[..nearest.len().min(count)];
        let [small, large] = self.neighbours.map(first);
        let distance = |inside: &[Neighbour]| inside.last().map_or(0.0, |last| last.0.sqrt());
        let terms = self.polynomial.terms;
        fit.fit(j, small, directions, terms);
        let at_small = self.polynomial.derivative(fit, directions);
        fit.extend(j, &large[small.len()..], directions, terms);
        let at_large = self.polynomial.derivative(fit, directions);
        Maps {
            radius: [small, large].map(distance),
            noise: at_small.noise,
            sizes: [at_small.map, at_large.map],
            judge: self.judge.map(|(polynomial, count)| {
                fit.fit(j, first(count), directions, polynomial.terms);
                polynomial.derivative(fit, directions).map
            }),
        }
    }
}

/// The maps around a point.
pub(crate) struct Maps {
    /// Maps of the smaller and the larger size.
    sizes: [LocalMap; 2],
    /// Radii of both, in the unit of the cloud.
    pub(crate) radius: [f64; 2],
    /// Part of the neighbours' variance in each direction that is noise, at the smaller size.
    noise: Row,
    judge: Option<LocalMap>,
}

/// The chains at both sizes, and that of the maps for comparison.
pub(crate) struct Extrapolation {
    plan: Plan,
    sizes: [Chains; 2],
    judged: Option<Chains>,
    /// Sum of the radii, in the unit of the cloud.
    radius: [f64; 2],
    /// Part of the neighbours' variance in each direction that is noise, at the smaller size.
    noises: Vec<Row>,
}

/// An exponent at size zero and what it is extrapolated from.
pub(crate) struct Extrapolated {
    /// Value at size zero, with its statistical error.
    pub(crate) zero: Average,
    /// Change from the smaller size to the larger.
    pub(crate) eps_sensitivity: f64,
    /// Changes from the larger size to zero, and from the maps that linear ones are compared with.
    /// 0 if there are none, NaN where they determine nothing.
    pub(crate) changes: [f64; 2],
    /// Fraction of the neighbours' variance in its direction that is noise. The slopes of the maps
    /// are too small by it.
    pub(crate) noise: f64,
}

impl Extrapolated {
    /// The exponent at size zero, with an error that contains the changes. A change that does not
    /// exist adds nothing; the status shows it.
    pub(crate) fn best(&self) -> Average {
        let [range, gap] = self.changes;
        let gap = gap.abs().max(0.0);
        let statistical = self.zero.stderr;
        Average {
            stderr: (statistical * statistical + range * range + gap * gap).sqrt(),
            ..self.zero
        }
    }
}

/// The results at size zero.
pub(crate) struct Corrected {
    pub(crate) sizes: Sizes,
    pub(crate) exponents: Vec<Extrapolated>,
    /// Sum of the exponents of the tangent directions, with its total error.
    pub(crate) sum: Average,
    /// Running means, with the number of reference points before each.
    pub(crate) running: Vec<(usize, Vec<f64>)>,
}

impl Extrapolation {
    /// Starts this many interleaved chains.
    pub(crate) fn new(plan: Plan, count: usize, columns: usize) -> Self {
        let chains = || Chains::new(count, columns);
        Self {
            sizes: [chains(), chains()],
            judged: plan.judge.map(|_| chains()),
            plan,
            radius: [0.0; 2],
            noises: Vec::new(),
        }
    }

    pub(crate) fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Applies the maps of the next reference point to the chains.
    pub(crate) fn push(&mut self, maps: &Maps, directions: &Matrix) {
        for (size, map) in maps.sizes.iter().enumerate() {
            self.radius[size] += maps.radius[size];
            self.sizes[size].push(map, directions);
        }
        if let (Some(judged), Some(map)) = (&mut self.judged, &maps.judge) {
            judged.push(map, directions);
        }
        self.noises.push(maps.noise);
    }

    /// The averages; `unit` is that of the cloud.
    pub(crate) fn corrected(&self, tau: f64, unit: f64) -> Corrected {
        let [small, large] = &self.sizes;
        let (count, columns) = (small.count, small.width);
        let settled = self.noises.len() / count / POINTS_PER_SETTLING * count;
        let at_zero = self.at_zero();
        let zero = &at_zero[settled..];
        let extrapolated = |noise: f64, of: &dyn Fn(&[Stretch]) -> Average| {
            let [small, large] = [small, large].map(|chains| of(&chains.stretches[settled..]).mean);
            let judged = self.judged.as_ref();
            let judged = judged.map(|chains| of(&chains.stretches[settled..]).mean);
            let zero = of(zero);
            Extrapolated {
                eps_sensitivity: large - small,
                changes: [large, judged.unwrap_or(zero.mean)].map(|other| zero.mean - other),
                zero,
                noise,
            }
        };
        let exponents = (0..columns).map(|i| {
            let noise = upper_median(self.noises.iter().map(|noise| noise[i]));
            extrapolated(noise, &|stretches| average(stretches, i, tau))
        });
        let tangent = self.plan.polynomial.tangent;
        let sum = extrapolated(0.0, &|stretches| volume(stretches, tangent, tau));
        let mut running = running(zero, columns, tau);
        running.iter_mut().for_each(|(count, _)| *count += settled);
        Corrected {
            sizes: Sizes {
                degree: self.plan.degree,
                neighbours: self.plan.neighbours,
                radius: self.radius().map(|radius| unit * radius),
            },
            exponents: exponents.collect(),
            sum: sum.best(),
            running,
        }
    }

    /// Mean radii, in the unit of the cloud.
    fn radius(&self) -> [f64; 2] {
        self.radius.map(|sum| sum / self.noises.len() as f64)
    }

    /// The stretchings at size zero.
    fn at_zero(&self) -> Vec<Stretch> {
        let [small, large] = self.radius();
        let rise = large * large - small * small;
        // Two neighbourhoods of the same radius, as for points in few places, allow no
        // extrapolation.
        let weight = if rise > 0.0 {
            small * small / rise
        } else {
            0.0
        };
        let [small, large] = &self.sizes;
        let pairs = small.stretches.iter().zip(&large.stretches);
        pairs
            .map(|(small, large)| {
                let mut zero = *small;
                zero.alive = small.alive.min(large.alive);
                zero.rank = small.rank.min(large.rank);
                for c in 0..zero.alive {
                    let change = small.factor[c] / large.factor[c];
                    zero.factor[c] = small.factor[c] * libm::pow(change, weight);
                }
                zero
            })
            .collect()
    }
}
