//! Results of a fit for one minimum.

use stickslip::analysis::LeastSquares;

use super::problem::{FitProblem, Sequence};
use super::statistics::runs_test;
use super::uncertainty::FitUncertainty;
use super::work::FitWork;
use super::{Fit, FitError, FittedColumn, FittedValue, Modelled, OtherMinimum};

/// Error of a run over its tolerance, below which signs of residuals say nothing.
const ROUNDING: f64 = 1e3;

impl FitProblem<'_> {
    pub(super) fn result(
        &self,
        best: &LeastSquares<Sequence>,
        work: FitWork,
        uncertainty: FitUncertainty,
        others: Vec<OtherMinimum>,
    ) -> Result<Fit, FitError> {
        let parts = self.modelled(&best.x).map_err(|error| self.failed(error))?;
        let residuals = parts.residuals.clone();
        let at = self.joined(parts);
        let mut columns = Vec::new();
        let records = self
            .request
            .records
            .iter()
            .zip(at.values.iter().zip(&at.sizes));
        for (number, (record, (values, sizes))) in records.enumerate() {
            let pairs = record.columns.iter().zip(values.iter().zip(sizes));
            for (observable, (data, (model, sizes))) in pairs.enumerate() {
                let scale = sizes.iter().fold(0.0_f64, |most, size| most.max(*size));
                columns.push(self.column((number, observable), data, (&model[..], scale)));
            }
        }
        // The starts of parts are no results.
        let unknowns = self.unknowns.0.iter();
        let named = unknowns.filter(|one| !one.name.is_empty()).enumerate();
        let values = named.map(|(k, one)| {
            let value = best.x[k];
            let std_error = uncertainty.std_errors.get(k).copied().flatten();
            let half = std_error.map(|error| error * uncertainty.quantile);
            FittedValue {
                name: one.name.clone(),
                start: one.start,
                value,
                bounds: one.bounds,
                is_at_bound: value <= one.bounds.0 || value >= one.bounds.1,
                std_error,
                interval: half.map(|half| (value - half, value + half)),
            }
        });
        let records = self.request.records.iter();
        Ok(Fit {
            values: values.collect(),
            columns,
            phases: at.phases,
            times: records.map(|record| record.times.clone()).collect(),
            cost: self.cost_of_data(&residuals),
            mismatch: self.largest_mismatch(&residuals),
            freedom: self.freedom(&residuals),
            end: best.end,
            steps: work.steps,
            evaluations: work.evaluations,
            failures: work.failures,
            crossings: work.crossings,
            jumps: work.jumps,
            others,
            uncertainty,
        })
    }

    /// One column of a record, by the numbers of both, with the size of what the state contributes.
    fn column(
        &self,
        (record, observable): (usize, usize),
        data: &[f64],
        (model, scale): (&[f64], f64),
    ) -> FittedColumn {
        let pairs = data.iter().zip(model);
        let residuals: Vec<f64> = pairs.map(|(data, model)| data - model).collect();
        let known: Vec<f64> = residuals.iter().copied().filter(|r| !r.is_nan()).collect();
        // The sum of no values is -0.
        let squares = known.iter().fold(0.0, |sum, r| sum + r * r);
        let rms = (squares / known.len().max(1) as f64).sqrt();
        let is_rounding = rms <= ROUNDING * self.request.options.rtol * scale;
        FittedColumn {
            record,
            observable,
            model: model.to_vec(),
            runs: runs_test(&known).filter(|_| !is_rounding),
            residuals,
            count: known.len(),
            rms,
            sigma: self.sigmas[observable],
        }
    }

    /// Joins the values of parts to those of records.
    fn joined(&self, at: Modelled) -> Modelled {
        let Some(parts) = &self.parts else {
            return at;
        };
        type Columns = Vec<Vec<f64>>;
        let (mut values, mut phases, mut sizes) = (Vec::new(), Vec::new(), Vec::new());
        let extend = |known: &mut Columns, by: Columns| {
            let pairs = known.iter_mut().zip(by);
            pairs.for_each(|(known, column)| known.extend(column));
        };
        let runs = at.values.into_iter().zip(at.sizes).zip(at.phases);
        for (part, ((columns, of_columns), of_part)) in runs.enumerate() {
            match (values.last_mut(), sizes.last_mut(), phases.last_mut()) {
                (Some(known), Some(of_known), Some(whole)) if parts.continues(part) => {
                    extend(known, columns);
                    extend(of_known, of_columns);
                    Vec::extend(whole, of_part);
                }
                _ => {
                    values.push(columns);
                    sizes.push(of_columns);
                    phases.push(of_part);
                }
            }
        }
        Modelled {
            values,
            sizes,
            phases,
            ..at
        }
    }
}
