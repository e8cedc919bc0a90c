//! The rates of all states, with the reactions of the stops.

use std::ops::Range;

use super::{BuildResult, Builder, Problem, Scope, are_same, no_number};
use crate::expression::{Binary, Id};
use crate::kernel::Combination;

impl Builder<'_> {
    /// The rates with these reactions of the stops.
    pub fn field_with(&mut self, forces: &[Id]) -> Result<Vec<Id>, Problem> {
        self.forget();
        self.forces = Some(forces.to_vec());
        self.field()
    }

    /// The rates of all states, and of the parameters that are states.
    pub fn field(&mut self) -> Result<Vec<Id>, Problem> {
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
            built.push(self.directed(rate, formula.whole())?);
        }
        for _ in 0..self.inputs.count_free() {
            let none = self.graph.constant(0.0);
            built.push(none.map_err(|error| no_number(error, 0..0))?);
        }
        Ok(built)
    }

    /// The reactions of all stops, in this combination of sides.
    pub(super) fn all_forces(&mut self, place: Range<usize>) -> Result<Vec<Id>, Problem> {
        if let Some(forces) = &self.forces {
            return Ok(forces.clone());
        }
        let forces = match self.scope {
            Scope::Sides(of) => {
                super::super::stops::reactions(self.file, self.inputs, self.graph, of)?
            }
            // Both ends of a gap have the same reaction on every side, or it has no one value.
            Scope::NoSides(_) | Scope::Constant(_) => {
                let all = (1 << self.file.contacts.len()) - 1;
                let mut on = |above| {
                    let of = Combination { above, held: 0 };
                    super::super::stops::reactions(self.file, self.inputs, self.graph, of)
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
    pub(super) fn directed(&mut self, id: Id, place: Range<usize>) -> BuildResult {
        if !self.file.is_reversed {
            return Ok(id);
        }
        let negative = self.graph.negative(id);
        negative.map_err(|error| no_number(error, place))
    }
}
