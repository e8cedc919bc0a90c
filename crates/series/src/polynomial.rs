//! Local polynomial maps of second degree, which account for curvature.
//!
//! A linear map fitted to a neighbourhood of radius r has an error from the quadratic terms of the
//! true map. The error is of order r where the neighbourhood is not symmetric. It is far larger on
//! a curved attractor, where a direction may be wide by curvature alone. A quadratic fit is `y' = A
//! y + Q(u, u)`, with u the coordinates of y along the widest directions. It leaves an error of
//! order r² and represents the curvature of the attractor.
//!
//! Bryant, Brown and Abarbanel, Phys. Rev. Lett. 65, 1523 (1990); Brown, Bryant and Abarbanel,
//! Phys. Rev. A 43, 2787 (1991).

use super::fit::LocalMap;
use super::least_squares::{LeastSquares, Terms};
use super::matrix::{Matrix, Row, product};
use super::series::MAX_COLUMNS;

/// A direction that is not tangent is omitted if the quadratic forms leave at most this fraction of
/// the widest. Cubic terms in so small a remainder would pass for a derivative. Chosen: of the
/// order of the cube of a radius of a tenth.
const OMITTED_WIDTH: f64 = 1e-3;
/// Largest number of unknowns per component of the image: six columns, all their 21 forms and a
/// constant. With more columns there are forms of the widest directions only. It bounds the time.
const MOST_UNKNOWNS: usize = 28;

/// A polynomial map, and which of its directions must be determined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polynomial {
    pub(crate) terms: Terms,
    /// Number of tangent directions of the attractor.
    pub(crate) tangent: usize,
    /// Rounding of a coordinate, as [`super::cloud::Cloud::rounding`].
    pub(crate) rounding: f64,
}

/// The linear part of a fitted polynomial. It counts as undetermined unless it is determined in all
/// tangent directions.
#[derive(Clone, Debug)]
pub(crate) struct Derivative {
    pub(crate) map: LocalMap,
    /// Fraction of the neighbours' variance in each direction that is noise, assumed equal in all
    /// columns. A slope is too small by this fraction. The unpredicted part of the images is taken
    /// as their own noise plus, through the map, that of the points. NaN without degrees of
    /// freedom.
    pub(crate) noise: Row,
}

impl Polynomial {
    /// A linear map.
    pub(crate) fn linear(affine: bool, step: usize, tangent: usize, rounding: f64) -> Self {
        Self {
            terms: Terms {
                forms: 0,
                affine,
                step,
            },
            tangent,
            rounding,
        }
    }

    /// Adds forms of all directions, or of as many of the widest as the limit of unknowns allows.
    pub(crate) fn quadratic(mut self, columns: usize) -> Self {
        let unknowns = |forms| {
            Terms {
                forms,
                ..self.terms
            }
            .unknowns(columns)
        };
        let are_few = |forms: &usize| unknowns(*forms) <= MOST_UNKNOWNS;
        let widest = (0..=columns).rev().find(are_few);
        self.terms.forms = widest.unwrap_or(0).max(self.tangent);
        self
    }

