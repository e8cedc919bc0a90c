//! Reads the entries of a file from its text.

use std::ops::Range;

use stickslip::{Direction, Options};
use toml::de::DeTable;

use super::names::{Meaning, Names, did_you_mean};
use super::problem::{Problem, Source};
use super::table::{Entry, Table, listed};
use super::template::Checked;
use super::{Contact, Formula, Named, Parameter, Rate, SectionEntry, StateEntry, SystemFile, Time};
use super::{stops, switching};
use crate::expression::normal;
use crate::kernel::{MOST_CONTACTS, MOST_STATES};

/// The tables and entries of a file.
const ENTRIES: [&str; 17] = [
    "name",
    "description",
    "time",
    "states",
    "parameters",
    "definitions",
    "contacts",
    "discrete",
    "jumps",
    "stops",
    "inputs",
    "switches",
    "curves",
    "field",
    "start",
    "section",
    "ranges",
];

pub(super) fn read(source: &Source) -> Result<SystemFile, Problem> {
    let parsed = DeTable::parse(&source.text).map_err(|error| not_toml(&error, source))?;
    let file = Table::of_file(source, &parsed);
    file.only(&ENTRIES)?;
    let name = file.need(
        "name",
        "what the system is called, as in name = \"Block on a belt\"",
    )?;
    let mut names = Names::new();
    let mut states = states(&file, &mut names)?;
    let parameters = parameters(&file, &mut names)?;
    let contacts = contacts(&file, &mut names)?;
    let definitions = definitions(&file, &mut names)?;
    let continuous = states.len();
    let mut discrete = switching::discrete(&file, &mut names, continuous)?;
    let mut field = field(&file, (&states, &names), contacts.len())?;
    let stops = stops::read(&file, &mut names, &states, &mut discrete)?;
    start(&file, (&mut states, &mut discrete), &names)?;
    states.extend(discrete);
    if states.len() > MOST_STATES {
        let message = format!("{} states, discrete ones among them", states.len());
        return Err(
            Problem::new(message, 0..0).help(format!("a file can have {MOST_STATES} states"))
        );
    }
    // Discrete states are constant between jumps.
    let none = || Rate::Same(Formula::number(0.0, 0..0));
    field.extend(states[continuous..].iter().map(|_| none()));
    let mut jumps = switching::jumps(&file, &mut names, &states)?;
    jumps.extend(stops::events(&stops, states.len()));
    let inputs = switching::inputs(source, &file, &mut names)?;
    let curves = super::curves::read(source, &file, &mut names)?;
    ranges(&file, &mut states, &names)?;
    Ok(SystemFile {
        jumps,
        stops,
        inputs,
        curves,
        name: name.text()?.to_owned(),
        description: text(&file, "description")?,
        time: time(&file)?,
        sections: section(&file)?.into_iter().collect(),
        source: source.clone(),
        states,
        parameters,
        definitions,
        contacts,
        field,
        names,
        is_reversed: false,
        checked: Checked::default(),
    })
}

/// Reports a text that is not TOML.
fn not_toml(error: &toml::de::Error, source: &Source) -> Problem {
    let place = error.span().unwrap_or(0..0);
    if error.message() == "duplicate key" {
        return duplicate_key(place, &source.text);
    }
    let line = &source.text[line_start(&source.text, place.start)..];
    let line = line.lines().next().unwrap_or_default();
    let key = line.split('=').next().unwrap_or_default();
    let unquoted = !key.is_ascii() && !key.contains(['"', '\'']);
    let problem = Problem::new(error.message().to_owned(), place);
    if unquoted {
        let key = key.trim();
        return problem.help(format!(
            "to the left of `=` a name with other letters than A to Z stands in quotes: \"{key}\" \
                = …"
        ));
    }
    problem.help(
        "the file must be TOML: names = values, texts and expressions in quotes, tables as [name]",
    )
}

/// Start of the line that contains a position.
fn line_start(text: &str, position: usize) -> usize {
    text[..position].rfind('\n').map_or(0, |end| end + 1)
}

