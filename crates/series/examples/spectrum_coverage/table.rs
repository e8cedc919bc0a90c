//! The results as CSV, and their table in Markdown.

use std::fmt::Write;

use numerics::middle_two;

use super::trial::{Observed, Row, Verdict};

/// First line of the CSV.
const HEADER: &str = "system,observed,points,seed,index,known,exponent,stderr,status,holds,\
    sano_sawada,sano_sawada_stderr,sano_sawada_status,sano_sawada_holds";

/// One line per exponent; a missing value is an empty cell.
pub fn csv(rows: &[Row]) -> String {
    let mut text = format!("{HEADER}\n");
    for row in rows {
        let verdict = |verdict: &Option<Verdict>| match verdict {
            Some(verdict) => format!(
                "{},{},{},{}",
                number(verdict.value),
                number(verdict.stderr),
                verdict.status.word(),
                verdict.holds(row.known)
            ),
            None => ",,missing,false".to_owned(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{}",
            row.system,
            row.observed.word(),
            row.points,
            row.seed,
            row.index,
            number(row.known),
            verdict(&row.found),
            verdict(&row.sano_sawada)
        );
    }
    text
}

fn number(v: f64) -> String {
    if v.is_nan() {
        String::new()
    } else {
        format!("{v:.6}")
    }
}

/// Counts for one estimator.
#[derive(Clone, Debug, Default)]
pub struct Count {
    /// Exponents with the status `ok`.
    pub ok: usize,
    /// Exponents among these whose true value is within two standard errors.
    pub holds: usize,
    /// Distances of those from the true values.
    errors: Vec<f64>,
}

impl Count {
    fn add(&mut self, known: &str, cells: &[&str]) {
        let [value, _, status, holds] = cells else {
            return;
        };
        if *status == "ok" {
            self.ok += 1;
            self.holds += usize::from(*holds == "true");
            if let (Ok(value), Ok(known)) = (value.parse::<f64>(), known.parse::<f64>()) {
                self.errors.push((value - known).abs());
            }
        }
    }

    fn cells(&self, exponents: usize) -> String {
        let error = middle_two(self.errors.iter().copied());
        format!(
            "{} | {} | {}",
            percent(self.ok, exponents),
            percent(self.holds, self.ok),
            error.map_or("–".into(), |[_, error]| format!("{error:.4}"))
        )
    }
}

/// A group of series.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// Name of the group.
    pub name: String,
    /// Series.
    pub series: usize,
    /// Exponents of the systems.
    pub exponents: usize,
    /// Count with the default settings.
    pub found: Count,
    /// Count with Sano and Sawada's estimator.
    pub sano_sawada: Count,
}

/// Groups the rows of what was `observed`, from a CSV written by [`csv`], by a name made of system
/// and points. The order is that of first occurrence.
pub fn groups(csv: &str, observed: Observed, name: impl Fn(&str, &str) -> String) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for line in csv.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [system, seen, points, _, index, known, verdicts @ ..] = &cells[..] else {
            continue;
        };
        if *seen != observed.word() {
            continue;
        }
        let name = name(system, points);
        let at = match groups.iter().position(|group| group.name == name) {
            Some(at) => at,
            None => {
                groups.push(Group {
                    name,
                    ..Group::default()
                });
                groups.len() - 1
            }
        };
        let group = &mut groups[at];
        group.series += usize::from(*index == "1");
        group.exponents += usize::from(!known.is_empty());
        if verdicts.len() == 8 {
            group.found.add(known, &verdicts[..4]);
            group.sano_sawada.add(known, &verdicts[4..]);
        }
    }
    groups
}

fn percent(part: usize, whole: usize) -> String {
    if whole == 0 {
        "–".into()
    } else {
        format!("{:.0} %", 100.0 * part as f64 / whole as f64)
    }
}

/// The Markdown table of what was `observed`, from a CSV: by system, by length, and in total.
pub fn table(csv: &str, observed: Observed) -> String {
    let mut text = String::from(
        "| | series | exponents | ok | within 2σ if ok | error if ok | Sano–Sawada: ok | within 2σ \
         if ok | error if ok |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    let by_system = groups(csv, observed, |system, _| system.to_owned());
    let by_length = groups(csv, observed, |_, points| format!("{points} points"));
    let all = groups(csv, observed, |_, _| "**all**".to_owned());
    for group in by_system.iter().chain(&by_length).chain(&all) {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} |",
            group.name,
            group.series,
            group.exponents,
            group.found.cells(group.exponents),
            group.sano_sawada.cells(group.exponents)
        );
    }
    text
}
