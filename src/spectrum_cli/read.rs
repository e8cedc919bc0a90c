//! A table of numbers from a CSV file.

use std::io::Read;
use std::path::Path;

use csv::StringRecord;

use super::error::SpectrumError;
use stickslip::error::readable;

/// Rows may be further apart in time than `dt` by this part of it.
const UNEVEN: f64 = 0.01;
/// Names of a column that holds the time.
const TIME: [&str; 2] = ["t", "time"];

/// The columns chosen from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Where it comes from, for messages.
    pub input: String,
    /// Names, or numbers counted from 1.
    pub names: Vec<String>,
    /// Values, row after row.
    pub values: Vec<f64>,
}

impl Table {
    /// Columns whose values rise or fall evenly from row to row, as a time or an index does and no recurrent state, with their step.
    pub fn even_columns(&self) -> impl Iterator<Item = (usize, f64)> {
        (0..self.names.len()).filter_map(|column| Some((column, self.even_step(column)?)))
    }

    fn even_step(&self, column: usize) -> Option<f64> {
        let rows = self.values.chunks_exact(self.names.len());
        let values: Vec<f64> = rows.map(|row| row[column]).collect();
        let (first, last) = (values.first()?, values.last()?);
        // Two rows are even whatever they hold.
        let steps = values.len().checked_sub(1).filter(|&steps| steps > 1)?;
        let mean = (last - first) / steps as f64;
        let even = |pair: &[f64]| (pair[1] - pair[0] - mean).abs() <= UNEVEN * mean.abs();
        (mean != 0.0 && values.windows(2).all(even)).then_some(mean)
    }
}

/// Reads the columns `wanted` (numbers counted from 1, or names; none for all but a time column) of `path`, `-` for standard
/// input. Columns are separated by commas, semicolons or tabs; lines that start with `#` are skipped; the first
/// line may hold names. A column named `t` or `time` is no coordinate but, if not asked for, is held against `dt`.
///
/// # Errors
/// Everything that is not a complete table of finite numbers, with line and column.
pub fn read(path: &Path, wanted: &[String], dt: f64) -> Result<Table, SpectrumError> {
    let stdin = path == Path::new("-");
    let input = if stdin {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    };
    let mut bytes = Vec::new();
    let outcome = if stdin {
        std::io::stdin().lock().read_to_end(&mut bytes)
    } else {
        std::fs::File::open(path).and_then(|mut file| file.read_to_end(&mut bytes))
    };
    outcome.map_err(|source| SpectrumError::Read {
        input: input.clone(),
        source,
    })?;
    parse(input, &bytes, wanted, dt)
}

/// As [`read`], from the content of a file.
///
/// # Errors
/// As [`read`].
pub fn parse(
    input: String,
    bytes: &[u8],
    wanted: &[String],
    dt: f64,
) -> Result<Table, SpectrumError> {
    // Spreadsheets put a mark before the first character.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .delimiter(delimiter(bytes))
        .from_reader(bytes);
    let mut record = StringRecord::new();
    if !advance(&mut reader, bytes, &mut record, &input)? {
        return Err(SpectrumError::Empty { input });
    }
    // A header is a first line in which nothing is a number.
    let header = record
        .iter()
        .all(|cell| cell.parse::<f64>().is_err())
        .then(|| record.clone());
    let layout = Layout::new(&input, bytes, record.len(), header.as_ref(), wanted)?;
    if layout.columns.is_empty() {
        let column = layout.name(layout.time.unwrap_or(0));
        return Err(SpectrumError::OnlyTime { input, column });
    }
    let mut values = Vec::new();
    let mut last_time = None;
    let mut more = header.is_none() || advance(&mut reader, bytes, &mut record, &input)?;
    while more {
        layout.width(&record)?;
        for &column in &layout.columns {
            values.push(layout.number(&record, column)?);
        }
        if let Some(column) = layout.time {
            let time = layout.number(&record, column)?;
            layout.even(&record, column, last_time.replace(time), time, dt)?;
        }
        more = advance(&mut reader, bytes, &mut record, &input)?;
    }
    if values.is_empty() {
        return Err(SpectrumError::Empty { input });
    }
    let names = layout.columns.iter().map(|&c| layout.name(c)).collect();
    Ok(Table {
        input,
        names,
        values,
    })
}

/// The next record, or false at the end.
fn advance(
    reader: &mut csv::Reader<&[u8]>,
    bytes: &[u8],
    record: &mut StringRecord,
    input: &str,
) -> Result<bool, SpectrumError> {
    reader.read_record(record).map_err(|error| {
        let cause = match error.kind() {
            csv::ErrorKind::Utf8 { .. } => {
                "the text is not UTF-8; save the file as UTF-8 or plain ASCII".to_owned()
            }
            _ => error.to_string(),
        };
        SpectrumError::Csv {
            input: input.to_owned(),
            line: error.position().map(|at| line_of(bytes, at.byte())),
            cause,
        }
    })
}

