//! Recording of an orbit for a command.

use std::ops::ControlFlow;

use plot::Trace;
use stickslip::analysis::OrbitDerivatives;
use stickslip::dynamics::{
    Modes, Moment, OrbitEvent, OrbitProgress, OrbitUnderWay, RecordedOrbit, RunMemory, Sampling,
    Step, Summary, Vector, Watching,
};
use stickslip::error::readable;
use stickslip::{Direction, Error, Mode, Options};

use super::trajectory::{CURVE_WIDTH, HISTORY_SIZE, MOST_POINTS, PORTRAIT_SIZE, stick_width};
use crate::failure::CommandLine;
use crate::render::input_name;
use output::terminal::{DelayedProgressBar, note};
use stickslip_model::file::{InputShape, Quantities, System};
use stickslip_model::kernel::{follow_all, follow_on};
use stickslip_model::study::{
    FrictionWatch, StepMonitor, VariedSystem, VariedTangents, left_out_at_start,
};

/// Number of parts of a step for a curve through the orbit, which has a point between any two.
/// Steps of high order are long, so that a curve through their ends alone would be a polygon.
const PARTS_PER_STEP: u32 = 8;

/// A part is halved if its midpoint is off the straight line by more than this fraction of the
/// extent of the orbit so far. The next constant limits the number of halvings.
const CHORD_TOLERANCE: f64 = 1e-3;
const MOST_HALVINGS: u32 = 6;

/// Relative differences up to this may be rounding.
const ROUNDING: f64 = 1e-9;

/// Number of steps of the progress bar.
const FINENESS: f64 = 1000.0;

/// A run of as many steps is large.
const MANY_STEPS: u64 = 1_000_000;

/// Items to record besides the events.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    pub(super) figures: bool,
    pub(super) steps: bool,
    /// Whether the terminal shows the progress of the run, and warnings while it runs.
    pub(super) progress: bool,
}

/// Content of the figures of an orbit.
pub(super) struct Pictures {
    /// Each state against time, and then each further quantity.
    pub(super) history: Vec<Trace>,
    /// The plane of the first two states; the same where each contact sticks.
    pub(super) portrait: Trace,
    pub(super) sticks: Vec<Trace>,
    /// Minimum and maximum of each state, and of each further quantity that had a value.
    pub(super) extents: Vec<(f64, f64)>,
}

impl Pictures {
    /// Pictures of a point.
    fn new(system: &System, at: &Moment, quantities: usize) -> Self {
        let trace = |size, pen, count: usize| Trace::new(size, pen, MOST_POINTS / count);
        let contacts = system.contacts();
        let stick = |contact| trace(PORTRAIT_SIZE, stick_width(contacts, contact), 2 + contacts);
        let panels = at.x.len() + quantities;
        let unknown = (f64::INFINITY, f64::NEG_INFINITY);
        let extents = at.x.iter().map(|&x| (x, x));
        let mut pictures = Pictures {
            history: vec![trace(HISTORY_SIZE, CURVE_WIDTH, panels); panels],
            portrait: trace(PORTRAIT_SIZE, CURVE_WIDTH, 2 + contacts),
            sticks: (0..contacts).map(stick).collect(),
            extents: extents.chain(vec![unknown; quantities]).collect(),
        };
        pictures.add(at, None, &[]);
        pictures
    }

    /// Adds a point, of an orbit in this mode, and the further quantities there.
    fn add(&mut self, Moment { t, x }: &Moment, mode: Option<Modes>, quantities: &[f64]) {
        for (trace, &x) in self.history.iter_mut().zip(x.iter().chain(quantities)) {
            match x.is_nan() {
                true => trace.lift(),
                false => trace.push((*t, x)),
            }
        }
        let extents = self.extents.iter_mut();
        for ((low, high), &x) in extents.zip(x.iter().chain(quantities)) {
            (*low, *high) = (low.min(x), high.max(x));
        }
        let Some(&second) = x.get(1) else {
            return;
        };
        self.portrait.push((x[0], second));
        for (contact, trace) in self.sticks.iter_mut().enumerate() {
            match mode.map(|mode| mode.get(contact)) {
                Some(Mode::Stick) => trace.push((x[0], second)),
                _ => trace.lift(),
            }
        }
    }

