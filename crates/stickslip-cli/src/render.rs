//! Results as text, CSV, JSON and files. A command describes what it has found once; each form is
//! written here and nowhere else.

use std::fmt::{Display, Write};
use std::path::{Path, PathBuf};

use output::{Artifact, PngError, WriteError};
use serde::Serialize;
use serde_json::{Map, Value as Json, json};
use stickslip::dynamics::{Modes, Vector};
use stickslip::{Mode, Side, math};
use stickslip_kernels::file::System;

/// What a command prints at its end.
pub(crate) struct Answer {
    /// For standard output.
    pub(crate) text: String,
    /// What went wrong behind what was found all the same.
    pub(crate) failure: Option<String>,
}

/// What to write, and where.
#[derive(Debug, clap::Args)]
pub(crate) struct OutputArguments {
    /// Folder for the files; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "stickslip-output")]
    pub(crate) out: String,

    /// Print the result as JSON
    #[arg(long)]
    pub(crate) json: bool,

    /// Also write the figures as PNG, at twice the nominal size
    #[arg(long)]
    pub(crate) png: bool,
}

impl OutputArguments {
    /// Refuses what cannot be written before anything is computed for it.
    ///
    /// # Errors
    /// [`OutputError::Png`].
    pub(crate) fn check(&self) -> Result<(), OutputError> {
        if self.png && !cfg!(feature = "png") {
            return Err(PngError::NotBuilt.into());
        }
        Ok(())
    }
}

/// Failure of making or writing files.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file or its folder cannot be made.
    #[error("{0}; {hint}choose another with --out", hint = if_file(.0))]
    Write(#[from] WriteError),
    /// The rows do not fit into a CSV file.
    #[error("cannot put the rows into CSV: {0}")]
    Csv(#[from] csv::Error),
    /// The drawing failed.
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    /// A figure cannot be made a PNG.
    #[error("{0}{hint}", hint = if_not_built(.0))]
    Png(#[from] PngError),
}

fn if_file(error: &WriteError) -> &'static str {
    match error {
        WriteError::Folder { .. } => "",
        WriteError::File { .. } => "check that the folder is writable and the disk not full, or ",
    }
}

fn if_not_built(error: &PngError) -> &'static str {
    match error {
        PngError::NotBuilt => {
            " (--no-default-features); rebuild it with `cargo build --release -p stickslip-cli`"
        }
        PngError::Rendering(_) => "",
    }
}

/// What a command has found, for people and for programs, with its tables and figures.
pub(crate) struct Report {
    text: String,
    /// Columns before the title of a line, and those that the title takes.
    margin: (usize, usize),
    json: Map<String, Json>,
    tables: Vec<Artifact>,
    figures: Vec<(String, String)>,
    /// Files that are on disk already.
    there: Vec<PathBuf>,
    failure: Option<String>,
}

impl Report {
    /// About a system: its name and what was done with it.
    pub(crate) fn of(system: &System, what: impl Display) -> Self {
        let mut report = Self::plain(format!("{}: {what}\n", system.file.name), (2, 13));
        report.system(system);
        report
    }

    /// The system's name and values, for programs.
    pub(crate) fn system(&mut self, system: &System) -> &mut Self {
        let parameters = system.file.parameters.iter().zip(&system.values);
        let parameters: Map<String, Json> = parameters
            .map(|(parameter, &value)| (parameter.name.clone(), json!(value)))
            .collect();
        let system = json!({ "name": system.file.name, "parameters": parameters });
        self.field("system", system)
    }

    /// With a beginning and margins of its own.
    pub(crate) fn plain(text: String, margin: (usize, usize)) -> Self {
        Self {
            text,
            margin,
            json: Map::new(),
            tables: Vec::new(),
            figures: Vec::new(),
            there: Vec::new(),
            failure: None,
        }
    }

    /// A line for people, under a title, which may be empty.
    pub(crate) fn line(&mut self, title: &str, text: impl Display) -> &mut Self {
        let (indent, width) = self.margin;
        // Writing into a text cannot fail.
        let _ = writeln!(self.text, "{:indent$}{title:width$}{text}", "");
        self
    }

    /// Lines under one title.
    pub(crate) fn lines(
        &mut self,
        title: &str,
        texts: impl IntoIterator<Item = String>,
    ) -> &mut Self {
        for (k, text) in texts.into_iter().enumerate() {
            self.line(if k == 0 { title } else { "" }, text);
        }
        self
    }

