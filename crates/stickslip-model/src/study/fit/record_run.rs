//! One record ready to run, and its run at a point.

use stickslip::analysis::{EventDerivatives, OrbitDerivatives, Variable};
use stickslip::dynamics::{DynamicsRef, Matrix, Modes, Vector};
use stickslip::scalar::Dual;
use stickslip::{Error, Options, Scalar};

use super::unknowns::{Kind, Local};
use super::{FitError, FitRequest, Record};
use crate::expression::Tape;
use crate::file::{FreeStarts, Meaning, Observed, System};

/// Reason for which the residuals of a record could not be computed.
pub(super) enum Failed {
    /// The run fails: number of the record, and why.
    Run(usize, Error),
    /// The run ends before this time.
    Ends(usize, f64),
}

/// A record ready to run.
pub(super) struct RecordRun {
    pub(super) name: String,
    pub(super) system: System,
    options: Options,
    dynamics: DynamicsRef<'static>,
    pub(super) observed: Vec<Observed>,
    pub(super) times: Vec<f64>,
    pub(super) columns: Vec<Vec<f64>>,
    /// Starts as far as they are fixed.
    t_start: Option<f64>,
    start: Vec<Option<f64>>,
    free: FreeStarts,
    /// Numbers that are sought here.
    pub(super) local: Local,
    /// Parameters that are states behind those of the system.
    parameters: Vec<usize>,
    /// Variables by which the orbit is differentiated.
    by: Vec<Variable>,
}

/// An event at which observables jump.
#[derive(Clone, Debug)]
pub(super) struct ObservedJump {
    pub(super) t: f64,
    /// Number of the jump, counted from 0.
    pub(super) number: Option<usize>,
    /// Derivatives of its time by everything that is sought.
    pub(super) slopes: Vec<f64>,
    /// Change of each observable.
    pub(super) changes: Vec<f64>,
}

/// One record at a point.
pub(super) struct RecordAt {
    pub(super) values: Vec<Vec<f64>>,
    /// Sizes of what the state contributes to the values: without an offset, which has no error.
    pub(super) sizes: Vec<Vec<f64>>,
    /// Derivatives by everything that is sought, for each column and time.
    pub(super) slopes: Vec<Vec<Vec<f64>>>,
    pub(super) phases: Vec<(f64, f64, Modes)>,
    pub(super) lost: Option<Error>,
    /// Events at which an observable jumps.
    pub(super) jumps: Vec<ObservedJump>,
    /// States at the times.
    pub(super) points: Vec<Vector>,
    /// The state at the last time, and its derivatives by what is sought here.
    pub(super) end: (Vector, Matrix),
}

impl RecordRun {
    pub(super) fn new(
        request: &FitRequest,
        system: System,
        record: &Record,
        local: Local,
    ) -> Result<Self, FitError> {
        check_columns(request, record)?;
        let own_parameters = request.file.parameters.len();
        let name = record.name.clone();
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
        check_span(record, &system)?;
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
        let observed = request.observables.iter();
        let observed = observed.map(|one| system.observed(&one.formula, &parameters));
        let run = RecordRun {
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
            options: request.options,
        };
        run.check_discrete()
    }

    /// The start as far as it is fixed, and the last time of the data.
    pub(super) fn span(&self) -> [f64; 2] {
        let start = self.t_start.unwrap_or(self.system.built.t_start);
        [start, self.times.last().copied().unwrap_or(start)]
    }

