//! Local maps with the curvature taken out: polynomials of second degree.
//!
//! A linear map fitted to a neighbourhood of radius r is off by what the quadratic terms of the
//! true map do to it, of the order of r where the neighbourhood is not symmetric, and on a curved
//! attractor far more: there a direction is wide by curvature alone. A fit `y' = A y + Q(u, u)`,
//! with u the coordinates of y along the widest directions, leaves an error of the order of r² and
//! takes the curvature of the attractor for what it is (Bryant, Brown and Abarbanel, Phys. Rev.
//! Lett. 65, 1523 (1990); Brown, Bryant and Abarbanel, Phys. Rev. A 43, 2787 (1991)).

use pulp::Arch;

use super::fit::{ABOVE_ROUNDING, LocalMap};
use super::matrix::{Matrix, Row};
use super::neighbours::Neighbour;
use super::series::MAX_COLUMNS;
use super::svd::{dot, reflect_below};

/// A direction that is not tangent is left out where less than this part of the widest is left of
/// it by the quadratic forms: what cubic terms do to such a small rest would pass for a derivative.
const THIN: f64 = 1e-3;
/// Most unknowns of one image's component: six columns, all their 21 forms and a constant. With
/// more columns the forms are of the widest directions only.
const MOST_UNKNOWNS: usize = 28;

/// A column of which less than this part is left by those before it is a combination of them: the
/// default of the rank tolerance.
const DEPENDENT: f64 = 1e-10;
/// Rows are filled up with zeros, which change no sum, so that no vector is broken.
const VECTOR: usize = 4;

/// Degree of local maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degree {
    /// Linear maps.
    Linear,
    /// Linear maps and quadratic forms of the widest directions beside them.
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

/// What is fitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polynomial {
    /// Directions that the quadratic forms are of.
    pub(crate) forms: usize,
    /// Directions that the attractor extends in.
    pub(crate) tangent: usize,
    /// A constant is fitted, too.
    pub(crate) affine: bool,
    /// `d` of Eq. (25).
    pub(crate) step: usize,
    /// Rounding of a coordinate.
    pub(crate) rounding: f64,
}

impl Polynomial {
    /// Unknowns for each component of the image, in `columns` columns.
    pub(crate) fn unknowns(&self, columns: usize) -> usize {
        columns + self.forms * (self.forms + 1) / 2 + usize::from(self.affine)
    }

    /// With forms of all directions, or of so many of the widest that the unknowns do not become
    /// too many.
    pub(crate) fn quadratic(self, columns: usize) -> Self {
        let of = |forms| Self { forms, ..self };
        let widest = (0..=columns)
            .rev()
            .find(|&forms| of(forms).unknowns(columns) <= MOST_UNKNOWNS);
        of(widest.unwrap_or(0).max(self.tangent))
    }
}

/// The linear part of a fitted polynomial. It is not determined in any direction if not in all
/// tangent ones.
#[derive(Clone, Debug)]
pub(crate) struct Derivative {
    pub(crate) map: LocalMap,
    /// Part of the neighbours' variance in each direction that is noise, by which a slope is too
    /// small, if the noise is the same in all columns: what the images leave unpredicted is theirs
    /// and, through the map, that of the points. NaN where there is nothing to tell it from.
    pub(crate) noise: Row,
}

/// Where the components of images come from: of delayed values, a delay ahead, all but the last are
/// values of the point itself, and only the last is to be fitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Images {
    /// The column that holds a component already.
    known: Vec<Option<usize>>,
    /// The components that are to be fitted.
    fitted: Vec<usize>,
}

impl Images {
    /// Of points whose images come `step` later. A component is known if its column is another one
    /// so much earlier, at all points.
    pub(crate) fn of(points: &Matrix, step: usize) -> Self {
        let columns = points.columns();
        let is_column = |component: usize, column: usize| {
            let mut pairs = points.rows().zip(points.rows().skip(step));
            column != component && pairs.all(|(a, b)| a[column] == b[component])
        };
        let known: Vec<Option<usize>> = (0..columns)
            .map(|component| (0..columns).find(|&column| is_column(component, column)))
            .collect();
        let fitted = (0..columns).filter(|&c| known[c].is_none()).collect();
        Self { known, fitted }
    }
}

/// Memory for a fit, used again for every point.
pub(crate) struct Fitter<'a> {
    points: &'a Matrix,
    images: &'a Images,
    /// Of the neighbours so far, row after row: constant, forms, coordinates along the directions,
    /// images. The linear ones come after the forms, so that the corner of the triangle that
    /// belongs to them holds what is theirs alone.
    triangle: Vec<f64>,
    /// Of the neighbours that are added, column after column.
    rows: Vec<f64>,
    /// Neighbours so far.
    count: usize,
    /// Sum of squares of what the polynomial leaves of their images.
    left: f64,
}

impl<'a> Fitter<'a> {
    pub(crate) fn new(points: &'a Matrix, images: &'a Images) -> Self {
        Self {
            points,
            images,
            triangle: Vec::new(),
            rows: Vec::new(),
            count: 0,
            left: 0.0,
        }
    }