/// Reports a key that a table contains twice, or a table that the file contains twice.
fn duplicate_key(place: Range<usize>, text: &str) -> Problem {
    let plain = |key: &str| key.trim().trim_matches(['"', '\'']).to_owned();
    // The name of a table in the line of its header.
    let header = |line: &str| {
        let (name, _) = line.trim_start().strip_prefix('[')?.split_once(']')?;
        Some(name.trim().to_owned())
    };
    let key = plain(&text[place.clone()]);
    let start = line_start(text, place.start);
    if let Some(name) = text[start..].lines().next().and_then(header) {
        return Problem::new(
            format!("the table [{name}] stands twice in the file"),
            place,
        )
        .label("here again")
        .help("write the entries of both below one header, and remove the other");
    }
    let before = text[..start].split_inclusive('\n').scan(0, |end, line| {
        let begin = *end;
        *end += line.len();
        Some((begin, line))
    });
    // The lines of the table, from its header on.
    let (mut table, mut lines) = (None, Vec::new());
    for (begin, line) in before {
        match header(line) {
            Some(name) => (table, lines) = (Some(name), Vec::new()),
            None => lines.push((begin, line)),
        }
    }
    let is_inline = text[start..place.start].contains('=');
    let first = lines.into_iter().find_map(|(begin, line)| {
        let (name, _) = line.split_once('=')?;
        (plain(name) == key && !is_inline).then(|| begin..begin + name.trim_end().len())
    });
    let kind = match table.as_deref() {
        _ if is_inline => "entry",
        Some("states" | "discrete" | "field" | "start" | "ranges") => "state",
        Some("parameters") => "parameter",
        Some("definitions") => "definition",
        _ => "entry",
    };
    let table = table.map_or_else(
        || "the head of the file".to_owned(),
        |name| format!("[{name}]"),
    );
    let problem = Problem::new(format!("the {kind} `{key}` stands twice in {table}"), place)
        .label("here again")
        .help("remove one of the two, or give one of them another name");
    match first {
        Some(first) => problem.also(first, "here first"),
        None => problem,
    }
}

fn text(table: &Table<'_>, name: &str) -> Result<Option<String>, Problem> {
    let entry = table.get(name);
    entry
        .map(|entry| entry.text().map(|text| text.trim().to_owned()))
        .transpose()
}

fn time(file: &Table<'_>) -> Result<Time, Problem> {
    let Some(table) = file.table("time")? else {
        return Ok(Time::default());
    };
    table.only(&["unit", "start", "end", "period"])?;
    let formula = |name: &str| table.get(name).map(Entry::formula).transpose();
    Ok(Time {
        unit: text(&table, "unit")?,
        start: formula("start")?,
        end: formula("end")?,
        period: formula("period")?,
    })
}

fn states(file: &Table<'_>, names: &mut Names) -> Result<Vec<StateEntry>, Problem> {
    let example = "[states] with the name and the unit of each, as in x = \"m\"";
    let table = file.need("states", example)?.table("", "states")?;
    let mut states = Vec::new();
    for (number, (name, place, entry)) in table.entries().enumerate() {
        if number == MOST_STATES {
            let message = format!("this is state number {}", number + 1);
            return Err(Problem::new(message, place).help(format!(
                "a file can have {MOST_STATES} states; a larger system can be written in Rust with \
                    the library"
            )));
        }
        let name = names.add(name, place, Meaning::State(number))?;
        let mut state = StateEntry {
            name,
            unit: String::new(),
            meaning: None,
            start: None,
            range: None,
            atol: None,
            is_discrete: false,
        };
        match entry.as_table(&format!("states.{}", state.name)) {
            Some(table) => {
                table.only(&["unit", "meaning", "atol"])?;
                state.unit = text(&table, "unit")?.unwrap_or_default();
                state.meaning = text(&table, "meaning")?;
                state.atol = table.get("atol").map(tolerance).transpose()?;
            }
            None => state.unit = entry.text()?.to_owned(),
        }
        states.push(state);
    }
    if states.is_empty() {
        return Err(
            Problem::new("[states] is empty", table.place).help(format!("it needs {example}"))
        );
    }
    Ok(states)
}

/// An absolute tolerance: a number, or an expression of numbers.
fn tolerance(entry: Entry<'_>) -> Result<f64, Problem> {
    let value = super::build::value(&entry.formula()?)?;
    match Options::tol(1e-12).atol(value).check() {
        Ok(()) => Ok(value),
        Err(error) => Err(Problem::new(error.to_string(), entry.place())),
    }
}

