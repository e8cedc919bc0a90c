//! The noise of each observable, estimated from residuals.

use crate::study::least_squares::Loss;
use stickslip::dynamics::Vector;

use super::problem::FitProblem;
use super::statistics::spread;

/// The median of the size of a normal deviate.
const MEDIAN_SIZE: f64 = 0.6745;

impl FitProblem<'_> {
    /// Sets the deviations that are not given to those of the residuals at a point, and returns the
    /// largest relative change. Their order of size is kept where residuals are rounding.
    pub(super) fn estimate_sigmas(&mut self, residuals: &Vector) -> f64 {
        let is_robust = self.request.loss != Loss::Squares;
        let data = self.of_data(residuals).len();
        let part = self.freedom(residuals).max(1) as f64 / data.max(1) as f64;
        let mut largest: f64 = 0.0;
        let sizes = self.sizes(residuals);
        for (k, (observable, mut sizes)) in self.request.observables.iter().zip(sizes).enumerate() {
            if observable.sigma.is_some() {
                continue;
            }
            let measured = self
                .records
                .iter()
                .filter_map(|record| record.columns.get(k));
            let measured = measured.flatten().copied().filter(|value| !value.is_nan());
            // Below the error of the runs, residuals are no noise.
            let least = self.request.options.rtol * spread(measured);
            let sigma = if is_robust {
                sizes.sort_by(f64::total_cmp);
                let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
                median / MEDIAN_SIZE / part.sqrt()
            } else {
                let squares: f64 = sizes.iter().map(|off| off * off).sum();
                (squares / sizes.len().max(1) as f64 / part).sqrt()
            };
            let sigma = sigma.max(least);
            let known = &mut self.sigmas[k];
            largest = largest.max((sigma - *known).abs() / sigma);
            *known = sigma;
        }
        largest
    }

    /// Sizes of the residuals of each observable, in the unit of the data.
    fn sizes(&self, residuals: &Vector) -> Vec<Vec<f64>> {
        let mut sizes = vec![Vec::new(); self.sigmas.len()];
        let mut weighted = residuals.iter();
        for record in &self.records {
            let columns = record.columns.iter().zip(&mut sizes).zip(&self.sigmas);
            for ((column, sizes), sigma) in columns {
                let count = column.iter().filter(|value| !value.is_nan()).count();
                sizes.extend(weighted.by_ref().take(count).map(|r| r.abs() * sigma));
            }
        }
        sizes
    }
}
