//! Adds expressions to a graph and resolves every name.

use std::ops::Range;

use stickslip::error::readable;

use super::formula::{not_finite, where_operands};
use super::names::{FURTHER_FUNCTIONS, LATER_FUNCTIONS, Meaning, did_you_mean, is_function};
use super::problem::Problem;
use super::{Formula, InputEntry, InputShape, SystemFile};
use crate::expression::{
    Binary, CHOICE, Condition, Expression, ExpressionKind, FUNCTIONS, Function, Graph, Id,
    NotANumber, Test,
};
use crate::kernel::{Combination, HELD_PER_INPUT};

/// Names that may occur in an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scope {
    /// Time, states and the sides of contacts.
    Sides(Combination),
    /// Time and states. The string says what the expression is.
    NoSides(&'static str),
    /// Neither time nor states. The string says what the expression is.
    Constant(&'static str),
}

/// The scope of a parameter's value, which has numbers alone.
pub(super) const NUMBERS: Scope = Scope::Constant("the value of a parameter");

/// Most parameters that can be states at once.
pub const MOST_FREE: usize = 16;

/// Parameters that are states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Freed {
    /// Indices of the parameters, in order of these states.
    pub parameters: [Option<usize>; MOST_FREE],
    /// Whether time is scaled so that a period that depends on them stays what it is.
    pub scales_time: bool,
}

/// All parameters have their values.
pub(crate) const NONE_FREE: Freed = Freed {
    parameters: [None; MOST_FREE],
    scales_time: true,
};

impl Freed {
    /// Frees the first [`MOST_FREE`] of these parameters.
    pub fn of(parameters: &[usize], scales_time: bool) -> Self {
        let mut freed = Freed {
            scales_time,
            ..NONE_FREE
        };
        for (slot, parameter) in freed.parameters.iter_mut().zip(parameters) {
            *slot = Some(*parameter);
        }
        freed
    }

    /// Number of free parameters.
    pub fn count(&self) -> usize {
        self.parameters.iter().flatten().count()
    }
}

/// Parameters and time of an expression.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inputs<'a> {
    /// Values of the parameters.
    values: &'a [f64],
    /// Parameters that are states instead, after those of the file and in this order.
    free: Freed,
    /// Rate of the file's time in scaled time, if it depends on a free parameter.
    pace: Option<Id>,
}

impl<'a> Inputs<'a> {
    /// All parameters have fixed values.
    pub(super) fn fixed(values: &'a [f64]) -> Self {
        Self::free(values, NONE_FREE)
    }

    /// Some of the parameters may be states.
    pub(super) fn free(values: &'a [f64], free: Freed) -> Self {
        Inputs {
            values,
            free,
            pace: None,
        }
    }

    /// Number of parameters that are states.
    pub(super) fn count_free(&self) -> usize {
        self.free.count()
    }

    /// Index of a parameter among those that are states.
    fn place(&self, parameter: usize) -> Option<usize> {
        self.free
            .parameters
            .iter()
            .flatten()
            .position(|free| *free == parameter)
    }

    /// A rate per scaled time as one per time of the file.
    pub(super) fn in_file_time(&self, graph: &mut Graph, rate: Id) -> Result<Id, NotANumber> {
        match self.pace {
            None => Ok(rate),
            Some(pace) => graph.binary(Binary::Quotient, rate, pace),
        }
    }

    /// Scope with another time scale.
    pub(super) fn paced(self, pace: Option<Id>) -> Self {
        Inputs { pace, ..self }
    }
}

/// Part of an expression: whether it is a number as written, and its position.
pub(super) type Operand = (bool, Range<usize>);

pub(super) fn of_operand(operand: &Expression) -> Operand {
    let is_plain = matches!(operand.kind, ExpressionKind::Number(_));
    (is_plain, operand.span.clone())
}

/// State of a named part.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PartState {
    NotYet,
    UnderWay,
    Done(Id),
}

/// A choice in an expression.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    pub test: Condition,
    /// The lead of each comparison, as of [`Builder::leads`].
    pub leads: Vec<Id>,
    /// The choices, by number, of whose branch it is part: that where they hold, or the other one.
    pub within: Vec<(usize, bool)>,
}

