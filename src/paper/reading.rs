//! Readings: the interpretation of the paper that a computed value belongs to.

use std::fmt;

use crate::text::described;

described! {
    /// A reading of the paper, as it stands in the column `reading` of every table.
    Reading: (&'static str, &'static str, Role) as described {
        /// The model as stated, solved accurately.
        Exact = (
            "exact",
            "the model as stated, solved accurately",
            Role::Stated,
        ),
        /// The model with the corrections that the claim's entry lists, solved accurately.
        Corrected = (
            "corrected",
            "the model with the corrections that are listed, solved accurately",
            Role::Corrected,
        ),
        /// Corrected equations: Lyapunov exponents from the equations.
        CorrectedEquations = (
            "corrected/equations",
            "the same; exponents from the equations",
            Role::Corrected,
        ),
        /// Corrected equations: Lyapunov exponents from the sampled motion, Eqs. (25) and (26).
        CorrectedData = (
            "corrected/data",
            "the same; exponents from the sampled motion by Eqs. (25), (26)",
            Role::Corrected,
        ),
        /// The paper's program or equations, taken literally.
        AsPrinted = (
            "as-printed",
            "the paper's program or equations, taken literally",
            Role::AsPrinted,
        ),
        /// The equations taken literally: Lyapunov exponents.
        AsPrintedEquations = (
            "as-printed/equations",
            "exponents of the equations, taken literally",
            Role::AsPrinted,
        ),
        /// The event-exact solver with the two defects of the paper's program that remain as the
        /// step goes to zero.
        SlipTimesThree = (
            "slip-times-three",
            "the accurate solver with the two defects of the program that remain as the step goes \
            to zero",
            Role::Supplementary,
        ),
        /// The nearest of the search's settings for the corrected equations, with radii in units of
        /// the spread.
        BestOfReadings = (
            "best-of-readings",
            "the nearest of the search's estimator settings for the corrected equations, radii in \
                units of the spread",
            Role::Supplementary,
        ),
    }
}

/// Role of a reading in a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// The model as stated.
    Stated,
    /// The model with named corrections.
    Corrected,
    /// The paper taken literally.
    AsPrinted,
    /// Shown beside the others; it decides nothing.
    Supplementary,
}

impl Reading {
    /// Name in tables.
    pub const fn name(self) -> &'static str {
        self.described().0
    }

    /// Meaning in words.
    pub const fn meaning(self) -> &'static str {
        self.described().1
    }

    /// Role.
    pub const fn role(self) -> Role {
        self.described().2
    }
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
