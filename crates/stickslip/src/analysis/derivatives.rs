//! Derivatives of an orbit and of the times of its events.

use super::cycle::SegmentEnd;
use super::graze::{graze_in, is_graze, turning_guards};
use super::instant::LastEvent;
use super::monodromy::{TangentMap, velocity_in};
use super::simultaneous::check_kinks;
use super::tangent::{Tangent, flatten, singular};
use crate::dynamics::{
    AsDynamics, Components, Dynamics, Matrix, Modes, Moment, OrbitProgress, OrbitUnderWay, Passage,
    Section, Step, Transition, Vector,
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

/// Derivatives along an orbit, as [`orbit_derivatives`] computes them. Rows are states and columns
/// variables. From [`OrbitDerivatives::lost`] on all are NaN.
#[derive(Clone, Debug)]
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

/// Derivatives of an orbit from `(t0, x0)` by some variables, to first order: of the states at
/// `times`, in rising order up to `t_end`, and of times and states at all events.
///
/// Tangent vectors are carried on dual numbers; at transitions and jumps they change by saltation
/// (Müller, *Chaos, Solitons & Fractals* 5 (1995) 1671). The time of an event with the function `g`
/// changes by `dt = −∇g·dx / (∂g/∂t + ∇g·f)`. A time that occurs twice, as of a jump, has the
/// derivative before it and then the one after it.
///
/// The run goes to `t_end`, or as far as the last of `times` if there is one: what a run reports
/// until then is the same.
///
/// A start on a boundary that the orbit leaves has the derivatives of the side to which it leaves.
/// At a graze, where two contacts come to zero at once, and where jumps act on one another at one
/// instant there is no derivative; see [`OrbitDerivatives::lost`].
///
/// ```
/// use stickslip::analysis::{Variable, orbit_derivatives};
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
/// let found = orbit_derivatives(&Block, 0.0, start, 3.0, (&by, &[1.0, 3.0]), &[], &options)?;
/// assert!((found.states[0][(0, 0)] - 1.0).abs() < 1e-12);
/// // Half a unit further on it is released a whole unit of time earlier.
/// let release = &found.transitions[0];
/// assert!((release.t[0] + 2.0).abs() < 1e-9 && (release.t[1] - 1.0).abs() < 1e-9);
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// Those of a run that cannot begin; [`Error::Parameter`] for a variable that is no state.
pub fn orbit_derivatives<Kind>(
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
    orbit_derivatives_of(of, start, t_end, times, sections, options)
}

/// What an orbit is differentiated by, with the system that moves it.
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
    fn extend(&self, x: Vector) -> Vector {
        match self.parameters {
            [] => x,
            parameters => Vector::from_iterator(
                x.len() + parameters.len(),
                x.iter().chain(parameters).copied(),
            ),
        }
    }

    fn extended_moment(&self, at: Moment) -> Moment {
        let x = self.extend(at.x);
        Moment { x, ..at }
    }

    fn extended_step(&self, step: Step) -> Step {
        Step {
            x_start: self.extend(step.x_start),
            x_end: self.extend(step.x_end),
            ..step
        }
    }
}

