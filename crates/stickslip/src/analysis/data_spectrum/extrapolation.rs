//! The estimate from neighbourhoods of two sizes, extrapolated to size zero.
//!
//! What is left of the bias of local polynomials of degree p falls as `r^(p + 1)` where neighbourhoods are symmetric on average,
//! with p + 1 = 2 for linear maps, and as `r²` at least for quadratic ones. From the exponents λ₁ at radius r₁ and λ₂ at r₂ the one at
//! zero is `λ₀ = λ₁ + w (λ₁ − λ₂)` with `w = r₁²/(r₂² − r₁²)`. The same combination is made of the stretchings at every point, so that the
//! scatter of its block means holds the correlation of the two. All of `λ₀ − λ₂` is counted as an error besides: the power of r is
//! a law for small r, and nothing says that r is.

use rayon::prelude::*;

use super::averages::{Average, average, volume};
use super::chain::{Stretch, carry};
use super::cloud::Cloud;
use super::neighbours::{Finder, Neighbour};
use super::polynomial::{Degree, Derivative, Fitter, Polynomial};
use super::settings::DataSettings;
use super::svd::Square;
use crate::math;

/// Reference points whose maps are held at a time.
const CHUNK: usize = 2048;
/// Neighbours of the smaller size for each unknown.
const PER_UNKNOWN: usize = 3;
/// The larger size holds no more than this part of the points.
const LARGEST_PART: usize = 20;

/// The sizes and what is fitted at them.
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
pub(super) struct Plan {
    pub(super) degree: Degree,
    pub(super) polynomial: Polynomial,
    pub(super) neighbours: [usize; 2],
}

impl Plan {
    /// Quadratic maps where the points suffice or they are asked for, linear ones elsewhere.
    pub(super) fn new<const N: usize>(
        cloud: &Cloud<N>,
        settings: &DataSettings,
        degree: Option<Degree>,
        tangent: usize,
    ) -> Self {
        let linear = Polynomial {
            forms: 0,
            tangent,
            affine: settings.affine,
            step: settings.step,
            rounding: cloud.rounding,
        };
        let quadratic = linear.quadratic(N);
        let fewest = settings.neighbours.fewest();
        let needed = fewest.max(PER_UNKNOWN * quadratic.unknowns(N));
        let enough = 2 * needed <= cloud.points.len() / LARGEST_PART;
        match degree {
            Some(Degree::Quadratic) => Self::of(Degree::Quadratic, quadratic, needed),
            None if enough => Self::of(Degree::Quadratic, quadratic, needed),
            None | Some(Degree::Linear) => Self::of(Degree::Linear, linear, fewest),
        }
    }

    fn of(degree: Degree, polynomial: Polynomial, neighbours: usize) -> Self {
        Self {
            degree,
            polynomial,
            neighbours: [neighbours, 2 * neighbours],
        }
    }
}

/// What the chains at both sizes give.
pub(super) struct Chains<const N: usize> {
    stretches: [Vec<Stretch<N>>; 2],
    /// Mean radius, in the unit of the cloud.
    radius: [f64; 2],
    /// Tangent directions.
    dimension: usize,
}

/// Averages at both sizes and at size zero.
pub(super) struct Corrected<const N: usize> {
    pub(super) sizes: Sizes,
    pub(super) small: [Average; N],
    pub(super) large: [Average; N],
    /// With statistical errors.
    pub(super) zero: [Average; N],
    /// Sum of the exponents of the tangent directions, with its whole error.
    pub(super) sum: Average,
}

impl<const N: usize> Corrected<N> {
    /// The way from the larger size to zero.
    pub(super) fn range(&self, i: usize) -> f64 {
        self.zero[i].mean - self.large[i].mean
    }

    /// At size zero, with the whole error.
    pub(super) fn best(&self, i: usize) -> Average {
        with_range(self.zero[i], self.range(i))
    }
}

/// The error holds the range, too.
fn with_range(zero: Average, range: f64) -> Average {
    Average {
        stderr: (zero.stderr * zero.stderr + range * range).sqrt(),
        ..zero
    }
}

