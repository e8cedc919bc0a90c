//! Records: columns against time, of which cells may be empty.

use std::fs::File;
use std::io::{BufRead, BufReader};

use stickslip_model::text_table::{TableError, TextTable};

/// Names of a column of times.
const TIMES: [&str; 2] = ["t", "time"];

/// Columns of a file against its time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredRecord {
    /// Times, as they stand there.
    pub times: Vec<f64>,
    /// The wanted columns; NaN for an empty cell or a cell `nan`.
    pub columns: Vec<Vec<f64>>,
    /// Notes on automatic choices.
    pub notes: Vec<String>,
}

/// Reads the columns with these names from a text file, or from standard input for `-`, and the
/// column `time`: by default that called `t` or `time`, else the first. A column is found by its
/// name, or by its number from 1.
///
/// # Errors
/// [`TableError`] for a file that cannot be read, a column that does not exist, a cell that is no
/// number.
pub fn read_record(
    path: &str,
    wanted: &[&str],
    time: Option<&str>,
) -> Result<MeasuredRecord, TableError> {
    if path == "-" {
        return parse_record("standard input", std::io::stdin().lock(), wanted, time);
    }
    let file = File::open(path).map_err(|source| TableError::read(path, source))?;
    parse_record(path, BufReader::new(file), wanted, time)
}

/// [`read_record`] from the content of a file.
///
/// # Errors
/// As [`read_record`].
pub fn parse_record(
    input: &str,
    source: impl BufRead,
    wanted: &[&str],
    time: Option<&str>,
) -> Result<MeasuredRecord, TableError> {
    let mut text = TextTable::new(input, source)?;
    let names = text.names.take().unwrap_or_default();
    let names: Vec<&str> = names.iter().map(|name| name.trim()).collect();
    let count = text.columns;
    let find = |name: &str| -> Result<usize, TableError> {
        let known = names.iter().take(count).position(|known| *known == name);
        let number = || {
            let number = name.parse::<usize>().ok()?.checked_sub(1)?;
            (number < count).then_some(number)
        };
        known.or_else(number).ok_or_else(|| {
            let known = match names.is_empty() {
                true => format!("{count} columns without names, which are called 1 to {count}"),
                false => format!("the columns {}", names.join(", ")),
            };
            TableError::Request(format!(
                "there is no column `{name}` in {input}, which has {known}; write the observable \
                 as {name}=FORMULA with the name of a column in front, or mend the name"
            ))
        })
    };
    let time = match time {
        Some(time) => find(time)?,
        None => {
            let is_time = |name: &&str| TIMES.contains(&name.to_lowercase().as_str());
            names.iter().position(is_time).unwrap_or(0)
        }
    };
    let columns = wanted.iter().map(|name| find(name));
    let columns = columns.collect::<Result<Vec<usize>, TableError>>()?;
    let mut record = MeasuredRecord {
        columns: vec![Vec::new(); columns.len()],
        ..MeasuredRecord::default()
    };
    while let Some((line, cells)) = text.row()? {
        if cells.len() != count {
            return Err(TableError::File(format!(
                "{input}, line {line}: the line has {} columns, separated by {}, the first has \
                 {count}; complete it or take it out",
                cells.len(),
                text.dialect.separated_by()
            )));
        }
        let number = |column: usize, may_be_missing: bool| {
            let cell = cells.get(column).unwrap_or_default();
            match text.dialect.number(cell) {
                Some(value) if value.is_finite() => Ok(value),
                Some(value) if value.is_nan() && may_be_missing => Ok(f64::NAN),
                None if cell.is_empty() && may_be_missing => Ok(f64::NAN),
                _ => Err(TableError::File(format!(
                    "{input}, line {line}, column {}: '{cell}' is no finite number{}",
                    column + 1,
                    match may_be_missing {
                        true => "; leave the cell empty where nothing was measured",
                        false => "; each row needs its time",
                    }
                ))),
            }
        };
        record.times.push(number(time, false)?);
        for (values, &column) in record.columns.iter_mut().zip(&columns) {
            values.push(number(column, true)?);
        }
    }
    if record.times.is_empty() {
        return Err(TableError::empty(input));
    }
    record.notes.append(&mut text.notes);
    Ok(record)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_and_cells_may_be_empty() {
        let text = "x, time ,force\n1,0,5\n,0.5,6\nnan,1,7\n";
        let found = parse_record("f", text.as_bytes(), &["force", "x"], None).unwrap();
        assert_eq!(found.times, [0.0, 0.5, 1.0]);
        assert_eq!(found.columns[0], [5.0, 6.0, 7.0]);
        assert_eq!(found.columns[1][0], 1.0);
        assert!(found.columns[1][1].is_nan() && found.columns[1][2].is_nan());
        let without = parse_record("f", "0;1,5\n1;2,5\n".as_bytes(), &["2"], None).unwrap();
        assert_eq!(without.columns, [[1.5, 2.5]]);
        let words = |text: &str, wanted: &str| {
            let error = parse_record("f", text.as_bytes(), &[wanted], None);
            error.unwrap_err().to_string()
        };
        assert!(words(text, "y").contains("there is no column `y` in f, which has the columns x"));
        assert!(words("t,x\n0,1\n,2\n", "x").contains("each row needs its time"));
        assert!(words("t,x\n0,1\n1,2O\n", "x").contains("line 3, column 2: '2O'"));
    }
}
