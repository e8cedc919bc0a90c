//! Stops: unilateral constraints of relative degree two, as jumps, discrete states and a reaction.
//!
//! While a stop carries, its reaction keeps the second derivative of its gap at zero (Brogliato,
//! *Nonsmooth Mechanics*, 3rd ed. 2016, Sect. 5.1). With the gap `g`, the rates `f` without
//! reactions and what a unit of reaction adds to them, `g'' = a + B N`, so that `B N = −a`.

use stickslip::Direction;
use stickslip::error::readable;

use super::build::tape;
use super::builder::{Builder, Inputs, Scope, no_number};
use super::names::{Meaning, Names};
use super::problem::Problem;
use super::table::{Entry, Table};
use super::{Formula, JumpEntry, StateEntry, StopEntry, StopEvent, SystemFile};
use crate::expression::{Binary, Function, Graph, GraphInput, Id, NotANumber};
use crate::kernel::{Combination, HELD_PER_INPUT, Impacts};

/// Most stops of a file. Chosen: an impact tries all sets of those that touch.
const MOST_STOPS: usize = 8;

/// The stops of a file. Each adds a discrete state.
pub(super) fn read(
    file: &Table<'_>,
    names: &mut Names,
    states: &[StateEntry],
    discrete: &mut Vec<StateEntry>,
) -> Result<Vec<StopEntry>, Problem> {
    file.each("stops", |number, name, place, entry| {
        if number == MOST_STOPS {
            let message = format!("this is stop number {}", number + 1);
            return Err(
                Problem::new(message, place).help(format!("a file can have {MOST_STOPS} stops"))
            );
        }
        let name = names.add(name, place.clone(), Meaning::Stop(number))?;
        let table = entry.table("stops", &name)?;
        table.only(&["gap", "acts", "restitution"])?;
        let gap = "a function of the states that is positive in flight, as in gap = \"h\"";
        let acts = "what a unit of the reaction adds to the rates, as in acts = { v = \"1/m\" }";
        let rows = table.need("acts", acts)?;
        let rows = rows.table(&format!("stops.{name}"), "acts")?;
        let rows = super::read::by_state(&rows, states, names)?;
        let acts = rows
            .into_iter()
            .map(|row| row.map(Entry::formula).transpose());
        let restitution = "the part of the approach speed that an impact gives back, 0 to 1";
        let closed = states.len() + discrete.len();
        discrete.push(StateEntry {
            name: names.add_part(&name, "closed", Meaning::State(closed)),
            unit: String::new(),
            meaning: Some(format!("1 while the stop {name} carries")),
            start: Some(Formula::number(0.0, 0..0)),
            range: None,
            is_discrete: true,
        });
        names.add_part(&name, "force", Meaning::Force(number));
        Ok(StopEntry {
            gap: table.need("gap", gap)?.formula()?,
            acts: acts.collect::<Result<_, _>>()?,
            restitution: table.need("restitution", restitution)?.formula()?,
            closed,
            place,
            name,
        })
    })
}

/// The jumps that are the events of stops, in a system of so many states.
pub(super) fn events(stops: &[StopEntry], states: usize) -> impl Iterator<Item = JumpEntry> {
    let kinds = [
        (StopEvent::Impact, "impact"),
        (StopEvent::LiftOff, "lift-off"),
        (StopEvent::Landing, "landing"),
    ];
    stops.iter().enumerate().flat_map(move |(number, stop)| {
        kinds.map(|(kind, name)| JumpEntry {
            name: format!("{}.{name}", stop.name),
            when: stop.gap.clone(),
            direction: Direction::Falling,
            condition: None,
            set: vec![None; states],
            most: None,
            of_stop: Some((number, kind)),
            place: stop.place.clone(),
        })
    })
}

/// The equations of the stops in one combination of sides.
struct StopEquations {
    /// The gaps, and their rates without reactions.
    gaps: Vec<Id>,
    rates: Vec<Id>,
    /// The second derivatives of the gaps without reactions.
    free: Vec<Id>,
    /// Part of each reaction in the second derivative of each gap.
    coupling: Vec<Vec<Id>>,
    /// The field without reactions.
    field: Vec<Id>,
}

