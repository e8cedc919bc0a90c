//! The estimate from neighbourhoods of two sizes, extrapolated to size zero.
//!
//! What is left of the bias of local polynomials of degree p falls as `r^(p + 1)` where
//! neighbourhoods are symmetric on average, with p + 1 = 2 for linear maps, and as `r²` at least
//! for quadratic ones. From the exponents λ₁ at radius r₁ and λ₂ at r₂ the one at zero is
//! `λ₀ = λ₁ + w (λ₁ − λ₂)` with `w = r₁²/(r₂² − r₁²)`. The same combination is made of the
//! stretchings at every point, so that the scatter of its block means holds the correlation of the
//! two. All of `λ₀ − λ₂` is counted as an error besides: the power of r is a law for small r, and
//! nothing says that r is.
//!
//! Linear maps that were asked for show why: of one column of Hénon's map their second exponent is
//! 0.09 off and hardly moves with the size, for what fits the folds badly does so at any size.
//! Quadratic maps are fitted beside them where the points suffice, and the distance between the two
//! is counted as an error, too.

use super::averages::{Average, averages, running, volume};
use super::chain::{Chains, Stretch};
use super::cloud::Cloud;
use super::fit::LocalMap;
use super::matrix::{Matrix, Row};
use super::neighbours::{LARGEST_PART, Neighbour};
use super::polynomial::{Degree, Fitter, Polynomial};
use super::settings::DataSettings;
use super::statistics::upper_median;

/// Neighbours of the smaller size for each unknown.
const PER_UNKNOWN: usize = 3;
/// This part of a chain is left out: its vectors begin with the directions of a neighbourhood and
/// have to turn to those that they keep.
const SETTLING: usize = 20;

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
pub(crate) struct Plan {
    pub(crate) degree: Degree,
    pub(crate) polynomial: Polynomial,
    pub(crate) neighbours: [usize; 2],
    /// What linear maps are held against, and its neighbours.
    pub(crate) judge: Option<(Polynomial, usize)>,
}

impl Plan {
    /// Quadratic maps where the points suffice or they are asked for, linear ones elsewhere. Where
    /// linear ones are asked for and the points suffice for quadratic ones, these judge them.
    pub(crate) fn new(
        cloud: &Cloud,
        settings: &DataSettings,
        degree: Option<Degree>,
        tangent: usize,
    ) -> Self {
        let columns = cloud.points.columns();
        let linear = Polynomial {
            forms: 0,
            tangent,
            affine: settings.affine,
            step: settings.step,
            rounding: cloud.rounding,
        };
        let quadratic = linear.quadratic(columns);
        let fewest = settings.neighbours.fewest();
        let needed = fewest.max(PER_UNKNOWN * quadratic.unknowns(columns));
        let enough = 2 * needed <= cloud.points.len() / LARGEST_PART;
        let of = |degree, polynomial, neighbours, judge| Self {
            degree,
            polynomial,
            neighbours: [neighbours, 2 * neighbours],
            judge,
        };
        match degree {
            Some(Degree::Quadratic) => of(Degree::Quadratic, quadratic, needed, None),
            None if enough => of(Degree::Quadratic, quadratic, needed, None),
            None | Some(Degree::Linear) => {
                let judge = enough.then_some((quadratic, needed));
                of(Degree::Linear, linear, fewest, judge)
            }
        }
    }

    /// Neighbours of the largest neighbourhood.
    pub(crate) fn furthest(&self) -> usize {
        let judge = self.judge.map_or(0, |(_, neighbours)| neighbours);
        self.neighbours[1].max(judge)
    }

    /// The maps around point `j` from its nearest neighbours; `directions` are those of the
    /// neighbourhood, the widest first.
    pub(crate) fn fit(
        &self,
        fitter: &mut Fitter<'_>,
        j: usize,
        found: &[Neighbour],
        directions: &Matrix,
    ) -> Maps {
        let (near, further) = found.split_at(self.neighbours[0].min(found.len()));
        let further = &further[..further.len().min(self.neighbours[1] - self.neighbours[0])];
        let distance = |near: &[Neighbour]| near.last().map(|far| far.0.sqrt());
        let radius = distance(near).unwrap_or(0.0);
        let small = fitter.fit(j, near, directions, &self.polynomial);
        let large = fitter.extend(j, further, directions, &self.polynomial);
        Maps {
            radius: [radius, distance(further).unwrap_or(radius)],
            noise: small.noise,
            sizes: [small.map, large.map],
            judge: self.judge.as_ref().map(|(polynomial, count)| {
                let near = &found[..found.len().min(*count)];
                fitter.fit(j, near, directions, polynomial).map
            }),
        }
    }
}

/// The maps around a point.
pub(crate) struct Maps {
    /// Of the smaller and the larger size.
    sizes: [LocalMap; 2],
    /// Radii of both, in the unit of the cloud.
    pub(crate) radius: [f64; 2],
    /// Part of the neighbours' variance in each direction that is noise, at the smaller size.
    noise: Row,
    judge: Option<LocalMap>,
}

