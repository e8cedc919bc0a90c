//! A system ready to run: a file, and values for its parameters.

use stickslip::Direction;

use crate::file::{Built, FileError, SystemFile, did_you_mean};
use crate::problem::{Problem, Source};
use stickslip_kernels::kernel::{
    Equations, Kernel, ManyContacts, OneContact, Section, of_many_contacts, of_one_contact,
};

/// A system ready to run.
pub struct System {
    /// The file that it is from.
    pub file: SystemFile,
    /// Values of the parameters, in the order of the file.
    pub values: Vec<f64>,
    /// Its equations.
    pub built: Built,
    kernel: Box<dyn Kernel>,
    section: Option<Section>,
}

/// A parameter was set wrongly.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SettingError {
    /// There is none of this name.
    #[error("there is no parameter `{name}`; {help}")]
    Unknown {
        /// Name given.
        name: String,
        /// What may have been meant, or what there is.
        help: String,
    },
    /// The value is outside what the file allows.
    #[error("{name} = {value} is not allowed: its range in the file is from {low} to {high}")]
    OutsideRange {
        /// Name.
        name: String,
        /// Value given.
        value: f64,
        /// Lowest that is allowed.
        low: f64,
        /// Highest that is allowed.
        high: f64,
    },
    /// A parameter is set twice.
    #[error("the parameter `{name}` is set twice; set it once")]
    Twice {
        /// Name.
        name: String,
    },
    /// With the values, something in the file cannot be evaluated.
    #[error(transparent)]
    File(#[from] FileError),
}

impl SystemFile {
    /// The system with some of its parameters set to other values.
    ///
    /// # Errors
    /// [`SettingError`] for a name that there is not, a value outside the parameter's range, or one with which an expression is no number.
    pub fn with(&self, settings: &[(String, f64)]) -> Result<System, SettingError> {
        let mut values = crate::file::values(self);
        for (i, (name, value)) in settings.iter().enumerate() {
            let known = || {
                self.parameters
                    .iter()
                    .map(|parameter| parameter.name.as_str())
            };
            let plain = stickslip_kernels::expression::normal(name);
            let Some(number) = known().position(|known| known == plain) else {
                let help = did_you_mean(name, known()).unwrap_or_else(|| {
                    let all: Vec<&str> = known().collect();
                    if all.is_empty() {
                        "the file has none".to_owned()
                    } else {
                        format!("there are {}", all.join(", "))
                    }
                });
                let name = name.clone();
                return Err(SettingError::Unknown { name, help });
            };
            if settings[..i].iter().any(|(other, _)| other == name) {
                let name = name.clone();
                return Err(SettingError::Twice { name });
            }
            if let Some((low, high)) = self.parameters[number].range
                && !(low..=high).contains(value)
            {
                let (name, value) = (name.clone(), *value);
                return Err(SettingError::OutsideRange {
                    name,
                    value,
                    low,
                    high,
                });
            }
            values[number] = *value;
        }
        Ok(System::new(self.clone(), values)?)
    }
}

impl System {
    fn new(file: SystemFile, values: Vec<f64>) -> Result<System, FileError> {
        let wrong = |problem: Problem, source: &Source| FileError::Wrong {
            problem: Box::new(problem),
            source_text: Box::new(source.clone()),
        };
        let built = crate::file::built(&file, &values).map_err(|p| wrong(p, &file.source))?;
        let states = file.states.len();
        let kernel = match equations(&built) {
            Equations::OneContact(system) => of_one_contact(*system, states),
            Equations::ManyContacts(system) => of_many_contacts(system, states),
        };
        let Some(kernel) = kernel else {
            // The reader lets no file through that has more states or contacts than there are kernels for, save one of
            // more contacts than states.
            let problem = Problem::new(
                format!(
                    "{} contacts are too many for {states} states: their boundaries cannot be independent",
                    file.contacts.len()
                ),
                0..0,
            );
            return Err(wrong(problem, &file.source));
        };
        let direction = file
            .section
            .as_ref()
            .map_or(Direction::Both, |section| section.direction);
        let section = built.section.clone().map(|function| Section {
            function,
            direction,
        });
        Ok(System {
            file,
            values,
            built,
            kernel,
            section,
        })
    }

    /// Its equations alone.
    pub fn equations(&self) -> Equations {
        equations(&self.built)
    }

    /// The compiled solver for it.
    pub fn kernel(&self) -> &dyn Kernel {
        &*self.kernel
    }

    /// The section that the file has.
    pub fn section(&self) -> Option<&Section> {
        self.section.as_ref()
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.file.states.len()
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.file.contacts.len()
    }

    /// Height of the state over the boundary of a contact.
    pub fn height(&self, contact: usize, t: f64, x: &[f64]) -> f64 {
        let mut heights = vec![f64::NAN; self.contacts()];
        self.built.boundaries.evaluate(t, x, &mut heights);
        heights[contact]
    }
}

fn equations(built: &Built) -> Equations {
    let boundaries = built.boundaries.clone();
    match &built.fields.slip[..] {
        [below, above] => {
            let holding = match &built.fields.holding[..] {
                [_, held] => match &held[..] {
                    [below, above] => Some([below.clone(), above.clone()]),
                    _ => None,
                },
                _ => None,
            };
            Equations::OneContact(Box::new(OneContact {
                field: [below.clone(), above.clone()],
                holding,
                boundary: boundaries,
                normal_force: built.normal_force.clone(),
            }))
        }
        _ => Equations::ManyContacts(ManyContacts {
            field: built.fields.slip.clone(),
            holding: built.fields.holding.clone(),
            boundaries,
        }),
    }
}
