//! Several contacts: event times with 25 digits, static friction, and properties of any chain of
//! blocks.

#![allow(
    clippy::needless_range_loop,
    reason = "forces, rates and matrices are indexed by contact, as in the equations"
)]

mod apart;
mod bad_input;
mod chains;
mod corners;
mod coupled;
mod events;
mod jumps;
mod references;
mod rig;
mod spectra;
mod static_friction;
mod two_states;

/// The fault of the contacts of a run.
fn fault(error: &stickslip::Error) -> &stickslip::error::ContactFault {
    match error {
        stickslip::Error::Contacts { fault, .. } => fault,
        other => panic!("{other}"),
    }
}
