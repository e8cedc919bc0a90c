//! The paper's misprints, each with the computation that shows it: a run of the solver or of the
//! listing that could have come out otherwise.

mod bracket;
mod listing;
mod proof;
mod sections_two_to_four;

use std::collections::BTreeMap;

use super::ReportError;
use super::accuracy::Accuracy;
use super::matrix::Matrix;
use crate::paper::listing::Defect;
use crate::paper::published::PublishedError;
pub(super) use proof::proof;
pub use proof::{Proof, Shown};

/// A misprint or defect.
#[derive(Clone, Debug, PartialEq)]
pub struct Erratum {
    /// Its name; of a defect, that of [`Defect::name`].
    pub name: String,
    /// Where.
    pub place: String,
    /// What stands there, in our words.
    pub printed: String,
    /// What should.
    pub correct: String,
    /// The computation's results.
    pub shown: Vec<Shown>,
    /// Whether they bear it out.
    pub holds: bool,
}

const MISPRINTS: &str = include_str!("../../../data/errata.csv");

/// All of them, in the order of the paper, some by what has been computed already.
///
/// # Errors
/// [`ReportError`].
pub fn errata(
    matrix: &Matrix,
    accuracy: &Accuracy,
    of_statements: &[Proof],
) -> Result<Vec<Erratum>, ReportError> {
    let mut proofs = vec![
        sections_two_to_four::unit_of_mu0(),
        sections_two_to_four::critical_points()?,
        sections_two_to_four::negative_friction()?,
        sections_two_to_four::wrong_reference()?,
        sections_two_to_four::step_from_above(accuracy),
        sections_two_to_four::time_in_stick(accuracy),
        sections_two_to_four::sign_of_friction()?,
        sections_two_to_four::spring_signs()?,
        listing::shifts(),
        bracket::signs()?,
        bracket::friction_counted_twice()?,
        bracket::unit_of_time()?,
        bracket::four_states()?,
        bracket::order_of_captions()?,
        bracket::caption_of_fig10()?,
    ];
    proofs.extend_from_slice(of_statements);
    for defect in Defect::ALL {
        proofs.push(listing::defect(matrix, defect)?);
    }
    Ok(proven(MISPRINTS, proofs)?)
}

/// The misprints of a table, each with its proof. What is shown has its words from the table
/// where that has them.
fn proven(table: &str, proofs: Vec<Proof>) -> Result<Vec<Erratum>, PublishedError> {
    let malformed = |reason: String| PublishedError::Malformed { reason };
    let named = proofs.into_iter().map(|proof| (proof.misprint, proof));
    let mut proofs: BTreeMap<&str, Proof> = named.collect();
    let mut all = Vec::new();
    for row in csv::Reader::from_reader(table.as_bytes()).into_records() {
        let row = row.map_err(|error| malformed(error.to_string()))?;
        let cell = |k| row.get(k).unwrap_or_default().to_owned();
        let name = cell(0);
        let proof = proofs.remove(&*name);
        let proof = proof.ok_or_else(|| malformed(format!("nothing proves misprint {name:?}")))?;
        let labels: Vec<(&str, &str)> = row
            .get(4)
            .unwrap_or_default()
            .split(" | ")
            .filter_map(|label| label.strip_suffix(']')?.split_once(" ["))
            .collect();
        let mut shown = proof.shown;
        let unnamed = shown.iter_mut().filter(|one| one.what.is_empty());
        let mut labelled = 0;
        for (one, (what, unit)) in unnamed.zip(&labels) {
            (one.what, one.unit) = ((*what).to_owned(), (*unit).to_owned());
            labelled += 1;
        }
        if labelled != labels.len() || shown.iter().any(|one| one.what.is_empty()) {
            let (found, due) = (shown.len(), labels.len());
            return Err(malformed(format!(
                "{name:?} has {due} labels for {found} values"
            )));
        }
        all.push(Erratum {
            name,
            place: cell(1),
            printed: cell(2),
            correct: cell(3),
            shown,
            holds: proof.holds,
        });
    }
    match proofs.keys().next() {
        Some(name) => Err(malformed(format!(
            "data/errata.csv has no misprint {name:?}"
        ))),
        None => Ok(all),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proof::shown;

    #[test]
    fn every_misprint_has_a_proof_and_every_proof_a_misprint() {
        let table = "name,place,printed,correct,shown\none,Eq. (1),a,b,c [m]\n";
        let of = |names: &[&'static str]| {
            let proofs = names.iter().map(|name| proof(name, [1.0], true));
            proven(table, proofs.collect())
        };
        let found = of(&["one"]).unwrap().remove(0);
        assert_eq!(
            (&*found.place, found.shown),
            ("Eq. (1)", vec![shown("c", 1.0, "m")])
        );
        assert!(of(&[]).is_err() && of(&["one", "two"]).is_err());
        for values in [vec![], vec![1.0, 2.0]] {
            assert!(proven(table, vec![proof("one", values, true)]).is_err());
        }
    }
}
