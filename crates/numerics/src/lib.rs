//! Numerical helpers that all packages share, with the same bits on every machine.

mod order;
mod power_law;
mod random;
mod search;

pub use order::{middle_two, order, upper_median};
pub use power_law::PowerLaw;
pub use random::SplitMix;
pub use search::{bisect, golden_section};
