//! Reads discrete states, jumps, and inputs that depend on time alone.

use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::names::{Meaning, Names, did_you_mean};
use super::problem::{Problem, Source};
use super::table::{Entry, Table, listed};
use super::{FileError, InputEntry, InputShape, JumpEntry, StateEntry, SystemFile};
use crate::kernel::{InputPiece, pulse};
use crate::text_table::{TableError, TextTable};

/// The periodic shapes and their pieces over one period.
const SHAPES: [&str; 5] = ["square", "triangle", "sawtooth", "pulse", "table"];

/// The columns of a table.
const POINT: [&str; 2] = ["time", "value"];

/// The points of a table in a file: times and values, as a file of a system reads them.
///
/// # Errors
/// [`FileError::Wrong`] for a file that cannot be read, or that has no rows of two numbers.
pub fn table_points(path: &str) -> Result<(Vec<f64>, Vec<f64>), FileError> {
    let from = (PathBuf::from(path), "in the working folder");
    let source = Source {
        name: "table".to_owned(),
        text: path.to_owned(),
    };
    rows(from, POINT, false, 0..path.len()).map_err(|problem| FileError::wrong(problem, source))
}

impl SystemFile {
    /// The file with other points in the table of an input. Messages call the points by `of`.
    ///
    /// # Errors
    /// [`FileError::Wrong`] for a name that is no table, a point that is not finite, and what a
    /// table of a file is refused for.
    pub fn with_table(
        &self,
        name: &str,
        (times, values): (&[f64], &[f64]),
        of: &str,
    ) -> Result<SystemFile, FileError> {
        let place = 0..name.len();
        let wrong = |problem| {
            let source = Source {
                name: of.to_owned(),
                text: name.to_owned(),
            };
            FileError::wrong(problem, source)
        };
        let mut file = self.clone();
        let number = match file.names.get(name) {
            Some(Meaning::Input(number)) => Some(number),
            _ => None,
        };
        let entry = number.and_then(|number| file.inputs.get_mut(number));
        let Some(InputEntry { shape, .. }) = entry else {
            let problem = Problem::new(format!("there is no input `{name}`"), place);
            return Err(wrong(
                problem.help("it is one of [inputs], with shape = \"table\""),
            ));
        };
        let InputShape::Table { is_linear, .. } = *shape else {
            let problem = Problem::new(format!("the input `{name}` is no table"), place);
            return Err(wrong(problem.help("give it shape = \"table\" in [inputs]")));
        };
        if let Some(point) = times.iter().chain(values).find(|point| !point.is_finite()) {
            let problem = Problem::new(format!("a point of the table has {point}"), place);
            return Err(wrong(problem.help("times and values are finite")));
        }
        *shape = interpolated(times, values, is_linear, place).map_err(wrong)?;
        Ok(file)
    }
}

/// Discrete states, which change only in jumps.
pub(super) fn discrete(
    file: &Table<'_>,
    names: &mut Names,
    states: usize,
) -> Result<Vec<StateEntry>, Problem> {
    file.each("discrete", |number, name, place, entry| {
        Ok(StateEntry {
            name: names.add(name, place, Meaning::State(states + number))?,
            unit: String::new(),
            meaning: None,
            start: Some(entry.formula()?),
            range: None,
            atol: None,
            is_discrete: true,
        })
    })
}

/// The jumps.
pub(super) fn jumps(
    file: &Table<'_>,
    names: &mut Names,
    states: &[StateEntry],
) -> Result<Vec<JumpEntry>, Problem> {
    file.each("jumps", |number, name, place, entry| {
        let name = names.add(name, place, Meaning::Jump(number))?;
        jump(entry.table("jumps", &name)?, name, (states, names))
    })
}

fn jump(
    table: Table<'_>,
    name: String,
    (states, names): (&[StateEntry], &Names),
) -> Result<JumpEntry, Problem> {
    table.only(&["when", "direction", "if", "set", "stop", "count"])?;
    let when = "an expression whose zero it is, as in when = \"x - gap\"";
    let most = match (table.get("stop"), table.get("count")) {
        (Some(_), Some(count)) => {
            return Err(
                Problem::new("`stop` and `count` say the same", count.place())
                    .help("stop = true is count = 1; write one of them"),
            );
        }
        (Some(stop), None) => stop.flag()?.then_some(1),
        (None, Some(count)) => Some(count.count()?),
        (None, None) => None,
    };
    let mut set = vec![None; states.len()];
    if let Some(entry) = table.get("set") {
        let entries = entry.table(&format!("jumps.{name}"), "set")?;
        let rows = super::read::by_state(&entries, states, names)?;
        for (set, row) in set.iter_mut().zip(rows) {
            *set = row.map(Entry::formula).transpose()?;
        }
    }
    if most.is_none() && set.iter().all(Option::is_none) {
        let message = format!("the jump `{name}` sets no state");
        return Err(Problem::new(message, table.place.clone())
            .help("write set = { v = \"-r*v\" }, or stop = true to end the run there"));
    }
    Ok(JumpEntry {
        when: table.need("when", when)?.formula()?,
        direction: super::read::direction(table.get("direction"))?,
        condition: table.get("if").map(Entry::condition).transpose()?,
        set,
        most,
        of_stop: None,
        place: table.place.clone(),
        name,
    })
}

