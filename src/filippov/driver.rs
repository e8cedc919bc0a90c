//! The driver: from phase to phase by the switching rules.

use std::marker::PhantomData;
use std::ops::ControlFlow;

use num_dual::Dual;

use super::flow::{
    CONTACT, Flow, MOST_GUARDS, Slip, Stick, boundary_gradient, project, sliding_field,
};
use super::march::{PhaseEnd, Run};
use super::observer::{Observer, Phase, StepRecord, Transition, TransitionKind};
use super::options::{AtRepelling, Method, Options};
use super::pile_up::PileUp;
use super::rules::{Departure, Fate, LieDerivatives, departure};
use super::taylor::TaylorStepper;
use crate::error::{Error, Point};
use crate::ode::{Dop853, Rk4, RungeKutta, Timed};
use crate::orbit::{Counters, Ending, Orbit};
use crate::system::{Filippov, Mode, Side, State};

/// How and where a streamed run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary<const N: usize> {
    /// Why it ended.
    pub ending: Ending,
    /// Last time.
    pub t: f64,
    /// Last state.
    pub x: State<f64, N>,
    /// Work done.
    pub counters: Counters,
}

/// A run that failed, with the orbit up to the failure.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{error}")]
pub struct Failure<const N: usize> {
    /// What went wrong.
    #[source]
    pub error: Error,
    /// What was computed before; its ending is [`Ending::Failed`].
    pub orbit: Box<Orbit<N>>,
}

impl<const N: usize> From<Failure<N>> for Error {
    fn from(failure: Failure<N>) -> Error {
        failure.error
    }
}

/// Integrates `system` from `(t0, x0)` to `t_end` and keeps the whole orbit.
///
/// The start may lie anywhere: on either side, on Σ, at a tangent point.
///
/// ```
/// use stickslip::{models::BeltOscillator, solve, Options, State};
///
/// let belt = BeltOscillator { belt_speed: 0.4, ..BeltOscillator::default() };
/// let orbit = solve(&belt, 0.0, State::from([0.5, 1.5]), 30.0, &Options::tol(1e-12))?;
/// for stick in orbit.sticks() {
///     let length = stick.displacement()[0];
///     assert!((length - 0.4 * stick.duration()).abs() < 1e-14);
/// }
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// [`Failure`] holds the [`Error`] and the orbit up to it; `?` turns it into the error alone.
pub fn solve<S: Filippov<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: State<f64, N>,
    t_end: f64,
    options: &Options,
) -> Result<Orbit<N>, Failure<N>> {
    let mut recorder = Recorder {
        phases: Vec::new(),
        transitions: Vec::new(),
        steps: Vec::new(),
        open: None,
    };
    let (result, counters) = run_counted(system, t0, x0, t_end, options, &mut recorder);
    let last = recorder.steps.last();
    let (t, x) = last.map_or((t0, x0), |step| (step.t_end, step.x_end));
    // A failure leaves the current phase unfinished; what was reached of it is kept.
    if result.is_err()
        && let Some(open) = recorder.open.take()
    {
        recorder.phases.push(open);
    }
    let ending = result
        .as_ref()
        .map_or(Ending::Failed, |summary| summary.ending);
    let orbit = Orbit {
        phases: recorder.phases,
        transitions: recorder.transitions,
        steps: recorder.steps,
        counters,
        ending,
        t_start: t0,
        t_end: t,
        x_start: x0,
        x_end: x,
    };
    match result {
        Ok(_) => Ok(orbit),
        Err(error) => Err(Failure {
            error,
            orbit: Box::new(orbit),
        }),
    }
}

/// Integrates `system` from `(t0, x0)` to `t_end`, telling `observer` of every step, transition and phase and keeping
/// nothing: for runs too long to hold.
///
/// # Errors
/// [`Error::Option`], [`Error::Interval`] and [`Error::StartOutsideDomain`] before the first step;
/// [`Error::NonFinite`], [`Error::StepCollapse`], [`Error::EventPileUp`] and [`Error::Escaped`] on the way.
pub fn run<S: Filippov<N>, O: Observer<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: State<f64, N>,
    t_end: f64,
    options: &Options,
    observer: &mut O,
) -> Result<Summary<N>, Error> {
    run_counted(system, t0, x0, t_end, options, observer).0
}