    /// Adds the points of a step.
    fn step(
        &mut self,
        step: &Step,
        solution: &dyn Fn(f64) -> Vector,
        quantities: &mut Quantities<'_>,
    ) {
        let at = |k: u32| {
            let part = f64::from(k) / f64::from(PARTS_PER_STEP);
            let t = step.t_start + part * (step.t_end - step.t_start);
            let x = solution(t);
            Moment { t, x }
        };
        let [mut from, end] = [(step.t_start, &step.x_start), (step.t_end, &step.x_end)]
            .map(|(t, x)| Moment { t, x: x.clone() });
        // Behind a jump the curve begins anew, so that its edge is vertical.
        let mut of = PictureStep {
            mode: step.mode,
            solution,
            quantities,
        };
        self.point(&mut of, &from);
        for to in (1..PARTS_PER_STEP).map(at).chain([end]) {
            self.part(&mut of, &from, &to, MOST_HALVINGS);
            from = to;
        }
    }

    /// Adds a point of a step.
    fn point(&mut self, of: &mut PictureStep<'_, '_>, at: &Moment) {
        let quantities = of.quantities.at(&of.mode, at.t, at.x.as_slice());
        self.add(at, Some(of.mode), &quantities);
    }

    /// Adds the points of a step between two moments, and the second one.
    fn part(&mut self, of: &mut PictureStep<'_, '_>, from: &Moment, to: &Moment, deep: u32) {
        let t = 0.5 * (from.t + to.t);
        let middle = Moment {
            t,
            x: (of.solution)(t),
        };
        let ends = from.x.iter().zip(&to.x);
        let mut states = middle.x.iter().zip(ends).zip(&self.extents);
        let is_bent = states.any(|((x, (a, b)), &(low, high))| {
            let rounding = ROUNDING * low.abs().max(high.abs());
            (x - 0.5 * (a + b)).abs() > CHORD_TOLERANCE * (high - low) + rounding
        });
        if is_bent && deep > 0 {
            self.part(of, from, &middle, deep - 1);
            return self.part(of, &middle, to, deep - 1);
        }
        self.point(of, &middle);
        self.point(of, to);
    }
}

/// A step as pictures show it.
struct PictureStep<'a, 's> {
    mode: Modes,
    solution: &'a dyn Fn(f64) -> Vector,
    quantities: &'a mut Quantities<'s>,
}

/// Name of the kind of an event in tables.
pub(super) fn kind_of(system: &System, event: &OrbitEvent) -> &'static str {
    match event {
        OrbitEvent::Transition { at, .. } => at.kind.name(),
        OrbitEvent::Kink(at) => match system.file.inputs[at.input].shape {
            InputShape::Switch(_) => "switch",
            _ => "kink",
        },
    }
}

/// Name of the contact, jump or input of an event.
pub(super) fn source_of(system: &System, event: &OrbitEvent) -> String {
    match event {
        OrbitEvent::Transition { at, .. } => system.contact_name(at.contact),
        OrbitEvent::Kink(at) => input_name(system, at.input),
    }
}

/// A point of an orbit: time, state, quantities.
pub(super) type Row<'r> = (f64, &'r [f64], &'r [f64]);

/// A recorded orbit with what figures and tables need besides.
pub(super) struct Recording {
    pub(super) orbit: RecordedOrbit,
    /// Doubts about the run.
    pub(super) doubtful: Vec<String>,
    /// Reactions of stops and what else is observed: their names, and a row for each point.
    pub(super) quantities: (Vec<String>, Vec<f64>),
    pub(super) pictures: Option<Pictures>,
    /// The end, if another run can go on from it.
    pub(super) memory: Option<RunMemory>,
    /// Derivatives at its points and transitions, if they are wanted.
    pub(super) derivatives: Option<OrbitDerivatives>,
    /// The mode of the last step.
    mode: Option<Modes>,
    wanted: Wanted,
    t_end: f64,
    monitor: StepMonitor,
    progress: Option<DelayedProgressBar>,
}

