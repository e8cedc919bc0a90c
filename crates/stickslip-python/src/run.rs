//! An orbit, its events and its dense output.

use std::ops::ControlFlow;
use std::time::Instant;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{EventDerivatives, OrbitDerivatives};
use stickslip::dynamics::{
    Matrix, Modes, Moment, OrbitProgress, OrbitUnderWay, Passage, Phase, RunMemory, Solution, Step,
    Summary, Transition, Vector,
};
use stickslip::{Ending, Error, Options};
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::kernel::follow_on;
use stickslip_model::study::{DerivativeError, FrictionWatch, StepMonitor, Variables};

use crate::errors::{Keywords, failed, words};
use crate::fields::{Fields, array};
use crate::task::{Report, SIGNAL_INTERVAL, check_signals};
use crate::{Settings, System};

/// Checks for signals, such as Ctrl-C, at intervals, and reports the progress of the run.
struct Signals {
    last: Instant,
    raised: Option<PyErr>,
    report: Report,
}

impl Signals {
    fn new(report: Report) -> Self {
        Signals {
            last: Instant::now(),
            raised: None,
            report,
        }
    }

    fn check_signals(&mut self, t: f64) -> ControlFlow<()> {
        if self.raised.is_some() {
            return ControlFlow::Break(());
        }
        if self.last.elapsed() < SIGNAL_INTERVAL {
            return ControlFlow::Continue(());
        }
        self.last = Instant::now();
        match check_signals(&self.report, t) {
            Ok(()) => ControlFlow::Continue(()),
            Err(raised) => {
                self.raised = Some(raised);
                ControlFlow::Break(())
            }
        }
    }
}

/// Passages of one event.
struct Passages {
    found: Vec<Passage>,
    /// Number of passages after which the run ends.
    most: usize,
}

impl Passages {
    fn new(most: usize) -> Self {
        let found = Vec::new();
        Passages { found, most }
    }

    /// Keeps a passage before the limit. The one that ends the run becomes the limit.
    fn passed(&mut self, at: Passage, limit: &mut f64) -> ControlFlow<()> {
        let t = at.t;
        if t > *limit {
            return ControlFlow::Break(());
        }
        self.found.push(at);
        if self.found.len() == self.most {
            *limit = t;
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    /// The passage that ends the run.
    fn terminal(&self) -> Option<&Passage> {
        let last = self.found.last();
        last.filter(|_| self.found.len() == self.most)
    }
}

/// Recording of an orbit for Python.
struct Recording<'a> {
    /// Passages of each event.
    events: Vec<Passages>,
    /// The run ends at this time.
    limit: f64,
    signals: &'a mut Signals,
    friction: FrictionWatch<'a>,
    monitor: StepMonitor,
    /// What looks wrong with the steps so far.
    doubtful: Vec<String>,
    /// Points at ends of steps, or at the requested times.
    points: Vec<(f64, Vector)>,
    /// Whether times are requested.
    has_requested: bool,
    /// Requested times that are not yet reached, the next one last.
    requested: Option<Vec<f64>>,
    phases: Vec<Phase>,
    /// Transitions, each with the state after it.
    transitions: Vec<(Transition, Vector)>,
    /// Steps with their solutions, if dense output is requested.
    steps: Option<Vec<(Step, Solution)>>,
    last: (f64, Vector),
}

impl Recording<'_> {
    fn watch(&mut self, progress: OrbitProgress, orbit: &mut dyn OrbitUnderWay) -> ControlFlow<()> {
        if !matches!(progress, OrbitProgress::Step | OrbitProgress::Passage(_)) {
            self.monitor.begin_anew();
        }
        match progress {
            OrbitProgress::Step => return self.step(orbit),
            OrbitProgress::Passage(at) => {
                return self.events[at.number].passed(at, &mut self.limit);
            }
            OrbitProgress::PhaseEnd(phase) => self.phases.push(phase),
            OrbitProgress::Transition(at) if at.t <= self.limit => {
                let after = Vector::from_column_slice(orbit.x());
                self.transitions.push((at, after));
            }
            _ => {}
        }
        ControlFlow::Continue(())
    }

