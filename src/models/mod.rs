//! The paper's systems and their ingredients.

pub mod cubic;
mod error;
pub mod friction;

pub use error::ParameterError;
