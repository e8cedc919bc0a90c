//! Which part of a formula is not a number at a state.

use super::builder::{Builder, Inputs, Scope};
use super::formula::{not_finite, where_operands};
use super::{Contact, Formula, Meaning, System};
use crate::expression::{Expression, ExpressionKind, Graph, Tape};
use crate::kernel::{Combination, sides_to_check};

impl System {
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
        in_boundaries.or_else(|| {
            let sides = sides_to_check(self.contacts()).into_iter();
            std::iter::once(of_state).chain(sides).find_map(|above| {
                let rates = file.states.iter().zip(&file.field).map(|(state, rate)| {
                    let key = format!("`{}` of [field]", state.name);
                    (key, rate.on_side(above == 1))
                });
                at(above).first(rates)
            })
        })
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
        let key = |key: &str| format!("`{key}` of [jumps.{}]", jump.name);
        let set = jump
            .set
            .iter()
            .flatten()
            .map(|formula| (key("set"), formula));
        evaluation.first(std::iter::once((key("when"), &jump.when)).chain(set))
    }
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

    /// The first undefined part of some formulas with their keys.
    fn first<'f>(
        &self,
        mut formulas: impl Iterator<Item = (String, &'f Formula)>,
    ) -> Option<String> {
        formulas.find_map(|(key, formula)| self.part(&key, formula, &formula.tree))
    }

    /// The value of an expression; `None` if it cannot be built.
    fn value(&self, formula: &Formula, expression: &Expression) -> Option<f64> {
        let (mut graph, file) = (Graph::new(), &self.system.file);
        let inputs = Inputs::fixed(&self.system.values);
        let scope = Scope::Sides(Combination {
            above: self.above,
            held: 0,
        });
        let mut builder = Builder::new(file, inputs, &mut graph, scope);
        let root = builder.expression(formula, expression).ok()?;
        let tape = Tape::new(&graph, &[root], self.x.len()).ok()?;
        let mut value = [0.0];
        tape.evaluate(self.t, &self.x, &mut value);
        Some(value[0])
    }

    /// The undefined part of an expression whose operands are defined.
    fn part(&self, key: &str, formula: &Formula, whole: &Expression) -> Option<String> {
        let value = self
            .value(formula, whole)
            .filter(|value| !value.is_finite())?;
        let named = match &whole.kind {
            ExpressionKind::Name(name) => self.in_definition(name),
            ExpressionKind::Call {
                function,
                arguments,
                ..
            } if function == "friction" => {
                let contact = arguments.first();
                contact.and_then(|contact| self.in_friction(contact))
            }
            _ => None,
        };
        if named.is_some() {
            return named;
        }
        let operands: Vec<&Expression> = match &whole.kind {
            ExpressionKind::Number(_) | ExpressionKind::Name(_) => Vec::new(),
            ExpressionKind::Negative(inner) => vec![&**inner],
            ExpressionKind::Binary(_, a, b) => vec![&**a, &**b],
            ExpressionKind::Call { function, .. } if function == "friction" => Vec::new(),
            ExpressionKind::Call { arguments, .. } => arguments.iter().collect(),
        };
        let in_operand = operands.iter().find_map(|one| self.part(key, formula, one));
        in_operand.or_else(|| {
            let is_plain = |one: &&Expression| matches!(one.kind, ExpressionKind::Number(_));
            let operands = operands.into_iter().filter(|one| !is_plain(one));
            let operands = operands.filter_map(|one| {
                let value = self.value(formula, one)?;
                Some((formula.part(&one.span), value))
            });
            let operands = where_operands(&operands.collect::<Vec<_>>());
            let (part, what) = (formula.part(&whole.span), not_finite(value));
            Some(format!("in {key}, `{part}` is {what}{operands}"))
        })
    }

    fn in_definition(&self, name: &str) -> Option<String> {
        let file = &self.system.file;
        let Some(Meaning::Definition(number)) = file.names.get(name) else {
            return None;
        };
        let formula = &file.definitions[number].formula;
        self.part(
            &format!("`{name}` of [definitions]"),
            formula,
            &formula.tree,
        )
    }

    fn in_friction(&self, contact: &Expression) -> Option<String> {
        let ExpressionKind::Name(name) = &contact.kind else {
            return None;
        };
        let file = &self.system.file;
        let Some(Meaning::Contact(number)) = file.names.get(name) else {
            return None;
        };
        let contact = &file.contacts[number];
        let laws = [
            ("friction", &contact.friction),
            ("normal_force", &contact.normal_force),
        ];
        let laws = laws.into_iter();
        self.first(laws.filter_map(|(key, law)| Some((of_contact(key, contact), law.as_ref()?))))
    }
}
