//! Rows of a table: choice of columns, and errors.

use csv::StringRecord;
use stickslip::error::readable;
use stickslip_model::text_table::Dialect;
use stickslip_series::MAX_COLUMNS;

use super::{MOST_VALUES, NumberTable, TableError, time};

/// Names of a column that holds the time.
const TIME: [&str; 2] = ["t", "time"];
/// Maximum number of names that a message lists, and of characters of a cell that it shows.
const MOST_LISTED_NAMES: usize = 20;
const MOST_SHOWN_CHARACTERS: usize = 40;
/// Number of values that are in rising order by chance with probability 1/10!, one in 3.6 million.
const RISING_ROWS: usize = 10;

/// Columns to read, and the rows so far.
pub(super) struct Rows<'a> {
    input: &'a str,
    /// Number of columns in the file.
    count: usize,
    names: Option<Vec<String>>,
    pub(super) columns: Vec<usize>,
    time: Option<usize>,
    /// Whether no columns were chosen.
    are_all: bool,
    pub(super) values: Vec<f64>,
    /// Times of the rows, with their lines.
    times: Vec<(u64, f64)>,
}

impl<'a> Rows<'a> {
    pub(super) fn new(
        input: &'a str,
        count: usize,
        names: Option<Vec<String>>,
        wanted: &[String],
    ) -> Result<Self, TableError> {
        // Names with a unit also count: "t (s)", "time [ms]".
        let plain = |name: &String| {
            let word = name.split(['(', '[', '/']).next().unwrap_or(name);
            word.trim().to_lowercase()
        };
        let is_time = |name: &String| TIME.contains(&plain(name).as_str());
        // Without such a column, one that ends in the word does: "Elapsed time (s)".
        let is_some_time = |name: &String| {
            let name = plain(name);
            name.rsplit([' ', '_', '-']).next() == Some("time")
        };
        let named = || names.iter().flatten();
        let time = named()
            .position(is_time)
            .or_else(|| named().position(is_some_time));
        let mut rows = Self {
            input,
            count,
            names,
            columns: Vec::new(),
            time,
            are_all: wanted.is_empty(),
            values: Vec::new(),
            times: Vec::new(),
        };
        if rows.are_all {
            rows.columns = (0..count).filter(|&c| Some(c) != time).collect();
        }
        for name in wanted {
            let column = rows.find(name.trim())?;
            if rows.columns.contains(&column) {
                return Err(TableError::Request(format!(
                    "--columns: {name} is given twice; give every column once"
                )));
            }
            rows.columns.push(column);
        }
        rows.time = time.filter(|time| !rows.columns.contains(time));
        Ok(rows)
    }

    /// Names come first: a column may be called 2.
    fn find(&self, wanted: &str) -> Result<usize, TableError> {
        let names = self.names.iter().flatten().enumerate();
        let called: Vec<usize> = names
            .filter(|(_, name)| *name == wanted)
            .map(|(column, _)| column)
            .collect();
        let input = self.input;
        let refusal = match (&called[..], wanted.parse::<usize>()) {
            ([column], _) => return Ok(*column),
            ([], Ok(number)) if (1..=self.count).contains(&number) => return Ok(number - 1),
            ([], _) => {
                let names = match &self.names {
                    Some(names) if names.len() <= MOST_LISTED_NAMES => {
                        format!(" ({})", names.join(", "))
                    }
                    Some(names) => format!(" ({}, …)", names[..MOST_LISTED_NAMES].join(", ")),
                    None => " and no names".to_owned(),
                };
                format!(
                    "'{wanted}' is no column of {input}; it has 1 to {}{names}",
                    self.count
                )
            }
            _ => {
                let numbers: Vec<String> = called.iter().map(|c| (c + 1).to_string()).collect();
                let numbers = numbers.join(" and ");
                format!(
                    "'{wanted}' is ambiguous, columns {numbers} of {input} are called so; give the \
                        number instead"
                )
            }
        };
        Err(TableError::Request(format!("--columns: {refusal}")))
    }

