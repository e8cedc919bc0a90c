//! States from fewer columns than the system has: delayed values, and how many of them at what delay.

mod choice;
mod delay;
mod false_neighbours;
mod information;

pub use choice::{
    DelayReason, DimensionEvidence, DimensionReason, EmbeddingChoice, EmbeddingSettings,
    NO_FALSE_NEIGHBOURS, choose_embedding, lacks_columns, needed_embedding,
};
pub use delay::Embedding;
