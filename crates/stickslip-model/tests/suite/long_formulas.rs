//! Formulas with many terms. Each runs on a stack of one megabyte, which recursion on
//! the terms would overflow.

use std::thread::Builder;

use stickslip::Error;
use stickslip::error::Point;
use stickslip::math::sin;
use stickslip_model::expression::parse;
use stickslip_model::file::{Interface, Source, System, SystemFile};
use stickslip_model::kernel::Combination;

const TERMS: usize = 30_000;

fn on_a_small_stack(test: impl FnOnce() + Send + 'static) {
    let thread = Builder::new().stack_size(1 << 20).spawn(test);
    thread.unwrap().join().unwrap();
}

fn system(entries: &str) -> System {
    let text = format!("name = \"long\"\n[states]\nx = \"\"\n{entries}");
    let name = "long.toml".to_owned();
    let file = SystemFile::parse(Source { name, text }).unwrap();
    file.with(&[]).unwrap()
}

fn rate(system: &System, x: f64) -> f64 {
    system.field(Combination { above: 0, held: 0 }, 0.0, &[x])[0]
}

#[test]
fn sums_and_products_have_any_number_of_terms() {
    on_a_small_stack(|| {
        for (operator, wanted) in [
            (" + ", 2.0 * TERMS as f64),
            (" - ", 4.0 - 2.0 * TERMS as f64),
            ("*", f64::INFINITY),
            ("/", 0.0),
        ] {
            let text = vec!["x"; TERMS].join(operator);
            let system = system(&format!("[field]\nx = \"{text}\"\n"));
            assert_eq!(rate(&system, 2.0), wanted, "{operator}");
            // Copies, comparisons and prints need no more.
            let tree = parse(&text).unwrap();
            assert_eq!(tree.clone(), tree);
            assert!(format!("{tree:?}").len() > text.len());
        }
    });
}

#[test]
fn functions_of_many_angles_are_shared_at_once() {
    on_a_small_stack(|| {
        let terms: Vec<String> = (0..TERMS).map(|k| format!("sin(x + {k})")).collect();
        let system = system(&format!("[field]\nx = \"{}\"\n", terms.join(" + ")));
        let wanted: f64 = (0..TERMS).map(|k| sin(0.5 + k as f64)).sum();
        assert!((rate(&system, 0.5) - wanted).abs() < 1e-9);
    });
}

#[test]
fn definitions_are_nested_to_a_limit_that_is_told() {
    on_a_small_stack(|| {
        let text = |depth: usize| {
            let define = |k: usize| format!("d{k} = \"d{} + 1\"\n", k - 1);
            let deep: String = (1..depth).map(define).collect();
            let last = depth - 1;
            format!(
                "name = \"deep\"\n[states]\nx = \"\"\n[definitions]\nd0 = \"x\"\n{deep}\
                 [field]\nx = \"d{last}\"\n"
            )
        };
        let name = "deep.toml".to_owned();
        let read = |text| {
            SystemFile::parse(Source {
                name: name.clone(),
                text,
            })
        };
        assert!(read(text(100)).is_ok());
        let error = read(text(20_000)).unwrap_err().to_string();
        assert!(error.contains("nested deeper than 300 levels"), "{error}");
    });
}

/// Options as they are.
struct Plain;

impl Interface for Plain {
    fn name(&self, option: &str) -> String {
        option.to_owned()
    }
    fn choice(&self, option: &str, _: &[&str]) -> String {
        option.to_owned()
    }
    fn value(&self, option: &str, _: f64) -> String {
        option.to_owned()
    }
    fn nearer(&self) -> &'static str {
        ""
    }
}

#[test]
fn the_undefined_part_of_a_long_formula_is_named() {
    on_a_small_stack(|| {
        let ones = vec!["x"; TERMS].join(" + ");
        for (formula, part) in [
            (
                format!("{ones} + ln(x)"),
                "`ln(x)` is not a number where `x` is -1",
            ),
            (
                format!("d + {ones}"),
                "`sqrt(x)` is not a number where `x` is -1",
            ),
            (
                "x + x/(x + 1)/2 + x".to_owned(),
                "`x/(x + 1)` is infinite where `x` is -1 and",
            ),
        ] {
            let text = format!("[definitions]\nd = \"2*sqrt(x)\"\n[field]\nx = \"{formula}\"\n");
            let error = Error::StartOutsideDomain {
                t: 0.0,
                x: Point(vec![-1.0]),
                what: "the field",
            };
            let words = Plain.words(&error, Some(&system(&text)));
            assert!(words.contains(part), "{words}");
        }
    });
}

#[test]
fn a_fault_in_a_long_line_has_a_short_message_with_its_place() {
    let text = format!(
        "name = \"long\"\n[states]\nx = \"\"\n[field]\nx = \"{}y\"\n",
        "x + ".repeat(TERMS)
    );
    let name = "long.toml".to_owned();
    let shown = SystemFile::parse(Source { name, text })
        .unwrap_err()
        .to_string();
    assert!(shown.contains("unknown name `y`"), "{shown}");
    assert!(
        shown.contains(&format!("long.toml:5:{}", 6 + 4 * TERMS)),
        "{shown}"
    );
    assert!(shown.len() < 400, "{shown}");
}
