//! Friction forces of contacts.

use std::ops::Range;

use stickslip::error::readable;

use super::super::Formula;
use super::calls::wrong_count;
use super::{BuildResult, Builder, PartState, Problem, Scope, no_number};
use crate::expression::{Expression, GraphInput, Id, Test};

impl Builder<'_> {
    /// The friction force of a contact: its sign times the law that holds in this mode, and zero if
    /// the normal force is not positive.
    pub(super) fn friction(
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
    pub fn friction_force(&mut self, number: usize) -> BuildResult {
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

    /// The friction force of a contact in this combination of sides, and the rate of its boundary
    /// with the field there.
    pub fn force_and_rate(&mut self, number: usize) -> Result<[Id; 2], Problem> {
        let force = self.friction_force(number)?;
        let field = self.field()?;
        let contact = &self.file.contacts[number];
        let scope = std::mem::replace(&mut self.scope, Scope::NoSides("a boundary"));
        let boundary = self.formula(&contact.boundary);
        self.scope = scope;
        let (boundary, wrong) = (boundary?, contact.boundary.whole());
        let rate = self.graph.constant(1.0).and_then(|one| {
            let rate = self.graph.along(boundary, |of| match of {
                GraphInput::Time => Some(one),
                GraphInput::State(state) => field.get(state).copied(),
            })?;
            rate.map_or_else(|| self.graph.constant(0.0), Ok)
        });
        Ok([force, rate.map_err(|error| no_number(error, wrong))?])
    }

    /// The size of the friction of a contact in this mode: its law, or zero if it has none or the
    /// normal force is not positive.
    pub fn size(&mut self, number: usize) -> BuildResult {
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
}
