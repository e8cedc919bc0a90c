//! Reads curves: functions of one argument through points.

use std::sync::Arc;

use super::CurveEntry;
use super::names::{Meaning, Names, did_you_mean};
use super::problem::{Problem, Source};
use super::switching::from_file;
use super::table::{Entry, Table, listed};
use crate::expression::{Between, Beyond, PiecewisePolynomial};

const BETWEEN: [(&str, Between); 2] =
    [("linear", Between::Linear), ("monotone", Between::Monotone)];

const BEYOND: [(&str, Beyond); 3] = [
    ("hold", Beyond::Hold),
    ("extend", Beyond::Extend),
    ("error", Beyond::Error),
];

/// The curves of a file.
pub(super) fn read(
    source: &Source,
    file: &Table<'_>,
    names: &mut Names,
) -> Result<Vec<CurveEntry>, Problem> {
    file.each("curves", |number, name, place, entry| {
        let name = names.add(name, place, Meaning::Curve(number))?;
        let table = entry.table("curves", &name)?;
        table.only(&["points", "file", "between", "beyond"])?;
        let (place, (xs, ys)) = match (table.get("points"), table.get("file")) {
            (Some(points), None) => {
                let pairs = points.pairs()?;
                (
                    points.place(),
                    pairs.into_iter().map(|[x, y]| (x, y)).unzip(),
                )
            }
            (None, Some(file)) => {
                let columns = ["argument", "value"];
                (file.place(), from_file(source, file, columns, true)?)
            }
            _ => {
                let place = table.place.clone();
                return Err(
                    Problem::new("a curve has points, or a file with them", place).help(
                        "points = [[0, 0.4], [1, 0.3]]; or file = \"mu.csv\" beside this file",
                    ),
                );
            }
        };
        let between = choice(table.get("between"), "between its points", &BETWEEN)?;
        let beyond = choice(table.get("beyond"), "beyond its points", &BEYOND)?;
        let curve = PiecewisePolynomial::new(&xs, &ys, between, beyond);
        let curve = curve.map_err(|no| Problem::new(no.message, place).help(no.help))?;
        Ok(CurveEntry {
            range: (xs[0], xs[xs.len() - 1]),
            points: xs.len(),
            curve: Arc::new(curve),
            name,
        })
    })
}

/// Reads one of several words; the default if there is none.
fn choice<T: Copy + Default>(
    entry: Option<Entry<'_>>,
    place: &str,
    words: &[(&str, T)],
) -> Result<T, Problem> {
    let Some(entry) = entry else {
        return Ok(T::default());
    };
    let text = entry.text()?;
    match words.iter().find(|(word, _)| *word == text) {
        Some((_, found)) => Ok(*found),
        None => {
            let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            let help = did_you_mean(text, known.iter().copied())
                .unwrap_or_else(|| format!("it can be {}", listed(&known)));
            let message = format!("{place} a curve cannot be `{text}`");
            Err(Problem::new(message, entry.place()).help(help))
        }
    }
}
