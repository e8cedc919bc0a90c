//! Derivatives of an orbit and of the times of its events.

use super::cycle::SegmentEnd;
use super::graze::{graze_in, is_graze, turning_guards};
use super::instant::LastEvent;
use super::monodromy::{TangentMap, velocity_in};
use super::simultaneous::check_kinks;
use super::tangent::{Tangent, flatten, singular};
use crate::dynamics::{
    AsDynamics, Components, Dynamics, Matrix, Modes, Moment, OrbitProgress, OrbitUnderWay, Passage,
    RecordedOrbit, Section, Step, Transition, Vector,
};
use crate::error::Error;
use crate::filippov::{Options, TransitionKind};

/// Quantities by which an orbit is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// A component of the start state, counted from 0. A parameter that is a last state is one.
    Start(usize),
    /// The time of the start.
    StartTime,
}

/// Derivatives at an event, with one column for each variable.
#[derive(Clone, Debug, PartialEq)]
pub struct EventDerivatives {
    /// Time of the event.
    pub at: f64,
    /// Derivatives of the event's time.
    pub t: Vec<f64>,
    /// The state before the event and after it: another one at a jump.
    pub points: [Vector; 2],
    /// Derivatives of the state before the event.
    pub before: Matrix,
    /// Derivatives of the state after the event: another state at a jump.
    pub after: Matrix,
}

/// Derivatives along an orbit, as [`OrbitDerivatives::of`] computes them. Rows are states and
/// columns variables. From [`OrbitDerivatives::lost`] on all are NaN.
#[derive(Clone, Debug, Default)]
pub struct OrbitDerivatives {
    /// Derivatives of the state at each requested time.
    pub states: Vec<Matrix>,
    /// The states at these times; NaN where the run does not reach them.
    pub points: Vec<Vector>,
    /// Start, end and modes of each phase up to the last of these times.
    pub phases: Vec<(f64, f64, Modes)>,
    /// Derivatives at each transition.
    pub transitions: Vec<EventDerivatives>,
    /// Derivatives at each passage of a section, with the section's index.
    pub passages: Vec<(usize, EventDerivatives)>,
    /// Loss of the flow's derivative, with its time and reason; or the error that ended the run.
    pub lost: Option<Error>,
}

impl OrbitDerivatives {
    /// Derivatives of an orbit from `(t0, x0)` by some variables, to first order: of the states at
    /// `times`, in rising order up to `t_end`, and of times and states at all events.
    ///
    /// Tangent vectors are carried on dual numbers; at transitions and jumps they change by
    /// saltation (Müller, *Chaos, Solitons & Fractals* 5 (1995) 1671). The time of an event with
    /// the function `g` changes by `dt = −∇g·dx / (∂g/∂t + ∇g·f)`. A time that occurs twice, as of
    /// a jump, has the derivative before it and then the one after it.
    ///
    /// The run goes to `t_end`, or as far as the last of `times` if there is one: what a run
    /// reports until then is the same.
    ///
    /// A start on a boundary that the orbit leaves has the derivatives of the side to which it
    /// leaves. At a graze, where two contacts come to zero at once, and where jumps act on one
    /// another at one instant there is no derivative; see [`OrbitDerivatives::lost`].
    ///
    /// ```
    /// use stickslip::analysis::{OrbitDerivatives, Variable};
    /// use stickslip::{Filippov, Options, Scalar, Side};
    ///
    /// /// A block on a belt of speed 0.5, with a spring and friction 1.
    /// struct Block;
    /// impl Filippov<2> for Block {
    ///     fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
    ///         [x[1], -x[0] - side.sign()]
    ///     }
    ///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
    ///         x[1] - 0.5
    ///     }
    /// }
    ///
    /// // It begins in stick at x = 0 and is released at x = 1, after a time of 1/0.5.
    /// let by = [Variable::Start(0), Variable::StartTime];
    /// let (start, options) = ([0.0, 0.5], Options::default());
    /// let by = (&by[..], &[1.0, 3.0][..]);
    /// let found = OrbitDerivatives::of(&Block, 0.0, start, 3.0, by, &[], &options)?;
    /// assert!((found.states[0][(0, 0)] - 1.0).abs() < 1e-12);
    /// // Half a unit further on it is released a whole unit of time earlier.
    /// let release = &found.transitions[0];
    /// assert!((release.t[0] + 2.0).abs() < 1e-9 && (release.t[1] - 1.0).abs() < 1e-9);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of a run that cannot begin; [`Error::Parameter`] for a variable that is no state.
    pub fn of<Kind>(
        system: &impl AsDynamics<Kind>,
        t0: f64,
        x0: impl Components,
        t_end: f64,
        (by, times): (&[Variable], &[f64]),
        sections: &[Section],
        options: &Options,
    ) -> Result<OrbitDerivatives, Error> {
        let start = Moment {
            t: t0,
            x: x0.vector(),
        };
        let system = system.dynamics();
        let of = Differentiated::all(&*system, by);
        of.derivatives(start, t_end, times, sections, options)
    }
}

