//! Event-exact integration of dry-friction (Filippov) systems, and the replication of one paper with it.

pub mod figures;
pub mod math;
pub mod models;
