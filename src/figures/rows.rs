//! The numbers behind a figure. Each is a row, formatted as CSV, as a table, or as a golden file.

use std::fmt;

use crate::paper::claim_id::ClaimId;
use crate::paper::published::Claims;
use crate::paper::reading::Reading;
use crate::text::{self, joined};

/// One part of a statement: its words, and whether it holds.
pub type Part = (&'static str, bool);

/// The value of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A measured or computed quantity. Minus infinity is allowed (the Lyapunov exponent of an
    /// annihilated direction).
    Number(f64),
    /// A number of items.
    Count(usize),
    /// A class or kind in a word, such as `quasi-periodic`.
    Word(String),
    /// A statement, part by part.
    Statement(Vec<Part>),
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Value::Number(value)
    }
}

impl From<usize> for Value {
    fn from(count: usize) -> Self {
        Value::Count(count)
    }
}

impl From<&str> for Value {
    fn from(word: &str) -> Self {
        Value::Word(word.to_owned())
    }
}

impl fmt::Display for Value {
    /// Full precision: the shortest decimal that reads back as the same number.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(v) => write!(f, "{v:?}"),
            Value::Count(n) => write!(f, "{n}"),
            Value::Word(word) => f.write_str(word),
            Value::Statement(parts) => {
                let holding = parts.iter().filter(|(_, holds)| *holds).count();
                match holding {
                    _ if holding == parts.len() => f.write_str("holds"),
                    0 => f.write_str("fails"),
                    _ => write!(f, "{holding} of {} parts hold", parts.len()),
                }
            }
        }
    }
}

/// The subject of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// The value of a claim.
    Claim(ClaimId),
    /// A member of the numbers that a claim publishes together. It is counted from 1 in the order
    /// of computation.
    Member(ClaimId, usize),
    /// A quantity for which the paper gives no value.
    Other(String),
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Quantity::Claim(id) => id.fmt(f),
            Quantity::Member(id, k) => write!(f, "{id}.{k}"),
            Quantity::Other(name) => f.write_str(name),
        }
    }
}

impl From<ClaimId> for Quantity {
    fn from(id: ClaimId) -> Self {
        Quantity::Claim(id)
    }
}

impl<S: Into<String>> From<S> for Quantity {
    fn from(name: S) -> Self {
        Quantity::Other(name.into())
    }
}

/// The published value for a row, and whether it agrees with the computed one.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Published value, in the paper's own digits or words.
    pub published: String,
    /// A number agrees if rounding gives the published digits. A count or a word must be equal. A
    /// statement must hold in all its parts.
    pub agrees: bool,
}

/// One line of a figure's table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Subject.
    pub quantity: Quantity,
    /// Interpretation of the paper.
    pub reading: Reading,
    /// The computed value.
    pub value: Value,
    /// Unit of the value; empty for a word, `1` for a pure number.
    pub unit: &'static str,
    /// Quality of the value in a word such as `unidentified`; `None` where nothing needs to be
    /// said.
    pub status: Option<&'static str>,
}

impl Row {
    /// A number with its unit. Negative zero becomes zero.
    pub fn number(
        quantity: impl Into<Quantity>,
        reading: Reading,
        value: f64,
        unit: &'static str,
    ) -> Self {
        Self::new(quantity, reading, Value::Number(value + 0.0), unit)
    }

    /// A count.
    pub fn count(quantity: impl Into<Quantity>, reading: Reading, value: usize) -> Self {
        Self::new(quantity, reading, Value::Count(value), "1")
    }

    /// A word.
    pub fn word(quantity: impl Into<Quantity>, reading: Reading, value: &str) -> Self {
        Self::new(quantity, reading, Value::Word(value.to_owned()), "")
    }

    /// A statement of the paper, part by part.
    pub fn statement(
        claim: ClaimId,
        reading: Reading,
        parts: impl IntoIterator<Item = Part>,
    ) -> Self {
        let parts = parts.into_iter().collect();
        Self::new(claim, reading, Value::Statement(parts), "")
    }

