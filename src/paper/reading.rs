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
    /// The event-exact solver with the two defects of the paper's program that outlast a vanishing step.
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
        match self {
            Reading::Exact => "exact",
            Reading::Corrected => "corrected",
            Reading::CorrectedEquations => "corrected/equations",
            Reading::CorrectedData => "corrected/data",
            Reading::AsPrinted => "as-printed",
            Reading::AsPrintedEquations => "as-printed/equations",
            Reading::SlipTimesThree => "slip-times-three",
            Reading::BestOfReadings => "best-of-readings",
        }
    }

    /// What it is, for a reader of the tables.
    pub const fn meaning(self) -> &'static str {
        match self {
            Reading::Exact => "the model as stated, solved accurately",
            Reading::Corrected => {
                "the model with the corrections that are listed, solved accurately"
            }
            Reading::CorrectedEquations => "of that, exponents from the equations",
            Reading::CorrectedData => {
                "of that, exponents from the sampled motion by Eqs. (25), (26)"
            }
            Reading::AsPrinted => "the paper's program or equations to the letter",
            Reading::AsPrintedEquations => "exponents of the equations to the letter",
            Reading::SlipTimesThree => {
                "the accurate solver with the two defects of the program that outlast a vanishing step"
            }
            Reading::BestOfReadings => {
                "the nearest of the search's estimator settings for the corrected equations, radii in units of the spread"
            }
        }
    }

    /// What it stands for in a verdict.
    pub const fn role(self) -> Role {
        match self {
            Reading::Exact => Role::Stated,
            Reading::Corrected | Reading::CorrectedEquations | Reading::CorrectedData => {
                Role::Corrected
            }
            Reading::AsPrinted | Reading::AsPrintedEquations => Role::AsPrinted,
            Reading::SlipTimesThree | Reading::BestOfReadings => Role::Beside,
        }
    }
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
