//! The meaning of names, and suggestions for unknown ones.

use std::collections::HashMap;
use std::ops::Range;

use super::problem::Problem;
use crate::expression::{FUNCTIONS, begins_name, is_in_name, normal};

/// The meaning of a name. Numbers count the entries of each kind from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Time.
    Time,
    /// π.
    Pi,
    /// A component of the state.
    State(usize),
    /// A parameter.
    Parameter(usize),
    /// A definition.
    Definition(usize),
    /// A contact: the sign of its side.
    Contact(usize),
    /// An input, or a switch of time.
    Input(usize),
    /// A curve, which is a function.
    Curve(usize),
    /// A jump.
    Jump(usize),
    /// A stop.
    Stop(usize),
    /// The force of a stop.
    Force(usize),
    /// The friction force of a contact.
    Friction(usize),
}

impl Meaning {
    pub(super) fn description(self) -> &'static str {
        match self {
            Meaning::Time => "time",
            Meaning::Pi => "the number π",
            Meaning::State(_) => "a state",
            Meaning::Parameter(_) => "a parameter",
            Meaning::Definition(_) => "a definition",
            Meaning::Contact(_) => "a contact",
            Meaning::Input(_) => "an input",
            Meaning::Curve(_) => "a curve",
            Meaning::Jump(_) => "a jump",
            Meaning::Stop(_) => "a stop",
            Meaning::Force(_) => "the force of a stop",
            Meaning::Friction(_) => "the friction force of a contact",
        }
    }
}

/// Functions that are not among [`FUNCTIONS`].
pub(super) const FURTHER_FUNCTIONS: [&str; 4] = ["min", "max", "friction", "by_side"];

/// Words that join conditions.
const CONDITION_WORDS: [&str; 3] = ["and", "or", "not"];

/// The names of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    known: HashMap<String, (Meaning, Range<usize>)>,
}

impl Names {
    /// The names of constants.
    pub(super) fn constants() -> Self {
        let mut names = Names::default();
        names.build_in("pi", Meaning::Pi);
        names.build_in("π", Meaning::Pi);
        names
    }

    /// The built-in names.
    pub(super) fn new() -> Self {
        let mut names = Names::constants();
        names.build_in("t", Meaning::Time);
        names
    }

    fn build_in(&mut self, name: &str, meaning: Meaning) {
        self.known.insert(name.to_owned(), (meaning, 0..0));
    }

    /// Adds a name, in the form used for comparison.
    pub(super) fn add(
        &mut self,
        name: &str,
        place: Range<usize>,
        meaning: Meaning,
    ) -> Result<String, Problem> {
        let mut characters = name.chars();
        let good = characters.next().is_some_and(begins_name) && characters.all(is_in_name);
        if !good {
            return Err(
                Problem::new(format!("`{name}` cannot be a name in an expression"), place)
                    .help("a name is letters, digits and `_`, and does not begin with a digit"),
            );
        }
        let name = normal(name);
        if is_function(&name) {
            return Err(
                Problem::new(format!("`{name}` is a function already"), place)
                    .help("choose another name"),
            );
        }
        if CONDITION_WORDS.contains(&&*name) {
            let message = format!("`{name}` is a word of conditions already");
            return Err(Problem::new(message, place).help("choose another name"));
        }
        match self.known.get(&name) {
            None => {
                self.known.insert(name.clone(), (meaning, place));
                Ok(name)
            }
            Some((known, first)) if first.is_empty() => {
                let message = format!("`{name}` is the name of {} already", known.description());
                Err(Problem::new(message, place).help("choose another name"))
            }
            Some((known, first)) => {
                let message = format!("`{name}` is the name of {} already", known.description());
                Err(Problem::new(message, place)
                    .label("here again")
                    .also(
                        first.clone(),
                        format!("{} of this name", known.description()),
                    )
                    .help("in expressions all names are together; choose another one"))
            }
        }
    }

    /// Adds the name of a part of an entry, such as `floor.force`.
    pub(super) fn add_part(&mut self, entry: &str, part: &str, meaning: Meaning) -> String {
        let name = format!("{entry}.{part}");
        self.known.insert(name.clone(), (meaning, 0..0));
        name
    }

    /// The meaning of a name.
    pub fn get(&self, name: &str) -> Option<Meaning> {
        self.known.get(&normal(name)).map(|&(meaning, _)| meaning)
    }

    /// A known name similar to it.
    pub(super) fn like(&self, name: &str) -> Option<String> {
        let mut known: Vec<&str> = self.known.keys().map(String::as_str).collect();
        known.sort_unstable();
        did_you_mean(name, known)
    }
}

/// Functions whose names may be those of states and others, too: files had such names before.
pub(super) const LATER_FUNCTIONS: [&str; 8] = [
    "asin", "acos", "atan2", "erf", "log10", "hypot", "clamp", "if",
];

pub(super) fn is_function(name: &str) -> bool {
    let plain = FUNCTIONS.iter().map(|(name, _)| *name);
    plain.chain(FURTHER_FUNCTIONS).any(|known| known == name)
}

/// A "did you mean" question, if a known name is similar.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    // Names are often written without underscores, or in another case.
    let plain = |name: &str| name.replace('_', "").to_lowercase();
    let likeness = |other: &str| {
        let as_written = strsim::jaro_winkler(name, other);
        as_written.max(strsim::jaro_winkler(&plain(name), &plain(other)))
    };
    let rated = known.into_iter().map(|other| (likeness(other), other));
    let best = rated.reduce(|best, other| if other.0 > best.0 { other } else { best })?;
    (best.0 > 0.75).then(|| format!("did you mean `{}`?", best.1))
}