impl Recording {
    /// Records a run, and returns how it ended. It goes on from the end of another run, or has
    /// derivatives, if these are given. A stiff system is told while it runs.
    pub(super) fn of(
        system: &System,
        start: (f64, &[f64]),
        t_end: f64,
        options: &Options,
        wanted: Wanted,
        (from, by): (Option<&RunMemory>, Option<&VariedSystem<'_>>),
        mut quantities: Quantities<'_>,
    ) -> (Self, Result<Summary, Error>) {
        let (t, x) = (start.0, Vector::from_column_slice(start.1));
        let begin = Moment { t, x };
        let mut recording = Recording::new(system, &begin, t_end, options, wanted, &quantities);
        let mut friction = FrictionWatch::new(system);
        let (dynamics, sections) = (system.dynamics(), system.sections());
        let begun = match from {
            None => dynamics.begin(&begin, t_end, options, &sections),
            Some(memory) => dynamics.resume(memory, t_end, options, &sections),
        };
        let mut tangents = None;
        let ended = begun.and_then(|mut orbit| {
            orbit.remember();
            if let Some(by) = by {
                tangents = Some(by.tangents((&*orbit, &begin), &sections, options)?);
            }
            let mut watcher = |progress, orbit: &mut dyn OrbitUnderWay| {
                let watches = (&mut friction, &mut quantities);
                recording.watch(watches, tangents.as_mut(), progress, orbit)
            };
            let ended = follow_on(&mut *orbit, &mut watcher);
            recording.memory = orbit.memory();
            ended
        });
        recording.finish(system, (friction, quantities), &ended);
        recording.derivatives = tangents.map(|of| of.finish(&recording.orbit, &ended));
        if from.is_none() {
            recording
                .doubtful
                .extend(left_out_at_start(system, &recording.orbit));
        }
        (recording, ended)
    }

    /// Records the runs from several starts, each with the bits of a single run.
    pub(super) fn of_all(
        system: &System,
        starts: &[Moment],
        t_end: f64,
        options: &Options,
        wanted: Wanted,
        quantities: Vec<Quantities<'_>>,
    ) -> Vec<(Self, Result<Summary, Error>)> {
        let new = |(at, of)| Recording::new(system, at, t_end, options, wanted, of);
        let mut recordings: Vec<Recording> = starts.iter().zip(&quantities).map(new).collect();
        let watches = quantities
            .into_iter()
            .map(|of| (FrictionWatch::new(system), of));
        let mut watches: Vec<(FrictionWatch<'_>, Quantities<'_>)> = watches.collect();
        let watcher = &mut |number: usize, progress, orbit: &mut dyn OrbitUnderWay| {
            let (friction, quantities) = &mut watches[number];
            recordings[number].watch((friction, quantities), None, progress, orbit)
        };
        let (dynamics, sections) = (system.dynamics(), system.sections());
        let watching = Watching {
            sections: &sections,
            // Friction laws are evaluated within steps.
            solutions: wanted.figures || system.contacts() > 0,
        };
        let ended = follow_all(dynamics, starts, t_end, options, watching, watcher);
        let all = recordings.into_iter().zip(watches).zip(ended);
        let finished = all.map(|((mut recording, watches), ended)| {
            recording.finish(system, watches, &ended);
            recording
                .doubtful
                .extend(left_out_at_start(system, &recording.orbit));
            (recording, ended)
        });
        finished.collect()
    }

    /// A recording of a run before its first step.
    fn new(
        system: &System,
        begin: &Moment,
        t_end: f64,
        options: &Options,
        wanted: Wanted,
        quantities: &Quantities<'_>,
    ) -> Self {
        let start = (begin.t, begin.x.as_slice());
        let sampling = match wanted.steps {
            true => Sampling::Steps,
            false => Sampling::Nowhere,
        };
        Recording {
            orbit: RecordedOrbit::new(begin, sampling, false),
            doubtful: Vec::new(),
            quantities: (quantities.names().to_vec(), Vec::new()),
            pictures: wanted
                .figures
                .then(|| Pictures::new(system, begin, quantities.names().len())),
            memory: None,
            derivatives: None,
            mode: None,
            wanted,
            t_end,
            monitor: StepMonitor::new(system, start, t_end, options),
            progress: wanted
                .progress
                .then(|| DelayedProgressBar::new("following {bar:40} {percent} %, {eta} to go")),
        }
    }

    /// Records what an orbit reports.
    fn watch(
        &mut self,
        (friction, quantities): (&mut FrictionWatch<'_>, &mut Quantities<'_>),
        tangents: Option<&mut VariedTangents<'_>>,
        progress: OrbitProgress,
        orbit: &mut dyn OrbitUnderWay,
    ) -> ControlFlow<()> {
        if !matches!(progress, OrbitProgress::Step | OrbitProgress::Passage(_)) {
            self.monitor.begin_anew();
        }
        match progress {
            OrbitProgress::Step => {
                self.step(orbit, quantities);
                friction.step(orbit);
                if let Some(tangents) = tangents {
                    tangents.step(&self.orbit, orbit);
                }
            }
            progress => {
                if let Some(tangents) = tangents {
                    tangents.event(&progress);
                }
                self.orbit.take(progress, orbit);
            }
        }
        ControlFlow::Continue(())
    }

    /// Completes the recording of a run that has ended.
    fn finish(
        &mut self,
        system: &System,
        (friction, mut quantities): (FrictionWatch<'_>, Quantities<'_>),
        ended: &Result<Summary, Error>,
    ) {
        if let Ok(end) = ended {
            self.orbit.finish(end);
            self.observe(&mut quantities);
        }
        if let Some(progress) = self.progress.take() {
            progress.clear();
        }
        self.doubtful.extend(friction.warning());
        let below = self.monitor.below_tolerance(system, &CommandLine);
        self.doubtful.extend(below);
    }

    /// The points, each as its time, its state and its quantities.
    pub(super) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        let (names, values) = &self.quantities;
        let count = names.len();
        self.orbit.points().enumerate().map(move |(k, (t, x))| {
            let own = values.get(k * count..(k + 1) * count);
            (t, x, own.unwrap_or_default())
        })
    }

