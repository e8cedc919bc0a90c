//! The tests of the replication, in one binary.

mod bench;
mod block_and_bracket;
mod claims;
mod cli;
mod common;
mod goldens;
mod listing;
mod models;
mod readings;
mod report;