/// Adds expressions to a graph.
pub(super) struct Builder<'a> {
    file: &'a SystemFile,
    inputs: Inputs<'a>,
    graph: &'a mut Graph,
    scope: Scope,
    definitions: Vec<PartState>,
    frictions: Vec<PartState>,
    /// The reactions of the stops, once they are known.
    forces: Option<Vec<Id>>,
    /// The friction forces of the contacts, where they are known.
    frictional: Option<Vec<Id>>,
    /// The speed of approach, in a restitution.
    approach: Option<Id>,
    /// Whether a choice may stand here.
    chooses: bool,
    /// The choices so far, and those of whose branches the present place is part.
    choices: Vec<Chosen>,
    within: Vec<(usize, bool)>,
    /// Bits of the contacts whose sides were used.
    pub(super) sided: usize,
    /// Levels of nesting so far.
    depth: usize,
}

/// Most levels of nesting, through brackets and definitions, so that recursion does not overflow
/// the stack of a thread. It is chosen: files written by hand have far fewer.
const MOST_DEPTH: usize = 300;

type BuildResult = Result<Id, Problem>;
type BuildNumber = Result<Id, NotANumber>;

impl<'a> Builder<'a> {
    pub(super) fn new(
        file: &'a SystemFile,
        inputs: Inputs<'a>,
        graph: &'a mut Graph,
        scope: Scope,
    ) -> Self {
        Builder {
            file,
            inputs,
            graph,
            scope,
            definitions: vec![PartState::NotYet; file.definitions.len()],
            frictions: vec![PartState::NotYet; file.contacts.len()],
            forces: None,
            frictional: None,
            approach: None,
            chooses: false,
            choices: Vec::new(),
            within: Vec::new(),
            sided: 0,
            depth: 0,
        }
    }

    /// A builder in whose expressions choices may stand, which are made once.
    pub(super) fn choosing(mut self) -> Self {
        self.chooses = true;
        self
    }

    /// The choices in an expression, with their leads in the graph, behind that expression.
    pub(super) fn with_choices(mut self, formula: &Formula) -> Result<(Id, Vec<Chosen>), Problem> {
        let root = self.formula(formula)?;
        Ok((root, self.choices))
    }

    /// A builder in whose expressions the reactions of the stops are these.
    pub(super) fn with_forces(mut self, forces: Vec<Id>) -> Self {
        self.forces = Some(forces);
        self
    }

    /// A builder in whose expressions the friction forces of the contacts are these.
    pub(super) fn with_friction_forces(mut self, forces: Vec<Id>) -> Self {
        self.frictional = Some(forces);
        self
    }

    /// A builder in whose expressions `approach` is this speed.
    pub(super) fn approached_at(mut self, speed: Id) -> Self {
        self.approach = Some(speed);
        self
    }

    /// Discards what has been built but keeps the record of used sides.
    pub(super) fn forget(&mut self) {
        self.definitions.fill(PartState::NotYet);
        self.frictions.fill(PartState::NotYet);
    }

    /// Whether the friction of a contact has been built.
    pub(super) fn has_friction(&self, contact: usize) -> bool {
        self.frictions[contact] != PartState::NotYet
    }

    /// The rates with these reactions of the stops.
    pub(super) fn field_with(&mut self, forces: &[Id]) -> Result<Vec<Id>, Problem> {
        self.forget();
        self.forces = Some(forces.to_vec());
        self.field()
    }

    /// The rates of all states, and of the parameters that are states.
    pub(super) fn field(&mut self) -> Result<Vec<Id>, Problem> {
        let file = self.file;
        let forces = match file.stops.is_empty() {
            true => Vec::new(),
            false => self.all_forces(0..0)?,
        };
        let mut built = Vec::with_capacity(self.file.field.len() + 1);
        let is_above = matches!(self.scope, Scope::Sides(Combination { above: 1, .. }));
        for (state, rate) in file.field.iter().enumerate() {
            let formula = rate.on_side(is_above);
            let mut rate = self.formula(formula)?;
            for (stop, force) in file.stops.iter().zip(&forces) {
                let Some(acts) = stop.acts.get(state).and_then(Option::as_ref) else {
                    continue;
                };
                let part = self.formula(acts)?;
                let part = self.graph.binary(Binary::Product, part, *force);
                let sum = part.and_then(|part| self.graph.binary(Binary::Sum, rate, part));
                rate = sum.map_err(|error| no_number(error, acts.whole()))?;
            }
            let rate = self.directed(rate, formula.whole())?;
            built.push(self.in_time(rate, formula.whole())?);
        }
        for _ in 0..self.inputs.count_free() {
            let none = self.graph.constant(0.0);
            built.push(none.map_err(|error| no_number(error, 0..0))?);
        }
        Ok(built)
    }

