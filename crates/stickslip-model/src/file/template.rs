//! Systems that are built once for all values of their parameters.
//!
//! A build decides by values: it leaves out a factor of one, and refuses a period that is not
//! positive. A template records these decisions. For other values it computes the held numbers
//! anew, and gives, bit for bit, the system of a build with these values, if such a build would
//! decide the same. Otherwise the system is built again. A constant part of a formula decides by
//! being 0, 1 or −1 or not, and an exponent by being 0, 1/2, 1, another integer or none. Each check
//! decides, too.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

use stickslip::error::readable;

use super::build::{self, Built, SectionBuild, TapeBuild};
use super::builder::{Freed, Inputs};
use super::formulas::Formulas;
use super::problem::Problem;
use super::{FileError, Formula, SystemFile};
use crate::expression::{Graph, HeldNumbers, Id, Place, Tape};
use crate::kernel::{ByCombination, Combination, Fields, Switching, sides_to_check};

/// Most templates of a family. Chosen: a sweep meets few special values beside general ones.
const MOST_TEMPLATES: usize = 16;

/// The build of a system.
#[derive(Clone, Debug)]
pub(super) struct Template {
    file: Arc<SystemFile>,
    free: Freed,
    /// Values of the parameters of the build.
    values: Arc<[f64]>,
    fields: ByCombination<Option<TapeBuild>>,
    /// The combinations whose fields are checked before a run.
    checked: Vec<Combination>,
    has_static: bool,
    frictions_add: bool,
    depends_on_time: bool,
    /// The held numbers of the following tapes.
    held: Arc<HeldNumbers>,
    boundaries: Tape,
    normal_force: Option<Tape>,
    free_period: Option<Tape>,
    switching: Switching,
    sections: Vec<SectionBuild>,
    constants: Arc<Constants>,
}

/// Numbers of a file that are expressions of parameters alone, by place.
#[derive(Debug)]
struct Constants {
    held: HeldNumbers,
    period: Option<Place>,
    t_start: Option<Place>,
    t_end: Option<Place>,
    starts: Vec<Option<Place>>,
}

impl Template {
    /// Builds a file with these values of the parameters. The `free` parameters become states with
    /// zero rates, after those of the file.
    ///
    /// # Errors
    /// [`Problem`] if a constant part of an expression is not a finite number, or an expression is
    /// too large.
    pub(super) fn new(
        file: &Arc<SystemFile>,
        values: &[f64],
        free: Freed,
    ) -> Result<Template, Problem> {
        let (mut graph, mut numbers) = (Graph::new(), Graph::new());
        let period = build::period(file, values, &mut numbers)?;
        let inputs = Inputs::free(values, free);
        let contacts = file.contacts.len();
        let has_static = file
            .contacts
            .iter()
            .any(|contact| contact.holding.is_some());
        let fields = ByCombination::new(contacts);
        let checked = combinations(contacts, has_static);
        let mut depends_on_time = false;
        for &of in &checked {
            let (field, is_timed) = build::field(file, values, free, of)?;
            depends_on_time |= is_timed;
            fields.get_or_make(of, || Some(field.clone()));
        }
        let (mut heights, is_timed) = build::heights(file, inputs, &mut graph)?;
        depends_on_time |= is_timed;
        let (switching, is_timed) = build::switching(file, inputs, &mut graph)?;
        depends_on_time |= is_timed || !switching.inputs.is_empty();
        if heights.is_empty() {
            // A system without contacts has one side.
            heights.extend(graph.constant(1.0));
        }
        let mut alone =
            |formula: &Formula, place| build::alone(file, (&mut graph, inputs), formula, place);
        let forces = file.contacts.iter();
        let forces = forces.filter_map(|contact| contact.normal_force.as_ref());
        let forces = forces.map(|force| alone(force, "a normal force"));
        let mut forces = forces.collect::<Result<Vec<_>, _>>()?;
        // Of several contacts, friction alone vanishes with it.
        let normal_force = forces.pop().filter(|_| contacts == 1);
        let free_period = file.time.period.as_ref().filter(|_| free.count() > 0);
        let free_period = free_period.map(|period| alone(period, "a period"));
        let free_period = free_period.transpose()?;
        let sections = file.sections.iter();
        let sections = sections.map(|section| {
            let tape = alone(&section.function, build::SECTION)?;
            Ok(SectionBuild::OfSystem(tape))
        });
        let sections = sections.collect::<Result<_, _>>()?;
        let mut constant = |formula: &Option<Formula>, what| {
            build::constant(file, values, &mut numbers, (formula, what))
        };
        let t_start = constant(&file.time.start, "the start of a run")?;
        let t_end = constant(&file.time.end, "the end of a run")?;
        let frictions_add = build::frictions_add(file, values, free)?;
        let boundaries = build::tape(file, &graph, &heights, inputs)?;
        let starts = file.states.iter();
        let starts = starts.map(|state| constant(&state.start, "a start"));
        let starts: Vec<Option<Id>> = starts.collect::<Result<_, _>>()?;
        let value = |number: Option<Id>| number.and_then(|number| numbers.value(number));
        let span = [
            value(t_start).unwrap_or(0.0),
            value(t_end).unwrap_or(f64::INFINITY),
        ];
        if let (Some(formula), false) = (&file.time.end, is_span(span)) {
            let [start, end] = span.map(readable);
            let message = format!("the end {end} does not lie after the start {start}");
            return Err(Problem::new(message, formula.whole()));
        }
        let place = |number: Option<Id>| number.and_then(|number| numbers.place(number));
        let constants = Constants {
            period: place(period),
            t_start: place(t_start),
            t_end: place(t_end),
            starts: starts.into_iter().map(place).collect(),
            held: numbers.into_held_numbers(),
        };
        let template = Template {
            file: Arc::clone(file),
            free,
            values: values.into(),
            fields,
            checked,
            has_static,
            frictions_add,
            depends_on_time,
            held: Arc::new(graph.into_held_numbers()),
            boundaries,
            normal_force,
            free_period: free_period.filter(|period| !period.is_constant()),
            switching,
            sections,
            constants: Arc::new(constants),
        };
        Ok(template)
    }

