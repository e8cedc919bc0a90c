//! An orbit of the in-place scheme, and the class of its motion.
//!
//! The scheme has no tangent flow: it is a map with jumps, and it meets Σ by whole passes. What it
//! does there depends on what is left of the pass, so that neighbours part up to a distance of
//! about `h` whatever the motion: their growth tells nothing. The class follows from the section
//! alone. A section that neither closes nor lies on a curve is called chaotic, whether the dynamics
//! or the scatter of the step makes it: that is the kinder reading of the published chaos.

use super::plan::{DT, Plan};
use super::trajectory::{BOUND, Bounded, Outcome};
use crate::correlation::CURVE;
use crate::paper::in_place::{InPlace, Lost};
use stickslip::analysis::motion::{Class, Criterion, Evidence, Of};
use stickslip::models::BlockAndBracket;
use stickslip::system::State;

/// Points of the section nearer than this, as a fraction of its extent, count as one: the passes do not hit it, and a
/// motion that closes is met at another phase of the pass every time.
pub const SAME: f64 = 1e-3;

/// A return to `x₂ = 0` from above between two states.
fn crossing(before: &State<4>, after: &State<4>) -> Option<State<4>> {
    let falls = before[1] > 0.0 && after[1] <= 0.0;
    falls.then(|| before + (after - before) * (before[1] / (before[1] - after[1])))
}

/// Follows the scheme. Every so many passes are a point, as the listing counts its records.
pub fn follow(system: &BlockAndBracket, start: State<4>, h: f64, plan: &Plan) -> Outcome {
    let passes = |t: f64| (t / h).round() as usize;
    let (first, every) = (passes(plan.from), passes(DT).max(1));
    let last = first + (plan.points - 1) * every;
    let mut scheme = InPlace::start(system, start, h, BOUND);
    let (mut series, mut section) = (Vec::new(), Vec::new());
    for pass in 0..=last {
        if pass >= first && (pass - first).is_multiple_of(every) {
            series.push((*scheme.x()).into());
        }
        let before = *scheme.x();
        match scheme.advance() {
            Ok(()) => {}
            Err(Lost::Escaped { t }) => return Outcome::Escaped(t),
            Err(Lost::BrokenDown { .. }) => return Outcome::Failed,
        }
        if let Some(at) = crossing(&before, scheme.x()).filter(|_| pass >= first) {
            section.push((scheme.t(), at.into()));
        }
    }
    let criterion = Criterion {
        same: SAME,
        ..Criterion::default()
    };
    let closing = Evidence::gather(&section, (Of::ReturnMap, &[], 1.0), &criterion).class();
    let mut motion = Bounded::new(series, &section, closing);
    if closing == Class::Undecided && motion.dimension < CURVE {
        motion.class = Class::QuasiPeriodic;
    } else if closing == Class::Undecided && motion.dimension >= CURVE {
        motion.class = Class::Chaotic;
    }
    Outcome::Bounded(motion)
}