    /// The column's name, or its number counted from 1.
    fn name(&self, column: usize) -> String {
        match self.names.as_ref().and_then(|names| names.get(column)) {
            Some(name) if !name.is_empty() => name.clone(),
            _ => (column + 1).to_string(),
        }
    }

    /// The error for a cell.
    fn cell(&self, line: u64, column: usize, cause: &str) -> TableError {
        let name = self.names.as_ref().and_then(|names| names.get(column));
        let name = name.map_or(String::new(), |name| format!(" ({name})"));
        let (input, column) = (self.input, column + 1);
        TableError::File(format!(
            "{input}, line {line}, column {column}{name}: {cause}"
        ))
    }

    pub(super) fn push(
        &mut self,
        line: u64,
        cells: &StringRecord,
        dialect: &Dialect,
    ) -> Result<(), TableError> {
        if cells.len() != self.count {
            let cause = format!(
                "the line has {} columns, separated by {}, the first has {}; complete it or take \
                    it out",
                cells.len(),
                dialect.separated_by(),
                self.count
            );
            return Err(self.cell(line, cells.len().min(self.count), &cause));
        }
        if self.values.len() + self.columns.len() > MOST_VALUES {
            return Err(TableError::File(format!(
                "{}, line {line}: more than {MOST_VALUES} numbers: choose fewer columns with \
                    --columns, or thin the series",
                self.input
            )));
        }
        for i in 0..self.columns.len() {
            let value = self.number(line, cells, self.columns[i], dialect)?;
            self.values.push(value);
        }
        if let Some(column) = self.time {
            let time = self.number(line, cells, column, dialect)?;
            self.times.push((line, time));
        }
        Ok(())
    }

    fn number(
        &self,
        line: u64,
        cells: &StringRecord,
        column: usize,
        dialect: &Dialect,
    ) -> Result<f64, TableError> {
        const GAP: &str = "a series must have no gaps: cut the file there or fill the gap";
        let text = &cells[column];
        let has_comma = || {
            text.split_once(',')
                .is_some_and(|(_, rest)| !rest.is_empty())
        };
        let cause = match dialect.number(text) {
            Some(value) if value.is_finite() => return Ok(value),
            Some(_) => format!("'{text}' is not finite; {GAP}"),
            None if text.is_empty() => format!("the cell is empty; {GAP}"),
            None if has_comma() => format!(
                "'{text}' may have a decimal comma, but other cells have decimal points; write \
                    points throughout"
            ),
            None => {
                let mut shown: String = text.chars().take(MOST_SHOWN_CHARACTERS).collect();
                if shown.len() < text.len() {
                    shown.push('…');
                }
                format!(
                    "'{shown}' is not a number; choose other columns with --columns or correct the \
                        file"
                )
            }
        };
        Err(self.cell(line, column, &cause))
    }

    /// Checks that all time steps are `dt`. The error describes the first that differs.
    fn holds(&self, dt: f64) -> Result<(), TableError> {
        let times = self.times.iter().map(|row| row.1);
        let gap = time::first_gap(times.clone(), dt);
        let Some(gap) = gap.filter(|_| !time::is_even(times, dt)) else {
            return Ok(());
        };
        let [(_, from), (line, to)] = [self.times[gap - 1], self.times[gap]];
        let (is_forward, from, to) = (to > from, readable(from), readable(to));
        let cause = if is_forward {
            format!(
                "the time goes from {from} to {to}, not on by dt = {}; cut the file at the gap, \
                 correct --dt if it was given, or give --columns and --dt if this is not the time",
                readable(dt)
            )
        } else {
            format!(
                "the time goes from {from} to {to}, not forward; reverse the order of the rows or \
                 cut the file there, or give --columns and --dt if this is not the time"
            )
        };
        Err(self.cell(line, self.time.unwrap_or(0), &cause))
    }

    /// The common time step.
    fn step(&self) -> Result<f64, TableError> {
        let times = || self.times.iter().map(|row| row.1);
        let Some((middle, mean)) = time::middle_step(times()).zip(time::mean_step(times())) else {
            // A single row is too few for an estimate, whatever the step.
            return Ok(1.0);
        };
        // If times fall or repeat, the first such time is reported.
        self.holds(middle.abs().max(f64::MIN_POSITIVE))?;
        Ok(mean)
    }

