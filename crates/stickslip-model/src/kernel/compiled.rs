//! The sizes for which the solver is compiled.

use std::sync::Arc;

use stickslip::dynamics::{Dynamics, DynamicsRef, Interrupt, Typed};
use stickslip::{Filippov, Several};

use super::inputs::Switching;
use super::system::{Equations, OwnSections, SectionFunction, TapedContacts, TapedFilippov};

/// Number of functions whose zeros end a mode of a system with one contact.
const GUARDS: usize = 3;

/// Numbers of states, with discrete ones and parameters that are states, and of contacts.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    pub states: usize,
    pub contacts: usize,
}

/// Parts of a system besides its equations.
type Extras = (OwnSections, Switching, Option<Arc<Interrupt>>);

/// The dynamics of these equations in the form that the library's analyses take. `None` if there
/// are more states than [`super::MOST_STATES`] and a parameter, or more contacts than
/// [`super::MOST_CONTACTS`]. Its orbits end when `interrupt` is raised.
pub fn dynamics(
    equations: Equations,
    sections: Vec<SectionFunction>,
    switching: Switching,
    size: Size,
    interrupt: Option<Arc<Interrupt>>,
) -> Option<DynamicsRef<'static>> {
    let extras = (OwnSections(sections), switching, interrupt);
    let dynamics = match equations {
        Equations::OneContact(system) => of_one_contact(*system, extras, size),
        Equations::ManyContacts(system) => of_many_contacts(system, extras, size),
    };
    dynamics.map(DynamicsRef::Owned)
}

/// The dynamics of a system with at most one contact; `None` if it has too many states.
fn of_one_contact(system: TapedFilippov, extras: Extras, size: Size) -> Option<Box<dyn Dynamics>> {
    fn sized<const N: usize>(
        system: TapedFilippov,
        (sections, switching, interrupt): Extras,
        size: Size,
    ) -> Box<dyn Dynamics>
    where
        TapedFilippov: Filippov<N>,
    {
        let system = (system, sections, switching);
        let (states, contacts) = (size.states, size.contacts);
        let typed =
            Typed::<_, TapedFilippov, _, _, Switching, N, GUARDS>::padded(system, states, contacts);
        Box::new(typed.interrupted_by(interrupt))
    }
    let room = extras.1.room();
    Some(match room {
        0..=2 => sized::<2>(system, extras, size),
        3 => sized::<3>(system, extras, size),
        4 => sized::<4>(system, extras, size),
        5..=8 => sized::<8>(system, extras, size),
        9..=66 => sized::<66>(system, extras, size),
        _ => return None,
    })
}

/// The dynamics of a system with several contacts; `None` if it has too many contacts or states.
fn of_many_contacts(
    system: TapedContacts,
    extras: Extras,
    size: Size,
) -> Option<Box<dyn Dynamics>> {
    fn sized<const N: usize, const M: usize>(
        system: TapedContacts,
        (sections, switching, interrupt): Extras,
        size: Size,
    ) -> Box<dyn Dynamics> {
        let system = (Several(system), sections, switching);
        let (states, contacts) = (size.states, size.contacts);
        let typed = Typed::<_, Several<_>, _, _, Switching, N, M>::padded(system, states, contacts);
        Box::new(typed.interrupted_by(interrupt))
    }
    let room = extras.1.room();
    Some(match (room, size.contacts) {
        (0..=4, 0..=2) => sized::<4, 2>(system, extras, size),
        (0..=9, 0..=4) => sized::<9, 4>(system, extras, size),
        (0..=66, 0..=16) => sized::<66, 16>(system, extras, size),
        _ => return None,
    })
}
