//! An orbit, its events and its dense output.

use std::ops::ControlFlow;
use std::time::Instant;

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{EventDerivatives, OrbitDerivatives};
use stickslip::dynamics::{
    Matrix, Modes, Moment, OrbitEvent, OrbitProgress, OrbitUnderWay, Passage, Phase, RecordedOrbit,
    RunMemory, Sampling, Section, Summary, Transition, Vector, Watching,
};
use stickslip::error::readable;
use stickslip::{Ending, Error, Options};
use stickslip_model::file::{Quantities, SettingError, System as CompiledSystem};
use stickslip_model::kernel::{follow_all, follow_on};
use stickslip_model::study::ensemble::by_system;
use stickslip_model::study::past::PastWatch;
use stickslip_model::study::{
    FrictionWatch, StepMonitor, Variables, VariedSystem, VariedTangents, left_out_at_start,
};

use crate::errors::{Failure, Keywords, computation, failed, words, wrong};
use crate::fields::{Fields, array};
use crate::task::{ProgressKind, Report, SIGNAL_INTERVAL, check_signals, computed};
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

/// Recording of an orbit for Python.
struct Recording<'a> {
    orbit: RecordedOrbit,
    /// Number of passages of each event that are left before the run ends; 0 for never.
    left: Vec<usize>,
    /// The passage that ends the run.
    terminal: Option<Moment>,
    /// The run ends at this time.
    limit: f64,
    /// Signals of Python that end the run; without them, the system itself ends its orbits.
    signals: Option<&'a mut Signals>,
    friction: FrictionWatch<'a>,
    monitor: StepMonitor,
    /// Tangent vectors, if derivatives are wanted.
    tangents: Option<VariedTangents<'a>>,
    /// Watch for moments without a past, with reversed time.
    past: Option<PastWatch<'a>>,
    /// Place and contact of a slide that has none.
    slide: Option<(Moment, usize)>,
    /// Doubts about the steps so far.
    doubtful: Vec<String>,
}

/// Parts of a run to record, besides its phases, transitions and events.
#[derive(Clone)]
struct Wanted<'a> {
    /// Numbers of passages of each event that end the run, 0 for never.
    most: &'a [usize],
    sampling: Sampling,
    keeps_steps: bool,
    /// The run ends at this time.
    limit: f64,
    /// Whether the system is reversed in time.
    is_reversed: bool,
    /// Whether the forces at the points are kept with each of many orbits.
    forces: bool,
}

impl Wanted<'_> {
    /// Whether the solution over steps is needed, not only their ends.
    fn needs_solutions(&self, system: &CompiledSystem, t_end: f64) -> bool {
        let is_inside = match &self.sampling {
            Sampling::Times(times) => times.iter().any(|t| *t != t_end),
            _ => false,
        };
        system.contacts() > 0 || self.keeps_steps || is_inside
    }
}

impl<'a> Recording<'a> {
    /// A recording of a run from its start.
    fn new(
        system: &'a CompiledSystem,
        ((t, x), t_end, options): ((f64, &[f64]), f64, &Options),
        wanted: Wanted<'_>,
        signals: Option<&'a mut Signals>,
    ) -> Self {
        let start = Moment {
            t,
            x: Vector::from_column_slice(x),
        };
        Recording {
            orbit: RecordedOrbit::new(&start, wanted.sampling, wanted.keeps_steps),
            left: wanted.most.to_vec(),
            terminal: None,
            limit: wanted.limit,
            signals,
            friction: FrictionWatch::new(system),
            monitor: StepMonitor::new(system, (t, x), t_end, options),
            tangents: None,
            past: wanted.is_reversed.then(|| PastWatch::new(system, options)),
            slide: None,
            doubtful: Vec::new(),
        }
    }

    fn watch(&mut self, progress: OrbitProgress, orbit: &mut dyn OrbitUnderWay) -> ControlFlow<()> {
        if !matches!(progress, OrbitProgress::Step | OrbitProgress::Passage(_)) {
            self.monitor.begin_anew();
        }
        match progress {
            OrbitProgress::Step => return self.step(orbit),
            OrbitProgress::Passage(ref at) => {
                let t = at.t;
                if t > self.limit {
                    return ControlFlow::Break(());
                }
                let left = &mut self.left[at.number];
                let is_last = *left == 1;
                *left = left.saturating_sub(1);
                if is_last {
                    self.limit = t;
                    self.terminal = Some(at.moment());
                }
                self.take(progress, orbit);
                if is_last {
                    return ControlFlow::Break(());
                }
            }
            OrbitProgress::Transition(ref at) => {
                if at.t > self.limit {
                    return ControlFlow::Continue(());
                }
                let slide = self.past.as_ref().and_then(|past| past.transition(at));
                if let Some(contact) = slide {
                    self.slide = Some((at.moment(), contact));
                    return ControlFlow::Break(());
                }
                self.take(progress, orbit);
            }
            progress => self.orbit.take(progress, orbit),
        }
        ControlFlow::Continue(())
    }

