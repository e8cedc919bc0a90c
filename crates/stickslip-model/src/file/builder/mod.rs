//! Adds expressions to a graph and resolves every name.

mod calls;
mod choices;
mod field;
mod free;
mod friction;
mod inputs;

use std::ops::Range;

use super::formula::{not_finite, where_operands};
use super::names::{Meaning, is_function};
use super::problem::Problem;
use super::{Formula, SystemFile};
use crate::expression::{Expression, ExpressionKind, Graph, Id, NotANumber};
use crate::kernel::Combination;
pub(super) use choices::Chosen;
pub use free::MOST_FREE;
pub(super) use free::{Freed, Inputs, NONE_FREE};

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

/// Adds expressions to a graph.
pub(super) struct Builder<'a> {
    file: &'a SystemFile,
    inputs: Inputs<'a>,
    graph: &'a mut Graph,
    scope: Scope,
    definitions: Vec<PartState>,
    frictions: Vec<PartState>,
    /// The boundary functions of the contacts, once they are needed; `None` for a wrong one.
    boundaries: Vec<Option<Id>>,
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
            boundaries: Vec::new(),
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
            return match self.file.names.get(name) {
                None => Ok(speed),
                Some(known) => {
                    let known = known.description();
                    let message = format!("`approach` is {known} and the speed of approach");
                    let help = "choose another name for the first";
                    Err(Problem::new(message, place).help(help))
                }
            };
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
                self.directed(time, place)
            }
            (Meaning::State(number), _) => Ok(self.graph.state(number)),
            (Meaning::Input(number), _) => self.input(number, place),
            (Meaning::Force(number), _) => Ok(self.all_forces(place)?[number]),
            (Meaning::Friction(number), _) => match &self.frictional {
                Some(forces) => Ok(forces[number]),
                None => {
                    let contact = &self.file.contacts[number].name;
                    let message =
                        format!("`{name}` is known along an orbit alone, where its mode is known");
                    let contacts = self.file.contacts.iter();
                    let laws = contacts.flat_map(|one| [&one.friction, &one.holding]);
                    let is_of_law =
                        { laws.flatten() }.any(|law| law.whole().contains(&place.start));
                    let help = match is_of_law {
                        true => "a law follows the reaction of a stop: what presses the contact \
                                 is [stops.NAME], with friction = \"mu*NAME.force\"; the forces \
                                 of two contacts do not add where both stick"
                            .to_owned(),
                        false => format!(
                            "in rates it is friction({contact}); a fit observes it where there is \
                             one contact"
                        ),
                    };
                    Err(Problem::new(message, place).help(help))
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
}

/// Whether numbers of a graph are the same, one by one.
pub(super) fn are_same(graph: &mut Graph, (ones, others): (&[Id], &[Id])) -> bool {
    let mut pairs = ones.iter().zip(others);
    ones.len() == others.len() && pairs.all(|(one, other)| graph.are_same(*one, *other))
}

pub(super) fn no_number(error: NotANumber, place: Range<usize>) -> Problem {
    let what = not_finite(error.value);
    Problem::new(format!("this is {what}"), place)
        .label("with the parameters' values")
        .help("change the expression, or a parameter in it")
}
