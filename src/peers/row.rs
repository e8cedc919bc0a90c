//! What was measured of one solver at one setting on one problem.

use super::error::PeersError;

/// A row of report/bench.csv.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Solver.
    pub solver: String,
    /// Problem.
    pub problem: &'static str,
    /// Setting, in words.
    pub setting: String,
    /// Tolerance, or step where that is fixed.
    pub tolerance: Option<f64>,
    /// Largest error of an event time; none if the events are not those of the reference.
    pub error: Option<f64>,
    /// Events found.
    pub events: Option<usize>,
    /// Time of a run in each round (s), compiled and warm.
    pub seconds: Vec<f64>,
    /// Time to compile (s), not part of `seconds`.
    pub compile: Option<f64>,
    /// Time of a whole process that starts, compiles and runs once (s).
    pub process: Option<f64>,
    /// Why there is no error or no time.
    pub note: String,
}

impl Row {
    /// Middle of the rounds (s).
    pub fn median(&self) -> Option<f64> {
        median(&self.seconds)
    }

    /// Shortest of the rounds (s).
    pub fn shortest(&self) -> Option<f64> {
        self.seconds.iter().copied().min_by(f64::total_cmp)
    }
}

/// The middle value; of an even number of values the upper of the two.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// The file's head.
const HEAD: [&str; 11] = [
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
///
/// # Errors
/// [`PeersError::Csv`].
pub fn csv(rows: &[Row]) -> Result<String, PeersError> {
    let short = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.3e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEAD)?;
    for row in rows {
        writer.write_record([
            row.solver.clone(),
            row.problem.into(),
            row.setting.clone(),
            short(row.tolerance),
            short(row.error),
            row.events
                .map_or(String::new(), |events| events.to_string()),
            short(row.median()),
            short(row.shortest()),
            short(row.compile),
            short(row.process),
            row.note.clone(),
        ])?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_has_a_cell_for_everything() {
        let row = Row {
            solver: "one".into(),
            problem: "decay",
            setting: "a, b".into(),
            tolerance: Some(1e-9),
            error: None,
            events: Some(3),
            seconds: vec![3e-6, 1e-6, 2e-6],
            compile: None,
            process: None,
            note: "failed".into(),
        };
        let text = csv(&[row]).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], HEAD.join(","));
        assert_eq!(
            lines[1],
            "one,decay,\"a, b\",1.000e-9,,3,2.000e-6,1.000e-6,,,failed"
        );
    }
}