/// The inputs: periodic shapes, tables and switches.
pub(super) fn inputs(
    source: &Source,
    file: &Table<'_>,
    names: &mut Names,
) -> Result<Vec<InputEntry>, Problem> {
    let mut inputs = file.each("inputs", |number, name, place, entry| {
        let name = names.add(name, place.clone(), Meaning::Input(number))?;
        let shape = input(source, &entry.table("inputs", &name)?)?;
        Ok(InputEntry { name, shape, place })
    })?;
    let first = inputs.len();
    inputs.extend(file.each("switches", |number, name, place, entry| {
        let name = names.add(name, place.clone(), Meaning::Input(first + number))?;
        let table = entry.table("switches", &name)?;
        table.only(&["function"])?;
        let function = "an expression of time whose sign it is, as in function = \"sin(w*t)\"";
        let shape = InputShape::Switch(table.need("function", function)?.formula()?);
        Ok(InputEntry { name, shape, place })
    })?);
    Ok(inputs)
}

fn input(source: &Source, table: &Table<'_>) -> Result<InputShape, Problem> {
    let wanted = "what it is over a period: square, triangle, sawtooth or pulse; or table";
    let entry = table.need("shape", wanted)?;
    let shape = entry.text()?;
    let piece = |from: f64, value: f64, slope: f64| InputPiece { from, value, slope };
    let mut width = None;
    let pieces = match shape {
        "square" => vec![piece(0.0, 1.0, 0.0), piece(0.5, -1.0, 0.0)],
        "triangle" => vec![
            piece(0.0, 0.0, 4.0),
            piece(0.25, 1.0, -4.0),
            piece(0.75, -1.0, 4.0),
        ],
        "sawtooth" => vec![piece(0.0, 0.0, 1.0)],
        "pulse" => {
            table.only(&["shape", "period", "phase", "width"])?;
            let wanted = table.need("width", "the part of the period in which it is 1")?;
            width = Some(Box::new(wanted.formula()?));
            pulse(0.5).to_vec()
        }
        "table" => return points(source, table),
        other => {
            let help = did_you_mean(other, SHAPES)
                .unwrap_or_else(|| format!("it can be {}", listed(&SHAPES)));
            let message = format!("there is no shape `{other}`");
            return Err(Problem::new(message, entry.place()).help(help));
        }
    };
    if shape != "pulse" {
        table.only(&["shape", "period", "phase"])?;
    }
    let period = table.need("period", "an expression, as in period = \"2*pi/w\"")?;
    Ok(InputShape::Periodic {
        shape: shape.to_owned(),
        pieces,
        width,
        period: period.formula()?,
        phase: table
            .get("phase")
            .map(Entry::formula)
            .transpose()?
            .map(Box::new),
    })
}

/// An input that interpolates points.
fn points(source: &Source, table: &Table<'_>) -> Result<InputShape, Problem> {
    table.only(&["shape", "times", "values", "file", "between"])?;
    let place = table.place.clone();
    let (times, values, place) = match (table.get("file"), table.get("times"), table.get("values"))
    {
        (Some(file), None, None) => {
            let (times, values) = from_file(source, file, POINT, false)?;
            (times, values, file.place())
        }
        (None, Some(times), Some(values)) => (times.list()?, values.list()?, times.place()),
        _ => {
            return Err(
                Problem::new("a table has times and values, or a file", place).help(
                    "times = [0, 1], values = [0, 5]; or file = \"force.csv\" beside this file",
                ),
            );
        }
    };
    let between = table.get("between");
    let is_linear = match between
        .map(|entry| Ok((entry.text()?, entry)))
        .transpose()?
    {
        None | Some(("linear", _)) => true,
        Some(("constant", _)) => false,
        Some((other, entry)) => {
            let message = format!("between points a table cannot be `{other}`");
            return Err(Problem::new(message, entry.place()).help("it is linear or constant"));
        }
    };
    interpolated(&times, &values, is_linear, place)
}