/// Whether there are several parts and all are numbers.
fn numbers<'t>(parts: impl Iterator<Item = &'t str>) -> bool {
    let parts: Vec<bool> = parts.map(|part| part.parse::<f64>().is_ok()).collect();
    parts.len() > 1 && parts.iter().all(|&is_number| is_number)
}

/// The separator that the first line with content uses.
fn delimiter(bytes: &[u8]) -> u8 {
    let line = bytes
        .split(|&b| b == b'\n')
        .find(|line| !line.trim_ascii().is_empty() && !line.starts_with(b"#"))
        .unwrap_or_default();
    [b';', b'\t']
        .into_iter()
        .find(|separator| line.contains(separator))
        .unwrap_or(b',')
}

/// The line, counted from 1, of the record that the reader met when it went on from `byte`. It goes over empty lines and
/// comments on the way, which its own count leaves out.
fn line_of(bytes: &[u8], byte: u64) -> u64 {
    let start = usize::try_from(byte).unwrap_or(usize::MAX).min(bytes.len());
    let (before, after) = bytes.split_at(start);
    let skipped = after
        .split_inclusive(|&b| b == b'\n')
        .take_while(|line| line.starts_with(b"#") || line.iter().all(|b| b"\r\n".contains(b)))
        .count();
    let ends = before.iter().filter(|&&b| b == b'\n').count();
    (1 + ends + skipped) as u64
}

/// Which columns are read.
struct Layout<'a> {
    input: &'a str,
    bytes: &'a [u8],
    count: usize,
    names: Option<Vec<String>>,
    columns: Vec<usize>,
    time: Option<usize>,
}

impl<'a> Layout<'a> {
    fn new(
        input: &'a str,
        bytes: &'a [u8],
        count: usize,
        header: Option<&StringRecord>,
        wanted: &[String],
    ) -> Result<Self, SpectrumError> {
        let names: Option<Vec<String>> =
            header.map(|record| record.iter().map(str::to_owned).collect());
        let is_time = |name: &String| TIME.contains(&name.to_lowercase().as_str());
        let time = names
            .as_ref()
            .and_then(|names| names.iter().position(is_time));
        let mut layout = Self {
            input,
            bytes,
            count,
            names,
            columns: Vec::new(),
            time,
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
            Some(names) => format!("1 to {} ({})", self.count, names.join(", ")),
            None => format!("1 to {} and no names", self.count),
        }
    }

    fn name(&self, column: usize) -> String {
        match self.names.as_ref().and_then(|names| names.get(column)) {
            Some(name) if !name.is_empty() => name.clone(),
            _ => (column + 1).to_string(),
        }
    }

    fn cell(&self, record: &StringRecord, column: usize, cause: String) -> SpectrumError {
        let name = self.names.as_ref().and_then(|names| names.get(column));
        SpectrumError::Cell {
            input: self.input.to_owned(),
            line: line_of(self.bytes, record.position().map_or(0, csv::Position::byte)),
            column: match name {
                Some(name) => format!("{} ({name})", column + 1),
                None => (column + 1).to_string(),
            },
            cause,
        }
    }

    fn width(&self, record: &StringRecord) -> Result<(), SpectrumError> {
        if record.len() == self.count {
            return Ok(());
        }
        let cause = format!(
            "the line has {} columns, the first has {}; complete it or take it out",
            record.len(),
            self.count
        );
        let first_wrong = record.len().min(self.count);
        Err(self.cell(record, first_wrong, cause))
    }

    fn number(&self, record: &StringRecord, column: usize) -> Result<f64, SpectrumError> {
        const GAP: &str = "a series must have no gaps: cut the file there or fill the gap";
        let text = record.get(column).unwrap_or("");
        let cause = match text.parse::<f64>() {
            Ok(value) if value.is_finite() => return Ok(value),
            Ok(_) => format!("'{text}' is not finite; {GAP}"),
            Err(_) if text.is_empty() => format!("the cell is empty; {GAP}"),
            Err(_) if numbers(text.split_whitespace()) => format!(
                "'{text}' are several numbers; separate the columns by commas, semicolons or tabs"
            ),
            Err(_) if numbers(text.splitn(2, ',')) => {
                format!("'{text}' has a decimal comma; write decimal points")
            }
            Err(_) => format!(
                "'{text}' is not a number; choose other columns with --columns or correct the file"
            ),
        };
        Err(self.cell(record, column, cause))
    }