/// [`orbit_derivatives`] of a system of run-time size, from a start without the parameters.
///
/// # Errors
/// As [`orbit_derivatives`].
pub fn orbit_derivatives_of(
    of: Differentiated<'_>,
    start: Moment,
    t_end: f64,
    times: &[f64],
    sections: &[Section],
    options: &Options,
) -> Result<OrbitDerivatives, Error> {
    let (t0, system) = (start.t, of.extended);
    let mut orbit = of.system.begin(&start, t_end, options, sections)?;
    let start = of.extended_moment(start);
    let mut carried = OrbitTangents {
        tangent: Tangent::new(system, options),
        before: Vec::new(),
        columns: columns_at_start(system, &*orbit, &start, of.by)?,
        last: LastEvent::none(),
        sections,
        found: OrbitDerivatives {
            states: Vec::with_capacity(times.len()),
            points: Vec::with_capacity(times.len()),
            phases: Vec::new(),
            transitions: Vec::new(),
            passages: Vec::new(),
            lost: None,
        },
    };
    let until = times.last().map_or(t_end, |last| last.max(t0));
    let mut times = times.iter().copied().peekable();
    while times.next_if(|t| *t <= t0).is_some() {
        carried.state(start.x.clone());
    }
    let mut phase = (t0, t0, orbit.mode());
    let mut last = start;
    loop {
        match orbit.step() {
            Ok(OrbitProgress::Step) => {
                let step = of.extended_step(orbit.last_step());
                if step.t_start > until {
                    break;
                }
                while times.next_if(|t| *t <= step.t_start).is_some() {
                    carried.state(step.x_start.clone());
                }
                (phase.1, phase.2) = (step.t_end.min(until), step.mode);
                carried.before = std::mem::take(&mut carried.columns);
                let turning = turning_guards(system, &step);
                let mut graze = None;
                if !turning.is_empty() || times.peek().is_some_and(|t| *t < step.t_end) {
                    let (mut rest, solution) = (step.clone(), orbit.solution());
                    let moment = |t: f64| Moment {
                        t,
                        x: of.extend(solution(t)),
                    };
                    graze = graze_in(&carried.tangent, &turning, &step, &moment);
                    carried.columns.clone_from(&carried.before);
                    while let Some(t) = times.next_if(|t| *t < step.t_end) {
                        if let Some(at) = graze.take_if(|at| at.t <= t) {
                            carried.lose(singular(at.t, &at.x));
                        }
                        let part = rest.cut(&moment(t));
                        carried.columns = carried.tangent.carried(&part, &carried.columns);
                        carried.state(part.x_end);
                    }
                }
                // Requested times do not affect the derivatives after them.
                carried.columns = carried.tangent.carried(&step, &carried.before);
                if let Err(error) = check_kinks(system, &step, &carried.before) {
                    carried.lose(error);
                }
                if let Some(at) = graze {
                    carried.lose(singular(at.t, &at.x));
                }
                if times.next_if(|t| *t <= step.t_end).is_some() {
                    carried.state(step.x_end.clone());
                }
                last = Moment {
                    t: step.t_end,
                    x: step.x_end,
                };
            }
            Ok(OrbitProgress::Transition(at)) if at.t > until => break,
            Ok(OrbitProgress::Transition(mut at)) => {
                at.x = of.extend(at.x);
                if let Err(error) = carried.transition(&at) {
                    carried.lose(error);
                }
            }
            Ok(OrbitProgress::Passage(at)) if at.t > until => {}
            Ok(OrbitProgress::Passage(mut at)) => {
                at.x = of.extend(at.x);
                let step = of.extended_step(orbit.last_step());
                carried.passage(&step, &at);
            }
            Ok(OrbitProgress::PhaseEnd(ended)) if ended.t_end <= until => {
                carried
                    .found
                    .phases
                    .push((ended.t_start, ended.t_end, ended.mode));
                phase = (ended.t_end, ended.t_end, phase.2);
            }
            Ok(OrbitProgress::PhaseEnd(_) | OrbitProgress::Kink(_)) => {}
            Ok(OrbitProgress::End(ended)) => {
                last = Moment {
                    t: ended.t,
                    x: of.extend(ended.x),
                };
                break;
            }
            Err(error) => {
                carried.lose(error);
                break;
            }
        }
    }
    if phase.1 > phase.0 {
        carried.found.phases.push(phase);
    }
    // After the end, as where a jump stands there.
    for t in times {
        let is_reached = t <= last.t;
        let beyond = || last.x.map(|_| f64::NAN);
        carried.state(if is_reached { last.x.clone() } else { beyond() });
    }
    Ok(carried.found)
}

