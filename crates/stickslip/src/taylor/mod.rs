//! Taylor series of the solution: the user's functions recorded once as a tape, the tape evaluated order by order.
//!
//! A run of the field on [`Recorded`](recorder::Recorded) numbers leaves a [`Tape`](tape::Tape) of a dozen operations.
//! Each of them has a recurrence that gives coefficient `k` of its result from the coefficients up to `k` of its
//! arguments (Moore, *Interval Analysis*, 1966; Griewank & Walther, *Evaluating Derivatives*, 2008, Ch. 13), and
//! `x_{k+1} = f_k/(k + 1)` closes the circle. Order and step follow the tolerance (Jorba & Zou, *Experimental Mathematics* 14
//! (2005) 99; Biscani & Izzo, *MNRAS* 504 (2021) 2614, the code heyoka). Any function of the solution that was recorded
//! with the field has its own series, a polynomial in time whose first zero in the step is isolated for certain
//! ([`roots`]). Knows nothing of discontinuities.

pub(crate) mod recorder;
pub(crate) mod roots;
pub(crate) mod series;
pub(crate) mod sketch;
pub(crate) mod tape;

/// Highest order of a series.
pub(crate) const MOST_ORDER: usize = 24;