    /// The reactions of all stops, in this combination of sides.
    fn all_forces(&mut self, place: Range<usize>) -> Result<Vec<Id>, Problem> {
        if let Some(forces) = &self.forces {
            return Ok(forces.clone());
        }
        let forces = match self.scope {
            Scope::Sides(of) => super::stops::reactions(self.file, self.inputs, self.graph, of)?,
            // Both ends of a gap have the same reaction on every side, or it has no one value.
            Scope::NoSides(_) | Scope::Constant(_) => {
                let all = (1 << self.file.contacts.len()) - 1;
                let mut on = |above| {
                    let of = Combination { above, held: 0 };
                    super::stops::reactions(self.file, self.inputs, self.graph, of)
                };
                let (below, above) = (on(0)?, on(all)?);
                if !are_same(self.graph, (&below, &above)) {
                    let message = "the force of a stop depends here on the sides of contacts";
                    return Err(Problem::new(message, place).help(
                        "it can stand in [field], friction laws and the definitions that these use",
                    ));
                }
                below
            }
        };
        self.forces = Some(forces.clone());
        Ok(forces)
    }

    /// A rate, or a time, of the file in the direction in which time runs.
    fn directed(&mut self, id: Id, place: Range<usize>) -> BuildResult {
        if !self.file.is_reversed {
            return Ok(id);
        }
        let negative = self.graph.negative(id);
        negative.map_err(|error| no_number(error, place))
    }

    /// Converts a rate, or a time, of the file to scaled time.
    fn in_time(&mut self, id: Id, place: Range<usize>) -> BuildResult {
        match self.inputs.pace {
            None => Ok(id),
            Some(pace) => {
                let product = self.graph.binary(Binary::Product, id, pace);
                product.map_err(|error| no_number(error, place))
            }
        }
    }

    pub(super) fn formula(&mut self, formula: &Formula) -> BuildResult {
        self.expression(formula, &formula.tree)
    }

    pub(super) fn expression(&mut self, formula: &Formula, expression: &Expression) -> BuildResult {
        self.depth += 1;
        if self.depth > MOST_DEPTH {
            let message = format!("nested deeper than {MOST_DEPTH} levels, definitions included");
            return Err(Problem::new(message, formula.at(&expression.span))
                .help("write what is repeated as states, or as one sum"));
        }
        let built = self.built(formula, expression);
        self.depth -= 1;
        built
    }

    fn built(&mut self, formula: &Formula, expression: &Expression) -> BuildResult {
        let place = formula.at(&expression.span);
        let value = match &expression.kind {
            ExpressionKind::Number(value) => self.graph.constant(*value),
            ExpressionKind::Name(name) => return self.name(name, place),
            ExpressionKind::Condition(_) => {
                return Err(Problem::new("a condition is no number", place));
            }
            ExpressionKind::Negative(inner) => {
                let inner = self.expression(formula, inner)?;
                self.graph.negative(inner)
            }
            ExpressionKind::Chain(first, rest) => {
                let (mut id, start) = (self.expression(formula, first)?, first.span.start);
                // The part so far, as an operand of the next.
                let mut part = of_operand(first);
                for (operator, operand) in rest {
                    let next = self.expression(formula, operand)?;
                    let value = self.graph.binary(*operator, id, next);
                    let whole = start..operand.span.end;
                    let operands = [(part, id), (of_operand(operand), next)];
                    id = value.map_err(|error| {
                        self.not_finite(error, formula, formula.at(&whole), &operands)
                    })?;
                    part = (false, whole);
                }
                return Ok(id);
            }
            ExpressionKind::Call {
                function,
                place: name,
                arguments,
            } => {
                let name = formula.at(name);
                return self.call(formula, function, name, arguments, place);
            }
        };
        value.map_err(|error| no_number(error, place))
    }

    /// Reports a constant part that is not finite, with the values of its operands.
    fn not_finite(
        &self,
        error: NotANumber,
        formula: &Formula,
        place: Range<usize>,
        operands: &[(Operand, Id)],
    ) -> Problem {
        let operands = operands.iter().filter_map(|((is_plain, span), id)| {
            let value = self.graph.value(*id).filter(|_| !is_plain)?;
            Some((formula.part(span), value))
        });
        let operands: Vec<(String, f64)> = operands.collect();
        let problem = no_number(error, place);
        let message = problem.message + &where_operands(&operands);
        Problem { message, ..problem }
    }

