//! From the expressions of a file to tapes.

use super::builder::{Builder, Inputs, Scope, no_number};
use super::problem::Problem;
use super::{Formula, Rate, SystemFile};
use crate::expression::{Binary, Graph, Id, NotANumber, Tape, TooLarge};

/// The tapes of a system.
#[derive(Clone, Debug)]
pub struct Built {
    /// The fields.
    pub fields: Fields,
    /// The boundary functions of all contacts.
    pub boundaries: Tape,
    /// The normal force of the only contact, where contact can be lost.
    pub normal_force: Option<Tape>,
    /// The function of the section.
    pub section: Option<Tape>,
    /// State at the start; `None` where the file gives none.
    pub start: Option<Vec<f64>>,
    /// When runs begin.
    pub t_start: f64,
    /// When runs end unless told otherwise.
    pub t_end: Option<f64>,
    /// Period in time.
    pub period: Option<f64>,
    /// Whether field or boundaries depend on time.
    pub depends_on_time: bool,
}

/// The fields of all combinations of sides.
#[derive(Clone, Debug)]
pub struct Fields {
    /// In slip: bit `i` of the index is set where contact `i` is above.
    pub slip: Vec<Tape>,
    /// While contacts hold (those whose bits are set in the first index); empty where nothing differs then.
    pub holding: Vec<Vec<Tape>>,
}

/// The value of an expression of numbers alone.
pub(super) fn value(formula: &Formula) -> Result<f64, Problem> {
    let mut graph = Graph::new();
    let built = Builder::of_numbers(&mut graph, "the value of a parameter").formula(formula)?;
    // Of numbers alone everything folds.
    Ok(graph.value(built).unwrap_or(f64::NAN))
}

/// Finds what is wrong with any expression of the file, used or not.
pub(super) fn check(file: &SystemFile) -> Result<(), Problem> {
    let mut graph = Graph::new();
    let values = values(file);
    let scope = Scope::Sides { above: 0, held: 0 };
    let mut builder = Builder::new(file, Inputs::fixed(&values), &mut graph, scope);
    for definition in 0..file.definitions.len() {
        builder.definition(definition)?;
    }
    builder.sided = 0;
    let contacts = file.contacts.iter();
    for law in contacts
        .flat_map(|contact| [&contact.friction, &contact.holding])
        .flatten()
    {
        builder.formula(law)?;
    }
    builder.sided = 0;
    // Definitions already known have told their sides; here those that the field has are counted.
    builder.forget();
    for rate in &file.field {
        match rate {
            Rate::Same(formula) => {
                builder.formula(formula)?;
            }
            Rate::BySide { below, above } => {
                builder.formula(below)?;
                builder.formula(above)?;
                builder.sided |= 1;
            }
        }
    }
    for (i, contact) in file.contacts.iter().enumerate() {
        if contact.friction.is_some() && !builder.has_friction(i) {
            let message = format!(
                "the friction of contact `{}` is not used in [field]",
                contact.name
            );
            return Err(Problem::new(message, contact.place.clone())
                .help(format!("write friction({}) where it acts", contact.name)));
        }
        if builder.sided & 1 << i == 0 {
            let message = format!(
                "the field is the same on both sides of contact `{}`",
                contact.name
            );
            return Err(Problem::new(message, contact.place.clone()).help(format!(
                "its sign `{0}`, friction({0}) or by_side({0}, below, above) must stand in [field]",
                contact.name
            )));
        }
    }
    built(file, &values, Variant::AsWritten).map(drop)
}

/// The values of the parameters as the file has them.
pub(crate) fn values(file: &SystemFile) -> Vec<f64> {
    file.parameters
        .iter()
        .map(|parameter| parameter.value)
        .collect()
}

/// How parameters and time enter the tapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Variant {
    /// As in the file.
    AsWritten,
    /// This parameter is a state behind those of the file, whose rate is zero. Time is measured so that the period, if there is one, is
    /// everywhere what it is with the given values.
    Free(usize),
    /// Time is measured so that the period, if there is one, is this.
    InPeriod(f64),
}

