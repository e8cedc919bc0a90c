//! The equations of the stops in one combination of sides, and their reactions.
//!
//! The boundary of a contact may vanish while a stop carries, as at the velocity that the stop
//! keeps at zero. Then the motion does not determine how contact and stop share the load. The
//! contact's friction is left out of that stop's reaction: the equation has the mean over both of
//! its sides. So it sticks, and what it holds alone it goes on to hold when the stop has let go.

use std::sync::Arc;

use numerics::SplitMix;
use stickslip::error::readable;

use super::super::build::tape;
use super::super::builder::{Builder, Inputs, Scope, are_same, no_number};
use super::super::problem::Problem;
use super::super::{Formula, StopEntry, SystemFile};
use crate::expression::{Binary, Graph, GraphInput, Id, NotANumber, Tape, Test};
use crate::kernel::{Combination, HELD_PER_INPUT, ROUNDING};

/// The equations of the stops in one combination of sides.
pub(super) struct StopEquations {
    /// The gaps, and their rates without reactions.
    pub gaps: Vec<Id>,
    pub rates: Vec<Id>,
    /// The second derivatives of the gaps without reactions.
    pub free: Vec<Id>,
    /// Second derivative of each gap by each reaction.
    pub coupling: Vec<Vec<Id>>,
    /// The field without reactions.
    pub field: Vec<Id>,
}

