//! A share of a sweep: what one of several processes or machines computes.

use std::fmt;
use std::str::FromStr;

use super::error::SweepError;
use super::plan::{Chain, Plan};

/// Share `number` of `of`, counted from 1: every `of`-th chain, so that dear and cheap parts of a plane spread over all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    number: usize,
    of: usize,
}

impl Share {
    /// The whole sweep.
    pub const WHOLE: Share = Share { number: 1, of: 1 };

    /// Share `number` of `of`.
    ///
    /// # Errors
    /// [`SweepError::Share`] unless 1 ≤ `number` ≤ `of`.
    pub fn new(number: usize, of: usize) -> Result<Self, SweepError> {
        if number == 0 || number > of {
            return Err(SweepError::Share {
                text: format!("{number}/{of}"),
            });
        }
        Ok(Self { number, of })
    }

    /// Whether it is all of the sweep.
    pub fn is_whole(&self) -> bool {
        self.of == 1
    }

    /// Its chains, in order. There are none if the sweep has fewer chains than there are shares before this one.
    pub fn chains(self, plan: &Plan) -> impl Iterator<Item = Chain> {
        let all = self.number - 1..plan.chains.get();
        all.step_by(self.of).map(|index| plan.chain(index))
    }
}

impl FromStr for Share {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            let number = number.parse().ok()?;
            Some((number, of.parse().ok()?))
        });
        match numbers {
            Some((number, of)) => Self::new(number, of),
            None => Err(SweepError::Share { text: text.into() }),
        }
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}