    /// The system for these values of the parameters; `None` if a build with them would decide
    /// otherwise.
    pub(super) fn bound(&self, values: &[f64]) -> Option<Built> {
        let held = self.held.of(values)?;
        let numbers = self.constants.held.of(values)?;
        let number = |place: Option<Place>| place.and_then(|place| place.of(&numbers));
        let t_start = number(self.constants.t_start).unwrap_or(0.0);
        let t_end = number(self.constants.t_end);
        if !is_span([t_start, t_end.unwrap_or(f64::INFINITY)]) {
            return None;
        }
        let starts = self.constants.starts.iter();
        let sections = self.sections.iter();
        Some(Built {
            fields: self.fields(values)?,
            has_static: self.has_static,
            frictions_add: self.frictions_add,
            boundaries: self.boundaries.with_held(&held),
            normal_force: self
                .normal_force
                .as_ref()
                .map(|force| force.with_held(&held)),
            free_period: self.free_period.as_ref().map(|tape| tape.with_held(&held)),
            sections: sections
                .map(|section| section.bound(values, &held))
                .collect::<Option<_>>()?,
            starts: starts.map(|start| number(*start)).collect(),
            t_start,
            t_end,
            period: number(self.constants.period),
            depends_on_time: self.depends_on_time,
            switching: self.switching.with_held(&held),
        })
    }

    /// The fields for these values of the parameters: now of the combinations that are checked
    /// before a run, and of others on first use.
    fn fields(&self, values: &[f64]) -> Option<Fields> {
        let make = {
            let (known, free, file) = (self.fields.clone(), self.free, Arc::clone(&self.file));
            let (reference, values): (Arc<[f64]>, Arc<[f64]>) =
                (Arc::clone(&self.values), values.into());
            move |of: Combination| {
                let build = |values: &[f64]| Some(build::field(&file, values, free, of).ok()?.0);
                let field = known.get_or_make(of, || build(&reference));
                let bound = field.and_then(|field| field.as_ref()?.bound(&values));
                bound.or_else(|| Some(build(&values)?.tape))
            }
        };
        let fields = Fields::new(self.file.contacts.len(), Arc::new(make));
        for of in &self.checked {
            let known = self.fields.get_or_make(*of, || None)?.as_ref();
            fields.keep(*of, &known?.bound(values)?);
        }
        Some(fields)
    }

