//! The ledger of claims is complete, rests on evidence and is frozen; the report's files are the
//! committed ones.

mod block_and_bracket;
mod cause;
mod page;

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{LazyLock, Mutex};

use crate::common::assert_golden;
use replication::paper::claim_id::ClaimId;
use replication::paper::listing::{Defect, Defects};
use replication::paper::published::{Claims, Digits, Group};
use replication::paper::reading::Role;
use replication::report::cli::{Arguments, run};
use replication::report::finding::Finding;
use replication::report::ledger::{Ledger, TICKS};
use replication::report::matrix::ComparedRun;
use replication::report::readme;
use replication::report::verdict::Verdict;

/// Results and files of the program `report`.
pub struct Report {
    folder: tempfile::TempDir,
    /// The ledger with all figures' tables.
    pub ledger: Ledger,
    text: String,
    ticks: usize,
}

/// Computed once for all tests, in some seconds.
static REPORT: LazyLock<Mutex<Report>> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let ticks = AtomicUsize::new(0);
    let arguments = Arguments {
        out_dir: folder.path().to_owned(),
    };
    let (ledger, text) = run(&arguments, &|| {
        ticks.fetch_add(1, Ordering::Relaxed);
    })
    .unwrap();
    Mutex::new(Report {
        folder,
        ledger,
        text,
        ticks: ticks.into_inner(),
    })
});

/// Gives a test access to the report.
pub fn with<T>(look: impl FnOnce(&Report) -> T) -> T {
    look(
        &REPORT
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner),
    )
}

#[test]
fn every_claim_has_a_verdict_that_follows_from_its_findings() {
    let claims = Claims::committed().unwrap();
    with(|report| {
        assert_eq!(report.ledger.entries.len(), ClaimId::ALL.len());
        for (claim, entry) in claims.iter().zip(&report.ledger.entries) {
            let id = claim.id;
            assert_eq!(claim, &entry.claim);
            assert_eq!(
                entry.verdict,
                Verdict::of(claim.kind, &entry.findings, &entry.corrections),
                "{id}"
            );
            let lines = entry.lines();
            assert!(
                lines.len() > entry.findings.len(),
                "{id}: a finding is no evidence"
            );
            assert!(lines.iter().all(|line| !line.trim().is_empty()), "{id}");
            let corrected = |one: &Finding| one.reading.role() == Role::Corrected;
            let corrected = entry.findings.iter().any(corrected);
            assert_eq!(!entry.corrections.is_empty(), corrected, "{id}");
            let is_exponent = claim.group == Group::Exponent;
            assert_eq!(entry.exponent.is_some(), is_exponent, "{id}");
        }
        let total: usize = report.ledger.counts().iter().map(|(_, count)| count).sum();
        assert_eq!(total, report.ledger.counted());
        let identities = report
            .ledger
            .entries
            .iter()
            .filter(|one| one.verdict == Verdict::Identity);
        assert_eq!(total + identities.count(), ClaimId::ALL.len());
    });
}

/// The entry that the ledger would have if the paper had printed something else.
#[test]
fn a_changed_digit_in_the_table_of_claims_changes_its_row() {
    let text = include_str!("../../data/claims.csv");
    let changes = [
        (
            "value,0.4697,4",
            "value,0.4698,4",
            ClaimId::Fig08StickLength1,
        ),
        (
            "value,0.4161,4",
            "value,0.4164,4",
            ClaimId::Fig08StickDuration2,
        ),
        (
            ",quasi-periodic,,,class",
            ",periodic,,,class",
            ClaimId::Fig11Class,
        ),
        (
            "\"visible 1,3,5; invisible 2,4,6\"",
            "\"visible 1,3,6; invisible 2,4,5\"",
            ClaimId::Fig04Visibility,
        ),
        (
            "0;0.38490017945975051;-0.38490017945975051,exact,1,critical mu0:",
            "0;0.38490017946975051;-0.38490017945975051,exact,1,critical mu0:",
            ClaimId::Eq13CriticalMu0,
        ),
        (
            "statement,2,,,two deflection",
            "statement,3,,,two deflection",
            ClaimId::Fig08Deflections,
        ),
    ];
    with(|report| {
        for (printed, instead, id) in changes {
            assert_eq!(text.matches(printed).count(), 1, "{printed}");
            let claims = Claims::parse(&text.replace(printed, instead)).unwrap();
            let entry = report.ledger.entry(id);
            let again = report.ledger.rejudged(&claims, id);
            assert_ne!(again.verdict, entry.verdict, "{id}: {instead}");
            // With the unchanged table, nothing changes.
            let same = report.ledger.rejudged(Claims::committed().unwrap(), id);
            assert_eq!(same.verdict, entry.verdict, "{id}");
        }
    });
}

