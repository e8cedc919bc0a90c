//! Residuals of all records, with derivatives by the unknowns.

use std::sync::Arc;

use crate::study::least_squares::{Loss, Residuals};
use rayon::prelude::*;
use stickslip::dynamics::{Matrix, Modes, Vector};
use stickslip::error::readable;

use super::parts::Parts;
use super::record_run::{Failed, RecordAt, RecordRun};
use super::statistics::spread;
use super::unknowns::Unknowns;
use super::{FitError, FitRequest, Modelled, Record};
use crate::expression::normal;
use crate::file::{FileError, Observed, System, SystemFile};

/// Modes of the phases of each record.
pub(super) type Sequence = Vec<Vec<Modes>>;

/// A request made ready to run, in whole records or in parts of them.
pub(super) struct FitProblem<'r> {
    pub(super) request: &'r FitRequest,
    /// The system with the parameters of the observables and the values of the file. The systems of
    /// records without inputs of their own share its build.
    pub(super) base: Arc<System>,
    pub(super) unknowns: Unknowns,
    /// Records, or their parts in order.
    pub(super) records: Vec<RecordRun>,
    pub(super) parts: Option<Parts>,
    /// Standard deviation of each observable's noise.
    pub(super) sigmas: Vec<f64>,
}

impl<'r> FitProblem<'r> {
    pub(super) fn new(request: &'r FitRequest) -> Result<Self, FitError> {
        check(request)?;
        let mut problem = FitProblem {
            request,
            base: Arc::new(observed_file(request)?.with(&[])?),
            unknowns: Unknowns::default(),
            records: Vec::new(),
            parts: None,
            sigmas: Vec::new(),
        };
        let mut systems = Vec::new();
        for record in &request.records {
            systems.push(problem.system(record)?);
        }
        let (unknowns, locals) = Unknowns::of(request, &systems)?;
        problem.unknowns = unknowns;
        for ((system, record), local) in systems.into_iter().zip(&request.records).zip(locals) {
            let run = RecordRun::new(request, system, record, local)?;
            problem.records.push(run);
        }
        let values = problem.records.iter().flat_map(|record| &record.columns);
        let count = values.flatten().filter(|value| !value.is_nan()).count();
        match (count, problem.unknowns.len()) {
            (0, _) => return Err(FitError::NoData),
            (values, unknowns) if values <= unknowns => {
                return Err(FitError::TooFew { values, unknowns });
            }
            _ => {}
        }
        let all = |k: usize| {
            let columns = problem.records.iter().filter_map(move |r| r.columns.get(k));
            columns.flatten().copied().filter(|value| !value.is_nan())
        };
        let sigmas = request.observables.iter().enumerate();
        problem.sigmas = sigmas
            .map(|(k, observable)| observable.sigma.unwrap_or_else(|| spread(all(k))))
            .collect();
        Ok(problem)
    }

    /// The system of a record.
    pub(super) fn system(&self, record: &Record) -> Result<System, FitError> {
        let is_own = |name: &str| {
            let mut own = record.set.iter();
            own.any(|(own, _)| normal(own) == normal(name))
        };
        let common = self.request.set.iter().filter(|(name, _)| !is_own(name));
        let settings = common.chain(&record.set);
        let settings: Vec<(&str, f64)> = settings.map(|(name, value)| (&**name, *value)).collect();
        let mut own = None;
        for (name, times, values) in &record.inputs {
            let file = own.map_or_else(|| observed_file(self.request), Ok)?;
            own = Some(file.with_table(name, (times, values), &record.name)?);
        }
        let system = match own {
            Some(file) => file.with(&[])?.with_values(&settings)?,
            None => self.base.with_values(&settings)?,
        };
        Ok(match &self.request.interrupt {
            Some(interrupt) => system.interrupted_by(interrupt.clone())?,
            None => system,
        })
    }

