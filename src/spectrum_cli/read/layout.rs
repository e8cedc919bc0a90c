//! Which columns of a table are read, and what is wrong with a cell.

use std::borrow::Cow;

use stickslip::error::readable;

use super::dialect::Dialect;
use super::time::Gap;
use crate::spectrum_cli::error::SpectrumError;

/// Names of a column that holds the time.
const TIME: [&str; 2] = ["t", "time"];
/// Most names that a message lists.
const LISTED: usize = 20;

/// A line with its cells.
pub(super) struct Row<'a> {
    pub line: u64,
    pub cells: &'a [Cow<'a, str>],
    pub dialect: &'a Dialect,
}

/// Which columns are read.
pub(super) struct Layout<'a> {
    pub input: &'a str,
    count: usize,
    names: Option<Vec<String>>,
    pub columns: Vec<usize>,
    pub time: Option<usize>,
    /// Whether no choice was made.
    pub are_all: bool,
}

impl<'a> Layout<'a> {
    pub(super) fn new(
        input: &'a str,
        count: usize,
        header: Option<Vec<Cow<'_, str>>>,
        wanted: &[String],
    ) -> Result<Self, SpectrumError> {
        let names =
            header.map(|header| header.into_iter().map(Cow::into_owned).collect::<Vec<_>>());
        let time = names
            .as_ref()
            .and_then(|names| names.iter().position(|name| is_time(name)));
        let mut layout = Self {
            input,
            count,
            names,
            columns: Vec::new(),
            time,
            are_all: wanted.is_empty(),
        };
        if wanted.is_empty() {
            layout.columns = (0..count).filter(|&c| Some(c) != time).collect();
        }
        for name in wanted {
            let column = layout.find(name.trim())?;
            if layout.columns.contains(&column) {
                return Err(SpectrumError::Twice {
                    wanted: name.clone(),
                });
            }
            layout.columns.push(column);
        }
        if layout
            .time
            .is_some_and(|time| layout.columns.contains(&time))
        {
            layout.time = None;
        }
        Ok(layout)
    }

    pub(super) fn has_names(&self) -> bool {
        self.names.is_some()
    }

    /// Names come first: a column may be called 2.
    fn find(&self, wanted: &str) -> Result<usize, SpectrumError> {
        let names = self.names.iter().flatten().enumerate();
        let called: Vec<usize> = names
            .filter(|(_, name)| *name == wanted)
            .map(|(column, _)| column)
            .collect();
        match called[..] {
            [column] => return Ok(column),
            [] => {}
            _ => {
                let numbers: Vec<String> = called.iter().map(|c| (c + 1).to_string()).collect();
                return Err(SpectrumError::Ambiguous {
                    input: self.input.to_owned(),
                    wanted: wanted.to_owned(),
                    numbers: numbers.join(" and "),
                });
            }
        }
        match wanted.parse::<usize>() {
            Ok(number) if (1..=self.count).contains(&number) => Ok(number - 1),
            _ => Err(SpectrumError::Column {
                input: self.input.to_owned(),
                wanted: wanted.to_owned(),
                available: self.available(),
            }),
        }
    }

    fn available(&self) -> String {
        match &self.names {
            Some(names) if names.len() <= LISTED => {
                format!("1 to {} ({})", self.count, names.join(", "))
            }
            Some(names) => format!("1 to {} ({}, …)", self.count, names[..LISTED].join(", ")),
            None => format!("1 to {} and no names", self.count),
        }
    }

    pub(super) fn name(&self, column: usize) -> String {
        match self.names.as_ref().and_then(|names| names.get(column)) {
            Some(name) if !name.is_empty() => name.clone(),
            _ => (column + 1).to_string(),
        }
    }

    fn cell(&self, line: u64, column: usize, cause: String) -> SpectrumError {
        let name = self.names.as_ref().and_then(|names| names.get(column));
        SpectrumError::Cell {
            input: self.input.to_owned(),
            line,
            column: match name {
                Some(name) => format!("{} ({name})", column + 1),
                None => (column + 1).to_string(),
            },
            cause,
        }
    }

    pub(super) fn width(&self, row: &Row) -> Result<(), SpectrumError> {
        let width = row.cells.len();
        if width == self.count {
            return Ok(());
        }
        let cause = format!(
            "the line has {width} columns, separated by {}, the first has {}; complete it or take it out",
            row.dialect.separated_by(),
            self.count
        );
        Err(self.cell(row.line, width.min(self.count), cause))
    }

    pub(super) fn number(&self, row: &Row, column: usize) -> Result<f64, SpectrumError> {
        const GAP: &str = "a series must have no gaps: cut the file there or fill the gap";
        let text = row.cells.get(column).map_or("", |cell| cell);
        let cause = match row.dialect.number(text) {
            Some(value) if value.is_finite() => return Ok(value),
            Some(_) => format!("'{text}' is not finite; {GAP}"),
            None if text.is_empty() => format!("the cell is empty; {GAP}"),
            None if text
                .split_once(',')
                .is_some_and(|(_, rest)| !rest.is_empty()) =>
            {
                format!(
                    "'{text}' may have a decimal comma, but other cells have decimal points; write points throughout"
                )
            }
            None => format!(
                "'{}' is not a number; choose other columns with --columns or correct the file",
                shortened(text)
            ),
        };
        Err(self.cell(row.line, column, cause))
    }

    pub(super) fn gap(&self, gap: Gap) -> SpectrumError {
        let Gap { line, from, to, dt } = gap;
        let cause = if to > from {
            format!(
                "the time goes from {from} to {to}, not on by dt = {}; cut the file at the gap, correct --dt if it was given, or give \
                 --columns and --dt if this is not the time",
                readable(dt)
            )
        } else {
            format!(
                "the time goes from {from} to {to}, not forward; reverse the order of the rows or cut the file there, or give --columns \
                 and --dt if this is not the time"
            )
        };
        self.cell(line, self.time.unwrap_or(0), cause)
    }

    pub(super) fn too_long(&self, line: u64, most: usize) -> SpectrumError {
        SpectrumError::Text {
            input: self.input.to_owned(),
            line,
            cause: format!(
                "more than {most} numbers: choose fewer columns with --columns, or thin the series"
            ),
        }
    }
}

fn is_time(name: &str) -> bool {
    // With a unit, too: "t (s)", "time [ms]".
    let word = name.split(['(', '[', '/']).next().unwrap_or(name).trim();
    TIME.contains(&word.to_lowercase().as_str())
}

/// So much of a cell as a message can hold.
fn shortened(text: &str) -> Cow<'_, str> {
    const MOST: usize = 40;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
        None => Cow::Borrowed(text),
    }
}
