//! Minimum and maximum of each state along an orbit.

use std::ops::ControlFlow;

use numerics::golden_section;
use stickslip::dynamics::{DynamicsRef, OrbitProgress, OrbitUnderWay, Step, Summary, Vector};
use stickslip::{Error, Options};

use crate::kernel::follow;

/// Number of equal parts of a step at whose ends motion is sampled. It is chosen: two extrema
/// within one part are not seen.
pub(super) const PARTS_PER_STEP: u32 = 16;

/// Time at the end of one of them.
pub(super) fn time_in(step: &Step, part: u32) -> f64 {
    step.t_start + (step.t_end - step.t_start) * f64::from(part) / f64::from(PARTS_PER_STEP)
}

/// Number of golden sections of the interval around an extremum. They shrink it to 4e-9 of its
/// length, where the value is accurate to rounding.
const GOLDEN_SECTIONS: u32 = 40;

/// Minimum and maximum of every state along a run, also between the ends of steps, and its end.
///
/// # Errors
/// Those of [`stickslip::run`].
pub fn extremes(
    system: &DynamicsRef<'_>,
    start: (f64, &[f64]),
    t_end: f64,
    options: &Options,
) -> Result<(Vec<(f64, f64)>, Summary), Error> {
    let mut ranges: Vec<(f64, f64)> = start.1.iter().map(|&x| (x, x)).collect();
    let mut watcher = |progress, orbit: &mut dyn OrbitUnderWay| {
        if progress == OrbitProgress::Step {
            widen(&mut ranges, &orbit.last_step(), &*orbit.solution());
        }
        ControlFlow::Continue(())
    };
    let ended = follow(system, start, t_end, options, &[], &mut watcher)?;
    Ok((ranges, ended))
}

/// Widens the ranges to those of a step.
fn widen(ranges: &mut [(f64, f64)], step: &Step, solution: &dyn Fn(f64) -> Vector) {
    let at = |k: u32| time_in(step, k);
    let samples: Vec<Vector> = (0..=PARTS_PER_STEP).map(|k| solution(at(k))).collect();
    for (i, (low, high)) in ranges.iter_mut().enumerate() {
        for sign in [-1.0, 1.0] {
            let heights = (0_u32..).zip(samples.iter().map(|x| sign * x[i]));
            let (k, highest) = heights.fold((0, f64::NEG_INFINITY), |best, next| {
                if next.1 > best.1 { next } else { best }
            });
            let around = (at(k.saturating_sub(1)), at((k + 1).min(PARTS_PER_STEP)));
            let depth = |t: f64| -sign * solution(t)[i];
            let lowest = golden_section(around.0, around.1, GOLDEN_SECTIONS, depth);
            let value = sign * highest.max(-lowest);
            (*low, *high) = (low.min(value), high.max(value));
        }
    }
}