/// The chains at both sizes, and that of the maps that judge.
pub(crate) struct Extrapolation {
    sizes: [Chains; 2],
    /// Without maps that judge nothing is pushed.
    judged: Chains,
    /// Interleaved chains of each of them.
    count: usize,
    /// Sum of the radii, in the unit of the cloud.
    radius: [f64; 2],
    /// Part of the neighbours' variance in each direction that is noise, at the smaller size.
    noises: Vec<Row>,
    columns: usize,
}

/// Averages at both sizes and at size zero.
pub(crate) struct Corrected {
    pub(crate) sizes: Sizes,
    pub(crate) small: Vec<Average>,
    pub(crate) large: Vec<Average>,
    /// With statistical errors.
    pub(crate) zero: Vec<Average>,
    /// Part of the neighbours' variance in each direction that is noise, by which the maps are
    /// flattened.
    pub(crate) noise: Vec<f64>,
    /// Reference points that the averages are over.
    pub(crate) counted: usize,
    /// By the maps that judge linear ones.
    pub(crate) judged: Option<Vec<Average>>,
    /// Sum of the exponents of the tangent directions, with its whole error.
    pub(crate) sum: Average,
    /// Running means at size zero, with the number of reference points before each.
    pub(crate) running: Vec<(usize, Vec<f64>)>,
}

impl Corrected {
    /// The way from the larger size to zero.
    pub(crate) fn range(&self, i: usize) -> f64 {
        self.zero[i].mean - self.large[i].mean
    }

    /// From the maps that judge linear ones to size zero; 0 if there are none, NaN where they
    /// determine nothing.
    pub(crate) fn gap(&self, i: usize) -> f64 {
        gap(&self.zero[i], self.judged.as_ref().map(|judged| &judged[i]))
    }

    /// At size zero, with the whole error.
    pub(crate) fn best(&self, i: usize) -> Average {
        with_bias(self.zero[i], self.range(i), self.gap(i))
    }
}

fn gap(zero: &Average, judged: Option<&Average>) -> f64 {
    judged.map_or(0.0, |judged| zero.mean - judged.mean)
}

/// The error holds the range and the gap, too. A gap to nothing adds nothing; the status tells.
fn with_bias(zero: Average, range: f64, gap: f64) -> Average {
    let gap = gap.abs().max(0.0);
    Average {
        stderr: (zero.stderr * zero.stderr + range * range + gap * gap).sqrt(),
        ..zero
    }
}

impl Extrapolation {
    /// So many interleaved chains, of which nothing is known yet.
    pub(crate) fn new(count: usize, columns: usize) -> Self {
        let chains = || Chains::new(count, columns);
        Self {
            sizes: [chains(), chains()],
            judged: chains(),
            count,
            radius: [0.0; 2],
            noises: Vec::new(),
            columns,
        }
    }

    /// Takes the chains through the maps of the next reference point.
    pub(crate) fn push(&mut self, maps: Maps, directions: &Matrix) {
        for (size, map) in maps.sizes.iter().enumerate() {
            self.radius[size] += maps.radius[size];
            self.sizes[size].push(map, directions);
        }
        if let Some(map) = &maps.judge {
            self.judged.push(map, directions);
        }
        self.noises.push(maps.noise);
    }

    /// The averages; `unit` is that of the cloud.
    pub(crate) fn corrected(&self, plan: &Plan, tau: f64, unit: f64) -> Corrected {
        let dimension = plan.polynomial.tangent;
        let settled = self.noises.len() / self.count / SETTLING * self.count;
        let stretches = self.at_zero();
        let stretches = &stretches[settled..];
        let [small, large] = [0, 1].map(|size| &self.sizes[size].stretches[settled..]);
        let columns = self.columns;
        let mut running = running(stretches, columns, tau);
        running.iter_mut().for_each(|(count, _)| *count += settled);
        let sum = volume(stretches, dimension, tau);
        let range = sum.mean - volume(large, dimension, tau).mean;
        let judged = self.judged.stretches.get(settled..);
        let judged = judged.filter(|judged| !judged.is_empty());
        let judged_sum = judged.map(|judged| volume(judged, dimension, tau));
        Corrected {
            sizes: Sizes {
                degree: plan.degree,
                neighbours: plan.neighbours,
                radius: self.radius().map(|radius| unit * radius),
            },
            small: averages(small, columns, tau),
            large: averages(large, columns, tau),
            zero: averages(stretches, columns, tau),
            noise: (0..columns)
                .map(|i| upper_median(self.noises.iter().map(|noise| noise[i])))
                .collect(),
            counted: stretches.len(),
            judged: judged.map(|judged| averages(judged, columns, tau)),
            sum: with_bias(sum, range, gap(&sum, judged_sum.as_ref())),
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
        // Neighbourhoods of the same radius, as of points in few places, tell nothing of another.
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
                zero.determined = small.determined.min(large.determined);
                for c in 0..zero.alive {
                    let change = small.factor[c] / large.factor[c];
                    zero.factor[c] = small.factor[c] * libm::pow(change, weight);
                }
                zero
            })
            .collect()
    }
}