/// The variables by which an orbit is differentiated, with the system that moves it.
#[derive(Clone, Copy)]
pub struct Differentiated<'a> {
    system: &'a dyn Dynamics,
    extended: &'a dyn Dynamics,
    parameters: &'a [f64],
    by: &'a [Variable],
}

impl<'a> Differentiated<'a> {
    /// An orbit of a system, with parameters that are its last states.
    pub fn all(system: &'a dyn Dynamics, by: &'a [Variable]) -> Self {
        Differentiated {
            system,
            extended: system,
            parameters: &[],
            by,
        }
    }

    /// An orbit of `system`, of which some parameters have these values. `extended` is the same
    /// system with them as further states, which the variables count too. The orbit has the bits
    /// of a run of `system`, and costs no more.
    pub fn with_parameters(
        system: &'a dyn Dynamics,
        (extended, parameters): (&'a dyn Dynamics, &'a [f64]),
        by: &'a [Variable],
    ) -> Self {
        Differentiated {
            system,
            extended,
            parameters,
            by,
        }
    }

    /// The state with the parameters.
    fn extend(&self, x: &Vector) -> Vector {
        let all = x.iter().chain(self.parameters).copied();
        Vector::from_iterator(x.len() + self.parameters.len(), all)
    }

    fn extended_moment(&self, at: &Moment) -> Moment {
        let x = self.extend(&at.x);
        Moment { t: at.t, x }
    }

    fn extended_step(&self, step: &Step) -> Step {
        Step {
            x_start: self.extend(&step.x_start),
            x_end: self.extend(&step.x_end),
            mode: step.mode,
            ..*step
        }
    }
}

impl Differentiated<'_> {
    /// [`OrbitDerivatives::of`] of a system of run-time size, from a start without the parameters.
    /// Rows are the states without them.
    ///
    /// # Errors
    /// As [`OrbitDerivatives::of`].
    pub fn derivatives(
        self,
        start: Moment,
        t_end: f64,
        times: &[f64],
        sections: &[Section],
        options: &Options,
    ) -> Result<OrbitDerivatives, Error> {
        let mut orbit = self.system.begin(&start, t_end, options, sections)?;
        let mut tangents = OrbitTangents::new(self, (&*orbit, &start), sections, options)?;
        let until = times.last().map_or(t_end, |last| last.max(start.t));
        let at_start = times.partition_point(|t| *t <= start.t);
        let (at_start, mut times) = times.split_at(at_start);
        at_start.iter().for_each(|t| tangents.state(*t, &start.x));
        let mut phase = (start.t, start.t, orbit.mode());
        let mut last = start;
        loop {
            match orbit.step() {
                Ok(OrbitProgress::Step) => {
                    let step = orbit.last_step();
                    if step.t_start > until {
                        break;
                    }
                    (phase.1, phase.2) = (step.t_end.min(until), step.mode);
                    // A second time at the end of the step is after a jump there.
                    let before = times.partition_point(|t| *t < step.t_end);
                    let at_end = times[before..].first().filter(|t| **t <= step.t_end);
                    let (now, later) = times.split_at(before + usize::from(at_end.is_some()));
                    times = later;
                    last = step.end();
                    tangents.step(&step, now, &mut *orbit);
                }
                Ok(OrbitProgress::Transition(at)) if at.t > until => break,
                Ok(OrbitProgress::Passage(at)) if at.t > until => {}
                Ok(OrbitProgress::PhaseEnd(ended)) if ended.t_end <= until => {
                    let whole = (ended.t_start, ended.t_end, ended.mode);
                    tangents.found.phases.push(whole);
                    phase = (ended.t_end, ended.t_end, phase.2);
                }
                Ok(OrbitProgress::End(ended)) => {
                    last = Moment {
                        t: ended.t,
                        x: ended.x,
                    };
                    break;
                }
                Ok(progress) => tangents.event(&progress),
                Err(error) => {
                    tangents.lose(error);
                    break;
                }
            }
        }
        if phase.1 > phase.0 {
            tangents.found.phases.push(phase);
        }
        // After the end, as where a jump stands there.
        for t in times {
            let beyond = || last.x.map(|_| f64::NAN);
            match *t <= last.t {
                true => tangents.state(*t, &last.x),
                false => tangents.state(*t, &beyond()),
            }
        }
        Ok(tangents.found)
    }
}