    /// Records an event.
    fn take(&mut self, progress: OrbitProgress, orbit: &mut dyn OrbitUnderWay) {
        if let Some(tangents) = &mut self.tangents {
            tangents.event(&progress);
        }
        self.orbit.take(progress, orbit);
    }

    fn step(&mut self, orbit: &mut dyn OrbitUnderWay) -> ControlFlow<()> {
        let step = orbit.last_step();
        if step.t_start > self.limit {
            return ControlFlow::Break(());
        }
        if let Some(signals) = &mut self.signals {
            signals.check_signals(step.t_end)?;
        }
        self.slide = self.past.as_ref().and_then(|past| past.step(orbit));
        self.friction.step(orbit);
        self.doubtful.extend(self.monitor.step(&step, &Keywords));
        if self.monitor.looks_within() {
            let middle = orbit.solution()(0.5 * (step.t_start + step.t_end));
            self.monitor.reaches(middle.as_slice());
        }
        self.orbit.step(step, orbit);
        if let Some(tangents) = &mut self.tangents {
            tangents.step(&self.orbit, orbit);
        }
        match self.slide {
            Some(_) => ControlFlow::Break(()),
            None => ControlFlow::Continue(()),
        }
    }
}

/// Result of a run.
struct Solved {
    orbit: RecordedOrbit,
    doubtful: Vec<String>,
    outcome: Result<Summary, Error>,
    memory: Option<RunMemory>,
    derivatives: Option<OrbitDerivatives>,
    /// Whether an event ended the run.
    is_terminated: bool,
    /// Place and contact of the slide that ended a run backwards.
    slide: Option<(Moment, usize)>,
    /// Forces at the points, row by row, if they are kept.
    forces: Option<Vec<f64>>,
}

impl Recording<'_> {
    /// The result, of a run that ended so.
    fn finished(
        mut self,
        system: &CompiledSystem,
        outcome: Result<Summary, Error>,
        memory: Option<RunMemory>,
    ) -> Solved {
        if let Ok(end) = &outcome {
            self.orbit.finish(end);
        }
        let cuts = [
            self.terminal.as_ref(),
            self.slide.as_ref().map(|slide| &slide.0),
        ];
        cuts.into_iter().flatten().for_each(|at| self.orbit.cut(at));
        let mut doubtful = self.doubtful;
        doubtful.extend(self.friction.warning());
        doubtful.extend(self.monitor.below_tolerance(system, &Keywords));
        let tangents = self.tangents.take();
        Solved {
            derivatives: tangents.map(|of| of.finish(&self.orbit, &outcome)),
            orbit: self.orbit,
            doubtful,
            outcome,
            // An event that ends the run leaves no step that its end has shortened.
            memory: memory.filter(|_| self.terminal.is_none()),
            is_terminated: self.terminal.is_some(),
            slide: self.slide,
            forces: None,
        }
    }
}

/// The requested times, or the ends of all steps.
fn sampling(t_eval: Option<PyReadonlyArray1<'_, f64>>) -> Sampling {
    t_eval.map_or(Sampling::Steps, |times| {
        Sampling::Times(times.as_array().to_vec())
    })
}

/// Sections of the system, one for each event. Without events the section of the system is not
/// used.
fn watched(system: &CompiledSystem, events: usize) -> Vec<Section> {
    let mut sections = system.sections();
    sections.truncate(events);
    sections
}