    /// Things of one kind, each with a line for people and a value for programs.
    pub(crate) fn list(
        &mut self,
        title: &str,
        things: impl IntoIterator<Item = (String, Json)>,
    ) -> &mut Self {
        let (lines, values): (Vec<String>, Vec<Json>) = things.into_iter().unzip();
        self.lines(title, lines).field(title, values)
    }

    /// A line for people that has no title.
    pub(crate) fn note(&mut self, text: impl Display) -> &mut Self {
        let _ = writeln!(self.text, "  {text}");
        self
    }

    /// A value for programs.
    pub(crate) fn field(&mut self, key: &str, value: impl Serialize) -> &mut Self {
        self.json.insert(key.to_owned(), json!(value));
        self
    }

    /// A table to write.
    pub(crate) fn table(&mut self, table: Artifact) -> &mut Self {
        self.tables.push(table);
        self
    }

    /// A file that is on disk already.
    pub(crate) fn file(&mut self, path: PathBuf) -> &mut Self {
        self.there.push(path);
        self
    }

    /// A figure to write.
    pub(crate) fn figure(
        &mut self,
        name: &str,
        figure: &plot::Figure,
    ) -> Result<&mut Self, OutputError> {
        self.figures.push((name.to_owned(), figure.render()?));
        Ok(self)
    }

    /// What went wrong behind what was found all the same.
    pub(crate) fn failure(&mut self, failure: Option<String>) -> &mut Self {
        self.failure = failure;
        self
    }

    /// What was found, of a command that writes no files.
    pub(crate) fn answer(self, as_json: bool) -> Answer {
        let text = if as_json {
            format!("{:#}\n", Json::Object(self.json))
        } else {
            self.text
        };
        Answer {
            text,
            failure: self.failure,
        }
    }

    /// Writes the files, by way of a folder for what is unfinished, and says what was found.
    pub(crate) fn written(
        mut self,
        staging: &Path,
        output: &OutputArguments,
    ) -> Result<Answer, OutputError> {
        let mut artifacts = std::mem::take(&mut self.tables);
        for (name, svg) in std::mem::take(&mut self.figures) {
            if output.png {
                artifacts.push(Artifact {
                    name: format!("{name}.png"),
                    bytes: output::png(&svg)?,
                });
            }
            artifacts.push(Artifact::text(format!("{name}.svg"), svg));
        }
        let written = output::write_all_by(staging, Path::new(&output.out), &artifacts)?;
        let paths = [std::mem::take(&mut self.there), written].concat();
        self.text.push('\n');
        self.text.push_str(&output::listing(&paths));
        let paths = paths.iter().map(|path| path.display().to_string());
        let paths: Vec<String> = paths.collect();
        self.field("files", paths);
        Ok(self.answer(output.json))
    }
}

/// A value in a row of a table.
pub(crate) enum Value {
    Missing,
    Text(String),
    Count(usize),
    Number(f64),
    /// A value for each state.
    State(Vec<f64>),
    /// A mode for each contact.
    Modes(Modes),
}

impl Value {
    /// The cells of a CSV. Numbers read back to the last bit.
    fn cells(&self, into: &mut Vec<String>) {
        match self {
            Value::Missing => into.push(String::new()),
            Value::Text(text) => into.push(text.clone()),
            Value::Count(count) => into.push(count.to_string()),
            Value::Number(number) => into.push(exact(*number)),
            Value::State(x) => into.extend(x.iter().map(|&x| exact(x))),
            Value::Modes(modes) => into.extend(modes.iter().map(|mode| {
                let name = match mode {
                    Mode::Slip(Side::Below) => "slip below",
                    Mode::Slip(Side::Above) => "slip above",
                    Mode::Stick => "stick",
                };
                name.to_owned()
            })),
        }
    }

    fn json(&self, members: &[String]) -> Json {
        match self {
            Value::Missing => Json::Null,
            Value::Text(text) => json!(text),
            Value::Count(count) => json!(count),
            Value::Number(number) => json!(number),
            Value::State(x) => {
                let members = members.iter().cloned().zip(x.iter().map(|x| json!(x)));
                Json::Object(members.collect())
            }
            Value::Modes(modes) => json!(letters(modes)),
        }
    }
}

