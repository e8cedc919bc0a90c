//! Tables of a file: entries in the order of the file, with their positions.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::formula::Formula;
use super::names::did_you_mean;
use super::problem::{Problem, Source};

/// A value and its position.
#[derive(Clone, Copy)]
pub(super) struct Entry<'a> {
    pub source: &'a Source,
    value: &'a Spanned<DeValue<'a>>,
}

/// A table and its name in messages.
pub(super) struct Table<'a> {
    pub place: Range<usize>,
    /// The name, such as `[parameters]`; empty for the whole file.
    title: String,
    entries: Vec<(&'a str, Range<usize>, Entry<'a>)>,
}

impl<'a> Table<'a> {
    pub(super) fn of_file(source: &'a Source, table: &'a Spanned<DeTable<'a>>) -> Self {
        Table::new(source, table.span(), table.get_ref(), String::new())
    }

    fn new(source: &'a Source, place: Range<usize>, table: &'a DeTable<'a>, title: String) -> Self {
        let entries = table.iter().map(|(key, value)| {
            let entry = Entry { source, value };
            (key.get_ref().as_ref(), key.span(), entry)
        });
        let mut entries: Vec<_> = entries.collect();
        entries.sort_by_key(|(_, place, _)| place.start);
        Table {
            place,
            title,
            entries,
        }
    }

    /// Keys, their positions and values in the order of the file.
    pub(super) fn entries(&self) -> impl Iterator<Item = (&'a str, Range<usize>, Entry<'a>)> {
        self.entries.iter().cloned()
    }

    pub(super) fn get(&self, name: &str) -> Option<Entry<'a>> {
        let mut entries = self.entries.iter();
        entries
            .find(|(key, ..)| *key == name)
            .map(|&(_, _, entry)| entry)
    }

    /// Removes the entries with some names, and returns them.
    pub(super) fn take(
        &mut self,
        is_taken: impl Fn(&str) -> bool,
    ) -> Vec<(&'a str, Range<usize>, Entry<'a>)> {
        let (taken, kept) = std::mem::take(&mut self.entries)
            .into_iter()
            .partition(|(name, ..)| is_taken(name));
        self.entries = kept;
        taken
    }

    /// A required entry.
    pub(super) fn need(&self, name: &str, what: &str) -> Result<Entry<'a>, Problem> {
        self.get(name).ok_or_else(|| {
            let place = if self.title.is_empty() {
                0..0
            } else {
                self.place.clone()
            };
            Problem::new(format!("{} has no `{name}`", self.description()), place)
                .help(format!("it is needed: {what}"))
        })
    }

    /// A table by name.
    pub(super) fn table(&self, name: &str) -> Result<Option<Table<'a>>, Problem> {
        self.get(name)
            .map(|entry| entry.table(&self.title, name))
            .transpose()
    }

    /// Applies a function to each entry of a table, which may be missing, with its number.
    pub(super) fn each<T>(
        &self,
        name: &str,
        mut make: impl FnMut(usize, &'a str, Range<usize>, Entry<'a>) -> Result<T, Problem>,
    ) -> Result<Vec<T>, Problem> {
        let table = self.table(name)?;
        let entries = table.iter().flat_map(Table::entries).enumerate();
        let made = entries.map(|(number, (name, place, entry))| make(number, name, place, entry));
        made.collect()
    }

    /// Rejects unknown entries.
    pub(super) fn only(&self, known: &[&str]) -> Result<(), Problem> {
        for (name, place, _) in &self.entries {
            if !known.contains(name) {
                let message = format!("{} has no entry `{name}`", self.description());
                let help = did_you_mean(name, known.iter().copied())
                    .unwrap_or_else(|| format!("there can be {}", listed(known)));
                return Err(Problem::new(message, place.clone())
                    .label("not known")
                    .help(help));
            }
        }
        Ok(())
    }

    fn description(&self) -> String {
        if self.title.is_empty() {
            "the file".to_owned()
        } else {
            format!("[{}]", self.title)
        }
    }
}

/// Names in backticks, separated by commas.
pub(super) fn listed(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    names.join(", ")
}

impl<'a> Entry<'a> {
    pub(super) fn place(self) -> Range<usize> {
        self.value.span()
    }

    fn wrong(self, wanted: &str) -> Problem {
        let found = match self.value.get_ref() {
            DeValue::String(_) => "a text",
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        };
        Problem::new(
            format!("{wanted} is expected here, not {found}"),
            self.place(),
        )
    }