/// Follows an orbit, from the end of another run or with derivatives, if given. The system has a
/// section for each event.
fn solved(
    system: &CompiledSystem,
    run: ((f64, &[f64]), f64, &Options),
    wanted: Wanted<'_>,
    (from, by): (Option<&RunMemory>, Option<&VariedSystem<'_>>),
    signals: &mut Signals,
) -> Solved {
    let ((t, x), t_end, options) = run;
    let at = Moment {
        t,
        x: Vector::from_column_slice(x),
    };
    let sections = watched(system, wanted.most.len());
    let mut recording = Recording::new(system, run, wanted, Some(signals));
    if let Some(contact) = recording.past.as_ref().and_then(|past| past.start(&at)) {
        let x = (&at.x).into();
        recording.slide = Some((at, contact));
        return recording.finished(system, Err(Error::NoUniqueFuture { t, x }), None);
    }
    let dynamics = system.dynamics();
    let begun = match from {
        None => dynamics.begin(&at, t_end, options, &sections),
        Some(memory) => dynamics.resume(memory, t_end, options, &sections),
    };
    let mut memory = None;
    let outcome = begun.and_then(|mut orbit| {
        orbit.remember();
        if let Some(by) = by {
            let tangents = by.tangents((&*orbit, &at), &sections, options)?;
            recording.tangents = Some(tangents);
        }
        let mut watcher =
            |progress, orbit: &mut dyn OrbitUnderWay| recording.watch(progress, orbit);
        let outcome = follow_on(&mut *orbit, &mut watcher);
        memory = orbit.memory();
        outcome
    });
    let mut solved = recording.finished(system, outcome, memory);
    if from.is_none() {
        solved
            .doubtful
            .extend(left_out_at_start(system, &solved.orbit));
    }
    solved
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
    let is_reversed = system.compiled.file.is_reversed;
    let (t_end, limit) = until;
    let from: Option<RunMemory> = from.map(remembered).transpose()?;
    let options = settings.options(&system.compiled)?;
    let (t, x) = start;
    // An event or a jump may end the run earlier.
    let jumps = &system.compiled.file.jumps;
    if most.iter().all(|&most| most == 0) && jumps.iter().all(|jump| jump.most.is_none()) {
        let checked = options.check_span(t, t_end);
        checked.map_err(|error| failed(&error, Some(&system.compiled)))?;
    }
    let mut signals = Signals::new(report);
    let wanted = Wanted {
        most: &most,
        sampling: sampling(t_eval),
        keeps_steps: dense_output,
        limit,
        is_reversed,
        forces: false,
    };
    let compiled = &system.compiled;
    let variables = Variables::named(compiled, derivatives.iter().map(String::as_str));
    let variables = variables.map_err(|error| {
        PyValueError::new_err(format!("derivatives = {derivatives:?}: {error}"))
    })?;
    let by = (!derivatives.is_empty()).then(|| variables.of(compiled));
    let by = by.transpose();
    let by = by.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let run = ((t, &x[..]), t_end, &options);
    let with = (from.as_ref(), by.as_ref());
    let mut solved = py.detach(|| solved(compiled, run, wanted, with, &mut signals));
    let found = solved.derivatives.take();
    let fields = described(
        py,
        compiled,
        solved,
        (t, x.len()),
        (most.len(), dense_output),
    )?;
    if let Some(found) = found {
        fields.fields(
            "derivatives",
            derivative_fields(py, compiled, &found, derivatives.len())?,
        )?;
    }
    fields.ended(signals.raised)
}

/// The passages of one event.
fn passages(orbit: &RecordedOrbit, number: usize) -> impl Iterator<Item = &Passage> {
    let all = orbit.passages.iter();
    all.filter(move |at| at.number == number)
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

/// Status and message of a run; the error of one that failed at its start.
fn status(solved: &Solved, system: &CompiledSystem, t_start: f64) -> Result<(i32, String), Error> {
    match (&solved.slide, &solved.outcome) {
        (Some((at, contact)), _) => Ok((2, no_past(system, at.t, *contact))),
        _ if solved.is_terminated => Ok((1, "A termination event occurred.".to_owned())),
        (None, Ok(summary)) => Ok(ending(summary, system)),
        // An error at the start leaves no result to return.
        (None, Err(error)) if solved.orbit.end.t == t_start => Err(error.clone()),
        (None, Err(error)) => Ok((-1, words(error, system))),
    }
}

/// Message for a run backwards that ends at a slide. Its times are negative.
fn no_past(system: &CompiledSystem, t: f64, contact: usize) -> String {
    format!(
        "the past is not unique: at t = {} the orbit comes from a slide along the boundary of {}, \
         into which many orbits lead; end t_span behind that time",
        readable(0.0 - t),
        system.contact_name(contact)
    )
}

/// The result of a run, for Python.
fn described<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    solved: Solved,
    (t_start, states): (f64, usize),
    (events, keeps_steps): (usize, bool),
) -> PyResult<Fields<'py>> {
    if let Some((at, contact)) = &solved.slide
        && at.t == t_start
    {
        let message = no_past(system, at.t, *contact);
        let (t, x) = (0.0 - at.t, (&at.x).into());
        let place = Error::NoUniqueFuture { t, x };
        return Err(computation("NoUniquePast", &message, Some(&place)));
    }
    let status = status(&solved, system, t_start);
    let (status, message) = status.map_err(|error| failed(&error, Some(system)))?;
    let fields = Fields::new(py);
    let orbit = solved.orbit;
    add_points(&fields, &mut || orbit.points(), states)?;
    if has_forces(system) {
        let mut quantities = quantities(system)?;
        let names = quantities.force_names();
        fields.array("forces", forces(&mut quantities, &orbit), [names.len()])?;
        fields.put("acting", names)?;
    }
    let events = (0..events).map(|number| {
        let times = PyArray1::from_iter(py, passages(&orbit, number).map(|at| at.t));
        let x = passages(&orbit, number).flat_map(|at| at.x.iter().copied());
        Ok((times, array(py, x.collect(), [states])?))
    });
    fields.put("events", events.collect::<PyResult<Vec<_>>>()?)?;
    let memory = solved.memory.as_ref();
    let memory = memory.and_then(|memory| serde_json::to_string(memory).ok());
    fields.put("memory", memory)?;
    fields.put("status", status)?;
    fields.put("message", message)?;
    let calls = solved.outcome.as_ref().ok();
    fields.put("nfev", calls.map(|summary| summary.counters.field_calls))?;
    fields.put("t_end", orbit.end.t)?;
    let transitions = Fields::new(py);
    add_transitions(&transitions, system, &mut || orbit.events.iter())?;
    fields.fields("transitions", transitions)?;
    let phases = Fields::new(py);
    add_phases(&phases, system, &mut || orbit.phases.iter())?;
    fields.fields("phases", phases)?;
    fields.put("doubtful", solved.doubtful)?;
    let dense = keeps_steps.then(|| Dense(orbit));
    fields.put("sol", dense)?;
    Ok(fields)
}

