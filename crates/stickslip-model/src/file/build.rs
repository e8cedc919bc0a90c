//! Builds tapes from the expressions of a file.

use std::sync::Arc;

use stickslip::error::readable;
use stickslip::{Mode, Side};

use super::builder::{Builder, Freed, Inputs, NONE_FREE, NUMBERS, Scope, no_number};
use super::names::{Meaning, Names};
use super::problem::Problem;
use super::template::Template;
use super::{Formula, InputShape, Rate, StopEvent, SystemFile};
use crate::expression::{
    Binary, Expression, ExpressionKind, Graph, HeldNumbers, Id, Tape, Test, TooLarge,
};
use crate::kernel::{
    Choice, Combination, Fields, HELD_PER_INPUT, Input, Jump, JumpCondition, Map, Shape, Switching,
    pulse,
};

/// The tapes of a system, for values of its parameters.
#[derive(Clone, Debug)]
pub struct Built {
    /// The fields.
    pub fields: Fields,
    /// Whether any contact has static friction of its own.
    pub has_static: bool,
    /// Whether frictions add for certain.
    pub frictions_add: bool,
    /// The boundary functions of all contacts.
    pub boundaries: Tape,
    /// The normal force of the only contact, if contact can be lost. With several contacts, the
    /// friction of each has it in it.
    pub normal_force: Option<Tape>,
    /// The functions of the sections.
    pub sections: Vec<Tape>,
    /// Initial value of each state, as far as the file gives it. Discrete states have one.
    pub starts: Vec<Option<f64>>,
    /// Start time of runs.
    pub t_start: f64,
    /// Default end time of runs.
    pub t_end: Option<f64>,
    /// Period in time.
    pub period: Option<f64>,
    /// Period of the drive, where it depends on free parameters.
    pub free_period: Option<Tape>,
    /// Whether a field or boundary depends on time.
    pub depends_on_time: bool,
    /// Jumps and inputs.
    pub switching: Switching,
}

/// The value of an expression without variables.
pub(super) fn value(formula: &Formula) -> Result<f64, Problem> {
    let file = SystemFile {
        names: Names::constants(),
        ..SystemFile::default()
    };
    folded(&file, &[], formula, NUMBERS)
}

/// Checks every expression of the file, used or not, and builds it.
pub(super) fn check(file: &Arc<SystemFile>) -> Result<Template, Problem> {
    let mut graph = Graph::new();
    let values = values(file);
    let scope = Scope::Sides(Combination { above: 0, held: 0 });
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
    // Definitions that are built already have marked their sides. Here the sides that the field
    // uses are counted.
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
    for contact in &file.contacts {
        let mut laws = [&contact.friction, &contact.holding].into_iter().flatten();
        if let Some(force) = &contact.normal_force
            && let Some(law) = laws.find(|law| has_reaction(file, &law.tree))
        {
            let message = format!(
                "the friction of contact `{}` follows a reaction, and the contact has a normal \
                 force",
                contact.name
            );
            return Err(Problem::new(message, force.whole())
                .also(law.whole(), "this friction")
                .help("a reaction is the normal force: leave `normal_force` out"));
        }
    }
    Template::new(file, &values, NONE_FREE)
}

/// Whether an expression, or a definition in it, has the reaction of a stop.
fn has_reaction(file: &SystemFile, expression: &Expression) -> bool {
    has_name(file, expression, &|meaning| {
        matches!(meaning, Meaning::Force(_))
    })
}

/// Whether an expression, or a definition in it, has a name with a wanted meaning.
pub(super) fn has_name(
    file: &SystemFile,
    expression: &Expression,
    is_wanted: &dyn Fn(Meaning) -> bool,
) -> bool {
    let of = |expression: &Expression| has_name(file, expression, is_wanted);
    match &expression.kind {
        ExpressionKind::Number(_) => false,
        ExpressionKind::Name(name) => match file.names.get(name) {
            Some(Meaning::Definition(number)) => of(&file.definitions[number].formula.tree),
            Some(meaning) => is_wanted(meaning),
            None => false,
        },
        ExpressionKind::Negative(inner) => of(inner),
        ExpressionKind::Chain(first, rest) => of(first) || rest.iter().any(|(_, one)| of(one)),
        ExpressionKind::Condition(condition) => condition.numbers().into_iter().any(of),
        ExpressionKind::Call { arguments, .. } => arguments.iter().any(of),
    }
}

