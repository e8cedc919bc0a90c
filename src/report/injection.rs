//! The two defects that survive the listing's limit, put into the event-exact solver.

use crate::numbers::missing;
use crate::paper::pattern::Pattern;
use crate::paper::slip_times_three::{Injected, settled};
use stickslip::error::Error;

/// The settled motions with the defects injected.
#[derive(Clone, Debug, PartialEq)]
pub struct Injection {
    /// With both.
    pub both: Pattern,
    /// Its lengths of the two stick phases (m), then their durations (s).
    pub numbers: [f64; 4],
    /// With the hastened slip alone, or the error that the run ends with.
    pub slip_alone: Result<Pattern, Error>,
    /// With the one-sided exit alone.
    pub exit_alone: Result<Pattern, Error>,
}

impl Injection {
    /// Runs all three.
    ///
    /// # Errors
    /// Those of [`settled`] with both defects; [`Error::NotFound`] if no two stick phases are left.
    pub fn compute() -> Result<Injection, Error> {
        let both = settled(Injected::BOTH)?;
        let numbers = both.four_numbers();
        let numbers = numbers.ok_or_else(|| missing("a pair of stick phases", 0.0, both.end))?;
        Ok(Injection {
            both,
            numbers,
            slip_alone: settled(Injected::SLIP_ALONE),
            exit_alone: settled(Injected::EXIT_ALONE),
        })
    }

    /// What either defect does alone, in words.
    pub fn alone(&self) -> String {
        let of = |run: &Result<Pattern, Error>| match run {
            Ok(pattern) => format!(
                "stick phases: {}, period {}",
                pattern.sticks_of_one().count(),
                pattern.period
            ),
            Err(error) => format!("no settled motion: {error}"),
        };
        format!(
            "Of the two alone: slip three times too fast, {}; exit tested at one end, {}.",
            of(&self.slip_alone),
            of(&self.exit_alone)
        )
    }
}