/// Whether a stop acts, or a contact by friction.
fn has_forces(system: &CompiledSystem) -> bool {
    let mut contacts = system.file.contacts.iter();
    contacts.any(|one| one.friction.is_some()) || !system.file.stops.is_empty()
}

/// Forces of a system, without further formulas.
fn quantities(system: &CompiledSystem) -> PyResult<Quantities<'_>> {
    let quantities = system.quantities(&[]);
    quantities.map_err(|error| PyValueError::new_err(error.to_string()))
}

/// The forces of all stops and contacts at the points, in the phases of these. Of two points of one
/// time, between which the state jumps, the second is in the next phase.
fn forces(quantities: &mut Quantities<'_>, orbit: &RecordedOrbit) -> Vec<f64> {
    let mut phases = orbit.phases.iter().peekable();
    let mut all = Vec::new();
    let mut last = f64::NAN;
    for (t, x) in orbit.points() {
        let is_over = |phase: &&Phase| phase.t_end < t || phase.t_end == t && last == t;
        let mut before = None;
        while let Some(phase) = phases.next_if(is_over) {
            before = Some(phase);
        }
        last = t;
        let phase = phases.peek().copied().or(before).or(orbit.phases.last());
        let mode = phase.map_or_else(|| Modes::new(&[]), |phase| phase.mode);
        all.extend(quantities.forces_at(&mode, t, x));
    }
    all
}

/// Adds the columns of points.
fn add_points<'s, I: Iterator<Item = (f64, &'s [f64])>>(
    fields: &Fields<'_>,
    all: &mut dyn FnMut() -> I,
    states: usize,
) -> PyResult<()> {
    fields.numbers("t", all().map(|(t, _)| t))?;
    fields.array("y", all().flat_map(|(_, x)| x).copied().collect(), [states])
}