/// The derivative of a number of the graph, where none is zero.
fn derivative(
    graph: &mut Graph,
    root: Id,
    direction: impl Fn(GraphInput) -> Option<Id>,
) -> Result<Id, NotANumber> {
    match graph.along(root, direction)? {
        Some(derivative) => Ok(derivative),
        None => graph.constant(0.0),
    }
}

/// The direction of motion with these rates of the states.
fn motion(rates: &[Id], one: Id) -> impl Fn(GraphInput) -> Option<Id> {
    move |of| match of {
        GraphInput::Time => Some(one),
        GraphInput::State(number) => rates.get(number).copied(),
    }
}

/// The direction that a unit of a reaction pushes the rates to.
fn push(acts: &[Option<Id>]) -> impl Fn(GraphInput) -> Option<Id> {
    move |of| match of {
        GraphInput::Time => None,
        GraphInput::State(number) => acts.get(number).copied().flatten(),
    }
}

/// The equations of the stops.
fn equations(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    of: Combination,
) -> Result<StopEquations, Problem> {
    let moving = file.states.len() + inputs.count_free();
    let first = moving + HELD_PER_INPUT * file.inputs.len();
    let count = file.stops.len();
    let wrong = |stop: &StopEntry| {
        let place = stop.gap.whole();
        move |error: NotANumber| no_number(error, place.clone())
    };
    let unknown: Vec<Id> = (0..count).map(|stop| graph.state(first + stop)).collect();
    let is_unknown = |state: usize| state >= first;
    let numbers = graph
        .constant(0.0)
        .and_then(|zero| Ok((zero, graph.constant(1.0)?)));
    let (zero, one) = numbers.map_err(|error| no_number(error, 0..0))?;
    let mut builder = Builder::new(file, inputs, graph, Scope::Sides(of));
    let with = builder.field_with(&unknown)?;
    let field = builder.field_with(&vec![zero; count])?;
    let mut found = StopEquations {
        gaps: Vec::new(),
        rates: Vec::new(),
        free: Vec::new(),
        coupling: Vec::new(),
        field,
    };
    for stop in &file.stops {
        let wrong = wrong(stop);
        let scope = Scope::NoSides("the gap of a stop");
        let gap = Builder::new(file, inputs, graph, scope).formula(&stop.gap)?;
        let held = |state: usize| {
            let discrete = file
                .states
                .get(state)
                .is_some_and(|state| state.is_discrete);
            discrete || state >= moving
        };
        if graph.depends_on_states(gap, held) || !graph.is_smooth(gap) {
            let message = format!("the gap of the stop `{}` is not smooth in time", stop.name);
            return Err(Problem::new(message, stop.gap.whole()).help(
                "a gap has no discrete state, input, abs, min or max; two surfaces are two stops",
            ));
        }
        let rate = derivative(graph, gap, motion(&found.field, one)).map_err(&wrong)?;
        let loaded = derivative(graph, gap, motion(&with, one)).map_err(&wrong)?;
        if graph.depends_on_states(loaded, is_unknown) {
            let message = format!(
                "the reaction of the stop `{}` acts on its gap's rate",
                stop.name
            );
            return Err(Problem::new(message, stop.gap.whole()).help(
                "a gap is a position: its rate has no reaction in it, its second derivative has",
            ));
        }
        if graph.depends_on_states(rate, |state| (moving..first).contains(&state)) {
            let message = format!("the rate of the gap of the stop `{}` has steps", stop.name);
            return Err(Problem::new(message, stop.gap.whole())
                .help("no input can stand in it: at its kinks the rate would jump"));
        }
        let bent = derivative(graph, rate, motion(&with, one)).map_err(&wrong)?;
        let free = derivative(graph, rate, motion(&found.field, one)).map_err(&wrong)?;
        let mut row = Vec::with_capacity(count);
        for number in 0..count {
            let only = |of| (of == GraphInput::State(first + number)).then_some(one);
            row.push(derivative(graph, bent, only).map_err(&wrong)?);
        }
        if row
            .iter()
            .any(|&part| graph.depends_on_states(part, is_unknown))
        {
            let message = format!(
                "the gap of the stop `{}` is not linear in a reaction",
                stop.name
            );
            return Err(Problem::new(message, stop.place.clone())
                .help("friction and rates can be proportional to the force of a stop only"));
        }
        let number = found.gaps.len();
        if let Some(own) = graph.value(row[number]).filter(|own| *own <= 0.0) {
            let message = match own == 0.0 {
                true => format!(
                    "the reaction of the stop `{}` does not move its gap",
                    stop.name
                ),
                false => format!(
                    "a unit of the reaction of the stop `{}` changes the gap's second derivative \
                     by {}, but must open it",
                    stop.name,
                    readable(own)
                ),
            };
            return Err(Problem::new(message, stop.place.clone()).help(
                "acts = { v = \"1/m\" } pushes where gap = \"h\" grows with v; friction that turns \
                 this around has no consistent motion (Painlevé)",
            ));
        }
        found.gaps.push(gap);
        found.rates.push(rate);
        found.free.push(free);
        found.coupling.push(row);
    }
    Ok(found)
}

