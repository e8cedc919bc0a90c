//! The paper's systems and their parts.

mod belt;
pub mod cubic;
mod forced;
pub mod friction;
mod parameters;
mod tangent_points;

pub use belt::BeltOscillator;
pub use forced::ForcedOscillator;
pub use tangent_points::BeltTangency;
