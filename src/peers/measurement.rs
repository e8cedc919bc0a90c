//! Measurements of one solver at one setting on one problem.

use std::str::FromStr;

use super::problem::Problem;
use crate::numbers::median;
use crate::text;

/// A row of report/bench.csv.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Solver.
    pub solver: String,
    /// Problem.
    pub problem: &'static str,
    /// Setting, in words.
    pub setting: String,
    /// Tolerance, or the step if that is fixed.
    pub tolerance: Option<f64>,
    /// Largest error of an event time; `None` if the events differ from those of the reference.
    pub error: Option<f64>,
    /// Number of events.
    pub events: Option<usize>,
    /// Time of a run in each round (s), after compilation and warm-up.
    pub seconds: Vec<f64>,
    /// Time to compile (s), not part of `seconds`.
    pub compile: Option<f64>,
    /// Time of a whole process that starts, compiles and runs once (s).
    pub process: Option<f64>,
    /// Why there is no error or no time.
    pub note: String,
}

/// Header of the file.
const HEADER: [&str; 11] = [
    "solver",
    "problem",
    "setting",
    "tolerance",
    "error",
    "events",
    "median_s",
    "min_s",
    "compile_s",
    "process_s",
    "note",
];

/// The rows as CSV.
pub fn csv(rows: &[Measurement]) -> String {
    let short = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.3e}"));
    let count = |value: Option<usize>| value.map_or(String::new(), |value| value.to_string());
    let record = |row: &Measurement| {
        [
            row.solver.clone(),
            row.problem.into(),
            row.setting.clone(),
            short(row.tolerance),
            short(row.error),
            count(row.events),
            short(median(&row.seconds)),
            short(row.seconds.iter().copied().min_by(f64::total_cmp)),
            short(row.compile),
            short(row.process),
            row.note.clone(),
        ]
    };
    let head = std::iter::once(HEADER.map(str::to_owned));
    text::csv(head.chain(rows.iter().map(record)))
}

/// Parses such a CSV. Each row has its median in place of its rounds.
///
/// # Errors
/// A message with the line that is not as [`csv`] writes it, or that names an unknown problem.
pub fn read(text: &str, problems: &[Problem]) -> Result<Vec<Measurement>, String> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut rows = Vec::new();
    for (index, record) in reader.records().enumerate() {
        let wrong = |cause: String| {
            let line = index + 1;
            format!("bench.csv, line {line}: {cause}; measure again with `peers`")
        };
        let record = record.map_err(|error| wrong(error.to_string()))?;
        let cells: Vec<&str> = record.iter().collect();
        if index == 0 {
            if cells != HEADER {
                return Err(wrong(format!("the head should be {}", HEADER.join(","))));
            }
            continue;
        }
        if cells.len() != HEADER.len() {
            let (actual, expected) = (cells.len(), HEADER.len());
            return Err(wrong(format!("{actual} cells where {expected} are due")));
        }
        let number = |cell: usize| parse_optional(cells[cell], "number").map_err(wrong);
        let problem = problems.iter().find(|one| one.name == cells[1]);
        let unknown = || wrong(format!("'{}' is none of the problems", cells[1]));
        rows.push(Measurement {
            solver: cells[0].into(),
            problem: problem.ok_or_else(unknown)?.name,
            setting: cells[2].into(),
            tolerance: number(3)?,
            error: number(4)?,
            events: parse_optional(cells[5], "count").map_err(wrong)?,
            // The column after the median, the shortest round, is not kept.
            seconds: number(6)?.into_iter().collect(),
            compile: number(8)?,
            process: number(9)?,
            note: cells[10].into(),
        });
    }
    Ok(rows)
}

/// The value of a cell; `None` if it is empty.
fn parse_optional<T: FromStr>(cell: &str, what: &str) -> Result<Option<T>, String> {
    let read = (!cell.is_empty()).then(|| cell.parse());
    read.transpose()
        .map_err(|_| format!("'{cell}' is no {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_has_a_cell_for_everything() {
        let row = Measurement {
            solver: "one".into(),
            problem: "decay",
            setting: "a, b".into(),
            tolerance: Some(1e-9),
            events: Some(3),
            seconds: vec![3e-6, 1e-6, 2e-6],
            note: "failed".into(),
            ..Measurement::default()
        };
        let text = csv(&[row]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], HEADER.join(","));
        assert_eq!(
            lines[1],
            "one,decay,\"a, b\",1.000e-9,,3,2.000e-6,1.000e-6,,,failed"
        );
    }

    #[test]
    fn a_file_is_read_as_it_was_written() {
        let problems = crate::peers::problems().unwrap();
        let text = include_str!("../../report/bench.csv");
        let rows = read(text, &problems).unwrap();
        assert!(rows.len() > 100);
        let shortest = HEADER.iter().position(|name| *name == "min_s").unwrap();
        // The shortest round is not kept: that column has the median again.
        for (one, other) in csv(&rows).lines().zip(text.lines()).skip(1) {
            let apart = |line: &str| -> Vec<String> {
                let mut reader = csv::ReaderBuilder::new()
                    .has_headers(false)
                    .from_reader(line.as_bytes());
                let record = reader.records().next().unwrap().unwrap();
                record.iter().map(str::to_owned).collect()
            };
            let (mut one, mut other) = (apart(one), apart(other));
            one.remove(shortest);
            other.remove(shortest);
            assert_eq!(one, other);
        }
    }

    #[test]
    fn a_damaged_file_is_refused_with_its_line() {
        let problems = crate::peers::problems().unwrap();
        let head = HEADER.join(",");
        for (line, cause) in [
            ("one,drift,,,,,,,,,", "'drift' is none"),
            ("one,decay,,x,,,,,,,", "'x' is no number"),
            ("one,decay,,,,2.5,,,,,", "'2.5' is no count"),
            ("one,decay", "2 cells"),
        ] {
            let text = read(&format!("{head}\n{line}\n"), &problems).unwrap_err();
            assert!(text.contains("line 2") && text.contains(cause), "{text}");
        }
        let error = read("solver,problem\n", &problems).unwrap_err();
        assert!(
            error.contains("line 1") && error.contains("median_s"),
            "{error}"
        );
    }
}
