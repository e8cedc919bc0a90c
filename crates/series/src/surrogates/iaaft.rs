//! Series with the power spectrum and the values of another.
//!
//! The transform's last bits may differ from machine to machine, as its crate takes sines from the
//! system. They decide only the order of the values. A surrogate is the same everywhere, except
//! where two values before ordering agree to rounding.

use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use crate::error::DataError;
use crate::series::Series;
use numerics::{SplitMix, order};

/// Largest number of iterations for a surrogate. Chosen, to bound the time: the spectrum then
/// changes by little.
const MOST_ITERATIONS: usize = 100;
/// Points of the series for each of those at either end that may be left out to make the ends fit.
const POINTS_PER_END_POINT: usize = 20;
/// Most points that may be left out at either end; the search takes the square of the time.
const MOST_END_POINTS: usize = 500;

/// Makes surrogates of a series.
pub(crate) struct Randomiser {
    original: Series,
    columns: Vec<Column>,
    forward: Arc<dyn RealToComplex<f64>>,
    backward: Arc<dyn ComplexToReal<f64>>,
}

/// Data that all surrogates of a column share.
struct Column {
    sorted: Vec<f64>,
    /// Rank of each value; equal values in the order of time.
    ranks: Vec<usize>,
    /// Moduli of the transform.
    moduli: Vec<f64>,
}

impl Randomiser {
    /// # Errors
    /// [`DataError::Transform`].
    pub(crate) fn new(series: &Series) -> Result<Self, DataError> {
        let original = periodic_part(series)?;
        let rows = original.len();
        let mut planner = RealFftPlanner::new();
        let forward = planner.plan_fft_forward(rows);
        let backward = planner.plan_fft_inverse(rows);
        let columns = (0..original.columns()).map(|column| {
            let values: Vec<f64> = original.column(column).collect();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let ranks = ranks(&values);
            let moduli = transform(&*forward, values)?;
            Ok(Column {
                sorted,
                ranks,
                moduli: moduli.iter().map(|c| c.norm_sqr().sqrt()).collect(),
            })
        });
        Ok(Self {
            columns: columns.collect::<Result<_, DataError>>()?,
            original,
            forward,
            backward,
        })
    }

    /// The part of the series that surrogates are made of.
    pub(crate) fn original(&self) -> &Series {
        &self.original
    }

    /// The surrogate of a seed.
    ///
    /// # Errors
    /// [`DataError::Transform`].
    pub(crate) fn surrogate(&self, seed: u64) -> Result<Series, DataError> {
        let rows = self.original.len();
        let mut random = SplitMix::new(seed);
        let phases: Vec<Complex<f64>> = (0..rows / 2 + 1)
            .map(|_| {
                let angle = std::f64::consts::TAU * random.uniform();
                Complex::new(libm::cos(angle), libm::sin(angle))
            })
            .collect();
        let mut bell: Vec<f64> = (0..rows)
            .map(|_| {
                let radius = (-2.0 * libm::log(1.0 - random.uniform())).sqrt();
                radius * libm::cos(std::f64::consts::TAU * random.uniform())
            })
            .collect();
        bell.sort_by(f64::total_cmp);
        let mut values = vec![0.0; rows * self.columns.len()];
        for (c, column) in self.columns.iter().enumerate() {
            let surrogate = self.randomise(column, &bell, &phases)?;
            let places = values.iter_mut().skip(c).step_by(self.columns.len());
            places
                .zip(surrogate)
                .for_each(|(place, value)| *place = value);
        }
        Series::new(values, self.columns.len(), self.original.dt())
    }

    fn randomise(
        &self,
        column: &Column,
        bell: &[f64],
        phases: &[Complex<f64>],
    ) -> Result<Vec<f64>, DataError> {
        // The order of the values with a Gaussian distribution, whose phases are turned (Theiler's
        // amplitude-adjusted surrogate).
        let gaussian = column.ranks.iter().map(|&rank| bell[rank]).collect();
        let mut spectrum = transform(&*self.forward, gaussian)?;
        spectrum
            .iter_mut()
            .zip(phases)
            .for_each(|(c, phase)| *c *= phase);
        let mut order = ranks(&self.back(spectrum)?);
        // Spectrum and values in turn, until the order of the values stays.
        for _ in 0..MOST_ITERATIONS {
            let values = order.iter().map(|&rank| column.sorted[rank]).collect();
            let mut spectrum = transform(&*self.forward, values)?;
            for (c, modulus) in spectrum.iter_mut().zip(&column.moduli) {
                *c = match c.norm_sqr().sqrt() {
                    own if own > 0.0 => *c * (modulus / own),
                    _ => Complex::new(*modulus, 0.0),
                };
            }
            let next = ranks(&self.back(spectrum)?);
            if next == order {
                break;
            }
            order = next;
        }
        Ok(order.iter().map(|&rank| column.sorted[rank]).collect())
    }

    fn back(&self, mut spectrum: Vec<Complex<f64>>) -> Result<Vec<f64>, DataError> {
        let mut values = self.backward.make_output_vec();
        // Mean and, for an even number of points, the highest frequency are real.
        if let Some(mean) = spectrum.first_mut() {
            mean.im = 0.0;
        }
        if values.len().is_multiple_of(2)
            && let Some(highest) = spectrum.last_mut()
        {
            highest.im = 0.0;
        }
        self.backward
            .process(&mut spectrum, &mut values)
            .map_err(|error| failed(values.len(), &error))?;
        Ok(values)
    }
}

