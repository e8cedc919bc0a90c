//! The numbers behind a figure: one row each, as CSV, as a table to read, as a golden.

use std::fmt::{self, Write};

use super::error::FigureError;

/// What a row states.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A measured or computed quantity; minus infinity is allowed (a Lyapunov exponent of an annihilated
    /// direction).
    Number(f64),
    /// How many of something.
    Count(u64),
    /// A statement in a word, such as `holds` or `quasi-periodic`.
    Word(String),
}

impl fmt::Display for Value {
    /// Full precision: the shortest decimal that reads back as the same number.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(v) => write!(f, "{v:?}"),
            Value::Count(n) => write!(f, "{n}"),
            Value::Word(word) => f.write_str(word),
        }
    }
}

/// One line of a figure's table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the quantity, such as `eq23.mu0_critical.2`.
    pub id: String,
    /// How the paper was understood: `as-printed`, `exact`, …
    pub reading: String,
    /// What was found.
    pub value: Value,
    /// What the paper says, in its own digits or words.
    pub published: Option<String>,
    /// Unit of the value; empty for a word, `1` for a pure number.
    pub unit: String,
    /// Whether the value, rounded to the published digits, is the published one; nothing where the paper
    /// says nothing.
    pub agrees: Option<bool>,
    /// What the value is worth, in a word such as `unidentified`; nothing where that goes without saying.
    pub status: Option<String>,
}

impl Row {
    /// A number with its unit. Negative zero becomes zero.
    pub fn number(id: &str, reading: &str, value: f64, unit: &str) -> Self {
        Self::new(id, reading, Value::Number(value + 0.0), unit)
    }

    /// A number of things.
    pub fn count(id: &str, reading: &str, value: u64) -> Self {
        Self::new(id, reading, Value::Count(value), "1")
    }

    /// A word.
    pub fn word(id: &str, reading: &str, value: &str) -> Self {
        Self::new(id, reading, Value::Word(value.to_owned()), "")
    }

    fn new(id: &str, reading: &str, value: Value, unit: &str) -> Self {
        Self {
            id: id.to_owned(),
            reading: reading.to_owned(),
            value,
            published: None,
            unit: unit.to_owned(),
            agrees: None,
            status: None,
        }
    }

    /// With a word on what the value is worth.
    #[must_use]
    pub fn status(mut self, word: &str) -> Self {
        self.status = Some(word.to_owned());
        self
    }

    /// What the paper says, and whether the value agrees with it.
    pub fn published(mut self, published: &str, agrees: bool) -> Self {
        self.published = Some(published.to_owned());
        self.agrees = Some(agrees);
        self
    }

    fn agreement(&self) -> &'static str {
        match self.agrees {
            Some(true) => "true",
            Some(false) => "false",
            None => "",
        }
    }
}

/// Whether any row has a status: only then is there a column for it.
fn have_status(rows: &[Row]) -> bool {
    rows.iter().any(|row| row.status.is_some())
}

/// The rows as CSV with the columns `id,reading,value,published,unit,agrees` and, if any row has one, `status`.
///
/// # Errors
/// [`FigureError::Csv`] if the writer refuses a field.
pub fn csv(rows: &[Row]) -> Result<String, FigureError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let columns = if have_status(rows) { 7 } else { 6 };
    let header = [
        "id",
        "reading",
        "value",
        "published",
        "unit",
        "agrees",
        "status",
    ];
    writer.write_record(&header[..columns])?;
    for row in rows {
        let value = row.value.to_string();
        let fields = [
            row.id.as_str(),
            row.reading.as_str(),
            value.as_str(),
            row.published.as_deref().unwrap_or(""),
            row.unit.as_str(),
            row.agreement(),
            row.status.as_deref().unwrap_or(""),
        ];
        writer.write_record(&fields[..columns])?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| csv::Error::from(error.into_error()))?;
    // Every field was a `str`, so nothing can be lost here.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The rows in aligned columns for the terminal, numbers rounded to eight digits.