/// [`run`], with the work done even where it failed.
fn run_counted<S: Filippov<N>, O: Observer<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: State<f64, N>,
    t_end: f64,
    options: &Options,
    observer: &mut O,
) -> (Result<Summary<N>, Error>, Counters) {
    let mut run = Run {
        options,
        observer,
        counters: Counters::default(),
        pile_up: PileUp::new(),
        t_end,
        h: 0.0,
    };
    let start = Timed { t: t0, x: x0 };
    let result = check(system, &start, t_end, options).and_then(|()| match options.method {
        Method::Dop853 | Method::Dop853Fixed { .. } => {
            run.drive(&mut BySlopes::<Dop853>(PhantomData), system, start)
        }
        Method::Rk4 { .. } => run.drive(&mut BySlopes::<Rk4>(PhantomData), system, start),
        Method::Taylor => run.drive(&mut TaylorStepper::new(options), system, start),
    });
    (result, run.counters)
}

fn check<S: Filippov<N>, const N: usize>(
    system: &S,
    start: &Timed<f64, N>,
    t_end: f64,
    options: &Options,
) -> Result<(), Error> {
    options.check()?;
    let Timed { t, x } = *start;
    if !(t.is_finite() && t_end.is_finite() && t < t_end) {
        return Err(Error::Interval { t0: t, t_end });
    }
    let outside = |what: &'static str| Error::StartOutsideDomain {
        t,
        x: Point::from(&x),
        what,
    };
    if x.iter().any(|v| !v.is_finite()) {
        return Err(outside("the start itself is not finite"));
    }
    let h = system.boundary(t, &x);
    if !h.is_finite() {
        return Err(outside("the boundary function is not finite there"));
    }
    if h == 0.0 {
        let (gradient, in_time) = boundary_gradient(system, t, &x);
        if gradient.iter().all(|&slope| slope == 0.0) && in_time == 0.0 {
            return Err(outside(
                "the boundary function is zero there and has no slope, so it marks no boundary",
            ));
        }
    }
    // On Σ both fields matter, off it only one need exist.
    for side in [Side::Below, Side::Above] {
        let matters = h * side.sign() >= 0.0;
        if matters && system.field(side, t, &x).iter().any(|v| !v.is_finite()) {
            return Err(outside("the field is not finite there"));
        }
    }
    if x.iter().any(|v| v.abs() > options.escape) {
        let (x, bound) = (Point::from(&x), options.escape);
        return Err(Error::Escaped { t, x, bound });
    }
    Ok(())
}

/// What carries a run through one phase.
pub(crate) trait Stepper<const N: usize> {
    /// Integrates `flow` from `start` until a guard fails; see [`Run::march`].
    fn march<F: Flow<N>, O: Observer<N>>(
        &mut self,
        run: &mut Run<'_, O>,
        flow: &F,
        mode: Mode,
        start: Timed<f64, N>,
        orders: [usize; MOST_GUARDS],
    ) -> Result<PhaseEnd<N>, Error>;
}

/// Runge–Kutta steps.
struct BySlopes<M>(PhantomData<M>);

impl<M: RungeKutta, const N: usize> Stepper<N> for BySlopes<M> {
    #[inline(always)]
    fn march<F: Flow<N>, O: Observer<N>>(
        &mut self,
        run: &mut Run<'_, O>,
        flow: &F,
        mode: Mode,
        start: Timed<f64, N>,
        orders: [usize; MOST_GUARDS],
    ) -> Result<PhaseEnd<N>, Error> {
        run.march::<M, F, N>(flow, mode, start, orders)
    }
}

/// Where the run goes from a point of Σ.
enum Course {
    On(Mode, [usize; MOST_GUARDS]),
    Repelled,
}

