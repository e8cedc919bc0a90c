//! Residuals of all records, with derivatives by the unknowns.

use rayon::prelude::*;
use stickslip::analysis::{LeastSquares, Loss, Residuals, Variable, orbit_derivatives};
use stickslip::dynamics::{DynamicsRef, Matrix, Modes, Vector};
use stickslip::error::readable;
use stickslip::scalar::Dual;
use stickslip::{Error, Options, Scalar};

use super::statistics::{halton, runs_test, spread};
use super::{
    Fit, FitError, FitRequest, FittedColumn, FittedValue, Modelled, OtherMinimum, Record,
    Uncertainty,
};
use crate::expression::{Tape, normal};
use crate::file::{FreeStarts, Meaning, Observed, System, SystemFile};
use crate::kernel::HELD_PER_INPUT;
use crate::study::Variables;

/// Modes of the phases of each record.
pub(super) type Sequence = Vec<Vec<Modes>>;

/// Why residuals could not be computed.
pub(super) enum Failed {
    Run(usize, Error),
    Ends(usize, f64),
}

/// What an unknown is in a record.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Parameter(usize),
    State(usize),
    StartTime,
}

/// A start of a part of a record: its first unknown, and states from which it may begin.
#[derive(Clone)]
pub(super) struct Node {
    pub(super) instance: usize,
    pub(super) first: usize,
    pub(super) candidates: Vec<Vector>,
}

/// A number that is sought.
#[derive(Clone)]
struct Sought {
    name: String,
    start: f64,
    bounds: (f64, f64),
}

/// A record ready to run.
struct Instance {
    name: String,
    system: System,
    options: Options,
    dynamics: DynamicsRef<'static>,
    observed: Vec<Observed>,
    times: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// Starts as far as they are fixed.
    t_start: Option<f64>,
    start: Vec<Option<f64>>,
    free: FreeStarts,
    /// What is sought here, and its index among all.
    local: Vec<(Kind, usize)>,
    /// Parameters that are states behind those of the system.
    parameters: Vec<usize>,
    /// What the orbit is differentiated by.
    by: Vec<Variable>,
}

pub(super) struct Problem<'r> {
    request: &'r FitRequest,
    /// The file with the parameters of the observables, and the number of those without them.
    file: SystemFile,
    own_parameters: usize,
    /// Records whose ends are the starts of the next, and the first unknown of that start.
    joins: Vec<(usize, usize)>,
    /// Weight of a mismatch there over the spread of each state.
    weight: f64,
    spreads: Vec<f64>,
    nodes: Vec<Node>,
    sought: Vec<Sought>,
    records: Vec<Instance>,
    /// For each observable.
    pub(super) sigmas: Vec<f64>,
}