    fn step(&mut self, orbit: &mut dyn OrbitUnderWay) -> ControlFlow<()> {
        let step = orbit.last_step();
        let decision = match step.t_start > self.limit {
            true => ControlFlow::Break(()),
            false => self.signals.check_signals(step.t_end),
        };
        if decision.is_continue() {
            self.points_of(&step, orbit);
            self.friction.step(orbit);
            self.doubtful.extend(self.monitor.step(&step, &Keywords));
            self.last = (step.t_end, step.x_end.clone());
        }
        if let Some(steps) = &mut self.steps {
            steps.push((step, orbit.solution()));
        }
        decision
    }

    /// Records the points in a step.
    fn points_of(&mut self, step: &Step, orbit: &mut dyn OrbitUnderWay) {
        match &mut self.requested {
            Some(requested) => {
                let mut solution = None;
                while let Some(t) = requested.pop_if(|t| *t <= step.t_end) {
                    let x = match t == step.t_end {
                        true => step.x_end.clone(),
                        false => solution.get_or_insert_with(|| orbit.solution())(t),
                    };
                    self.points.push((t, x));
                }
            }
            None => {
                // After a jump the orbit continues from another state.
                if self.last.1 != step.x_start {
                    self.points.push((step.t_start, step.x_start.clone()));
                }
                self.points.push((step.t_end, step.x_end.clone()));
            }
        }
    }

    /// Removes what lies after the event that ends the run.
    fn cut(&mut self, at: &Passage) {
        let wants_all = self.requested.is_none();
        self.transitions.retain(|(one, _)| one.t <= at.t);
        self.points.retain(|(t, _)| *t <= at.t);
        if wants_all && self.points.last().is_none_or(|(t, _)| *t < at.t) {
            self.points.push((at.t, at.x.clone()));
        }
        self.phases.retain(|phase| phase.t_start < at.t);
        if let Some(phase) = self.phases.last_mut()
            && phase.t_end > at.t
        {
            (phase.t_end, phase.x_end) = (at.t, at.x.clone());
        }
        self.last = (at.t, at.x.clone());
    }
}

/// Result of a run.
struct Solved<'a> {
    recording: Recording<'a>,
    outcome: Result<Summary, Error>,
    memory: Option<RunMemory>,
    /// Whether an event ended the run.
    is_terminated: bool,
}

/// Follows an orbit. Its system has a section for each event; `most` passages of it end the run (0
/// for never).
fn solved<'a>(
    system: &'a CompiledSystem,
    most: &[usize],
    ((t, x), t_end, options): ((f64, &[f64]), f64, &Options),
    (requested, keeps_steps, limit): (Option<Vec<f64>>, bool, f64),
    from: Option<&RunMemory>,
    signals: &'a mut Signals,
) -> Solved<'a> {
    let start = (t, Vector::from_column_slice(x));
    let at = Moment {
        t,
        x: start.1.clone(),
    };
    let mut recording = Recording {
        events: most.iter().map(|&most| Passages::new(most)).collect(),
        limit,
        signals,
        friction: FrictionWatch::new(system),
        monitor: StepMonitor::new((t, x), t_end, options),
        doubtful: Vec::new(),
        points: match requested {
            None => vec![start.clone()],
            Some(_) => Vec::new(),
        },
        has_requested: requested.is_some(),
        requested,
        phases: Vec::new(),
        transitions: Vec::new(),
        steps: keeps_steps.then(Vec::new),
        last: start,
    };
    if let Some(requested) = &mut recording.requested {
        while requested.pop_if(|time| *time == t).is_some() {
            recording.points.push(recording.last.clone());
        }
    }
    let mut watcher = |progress, orbit: &mut dyn OrbitUnderWay| recording.watch(progress, orbit);
    let sections = system.sections();
    // Without events the section of the system is not used.
    let sections = sections.get(..most.len()).unwrap_or_default();
    let dynamics = system.dynamics();
    let begun = match from {
        None => dynamics.begin(&at, t_end, options, sections),
        Some(memory) => dynamics.resume(memory, t_end, options, sections),
    };
    let mut memory = None;
    let outcome = begun.and_then(|mut orbit| {
        orbit.remember();
        let outcome = follow_on(&mut *orbit, &mut watcher);
        memory = orbit.memory();
        outcome
    });
    // A jump at the very end leads to another state.
    if let Ok(end) = &outcome
        && recording.last.1 != end.x
        && end.t == recording.last.0
    {
        let last = (end.t, end.x.clone());
        match recording.points.last_mut() {
            Some(point) if recording.has_requested && point.0 == end.t => *point = last.clone(),
            _ if !recording.has_requested => recording.points.push(last.clone()),
            _ => {}
        }
        recording.last = last;
    }
    let terminal = recording.events.iter().filter_map(Passages::terminal);
    let terminal = terminal.min_by(|a, b| a.t.total_cmp(&b.t)).cloned();
    if let Some(at) = &terminal {
        recording.cut(at);
        let found = recording.events.iter_mut().map(|event| &mut event.found);
        found.for_each(|found| found.retain(|one| one.t <= at.t));
    }
    Solved {
        recording,
        outcome,
        // An event that ends the run leaves no step that its end has shortened.
        memory: memory.filter(|_| terminal.is_none()),
        is_terminated: terminal.is_some(),
    }
}

