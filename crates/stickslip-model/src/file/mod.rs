//! Systems as files: the format of `system.toml`.
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
//! friction = "mu0/(1 + slip)"    # its size in slip; friction(belt) is belt times that
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
//! Friction is written by side and not by the sign of a velocity, so that the formula of each side
//! extends smoothly across Σ. `static`, beside `friction`, is the largest friction force while the
//! contact holds. If the sides differ in more than friction, `by_side(belt, below, above)` selects
//! an expression, and so does `v = { below = "…", above = "…" }` in `[field]`.
//!
//! `[jumps.NAME]` describes a jump of the state. `when` is the function whose zero triggers it,
//! `direction` the sign change that counts (`rising`, `falling`, `both`), and `set` gives the new
//! states. With `stop = true`, or `count = n`, the run ends there, or with the n-th jump. With
//! `if`, a condition, nothing happens where it does not hold.
//! `[discrete]` lists states that change only in jumps, each with its start.
//!
//! `[stops.NAME]` describes a stop, whose `gap` is positive in flight. `acts` is what a unit of its
//! reaction adds to the rates of states. `restitution` is the part of the approach speed that an
//! impact gives back. `NAME.force` is the reaction, and the discrete state `NAME.closed` is 1 while
//! the stop carries. It is 0 at the start, unless `[start]` has `NAME.closed = 1`.
//!
//! `[inputs.NAME]` describes a function of time alone by its `shape`. The shapes `square`,
//! `triangle`, `sawtooth` and `pulse` have a `period`, and a `phase` in fractions of it; a pulse
//! has a `width`. The shape `table` has `times` and `values`, or a `file`, and `between`.
//! `[switches.NAME]` is the sign of a `function` of time.
//!
//! `[curves.NAME]` describes a function of one argument by its `points`, or a `file`. It is linear
//! or monotone `between` them. `beyond` them its ends hold, go on (`extend`) or are an `error`.

mod build;
mod builder;
mod curves;
mod error_text;
mod formula;
mod formulas;
mod names;
mod notation;
mod observe;
mod problem;
mod reactions;
mod read;
mod stops;
mod switching;
mod system;
mod table;
mod template;
mod undefined;

pub use build::Built;
pub use builder::MOST_FREE;
pub use error_text::Interface;
pub use formula::Formula;
pub use names::{Meaning, Names, did_you_mean};
pub use observe::{FreeStarts, Observed};
pub use problem::{Problem, Source};
pub use reactions::Quantities;
pub use switching::table_points;
pub use system::{PeriodError, SettingError, System};

use template::Checked;

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use stickslip::Direction;

use crate::expression::PiecewisePolynomial;
use crate::kernel::InputPiece;

/// The models that come with the crate: names and files, in the order of listing.
const SHIPPED: [(&str, &str); 6] = [
    ("belt", include_str!("../../systems/belt.toml")),
    ("forced", include_str!("../../systems/forced.toml")),
    ("bracket", include_str!("../../systems/bracket.toml")),
    ("leine", include_str!("../../systems/leine.toml")),
    ("basins", include_str!("../../systems/basins.toml")),
    ("den-hartog", include_str!("../../systems/den-hartog.toml")),
];

/// A template, with a comment on every possible entry.
pub const EXAMPLE: &str = include_str!("../../systems/example.toml");

/// The content of a file, with all names checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SystemFile {
    /// The source file.
    pub source: Source,
    /// Name of the system.
    pub name: String,
    /// Description.
    pub description: Option<String>,
    /// The time settings.
    pub time: Time,
    /// Components of the state, in their order.
    pub states: Vec<StateEntry>,
    /// Parameters.
    pub parameters: Vec<Parameter>,
    /// Named parts.
    pub definitions: Vec<Named>,
    /// Contacts.
    pub contacts: Vec<Contact>,
    /// Jumps, in the order of execution if several happen at one time.
    pub jumps: Vec<JumpEntry>,
    /// Stops. The events of each are the last of the jumps.
    pub stops: Vec<StopEntry>,
    /// Inputs that depend on time alone.
    pub inputs: Vec<InputEntry>,
    /// Functions of one argument through points.
    pub curves: Vec<CurveEntry>,
    /// Rates of the states, in their order.
    pub field: Vec<Rate>,
    /// Poincaré sections; a file gives one at most.
    pub sections: Vec<SectionEntry>,
    /// The meaning of every name.
    pub names: Names,
    /// Whether time runs backwards: rates have the other sign, and `t` in formulas is its negative.
    pub is_reversed: bool,
    checked: Checked,
}

