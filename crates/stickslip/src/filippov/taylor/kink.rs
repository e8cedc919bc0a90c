//! Comparisons that a series relies on, and where they come out otherwise.

use super::TaylorStepper;
use crate::error::{Error, Point};
use crate::filippov::options::Options;
use crate::filippov::pile_up::Burst;
use crate::ode::{Timed, power_series};
use crate::taylor::roots::first_zero;

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// Where in the step, before the part `before`, a comparison that the series relies on first comes out otherwise: a little
    /// behind the place where the two are equal, so that the next series sees it.
    pub(super) fn first_kink(&self, before: f64) -> Option<f64> {
        let piece = &self.piece;
        let mut first: Option<f64> = None;
        for c in &self.choices {
            let c = &c[..=piece.order];
            // Two that are equal throughout come out the same throughout.
            let Some(start) = c.iter().position(|&c| c != 0.0) else {
                continue;
            };
            let c_left = &c[start..];
            let s = if c_left[0] <= 0.0 {
                0.0
            } else {
                match first_zero(c_left) {
                    Some(s) => s,
                    None => continue,
                }
            };
            let size: f64 = c.iter().map(|c| c.abs()).sum();
            let mut behind = s;
            // At least something, where the step begins at time zero.
            let mut more = 4.0 * f64::EPSILON * (s + (piece.t / piece.h).abs()).max(1.0);
            while behind < 1.0 && power_series(c, behind).0 > -8.0 * f64::EPSILON * size {
                behind = s + more;
                more *= 2.0;
            }
            if behind < first.unwrap_or(before) {
                first = Some(behind);
            }
        }
        first
    }
}

/// Counts a step that has ended at `at` for that; too many within no time are a boundary that the field hides.
#[cold]
pub(super) fn note_branching<const N: usize>(
    branchings: &mut Burst,
    at: &Timed<N>,
    options: &Options,
) -> Result<(), Error> {
    let (count, span) = branchings.note(at.t, options);
    if count < options.pile_up_count {
        return Ok(());
    }
    Err(Error::BranchPileUp {
        count,
        span,
        t: at.t,
        x: Point::from(&at.x),
    })
}