    /// Replaces the sections by others than those of the file.
    pub(super) fn with_sections(&self, file: Arc<SystemFile>, sections: Vec<SectionBuild>) -> Self {
        Template {
            file,
            sections,
            ..self.clone()
        }
    }
}

/// Whether a run can have this start and end.
fn is_span([start, end]: [f64; 2]) -> bool {
    end > start
}

/// The combinations whose fields are checked before a run.
fn combinations(contacts: usize, has_static: bool) -> Vec<Combination> {
    let all = (1 << contacts) - 1;
    let held = match (has_static, contacts) {
        (false, _) => vec![0],
        (true, 0..=4) => (0..=all).collect(),
        (true, _) => vec![0, all],
    };
    let sides = sides_to_check(contacts).into_iter();
    let with = |above| held.iter().map(move |&held| Combination { above, held });
    sides.flat_map(with).collect()
}

/// The builds of a file, of which there is one since it was checked.
#[derive(Clone, Debug, Default)]
pub(super) struct Checked(Option<Arc<Family>>);

/// Files are compared by their content.
impl PartialEq for Checked {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Checked {
    /// The builds of a file whose check made this one.
    pub(super) fn of(template: Template) -> Self {
        Checked(Some(Arc::new(Family::of(template, 1))))
    }

    /// The builds of a file, unless its content is another now.
    pub(super) fn family(&self, file: &SystemFile) -> Option<Arc<Family>> {
        self.0.clone().filter(|family| *family.file == *file)
    }
}

/// The builds of one file.
#[derive(Debug)]
pub(super) struct Family {
    file: Arc<SystemFile>,
    /// The last one first.
    templates: RwLock<Vec<Arc<Template>>>,
    builds: AtomicUsize,
    /// Formulas beside the system.
    pub(super) formulas: Formulas,
}

impl Family {
    /// Nothing is built yet.
    pub(super) fn new(file: Arc<SystemFile>) -> Self {
        Family {
            file,
            templates: RwLock::default(),
            builds: AtomicUsize::new(0),
            formulas: Formulas::default(),
        }
    }

    /// The builds of a file that has one build already, which counts or does not.
    pub(super) fn of(template: Template, builds: usize) -> Self {
        Family {
            file: Arc::clone(&template.file),
            templates: RwLock::new(vec![Arc::new(template)]),
            builds: AtomicUsize::new(builds),
            formulas: Formulas::default(),
        }
    }

    /// Number of builds so far, with those of formulas beside the system.
    pub(super) fn builds(&self) -> usize {
        self.builds.load(Ordering::Relaxed) + self.formulas.builds()
    }

    /// The file.
    pub(super) fn file(&self) -> &Arc<SystemFile> {
        &self.file
    }

    /// The system with these values of the parameters, of which some are free, and its template. It
    /// is built if no template holds for the values.
    ///
    /// # Errors
    /// [`FileError::Wrong`] with the fault in the file.
    pub(super) fn system(
        &self,
        values: &[f64],
        free: Freed,
    ) -> Result<(Built, Arc<Template>), FileError> {
        let known = |templates: &[Arc<Template>]| {
            let mut of_kind = templates.iter().filter(|template| template.free == free);
            of_kind.find_map(|template| Some((template.bound(values)?, Arc::clone(template))))
        };
        // A thread that panicked left complete templates.
        let templates = self
            .templates
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known(&templates) {
            return Ok(found);
        }
        drop(templates);
        // Other threads wait for the build that they are likely to need, too.
        let mut templates = self
            .templates
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known(&templates) {
            return Ok(found);
        }
        self.builds.fetch_add(1, Ordering::Relaxed);
        let wrong = |problem| FileError::wrong(problem, self.file.source.clone());
        let template = Arc::new(Template::new(&self.file, values, free).map_err(wrong)?);
        let built = template.bound(values).ok_or_else(|| {
            let message = "a constant part of a formula is not finite with these values";
            wrong(Problem::new(message, 0..0).help("change the values of parameters"))
        })?;
        templates.insert(0, Arc::clone(&template));
        templates.truncate(MOST_TEMPLATES);
        Ok((built, template))
    }
}
