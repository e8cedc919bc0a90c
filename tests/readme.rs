//! The README's table says what the figures' rows say.

use stickslip::figures::fig04::Fig04;
use stickslip::figures::fig08::Fig08;
use stickslip::figures::rows::{Row, Value};
use stickslip::figures::{FigureError, FigureSpec};

fn rows<F: FigureSpec>() -> Result<Vec<Row>, FigureError> {
    Ok(F::numbers(&F::compute()?))
}

/// A row's value as the README shows it: numbers rounded to the published decimals.
fn shown(row: &Row) -> String {
    match &row.value {
        Value::Number(value) => {
            let published = row.published.as_deref().unwrap_or_default();
            let decimals = published
                .split_once('.')
                .map_or(0, |(_, digits)| digits.len());
            format!("{value:.decimals$}")
        }
        other => other.to_string(),
    }
}

#[test]
fn the_table_is_what_the_figures_compute() -> Result<(), FigureError> {
    let mut all = rows::<Fig04>()?;
    all.extend(rows::<Fig08>()?);
    let sticks = all
        .iter()
        .find(|row| row.id == "fig08.sticks_per_period" && row.reading == "exact");
    assert_eq!(
        sticks.map(shown).as_deref(),
        Some("0"),
        "the exact orbit sticks"
    );
    let readme = include_str!("../README.md");
    let lines: Vec<Vec<&str>> = readme
        .lines()
        .filter(|line| line.starts_with("| `fig"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(lines.len() >= 10, "the table is gone");
    for line in lines {
        let [id, published, as_printed, exact] = line[..] else {
            panic!("{line:?} has not four columns");
        };
        let id = id.trim_matches('`');
        for (reading, cell) in [("as-printed", as_printed), ("exact", exact)] {
            let row = all
                .iter()
                .find(|row| row.id == id && row.reading == reading);
            match row {
                Some(row) => {
                    assert_eq!(cell, shown(row), "{id}, {reading}");
                    assert_eq!(Some(published), row.published.as_deref(), "{id}");
                }
                None => assert!(
                    cell.is_empty() || cell == "no stick phase" && reading == "exact",
                    "{id}, {reading}: {cell:?} has no row behind it"
                ),
            }
        }
    }
    Ok(())
}
