//! Builds tapes from the expressions of a file.

use std::sync::Arc;

use stickslip::error::readable;

use super::builder::{Builder, Freed, Inputs, NONE_FREE, NUMBERS, Scope, no_number};
use super::names::{Meaning, Names};
use super::problem::Problem;
use super::{Formula, InputShape, Rate, StopEvent, SystemFile};
use crate::expression::{
    Binary, Expression, ExpressionKind, Graph, Id, NotANumber, Tape, TooLarge,
};
use crate::kernel::{
    Choice, Combination, Fields, HELD_PER_INPUT, Input, Jump, JumpCondition, Map, Shape, Switching,
    pulse, sides_to_check,
};

/// The tapes of a system.
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

/// Checks every expression of the file, used or not.
pub(super) fn check(file: &Arc<SystemFile>) -> Result<(), Problem> {
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
    built(file, &values, NONE_FREE).map(drop)
}

/// Whether an expression, or a definition in it, has the reaction of a stop.
fn has_reaction(file: &SystemFile, expression: &Expression) -> bool {
    let of = |expression: &Expression| has_reaction(file, expression);
    match &expression.kind {
        ExpressionKind::Number(_) => false,
        ExpressionKind::Name(name) => match file.names.get(name) {
            Some(Meaning::Force(_)) => true,
            Some(Meaning::Definition(number)) => of(&file.definitions[number].formula.tree),
            _ => false,
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
const SECTION: &str = "a section";

/// The tape of a formula without sides, at a place of this name.
fn alone(
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
) -> Result<Tape, Problem> {
    let mut graph = Graph::new();
    let inputs = inputs(file, values, free, &mut graph)?;
    alone(file, (&mut graph, inputs), formula, "what is observed")
}

/// The tape of a section for these parameter values.
///
/// # Errors
/// [`Problem`] of the function.
pub(super) fn section(
    file: &Arc<SystemFile>,
    values: &[f64],
    function: &Formula,
) -> Result<Tape, Problem> {
    let mut graph = Graph::new();
    let inputs = inputs(file, values, NONE_FREE, &mut graph)?;
    alone(file, (&mut graph, inputs), function, SECTION)
}

/// Builds the tapes for these parameter values. The `free` parameters become states with zero
/// rates, after those of the file. Time is scaled so that the period, if there is one, stays what
/// it is for the given values.
///
/// # Errors
/// [`Problem`] if a constant part of an expression is not a finite number, or an expression is too
/// large.
pub(crate) fn built(file: &Arc<SystemFile>, values: &[f64], free: Freed) -> Result<Built, Problem> {
    let mut graph = Graph::new();
    let period = period(file, values)?;
    let inputs = inputs(file, values, free, &mut graph)?;
    let contacts = file.contacts.len();
    let mut depends_on_time = false;

    let has_static = file
        .contacts
        .iter()
        .any(|contact| contact.holding.is_some());
    let fields = {
        let (file, values) = (Arc::clone(file), values.to_vec());
        let make = move |of| Some(field(&file, &values, free, of).ok()?.0);
        Fields::new(contacts, Arc::new(make))
    };
    for above in sides_to_check(contacts) {
        let all = (1 << contacts) - 1;
        let held_ones = match (has_static, contacts) {
            (false, _) => vec![0],
            (true, 0..=4) => (0..=all).collect(),
            (true, _) => vec![0, all],
        };
        for held in held_ones {
            let of = Combination { above, held };
            let (tape, is_timed) = field(file, values, free, of)?;
            depends_on_time |= is_timed;
            fields.keep(of, &tape);
        }
    }

    let mut heights = Vec::with_capacity(contacts);
    for contact in &file.contacts {
        let scope = Scope::NoSides("a boundary");
        let height = Builder::new(file, inputs, &mut graph, scope).formula(&contact.boundary)?;
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
    let (switching, is_timed) = switching(file, inputs, &mut graph)?;
    depends_on_time |= is_timed || !switching.inputs.is_empty();
    if heights.is_empty() {
        // A system without contacts has one side.
        heights.extend(graph.constant(1.0));
    }
    let mut alone = |formula: &Formula, place| alone(file, (&mut graph, inputs), formula, place);
    let forces = file.contacts.iter();
    let forces = forces.filter_map(|contact| contact.normal_force.as_ref());
    let forces = forces.map(|force| alone(force, "a normal force"));
    let mut forces = forces.collect::<Result<Vec<_>, _>>()?;
    // Of several contacts, friction alone vanishes with it.
    let normal_force = forces.pop().filter(|_| contacts == 1);
    let sections = file.sections.iter();
    let sections = sections.map(|section| alone(&section.function, SECTION));
    let sections = sections.collect::<Result<_, _>>()?;
    let time = |formula: &Option<Formula>, what| {
        let formula = formula.as_ref();
        let value = formula.map(|formula| folded(file, values, formula, Scope::Constant(what)));
        value.transpose()
    };
    let t_start = time(&file.time.start, "the start of a run")?.unwrap_or(0.0);
    let t_end = time(&file.time.end, "the end of a run")?;
    if let (Some(end), Some(formula)) = (t_end, &file.time.end)
        && end <= t_start
    {
        let (end, start) = (readable(end), readable(t_start));
        let message = format!("the end {end} does not lie after the start {start}");
        return Err(Problem::new(message, formula.whole()));
    }
    Ok(Built {
        fields,
        has_static,
        frictions_add: frictions_add(file, values, free)?,
        boundaries: tape(file, &graph, &heights, inputs)?,
        normal_force,
        sections,
        starts: starts(file, values)?,
        t_start,
        t_end,
        period,
        depends_on_time,
        switching,
    })
}

/// The tapes of jumps and inputs, and whether a jump depends on time.
fn switching(
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
        made.push(Input {
            clock: tape(file, graph, &[clock], inputs)?,
            shape: match &entry.shape {
                InputShape::Periodic {
                    width: Some(width), ..
                } => {
                    let width =
                        Builder::new(file, inputs, graph, scope).of_input(width, "width")?;
                    match graph.value(width) {
                        Some(width) => Shape::Repeated(pulse(width).to_vec()),
                        None => Shape::Pulse(tape(file, graph, &[width], inputs)?),
                    }
                }
                InputShape::Periodic { pieces, .. } => Shape::Repeated(pieces.clone()),
                InputShape::Table(pieces) => Shape::Once(pieces.clone()),
                InputShape::Switch(_) => Shape::Sign,
            },
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
/// which a condition may choose one.
fn discrete(file: &SystemFile, graph: &Graph, sets: &[Vec<Id>]) -> Vec<bool> {
    let mut discrete = constant_between_jumps(file);
    loop {
        let is_held = |state: usize| {
            let varies = |of: usize| discrete.get(of) != Some(&true);
            let depends = |set: &Vec<Id>| !graph.is_isolated_from(set[state], varies);
            discrete[state] && sets.iter().any(depends)
        };
        match (0..discrete.len()).find(|&state| is_held(state)) {
            Some(state) => discrete[state] = false,
            None => return discrete,
        }
    }
}

/// The tape of the friction of each contact in a combination, as a size; `None` if all are
/// constant.
pub(super) fn frictions(file: &SystemFile, values: &[f64], of: Combination) -> Option<Tape> {
    let (mut graph, inputs) = (Graph::new(), Inputs::fixed(values));
    let mut builder = Builder::new(file, inputs, &mut graph, Scope::Sides(of));
    let contacts = 0..file.contacts.len();
    let sizes: Vec<Id> = contacts
        .map(|contact| builder.size(contact))
        .collect::<Result<_, _>>()
        .ok()?;
    let varies = sizes.iter().any(|&size| graph.value(size).is_none());
    varies
        .then(|| tape(file, &graph, &sizes, inputs).ok())
        .flatten()
}

/// Whether no rate depends on the sides of two contacts, in slip or while contacts hold, so that
/// frictions add.
fn frictions_add(file: &SystemFile, values: &[f64], free: Freed) -> Result<bool, Problem> {
    if !file.stops.is_empty() {
        return Ok(false);
    }
    let mut graph = Graph::new();
    let inputs = inputs(file, values, free, &mut graph)?;
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

/// The tape of the field of one combination, and whether it depends on time.
fn field(
    file: &SystemFile,
    values: &[f64],
    free: Freed,
    of: Combination,
) -> Result<(Tape, bool), Problem> {
    let mut graph = Graph::new();
    let inputs = inputs(file, values, free, &mut graph)?;
    let rates = Builder::new(file, inputs, &mut graph, Scope::Sides(of)).field()?;
    let is_timed = rates.iter().any(|&rate| graph.depends_on_time(rate));
    Ok((tape(file, &graph, &rates, inputs)?, is_timed))
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

/// Parameters and time, of which some parameters are free.
fn inputs<'a>(
    file: &SystemFile,
    values: &'a [f64],
    free: Freed,
    graph: &mut Graph,
) -> Result<Inputs<'a>, Problem> {
    let inputs = Inputs::free(values, free);
    if !free.scales_time {
        return Ok(inputs);
    }
    let reference = period(file, values)?;
    Ok(inputs.paced(pace(file, inputs, reference, graph)?))
}

/// Rate of the file's time in scaled time such that the period is `period`; `None` if it is that
/// already.
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

fn starts(file: &SystemFile, values: &[f64]) -> Result<Vec<Option<f64>>, Problem> {
    let component = |formula| folded(file, values, formula, Scope::Constant("a start"));
    let starts = file.states.iter();
    let starts = starts.map(|state| state.start.as_ref().map(component).transpose());
    starts.collect()
}

fn period(file: &SystemFile, values: &[f64]) -> Result<Option<f64>, Problem> {
    let Some(formula) = &file.time.period else {
        return Ok(None);
    };
    let period = folded(file, values, formula, Scope::Constant("a period"))?;
    if period > 0.0 {
        return Ok(Some(period));
    }
    Err(Problem::new(
        format!("the period is {}, but must be positive", readable(period)),
        formula.whole(),
    ))
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
