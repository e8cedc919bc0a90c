//! The driver: from phase to phase by the switching rules.

use std::marker::PhantomData;
use std::ops::ControlFlow;

use super::flow::{Flow, MOST_GUARDS, boundary_gradient};
use super::journey::{Journey, on_flow};
use super::march::{PhaseEnd, Run};
use super::observer::{Observer, Phase, StepRecord, Transition};
use super::options::{Method, Options};
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
    let mut run = Run::new(options, observer, t_end);
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

pub(super) fn check<S: Filippov<N>, const N: usize>(
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
        let mut journey = match Journey::begin(self, system, start) {
            Ok(journey) => journey,
            Err(ended) => return Ok(ended),
        };
        loop {
            let Journey {
                mode, at, orders, ..
            } = journey;
            let end = on_flow!(journey, system, |flow| stepper
                .march(self, flow, mode, at, orders)?);
            if let Some(summary) = journey.turn(self, system, end)? {
                return Ok(summary);
            }
        }
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
