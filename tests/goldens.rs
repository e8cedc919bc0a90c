//! The numbers of every figure against `golden/`, and the pictures against `figures/`.
//!
//! After a change that is meant, `INSTA_UPDATE=always cargo test --test goldens` rewrites the goldens and the
//! figure programs rewrite the pictures; the diff shows what changed.

use std::path::Path;

use crate::common::Numerically;
use replication::figures::{FigureSpec, rows};

/// Relative difference up to which two numbers in a golden are the same.
const TOLERANCE: f64 = 1e-10;

fn numbers_are_the_golden_ones<F: FigureSpec>() {
    let data = F::compute().unwrap();
    let text = rows::golden(&F::numbers(&data));
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../golden");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_comparator(Box::new(Numerically {
        tolerance: TOLERANCE,
    }));
    settings.bind(|| insta::assert_snapshot!(F::NAME, text));
}

fn the_committed_picture_is_the_drawn_one<F: FigureSpec>() {
    let data = F::compute().unwrap();
    let first = F::draw(&data).unwrap();
    assert!(first == F::draw(&data).unwrap(), "two drawings differ");
    let csv = rows::csv(&F::numbers(&data)).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures");
    for (extension, drawn) in [("svg", first), ("csv", csv)] {
        let path = folder.join(format!("{}.{extension}", F::NAME));
        let committed = std::fs::read_to_string(&path).unwrap();
        // Not assert_eq: nobody wants two whole pictures in the terminal.
        assert!(
            committed == drawn,
            "{} is not what the program draws now; run `cargo run --release --bin {}` and look at the difference",
            path.display(),
            F::NAME
        );
    }
}

macro_rules! figures {
    ($($name:ident: $figure:ident),* $(,)?) => {$(
        mod $name {
            use super::*;
            use replication::figures::$name::$figure;

            #[test]
            fn numbers() {
                numbers_are_the_golden_ones::<$figure>();
            }

            #[test]
            fn picture() {
                the_committed_picture_is_the_drawn_one::<$figure>();
            }
        }
    )*};
}

figures!(
    fig04: Fig04,
    fig06: Fig06,
    fig07: Fig07,
    fig08: Fig08,
    fig10: Fig10,
    fig11: Fig11,
    fig12: Fig12,
    locator: Locator,
);

#[test]
fn the_comparison_lets_rounding_pass_and_nothing_else() {
    let compare = Numerically {
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
    // Everything that is not a number counts to the letter, but not the width of a column.
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