/// The reference points.
pub(super) struct References<'a, const N: usize> {
    pub(super) count: usize,
    /// Directions of the neighbourhood of each, the widest first.
    pub(super) directions: &'a (dyn Fn(usize) -> Square<N> + Sync),
    /// Called with the number of those that are done.
    pub(super) progress: &'a dyn Fn(usize),
}

/// Runs the chains at both sizes.
pub(super) fn run<const N: usize>(
    cloud: &Cloud<N>,
    finder: &Finder<'_, N>,
    plan: &Plan,
    settings: &DataSettings,
    reference: &References<'_, N>,
) -> Chains<N> {
    let (references, directions) = (reference.count, reference.directions);
    let chains = settings.step / settings.stride;
    let mut bases: [Vec<Square<N>>; 2] =
        [0, 1].map(|_| (0..chains.min(references)).map(directions).collect());
    let mut stretches = [0, 1].map(|_| Vec::with_capacity(references));
    let mut radius = [0.0; 2];
    let mut from = 0;
    while from < references {
        (reference.progress)(from);
        let until = (from + CHUNK).min(references);
        let maps: Vec<[(Derivative<N>, f64); 2]> = (from..until)
            .into_par_iter()
            .map_init(
                || (Fitter::default(), Vec::<Neighbour>::new()),
                |(fitter, found), i| {
                    let j = i * settings.stride;
                    finder.nearest(j, plan.neighbours[1], f64::INFINITY, found);
                    plan.neighbours.map(|count| {
                        let near = &found[..count.min(found.len())];
                        let distance = near.last().map_or(0.0, |far| far.0.sqrt());
                        let fitted =
                            fitter.fit(&cloud.points, j, near, &directions(i), &plan.polynomial);
                        (fitted, distance)
                    })
                },
            )
            .collect();
        for (i, maps) in (from..until).zip(maps) {
            for (size, (map, distance)) in maps.into_iter().enumerate() {
                radius[size] += distance;
                let basis = &mut bases[size][i % chains];
                let stretch = carry(&map.matrix, map.nothing, map.rank, basis, N);
                stretches[size].push(stretch);
            }
        }
        from = until;
    }
    Chains {
        stretches,
        dimension: plan.polynomial.tangent,
        radius: radius.map(|sum| sum / references as f64),
    }
}

impl<const N: usize> Chains<N> {
    /// The averages, and the running means at size zero; `unit` is that of the cloud.
    pub(super) fn corrected(
        &self,
        plan: &Plan,
        tau: f64,
        unit: f64,
    ) -> (Corrected<N>, Vec<(usize, [f64; N])>) {
        let [small, large] = &self.stretches;
        let stretches = self.at_zero();
        let (zero, running) = average(&stretches, tau);
        let sum = volume(&stretches, self.dimension, tau);
        let range = sum.mean - volume(large, self.dimension, tau).mean;
        let corrected = Corrected {
            sizes: Sizes {
                degree: plan.degree,
                neighbours: plan.neighbours,
                radius: self.radius.map(|radius| unit * radius),
            },
            small: average(small, tau).0,
            large: average(large, tau).0,
            zero,
            sum: with_range(sum, range),
        };
        (corrected, running)
    }

    /// The stretchings at size zero.
    fn at_zero(&self) -> Vec<Stretch<N>> {
        let [small, large] = self.radius;
        let rise = large * large - small * small;
        // Neighbourhoods of the same radius, as of points in few places, tell nothing of another.
        let weight = if rise > 0.0 {
            small * small / rise
        } else {
            0.0
        };
        let [small, large] = &self.stretches;
        let pairs = small.iter().zip(large);
        pairs
            .map(|(small, large)| {
                let mut zero = *small;
                zero.alive = small.alive.min(large.alive);
                zero.determined = small.determined.min(large.determined);
                for c in 0..zero.alive {
                    let change = small.factor[c] / large.factor[c];
                    zero.factor[c] = small.factor[c] * math::pow(change, weight);
                }
                zero
            })
            .collect()
    }
}