/// The reactions of the stops in one combination of sides: zero where a stop does not carry, not a
/// number where a reaction cannot keep its gap closed.
pub(super) fn reactions(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    of: Combination,
) -> Result<Vec<Id>, Problem> {
    let equations = equations(file, inputs, graph, of)?;
    let solved = solved(file, graph, &equations);
    solved.map_err(|error| no_number(error, file.stops[0].place.clone()))
}

fn solved(
    file: &SystemFile,
    graph: &mut Graph,
    equations: &StopEquations,
) -> Result<Vec<Id>, NotANumber> {
    let count = file.stops.len();
    let closed: Vec<Id> = file
        .stops
        .iter()
        .map(|stop| graph.state(stop.closed))
        .collect();
    let one = graph.constant(1.0)?;
    let mut right = Vec::with_capacity(count);
    for (free, closed) in equations.free.iter().zip(&closed) {
        let against = graph.negative(*free)?;
        right.push(graph.binary(Binary::Product, against, *closed)?);
    }
    // Rows of stops that do not carry are those of the identity.
    let mut matrix = equations.coupling.clone();
    for (row, entries) in matrix.iter_mut().enumerate() {
        for (column, entry) in entries.iter_mut().enumerate() {
            let is_own = row == column;
            if is_own && count == 1 && graph.value(*entry).is_some() {
                continue;
            }
            if is_own && graph.value(*entry).is_none() {
                *entry = graph.where_positive(*entry, *entry)?;
            }
            *entry = graph.binary(Binary::Product, *entry, closed[row])?;
            if is_own {
                let open = graph.binary(Binary::Difference, one, closed[row])?;
                *entry = graph.binary(Binary::Sum, *entry, open)?;
            } else {
                *entry = graph.binary(Binary::Product, *entry, closed[column])?;
            }
        }
    }
    // Gauss's elimination; a pivot that is not positive has no unique reaction.
    for pivot in 0..count {
        for row in pivot + 1..count {
            if graph.value(matrix[row][pivot]) == Some(0.0) {
                continue;
            }
            let factor =
                graph.binary(Binary::Quotient, matrix[row][pivot], matrix[pivot][pivot])?;
            let lead = matrix[pivot].clone();
            for (entry, lead) in matrix[row].iter_mut().zip(lead).skip(pivot) {
                let part = graph.binary(Binary::Product, factor, lead)?;
                *entry = graph.binary(Binary::Difference, *entry, part)?;
            }
            let part = graph.binary(Binary::Product, factor, right[pivot])?;
            right[row] = graph.binary(Binary::Difference, right[row], part)?;
        }
    }
    for row in (0..count).rev() {
        for column in row + 1..count {
            let part = graph.binary(Binary::Product, matrix[row][column], right[column])?;
            right[row] = graph.binary(Binary::Difference, right[row], part)?;
        }
        right[row] = graph.binary(Binary::Quotient, right[row], matrix[row][row])?;
    }
    Ok(right)
}

