//! A system ready to run: a file and values for its parameters.

use std::sync::Arc;

use numerics::SplitMix;
use stickslip::dynamics::{DynamicsRef, Interrupt, Section};
use stickslip::error::readable;
use stickslip::nalgebra::{DMatrix, DVector};
use stickslip::scalar::Dual;
use stickslip::{AbsoluteTolerance, Direction, Error, Scalar};

use super::build::{self, Built, TapeBuild};
use super::builder::{Freed, NONE_FREE};
use super::formulas::FormulaKey;
use super::template::{Family, Template};
use super::{
    FileError, Formula, Problem, SectionEntry, Source, StateEntry, SystemFile, did_you_mean,
};
use crate::expression::Tape;
use crate::kernel::{
    Combination, Equations, HELD_PER_INPUT, SectionFunction, Size, Switching, TapedContacts,
    TapedFilippov, dynamics, sides_to_check,
};

/// Number of random states at which a period or the boundaries are checked. It is chosen: one that
/// is not special would do.
const PROBE_STATES: usize = 16;

/// Newton iterations. Where gradients are dependent, each iteration halves the remaining distance.
const NEWTON_STEPS: usize = 60;

/// Gradients of length 1 are dependent if a singular value is below this. It is ten times the limit
/// in a run, which may come nearer.
const DEPENDENT_SINGULAR_VALUE: f64 = 1e-5;

/// Distance from a boundary that Newton's iteration leaves, relative to the state: some hundred
/// units in the last place.
const BOUNDARY_DISTANCE: f64 = 1e-13;

/// Relative difference of the field after a period that counts as rounding. It is chosen so that a
/// period may be written with seven digits.
const PERIOD_TOLERANCE: f64 = 1e-6;

/// A system ready to run.
pub struct System {
    /// The source file.
    pub file: Arc<SystemFile>,
    /// Values of the parameters, in the order of the file.
    pub values: Vec<f64>,
    /// Equations.
    pub built: Built,
    dynamics: DynamicsRef<'static>,
    interrupt: Option<Arc<Interrupt>>,
    /// The builds of the file, which systems with other values share.
    family: Arc<Family>,
    /// The build that the tapes are of.
    template: Arc<Template>,
}

/// Reason for which attractors of a time-dependent system cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PeriodError {
    /// No period is given.
    #[error(
        "the system depends on time: what is its period? Add period = \"…\" to [time] of the file"
    )]
    Missing,
    /// The given period is not a period.
    #[error(
        "the field, a boundary or a jump is not the same after the file's period {}; correct the \
            period in [time]", readable(*period)
    )]
    Wrong {
        /// The period given.
        period: f64,
    },
}

/// Reason for which a parameter cannot be set.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SettingError {
    /// No parameter has this name.
    #[error("there is no parameter `{name}`; {help}")]
    Unknown {
        /// Name given.
        name: String,
        /// A suggestion, or the names that exist.
        help: String,
    },
    /// The value is outside the range in the file.
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
    /// The period in the file is none of the system with the value.
    #[error(
        "with {name} = {} the system is not the same after the file's period {}: write the period \
            as a formula of `{name}`, as in period = \"2*pi/{name}\"", readable(*value),
            readable(*period)
    )]
    OtherPeriod {
        /// Name.
        name: String,
        /// Value.
        value: f64,
        /// The period there.
        period: f64,
    },
    /// A parameter is set twice.
    #[error("the parameter `{name}` is set twice; set it once")]
    Twice {
        /// Name.
        name: String,
    },
    /// An expression of the file cannot be evaluated with the values.
    #[error(transparent)]
    File(#[from] FileError),
}

impl SystemFile {
    /// The system with some of its parameters set to other values.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown name, a value outside the parameter's range, or a value with
    /// which an expression is not a finite number.
    pub fn with(&self, settings: &[(String, f64)]) -> Result<System, SettingError> {
        let values = self.values_with(build::values(self), settings)?;
        let known = self.checked.family(self);
        let family = known.unwrap_or_else(|| Arc::new(Family::new(Arc::new(self.clone()))));
        Ok(System::new(family, values, None)?)
    }

    /// The number of a parameter.
    ///
    /// # Errors
    /// [`SettingError::Unknown`].
    pub fn parameter(&self, name: &str) -> Result<usize, SettingError> {
        let known = self.parameters.iter();
        let known = known.map(|parameter| parameter.name.as_str());
        let plain = crate::expression::normal(name);
        let number = known.clone().position(|known| known == plain);
        number.ok_or_else(|| {
            let all: Vec<&str> = known.clone().collect();
            let help = did_you_mean(name, known).unwrap_or_else(|| match all.is_empty() {
                true => "the system has none".to_owned(),
                false => format!("there are {}", all.join(", ")),
            });
            let name = name.to_owned();
            SettingError::Unknown { name, help }
        })
    }

