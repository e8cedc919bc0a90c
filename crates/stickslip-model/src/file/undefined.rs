//! Search for the part of a formula that is not a number at a state.

use stickslip::Scalar;
use stickslip::error::readable;

use super::builder::{Builder, Inputs, Operand, Scope, of_operand};
use super::formula::{not_finite, where_operands};
use super::{Contact, Formula, Meaning, StopEntry, System};
use crate::expression::{Expression, ExpressionKind, Graph, Tape};
use crate::kernel::{Combination, sides_to_check};

/// Distance ahead of a state at which an undefined part is looked for, relative to the size of the
/// state. Chosen: a run stops at a billionth of the range of a curve behind its end.
const AHEAD: f64 = 1e-6;

/// Largest normal force that vanishes beside a friction, as a part of that. Chosen: friction that
/// is proportional to the normal force is less than a millionth of it nowhere.
const NO_FORCE: f64 = 1e-6;

impl System {
    /// The contact, one of several, whose normal force vanishes at a state without its friction: a
    /// stick that it ends there has no continuation.
    pub(super) fn friction_without_force(&self, t: f64, x: &[f64]) -> Option<String> {
        if self.contacts() < 2 || x.len() != self.states() {
            return None;
        }
        let at = Evaluation::new(self, 0, t, x);
        let value = |formula: &Formula| at.value(formula, &formula.tree);
        let found = self.file.contacts.iter().find(|contact| {
            let forces = contact.normal_force.as_ref().zip(contact.friction.as_ref());
            forces.is_some_and(|(force, law)| {
                let (force, law) = (value(force), value(law));
                force
                    .zip(law)
                    .is_some_and(|(force, law)| force.abs() <= NO_FORCE * law.abs())
            })
        });
        found.map(|contact| {
            format!(
                "the normal force of contact `{}` vanishes there, and its friction does not",
                contact.name
            )
        })
    }

    /// Finds the part of [`System::undefined_in_field`], a little ahead of a state along the
    /// motion.
    pub(super) fn undefined_ahead(&self, t: f64, x: &[f64]) -> Option<String> {
        if x.len() != self.states() {
            return None;
        }
        let contacts = 0..self.contacts();
        let above = contacts.fold(0, |above, contact| {
            above | usize::from(self.boundary(contact, t, x) > 0.0) << contact
        });
        let rates = self.field(Combination { above, held: 0 }, t, x);
        let largest = |values: &[f64]| values.iter().fold(0.0, |far, x| Scalar::max(far, x.abs()));
        let time = AHEAD * (1.0 + largest(x)) / largest(&rates);
        let ahead: Vec<f64> = x
            .iter()
            .zip(&rates)
            .map(|(x, rate)| x + time * rate)
            .collect();
        self.undefined_in_field(t + time, &ahead)
    }

    /// The part of a boundary or of the field that is not a finite number at a time and state,
    /// although its operands are, in words. The sides are those of the state; then others are
    /// tried. `None` if all parts are finite.
    pub(super) fn undefined_in_field(&self, t: f64, x: &[f64]) -> Option<String> {
        if x.len() != self.states() {
            return None;
        }
        let file = &self.file;
        let contacts = 0..self.contacts();
        let of_state = contacts.fold(0, |above, contact| {
            above | usize::from(self.boundary(contact, t, x) > 0.0) << contact
        });
        let at = |above: usize| Evaluation::new(self, above, t, x);
        let boundaries = file.contacts.iter();
        let boundaries =
            boundaries.map(|contact| (of_contact("boundary", contact), &contact.boundary));
        let in_boundaries = at(of_state).first(boundaries);
        in_boundaries
            .or_else(|| {
                let sides = sides_to_check(self.contacts()).into_iter();
                std::iter::once(of_state).chain(sides).find_map(|above| {
                    let rates = file.states.iter().zip(&file.field).map(|(state, rate)| {
                        let key = format!("`{}` of [field]", state.name);
                        (key, rate.on_side(above == 1))
                    });
                    at(above).first(rates)
                })
            })
            .or_else(|| at(of_state).first(file.stops.iter().map(gap_of)))
    }

