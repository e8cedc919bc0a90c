//! The table of the search: one row for each configuration, with the classes and exponents of the
//! three figures.

use std::fmt;
use std::str::FromStr;

use crate::motion::{Class, UnknownClass};
use crate::text::joined;
use stickslip_series::Status;

/// The twelve exponents of Figs. 10–12, each figure's in descending order.
pub type Twelve = [[f64; 4]; 3];

/// The captioned classes of Figs. 10–12.
const PUBLISHED: [Class; 3] = [Class::Periodic(2), Class::QuasiPeriodic, Class::Chaotic];

/// The outcome of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OrbitVerdict {
    /// Stays bounded; the class of its motion.
    Motion(Class),
    /// Diverges.
    Escaped,
    /// Cannot be integrated.
    Failed,
}

impl OrbitVerdict {
    /// Whether it is the class that the caption of figure 10, 11 or 12 (0, 1, 2) names, including
    /// the number of loops.
    pub fn is_published(self, figure: usize) -> bool {
        self == OrbitVerdict::Motion(PUBLISHED[figure])
    }

    /// Whether it is of that kind: for Fig. 10's "two-periodic", periodic with any number of loops.
    /// The search ranks by kind.
    pub fn is_of_kind(self, figure: usize) -> bool {
        match (self, PUBLISHED[figure]) {
            (OrbitVerdict::Motion(Class::Periodic(_)), Class::Periodic(_)) => true,
            _ => self.is_published(figure),
        }
    }

    /// Whether the orbit stays bounded.
    pub fn is_bounded(self) -> bool {
        matches!(self, OrbitVerdict::Motion(_))
    }
}

impl fmt::Display for OrbitVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            OrbitVerdict::Motion(class) => class.fmt(f),
            OrbitVerdict::Escaped => f.write_str("escaped"),
            OrbitVerdict::Failed => f.write_str("failed"),
        }
    }
}

impl FromStr for OrbitVerdict {
    type Err = UnknownClass;

    fn from_str(text: &str) -> Result<Self, UnknownClass> {
        match text {
            "escaped" => Ok(OrbitVerdict::Escaped),
            "failed" => Ok(OrbitVerdict::Failed),
            _ => text.parse().map(OrbitVerdict::Motion),
        }
    }
}

/// A line of `readings.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigurationRow {
    /// Part, reading, integrator, settings: the key of the row.
    pub key: [String; 4],
    /// Class of each figure's orbit.
    pub classes: [OrbitVerdict; 3],
    /// Half the extent of each figure's x₁, and the correlation dimension of its section; NaN where
    /// undefined.
    pub sizes: [[f64; 2]; 3],
    /// Exponents, descending; NaN where missing.
    pub exponents: Twelve,
    /// Status of each exponent.
    pub statuses: [[&'static str; 4]; 3],
    /// Distance from the published exponents, for each figure and for all.
    pub scores: [f64; 4],
}

/// Reason for a figure without exponents: its orbit has no series.
pub const NO_SERIES: &str = "no series";
/// Reason for a figure without exponents: its reading loses another figure, and its motion is not
/// of the published kind.
pub const READING_LOST: &str = "reading lost";
/// Reason for a missing exponent: the estimator gives none.
pub const NO_ESTIMATE: &str = "no estimate";
/// Key, three figures of class, two sizes and four exponents with their status, and six scores.
const FIELDS: usize = 4 + 3 * 11 + 6;

/// The motions of the other two figures in words; `figure` is 0, 1 or 2.
pub fn other_motions(motions: &[String; 3], figure: usize) -> String {
    let others = (0..3).filter(|f| *f != figure);
    let others = others.map(|f| format!("Fig. {} {}", f + 10, motions[f]));
    joined(others, ", ")
}

/// Empty for NaN. Other numbers read back to the same bits.
fn text(value: f64) -> String {
    match value.is_nan() {
        true => String::new(),
        false => value.to_string(),
    }
}

fn number(text: &str) -> Option<f64> {
    match text {
        "" => Some(f64::NAN),
        _ => text.parse().ok(),
    }
}

/// A status by its name.
fn parse_status(status: &str) -> Option<&'static str> {
    let all = Status::ALL.iter().map(|one| one.word());
    all.chain([NO_SERIES, READING_LOST, NO_ESTIMATE])
        .find(|one| *one == status)
}

