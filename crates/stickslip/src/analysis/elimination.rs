//! Elimination of a sparse matrix by orthogonal reflections, group by group of its columns.
//!
//! A chain of segments has a matrix in which the rows of one segment meet the unknowns at its ends
//! only. Reflections then act on the rows of neighbouring segments, and their cost is linear in the
//! number of segments (Wright, *SIAM J. Sci. Stat. Comput.* 13 (1992) 742). No product of segments
//! is computed: with multipliers far apart, it would lose the small ones.
//!
//! In each group the rows are sorted by size, and the longest column comes first. So every row
//! keeps its own accuracy, however different their sizes are (Cox & Higham, *BIT* 38 (1998) 34).

mod determinant;

use crate::dynamics::{Matrix, Vector};

pub(super) use determinant::Determinant;

/// The entries of a row that are not zero: column and value.
pub(super) type SparseRow = Vec<(usize, f64)>;

/// The part of a front whose reflections eliminate one group of columns.
struct Stage {
    /// Rows that take part, the largest first. After the reflections, the first ones belong to the
    /// triangular factor.
    rows: Vec<usize>,
    /// The columns of the group, as they were eliminated, and others that these rows meet.
    columns: Vec<usize>,
    /// The vector of each reflection, and the factor 2/v².
    reflections: Vec<(Vec<f64>, f64)>,
    /// The rows of the triangular factor.
    factor: Matrix,
}

impl Stage {
    /// Number of columns that are eliminated.
    fn pivots(&self) -> usize {
        self.factor.nrows()
    }
}

/// A matrix as an orthogonal one times a triangular one.
pub(super) struct Elimination {
    size: usize,
    /// Length of each row, by which it was divided.
    lengths: Vec<f64>,
    /// Length of each column after that.
    column_lengths: Vec<f64>,
    stages: Vec<Stage>,
    /// Columns of the last group.
    last: Vec<usize>,
    /// Sign of the determinant of all but the triangular factor.
    sign: f64,
    /// Whether each group before the last has a row for each column.
    is_regular: bool,
}

impl Elimination {
    /// Eliminates a matrix with these rows. The columns of each group are eliminated together, in
    /// this order. There are at most as many rows as columns.
    pub fn of(rows: &[SparseRow], groups: &[Vec<usize>]) -> Self {
        let size = groups.iter().map(Vec::len).sum();
        let mut group_of = vec![0; size];
        let mut rank = vec![0; size];
        for (place, (group, &column)) in groups
            .iter()
            .enumerate()
            .flat_map(|(group, columns)| columns.iter().map(move |column| (group, column)))
            .enumerate()
        {
            (group_of[column], rank[column]) = (group, place);
        }
        let mut waiting: Vec<Vec<usize>> = vec![Vec::new(); groups.len()];
        let mut lengths = Vec::with_capacity(rows.len());
        for (number, row) in rows.iter().enumerate() {
            let first = row.iter().map(|&(column, _)| group_of[column]).min();
            waiting[first.unwrap_or(groups.len() - 1)].push(number);
            let square: f64 = row.iter().map(|(_, value)| value * value).sum();
            lengths.push(square.sqrt().max(f64::MIN_POSITIVE));
        }
        let mut column_lengths = vec![0.0; size];
        for (row, length) in rows.iter().zip(&lengths) {
            for &(column, value) in row {
                column_lengths[column] += (value / length) * (value / length);
            }
        }
        for length in &mut column_lengths {
            *length = length.sqrt();
        }
        let mut found = Elimination {
            size,
            lengths,
            column_lengths,
            stages: Vec::with_capacity(groups.len()),
            last: groups.last().cloned().unwrap_or_default(),
            sign: 1.0,
            is_regular: true,
        };
        let mut carried = Front::default();
        for (number, (group, waiting)) in groups.iter().zip(&waiting).enumerate() {
            let new = waiting.iter().map(|&row| (row, &rows[row]));
            let front = carried.with(new, &found.lengths, (group, &rank));
            let (stage, rest, count) = front.eliminated(group.len());
            let is_last = number + 1 == groups.len();
            found.is_regular &= is_last || stage.pivots() == group.len();
            if count % 2 == 1 {
                found.sign = -found.sign;
            }
            found.stages.push(stage);
            carried = rest;
        }
        let rows = found.stages.iter().flat_map(Stage::own_rows);
        let columns = found.stages.iter().flat_map(Stage::own_columns);
        found.sign *= parity(rows.collect()) * parity(columns.collect());
        let diagonals = found.stages.iter().flat_map(Stage::diagonal);
        let negative = diagonals.filter(|entry| *entry < 0.0).count();
        if negative % 2 == 1 {
            found.sign = -found.sign;
        }
        found
    }

