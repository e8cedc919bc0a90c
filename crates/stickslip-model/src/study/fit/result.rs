//! Results of a fit for one minimum.

use crate::study::least_squares::LeastSquares;
use stickslip::dynamics::Modes;

use super::problem::{FitProblem, Sequence};
use super::statistics::{FALSE_ALARMS, FEWEST_IN_PHASE, above_squares, runs_test};
use super::uncertainty::FitUncertainty;
use super::work::FitWork;
use super::{Fit, FitError, FittedColumn, FittedValue, Modelled, OtherMinimum, PhaseOff};

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
                let mut column = self.column((number, observable), data, model);
                if !self.is_rounding(column.rms, scale) {
                    column.runs = runs_test(&column.residuals);
                    column.off = self.phases_off(&column, &at.phases[number]);
                }
                columns.push(column);
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
        let grazes = match work.crossings {
            0 => Some(0),
            _ => self.grazes(&self.unknowns.start(), &best.x),
        };
        Ok(Fit {
            values: values.collect(),
            columns,
            seen: self.seen(&best.x, &at)?,
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
            grazes,
            others,
            uncertainty,
        })
    }

    /// Whether residuals of this size are rounding. `scale` is that of what the state contributes.
    fn is_rounding(&self, rms: f64, scale: f64) -> bool {
        rms <= ROUNDING * self.request.options.rtol * scale
    }

    /// One column of a record, by the numbers of both, without tests.
    fn column(
        &self,
        (record, observable): (usize, usize),
        data: &[f64],
        model: &[f64],
    ) -> FittedColumn {
        let pairs = data.iter().zip(model);
        let residuals: Vec<f64> = pairs.map(|(data, model)| data - model).collect();
        let known: Vec<f64> = residuals.iter().copied().filter(|r| !r.is_nan()).collect();
        // The sum of no values is -0.
        let squares = known.iter().fold(0.0, |sum, r| sum + r * r);
        let rms = (squares / known.len().max(1) as f64).sqrt();
        FittedColumn {
            record,
            observable,
            model: model.to_vec(),
            runs: None,
            off: Vec::new(),
            residuals,
            count: known.len(),
            rms,
            sigma: self.sigmas[observable],
        }
    }

    /// The phases of a record in which the residuals of a column are too large for its noise.
    fn phases_off(&self, column: &FittedColumn, phases: &[(f64, f64, Modes)]) -> Vec<PhaseOff> {
        let times = &self.request.records[column.record].times;
        let mut off = Vec::new();
        let mut tested: usize = 0;
        for (phase, (from, to, _)) in phases.iter().enumerate() {
            let after = |end: &f64| times.partition_point(|t| t <= end);
            // A value at the start is in the first phase.
            let rows = if phase == 0 { 0 } else { after(from) }..after(to);
            let residuals = column.residuals[rows].iter().filter(|r| !r.is_nan());
            // Twice the cost: outliers count as in the fit.
            let cost = |r: &f64| 2.0 * self.loss().of(r / column.sigma).0;
            let squares: Vec<f64> = residuals.map(cost).collect();
            if squares.len() < FEWEST_IN_PHASE {
                continue;
            }
            tested += 1;
            let (count, sum) = (squares.len(), squares.iter().sum::<f64>());
            off.push(PhaseOff {
                phase,
                count,
                ratio: (sum / count as f64).sqrt(),
                p_value: above_squares(sum, count),
            });
        }
        off.retain(|one| one.p_value * (tested as f64) < FALSE_ALARMS);
        off
    }

    /// Joins the values of parts to those of records.
    fn joined(&self, at: Modelled) -> Modelled {
        let Some(parts) = &self.parts else {
            return at;
        };
        type Columns = Vec<Vec<f64>>;
        let columns = |known: &mut Columns, by: Columns| {
            let pairs = known.iter_mut().zip(by);
            pairs.for_each(|(known, column)| known.extend(column));
        };
        Modelled {
            values: parts.joined(at.values, columns),
            sizes: parts.joined(at.sizes, columns),
            points: parts.joined(at.points, Vec::extend),
            phases: parts.joined(at.phases, Vec::extend),
            ..at
        }
    }
}