    fn name(&mut self, name: &str, place: Range<usize>) -> BuildResult {
        if let Some(speed) = self.approach.filter(|_| name == "approach") {
            return Ok(speed);
        }
        let Some(meaning) = self.file.names.get(name) else {
            return Err(self.unknown(name, place));
        };
        match (meaning, self.scope) {
            (Meaning::Pi, _) => {
                let made = self.graph.constant(std::f64::consts::PI);
                made.map_err(|error| no_number(error, place))
            }
            (Meaning::Parameter(number), Scope::Sides(_) | Scope::NoSides(_))
                if self.inputs.place(number).is_some() =>
            {
                let behind = self.inputs.place(number).unwrap_or(0);
                Ok(self.graph.state(self.file.states.len() + behind))
            }
            (Meaning::Parameter(number), _) => {
                let made = self.graph.parameter(number, self.inputs.values[number]);
                made.map_err(|error| no_number(error, place))
            }
            (
                Meaning::Time | Meaning::State(_) | Meaning::Input(_) | Meaning::Force(_),
                Scope::Constant(what),
            ) => {
                let message = format!(
                    "{what} cannot depend on `{name}`, which is {}",
                    meaning.description()
                );
                Err(Problem::new(message, place)
                    .help("it is a number, or an expression of numbers and parameters"))
            }
            (Meaning::Time, _) => {
                let time = self.graph.time();
                let time = self.directed(time, place.clone())?;
                self.in_time(time, place)
            }
            (Meaning::State(number), _) => Ok(self.graph.state(number)),
            (Meaning::Input(number), _) => self.input(number, place),
            (Meaning::Force(number), _) => Ok(self.all_forces(place)?[number]),
            (Meaning::Friction(number), _) => match &self.frictional {
                Some(forces) => Ok(forces[number]),
                None => {
                    let contact = &self.file.contacts[number].name;
                    let message =
                        format!("`{name}` is known along an orbit alone, as what is observed");
                    Err(Problem::new(message, place)
                        .help(format!("in rates and laws it is friction({contact})")))
                }
            },
            (Meaning::Stop(_), _) => Err(Problem::new(
                format!("`{name}` is a stop and has no value"),
                place,
            )
            .help(format!(
                "`{name}.force` is its reaction, `{name}.closed` is 1 while it carries"
            ))),
            (Meaning::Jump(_), _) => Err(Problem::new(
                format!("`{name}` is a jump and has no value"),
                place,
            )
            .help("a discrete state that the jump sets can stand here")),
            (Meaning::Curve(_), _) => Err(Problem::new(
                format!("`{name}` is a curve and has no value by itself"),
                place,
            )
            .help(format!("write {name}(…), with its argument"))),
            (Meaning::Definition(number), _) => self.definition(number),
            (Meaning::Contact(number), _) => {
                let above = self.side(number, place.clone())?;
                let sign = if above { 1.0 } else { -1.0 };
                self.graph
                    .constant(sign)
                    .map_err(|error| no_number(error, place))
            }
        }
    }

    /// The value of an input: the value held, plus its slope times its clock.
    fn input(&mut self, number: usize, place: Range<usize>) -> BuildResult {
        let entry = &self.file.inputs[number];
        let states = self.file.states.len() + self.inputs.count_free();
        let held = states + HELD_PER_INPUT * number;
        let value = self.graph.state(held);
        let pieces = match &entry.shape {
            InputShape::Switch(_) => return Ok(value),
            InputShape::Periodic { pieces, .. } | InputShape::Table(pieces) => pieces,
        };
        if pieces.iter().all(|piece| piece.slope == 0.0) {
            return Ok(value);
        }
        let (slope, clock) = (self.graph.state(held + 1), self.clock(entry)?);
        let made = self.graph.binary(Binary::Product, slope, clock);
        let made = made.and_then(|product| self.graph.binary(Binary::Sum, value, product));
        made.map_err(|error| no_number(error, place))
    }

    /// The clock of an input. For a switch, it is the function whose sign it takes.
    pub(super) fn clock(&mut self, entry: &InputEntry) -> BuildResult {
        let time = self.graph.time();
        let time = self.in_time(time, entry.place.clone())?;
        let (period, phase) = match &entry.shape {
            InputShape::Switch(function) => return self.formula(function),
            InputShape::Table(_) => return Ok(time),
            InputShape::Periodic { period, phase, .. } => (self.of_input(period, "period")?, phase),
        };
        let made = self.graph.binary(Binary::Quotient, time, period);
        let mut made = made.map_err(|error| no_number(error, entry.place.clone()))?;
        if let Some(phase) = phase {
            let phase = self.of_input(phase, "phase")?;
            let sum = self.graph.binary(Binary::Sum, made, phase);
            made = sum.map_err(|error| no_number(error, entry.place.clone()))?;
        }
        Ok(made)
    }

