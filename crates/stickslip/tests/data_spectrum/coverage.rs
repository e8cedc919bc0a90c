//! The true exponent is within two error bars, at least nine times in ten where the status is `ok`: a part of the example
//! `spectrum_coverage`, and what it left behind.

#[path = "../../examples/spectrum_coverage/systems.rs"]
mod systems;
#[path = "../../examples/spectrum_coverage/table.rs"]
mod table;
#[path = "../../examples/spectrum_coverage/trial.rs"]
mod trial;

const CSV: &str = include_str!("../../examples/spectrum_coverage/coverage.csv");
const PAGE: &str = include_str!("../../examples/spectrum_coverage/README.md");

fn all(csv: &str) -> table::Group {
    table::groups(csv, |_, _| String::new()).remove(0)
}

#[test]
fn short_series_hold_what_ok_promises() {
    let mut rows = Vec::new();
    for case in systems::cases() {
        for seed in 21..23 {
            rows.extend(trial::trial(&case, 3000, seed).unwrap());
        }
    }
    let found = all(&table::csv(&rows));
    assert_eq!(found.series, 16);
    assert!(10 * found.found.holds >= 9 * found.found.ok, "{found:?}");
    assert!(10 * found.found.ok >= 6 * found.exponents, "{found:?}");
    // It is the estimator that makes it so, not the size of what is asked.
    let linear = &found.sano_sawada;
    assert!(10 * linear.holds < 9 * linear.ok, "{found:?}");
}

#[test]
fn the_table_is_that_of_the_csv_and_holds_what_ok_promises() {
    assert!(PAGE.contains(&table::tables(CSV)));
    let all = all(CSV);
    assert_eq!(all.series, 200);
    assert!(10 * all.found.holds >= 9 * all.found.ok, "{all:?}");
}

/// The known exponents are those of the equations: a shorter run is within a few of its own errors, here as parts of the
/// largest exponent.
#[test]
fn the_known_exponents_follow_from_the_equations() {
    for case in systems::cases() {
        let found = (case.exponents)(7, 40_000);
        let largest = case.known.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        for (found, known) in found.iter().zip(case.known) {
            assert!(
                (found - known).abs() < 0.03 * largest,
                "{}: {found} {known}",
                case.name
            );
        }
    }
}
