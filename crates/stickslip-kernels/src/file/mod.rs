//! Systems as files: what a `system.toml` says.
//!
//! ```toml
//! name = "Block on a belt"
//!
//! [states]                       # in this order; units, or "" where there are none
//! x = "m"
//! v = "m/s"
//!
//! [parameters]
//! k = 1
//! mu0 = { value = 0.4, unit = "1", range = [0, 1] }
//! vp = 0.2
//!
//! [definitions]                  # names for parts of what follows
//! slip = "belt*(v - vp)"         # the name of a contact is the sign of its side, here |v - vp|
//!
//! [contacts.belt]
//! boundary = "v - vp"            # belt is -1 where this is negative, +1 where it is positive
//! friction = "mu0/(1 + slip)"    # in slip; friction(belt) is belt times that
//!
//! [field]                        # the rates of the states
//! x = "v"
//! v = "-k*x - friction(belt)"
//!
//! [start]
//! x = 0.5
//! v = 0
//! ```
//!
//! Friction is written by side and not by the sign of a velocity, so that each side's formula goes
//! on smoothly across Σ. `static` beside `friction` is how large it may be while the contact holds.
//! Where the sides differ in more than friction, `by_side(belt, below, above)` is one expression or
//! the other, and so is `v = { below = "…", above = "…" }` in `[field]`.
//!
//! A state jumps where `[jumps.NAME]` says: `when` is the function whose zero it is, `direction`
//! which way that passes (`rising`, `falling`, `both`), `set` what the states become. With `stop =
//! true`, or `count = n`, the run ends there, or with the n-th. `[discrete]` has states that change
//! by jumps only, each with its start. What depends on time alone is `[inputs.NAME]`, with `shape`
//! (`square`, `triangle`, `sawtooth`, `pulse` with `width`; each with `period` and `phase`, in
//! parts of the period; or `table` with `times` and `values`, or a `file`, and `between`), or
//! `[switches.NAME]`, the sign of a `function` of time.

mod build;
mod builder;
mod formula;
mod names;
mod problem;
mod read;
mod switching;
mod system;
mod table;
mod words;

pub use build::Built;
pub use formula::Formula;
pub use names::{Meaning, Names, did_you_mean};
pub use problem::{Problem, Source};
pub use system::{PeriodError, SettingError, System};

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use stickslip::Direction;

use crate::kernel::Piece;

/// The models that come with the crate: names and files, in the order in which they are listed.
const SHIPPED: [(&str, &str); 6] = [
    ("belt", include_str!("../../systems/belt.toml")),
    ("forced", include_str!("../../systems/forced.toml")),
    ("bracket", include_str!("../../systems/bracket.toml")),
    ("leine", include_str!("../../systems/leine.toml")),
    ("basins", include_str!("../../systems/basins.toml")),
    ("den-hartog", include_str!("../../systems/den-hartog.toml")),
];

/// A file to begin with, with a comment on everything that can be in it.
pub const EXAMPLE: &str = include_str!("../../systems/example.toml");

/// What a file says, its names known to be right.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemFile {
    /// The file.
    pub source: Source,
    /// Name of the system.
    pub name: String,
    /// What it is.
    pub description: Option<String>,
    /// About time.
    pub time: Time,
    /// Components of the state, in their order.
    pub states: Vec<StateEntry>,
    /// Parameters.
    pub parameters: Vec<Parameter>,
    /// Named parts.
    pub definitions: Vec<Named>,
    /// Contacts.
    pub contacts: Vec<Contact>,
    /// Jumps, in the order in which they are done where several happen at one time.
    pub jumps: Vec<JumpEntry>,
    /// Inputs that depend on time alone.
    pub inputs: Vec<InputEntry>,
    /// Rates of the states, in their order.
    pub field: Vec<Rate>,
    /// Poincaré section.
    pub section: Option<SectionEntry>,
    /// What every name stands for.
    pub names: Names,
}

/// What `[time]` and `[start]` say of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Time {
    /// Unit of time.
    pub unit: Option<String>,
    /// When runs begin; 0 unless given.
    pub start: Option<Formula>,
    /// When runs end unless told otherwise.
    pub end: Option<Formula>,
    /// Period in time, of a driven system.
    pub period: Option<Formula>,
}

/// A component of the state.
#[derive(Clone, Debug, PartialEq)]
pub struct StateEntry {
    /// Name.
    pub name: String,
    /// Unit, empty where there is none.
    pub unit: String,
    /// What it is, in words.
    pub meaning: Option<String>,
    /// Where runs begin.
    pub start: Option<Formula>,
    /// The part that figures and scans show.
    pub range: Option<(f64, f64)>,
    /// Whether it changes by jumps only.
    pub is_discrete: bool,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit, empty where there is none.
    pub unit: String,
    /// What it is, in words.
    pub meaning: Option<String>,
    /// Values that are allowed.
    pub range: Option<(f64, f64)>,
    /// Where the value stands.
    pub place: Range<usize>,
}

/// A named part of other expressions.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Name.
    pub name: String,
    /// What it stands for.
    pub formula: Formula,
}

/// A contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Name.
    pub name: String,
    /// The boundary function.
    pub boundary: Formula,
    /// How large friction is in slip.
    pub friction: Option<Formula>,
    /// How large friction may be while the contact holds, where that differs.
    pub holding: Option<Formula>,
    /// The normal force, where contact can be lost: friction is zero where it is not positive.
    pub normal_force: Option<Formula>,
    /// Where it stands.
    pub place: Range<usize>,
}

