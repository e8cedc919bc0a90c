//! A configuration and what came of it, as a line of the table.

use super::score::Twelve;
use super::verdict::Verdict;
use stickslip_series::Status;

/// A line of `readings.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Part, reading, integrator, settings: what is told apart.
    pub key: [String; 4],
    /// Class of each figure's orbit.
    pub classes: [Verdict; 3],
    /// Half the extent of each figure's x₁, and the correlation dimension of its section; NaN where
    /// there is none.
    pub sizes: [[f64; 2]; 3],
    /// Exponents, descending; NaN where there is none.
    pub exponents: Twelve,
    /// What the estimator says of each.
    pub statuses: [[String; 4]; 3],
    /// Distance from the published exponents: of each figure, and of all.
    pub scores: [f64; 4],
}

/// Why a figure has no exponents: its orbit has no series.
pub const NO_SERIES: &str = "no series";
/// Why a figure has no exponents: its reading loses another figure, and its motion is not of the
/// published kind.
pub const LOST: &str = "reading lost";
/// Why an exponent is not there: the estimator gives none.
pub const NO_ESTIMATE: &str = "no estimate";
const FIELDS: usize = 4 + 3 * 11 + 6;

/// Nothing for NaN; other numbers read back to the same bits.
fn text(value: f64) -> String {
    if value.is_nan() {
        String::new()
    } else {
        value.to_string()
    }
}

fn number(text: &str) -> Option<f64> {
    if text.is_empty() {
        Some(f64::NAN)
    } else {
        text.parse().ok()
    }
}

fn known(status: &str) -> bool {
    Status::ALL.map(Status::word).contains(&status)
        || [NO_SERIES, LOST, NO_ESTIMATE].contains(&status)
}

impl Row {
    /// A row without results.
    pub fn empty(key: [String; 4]) -> Row {
        Row {
            key,
            classes: [Verdict::Failed; 3],
            sizes: [[f64::NAN; 2]; 3],
            exponents: [[f64::NAN; 4]; 3],
            statuses: Default::default(),
            scores: [f64::NAN; 4],
        }
    }

    /// The table's second line.
    pub fn header() -> String {
        let mut text = String::from("part,reading,integrator,settings");
        for figure in 10..=12 {
            text += &format!(",fig{figure}.class,fig{figure}.amplitude,fig{figure}.dimension");
            for k in 1..=4 {
                text += &format!(",fig{figure}.lambda.{k},fig{figure}.status.{k}");
            }
        }
        text + ",classes_right,kinds_right,fig10.distance,fig11.distance,fig12.distance,distance\n"
    }

    /// Whether it can match the figures: all three motions are of the published kind.
    pub fn is_ranked(&self) -> bool {
        self.kinds_right() == 3
    }

    /// Whether all three motions stay.
    pub fn keeps_all(&self) -> bool {
        self.classes.iter().all(|class| class.stays())
    }

    /// How many motions are of the published class, loops and all.
    pub fn classes_right(&self) -> usize {
        (0..3).filter(|&f| self.classes[f].is_published(f)).count()
    }

    /// How many motions are of the published kind ([`Verdict::is_of_kind`]).
    pub fn kinds_right(&self) -> usize {
        (0..3).filter(|&f| self.classes[f].is_of_kind(f)).count()
    }

    /// What the recommended row has least of: kinds of motion wrong, then distance of all exponents.
    pub fn kinds_first(&self) -> (usize, f64) {
        (3 - self.kinds_right(), self.scores[3])
    }

    /// The line. Numbers read back to the same bits.
    pub fn line(&self) -> String {
        let mut line = self.key.join(",");
        for figure in 0..3 {
            line += &format!(",{}", self.classes[figure]);
            for size in self.sizes[figure] {
                line += &format!(",{}", text(size));
            }
            for k in 0..4 {
                let value = text(self.exponents[figure][k]);
                line += &format!(",{value},{}", self.statuses[figure][k]);
            }
        }
        line += &format!(",{},{}", self.classes_right(), self.kinds_right());
        for score in self.scores {
            line += &format!(",{score}");
        }
        line + "\n"
    }

    /// Reads a line; `None` if it is damaged.
    pub fn parse(line: &str) -> Option<Row> {
        let fields: Vec<&str> = line.split(',').collect();
        if fields.len() != FIELDS {
            return None;
        }
        let mut rest = fields.iter().copied();
        let mut next = || rest.next();
        let mut row = Row::empty(Default::default());
        for part in &mut row.key {
            *part = next()?.to_owned();
        }
        for figure in 0..3 {
            row.classes[figure] = next()?.parse().ok()?;
            for size in &mut row.sizes[figure] {
                *size = number(next()?)?;
            }
            for k in 0..4 {
                row.exponents[figure][k] = number(next()?)?;
                let status = next()?;
                row.statuses[figure][k] = known(status).then(|| status.to_owned())?;
            }
        }
        for right in [row.classes_right(), row.kinds_right()] {
            if next()? != right.to_string() {
                return None;
            }
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
        for status in
            Status::ALL
                .map(Status::word)
                .into_iter()
                .chain([NO_SERIES, LOST, NO_ESTIMATE])
        {
            let row = Row {
                sizes: [[1.5, f64::NAN]; 3],
                exponents: [[0.25, -1e-17, f64::NEG_INFINITY, -0.1]; 3],
                statuses: [[(); 4]; 3].map(|four| four.map(|()| status.to_owned())),
                scores: [3.0; 4],
                ..Row::empty(["search", "r", "i", "s"].map(str::to_owned))
            };
            let line = row.line();
            let back = Row::parse(line.trim_end());
            assert_eq!(back.map(|row| row.line()), Some(line), "{status}");
        }
    }
}