/// The row of a claim as it would be judged if the paper had printed another number.
fn verdict_of(ledger: &Ledger, id: ClaimId, published: f64) -> Verdict {
    let text = include_str!("../../data/claims.csv");
    let claim = Claims::committed().unwrap().of(id);
    let Digits::Decimals(decimals) = claim.digits else {
        panic!("{id} has no decimals");
    };
    let old = format!("\n{id},{},value,{},", claim.location, claim.published);
    assert_eq!(text.matches(&old).count(), 1, "{old}");
    let new = format!("\n{id},{},value,{published:.decimals$},", claim.location);
    let claims = Claims::parse(&text.replace(&old, &new)).unwrap();
    ledger.rejudged(&claims, id).verdict
}

/// Digits outside the range of the settings are not reproduced, digits inside are undeterminable;
/// where no setting identifies an exponent, its sign decides.
#[test]
fn published_exponents_decide_their_verdicts() {
    use Verdict::{NotReproduced, Undeterminable};
    let [mut outside, mut inside, mut by_sign] = [const { Vec::new() }; 3];
    with(|report| {
        let ledger = &report.ledger;
        for entry in ledger.entries.iter().filter(|one| one.exponent.is_some()) {
            let (id, check) = (entry.claim.id, entry.exponent.unwrap());
            let Some([least, largest]) = check.range.widened() else {
                assert_eq!(entry.verdict, Undeterminable, "{id}");
                assert_eq!(
                    verdict_of(ledger, id, -check.published),
                    NotReproduced,
                    "{id}"
                );
                by_sign.push(id.name());
                continue;
            };
            assert!(
                check
                    .range
                    .errors
                    .iter()
                    .all(|one| *one > 0.0 && *one < 1.0),
                "{check:?}"
            );
            let unit = if id == ClaimId::Fig12Ratio {
                1e-3
            } else {
                1e-4
            };
            let middle = least.midpoint(largest);
            assert_eq!(
                verdict_of(ledger, id, middle),
                Undeterminable,
                "{id}: {middle}"
            );
            for beyond in [least - 2.0 * unit, largest + 2.0 * unit, 7.0] {
                assert_eq!(
                    verdict_of(ledger, id, beyond),
                    NotReproduced,
                    "{id}: {beyond}"
                );
            }
            match entry.verdict {
                NotReproduced => outside.push(id.name()),
                _ => inside.push(id.name()),
            }
        }
    });
    assert_eq!(
        outside,
        [
            "fig10.lambda.1",
            "fig10.lambda.2",
            "fig11.lambda.3",
            "fig12.lambda.1",
            "fig12.lambda_ratio"
        ]
    );
    assert_eq!(
        inside,
        [
            "fig11.lambda.1",
            "fig11.lambda.2",
            "fig12.lambda.2",
            "fig12.lambda.3"
        ]
    );
    assert_eq!(
        by_sign,
        [
            "fig10.lambda.3",
            "fig10.lambda.4",
            "fig11.lambda.4",
            "fig12.lambda.4"
        ]
    );
}

/// The estimates at the ends, made again for their standard errors, are those of the search.
#[test]
fn the_ends_of_the_ranges_are_made_again() {
    with(|report| {
        let spread = &report.ledger.spread;
        assert!(spread.at_ends.len() > 10);
        for ((figure, row), exponents) in &spread.at_ends {
            let row = &spread.search.recommended[*row].0;
            for (k, one) in exponents.iter().enumerate() {
                let committed = row.exponents[*figure][k];
                let off = (one.value - committed).abs();
                assert!(
                    off <= 1e-9 * committed.abs(),
                    "{row:?}: {} {committed}",
                    one.value
                );
                assert_eq!(one.status.word(), row.statuses[*figure][k]);
            }
        }
    });
}

#[test]
fn more_neighbours_than_components_are_not_enough() {
    with(|report| {
        for id in [ClaimId::S5Reconstruction, ClaimId::S5LargeEnough] {
            let entry = report.ledger.entry(id);
            assert_eq!(entry.verdict, Verdict::NotReproduced, "{id}");
        }
        // Some exponent is identified by some settings and not by others, all with twelve
        // neighbours or more.
        let check = report.ledger.entry(ClaimId::Fig11Lambda3).exponent.unwrap();
        let identifying = check.range.identifying;
        assert!(
            (1..check.range.settings).contains(&identifying),
            "{check:?}"
        );
    });
}

/// Of Fig. 10's caption: one loop from every start, and two only far from its numbers.
#[test]
fn fig_10_has_one_loop_from_every_start_and_two_far_away_only() {
    with(|report| {
        let loops = &report.ledger.statements.loops;
        assert_eq!(loops.starts.0, loops.starts.1, "{loops:?}");
        let far = |(_, factor): &(&str, f64)| (factor - 1.0).abs() > 0.15;
        assert!(
            !loops.nearest.is_empty() && loops.nearest.iter().all(far),
            "{loops:?}"
        );
    });
}