    /// Fits the polynomial to the neighbours of point `j`; `directions` are those of the
    /// neighbourhood, the widest first.
    pub(crate) fn fit(
        &mut self,
        j: usize,
        neighbours: &[Neighbour],
        directions: &Matrix,
        polynomial: &Polynomial,
    ) -> Derivative {
        let unknowns = polynomial.unknowns(self.points.columns());
        let columns = unknowns + self.images.fitted.len();
        self.triangle.clear();
        self.triangle.resize(unknowns * columns, 0.0);
        (self.count, self.left) = (0, 0.0);
        self.extend(j, neighbours, directions, polynomial)
    }

    /// Fits it to further neighbours beside those of the last call, of which the triangle holds all
    /// that is needed.
    pub(crate) fn extend(
        &mut self,
        j: usize,
        further: &[Neighbour],
        directions: &Matrix,
        polynomial: &Polynomial,
    ) -> Derivative {
        self.count += further.len();
        if !further.is_empty() {
            // With the machine's vectors, which change no bit: the partial sums of [`dot`] are
            // lanes of one.
            self.left += Arch::new().dispatch(
                #[inline(always)]
                || self.absorb(j, further, directions, polynomial),
            );
        }
        self.derivative(directions, polynomial)
    }

    /// Writes the columns, each of `long` rows.
    #[inline(always)]
    fn fill(
        &mut self,
        j: usize,
        further: &[Neighbour],
        directions: &Matrix,
        polynomial: &Polynomial,
        long: usize,
    ) {
        let (forms, affine) = (polynomial.forms, polynomial.affine);
        let components = self.points.columns();
        let unknowns = polynomial.unknowns(components);
        // Differences to the point come last, for a while.
        let columns = unknowns + self.images.fitted.len();
        let cells = (columns + components) * long;
        if self.rows.len() < cells {
            self.rows.resize(cells, 0.0);
        }
        let (columns, differences) = self.rows[..cells].split_at_mut(columns * long);
        let (known, images) = columns.split_at_mut(unknowns * long);
        let (before, along) = known.split_at_mut((unknowns - components) * long);
        let count = further.len();
        let origin = &self.points[j];
        let image = &self.points[j + polynomial.step];
        for (row, &(_, k)) in further.iter().enumerate() {
            let point = &self.points[k as usize];
            for (c, (v, origin)) in point.iter().zip(origin).enumerate() {
                differences[c * long + row] = v - origin;
            }
            let ahead = &self.points[k as usize + polynomial.step];
            for (i, &c) in self.images.fitted.iter().enumerate() {
                images[i * long + row] = ahead[c] - image[c];
            }
        }
        let written = images.chunks_exact_mut(long);
        for column in written.chain(differences.chunks_exact_mut(long)) {
            column[count..].fill(0.0);
        }
        for (along, direction) in along.chunks_exact_mut(long).zip(directions.rows()) {
            along.fill(0.0);
            for (part, column) in direction.iter().zip(differences.chunks_exact(long)) {
                for (sum, difference) in along.iter_mut().zip(column) {
                    *sum += part * difference;
                }
            }
        }
        let mut columns = before.chunks_exact_mut(long);
        if affine && let Some(ones) = columns.next() {
            ones[..count].fill(1.0);
            ones[count..].fill(0.0);
        }
        let pairs = (0..forms).flat_map(|a| (a..forms).map(move |b| (a, b)));
        for (column, (a, b)) in columns.zip(pairs) {
            let factors = along[a * long..][..long].iter().zip(&along[b * long..]);
            for (product, (a, b)) in column.iter_mut().zip(factors) {
                *product = a * b;
            }
        }
    }

    /// Adds neighbours to the triangle, by reflections that take their rows to zero, and returns
    /// the sum of squares of what is left of their images. A column that depends on those before it
    /// gets a zero corner and is passed over.
    #[inline(always)]
    fn absorb(
        &mut self,
        j: usize,
        further: &[Neighbour],
        directions: &Matrix,
        polynomial: &Polynomial,
    ) -> f64 {
        let long = further.len().next_multiple_of(VECTOR);
        self.fill(j, further, directions, polynomial, long);
        let unknowns = polynomial.unknowns(self.points.columns());
        let columns = self.triangle.len() / unknowns;
        let rows = &mut self.rows[..columns * long];
        for i in 0..unknowns {
            let above: f64 = (0..i)
                .map(|row| self.triangle[row * columns + i])
                .map(|v| v * v)
                .sum();
            let row = &mut self.triangle[i * columns..][..columns];
            let (done, rest) = rows.split_at_mut((i + 1) * long);
            let mirror = &done[i * long..];
            let below = dot(mirror, mirror);
            let square = row[i] * row[i] + below;
            let norm = square.sqrt();
            if norm <= DEPENDENT * (above + square).sqrt() {
                row[i] = 0.0;
                continue;
            }
            let corner = if row[i] > 0.0 { -norm } else { norm };
            let first = row[i] - corner;
            row[i] = corner;
            reflect_below(
                mirror,
                (first, first * first + below),
                &mut row[i + 1..],
                rest,
            );
        }
        let images = &rows[unknowns * long..];
        dot(images, images)
    }

