//! An orbit, its events and its dense output.

use std::ops::ControlFlow;
use std::time::Instant;

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::analysis::{EventDerivatives, OrbitDerivatives};
use stickslip::dynamics::{
    Matrix, Modes, Moment, OrbitProgress, OrbitUnderWay, Passage, Phase, RunMemory, Section,
    Solution, Step, Summary, Transition, Vector, Watching,
};
use stickslip::error::readable;
use stickslip::{Ending, Error, Options};
use stickslip_model::file::System as CompiledSystem;
use stickslip_model::kernel::{follow_all, follow_on};
use stickslip_model::study::ensemble::by_system;
use stickslip_model::study::past::PastWatch;
use stickslip_model::study::{DerivativeError, FrictionWatch, StepMonitor, Variables};

use crate::errors::{Failure, Keywords, computation, failed, words};
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
    /// Signals of Python that end the run; without them, the system itself ends its orbits.
    signals: Option<&'a mut Signals>,
    friction: FrictionWatch<'a>,
    monitor: StepMonitor,
    /// Watch for moments without a past, with reversed time.
    past: Option<PastWatch<'a>>,
    /// Place and contact of a slide that has none.
    slide: Option<(Moment, usize)>,
    /// Doubts about the steps so far.
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

/// Parts of a run to record, besides its phases, transitions and events.
#[derive(Clone)]
struct Wanted<'a> {
    /// Numbers of passages of each event that end the run, 0 for never.
    most: &'a [usize],
    /// Requested times, the last one first; the ends of all steps without them.
    requested: Option<Vec<f64>>,
    keeps_steps: bool,
    /// The run ends at this time.
    limit: f64,
    /// Whether the system is reversed in time.
    is_reversed: bool,
}

