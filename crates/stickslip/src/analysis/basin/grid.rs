//! A regular grid of starts, each with the number of the attractor that it reaches.

use crate::error::{Error, require};

/// Numbers of attractors on a regular grid; the last axis varies fastest.
#[derive(Clone, Copy)]
pub(super) struct Grid<'a> {
    pub reached: &'a [usize],
    pub shape: &'a [usize],
}

impl<'a> Grid<'a> {
    /// A grid with an attractor for each of its points.
    pub fn new(reached: &'a [usize], shape: &'a [usize]) -> Result<Self, Error> {
        let points: usize = shape.iter().product();
        require(
            !shape.is_empty() && points == reached.len(),
            "shape",
            points as f64,
            "of as many points as there are starts",
        )?;
        Ok(Grid { reached, shape })
    }

    /// Number of points along the shortest axis.
    pub fn shortest(&self) -> usize {
        self.shape.iter().copied().min().unwrap_or(0)
    }

    /// Distance in `reached` between neighbours along each axis.
    pub fn strides(&self) -> Vec<usize> {
        let mut strides = vec![1; self.shape.len()];
        for axis in (1..self.shape.len()).rev() {
            strides[axis - 1] = strides[axis] * self.shape[axis];
        }
        strides
    }
}

/// All indices of a grid of so many points along each axis; the last axis varies fastest.
pub(super) fn indices(counts: &[usize]) -> impl Iterator<Item = Vec<usize>> + '_ {
    let all: usize = counts.iter().product();
    (0..all).map(move |mut number| {
        let mut index = vec![0; counts.len()];
        for (one, count) in index.iter_mut().zip(counts).rev() {
            *one = number % count;
            number /= count;
        }
        index
    })
}
