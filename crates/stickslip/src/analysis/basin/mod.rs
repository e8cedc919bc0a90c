//! Basins of attraction: which attractor each of many starts leads to.

mod edge;
mod entropy;
mod grid;
mod push;
mod return_time;
mod shares;
mod uncertainty;

pub use edge::{EdgeKind, EdgeSettings, EdgeState};
pub use entropy::BasinEntropy;
pub use push::{Push, PushSettings};
pub use shares::SharesAt;
pub use uncertainty::UncertaintyExponent;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::analysis::attractors::{
    Attractor, AttractorKind, Attractors, RecurrenceSettings, attractors_of,
};
use crate::dynamics::{AsDynamics, Components};
use crate::error::Error;
use crate::filippov::{ORBITS_AT_ONCE, Options, task_size};

/// Whether an outcome is that of a start on a boundary itself, or too near it to be decided.
fn is_on_boundary(kind: &AttractorKind) -> bool {
    matches!(kind, AttractorKind::Undecided | AttractorKind::Unstable)
}

/// The attractor reached from each start.
#[derive(Clone, Debug, PartialEq)]
pub struct Basin {
    /// The attractors by their numbers, in the order in which the starts first reach them.
    pub attractors: Vec<Attractor>,
    /// Number of the attractor of each start, in order.
    pub reached: Vec<usize>,
}

/// A fraction of the starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Number of starts that lead there.
    pub starts: usize,
    /// The fraction.
    pub part: f64,
    /// Standard error of the fraction, if the starts were drawn at random: `√(p (1 − p)/n)`.
    pub std_error: f64,
}

impl Share {
    /// Share of `starts` among `all`.
    fn of(starts: usize, all: usize) -> Self {
        let total = all as f64;
        let part = starts as f64 / total;
        Share {
            starts,
            part,
            std_error: (part * (1.0 - part) / total).sqrt(),
        }
    }
}

impl Basin {
    /// The fraction of the starts that reaches attractor `number`.
    pub fn share(&self, number: usize) -> Share {
        let starts = self.reached.iter().filter(|one| **one == number).count();
        Share::of(starts, self.reached.len())
    }
}

/// The basins of attraction of a system on a set of starts, computed on all threads. The result is
/// bit-for-bit the same on any number of threads. Each start is integrated on its own; the
/// attractors are distinguished afterwards, in the order of the starts.
///
/// ```
#[doc = include_str!("../../../examples/common/belt.rs")]
/// use stickslip::analysis::{RecurrenceSettings, basin};
/// use stickslip::{Options, State};
///
/// let belt = Belt { speed: 0.2 };
/// let starts = (0..20).map(|k| State::from([0.1 * f64::from(k) - 1.0, 0.0]));
/// let basins = basin(&belt, starts, &RecurrenceSettings::within(500.0), &Options::default())?;
/// for (number, attractor) in basins.attractors.iter().enumerate() {
///     println!("{}: {:.0} %", attractor.kind, 100.0 * basins.share(number).part);
/// }
/// assert_eq!(basins.reached.len(), 20);
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// Those of [`super::Attractor::of_any`], for the first start that fails.
pub fn basin<Kind>(
    system: &impl AsDynamics<Kind>,
    starts: impl IntoIterator<Item = impl Components>,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Basin, Error> {
    let go_on = || ControlFlow::Continue(());
    let (attractors, reached) = Basin::found_while(system, starts, settings, options, go_on)?;
    Ok(Basin {
        attractors,
        reached: reached.into_iter().flatten().collect(),
    })
}

impl Basin {
    /// [`basin`] with a callback after each start, on the thread that integrated it. The callback
    /// may stop the computation; starts left out then have no number.
    ///
    /// # Errors
    /// Those of [`basin`].
    pub fn found_while<Kind>(
        system: &impl AsDynamics<Kind>,
        starts: impl IntoIterator<Item = impl Components>,
        settings: &RecurrenceSettings,
        options: &Options,
        after_each: impl Fn() -> ControlFlow<()> + Sync,
    ) -> Result<(Vec<Attractor>, Vec<Option<usize>>), Error> {
        let mut distinct = Attractors::new(system, settings, options);
        let dynamics = system.dynamics();
        let mut reached = Vec::new();
        let mut starts = starts.into_iter().map(Components::vector);
        let is_enough = AtomicBool::new(false);
        loop {
            let wave: Vec<_> = starts.by_ref().take(ORBITS_AT_ONCE).collect();
            if wave.is_empty() {
                break;
            }
            let outcomes: Vec<_> = wave
                .par_chunks(task_size(wave.len()))
                .map(|starts| {
                    if is_enough.load(Ordering::Relaxed) {
                        return Ok(vec![None; starts.len()]);
                    }
                    let mut go_on = || {
                        if is_enough.load(Ordering::Relaxed) {
                            return ControlFlow::Break(());
                        }
                        let flow = after_each();
                        is_enough.fetch_or(flow.is_break(), Ordering::Relaxed);
                        flow
                    };
                    attractors_of(&*dynamics, starts, settings, options, &mut go_on)
                })
                .collect();
            for outcomes in outcomes {
                for outcome in outcomes? {
                    let outcome = outcome.transpose()?;
                    reached.push(outcome.map(|outcome| distinct.number(outcome)));
                }
            }
        }
        Ok((distinct.into_vec(), reached))
    }
}