fn parameters(file: &Table<'_>, names: &mut Names) -> Result<Vec<Parameter>, Problem> {
    file.each("parameters", |number, name, place, entry| {
        let name = names.add(name, place.clone(), Meaning::Parameter(number))?;
        let mut parameter = Parameter {
            value: 0.0,
            unit: String::new(),
            meaning: None,
            range: None,
            place,
            name,
        };
        let mut given = entry;
        if let Some(table) = entry.as_table(&format!("parameters.{}", parameter.name)) {
            table.only(&["value", "unit", "range", "meaning"])?;
            given = table.need("value", "a number, or an expression of numbers")?;
            parameter.unit = text(&table, "unit")?.unwrap_or_default();
            parameter.meaning = text(&table, "meaning")?;
            parameter.range = table
                .get("range")
                .map(|range| range.interval(true))
                .transpose()?;
        }
        parameter.place = given.place();
        // An expression of constants only: parameters are set one by one.
        parameter.value = super::build::value(&given.formula()?)?;
        if let Some((low, high)) = parameter.range
            && !(low..=high).contains(&parameter.value)
        {
            let message = format!(
                "{} = {} lies outside its range from {low} to {high}",
                parameter.name, parameter.value
            );
            return Err(Problem::new(message, parameter.place));
        }
        Ok(parameter)
    })
}

fn definitions(file: &Table<'_>, names: &mut Names) -> Result<Vec<Named>, Problem> {
    file.each("definitions", |number, name, place, entry| {
        Ok(Named {
            name: names.add(name, place, Meaning::Definition(number))?,
            formula: entry.formula()?,
        })
    })
}

fn contacts(file: &Table<'_>, names: &mut Names) -> Result<Vec<Contact>, Problem> {
    // A system without contacts is smooth.
    file.each("contacts", |number, name, place, entry| {
        if number == MOST_CONTACTS {
            let message = format!("this is contact number {}", number + 1);
            return Err(Problem::new(message, place).help(format!(
                "a file can have {MOST_CONTACTS} contacts; a larger system can be written in Rust \
                    with the library"
            )));
        }
        let name = names.add(name, place.clone(), Meaning::Contact(number))?;
        let table = entry.table("contacts", &name)?;
        table.only(&["boundary", "friction", "static", "normal_force"])?;
        let formula = |name: &str| table.get(name).map(Entry::formula).transpose();
        let boundary =
            "an expression that is zero where the contact can stick, as in boundary = \"v - vp\"";
        let contact = Contact {
            boundary: table.need("boundary", boundary)?.formula()?,
            friction: formula("friction")?,
            holding: formula("static")?,
            normal_force: formula("normal_force")?,
            name,
            place,
        };
        if let (Some(holding), None) = (&contact.holding, &contact.friction) {
            let message = format!(
                "contact `{}` has static friction but no friction in slip",
                contact.name
            );
            return Err(Problem::new(message, holding.whole()).help(format!(
                "write friction = \"…\" beside it, and friction({}) in [field]",
                contact.name
            )));
        }
        if contact.friction.is_some() {
            names.add_part(&contact.name, "force", Meaning::Friction(number));
        }
        Ok(contact)
    })
}

fn field(
    file: &Table<'_>,
    (states, names): (&[StateEntry], &Names),
    contacts: usize,
) -> Result<Vec<Rate>, Problem> {
    let example = "[field] with the rate of every state, as in x = \"v\"";
    let table = file.need("field", example)?.table("", "field")?;
    let rows = by_state(&table, states, names)?;
    let rows = states.iter().zip(rows).map(|(state, entry)| {
        let Some(entry) = entry else {
            let message = format!("[field] has no rate of the state `{}`", state.name);
            return Err(Problem::new(message, table.place.clone()).help(format!(
                "add {} = \"…\", its derivative by time",
                state.name
            )));
        };
        let Some(sides) = entry.as_table(&format!("field.{}", state.name)) else {
            return entry.formula().map(Rate::Same);
        };
        if contacts != 1 {
            let message = format!("with {contacts} contacts it is not clear whose sides these are");
            return Err(Problem::new(message, entry.place())
                .help("name the contact: by_side(contact, below, above)"));
        }
        sides.only(&["below", "above"])?;
        let side = |name: &str| sides.need(name, "the rate on that side")?.formula();
        Ok(Rate::BySide {
            below: side("below")?,
            above: side("above")?,
        })
    });
    rows.collect()
}

