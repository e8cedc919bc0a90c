//! Sweeps that can outlast a session or be shared between machines. A sweep consists of blocks.
//! Each block is a pure function of its index, and is on disk either complete or not at all.
//!
//! This module does not depend on what is computed. [`Plan`] defines a sweep, and [`run`] computes
//! the blocks of a [`Share`] on all cores. [`merge()`] joins shares from separate folders, and
//! [`Store::for_each`] reads the blocks in order, one at a time. The bytes of a block do not depend
//! on the number of threads, on the shares, on earlier results, or on how often the sweep was
//! killed.
//!
//! Files in the folder of a sweep:
//!
//! * `manifest.json`: the command, every argument by name, the text of the system and its hash, the
//!   version of the format.
//! * `blocks/00000017.block`: a line with the sweep's fingerprint, the index, the length and a
//!   checksum; then the content of the block.
//! * `work/3-of-8/`: the lock of a share, and incomplete files.
//! * `work/tables/`: incomplete tables and figures.

mod block;
mod error;
mod merge;
mod plan;
mod run;
mod store;

pub(crate) use block::digest;
pub use error::{BlockError, SweepError};
pub use merge::{Merged, merge};
pub use plan::{Definition, Plan, Share};
pub use run::{Computed, Task, run};
pub use store::{BlockContent, Store, Writer, write_whole};
