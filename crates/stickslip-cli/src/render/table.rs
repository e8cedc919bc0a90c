//! Tables, as CSV and as JSON objects.

use std::io;

use output::Artifact;
use serde_json::{Value as Json, json};
use stickslip::dynamics::{Modes, Vector};
use stickslip::{Mode, Side};
use stickslip_model::file::System;

use super::OutputError;
use super::words::exact;

/// A value in a row of a table.
pub(crate) enum Value {
    Missing,
    Text(String),
    Count(usize),
    Number(f64),
    /// A value for each state.
    State(Vec<f64>),
    /// A mode for each contact, and all modes as letters.
    Modes(Modes, String),
}

impl Value {
    /// Appends the cells of the value for CSV. Numbers read back bit for bit.
    fn cells(&self, into: &mut Vec<String>) {
        match self {
            Value::Missing => into.push(String::new()),
            Value::Text(text) => into.push(text.clone()),
            Value::Count(count) => into.push(count.to_string()),
            Value::Number(number) => into.push(exact(*number)),
            Value::State(x) => into.extend(x.iter().map(|&x| exact(x))),
            Value::Modes(modes, _) => into.extend(modes.iter().map(|mode| {
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
            Value::Modes(_, letters) => json!(letters),
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
value_from!(f64 => Number, usize => Count, &str => Text, String => Text, Vec<f64> => State);

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

/// Adjacent columns of a table, which are one member in JSON.
struct Columns<'a, R> {
    /// Name of the member in JSON.
    key: String,
    names: Vec<String>,
    /// Names of the values of a state in JSON.
    members: Vec<String>,
    value: Box<dyn Fn(&R) -> Value + 'a>,
}

/// Names of the columns of a table, and functions that compute their values for a row.
pub(crate) struct Table<'a, R> {
    columns: Vec<Columns<'a, R>>,
}

impl<'a, R> Table<'a, R> {
    pub(crate) fn new() -> Self {
        Self {
            columns: Vec::new(),
        }
    }

    /// Adds a column.
    pub(crate) fn column<V: Into<Value>>(self, name: &str, value: impl Fn(&R) -> V + 'a) -> Self {
        self.many(name, vec![name.to_owned()], value)
    }

    /// Adds a column for each state, with a suffix to its name.
    pub(crate) fn state<V: Into<Value>>(
        self,
        system: &System,
        suffix: &str,
        value: impl Fn(&R) -> V + 'a,
    ) -> Self {
        let states = || system.file.states.iter().map(|state| state.name.clone());
        let names = states().map(|name| name + suffix).collect();
        self.columns_of(&format!("x{suffix}"), (names, states().collect()), value)
    }

    /// Adds a column for each contact, with a prefix to its name.
    pub(crate) fn modes(
        self,
        system: &'a System,
        (key, prefix): (&str, &str),
        value: impl Fn(&R) -> Modes + 'a,
    ) -> Self {
        let contacts = system.file.contacts.iter();
        let names = contacts.map(|contact| format!("{prefix}{}", contact.name));
        self.many(key, names.collect(), move |row| {
            let modes = value(row);
            Value::Modes(modes, system.letters(&modes))
        })
    }

    /// Adds columns with these names. If a row has fewer values, its other cells are empty.
    pub(crate) fn many<V: Into<Value>>(
        self,
        key: &str,
        names: Vec<String>,
        value: impl Fn(&R) -> V + 'a,
    ) -> Self {
        self.columns_of(key, (names.clone(), names), value)
    }

    fn columns_of<V: Into<Value>>(
        mut self,
        key: &str,
        (names, members): (Vec<String>, Vec<String>),
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

    /// Writes the names of all columns.
    pub(crate) fn write_heading<W: io::Write>(
        &self,
        to: &mut csv::Writer<W>,
    ) -> Result<(), OutputError> {
        let names = self.columns.iter().flat_map(|columns| &columns.names);
        Ok(to.write_record(names)?)
    }

    /// Writes rows.
    pub(crate) fn write_rows<W: io::Write>(
        &self,
        to: &mut csv::Writer<W>,
        rows: impl IntoIterator<Item = R>,
    ) -> Result<(), OutputError> {
        for row in rows {
            to.write_record(self.row(&row))?;
        }
        Ok(())
    }

    /// The cells of a row.
    fn row(&self, of: &R) -> Vec<String> {
        let (mut row, mut width) = (Vec::new(), 0);
        for columns in &self.columns {
            (columns.value)(of).cells(&mut row);
            width += columns.names.len();
            row.resize(width, String::new());
        }
        row
    }

    /// The table as CSV.
    ///
    /// # Errors
    /// [`OutputError::Csv`].
    pub(crate) fn csv(
        &self,
        name: &str,
        rows: impl IntoIterator<Item = R>,
    ) -> Result<Artifact, OutputError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        self.write_heading(&mut writer)?;
        self.write_rows(&mut writer, rows)?;
        let bytes = writer.into_inner().map_err(|error| error.into_error());
        Ok(Artifact {
            name: format!("{name}.csv"),
            bytes: bytes.map_err(csv::Error::from)?,
        })
    }

    /// The table as JSON, an object for each row.
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

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip_model::file::SystemFile;

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

    #[test]
    fn many_values_have_their_names_in_json() {
        let names = ["a", "b"].map(str::to_owned).to_vec();
        let table = Table::new().many("set", names, |row: &Vec<f64>| row.clone());
        let rows = table.json([vec![1.0, 2.0], vec![3.0]]);
        assert_eq!(
            Json::Array(rows),
            json!([{"set": {"a": 1.0, "b": 2.0}}, {"set": {"a": 3.0}}])
        );
    }
}
