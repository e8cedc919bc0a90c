//! Functions of an orbit's multipliers that vanish at a branch point, fold, flip or Neimark–Sacker
//! bifurcation.

use nalgebra::Complex;

use super::multipliers::eigenvalues;
use crate::dynamics::Matrix;

/// The functions at one orbit.
#[derive(Clone, Debug)]
pub(super) struct Critical {
    /// Zero where a nontrivial multiplier is 1: the determinant of Newton's matrix at a given
    /// parameter.
    pub one: f64,
    /// Zero where a multiplier is −1.
    pub minus_one: f64,
    /// Zero where a pair is on the unit circle; `None` where there is no pair.
    pub circle: Option<f64>,
    /// Angle of that pair.
    pub angle: f64,
    /// The multipliers without the trivial one of an autonomous system.
    pub multipliers: Vec<Complex<f64>>,
    /// The multipliers that are not those of a family.
    pub others: Vec<Complex<f64>>,
}

impl Critical {
    /// Multipliers of the derivative of the flow map over the period, transverse to the flow in an
    /// autonomous system. An orbit in a family of some dimension always has as many multipliers
    /// equal to 1, and they are ignored.
    pub fn of(matrix: &Matrix, family: usize) -> Self {
        let states = matrix.nrows();
        let shifted = |by: f64| matrix + Matrix::identity(states, states) * by;
        let one = if family > 0 {
            0.0
        } else {
            shifted(-1.0).determinant()
        };
        let mut multipliers = eigenvalues(matrix);
        multipliers.sort_by(|a, b| b.norm_sqr().total_cmp(&a.norm_sqr()));
        let without_nearest = |mut values: Vec<Complex<f64>>| {
            let off = |k: usize| (values[k] - 1.0).norm_sqr();
            let nearest = (0..values.len()).min_by(|a, b| off(*a).total_cmp(&off(*b)));
            nearest.map(|k| values.remove(k));
            values
        };
        let others = (0..family).fold(multipliers.clone(), |others, _| without_nearest(others));
        let pairs = others.iter().filter(|value| value.im > 0.0);
        let nearest = pairs.min_by(|a, b| {
            let off = |value: &Complex<f64>| (value.norm_sqr() - 1.0).abs();
            off(a).total_cmp(&off(b))
        });
        Critical {
            one,
            minus_one: shifted(1.0).determinant(),
            circle: nearest.map(|value| value.norm_sqr() - 1.0),
            angle: nearest.map_or(0.0, |value| crate::math::atan2(value.im, value.re)),
            multipliers,
            others,
        }
    }
}

/// Two multipliers with a product near 1: a pair of complex ones near the unit circle, or two real
/// ones, into which such a pair turns where it meets at 1 or −1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// The product, less 1.
    pub beyond: f64,
    pub sum: f64,
}

impl Pair {
    /// The pair whose sum and product are nearest to a given sum and to 1.
    pub fn near(of: &Critical, sum: f64) -> Option<Self> {
        let all = of.multipliers.iter().enumerate();
        let pairs = all.flat_map(|(k, one)| {
            let others = of.multipliers[k + 1..].iter();
            // Two real ones, or one with its conjugate.
            let pairs = others.filter(|other| (one.im == 0.0) == (other.im == 0.0));
            pairs.map(move |other| (one * other, one + other))
        });
        let pairs = pairs.filter(|(product, sum)| product.im == 0.0 && sum.im == 0.0);
        let pairs = pairs.map(|(product, sum)| Pair {
            beyond: product.re - 1.0,
            sum: sum.re,
        });
        let off = |pair: &Pair| pair.beyond.abs() + (pair.sum - sum).abs();
        pairs.min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

/// Distance of two iterates at which [`zero_between`] ends, relative to the place or absolute.
pub(super) const RESOLVED_PLACE: f64 = 1e-13;

/// The zero between two points of opposite sign, by regula falsi with the Illinois rule. At a
/// branch point no orbit can be computed; the function is then evaluated next to it.
pub(super) fn zero_between(
    (mut a, mut at_a): (f64, f64),
    (mut b, mut at_b): (f64, f64),
    mut function: impl FnMut(f64) -> Option<f64>,
) -> Option<f64> {
    const MOST_STEPS: usize = 60;
    // Fraction of the interval by which a point is moved where the function has no value.
    const SIDE_STEP: f64 = 1e-10;
    // A value at a moved point is zero up to this fraction of those at the ends.
    const SIDE_STEP_VALUE: f64 = 1e-6;
    let (width, size) = (b - a, at_a.abs().min(at_b.abs()));
    for _ in 0..MOST_STEPS {
        let zero = b - at_b * (b - a) / (at_b - at_a);
        if (zero - b).abs() <= RESOLVED_PLACE * (1.0 + b.abs()) {
            return Some(zero);
        }
        let mut points = [0.0, SIDE_STEP, -SIDE_STEP]
            .map(|part| zero + part * width)
            .into_iter();
        let (next, value) = points.find_map(|point| Some((point, function(point)?)))?;
        if value == 0.0 || next != zero && value.abs() <= SIDE_STEP_VALUE * size {
            return Some(next);
        }
        if value * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        (b, at_b) = (next, value);
    }
    Some(b)
}
