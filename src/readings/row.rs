//! A configuration and what came of it, as a line of the table.

use super::score::Twelve;
use super::verdict::Verdict;
use stickslip::analysis::data_spectrum::Status;

/// A line of `readings.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Part, reading, integrator, settings: what is told apart.
    pub key: [String; 4],
    /// Class of each figure's orbit.
    pub classes: [Verdict; 3],
    /// Exponents, descending; NaN where there is none.
    pub exponents: Twelve,
    /// What the estimator says of each.
    pub statuses: [[String; 4]; 3],
    /// Distance from the published exponents: of each figure, and of all.
    pub scores: [f64; 4],
}

/// Why a figure has no exponents: its orbit has no series.
pub const NO_SERIES: &str = "no series";
/// Why an exponent is not there: the estimator gives none.
pub const NO_ESTIMATE: &str = "no estimate";
const FIELDS: usize = 4 + 3 * 9 + 5;

fn known(status: &str) -> bool {
    Status::ALL.map(Status::word).contains(&status) || [NO_SERIES, NO_ESTIMATE].contains(&status)
}

impl Row {
    /// The table's second line.
    pub fn header() -> String {
        let mut text = String::from("part,reading,integrator,settings");
        for figure in 10..=12 {
            text += &format!(",fig{figure}.class");
            for k in 1..=4 {
                text += &format!(",fig{figure}.lambda.{k},fig{figure}.status.{k}");
            }
        }
        text + ",classes_right,fig10.distance,fig11.distance,fig12.distance,distance\n"
    }

    /// How many motions are of the published kind ([`Verdict::is_of_kind`]); the table's column for it is named `classes_right`.
    pub fn kinds_right(&self) -> usize {
        let right = |&f: &usize| self.classes[f].is_of_kind(f);
        (0..3).filter(right).count()
    }

    /// What the recommended row has least of: kinds of motion wrong, then distance of all exponents.
    pub fn kinds_first(&self) -> (usize, f64) {
        (3 - self.kinds_right(), self.scores[3])
    }

    /// The line. Numbers read back to the same bits.
    pub fn line(&self) -> String {
        let mut text = self.key.join(",");
        for figure in 0..3 {
            text += &format!(",{}", self.classes[figure]);
            for k in 0..4 {
                let value = self.exponents[figure][k];
                if value.is_nan() {
                    text += ",";
                } else {
                    text += &format!(",{value}");
                }
                text += &format!(",{}", self.statuses[figure][k]);
            }
        }
        text += &format!(",{}", self.kinds_right());
        for score in self.scores {
            text += &format!(",{score}");
        }
        text + "\n"
    }

    /// Reads a line; `None` if it is damaged.
    pub fn parse(line: &str) -> Option<Row> {
        let fields: Vec<&str> = line.split(',').collect();
        if fields.len() != FIELDS {
            return None;
        }
        let mut rest = fields.iter().copied();
        let mut next = || rest.next();
        let mut row = Row {
            key: Default::default(),
            classes: [Verdict::Failed; 3],
            exponents: [[f64::NAN; 4]; 3],
            statuses: Default::default(),
            scores: [f64::NAN; 4],
        };
        for part in &mut row.key {
            *part = next()?.to_owned();
        }
        for figure in 0..3 {
            row.classes[figure] = next()?.parse().ok()?;
            for k in 0..4 {
                let value = next()?;
                if !value.is_empty() {
                    row.exponents[figure][k] = value.parse().ok()?;
                }
                let status = next()?;
                row.statuses[figure][k] = known(status).then(|| status.to_owned())?;
            }
        }
        if next()? != row.kinds_right().to_string() {
            return None;
        }
        for score in &mut row.scores {
            *score = next()?.parse().ok()?;
        }
        Some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_with_any_status_reads_back() {
        for status in Status::ALL
            .map(Status::word)
            .into_iter()
            .chain([NO_SERIES, NO_ESTIMATE])
        {
            let row = Row {
                key: ["search", "r", "i", "s"].map(str::to_owned),
                classes: [Verdict::Failed; 3],
                exponents: [[0.25, -1e-17, f64::NEG_INFINITY, -0.1]; 3],
                statuses: [[(); 4]; 3].map(|four| four.map(|()| status.to_owned())),
                scores: [3.0; 4],
            };
            let line = row.line();
            let back = Row::parse(line.trim_end());
            assert_eq!(back.map(|row| row.line()), Some(line), "{status}");
        }
    }
}