impl<O> Run<'_, O> {
    fn drive<P: Stepper<N>, S: Filippov<N>, const N: usize>(
        &mut self,
        stepper: &mut P,
        system: &S,
        start: Timed<f64, N>,
    ) -> Result<Summary<N>, Error>
    where
        O: Observer<N>,
    {
        let mut at = start;
        let (mut mode, mut orders) = match self.first_course(system, &at) {
            Course::On(mode, orders) => (mode, orders),
            Course::Repelled => return Ok(self.summary(Ending::Repelling, at)),
        };
        let mut contact = contact_sign(system, &at);
        let mut from = at;
        loop {
            let end = match mode {
                Mode::Slip(Side::Below) => {
                    let flow = Slip::<S, false> { system, contact };
                    stepper.march(self, &flow, mode, at, orders)?
                }
                Mode::Slip(Side::Above) => {
                    let flow = Slip::<S, true> { system, contact };
                    stepper.march(self, &flow, mode, at, orders)?
                }
                Mode::Stick => {
                    at.x = project(system, at.t, at.x);
                    let flow = Stick { system, contact };
                    stepper.march(self, &flow, mode, at, orders)?
                }
            };
            let (reached, ending) = match &end {
                PhaseEnd::Time(at) => (*at, Some(Ending::EndTime)),
                PhaseEnd::Stopped(at) => (*at, Some(Ending::Stopped)),
                PhaseEnd::Exit { at, .. } => (*at, None),
            };
            at = reached;
            if let PhaseEnd::Exit {
                guard: CONTACT,
                residual,
                orders: departures,
                ..
            } = end
            {
                self.note_event(&at, &velocity(system, mode, &at))?;
                let change = Transition {
                    t: at.t,
                    x: at.x,
                    kind: if contact > 0.0 {
                        TransitionKind::ContactLoss
                    } else {
                        TransitionKind::ContactGain
                    },
                    from: mode,
                    to: mode,
                    residual,
                };
                if self.observer.transition(&change).is_break() {
                    return Ok(self.summary(Ending::Stopped, at));
                }
                contact = -contact;
                orders = departures;
                orders[CONTACT] = 1;
                continue;
            }
            let phase = Phase {
                mode,
                t_start: from.t,
                t_end: at.t,
                x_start: from.x,
                x_end: at.x,
            };
            let told = self.observer.phase(&phase);
            if let Some(ending) = ending {
                return Ok(self.summary(ending, at));
            }
            let PhaseEnd::Exit {
                guard, residual, ..
            } = end
            else {
                return Ok(self.summary(Ending::EndTime, at));
            };
            let tangent = (mode == Mode::Stick).then(|| Stick::<S>::side_of_guard(guard));
            self.counters.field_calls += 2 * LieDerivatives::field_calls(N);
            let (next, next_orders) = match self.course(self.departure(system, &at, tangent)) {
                Course::On(next, orders) => (next, orders),
                Course::Repelled => return Ok(self.summary(Ending::Repelling, at)),
            };
            self.note_event(&at, &velocity(system, next, &at))?;
            let transition = Transition {
                t: at.t,
                x: at.x,
                kind: kind(mode, next),
                from: mode,
                to: next,
                residual,
            };
            if self.observer.transition(&transition).is_break() || told.is_break() {
                return Ok(self.summary(Ending::Stopped, at));
            }
            (mode, orders, from) = (next, next_orders, at);
        }
    }

    fn summary<const N: usize>(&self, ending: Ending, at: Timed<f64, N>) -> Summary<N> {
        Summary {
            ending,
            t: at.t,
            x: at.x,
            counters: self.counters,
        }
    }

    /// Off Σ the side decides; on it, to rounding, the rules.
    fn first_course<S: Filippov<N>, const N: usize>(
        &self,
        system: &S,
        at: &Timed<f64, N>,
    ) -> Course {
        let h = system.boundary(at.t, &at.x);
        let side = if h < 0.0 { Side::Below } else { Side::Above };
        if !LieDerivatives::new(system, side, at.t, &at.x, self.slack()).on_boundary() {
            return Course::On(Mode::Slip(side), [0; MOST_GUARDS]);
        }
        let departure = self.departure(system, at, None);
        self.course(departure)
    }

    /// A state this near to where it should be is there: a thousandth of what error control lets pass.
    fn slack(&self) -> f64 {
        1e-3 * self.options.atol
    }

    fn departure<S: Filippov<N>, const N: usize>(
        &self,
        system: &S,
        at: &Timed<f64, N>,
        tangent: Option<Side>,
    ) -> Departure {
        let below = LieDerivatives::new(system, Side::Below, at.t, &at.x, self.slack());
        let above = LieDerivatives::new(system, Side::Above, at.t, &at.x, self.slack());
        departure(&below, &above, tangent)
    }

    fn course(&self, departure: Departure) -> Course {
        let orders = departure.orders;
        match (departure.fate, self.options.at_repelling) {
            (Fate::Slip(side), _) => Course::On(Mode::Slip(side), orders),
            (Fate::Stick, _) => Course::On(Mode::Stick, orders),
            (Fate::Repelling, AtRepelling::Stop) => Course::Repelled,
            (Fate::Repelling, AtRepelling::GoBelow) => {
                Course::On(Mode::Slip(Side::Below), [orders[0] + 1, 0, 0])
            }
            (Fate::Repelling, AtRepelling::GoAbove) => {
                Course::On(Mode::Slip(Side::Above), [orders[1] + 1, 0, 0])
            }
        }
    }
}