/// The settings in `[time]` and `[start]` that concern time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Time {
    /// Unit of time.
    pub unit: Option<String>,
    /// Start time of runs; 0 by default.
    pub start: Option<Formula>,
    /// Default end time of runs.
    pub end: Option<Formula>,
    /// Period in time of a driven system.
    pub period: Option<Formula>,
}

/// A component of the state.
#[derive(Clone, Debug, PartialEq)]
pub struct StateEntry {
    /// Name.
    pub name: String,
    /// Unit, empty where there is none.
    pub unit: String,
    /// Description.
    pub meaning: Option<String>,
    /// Initial value.
    pub start: Option<Formula>,
    /// The range that figures and scans show.
    pub range: Option<(f64, f64)>,
    /// Absolute tolerance of runs, unless they are given another.
    pub atol: Option<f64>,
    /// Whether it changes only in jumps.
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
    /// Description.
    pub meaning: Option<String>,
    /// Allowed values.
    pub range: Option<(f64, f64)>,
    /// Position of the value.
    pub place: Range<usize>,
}

/// A named subexpression.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Name.
    pub name: String,
    /// The expression.
    pub formula: Formula,
}

/// A contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Name.
    pub name: String,
    /// The boundary function.
    pub boundary: Formula,
    /// Magnitude of friction in slip.
    pub friction: Option<Formula>,
    /// Largest friction force while the contact holds, if it differs.
    pub holding: Option<Formula>,
    /// The normal force, if contact can be lost. Friction is zero where it is not positive.
    pub normal_force: Option<Formula>,
    /// Position in the file.
    pub place: Range<usize>,
}

/// A jump: the state is mapped where a function passes through zero.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpEntry {
    /// Name.
    pub name: String,
    /// The function.
    pub when: Formula,
    /// The sign change that counts.
    pub direction: Direction,
    /// The condition, judged at the zero on the state before the jump; nothing happens where it
    /// does not hold.
    pub condition: Option<Formula>,
    /// The new states; states without a formula stay.
    pub set: Vec<Option<Formula>>,
    /// The run ends with this jump of the count.
    pub most: Option<u64>,
    /// The stop that it is an event of, and which one.
    pub of_stop: Option<(usize, StopEvent)>,
    /// Position in the file.
    pub place: Range<usize>,
}

/// A stop: a unilateral constraint of relative degree two with Newton's law of restitution.
#[derive(Clone, Debug, PartialEq)]
pub struct StopEntry {
    /// Name.
    pub name: String,
    /// The gap, positive in flight.
    pub gap: Formula,
    /// Part of a unit of the reaction in the rate of each state.
    pub acts: Vec<Option<Formula>>,
    /// Part of the approach speed that an impact gives back. `approach` in it is that speed.
    pub restitution: Formula,
    /// The discrete state that is 1 while the stop carries, else 0.
    pub closed: usize,
    /// Position in the file.
    pub place: Range<usize>,
}

/// The events of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopEvent {
    /// The gap closes.
    Impact,
    /// The reaction vanishes.
    LiftOff,
    /// Impacts have accumulated.
    Landing,
}

/// A function of one argument through points.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveEntry {
    /// Name.
    pub name: String,
    /// The function.
    pub curve: Arc<PiecewisePolynomial>,
    /// First argument and last one of the points.
    pub range: (f64, f64),
    /// Number of points.
    pub points: usize,
}