macro_rules! value_from {
    ($($from:ty => $kind:ident),*) => {$(
        impl From<$from> for Value {
            fn from(from: $from) -> Self {
                Value::$kind(from.into())
            }
        }
    )*};
}
value_from!(f64 => Number, usize => Count, &str => Text, String => Text, Vec<f64> => State, Modes => Modes);

impl From<Vector> for Value {
    fn from(from: Vector) -> Self {
        Value::State(from.as_slice().to_vec())
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(from: Option<T>) -> Self {
        from.map_or(Value::Missing, Into::into)
    }
}

/// Neighbouring columns of a table, in JSON one member.
struct Columns<'a, R> {
    /// What JSON calls it.
    key: String,
    names: Vec<String>,
    /// What JSON calls the values of a state.
    members: Vec<String>,
    value: Box<dyn Fn(&R) -> Value + 'a>,
}

/// What the columns of a table are called, and how each is made of what a row is of.
pub(crate) struct Table<'a, R> {
    columns: Vec<Columns<'a, R>>,
}

impl<'a, R> Table<'a, R> {
    pub(crate) fn new() -> Self {
        Self {
            columns: Vec::new(),
        }
    }

    /// A column.
    pub(crate) fn column<V: Into<Value>>(self, name: &str, value: impl Fn(&R) -> V + 'a) -> Self {
        self.many(name, vec![name.to_owned()], Vec::new(), move |row| {
            value(row).into()
        })
    }

    /// A column for each state, with something behind its name.
    pub(crate) fn state<V: Into<Value>>(
        self,
        system: &System,
        suffix: &str,
        value: impl Fn(&R) -> V + 'a,
    ) -> Self {
        let states = || system.file.states.iter().map(|state| state.name.clone());
        let names = states().map(|name| name + suffix).collect();
        self.many(&format!("x{suffix}"), names, states().collect(), value)
    }

    /// A column for each contact, with something before its name.
    pub(crate) fn modes(
        self,
        system: &System,
        (key, prefix): (&str, &str),
        value: impl Fn(&R) -> Modes + 'a,
    ) -> Self {
        let contacts = system.file.contacts.iter();
        let names = contacts.map(|contact| format!("{prefix}{}", contact.name));
        self.many(key, names.collect(), Vec::new(), value)
    }

    /// Columns of these names; cells of a row that has fewer values are empty.
    pub(crate) fn many<V: Into<Value>>(
        mut self,
        key: &str,
        names: Vec<String>,
        members: Vec<String>,
        value: impl Fn(&R) -> V + 'a,
    ) -> Self {
        self.columns.push(Columns {
            key: key.to_owned(),
            names,
            members,
            value: Box::new(move |row| value(row).into()),
        });
        self
    }

    /// The names of all columns.
    pub(crate) fn heading(&self) -> Vec<String> {
        let names = self.columns.iter().flat_map(|columns| &columns.names);
        names.cloned().collect()
    }

    /// The cells of a row.
    pub(crate) fn row(&self, of: &R) -> Vec<String> {
        let (mut row, mut width) = (Vec::new(), 0);
        for columns in &self.columns {
            (columns.value)(of).cells(&mut row);
            width += columns.names.len();
            row.resize(width, String::new());
        }
        row
    }

    /// As CSV.
    ///
    /// # Errors
    /// [`OutputError::Csv`].
    pub(crate) fn csv(
        &self,
        name: &str,
        rows: impl IntoIterator<Item = R>,
    ) -> Result<Artifact, OutputError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.heading())?;
        for row in rows {
            writer.write_record(self.row(&row))?;
        }
        let bytes = writer.into_inner().map_err(|error| error.into_error());
        Ok(Artifact {
            name: format!("{name}.csv"),
            bytes: bytes.map_err(csv::Error::from)?,
        })
    }

    /// As JSON, an object for each row.
    pub(crate) fn json(&self, rows: impl IntoIterator<Item = R>) -> Vec<Json> {
        let object = |row: R| {
            let member = |columns: &Columns<'_, R>| {
                let value = (columns.value)(&row);
                (columns.key.clone(), value.json(&columns.members))
            };
            Json::Object(self.columns.iter().map(member).collect())
        };
        rows.into_iter().map(object).collect()
    }
}

/// A number that reads back to the last bit.
pub(crate) fn exact(value: f64) -> String {
    format!("{value:?}")
}