/// The tapes with these values of the parameters.
///
/// # Errors
/// [`Problem`] where a constant part of an expression is no number with them, or an expression is too large.
pub(crate) fn built(file: &SystemFile, values: &[f64], variant: Variant) -> Result<Built, Problem> {
    let free = match variant {
        Variant::Free(parameter) => Some(parameter),
        Variant::AsWritten | Variant::InPeriod(_) => None,
    };
    let mut graph = Graph::new();
    let period = period(file, values)?;
    let inputs = Inputs::free(values, free);
    let reference = match variant {
        Variant::InPeriod(reference) => Some(reference),
        Variant::AsWritten | Variant::Free(_) => period,
    };
    let inputs = inputs.paced(pace(file, inputs, reference, &mut graph)?);
    let states = file.states.len() + usize::from(free.is_some());
    let tape = |graph: &Graph, roots: &[Id]| -> Result<Tape, Problem> {
        let too_large = |error: TooLarge| Problem::new(error.to_string(), 0..0);
        Tape::new(graph, roots, states).map_err(too_large)
    };
    let contacts = file.contacts.len();
    let combinations = 1 << contacts;
    let mut depends_on_time = false;

    let mut fields_of = |graph: &mut Graph, held: usize| -> Result<Vec<Tape>, Problem> {
        let mut tapes = Vec::with_capacity(combinations);
        for above in 0..combinations {
            let scope = Scope::Sides { above, held };
            let rates = Builder::new(file, inputs, graph, scope).field()?;
            depends_on_time |= rates.iter().any(|&rate| graph.depends_on_time(rate));
            tapes.push(tape(graph, &rates)?);
        }
        Ok(tapes)
    };
    let slip = fields_of(&mut graph, 0)?;
    let has_static = file
        .contacts
        .iter()
        .any(|contact| contact.holding.is_some());
    let holding = if has_static {
        let holding = (0..combinations).map(|held| fields_of(&mut graph, held));
        holding.collect::<Result<_, _>>()?
    } else {
        Vec::new()
    };

    let mut heights = Vec::with_capacity(contacts);
    for contact in &file.contacts {
        let scope = Scope::NoSides("a boundary");
        let height = Builder::new(file, inputs, &mut graph, scope).formula(&contact.boundary)?;
        if !graph.depends_on_state(height) {
            let message = format!(
                "the boundary of contact `{}` depends on no state",
                contact.name
            );
            return Err(Problem::new(message, contact.boundary.whole())
                .help("a boundary is where a function of the states is zero, as in \"v - vp\""));
        }
        depends_on_time |= graph.depends_on_time(height);
        heights.push(height);
    }
    let mut alone = |formula: &Formula, place| -> Result<Tape, Problem> {
        let scope = Scope::NoSides(place);
        let root = Builder::new(file, inputs, &mut graph, scope).formula(formula)?;
        tape(&graph, &[root])
    };
    let force = file
        .contacts
        .iter()
        .find_map(|contact| contact.normal_force.as_ref());
    let normal_force = force
        .map(|force| alone(force, "a normal force"))
        .transpose()?;
    let section = file.section.as_ref();
    let section = section
        .map(|section| alone(&section.function, "a section"))
        .transpose()?;
    let time = |formula: &Option<Formula>, what| {
        let formula = formula.as_ref();
        let value = formula.map(|formula| constant(file, values, formula, what));
        value.transpose()
    };
    let t_start = time(&file.time.start, "the start of a run")?.unwrap_or(0.0);
    let t_end = time(&file.time.end, "the end of a run")?;
    if let (Some(end), Some(formula)) = (t_end, &file.time.end)
        && end <= t_start
    {
        let message = format!("the end {end} does not lie after the start {t_start}");
        return Err(Problem::new(message, formula.whole()));
    }
    Ok(Built {
        fields: Fields { slip, holding },
        boundaries: tape(&graph, &heights)?,
        normal_force,
        section,
        start: start(file, values)?,
        t_start,
        t_end,
        period,
        depends_on_time,
    })
}

/// How fast the file's time passes where the period is to be `period`; `None` where it is that.
fn pace(
    file: &SystemFile,
    inputs: Inputs<'_>,
    period: Option<f64>,
    graph: &mut Graph,
) -> Result<Option<Id>, Problem> {
    let (Some(formula), Some(period)) = (&file.time.period, period) else {
        return Ok(None);
    };
    let scope = Scope::NoSides("a period");
    let free = Builder::new(file, inputs, graph, scope).formula(formula)?;
    if graph.value(free) == Some(period) {
        return Ok(None);
    }
    let wrong = |error: NotANumber| no_number(error, formula.whole());
    let period = graph.constant(period).map_err(wrong)?;
    let pace = graph.binary(Binary::Quotient, free, period);
    pace.map_err(wrong).map(Some)
}

fn start(file: &SystemFile, values: &[f64]) -> Result<Option<Vec<f64>>, Problem> {
    let given: Option<Vec<&Formula>> = file
        .states
        .iter()
        .map(|state| state.start.as_ref())
        .collect();
    let Some(given) = given else { return Ok(None) };
    let components = given
        .into_iter()
        .map(|formula| constant(file, values, formula, "a start"));
    components.collect::<Result<_, _>>().map(Some)
}

fn period(file: &SystemFile, values: &[f64]) -> Result<Option<f64>, Problem> {
    let Some(formula) = &file.time.period else {
        return Ok(None);
    };
    let period = constant(file, values, formula, "a period")?;
    if period > 0.0 {
        return Ok(Some(period));
    }
    Err(Problem::new(
        format!("the period is {period}, but must be positive"),
        formula.whole(),
    ))
}

fn constant(
    file: &SystemFile,
    values: &[f64],
    formula: &Formula,
    what: &'static str,
) -> Result<f64, Problem> {
    let mut graph = Graph::new();
    let inputs = Inputs::fixed(values);
    let mut builder = Builder::new(file, inputs, &mut graph, Scope::Constant(what));
    let built = builder.formula(formula)?;
    Ok(graph.value(built).unwrap_or(f64::NAN))
}
