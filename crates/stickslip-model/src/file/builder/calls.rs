//! Calls of functions and curves.

use std::ops::Range;

use super::super::names::{FURTHER_FUNCTIONS, LATER_FUNCTIONS, Meaning, did_you_mean};
use super::super::{Formula, Rate, SystemFile, table};
use super::{BuildNumber, BuildResult, Builder, Operand, Problem, Scope, no_number, of_operand};
use crate::expression::{
    Binary, CHOICE, Expression, ExpressionKind, FUNCTIONS, Function, Graph, Id,
};

impl Builder<'_> {
    pub(super) fn call(
        &mut self,
        formula: &Formula,
        function: &str,
        name: Range<usize>,
        arguments: &[Expression],
        place: Range<usize>,
    ) -> BuildResult {
        if let Some(Meaning::Curve(number)) = self.file.names.get(function) {
            let entry = &self.file.curves[number];
            let wanted = (&*entry.name, "one argument", 1);
            return self.applied(formula, wanted, arguments, place, |graph, of| {
                graph.curve(&entry.curve, of[0])
            });
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
            CHOICE => return self.choice(formula, arguments, (name, place)),
            "abs" => {
                if let [argument] = arguments
                    && let Some(distance) = self.distance(formula, argument)?
                {
                    return Ok(distance);
                }
            }
            _ => {}
        }
        let (wanted, count) = match function {
            "hypot" => ("two arguments", 2),
            "atan2" => ("two arguments, y and x", 2),
            "clamp" => ("a number, its lowest and its highest value", 3),
            _ if Function::named(function).is_some() => ("one argument", 1),
            _ if LATER_FUNCTIONS.contains(&function) => ("one argument", 1),
            _ => return Err(self.no_function(function, name)),
        };
        let wanted = (function, wanted, count);
        self.applied(formula, wanted, arguments, place, |graph, of| {
            function_of(graph, function, of)
        })
    }

    /// A function of a fixed number of arguments, by what it adds to the graph. `wanted` is its
    /// name, and the arguments in words and in number.
    fn applied(
        &mut self,
        formula: &Formula,
        (function, wanted, count): (&str, &str, usize),
        arguments: &[Expression],
        place: Range<usize>,
        add: impl FnOnce(&mut Graph, &[Id]) -> BuildNumber,
    ) -> BuildResult {
        if arguments.len() != count {
            return Err(wrong_count(function, wanted, arguments.len(), place));
        }
        let mut ids = Vec::with_capacity(count);
        for argument in arguments {
            ids.push(self.expression(formula, argument)?);
        }
        let made = add(self.graph, &ids);
        let operands = arguments.iter().map(of_operand).zip(ids);
        let operands: Vec<(Operand, Id)> = operands.collect();
        made.map_err(|error| self.not_finite(error, formula, place, &operands))
    }

    /// The absolute value of a boundary function, which is smooth on each side: the side times the
    /// function. `None` for what is none, and where there are no sides.
    fn distance(
        &mut self,
        formula: &Formula,
        argument: &Expression,
    ) -> Result<Option<Id>, Problem> {
        if !matches!(self.scope, Scope::Sides(_)) {
            return Ok(None);
        }
        let place = formula.at(&argument.span);
        let of = self.expression(formula, argument)?;
        let wrong = |error| no_number(error, place.clone());
        let turned = self.graph.opposite(of).map_err(wrong)?;
        if self.boundaries.is_empty() {
            let contacts = self.file.contacts.iter();
            let (file, inputs, graph) = (self.file, self.inputs, &mut *self.graph);
            let goes_on = goes_on_beyond(file);
            // A wrong boundary is reported where it stands.
            let built = contacts.map(|contact| {
                let scope = Scope::NoSides("a boundary");
                let mut builder = Builder::new(file, inputs, &mut *graph, scope);
                goes_on.then(|| builder.formula(&contact.boundary).ok())?
            });
            self.boundaries = built.collect();
        }
        let same = |of: Id| self.boundaries.iter().position(|one| *one == Some(of));
        let Some((number, above)) = (same(of).map(|number| (number, of)))
            .or_else(|| same(turned).map(|number| (number, turned)))
        else {
            return Ok(None);
        };
        Ok(Some(match self.side(number, place.clone())? {
            true => above,
            false => self.graph.negative(above).map_err(wrong)?,
        }))
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
    pub(super) fn contact(
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
            .unwrap_or_else(|| format!("the contacts are {}", table::listed(&names)));
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

/// Whether a field that goes on smoothly beyond a boundary, where a distance is negative, has a
/// value there: no root, logarithm or real power is in it, and no comparison. A contact that can be
/// lost has one.
fn goes_on_beyond(file: &SystemFile) -> bool {
    const ENTIRE: [&str; 11] = [
        "abs", "sin", "cos", "exp", "tanh", "sinh", "cosh", "atan", "erf", "friction", "by_side",
    ];
    fn is_whole(of: &Expression) -> bool {
        match &of.kind {
            ExpressionKind::Number(value) => value.fract() == 0.0,
            ExpressionKind::Negative(inner) => is_whole(inner),
            _ => false,
        }
    }
    fn goes_on(of: &Expression) -> bool {
        match &of.kind {
            ExpressionKind::Number(_) | ExpressionKind::Name(_) => true,
            ExpressionKind::Negative(inner) => goes_on(inner),
            ExpressionKind::Chain(first, rest) => {
                let mut rest = rest.iter();
                let power = |operator: &Binary| *operator == Binary::Power;
                goes_on(first) && rest.all(|(by, of)| goes_on(of) && (!power(by) || is_whole(of)))
            }
            ExpressionKind::Condition(_) => false,
            ExpressionKind::Call {
                function,
                arguments,
                ..
            } => ENTIRE.contains(&&**function) && arguments.iter().all(goes_on),
        }
    }
    let definitions = file.definitions.iter().map(|one| &one.formula);
    let field = file.field.iter().flat_map(|rate| match rate {
        Rate::Same(formula) => vec![formula],
        Rate::BySide { below, above } => vec![below, above],
    });
    let laws = file.contacts.iter();
    let laws = laws.flat_map(|one| [&one.friction, &one.holding]).flatten();
    let mut all = definitions.chain(field).chain(laws);
    let is_lost = file.contacts.iter().any(|one| one.normal_force.is_some());
    !is_lost && all.all(|formula| goes_on(&formula.tree))
}

/// A function of numbers of a graph, composed of others where the graph does not have it.
fn function_of(graph: &mut Graph, function: &str, of: &[Id]) -> BuildNumber {
    match (function, of) {
        ("asin" | "acos", &[x]) => {
            let one = graph.constant(1.0)?;
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
        (_, of) => match (Function::named(function), of) {
            (Some(known), &[x]) => graph.call(known, x),
            _ => graph.constant(f64::NAN),
        },
    }
}

pub(super) fn wrong_count(
    function: &str,
    wanted: &str,
    found: usize,
    place: Range<usize>,
) -> Problem {
    let found = match found {
        0 => "none".to_owned(),
        some => some.to_string(),
    };
    Problem::new(format!("{function} takes {wanted}, not {found}"), place)
}