/// A number for people: twelve digits, of which rounding has not made the last ones.
pub(crate) fn rounded(value: f64) -> f64 {
    to_digits(value, 12)
}

/// A number to so many significant digits.
fn to_digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// A number to the digits that it has, in which it is rounded by more than its uncertainty.
pub(crate) fn known(value: f64, uncertainty: f64) -> f64 {
    const MOST: f64 = 12.0;
    let digits = 1.0 + math::log10(value.abs() / (2.0 * uncertainty)).floor();
    to_digits(value, digits.clamp(1.0, MOST) as usize)
}

/// A number with what it is uncertain by, and no digits beyond.
pub(crate) fn within(value: f64, uncertainty: f64) -> String {
    const MOST: f64 = 16.0;
    if !(uncertainty > 0.0 && uncertainty.is_finite()) {
        return format!("about {}", to_digits(value, 4));
    }
    let decimals = (1.0 - math::log10(uncertainty).floor()).max(0.0);
    if decimals > MOST {
        return format!("{value:.2e} ± {uncertainty:.0e}");
    }
    let text = format!("{value:.0$}", decimals as usize);
    // Rounded to zero it has no sign.
    let is_zero = text
        .bytes()
        .all(|digit| matches!(digit, b'-' | b'0' | b'.'));
    let text = if is_zero {
        text.trim_start_matches('-')
    } else {
        &text
    };
    format!("{text} ± {uncertainty:.0e}")
}

/// A located number, with no digits beyond its uncertainty.
pub(crate) fn place(value: f64, uncertainty: f64) -> String {
    if uncertainty > 1e-12 * value.abs() {
        within(value, uncertainty)
    } else {
        rounded(value).to_string()
    }
}

/// A state for people.
pub(crate) fn state_words(x: &[f64]) -> String {
    // What rounds to zero has no sign.
    let signed = |x: f64| if x.abs() < 0.5e-9 { 0.0 } else { x };
    let x: Vec<String> = x.iter().map(|&x| format!("{:.9}", signed(x))).collect();
    format!("({})", x.join(", "))
}

/// The name of a contact; empty where it is not one of the system's.
pub(crate) fn contact_name(system: &System, contact: usize) -> String {
    let contact = system.file.contacts.get(contact);
    contact.map_or_else(String::new, |contact| contact.name.clone())
}

/// Something of each state, by names.
pub(crate) fn by_state(system: &System, of_each: &[impl Serialize]) -> Json {
    let states = system.file.states.iter().zip(of_each);
    let map = states.map(|(state, value)| (state.name.clone(), json!(value)));
    Json::Object(map.collect())
}

/// The modes of a phase in a few letters, of several contacts separated by `|`: `+` and `-` for
/// slip above and below, `S` for stick.
pub(crate) fn letters(modes: &Modes) -> String {
    let letters = modes.iter().map(|mode| match mode {
        Mode::Stick => "S",
        Mode::Slip(Side::Above) => "+",
        Mode::Slip(Side::Below) => "-",
    });
    letters.collect::<Vec<_>>().join("|")
}

/// The modes gone through, in letters.
pub(crate) fn sequence(modes: &[Modes]) -> String {
    let signs: Vec<String> = modes.iter().map(letters).collect();
    signs.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip_kernels::file::SystemFile;

    #[test]
    fn csv_and_json_have_the_same_values() {
        let system = SystemFile::open("belt").unwrap().with(&[]).unwrap();
        type Row = (usize, Option<f64>, Vec<f64>);
        let table = Table::new()
            .column("k", |row: &Row| row.0)
            .column("rate", |row| row.1)
            .state(&system, "_end", |row| row.2.clone());
        let rows: [Row; 2] = [(1, Some(0.1), vec![-0.0, 2.0]), (2, None, Vec::new())];
        let csv = table.csv("rows", rows.clone()).unwrap();
        assert_eq!(
            String::from_utf8(csv.bytes).unwrap(),
            "k,rate,x_end,v_end\n1,0.1,-0.0,2.0\n2,,,\n"
        );
        let wanted = [
            json!({ "k": 1, "rate": 0.1, "x_end": { "x": -0.0, "v": 2.0 } }),
            json!({ "k": 2, "rate": null, "x_end": {} }),
        ];
        assert_eq!(table.json(rows), wanted);
    }
}