    /// Reason, in words, why no impulses follow the law of impact at a stop, or at one that touches
    /// with it. The state has what inputs hold.
    fn without_impulse(&self, stop: usize, t: f64, x: &[f64]) -> Option<String> {
        let law = self.built.switching.impacts.as_ref()?;
        let faulty = law.touching(stop, t, x).into_iter().find_map(|touching| {
            let name = &self.file.stops[touching.stop].name;
            let opens = touching.coupling[touching.stop];
            let of_acts = || {
                format!(
                    "a unit of `acts` of [stops.{name}] changes the rate of the gap by {} there \
                     and must open it",
                    readable(opens)
                )
            };
            let of_restitution = || {
                format!(
                    "`restitution` of [stops.{name}] is not between 0 and 1 there but {}",
                    readable(touching.restitution)
                )
            };
            match touching.has_restitution() {
                _ if opens <= 0.0 => Some(of_acts()),
                false => Some(of_restitution()),
                true => None,
            }
        });
        faulty.or_else(|| Some("no impulses follow the law of impact there".to_owned()))
    }

    /// The part of a jump or a switch that is not a finite number at a time and state. The number
    /// counts contacts, jumps and inputs, in this order.
    pub(super) fn undefined_in_event(&self, number: usize, t: f64, x: &[f64]) -> Option<String> {
        let number = number.checked_sub(self.contacts())?;
        let file = &self.file;
        if x.len() != self.states() {
            return None;
        }
        let evaluation = Evaluation::new(self, 0, t, x);
        let Some(jump) = file.jumps.get(number) else {
            let input = file.inputs.get(number - file.jumps.len())?;
            let super::InputShape::Switch(function) = &input.shape else {
                return None;
            };
            let key = format!("`function` of [switches.{}]", input.name);
            return evaluation.first([(key, function)].into_iter());
        };
        if let Some((stop, _)) = jump.of_stop {
            let undefined = evaluation.first(std::iter::once(gap_of(&file.stops[stop])));
            return undefined.or_else(|| self.without_impulse(stop, t, &evaluation.x));
        }
        let key = |key: &str| format!("`{key}` of [jumps.{}]", jump.name);
        let set = jump
            .set
            .iter()
            .flatten()
            .map(|formula| (key("set"), formula));
        let mut conditions: Vec<FormulaPart<'_>> = Vec::new();
        if let Some(formula) = &jump.condition {
            let numbers = operands(&formula.tree).into_iter();
            conditions.extend(numbers.map(|number| (key("if"), formula, number)));
        }
        let when = evaluation.first(std::iter::once((key("when"), &jump.when)));
        when.or_else(|| evaluation.first_part(conditions.into_iter()))
            .or_else(|| evaluation.first(set))
    }
}

/// The gap of a stop with its key.
fn gap_of(stop: &StopEntry) -> (String, &Formula) {
    (format!("`gap` of [stops.{}]", stop.name), &stop.gap)
}

/// The key of a formula of a contact.
fn of_contact(key: &str, contact: &Contact) -> String {
    format!("`{key}` of [contacts.{}]", contact.name)
}

/// Values of expressions at a time and state, on given sides of the contacts.
struct Evaluation<'a> {
    system: &'a System,
    above: usize,
    t: f64,
    /// The states, followed by the numbers that inputs hold.
    x: Vec<f64>,
}

impl<'a> Evaluation<'a> {
    fn new(system: &'a System, above: usize, t: f64, x: &[f64]) -> Self {
        let x = system.built.switching.extended(t, x);
        Evaluation {
            system,
            above,
            t,
            x,
        }
    }

    /// The value of an expression; `None` if it cannot be built.
    fn value(&self, formula: &Formula, expression: &Expression) -> Option<f64> {
        let (mut graph, file) = (Graph::new(), &self.system.file);
        let inputs = Inputs::fixed(&self.system.values);
        let scope = Scope::Sides(Combination {
            above: self.above,
            held: 0,
        });
        let builder = Builder::new(file, inputs, &mut graph, scope);
        let root = builder.choosing().expression(formula, expression).ok()?;
        let tape = Tape::new(&graph, &[root], self.x.len()).ok()?;
        let mut value = [0.0];
        tape.evaluate(self.t, &self.x, &mut value);
        Some(value[0])
    }