#[test]
fn the_cause_of_fig_8_is_in_the_matrix() {
    with(|report| {
        let matrix = &report.ledger.matrix;
        assert_eq!(matrix.runs.len(), 128);
        assert!(matrix.with(Defects::AS_PRINTED).gives_digits());
        assert!(!matrix.with(Defects::MENDED).gives_class());
        // Nothing in the smallest set can be mended.
        let least = matrix.minimal(ComparedRun::gives_digits);
        assert!(!least.is_empty());
        for cell in least {
            for defect in cell.present.present() {
                let without = matrix.with(cell.present.flipped(defect));
                assert!(!without.gives_digits(), "without {defect:?}");
            }
        }
        let necessary = matrix.necessary(ComparedRun::gives_digits);
        assert!(!necessary.is_empty());
        for defect in necessary {
            assert!(matrix.sentence().contains(defect.name()));
            assert!(!matrix.mended(defect).gives_digits());
        }
    });
}

#[test]
fn all_misprints_are_borne_out() {
    with(|report| {
        let errata = &report.ledger.errata;
        assert!(errata.len() > Defect::ALL.len());
        for erratum in errata {
            let by_reading = erratum.by_reading.is_some();
            assert!(
                erratum.holds && erratum.shown.is_empty() == by_reading,
                "{erratum:?}"
            );
        }
    });
}

#[test]
fn the_scan_covers_a_factor_of_two_either_way() {
    with(|report| {
        let scan = &report.ledger.scan;
        assert_eq!(scan.lines.len(), 8);
        let printed = scan.printed().unwrap();
        for line in &scan.lines {
            let ends = (line.points.first().unwrap(), line.points.last().unwrap());
            assert_eq!((ends.0.factor, ends.1.factor), (0.5, 2.0));
            for point in &line.points {
                assert!(point.counts.iter().sum::<usize>() > 40);
            }
            let middle = line
                .points
                .iter()
                .find(|point| point.factor == 1.0)
                .unwrap();
            assert_eq!(middle.counts, printed.counts, "{}", line.name);
        }
    });
}

#[test]
fn progress_comes_to_its_end() {
    with(|report| {
        assert_eq!(report.ticks, TICKS);
        for (verdict, count) in report.ledger.counts() {
            assert!(report.text.contains(&format!("{count:>5} {verdict}\n")));
        }
    });
}

#[test]
fn the_readme_says_what_the_ledger_does() {
    let readme = include_str!("../../README.md");
    with(|report| {
        let block = readme::block(&report.ledger);
        let written = readme::SECTION_MARKERS
            .replace_section(readme, &block)
            .expect("the README has marks for its verdicts");
        assert!(written == readme, "run `make report`");
    });
}

/// The contents that must not change unnoticed.
fn golden(ledger: &Ledger) -> String {
    let mut text = String::new();
    for entry in &ledger.entries {
        writeln!(text, "{} -> {}", entry.claim.id, entry.verdict).unwrap();
        for one in &entry.findings {
            let values = one.text().replace(';', " ");
            let digits = one
                .digits
                .map_or_else(String::new, |digits| format!("({digits} digits)"));
            writeln!(
                text,
                "  {} {} {values} {} {digits}",
                one.source, one.reading, one.agrees
            )
            .unwrap();
        }
        if let Some(exponent) = &entry.exponent {
            let (sign, agrees) = (exponent.sign, exponent.sign_agrees());
            writeln!(text, "  sign {sign} {agrees}").unwrap();
            for range in [exponent.range, exponent.linear] {
                let (identifying, settings) = (range.identifying, range.settings);
                write!(text, "  {identifying} of {settings}").unwrap();
                if let Some([least, largest]) = range.ends {
                    write!(text, " from {least:?} to {largest:?}").unwrap();
                }
                writeln!(text).unwrap();
            }
            let [least, largest] = exponent.range.errors;
            writeln!(text, "  errors {least:?} {largest:?}").unwrap();
        }
    }
    writeln!(
        text,
        "{}\n{}\n{}",
        ledger.matrix.sentence(),
        ledger.convergence.sentence(),
        ledger.scan.sentence()
    )
    .unwrap();
    writeln!(text, "cause {}", ledger.cause.status()).unwrap();
    for erratum in &ledger.errata {
        writeln!(text, "{}: {}", erratum.location, erratum.holds).unwrap();
    }
    text
}

#[test]
fn the_ledger_is_frozen() {
    let text = with(|report| golden(&report.ledger));
    assert_golden("ledger", text, 1e-10);
}

#[test]
fn the_committed_files_are_the_computed_ones() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    with(|report| {
        for name in [
            "report/index.html",
            "report/claims.csv",
            "figures/convergence.svg",
            "figures/convergence.csv",
            "figures/scan.svg",
            "figures/scan.csv",
        ] {
            let computed = std::fs::read_to_string(report.folder.path().join(name)).unwrap();
            let committed = std::fs::read_to_string(top.join(name)).unwrap();
            // assert_eq would print both files.
            assert!(
                committed == computed,
                "{name} is not what the program computes now; run `make report` and look at the \
                    difference"
            );
        }
    });
}
