//! `stickslip simulate --starts`: orbits from the rows of a table.

use std::fs::File;
use std::io::{BufRead, BufReader};

use stickslip::dynamics::{Moment, Summary, Vector};
use stickslip::error::readable;
use stickslip_model::expression::normal;
use stickslip_model::file::{SettingError, System};
use stickslip_model::study::ensemble::by_system;
use stickslip_model::text_table::{TableError, TextTable};

use super::arguments::RunArguments;
use super::recording::{self, Recording, Wanted};
use super::resume::End;
use super::simulate::{end_time, ending, passage_columns};
use super::trajectory::{phase_columns, transitions, transitions_with_residuals};
use crate::failure::{Failure, in_words};
use crate::render::{CommandOutput, Report, Table};
use output::terminal::with_spinner;

/// Target of a column of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    State(usize),
    Parameter(usize),
}

/// Starts, with values of parameters.
struct Starts {
    columns: Vec<Column>,
    rows: Vec<Vec<f64>>,
}

impl Starts {
    /// The values of the columns of one kind, of one row.
    fn of(&self, row: usize, parameters: bool) -> impl Iterator<Item = (Column, f64)> {
        let pairs = self
            .columns
            .iter()
            .copied()
            .zip(self.rows[row].iter().copied());
        pairs.filter(move |(column, _)| matches!(column, Column::Parameter(_)) == parameters)
    }

    fn open(path: &str, system: &System) -> Result<Self, Failure> {
        if path == "-" {
            return Starts::read("standard input", std::io::stdin().lock(), system);
        }
        let file = File::open(path).map_err(|source| TableError::read(path, source))?;
        Starts::read(path, BufReader::new(file), system)
    }

    fn read(input: &str, source: impl BufRead, system: &System) -> Result<Self, Failure> {
        let mut text = TextTable::new(input, source)?;
        let names = text.names.take().ok_or_else(|| {
            Failure::Usage(format!(
                "--starts {input}: the first line has no names; write the names of states and \
                 parameters there, one for each column"
            ))
        })?;
        let columns = names.iter().map(|name| column(input, name.trim(), system));
        let columns = columns.collect::<Result<Vec<Column>, Failure>>()?;
        let twice = (1..columns.len()).find(|&k| columns[..k].contains(&columns[k]));
        if let Some(k) = twice {
            let name = names[k].trim();
            let message = format!("--starts {input}: the column {name} stands twice; take one out");
            return Err(Failure::Usage(message));
        }
        let mut rows = Vec::new();
        while let Some((line, cells)) = text.row()? {
            let numbers = cells.iter().map(|cell| text.dialect.number(cell));
            let numbers: Option<Vec<f64>> = numbers.collect();
            let complete = numbers.filter(|row| {
                row.len() == columns.len() && row.iter().all(|value| value.is_finite())
            });
            rows.push(complete.ok_or_else(|| {
                TableError::File(format!(
                    "{input}, line {line}: {} finite numbers are needed, one for each of {}",
                    columns.len(),
                    names.join(", ")
                ))
            })?);
        }
        if rows.is_empty() {
            return Err(TableError::empty(input).into());
        }
        Ok(Starts { columns, rows })
    }
}

/// Finds the target that a name in the first line sets.
fn column(input: &str, name: &str, system: &System) -> Result<Column, Failure> {
    let (file, plain) = (&system.file, normal(name));
    let state = file.states.iter().position(|state| state.name == plain);
    let mut parameters = file.parameters.iter();
    let parameter = parameters.position(|parameter| parameter.name == plain);
    let state = state.map(Column::State);
    state.or(parameter.map(Column::Parameter)).ok_or_else(|| {
        let states = file.states.iter().map(|state| state.name.as_str());
        let parameters = file.parameters.iter().map(|one| one.name.as_str());
        let all: Vec<&str> = states.chain(parameters).collect();
        Failure::Usage(format!(
            "--starts {input}: there is no state or parameter `{name}`; there are {}",
            all.join(", ")
        ))
    })
}

