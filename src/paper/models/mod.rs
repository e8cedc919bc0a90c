//! The paper's systems and their parts.

mod belt;
mod block_and_bracket;
pub mod cubic;
mod forced;
mod parameters;
mod tangent_points;
mod unchecked;

pub use belt::BeltOscillator;
pub use block_and_bracket::{
    Amplitude, BlockAndBracket, Caption, CaptionOrder, Interpretation, Rig, Unloading,
};
pub use forced::ForcedOscillator;
pub use tangent_points::BeltTangency;
pub(crate) use tangent_points::{tangency, visibility};
pub use unchecked::Unchecked;