    /// The undefined part, with defined operands, of the first of some formulas that is undefined.
    /// The formulas have their keys.
    fn first(&self, formulas: impl Iterator<Item = (String, &'a Formula)>) -> Option<String> {
        self.first_part(formulas.map(|(key, formula)| (key, formula, &formula.tree)))
    }

    /// Finds the part of [`Evaluation::first`] among some parts of formulas.
    fn first_part(&self, wholes: impl Iterator<Item = FormulaPart<'a>>) -> Option<String> {
        let (mut part, mut value) = self.undefined(wholes)?;
        while let Some(inner) = self.undefined(self.inside(&part).into_iter()) {
            (part, value) = inner;
        }
        let (key, formula, whole) = part;
        let with_value = |one| Some((of_operand(one), self.value(formula, one)?));
        let operands = operands(whole).into_iter().map(with_value);
        let mut operands: Vec<(Operand, f64)> = operands.collect::<Option<_>>().unwrap_or_default();
        let mut span = whole.span.clone();
        if let ExpressionKind::Chain(_, rest) = &whole.kind {
            // The shortest leading part that is undefined, and its two operands.
            let mut all = operands.into_iter();
            operands = all.next().into_iter().collect();
            for ((operator, _), right) in rest.iter().zip(all) {
                let left = operands.swap_remove(0);
                value = operator.of(left.1, right.1);
                span = left.0.1.start..right.0.1.end;
                operands = vec![((false, span.clone()), value)];
                if !value.is_finite() {
                    operands = vec![left, right];
                    break;
                }
            }
        }
        let operands = operands.into_iter().filter(|((is_plain, _), _)| !is_plain);
        let operands = operands.map(|((_, span), value)| (formula.part(&span), value));
        let operands = where_operands(&operands.collect::<Vec<_>>());
        let (part, what) = (formula.part(&span), not_finite(value));
        Some(format!("in {key}, `{part}` is {what}{operands}"))
    }

    /// The first of some parts that is undefined, and its value.
    fn undefined(
        &self,
        mut parts: impl Iterator<Item = FormulaPart<'a>>,
    ) -> Option<(FormulaPart<'a>, f64)> {
        parts.find_map(|part| {
            let value = self.value(part.1, part.2)?;
            (!value.is_finite()).then_some((part, value))
        })
    }

    /// Components of a part: a definition, the laws of a contact, or operands.
    fn inside(&self, (key, formula, whole): &FormulaPart<'a>) -> Vec<FormulaPart<'a>> {
        let file = &*self.system.file;
        let meaning = |name: &String| file.names.get(name);
        let named = |(key, formula): (String, &'a Formula)| (key, formula, &formula.tree);
        match &whole.kind {
            ExpressionKind::Name(name) => match meaning(name) {
                Some(Meaning::Definition(number)) => {
                    let key = format!("`{name}` of [definitions]");
                    vec![named((key, &file.definitions[number].formula))]
                }
                _ => Vec::new(),
            },
            ExpressionKind::Call {
                function,
                arguments,
                ..
            } if function == "friction" => {
                let contact = arguments.first().and_then(|contact| match &contact.kind {
                    ExpressionKind::Name(name) => meaning(name),
                    _ => None,
                });
                let Some(Meaning::Contact(number)) = contact else {
                    return Vec::new();
                };
                let contact = &file.contacts[number];
                let laws = [
                    ("friction", &contact.friction),
                    ("normal_force", &contact.normal_force),
                ];
                let laws = laws.into_iter();
                let laws = laws.filter_map(|(key, law)| {
                    let law = law.as_ref()?;
                    Some(named((of_contact(key, contact), law)))
                });
                laws.collect()
            }
            _ => {
                let operands = operands(whole).into_iter();
                operands.map(|one| (key.clone(), *formula, one)).collect()
            }
        }
    }
}

/// A part of a formula: the formula's key, the formula and the part.
type FormulaPart<'a> = (String, &'a Formula, &'a Expression);

/// The operands of an expression. The contact of a friction is none.
fn operands(whole: &Expression) -> Vec<&Expression> {
    match &whole.kind {
        ExpressionKind::Number(_) | ExpressionKind::Name(_) => Vec::new(),
        ExpressionKind::Negative(inner) => vec![&**inner],
        ExpressionKind::Chain(first, rest) => {
            let rest = rest.iter().map(|(_, operand)| operand);
            std::iter::once(&**first).chain(rest).collect()
        }
        ExpressionKind::Condition(condition) => condition.numbers(),
        ExpressionKind::Call { function, .. } if function == "friction" => Vec::new(),
        ExpressionKind::Call { arguments, .. } => {
            let arguments = arguments.iter();
            let numbers = arguments.flat_map(|argument| match &argument.kind {
                ExpressionKind::Condition(_) => operands(argument),
                _ => vec![argument],
            });
            numbers.collect()
        }
    }
}
