//! Every claim has a finding that can decide it, and every row of a figure's table occurs once.

use crate::report::with;
use replication::figures::rows::Quantity;
use replication::paper::claim_id::ClaimId;
use replication::paper::published::Claims;
use replication::paper::reading::Role;
use replication::report::verdict::Verdict;

/// `report/datapackage.json` describes the columns of `report/claims.csv`, and `codemeta.json` the
/// version.
#[test]
fn every_column_of_the_table_of_claims_is_described() {
    let package: serde_json::Value =
        serde_json::from_str(include_str!("../report/datapackage.json")).unwrap();
    let fields = package["resources"][0]["schema"]["fields"]
        .as_array()
        .unwrap();
    let described = fields.iter().map(|field| {
        assert!(field["description"].as_str().unwrap().len() > 5, "{field}");
        field["name"].as_str().unwrap()
    });
    let table = include_str!("../report/claims.csv");
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    assert_eq!(described.collect::<Vec<_>>(), header);
    let meta: serde_json::Value = serde_json::from_str(include_str!("../codemeta.json")).unwrap();
    assert_eq!(meta["version"], env!("CARGO_PKG_VERSION"));
}

#[test]
fn every_claim_has_a_finding_that_decides() {
    with(|report| {
        for entry in &report.ledger.entries {
            if entry.verdict == Verdict::Identity {
                continue;
            }
            let decides = |role| {
                let mut of = entry.findings.iter();
                of.any(|one| one.reading.role() == role && !one.by_construction)
            };
            assert!(
                [Role::Stated, Role::Corrected, Role::AsPrinted].map(decides) != [false; 3],
                "{}",
                entry.claim.id
            );
        }
    });
}

#[test]
fn a_row_that_claims_something_is_compared() {
    let claims = Claims::committed().unwrap();
    let mut compared = 0;
    with(|report| {
        for row in report
            .ledger
            .computed
            .pictures
            .iter()
            .flat_map(|picture| &picture.rows)
        {
            let claim = matches!(row.quantity, Quantity::Claim(_) | Quantity::Member(..));
            assert_eq!(
                row.comparison(claims).is_some(),
                claim,
                "{} ({})",
                row.quantity,
                row.reading
            );
            compared += usize::from(claim);
        }
    });
    assert!(compared > ClaimId::ALL.len());
}

#[test]
fn no_row_stands_twice_in_a_table() {
    with(|report| {
        for table in &report.ledger.computed.pictures {
            for (i, row) in table.rows.iter().enumerate() {
                let again = table.rows[i + 1..]
                    .iter()
                    .any(|other| (&other.quantity, other.reading) == (&row.quantity, row.reading));
                assert!(!again, "{} ({}) stands twice", row.quantity, row.reading);
            }
        }
    });
}
