//! Every claim about the figures and about the spectra of Sect. 5.2 has a row, and every row that a claim speaks of is compared with it.

use replication::figures::rows::Row;
use replication::figures::{
    FigureSpec, fig04::Fig04, fig06::Fig06, fig07::Fig07, fig08::Fig08, fig10::Fig10, fig11::Fig11,
    fig12::Fig12,
};
use replication::paper::published::claims;

fn rows<F: FigureSpec>() -> Vec<Row> {
    F::numbers(&F::compute().unwrap())
}

fn all_rows() -> Vec<Row> {
    [
        rows::<Fig04>(),
        rows::<Fig06>(),
        rows::<Fig07>(),
        rows::<Fig08>(),
        rows::<Fig10>(),
        rows::<Fig11>(),
        rows::<Fig12>(),
    ]
    .concat()
}

/// Claims of a figure or a spectrum; the ledger answers the others too, see `tests/report.rs`.
fn is_due(id: &str) -> bool {
    !id.starts_with("abstract")
}

#[test]
fn every_claim_has_a_compared_row() {
    let rows = all_rows();
    let mut due = 0;
    for claim in claims().unwrap().iter().filter(|claim| is_due(&claim.id)) {
        due += 1;
        let members = format!("{}.", claim.id);
        let about: Vec<&Row> = rows
            .iter()
            .filter(|row| row.id == claim.id || row.id.starts_with(&members))
            .collect();
        assert!(!about.is_empty(), "no row about {}", claim.id);
        for row in about {
            assert!(
                row.agrees.is_some(),
                "{} ({}) is not compared",
                row.id,
                row.reading
            );
        }
    }
    assert!(
        due >= 20,
        "only {due} claims are due: the table has lost rows"
    );
}

#[test]
fn no_row_stands_twice() {
    let rows = all_rows();
    for (i, row) in rows.iter().enumerate() {
        let again = rows[i + 1..]
            .iter()
            .any(|other| (&other.id, &other.reading) == (&row.id, &row.reading));
        assert!(!again, "{} ({}) stands twice", row.id, row.reading);
    }
}