    fn values_with(
        &self,
        mut values: Vec<f64>,
        settings: &[(impl AsRef<str>, f64)],
    ) -> Result<Vec<f64>, SettingError> {
        for (i, &(ref name, value)) in settings.iter().enumerate() {
            let number = self.parameter(name.as_ref())?;
            let name = name.as_ref().to_owned();
            if settings[..i]
                .iter()
                .any(|(other, _)| other.as_ref() == name)
            {
                return Err(SettingError::Twice { name });
            }
            if let Some((low, high)) = self.parameters[number].range
                && !(low..=high).contains(&value)
            {
                return Err(SettingError::OutsideRange {
                    name,
                    value,
                    low,
                    high,
                });
            }
            values[number] = value;
        }
        Ok(values)
    }
}

impl System {
    /// The system of a family with these values of the parameters.
    fn new(
        family: Arc<Family>,
        values: Vec<f64>,
        interrupt: Option<Arc<Interrupt>>,
    ) -> Result<System, FileError> {
        let (built, template) = family.system(&values, NONE_FREE)?;
        System::of((family, template), values, built, interrupt)
    }

    /// The system of these tapes.
    fn of(
        (family, template): (Arc<Family>, Arc<Template>),
        values: Vec<f64>,
        built: Built,
        interrupt: Option<Arc<Interrupt>>,
    ) -> Result<System, FileError> {
        let file = Arc::clone(family.file());
        let states = file.states.len();
        let with = (sections(&file, &built), interrupt.clone());
        let dynamics = solver(&file, &built, with, states)?;
        Ok(System {
            file,
            values,
            built,
            dynamics,
            interrupt,
            family,
            template,
        })
    }

    /// Number of times that formulas were built for this system and its relatives. Relatives differ
    /// in values of parameters, in free parameters or in the interrupt. As a rule, formulas are
    /// built once for each set of free parameters, and once for each observed formula. A value that
    /// changes what is left out of a formula builds it again, such as a factor that is exactly 0 or
    /// 1.
    pub fn builds(&self) -> usize {
        self.family.builds()
    }

    /// The system with other values of some parameters, by name.
    ///
    /// # Errors
    /// See [`SystemFile::with`].
    pub fn with_values(&self, given: &[(&str, f64)]) -> Result<System, SettingError> {
        let values = self.file.values_with(self.values.clone(), given)?;
        let (family, interrupt) = (self.family.clone(), self.interrupt.clone());
        Ok(System::new(family, values, interrupt)?)
    }

    /// The system with time that runs backwards: an orbit of it from `-t` is the past of the state
    /// at `t`. Times of the section are negative, too.
    ///
    /// # Errors
    /// [`FileError::Wrong`] for a formula that is not a finite number.
    pub fn reversed(&self) -> Result<System, FileError> {
        let file = SystemFile {
            is_reversed: !self.file.is_reversed,
            ..SystemFile::clone(&self.file)
        };
        let family = Arc::new(Family::new(Arc::new(file)));
        System::new(family, self.values.clone(), self.interrupt.clone())
    }

    /// The system with other sections.
    ///
    /// # Errors
    /// [`FileError::Wrong`] with the fault of a function.
    pub fn with_sections(&self, sections: &[(&str, Direction)]) -> Result<System, FileError> {
        let (mut file, mut builds) = (SystemFile::clone(&self.file), Vec::new());
        file.sections = Vec::new();
        for &(text, direction) in sections {
            let source = Source {
                name: "section".to_owned(),
                text: text.to_owned(),
            };
            let function = Formula::parsed(text, 0..text.len(), &source);
            let section = function.and_then(|function| {
                builds.push(build::section(&self.file, &self.values, &function)?);
                Ok(SectionEntry {
                    function,
                    direction,
                })
            });
            let section = section.map_err(|problem| FileError::wrong(problem, source))?;
            file.sections.push(section);
        }
        let template = self.template.with_sections(Arc::new(file), builds);
        let family = Arc::new(Family::of(template, self.builds()));
        System::new(family, self.values.clone(), self.interrupt.clone())
    }

