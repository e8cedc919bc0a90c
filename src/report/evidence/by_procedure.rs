//! `s5.by_procedure`: what the procedure of Sect. 3 makes of Eq. (27), steps of RK4 with Hénon's
//! step onto Σ.

use rayon::prelude::*;

use super::{Evidence, EvidenceError, Part};
use crate::figures::block_and_bracket::{BlockAndBracketFigure, Set, by_rk4_and_henon};
use crate::figures::{fig10::Fig10, fig11::Fig11, fig12::Fig12};
use crate::readings::Verdict;
use stickslip::analysis::motion::Class;
use stickslip::models::Reading;

/// Step of the classical Runge–Kutta method; the paper states none for Figs. 10–12.
const STEP: f64 = 0.01;
const SETS: [Set; 3] = [Fig10::SET, Fig11::SET, Fig12::SET];

/// Classes of the motions of Figs. 10, 11 and 12.
#[derive(Clone, Debug, PartialEq)]
pub struct ByProcedure {
    /// With the corrected equations; nothing where the orbit escapes.
    pub corrected: Vec<Option<Class>>,
    /// With the equations as printed.
    pub as_printed: Vec<Option<Class>>,
}

impl ByProcedure {
    /// Follows all six orbits.
    ///
    /// # Errors
    /// [`EvidenceError`] of the solver except an escape.
    pub fn compute() -> Result<ByProcedure, EvidenceError> {
        let runs =
            [Reading::exact(), Reading::as_printed()].map(|reading| SETS.map(|set| (reading, set)));
        let kinds = runs
            .as_flattened()
            .par_iter()
            .map(|(reading, set)| Ok(by_rk4_and_henon(set, reading, STEP)?))
            .collect::<Result<Vec<_>, EvidenceError>>()?;
        let (corrected, as_printed) = kinds.split_at(SETS.len());
        Ok(ByProcedure {
            corrected: corrected.to_vec(),
            as_printed: as_printed.to_vec(),
        })
    }
}

fn parts(found: &[Option<Class>]) -> Vec<Part> {
    let whats = [
        "Fig. 10: the captioned class, loops counted",
        "Fig. 11: the captioned class",
        "Fig. 12: the captioned class",
    ];
    let of = whats.into_iter().zip(found).enumerate();
    of.map(|(figure, (what, found))| Part {
        what,
        holds: found.is_some_and(|class| Verdict::Motion(class).is_published(figure)),
    })
    .collect()
}

impl Evidence for ByProcedure {
    fn parts(&self) -> Vec<Part> {
        parts(&self.corrected)
    }

    fn as_printed(&self) -> Vec<Part> {
        parts(&self.as_printed)
    }

    fn line(&self) -> String {
        let names = |found: &[Option<Class>]| {
            let names: Vec<String> = found
                .iter()
                .map(|one| one.map_or("escapes".to_owned(), |class| class.to_string()))
                .collect();
            names.join(", ")
        };
        format!(
            "by RK4 with steps of {STEP} and Hénon's step, Figs. 10, 11, 12: {}; with the equations as printed: {}. Another reading, that it \
             gave the very trajectories of the figures, cannot be decided: neither step nor program is stated, and only the text of the \
             paper was at hand, not its pictures",
            names(&self.corrected),
            names(&self.as_printed)
        )
    }
}