/// The derivatives of the start state.
fn columns_at_start(
    system: &dyn Dynamics,
    orbit: &dyn OrbitUnderWay,
    start: &Moment,
    by: &[Variable],
) -> Result<Vec<Vector>, Error> {
    let mode = orbit.mode();
    let mut all = TangentMap::identity(system);
    all.begin(system, mode, start);
    let all = all.matrix();
    let column = |variable: &Variable| match *variable {
        Variable::Start(state) if state < all.ncols() => Ok(all.column(state).into_owned()),
        Variable::Start(state) => Err(Error::Parameter {
            name: "the state of a derivative",
            value: state as f64,
            bound: "below the number of states",
        }),
        Variable::StartTime => Ok(-velocity_in(system, mode, start)),
    };
    by.iter().map(column).collect()
}

/// Tangent vectors beside an orbit, and what they have given so far.
struct OrbitTangents<'a> {
    tangent: Tangent<'a>,
    /// Tangent vectors at the start of the last step; `columns` are the present ones.
    before: Vec<Vector>,
    columns: Vec<Vector>,
    last: LastEvent,
    sections: &'a [Section],
    found: OrbitDerivatives,
}

impl OrbitTangents<'_> {
    /// Records a state and its present derivatives.
    fn state(&mut self, point: Vector) {
        let states = point.len();
        self.found.points.push(point);
        self.found.states.push(matrix(states, &self.columns));
    }

    /// Nothing is known from here on.
    fn lose(&mut self, why: Error) {
        for column in self.columns.iter_mut().chain(&mut self.before) {
            column.fill(f64::NAN);
        }
        self.found.lost.get_or_insert(why);
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
        let jump = match is_graze(&self.tangent, at, &end) {
            true => Err(singular(at.t, &at.x)),
            false => self.tangent.passed(at, cause, &self.columns),
        };
        let (t, before) = of_zero(&self.columns, &velocity, (&gradient, in_time));
        let jump = match jump {
            Ok(jump) => jump,
            Err(why) => {
                let none = before.map(|_| f64::NAN);
                self.found.transitions.push(EventDerivatives {
                    at: at.t,
                    t: vec![f64::NAN; t.len()],
                    points: [here.x.clone(), here.x],
                    before: none.clone(),
                    after: none,
                });
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
        self.found.transitions.push(EventDerivatives {
            at: at.t,
            t,
            points: [here.x, after_jump.x],
            before,
            after,
        });
        Ok(())
    }

    /// Records the derivatives at a passage in the last step.
    fn passage(&mut self, step: &Step, at: &Passage) {
        let system = self.tangent.system;
        let here = at.moment();
        let columns = self.inside(step, &here);
        let velocity = velocity_in(system, step.mode, &here);
        let slopes = system.section_gradient(&self.sections[at.number], &here);
        let (t, before) = of_zero(&columns, &velocity, (&slopes.0, slopes.1));
        let after = before.clone();
        let of_event = EventDerivatives {
            at: at.t,
            t,
            points: [here.x.clone(), here.x],
            before,
            after,
        };
        self.found.passages.push((at.number, of_event));
    }
}

/// Derivatives of the time at which a function vanishes, and of the state there.
fn of_zero(
    columns: &[Vector],
    velocity: &Vector,
    (gradient, in_time): (&Vector, f64),
) -> (Vec<f64>, Matrix) {
    let rate = in_time + gradient.dot(velocity);
    let of = |column: &Vector| -gradient.dot(column) / rate;
    let times: Vec<f64> = columns.iter().map(of).collect();
    let state = moved(columns, velocity, &times);
    (times, state)
}

/// Vectors at a fixed time, moved to a time that has these derivatives.
fn moved(columns: &[Vector], velocity: &Vector, times: &[f64]) -> Matrix {
    let columns = columns.iter().zip(times);
    let columns: Vec<Vector> = columns
        .map(|(column, dt)| column + velocity * *dt)
        .collect();
    matrix(velocity.len(), &columns)
}

/// The matrix of these columns, of which there may be none.
fn matrix(rows: usize, columns: &[Vector]) -> Matrix {
    match columns {
        [] => Matrix::zeros(rows, 0),
        columns => Matrix::from_columns(columns),
    }
}