/// The entries of a table whose keys are states, in the order of the states.
pub(super) fn by_state<'a>(
    table: &Table<'a>,
    states: &[StateEntry],
    names: &Names,
) -> Result<Vec<Option<Entry<'a>>>, Problem> {
    let mut rows = vec![None; states.len()];
    for (name, place, entry) in table.entries() {
        let known = || states.iter().map(|state| state.name.as_str());
        match known().position(|state| state == normal(name)) {
            Some(number) => rows[number] = Some(entry),
            None => {
                let all: Vec<&str> = known().collect();
                let all = format!("the states are {}", listed(&all));
                let (message, help) = match names.get(name) {
                    // States that are missing here are discrete.
                    Some(Meaning::State(_)) => (
                        format!("`{name}` is a discrete state and stands in [discrete] alone"),
                        "it changes by jumps only, and [discrete] has its start".to_owned(),
                    ),
                    Some(meaning) => (
                        format!("`{name}` is {}, not a state", meaning.description()),
                        all,
                    ),
                    None => (
                        format!("there is no state `{name}`"),
                        did_you_mean(name, known()).unwrap_or(all),
                    ),
                };
                return Err(Problem::new(message, place).help(help));
            }
        }
    }
    Ok(rows)
}

/// The starts of the states, and of the discrete state of a stop as in `floor.closed = 1`.
fn start(
    file: &Table<'_>,
    (states, discrete): (&mut [StateEntry], &mut [StateEntry]),
    names: &Names,
) -> Result<(), Problem> {
    let Some(mut table) = file.table("start")? else {
        return Ok(());
    };
    let is_stop = |name: &str| matches!(names.get(name), Some(Meaning::Stop(_)));
    for (name, _, entry) in table.take(|name| is_stop(name.split('.').next().unwrap_or(name))) {
        let (whole, carries) = match entry.as_table(&format!("start.{name}")) {
            Some(part) => {
                part.only(&["closed"])?;
                let carries = part.need("closed", "1 where the stop carries at the start, or 0")?;
                (format!("{name}.closed"), carries)
            }
            None => (name.to_owned(), entry),
        };
        let stop = name.split('.').next().unwrap_or(name);
        let whole = normal(&whole);
        let help = format!(
            "a start with zero gap and rate is carried at once; {stop}.closed = 1 begins on the \
             stop"
        );
        let Some(place) = discrete.iter().position(|state| state.name == whole) else {
            let message = format!("there is no state `{name}`; `{stop}` is a stop");
            return Err(Problem::new(message, carries.place()).help(help));
        };
        let value = carries.finite().map_err(|wrong| wrong.help(help.clone()))?;
        if ![0.0, 1.0].contains(&value) {
            let message = format!("`{whole}` is 0, or 1 where the stop carries, and not {value}");
            return Err(Problem::new(message, carries.place()).help(help));
        }
        discrete[place].start = Some(Formula::number(value, carries.place()));
    }
    let rows = by_state(&table, states, names)?;
    for (state, entry) in states.iter_mut().zip(rows) {
        let Some(entry) = entry else {
            let message = format!("[start] has no value of the state `{}`", state.name);
            return Err(Problem::new(message, table.place).help(format!("add {} = 0", state.name)));
        };
        state.start = Some(entry.formula()?);
    }
    Ok(())
}

fn ranges(file: &Table<'_>, states: &mut [StateEntry], names: &Names) -> Result<(), Problem> {
    let Some(table) = file.table("ranges")? else {
        return Ok(());
    };
    let rows = by_state(&table, states, names)?;
    for (state, entry) in states.iter_mut().zip(rows) {
        state.range = entry.map(|entry| entry.interval(false)).transpose()?;
    }
    Ok(())
}

fn section(file: &Table<'_>) -> Result<Option<SectionEntry>, Problem> {
    let Some(table) = file.table("section")? else {
        return Ok(None);
    };
    table.only(&["function", "direction"])?;
    let function = table
        .need("function", "an expression that is zero on the section")?
        .formula()?;
    Ok(Some(SectionEntry {
        function,
        direction: direction(table.get("direction"))?,
    }))
}

/// The direction of a sign change.
pub(super) fn direction(entry: Option<Entry<'_>>) -> Result<Direction, Problem> {
    let Some(entry) = entry else {
        return Ok(Direction::Both);
    };
    match entry.text()? {
        "rising" => Ok(Direction::Rising),
        "falling" => Ok(Direction::Falling),
        "both" => Ok(Direction::Both),
        other => {
            let known = ["rising", "falling", "both"];
            let help = did_you_mean(other, known)
                .unwrap_or_else(|| format!("it can be {}", listed(&known)));
            let message = format!("there is no direction `{other}`");
            Err(Problem::new(message, entry.place()).help(help))
        }
    }
}