    /// The period, phase or width of an input, which must be constant so that its clock runs
    /// uniformly.
    pub(super) fn of_input(&mut self, formula: &Formula, what: &str) -> BuildResult {
        let made = self.formula(formula)?;
        if self.graph.depends_on_time(made) {
            let message = format!("the {what} of an input cannot depend on time");
            return Err(Problem::new(message, formula.whole())
                .help("an input with another clock is a switch: the sign of a function of time"));
        }
        if self.inputs.count_free() == 0 && self.graph.depends_on_state(made) {
            let message =
                format!("the {what} of an input cannot depend on a state or another input");
            return Err(Problem::new(message, formula.whole()).help(
                "it is an expression of parameters; what depends on states is a jump that sets a \
                 discrete state",
            ));
        }
        let asked = match what {
            "period" => Some(Test::Positive),
            "width" => Some(Test::InsideUnit),
            _ => None,
        };
        let is_wrong = asked.is_some_and(|asked| !self.graph.is(made, asked));
        match self.graph.value(made).filter(|_| is_wrong) {
            Some(period) if what == "period" => Err(Problem::new(
                format!("the period is {}, but must be positive", readable(period)),
                formula.whole(),
            )
            .help("it is the time after which the input comes again")),
            Some(width) => {
                let message = format!("the width {} is not between 0 and 1", readable(width));
                Err(Problem::new(message, formula.whole())
                    .help("it is the part of the period in which the pulse is 1"))
            }
            None => Ok(made),
        }
    }

    fn unknown(&self, name: &str, place: Range<usize>) -> Problem {
        let problem = Problem::new(format!("unknown name `{name}`"), place).label("not known here");
        if is_function(name) {
            return problem.help(format!("`{name}` is a function: write {name}(…)"));
        }
        if self.scope == NUMBERS {
            return problem.help(
                "the value of a parameter has numbers only; what depends on other parameters goes \
                    into [definitions]",
            );
        }
        problem.help(self.file.names.like(name).unwrap_or_else(|| {
            "names are states, parameters, definitions, contacts, inputs, t (time) and pi"
                .to_owned()
        }))
    }

    /// Whether a contact is above.
    fn side(&mut self, number: usize, place: Range<usize>) -> Result<bool, Problem> {
        match self.scope {
            Scope::Sides(Combination { above, .. }) => {
                self.sided |= 1 << number;
                Ok(above & 1 << number != 0)
            }
            Scope::NoSides(what) | Scope::Constant(what) => Err(Problem::new(
                format!("{what} cannot depend on the side of a contact"),
                place,
            )
            .help("sides belong into [field], friction laws and the definitions that these use")),
        }
    }

    pub(super) fn definition(&mut self, number: usize) -> BuildResult {
        let definition = &self.file.definitions[number];
        match self.definitions[number] {
            PartState::Done(id) => return Ok(id),
            PartState::UnderWay => {
                let message = format!("the definition of `{}` depends on itself", definition.name);
                return Err(Problem::new(message, definition.formula.whole()));
            }
            PartState::NotYet => {}
        }
        self.definitions[number] = PartState::UnderWay;
        // What stands in it counts wherever the definition does.
        let within = std::mem::take(&mut self.within);
        let id = self.formula(&definition.formula)?;
        self.within = within;
        self.definitions[number] = PartState::Done(id);
        Ok(id)
    }

