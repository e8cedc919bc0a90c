//! The replication of one paper with the library [`stickslip`]: its figures, claims and readings.

pub mod captions;
mod destination;
pub mod figures;
pub mod motion;
mod numbers;
mod orbit_records;
pub mod paper;
pub mod readings;
pub mod report;
mod terminal;
mod text;