impl ConfigurationRow {
    /// A row without results.
    pub fn empty(key: [String; 4]) -> ConfigurationRow {
        ConfigurationRow {
            key,
            classes: [OrbitVerdict::Failed; 3],
            sizes: [[f64::NAN; 2]; 3],
            exponents: [[f64::NAN; 4]; 3],
            statuses: Default::default(),
            scores: [f64::NAN; 4],
        }
    }

    /// The table's header.
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

    /// Reading.
    pub fn reading(&self) -> &str {
        &self.key[1]
    }

    /// Integrator.
    pub fn integrator(&self) -> &str {
        &self.key[2]
    }

    /// Three motions in words.
    pub fn motions(&self) -> [String; 3] {
        self.classes.map(|class| class.to_string())
    }

    /// Whether it can match the figures: all three motions are of the published kind.
    pub fn is_ranked(&self) -> bool {
        self.right(OrbitVerdict::is_of_kind) == 3
    }

    /// Whether all three motions stay bounded.
    pub fn all_bounded(&self) -> bool {
        self.classes.iter().all(|class| class.is_bounded())
    }

    /// Number of motions of the published class ([`OrbitVerdict::is_published`]) or kind
    /// ([`OrbitVerdict::is_of_kind`]).
    pub fn right(&self, is: fn(OrbitVerdict, usize) -> bool) -> usize {
        (0..3).filter(|&f| is(self.classes[f], f)).count()
    }

    /// The key that the recommended row minimizes: wrong kinds of motion, then the distance of all
    /// exponents.
    pub fn kinds_first(&self) -> (usize, f64) {
        (3 - self.right(OrbitVerdict::is_of_kind), self.scores[3])
    }

    /// The line. Numbers read back to the same bits.
    pub fn line(&self) -> String {
        let mut fields = self.key.to_vec();
        for figure in 0..3 {
            fields.push(self.classes[figure].to_string());
            fields.extend(self.sizes[figure].map(text));
            for k in 0..4 {
                fields.push(text(self.exponents[figure][k]));
                fields.push(self.statuses[figure][k].to_owned());
            }
        }
        fields.extend(self.rights());
        fields.extend(self.scores.map(|score| score.to_string()));
        fields.join(",") + "\n"
    }

    /// Numbers of right classes and kinds, as in the table.
    fn rights(&self) -> [String; 2] {
        [OrbitVerdict::is_published, OrbitVerdict::is_of_kind].map(|is| self.right(is).to_string())
    }

    /// Parses a line; `None` if it is damaged.
    pub fn parse(line: &str) -> Option<ConfigurationRow> {
        let fields: Vec<&str> = line.split(',').collect();
        if fields.len() != FIELDS {
            return None;
        }
        let mut remaining = fields.iter().copied();
        let mut next = || remaining.next();
        let mut row = ConfigurationRow::empty(Default::default());
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
                row.statuses[figure][k] = parse_status(next()?)?;
            }
        }
        for right in row.rights() {
            if next()? != right {
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
    use crate::paper::claim_id::SpectrumFigure;
    use crate::paper::published::Claims;

    #[test]
    fn the_classes_are_those_of_the_table_of_claims() {
        let claims = Claims::committed().unwrap();
        for (class, figure) in PUBLISHED.iter().zip(SpectrumFigure::ALL) {
            assert_eq!(class.to_string(), claims.of(figure.class()).published);
        }
    }

    #[test]
    fn loops_count_for_the_class_and_not_for_the_kind() {
        let one_loop: OrbitVerdict = "periodic".parse().unwrap();
        assert!(one_loop.is_of_kind(0) && !one_loop.is_published(0));
        assert!(!one_loop.is_of_kind(1) && one_loop.is_bounded());
        assert!(!OrbitVerdict::Escaped.is_bounded());
    }

    #[test]
    fn a_line_with_any_status_reads_back() {
        for status in
            Status::ALL
                .map(Status::word)
                .into_iter()
                .chain([NO_SERIES, READING_LOST, NO_ESTIMATE])
        {
            let row = ConfigurationRow {
                sizes: [[1.5, f64::NAN]; 3],
                exponents: [[0.25, -1e-17, f64::NEG_INFINITY, -0.1]; 3],
                statuses: [[(); 4]; 3].map(|four| four.map(|()| status)),
                scores: [3.0; 4],
                ..ConfigurationRow::empty(["search", "r", "i", "s"].map(str::to_owned))
            };
            let line = row.line();
            let back = ConfigurationRow::parse(line.trim_end());
            assert_eq!(back.map(|row| row.line()), Some(line), "{status}");
        }
    }
}
