//! Failures at contacts, with the values that explain them.

use crate::error::{Point, readable};

/// Reason for which the motion at one or several contacts cannot continue. Contacts are counted
/// from 0.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ContactFault {
    /// Several contacts are at zero, and the motion that follows is not unique or does not exist.
    NoUniqueMode {
        /// The contacts.
        contacts: Vec<usize>,
        /// The consistent outcomes, in the same order.
        candidates: Vec<String>,
    },
    /// Too many contacts are at zero together to try all combinations, and their friction does not
    /// guarantee a unique solution.
    TooManyContacts {
        /// The contacts.
        contacts: Vec<usize>,
    },
    /// The boundaries of contacts at zero together are degenerate: one has no slope, or two
    /// coincide.
    DependentContacts {
        /// The contacts.
        contacts: Vec<usize>,
    },
    /// A contact's static friction is below its kinetic friction.
    StaticBelowKinetic {
        /// The contact.
        contact: usize,
        /// Static over kinetic friction.
        ratio: f64,
    },
    /// The field that holds a contact also changes the friction of a slipping contact.
    HoldsElsewhere {
        /// The contact at rest.
        held: usize,
        /// The contact that slips.
        slipping: usize,
    },
    /// Friction at one contact depends on the side of another, which the system does not declare.
    NotAdditive {
        /// The two contacts.
        pair: (usize, usize),
    },
}

impl ContactFault {
    /// Whether the friction that the system declares is at fault, not the motion.
    pub(crate) fn is_of_friction(&self) -> bool {
        matches!(
            self,
            ContactFault::StaticBelowKinetic { .. }
                | ContactFault::HoldsElsewhere { .. }
                | ContactFault::NotAdditive { .. }
        )
    }

    /// The fault in words, with its place.
    pub(crate) fn words(&self, t: f64, x: &Point) -> String {
        let at = format!("at t = {}, x = {x}", readable(t));
        match self {
            ContactFault::NoUniqueMode {
                contacts,
                candidates,
            } => format!(
                "contacts {contacts:?} stand at zero {at}, and {}; friction there may push apart, \
                 or one contact's force act on another too strongly: look at the field with each \
                 of them on either side (Options::at_repelling has no say for several contacts)",
                candidates_in_words(candidates)
            ),
            ContactFault::TooManyContacts { contacts } => format!(
                "contacts {contacts:?} stand at zero together {at}: more than eight are too many \
                 to try where friction at one does not resist all of them as Coulomb's does; move \
                 their boundaries apart, or write their friction without coupling"
            ),
            ContactFault::DependentContacts { contacts } => format!(
                "the boundary functions of contacts {contacts:?} have gradients {at} that are zero \
                 or depend on each other; each contact needs a boundary of its own"
            ),
            ContactFault::StaticBelowKinetic { contact, ratio } => format!(
                "the static friction of contact {contact} {at} is {} times the kinetic; it must be \
                 at least as large",
                readable(*ratio)
            ),
            ContactFault::HoldsElsewhere { held, slipping } => format!(
                "with contact {held} at rest {at}, Contacts::holding changes the friction of \
                 contact {slipping}, which slips; only contacts in `held` have static friction"
            ),
            ContactFault::NotAdditive { pair } => format!(
                "the friction of contacts {} and {} does not add {at}: what one does depends on \
                 the side of the other; set Contacts::MULTI_AFFINE to true",
                pair.0, pair.1
            ),
        }
    }
}

/// The consistent outcomes and their number, in words.
fn candidates_in_words(candidates: &[String]) -> String {
    if candidates.is_empty() {
        "no motion that follows is consistent with the friction at all of them".to_owned()
    } else {
        format!(
            "{} motions that follow are consistent: {}",
            candidates.len(),
            candidates.join(" or ")
        )
    }
}