    /// A formula of the parameters, with its derivative by an unknown.
    fn of_parameters(&self, tape: &Tape, values: &[f64], by: Kind) -> Dual<f64> {
        let by = match by {
            Kind::Parameter(number) => Some(number),
            Kind::State(_) | Kind::StartTime => None,
        };
        self.system
            .of_parameters(tape, (&self.parameters, values), by)
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

    /// The record at a point, with derivatives by all `sought` unknowns. The run goes beyond the
    /// last time by that between two times, if wanted.
    pub(super) fn at(
        &self,
        number: usize,
        x: &Vector,
        (sought, is_beyond): (usize, bool),
    ) -> Result<RecordAt, Failed> {
        let of = |kind: Kind| {
            let mut found = self.local.iter().filter(|(known, _)| *known == kind);
            found.next().map(|&(_, place)| x[place])
        };
        let parameters = self.parameters.iter();
        let parameters: Vec<f64> = parameters
            .map(|&k| of(Kind::Parameter(k)).unwrap_or(self.system.values[k]))
            .collect();
        let states = self.system.states();
        // What the run begins with, and its derivative by an unknown of this record.
        let begins = |own: Kind, fixed: Option<f64>, tape: &Option<Tape>, by: Kind| match (
            of(own),
            fixed,
            tape,
        ) {
            (Some(value), ..) => Dual::new(value, if by == own { 1.0 } else { 0.0 }),
            (None, Some(value), _) => Dual::constant(value),
            (None, None, Some(tape)) => self.of_parameters(tape, &parameters, by),
            (None, None, None) if own == Kind::StartTime => {
                Dual::constant(self.system.built.t_start)
            }
            (None, None, None) => Dual::constant(f64::NAN),
        };
        let state = |k: usize, by| begins(Kind::State(k), self.start[k], &self.free.states[k], by);
        let time = |by| begins(Kind::StartTime, self.t_start, &self.free.time, by);
        // Derivatives of what the orbit depends on, by the unknowns.
        let weights = Matrix::from_fn(self.by.len(), self.local.len(), |row, column| {
            let by = self.local[column].0;
            match self.by[row] {
                Variable::Start(k) if k < states => state(k, by).eps,
                Variable::Start(k) => {
                    let own = Kind::Parameter(self.parameters[k - states]);
                    if own == by { 1.0 } else { 0.0 }
                }
                Variable::StartTime => time(by).eps,
            }
        });
        let none = Kind::Parameter(usize::MAX);
        let start = (0..states).map(|k| state(k, none).re);
        let start: Vec<f64> = start.chain(parameters.iter().copied()).collect();
        let t_start = time(none).re;
        let last = self.times.last().copied().unwrap_or(t_start);
        let mut times = self.times.clone();
        if is_beyond {
            times.push(last + (last - t_start) / self.times.len().max(1) as f64);
        }
        let last = times.last().copied().unwrap_or(t_start);
        let run = OrbitDerivatives::of(
            &self.dynamics,
            t_start,
            Vector::from_vec(start),
            // A run needs a length, also where all values are at its start.
            last.max(t_start + f64::EPSILON * t_start.abs().max(1.0)),
            (&self.by, &times),
            &[],
            &self.options,
        );
        let run = run.map_err(|error| Failed::Run(number, error))?;
        let mut at = RecordAt {
            values: vec![Vec::with_capacity(self.times.len()); self.observed.len()],
            sizes: vec![Vec::with_capacity(self.times.len()); self.observed.len()],
            slopes: vec![Vec::with_capacity(self.times.len()); self.observed.len()],
            jumps: self.jumps((&run.transitions, &run.phases), &weights, sought),
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
            let modes = mode_at(&at.phases, *t, Place::Behind);
            for (k, observed) in self.observed.iter().enumerate() {
                let (value, row) =
                    self.observation(observed, (*t, modes), (point, &slopes), sought);
                let sizes = (0..states).map(|state| {
                    let seeded = point.iter().enumerate();
                    let seed = |i: usize| f64::from(u8::from(i == state));
                    let seeded = seeded.map(|(i, x)| Dual::new(*x, seed(i)));
                    let seeded: Vec<Dual<f64>> = seeded.collect();
                    (observed.value(modes, *t, &seeded).eps * point[state]).abs()
                });
                at.sizes[k].push(sizes.sum());
                at.values[k].push(value);
                at.slopes[k].push(row);
            }
            let states = point.rows(0, states).into_owned();
            at.points.push(states.clone());
            at.end = (states, slopes);
        }
        Ok(at)
    }

    /// The events at which an observable jumps. `weights` are derivatives of what the orbit depends
    /// on, by the unknowns of this record.
    fn jumps(
        &self,
        (events, phases): (&[EventDerivatives], &[(f64, f64, Modes)]),
        weights: &Matrix,
        sought: usize,
    ) -> Vec<ObservedJump> {
        let none = Matrix::zeros(self.system.states(), self.local.len());
        let jump = |event: &EventDerivatives| {
            let changes = self.observed.iter().map(|observed| {
                let value = |(point, place): (&Vector, Place)| {
                    let at = (event.at, mode_at(phases, event.at, place));
                    self.observation(observed, at, (point, &none), sought).0
                };
                let [before, after] = &event.points;
                let [before, after] = [(before, Place::Before), (after, Place::Behind)].map(value);
                let change = after - before;
                // A force goes on where a contact slips off at its limit.
                let goes_on = change.abs() <= SAME * before.abs().max(after.abs());
                if observed.has_force() && goes_on {
                    0.0
                } else {
                    change
                }
            });
            let changes: Vec<f64> = changes.collect();
            if changes.iter().all(|change| *change == 0.0) {
                return None;
            }
            let mut slopes = vec![0.0; sought];
            for (column, &(_, place)) in self.local.iter().enumerate() {
                let parts = event.t.iter().enumerate();
                let parts = parts.map(|(row, slope)| slope * weights[(row, column)]);
                slopes[place] = parts.sum();
            }
            let t = event.at;
            let ended = phases.iter().find(|phase| phase.1 == t);
            Some(ObservedJump {
                t,
                number: ended.and_then(|phase| phase.2.jump()),
                slopes,
                changes,
            })
        };
        let mut found: Vec<ObservedJump> = Vec::new();
        for jump in events.iter().filter_map(jump) {
            // Jumps at one instant are passed together.
            match found.last_mut().filter(|last| last.t == jump.t) {
                Some(last) => {
                    let changes = last.changes.iter_mut().zip(&jump.changes);
                    changes.for_each(|(all, change)| *all += change);
                }
                None => found.push(jump),
            }
        }
        found
    }

    /// An observable at a point of the orbit, and its derivatives by all `sought` unknowns.
    fn observation(
        &self,
        observed: &Observed,
        (t, modes): (f64, Modes),
        (point, slopes): (&Vector, &Matrix),
        sought: usize,
    ) -> (f64, Vec<f64>) {
        let states = self.system.states();
        let (mut value, mut row) = (f64::NAN, vec![0.0; sought]);
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
            let of = observed.value(modes, t, &seeded);
            (value, row[place]) = (of.re, of.eps);
        }
        (value, row)
    }
}