    /// Whether there is a row for each column.
    fn is_square(&self) -> bool {
        let whole = self
            .stages
            .last()
            .is_some_and(|stage| stage.pivots() == self.last.len());
        self.is_regular && whole
    }

    /// The determinant.
    pub fn determinant(&self) -> Determinant {
        if !self.is_square() {
            return Determinant::ZERO;
        }
        let entries = self.stages.iter().flat_map(Stage::diagonal);
        let sizes = entries.map(f64::abs).zip(&self.lengths);
        let one = Determinant::of(self.sign);
        sizes.fold(one, |product, (entry, length)| {
            product.times(entry * length)
        })
    }

    /// Whether a column depends on others to within rounding. Of columns that depend exactly,
    /// reflections leave rounding instead of zero.
    fn is_singular(&self) -> bool {
        let rounding = self.size as f64 * f64::EPSILON;
        let mut stages = self.stages.iter();
        stages.any(|stage| {
            let mut own = stage.own_columns().zip(stage.diagonal());
            own.any(|(column, entry)| entry.abs() <= rounding * self.column_lengths[column])
        })
    }

    /// The solution; `None` where the matrix is singular to within rounding.
    pub fn solve(&self, right: &Vector) -> Option<Vector> {
        let has_one = self.is_square() && !self.is_singular();
        has_one.then(|| self.solved(right, 0.0))
    }

    /// The solution where no entry of the triangular factor's diagonal counts as smaller than the
    /// rounding of its row, which has length 1; `None` where there are too few rows.
    pub fn solve_regularised(&self, right: &Vector) -> Option<Vector> {
        self.is_square().then(|| self.solved(right, f64::EPSILON))
    }

    /// The solution of the equations with the transposed matrix, likewise.
    pub fn solve_transposed_regularised(&self, right: &Vector) -> Option<Vector> {
        if !self.is_square() {
            return None;
        }
        let mut left = right.clone();
        let mut image = Vector::zeros(self.size);
        for stage in &self.stages {
            for k in 0..stage.pivots() {
                let value = left[stage.columns[k]] / beyond(stage.factor[(k, k)], f64::EPSILON);
                image[stage.rows[k]] = value;
                for (j, &column) in stage.columns.iter().enumerate().skip(k + 1) {
                    left[column] -= stage.factor[(k, j)] * value;
                }
            }
        }
        for stage in self.stages.iter().rev() {
            for reflection in stage.reflections.iter().enumerate().rev() {
                stage.reflect(reflection, &mut image);
            }
        }
        for (value, length) in image.iter_mut().zip(&self.lengths) {
            *value /= length;
        }
        Some(image)
    }

    /// One vector for each column of the last group: 1 there, and 0 at the others of the group. Its
    /// other components make the residual of the equations least. `None` where there are too few
    /// equations.
    pub fn fundamental(&self) -> Option<Vec<Vector>> {
        let solution = |&free: &usize| {
            let mut x = Vector::zeros(self.size);
            x[free] = 1.0;
            let none = Vector::zeros(self.lengths.len());
            let before = self.stages.len().saturating_sub(1);
            self.substitute((&none, &mut x), &self.stages[..before], f64::EPSILON);
            x
        };
        self.is_regular
            .then(|| self.last.iter().map(solution).collect())
    }

    fn solved(&self, right: &Vector, least: f64) -> Vector {
        let mut image = right.clone();
        for (value, length) in image.iter_mut().zip(&self.lengths) {
            *value /= length;
        }
        for stage in &self.stages {
            for reflection in stage.reflections.iter().enumerate() {
                stage.reflect(reflection, &mut image);
            }
        }
        let mut x = Vector::zeros(self.size);
        self.substitute((&image, &mut x), &self.stages, least);
        x
    }