/// The derivatives of the start state.
fn columns_at_start(
    system: &dyn Dynamics,
    orbit: &dyn OrbitUnderWay,
    start: &Moment,
    by: &[Variable],
) -> Result<Vec<Vector>, Error> {
    let (mode, states) = (orbit.mode(), system.states());
    // A later start lags behind the motion. A boundary or a stop that moves takes it along.
    let mut all = TangentMap::identity(system).with(-velocity_in(system, mode, start));
    all.begin(system, mode, start);
    let all = all.matrix();
    let column = |variable: &Variable| match *variable {
        Variable::Start(state) if state < states => Ok(all.column(state).into_owned()),
        Variable::Start(state) => Err(Error::Parameter {
            name: "the state of a derivative",
            value: state as f64,
            bound: "below the number of states",
        }),
        Variable::StartTime => Ok(all.column(states).into_owned()),
    };
    by.iter().map(column).collect()
}

/// Tangent vectors beside an orbit under way, and the derivatives that they have given so far. The
/// vectors are carried over each step after the orbit has taken it, so that the orbit has the bits
/// of a run alone.
///
/// Each step goes to [`OrbitTangents::step`], and every other report to [`OrbitTangents::event`].
pub struct OrbitTangents<'a> {
    of: Differentiated<'a>,
    tangent: Tangent<'a>,
    sections: &'a [Section],
    /// The last step, with the parameters.
    last_step: Option<Step>,
    /// Tangent vectors at the start of the last step; `columns` are the present ones.
    before: Vec<Vector>,
    columns: Vec<Vector>,
    last: LastEvent,
    /// Time and modes of the last transition.
    last_change: Option<(f64, Modes, Modes)>,
    /// Times of the recorded states.
    times: Vec<f64>,
    found: OrbitDerivatives,
}

impl<'a> OrbitTangents<'a> {
    /// Tangent vectors at the start of an orbit of the differentiated system, which has taken no
    /// step and watches these sections.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a variable that is no state.
    pub fn new(
        of: Differentiated<'a>,
        (orbit, start): (&dyn OrbitUnderWay, &Moment),
        sections: &'a [Section],
        options: &Options,
    ) -> Result<Self, Error> {
        let start = of.extended_moment(start);
        Ok(OrbitTangents {
            of,
            tangent: Tangent::new(of.extended, options),
            sections,
            last_step: None,
            before: Vec::new(),
            columns: columns_at_start(of.extended, orbit, &start, of.by)?,
            last: LastEvent::none(),
            last_change: None,
            times: Vec::new(),
            found: OrbitDerivatives::default(),
        })
    }

    /// Number of recorded states.
    pub fn recorded(&self) -> usize {
        self.times.len()
    }

    /// Records a state, without parameters, and its present derivatives.
    fn state(&mut self, t: f64, point: &Vector) {
        self.times.push(t);
        self.found.points.push(point.clone());
        self.found.states.push(self.matrix(&self.columns));
    }

    /// The vectors as columns, without the rows of parameters.
    fn matrix(&self, columns: &[Vector]) -> Matrix {
        let states = self.of.system.states();
        Matrix::from_fn(states, columns.len(), |i, k| columns[k][i])
    }

    /// Loses the derivatives from here on: the orbit has none, or has failed.
    pub fn lose(&mut self, why: Error) {
        for column in self.columns.iter_mut().chain(&mut self.before) {
            column.fill(f64::NAN);
        }
        self.found.lost.get_or_insert(why);
    }