/// Change of a friction force at an event that counts as none, as a part of its size: location of
/// the event leaves it. Chosen: half of the digits of a double.
const SAME: f64 = 1e-8;

/// Side of an instant at which an event may stand.
#[derive(Clone, Copy)]
pub(super) enum Place {
    Before,
    Behind,
}

/// The modes at a time, from the phases.
pub(super) fn mode_at(phases: &[(f64, f64, Modes)], t: f64, place: Place) -> Modes {
    let mut lasting = phases.iter().filter(|phase| phase.0 < phase.1);
    let found = match place {
        Place::Before => lasting.find(|phase| t <= phase.1),
        Place::Behind => lasting.rev().find(|phase| phase.0 <= t),
    };
    let phase = found.or_else(|| phases.first());
    phase.map_or_else(|| Modes::new(&[]), |phase| phase.2)
}

/// Refuses times and columns that do not belong together.
fn check_columns(request: &FitRequest, record: &Record) -> Result<(), FitError> {
    let name = &record.name;
    let is_wrong = |k: &usize| {
        let (before, now) = (record.times.get(k.wrapping_sub(1)), record.times[*k]);
        !now.is_finite() || before.is_some_and(|before| *before >= now)
    };
    if let Some(row) = (0..record.times.len()).find(is_wrong) {
        return Err(FitError::Times {
            record: name.clone(),
            row: row + 1,
            time: record.times[row],
        });
    }
    let mut columns = record.columns.iter();
    if record.columns.len() != request.observables.len()
        || columns.any(|of| of.len() != record.times.len())
    {
        return Err(FitError::Request(format!(
            "{name}: each observable needs a column with a value for each time"
        )));
    }
    let values = record.columns.iter().flatten();
    match values.into_iter().find(|value| value.is_infinite()) {
        Some(value) => Err(FitError::Request(format!(
            "{name}: a value is {value}; leave the cell empty where nothing was measured"
        ))),
        None => Ok(()),
    }
}

/// Refuses times before the start, and outside the tables of inputs.
fn check_span(record: &Record, system: &System) -> Result<(), FitError> {
    let (Some(&first), Some(&last)) = (record.times.first(), record.times.last()) else {
        return Err(FitError::NoData);
    };
    let start = record.t_start.unwrap_or(system.built.t_start);
    if first < start {
        return Err(FitError::BeforeStart {
            record: record.name.clone(),
            first,
            start,
        });
    }
    match system.covered() {
        Some(table) if start < table.0 || last > table.1 => Err(FitError::OutsideTable {
            record: record.name.clone(),
            span: (start, last),
            table,
        }),
        _ => Ok(()),
    }
}