pub fn table(rows: &[Row]) -> String {
    let header = [
        "id",
        "reading",
        "value",
        "published",
        "unit",
        "agrees",
        "status",
    ]
    .map(str::to_owned);
    let lines = rows.iter().map(|row| {
        [
            row.id.clone(),
            row.reading.clone(),
            match &row.value {
                Value::Number(v) => rounded(*v),
                other => other.to_string(),
            },
            row.published.clone().unwrap_or_else(|| "–".into()),
            row.unit.clone(),
            match row.agrees {
                Some(true) => "yes",
                Some(false) => "NO",
                None => "–",
            }
            .to_owned(),
            row.status.clone().unwrap_or_else(|| "–".into()),
        ]
    });
    let columns = if have_status(rows) { 7 } else { 6 };
    aligned(std::iter::once(header).chain(lines).collect(), columns)
}

/// The rows as a golden: one line each, full precision, without the unit.
pub fn golden(rows: &[Row]) -> String {
    let header = ["id", "reading", "value", "published", "agrees", "status"].map(str::to_owned);
    let lines = rows.iter().map(|row| {
        [
            row.id.clone(),
            row.reading.clone(),
            row.value.to_string(),
            row.published.clone().unwrap_or_else(|| "-".into()),
            match row.agreement() {
                "" => "-",
                said => said,
            }
            .to_owned(),
            row.status.clone().unwrap_or_else(|| "-".into()),
        ]
    });
    let columns = if have_status(rows) { 6 } else { 5 };
    aligned(std::iter::once(header).chain(lines).collect(), columns)
}

/// The first so many columns, two spaces apart, without blanks at the end of a line.
fn aligned<const N: usize>(lines: Vec<[String; N]>, columns: usize) -> String {
    let mut widths = [0; N];
    for line in &lines {
        for (cell, width) in line.iter().zip(&mut widths) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let mut text = String::new();
    for line in &lines {
        let mut padded = String::new();
        for (cell, width) in line.iter().zip(widths).take(columns) {
            // Writing to a string cannot fail.
            let _ = write!(padded, "{cell:width$}  ");
        }
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
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        vec![
            Row::number("fig08.stick_length.1", "exact", 1.0 / 3.0, "m").published("0.4697", false),
            Row::number("fig11.lambda.4", "exact", f64::NEG_INFINITY, "1/t"),
            Row::count("fig07c.branches.below", "exact", 6),
            Row::word("fig12.class", "as-printed", "periodic, \"slow\"").published("chaotic", true),
        ]
    }

    #[test]
    fn csv_has_full_precision_and_quotes() {
        assert_eq!(
            csv(&rows()).unwrap(),
            "id,reading,value,published,unit,agrees\n\
             fig08.stick_length.1,exact,0.3333333333333333,0.4697,m,false\n\
             fig11.lambda.4,exact,-inf,,1/t,\n\
             fig07c.branches.below,exact,6,,1,\n\
             fig12.class,as-printed,\"periodic, \"\"slow\"\"\",chaotic,,true\n"
        );
    }

    #[test]
    fn a_status_adds_a_column() {
        let mut rows = rows();
        rows[1] = rows[1].clone().status("annihilated");
        let text = csv(&rows).unwrap();
        assert!(text.starts_with("id,reading,value,published,unit,agrees,status\n"));
        assert!(text.contains("-inf,,1/t,,annihilated\n") && text.contains("0.4697,m,false,\n"));
        assert!(table(&rows).contains("annihilated") && golden(&rows).contains("annihilated"));
    }

    #[test]
    fn the_table_is_aligned_and_rounded() {
        let table = table(&rows());
        let lines: Vec<&str> = table.lines().collect();
        assert!(lines[1].contains("  0.33333333  ") && lines[1].ends_with("NO"));
        assert!(lines[2].contains("-inf"));
        let column = |line: &str| line.find("exact");
        assert_eq!(column(lines[1]), column(lines[2]));
    }

    #[test]
    fn goldens_keep_every_digit() {
        let golden = golden(&rows());
        assert!(golden.contains("0.3333333333333333"));
        assert_eq!(golden.lines().count(), 5);
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
