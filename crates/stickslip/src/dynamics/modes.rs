//! The modes of a system's contacts, with their number known at run time.

use std::fmt;

use crate::system::{Mode, Side};

/// The mode of each contact, of at most [`Modes::MAX_CONTACTS`] contacts; for a phase that a jump
/// ends, with that jump. Written as one letter per contact: `-` for slip below, `+` for slip above,
/// `S` for stick.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "String", try_from = "String"))]
pub struct Modes {
    sticks: u64,
    above: u64,
    count: u8,
    /// One plus the number of the jump that ends the phase; 0 where none does.
    until: u16,
}

impl Modes {
    /// Largest number of contacts of a system: one bit of a word each.
    pub const MAX_CONTACTS: usize = 64;

    /// The modes of these contacts; of the first [`Modes::MAX_CONTACTS`] if there are more.
    pub fn new(of: &[Mode]) -> Self {
        let count = of.len().min(Modes::MAX_CONTACTS);
        let none = Modes {
            sticks: 0,
            above: 0,
            count: count as u8,
            until: 0,
        };
        let each = of.iter().take(count).enumerate();
        each.fold(none, |modes, (contact, mode)| modes.with(contact, *mode))
    }

    /// The mode of a contact; stick where there is no such contact.
    pub fn get(&self, contact: usize) -> Mode {
        let is_set = |bits: u64| bits >> (contact % Modes::MAX_CONTACTS) & 1 == 1;
        match (
            contact < self.len(),
            is_set(self.sticks),
            is_set(self.above),
        ) {
            (true, false, false) => Mode::Slip(Side::Below),
            (true, false, true) => Mode::Slip(Side::Above),
            _ => Mode::Stick,
        }
    }

    /// Modes with another mode of one contact.
    #[must_use]
    pub fn with(mut self, contact: usize, mode: Mode) -> Self {
        if contact < self.len() {
            let bit = 1 << contact;
            self.sticks &= !bit;
            self.above &= !bit;
            match mode {
                Mode::Stick => self.sticks |= bit,
                Mode::Slip(Side::Above) => self.above |= bit,
                Mode::Slip(Side::Below) => {}
            }
        }
        self
    }

    /// Modes of a phase that a jump ends, by its number from 0.
    #[must_use]
    pub fn until(self, jump: Option<usize>) -> Self {
        let number = jump.map_or(0, |jump| jump.saturating_add(1));
        let until = u16::try_from(number).unwrap_or(u16::MAX);
        Modes { until, ..self }
    }

    /// The jump that ends the phase, by its number from 0. Two phases that differ in it have
    /// different modes.
    pub fn jump(&self) -> Option<usize> {
        usize::from(self.until).checked_sub(1)
    }

    /// The phases of a cycle in an order that does not depend on where it begins. It is the
    /// rotation whose letters are least (`+` before `-` before `S`).
    pub fn cycle(phases: impl IntoIterator<Item = Modes>) -> Vec<Modes> {
        let phases: Vec<Modes> = phases.into_iter().collect();
        let rotated = |by: usize| [&phases[by..], &phases[..by]].concat();
        let letters = |modes: &Vec<Modes>| -> Vec<String> {
            modes.iter().map(|modes| String::from(*modes)).collect()
        };
        let all = (0..phases.len()).map(rotated);
        all.min_by_key(letters).unwrap_or_default()
    }

    /// The modes in order of the contacts, as a list.
    pub fn to_vec(&self) -> Vec<Mode> {
        self.iter().collect()
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        usize::from(self.count)
    }

    /// Whether there is no contact at all.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether any contact sticks.
    pub fn any_sticks(&self) -> bool {
        self.sticks != 0
    }

    /// The modes in order of the contacts.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = Mode> + use<> {
        let modes = *self;
        (0..self.len()).map(move |contact| modes.get(contact))
    }
}

impl fmt::Display for Modes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.iter().try_for_each(|mode| {
            f.write_str(match mode {
                Mode::Slip(Side::Below) => "-",
                Mode::Slip(Side::Above) => "+",
                Mode::Stick => "S",
            })
        })
    }
}

impl fmt::Debug for Modes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&String::from(*self))
    }
}

/// The modes of a system with one contact.
impl From<Mode> for Modes {
    fn from(mode: Mode) -> Modes {
        Modes::new(&[mode])
    }
}

impl<const M: usize> From<[Mode; M]> for Modes {
    fn from(modes: [Mode; M]) -> Modes {
        Modes::new(&modes)
    }
}

/// The mode of a single contact can stand for all, whatever ends the phase.
impl PartialEq<Mode> for Modes {
    fn eq(&self, mode: &Mode) -> bool {
        self.until(None) == Modes::from(*mode)
    }
}

/// Whatever ends the phase.
impl<const M: usize> PartialEq<[Mode; M]> for Modes {
    fn eq(&self, modes: &[Mode; M]) -> bool {
        self.until(None) == Modes::from(*modes)
    }
}

/// Letters, then, after `:`, the number of the jump that ends the phase.
impl From<Modes> for String {
    fn from(modes: Modes) -> String {
        match modes.jump() {
            Some(jump) => format!("{modes}:{jump}"),
            None => modes.to_string(),
        }
    }
}

impl TryFrom<String> for Modes {
    type Error = String;

    fn try_from(text: String) -> Result<Modes, String> {
        let mode = |letter| match letter {
            '-' => Ok(Mode::Slip(Side::Below)),
            '+' => Ok(Mode::Slip(Side::Above)),
            'S' => Ok(Mode::Stick),
            other => Err(format!("`{other}` is no mode: -, + or S is")),
        };
        let (letters, jump) = match text.split_once(':') {
            Some((letters, jump)) => (letters, Some(jump)),
            None => (text.as_str(), None),
        };
        let jump = jump.map(|jump| {
            let number = jump.parse();
            number.map_err(|_| format!("`{jump}` is no number of a jump"))
        });
        let jump = jump.transpose()?;
        let modes: Vec<Mode> = letters.chars().map(mode).collect::<Result<_, String>>()?;
        if modes.len() > Modes::MAX_CONTACTS {
            return Err(format!(
                "`{text}` has {} modes: at most {} contacts are possible",
                modes.len(),
                Modes::MAX_CONTACTS
            ));
        }
        Ok(Modes::new(&modes).until(jump))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_read_back_what_they_write() {
        for text in ["", "-", "S+-", &"+S".repeat(32), ":0", "S:12"] {
            let modes = Modes::try_from(text.to_owned()).unwrap();
            assert_eq!(String::from(modes), text);
            assert_eq!(modes.any_sticks(), text.contains('S'));
            assert_eq!(modes.jump().is_some(), text.contains(':'));
        }
        assert!(Modes::try_from("x".to_owned()).is_err());
        assert!(Modes::try_from("S:x".to_owned()).is_err());
        assert!(Modes::try_from("+".repeat(65)).is_err());
    }

    #[test]
    fn one_contact_changes_and_the_others_stay() {
        let modes = Modes::try_from("-+S".to_owned()).unwrap();
        assert_eq!(modes.with(1, Mode::Stick).to_string(), "-SS");
        assert_eq!(modes.with(2, Mode::Slip(Side::Above)).to_string(), "-++");
        assert_eq!(modes.with(3, Mode::Stick), modes);
    }
}
