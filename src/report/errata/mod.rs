//! The paper's misprints. A computation shows each, a run of the solver or of the listing that
//! could have contradicted it, or the text alone does, which the table says: `by reading: …`.

mod bracket;
mod listing;
mod proof;
mod rig;
mod sections_two_to_four;
mod shifts;

use std::collections::BTreeMap;

use super::accuracy::Accuracy;
use super::matrix::Matrix;
use crate::paper::listing::Defect;
use crate::paper::published::Claims;
use crate::terminal::ProgramError;
pub use bracket::MotionOutcome;
pub(super) use bracket::by_section;
pub use proof::{Proof, ProofResult};

/// A misprint or defect.
#[derive(Clone, Debug, PartialEq)]
pub struct Erratum {
    /// Name; for a defect, [`Defect::name`].
    pub name: String,
    /// Location in the paper.
    pub location: String,
    /// Printed statement, in our words.
    pub printed: String,
    /// Correct statement.
    pub correct: String,
    /// Results of the computation.
    pub shown: Vec<ProofResult>,
    /// Proof by the text itself, where no computation could give one.
    pub by_reading: Option<String>,
    /// Whether the computation confirms the misprint.
    pub holds: bool,
}

/// Begin of the last column for a misprint that the text alone shows.
const BY_READING: &str = "by reading: ";
const MISPRINTS: &str = include_str!("../../../data/errata.csv");

/// All misprints, in the order of the paper, some from results computed elsewhere.
///
/// # Errors
/// The solver's; a message where a misprint has no proof.
pub fn errata(
    claims: &Claims,
    matrix: &Matrix,
    accuracy: &Accuracy,
    of_statements: &[Proof],
) -> Result<Vec<Erratum>, ProgramError> {
    let mut proofs = vec![
        sections_two_to_four::unit_of_mu0(),
        sections_two_to_four::critical_points(claims),
        sections_two_to_four::negative_friction(claims),
        sections_two_to_four::step_from_above(accuracy),
        sections_two_to_four::release_step(accuracy),
        sections_two_to_four::time_in_stick(accuracy),
        sections_two_to_four::sign_of_friction()?,
        sections_two_to_four::spring_signs()?,
        shifts::shifts(),
        bracket::signs()?,
        rig::friction_counted_twice()?,
        rig::unit_of_time()?,
        bracket::order_of_captions()?,
        bracket::caption_of_fig10()?,
    ];
    proofs.extend_from_slice(of_statements);
    proofs.extend(Defect::ALL.map(|defect| listing::defect(matrix, defect)));
    Ok(misprints_with_proofs(MISPRINTS, proofs)?)
}

/// The misprints of a table, each with its proof. Results take their descriptions from the table if
/// it has them.
fn misprints_with_proofs(table: &str, proofs: Vec<Proof>) -> Result<Vec<Erratum>, String> {
    let named = proofs.into_iter().map(|proof| (proof.misprint, proof));
    let mut proofs: BTreeMap<&str, Proof> = named.collect();
    let mut all = Vec::new();
    for row in csv::Reader::from_reader(table.as_bytes()).into_records() {
        let row = row.map_err(|error| format!("data/errata.csv: {error}"))?;
        let cell = |k| row.get(k).unwrap_or_default().to_owned();
        let name = cell(0);
        let erratum = |shown, by_reading, holds| Erratum {
            name: cell(0),
            location: cell(1),
            printed: cell(2),
            correct: cell(3),
            shown,
            by_reading,
            holds,
        };
        if let Some(why) = cell(4).strip_prefix(BY_READING) {
            all.push(erratum(Vec::new(), Some(why.to_owned()), true));
            continue;
        }
        let proof = proofs.remove(&*name);
        let proof = proof.ok_or_else(|| {
            format!("data/errata.csv: nothing in src/report/errata proves {name:?}")
        })?;
        let labels = cell(4);
        let label = |label| str::strip_suffix(label, ']')?.split_once(" [");
        let mut labels = labels.split(" | ").filter_map(label);
        let mut shown = proof.shown;
        for one in shown.iter_mut().filter(|one| one.what.is_empty()) {
            let (what, unit) = labels.next().unwrap_or_default();
            (one.what, one.unit) = (what.to_owned(), unit.to_owned());
        }
        if labels.next().is_some() || shown.iter().any(|one| one.what.is_empty()) {
            let values = shown.len();
            return Err(format!(
                "data/errata.csv: {name:?} must have one label for each of its {values} values"
            ));
        }
        all.push(erratum(shown, None, proof.holds));
    }
    match proofs.keys().next() {
        Some(name) => Err(format!("data/errata.csv has no misprint {name:?}")),
        None => Ok(all),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_misprint_has_a_proof_and_every_proof_a_misprint() {
        let table = "name,place,printed,correct,shown\none,Eq. (1),a,b,c [m]\n";
        let of = |names: &[&'static str]| {
            let proofs = names.iter().map(|name| Proof::new(name, [1.0], true));
            misprints_with_proofs(table, proofs.collect())
        };
        let proven_one = of(&["one"]).unwrap().remove(0);
        assert_eq!(
            (&*proven_one.location, proven_one.shown),
            ("Eq. (1)", vec![ProofResult::new("c", 1.0, "m")])
        );
        assert!(of(&[]).is_err() && of(&["one", "two"]).is_err());
        let read = "name,place,printed,correct,shown\none,Eq. (1),a,b,by reading: d\n";
        let read = misprints_with_proofs(read, Vec::new()).unwrap().remove(0);
        assert_eq!(read.by_reading.as_deref(), Some("d"));
        for values in [vec![], vec![1.0, 2.0]] {
            assert!(misprints_with_proofs(table, vec![Proof::new("one", values, true)]).is_err());
        }
    }
}
