//! The numbers of every figure are compared with `golden/` and the pictures with `figures/`. The
//! report computes each figure once.
//!
//! The snapshots are the golden files. The tables in `figures/*.csv` hold the same rows for other
//! programs. They are current if `make figures` leaves the tree clean.

use std::path::Path;

use crate::common::{NumericComparison, assert_golden};
use crate::report::with;
use replication::figures::locator::LOCATOR;
use replication::figures::rows;
use replication::paper::published::Claims;
use replication::report::figures::Picture;

/// Relative difference up to which two numbers in a golden file are equal.
const TOLERANCE: f64 = 1e-10;

fn is_golden(table: &Picture) {
    let text = rows::golden(&table.rows, Claims::committed().unwrap());
    assert_golden(table.figure, text, TOLERANCE);
    let name = table.figure;
    for (file, computed) in [
        (format!("figures/{name}.svg"), &table.svg),
        (format!("figures/curves/{name}.csv"), &table.curves),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(&file);
        let committed = std::fs::read_to_string(&path).unwrap();
        // assert_eq would print both files.
        assert!(
            committed == *computed,
            "{file} is not what the program draws now; run `make figures` and look at the \
             difference"
        );
        assert!(file.ends_with("svg") || computed.len() <= 100_000, "{file}");
    }
}

macro_rules! figures {
    ($($name:ident),* $(,)?) => {$(
        #[test]
        fn $name() {
            with(|report| {
                let tables = &report.ledger.computed.pictures;
                let table = tables.iter().find(|table| table.figure == stringify!($name));
                is_golden(table.unwrap());
            });
        }
    )*};
}

figures!(fig04, fig06, fig07, fig08, fig10, fig11, fig12);

#[test]
fn locator() {
    let data = LOCATOR.compute().unwrap();
    is_golden(&Picture::of(&LOCATOR, &data).unwrap());
}

#[test]
fn the_comparison_lets_rounding_pass_and_nothing_else() {
    let compare = NumericComparison {
        tolerance: TOLERANCE,
    };
    let same = |a: &str, b: &str| compare.same(a, b);
    let golden = "eq22.1  exact  0.5773502691896257  √(k1/3)  true";
    let scaled = |factor: f64| {
        golden.replace(
            "0.5773502691896257",
            &(0.5773502691896257 * factor).to_string(),
        )
    };
    assert!(same(golden, &scaled(1.0 + 1e-11)));
    assert!(!same(golden, &scaled(1.0 + 1e-9)));
    assert!(!same(golden, &scaled(-1.0)));
    // Everything except numbers and the width of columns must agree exactly.
    assert!(!same(golden, &golden.replace("true", "false")));
    assert!(!same(golden, &golden.replace("eq22.1", "eq22.2")));
    assert!(!same(golden, &format!("{golden}\n{golden}")));
    assert!(!same("a b", "a\nb"));
    assert!(same(golden, &golden.replace("  ", "   ")));
    // Infinities and zeros have no relative error.
    assert!(same("-inf", "-inf"));
    assert!(!same("-inf", "inf"));
    assert!(!same("-inf", "-1e300"));
    assert!(!same("0.0", "1e-30"));
    assert!(!same("NaN", "1.0"));
}