fn transform(
    forward: &dyn RealToComplex<f64>,
    mut values: Vec<f64>,
) -> Result<Vec<Complex<f64>>, DataError> {
    let mut spectrum = forward.make_output_vec();
    forward
        .process(&mut values, &mut spectrum)
        .map_err(|error| failed(values.len(), &error))?;
    Ok(spectrum)
}

fn failed(rows: usize, error: &realfft::FftError) -> DataError {
    DataError::Transform {
        rows,
        cause: error.to_string(),
    }
}

/// Rank of each value, equal ones in order.
fn ranks(values: &[f64]) -> Vec<usize> {
    let mut ranks = vec![0; values.len()];
    for (rank, at) in order(values).into_iter().enumerate() {
        ranks[at] = rank;
    }
    ranks
}

/// The part of the series whose ends fit together best in value and slope. The transform treats it
/// as periodic, and a jump there would be noise in all surrogates (Theiler and others 1992).
fn periodic_part(series: &Series) -> Result<Series, DataError> {
    let (rows, columns) = (series.len(), series.columns());
    let reach = (rows / POINTS_PER_END_POINT).min(MOST_END_POINTS);
    let row = |i: usize| &series.values()[i * columns..(i + 1) * columns];
    let weights = weights(series);
    let mut best = (f64::INFINITY, 0, rows);
    for from in 0..reach {
        for until in rows - reach + 1..=rows {
            let (mut jump, mut bend) = (0.0, 0.0);
            for (c, weight) in weights.iter().enumerate() {
                // The point after the last one would be the first.
                let value = row(from)[c] - row(until - 1)[c];
                let slope = row(from + 1)[c] - row(from)[c];
                let last = row(until - 1)[c] - row(until - 2)[c];
                jump += weight * (value - 0.5 * (slope + last)) * (value - 0.5 * (slope + last));
                bend += weight * (slope - last) * (slope - last);
            }
            if jump + bend < best.0 {
                best = (jump + bend, from, until);
            }
        }
    }
    let (_, from, until) = best;
    let part = series.values()[from * columns..until * columns].to_vec();
    Series::new(part, columns, series.dt())
}

/// One over the variance of each column.
fn weights(series: &Series) -> Vec<f64> {
    let weight = |column: usize| {
        let values = || series.column(column);
        let count = series.len() as f64;
        let mean = values().sum::<f64>() / count;
        let variance = values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
        if variance > 0.0 { 1.0 / variance } else { 0.0 }
    };
    (0..series.columns()).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(rows: usize, phi: f64) -> Vec<[f64; 2]> {
        let mut random = SplitMix::new(3);
        let mut x = [0.0; 2];
        (0..rows)
            .map(|_| {
                x[0] = phi * x[0] + random.between(-1.0, 1.0);
                x[1] = 0.5 * x[1] + x[0];
                [libm::exp(0.3 * x[0]), x[1]]
            })
            .collect()
    }

    fn correlation(series: &Series, a: usize, b: usize, lag: usize) -> f64 {
        let rows = series.len();
        let value = |row: usize, column: usize| series.values()[row * 2 + column];
        let mean = |c| (0..rows).map(|i| value(i, c)).sum::<f64>() / rows as f64;
        let (ma, mb) = (mean(a), mean(b));
        let product = |x: usize, y: usize, lag: usize, mx: f64, my: f64| -> f64 {
            (0..rows - lag)
                .map(|i| (value(i, x) - mx) * (value(i + lag, y) - my))
                .sum()
        };
        product(a, b, lag, ma, mb) / (product(a, a, 0, ma, ma) * product(b, b, 0, mb, mb)).sqrt()
    }

    /// The values are the same ones, the correlations are kept (over 5000 points to about 1/√5000),
    /// the order is another.
    #[test]
    fn surrogates_have_the_values_and_the_correlations() {
        let series = Series::from_rows(noise(5000, 0.8), 0.1).unwrap();
        let randomiser = Randomiser::new(&series).unwrap();
        let original = randomiser.original();
        let surrogate = randomiser.surrogate(1).unwrap();
        assert_ne!(original.values(), surrogate.values());
        for column in 0..2 {
            let sorted = |series: &Series| {
                let mut values: Vec<f64> = series.values()[column..]
                    .iter()
                    .step_by(2)
                    .copied()
                    .collect();
                values.sort_by(f64::total_cmp);
                values
            };
            assert_eq!(sorted(original), sorted(&surrogate));
        }
        for (a, b, lag) in [(0, 0, 1), (0, 0, 4), (1, 1, 2), (0, 1, 0), (0, 1, 2)] {
            let (kept, found) = (
                correlation(original, a, b, lag),
                correlation(&surrogate, a, b, lag),
            );
            assert!((kept - found).abs() < 0.05, "{a} {b} {lag}: {kept} {found}");
        }
        let again = randomiser.surrogate(1).unwrap();
        assert_eq!(surrogate, again);
        assert_ne!(surrogate, randomiser.surrogate(2).unwrap());
    }

    #[test]
    fn the_part_taken_is_periodic() {
        // 10.3 periods of a sine.
        let sine = (0..1030).map(|i| [libm::sin(std::f64::consts::TAU * f64::from(i) / 100.0)]);
        let part = periodic_part(&Series::from_rows(sine, 1.0).unwrap()).unwrap();
        assert_eq!(part.len() % 100, 0, "{}", part.len());
        // Odd and tiny lengths are no failure.
        for rows in [1, 2, 3, 45, 101] {
            let short = (0..rows).map(|i| [f64::from(i * i % 7), 1.0]);
            let randomiser = Randomiser::new(&Series::from_rows(short, 1.0).unwrap()).unwrap();
            assert_eq!(
                randomiser.surrogate(5).unwrap().len(),
                randomiser.original().len()
            );
        }
    }
}