impl Wanted<'_> {
    /// Whether the solution over steps is needed, not only their ends.
    fn needs_solutions(&self, system: &CompiledSystem, t_end: f64) -> bool {
        let inside = |times: &Vec<f64>| times.iter().any(|t| *t != t_end);
        system.contacts() > 0 || self.keeps_steps || self.requested.as_ref().is_some_and(inside)
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
        let start = (t, Vector::from_column_slice(x));
        let mut recording = Recording {
            events: wanted
                .most
                .iter()
                .map(|&most| Passages::new(most))
                .collect(),
            limit: wanted.limit,
            signals,
            friction: FrictionWatch::new(system),
            monitor: StepMonitor::new(system, (t, x), t_end, options),
            past: wanted.is_reversed.then(|| PastWatch::new(system, options)),
            slide: None,
            doubtful: Vec::new(),
            points: match wanted.requested {
                None => vec![start.clone()],
                Some(_) => Vec::new(),
            },
            has_requested: wanted.requested.is_some(),
            requested: wanted.requested,
            phases: Vec::new(),
            transitions: Vec::new(),
            steps: wanted.keeps_steps.then(Vec::new),
            last: start,
        };
        if let Some(requested) = &mut recording.requested {
            while requested.pop_if(|time| *time == t).is_some() {
                recording.points.push(recording.last.clone());
            }
        }
        recording
    }

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
                let slide = self.past.as_ref().and_then(|past| past.transition(&at));
                if let Some(contact) = slide {
                    self.slide = Some((at.moment(), contact));
                    return ControlFlow::Break(());
                }
                let after = Vector::from_column_slice(orbit.x());
                self.transitions.push((at, after));
            }
            _ => {}
        }
        ControlFlow::Continue(())
    }

    fn step(&mut self, orbit: &mut dyn OrbitUnderWay) -> ControlFlow<()> {
        let step = orbit.last_step();
        let decision = match (step.t_start > self.limit, &mut self.signals) {
            (true, _) => ControlFlow::Break(()),
            (false, Some(signals)) => signals.check_signals(step.t_end),
            (false, None) => ControlFlow::Continue(()),
        };
        if decision.is_continue() {
            self.slide = self.past.as_ref().and_then(|past| past.step(orbit));
            self.points_of(&step, orbit);
            self.friction.step(orbit);
            self.doubtful.extend(self.monitor.step(&step, &Keywords));
            if self.monitor.looks_within() {
                let middle = orbit.solution()(0.5 * (step.t_start + step.t_end));
                self.monitor.reaches(middle.as_slice());
            }
            self.last = (step.t_end, step.x_end.clone());
        }
        if let Some(steps) = &mut self.steps {
            steps.push((step, orbit.solution()));
        }
        match self.slide {
            Some(_) => ControlFlow::Break(()),
            None => decision,
        }
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
    fn cut(&mut self, at: &Moment) {
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
struct Solved {
    events: Vec<Passages>,
    points: Vec<(f64, Vector)>,
    phases: Vec<Phase>,
    /// Transitions, each with the state after it.
    transitions: Vec<(Transition, Vector)>,
    steps: Option<Vec<(Step, Solution)>>,
    /// The end of the run.
    last: (f64, Vector),
    doubtful: Vec<String>,
    outcome: Result<Summary, Error>,
    memory: Option<RunMemory>,
    /// Whether an event ended the run.
    is_terminated: bool,
    /// Place and contact of the slide that ended a run backwards.
    slide: Option<(Moment, usize)>,
}

impl Recording<'_> {
    /// The result, of a run that ended so.
    fn finished(
        mut self,
        system: &CompiledSystem,
        outcome: Result<Summary, Error>,
        memory: Option<RunMemory>,
    ) -> Solved {
        // A jump at the very end leads to another state.
        if let Ok(end) = &outcome
            && self.last.1 != end.x
            && end.t == self.last.0
        {
            let last = (end.t, end.x.clone());
            match self.points.last_mut() {
                Some(point) if self.has_requested && point.0 == end.t => *point = last.clone(),
                _ if !self.has_requested => self.points.push(last.clone()),
                _ => {}
            }
            self.last = last;
        }
        let terminal = self.events.iter().filter_map(Passages::terminal);
        let terminal = terminal.min_by(|a, b| a.t.total_cmp(&b.t)).cloned();
        if let Some(at) = &terminal {
            self.cut(&at.moment());
            let found = self.events.iter_mut().map(|event| &mut event.found);
            found.for_each(|found| found.retain(|one| one.t <= at.t));
        }
        if let Some((at, _)) = self.slide.clone() {
            self.cut(&at);
        }
        let mut doubtful = self.doubtful;
        doubtful.extend(self.friction.warning());
        doubtful.extend(self.monitor.below_tolerance(system, &Keywords));
        Solved {
            events: self.events,
            points: self.points,
            phases: self.phases,
            transitions: self.transitions,
            steps: self.steps,
            last: self.last,
            doubtful,
            outcome,
            // An event that ends the run leaves no step that its end has shortened.
            memory: memory.filter(|_| terminal.is_none()),
            is_terminated: terminal.is_some(),
            slide: self.slide,
        }
    }
}

/// Sections of the system, one for each event. Without events the section of the system is not
/// used.
fn watched(system: &CompiledSystem, events: usize) -> Vec<Section> {
    let mut sections = system.sections();
    sections.truncate(events);
    sections
}

/// Follows an orbit. Its system has a section for each event.
fn solved(
    system: &CompiledSystem,
    run: ((f64, &[f64]), f64, &Options),
    wanted: Wanted<'_>,
    from: Option<&RunMemory>,
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
    let mut watcher = |progress, orbit: &mut dyn OrbitUnderWay| recording.watch(progress, orbit);
    let dynamics = system.dynamics();
    let begun = match from {
        None => dynamics.begin(&at, t_end, options, &sections),
        Some(memory) => dynamics.resume(memory, t_end, options, &sections),
    };
    let mut memory = None;
    let outcome = begun.and_then(|mut orbit| {
        orbit.remember();
        let outcome = follow_on(&mut *orbit, &mut watcher);
        memory = orbit.memory();
        outcome
    });
    recording.finished(system, outcome, memory)
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
    let requested = t_eval.map(|times| times.as_array().iter().rev().copied().collect());
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
        requested,
        keeps_steps: dense_output,
        limit,
        is_reversed,
    };
    let compiled = &system.compiled;
    let variables = Variables::named(compiled, derivatives.iter().map(String::as_str));
    let variables = variables.map_err(|error| {
        PyValueError::new_err(format!("derivatives = {derivatives:?}: {error}"))
    })?;
    let run = ((t, &x[..]), t_end, &options);
    let solved = py.detach(|| solved(compiled, run, wanted, from.as_ref(), &mut signals));
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
    solved: &Solved,
) -> Result<OrbitDerivatives, DerivativeError> {
    let mut times: Vec<f64> = solved.points.iter().map(|point| point.0).collect();
    let wanted = times.len();
    // A jump that falls on the end leads to the last state.
    let last = solved.points.last().zip(solved.transitions.last());
    let is_behind = |(point, (at, after)): &(&(f64, Vector), &(Transition, Vector))| {
        point.0 == at.t && point.1 == *after && *after != at.x
    };
    let is_once = wanted < 2 || times[wanted - 2] < times[wanted - 1];
    let is_behind = is_once && last.as_ref().is_some_and(is_behind);
    if is_behind {
        times.push(times[wanted - 1]);
    }
    // Events go on behind the last requested time.
    times.extend(Some(solved.last.0).filter(|last| times.last().is_none_or(|t| t < last)));
    let sections = watched(system, events);
    let mut found = variables.along(system, (start, t_end), (&times, &sections), options)?;
    if is_behind {
        found.states.remove(wanted - 1);
    }
    found.states.truncate(wanted);
    variables.fit(
        system,
        &mut found,
        solved.transitions.iter().map(|(at, _)| at.t),
    );
    for (number, event) in solved.events.iter().enumerate() {
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

/// Status and message of a run; the error of one that failed at its start.
fn status(solved: &Solved, system: &CompiledSystem, t_start: f64) -> Result<(i32, String), Error> {
    match (&solved.slide, &solved.outcome) {
        (Some((at, contact)), _) => Ok((2, no_past(system, at.t, *contact))),
        _ if solved.is_terminated => Ok((1, "A termination event occurred.".to_owned())),
        (None, Ok(summary)) => Ok(ending(summary, system)),
        // An error at the start leaves no result to return.
        (None, Err(error)) if solved.last.0 == t_start => Err(error.clone()),
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
    let points = &solved.points;
    fields.numbers("t", points.iter().map(|point| point.0))?;
    fields.rows("y", points.iter().map(|point| &point.1), states)?;
    let has_friction = system
        .file
        .contacts
        .iter()
        .any(|one| one.friction.is_some());
    if has_friction || !system.file.stops.is_empty() {
        let (names, forces) = forces(system, &solved)?;
        fields.array("forces", forces, [names.len()])?;
        fields.put("acting", names)?;
    }
    let events = solved.events.iter().map(|event| {
        let found = &event.found;
        let times = PyArray1::from_iter(py, found.iter().map(|at| at.t));
        let x = found.iter().flat_map(|at| at.x.iter().copied());
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
    fields.put("t_end", solved.last.0)?;
    let transitions = Fields::new(py);
    add_transitions(&transitions, system, &mut || solved.transitions.iter())?;
    fields.fields("transitions", transitions)?;
    let phases = Fields::new(py);
    add_phases(&phases, system, &mut || solved.phases.iter())?;
    fields.fields("phases", phases)?;
    fields.put("doubtful", solved.doubtful)?;
    let end = solved.last;
    let dense = solved.steps.map(|steps| Dense { steps, end });
    fields.put("sol", dense)?;
    Ok(fields)
}

/// The forces of all stops and contacts at the points, in the phases of these, and their names. Of
/// two points of one time, between which the state jumps, the second is in the next phase.
fn forces(system: &CompiledSystem, solved: &Solved) -> PyResult<(Vec<String>, Vec<f64>)> {
    let quantities = system.quantities(&[]);
    let mut quantities = quantities.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let mut phases = solved.phases.iter().peekable();
    let mut all = Vec::new();
    let mut last = f64::NAN;
    for (t, x) in &solved.points {
        let is_over = |phase: &&Phase| phase.t_end < *t || phase.t_end == *t && last == *t;
        let mut before = None;
        while let Some(phase) = phases.next_if(is_over) {
            before = Some(phase);
        }
        last = *t;
        let phase = phases.peek().copied().or(before).or(solved.phases.last());
        let mode = phase.map_or_else(|| Modes::new(&[]), |phase| phase.mode);
        all.extend(quantities.forces_at(&mode, *t, x.as_slice()));
    }
    Ok((quantities.force_names(), all))
}

/// Adds the columns of transitions, each with the state after it.
fn add_transitions<'s, I: Iterator<Item = &'s (Transition, Vector)>>(
    table: &Fields<'_>,
    system: &CompiledSystem,
    all: &mut dyn FnMut() -> I,
) -> PyResult<()> {
    let states = system.states();
    let letters = |modes: &Modes| system.letters(modes);
    let contact = |&number: &usize| system.contact_name(number);
    table.numbers("t", all().map(|(at, _)| at.t))?;
    table.words("kind", all().map(|(at, _)| at.kind), |kind| kind.name())?;
    table.words("contact", all().map(|(at, _)| at.contact), contact)?;
    table.words("from_mode", all().map(|(at, _)| at.from), letters)?;
    table.words("to_mode", all().map(|(at, _)| at.to), letters)?;
    table.rows("y_before", all().map(|(at, _)| &at.x), states)?;
    table.rows("y", all().map(|(_, after)| after), states)?;
    table.numbers("residual", all().map(|(at, _)| at.residual))?;
    for (number, stop) in system.file.stops.iter().enumerate() {
        let impulse = |(at, _): &(Transition, Vector)| {
            let impulses = system.impulses(at.contact, at.t, at.x.as_slice());
            impulses.get(number).map_or(0.0, |impulse| impulse + 0.0)
        };
        table.numbers(&format!("impulse.{}", stop.name), all().map(impulse))?;
    }
    Ok(())
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
    workers: usize,
    settings: Settings,
    report: Report,
) -> PyResult<Bound<'py, PyDict>> {
    let ((t, t_end), compiled) = (span, &system.compiled);
    let options = settings.options(compiled)?;
    let requested: Option<Vec<f64>> =
        t_eval.map(|times| times.as_array().iter().rev().copied().collect());
    let rows = |of: &PyReadonlyArray2<'py, f64>| -> Vec<Vec<f64>> {
        let rows = of.as_array();
        rows.rows().into_iter().map(|row| row.to_vec()).collect()
    };
    let (starts, names, values) = (rows(&starts), parameters.0, rows(&parameters.1));
    let wanted = Wanted {
        most: &most,
        requested,
        keeps_steps: false,
        limit: f64::INFINITY,
        is_reversed: compiled.file.is_reversed,
    };
    let outcome = computed(py, workers, (&report, ProgressKind::Count), |task| {
        let system = task.system(compiled)?;
        by_system(&system, &names, &values, |system, numbers| {
            let own: Vec<&[f64]> = numbers.iter().map(|&number| &*starts[number]).collect();
            let found = side_by_side(system, &own, ((t, t_end), &options), &wanted);
            numbers.iter().for_each(|_| task.count());
            Ok::<_, Failure>(found)
        })
    })?;
    let (found, raised) = outcome.kept(|error| error.raised(compiled))?;
    described_all(py, compiled, &found, t)?.ended(raised)
}

/// Follows orbits of one system.
fn side_by_side(
    system: &CompiledSystem,
    starts: &[&[f64]],
    ((t, t_end), options): ((f64, f64), &Options),
    wanted: &Wanted<'_>,
) -> Vec<Solved> {
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
    let both = recordings.into_iter().zip(ended);
    both.map(|(recording, ended)| recording.finished(system, ended, None))
        .collect()
}

/// The results of many runs, for Python: numbers of rows of each run, and all rows.
fn described_all<'py>(
    py: Python<'py>,
    system: &CompiledSystem,
    all: &[Solved],
    t_start: f64,
) -> PyResult<Fields<'py>> {
    let states = system.states();
    let counts = |of: &dyn Fn(&Solved) -> usize| -> Vec<i64> {
        all.iter().map(|one| of(one) as i64).collect()
    };
    let fields = Fields::new(py);
    let points = || all.iter().flat_map(|one| &one.points);
    fields.integers("points", counts(&|one| one.points.len()))?;
    fields.numbers("t", points().map(|point| point.0))?;
    fields.rows("y", points().map(|point| &point.1), states)?;
    fields.numbers("t_end", all.iter().map(|one| one.last.0))?;
    fields.rows("y_end", all.iter().map(|one| &one.last.1), states)?;
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
        all.iter().flat_map(|one| &one.transitions)
    })?;
    fields.integers("transition_counts", counts(&|one| one.transitions.len()))?;
    fields.fields("transitions", transitions)?;
    let phases = Fields::new(py);
    add_phases(&phases, system, &mut || {
        all.iter().flat_map(|one| &one.phases)
    })?;
    fields.integers("phase_counts", counts(&|one| one.phases.len()))?;
    fields.fields("phases", phases)?;
    let events = all.first().map_or(0, |one| one.events.len());
    let events = (0..events).map(|number| {
        let found = || all.iter().flat_map(|one| &one.events[number].found);
        let own = Fields::new(py);
        own.integers("counts", counts(&|one| one.events[number].found.len()))?;
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
