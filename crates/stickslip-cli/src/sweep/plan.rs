//! What a sweep is: everything its blocks depend on.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::ops::Range;

use serde_json::Value;

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
        if block.is_multiple_of(self.length.get()) {
            None
        } else {
            Some(block - 1)
        }
    }
}