    /// The table, with its time step and without constant columns.
    pub(super) fn finish(mut self, dt: Option<f64>) -> Result<NumberTable, TableError> {
        let input = self.input;
        if self.values.is_empty() && self.times.is_empty() {
            return Err(TableError::empty(input));
        }
        let columns = self.columns.len();
        if columns == 0 {
            let column = self.name(self.time.unwrap_or(0));
            return Err(TableError::File(format!(
                "the only column of {input}, {column}, was skipped as the time: give a file with \
                 the columns of the state too, or --columns {column} if this is the state"
            )));
        }
        if self.values.len() == columns && columns > MAX_COLUMNS {
            return Err(TableError::File(format!(
                "{input} has one row of {columns} numbers, and a row is a state: write each state \
                 in a line of its own, of a single column each number"
            )));
        }
        let mut table = NumberTable {
            input: input.to_owned(),
            names: self.columns.iter().map(|&c| self.name(c)).collect(),
            values: std::mem::take(&mut self.values),
            ..NumberTable::default()
        };
        table.dt = match (self.time, dt) {
            (Some(_), Some(dt)) => {
                match self.holds(dt) {
                    Err(error) if self.are_all => return Err(error),
                    // Both were chosen.
                    Err(error) => table.notes.push(format!("--dt is used, although {error}")),
                    Ok(()) => {}
                }
                dt
            }
            (Some(column), None) => {
                table.time = Some(self.name(column));
                self.step()?
            }
            (None, given) => {
                let may_be = self.names.is_none() && self.are_all && columns > 1;
                let step = if may_be {
                    time_in_first_column(&mut table, given)?
                } else {
                    None
                };
                given.or(step).ok_or_else(|| {
                    TableError::Request(format!(
                        "--dt is missing, and {input} has no column named t or time beside those \
                         used: give the time between two lines, 1 for a map"
                    ))
                })?
            }
        };
        table.leave_out_constants();
        Ok(table)
    }
}

/// Returns the step of a first column that is the time. Without names and a choice, that is an
/// evenly spaced column, unless another step is given. One that rises unevenly is an error: it
/// cannot be a state of a recurrent system.
fn time_in_first_column(
    table: &mut NumberTable,
    given: Option<f64>,
) -> Result<Option<f64>, TableError> {
    let all = table.names.join(",");
    let first = || table.column(0);
    let refused = |step: f64, but: &str| {
        Err(TableError::File(format!(
            "{}: column {} goes on by {} from row to row, as a time does, {but}, or --columns \
                {all} if it is part of the state",
            table.input,
            table.names[0],
            readable(step)
        )))
    };
    let is_rising = first().zip(first().skip(1)).all(|(one, next)| one < next);
    let is_time = is_rising && table.rows() >= RISING_ROWS;
    let Some(step) = time::even_step(first()).filter(|step| *step > 0.0) else {
        let step = time::middle_step(first()).filter(|_| is_time);
        let gap = step.and_then(|step| Some((step, time::first_gap(first(), step)?)));
        let Some((step, row)) = gap else {
            return Ok(None);
        };
        let mut values = first().skip(row - 1).map(readable);
        let [from, to] = [values.next(), values.next()].map(Option::unwrap_or_default);
        let but = format!(
            "but from {from} to {to} at row {}: cut the file there, as a series must have no gaps",
            row + 1
        );
        return refused(step, &but);
    };
    if let Some(dt) = given.filter(|&dt| !time::agree(step, dt)) {
        if !is_time {
            return Ok(None);
        }
        let [dt, right] = [dt, step].map(readable);
        return refused(step, &format!("while --dt is {dt}: give --dt {right}"));
    }
    table.notes.push(format!(
        "column {} goes on evenly by {} and is taken as the time; --columns {all} uses it as a \
            coordinate",
        table.names[0],
        readable(step)
    ));
    table.leave_out(0);
    Ok(Some(step))
}