/// An input that depends on time alone.
#[derive(Clone, Debug, PartialEq)]
pub struct InputEntry {
    /// Name.
    pub name: String,
    /// Shape of the input.
    pub shape: InputShape,
    /// Position in the file.
    pub place: Range<usize>,
}

/// The shapes of inputs.
#[derive(Clone, Debug, PartialEq)]
pub enum InputShape {
    /// Periodic in time.
    Periodic {
        /// Name of the shape.
        shape: String,
        /// The pieces over one period, in fractions of it. Those of a pulse follow from its width.
        pieces: Vec<InputPiece>,
        /// The fraction of the period in which a pulse is 1.
        width: Option<Box<Formula>>,
        /// The period.
        period: Formula,
        /// The phase at time 0, as a fraction of the period; 0 by default.
        phase: Option<Box<Formula>>,
    },
    /// Interpolation of points in time.
    Table {
        /// The pieces, the first of which has no begin.
        pieces: Vec<InputPiece>,
        /// Whether a line joins two points; else the value of the first lasts.
        is_linear: bool,
    },
    /// The sign of a function of time.
    Switch(Formula),
}

/// The rate of a state.
#[derive(Clone, Debug, PartialEq)]
pub enum Rate {
    /// One expression for both sides.
    Same(Formula),
    /// An expression for each side of the only contact.
    BySide {
        /// Formula below the boundary.
        below: Formula,
        /// Formula above the boundary.
        above: Formula,
    },
}

impl Rate {
    /// The expression above or below the boundary of the only contact.
    pub(crate) fn on_side(&self, is_above: bool) -> &Formula {
        match self {
            Rate::Same(formula) => formula,
            Rate::BySide { above, .. } if is_above => above,
            Rate::BySide { below, .. } => below,
        }
    }
}

/// A Poincaré section.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionEntry {
    /// The function that vanishes on it.
    pub function: Formula,
    /// The direction of the crossings.
    pub direction: Direction,
}

/// Reason for which a file cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
pub enum FileError {
    /// The file cannot be read.
    #[error(
        "cannot read {path}: {cause}; {meant}give the path of a system's file or the name of a \
            shipped model ({shipped})"
    )]
    Unreadable {
        /// The path as given.
        path: String,
        /// The operating system's message.
        cause: String,
        /// The shipped model that may have been meant, as a question; empty if there is none.
        meant: String,
        /// Names of the shipped models.
        shipped: String,
    },
    /// The file is not UTF-8.
    #[error("{path} is no text in UTF-8: line {line} has other bytes; save it as UTF-8")]
    NotUtf8 {
        /// The path as given.
        path: String,
        /// The first line that is not UTF-8.
        line: usize,
    },
    /// The content is invalid.
    #[error("{}", problem.shown(source_text))]
    Wrong {
        /// The fault and its position.
        problem: Box<Problem>,
        /// The file.
        source_text: Box<Source>,
    },
}

/// The value of an expression of constants, such as on a command line.
///
/// # Errors
/// A message about the fault.
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
    // If a file of that name exists, it is the one that is meant.
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

impl FileError {
    fn wrong(problem: Problem, source: Source) -> Self {
        FileError::Wrong {
            problem: Box::new(problem),
            source_text: Box::new(source),
        }
    }
}

/// The content of a file, if every expression in it is valid.
fn checked(file: SystemFile) -> Result<SystemFile, Problem> {
    let file = Arc::new(file);
    let checked = Checked::of(build::check(&file)?);
    Ok(SystemFile {
        checked,
        ..Arc::unwrap_or_clone(file)
    })
}

impl SystemFile {
    /// Reads a file, or a shipped model by name. A file of that name takes precedence.
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

    /// Parses a text.
    ///
    /// # Errors
    /// [`FileError::Wrong`] with the first fault.
    pub fn parse(source: Source) -> Result<SystemFile, FileError> {
        let read = read::read(&source).and_then(checked);
        read.map_err(|problem| FileError::wrong(problem, source))
    }
}
