//! From the expressions of a file to tapes: every name becomes what it stands for.

use std::ops::Range;

use super::names::{FURTHER_FUNCTIONS, Meaning, did_you_mean, is_function};
use super::{Formula, Rate, SystemFile};
use crate::problem::Problem;
use stickslip_kernels::expression::{
    Expression, FUNCTIONS, Function, Graph, Id, Kind, NotANumber, Tape, TooLarge,
};

/// What may occur in an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scope {
    /// Time, states and the sides of contacts: bit `i` of `above` is set where contact `i` is above, of `held` where it holds.
    Sides { above: usize, held: usize },
    /// Time and states; the name says where.
    NoSides(&'static str),
    /// Neither; the name says where.
    Constant(&'static str),
}

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
    let mut builder = Builder {
        file: None,
        values: &[],
        graph: &mut graph,
        scope: Scope::Constant("the value of a parameter"),
        definitions: Vec::new(),
        frictions: Vec::new(),
        sided: 0,
    };
    let built = builder.formula(formula)?;
    // Of numbers alone everything folds.
    Ok(graph.value(built).unwrap_or(f64::NAN))
}

/// Finds what is wrong with any expression of the file, used or not.
pub(super) fn check(file: &SystemFile) -> Result<(), Problem> {
    let mut graph = Graph::new();
    let values = values(file);
    let scope = Scope::Sides { above: 0, held: 0 };
    let mut builder = Builder::new(file, &values, &mut graph, scope);
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
    builder.definitions.fill(Progress::NotYet);
    builder.frictions.fill(Progress::NotYet);
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
    let (sided, frictions) = (builder.sided, builder.frictions);
    for (i, contact) in file.contacts.iter().enumerate() {
        if contact.friction.is_some() && matches!(frictions[i], Progress::NotYet) {
            let message = format!(
                "the friction of contact `{}` is not used in [field]",
                contact.name
            );
            return Err(Problem::new(message, contact.place.clone())
                .help(format!("write friction({}) where it acts", contact.name)));
        }
        if sided & 1 << i == 0 {
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
    built(file, &values).map(drop)
}

/// The values of the parameters as the file has them.
pub(crate) fn values(file: &SystemFile) -> Vec<f64> {
    file.parameters
        .iter()
        .map(|parameter| parameter.value)
        .collect()
}

/// The tapes with these values of the parameters.
///
/// # Errors
/// [`Problem`] where a constant part of an expression is no number with them, or an expression is too large.
pub(crate) fn built(file: &SystemFile, values: &[f64]) -> Result<Built, Problem> {
    let mut graph = Graph::new();
    let contacts = file.contacts.len();
    let combinations = 1 << contacts;
    let mut depends_on_time = false;

    let mut fields_of = |graph: &mut Graph, held: usize| -> Result<Vec<Tape>, Problem> {
        let mut tapes = Vec::with_capacity(combinations);
        for above in 0..combinations {
            let scope = Scope::Sides { above, held };
            let rates = Builder::new(file, values, graph, scope).field()?;
            depends_on_time |= rates.iter().any(|&rate| graph.depends_on_time(rate));
            tapes.push(tape(file, graph, &rates)?);
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
        let height = Builder::new(file, values, &mut graph, scope).formula(&contact.boundary)?;
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
        let root = Builder::new(file, values, &mut graph, scope).formula(formula)?;
        tape(file, &graph, &[root])
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
    Ok(Built {
        fields: Fields { slip, holding },
        boundaries: tape(file, &graph, &heights)?,
        normal_force,
        section,
        start: start(file, values)?,
        period: period(file, values)?,
        depends_on_time,
    })
}

fn tape(file: &SystemFile, graph: &Graph, roots: &[Id]) -> Result<Tape, Problem> {
    let too_large = |error: TooLarge| Problem::new(error.to_string(), 0..0);
    Tape::new(graph, roots, file.states.len()).map_err(too_large)
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
    let mut builder = Builder::new(file, values, &mut graph, Scope::Constant(what));
    let built = builder.formula(formula)?;
    Ok(graph.value(built).unwrap_or(f64::NAN))
}

/// How far a named part is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Progress {
    NotYet,
    UnderWay,
    Done(Id),
}

struct Builder<'a> {
    /// `None` where there are no names but the ones that every file has.
    file: Option<&'a SystemFile>,
    values: &'a [f64],
    graph: &'a mut Graph,
    scope: Scope,
    definitions: Vec<Progress>,
    frictions: Vec<Progress>,
    /// Bits of the contacts whose sides have been asked for.
    sided: usize,
}

type Made = Result<Id, Problem>;

impl<'a> Builder<'a> {
    fn new(file: &'a SystemFile, values: &'a [f64], graph: &'a mut Graph, scope: Scope) -> Self {
        Builder {
            file: Some(file),
            values,
            graph,
            scope,
            definitions: vec![Progress::NotYet; file.definitions.len()],
            frictions: vec![Progress::NotYet; file.contacts.len()],
            sided: 0,
        }
    }

    /// The rates of all states.
    fn field(&mut self) -> Result<Vec<Id>, Problem> {
        let rates = self.file.map_or(&[][..], |file| &file.field);
        let rates = rates.iter().map(|rate| match (rate, self.scope) {
            (Rate::Same(formula), _) => self.formula(formula),
            (Rate::BySide { above, .. }, Scope::Sides { above: 1, .. }) => self.formula(above),
            (Rate::BySide { below, .. }, _) => self.formula(below),
        });
        rates.collect()
    }

    fn formula(&mut self, formula: &Formula) -> Made {
        self.expression(formula, &formula.tree)
    }

    fn expression(&mut self, formula: &Formula, expression: &Expression) -> Made {
        let place = formula.at(&expression.span);
        let made = match &expression.kind {
            Kind::Number(value) => self.graph.constant(*value),
            Kind::Name(name) => return self.name(name, place),
            Kind::Negative(inner) => {
                let inner = self.expression(formula, inner)?;
                self.graph.negative(inner)
            }
            Kind::Binary(operator, a, b) => {
                let (a, b) = (self.expression(formula, a)?, self.expression(formula, b)?);
                self.graph.binary(*operator, a, b)
            }
            Kind::Call {
                function,
                place: name,
                arguments,
            } => {
                let name = formula.at(name);
                return self.call(formula, function, name, arguments, place);
            }
        };
        made.map_err(|error| no_number(error, place))
    }

    fn name(&mut self, name: &str, place: Range<usize>) -> Made {
        let Some(meaning) = self.meaning(name) else {
            return Err(self.unknown(name, place));
        };
        match (meaning, self.scope) {
            (Meaning::Pi, _) => {
                let made = self.graph.constant(std::f64::consts::PI);
                made.map_err(|error| no_number(error, place))
            }
            (Meaning::Parameter(number), _) => {
                let made = self.graph.constant(self.values[number]);
                made.map_err(|error| no_number(error, place))
            }
            (Meaning::Time | Meaning::State(_), Scope::Constant(what)) => {
                let message = format!(
                    "{what} cannot depend on `{name}`, which is {}",
                    meaning.told()
                );
                Err(Problem::new(message, place)
                    .help("it is a number, or an expression of numbers and parameters"))
            }
            (Meaning::Time, _) => Ok(self.graph.time()),
            (Meaning::State(number), _) => Ok(self.graph.state(number)),
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

    fn meaning(&self, name: &str) -> Option<Meaning> {
        match self.file {
            Some(file) => file.names.get(name),
            None if name == "pi" || name == "π" => Some(Meaning::Pi),
            None => None,
        }
    }

    fn unknown(&self, name: &str, place: Range<usize>) -> Problem {
        let problem = Problem::new(format!("unknown name `{name}`"), place).label("not known here");
        if is_function(name) {
            return problem.help(format!("`{name}` is a function: write {name}(…)"));
        }
        let Some(file) = self.file else {
            return problem.help(
                "the value of a parameter has numbers only; what depends on other parameters goes into [definitions]",
            );
        };
        problem.help(file.names.like(name).unwrap_or_else(|| {
            "names are states, parameters, definitions, contacts, t (time) and pi".to_owned()
        }))
    }

    /// Whether a contact is above.
    fn side(&mut self, number: usize, place: Range<usize>) -> Result<bool, Problem> {
        match self.scope {
            Scope::Sides { above, .. } => {
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

    fn definition(&mut self, number: usize) -> Made {
        let Some(file) = self.file else {
            return Err(Problem::new("there are no definitions here", 0..0));
        };
        let definition = &file.definitions[number];
        match self.definitions[number] {
            Progress::Done(id) => return Ok(id),
            Progress::UnderWay => {
                let message = format!("the definition of `{}` depends on itself", definition.name);
                return Err(Problem::new(message, definition.formula.whole()));
            }
            Progress::NotYet => {}
        }
        self.definitions[number] = Progress::UnderWay;
        let id = self.formula(&definition.formula)?;
        self.definitions[number] = Progress::Done(id);
        Ok(id)
    }

    fn call(
        &mut self,
        formula: &Formula,
        function: &str,
        name: Range<usize>,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> Made {
        match function {
            "friction" => return self.friction(formula, arguments, place),
            "by_side" => return self.by_side(formula, arguments, place),
            "min" | "max" => {
                let [first, rest @ ..] = arguments else {
                    return Err(wrong_count(function, "two or more arguments", 0, place));
                };
                if rest.is_empty() {
                    return Err(wrong_count(function, "two or more arguments", 1, place));
                }
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
        let argument = self.expression(formula, argument)?;
        self.graph
            .call(known, argument)
            .map_err(|error| no_number(error, place))
    }

    /// The friction force of a contact: its sign times the law that holds in this mode.
    fn friction(
        &mut self,
        formula: &Formula,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> Made {
        let number = self.contact(formula, "friction", arguments.first(), place.clone())?;
        if arguments.len() != 1 {
            return Err(wrong_count(
                "friction",
                "the name of a contact",
                arguments.len(),
                place,
            ));
        }
        let above = self.side(number, place.clone())?;
        let Some(contact) = self.file.and_then(|file| file.contacts.get(number)) else {
            return Err(Problem::new("there are no contacts here", place));
        };
        let Some(slip) = &contact.friction else {
            return Err(Problem::new(
                format!("contact `{}` has no friction law", contact.name),
                place,
            )
            .also(contact.place.clone(), "this contact")
            .help("write friction = \"…\" there: how large friction is in slip"));
        };
        let is_held = matches!(self.scope, Scope::Sides { held, .. } if held & 1 << number != 0);
        let law = contact.holding.as_ref().filter(|_| is_held).unwrap_or(slip);
        let size = match self.frictions[number] {
            Progress::Done(id) => id,
            Progress::UnderWay => {
                let message = format!(
                    "the friction of contact `{}` depends on itself",
                    contact.name
                );
                return Err(Problem::new(message, law.whole()));
            }
            Progress::NotYet => {
                self.frictions[number] = Progress::UnderWay;
                let id = self.formula(law)?;
                self.frictions[number] = Progress::Done(id);
                id
            }
        };
        let force = if above {
            Ok(size)
        } else {
            self.graph.negative(size)
        };
        force.map_err(|error| no_number(error, place))
    }

    fn by_side(
        &mut self,
        formula: &Formula,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> Made {
        let number = self.contact(formula, "by_side", arguments.first(), place.clone())?;
        let [_, below, above] = arguments else {
            let wanted = "a contact, the expression below and the one above";
            return Err(wrong_count("by_side", wanted, arguments.len(), place));
        };
        // Both are looked at, so that nothing wrong hides on the other side.
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
        let contacts = self.file.map_or(&[][..], |file| &file.contacts);
        let Some(argument) = argument else {
            return Err(wrong_count(function, "the name of a contact", 0, place));
        };
        let place = formula.at(&argument.span);
        let Kind::Name(name) = &argument.kind else {
            return Err(Problem::new(
                format!("{function} takes the name of a contact here"),
                place,
            ));
        };
        if let Some(Meaning::Contact(number)) = self.meaning(name) {
            return Ok(number);
        }
        let names: Vec<&str> = contacts
            .iter()
            .map(|contact| contact.name.as_str())
            .collect();
        let help = did_you_mean(name, names.iter().copied())
            .unwrap_or_else(|| format!("the contacts are {}", super::table::listed(&names)));
        Err(Problem::new(format!("`{name}` is no contact"), place).help(help))
    }

    fn no_function(&self, function: &str, place: Range<usize>) -> Problem {
        let problem =
            Problem::new(format!("unknown function `{function}`"), place).label("not known");
        if let Some(meaning) = self.meaning(function) {
            return Problem {
                message: format!("`{function}` is {}, not a function", meaning.told()),
                ..problem
            }
            .help(format!("a product needs its sign: {function}*(…)"));
        }
        let all = FUNCTIONS
            .iter()
            .map(|(name, _)| *name)
            .chain(FURTHER_FUNCTIONS);
        problem.help(match function {
            "sgn" | "sign" | "signum" => {
                "friction is written by side: the name of a contact is the sign of its side"
                    .to_owned()
            }
            "log" => "the natural logarithm is ln; the decimal one is ln(…)/ln(10)".to_owned(),
            "pow" => "a power is written x^2".to_owned(),
            _ => did_you_mean(function, all.clone()).unwrap_or_else(|| {
                let all: Vec<&str> = all.collect();
                format!("there are {}", all.join(", "))
            }),
        })
    }
}

fn wrong_count(function: &str, wanted: &str, found: usize, place: Range<usize>) -> Problem {
    let found = match found {
        0 => "none".to_owned(),
        some => some.to_string(),
    };
    Problem::new(format!("{function} takes {wanted}, not {found}"), place)
}

fn no_number(error: NotANumber, place: Range<usize>) -> Problem {
    let what = if error.value.is_nan() {
        "not a number"
    } else {
        "infinite"
    };
    Problem::new(format!("this is {what}"), place)
        .label("with the parameters' values")
        .help("change the expression, or a parameter in it")
}
