//! The tests of the replication, in one binary.

mod block_and_bracket;
mod claims;
mod cli;
mod common;
mod goldens;
mod listing;
#[cfg(feature = "peers")]
mod peers;
mod readings;
mod report;
mod spectra_table;