    pub(super) fn table(self, above: &str, name: &str) -> Result<Table<'a>, Problem> {
        let title = if above.is_empty() {
            name.to_owned()
        } else {
            format!("{above}.{name}")
        };
        self.as_table(&title).ok_or_else(|| {
            self.wrong(&format!("a table [{title}]"))
                .help(format!("write a line [{title}], and its entries below it"))
        })
    }

    /// The value as a table, if it is one.
    pub(super) fn as_table(self, title: &str) -> Option<Table<'a>> {
        let DeValue::Table(table) = self.value.get_ref() else {
            return None;
        };
        let (place, title) = (self.place(), title.to_owned());
        Some(Table::new(self.source, place, table, title))
    }

    pub(super) fn text(self) -> Result<&'a str, Problem> {
        match self.value.get_ref() {
            DeValue::String(text) => Ok(text),
            _ => Err(self.wrong("a text in quotes")),
        }
    }

    /// A number, which may be infinite but not NaN.
    fn number(self) -> Option<f64> {
        match self.value.get_ref() {
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
                .ok()
                .map(|value| value as f64),
            DeValue::Float(float) => float.as_str().parse().ok(),
            _ => None,
        }
    }

    /// A finite number.
    pub(super) fn finite(self) -> Result<f64, Problem> {
        match self.number() {
            Some(value) if value.is_finite() => Ok(value),
            Some(value) => Err(Problem::new(
                format!("a finite number is expected here, not {value}"),
                self.place(),
            )),
            None => Err(self.wrong("a number")),
        }
    }

    /// True or false.
    pub(super) fn flag(self) -> Result<bool, Problem> {
        match self.value.get_ref() {
            DeValue::Boolean(flag) => Ok(*flag),
            _ => Err(self.wrong("true or false")),
        }
    }

    /// An integer from 1 on.
    pub(super) fn count(self) -> Result<u64, Problem> {
        match self.number() {
            Some(value) if value >= 1.0 && value.fract() == 0.0 => Ok(value as u64),
            Some(value) => Err(Problem::new(
                format!("a whole number from 1 on is expected here, not {value}"),
                self.place(),
            )),
            None => Err(self.wrong("a whole number from 1 on")),
        }
    }

    /// A list of finite numbers.
    pub(super) fn list(self) -> Result<Vec<f64>, Problem> {
        let DeValue::Array(array) = self.value.get_ref() else {
            return Err(self.wrong("a list of numbers"));
        };
        let entries = array.iter().map(|value| Entry { value, ..self });
        entries.map(Entry::finite).collect()
    }

    /// A condition, as a text.
    pub(super) fn condition(self) -> Result<Formula, Problem> {
        match self.value.get_ref() {
            DeValue::String(text) => Formula::condition(text, self.place(), self.source),
            _ => Err(self.wrong("a condition in quotes, as in \"v < 0.1\",")),
        }
    }

    /// A list of pairs of finite numbers.
    pub(super) fn pairs(self) -> Result<Vec<[f64; 2]>, Problem> {
        let wanted = "a list of points, as in [[0, 0.4], [1, 0.3]]";
        let DeValue::Array(array) = self.value.get_ref() else {
            return Err(self.wrong(wanted));
        };
        let entries = array.iter().map(|value| Entry { value, ..self });
        let pair = |entry: Entry<'a>| {
            let DeValue::Array(pair) = entry.value.get_ref() else {
                return Err(entry.wrong("a point of two numbers"));
            };
            let [x, y] = &**pair else {
                let message = format!("a point has two numbers, this has {}", pair.len());
                return Err(Problem::new(message, entry.place()));
            };
            let finite = |value| Entry { value, ..self }.finite();
            Ok([finite(x)?, finite(y)?])
        };
        entries.map(pair).collect()
    }

    /// An expression: a text or a number.
    pub(super) fn formula(self) -> Result<Formula, Problem> {
        match self.value.get_ref() {
            DeValue::String(text) => Formula::parsed(text, self.place(), self.source),
            DeValue::Integer(_) | DeValue::Float(_) => {
                Ok(Formula::number(self.finite()?, self.place()))
            }
            _ => Err(self.wrong("an expression in quotes, or a number,")),
        }
    }

    /// A lower and an upper bound, not equal. They may be infinite only if that is allowed.
    pub(super) fn interval(self, may_be_infinite: bool) -> Result<(f64, f64), Problem> {
        let wanted = "a range [lowest, highest]";
        let DeValue::Array(array) = self.value.get_ref() else {
            return Err(self.wrong(wanted));
        };
        let ends: Vec<Entry<'_>> = array.iter().map(|value| Entry { value, ..self }).collect();
        let [low, high] = ends[..] else {
            let message = format!("{wanted} has two numbers, this has {}", ends.len());
            return Err(Problem::new(message, self.place()));
        };
        let end = |entry: Entry<'_>| match entry.number() {
            Some(value) if may_be_infinite && !value.is_nan() => Ok(value),
            _ => entry.finite(),
        };
        let (low, high) = (end(low)?, end(high)?);
        if low < high {
            return Ok((low, high));
        }
        let message = format!("the range from {low} to {high} is empty");
        Err(Problem::new(message, self.place()).help("the lower end comes first"))
    }
}