/// An orbit, and how it ended.
struct Followed {
    /// The orbit, unless it cannot begin with the values of its row.
    recording: Option<Recording>,
    ended: Result<Summary, String>,
}

impl Followed {
    /// Time and state at the end.
    fn end(&self) -> Option<(f64, &Vector)> {
        let last = || self.recording.as_ref().map(|one| &one.orbit.end);
        match &self.ended {
            Ok(summary) => Some((summary.t, &summary.x)),
            Err(_) => last().map(|end| (end.t, &end.x)),
        }
    }
}

pub(super) fn run(
    run: &RunArguments,
    file: &str,
    t_end: Option<f64>,
    (observed, steps): (&[(&str, &str)], bool),
) -> Result<CommandOutput, Failure> {
    let system = run.system()?;
    let options = run.solver.options(&system)?;
    let t_end = end_time(&system, t_end)?;
    let starts = Starts::open(file, &system)?;
    for column in &starts.columns {
        let (option, name, is_set) = match column {
            Column::State(state) => {
                let name = &system.file.states[*state].name;
                ("--start", name, run.start.sets(name))
            }
            Column::Parameter(number) => {
                let name = &system.file.parameters[*number].name;
                ("--set", name, run.system.sets(name))
            }
        };
        if is_set {
            return Err(Failure::Usage(format!(
                "{option} {name}=… has no effect: {name} is a column of {file}; leave one of them \
                 out"
            )));
        }
    }
    let states = starts.columns.iter().filter_map(|column| match column {
        Column::State(state) => Some(*state),
        Column::Parameter(_) => None,
    });
    let states: Vec<usize> = states.collect();
    let names = starts.columns.iter().filter_map(|column| match column {
        Column::Parameter(number) => Some(system.file.parameters[*number].name.clone()),
        Column::State(_) => None,
    });
    let names: Vec<String> = names.collect();
    let values =
        (0..starts.rows.len()).map(|row| starts.of(row, true).map(|(_, value)| value).collect());
    let values: Vec<Vec<f64>> = values.collect();
    let wanted = Wanted {
        figures: false,
        steps,
        progress: false,
    };
    let (t, _) = run.start.except(&system, &states)?;
    options.check_span(t, t_end)?;
    let begin = |system: &System, row: usize| -> Result<Moment, Failure> {
        let (t, mut x) = run.start.except(system, &states)?;
        for (column, value) in starts.of(row, false) {
            if let Column::State(state) = column {
                x[state] = value;
            }
        }
        let x = Vector::from_vec(x);
        Ok(Moment { t, x })
    };
    // A wrong formula is the fault of the command, not of a row.
    system.quantities(observed)?;
    let follow = |system: &System, rows: &[usize]| -> Result<Vec<Followed>, Failure> {
        let begins = rows.iter().map(|&row| begin(system, row));
        let begins = begins.collect::<Result<Vec<Moment>, Failure>>()?;
        let quantities = begins.iter().map(|_| system.quantities(observed));
        let quantities = quantities.collect::<Result<Vec<_>, _>>()?;
        let all = Recording::of_all(system, &begins, t_end, &options, wanted, quantities);
        let followed = all.into_iter().map(|(recording, ended)| Followed {
            recording: Some(recording),
            ended: ended.map_err(|error| in_words(&error, system)),
        });
        Ok(followed.collect())
    };
    let of_block = |system: Result<&System, SettingError>, rows: &[usize]| {
        let followed = system
            .map_err(Failure::from)
            .and_then(|system| follow(system, rows));
        followed.unwrap_or_else(|error| {
            let ended = Err(error.to_string());
            let failed = || Followed {
                recording: None,
                ended: ended.clone(),
            };
            rows.iter().map(|_| failed()).collect()
        })
    };
    let orbits = with_spinner("following the orbits", |_| {
        by_system(&system, &names, &values, of_block)
    });
    let what = format!(
        "{} orbits from {file}, t = {} to {}",
        orbits.len(),
        readable(t),
        readable(t_end)
    );
    let mut report = Report::of(&system, what);
    tables(&system, (&names, &values), &orbits, (steps, &mut report))?;
    let end = End::of_many(&system, &options, t_end, orbits.len());
    report.table(end.artifact()?);
    Ok(report.written(run.output.out.as_ref(), &run.output)?)
}

