//! What came of an orbit, as the table has it.

use std::fmt;
use std::str::FromStr;

use stickslip::analysis::motion::{Class, UnknownClass};

/// The verdict on an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It stayed; this is the class of its motion.
    Motion(Class),
    /// It left for infinity.
    Escaped,
    /// It could not be followed.
    Failed,
}

impl Verdict {
    /// Whether it is this class, loops and all.
    pub fn is(self, class: Class) -> bool {
        self == Verdict::Motion(class)
    }

    /// Whether it is of the kind that the paper says of figure 10, 11 or 12 (0, 1, 2): periodic with any number of loops passes for Fig.
    /// 10's "two-periodic". The search ranks by kind.
    pub fn is_of_kind(self, figure: usize) -> bool {
        self.kind() == Some(figure)
    }

    /// The figure whose published kind of motion it is.
    pub fn kind(self) -> Option<usize> {
        match self {
            Verdict::Motion(Class::Periodic(_)) => Some(0),
            Verdict::Motion(Class::QuasiPeriodic) => Some(1),
            Verdict::Motion(Class::Chaotic) => Some(2),
            Verdict::Motion(Class::Undecided) | Verdict::Escaped | Verdict::Failed => None,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Verdict::Motion(class) => class.fmt(f),
            Verdict::Escaped => f.write_str("escaped"),
            Verdict::Failed => f.write_str("failed"),
        }
    }
}

impl FromStr for Verdict {
    type Err = UnknownClass;

    fn from_str(text: &str) -> Result<Self, UnknownClass> {
        match text {
            "escaped" => Ok(Verdict::Escaped),
            "failed" => Ok(Verdict::Failed),
            _ => text.parse().map(Verdict::Motion),
        }
    }
}