/// Points in time with a line between two of them, or with the value of the first.
fn interpolated(
    times: &[f64],
    values: &[f64],
    is_linear: bool,
    place: Range<usize>,
) -> Result<InputShape, Problem> {
    if times.len() != values.len() {
        let message = format!("{} times and {} values", times.len(), values.len());
        return Err(Problem::new(message, place).help("each time has its value"));
    }
    if times.len() < 2 {
        let message = format!("a table of {} points in time", times.len());
        return Err(Problem::new(message, place)
            .help("it needs two at least; what is constant is a parameter"));
    }
    // Two points at one time are a step.
    let is_wrong = |&k: &usize| times[k - 1] > times[k] || k > 1 && times[k - 2] == times[k];
    if let Some(k) = (1..times.len()).find(is_wrong) {
        let message = format!(
            "the times are not in order: {} comes before {}, as number {k} and {} of {}",
            times[k - 1],
            times[k],
            k + 1,
            times.len()
        );
        return Err(Problem::new(message, place).help(
            "times rise; two points at one time are a step, from the first value to the second",
        ));
    }
    // The input is constant before the first point and after the last.
    let first = InputPiece {
        from: f64::NEG_INFINITY,
        value: values[0],
        slope: 0.0,
    };
    let part = |k: usize| InputPiece {
        from: times[k],
        value: values[k],
        slope: match times.get(k + 1) {
            Some(next) if is_linear => (values[k + 1] - values[k]) / (next - times[k]),
            _ => 0.0,
        },
    };
    let parts = (0..times.len()).filter(|&k| times.get(k + 1) != Some(&times[k]));
    let pieces = std::iter::once(first).chain(parts.map(part));
    Ok(InputShape::Table {
        pieces: pieces.collect(),
        is_linear,
    })
}

/// The first two columns of a file, relative to the system's file. Messages call them by these
/// names. Where they are the only ones, a third is refused.
pub(super) fn from_file(
    source: &Source,
    entry: Entry<'_>,
    columns: [&str; 2],
    are_alone: bool,
) -> Result<(Vec<f64>, Vec<f64>), Problem> {
    let folder = Path::new(&source.name).parent().unwrap_or(Path::new(""));
    let path = (folder.join(entry.text()?), "in the folder of this file");
    rows(path, columns, are_alone, entry.place())
}

/// The rows of [`from_file`], from a path that begins in the folder of these words.
fn rows(
    (path, begins): (PathBuf, &str),
    columns: [&str; 2],
    are_alone: bool,
    place: Range<usize>,
) -> Result<(Vec<f64>, Vec<f64>), Problem> {
    let wrong = |message: String| Problem::new(message, place.clone());
    let file = File::open(&path).map_err(|error| {
        wrong(format!("cannot read {}: {error}", path.display()))
            .help(format!("its path begins {begins}"))
    })?;
    let input = path.display().to_string();
    let refused = |error: TableError| wrong(error.to_string());
    let mut table = TextTable::new(&input, BufReader::new(file)).map_err(refused)?;
    let (mut times, mut values) = (Vec::new(), Vec::new());
    while let Some((line, cells)) = table.row().map_err(refused)? {
        if are_alone && cells.iter().skip(2).any(|cell| !cell.is_empty()) {
            let names = table.names.iter().flatten().map(String::as_str);
            let names: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
            let names = match names[..] {
                [] => String::new(),
                _ => format!(" ({})", names.join(", ")),
            };
            let [first, second] = columns;
            let message = format!(
                "{input} has {} columns{names}, and only two can be meant, {first} and {second}",
                cells.len()
            );
            return Err(wrong(message).help("leave these two in the file, in this order"));
        }
        let number = |column: usize| {
            let cell = cells.get(column).unwrap_or_default();
            let found = table.dialect.number(cell);
            let found = found.filter(|value| value.is_finite());
            found.ok_or_else(|| match cell {
                "" => format!("has no {}", columns[column]),
                _ => format!("has `{cell}`, which is no finite number"),
            })
        };
        match (number(0), number(1)) {
            (Ok(t), Ok(value)) => {
                times.push(t);
                values.push(value);
            }
            (Err(what), _) | (_, Err(what)) => {
                let [first, second] = columns;
                return Err(wrong(format!("{input}: line {line} {what}")).help(format!(
                    "a row has two numbers, {first} and {second}, with a comma, a semicolon or \
                     spaces between them"
                )));
            }
        }
    }
    Ok((times, values))
}