/// The functions and maps of the events of stops.
pub(super) struct Events {
    /// The function at whose zero each event occurs, by stop: impact, lift-off, landing.
    pub when: Vec<[Id; 3]>,
    /// The law of impact.
    pub impacts: Impacts,
}

impl Events {
    /// The function of an event.
    pub(super) fn when(&self, stop: usize, event: StopEvent) -> Id {
        self.when[stop][match event {
            StopEvent::Impact => 0,
            StopEvent::LiftOff => 1,
            StopEvent::Landing => 2,
        }]
    }
}

/// Most contacts of which all combinations of sides are compared. Chosen: 64 builds of a field.
const MOST_COMBINED: usize = 6;

/// The combinations of sides to compare with that of all contacts below: with many contacts, those
/// of each contact alone, and of all others.
fn combinations(contacts: usize) -> Vec<usize> {
    if contacts <= MOST_COMBINED {
        return (1..1 << contacts).collect();
    }
    let all = (1 << contacts) - 1;
    let alone = (0..contacts).map(|contact| 1 << contact);
    alone
        .flat_map(|one| [one, all ^ one])
        .chain([all])
        .collect()
}

/// The events of the stops of a file, which has some.
pub(super) fn built(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
) -> Result<Events, Problem> {
    let below = equations(file, inputs, graph, Combination { above: 0, held: 0 })?;
    let sided = |name: &str, what: &str| {
        format!("the {what} of the gap of the stop `{name}` depends on the side of a contact")
    };
    let none = Combination { above: 0, held: 0 };
    let forces = reactions(file, inputs, graph, none)?;
    // Sides may cancel where all contacts are on one, so that each combination counts.
    let mut is_one_force = true;
    let mut is_free_of_sides = vec![true; file.stops.len()];
    for above in combinations(file.contacts.len()) {
        let of = Combination { above, held: 0 };
        let there = equations(file, inputs, graph, of)?;
        is_one_force &= reactions(file, inputs, graph, of)? == forces;
        for (number, stop) in file.stops.iter().enumerate() {
            if below.rates[number] != there.rates[number] {
                let message = sided(&stop.name, "rate");
                return Err(Problem::new(message, stop.gap.whole())
                    .help("a gap is a position: friction acts on its second derivative"));
            }
            is_free_of_sides[number] &= below.free[number] == there.free[number];
        }
    }
    let mut when = Vec::new();
    for (number, stop) in file.stops.iter().enumerate() {
        if !is_one_force && (file.stops.len() > 1 || !is_free_of_sides[number]) {
            let message = sided(&stop.name, "second derivative");
            return Err(Problem::new(message, stop.place.clone()).help(
                "friction can follow the force of the only stop; other friction must not act on \
                 its gap",
            ));
        }
        let function = (|| {
            let closed = graph.state(stop.closed);
            let gap = graph.binary(Binary::Sum, below.gaps[number], closed)?;
            // Without reaction there is no friction that follows it, so that the second derivative
            // without reaction vanishes with it on either side.
            let force = match is_one_force {
                true => forces[number],
                false => {
                    let against = graph.negative(below.free[number])?;
                    graph.binary(Binary::Product, against, closed)?
                }
            };
            let one = graph.constant(1.0)?;
            let open = graph.binary(Binary::Difference, one, closed)?;
            let lift = graph.binary(Binary::Sum, force, open)?;
            Ok([gap, lift, below.rates[number]])
        })();
        when.push(function.map_err(|error| no_number(error, stop.place.clone()))?);
    }
    let acts = acts(file, inputs, graph)?;
    let impacts = impacts(file, inputs, graph, (&below, &acts))?;
    Ok(Events { when, impacts })
}