impl<'r> Problem<'r> {
    pub(super) fn new(request: &'r FitRequest) -> Result<Self, FitError> {
        let further = request.extra.iter();
        let further: Vec<(&str, f64)> = further.map(|(name, value)| (&**name, *value)).collect();
        let own = request.file.parameters.len();
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
        let mut problem = Problem {
            request,
            file: request.file.with_parameters(&further)?,
            own_parameters: own,
            joins: Vec::new(),
            weight: 0.0,
            spreads: Vec::new(),
            nodes: Vec::new(),
            sought: Vec::new(),
            records: Vec::new(),
            sigmas: Vec::new(),
        };
        let mut systems = Vec::new();
        for record in &request.records {
            systems.push(problem.system(record)?);
        }
        let locals = problem.unknowns(&systems)?;
        for ((system, record), local) in systems.into_iter().zip(&request.records).zip(locals) {
            let instance = problem.instance(system, record, local)?;
            problem.records.push(instance);
        }
        let values = problem.records.iter().flat_map(|record| &record.columns);
        let count = values.flatten().filter(|value| !value.is_nan()).count();
        match (count, problem.sought.len()) {
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
    fn system(&self, record: &Record) -> Result<System, FitError> {
        let is_own = |name: &str| {
            let mut own = record.set.iter();
            own.any(|(own, _)| normal(own) == normal(name))
        };
        let common = self.request.set.iter().filter(|(name, _)| !is_own(name));
        let settings: Vec<(String, f64)> = common.chain(&record.set).cloned().collect();
        let system = self.file.with(&settings)?;
        Ok(match &self.request.interrupt {
            Some(interrupt) => system.interrupted_by(interrupt.clone())?,
            None => system,
        })
    }

    /// The problem of records in parts, each of which begins at a state of its own, and the point
    /// that has the present orbit. None where that run fails, or a part could have no start.
    pub(super) fn in_segments(
        &self,
        x: &Vector,
        segments: usize,
        candidates: usize,
    ) -> Option<(Problem<'r>, Vector)> {
        let mut parts = Problem {
            request: self.request,
            file: self.file.clone(),
            own_parameters: self.own_parameters,
            sought: self.sought.clone(),
            records: Vec::new(),
            sigmas: self.sigmas.clone(),
            joins: Vec::new(),
            weight: 0.0,
            spreads: Vec::new(),
            nodes: Vec::new(),
        };
        let mut whole: Vec<f64> = x.iter().copied().collect();
        for (k, (record, base)) in self.request.records.iter().zip(&self.records).enumerate() {
            let states = base.system.states();
            if base
                .system
                .file
                .states
                .iter()
                .any(|state| state.is_discrete)
            {
                return None;
            }
            let points = base.at(k, x, self.sought.len()).ok()?.points;
            if k == 0 {
                let of = |state: usize| spread(points.iter().map(|point| point[state]));
                parts.spreads = (0..states).map(of).collect();
            }
            let count = base.times.len();
            let every = (points.len() / candidates).max(1);
            // A part without a value of its own would begin anywhere.
            let segments = segments.min(count / 2).max(1);
            for segment in 0..segments {
                let [from, to] = [segment, segment + 1].map(|part| part * count / segments);
                let cut = |of: &Vec<f64>| of[from..to].to_vec();
                let is_first = segment == 0;
                let before = from.checked_sub(1).map(|row| base.times[row]);
                let part = Record {
                    name: record.name.clone(),
                    times: cut(&record.times),
                    columns: record.columns.iter().map(cut).collect(),
                    set: record.set.clone(),
                    start: if is_first {
                        record.start.clone()
                    } else {
                        Vec::new()
                    },
                    t_start: before.or(record.t_start),
                };
                let mut local = base.local.clone();
                if !is_first {
                    local.retain(|(kind, _)| matches!(kind, Kind::Parameter(_)));
                    let first = parts.sought.len();
                    let begin = points.get(from.wrapping_sub(1))?;
                    for state in 0..states {
                        local.push((Kind::State(state), first + state));
                        whole.push(begin[state]);
                        parts.sought.push(Sought {
                            name: String::new(),
                            start: begin[state],
                            bounds: (f64::NEG_INFINITY, f64::INFINITY),
                        });
                    }
                    let others = points.iter().step_by(every).cloned();
                    parts.joins.push((parts.records.len() - 1, first));
                    parts.nodes.push(Node {
                        instance: parts.records.len(),
                        first,
                        candidates: std::iter::once(begin.clone()).chain(others).collect(),
                    });
                }
                let system = parts.system(&part).ok()?;
                let instance = parts.instance(system, &part, local).ok()?;
                parts.records.push(instance);
            }
        }
        Some((parts, Vector::from_vec(whole)))
    }

    pub(super) fn nodes(&self) -> Vec<Node> {
        self.nodes.clone()
    }

    pub(super) fn set_weight(&mut self, weight: f64) {
        self.weight = weight;
    }

    /// Residuals of one record alone, by all unknowns.
    pub(super) fn of_instance(
        &self,
        number: usize,
        x: &Vector,
    ) -> Result<Residuals<Sequence>, Failed> {
        let record = &self.records[number];
        let run = record.at(number, x, self.sought.len())?;
        let (mut residuals, mut slopes) = (Vec::new(), Vec::new());
        self.add_rows(record, &run, &mut residuals, &mut slopes);
        let rows = residuals.len();
        Ok(Residuals {
            values: Vector::from_vec(residuals),
            jacobian: Matrix::from_row_slice(rows, self.sought.len(), &slopes),
            piece: vec![run.phases.iter().map(|phase| phase.2).collect()],
        })
    }

    /// Adds the residuals of a record, and their derivatives, without missing values.
    fn add_rows(
        &self,
        record: &Instance,
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

    /// Collects what is sought, and returns for each record what of it is there.
    fn unknowns(&mut self, systems: &[System]) -> Result<Vec<Vec<(Kind, usize)>>, FitError> {
        let request = self.request;
        let mut locals = vec![Vec::new(); systems.len()];
        let Some(first) = systems.first() else {
            return Err(FitError::NoData);
        };
        let names: Vec<&str> = request.unknowns.iter().map(|one| &*one.name).collect();
        // Names the first that is wrong.
        Variables::named(first, names.iter().copied())?;
        for unknown in &request.unknowns {
            let (low, high) = unknown.bounds;
            if low.is_nan() || high.is_nan() || low >= high {
                return Err(FitError::Request(format!(
                    "the bounds of `{}` from {} to {} contain nothing: the lower one comes first",
                    unknown.name,
                    readable(low),
                    readable(high)
                )));
            }
            let name = normal(&unknown.name);
            let kind = match first.file.names.get(&name) {
                Some(Meaning::Parameter(number)) => Kind::Parameter(number),
                Some(Meaning::State(state)) => Kind::State(state),
                _ => Kind::StartTime,
            };
            let is_local = unknown.each || !matches!(kind, Kind::Parameter(_));
            let several = systems.len() > 1;
            for (k, (system, record)) in systems.iter().zip(&request.records).enumerate() {
                if k > 0 && !is_local {
                    if let Some(&shared) = locals.first().and_then(|local: &Vec<_>| local.last()) {
                        locals[k].push(shared);
                    }
                    continue;
                }
                let starts = record.start.iter();
                let given = |name: &str| {
                    let mut found = starts.clone().filter(|(own, _)| normal(own) == name);
                    found.next().map(|(_, value)| *value)
                };
                let (start, (mut low, mut high)) = match kind {
                    Kind::Parameter(number) => {
                        let entry = first.file.parameters.get(number);
                        let range = entry.and_then(|entry| entry.range);
                        let (from, to) = range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
                        let value = system.values.get(number).copied();
                        (value, (low.max(from), high.min(to)))
                    }
                    Kind::State(state) => {
                        let of_file = system.built.starts.get(state).copied().flatten();
                        (given(&name).or(of_file), unknown.bounds)
                    }
                    Kind::StartTime => {
                        let start = record.t_start.unwrap_or(system.built.t_start);
                        // The run cannot begin after the first value.
                        let first = record.times.first().copied().unwrap_or(f64::INFINITY);
                        (Some(start), (low, high.min(first)))
                    }
                };
                let start = unknown.start.or(start).ok_or_else(|| {
                    FitError::Request(format!(
                        "the start has no value of `{name}`: give one to begin with, as in \
                         {name}=0"
                    ))
                })?;
                if !(low..=high).contains(&start) {
                    return Err(FitError::Request(format!(
                        "`{name}` begins with {}, outside its bounds from {} to {}: begin within \
                         them, or widen them",
                        readable(start),
                        readable(low),
                        readable(high)
                    )));
                }
                // Both zeros are one bound.
                (low, high) = (low + 0.0, high + 0.0);
                locals[k].push((kind, self.sought.len()));
                self.sought.push(Sought {
                    name: match is_local && several {
                        true => format!("{name}@{}", k + 1),
                        false => name.clone(),
                    },
                    start,
                    bounds: (low, high),
                });
            }
        }
        Ok(locals)
    }

    fn instance(
        &self,
        system: System,
        record: &Record,
        local: Vec<(Kind, usize)>,
    ) -> Result<Instance, FitError> {
        let own_parameters = self.own_parameters;
        let name = record.name.clone();
        let is_wrong = |k: &usize| {
            let (before, now) = (record.times.get(k.wrapping_sub(1)), record.times[*k]);
            !now.is_finite() || before.is_some_and(|before| *before >= now)
        };
        if let Some(row) = (0..record.times.len()).find(is_wrong) {
            let (time, row) = (record.times[row], row + 1);
            let record = name;
            return Err(FitError::Times { record, row, time });
        }
        let (Some(&first), Some(&last)) = (record.times.first(), record.times.last()) else {
            return Err(FitError::NoData);
        };
        if record.columns.len() != self.request.observables.len()
            || record
                .columns
                .iter()
                .any(|of| of.len() != record.times.len())
        {
            return Err(FitError::Request(format!(
                "{name}: each observable needs a column with a value for each time"
            )));
        }
        if let Some(value) = record.columns.iter().flatten().find(|v| v.is_infinite()) {
            return Err(FitError::Request(format!(
                "{name}: a value is {value}; leave the cell empty where nothing was measured"
            )));
        }
        // Those of the system first: the orbit depends on no others.
        let mut parameters: Vec<usize> = Vec::new();
        for is_extra in [false, true] {
            parameters.extend(local.iter().filter_map(|(kind, _)| match *kind {
                Kind::Parameter(number) if (number >= own_parameters) == is_extra => Some(number),
                _ => None,
            }));
        }
        let mut start = vec![None; system.states()];
        for (given, value) in &record.start {
            match system.file.names.get(given) {
                Some(Meaning::State(state)) => start[state] = Some(*value),
                _ => {
                    let states = system.file.states.iter().map(|state| &*state.name);
                    let states: Vec<&str> = states.collect();
                    return Err(FitError::Request(format!(
                        "{name}: there is no state `{given}`; the states are {}",
                        states.join(", ")
                    )));
                }
            }
        }
        let is_fitted = |kind: Kind| local.iter().any(|(known, _)| *known == kind);
        for (k, state) in system.file.states.iter().enumerate() {
            if start[k].is_none() && state.start.is_none() && !is_fitted(Kind::State(k)) {
                let state = &state.name;
                return Err(FitError::Request(format!(
                    "{name}: the start has no value of `{state}`; add [start] to the file, set \
                     it, or fit it"
                )));
            }
        }
        let t_start = record.t_start;
        let begins = t_start.unwrap_or(system.built.t_start);
        if first < begins {
            return Err(FitError::BeforeStart {
                record: name,
                first,
                start: begins,
            });
        }
        if let Some(table) = system.covered()
            && (begins < table.0 || last > table.1)
        {
            return Err(FitError::OutsideTable {
                record: name,
                span: (begins, last),
                table,
            });
        }
        let free = system.free_starts(&parameters)?;
        let extra = local
            .iter()
            .filter(
                |(kind, _)| matches!(kind, Kind::Parameter(number) if *number >= own_parameters),
            )
            .count();
        let mut by: Vec<Variable> = (0..parameters.len() - extra)
            .map(|k| Variable::Start(system.states() + k))
            .collect();
        for (state, given) in start.iter().enumerate() {
            let depends = !parameters.is_empty() && given.is_none();
            let has_formula = free.states.get(state).is_some_and(|tape| tape.is_some());
            let is_discrete = system.dynamics().is_discrete(state);
            if is_fitted(Kind::State(state)) || depends && has_formula && !is_discrete {
                by.push(Variable::Start(state));
            }
        }
        let depends = !parameters.is_empty() && t_start.is_none() && free.time.is_some();
        if is_fitted(Kind::StartTime) || depends {
            by.push(Variable::StartTime);
        }
        let observed = self.request.observables.iter();
        let observed = observed.map(|one| system.observed(&one.formula, &parameters));
        let instance = Instance {
            dynamics: system.with_states_of(&parameters)?,
            observed: observed.collect::<Result<_, _>>()?,
            name,
            times: record.times.clone(),
            columns: record.columns.clone(),
            t_start,
            start,
            free,
            local,
            parameters,
            by,
            system,
            options: self.request.options,
        };
        instance.check_discrete()
    }

    pub(super) fn start(&self) -> Vector {
        Vector::from_iterator(self.sought.len(), self.sought.iter().map(|one| one.start))
    }

    pub(super) fn bounds(&self) -> Vec<(f64, f64)> {
        self.sought.iter().map(|one| one.bounds).collect()
    }

    pub(super) fn name(&self, number: usize) -> &str {
        self.sought.get(number).map_or("", |one| &one.name)
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

    /// Whether two minima are one.
    pub(super) fn is_same(&self, one: &Vector, other: &Vector) -> bool {
        let pairs = one.iter().zip(other).zip(&self.sought);
        pairs.into_iter().all(|((a, b), sought)| {
            let width = sought.bounds.1 - sought.bounds.0;
            let scale = if width.is_finite() {
                width
            } else {
                a.abs().max(1.0)
            };
            (a - b).abs() <= super::SAME_MINIMUM * scale
        })
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
                name: self.name(number).to_owned(),
            }),
            None => Ok(()),
        }
    }

    /// The best of `count` starts that fill the bounds evenly, and the given one, by rising cost.
    pub(super) fn best_starts(
        &self,
        given: &Vector,
        count: usize,
        best: usize,
    ) -> Result<Vec<Vector>, FitError> {
        for one in &self.sought {
            if !(one.bounds.1 - one.bounds.0).is_finite() {
                return Err(FitError::Request(format!(
                    "`{}` has no bounds to search within: give both, as in {}=0..1",
                    one.name, one.name
                )));
            }
        }
        let place = |k: usize| {
            let parts = self.sought.iter().enumerate().map(|(i, one)| {
                let (low, high) = one.bounds;
                low + (high - low) * halton(k + 1, i)
            });
            Vector::from_iterator(self.sought.len(), parts)
        };
        let starts: Vec<Vector> = std::iter::once(given.clone())
            .chain((0..count).map(place))
            .collect();
        let costs: Vec<Option<f64>> = starts
            .par_iter()
            .map(|x| self.cost(x).filter(|cost| cost.is_finite()))
            .collect();
        self.check_interrupt()?;
        let mut rated: Vec<(f64, Vector)> = costs
            .into_iter()
            .zip(starts)
            .filter_map(|(cost, x)| Some((cost?, x)))
            .collect();
        // A stable sort: equal ones stay in order.
        rated.sort_by(|one, other| one.0.total_cmp(&other.0));
        rated.truncate(best);
        match rated.is_empty() {
            true => Err(FitError::NoStart { count: count + 1 }),
            false => Ok(rated.into_iter().map(|(_, x)| x).collect()),
        }
    }

    /// The cost at a point, if its runs reach the data and have derivatives.
    pub(super) fn cost(&self, x: &Vector) -> Option<f64> {
        let at = self.modelled(x).ok().filter(|at| at.lost.is_none())?;
        let loss = self.request.loss;
        Some(at.residuals.iter().map(|r| loss.of(*r).0).sum())
    }

    pub(super) fn failed(&self, error: Failed) -> FitError {
        let name = |record: usize| self.records[record].name.clone();
        match error {
            Failed::Run(record, cause) => FitError::Start {
                record: name(record),
                cause,
            },
            Failed::Ends(record, t) => FitError::Ends {
                record: name(record),
                t,
            },
        }
    }

    pub(super) fn residuals(&self, x: &Vector) -> Result<Residuals<Sequence>, Failed> {
        let at = self.modelled(x)?;
        let modes = |phases: &Vec<(f64, f64, Modes)>| phases.iter().map(|one| one.2).collect();
        Ok(Residuals {
            values: at.residuals,
            jacobian: at.jacobian,
            piece: at.phases.iter().map(modes).collect(),
        })
    }

    /// Everything at a point.
    pub(super) fn modelled(&self, x: &Vector) -> Result<Modelled, Failed> {
        let runs: Vec<Result<RecordAt, Failed>> = self
            .records
            .par_iter()
            .enumerate()
            .map(|(k, record)| record.at(k, x, self.sought.len()))
            .collect();
        let mut all = Modelled {
            values: Vec::new(),
            residuals: Vector::zeros(0),
            jacobian: Matrix::zeros(0, 0),
            phases: Vec::new(),
            lost: None,
        };
        let (mut residuals, mut slopes) = (Vec::new(), Vec::new());
        let mut ends = Vec::new();
        for ((number, run), record) in runs.into_iter().enumerate().zip(&self.records) {
            let run = run?;
            self.add_rows(record, &run, &mut residuals, &mut slopes);
            ends.push(run.end);
            all.values.push(run.values);
            all.phases.push(run.phases);
            if let Some(lost) = run.lost {
                all.lost.get_or_insert((number, lost));
            }
        }
        for &(before, first) in &self.joins {
            let (end, by_local) = &ends[before];
            let local = &self.records[before].local;
            for (state, scale) in self.spreads.iter().enumerate() {
                let weight = self.weight / scale;
                residuals.push(weight * (end[state] - x[first + state]));
                let mut row = vec![0.0; self.sought.len()];
                for (column, &(_, place)) in local.iter().enumerate() {
                    row[place] = weight * by_local[(state, column)];
                }
                row[first + state] -= weight;
                slopes.extend(row);
            }
        }
        let rows = residuals.len();
        all.residuals = Vector::from_vec(residuals);
        all.jacobian = Matrix::from_row_slice(rows, self.sought.len(), &slopes);
        Ok(all)
    }

    /// Sets the deviations that are not given to those of the residuals, and returns the largest
    /// relative change. Their order of size is kept where residuals are rounding.
    pub(super) fn estimate_sigmas(&mut self, at: &LeastSquares<Sequence>) -> Result<f64, FitError> {
        let modelled = self.modelled(&at.x).map_err(|error| self.failed(error))?;
        let is_robust = self.request.loss != Loss::Squares;
        let mut largest: f64 = 0.0;
        let part = self.part_of_freedom(at.at.values.len());
        for (k, observable) in self.request.observables.iter().enumerate() {
            if observable.sigma.is_some() {
                continue;
            }
            let residuals = self.residuals_of(&modelled, k);
            let scale = spread(residuals.iter().map(|(_, data)| *data));
            // Below the error of the runs, residuals are no noise.
            let least = self.request.options.rtol * scale;
            let mut sizes: Vec<f64> = residuals.iter().map(|(off, _)| off.abs()).collect();
            let sigma = if is_robust {
                sizes.sort_by(f64::total_cmp);
                let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
                // The median of the size of a normal deviate is 0.6745.
                median / 0.6745 / part.sqrt()
            } else {
                let squares: f64 = sizes.iter().map(|off| off * off).sum();
                (squares / sizes.len().max(1) as f64 / part).sqrt()
            };
            let sigma = sigma.max(least);
            let known = &mut self.sigmas[k];
            largest = largest.max((sigma - *known).abs() / sigma);
            *known = sigma;
        }
        Ok(largest)
    }

    /// Number of residuals that are mismatches of parts.
    fn mismatches(&self) -> usize {
        self.joins.len() * self.spreads.len()
    }

    /// Degrees of freedom over number of values, of so many residuals.
    fn part_of_freedom(&self, residuals: usize) -> f64 {
        let freedom = residuals.saturating_sub(self.sought.len()).max(1) as f64;
        freedom / residuals.saturating_sub(self.mismatches()).max(1) as f64
    }

    /// The largest mismatch of parts at a point, over the spread of the state.
    pub(super) fn largest_mismatch(&self, at: &LeastSquares<Sequence>) -> f64 {
        let residuals = at.at.values.as_slice();
        let from = residuals.len().saturating_sub(self.mismatches());
        let sizes = residuals.iter().skip(from).map(|r| r.abs() / self.weight);
        sizes.fold(0.0, f64::max)
    }

    /// Half the sum of squares of the data alone.
    pub(super) fn cost_of_data(&self, at: &LeastSquares<Sequence>) -> f64 {
        let residuals = at.at.values.as_slice();
        let count = residuals.len().saturating_sub(self.mismatches());
        residuals.iter().take(count).map(|r| 0.5 * r * r).sum()
    }

    /// Whether this is a problem of parts.
    pub(super) fn is_in_parts(&self) -> bool {
        !self.joins.is_empty()
    }

    /// Residuals and data of an observable in all records.
    fn residuals_of(&self, at: &Modelled, observable: usize) -> Vec<(f64, f64)> {
        let records = self.records.iter().zip(&at.values);
        let pairs = records.flat_map(|(record, values)| {
            let data = record.columns[observable].iter();
            data.zip(&values[observable])
        });
        pairs
            .filter(|(data, _)| !data.is_nan())
            .map(|(data, model)| (data - model, *data))
            .collect()
    }

    /// What was modelled in parts, by records.
    fn joined(&self, at: Modelled) -> Modelled {
        if !self.is_in_parts() {
            return at;
        }
        let (mut values, mut phases): (Vec<Vec<Vec<f64>>>, Vec<Vec<_>>) = Default::default();
        let parts = at.values.into_iter().zip(at.phases).enumerate();
        for (number, (columns, of_part)) in parts {
            let goes_on = self.joins.iter().any(|(before, _)| before + 1 == number);
            match (values.last_mut(), phases.last_mut()) {
                (Some(known), Some(whole)) if goes_on => {
                    for (known, column) in known.iter_mut().zip(columns) {
                        known.extend(column);
                    }
                    whole.extend(of_part);
                }
                _ => {
                    values.push(columns);
                    phases.push(of_part);
                }
            }
        }
        Modelled {
            values,
            phases,
            ..at
        }
    }

    pub(super) fn result(
        &self,
        best: LeastSquares<Sequence>,
        uncertainty: Uncertainty,
        others: Vec<OtherMinimum>,
    ) -> Result<Fit, FitError> {
        let parts = self.modelled(&best.x).map_err(|error| self.failed(error))?;
        let at = self.joined(parts);
        let mut columns = Vec::new();
        for (number, (record, values)) in self.request.records.iter().zip(&at.values).enumerate() {
            for (k, (data, model)) in record.columns.iter().zip(values).enumerate() {
                let pairs = data.iter().zip(model);
                let residuals: Vec<f64> = pairs.map(|(data, model)| data - model).collect();
                let known: Vec<f64> = residuals.iter().copied().filter(|r| !r.is_nan()).collect();
                let squares: f64 = known.iter().map(|r| r * r).sum();
                let rms = (squares / known.len().max(1) as f64).sqrt();
                let scale = model
                    .iter()
                    .fold(0.0, |most: f64, value| most.max(value.abs()));
                // The signs of the errors of runs say nothing.
                let is_rounding = rms <= 1e3 * self.request.options.rtol * scale;
                columns.push(FittedColumn {
                    record: number,
                    observable: k,
                    model: model.clone(),
                    runs: runs_test(&known).filter(|_| !is_rounding),
                    residuals,
                    count: known.len(),
                    rms,
                    sigma: self.sigmas[k],
                });
            }
        }
        // The starts of parts are no results.
        let named = self.sought.iter().filter(|one| !one.name.is_empty());
        let values = named.enumerate().map(|(k, one)| {
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
        Ok(Fit {
            values: values.collect(),
            columns,
            phases: at.phases,
            times: {
                let records = self.request.records.iter();
                records.map(|record| record.times.clone()).collect()
            },
            cost: match self.is_in_parts() {
                true => self.cost_of_data(&best),
                false => best.cost,
            },
            mismatch: self.is_in_parts().then(|| self.largest_mismatch(&best)),
            freedom: best.at.values.len() - self.sought.len(),
            end: best.end,
            steps: best.steps,
            evaluations: best.evaluations,
            failures: best.failures,
            crossings: best.crossings,
            jumps: best.jumps,
            others,
            uncertainty,
        })
    }
}

/// One record at a point.
struct RecordAt {
    values: Vec<Vec<f64>>,
    /// For each column and time, derivatives by everything that is sought.
    slopes: Vec<Vec<Vec<f64>>>,
    phases: Vec<(f64, f64, Modes)>,
    lost: Option<Error>,
    /// States at the times.
    points: Vec<Vector>,
    /// The state at the last time, and its derivatives by what is sought here.
    end: (Vector, Matrix),
}

impl Instance {
    /// A formula of the parameters, with its derivative by one of them.
    fn of_parameters(&self, tape: &Tape, parameters: &[f64], by: Kind) -> Dual<f64> {
        let mut all = vec![Dual::constant(0.0); self.system.states()];
        all.extend(self.parameters.iter().zip(parameters).map(|(k, value)| {
            let slope = if by == Kind::Parameter(*k) { 1.0 } else { 0.0 };
            Dual::new(*value, slope)
        }));
        // Starts have no inputs, but tapes have room for them.
        let inputs = self.system.file.inputs.len();
        all.resize(all.len() + HELD_PER_INPUT * inputs, Dual::constant(0.0));
        let mut out = [Dual::constant(0.0)];
        tape.evaluate(Dual::constant(0.0), &all, &mut out);
        out[0]
    }

    /// Refuses a discrete state whose start depends on what is sought: no derivative has it.
    fn check_discrete(self) -> Result<Self, FitError> {
        let values = self.parameters.iter();
        let values: Vec<f64> = values.map(|&k| self.system.values[k]).collect();
        for (k, state) in self.system.file.states.iter().enumerate() {
            let Some(tape) = self.free.states[k].as_ref().filter(|_| state.is_discrete) else {
                continue;
            };
            let depends = |&&parameter: &&usize| {
                let by = Kind::Parameter(parameter);
                self.start[k].is_none() && self.of_parameters(tape, &values, by).eps != 0.0
            };
            if let Some(&parameter) = self.parameters.iter().find(depends) {
                return Err(FitError::Request(format!(
                    "the start of the discrete state `{}` depends on `{}`, by which the run then \
                     has no derivative: set the start to a number",
                    state.name, self.system.file.parameters[parameter].name
                )));
            }
        }
        Ok(self)
    }

    fn at(&self, number: usize, x: &Vector, sought: usize) -> Result<RecordAt, Failed> {
        let of = |kind: Kind| {
            let mut found = self.local.iter().filter(|(known, _)| *known == kind);
            found.next().map(|&(_, place)| x[place])
        };
        let parameters = self.parameters.iter();
        let parameters: Vec<f64> = parameters
            .map(|&k| of(Kind::Parameter(k)).unwrap_or(self.system.values[k]))
            .collect();
        let states = self.system.states();
        // Starts, and their derivatives by the unknowns of this record.
        let on_tape = |tape: &Tape, by: Kind| self.of_parameters(tape, &parameters, by);
        let state = |state: usize, by: Kind| -> (f64, f64) {
            let own = Kind::State(state);
            match (of(own), self.start[state], &self.free.states[state]) {
                (Some(value), ..) => (value, if by == own { 1.0 } else { 0.0 }),
                (None, Some(value), _) => (value, 0.0),
                (None, None, Some(tape)) => {
                    let value = on_tape(tape, by);
                    (value.re, value.eps)
                }
                (None, None, None) => (f64::NAN, 0.0),
            }
        };
        let time = |by: Kind| -> (f64, f64) {
            match (of(Kind::StartTime), self.t_start, &self.free.time) {
                (Some(value), ..) => (value, if by == Kind::StartTime { 1.0 } else { 0.0 }),
                (None, Some(value), _) => (value, 0.0),
                (None, None, Some(tape)) => {
                    let value = on_tape(tape, by);
                    (value.re, value.eps)
                }
                (None, None, None) => (self.system.built.t_start, 0.0),
            }
        };
        // Derivatives of what the orbit depends on, by the unknowns.
        let weights = Matrix::from_fn(self.by.len(), self.local.len(), |row, column| {
            let by = self.local[column].0;
            match self.by[row] {
                Variable::Start(k) if k < states => state(k, by).1,
                Variable::Start(k) => {
                    let own = Kind::Parameter(self.parameters[k - states]);
                    if own == by { 1.0 } else { 0.0 }
                }
                Variable::StartTime => time(by).1,
            }
        });
        let none = Kind::Parameter(usize::MAX);
        let start = (0..states).map(|k| state(k, none).0);
        let start: Vec<f64> = start.chain(parameters.iter().copied()).collect();
        let t_start = time(none).0;
        let last = self.times.last().copied().unwrap_or(t_start);
        let run = orbit_derivatives(
            &self.dynamics,
            t_start,
            Vector::from_vec(start),
            // A run needs a length, also where all values are at its start.
            last.max(t_start + f64::EPSILON * t_start.abs().max(1.0)),
            (&self.by, &self.times),
            &[],
            &self.options,
        );
        let run = run.map_err(|error| Failed::Run(number, error))?;
        let mut at = RecordAt {
            values: vec![Vec::with_capacity(self.times.len()); self.observed.len()],
            slopes: vec![Vec::with_capacity(self.times.len()); self.observed.len()],
            phases: run.phases,
            lost: run.lost,
            points: Vec::with_capacity(self.times.len()),
            end: (Vector::zeros(0), Matrix::zeros(0, 0)),
        };
        for ((t, point), slopes) in self.times.iter().zip(&run.points).zip(&run.states) {
            if point.iter().any(|x| x.is_nan()) {
                return Err(match at.lost {
                    Some(error) => Failed::Run(number, error),
                    None => Failed::Ends(number, *t),
                });
            }
            let slopes = slopes.rows(0, states) * &weights;
            for (k, observed) in self.observed.iter().enumerate() {
                let mut row = vec![0.0; sought];
                let mut value = f64::NAN;
                for (column, &(by, place)) in self.local.iter().enumerate() {
                    let dual = |(i, x): (usize, &f64)| {
                        let slope = match i.checked_sub(states) {
                            None => slopes[(i, column)],
                            Some(k) if by == Kind::Parameter(self.parameters[k]) => 1.0,
                            Some(_) => 0.0,
                        };
                        Dual::new(*x, slope)
                    };
                    let seeded: Vec<Dual<f64>> = point.iter().enumerate().map(dual).collect();
                    let of = observed.value(*t, &seeded);
                    (value, row[place]) = (of.re, of.eps);
                }
                at.values[k].push(value);
                at.slopes[k].push(row);
            }
            let states = point.rows(0, states).into_owned();
            at.points.push(states.clone());
            at.end = (states, slopes);
        }
        Ok(at)
    }
}