/// Adds the columns of transitions, each with the state after it.
fn add_transitions<'s, I: Iterator<Item = &'s OrbitEvent>>(
    table: &Fields<'_>,
    system: &CompiledSystem,
    events: &mut dyn FnMut() -> I,
) -> PyResult<()> {
    let states = system.states();
    let letters = |modes: &Modes| system.letters(modes);
    let contact = |&number: &usize| system.contact_name(number);
    let mut all = || events().filter_map(OrbitEvent::transition);
    table.numbers("t", all().map(|at| at.t))?;
    table.words("kind", all().map(|at| at.kind), |kind| kind.name())?;
    table.words("contact", all().map(|at| at.contact), contact)?;
    table.words("from_mode", all().map(|at| at.from), letters)?;
    table.words("to_mode", all().map(|at| at.to), letters)?;
    table.rows("y_before", all().map(|at| &at.x), states)?;
    table.numbers("residual", all().map(|at| at.residual))?;
    for (number, stop) in system.file.stops.iter().enumerate() {
        let impulse = |at: &Transition| {
            let impulses = system.impulses(at.contact, at.t, at.x.as_slice());
            impulses.get(number).map_or(0.0, |impulse| impulse + 0.0)
        };
        table.numbers(&format!("impulse.{}", stop.name), all().map(impulse))?;
    }
    let transitions = events().filter(|event| event.transition().is_some());
    table.rows("y", transitions.map(OrbitEvent::after), states)
}

/// Adds the columns of phases.
fn add_phases<'s, I: Iterator<Item = &'s Phase>>(
    table: &Fields<'_>,
    system: &CompiledSystem,
    all: &mut dyn FnMut() -> I,
) -> PyResult<()> {
    let states = system.states();
    let letters = |modes: &Modes| system.letters(modes);
    table.numbers("t_start", all().map(|phase| phase.t_start))?;
    table.numbers("t_end", all().map(|phase| phase.t_end))?;
    table.words("mode", all().map(|phase| phase.mode), letters)?;
    table.rows("y_start", all().map(|phase| &phase.x_start), states)?;
    table.rows("y_end", all().map(|phase| &phase.x_end), states)
}

/// Follows the orbit from each start, all to the same end, with the bits of single runs. Each has
/// its values of the named parameters.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "they are those of a call from Python"
)]
pub(crate) fn ensemble<'py>(
    py: Python<'py>,
    system: &System,
    starts: PyReadonlyArray2<'py, f64>,
    parameters: (Vec<String>, PyReadonlyArray2<'py, f64>),
    span: (f64, f64),
    most: Vec<usize>,
    t_eval: Option<PyReadonlyArray1<'py, f64>>,
    how: (usize, bool),
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let ((t, t_end), compiled) = (span, &system.compiled);
    let (workers, keeps_forces) = how;
    let options = settings.options(compiled)?;
    let rows = |of: &PyReadonlyArray2<'py, f64>| -> Vec<Vec<f64>> {
        let rows = of.as_array();
        rows.rows().into_iter().map(|row| row.to_vec()).collect()
    };
    let (starts, names, values) = (rows(&starts), parameters.0, rows(&parameters.1));
    let wanted = Wanted {
        most: &most,
        sampling: sampling(t_eval),
        keeps_steps: false,
        limit: f64::INFINITY,
        is_reversed: compiled.file.is_reversed,
        forces: keeps_forces && has_forces(compiled),
    };
    let outcome = computed(py, workers, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        let found = by_system(&system, &names, &values, |system, numbers| {
            let own: Vec<&[f64]> = numbers.iter().map(|&number| &*starts[number]).collect();
            let run = ((t, t_end), &options);
            let found = system.map(|system| side_by_side(system, &own, run, &wanted));
            numbers.iter().for_each(|_| task.count());
            let refused = |error: SettingError| {
                let each = numbers.iter();
                each.map(|_| Err(Failure::from(error.clone()))).collect()
            };
            found.unwrap_or_else(refused)
        });
        found.into_iter().collect::<Result<Vec<Solved>, Failure>>()
    })?;
    let (found, raised) = outcome.kept(|error| error.raised(compiled))?;
    described_all(py, compiled, &found, t, most.len())?.ended(raised)
}

