//! The paper's figures: `compute() -> data`, `numbers(&data)`, `draw(&data)`.

pub mod cli;
mod error;
pub mod fig06;
pub mod fig07;

pub mod output;
pub mod png;
pub mod rows;
mod spec;
pub mod style;

pub use error::FigureError;
pub use spec::FigureSpec;
