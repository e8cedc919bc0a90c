//! The paper's figures: `compute() -> data`, `numbers(&data)`, `draw(&data)`.

pub mod block_and_bracket;
pub mod cli;
mod error;
pub mod fig04;
pub mod fig06;
pub mod fig07;
pub mod fig08;
pub mod fig10;
pub mod fig11;
pub mod fig12;
pub mod locator;

pub mod output;
pub mod rows;
mod spec;
mod trace;

pub use error::FigureError;
pub use spec::FigureSpec;
