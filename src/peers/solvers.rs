//! Our solvers: a table in which one line adds one.

use stickslip::filippov::{Method, Options};

/// A solver of ours.
#[derive(Clone, Copy, Debug)]
pub struct Solver {
    /// Name in the report and in the figure.
    pub name: &'static str,
    /// Its integrator.
    pub method: Method,
    /// The tolerances it is run with.
    pub tolerances: &'static [f64],
}

const LADDER: [f64; 12] = [
    1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15,
];

/// The solvers.
pub const SOLVERS: &[Solver] = &[
    Solver {
        name: "stickslip Taylor",
        method: Method::Taylor,
        tolerances: &LADDER,
    },
    Solver {
        name: "stickslip Dop853",
        method: Method::Dop853,
        // Rounding ends what slopes can reach.
        tolerances: LADDER.split_at(11).0,
    },
];

impl Solver {
    /// Its settings for a tolerance.
    pub fn options(&self, tolerance: f64) -> Options {
        Options::tol(tolerance).method(self.method)
    }
}