/// The derivative of a number of the graph, where none is zero.
pub(super) fn derivative(
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
pub(super) fn push(acts: &[Option<Id>]) -> impl Fn(GraphInput) -> Option<Id> {
    move |of| match of {
        GraphInput::Time => None,
        GraphInput::State(number) => acts.get(number).copied().flatten(),
    }
}

/// Effects of a unit of each reaction on the rates, by stop and state.
pub(super) fn acts(
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
pub(super) fn ways(
    graph: &mut Graph,
    (gap, field, acts): (Id, &[Id], &[Option<Id>]),
) -> Result<Vec<Option<Id>>, NotANumber> {
    let mut ways = Vec::with_capacity(field.len());
    for &rate in field {
        ways.push(graph.along(rate, push(acts))?);
    }
    let opened = derivative(graph, gap, push(&ways))?;
    if graph.is(opened, Test::Zero) {
        return Ok(vec![None; ways.len()]);
    }
    let scaled = ways.into_iter();
    let scaled = scaled.map(|way| {
        way.map(|way| graph.binary(Binary::Quotient, way, opened))
            .transpose()
    });
    scaled.collect()
}

/// A number for each state, zero where there is none.
pub(super) fn by_state(
    graph: &mut Graph,
    of: &[Option<Id>],
    states: usize,
) -> Result<Vec<Id>, NotANumber> {
    let zero = graph.constant(0.0)?;
    let all = (0..states).map(|state| of.get(state).copied().flatten().unwrap_or(zero));
    Ok(all.collect())
}

/// Number of points at which contacts are compared with a stop. Chosen: no other function vanishes
/// by chance at all of them.
const POINTS: usize = 4;

/// A boundary vanishes if the constraint leaves less than this part of it. Chosen between rounding
/// and one.
const VANISHED: f64 = 1e-9;

/// The second derivative of a gap: without reactions, and what each of them adds.
struct GapAcceleration {
    free: Id,
    coupling: Vec<Id>,
}

/// The builds of the fields of a file, with and without reactions.
struct Build<'a> {
    file: &'a SystemFile,
    inputs: Inputs<'a>,
    /// The reactions, as states behind all others.
    unknown: Vec<Id>,
    zero: Id,
    one: Id,
    /// The fields with and without reactions in those combinations that were built.
    fields: Vec<(Combination, [Vec<Id>; 2])>,
}

impl<'a> Build<'a> {
    fn new(file: &'a SystemFile, inputs: Inputs<'a>, graph: &mut Graph) -> Result<Self, Problem> {
        let first = file.states.len() + inputs.count_free() + HELD_PER_INPUT * file.inputs.len();
        let unknown = (0..file.stops.len()).map(|stop| graph.state(first + stop));
        let unknown = unknown.collect();
        let numbers = graph
            .constant(0.0)
            .and_then(|zero| Ok((zero, graph.constant(1.0)?)));
        let (zero, one) = numbers.map_err(|error| no_number(error, 0..0))?;
        Ok(Build {
            file,
            inputs,
            unknown,
            zero,
            one,
            fields: Vec::new(),
        })
    }

    /// Number of states, with free parameters.
    fn moving(&self) -> usize {
        self.file.states.len() + self.inputs.count_free()
    }

    /// Number of states, with free parameters and what inputs hold.
    fn states(&self) -> usize {
        self.moving() + HELD_PER_INPUT * self.file.inputs.len()
    }

    /// The fields with and without reactions.
    fn fields(&mut self, graph: &mut Graph, of: Combination) -> Result<[Vec<Id>; 2], Problem> {
        if let Some((_, built)) = self.fields.iter().find(|(built, _)| *built == of) {
            return Ok(built.clone());
        }
        let mut builder = Builder::new(self.file, self.inputs, graph, Scope::Sides(of));
        let with = builder.field_with(&self.unknown)?;
        let without = builder.field_with(&vec![self.zero; self.unknown.len()])?;
        self.fields.push((of, [with.clone(), without.clone()]));
        Ok([with, without])
    }

    /// The gap of a stop and its rate.
    fn gap(
        &mut self,
        graph: &mut Graph,
        (stop, of): (&StopEntry, Combination),
    ) -> Result<[Id; 2], Problem> {
        let wrong = |error: NotANumber| no_number(error, stop.gap.whole());
        let (moving, first) = (self.moving(), self.states());
        let scope = Scope::NoSides("the gap of a stop");
        let gap = Builder::new(self.file, self.inputs, graph, scope).formula(&stop.gap)?;
        let held = |state: usize| {
            let of = self.file.states.get(state);
            of.is_some_and(|state| state.is_discrete) || state >= moving
        };
        if graph.depends_on_states(gap, held) || !graph.is_smooth(gap) {
            let message = format!("the gap of the stop `{}` is not smooth in time", stop.name);
            return Err(Problem::new(message, stop.gap.whole()).help(
                "a gap has no discrete state, input, abs, min or max; two surfaces are two stops",
            ));
        }
        let [with, without] = self.fields(graph, of)?;
        let rate = derivative(graph, gap, motion(&without, self.one)).map_err(wrong)?;
        let loaded = derivative(graph, gap, motion(&with, self.one)).map_err(wrong)?;
        if graph.depends_on_states(loaded, |state| state >= first) {
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
        Ok([gap, rate])
    }

    /// The contacts, as bits, whose boundaries vanish wherever the gap of a stop and its rate do.
    fn shared(
        &mut self,
        graph: &mut Graph,
        (number, gap, rate): (usize, Id, Id),
        of: Combination,
    ) -> Result<usize, Problem> {
        let mut boundaries = Vec::with_capacity(self.file.contacts.len());
        for contact in &self.file.contacts {
            let scope = Scope::NoSides("a boundary");
            let builder = &mut Builder::new(self.file, self.inputs, graph, scope);
            boundaries.push(builder.formula(&contact.boundary)?);
        }
        let [_, field] = self.fields(graph, of)?;
        let states = self.moving();
        let closing = ((number, gap, rate), &*field, &*boundaries);
        let tape = self::closing(self.file, self.inputs, graph, closing)?;
        if boundaries.is_empty() {
            return Ok(0);
        }
        let sizes = (self.states(), states, boundaries.len());
        Ok(graph.probed(Arc::new(move |held| {
            shared_by(&tape.with_held(held), sizes)
        })))
    }

    /// The second derivative of a gap with this rate.
    fn row(
        &mut self,
        graph: &mut Graph,
        (stop, rate): (&StopEntry, Id),
        of: Combination,
    ) -> Result<GapAcceleration, Problem> {
        let wrong = |error: NotANumber| no_number(error, stop.gap.whole());
        let first = self.states();
        let [with, without] = self.fields(graph, of)?;
        let bent = derivative(graph, rate, motion(&with, self.one)).map_err(wrong)?;
        let free = derivative(graph, rate, motion(&without, self.one)).map_err(wrong)?;
        let mut coupling = Vec::with_capacity(self.unknown.len());
        for number in 0..self.unknown.len() {
            let only = |of| (of == GraphInput::State(first + number)).then_some(self.one);
            coupling.push(derivative(graph, bent, only).map_err(wrong)?);
        }
        let bends = |part: &Id| graph.depends_on_states(*part, |state| state >= first);
        if coupling.iter().any(bends) {
            let message = format!(
                "the gap of the stop `{}` is not linear in a reaction",
                stop.name
            );
            return Err(Problem::new(message, stop.place.clone())
                .help("friction and rates can be proportional to the force of a stop only"));
        }
        Ok(GapAcceleration { free, coupling })
    }

    /// The mean of a row over both sides of the contacts of these bits.
    fn mean_row(
        &mut self,
        graph: &mut Graph,
        of_gap: (&StopEntry, Id),
        (of, shared): (Combination, usize),
    ) -> Result<GapAcceleration, Problem> {
        let mut rows = Vec::new();
        for sides in (0..=shared).filter(|sides| sides & !shared == 0) {
            let above = of.above & !shared | sides;
            let row = self.row(graph, of_gap, Combination { above, ..of })?;
            rows.push(row);
        }
        let count = rows.len() as f64;
        let Some(mut mean) = rows.pop() else {
            return self.row(graph, of_gap, of);
        };
        let is_one = |row: &GapAcceleration| {
            let coupling = (&*row.coupling, &*mean.coupling);
            graph.are_same(row.free, mean.free) && are_same(graph, coupling)
        };
        if rows.iter().all(is_one) {
            return Ok(mean);
        }
        let made = (|| {
            let part = graph.constant(1.0 / count)?;
            for row in rows {
                mean.free = graph.binary(Binary::Sum, mean.free, row.free)?;
                for (mean, one) in mean.coupling.iter_mut().zip(row.coupling) {
                    *mean = graph.binary(Binary::Sum, *mean, one)?;
                }
            }
            for one in std::iter::once(&mut mean.free).chain(&mut mean.coupling) {
                *one = graph.binary(Binary::Product, *one, part)?;
            }
            Ok(mean)
        })();
        made.map_err(|error| no_number(error, of_gap.0.place.clone()))
    }
}

/// The tape of a gap, its rate, the derivative of that by the reaction, the rows of [`ways`] and
/// [`acts`], and further numbers.
fn closing(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    ((number, gap, rate), field, further): ((usize, Id, Id), &[Id], &[Id]),
) -> Result<Tape, Problem> {
    let states = file.states.len() + inputs.count_free();
    let acts = acts(file, inputs, graph)?.swap_remove(number);
    let roots = (|| {
        let ways = ways(graph, (gap, field, &acts))?;
        let opened = derivative(graph, rate, push(&acts))?;
        let mut roots = vec![gap, rate, opened];
        roots.extend(by_state(graph, &ways, states)?);
        roots.extend(by_state(graph, &acts, states)?);
        roots.extend(further);
        Ok(roots)
    })();
    let roots = roots.map_err(|error| no_number(error, file.stops[number].place.clone()))?;
    tape(file, graph, &roots, inputs)
}

/// Most steps of Newton's iteration to a zero of a gap. Chosen: at a zero of fourth order, each
/// step leaves three quarters of the distance.
const MOST_STEPS: usize = 80;

/// Part of the slope that Newton's last step to a zero leaves, at most, where it vanishes there.
/// Chosen between one half, as at a double zero, and 1, as at a zero with a slope.
const FLATTENS: f64 = 0.7;

/// Part of a gap that is left next to a zero. Chosen above rounding, which decides nearer steps.
const NEXT_TO_ZERO: f64 = 64.0 * f64::EPSILON;

/// Whether the derivative of a gap's rate by the reaction vanishes wherever the gap does: Newton's
/// steps to a zero then leave a part of it each. The tape is that of [`closing`]. The
/// numbers are those of states with what inputs hold, and of states.
fn flattens_by(tape: &Tape, (all, states): (usize, usize)) -> bool {
    let evaluated = |t: f64, x: &[f64]| {
        let mut values = vec![0.0; 3 + 2 * states];
        tape.evaluate(t, x, &mut values);
        values
    };
    let mut draw = SplitMix::new(1);
    (0..POINTS).all(|_| {
        let t = draw.uniform();
        let mut x: Vec<f64> = (0..all).map(|_| draw.between(0.5, 1.5)).collect();
        let start = evaluated(t, &x);
        let (mut at, mut flattens, mut length) = (start.clone(), false, f64::INFINITY);
        for _ in 0..MOST_STEPS {
            if at[0].abs() <= NEXT_TO_ZERO * start[0].abs() {
                break;
            }
            let (before, last) = (at[2], length);
            length = 0.0;
            for (x, way) in x.iter_mut().zip(&at[3..3 + states]) {
                *x -= way * at[0];
                length += (way * at[0]).abs();
            }
            at = evaluated(t, &x);
            // A gap also vanishes towards infinity, by ever longer steps.
            flattens = length < last && at[2].abs() <= FLATTENS * before.abs();
        }
        let is_near = at[0].abs() <= NEXT_TO_ZERO * start[0].abs();
        start[0] != 0.0 && start[2] != 0.0 && is_near && flattens
    })
}

/// Contacts, as bits, whose boundaries vanish wherever a gap and its rate do. The tape is that of
/// [`closing`] with the boundaries. The numbers are those of states with what inputs hold, of
/// states, and of contacts.
fn shared_by(tape: &Tape, (all, states, contacts): (usize, usize, usize)) -> usize {
    let evaluated = |t: f64, x: &[f64]| {
        let mut values = vec![0.0; 3 + 2 * states + contacts];
        tape.evaluate(t, x, &mut values);
        values
    };
    let mut draw = SplitMix::new(1);
    let mut shared = (1 << contacts) - 1;
    for _ in 0..POINTS {
        let t = draw.uniform();
        let mut x: Vec<f64> = (0..all).map(|_| draw.between(0.5, 1.5)).collect();
        let before = evaluated(t, &x);
        for (x, way) in x.iter_mut().zip(&before[3..3 + states]) {
            *x -= way * before[0];
        }
        let closed = evaluated(t, &x);
        for (x, acts) in x.iter_mut().zip(&closed[3 + states..3 + 2 * states]) {
            *x -= acts * closed[1] / closed[2];
        }
        let after = evaluated(t, &x);
        for contact in 0..contacts {
            let of = |values: &[f64]| values[3 + 2 * states + contact].abs();
            let vanishes = of(&after) <= VANISHED * of(&before);
            shared &= !(usize::from(!vanishes) << contact);
        }
    }
    shared
}

/// The equations of the stops.
pub(super) fn equations(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    of: Combination,
) -> Result<StopEquations, Problem> {
    let mut build = Build::new(file, inputs, graph)?;
    let [_, field] = build.fields(graph, of)?;
    let mut found = StopEquations {
        gaps: Vec::new(),
        rates: Vec::new(),
        free: Vec::new(),
        coupling: Vec::new(),
        field,
    };
    for (number, stop) in file.stops.iter().enumerate() {
        let [gap, rate] = build.gap(graph, (stop, of))?;
        let shared = build.shared(graph, (number, gap, rate), of)?;
        let GapAcceleration { free, coupling } =
            build.mean_row(graph, (stop, rate), (of, shared))?;
        if let Some(own) = graph.value(coupling[number])
            && !graph.is(coupling[number], Test::Positive)
        {
            return Err(unopened(file, inputs, graph, (number, rate, own))?);
        }
        found.gaps.push(gap);
        found.rates.push(rate);
        found.free.push(free);
        found.coupling.push(coupling);
    }
    Ok(found)
}

/// The fault of a stop whose reaction changes the second derivative of its gap by `own`, which is
/// not positive.
fn unopened(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    (number, rate, own): (usize, Id, f64),
) -> Result<Problem, Problem> {
    let stop = &file.stops[number];
    let acts = acts(file, inputs, graph)?.swap_remove(number);
    let alone = derivative(graph, rate, push(&acts));
    let alone = alone.map_err(|error| no_number(error, stop.place.clone()))?;
    let pulls = graph.value(alone).is_none_or(|alone| alone <= 0.0);
    if own == 0.0 && pulls {
        let message = format!(
            "the reaction of the stop `{}` does not move its gap",
            stop.name
        );
        return Ok(Problem::new(message, stop.place.clone())
            .help("acts = { v = \"1/m\" } pushes where gap = \"h\" grows with v"));
    }
    let (with, place, help) = match pulls {
        true => {
            let place = stop.acts.iter().flatten().next();
            let place = place.map_or_else(|| stop.place.clone(), Formula::whole);
            let help = "such a reaction draws the bodies together: turn the signs in acts, or that \
                        of the gap; acts = { v = \"1/m\" } pushes where gap = \"h\" grows with v";
            ("", place, help)
        }
        false => {
            let help = "lower that friction: no motion in contact is consistent, or several are \
                        (Painlevé)";
            (
                " with the friction that follows it",
                stop.place.clone(),
                help,
            )
        }
    };
    let message = format!(
        "a unit of the reaction of the stop `{}` changes the gap's second derivative by {}{with}, \
         but must open it",
        stop.name,
        readable(own)
    );
    Ok(Problem::new(message, place).help(help))
}

/// Refuses stops whose gaps have no slope where they close, as the square of a distance. No rate
/// closes such a gap.
pub(super) fn check_slopes(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    equations: &StopEquations,
) -> Result<(), Problem> {
    let states = file.states.len() + inputs.count_free();
    let all = states + HELD_PER_INPUT * file.inputs.len();
    for (number, stop) in file.stops.iter().enumerate() {
        let of = (number, equations.gaps[number], equations.rates[number]);
        let tape = closing(file, inputs, graph, (of, &equations.field, &[]))?;
        let flattens = graph.probed(Arc::new(move |held| {
            usize::from(flattens_by(&tape.with_held(held), (all, states)))
        }));
        if flattens != 0 {
            let message = format!(
                "the slope of the gap of the stop `{}` vanishes where it closes",
                stop.name
            );
            return Err(Problem::new(message, stop.gap.whole())
                .help("a gap passes zero with a rate: gap = \"h\" in place of \"h^2\""));
        }
    }
    Ok(())
}

/// Second derivative of each stop's gap by a unit of its own reaction, without the friction that
/// follows it. Then, by stop, by a unit of each reaction, with friction in one combination of
/// sides.
pub(in super::super) fn openings(
    file: &SystemFile,
    inputs: Inputs<'_>,
    graph: &mut Graph,
    of: Combination,
) -> Result<Vec<Id>, Problem> {
    let found = equations(file, inputs, graph, of)?;
    let acts = acts(file, inputs, graph)?;
    let mut openings = Vec::with_capacity(acts.len() * (acts.len() + 1));
    for (number, acts) in acts.iter().enumerate() {
        let place = file.stops[number].place.clone();
        let alone = derivative(graph, found.rates[number], push(acts));
        openings.push(alone.map_err(|error| no_number(error, place))?);
    }
    openings.extend(found.coupling.concat());
    Ok(openings)
}

/// The reactions of the stops in one combination of sides: zero where a stop does not carry, not a
/// number where a reaction cannot keep its gap closed.
pub(in super::super) fn reactions(
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
            if is_own && count == 1 && graph.is_held(*entry) {
                continue;
            }
            if is_own && !graph.is_held(*entry) {
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
    // Gauss's elimination; a pivot that is not positive has no unique reaction. Of stops that hold
    // the same motion, rounding leaves one.
    let own: Vec<Id> = (0..count).map(|stop| matrix[stop][stop]).collect();
    let rounding = graph.constant(ROUNDING)?;
    for pivot in 0..count {
        let left = matrix[pivot][pivot];
        if left != own[pivot] {
            let noise = graph.binary(Binary::Product, rounding, own[pivot])?;
            let clear = graph.binary(Binary::Difference, left, noise)?;
            matrix[pivot][pivot] = graph.where_positive(clear, left)?;
        }
        for row in pivot + 1..count {
            if graph.is(matrix[row][pivot], Test::Zero) {
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
