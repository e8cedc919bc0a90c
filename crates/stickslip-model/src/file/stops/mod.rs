//! Stops: unilateral constraints of relative degree two, as jumps, discrete states and a reaction.
//!
//! While a stop carries, its reaction keeps the second derivative of its gap at zero (Brogliato,
//! *Nonsmooth Mechanics*, 3rd ed. 2016, Sect. 5.1). With the gap `g`, the rates `f` without
//! reactions and what a unit of reaction adds to them, `g'' = a + B N`, so that `B N = −a`.

use stickslip::Direction;
use stickslip::error::readable;

mod equations;

use equations::{StopEquations, acts, by_state, check_slopes, derivative, equations, push, ways};

pub(super) use equations::{openings, reactions};

use super::build::tape;
use super::builder::{Builder, Inputs, Scope, are_same, no_number};
use super::names::{Meaning, Names};
use super::problem::Problem;
use super::table::{Entry, Table};
use super::{Formula, JumpEntry, StateEntry, StopEntry, StopEvent, SystemFile};
use crate::expression::{Binary, Function, Graph, GraphInput, Id, NotANumber, Test};
use crate::kernel::{Combination, Impacts};

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
            atol: None,
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
    check_slopes(file, inputs, graph, &below)?;
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
        let here = reactions(file, inputs, graph, of)?;
        is_one_force &= are_same(graph, (&here, &forces));
        for (number, stop) in file.stops.iter().enumerate() {
            if !graph.are_same(below.rates[number], there.rates[number]) {
                let message = sided(&stop.name, "rate");
                return Err(Problem::new(message, stop.gap.whole())
                    .help("a gap is a position: friction acts on its second derivative"));
            }
            is_free_of_sides[number] &= graph.are_same(below.free[number], there.free[number]);
        }
    }
    let acts = acts(file, inputs, graph)?;
    let mut when = Vec::new();
    for (number, stop) in file.stops.iter().enumerate() {
        if !is_one_force && (file.stops.len() > 1 || !is_free_of_sides[number]) {
            let message = sided(&stop.name, "second derivative");
            return Err(Problem::new(message, stop.place.clone()).help(
                "friction acts along a gap only where its contact rests while the stop carries, \
                 or where it follows the force of the only stop",
            ));
        }
        let function = (|| {
            let closed = graph.state(stop.closed);
            let gap = graph.binary(Binary::Sum, below.gaps[number], closed)?;
            // Without reaction there is no friction that follows it, so that the second derivative
            // without reaction vanishes with it on either side.
            let force = match is_one_force {
                // By what it adds to the second derivative: bodies may be as light as one likes.
                true => {
                    let unit = derivative(graph, below.rates[number], push(&acts[number]))?;
                    let unit = graph.call(Function::Abs, unit)?;
                    graph.binary(Binary::Product, forces[number], unit)?
                }
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
    let impacts = impacts(file, inputs, graph, (&below, &acts))?;
    Ok(Events { when, impacts })
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
        let scope = Scope::NoSides("a restitution");
        let builder = Builder::new(file, inputs, graph, scope);
        let restitution = builder.approached_at(speed).formula(&stop.restitution)?;
        if let Some(value) = graph.value(restitution)
            && !graph.is(restitution, Test::WithinUnit)
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
    for (number, acts) in acts.iter().enumerate() {
        let rows = ways(graph, (equations.gaps[number], &equations.field, acts)).and_then(|ways| {
            Ok([
                by_state(graph, acts, states)?,
                by_state(graph, &ways, states)?,
            ])
        });
        roots.extend(rows.map_err(|error| no_number(error, 0..0))?.concat());
    }
    Ok(Impacts {
        parts: tape(file, graph, &roots, inputs)?,
        closed: file.stops.iter().map(|stop| stop.closed).collect(),
        states,
    })
}