    /// Back substitution through some stages.
    fn substitute(&self, (image, x): (&Vector, &mut Vector), stages: &[Stage], least: f64) {
        for stage in stages.iter().rev() {
            for k in (0..stage.pivots()).rev() {
                let mut value = image[stage.rows[k]];
                for (j, &column) in stage.columns.iter().enumerate().skip(k + 1) {
                    value -= stage.factor[(k, j)] * x[column];
                }
                x[stage.columns[k]] = value / beyond(stage.factor[(k, k)], least);
            }
        }
    }
}

/// A value or, where it is smaller than a bound, that with its sign.
fn beyond(value: f64, least: f64) -> f64 {
    if value.abs() >= least {
        value
    } else {
        least.copysign(value)
    }
}

impl Stage {
    fn own_rows(&self) -> impl Iterator<Item = usize> {
        self.rows[..self.pivots()].iter().copied()
    }

    fn own_columns(&self) -> impl Iterator<Item = usize> {
        self.columns[..self.pivots()].iter().copied()
    }

    fn diagonal(&self) -> impl Iterator<Item = f64> {
        (0..self.pivots()).map(|k| self.factor[(k, k)])
    }

    /// Applies a reflection to the components of its rows.
    fn reflect(&self, (number, (vector, factor)): (usize, &(Vec<f64>, f64)), image: &mut Vector) {
        let rows = &self.rows[number..];
        let part: f64 = rows
            .iter()
            .zip(vector)
            .map(|(&row, v)| v * image[row])
            .sum();
        for (&row, v) in rows.iter().zip(vector) {
            image[row] -= factor * part * v;
        }
    }
}

/// Rows whose first columns come next, as a dense matrix of all columns that they meet.
#[derive(Default)]
struct Front {
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// One row after the other.
    entries: Vec<f64>,
}

impl Front {
    /// Adds further rows. The columns of a group come first, then the others by their rank.
    fn with<'r>(
        self,
        new: impl Iterator<Item = (usize, &'r SparseRow)> + Clone,
        lengths: &[f64],
        (group, rank): (&[usize], &[usize]),
    ) -> Self {
        let met = new
            .clone()
            .flat_map(|(_, row)| row.iter().map(|&(column, _)| column));
        let mut columns: Vec<usize> = group
            .iter()
            .chain(&self.columns)
            .copied()
            .chain(met)
            .collect();
        columns.sort_unstable_by_key(|&column| rank[column]);
        columns.dedup();
        let width = columns.len();
        let place = |column: usize| {
            let found = columns.binary_search_by_key(&rank[column], |&other| rank[other]);
            found.unwrap_or_else(|next| next)
        };
        let size = |entries: &[f64]| entries.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let mut all: Vec<(f64, usize, Vec<f64>)> = Vec::new();
        let places: Vec<usize> = self.columns.iter().map(|&column| place(column)).collect();
        for (k, &row) in self.rows.iter().enumerate() {
            let mut entries = vec![0.0; width];
            let own = &self.entries[k * places.len()..(k + 1) * places.len()];
            for (&place, value) in places.iter().zip(own) {
                entries[place] = *value;
            }
            all.push((size(&entries), row, entries));
        }
        for (number, row) in new {
            let mut entries = vec![0.0; width];
            for &(column, value) in row {
                entries[place(column)] += value / lengths[number];
            }
            all.push((size(&entries), number, entries));
        }
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        Front {
            rows: all.iter().map(|(_, row, _)| *row).collect(),
            entries: all
                .into_iter()
                .flat_map(|(_, _, entries)| entries)
                .collect(),
            columns,
        }
    }

