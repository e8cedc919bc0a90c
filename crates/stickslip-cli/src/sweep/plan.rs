//! What a sweep is, everything its blocks depend on; and a share of it, which one of several
//! processes or machines computes.

use std::collections::BTreeMap;
use std::fmt;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::str::FromStr;

use serde_json::Value;

use super::error::SweepError;

/// A sweep. Two sweeps with the same plan have the same blocks, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What is computed, such as `basin`.
    pub command: String,
    /// Every argument that a block depends on, by name.
    pub arguments: BTreeMap<String, Value>,
    /// Name of the system.
    pub system: String,
    /// Its definition: the whole file.
    pub system_text: String,
    /// Number of chains.
    pub chains: NonZeroUsize,
    /// Blocks of a chain. Where blocks do not depend on each other, each is a chain of its own.
    pub length: NonZeroUsize,
}

/// Blocks of which each begins where the one before has ended. They are computed one after the other, by one thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain {
    first: usize,
    length: usize,
}

impl Chain {
    /// The indices of its blocks.
    pub fn blocks(&self) -> Range<usize> {
        self.first..self.first + self.length
    }
}

impl Plan {
    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.chains.get() * self.length.get()
    }

    /// Chain `index`.
    pub fn chain(&self, index: usize) -> Chain {
        let length = self.length.get();
        let first = index * length;
        Chain { first, length }
    }

    /// The block that `block` goes on from.
    pub fn before(&self, block: usize) -> Option<usize> {
        (!block.is_multiple_of(self.length.get())).then(|| block - 1)
    }
}

/// Share `number` of `of`, counted from 1: every `of`-th chain, so that dear and cheap parts of a
/// plane spread over all of them.
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

    /// Its chains, in order. There are none if the sweep has fewer chains than there are shares
    /// before this one.
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
