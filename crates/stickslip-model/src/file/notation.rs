//! Names, modes and phase sequences of a system in words.

use stickslip::analysis::{Attractor, AttractorKind};
use stickslip::dynamics::Modes;
use stickslip::{Mode, Side};

use super::System;

impl System {
    /// Name of a contact, or of a jump or an input, whose numbers follow those of the contacts.
    /// Empty for a number that the system does not have.
    pub fn contact_name(&self, number: usize) -> String {
        let contacts = self.file.contacts.iter().map(|contact| &contact.name);
        let jumps = self.file.jumps.iter().map(|jump| &jump.name);
        let inputs = self.file.inputs.iter().map(|input| &input.name);
        let mut all = contacts.chain(jumps).chain(inputs);
        all.nth(number).cloned().unwrap_or_default()
    }

    /// Name of the surface on which the event function of a contact or a jump is zero, by the
    /// number of [`System::contact_name`].
    pub fn surface(&self, number: usize) -> String {
        let name = self.contact_name(number);
        let part = |stop: &str| {
            name.strip_prefix(stop)
                .is_some_and(|part| part.starts_with('.'))
        };
        let stop = self.file.stops.iter().find(|stop| part(&stop.name));
        match stop {
            Some(stop) => format!("the stop {}", stop.name),
            None if number < self.contacts() => format!("the boundary of {name}"),
            None => format!("the guard of {name}"),
        }
    }

    /// The names of several contacts.
    pub fn contact_names(&self, numbers: &[usize]) -> String {
        let names = numbers.iter().map(|&number| self.contact_name(number));
        names.collect::<Vec<_>>().join(" and ")
    }

    /// The modes of a phase in letters, with several contacts separated by `|`: `+` and `-` for
    /// slip above and below, `S` for stick. The jump that ends the phase follows, in brackets if
    /// there is a contact. `·` stands for a phase without a contact that no jump ends.
    pub fn letters(&self, modes: &Modes) -> String {
        let letters = modes.iter().map(|mode| match mode {
            Mode::Stick => "S",
            Mode::Slip(Side::Above) => "+",
            Mode::Slip(Side::Below) => "-",
        });
        let letters = letters.collect::<Vec<_>>().join("|");
        match modes.jump() {
            None if letters.is_empty() => "·".to_owned(),
            _ => self.with_jump(letters, modes),
        }
    }

    /// Letters of the modes, and the jump that ends the phase.
    pub fn with_jump(&self, letters: String, modes: &Modes) -> String {
        let jump = modes.jump().map(|jump| self.contacts() + jump);
        match jump.map(|number| self.contact_name(number)) {
            Some(name) if letters.is_empty() => name,
            Some(name) => format!("{letters}({name})"),
            None => letters,
        }
    }

    /// The modes of successive phases, in letters.
    pub fn sequence(&self, modes: &[Modes]) -> String {
        let phases: Vec<String> = modes.iter().map(|modes| self.letters(modes)).collect();
        phases.join(" ")
    }

    /// The phases of a period in letters, independent of where in the cycle they begin, or the
    /// modes of an equilibrium. Empty for other motions, whose phases are only the last ones.
    pub fn phases(&self, reached: &Attractor) -> String {
        match reached.kind {
            AttractorKind::Periodic { .. } => self.sequence(&reached.sequence()),
            AttractorKind::Equilibrium | AttractorKind::EquilibriumSet => {
                self.letters(&reached.mode)
            }
            _ => String::new(),
        }
    }

    /// The kind of motion; for a periodic orbit, with the cycle of its phases.
    pub fn class(&self, reached: &Attractor) -> String {
        let word = reached.kind.word();
        match reached.kind {
            AttractorKind::Periodic { .. } => match self.phases(reached) {
                phases if phases.trim().is_empty() => word.to_owned(),
                phases => format!("{word}, {phases}"),
            },
            _ => word.to_owned(),
        }
    }
}
