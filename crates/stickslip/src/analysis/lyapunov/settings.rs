//! Settings of the measurement and of its report.

use crate::error::{Error, require};
use crate::filippov::Options;

/// Settings of [`super::lyapunov_spectrum`]. Times are in the system's own unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumOptions {
    /// Time run before measuring, with the frame on the orbit; default 200.
    pub transient: f64,
    /// Measured time; default 2000.
    pub duration: f64,
    /// Number of blocks of equal length whose means give the standard errors; default 20. A block
    /// should be long compared with the correlation time of the orbit.
    pub blocks: usize,
    /// Approximate number of points of the running exponents; default 200.
    pub samples: usize,
    /// Settings of the solver.
    pub solver: Options,
}

impl Default for SpectrumOptions {
    fn default() -> Self {
        SpectrumOptions {
            transient: 200.0,
            duration: 2000.0,
            blocks: 20,
            samples: 200,
            solver: Options::default(),
        }
    }
}

impl SpectrumOptions {
    /// The defaults with these times.
    pub fn over(transient: f64, duration: f64) -> Self {
        SpectrumOptions {
            transient,
            duration,
            ..SpectrumOptions::default()
        }
    }

    /// Sets the solver's options.
    #[must_use]
    pub fn solver(self, solver: Options) -> Self {
        SpectrumOptions { solver, ..self }
    }

    /// Sets the number of blocks.
    #[must_use]
    pub fn blocks(self, blocks: usize) -> Self {
        SpectrumOptions { blocks, ..self }
    }

    /// Sets the approximate number of points of the running exponents.
    #[must_use]
    pub fn samples(self, samples: usize) -> Self {
        SpectrumOptions { samples, ..self }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`Error::Option`] with name, value and bound of the first that is not allowed.
    pub fn check(&self) -> Result<(), Error> {
        let transient = self.transient >= 0.0 && self.transient.is_finite();
        require(
            transient,
            "transient",
            self.transient,
            "finite and at least 0",
        )?;
        let duration = self.duration > 0.0 && self.duration.is_finite();
        require(duration, "duration", self.duration, "positive and finite")?;
        require(self.blocks >= 2, "blocks", self.blocks as f64, "at least 2")?;
        require(
            self.samples >= 1,
            "samples",
            self.samples as f64,
            "at least 1",
        )?;
        self.solver.check()
    }
}
