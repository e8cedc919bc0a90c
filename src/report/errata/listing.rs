//! The defects of the Appendix's listing, each mended alone.

use super::{Erratum, Shown, count, number, word};
use crate::paper::listing::{Defect, Defects, ListingError, Params, Setup, run};
use crate::report::evidence::EvidenceError;
use crate::report::matrix::{Cell, Matrix};

pub(super) fn errata(matrix: &Matrix) -> Result<Vec<Erratum>, EvidenceError> {
    Defect::ALL
        .into_iter()
        .map(|defect| of_defect(matrix, defect))
        .collect()
}

/// What changes when a defect alone is mended; the test of the start changes something for another start only.
fn of_defect(matrix: &Matrix, defect: Defect) -> Result<Erratum, EvidenceError> {
    let (printed, mended) = (matrix.all(), matrix.mended(defect));
    let mut shown = changes(printed, mended);
    let mut holds = mended.motion != printed.motion || mended.numbers != printed.numbers;
    if defect == Defect::StartUpTest {
        let as_printed = sticking_starts(Defects::AS_PRINTED)?;
        let mended = sticking_starts(Defects::AS_PRINTED.flipped(defect))?;
        shown.push(count(
            "starts in the middles of the three zones that stick at once, printed",
            as_printed,
        ));
        shown.push(count("the same, mended", mended));
        holds = as_printed < mended;
    }
    Ok(Erratum {
        place: format!("Listing, lines {}", defect.lines()),
        printed: defect.description().to_owned(),
        correct: instead_of(defect).to_owned(),
        shown,
        holds,
    })
}

fn changes(printed: &Cell, mended: &Cell) -> Vec<Shown> {
    match (mended.numbers, printed.numbers) {
        (Some(mended), Some(printed)) => vec![
            number(
                "mended alone, first stick length changes by",
                mended[0] - printed[0],
                "m",
            ),
            number("second stick length by", mended[1] - printed[1], "m"),
        ],
        _ => vec![word("mended alone, the listing's motion", mended.class())],
    }
}

/// What the listing should do instead.
fn instead_of(defect: Defect) -> &'static str {
    match defect {
        Defect::InPlaceStages => {
            "a copy of the state, so that a step moves it by h and a crossing step can be taken back"
        }
        Defect::FrozenForcing => "each stage at its own time",
        Defect::OneSidedExit => "both ends: the lower one can overtake the body",
        Defect::ReversedExitSide => "the side that the spring force leads to",
        Defect::S2StepSign => "a - x[2] on both sides",
        Defect::StartUpTest => "all three zones, moved by the forcing at the start",
        Defect::SixthRounded => "1/6",
    }
}

/// How many bodies on the belt in the middles of the three stick zones stick at once.
fn sticking_starts(defects: Defects) -> Result<usize, ListingError> {
    let tangent = Params::default().tangent_points;
    let mut found = 0;
    for zone in tangent.chunks_exact(2) {
        let params = Params {
            x1: zone[0].midpoint(zone[1]),
            ..Params::default()
        };
        let outcome = run(&Setup {
            params,
            defects,
            end: 0.01,
            window_start: 0.0,
            ..Setup::default()
        })?;
        let first = outcome.phases.first().map(|phase| phase.entry);
        let entry = first.or(outcome.unfinished.map(|(entry, _)| entry));
        found += usize::from(entry.is_some_and(|entry| entry.t == 0.0));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_defect_changes_something() {
        let matrix = Matrix::compute(&|| {}).unwrap();
        for found in errata(&matrix).unwrap() {
            assert!(found.holds && !found.shown.is_empty(), "{found:?}");
        }
        // A defect that is already mended changes nothing.
        assert_eq!(
            changes(matrix.all(), matrix.all())[0],
            number("mended alone, first stick length changes by", 0.0, "m")
        );
    }
}