    /// Adds the residuals of a record, and their derivatives, without missing values.
    pub(super) fn add_rows(
        &self,
        record: &RecordRun,
        run: &RecordAt,
        residuals: &mut Vec<f64>,
        slopes: &mut Vec<f64>,
    ) {
        for (k, (model, data)) in run.values.iter().zip(&record.columns).enumerate() {
            let sigma = self.sigmas.get(k).copied().unwrap_or(1.0);
            for (i, (model, data)) in model.iter().zip(data).enumerate() {
                if data.is_nan() {
                    continue;
                }
                residuals.push((model - data) / sigma);
                slopes.extend(run.slopes[k][i].iter().map(|slope| slope / sigma));
            }
        }
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.request.options.rtol
    }

    pub(super) fn loss(&self) -> Loss {
        self.request.loss
    }

    pub(super) fn is_estimated(&self) -> bool {
        self.request
            .observables
            .iter()
            .any(|one| one.sigma.is_none())
    }

    pub(super) fn check_interrupt(&self) -> Result<(), FitError> {
        match &self.request.interrupt {
            Some(interrupt) if interrupt.is_raised() => Err(FitError::Interrupted),
            _ => Ok(()),
        }
    }

    /// Reports why the fit cannot begin at a point.
    pub(super) fn check_start(&self, x: &Vector) -> Result<(), FitError> {
        let at = self.modelled(x).map_err(|error| self.failed(error))?;
        self.check_interrupt()?;
        if let Some((record, cause)) = at.lost {
            let record = self.records[record].name.clone();
            return Err(FitError::NoDerivatives { record, cause });
        }
        let columns = at.jacobian.column_iter().enumerate();
        let mut idle = columns.filter(|(_, column)| column.amax() == 0.0);
        match idle.next() {
            Some((number, _)) => Err(FitError::NoEffect {
                name: self.unknowns.name(number).to_owned(),
            }),
            None => Ok(()),
        }
    }

    /// Half the weighted sum of squares of the data alone, of residuals at a point.
    pub(super) fn cost_of_data(&self, residuals: &Vector) -> f64 {
        let loss = self.request.loss;
        let data = self.of_data(residuals);
        data.iter().map(|r| loss.of(*r).0).sum()
    }

    /// The residuals of the data: those without the mismatches of parts.
    pub(super) fn of_data(&self, residuals: &Vector) -> Vector {
        let count = residuals.len().saturating_sub(self.mismatches());
        residuals.rows(0, count).into_owned()
    }

    /// Number of data minus number of unknowns that they determine.
    pub(super) fn freedom(&self, residuals: &Vector) -> usize {
        residuals.len().saturating_sub(self.unknowns.len())
    }

    /// The cost at a point, if its runs reach the data and have derivatives.
    pub(super) fn cost(&self, x: &Vector) -> Option<f64> {
        let at = self.modelled(x).ok().filter(|at| at.lost.is_none())?;
        Some(self.cost_of_data(&at.residuals))
    }

    /// The error of runs of whole records, or of parts, that have failed.
    pub(super) fn failed(&self, error: Failed) -> FitError {
        let (number, cause) = match error {
            Failed::Run(number, cause) => (number, Some(cause)),
            Failed::Ends(number, t) if self.parts.is_none() => {
                let record = self.records[number].name.clone();
                return FitError::Ends { record, t };
            }
            Failed::Ends(number, _) => (number, None),
        };
        let run = &self.records[number];
        let record = run.name.clone();
        match cause {
            Some(cause) if self.parts.is_none() => FitError::Start { record, cause },
            cause => {
                let [from, to] = run.span().map(readable);
                let part = format!("{record}: the part from {from} to {to}");
                FitError::Part { part, cause }
            }
        }
    }

    /// The error of a part without derivatives at a point.
    pub(super) fn lost(&self, x: &Vector) -> FitError {
        match self.modelled(x) {
            Ok(Modelled {
                lost: Some((number, cause)),
                ..
            }) => self.failed(Failed::Run(number, cause)),
            Ok(_) => FitError::NoData,
            Err(error) => self.failed(error),
        }
    }

    pub(super) fn residuals(&self, x: &Vector) -> Result<Residuals<Sequence>, Failed> {
        let at = self.modelled(x)?;
        Ok(Residuals {
            piece: at.sequence(),
            values: at.residuals,
            jacobian: at.jacobian,
            constraints: self.mismatches(),
        })
    }

