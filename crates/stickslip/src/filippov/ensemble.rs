//! Many orbits at once: starts or parameters.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::batch::{self, LANES, side_by_side};
use super::integration::Integration;
use super::observer::Observer;
use super::options::{Method, Options};
use super::solve::{Failure, notify_of, run};
use super::stepper::Stepper;
use super::switched::Switched;
use crate::ode::Timed;
use crate::orbit::Summary;
use crate::system::State;

/// Number of orbits that run or wait to be reported at one time. Chosen: it bounds the memory, and
/// is enough tasks for a hundred threads.
pub(crate) const ORBITS_AT_ONCE: usize = 4096;

/// Number of orbits that a thread takes at once: about a quarter of its share. They are enough to
/// fill the lanes, and few enough that no thread waits long for the others.
pub(crate) fn task_size(orbits: usize) -> usize {
    (orbits / (4 * rayon::current_num_threads())).clamp(2 * LANES, 16 * LANES)
}

/// The start of an orbit of an ensemble, and its system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start<S, const N: usize> {
    /// The system with its parameters; a reference if all orbits share one.
    pub system: S,
    /// First time.
    pub t: f64,
    /// First state.
    pub x: State<N>,
}

/// Integrates every start to `t_end` on all threads. Calls `each` with every orbit's number,
/// observer and outcome, in the order of the starts. An orbit that fails does not stop the others;
/// `each` may end the ensemble.
///
/// With [`Method::Taylor`], orbits of equal systems are computed side by side in vectors. Each
/// orbit is bit-for-bit the same as by [`run`], on any number of threads. Starts are drawn as they
/// are needed, and the memory does not grow with their number.
///
/// ```
#[doc = include_str!("../../examples/common/belt.rs")]
/// use std::ops::ControlFlow;
/// use stickslip::{Method, Options, Start, State, ensemble};
///
/// let belt = Belt { speed: 0.4 };
/// let starts = (0..100).map(|k| Start {
///     system: &belt,
///     t: 0.0,
///     x: State::from([0.01 * f64::from(k), 1.0]),
/// });
/// let mut finished = 0;
/// let options = Options::tol(1e-10).method(Method::Taylor);
/// ensemble(starts, 30.0, &options, |_| (), |_number, (), outcome| {
///     finished += u32::from(outcome.is_ok_and(|end| end.t == 30.0));
///     ControlFlow::Continue(())
/// });
/// assert_eq!(finished, 100);
/// ```
pub fn ensemble<S, O, const N: usize, const G: usize>(
    starts: impl IntoIterator<Item = Start<S, N>>,
    t_end: f64,
    options: &Options,
    observer: impl Fn(usize) -> O + Sync,
    mut each: impl FnMut(usize, O, Result<Summary<N>, Failure<Summary<N>>>) -> ControlFlow<()>,
) where
    S: Switched<N, G> + PartialEq + Send + Sync,
    O: Observer<N, S::Mode> + Send,
{
    let mut starts = starts.into_iter();
    let mut first = 0;
    let mut wave = Vec::with_capacity(ORBITS_AT_ONCE);
    let mut outcomes = Vec::new();
    loop {
        wave.clear();
        wave.extend(starts.by_ref().take(ORBITS_AT_ONCE));
        if wave.is_empty() {
            return;
        }
        let size = task_size(wave.len());
        wave.par_chunks(size)
            .enumerate()
            .map(|(k, starts)| {
                let first = first + k * size;
                let mut observers: Vec<O> = (first..first + starts.len()).map(&observer).collect();
                let outcomes = if options.method == Method::Taylor {
                    let each = starts.iter().zip(&mut observers);
                    let begin = |(start, observer), stepper| {
                        ObservedOrbit::begin(start, observer, t_end, options, stepper)
                    };
                    side_by_side(classes(starts).into_iter().zip(each), begin, options)
                } else {
                    let each = starts.iter().zip(&mut observers);
                    each.map(|(start, observer)| {
                        run(&start.system, start.t, start.x, t_end, options, observer)
                    })
                    .collect()
                };
                (observers, outcomes)
            })
            .collect_into_vec(&mut outcomes);
        let ended = outcomes
            .drain(..)
            .flat_map(|(observers, outcomes)| observers.into_iter().zip(outcomes));
        for (k, (observer, outcome)) in ended.enumerate() {
            if each(first + k, observer, outcome).is_break() {
                return;
            }
        }
        first += wave.len();
    }
}

type SummaryOrFailure<const N: usize> = Result<Summary<N>, Failure<Summary<N>>>;

/// An orbit under way, and its observer.
struct ObservedOrbit<'a, S: Switched<N, G>, O, const N: usize, const G: usize> {
    integration: Integration<'a, S, N, G>,
    observer: &'a mut O,
}

impl<'a, S: Switched<N, G>, O: Observer<N, S::Mode>, const N: usize, const G: usize>
    ObservedOrbit<'a, S, O, N, G>
{
    /// An orbit at its start, or its outcome if it cannot begin.
    fn begin(
        start: &'a Start<S, N>,
        observer: &'a mut O,
        t_end: f64,
        options: &Options,
        stepper: Stepper<N, G>,
    ) -> Result<Self, SummaryOrFailure<N>> {
        let (t, x) = (start.t, start.x);
        let begun =
            Integration::with_stepper(&start.system, Timed { t, x }, t_end, options, stepper);
        Ok(ObservedOrbit {
            integration: begun
                .map_err(|error| Err(Failure::new(error, Summary::before_first_step(t, x))))?,
            observer,
        })
    }
}

impl<'a, S, O, const N: usize, const G: usize> batch::BatchMember<'a, S, N, G>
    for ObservedOrbit<'a, S, O, N, G>
where
    S: Switched<N, G>,
    O: Observer<N, S::Mode>,
{
    type Outcome = SummaryOrFailure<N>;

    fn integration(&mut self) -> &mut Integration<'a, S, N, G> {
        &mut self.integration
    }

    fn watches_step(&mut self) -> bool {
        self.observer.watches_steps()
    }

    fn go_on(&mut self) -> Option<SummaryOrFailure<N>> {
        loop {
            let progress = self.integration.go_on().transpose()?;
            let outcome = notify_of(&mut self.integration, progress, self.observer);
            if outcome.is_some() {
                return outcome;
            }
        }
    }
}

/// Index, for every start, of the first start with an equal system.
fn classes<S: PartialEq, const N: usize>(starts: &[Start<S, N>]) -> Vec<usize> {
    let mut firsts: Vec<usize> = Vec::new();
    let class = |(number, start): (usize, &Start<S, N>)| {
        let earlier = firsts
            .iter()
            .copied()
            .find(|&first| starts[first].system == start.system);
        earlier.unwrap_or_else(|| {
            firsts.push(number);
            number
        })
    };
    starts.iter().enumerate().map(class).collect()
}