    /// Carries the vectors over the last step of the orbit, and records derivatives at these times.
    /// They rise from the start of the step to its end, and may repeat there.
    pub fn step(&mut self, own: &Step, times: &[f64], orbit: &mut dyn OrbitUnderWay) {
        let (of, tangent) = (self.of, self.tangent);
        let (at_start, times) = times.split_at(times.partition_point(|t| *t <= own.t_start));
        let (inside, at_end) = times.split_at(times.partition_point(|t| *t < own.t_end));
        at_start.iter().for_each(|t| self.state(*t, &own.x_start));
        let step = of.extended_step(own);
        self.before = std::mem::take(&mut self.columns);
        let turning = turning_guards(tangent.system, &step);
        let mut graze = None;
        if !turning.is_empty() || !inside.is_empty() {
            let (mut rest, solution) = (step.clone(), orbit.solution());
            let moment = |t: f64| Moment {
                t,
                x: of.extend(&solution(t)),
            };
            graze = graze_in(&tangent, &turning, &step, &moment);
            self.columns.clone_from(&self.before);
            for &t in inside {
                if let Some(at) = graze.take_if(|at| at.t <= t) {
                    self.lose(singular(at.t, &at.x));
                }
                let part = rest.cut(&moment(t));
                self.columns = tangent.carried(&part, &self.columns);
                self.state(t, &solution(t));
            }
        }
        // Requested times do not affect the derivatives after them.
        self.columns = tangent.carried(&step, &self.before);
        if let Err(error) = check_kinks(tangent.system, &step, &self.before) {
            self.lose(error);
        }
        if let Some(at) = graze {
            self.lose(singular(at.t, &at.x));
        }
        // Where the field has a value and no derivative, as √x at 0.
        if !self.columns.iter().flatten().all(|value| value.is_finite()) {
            self.lose(singular(step.t_start, &step.x_start));
        }
        at_end.iter().for_each(|t| self.state(*t, &own.x_end));
        self.last_step = Some(step);
    }

    /// Takes another report than a step: transitions and passages have derivatives. A change of
    /// modes that is reported once for each contact has them for each, but acts once.
    pub fn event(&mut self, progress: &OrbitProgress) {
        match progress {
            OrbitProgress::Transition(at) => {
                let change = (at.t, at.from, at.to);
                let is_known = at.from != at.to && self.last_change == Some(change);
                self.last_change = Some(change);
                if let Some(last) = self.found.transitions.last().filter(|_| is_known).cloned() {
                    let before = last.after.clone();
                    self.found
                        .transitions
                        .push(EventDerivatives { before, ..last });
                    return;
                }
                let mut at = at.clone();
                at.x = self.of.extend(&at.x);
                if let Err(error) = self.transition(&at) {
                    self.lose(error);
                }
            }
            OrbitProgress::Passage(at) => self.passage(at),
            _ => {}
        }
    }

    /// The derivatives at the points and events of a record of the same orbit, which ended so and
    /// may have been cut.
    pub fn finish<T>(
        mut self,
        orbit: &RecordedOrbit,
        ended: &Result<T, Error>,
    ) -> OrbitDerivatives {
        if let Err(error) = ended {
            self.lose(error.clone());
        }
        let count = orbit.point_count();
        self.found.transitions.truncate(orbit.transitions().count());
        self.found.passages.truncate(orbit.passages.len());
        let Some((t, x)) = orbit.points().next_back() else {
            return self.found;
        };
        let known = self
            .times
            .get(count - 1)
            .zip(self.found.points.get(count - 1));
        let is_known = known.is_some_and(|(of, point)| *of == t && point.as_slice() == x);
        self.found.states.truncate(count);
        self.found.points.truncate(count);
        if !is_known {
            // The record ends after a jump there, or within the last step.
            let at = self.of.extended_moment(&orbit.end);
            let inside = self.last_step.take().filter(|step| at.t < step.t_end);
            if let Some(step) = inside {
                self.columns = self.inside(&step, &at);
            }
            self.found.states.truncate(count - 1);
            self.found.points.truncate(count - 1);
            self.state(t, &orbit.end.x);
        }
        self.found
    }