    /// Whether an observable may jump: at jumps of the state, and as a friction force at events.
    pub(super) fn may_jump(&self) -> bool {
        let has_force = |record: &RecordRun| record.observed.iter().any(Observed::has_force);
        !self.base.file.jumps.is_empty() || self.records.iter().any(has_force)
    }

    /// Everything at a point.
    pub(super) fn modelled(&self, x: &Vector) -> Result<Modelled, Failed> {
        self.modelled_to(x, false)
    }

    /// Everything at a point, with events until after the last time of each record whose run goes
    /// on.
    pub(super) fn modelled_beyond(&self, x: &Vector) -> Result<Modelled, Failed> {
        self.modelled_to(x, true)
    }

    fn modelled_to(&self, x: &Vector, is_beyond: bool) -> Result<Modelled, Failed> {
        let runs = self.records.par_iter().enumerate();
        let runs = runs.map(|(k, record)| {
            let run = |is_beyond| record.at(k, x, (self.unknowns.len(), is_beyond));
            match is_beyond {
                true => run(true).or_else(|_| run(false)),
                false => run(false),
            }
        });
        // In order, so that the first failure is the same each time.
        let runs: Vec<Result<RecordAt, Failed>> = runs.collect();
        let runs = runs.into_iter().collect::<Result<Vec<_>, _>>()?;
        let (mut residuals, mut slopes) = (Vec::new(), Vec::new());
        for (run, record) in runs.iter().zip(&self.records) {
            self.add_rows(record, run, &mut residuals, &mut slopes);
        }
        if let Some(parts) = &self.parts {
            parts.add_rows((&self.records, &runs), x, (&mut residuals, &mut slopes));
        }
        let mut all = Modelled {
            values: Vec::new(),
            sizes: Vec::new(),
            jacobian: Matrix::from_row_slice(residuals.len(), self.unknowns.len(), &slopes),
            residuals: Vector::from_vec(residuals),
            points: Vec::new(),
            phases: Vec::new(),
            jumps: Vec::new(),
            lost: None,
        };
        for (number, run) in runs.into_iter().enumerate() {
            all.values.push(run.values);
            all.sizes.push(run.sizes);
            all.points.push(run.points);
            all.phases.push(run.phases);
            all.jumps.push(run.jumps);
            if let Some(lost) = run.lost {
                all.lost.get_or_insert((number, lost));
            }
        }
        Ok(all)
    }
}

/// The file with the parameters of the observables.
fn observed_file(request: &FitRequest) -> Result<SystemFile, FileError> {
    let further = request.extra.iter();
    let further: Vec<(&str, f64)> = further.map(|(name, value)| (&**name, *value)).collect();
    request.file.with_parameters(&further)
}

/// Refuses settings that no fit can have.
fn check(request: &FitRequest) -> Result<(), FitError> {
    for observable in &request.observables {
        if let Some(sigma) = observable.sigma
            && !(sigma > 0.0 && sigma.is_finite())
        {
            return Err(FitError::Request(format!(
                "the standard deviation {} of `{}` must be positive: leave it out to have it \
                 estimated",
                readable(sigma),
                observable.name
            )));
        }
    }
    if let Loss::SoftL1(scale) | Loss::Huber(scale) = request.loss
        && !(scale > 0.0 && scale.is_finite())
    {
        return Err(FitError::Request(format!(
            "the scale {} of the loss must be positive: it counts standard deviations",
            readable(scale)
        )));
    }
    if request.unknowns.is_empty() {
        return Err(FitError::Request(
            "nothing is fitted: name a parameter, a state for its start value, or t0".into(),
        ));
    }
    let mut states = request.file.states.iter();
    if request.segments > 1
        && let Some(held) = states.find(|state| state.is_discrete)
    {
        return Err(FitError::Request(format!(
            "{} segments need a start of the discrete state `{}` each, which no derivative gives: \
             leave segments out",
            request.segments, held.name
        )));
    }
    Ok(())
}