/// A jump: where a function of the state passes through zero the state is mapped.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpEntry {
    /// Name.
    pub name: String,
    /// The function.
    pub when: Formula,
    /// Which way it passes through zero.
    pub direction: Direction,
    /// What the states become; those without a formula stay.
    pub set: Vec<Option<Formula>>,
    /// The run ends with so many.
    pub most: Option<u64>,
    /// Where it stands.
    pub place: Range<usize>,
}

/// An input that depends on time alone.
#[derive(Clone, Debug, PartialEq)]
pub struct InputEntry {
    /// Name.
    pub name: String,
    /// What it is.
    pub shape: InputShape,
    /// Where it stands.
    pub place: Range<usize>,
}

/// What an input is.
#[derive(Clone, Debug, PartialEq)]
pub enum InputShape {
    /// The same again in each period.
    Periodic {
        /// The name of its shape.
        shape: String,
        /// What it is over a period, in parts of it.
        pieces: Vec<Piece>,
        /// The period.
        period: Formula,
        /// The part of the period that has passed at time 0; none unless given.
        phase: Option<Formula>,
    },
    /// Through points in time.
    Table(Vec<Piece>),
    /// The sign of a function of time.
    Switch(Formula),
}

/// The rate of a state.
#[derive(Clone, Debug, PartialEq)]
pub enum Rate {
    /// One expression.
    Same(Formula),
    /// One on each side of the only contact.
    BySide {
        /// Where the boundary function is negative.
        below: Formula,
        /// Where it is positive.
        above: Formula,
    },
}

/// A Poincaré section.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionEntry {
    /// The function that is zero on it.
    pub function: Formula,
    /// Which way it is passed.
    pub direction: Direction,
}

/// A file that cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
pub enum FileError {
    /// It cannot be read.
    #[error(
        "cannot read {path}: {cause}; {meant}give the path of a system's file or the name of a \
            shipped model ({shipped})"
    )]
    Unreadable {
        /// The path as given.
        path: String,
        /// What the operating system said.
        cause: String,
        /// The shipped model that may have been meant, as a question; empty where there is none.
        meant: String,
        /// Names of the shipped models.
        shipped: String,
    },
    /// Its letters are in another code.
    #[error("{path} is no text in UTF-8: line {line} has other bytes; save it as UTF-8")]
    NotUtf8 {
        /// The path as given.
        path: String,
        /// The first line that is not.
        line: usize,
    },
    /// Its content is wrong.
    #[error("{}", problem.shown(source_text))]
    Wrong {
        /// What is wrong, and where.
        problem: Box<Problem>,
        /// The file.
        source_text: Box<Source>,
    },
}

/// The value of an expression of numbers, as on a command line.
///
/// # Errors
/// What is wrong with it.
pub fn number(text: &str) -> Result<f64, String> {
    let source = Source {
        name: String::new(),
        text: text.to_owned(),
    };
    let formula =
        Formula::parsed(text, 0..text.len(), &source).map_err(|problem| problem.message)?;
    build::value(&formula).map_err(|problem| problem.message)
}

fn unreadable(path: &str, cause: &std::io::Error) -> FileError {
    let shipped = SHIPPED.map(|(name, _)| name);
    // Of a file that is there somebody means that file.
    let is_missing = cause.kind() == std::io::ErrorKind::NotFound;
    let meant = is_missing.then(|| did_you_mean(path, shipped.iter().copied()));
    FileError::Unreadable {
        path: path.to_owned(),
        cause: cause.to_string(),
        meant: meant
            .flatten()
            .map_or_else(String::new, |meant| meant + " Or "),
        shipped: shipped.join(", "),
    }
}

fn not_utf8(path: &str, wrong: &std::string::FromUtf8Error) -> FileError {
    let before = wrong
        .as_bytes()
        .iter()
        .take(wrong.utf8_error().valid_up_to());
    FileError::NotUtf8 {
        path: path.to_owned(),
        line: 1 + before.filter(|byte| **byte == b'\n').count(),
    }
}

impl SystemFile {
    /// Reads a file, or a shipped model by its name. A file of that name comes first.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn open(path: &str) -> Result<SystemFile, FileError> {
        let shipped = SHIPPED.iter().find(|(name, _)| *name == path);
        let text = match shipped.filter(|_| !Path::new(path).is_file()) {
            Some((_, text)) => (*text).to_owned(),
            None => {
                let bytes = std::fs::read(path).map_err(|cause| unreadable(path, &cause))?;
                String::from_utf8(bytes).map_err(|wrong| not_utf8(path, &wrong))?
            }
        };
        let name = path.to_owned();
        SystemFile::parse(Source { name, text })
    }

    /// What a text says.
    ///
    /// # Errors
    /// [`FileError::Wrong`] with the first thing that is wrong.
    pub fn parse(source: Source) -> Result<SystemFile, FileError> {
        let read = read::read(&source).and_then(|file| {
            let file = Arc::new(file);
            build::check(&file)?;
            Ok(Arc::unwrap_or_clone(file))
        });
        read.map_err(|problem| FileError::Wrong {
            problem: Box::new(problem),
            source_text: Box::new(source),
        })
    }

    /// The same system with this section in place of its own.
    ///
    /// # Errors
    /// [`FileError::Wrong`] with what is wrong with the function.
    pub fn with_section(
        &self,
        function: &str,
        direction: Direction,
    ) -> Result<SystemFile, FileError> {
        let source = Source {
            name: "section".to_owned(),
            text: function.to_owned(),
        };
        let checked = Formula::parsed(function, 0..function.len(), &source).and_then(|function| {
            let mut file = self.clone();
            file.section = Some(SectionEntry {
                function,
                direction,
            });
            let file = Arc::new(file);
            build::check(&file)?;
            Ok(Arc::unwrap_or_clone(file))
        });
        checked.map_err(|problem| FileError::Wrong {
            problem: Box::new(problem),
            source_text: Box::new(source),
        })
    }
}