    /// The system with orbits that end when `interrupt` is raised. This also holds for systems
    /// derived from it.
    ///
    /// # Errors
    /// See [`SystemFile::with`].
    pub fn interrupted_by(&self, interrupt: Arc<Interrupt>) -> Result<System, SettingError> {
        let of = (self.family.clone(), self.template.clone());
        let (values, built) = (self.values.clone(), self.built.clone());
        Ok(System::of(of, values, built, Some(interrupt))?)
    }

    /// The system with parameters as additional last states, in this order and at most
    /// [`super::MOST_FREE`], for continuation and for derivatives by them. An orbit that begins
    /// with their values has the bits of that of this system, unless one of them is an exponent.
    ///
    /// # Errors
    /// [`SettingError::File`] if the expressions are too large with additional states.
    pub fn with_states_of(
        &self,
        parameters: &[usize],
    ) -> Result<DynamicsRef<'static>, SettingError> {
        let free = Freed::of(parameters);
        let (built, _) = self.family.system(&self.values, free)?;
        let with = (sections(&self.file, &built), self.interrupt.clone());
        let states = self.states() + free.count();
        Ok(solver(&self.file, &built, with, states)?)
    }

    /// The tape of a formula beside the system, which systems with other values share.
    pub(super) fn formula_tape(
        &self,
        key: FormulaKey,
        build: impl FnOnce() -> Result<TapeBuild, Problem>,
    ) -> Result<Tape, Problem> {
        self.family.formulas.tape(key, &self.values, build)
    }

    /// The jumps and inputs, with free parameters as states.
    pub(super) fn switching_with(&self, free: Freed) -> Result<Switching, FileError> {
        Ok(self.family.system(&self.values, free)?.0.switching)
    }

    /// The period of a driven system; `None` for an autonomous one.
    ///
    /// # Errors
    /// [`PeriodError`] if the system depends on time and no valid period is given.
    pub fn checked_period(&self) -> Result<Option<f64>, PeriodError> {
        let period = self.built.period;
        match (period, self.is_periodic()) {
            (None, _) if self.built.depends_on_time => Err(PeriodError::Missing),
            (Some(period), Some(false)) => Err(PeriodError::Wrong { period }),
            _ => Ok(period),
        }
    }

    /// The system with other values of parameters along which driven orbits are followed.
    ///
    /// # Errors
    /// [`SettingError`]; also where the period of the file is none with these values.
    pub fn driven_with(&self, settings: &[(&str, f64)]) -> Result<System, SettingError> {
        let there = self.with_values(settings)?;
        match (there.built.period, there.is_periodic(), settings.first()) {
            (Some(period), Some(false), Some(&(name, value))) => Err(SettingError::OtherPeriod {
                name: name.to_owned(),
                value,
                period,
            }),
            _ => Ok(there),
        }
    }

    /// Whether field, boundaries and jumps repeat after a period, checked at some states; `None` if
    /// there is no period.
    pub fn is_periodic(&self) -> Option<bool> {
        let period = self.built.period?;
        let at = |t: f64, x: &[f64]| -> Vec<f64> {
            let heights = (0..self.contacts()).map(|contact| self.boundary(contact, t, x));
            let mut values: Vec<f64> = heights.collect();
            for above in sides_to_check(self.contacts()) {
                values.extend(self.field(Combination { above, held: 0 }, t, x));
            }
            let switching = &self.built.switching;
            let extended = switching.extended(t, x);
            for (number, jump) in switching.jumps.iter().enumerate() {
                let mut behind = extended.clone();
                jump.when.evaluate(t, &extended, &mut behind[..1]);
                values.push(behind[0]);
                let happens = switching.happens(number, t, &extended);
                values.push(f64::from(u8::from(happens)));
                behind.clone_from(&extended);
                switching.after(number, t, &mut behind);
                // What inputs hold depends on the time since they began.
                values.extend(&behind[..x.len()]);
            }
            values
        };
        let random = &mut SplitMix::new(2);
        Some(self.probes().iter().all(|x| {
            let t = self.built.t_start + random.between(0.0, period);
            let (now, later) = (at(t, x), at(t + period, x));
            // States at which a value is not finite do not count.
            now.iter().zip(&later).all(|(now, later)| {
                let off = (now - later).abs();
                off.is_nan() || off <= PERIOD_TOLERANCE * (1.0 + now.abs())
            })
        }))
    }

    /// Whether each input that repeats does so after the period of the file, as far as its clock
    /// tells. A kink that is moved by little is between most samples of the field.
    pub(crate) fn inputs_repeat(&self) -> bool {
        let Some(period) = self.built.period else {
            return true;
        };
        let x = self.start().unwrap_or_else(|| vec![0.0; self.states()]);
        let mut inputs = self.built.switching.inputs.iter();
        inputs.all(|input| {
            let turns = input.turns(self.built.t_start, period, &x);
            turns.is_none_or(|turns| (turns - turns.round()).abs() <= PERIOD_TOLERANCE)
        })
    }

    /// States around the start, or around zero.
    fn probes(&self) -> Vec<Vec<f64>> {
        let random = &mut SplitMix::new(1);
        let start = self.start();
        let start = start.unwrap_or_else(|| vec![0.0; self.states()]);
        let mut probe = |_| {
            start
                .iter()
                .map(|x| x + random.between(-1.0, 1.0))
                .collect()
        };
        (0..PROBE_STATES).map(&mut probe).collect()
    }

    /// Contacts whose boundaries vanish together at a state with dependent gradients, and that
    /// state. No run can pass through it. The search uses the start time and states around the
    /// start. With more than four contacts, only pairs are checked.
    pub fn dependent_boundaries(&self) -> Option<(Vec<usize>, Vec<f64>)> {
        let most = if self.contacts() <= 4 { 4 } else { 2 };
        let sets = 1..1_usize << self.contacts();
        // A subset has a smaller number than the sets that contain it.
        sets.filter(|set| set.count_ones() <= most).find_map(|set| {
            let contacts = (0..self.contacts()).filter(|contact| set >> contact & 1 == 1);
            let contacts: Vec<usize> = contacts.collect();
            let states = self.probes().into_iter();
            let found = states.filter_map(|x| self.dependence(&contacts, x)).next();
            found.map(|x| (contacts, x))
        })
    }

    /// Newton's iteration with minimum-norm steps to a common zero of the boundaries of these
    /// contacts. Returns the state if their gradients are dependent there.
    fn dependence(&self, contacts: &[usize], mut x: Vec<f64>) -> Option<Vec<f64>> {
        for _ in 0..NEWTON_STEPS {
            let at = |i: usize, k| self.boundary_and_slope(contacts[i], self.built.t_start, &x, k);
            let mut normals = DMatrix::from_fn(contacts.len(), x.len(), |i, k| at(i, k).1);
            let mut heights = DVector::from_fn(contacts.len(), |i, _| at(i, 0).0);
            for (mut normal, height) in normals.row_iter_mut().zip(heights.iter_mut()) {
                let size = normal.norm();
                if !(size > 0.0 && size.is_finite()) {
                    return None;
                }
                normal /= size;
                *height /= size;
            }
            let is_there = heights.amax()
                <= BOUNDARY_DISTANCE * x.iter().fold(1.0, |far: f64, x| far.max(x.abs()));
            let normals = normals.svd(true, true);
            if is_there {
                return (normals.rank(DEPENDENT_SINGULAR_VALUE) < contacts.len()).then_some(x);
            }
            let step = normals
                .solve(
                    &heights,
                    DEPENDENT_SINGULAR_VALUE * DEPENDENT_SINGULAR_VALUE,
                )
                .ok()?;
            x.iter_mut().zip(&step).for_each(|(x, step)| *x -= step);
        }
        None
    }

    /// The system in the form that the library's analyses take.
    pub fn dynamics(&self) -> &DynamicsRef<'static> {
        &self.dynamics
    }

    /// The sections of the system.
    pub fn sections(&self) -> Vec<Section> {
        (0..self.built.sections.len())
            .map(Section::OfSystem)
            .collect()
    }

    /// Initial state, if the file gives every component.
    pub fn start(&self) -> Option<Vec<f64>> {
        self.built.starts.iter().copied().collect()
    }

    /// Absolute tolerances of the states: those `given`, in the order of the states, or else those
    /// of the file, or else `other`. Where neither names one, `other` is that of all.
    ///
    /// # Errors
    /// [`Error::Tolerances`] where more are given than there are states.
    pub fn absolute_tolerance(
        &self,
        other: f64,
        given: &[Option<f64>],
    ) -> Result<AbsoluteTolerance, Error> {
        let states = self.states();
        if given.len() > states {
            let given = given.len();
            return Err(Error::Tolerances { given, states });
        }
        let of_state =
            |(i, state): (usize, &StateEntry)| given.get(i).copied().flatten().or(state.atol);
        // Discrete states follow those that move, and have no error.
        let moving = self.file.states.iter().enumerate();
        let moving = moving.filter(|(_, state)| !state.is_discrete);
        let each: Vec<Option<f64>> = moving.map(of_state).collect();
        if each.iter().all(Option::is_none) {
            return Ok(other.into());
        }
        let each: Vec<f64> = each.into_iter().map(|one| one.unwrap_or(other)).collect();
        AbsoluteTolerance::each(&each)
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.file.states.len()
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.file.contacts.len()
    }

    /// The boundary function of a contact, on any number type.
    pub fn boundary<T: Scalar>(&self, contact: usize, t: T, x: &[T]) -> T {
        let mut heights = vec![T::zero(); self.contacts()];
        let x = self.built.switching.extended(t.value(), x);
        self.built.boundaries.evaluate(t, &x, &mut heights);
        heights[contact]
    }

    /// The field of a combination of sides, on any number type.
    pub fn field<T: Scalar>(&self, of: Combination, t: T, x: &[T]) -> Vec<T> {
        let mut rates = vec![T::zero(); x.len()];
        let x = self.built.switching.extended(t.value(), x);
        self.built.fields.evaluate(of, t, &x, &mut rates);
        rates
    }

    /// The tape of the friction of each contact in a combination, as a size. `None` if all are
    /// constant.
    pub(crate) fn frictions(&self, of: Combination) -> Option<Tape> {
        let build = || build::frictions(&self.file, &self.values, of);
        let tape = self.formula_tape(FormulaKey::Frictions(of), build).ok()?;
        Some(tape).filter(|tape| !tape.is_constant())
    }

    /// The boundary function of a contact, and its derivative with respect to one state.
    pub fn boundary_and_slope(
        &self,
        contact: usize,
        t: f64,
        x: &[f64],
        state: usize,
    ) -> (f64, f64) {
        let seeded: Vec<Dual<f64>> = x
            .iter()
            .enumerate()
            .map(|(k, &x)| Dual::new(x, if k == state { 1.0 } else { 0.0 }))
            .collect();
        let height = self.boundary(contact, Dual::constant(t), &seeded);
        (height.re, height.eps)
    }
}

