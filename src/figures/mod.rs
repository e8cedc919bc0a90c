//! The paper's figures: `compute() -> data`, `numbers(&data)`, `draw(&data)`.

mod error;
pub mod style;

pub use error::FigureError;
