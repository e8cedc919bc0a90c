//! What can be wrong with a setup.

/// Why a setup cannot be run; every message names the value, the bound and a remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ListingError {
    /// A parameter is not a number that it can be.
    #[error("{name} is {value}, but it must be {bound}; choose such a value")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it can be.
        bound: &'static str,
    },
    /// The tangent points are not in the listing's order.
    #[error(
        "tangent point {index} is {value}, not below its predecessor {previous}; list all six from the largest down"
    )]
    TangentOrder {
        /// Index into the list, from 0.
        index: usize,
        /// The value found.
        value: f64,
        /// The value before it.
        previous: f64,
    },
    /// A tangent point is no root of the transition function, Eq. (19).
    #[error(
        "tangent point {index} is {value}, where the spring force is {force} and not ±mu0 = ±{mu0}; recompute the tangent points whenever mu0, k1 or k2 changes"
    )]
    NotTangent {
        /// Index into the list, from 0.
        index: usize,
        /// The value found.
        value: f64,
        /// Spring force at it, in newtons.
        force: f64,
        /// Friction coefficient.
        mu0: f64,
    },
    /// The step is too long to tell forcing periods apart.
    #[error(
        "step h is {h} s, above the bound {bound} s (a twentieth of the forcing period); choose a smaller h"
    )]
    StepTooLong {
        /// The step, in seconds.
        h: f64,
        /// The largest step accepted, in seconds.
        bound: f64,
    },
    /// The run would take more steps than is sensible.
    #[error(
        "the run would take {steps:e} steps, above the bound {bound:e}; choose a larger h or an earlier end"
    )]
    TooManySteps {
        /// Steps asked for.
        steps: f64,
        /// Steps allowed.
        bound: f64,
    },
    /// The window does not lie inside the run.
    #[error(
        "the window starts at {window_start} s, outside the run's [0, {end}] s; choose a start within it"
    )]
    WindowOutside {
        /// Start of the window, in seconds.
        window_start: f64,
        /// Length of the run, in seconds.
        end: f64,
    },
}
