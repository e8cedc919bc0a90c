//! How the paper was understood: what a computed value speaks of.

use std::fmt;

/// A reading of the paper, as it stands in the column `reading` of every table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reading {
    /// The model as stated, solved accurately.
    Exact,
    /// The model with the corrections that the claim's entry lists, solved accurately.
    Corrected,
    /// Of that, Lyapunov exponents from the equations.
    CorrectedEquations,
    /// Of that, Lyapunov exponents from the sampled motion, Eqs. (25) and (26).
    CorrectedData,
    /// What the paper's program or equations say to the letter.
    AsPrinted,
    /// Of the equations to the letter, Lyapunov exponents.
    AsPrintedEquations,
    /// The event-exact solver with the two defects of the paper's program that outlast a vanishing
    /// step.
    SlipTimesThree,
    /// The nearest of the search's settings for the corrected equations, radii in units of the
    /// spread.
    BestOfReadings,
}

/// What a reading stands for in a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// The model as stated.
    Stated,
    /// The model with named corrections.
    Corrected,
    /// The letter of the paper.
    AsPrinted,
    /// Shown beside the others; decides nothing.
    Beside,
}

impl Reading {
    /// All of them.
    pub const ALL: [Reading; 8] = [
        Reading::Exact,
        Reading::Corrected,
        Reading::CorrectedEquations,
        Reading::CorrectedData,
        Reading::AsPrinted,
        Reading::AsPrintedEquations,
        Reading::SlipTimesThree,
        Reading::BestOfReadings,
    ];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        self.described().0
    }

    /// What it means.
    pub const fn meaning(self) -> &'static str {
        self.described().1
    }

    /// What it stands for.
    pub const fn role(self) -> Role {
        self.described().2
    }

    const fn described(self) -> (&'static str, &'static str, Role) {
        match self {
            Reading::Exact => (
                "exact",
                "the model as stated, solved accurately",
                Role::Stated,
            ),
            Reading::Corrected => (
                "corrected",
                "the model with the corrections that are listed, solved accurately",
                Role::Corrected,
            ),
            Reading::CorrectedEquations => (
                "corrected/equations",
                "of that, exponents from the equations",
                Role::Corrected,
            ),
            Reading::CorrectedData => (
                "corrected/data",
                "of that, exponents from the sampled motion by Eqs. (25), (26)",
                Role::Corrected,
            ),
            Reading::AsPrinted => (
                "as-printed",
                "the paper's program or equations to the letter",
                Role::AsPrinted,
            ),
            Reading::AsPrintedEquations => (
                "as-printed/equations",
                "exponents of the equations to the letter",
                Role::AsPrinted,
            ),
            Reading::SlipTimesThree => (
                "slip-times-three",
                "the accurate solver with the two defects of the program that outlast a vanishing step",
                Role::Beside,
            ),
            Reading::BestOfReadings => (
                "best-of-readings",
                "the nearest of the search's estimator settings for the corrected equations, radii in units of the spread",
                Role::Beside,
            ),
        }
    }
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
