//! The tests of the replication, in one binary.

mod block_and_bracket;
mod captions;
mod claims;
mod cli;
mod common;
mod goldens;
mod listing;
mod models;
#[cfg(feature = "peers")]
mod peers;
mod properties;
mod readings;
mod report;
#[cfg(feature = "peers")]
mod shipped;
mod spectra_table;