/// Follows orbits of one system.
fn side_by_side(
    system: &CompiledSystem,
    starts: &[&[f64]],
    ((t, t_end), options): ((f64, f64), &Options),
    wanted: &Wanted<'_>,
) -> Vec<Result<Solved, Failure>> {
    let moments: Vec<Moment> = starts
        .iter()
        .map(|x| Moment {
            t,
            x: Vector::from_column_slice(x),
        })
        .collect();
    let recording = |x: &&[f64]| {
        let run = ((t, *x), t_end, options);
        Recording::new(system, run, wanted.clone(), None)
    };
    let mut recordings: Vec<Recording<'_>> = starts.iter().map(recording).collect();
    let sections = watched(system, wanted.most.len());
    let watching = Watching {
        sections: &sections,
        solutions: wanted.needs_solutions(system, t_end),
    };
    let dynamics = system.dynamics();
    let watcher = &mut |number: usize, progress, orbit: &mut dyn OrbitUnderWay| {
        recordings[number].watch(progress, orbit)
    };
    let ended = follow_all(dynamics, &moments, t_end, options, watching, watcher);
    let mut quantities = wanted.forces.then(|| system.quantities(&[])).transpose();
    let solved = |(recording, ended): (Recording<'_>, _)| {
        let mut solved = recording.finished(system, ended, None);
        match &mut quantities {
            Ok(of) => solved.forces = of.as_mut().map(|of| forces(of, &solved.orbit)),
            Err(error) => return Err(Failure::Python(wrong(error))),
        }
        Ok(solved)
    };
    recordings.into_iter().zip(ended).map(solved).collect()
}

/// The results of many runs, for Python: numbers of rows of each run, and all rows.
fn described_all<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    all: &[Solved],
    t_start: f64,
    events: usize,
) -> PyResult<Fields<'py>> {
    let states = system.states();
    let counts = |of: &dyn Fn(&Solved) -> usize| -> Vec<i64> {
        all.iter().map(|one| of(one) as i64).collect()
    };
    let fields = Fields::new(py);
    let mut points = || all.iter().flat_map(|one| one.orbit.points());
    fields.integers("points", counts(&|one| one.orbit.point_count()))?;
    add_points(&fields, &mut points, states)?;
    let mut kept = all.iter().filter_map(|one| one.forces.as_ref()).peekable();
    if kept.peek().is_some() {
        let names = quantities(system)?.force_names();
        fields.array("forces", kept.flatten().copied().collect(), [names.len()])?;
        fields.put("acting", names)?;
    }
    fields.numbers("t_end", all.iter().map(|one| one.orbit.end.t))?;
    fields.rows("y_end", all.iter().map(|one| &one.orbit.end.x), states)?;
    let ends = all.iter().map(|one| {
        let failed = |error: Error| (-1, words(&error, system));
        status(one, system, t_start).unwrap_or_else(failed)
    });
    let ends: Vec<(i32, String)> = ends.collect();
    fields.integers("status", ends.iter().map(|end| i64::from(end.0)))?;
    fields.texts("message", ends.iter().map(|end| &end.1))?;
    let calls = all.iter().map(|one| {
        let calls = one.outcome.as_ref().ok();
        calls.map(|summary| summary.counters.field_calls as f64)
    });
    fields.optional_numbers("nfev", calls)?;
    let doubts = all.iter().map(|one| one.doubtful.join("; "));
    fields.texts("doubtful", doubts)?;
    let transitions = Fields::new(py);
    add_transitions(&transitions, system, &mut || {
        all.iter().flat_map(|one| &one.orbit.events)
    })?;
    let transitions_of = |one: &Solved| one.orbit.transitions().count();
    fields.integers("transition_counts", counts(&transitions_of))?;
    fields.fields("transitions", transitions)?;
    let phases = Fields::new(py);
    add_phases(&phases, system, &mut || {
        all.iter().flat_map(|one| &one.orbit.phases)
    })?;
    fields.integers("phase_counts", counts(&|one| one.orbit.phases.len()))?;
    fields.fields("phases", phases)?;
    let events = (0..events).map(|number| {
        let found = || all.iter().flat_map(|one| passages(&one.orbit, number));
        let own = Fields::new(py);
        own.integers(
            "counts",
            counts(&|one| passages(&one.orbit, number).count()),
        )?;
        own.numbers("t", found().map(|at| at.t))?;
        own.rows("y", found().map(|at| &at.x), states)?;
        own.ended(None)
    });
    fields.put("events", events.collect::<PyResult<Vec<_>>>()?)?;
    Ok(fields)
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
pub(crate) struct Dense(RecordedOrbit);

#[pymethods]
impl Dense {
    /// The states at the given times, with one row for each.
    fn at<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let times = times.as_array();
        let states = times.iter().map(|&t| self.0.at(t));
        let states = states.collect::<Result<Vec<_>, _>>();
        let states = states.map_err(|error| failed(&error, None))?;
        let flat = states.iter().flatten().copied().collect();
        array(py, flat, [self.0.end.x.len()])
    }
}
