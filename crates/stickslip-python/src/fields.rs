//! Results for Python.

use std::collections::HashMap;
use std::hash::Hash;

use numpy::{Complex64, IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::dynamics::Vector;
use stickslip::nalgebra::Complex;

/// A result for Python: a dictionary of numbers, texts and arrays.
pub(crate) struct Fields<'py>(Bound<'py, PyDict>);

impl<'py> Fields<'py> {
    pub(crate) fn new(py: Python<'py>) -> Self {
        Fields(PyDict::new(py))
    }

    pub(crate) fn py(&self) -> Python<'py> {
        self.0.py()
    }

    pub(crate) fn put(&self, name: &str, value: impl IntoPyObject<'py>) -> PyResult<()> {
        self.0.set_item(name, value)
    }

    /// Other fields as a field.
    pub(crate) fn fields(&self, name: &str, fields: Fields<'py>) -> PyResult<()> {
        self.put(name, fields.0)
    }

    /// An array of numbers.
    pub(crate) fn numbers(
        &self,
        name: &str,
        values: impl IntoIterator<Item = f64>,
    ) -> PyResult<()> {
        self.put(name, PyArray1::from_iter(self.py(), values))
    }

    /// An array of numbers, NaN where there is none.
    pub(crate) fn optional_numbers(
        &self,
        name: &str,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> PyResult<()> {
        let values = values.into_iter();
        self.numbers(name, values.map(|value| value.unwrap_or(f64::NAN)))
    }

    /// An array of integers.
    pub(crate) fn integers(
        &self,
        name: &str,
        values: impl IntoIterator<Item = i64>,
    ) -> PyResult<()> {
        self.put(name, PyArray1::from_iter(self.py(), values))
    }

    /// A list of texts.
    pub(crate) fn texts<T: IntoPyObject<'py>>(
        &self,
        name: &str,
        texts: impl IntoIterator<Item = T>,
    ) -> PyResult<()> {
        self.put(name, texts.into_iter().collect::<Vec<T>>())
    }

    /// A column of words: the distinct ones, and for each entry its index among them.
    pub(crate) fn words<K: Copy + Eq + Hash, W: IntoPyObject<'py>>(
        &self,
        name: &str,
        entries: impl Iterator<Item = K>,
        word: impl Fn(&K) -> W,
    ) -> PyResult<()> {
        let (mut indices, mut words) = (HashMap::new(), Vec::new());
        let index = |entry: K| {
            *indices.entry(entry).or_insert_with(|| {
                words.push(word(&entry));
                words.len() - 1
            })
        };
        let column = PyArray1::from_iter(self.py(), entries.map(index));
        self.put(name, (words, column))
    }

    /// An array of numbers with a row for each state.
    pub(crate) fn rows<'a>(
        &self,
        name: &str,
        states: impl IntoIterator<Item = &'a Vector>,
        components: usize,
    ) -> PyResult<()> {
        let flat: Vec<f64> = states.into_iter().flatten().copied().collect();
        self.array(name, flat, [components])
    }

    /// An array of numbers, row by row, of as many rows as they fill.
    pub(crate) fn array<const N: usize>(
        &self,
        name: &str,
        flat: Vec<f64>,
        row: [usize; N],
    ) -> PyResult<()> {
        self.put(name, array(self.py(), flat, row)?)
    }

    /// The dictionary, with the exception that ended the computation early.
    pub(crate) fn ended(self, raised: Option<PyErr>) -> PyResult<Bound<'py, PyDict>> {
        if let Some(raised) = raised {
            self.put("raised", raised.into_value(self.py()))?;
        }
        Ok(self.0)
    }
}

/// An array of numbers, row by row, of as many rows as they fill.
pub(crate) fn array<'py, const N: usize>(
    py: Python<'py>,
    flat: Vec<f64>,
    row: [usize; N],
) -> PyResult<Bound<'py, PyAny>> {
    let count = flat.len() / row.iter().product::<usize>().max(1);
    let shape: Vec<usize> = std::iter::once(count).chain(row).collect();
    Ok(flat.into_pyarray(py).reshape(shape)?.into_any())
}

/// An array of complex numbers.
pub(crate) fn complex<'py>(
    py: Python<'py>,
    values: &[Complex<f64>],
) -> Bound<'py, PyArray1<Complex64>> {
    let values = values
        .iter()
        .map(|value| Complex64::new(value.re, value.im));
    PyArray1::from_iter(py, values)
}
