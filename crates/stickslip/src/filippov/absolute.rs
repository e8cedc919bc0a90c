//! Absolute tolerances of the states.

use std::fmt;

use crate::error::{Error, require};

/// Largest number of states that can have their own tolerances.
const MOST_STATES: usize = 64;

/// Absolute error allowed per step: one number for all states, or one for each.
///
/// ```
/// use stickslip::{AbsoluteTolerance, Options};
/// // A position in metres, and a pressure in pascals.
/// let each = AbsoluteTolerance::each(&[1e-12, 1e-4])?;
/// let options = Options { atol: each, ..Options::tol(1e-10) };
/// assert_eq!(options.atol.of(1), 1e-4);
/// assert_eq!(AbsoluteTolerance::from(1e-9).of(1), 1e-9);
/// # Ok::<(), stickslip::Error>(())
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct AbsoluteTolerance {
    /// Values of the first states.
    each: [f64; MOST_STATES],
    /// Number of these; none where one number is for all.
    given: usize,
    /// Value of all other components. Where each state has its own, those are parameters and what
    /// inputs hold, and the value is the smallest.
    other: f64,
}

impl AbsoluteTolerance {
    /// A value for each state, in the order and the units of the states.
    ///
    /// # Errors
    /// [`Error::Option`] where there is no value, or more than 64. A run checks the values, and
    /// that there are as many as states.
    pub fn each(values: &[f64]) -> Result<Self, Error> {
        let given = values.len();
        let is_allowed = (1..=MOST_STATES).contains(&given);
        let bound = "between 1 and 64, one for each state, or one number for all states";
        require(is_allowed, "number of values of atol", given as f64, bound)?;
        let other = values.iter().copied().fold(f64::INFINITY, f64::min);
        let mut each = [other; MOST_STATES];
        each[..given].copy_from_slice(values);
        Ok(AbsoluteTolerance { each, given, other })
    }

    /// The value of a component of the state.
    #[inline(always)]
    pub fn of(&self, component: usize) -> f64 {
        if component < self.given {
            self.each[component]
        } else {
            self.other
        }
    }

    /// The values by state, empty where one number is for all.
    pub fn values(&self) -> &[f64] {
        &self.each[..self.given]
    }

    /// The smallest value.
    #[inline(always)]
    pub fn smallest(&self) -> f64 {
        self.other
    }

    /// The largest value.
    #[inline(always)]
    pub fn largest(&self) -> f64 {
        self.values().iter().copied().fold(self.other, f64::max)
    }

    /// The values, each changed by the same non-decreasing function.
    #[must_use]
    pub fn map(&self, change: impl Fn(f64) -> f64) -> Self {
        AbsoluteTolerance {
            each: self.each.map(&change),
            given: self.given,
            other: change(self.other),
        }
    }

    /// The values of all `N` components.
    #[inline(always)]
    pub(crate) fn components<const N: usize>(&self) -> [f64; N] {
        if self.given == 0 {
            [self.other; N]
        } else {
            std::array::from_fn(|i| self.of(i))
        }
    }

    /// Checks that the values belong to that number of states.
    pub(crate) fn check_states(&self, states: usize) -> Result<(), Error> {
        if self.given == 0 || self.given == states {
            return Ok(());
        }
        Err(Error::Tolerances {
            given: self.given,
            states,
        })
    }
}

impl From<f64> for AbsoluteTolerance {
    fn from(value: f64) -> Self {
        AbsoluteTolerance {
            each: [value; MOST_STATES],
            given: 0,
            other: value,
        }
    }
}

/// The number as such, or a list.
impl fmt::Debug for AbsoluteTolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.values() {
            [] => self.other.fmt(f),
            values => values.fmt(f),
        }
    }
}
