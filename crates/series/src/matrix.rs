//! Rows of equal length, which is known at run time only.

use std::ops::{Index, IndexMut};

use super::series::MAX_COLUMNS;

/// One number per column, padded with zeros, so that no allocation per point is needed.
pub(crate) type Row = [f64; MAX_COLUMNS];

/// A matrix, `[row][column]`; each point is a row.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Matrix {
    columns: usize,
    cells: Vec<f64>,
}

impl Matrix {
    /// The matrix of these cells, row after row.
    pub(crate) fn new(cells: Vec<f64>, columns: usize) -> Self {
        Self { columns, cells }
    }

    pub(crate) fn zeros(rows: usize, columns: usize) -> Self {
        Self::new(vec![0.0; rows * columns], columns)
    }

    /// A matrix of orthonormal directions.
    #[cfg(test)]
    pub(crate) fn identity(columns: usize) -> Self {
        let mut identity = Self::zeros(columns, columns);
        (0..columns).for_each(|i| identity[i][i] = 1.0);
        identity
    }

    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.cells.len() / self.columns
    }

    pub(crate) fn rows(&self) -> std::slice::ChunksExact<'_, f64> {
        self.cells.chunks_exact(self.columns)
    }

    pub(crate) fn rows_mut(&mut self) -> std::slice::ChunksExactMut<'_, f64> {
        self.cells.chunks_exact_mut(self.columns)
    }

    /// The first rows, this many.
    pub(crate) fn first(&self, rows: usize) -> std::slice::ChunksExact<'_, f64> {
        self.cells[..rows * self.columns].chunks_exact(self.columns)
    }

    pub(crate) fn cells(&self) -> &[f64] {
        &self.cells
    }
}

impl Index<usize> for Matrix {
    type Output = [f64];

    #[inline(always)]
    fn index(&self, row: usize) -> &[f64] {
        &self.cells[row * self.columns..][..self.columns]
    }
}

impl IndexMut<usize> for Matrix {
    #[inline(always)]
    fn index_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.cells[row * self.columns..][..self.columns]
    }
}

/// Scalar product, always added in the same order.
#[inline(always)]
pub(crate) fn product(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}

/// Square of the distance of two points, always added in the same order.
#[inline(always)]
pub(crate) fn distance2(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += (a - b) * (a - b);
    }
    sum
}
