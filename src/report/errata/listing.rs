//! The defects of the Appendix's listing, each mended alone.

use super::proof::{Proof, ProofResult};
use crate::paper::listing::{Defect, Defects, Setup, run};
use crate::report::matrix::{ComparedRun, Matrix};

/// The effect of mending one defect alone. The test of the start has an effect for another start
/// only.
pub(super) fn defect(matrix: &Matrix, defect: Defect) -> Proof {
    let (printed, mended) = (matrix.with(Defects::AS_PRINTED), matrix.mended(defect));
    let mut all = changes(printed, mended);
    let mut holds = mended.motion != printed.motion || mended.numbers != printed.numbers;
    if defect == Defect::StartUpTest {
        let printed = sticking_starts(Defects::AS_PRINTED);
        let mended = sticking_starts(Defects::AS_PRINTED.flipped(defect));
        let what = "starts in the middles of the three zones that stick at once, printed";
        all.push(ProofResult::new(what, printed, "1"));
        all.push(ProofResult::new("the same, mended", mended, "1"));
        holds = printed < mended;
    }
    Proof::new(defect.name(), all, holds)
}

fn changes(printed: &ComparedRun, mended: &ComparedRun) -> Vec<ProofResult> {
    let (Some(after), Some(before)) = (mended.numbers, printed.numbers) else {
        let motion = mended.motion.to_string();
        return vec![ProofResult::new(
            "mended alone, the listing's motion",
            &*motion,
            "",
        )];
    };
    let what = "mended alone, first stick length changes by";
    vec![
        ProofResult::new(what, after[0] - before[0], "m"),
        ProofResult::new("second stick length by", after[1] - before[1], "m"),
    ]
}

/// Number of bodies, placed in the middles of the three stick zones, that stick at once.
fn sticking_starts(defects: Defects) -> usize {
    let printed = Setup::with(defects);
    let sticks_at_once = |zone: &&[f64]| {
        let middle = zone[0].midpoint(zone[1]);
        let outcome = run(&Setup {
            start: [0.0, middle, printed.model.belt_speed],
            end: 0.01,
            window_start: 0.0,
            ..printed
        });
        let first = outcome.phases.first().map(|phase| phase.stick.entry);
        let entry = first.or(outcome.unfinished.map(|(entry, _)| entry));
        entry.is_some_and(|entry| entry.t == 0.0)
    };
    let zones = printed.tangent_points.chunks_exact(2);
    zones.filter(sticks_at_once).count()
}
