//! Problems with events known in closed form or to twenty digits.

mod belt;
mod circles;
mod dips;
pub mod grazing;
mod lines;
mod static_friction;