/// The parameter values given in the file.
pub(crate) fn values(file: &SystemFile) -> Vec<f64> {
    file.parameters
        .iter()
        .map(|parameter| parameter.value)
        .collect()
}

/// Name of a section's formula in messages.
pub(super) const SECTION: &str = "a section";

/// The tape of a formula without sides, at a place of this name.
pub(super) fn alone(
    file: &Arc<SystemFile>,
    (graph, inputs): (&mut Graph, Inputs<'_>),
    formula: &Formula,
    place: &'static str,
) -> Result<Tape, Problem> {
    let scope = Scope::NoSides(place);
    let root = Builder::new(file, inputs, graph, scope).formula(formula)?;
    tape(file, graph, &[root], inputs)
}

/// The tape of a formula of time, states and inputs; the `free` parameters are states behind them.
///
/// # Errors
/// [`Problem`] of the formula.
pub(super) fn formula(
    file: &Arc<SystemFile>,
    values: &[f64],
    free: Freed,
    formula: &Formula,
) -> Result<TapeBuild, Problem> {
    let mut graph = Graph::new();
    let inputs = Inputs::free(values, free);
    let tape = alone(file, (&mut graph, inputs), formula, "what is observed")?;
    Ok(TapeBuild::new(graph, tape))
}

/// The tape of [`formula`] in a mode of the only contact, whose friction force may stand in it.
///
/// # Errors
/// [`Problem`] of a formula.
pub(super) fn formula_in_mode(
    file: &Arc<SystemFile>,
    values: &[f64],
    free: Freed,
    (formula, mode): (&Formula, Mode),
) -> Result<TapeBuild, Problem> {
    let mut graph = Graph::new();
    let inputs = Inputs::free(values, free);
    let mut on_side = |above: usize, held: usize| {
        let scope = Scope::Sides(Combination { above, held });
        Builder::new(file, inputs, &mut graph, scope).force_and_rate(0)
    };
    let force = match mode {
        Mode::Slip(side) => on_side(usize::from(side == Side::Above), 0)?[0],
        Mode::Stick => {
            let [[below, falls], [above, rises]] = [on_side(0, 1)?, on_side(1, 1)?];
            // The part of the side above in Filippov's combination keeps the rate at zero.
            let force = (|| {
                let relative = graph.binary(Binary::Difference, falls, rises)?;
                let part = graph.binary(Binary::Quotient, falls, relative)?;
                let more = graph.binary(Binary::Difference, above, below)?;
                let more = graph.binary(Binary::Product, part, more)?;
                graph.binary(Binary::Sum, below, more)
            })();
            force.map_err(|error| no_number(error, formula.whole()))?
        }
    };
    let scope = Scope::NoSides("what is observed");
    let builder = Builder::new(file, inputs, &mut graph, scope);
    let root = builder.with_friction_forces(vec![force]).formula(formula)?;
    let tape = tape(file, &graph, &[root], inputs)?;
    Ok(TapeBuild::new(graph, tape))
}

/// The tape of a section for these parameter values.
///
/// # Errors
/// [`Problem`] of the function.
pub(super) fn section(
    file: &Arc<SystemFile>,
    values: &[f64],
    function: &Formula,
) -> Result<SectionBuild, Problem> {
    let mut graph = Graph::new();
    let inputs = Inputs::fixed(values);
    let tape = alone(file, (&mut graph, inputs), function, SECTION)?;
    Ok(SectionBuild::Alone(TapeBuild::new(graph, tape)))
}

/// A tape, and the held numbers of its graph.
#[derive(Clone, Debug)]
pub(super) struct TapeBuild {
    pub tape: Tape,
    held: Arc<HeldNumbers>,
}

impl TapeBuild {
    /// A tape of this graph.
    pub(super) fn new(graph: Graph, tape: Tape) -> Self {
        let held = Arc::new(graph.into_held_numbers());
        TapeBuild { tape, held }
    }

    /// The tape for these values of the parameters; `None` if a build with them would decide
    /// otherwise.
    pub(super) fn bound(&self, values: &[f64]) -> Option<Tape> {
        Some(self.tape.with_held(&self.held.of(values)?))
    }
}

/// The tape of a section: of a graph of its own, or of that of the system.
#[derive(Clone, Debug)]
pub(super) enum SectionBuild {
    Alone(TapeBuild),
    OfSystem(Tape),
}

impl SectionBuild {
    /// The tape for these values of the parameters, for which the graph of the system has these
    /// held numbers; `None` if a build with them would decide otherwise.
    pub(super) fn bound(&self, values: &[f64], held: &Arc<[f64]>) -> Option<Tape> {
        match self {
            SectionBuild::Alone(build) => build.bound(values),
            SectionBuild::OfSystem(tape) => Some(tape.with_held(held)),
        }
    }
}

/// The boundary functions of all contacts, and whether one depends on time.
pub(super) fn heights(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
) -> Result<(Vec<Id>, bool), Problem> {
    let mut depends_on_time = false;
    let mut heights = Vec::with_capacity(file.contacts.len());
    for contact in &file.contacts {
        let scope = Scope::NoSides("a boundary");
        let height = Builder::new(file, inputs, graph, scope).formula(&contact.boundary)?;
        let is_moving = |of: usize| match file.states.get(of) {
            Some(state) => !state.is_discrete,
            None => false,
        };
        if !graph.depends_on_states(height, is_moving) {
            let message = format!(
                "the boundary of contact `{}` depends on no state that moves",
                contact.name
            );
            return Err(Problem::new(message, contact.boundary.whole()).help(
                "a boundary is where a function of the states is zero, as in \"v - vp\"; what \
                     switches with time alone is written as [switches.NAME] with function = \"…\"",
            ));
        }
        depends_on_time |= graph.depends_on_time(height);
        heights.push(height);
    }
    Ok((heights, depends_on_time))
}

/// The number of an expression of parameters alone, if there is one.
pub(super) fn constant(
    file: &SystemFile,
    values: &[f64],
    graph: &mut Graph,
    (formula, what): (&Option<Formula>, &'static str),
) -> Result<Option<Id>, Problem> {
    let (formula, scope) = (formula.as_ref(), Scope::Constant(what));
    let inputs = Inputs::fixed(values);
    let number = formula.map(|formula| Builder::new(file, inputs, graph, scope).formula(formula));
    number.transpose()
}

/// The tapes of jumps and inputs, and whether a jump depends on time.
pub(super) fn switching(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
) -> Result<(Switching, bool), Problem> {
    let mut is_timed = false;
    let mut sets = Vec::with_capacity(file.jumps.len());
    let mut jumps = Vec::with_capacity(file.jumps.len());
    let stops = match file.stops.is_empty() {
        true => None,
        false => Some(super::stops::built(file, inputs, graph)?),
    };
    for entry in &file.jumps {
        if let (Some(stops), Some((stop, event))) = (&stops, entry.of_stop) {
            let when = stops.when(stop, event);
            is_timed |= graph.depends_on_time(when);
            let map = match event {
                StopEvent::Impact => Map::Impact(stop),
                StopEvent::Landing => Map::Landing(stop),
                StopEvent::LiftOff => Map::LiftOff(stop),
            };
            let states = 0..file.states.len();
            sets.push(states.map(|state| graph.state(state)).collect());
            jumps.push(Jump {
                when: tape(file, graph, &[when], inputs)?,
                direction: entry.direction,
                condition: None,
                choices: Vec::new(),
                set: map,
                most: None,
                of_stop: entry.of_stop,
            });
            continue;
        }
        let scope = Scope::NoSides("a jump");
        let when = Builder::new(file, inputs, graph, scope).formula(&entry.when)?;
        if !graph.depends_on_state(when) && !graph.depends_on_time(when) {
            let message = format!("`when` of the jump `{}` is constant", entry.name);
            return Err(Problem::new(message, entry.when.whole())
                .help("it is a function of states or of time, and its zero is where they jump"));
        }
        let mut set = Vec::with_capacity(entry.set.len());
        let mut choices = Vec::new();
        for (number, formula) in entry.set.iter().enumerate() {
            set.push(match formula {
                Some(formula) => {
                    let builder = Builder::new(file, inputs, graph, scope);
                    let (root, made) = builder.choosing().with_choices(formula)?;
                    let first = choices.len();
                    for one in made {
                        let of = one
                            .within
                            .iter()
                            .map(|(number, holds)| (first + number, *holds));
                        choices.push(Choice {
                            within: of.collect(),
                            condition: JumpCondition {
                                count: one.leads.len(),
                                leads: tape(file, graph, &one.leads, inputs)?,
                                test: one.test,
                            },
                        });
                    }
                    root
                }
                None => graph.state(number),
            });
        }
        if entry.most.is_none()
            && set
                .iter()
                .enumerate()
                .all(|(number, id)| *id == graph.state(number))
        {
            let message = format!("the jump `{}` sets every state to what it is", entry.name);
            return Err(Problem::new(message, entry.place.clone())
                .help("set = { v = \"-r*v\" } changes `v`; stop = true ends the run there"));
        }
        let condition = match entry
            .condition
            .as_ref()
            .map(|formula| (formula, &formula.tree.kind))
        {
            Some((formula, ExpressionKind::Condition(test))) => {
                let builder = Builder::new(file, inputs, graph, scope);
                Some((test, builder.choosing().leads(formula, test)?))
            }
            _ => None,
        };
        let leads = condition.iter().flat_map(|(_, leads)| leads);
        let all = set.iter().chain([&when]).chain(leads);
        is_timed |= all.into_iter().any(|&id| graph.depends_on_time(id));
        jumps.push(Jump {
            when: tape(file, graph, &[when], inputs)?,
            direction: entry.direction,
            condition: match condition {
                None => None,
                Some((test, leads)) => Some(JumpCondition {
                    test: (**test).clone(),
                    count: leads.len(),
                    leads: tape(file, graph, &leads, inputs)?,
                }),
            },
            choices,
            set: Map::Formulas(tape(file, graph, &set, inputs)?),
            most: entry.most,
            of_stop: None,
        });
        sets.push(set);
    }
    let mut made = Vec::with_capacity(file.inputs.len());
    for entry in &file.inputs {
        let scope = Scope::NoSides("an input");
        let clock = Builder::new(file, inputs, graph, scope).clock(entry)?;
        if let InputShape::Switch(function) = &entry.shape {
            let is_free = inputs.count_free() > 0;
            let wrong = if graph.depends_on_state(clock) && !is_free {
                Some((
                    "depends on a state or another input",
                    "a switch is the sign of a function of time; what depends on states is a \
                     contact, or a jump that sets a discrete state",
                ))
            } else if !graph.depends_on_time(clock) {
                Some((
                    "does not depend on time",
                    "a switch is the sign of a function of time, as in \"sin(w*t)\"; what is \
                     constant is a parameter",
                ))
            } else {
                None
            };
            if let Some((what, help)) = wrong {
                let message = format!("the function of the switch `{}` {what}", entry.name);
                return Err(Problem::new(message, function.whole()).help(help));
            }
        }
        let mut held_width = None;
        made.push(Input {
            clock: tape(file, graph, &[clock], inputs)?,
            shape: match &entry.shape {
                InputShape::Periodic {
                    width: Some(width), ..
                } => {
                    let width =
                        Builder::new(file, inputs, graph, scope).of_input(width, "width")?;
                    held_width = graph.place(width);
                    match graph.value(width) {
                        Some(width) => Shape::Repeated(pulse(width).to_vec()),
                        None => Shape::Pulse(tape(file, graph, &[width], inputs)?),
                    }
                }
                InputShape::Periodic { pieces, .. } => Shape::Repeated(pieces.clone()),
                InputShape::Table { pieces, .. } => Shape::Once(pieces.clone()),
                InputShape::Switch(_) => Shape::Sign,
            },
            width: held_width,
        });
    }
    let switching = Switching {
        jumps,
        impacts: stops.map(|stops| stops.impacts),
        inputs: made,
        states: file.states.len() + inputs.count_free(),
        discrete: discrete(file, graph, &sets),
        constant_between_jumps: constant_between_jumps(file),
    };
    Ok((switching, is_timed))
}

/// The states that jumps alone change.
fn constant_between_jumps(file: &SystemFile) -> Vec<bool> {
    file.states.iter().map(|state| state.is_discrete).collect()
}

/// The states that jumps set to isolated values: to expressions of constants and such states, of
/// which a condition may choose one. A state that is multiplied by a factor, or set to a curved
/// function of its value, has a continuum of neighbours instead, which approach it or part.
fn discrete(file: &SystemFile, graph: &mut Graph, sets: &[Vec<Id>]) -> Vec<bool> {
    let mut discrete = constant_between_jumps(file);
    loop {
        let mut is_held = |state: usize| {
            let varies = |of: usize| discrete.get(of) != Some(&true);
            discrete[state]
                && sets.iter().any(|set| {
                    let others = (0..discrete.len()).filter(|&other| discrete[other]);
                    !graph.is_isolated_from(set[state], varies)
                        || graph.multiplies(set[state], others).unwrap_or(false)
                })
        };
        match (0..discrete.len()).find(|&state| is_held(state)) {
            Some(state) => discrete[state] = false,
            None => return discrete,
        }
    }
}

/// The tape of the friction of each contact in a combination, as a size.
pub(super) fn frictions(
    file: &SystemFile,
    values: &[f64],
    of: Combination,
) -> Result<TapeBuild, Problem> {
    let (mut graph, inputs) = (Graph::new(), Inputs::fixed(values));
    let mut builder = Builder::new(file, inputs, &mut graph, Scope::Sides(of));
    let contacts = 0..file.contacts.len();
    let sizes = contacts.map(|contact| builder.size(contact));
    let sizes: Vec<Id> = sizes.collect::<Result<_, _>>()?;
    let tape = tape(file, &graph, &sizes, inputs)?;
    Ok(TapeBuild::new(graph, tape))
}

/// Whether no rate depends on the sides of two contacts, in slip or while contacts hold, so that
/// frictions add.
pub(super) fn frictions_add(
    file: &SystemFile,
    values: &[f64],
    free: Freed,
) -> Result<bool, Problem> {
    if !file.stops.is_empty() {
        return Ok(false);
    }
    let mut graph = Graph::new();
    let inputs = Inputs::free(values, free);
    let all = (1 << file.contacts.len()) - 1;
    let mut sided = vec![0_usize; file.field.len()];
    for held in [0, all] {
        let scope = Scope::Sides(Combination { above: 0, held });
        let mut builder = Builder::new(file, inputs, &mut graph, scope);
        for (sided, rate) in sided.iter_mut().zip(&file.field) {
            builder.sided = 0;
            builder.forget();
            builder.formula(rate.on_side(false))?;
            *sided |= builder.sided;
        }
    }
    Ok(sided.iter().all(|sided| sided.count_ones() <= 1))
}

/// The field of one combination, and whether it depends on time.
pub(super) fn field(
    file: &SystemFile,
    values: &[f64],
    free: Freed,
    of: Combination,
) -> Result<(TapeBuild, bool), Problem> {
    let mut graph = Graph::new();
    let inputs = Inputs::free(values, free);
    let rates = Builder::new(file, inputs, &mut graph, Scope::Sides(of)).field()?;
    let is_timed = rates.iter().any(|&rate| graph.depends_on_time(rate));
    let tape = tape(file, &graph, &rates, inputs)?;
    Ok((TapeBuild::new(graph, tape), is_timed))
}

pub(super) fn tape(
    file: &SystemFile,
    graph: &Graph,
    roots: &[Id],
    inputs: Inputs<'_>,
) -> Result<Tape, Problem> {
    let states = file.states.len() + inputs.count_free() + HELD_PER_INPUT * file.inputs.len();
    let too_large = |error: TooLarge| Problem::new(error.to_string(), 0..0);
    Tape::new(graph, roots, states).map_err(too_large)
}

/// The period in time, which is positive; `None` if the file has none.
pub(super) fn period(
    file: &SystemFile,
    values: &[f64],
    graph: &mut Graph,
) -> Result<Option<Id>, Problem> {
    let wanted = (&file.time.period, "a period");
    let period = constant(file, values, graph, wanted)?;
    if let (Some(formula), Some(period)) = (&file.time.period, period)
        && !graph.is(period, Test::Positive)
    {
        let value = graph.value(period).unwrap_or(f64::NAN);
        return Err(Problem::new(
            format!("the period is {}, but must be positive", readable(value)),
            formula.whole(),
        ));
    }
    Ok(period)
}

/// The value of an expression of constants, which folds to one number.
fn folded(
    file: &SystemFile,
    values: &[f64],
    formula: &Formula,
    scope: Scope,
) -> Result<f64, Problem> {
    let mut graph = Graph::new();
    let built = Builder::new(file, Inputs::fixed(values), &mut graph, scope).formula(formula)?;
    Ok(graph.value(built).unwrap_or(f64::NAN))
}
