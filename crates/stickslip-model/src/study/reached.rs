//! Attractors that orbits reach, as results hold them.

use stickslip::Error;
use stickslip::analysis::{Attractor, AttractorKind};

/// Attractor of an orbit, in the form that results hold and files store. The error of a failed
/// run is in the words of `describe`. Motions that points do not distinguish have no points and no
/// phases.
pub fn reported(reached: Attractor, describe: impl FnOnce(&Error) -> String) -> Attractor {
    let kind = match reached.kind {
        AttractorKind::Failure(error) => AttractorKind::Failure(Error::Recorded {
            words: describe(&error),
        }),
        kind if kind.is_attractor() => return Attractor { kind, ..reached },
        kind => kind,
    };
    Attractor {
        kind,
        points: Vec::new(),
        phases: Vec::new(),
        transitions: Vec::new(),
        ..reached
    }
}
