//! Stops: unilateral constraints of relative degree two, as jumps, discrete states and a reaction.
//!
//! While a stop carries, its reaction keeps the second derivative of its gap at zero (Brogliato,
//! *Nonsmooth Mechanics*, 3rd ed. 2016, Sect. 5.1). With the gap `g`, the rates `f` without
//! reactions and what a unit of reaction adds to them, `g'' = a + B N`, so that `B N = −a`.

use stickslip::Direction;
use stickslip::error::readable;

mod equations;

use equations::{StopEquations, acts, by_state, check_slopes, derivative, equations, push, ways};

pub(super) use equations::{openings, prescribe, reactions};

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
    /// Whether those of lift-off depend on modes: see [`lift_offs`].
    by_mode: bool,
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

    /// Whether the function of an event depends on modes.
    pub(super) fn by_mode(&self, event: StopEvent) -> bool {
        self.by_mode && event == StopEvent::LiftOff
    }
}

/// Most contacts of which all combinations of sides are compared. Chosen: 64 builds of a field.
const MOST_COMBINED: usize = 6;

/// All contacts below, and none that holds.
pub(super) const BELOW: Combination = Combination { above: 0, held: 0 };

/// The combinations to compare with [`BELOW`]: with many contacts, those of each contact alone
/// above, and of all others. With static friction, all of them hold as well.
pub(super) fn combinations(file: &SystemFile) -> Vec<Combination> {
    let contacts = file.contacts.len();
    let all = (1 << contacts) - 1;
    let above: Vec<usize> = match contacts <= MOST_COMBINED {
        true => (0..=all).collect(),
        false => {
            let alone = (0..contacts).map(|contact| 1 << contact);
            let alone = alone.flat_map(|one| [one, all ^ one]);
            alone.chain([0, all]).collect()
        }
    };
    let mut holding = file.contacts.iter();
    let held = match holding.any(|contact| contact.holding.is_some()) {
        true => vec![0, all],
        false => vec![0],
    };
    let each = |held| above.iter().map(move |&above| Combination { above, held });
    held.into_iter().flat_map(each).collect()
}

/// The events of the stops of a file, which has some.
pub(super) fn built(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
) -> Result<Events, Problem> {
    let below = equations(file, inputs, graph, BELOW)?;
    check_slopes(file, inputs, graph, &below)?;
    let forces = reactions(file, inputs, graph, BELOW)?;
    // Sides may cancel where all contacts are on one, so that each combination counts.
    let mut is_one_force = true;
    let mut is_free_of_sides = true;
    for of in combinations(file) {
        let there = equations(file, inputs, graph, of)?;
        let here = reactions(file, inputs, graph, of)?;
        is_one_force &= are_same(graph, (&here, &forces));
        is_free_of_sides &= are_same(graph, (&below.free, &there.free));
        for (number, stop) in file.stops.iter().enumerate() {
            if !graph.are_same(below.rates[number], there.rates[number]) {
                let message = format!(
                    "the rate of the gap of the stop `{}` depends on the side of a contact",
                    stop.name
                );
                return Err(Problem::new(message, stop.gap.whole())
                    .help("a gap is a position: friction acts on its second derivative"));
            }
        }
    }
    let follows = !is_one_force && file.stops.len() == 1 && is_free_of_sides;
    let by_mode = !is_one_force && !follows;
    if by_mode {
        check_boundaries(file, inputs, graph)?;
    }
    let acts = acts(file, inputs, graph)?;
    let mut when = Vec::new();
    for (number, stop) in file.stops.iter().enumerate() {
        let function = (|| {
            let closed = graph.state(stop.closed);
            let gap = graph.binary(Binary::Sum, below.gaps[number], closed)?;
            // Without reaction there is no friction that follows it, so that the second derivative
            // without reaction vanishes with it on either side.
            let force = match follows {
                true => {
                    let against = graph.negative(below.free[number])?;
                    graph.binary(Binary::Product, against, closed)?
                }
                false => effect(graph, (below.rates[number], &acts[number]), forces[number])?,
            };
            Ok([gap, lift_off(graph, force, closed)?, below.rates[number]])
        })();
        when.push(function.map_err(|error| no_number(error, stop.place.clone()))?);
    }
    let impacts = impacts(file, inputs, graph, (&below, &acts))?;
    Ok(Events {
        when,
        by_mode,
        impacts,
    })
}

/// What a reaction adds to the second derivative of its gap without friction that follows it, with
/// the sign of the reaction: bodies may be as light as one likes.
fn effect(
    graph: &mut Graph,
    (rate, acts): (Id, &[Option<Id>]),
    force: Id,
) -> Result<Id, NotANumber> {
    let unit = derivative(graph, rate, push(acts))?;
    let unit = graph.call(Function::Abs, unit)?;
    graph.binary(Binary::Product, force, unit)
}

/// The function of lift-off: the effect of the reaction, which vanishes while the stop is open, and
/// 1 then.
fn lift_off(graph: &mut Graph, force: Id, closed: Id) -> Result<Id, NotANumber> {
    let one = graph.constant(1.0)?;
    let open = graph.binary(Binary::Difference, one, closed)?;
    graph.binary(Binary::Sum, force, open)
}

/// The functions of lift-off of all stops in one combination of sides. They are affine in what a
/// contact that sticks combines of its sides, as the reactions are.
pub(super) fn lift_offs(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    of: Combination,
) -> Result<Vec<Id>, Problem> {
    let rates = equations(file, inputs, graph, of)?.rates;
    let forces = reactions(file, inputs, graph, of)?;
    let acts = acts(file, inputs, graph)?;
    let mut functions = Vec::with_capacity(forces.len());
    for (number, stop) in file.stops.iter().enumerate() {
        let closed = graph.state(stop.closed);
        let force = effect(graph, (rates[number], &acts[number]), forces[number]);
        let function = force.and_then(|force| lift_off(graph, force, closed));
        functions.push(function.map_err(|error| no_number(error, stop.place.clone()))?);
    }
    Ok(functions)
}

/// Refuses contacts whose boundaries move when a stop closes or opens, beside reactions that depend
/// on their sides.
fn check_boundaries(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
) -> Result<(), Problem> {
    for contact in &file.contacts {
        let scope = Scope::NoSides("a boundary");
        let boundary = Builder::new(file, inputs, graph, scope).formula(&contact.boundary)?;
        let is_closed = |state| file.stops.iter().any(|stop| stop.closed == state);
        if graph.depends_on_states(boundary, is_closed) {
            let message = format!(
                "the boundary of contact `{}` depends on whether a stop carries, and the reaction \
                 of a stop on the side of a contact",
                contact.name
            );
            return Err(Problem::new(message, contact.boundary.whole())
                .help("leave NAME.closed out of the boundary, or friction along the gap"));
        }
    }
    Ok(())
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