    fn even(
        &self,
        record: &StringRecord,
        column: usize,
        last: Option<f64>,
        time: f64,
        dt: f64,
    ) -> Result<(), SpectrumError> {
        let Some(last) = last else {
            return Ok(());
        };
        if (time - last - dt).abs() <= UNEVEN * dt {
            return Ok(());
        }
        let cause = format!(
            "the time goes from {last} to {time}, not on by dt = {}; correct --dt, cut the file at the gap, or choose columns \
             with --columns if this is not the time",
            readable(dt)
        );
        Err(self.cell(record, column, cause))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str, wanted: &[&str]) -> Result<Table, String> {
        let wanted: Vec<String> = wanted.iter().map(|&w| w.to_owned()).collect();
        parse("f".into(), text.as_bytes(), &wanted, 0.5).map_err(|error| error.to_string())
    }

    #[test]
    fn with_and_without_names_and_with_other_separators() {
        let plain = table("1,2\n3,4e0\n", &[]).unwrap();
        assert_eq!(
            (plain.names, plain.values),
            (vec!["1".into(), "2".into()], vec![1.0, 2.0, 3.0, 4.0])
        );
        for text in [
            "x,y\n1,2\n3,4\n",
            "\u{feff}# made by hand\r\nx;y\r\n1 ; 2\r\n\r\n3;4",
            "x\ty\n1\t2\n3\t4\n",
        ] {
            let named = table(text, &[]).unwrap();
            assert_eq!(named.names, ["x", "y"]);
            assert_eq!(named.values, [1.0, 2.0, 3.0, 4.0]);
        }
    }

    #[test]
    fn columns_are_chosen_by_number_or_name() {
        let text = "a,b,c\n1,2,3\n";
        assert_eq!(table(text, &["3", "a"]).unwrap().values, [3.0, 1.0]);
        assert_eq!(table(text, &["b"]).unwrap().names, ["b"]);
        assert!(
            table(text, &["d"])
                .unwrap_err()
                .contains("1 to 3 (a, b, c)")
        );
        assert!(table(text, &["a", "1"]).unwrap_err().contains("twice"));
        assert_eq!(table(text, &[" c", "a "]).unwrap().values, [3.0, 1.0]);
        let twins = "a,b,a\n1,2,3\n";
        let ambiguous = table(twins, &["b", "a"]).unwrap_err();
        assert!(
            ambiguous.contains("'a'") && ambiguous.contains("1 and 3"),
            "{ambiguous}"
        );
        assert_eq!(table(twins, &["3", "b"]).unwrap().values, [3.0, 2.0]);
        // A column that is not read may hold anything.
        assert_eq!(
            table("n,x\none,1\ntwo,2\n", &["x"]).unwrap().values,
            [1.0, 2.0]
        );
    }

    #[test]
    fn a_time_column_is_checked_and_not_a_coordinate() {
        assert_eq!(table("t,x\n0,7\n0.5,8\n", &[]).unwrap().values, [7.0, 8.0]);
        let gap = table("Time,x\n0,7\n0.5,8\n1.5,9\n", &[]).unwrap_err();
        assert!(gap.starts_with("f, line 4, column 1 (Time): "), "{gap}");
        assert_eq!(table("t,x\n0,7\n9,8\n", &["t"]).unwrap().values, [0.0, 9.0]);
        let only = table("t\n0\n0.5\n", &[]).unwrap_err();
        assert!(only.contains("skipped as the time"), "{only}");
    }

    #[test]
    fn columns_that_count_are_found() {
        let even =
            |text| -> Vec<(usize, f64)> { table(text, &[]).unwrap().even_columns().collect() };
        // A time that is rounded is one all the same.
        assert_eq!(even("0,1,9\n1,4,6\n2,9,3\n"), [(0, 1.0), (2, -3.0)]);
        assert_eq!(even("x\n0.333\n0.667\n1.000\n").len(), 1);
        assert_eq!(even("0,1\n1,1\n2.1,1\n"), []);
        assert_eq!(even("0,1\n1,2\n"), []);
    }

    #[test]
    fn bad_cells_are_named_by_line_and_column() {
        let bad = [
            (
                "x,y\n1,2\n3,oops\n",
                "f, line 3, column 2 (y): 'oops' is not a number",
            ),
            (
                "#\n1,2\n\n# gap\r\n3,\n",
                "f, line 5, column 2: the cell is empty",
            ),
            ("1,2\n3,nan\n", "f, line 2, column 2: 'nan' is not finite"),
            ("1,2\n3\n", "f, line 2, column 2: the line has 1 columns"),
            (
                "1,2\n3,4,5\n",
                "f, line 2, column 3: the line has 3 columns",
            ),
            ("", "f holds no data"),
            ("x,y\n", "f holds no data"),
            (
                "1,oops\n3,4\n",
                "f, line 1, column 2: 'oops' is not a number",
            ),
        ];
        for (text, expected) in bad {
            let error = table(text, &[]).unwrap_err();
            assert!(error.starts_with(expected), "{text:?}: {error}");
        }
        let not_text = parse("f".into(), b"1,2\n3,\xff\n", &[], 1.0)
            .unwrap_err()
            .to_string();
        assert!(not_text.starts_with("f, line 2: "), "{not_text}");
    }
}