    /// The linear part by back substitution in the last rows of the triangle.
    fn derivative(&self, directions: &Matrix, polynomial: &Polynomial) -> Derivative {
        let components = self.points.columns();
        let (rows, unknowns) = (self.count, polynomial.unknowns(components));
        let mut derivative = Derivative {
            map: LocalMap {
                matrix: Matrix::zeros(components, components),
                rank: 0,
                nothing: 0.0,
            },
            noise: [f64::NAN; MAX_COLUMNS],
        };
        if rows < unknowns {
            return derivative;
        }
        let first = unknowns - components;
        let columns = self.triangle.len() / unknowns;
        let at = |column: usize, row: usize| self.triangle[(first + row) * columns + column];
        // What belongs to a component in a row: of a known one it is that of its column, along all
        // directions.
        let mut images = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        for (component, images) in images.iter_mut().enumerate().take(components) {
            if let Some(column) = self.images.known[component] {
                for (i, image) in images.iter_mut().enumerate().take(components) {
                    *image = (i..components)
                        .map(|k| at(first + k, i) * directions[k][column])
                        .sum();
                }
            }
        }
        for (fitted, &component) in self.images.fitted.iter().enumerate() {
            let images = images[component].iter_mut().take(components);
            for (i, image) in images.enumerate() {
                *image = at(unknowns + fitted, i);
            }
        }
        let rounding = ABOVE_ROUNDING * polynomial.rounding * (rows as f64).sqrt();
        let widest = at(first, 0).abs();
        let Derivative { map, noise } = &mut derivative;
        // `[component of the image][direction]`
        let mut slopes = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        let slopes = &mut slopes[..components];
        for i in (0..components).rev() {
            let corner = at(first + i, i);
            let tangent = i < polynomial.tangent;
            let thin = if tangent { 0.0 } else { THIN * widest };
            if corner.abs() <= rounding.max(thin) {
                if tangent {
                    map.rank = 0;
                    return derivative;
                }
                continue;
            }
            map.rank += 1;
            noise[i] = rows as f64 / (corner * corner);
            map.nothing = map.nothing.max(rounding / corner.abs());
            for (slopes, images) in slopes.iter_mut().zip(&images) {
                let others: f64 = (i + 1..components)
                    .map(|k| at(first + k, i) * slopes[k])
                    .sum();
                slopes[i] = (images[i] - others) / corner;
            }
        }
        let carried: f64 = slopes
            .iter()
            .map(|slopes| dot(&slopes[..components], &slopes[..components]))
            .sum();
        // Variance that the polynomial leaves of a component; NaN where there are no degrees of
        // freedom to tell from.
        let unpredicted = self.left / ((rows - unknowns) * components) as f64;
        let of_noise = unpredicted / (1.0 + carried / components as f64);
        noise.iter_mut().for_each(|part| *part *= of_noise);
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
    use crate::matrix::product;
    use crate::statistics::SplitMix;

    fn fitted(
        points: &[f64],
        columns: usize,
        j: &[Neighbour],
        polynomial: &Polynomial,
    ) -> Derivative {
        let points = Matrix::new(points.to_vec(), columns);
        let images = Images::of(&points, 1);
        let directions = Matrix::identity(columns);
        Fitter::new(&points, &images).fit(0, j, &directions, polynomial)
    }

    /// Any quadratic map is recovered to rounding, also where the neighbours lie on a curved
    /// surface, of which a linear fit would take the curvature for a third direction.
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
        let polynomial = Polynomial {
            forms: 3,
            tangent: 2,
            affine: false,
            step: 1,
            rounding: f64::EPSILON,
        };
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
        let linear = fit(&Polynomial {
            forms: 0,
            ..polynomial
        });
        assert_eq!(linear.map.rank, 3);
    }

    /// Points and images with noise of variance σ² beside a spread of s², turned and stretched a
    /// times: its slopes come out too small by f = σ²/(s² + σ²). What is left of a component of the
    /// images is σ² + a² s² f, which the fitted slope a (1 − f) passes for a noise of the points
    /// that is less by a part of the order of f.
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
            let linear = Polynomial {
                forms: 0,
                tangent: 2,
                affine: false,
                step: 1,
                rounding: f64::EPSILON,
            };
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
            let told = left / (1.0 + part * part) / 1.04;
            assert!(
                (found.noise[0] / told - 1.0).abs() < 0.03,
                "{stretch}: {:?} {told}",
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
        let polynomial = Polynomial {
            forms: 2,
            tangent: 2,
            affine: false,
            step: 1,
            rounding: f64::EPSILON,
        };
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
        let linear = Polynomial {
            forms: 0,
            tangent: 2,
            affine: false,
            step: 1,
            rounding: 0.0,
        };
        let forms = |columns| linear.quadratic(columns).forms;
        assert_eq!([2, 4, 6, 7, 8, 10].map(forms), [2, 4, 6, 6, 5, 5]);
        let thick = Polynomial {
            tangent: 8,
            ..linear
        };
        assert_eq!(thick.quadratic(10).forms, 8);
    }
}
