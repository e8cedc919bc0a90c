//! Problems whose events are known in closed form or to twenty digits.

mod belt;
mod circles;
mod dips;
mod grazing;
mod lines;