/// Time and state of the end of a run.
#[pyfunction]
pub(crate) fn end_of(memory: &str) -> PyResult<(f64, Vec<f64>)> {
    let memory = remembered(memory)?;
    Ok((memory.t(), memory.x().iter().copied().collect()))
}

/// Follows an orbit from `t` to `t_end`, as far as `limit`.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "they are those of a call from Python"
)]
pub(crate) fn solve<'py>(
    py: Python<'py>,
    system: &System,
    start: (f64, Vec<f64>),
    until: (f64, f64),
    most: Vec<usize>,
    t_eval: Option<PyReadonlyArray1<'py, f64>>,
    dense_output: bool,
    settings: Settings,
    from: Option<&str>,
    derivatives: Vec<String>,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let (t_end, limit) = until;
    let from: Option<RunMemory> = from.map(remembered).transpose()?;
    let options = settings.options()?;
    let requested = t_eval.map(|times| times.as_array().iter().rev().copied().collect());
    let (t, x) = start;
    // An event or a jump may end the run earlier.
    let jumps = &system.compiled.file.jumps;
    if most.iter().all(|&most| most == 0) && jumps.iter().all(|jump| jump.most.is_none()) {
        let checked = options.check_span(t, t_end);
        checked.map_err(|error| failed(&error, Some(&system.compiled)))?;
    }
    let mut signals = Signals::new(report);
    let wanted = (requested, dense_output, limit);
    let compiled = &system.compiled;
    let variables = Variables::named(compiled, derivatives.iter().map(String::as_str));
    let variables = variables.map_err(|error| {
        PyValueError::new_err(format!("derivatives = {derivatives:?}: {error}"))
    })?;
    let run = ((t, &x[..]), t_end, &options);
    let solved = py.detach(|| solved(compiled, &most, run, wanted, from.as_ref(), &mut signals));
    let found = match derivatives.is_empty() {
        true => None,
        false => Some(py.detach(|| differentiated(compiled, &variables, run, most.len(), &solved))),
    };
    let fields = described(py, compiled, solved, (t, x.len()))?;
    if let Some(found) = found {
        let found = found.map_err(|error| match error {
            DerivativeError::Setting(error) => PyValueError::new_err(error.to_string()),
            DerivativeError::Run(error) => failed(&error, Some(compiled)),
            error => PyValueError::new_err(error.to_string()),
        })?;
        fields.fields(
            "derivatives",
            derivative_fields(py, compiled, &found, derivatives.len())?,
        )?;
    }
    fields.ended(signals.raised)
}

/// Derivatives of a run, as far as it was recorded.
fn differentiated(
    system: &CompiledSystem,
    variables: &Variables,
    (start, t_end, options): ((f64, &[f64]), f64, &Options),
    events: usize,
    solved: &Solved<'_>,
) -> Result<OrbitDerivatives, DerivativeError> {
    let recording = &solved.recording;
    let mut times: Vec<f64> = recording.points.iter().map(|point| point.0).collect();
    let wanted = times.len();
    // A jump that falls on the end leads to the last state.
    let last = recording.points.last().zip(recording.transitions.last());
    let is_behind = |(point, (at, after)): &(&(f64, Vector), &(Transition, Vector))| {
        point.0 == at.t && point.1 == *after && *after != at.x
    };
    let is_once = wanted < 2 || times[wanted - 2] < times[wanted - 1];
    let is_behind = is_once && last.as_ref().is_some_and(is_behind);
    if is_behind {
        times.push(times[wanted - 1]);
    }
    // Events go on behind the last requested time.
    times.extend(Some(recording.last.0).filter(|last| times.last().is_none_or(|t| t < last)));
    let sections = system.sections();
    let sections = sections.get(..events).unwrap_or_default();
    let mut found = variables.along(system, (start, t_end), (&times, sections), options)?;
    if is_behind {
        found.states.remove(wanted - 1);
    }
    found.states.truncate(wanted);
    variables.fit(
        system,
        &mut found,
        recording.transitions.iter().map(|(at, _)| at.t),
    );
    for (number, event) in recording.events.iter().enumerate() {
        let mut left = event.found.len();
        found.passages.retain(|(of, _)| {
            let is_kept = *of != number || left > 0;
            left -= usize::from(*of == number && left > 0);
            is_kept
        });
    }
    Ok(found)
}