    /// Computes the quantities of the points that have none, in the mode of the last step.
    fn observe(&mut self, quantities: &mut Quantities<'_>) {
        let (names, values) = &mut self.quantities;
        let (Some(mode), false) = (self.mode, names.is_empty()) else {
            return;
        };
        for (t, x) in self.orbit.points_from(values.len() / names.len()) {
            values.extend(quantities.at(&mode, t, x));
        }
    }

    /// Records a step.
    fn step(&mut self, orbit: &mut dyn OrbitUnderWay, quantities: &mut Quantities<'_>) {
        let step = orbit.last_step();
        self.mode = Some(step.mode);
        match self.monitor.step(&step, &CommandLine) {
            Some(warning) if self.wanted.progress => note(&format!("warning: {warning}")),
            warning => self.doubtful.extend(warning),
        }
        if self.monitor.looks_within() {
            let middle = orbit.solution()(0.5 * (step.t_start + step.t_end));
            self.monitor.reaches(middle.as_slice());
        }
        if self.wanted.progress && orbit.counters().steps == MANY_STEPS {
            let advice = match (self.wanted.steps, self.wanted.figures) {
                (false, false) => "",
                _ => "; --no-steps and --no-figures save memory and time",
            };
            note(&format!(
                "note: {MANY_STEPS} steps so far, to t = {} of {}{advice}",
                readable(step.t_end),
                readable(self.t_end)
            ));
        }
        self.orbit.step(step.clone(), orbit);
        self.observe(quantities);
        if let Some(pictures) = &mut self.pictures {
            pictures.step(&step, &*orbit.solution(), quantities);
        }
        let (from, to) = (self.orbit.start.t, self.t_end);
        let part = ((step.t_end - from) / (to - from)).clamp(0.0, 1.0);
        if let Some(progress) = &self.progress {
            progress.done((part * FINENESS) as u64, FINENESS as u64);
        }
    }
}

/// Names of transitions in tables, in the order in which they are counted.
pub(super) const KINDS: [&str; 9] = [
    "stick entry",
    "stick exit",
    "crossing",
    "touch",
    "contact loss",
    "contact gain",
    "jump",
    "switch",
    "kink",
];

/// Name of a direction in tables.
pub(super) fn direction_name(direction: Direction) -> &'static str {
    match direction {
        Direction::Rising => "rising",
        Direction::Falling => "falling",
        Direction::Both => "both",
    }
}
