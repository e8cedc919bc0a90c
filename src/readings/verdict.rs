//! What came of an orbit, as the table has it.

use std::fmt;
use std::str::FromStr;

use stickslip::analysis::motion::{Class, UnknownClass};

/// The captioned classes of Figs. 10–12.
const PUBLISHED: [Class; 3] = [Class::Periodic(2), Class::QuasiPeriodic, Class::Chaotic];

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
    /// Whether it is the class that the caption of figure 10, 11 or 12 (0, 1, 2) names, loops and
    /// all.
    pub fn is_published(self, figure: usize) -> bool {
        self == Verdict::Motion(PUBLISHED[figure])
    }

    /// Whether it is of that kind: periodic with any number of loops passes for Fig. 10's
    /// "two-periodic". The search ranks by kind.
    pub fn is_of_kind(self, figure: usize) -> bool {
        match (self, PUBLISHED[figure]) {
            (Verdict::Motion(Class::Periodic(_)), Class::Periodic(_)) => true,
            _ => self.is_published(figure),
        }
    }

    /// Whether the orbit stayed.
    pub fn stays(self) -> bool {
        matches!(self, Verdict::Motion(_))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::claim_id::SpectrumFigure;
    use crate::paper::published::Claims;

    #[test]
    fn the_classes_are_those_of_the_table_of_claims() {
        let claims = Claims::committed().unwrap();
        for (class, figure) in PUBLISHED.iter().zip(SpectrumFigure::ALL) {
            assert_eq!(class.to_string(), claims.of(figure.class()).published);
        }
    }

    #[test]
    fn loops_count_for_the_class_and_not_for_the_kind() {
        let one_loop: Verdict = "periodic".parse().unwrap();
        assert!(one_loop.is_of_kind(0) && !one_loop.is_published(0));
        assert!(!one_loop.is_of_kind(1) && one_loop.stays());
        assert!(!Verdict::Escaped.stays());
    }
}