/// The sections of a system.
fn sections(file: &SystemFile, built: &Built) -> Vec<SectionFunction> {
    let sections = built.sections.iter().zip(&file.sections);
    let sections = sections.map(|(function, section)| SectionFunction {
        function: function.clone(),
        direction: section.direction,
    });
    sections.collect()
}

/// The solver for the equations of a file with this number of states, those that are parameters
/// among them.
fn solver(
    file: &SystemFile,
    built: &Built,
    (sections, interrupt): (Vec<SectionFunction>, Option<Arc<Interrupt>>),
    states: usize,
) -> Result<DynamicsRef<'static>, FileError> {
    let contacts = file.contacts.len();
    let switching = built.switching.clone();
    let room = switching.room();
    let size = Size { states, contacts };
    let equations = equations(file, built);
    let solver = dynamics(equations, sections, switching, size, interrupt);
    // The reader admits no more states and contacts than the solver supports.
    solver.filter(|_| contacts <= states).ok_or_else(|| {
        let message = if contacts > states {
            format!(
                "{contacts} contacts are too many for {states} states: their boundaries cannot be \
                    independent"
            )
        } else {
            format!(
                "{states} states and {} inputs are too many: each input holds {HELD_PER_INPUT} \
                    numbers, which leaves room for {} states",
                file.inputs.len(),
                (states + 66).saturating_sub(room)
            )
        };
        FileError::wrong(Problem::new(message, 0..0), file.source.clone())
    })
}

fn equations(file: &SystemFile, built: &Built) -> Equations {
    let Built {
        fields, boundaries, ..
    } = built;
    // Discrete states follow those that move.
    let states = file.states.iter();
    let dimension = states.filter(|state| !state.is_discrete).count();
    let one_contact = || {
        let both = |held: usize| {
            let tape = |above| fields.tape(Combination { above, held });
            Some([tape(0)?, tape(1)?])
        };
        Some(TapedFilippov {
            dimension,
            field: both(0)?,
            holding: match built.has_static {
                true => Some(both(1)?),
                false => None,
            },
            boundary: boundaries.clone(),
            normal_force: built.normal_force.clone(),
            period: built.free_period.clone(),
        })
    };
    match one_contact().filter(|_| fields.contacts() <= 1) {
        Some(system) => Equations::OneContact(Box::new(system)),
        None => Equations::ManyContacts(TapedContacts {
            dimension,
            fields: fields.clone(),
            has_static: built.has_static,
            frictions_add: built.frictions_add,
            boundaries: boundaries.clone(),
            period: built.free_period.clone(),
        }),
    }
}