    /// The vectors at a moment in the last step.
    fn inside(&self, step: &Step, at: &Moment) -> Vec<Vector> {
        let part = Step {
            t_end: at.t,
            x_end: at.x.clone(),
            ..step.clone()
        };
        self.tangent.carried(&part, &self.before)
    }

    /// Records the derivatives at a transition, and applies it to the vectors.
    fn transition(&mut self, at: &Transition) -> Result<(), Error> {
        let system = self.tangent.system;
        let here = at.moment();
        let velocity = velocity_in(system, at.from, &here);
        let cause = self.last.cause_of(system, at);
        let end = SegmentEnd::of(system, at, cause);
        let (gradient, in_time) = match end.at_kink {
            Some((input, _)) => {
                let (_, gradient, in_time) = system.clock(input, &here);
                (gradient, in_time)
            }
            None if end.is_of_jump => {
                let reset = system.reset(at.contact, &here);
                (reset.gradient, reset.in_time)
            }
            None => system.flow(at.from, &here).guard_gradient(end.guard, &here),
        };
        let jump = match is_graze(&self.tangent, at, &end, cause) {
            true => Err(singular(at.t, &at.x)),
            false => self.tangent.passed(at, cause, &self.columns),
        };
        let (t, before) = of_zero(&self.columns, &velocity, (&gradient, in_time));
        let jump = match jump {
            Ok(jump) => jump,
            Err(why) => {
                let lost: Vec<Vector> = before.iter().map(|one| one.map(|_| f64::NAN)).collect();
                let none = vec![f64::NAN; t.len()];
                let of = self.of_event([&here.x; 2], none, [&lost; 2], at.t);
                self.found.transitions.push(of);
                return Err(why);
            }
        };
        let mut after_jump = here.clone();
        if end.is_of_jump {
            after_jump.x = system.reset(at.contact, &after_jump).after;
        }
        if let Some(jump) = jump {
            for column in &mut self.columns {
                *column = &jump.matrix * &*column;
                // On Σ the component across it is zero, except for rounding.
                if at.kind == TransitionKind::StickEntry && end.at_kink.is_none() {
                    flatten(&jump.gradient, column);
                }
            }
        }
        let velocity = velocity_in(system, at.to, &after_jump);
        let after = moved(&self.columns, &velocity, &t);
        let of = self.of_event([&here.x, &after_jump.x], t, [&before, &after], at.t);
        self.found.transitions.push(of);
        Ok(())
    }

    /// Derivatives at an event, without the rows of parameters.
    fn of_event(
        &self,
        points: [&Vector; 2],
        t: Vec<f64>,
        [before, after]: [&[Vector]; 2],
        at: f64,
    ) -> EventDerivatives {
        let states = self.of.system.states();
        EventDerivatives {
            at,
            t,
            points: points.map(|x| x.rows(0, states).into_owned()),
            before: self.matrix(before),
            after: self.matrix(after),
        }
    }

    /// Records the derivatives at a passage in the last step.
    fn passage(&mut self, at: &Passage) {
        let Some(step) = &self.last_step else {
            return;
        };
        let system = self.tangent.system;
        let here = self.of.extended_moment(&at.moment());
        let columns = self.inside(step, &here);
        let velocity = velocity_in(system, step.mode, &here);
        let slopes = system.section_gradient(&self.sections[at.number], &here);
        let (t, there) = of_zero(&columns, &velocity, (&slopes.0, slopes.1));
        let of = self.of_event([&here.x; 2], t, [&there; 2], at.t);
        self.found.passages.push((at.number, of));
    }
}

/// Derivatives of the time at which a function vanishes, and of the state there.
fn of_zero(
    columns: &[Vector],
    velocity: &Vector,
    (gradient, in_time): (&Vector, f64),
) -> (Vec<f64>, Vec<Vector>) {
    let rate = in_time + gradient.dot(velocity);
    let of = |column: &Vector| -gradient.dot(column) / rate;
    let times: Vec<f64> = columns.iter().map(of).collect();
    let state = moved(columns, velocity, &times);
    (times, state)
}

/// Vectors at a fixed time, moved to a time that has these derivatives.
fn moved(columns: &[Vector], velocity: &Vector, times: &[f64]) -> Vec<Vector> {
    let columns = columns.iter().zip(times);
    columns
        .map(|(column, dt)| column + velocity * *dt)
        .collect()
}