/// Derivatives for Python.
fn derivative_fields<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    found: &OrbitDerivatives,
    variables: usize,
) -> PyResult<Fields<'py>> {
    let fields = Fields::new(py);
    let row = [system.states(), variables];
    let flat = |of: &Matrix| of.transpose().as_slice().to_vec();
    fields.array("dy", found.states.iter().flat_map(flat).collect(), row)?;
    let events = |of: &[&EventDerivatives]| -> PyResult<Fields<'py>> {
        let table = Fields::new(py);
        let all = || of.iter();
        table.array(
            "dt",
            all().flat_map(|at| at.t.clone()).collect(),
            [variables],
        )?;
        table.array(
            "dy_before",
            all().flat_map(|at| flat(&at.before)).collect(),
            row,
        )?;
        table.array("dy", all().flat_map(|at| flat(&at.after)).collect(), row)?;
        Ok(table)
    };
    let transitions: Vec<_> = found.transitions.iter().collect();
    fields.fields("transitions", events(&transitions)?)?;
    let count = found.passages.iter().map(|(number, _)| number + 1).max();
    for number in 0..count.unwrap_or(0) {
        let own = found.passages.iter().filter(|(of, _)| *of == number);
        let own: Vec<_> = own.map(|(_, event)| event).collect();
        fields.fields(&format!("event {number}"), events(&own)?)?;
    }
    fields.put("lost", found.lost.as_ref().map(|why| words(why, system)))?;
    Ok(fields)
}

/// The end of a run, from its text.
fn remembered(text: &str) -> PyResult<RunMemory> {
    serde_json::from_str(text).map_err(|error| {
        PyValueError::new_err(format!("y0 holds no end of a run that can go on: {error}"))
    })
}

/// The result of a run, for Python.
fn described<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    solved: Solved<'_>,
    (t_start, states): (f64, usize),
) -> PyResult<Fields<'py>> {
    let Solved {
        recording,
        outcome,
        memory,
        is_terminated,
    } = solved;
    let (status, message) = match &outcome {
        _ if is_terminated => (1, "A termination event occurred.".to_owned()),
        Ok(summary) => ending(summary, system),
        // An error at the start leaves no result to return.
        Err(error) if recording.last.0 == t_start => return Err(failed(error, Some(system))),
        Err(error) => (-1, words(error, system)),
    };
    let fields = Fields::new(py);
    let points = &recording.points;
    fields.numbers("t", points.iter().map(|point| point.0))?;
    fields.rows("y", points.iter().map(|point| &point.1), states)?;
    let stops = system.file.stops.len();
    if stops > 0 {
        let reactions = reactions(system, &recording)?;
        fields.array("forces", reactions, [stops])?;
    }
    let events = recording.events.iter().map(|event| {
        let found = &event.found;
        let times = PyArray1::from_iter(py, found.iter().map(|at| at.t));
        let x = found.iter().flat_map(|at| at.x.iter().copied());
        Ok((times, array(py, x.collect(), [states])?))
    });
    fields.put("events", events.collect::<PyResult<Vec<_>>>()?)?;
    let memory = memory.and_then(|memory| serde_json::to_string(&memory).ok());
    fields.put("memory", memory)?;
    fields.put("status", status)?;
    fields.put("message", message)?;
    let calls = outcome.as_ref().ok();
    fields.put("nfev", calls.map(|summary| summary.counters.field_calls))?;
    fields.put("t_end", recording.last.0)?;
    let transitions = Fields::new(py);
    let all = &recording.transitions;
    let changes = || all.iter().map(|(at, _)| at);
    transitions.numbers("t", changes().map(|at| at.t))?;
    transitions.words("kind", changes().map(|at| at.kind), |kind| kind.name())?;
    let contact = |&number: &usize| system.contact_name(number);
    transitions.words("contact", changes().map(|at| at.contact), contact)?;
    let letters = |modes: &Modes| system.letters(modes);
    transitions.words("from_mode", changes().map(|at| at.from), letters)?;
    transitions.words("to_mode", changes().map(|at| at.to), letters)?;
    transitions.rows("y_before", changes().map(|at| &at.x), states)?;
    transitions.rows("y", all.iter().map(|(_, after)| after), states)?;
    transitions.numbers("residual", changes().map(|at| at.residual))?;
    if stops > 0 {
        let impulses = |at: &Transition| system.impulses(at.contact, at.t, at.x.as_slice());
        let impulses = changes().flat_map(impulses).map(|impulse| impulse + 0.0);
        transitions.array("impulse", impulses.collect(), [stops])?;
    }
    fields.fields("transitions", transitions)?;
    let phases = Fields::new(py);
    let all = &recording.phases;
    phases.numbers("t_start", all.iter().map(|phase| phase.t_start))?;
    phases.numbers("t_end", all.iter().map(|phase| phase.t_end))?;
    phases.words("mode", all.iter().map(|phase| phase.mode), letters)?;
    phases.rows("y_start", all.iter().map(|phase| &phase.x_start), states)?;
    phases.rows("y_end", all.iter().map(|phase| &phase.x_end), states)?;
    fields.fields("phases", phases)?;
    let mut doubtful = recording.doubtful;
    doubtful.extend(recording.friction.warning());
    doubtful.extend(recording.monitor.below_tolerance(system, &Keywords));
    fields.put("doubtful", doubtful)?;
    let end = recording.last;
    let dense = recording.steps.map(|steps| Dense { steps, end });
    fields.put("sol", dense)?;
    Ok(fields)
}

