//! The paper's systems and a few textbook ones with known answers.

mod belt;
mod forced;
mod parameters;

pub use belt::BeltOscillator;
pub use forced::ForcedOscillator;