/// Reports all orbits, with a table of their ends and those of a single run.
fn tables(
    system: &System,
    (names, values): (&[String], &[Vec<f64>]),
    orbits: &[Followed],
    (steps, report): (bool, &mut Report),
) -> Result<(), Failure> {
    let numbered = || (1..).zip(orbits);
    let mut endings: Vec<(&str, usize)> = Vec::new();
    for (_, orbit) in numbered() {
        let word = ending(orbit.ended.as_ref().ok());
        match endings.iter_mut().find(|(known, _)| *known == word) {
            Some((_, count)) => *count += 1,
            None => endings.push((word, 1)),
        }
    }
    let counts = endings
        .iter()
        .map(|(word, count)| format!("{count} × {word}"));
    report.line("ended", counts.collect::<Vec<_>>().join(", "));
    type Row<'r> = (usize, &'r Followed);
    let ends = Table::new()
        .column("orbit", |&(number, _): &Row<'_>| number)
        .many("parameters", names.to_vec(), |&(number, _)| {
            values[number - 1].clone()
        })
        .state(system, "_start", |(_, orbit)| {
            let recording = orbit.recording.as_ref();
            recording.map(|one| one.orbit.start.x.clone())
        })
        .column("t_end", |(_, orbit)| orbit.end().map(|end| end.0))
        .column("ending", |(_, orbit)| ending(orbit.ended.as_ref().ok()))
        .state(system, "_end", |(_, orbit)| {
            orbit.end().map(|end| end.1.clone())
        })
        .column("error", |(_, orbit)| orbit.ended.as_ref().err().cloned())
        .column("doubtful", |(_, orbit)| {
            let recording = orbit.recording.as_ref();
            recording.map(|one| one.doubtful.join("; "))
        });
    report.field("orbits", ends.json(numbered()));
    report.table(ends.csv("orbits", numbered())?);
    let recorded =
        || numbered().filter_map(|(number, orbit)| Some((number, orbit.recording.as_ref()?)));
    let phases = recorded().flat_map(|(number, one)| {
        let phases = (1..).zip(&one.orbit.phases);
        phases.map(move |(k, phase)| (number, k, phase))
    });
    report.table(phase_columns(system, true).csv("phases", phases)?);
    let changes = || {
        recorded().flat_map(|(number, one)| {
            let changes = one.orbit.events.iter();
            changes.map(move |at| (number, at))
        })
    };
    report.field("transitions", transitions(system, true).json(changes()));
    let with_residuals = transitions_with_residuals(system, true);
    report.table(with_residuals.csv("transitions", changes())?);
    if !system.sections().is_empty() {
        let passages = recorded().flat_map(|(number, one)| {
            let passages = one.orbit.passages.iter();
            passages.map(move |at| (number, at))
        });
        report.table(passage_columns(system, true).csv("section", passages)?);
    }
    if steps {
        let names = recorded().next().map(|(_, one)| one.quantities.0.clone());
        type Numbered<'r> = (usize, recording::Row<'r>);
        let table = Table::new()
            .column("orbit", |&(number, _): &Numbered<'_>| number)
            .column("t", |(_, (t, ..))| *t)
            .state(system, "", |(_, (_, x, _))| x.to_vec())
            .many("quantities", names.unwrap_or_default(), |(_, row)| {
                row.2.to_vec()
            });
        let rows = recorded().flat_map(|(number, one)| {
            let rows = one.rows();
            rows.map(move |row| (number, row))
        });
        report.table(table.csv("steps", rows)?);
    }
    let failed =
        || numbered().filter_map(|(number, orbit)| Some((number, orbit.ended.as_ref().err()?)));
    if let Some((number, error)) = failed().next() {
        let count = failed().count();
        let words = format!(
            "{count} of {} orbits failed; the first, orbit {number}: {error}",
            orbits.len()
        );
        report.failure(Some(words));
    }
    Ok(())
}
