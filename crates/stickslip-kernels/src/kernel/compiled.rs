//! The sizes that the solver is compiled for.

use stickslip::dynamics::{Dynamics, DynamicsRef, Typed};
use stickslip::{Filippov, Several};

use super::system::{Equations, ManyContacts, OneContact, OwnSection, Section};

/// Functions whose zeros end a mode of a system of one contact.
const GUARDS: usize = 3;

/// The dynamics of these equations with numbers of states and contacts, which the library's
/// analyses take; `None` for more states than [`super::MOST_STATES`] and a parameter, or more
/// contacts than [`super::MOST_CONTACTS`].
pub fn dynamics(
    equations: Equations,
    section: Option<Section>,
    size: (usize, usize),
) -> Option<DynamicsRef<'static>> {
    let section = OwnSection(section);
    let dynamics = match equations {
        Equations::OneContact(system) => of_one_contact(*system, section, size),
        Equations::ManyContacts(system) => of_many_contacts(system, section, size),
    };
    dynamics.map(DynamicsRef::Owned)
}

/// The dynamics of a system of one contact, or of none; `None` for more states than any size has.
fn of_one_contact(
    system: OneContact,
    section: OwnSection,
    (states, contacts): (usize, usize),
) -> Option<Box<dyn Dynamics>> {
    fn sized<const N: usize>(
        system: OneContact,
        section: OwnSection,
        (states, contacts): (usize, usize),
    ) -> Box<dyn Dynamics>
    where
        OneContact: Filippov<N>,
    {
        let system = (system, section);
        Box::new(Typed::<_, OneContact, _, N, GUARDS>::padded(
            system, states, contacts,
        ))
    }
    let size = (states, contacts);
    Some(match states {
        0..=2 => sized::<2>(system, section, size),
        3 => sized::<3>(system, section, size),
        4 => sized::<4>(system, section, size),
        5..=8 => sized::<8>(system, section, size),
        9..=66 => sized::<66>(system, section, size),
        _ => return None,
    })
}

/// The dynamics of a system of several contacts; `None` for more of them, or more states, than any
/// size has.
fn of_many_contacts(
    system: ManyContacts,
    section: OwnSection,
    (states, contacts): (usize, usize),
) -> Option<Box<dyn Dynamics>> {
    fn sized<const N: usize, const M: usize>(
        system: ManyContacts,
        section: OwnSection,
        (states, contacts): (usize, usize),
    ) -> Box<dyn Dynamics> {
        let system = (Several(system), section);
        Box::new(Typed::<_, Several<ManyContacts>, _, N, M>::padded(
            system, states, contacts,
        ))
    }
    let size = (states, contacts);
    Some(match size {
        (0..=4, 0..=2) => sized::<4, 2>(system, section, size),
        (0..=9, 0..=4) => sized::<9, 4>(system, section, size),
        (0..=66, 0..=16) => sized::<66, 16>(system, section, size),
        _ => return None,
    })
}