    /// The members of a set, a row each.
    pub fn members<'a>(
        claim: ClaimId,
        reading: Reading,
        values: impl IntoIterator<Item = &'a f64>,
        unit: &'static str,
    ) -> Vec<Self> {
        (1..)
            .zip(values)
            .map(|(k, value)| Row::number(Quantity::Member(claim, k), reading, *value, unit))
            .collect()
    }

    fn new(
        quantity: impl Into<Quantity>,
        reading: Reading,
        value: Value,
        unit: &'static str,
    ) -> Self {
        Self {
            quantity: quantity.into(),
            reading,
            value,
            unit,
            status: None,
        }
    }

    /// Adds a word on the quality of the value.
    #[must_use]
    pub fn status(mut self, word: &'static str) -> Self {
        self.status = Some(word);
        self
    }

    /// Comparison with the paper; `None` where the paper gives no value.
    pub fn comparison(&self, claims: &Claims) -> Option<Comparison> {
        let (Quantity::Claim(id) | Quantity::Member(id, _)) = self.quantity else {
            return None;
        };
        let claim = claims.of(id);
        let published = claim.published.clone();
        let (published, agrees) = match (&self.quantity, &self.value) {
            (Quantity::Member(..), Value::Number(value)) => {
                let distance = |published: &f64| (value - published).abs();
                let members = claim.values().iter().copied();
                let nearest = members.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
                (format!("{nearest:?}"), claim.agrees_with(nearest, *value))
            }
            (_, Value::Number(value)) => (published, claim.agrees(*value)),
            (_, Value::Statement(parts)) => {
                ("stated".to_owned(), parts.iter().all(|(_, holds)| *holds))
            }
            (_, word) => {
                let agrees = word.to_string() == published;
                (published, agrees)
            }
        };
        Some(Comparison { published, agrees })
    }
}

const HEADER: &str = "id,reading,value,published,unit,agrees,status";

/// The rows' cells under the header. `agrees` has the words for yes, for no, and for rows without a
/// published value. The last one also stands for empty cells. A status is shown where a row has
/// one.
fn lines(
    rows: &[Row],
    claims: &Claims,
    value: impl Fn(&Value) -> String,
    [yes, no, none]: [&str; 3],
) -> Vec<Vec<String>> {
    let mut lines = vec![HEADER.split(',').map(str::to_owned).collect::<Vec<_>>()];
    lines.extend(rows.iter().map(|row| {
        let (published, agrees) = match row.comparison(claims) {
            Some(one) => (one.published, if one.agrees { yes } else { no }),
            None => (none.to_owned(), none),
        };
        vec![
            row.quantity.to_string(),
            row.reading.name().to_owned(),
            value(&row.value),
            published,
            row.unit.to_owned(),
            agrees.to_owned(),
            row.status.unwrap_or(none).to_owned(),
        ]
    }));
    if rows.iter().all(|row| row.status.is_none()) {
        lines.iter_mut().for_each(|line| line.truncate(6));
    }
    lines
}

/// Rows as CSV, numbers in full precision.
pub fn csv(rows: &[Row], claims: &Claims) -> String {
    text::csv(lines(rows, claims, Value::to_string, ["true", "false", ""]))
}

/// Rows as an aligned table for a terminal, numbers to eight digits.
pub fn table(rows: &[Row], claims: &Claims) -> String {
    let value = |value: &Value| match value {
        Value::Number(v) => rounded(*v),
        other => other.to_string(),
    };
    aligned(&lines(rows, claims, value, ["yes", "NO", "–"]))
}

/// Rows in the format of golden files: in full precision, without units.
pub fn golden(rows: &[Row], claims: &Claims) -> String {
    let mut lines = lines(rows, claims, Value::to_string, ["true", "false", "-"]);
    for line in &mut lines {
        line.remove(4);
    }
    aligned(&lines)
}

/// The first columns, two spaces apart, without trailing blanks.
fn aligned(lines: &[Vec<String>]) -> String {
    let columns = lines.first().map_or(0, Vec::len);
    let width = |k: usize| lines.iter().map(|line| line[k].chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|k| width(k).unwrap_or(0)).collect();
    let mut text = String::new();
    for line in lines {
        let cells = line.iter().zip(&widths);
        let padded = joined(cells.map(|(cell, &width)| format!("{cell:width$}")), "  ");
        text.push_str(padded.trim_end());
        text.push('\n');
    }
    text
}

