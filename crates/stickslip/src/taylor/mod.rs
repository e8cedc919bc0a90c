//! Taylor series of the solution: the user's functions run once per order on a number type that
//! evaluates its own recurrence.
//!
//! A [`Jet`](jet::Jet) carries its newest coefficient and the location of its earlier ones. Every
//! operation has a recurrence that gives coefficient `k` of its result from the coefficients up to
//! `k` of its arguments (Moore, *Interval Analysis*, 1966; Griewank & Walther, *Evaluating
//! Derivatives*, 2008, Ch. 13). The differential equation `x_{k+1} = f_k/(k + 1)` then gives the
//! next coefficient of the state. Order and step follow the tolerance (Jorba & Zou, *Experimental
//! Mathematics* 14 (2005) 99; Biscani & Izzo, *MNRAS* 504 (2021) 2614, the code heyoka). Any
//! function of the solution has a series of its own, a polynomial in time whose first zero in the
//! step is isolated rigorously ([`roots`]). This module does not deal with discontinuities.
//!
//! Numbers, sweeps and recordings refer to each other: a number knows its sweep, a sweep makes
//! numbers, and a recording repeats what was done with them.

mod functions;
pub(crate) mod jet;
mod recorded;
pub(crate) mod recorded_calls;
pub(crate) mod recorded_functions;
mod recording;
pub(crate) mod roots;
pub(crate) mod row;
pub(crate) mod series;
pub(crate) mod steps;
pub(crate) mod sweep;
#[cfg(test)]
mod tests;

/// Highest order of a series: the one that a tolerance of 1e-14 asks for. It fixes the memory of a
/// step.
pub(crate) const MAX_ORDER: usize = 24;

/// Number of coefficients of a series of the highest order.
pub(crate) const MAX_COEFFICIENTS: usize = MAX_ORDER + 1;

/// Reciprocal of an order.
#[inline(always)]
pub(crate) fn inverse(k: usize) -> f64 {
    const ALL: [f64; MAX_COEFFICIENTS] = {
        let mut all = [0.0; MAX_COEFFICIENTS];
        let mut k = 1;
        while k <= MAX_ORDER {
            all[k] = 1.0 / k as f64;
            k += 1;
        }
        all
    };
    ALL[k]
}
