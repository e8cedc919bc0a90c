//! The ledger of claims: complete, resting on evidence, frozen; and the report's files are the committed ones.

mod browser;
mod page;

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{LazyLock, Mutex};

use crate::common::Numerically;
use replication::paper::listing::Defect;
use replication::paper::published::{Kind, claims};
use replication::report::cli::{Arguments, run};
use replication::report::entry::{Role, Verdict};
use replication::report::figures::claim_of;
use replication::report::ledger::{Ledger, TICKS};
use replication::report::matrix::Cell;
use replication::report::readme;

struct Report {
    folder: tempfile::TempDir,
    ledger: Ledger,
    text: String,
    ticks: usize,
}

/// Computed once for all tests: it takes some seconds.
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

fn with<T>(look: impl FnOnce(&Report) -> T) -> T {
    look(
        &REPORT
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner),
    )
}

#[test]
fn every_claim_has_a_verdict_and_every_verdict_its_evidence() {
    with(|report| {
        let claims = claims().unwrap();
        assert_eq!(report.ledger.entries.len(), claims.len());
        for (claim, entry) in claims.iter().zip(&report.ledger.entries) {
            let id = &claim.id;
            assert_eq!(claim, &entry.claim);
            assert!(!entry.readings.is_empty(), "{id}: no reading");
            assert!(
                entry.evidence.len() >= entry.readings.len(),
                "{id}: a reading is no evidence"
            );
            assert!(
                entry.evidence.iter().all(|line| !line.trim().is_empty()),
                "{id}"
            );
            assert_eq!(
                entry.cause.is_some(),
                entry.verdict == Verdict::AsPrintedOnly,
                "{id}"
            );
            if let Some(cause) = &entry.cause {
                assert!(!cause.defects.is_empty(), "{id}: no defect is named");
                let injected = |role| role == Role::Injected;
                let gives = entry
                    .readings
                    .iter()
                    .any(|one| injected(one.role()) && one.agrees);
                assert!(gives, "{id}: the injection does not give it");
            }
            let number = claim.kind == Kind::Value && entry.verdict == Verdict::ClassOnly;
            assert_eq!(entry.spread.is_some(), number, "{id}");
            if let Some(spread) = &entry.spread {
                assert!(spread.least < spread.largest, "{id}: {spread:?}");
            }
        }
        let total: usize = report.ledger.counts().iter().map(|(_, count)| count).sum();
        assert_eq!(total, claims.len());
    });
}

#[test]
fn every_table_speaks_of_claims_and_every_compared_row_of_one() {
    let claims = claims().unwrap();
    with(|report| {
        assert_eq!(report.ledger.tables.len(), 7);
        for table in &report.ledger.tables {
            let compared = table.rows.iter().filter(|row| row.agrees.is_some());
            let mut rows = 0;
            for row in compared {
                rows += 1;
                assert!(
                    claim_of(&row.id, &claims).is_some(),
                    "no claim behind {}",
                    row.id
                );
            }
            assert!(rows > 0, "{} speaks of no claim", table.figure);
        }
    });
}

#[test]
fn the_cause_of_fig_8_is_in_the_matrix() {
    with(|report| {
        let matrix = &report.ledger.matrix;
        assert_eq!(matrix.cells.len(), 128);
        assert!(matrix.all().gives_digits() && !matrix.none().gives_class());
        // Of the least set nothing can be mended.
        let least = matrix.minimal(Cell::gives_digits);
        assert!(!least.is_empty());
        for cell in least {
            for &defect in &cell.present {
                let rest = cell.present.iter().filter(|&&one| one != defect);
                let mask = rest.fold(0, |mask, one| {
                    let k = Defect::ALL.iter().position(|other| other == one);
                    mask | 1 << k.unwrap()
                });
                assert!(!matrix.cells[mask].gives_digits(), "without {defect:?}");
            }
        }
        for defect in matrix.necessary(Cell::gives_digits) {
            assert!(matrix.sentence().contains(defect.name()));
            assert!(!matrix.mended(defect).gives_digits());
        }
        // The mended listing may stand for an accurate solver.
        assert!(report.ledger.mended_listing_error < 1e-6);
        // Two sides of the same limit: steps towards zero, and the event-exact solver.
        let convergence = &report.ledger.convergence;
        for i in 0..4 {
            let errors = convergence.errors(i);
            assert_eq!(errors.len(), convergence.steps.len());
            assert!(errors.iter().all(|(h, e)| *e < 10.0 * h), "{errors:?}");
        }
    });
}

#[test]
fn all_misprints_are_borne_out() {
    with(|report| {
        let errata = &report.ledger.errata;
        assert!(errata.len() > Defect::ALL.len());
        for erratum in errata {
            assert!(erratum.holds && !erratum.shown.is_empty(), "{erratum:?}");
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
            assert_eq!(middle.counts, printed.counts, "{:?}", line.parameter);
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
        let table = readme::table(&report.ledger);
        let written =
            readme::with_table(readme, &table).expect("the README has marks for the table");
        assert!(written == readme, "run `make report`");
        let [reproduced, printed, class, none] = report.ledger.counts().map(|(_, count)| count);
        assert!(readme.contains(&format!(
            "{reproduced} are reproduced, {printed} as printed only"
        )));
        assert!(readme.contains(&format!("{class} in class only")));
        assert_eq!(none, 0, "the README names no claim that is not reproduced");
    });
}

/// What must not change unnoticed.
fn golden(ledger: &Ledger) -> String {
    let mut text = String::new();
    for entry in &ledger.entries {
        writeln!(text, "{} -> {}", entry.claim.id, entry.verdict).unwrap();
        for one in &entry.readings {
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
        if let Some(cause) = &entry.cause {
            writeln!(text, "  cause {}", cause.defects.join(" ")).unwrap();
        }
        if let Some(spread) = &entry.spread {
            writeln!(text, "  from {:?} to {:?}", spread.least, spread.largest).unwrap();
        }
    }
    writeln!(
        text,
        "{}\n{}",
        ledger.matrix.sentence(),
        ledger.convergence.sentence()
    )
    .unwrap();
    writeln!(text, "{}", ledger.scan.sentence()).unwrap();
    for erratum in &ledger.errata {
        writeln!(text, "{}: {}", erratum.place, erratum.holds).unwrap();
    }
    text
}

#[test]
fn the_ledger_is_frozen() {
    let text = with(|report| golden(&report.ledger));
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../../golden");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_comparator(Box::new(Numerically { tolerance: 1e-10 }));
    settings.bind(|| insta::assert_snapshot!("ledger", text));
}

#[test]
fn the_committed_files_are_the_computed_ones() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    with(|report| {
        for name in [
            "report/claims.csv",
            "figures/convergence.svg",
            "figures/convergence.csv",
            "figures/scan.svg",
            "figures/scan.csv",
        ] {
            let computed = std::fs::read_to_string(report.folder.path().join(name)).unwrap();
            let committed = std::fs::read_to_string(top.join(name)).unwrap();
            // Not assert_eq: nobody wants two whole files in the terminal.
            assert!(
                committed == computed,
                "{name} is not what the program computes now; run `make report` and look at the difference"
            );
        }
    });
}