/// Eight significant digits, without trailing zeros.
fn rounded(v: f64) -> String {
    const DIGITS: i32 = 8;
    if v == 0.0 {
        return "0".into();
    }
    if !v.is_finite() {
        return format!("{v:?}");
    }
    let power = stickslip::math::log10(v.abs()).floor() as i32;
    if !(-4..DIGITS).contains(&power) {
        return format!("{v:.7e}");
    }
    let decimals = (DIGITS - 1 - power).unsigned_abs() as usize;
    let text = format!("{v:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claims() -> &'static Claims {
        Claims::committed().unwrap()
    }

    fn rows() -> Vec<Row> {
        vec![
            Row::number(ClaimId::Fig08StickLength1, Reading::Exact, 1.0 / 3.0, "m"),
            Row::number("fig11.multiplier", Reading::Exact, f64::NEG_INFINITY, "1/t"),
            Row::count("fig07c.branches.below", Reading::Exact, 6),
            Row::word(
                ClaimId::Fig12Class,
                Reading::AsPrinted,
                "periodic, \"slow\"",
            ),
            Row::word(ClaimId::Fig12Class, Reading::Exact, "chaotic"),
        ]
    }

    #[test]
    fn csv_has_full_precision_and_quotes() {
        assert_eq!(
            csv(&rows(), claims()),
            "id,reading,value,published,unit,agrees\n\
             fig08.stick_length.1,exact,0.3333333333333333,0.4697,m,false\n\
             fig11.multiplier,exact,-inf,,1/t,\n\
             fig07c.branches.below,exact,6,,1,\n\
             fig12.class,as-printed,\"periodic, \"\"slow\"\"\",chaotic,,false\n\
             fig12.class,exact,chaotic,chaotic,,true\n"
        );
    }

    #[test]
    fn a_status_adds_a_column() {
        let mut rows = rows();
        rows[1] = rows[1].clone().status("annihilated");
        let text = csv(&rows, claims());
        assert!(text.starts_with("id,reading,value,published,unit,agrees,status\n"));
        assert!(text.contains("-inf,,1/t,,annihilated\n") && text.contains("0.4697,m,false,\n"));
        assert!(table(&rows, claims()).contains("annihilated"));
        assert!(golden(&rows, claims()).contains("annihilated"));
    }

    #[test]
    fn the_table_is_aligned_and_rounded() {
        let table = table(&rows(), claims());
        let lines: Vec<&str> = table.lines().collect();
        assert!(lines[1].contains("  0.33333333  ") && lines[1].ends_with("NO"));
        assert!(lines[2].contains("-inf"));
        let column = |line: &str| line.find("exact");
        assert_eq!(column(lines[1]), column(lines[2]));
    }

    #[test]
    fn goldens_keep_every_digit() {
        let golden = golden(&rows(), claims());
        assert!(golden.contains("0.3333333333333333"));
        assert_eq!(golden.lines().count(), 6);
    }

    #[test]
    fn a_member_is_held_against_the_nearest_published_one() {
        let rows = Row::members(
            ClaimId::Eq13CriticalMu0,
            Reading::Exact,
            &[1e-14, 0.38],
            "N",
        );
        let of = |row: &Row| row.comparison(claims()).unwrap();
        assert_eq!(of(&rows[0]).published, "0.0");
        assert!(of(&rows[0]).agrees && !of(&rows[1]).agrees);
        assert_eq!(rows[1].quantity.to_string(), "eq13.mu0_critical.2");
    }

    #[test]
    fn a_statement_holds_with_all_its_parts() {
        let of = |parts: &[bool]| {
            let parts = parts.iter().map(|&holds| ("something", holds));
            let row = Row::statement(ClaimId::S4Arcs, Reading::Exact, parts);
            (
                row.value.to_string(),
                row.comparison(claims()).unwrap().agrees,
            )
        };
        assert_eq!(of(&[true, true]), ("holds".into(), true));
        assert_eq!(of(&[true, false]), ("1 of 2 parts hold".into(), false));
        assert_eq!(of(&[false]), ("fails".into(), false));
    }

    #[test]
    fn rounding_for_the_eye() {
        assert_eq!(rounded(0.0), "0");
        assert_eq!(rounded(2.0), "2");
        assert_eq!(rounded(-0.384_900_179_459_750_5), "-0.38490018");
        assert_eq!(rounded(1234.5), "1234.5");
        assert_eq!(rounded(1.5e-7), "1.5000000e-7");
        assert_eq!(rounded(12_345_678.0), "12345678");
    }
}