    /// The linear part of the fit of these terms, by back substitution. The coordinates are along
    /// `directions`.
    pub(crate) fn derivative(&self, fit: &LeastSquares<'_>, directions: &Matrix) -> Derivative {
        let components = directions.columns();
        let (rows, unknowns) = (fit.count, self.terms.unknowns(components));
        let mut derivative = Derivative {
            map: LocalMap {
                matrix: Matrix::zeros(components, components),
                rank: 0,
                negligible: 0.0,
            },
            noise: [f64::NAN; MAX_COLUMNS],
        };
        if rows < unknowns {
            return derivative;
        }
        let (triangle, images) = fit.linear_part(directions);
        let rounding = self.rounding * (rows as f64).sqrt();
        let widest = triangle[0][0].abs();
        let Derivative { map, noise } = &mut derivative;
        // `[component of the image][direction]`
        let mut slopes = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        let slopes = &mut slopes[..components];
        for i in (0..components).rev() {
            let corner = triangle[i][i];
            let tangent = i < self.tangent;
            let thin = if tangent { 0.0 } else { OMITTED_WIDTH * widest };
            if corner.abs() <= rounding.max(thin) {
                if tangent {
                    map.rank = 0;
                    return derivative;
                }
                continue;
            }
            map.rank += 1;
            noise[i] = rows as f64 / (corner * corner);
            map.negligible = map.negligible.max(rounding / corner.abs());
            for (slopes, image) in slopes.iter_mut().zip(&images[i]) {
                let others: f64 = (i + 1..components)
                    .map(|k| triangle[i][k] * slopes[k])
                    .sum();
                slopes[i] = (image - others) / corner;
            }
        }
        let carried: f64 = slopes.iter().map(|slopes| product(slopes, slopes)).sum();
        // Residual variance of a component; NaN without degrees of freedom.
        let unpredicted = fit.residual / ((rows - unknowns) * components) as f64;
        let noise_variance = unpredicted / (1.0 + carried / components as f64);
        noise.iter_mut().for_each(|part| *part *= noise_variance);
        for (row, slopes) in map.matrix.rows_mut().zip(&*slopes) {
            for (slope, direction) in slopes.iter().zip(directions.rows()) {
                for (cell, d) in row.iter_mut().zip(direction) {
                    *cell += slope * d;
                }
            }
        }
        derivative
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::least_squares::ShiftedColumns;
    use crate::tree::Neighbour;
    use numerics::SplitMix;

    /// A polynomial with two tangent directions and quadratic forms of the given number of
    /// directions.
    fn with_forms(forms: usize) -> Polynomial {
        let mut polynomial = Polynomial::linear(false, 1, 2, f64::EPSILON);
        polynomial.terms.forms = forms;
        polynomial
    }

    fn fitted(
        points: &[f64],
        columns: usize,
        j: &[Neighbour],
        polynomial: &Polynomial,
    ) -> Derivative {
        let points = Matrix::new(points.to_vec(), columns);
        let shifted = ShiftedColumns::of(&points, 1);
        let mut fit = LeastSquares::new(&points, &shifted);
        let axes = Matrix::identity(columns);
        fit.fit(0, j, &axes, polynomial.terms);
        polynomial.derivative(&fit, &axes)
    }

    /// Any quadratic map is recovered to rounding, also if the neighbours lie on a curved surface.
    /// A linear fit would take the curvature for a third direction.
    #[test]
    fn a_quadratic_map_is_recovered_from_points_on_a_curved_surface() {
        let map = |[x, y, z]: [f64; 3]| {
            [
                0.4 * x - 1.1 * y + 0.2 * z + 0.7 * x * x - 0.3 * x * y,
                0.9 * x + 0.1 * y - 0.5 * z + 0.2 * y * y,
                -0.6 * x + 0.8 * y + 0.1 * z + 0.5 * x * x + 0.4 * y * y,
            ]
        };
        let mut points = vec![[0.0; 3], map([0.0; 3])];
        let mut neighbours = Vec::new();
        for i in 0..24_u32 {
            let (a, b) = (f64::from(i % 5) - 1.8, f64::from(i / 5) - 2.3);
            let (x, y) = (0.01 * a, 0.01 * b);
            let point = [x, y, 3.0 * x * x - 2.0 * x * y];
            neighbours.push((product(&point, &point), points.len() as u32));
            points.extend([point, map(point)]);
        }
        let polynomial = with_forms(3);
        let fit = |polynomial: &Polynomial| fitted(&points.concat(), 3, &neighbours, polynomial);
        let found = fit(&polynomial);
        assert_eq!(found.map.rank, 2);
        let wanted = [[0.4, -1.1], [0.9, 0.1], [-0.6, 0.8]];
        for (row, wanted) in found.map.matrix.rows().zip(wanted) {
            for (cell, wanted) in row.iter().zip(wanted) {
                assert!((cell - wanted).abs() < 1e-11, "{cell} {wanted}");
            }
            assert_eq!(row[2], 0.0);
        }
        let linear = fit(&with_forms(0));
        assert_eq!(linear.map.rank, 3);
    }

    /// The map turns and stretches a times. Points of variance s² and images have noise of variance
    /// σ². The slopes are too small by f = σ²/(s² + σ²). A component of the images has a residual
    /// of σ² + a² s² f. From it and the slope a (1 − f), the noise of the points is estimated too
    /// small by a relative error of order f.
    #[test]
    fn what_is_unpredicted_shows_by_how_much_noise_flattens_a_map() {
        const COUNT: u32 = 20_000;
        for stretch in [0.1, 1.0, 4.0] {
            let mut random = SplitMix::new(3);
            // Variances 1 and 1/25; sums of twelve are nearly normal.
            let mut normal = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
            let mut points = vec![[0.0; 2]; 2];
            let mut neighbours = Vec::new();
            for _ in 0..COUNT {
                let [x, y] = [normal(), normal()];
                let pair = [[x, y], [stretch * y, -stretch * x]];
                neighbours.push((1.0, points.len() as u32));
                points.extend(pair.map(|[a, b]| [a + 0.2 * normal(), b + 0.2 * normal()]));
            }
            let linear = with_forms(0);
            let found = fitted(&points.concat(), 2, &neighbours, &linear);
            let slope = 0.5 * (found.map.matrix[0][1] - found.map.matrix[1][0]);
            let flattened = 1.0 - slope / stretch;
            let wanted = 0.04 / 1.04;
            let scatter = 4e-3 * (1.0 + 0.1 / stretch);
            assert!(
                (flattened - wanted).abs() < 4.0 * scatter,
                "{stretch}: {flattened}"
            );
            let part = (1.0 - wanted) * stretch;
            let left = 0.04 + stretch * stretch * wanted;
            let expected = left / (1.0 + part * part) / 1.04;
            assert!(
                (found.noise[0] / expected - 1.0).abs() < 0.03,
                "{stretch}: {:?} {expected}",
                found.noise
            );
            assert!(
                (found.noise[0] / wanted - 1.0).abs() < 0.1,
                "{stretch}: {:?} {wanted}",
                found.noise
            );
        }
    }

    #[test]
    fn too_few_neighbours_and_a_missing_tangent_direction_determine_nothing() {
        let polynomial = with_forms(2);
        // All on a straight line.
        let points: Vec<[f64; 2]> = (0..40).map(|i| [0.1 * f64::from(i), 0.0]).collect();
        let neighbours: Vec<Neighbour> = (1..30).map(|k| (0.01 * f64::from(k * k), k)).collect();
        let rank = |neighbours: &[Neighbour]| {
            fitted(&points.concat(), 2, neighbours, &polynomial)
                .map
                .rank
        };
        assert_eq!(rank(&neighbours), 0);
        assert_eq!(rank(&neighbours[..4]), 0);
    }

    #[test]
    fn with_many_columns_the_forms_are_of_the_widest_directions() {
        let linear = with_forms(0);
        let forms = |columns| linear.quadratic(columns).terms.forms;
        assert_eq!([2, 4, 6, 7, 8, 10].map(forms), [2, 4, 6, 6, 5, 5]);
        let thick = Polynomial {
            tangent: 8,
            ..linear
        };
        assert_eq!(thick.quadratic(10).terms.forms, 8);
    }
}