/// Sign of the contact function; where it is zero, of its rate along the mean of the two fields.
fn contact_sign<S: Filippov<N>, const N: usize>(system: &S, at: &Timed<f64, N>) -> f64 {
    let below = system.field(Side::Below, at.t, &at.x);
    let above = system.field(Side::Above, at.t, &at.x);
    let path =
        State::<Dual<f64>, N>::from_fn(|i, _| Dual::new(at.x[i], 0.5 * (below[i] + above[i])));
    match system.contact(Dual::new(at.t, 1.0), &path) {
        Some(contact) if contact.re < 0.0 || contact.re == 0.0 && contact.eps < 0.0 => -1.0,
        _ => 1.0,
    }
}

/// The vector that moves the state in a mode.
fn velocity<S: Filippov<N>, const N: usize>(
    system: &S,
    mode: Mode,
    at: &Timed<f64, N>,
) -> State<f64, N> {
    match mode {
        Mode::Slip(side) => system.field(side, at.t, &at.x),
        Mode::Stick => sliding_field(system, at.t, &at.x),
    }
}

fn kind(from: Mode, to: Mode) -> TransitionKind {
    match (from, to) {
        (Mode::Slip(before), Mode::Slip(after)) if before != after => TransitionKind::Crossing,
        (Mode::Slip(_), Mode::Stick) => TransitionKind::StickEntry,
        (Mode::Stick, Mode::Slip(_)) => TransitionKind::StickExit,
        _ => TransitionKind::Touch,
    }
}

/// Keeps everything.
struct Recorder<const N: usize> {
    phases: Vec<Phase<N>>,
    transitions: Vec<Transition<N>>,
    steps: Vec<StepRecord<N>>,
    /// The phase under way.
    open: Option<Phase<N>>,
}

impl<const N: usize> Observer<N> for Recorder<N> {
    fn step(&mut self, step: &StepRecord<N>) -> ControlFlow<()> {
        self.steps.push(*step);
        let open = self.open.get_or_insert(Phase {
            mode: step.mode,
            t_start: step.t_start,
            t_end: step.t_end,
            x_start: step.x_start,
            x_end: step.x_end,
        });
        (open.t_end, open.x_end) = (step.t_end, step.x_end);
        ControlFlow::Continue(())
    }

    fn transition(&mut self, transition: &Transition<N>) -> ControlFlow<()> {
        self.transitions.push(*transition);
        ControlFlow::Continue(())
    }

    fn phase(&mut self, phase: &Phase<N>) -> ControlFlow<()> {
        self.open = None;
        self.phases.push(*phase);
        ControlFlow::Continue(())
    }
}