    fn call(
        &mut self,
        formula: &Formula,
        function: &str,
        name: Range<usize>,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> BuildResult {
        if let Some(Meaning::Curve(number)) = self.file.names.get(function) {
            return self.curve(formula, number, arguments, place);
        }
        match function {
            "friction" => return self.friction(formula, arguments, place),
            "by_side" => return self.by_side(formula, arguments, place),
            "min" | "max" => {
                let (Some((first, rest)), 2..) = (arguments.split_first(), arguments.len()) else {
                    let (wanted, found) = ("two or more arguments", arguments.len());
                    return Err(wrong_count(function, wanted, found, place));
                };
                let mut best = self.expression(formula, first)?;
                for argument in rest {
                    let next = self.expression(formula, argument)?;
                    let made = match function {
                        "min" => self.graph.smaller(best, next),
                        _ => self.graph.larger(best, next),
                    };
                    best = made.map_err(|error| no_number(error, place.clone()))?;
                }
                return Ok(best);
            }
            "asin" | "acos" | "atan2" | "erf" | "log10" | "hypot" | "clamp" => {
                return self.composed(formula, function, arguments, place);
            }
            CHOICE => return self.choice(formula, arguments, (name, place)),
            _ => {}
        }
        let Some(known) = Function::named(function) else {
            return Err(self.no_function(function, name));
        };
        let [argument] = arguments else {
            return Err(wrong_count(
                function,
                "one argument",
                arguments.len(),
                place,
            ));
        };
        let id = self.expression(formula, argument)?;
        let value = self.graph.call(known, id);
        let operands = [(of_operand(argument), id)];
        value.map_err(|error| self.not_finite(error, formula, place, &operands))
    }

    /// A curve at an argument.
    fn curve(
        &mut self,
        formula: &Formula,
        number: usize,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> BuildResult {
        let entry = &self.file.curves[number];
        let [argument] = arguments else {
            let wanted = "one argument";
            return Err(wrong_count(&entry.name, wanted, arguments.len(), place));
        };
        let id = self.expression(formula, argument)?;
        let value = self.graph.curve(&entry.curve, id);
        let operands = [(of_operand(argument), id)];
        value.map_err(|error| self.not_finite(error, formula, place, &operands))
    }

    /// A function that others make up, or that has further ones.
    fn composed(
        &mut self,
        formula: &Formula,
        function: &str,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> BuildResult {
        let (wanted, count) = match function {
            "hypot" => ("two arguments", 2),
            "atan2" => ("two arguments, y and x", 2),
            "clamp" => ("a number, its lowest and its highest value", 3),
            _ => ("one argument", 1),
        };
        if arguments.len() != count {
            return Err(wrong_count(function, wanted, arguments.len(), place));
        }
        let mut ids = Vec::with_capacity(count);
        for argument in arguments {
            ids.push(self.expression(formula, argument)?);
        }
        let made = composed(self.graph, function, &ids);
        let operands = arguments.iter().map(of_operand).zip(ids.iter().copied());
        let operands: Vec<(Operand, Id)> = operands.collect();
        made.map_err(|error| self.not_finite(error, formula, place, &operands))
    }

    /// Adds the choice of one of two expressions, by the sign of a third.
    fn choice(
        &mut self,
        formula: &Formula,
        arguments: &[Expression],
        (name, place): (Range<usize>, Range<usize>),
    ) -> BuildResult {
        if !self.chooses {
            return Err(
                Problem::new("a choice can stand only at a jump", name).help(
                    "in fields and laws what switches is a contact, by_side(contact, below, \
                     above), a jump that sets a discrete state, or a switch",
                ),
            );
        }
        let [condition, yes, no] = arguments else {
            let wanted = "a condition, the expression where it holds and the one elsewhere";
            return Err(wrong_count(CHOICE, wanted, arguments.len(), place));
        };
        let ExpressionKind::Condition(condition) = &condition.kind else {
            let place = formula.at(&condition.span);
            return Err(Problem::new("this is a number, not a condition", place)
                .help("a condition compares two numbers, as in v < 0.1"));
        };
        let number = self.choices.len();
        self.choices.push(Chosen {
            test: (**condition).clone(),
            leads: Vec::new(),
            within: self.within.clone(),
        });
        let mut branch = |holds: bool, of: &Expression| {
            self.within.push((number, holds));
            let made = self.expression(formula, of);
            self.within.pop();
            made
        };
        let branches = [branch(true, yes)?, branch(false, no)?];
        let leads = self.leads(formula, condition)?;
        if let Some(choice) = self.choices.get_mut(number) {
            choice.leads = leads;
        }
        self.chosen((formula, condition), branches, &place)
    }

    /// The number whose sign decides each comparison of a condition, in order.
    pub(super) fn leads(
        &mut self,
        formula: &Formula,
        condition: &Condition,
    ) -> Result<Vec<Id>, Problem> {
        let numbers = condition.numbers();
        let pairs = numbers.chunks_exact(2);
        let lead = |pair: &[&Expression]| {
            let (larger, smaller) = (
                self.expression(formula, pair[0])?,
                self.expression(formula, pair[1])?,
            );
            let lead = self.graph.binary(Binary::Difference, larger, smaller);
            lead.map_err(|error| no_number(error, formula.at(&pair[0].span)))
        };
        pairs.map(lead).collect()
    }

    /// The first of two numbers where a condition holds, the second elsewhere.
    fn chosen(
        &mut self,
        (formula, condition): (&Formula, &Condition),
        [yes, no]: [Id; 2],
        place: &Range<usize>,
    ) -> BuildResult {
        match condition {
            Condition::Comparison {
                larger,
                smaller,
                with_equal,
            } => {
                // Where equal numbers count, the opposite is asked for.
                let ([more, less], [there, elsewhere]) = match with_equal {
                    false => ([larger, smaller], [yes, no]),
                    true => ([smaller, larger], [no, yes]),
                };
                let (more, less) = (
                    self.expression(formula, more)?,
                    self.expression(formula, less)?,
                );
                let lead = self.graph.binary(Binary::Difference, more, less);
                let made = lead.and_then(|lead| self.graph.chosen(lead, there, elsewhere));
                made.map_err(|error| no_number(error, place.clone()))
            }
            Condition::Not(part) => self.chosen((formula, part), [no, yes], place),
            Condition::All(parts) => parts.iter().rev().try_fold(yes, |yes, part| {
                self.chosen((formula, part), [yes, no], place)
            }),
            Condition::Any(parts) => parts.iter().rev().try_fold(no, |no, part| {
                self.chosen((formula, part), [yes, no], place)
            }),
        }
    }

    /// The friction force of a contact: its sign times the law that holds in this mode, and zero if
    /// the normal force is not positive.
    fn friction(
        &mut self,
        formula: &Formula,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> BuildResult {
        let number = self.contact(formula, "friction", arguments.first(), place.clone())?;
        if arguments.len() != 1 {
            return Err(wrong_count(
                "friction",
                "the name of a contact",
                arguments.len(),
                place,
            ));
        }
        // The error of a side comes first.
        self.side(number, place.clone())?;
        let contact = &self.file.contacts[number];
        if contact.friction.is_none() {
            return Err(Problem::new(
                format!("contact `{}` has no friction law", contact.name),
                place,
            )
            .also(contact.place.clone(), "this contact")
            .help("write friction = \"…\" there: how large friction is in slip"));
        }
        self.friction_force(number)
    }

    /// The friction force of a contact in this mode, zero if it has no law.
    pub(super) fn friction_force(&mut self, number: usize) -> BuildResult {
        let place = self.file.contacts[number].place.clone();
        let above = self.side(number, place.clone())?;
        let size = self.size(number)?;
        match above {
            true => Ok(size),
            false => {
                let force = self.graph.negative(size);
                force.map_err(|error| no_number(error, place))
            }
        }
    }

    /// The size of the friction of a contact in this mode: its law, or zero if it has none or the
    /// normal force is not positive.
    pub(super) fn size(&mut self, number: usize) -> BuildResult {
        let contact = &self.file.contacts[number];
        let Some(slip) = &contact.friction else {
            let zero = self.graph.constant(0.0);
            return zero.map_err(|error| no_number(error, contact.place.clone()));
        };
        let is_held = matches!(self.scope, Scope::Sides(of) if of.held & 1 << number != 0);
        let law = contact.holding.as_ref().filter(|_| is_held).unwrap_or(slip);
        match self.frictions[number] {
            PartState::Done(id) => return Ok(id),
            PartState::UnderWay => {
                let message = format!(
                    "the friction of contact `{}` depends on itself",
                    contact.name
                );
                return Err(Problem::new(message, law.whole()));
            }
            PartState::NotYet => self.frictions[number] = PartState::UnderWay,
        }
        let mut id = self.formula(law)?;
        if let Some(value) = self.graph.value(id)
            && self.graph.is(id, Test::Negative)
        {
            let message = format!(
                "the friction of contact `{}` is {}, but must not be negative",
                contact.name,
                readable(value)
            );
            return Err(Problem::new(message, law.whole()).help(
                "it is a size, and acts against the slip; the sign of what it does \
                 stands in [field]",
            ));
        }
        if let Some(force) = &contact.normal_force {
            let force = self.formula(force)?;
            let made = self.graph.where_positive(force, id);
            id = made.map_err(|error| no_number(error, law.whole()))?;
        }
        self.frictions[number] = PartState::Done(id);
        Ok(id)
    }

    fn by_side(
        &mut self,
        formula: &Formula,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> BuildResult {
        let number = self.contact(formula, "by_side", arguments.first(), place.clone())?;
        let [_, below, above] = arguments else {
            let wanted = "a contact, the expression below and the one above";
            return Err(wrong_count("by_side", wanted, arguments.len(), place));
        };
        // Both sides are built, so that an error on the other side is reported too.
        let (below, above) = (
            self.expression(formula, below)?,
            self.expression(formula, above)?,
        );
        let is_above = self.side(number, place)?;
        Ok(if is_above { above } else { below })
    }

    /// The contact that an argument names.
    fn contact(
        &self,
        formula: &Formula,
        function: &str,
        argument: Option<&Expression>,
        place: Range<usize>,
    ) -> Result<usize, Problem> {
        let Some(argument) = argument else {
            return Err(wrong_count(function, "the name of a contact", 0, place));
        };
        let place = formula.at(&argument.span);
        let ExpressionKind::Name(name) = &argument.kind else {
            return Err(Problem::new(
                format!("{function} takes the name of a contact here"),
                place,
            ));
        };
        if let Some(Meaning::Contact(number)) = self.file.names.get(name) {
            return Ok(number);
        }
        let contacts = self.file.contacts.iter();
        let names: Vec<&str> = contacts.map(|contact| contact.name.as_str()).collect();
        let help = did_you_mean(name, names.iter().copied())
            .unwrap_or_else(|| format!("the contacts are {}", super::table::listed(&names)));
        Err(Problem::new(format!("`{name}` is no contact"), place).help(help))
    }

    fn no_function(&self, function: &str, place: Range<usize>) -> Problem {
        let problem =
            Problem::new(format!("unknown function `{function}`"), place).label("not known");
        if let Some(meaning) = self.file.names.get(function) {
            return Problem {
                message: format!("`{function}` is {}, not a function", meaning.description()),
                ..problem
            }
            .help(format!("a product needs its sign: {function}*(…)"));
        }
        let curves = self.file.curves.iter();
        let all = FUNCTIONS
            .iter()
            .map(|(name, _)| *name)
            .chain(FURTHER_FUNCTIONS)
            .chain(LATER_FUNCTIONS)
            .chain(curves.map(|curve| curve.name.as_str()));
        problem.help(match function {
            "sgn" | "sign" | "signum" => {
                "friction is written by side: the name of a contact is the sign of its side; the \
                 sign of a function of time is a switch, [switches.NAME] with function = \"…\""
                    .to_owned()
            }
            "mod" | "floor" | "ceil" | "round" | "square" | "triangle" | "sawtooth" | "pulse" => {
                "what repeats in time is an input: [inputs.NAME] with shape = \"sawtooth\" and \
                 period = \"…\""
                    .to_owned()
            }
            "log" => "the natural logarithm is ln, the decimal one log10".to_owned(),
            "pow" => "a power is written x^2".to_owned(),
            _ => did_you_mean(function, all.clone()).unwrap_or_else(|| {
                let all: Vec<&str> = all.collect();
                format!("there are {}", all.join(", "))
            }),
        })
    }
}

/// Whether numbers of a graph are the same, one by one.
pub(super) fn are_same(graph: &mut Graph, (ones, others): (&[Id], &[Id])) -> bool {
    let mut pairs = ones.iter().zip(others);
    ones.len() == others.len() && pairs.all(|(one, other)| graph.are_same(*one, *other))
}

/// A function of numbers of a graph that others make up, or that the graph has.
fn composed(graph: &mut Graph, function: &str, of: &[Id]) -> BuildNumber {
    let one = graph.constant(1.0)?;
    match (function, of) {
        ("asin" | "acos", &[x]) => {
            // (1 − x)(1 + x) keeps its digits near both ends, where 1 − x² loses them.
            let (below, above) = (
                graph.binary(Binary::Difference, one, x)?,
                graph.binary(Binary::Sum, one, x)?,
            );
            let square = graph.binary(Binary::Product, below, above)?;
            let root = graph.call(Function::Sqrt, square)?;
            let slope = graph.binary(Binary::Quotient, x, root)?;
            let angle = graph.call(Function::Atan, slope)?;
            if function == "asin" {
                return Ok(angle);
            }
            let right = graph.constant(std::f64::consts::FRAC_PI_2)?;
            graph.binary(Binary::Difference, right, angle)
        }
        ("atan2", &[y, x]) => graph.angle(y, x),
        ("erf", &[x]) => graph.call(Function::Erf, x),
        ("log10", &[x]) => {
            let (logarithm, ten) = (graph.call(Function::Ln, x)?, graph.constant(10.0)?);
            let unit = graph.call(Function::Ln, ten)?;
            graph.binary(Binary::Quotient, logarithm, unit)
        }
        ("hypot", &[x, y]) => {
            let squares = [x, y].map(|one| graph.binary(Binary::Product, one, one));
            let [x, y] = squares;
            let sum = graph.binary(Binary::Sum, x?, y?)?;
            graph.call(Function::Sqrt, sum)
        }
        (_, &[x, low, high]) => {
            let raised = graph.larger(x, low)?;
            graph.smaller(raised, high)
        }
        _ => graph.constant(f64::NAN),
    }
}

fn wrong_count(function: &str, wanted: &str, found: usize, place: Range<usize>) -> Problem {
    let found = match found {
        0 => "none".to_owned(),
        some => some.to_string(),
    };
    Problem::new(format!("{function} takes {wanted}, not {found}"), place)
}

pub(super) fn no_number(error: NotANumber, place: Range<usize>) -> Problem {
    let what = not_finite(error.value);
    Problem::new(format!("this is {what}"), place)
        .label("with the parameters' values")
        .help("change the expression, or a parameter in it")
}