    /// Eliminates the first columns, as many as there are rows for. The number of reflections is
    /// returned, too.
    fn eliminated(mut self, columns: usize) -> (Stage, Front, usize) {
        let (count, width) = (self.rows.len(), self.columns.len());
        let pivots = columns.min(count);
        let mut reflections = Vec::with_capacity(pivots);
        let mut number = 0;
        let entries = &mut self.entries;
        for k in 0..pivots {
            let square = |entries: &[f64], j: usize| -> f64 {
                (k..count)
                    .map(|i| entries[i * width + j] * entries[i * width + j])
                    .sum()
            };
            let mut longest = (k, square(entries, k));
            for j in k + 1..columns {
                let other = square(entries, j);
                if other > longest.1 {
                    longest = (j, other);
                }
            }
            let (j, square) = longest;
            if j != k {
                self.columns.swap(j, k);
                for i in 0..count {
                    entries.swap(i * width + j, i * width + k);
                }
            }
            let length = square.sqrt();
            if length == 0.0 || k + 1 == count {
                reflections.push((Vec::new(), 0.0));
                continue;
            }
            let mut vector: Vec<f64> = (k..count).map(|i| entries[i * width + k]).collect();
            let first = vector[0];
            vector[0] += length.copysign(first);
            let factor = (length * (length + first.abs())).recip();
            entries[k * width + k] = -length.copysign(first);
            for i in k + 1..count {
                entries[i * width + k] = 0.0;
            }
            for j in k + 1..width {
                let terms = vector.iter().enumerate();
                let part: f64 = terms.map(|(i, v)| v * entries[(k + i) * width + j]).sum();
                for (i, v) in vector.iter().enumerate() {
                    entries[(k + i) * width + j] -= factor * part * v;
                }
            }
            reflections.push((vector, factor));
            number += 1;
        }
        let factor = Matrix::from_fn(pivots, width, |i, j| self.entries[i * width + j]);
        let rest = pivots * width;
        let left = self.entries[rest..].chunks_exact(width.max(1));
        let carried = Front {
            rows: self.rows[pivots..].to_vec(),
            columns: self.columns[columns..].to_vec(),
            entries: left
                .flat_map(|row| row[columns..].iter().copied())
                .collect(),
        };
        let stage = Stage {
            rows: self.rows,
            columns: self.columns,
            reflections,
            factor,
        };
        (stage, carried, number)
    }
}

/// The sign of a permutation.
fn parity(mut places: Vec<usize>) -> f64 {
    let (count, mut sign) = (places.len(), 1.0);
    for k in 0..count {
        while places[k] != k && places[k] < count {
            let home = places[k];
            places.swap(k, home);
            sign = -sign;
        }
    }
    sign
}

/// Singular values of a matrix with few columns, rising, with their right singular vectors; by
/// rotations of pairs of columns (Jacobi; Demmel & Veselić, *SIAM J. Matrix Anal. Appl.* 13 (1992)
/// 1204).
pub(super) fn singular(columns: &[Vector]) -> Vec<(f64, Vector)> {
    // Largest cosine between columns that count as orthogonal, and number of rounds: five or six
    // suffice.
    const ORTHOGONAL: f64 = 4.0 * f64::EPSILON;
    const MOST_ROUNDS: usize = 30;
    let count = columns.len();
    let mut images = columns.to_vec();
    let mut vectors: Vec<Vector> = (0..count)
        .map(|k| Vector::from_fn(count, |i, _| f64::from(u8::from(i == k))))
        .collect();
    for _ in 0..MOST_ROUNDS {
        let mut is_done = true;
        for one in 0..count {
            for other in one + 1..count {
                let (a, b) = (images[one].norm_squared(), images[other].norm_squared());
                let both = images[one].dot(&images[other]);
                if both == 0.0 || both.abs() <= ORTHOGONAL * (a * b).sqrt() {
                    continue;
                }
                is_done = false;
                let ratio = (b - a) / (2.0 * both);
                let tangent = ratio.signum() / (ratio.abs() + (1.0 + ratio * ratio).sqrt());
                let cosine = (1.0 + tangent * tangent).sqrt().recip();
                let sine = cosine * tangent;
                for all in [&mut images, &mut vectors] {
                    let first = &all[one] * cosine - &all[other] * sine;
                    all[other] = &all[one] * sine + &all[other] * cosine;
                    all[one] = first;
                }
            }
        }
        if is_done {
            break;
        }
    }
    let mut found: Vec<(f64, Vector)> = images.iter().map(Vector::norm).zip(vectors).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

/// An orthonormal basis of the span of some vectors, by Gram and Schmidt, each time twice.
pub(super) fn orthonormal(vectors: &[Vector]) -> Vec<Vector> {
    let mut basis: Vec<Vector> = Vec::with_capacity(vectors.len());
    for vector in vectors {
        let mut next = vector / vector.norm();
        for _ in 0..2 {
            for one in &basis {
                next.axpy(-one.dot(&next), one, 1.0);
            }
            next.normalize_mut();
        }
        basis.push(next);
    }
    basis
}

#[cfg(test)]
mod tests;