/// Part of a unit of each reaction in the rates, by stop and state.
fn acts(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
) -> Result<Vec<Vec<Option<Id>>>, Problem> {
    let scope = Scope::NoSides("what a reaction acts on");
    let all = file.stops.iter().map(|stop| {
        let of = stop.acts.iter().map(|acts| {
            let mut builder = Builder::new(file, inputs, graph, scope);
            acts.as_ref().map(|acts| builder.formula(acts)).transpose()
        });
        of.collect()
    });
    all.collect()
}

/// The direction of the motion that follows an impulse at a stop, such that a unit of it opens the
/// gap by one.
fn ways(
    graph: &mut Graph,
    (number, equations, acts): (usize, &StopEquations, &[Option<Id>]),
) -> Result<Vec<Option<Id>>, NotANumber> {
    let mut ways = Vec::with_capacity(equations.field.len());
    for &field in &equations.field {
        ways.push(graph.along(field, push(acts))?);
    }
    let opened = derivative(graph, equations.gaps[number], push(&ways))?;
    if graph.value(opened) == Some(0.0) {
        return Ok(vec![None; ways.len()]);
    }
    let scaled = ways.into_iter();
    let scaled = scaled.map(|way| {
        way.map(|way| graph.binary(Binary::Quotient, way, opened))
            .transpose()
    });
    scaled.collect()
}

/// Size of a number as the sum of the sizes of its parts that are linear in the states.
fn size(graph: &mut Graph, of: Id, states: usize) -> Result<Id, NotANumber> {
    let mut size = graph.constant(0.0)?;
    let one = graph.constant(1.0)?;
    for state in 0..states {
        let only = |variable| (variable == GraphInput::State(state)).then_some(one);
        if let Some(slope) = graph.along(of, only)? {
            let value = graph.state(state);
            let part = graph.binary(Binary::Product, slope, value)?;
            let part = graph.call(Function::Abs, part)?;
            size = graph.binary(Binary::Sum, size, part)?;
        }
    }
    Ok(size)
}

/// The law of impact of all stops.
fn impacts(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    (equations, acts): (&StopEquations, &[Vec<Option<Id>>]),
) -> Result<Impacts, Problem> {
    let states = file.states.len();
    let mut roots = Vec::new();
    for (number, stop) in file.stops.iter().enumerate() {
        let wrong = |error| no_number(error, stop.place.clone());
        let (gap, rate) = (equations.gaps[number], equations.rates[number]);
        let speed = graph.negative(rate).map_err(wrong)?;
        let speed = inputs.in_file_time(graph, speed).map_err(wrong)?;
        let scope = Scope::NoSides("a restitution");
        let builder = Builder::new(file, inputs, graph, scope);
        let restitution = builder.approached_at(speed).formula(&stop.restitution)?;
        if let Some(value) = graph
            .value(restitution)
            .filter(|e| !(0.0..=1.0).contains(e))
        {
            let message = format!("the restitution {} is not between 0 and 1", readable(value));
            return Err(Problem::new(message, stop.restitution.whole())
                .help("it is the part of the approach speed that an impact gives back"));
        }
        let sizes = size(graph, gap, states).and_then(|of| Ok((of, size(graph, rate, states)?)));
        let (gap_size, rate_size) = sizes.map_err(wrong)?;
        roots.extend([gap, gap_size, rate, rate_size, restitution]);
        for acts in acts {
            roots.push(derivative(graph, rate, push(acts)).map_err(wrong)?);
        }
    }
    let zero = graph
        .constant(0.0)
        .map_err(|error| no_number(error, 0..0))?;
    let rows = |of: &[Option<Id>]| -> Vec<Id> {
        let all = (0..states).map(|state| of.get(state).copied().flatten().unwrap_or(zero));
        all.collect()
    };
    for (number, acts) in acts.iter().enumerate() {
        let ways = ways(graph, (number, equations, acts));
        roots.extend(rows(acts));
        roots.extend(rows(&ways.map_err(|error| no_number(error, 0..0))?));
    }
    Ok(Impacts {
        parts: tape(file, graph, &roots, inputs)?,
        closed: file.stops.iter().map(|stop| stop.closed).collect(),
        states,
    })
}