/// The reactions of all stops at the points, in the phases of these. Of two points of one time,
/// between which the state jumps, the second is in the next phase.
fn reactions(system: &CompiledSystem, recording: &Recording<'_>) -> PyResult<Vec<f64>> {
    let quantities = system.quantities(&[]);
    let mut quantities = quantities.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let mut phases = recording.phases.iter().peekable();
    let mut all = Vec::new();
    let mut last = f64::NAN;
    for (t, x) in &recording.points {
        let is_over = |phase: &&Phase| phase.t_end < *t || phase.t_end == *t && last == *t;
        let mut before = None;
        while let Some(phase) = phases.next_if(is_over) {
            before = Some(phase);
        }
        last = *t;
        let phase = phases
            .peek()
            .copied()
            .or(before)
            .or(recording.phases.last());
        let mode = phase.map_or_else(|| Modes::new(&[]), |phase| phase.mode);
        all.extend(quantities.at(&mode, *t, x.as_slice()));
    }
    Ok(all)
}

/// Status and message of a run that did not fail.
fn ending(summary: &Summary, system: &CompiledSystem) -> (i32, String) {
    let (t, x) = (summary.t, (&summary.x).into());
    match summary.ending {
        Ending::EndTime => (
            0,
            "The solver successfully reached the end of the integration interval.".to_owned(),
        ),
        Ending::Stopped => (1, "A jump that ends the run occurred.".to_owned()),
        Ending::Repelling | Ending::TwoFold(_) => {
            (2, words(&Error::NoUniqueFuture { t, x }, system))
        }
        Ending::Shrunk => (2, words(&Error::Shrunk { t, x }, system)),
        Ending::Failed => (-1, "The run failed.".to_owned()),
    }
}

/// The solution over all steps.
#[pyclass(frozen, module = "stickslip._core")]
pub(crate) struct Dense {
    steps: Vec<(Step, Solution)>,
    end: (f64, Vector),
}

#[pymethods]
impl Dense {
    /// The states at the given times, with one row for each.
    fn at<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let from = self
            .steps
            .first()
            .map_or(self.end.0, |(step, _)| step.t_start);
        let to = self.end.0;
        let state = |&t: &f64| {
            if !(from..=to).contains(&t) {
                return Err(failed(&Error::OutsideOrbit { t, from, to }, None));
            }
            let index = self.steps.partition_point(|(step, _)| step.t_end < t);
            Ok(match self.steps.get(index) {
                Some((step, _)) if t == step.t_end => step.x_end.clone(),
                Some((_, solution)) => solution(t),
                None => self.end.1.clone(),
            })
        };
        let times = times.as_array();
        let states = times.iter().map(state).collect::<PyResult<Vec<_>>>()?;
        let flat = states.iter().flatten().copied().collect();
        array(py, flat, [self.end.1.len()])
    }
}
