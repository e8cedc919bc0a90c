//! Runs as loops over [`Integration::step`]: one stores the whole orbit, one stores nothing.

use super::integration::{Integration, Progress};
use super::observer::Observer;
use super::options::Options;
use super::switched::Switched;
use crate::error::Error;
use crate::orbit::{Ending, Orbit, Summary};
use crate::system::IntoState;

/// A run that failed, and what was computed before: the [`Orbit`] of [`solve`], the [`Summary`] of
/// [`run`] and of [`crate::ensemble`].
///
/// `?` turns it into the error alone.
///
/// ```
#[doc = include_str!("../../examples/common/belt.rs")]
/// use stickslip::{Error, Options, solve};
///
/// // The belt takes the block further than that.
/// let options = Options::default().escape(1.0);
/// let failure = solve(&Belt { speed: 1.0 }, 0.0, [0.5, 0.9], 50.0, &options).unwrap_err();
/// assert!(matches!(failure.error, Error::Escaped { .. }));
/// println!("{failure}; it came to t = {}", failure.partial.t_end);
/// ```
#[derive(Clone, Debug, thiserror::Error)]
#[error("{error}")]
pub struct Failure<R> {
    /// The error.
    #[source]
    pub error: Error,
    /// Orbit up to the failure; its ending is [`Ending::Failed`].
    pub partial: Box<R>,
}

impl<R> From<Failure<R>> for Error {
    fn from(failure: Failure<R>) -> Error {
        failure.error
    }
}

impl<R> Failure<R> {
    pub(super) fn new(error: Error, partial: R) -> Self {
        let partial = Box::new(partial);
        Failure { error, partial }
    }
}

/// Integrates `system` from `(t0, x0)` to `t_end` and stores the whole orbit.
///
/// The start may lie anywhere: on either side, on Σ, at a tangent point.
///
/// ```
#[doc = include_str!("../../examples/common/belt.rs")]
/// use stickslip::{Options, solve};
///
/// let belt = Belt { speed: 0.4 };
/// let orbit = solve(&belt, 0.0, [0.5, 1.5], 30.0, &Options::tol(1e-12))?;
/// for stick in orbit.sticks() {
///     let length = stick.displacement()[0];
///     assert!((length - 0.4 * stick.duration()).abs() < 1e-14);
/// }
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// As [`run`]; [`Failure::partial`] is the orbit up to the failure.
pub fn solve<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    t0: f64,
    x0: impl IntoState<N>,
    t_end: f64,
    options: &Options,
) -> Result<Orbit<N, S::Mode>, Failure<Orbit<N, S::Mode>>> {
    let x0 = x0.into_state();
    let mut orbit = Orbit::before_first_step(t0, x0);
    match fill(system, t_end, options, &mut orbit) {
        Ok(()) => Ok(orbit),
        Err(error) => Err(Failure::new(error, orbit)),
    }
}

/// Fills an orbit that holds its start and nothing else.
fn fill<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    t_end: f64,
    options: &Options,
    orbit: &mut Orbit<N, S::Mode>,
) -> Result<(), Error> {
    let (t0, x0) = (orbit.t_start, orbit.x_start);
    let mut integration = Integration::new(system, t0, x0, t_end, options)?;
    loop {
        let progress = integration.step();
        if store(orbit, &mut integration, progress)? {
            return Ok(());
        }
    }
}

/// Stores the progress of an integration, and returns whether it has ended.
#[inline(always)]
pub(super) fn store<S: Switched<N, G>, const N: usize, const G: usize>(
    orbit: &mut Orbit<N, S::Mode>,
    integration: &mut Integration<'_, S, N, G>,
    progress: Result<Progress<N, S::Mode>, Error>,
) -> Result<bool, Error> {
    orbit.counters = *integration.counters();
    match progress {
        Ok(Progress::Step) => {
            let step = integration.last_step();
            (orbit.t_end, orbit.x_end) = (step.t_end, step.x_end);
            orbit.steps.push(step);
        }
        Ok(Progress::PhaseEnd(phase)) => orbit.phases.push(phase),
        Ok(Progress::Transition(transition)) => orbit.transitions.push(transition),
        Ok(Progress::End(summary)) => {
            orbit.ending = summary.ending;
            return Ok(true);
        }
        Err(error) => {
            // The present phase stays unfinished; its computed part is stored.
            orbit.phases.extend(integration.phase());
            return Err(error);
        }
    }
    Ok(false)
}

/// Integrates `system` from `(t0, x0)` to `t_end`. Reports every step, transition and phase to
/// `observer` and stores nothing: for runs too long to store.
///
/// # Errors
/// Before the first step, [`Failure`] with [`Error::Option`], [`Error::Interval`],
/// [`Error::Parameter`] or [`Error::StartOutsideDomain`]. After it, those of [`Integration::step`].
pub fn run<S: Switched<N, G>, O: Observer<N, S::Mode> + ?Sized, const N: usize, const G: usize>(
    system: &S,
    t0: f64,
    x0: impl IntoState<N>,
    t_end: f64,
    options: &Options,
    observer: &mut O,
) -> Result<Summary<N>, Failure<Summary<N>>> {
    let x0 = x0.into_state();
    let mut integration = match Integration::new(system, t0, x0, t_end, options) {
        Ok(integration) => integration,
        Err(error) => return Err(Failure::new(error, Summary::before_first_step(t0, x0))),
    };
    loop {
        let progress = integration.step();
        if let Some(outcome) = notify_of(&mut integration, progress, observer) {
            return outcome;
        }
    }
}

/// Reports what happened to `observer`. Returns the outcome if the run has ended.
#[inline(always)]
pub(super) fn notify_of<S, O, const N: usize, const G: usize>(
    integration: &mut Integration<'_, S, N, G>,
    progress: Result<Progress<N, S::Mode>, Error>,
    observer: &mut O,
) -> Option<Result<Summary<N>, Failure<Summary<N>>>>
where
    S: Switched<N, G>,
    O: Observer<N, S::Mode> + ?Sized,
{
    let notified = progress.and_then(|progress| notify(integration, &progress, observer));
    let failed = |error| Failure::new(error, integration.summary(Ending::Failed));
    notified.map_err(failed).transpose()
}

/// Reports progress to `observer`. Returns the end of the run, if it has ended or the observer asks
/// for it. An observer that stops at the end of a phase still receives the transition.
#[inline(always)]
pub(crate) fn notify<S, O, const N: usize, const G: usize>(
    integration: &mut Integration<'_, S, N, G>,
    progress: &Progress<N, S::Mode>,
    observer: &mut O,
) -> Result<Option<Summary<N>>, Error>
where
    S: Switched<N, G>,
    O: Observer<N, S::Mode> + ?Sized,
{
    match progress {
        Progress::Step => {
            if !observer.watches_steps() || observer.step(&integration.last_step()).is_continue() {
                return Ok(None);
            }
            // An orbit that has escaped is an error, also if the observer stops.
            integration.run.check_escape()?;
        }
        Progress::PhaseEnd(phase) => {
            integration.is_stopping = observer.phase(phase).is_break();
            return Ok(None);
        }
        Progress::Transition(at) => {
            if observer.transition(at).is_continue() && !integration.is_stopping {
                return Ok(None);
            }
        }
        Progress::End(summary) => return Ok(Some(*summary)),
    }
    // Between phases there is no present phase: the previous one was reported.
    if let Some(phase) = integration.phase() {
        // The run ends in any case.
        let _ = observer.phase(&phase);
    }
    Ok(Some(integration.summary(Ending::Stopped)))
}
