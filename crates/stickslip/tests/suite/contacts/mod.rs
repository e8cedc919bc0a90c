//! Several contacts: event times known to 25 digits, static friction, and what must hold of any chain of blocks.

mod apart;
mod bad_input;
mod chains;
mod coupled;
mod references;
mod rig;
mod spectra;
mod static_friction;
