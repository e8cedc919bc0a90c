//! Sweeps that outgrow a session or a machine: many blocks, each a pure function of its index, each
//! on disk whole or not at all.
//!
//! A sweep knows nothing of what is computed. [`Plan`] says what it is, [`run`] computes the blocks
//! of a [`Share`] on all cores, [`merge()`] joins shares that were computed in folders of their
//! own, and [`Store::for_each`] reads the blocks in order, one at a time. The bytes of a block do
//! not depend on the number of threads, on the shares, on what was computed before, or on how often
//! the sweep was killed.
//!
//! | file in the folder of a sweep | what it holds |
//! |---|---|
//! | `manifest.json` | the command, every argument by name, the system's text and its hash, the version of the format |
//! | `blocks/00000017.block` | a line with the sweep's fingerprint, the index, the length and a checksum; then the block |
//! | `work/3-of-8/` | the lock of a share, and files that are not complete |
//! | `work/tables/` | tables and figures that are not complete |

mod block;
mod error;
mod merge;
mod plan;
mod run;
mod store;

pub use error::{BlockError, SweepError};
pub use merge::{Merged, merge};
pub use plan::{Definition, Plan, Share};
pub use run::{Computed, Task, run};
pub use store::{Store, Whole, Writer, write_whole};
