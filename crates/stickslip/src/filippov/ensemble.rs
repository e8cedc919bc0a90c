//! Many orbits at once: starts or parameters.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::batch::side_by_side;
use super::observer::Observer;
use super::options::{Method, Options};
use super::solve::{Failure, Summary, run};
use super::switched::Switched;
use crate::system::State;

/// Number of orbits that run or wait to be reported at one time. It bounds the memory.
const WAVE: usize = 4096;
/// Number of orbits that a thread takes at once: enough to fill the lanes, and few enough that no
/// thread waits long for the others.
const MOST: usize = 128;
const LEAST: usize = 16;

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
/// use std::ops::ControlFlow;
/// use stickslip::{Method, Options, Start, State, ensemble, models::BeltOscillator};
///
/// let belt = BeltOscillator { belt_speed: 0.4, ..BeltOscillator::default() };
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
    let mut wave = Vec::with_capacity(WAVE);
    let mut outcomes = Vec::new();
    loop {
        wave.clear();
        wave.extend(starts.by_ref().take(WAVE));
        if wave.is_empty() {
            return;
        }
        let share = wave.len() / (4 * rayon::current_num_threads());
        let share = share.clamp(LEAST, MOST);
        wave.par_chunks(share)
            .enumerate()
            .map(|(k, starts)| {
                let first = first + k * share;
                let mut observers: Vec<O> = (first..first + starts.len()).map(&observer).collect();
                let outcomes = if options.method == Method::Taylor {
                    side_by_side(starts, &mut observers, t_end, options)
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
