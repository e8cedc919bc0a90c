//! Reactions of stops and friction forces of contacts along an orbit, impulses, and formulas that
//! have them.

use stickslip::dynamics::Modes;
use stickslip::error::readable;
use stickslip::nalgebra::DVector;
use stickslip::scalar::Dual;
use stickslip::{Mode, Side};

use super::build::{TapeBuild, tape};
use super::builder::{Builder, Inputs, Scope};
use super::formulas::FormulaKey;
use super::problem::Problem;
use super::{FileError, Formula, Source, System, stops};
use crate::expression::{Graph, Id, Tape};
use crate::kernel::{Combination, HELD_PER_INPUT, sides_to_check};

/// A reaction that friction leaves less than this part of its effect on its gap has no finite
/// value. Chosen: a run that ends where the effect vanishes comes nearer than that.
const NO_EFFECT: f64 = 1e-6;

/// The friction force of a contact that sticks beside others is told where the field is a sum of
/// what each contributes, to this part of it. Chosen far above rounding, and far below an effect
/// that is meant.
const NOT_A_SUM: f64 = 1e-9;

/// The reactions of the stops of a system, the friction forces of its contacts, and formulas of
/// states, parameters, inputs, time and these forces, at any moment of an orbit.
///
/// The force of a contact is the value of `friction(NAME)` in the field. In slip that is its law,
/// with the sign of its side. In stick it is what keeps the rate of the boundary at zero.
pub struct Quantities<'a> {
    system: &'a System,
    /// Names of reactions and formulas: the reactions first.
    names: Vec<String>,
    /// The reactions in those combinations of sides that have occurred. Only one is needed where
    /// they do not depend on sides.
    reactions: Vec<(Combination, Option<Tape>)>,
    is_sided: bool,
    /// The friction of all contacts in those combinations of sides that have occurred.
    frictions: Vec<(Combination, Option<Tape>)>,
    /// Whether a formula may have the friction force of a contact.
    has_friction: bool,
    formulas: Vec<Tape>,
}

impl System {
    /// The reactions of all stops, and these formulas with their names.
    ///
    /// # Errors
    /// [`FileError::Wrong`] with the fault of a formula, or of a name that occurs already.
    pub fn quantities(&self, formulas: &[(&str, &str)]) -> Result<Quantities<'_>, FileError> {
        let file = &self.file;
        let stops = file.stops.iter().map(|stop| format!("{}.force", stop.name));
        let mut names: Vec<String> = stops.collect();
        let (mut tapes, mut has_friction) = (Vec::new(), false);
        for &(name, text) in formulas {
            let source = |text: &str| Source {
                name: format!("formula of {name}"),
                text: text.to_owned(),
            };
            let taken = names.iter().any(|known| known == name) || file.names.get(name).is_some();
            if taken || name.is_empty() {
                let message = match taken {
                    true => format!("the name `{name}` is taken already"),
                    false => "the formula has no name".to_owned(),
                };
                let problem = Problem::new(message, 0..name.len()).help("choose another name");
                return Err(FileError::wrong(problem, source(name)));
            }
            let formula = Formula::parsed(text, 0..text.len(), &source(text));
            let made = formula.and_then(|formula| self.with_forces(&formula));
            let made = made.map_err(|problem| FileError::wrong(problem, source(text)));
            tapes.push(made?);
            let mut contacts = file.contacts.iter();
            has_friction |= contacts.any(|one| text.contains(&format!("{}.force", one.name)));
            names.push(name.to_owned());
        }
        let all = (1 << file.contacts.len()) - 1;
        let [below, above] = [0, all].map(|above| self.reactions(Combination { above, held: 0 }));
        Ok(Quantities {
            system: self,
            names,
            is_sided: below != above,
            reactions: Vec::new(),
            frictions: Vec::new(),
            has_friction,
            formulas: tapes,
        })
    }

    /// The tape of a formula, with the reactions behind all states and the friction forces behind
    /// these.
    fn with_forces(&self, formula: &Formula) -> Result<Tape, Problem> {
        let build = || {
            let (file, mut graph) = (&self.file, Graph::new());
            let first = file.states.len() + HELD_PER_INPUT * file.inputs.len();
            let (stops, contacts) = (file.stops.len(), file.contacts.len());
            let mut forces: Vec<Id> = (0..stops + contacts)
                .map(|number| graph.state(first + number))
                .collect();
            let frictional = forces.split_off(stops);
            let inputs = Inputs::fixed(&self.values);
            let scope = Scope::NoSides("what is observed");
            let builder = Builder::new(file, inputs, &mut graph, scope);
            let builder = builder.with_forces(forces);
            let root = builder.with_friction_forces(frictional).formula(formula)?;
            let tape = Tape::new(&graph, &[root], first + stops + contacts);
            let tape = tape.map_err(|error| Problem::new(error.to_string(), 0..0))?;
            Ok(TapeBuild::new(graph, tape))
        };
        self.formula_tape(FormulaKey::WithForces(formula.text.clone()), build)
    }

    /// The tape of the friction of all contacts in a combination of sides; `None` if there is none.
    fn friction_forces(&self, of: Combination) -> Option<Tape> {
        let build = || {
            let (mut graph, inputs) = (Graph::new(), Inputs::fixed(&self.values));
            let mut builder = Builder::new(&self.file, inputs, &mut graph, Scope::Sides(of));
            let contacts = 0..self.contacts();
            let forces = contacts.map(|contact| builder.friction_force(contact));
            let forces = forces.collect::<Result<Vec<Id>, _>>()?;
            let tape = tape(&self.file, &graph, &forces, inputs)?;
            Ok(TapeBuild::new(graph, tape))
        };
        self.formula_tape(FormulaKey::FrictionForces(of), build)
            .ok()
    }

    /// The tape of the reactions in a combination of sides; `None` if there is none.
    fn reactions(&self, of: Combination) -> Option<Tape> {
        if self.file.stops.is_empty() {
            return None;
        }
        let build = || {
            let (mut graph, inputs) = (Graph::new(), Inputs::fixed(&self.values));
            let roots = stops::reactions(&self.file, inputs, &mut graph, of)?;
            let tape = tape(&self.file, &graph, &roots, inputs)?;
            Ok(TapeBuild::new(graph, tape))
        };
        self.formula_tape(FormulaKey::Reactions(of), build).ok()
    }

    /// Reason, in words, why stops that carry at a state have no finite reactions there, and the
    /// remedy. On some sides of the contacts, the friction that follows a reaction undoes its
    /// effect on the gap, or several stops hold the same motion. `None` if all reactions are
    /// finite.
    pub(super) fn without_reaction(&self, t: f64, x: &[f64]) -> Option<String> {
        let file = &self.file;
        if file.stops.is_empty() || x.len() != self.states() {
            return None;
        }
        let extended = self.built.switching.extended(t, x);
        let count = file.stops.len();
        let carrying: Vec<usize> = (0..count)
            .filter(|&stop| x[file.stops[stop].closed] > 0.5)
            .collect();
        sides_to_check(self.contacts()).into_iter().find_map(|above| {
            let (mut graph, inputs) = (Graph::new(), Inputs::fixed(&self.values));
            let of = Combination { above, held: 0 };
            let roots = stops::openings(file, inputs, &mut graph, of).ok()?;
            let tape = tape(file, &graph, &roots, inputs).ok()?;
            let mut values = vec![0.0; roots.len()];
            tape.evaluate(t, &extended, &mut values);
            let coupling = |row: usize, column: usize| values[count * (1 + row) + column];
            let mut all = carrying.iter();
            let own = |&&stop: &&usize| coupling(stop, stop) <= NO_EFFECT * values[stop];
            let Some(&stop) = all.find(own) else {
                return self.shared_motion(&carrying, coupling);
            };
            let (with, alone) = (coupling(stop, stop), values[stop]);
            let name = &file.stops[stop].name;
            if alone <= 0.0 {
                return Some(format!(
                    "a unit of `acts` of [stops.{name}] changes the second derivative of the gap \
                     by {} there and must open it; turn its sign, or end the run before",
                    readable(alone)
                ));
            }
            Some(format!(
                "no motion in contact is consistent there, or several are (Painlevé): a unit of \
                 the reaction of the stop `{name}` changes the second derivative of its gap by {}, \
                 and by {} with the friction that follows it; lower that friction, or end the run \
                 before",
                readable(alone),
                // Where it vanishes, rounding is left.
                readable(if with.abs() <= NO_EFFECT * alone { 0.0 } else { with }),
            ))
        })
    }

    /// The stops among these that hold the same motion, in words, with the remedy. The second
    /// derivatives of their gaps by their reactions depend on each other.
    fn shared_motion(
        &self,
        carrying: &[usize],
        coupling: impl Fn(usize, usize) -> f64,
    ) -> Option<String> {
        let dependent = (1..carrying.len()).find_map(|last| {
            let (before, last) = (&carrying[..last], carrying[last]);
            // What the reactions before it do for the gap of the last one.
            let row = |&row: &usize| {
                let columns = before.iter().map(|&column| coupling(column, row));
                columns.chain([coupling(last, row)]).collect()
            };
            let parts = solved(before.iter().map(row).collect())?;
            let shared = before.iter().zip(&parts);
            let held: f64 = shared.map(|(&row, part)| part * coupling(row, last)).sum();
            let own = coupling(last, last);
            let of = before.iter().zip(parts);
            let of = of.filter(|(_, part)| part.abs() > NO_EFFECT);
            let all = of.map(|(&stop, _)| stop).chain([last]).collect();
            (own - held <= NO_EFFECT * own).then_some(all)
        });
        let dependent: Vec<usize> = dependent?;
        let stops = dependent
            .into_iter()
            .map(|stop| &self.file.stops[stop].name);
        let names: Vec<String> = stops.map(|name| format!("`{name}`")).collect();
        Some(format!(
            "the reactions of the stops {} are not unique there: these stops hold the same motion, \
             so that no equation tells how they share the load, even where the accelerations are \
             unique; leave one of them out, or replace one by a stiff spring in [field]",
            names.join(", ")
        ))
    }

    /// Impulses of all stops at a transition of a contact or jump with this number, from the state
    /// before it. Zero where a stop takes no part, and at what is no impact.
    pub fn impulses(&self, number: usize, t: f64, x: &[f64]) -> Vec<f64> {
        let switching = &self.built.switching;
        match number.checked_sub(self.contacts()) {
            Some(jump) if jump < switching.jumps.len() => {
                switching.impulses(jump, t, &switching.extended(t, x))
            }
            _ => vec![0.0; self.file.stops.len()],
        }
    }

    /// The part of the side above in the motion of a contact that sticks, in Filippov's convex
    /// combination, with the other contacts as in `of`.
    fn part_above(&self, contact: usize, of: Combination, t: f64, x: &[f64]) -> f64 {
        let [below, above] = [0, 1 << contact].map(|side| {
            let of = Combination {
                above: of.above & !(1 << contact) | side,
                ..of
            };
            self.rate_of_boundary(contact, &self.field(of, t, x), t, x)
        });
        below / (below - above)
    }

    /// The rate of a boundary where the state moves with these rates.
    fn rate_of_boundary(&self, contact: usize, rates: &[f64], t: f64, x: &[f64]) -> f64 {
        let moved = x.iter().zip(rates).map(|(x, rate)| Dual::new(*x, *rate));
        let moved: Vec<Dual<f64>> = moved.collect();
        self.boundary(contact, Dual::new(t, 1.0), &moved).eps
    }

    /// The parts of the sides above in the motion of several contacts that stick, which lie below
    /// in `of`. `None` where the field of the mode is no sum of what each contributes.
    fn parts_above(
        &self,
        sticking: &[usize],
        of: Combination,
        t: f64,
        x: &[f64],
    ) -> Option<Vec<f64>> {
        let with = |above: usize| DVector::from(self.field(Combination { above, ..of }, t, x));
        let below = with(of.above);
        let each: Vec<DVector<f64>> = sticking
            .iter()
            .map(|contact| with(of.above | 1 << contact) - &below)
            .collect();
        let count = sticking.len();
        let rate = |contact: usize, rates: &DVector<f64>| {
            self.rate_of_boundary(contact, rates.as_slice(), t, x)
        };
        let rows = sticking.iter().map(|&contact| {
            let present = rate(contact, &below);
            let effects = each
                .iter()
                .map(|one| rate(contact, &(&below + one)) - present);
            effects.chain([-present]).collect()
        });
        let parts = solved(rows.collect())?;
        // Each pair acts as both together do.
        let mut pairs = (0..count).flat_map(|i| (0..i).map(move |j| (i, j)));
        let is_sum = pairs.all(|(i, j)| {
            let both = with(of.above | 1 << sticking[i] | 1 << sticking[j]);
            let sum = &below + &each[i] + &each[j];
            (&both - &sum).amax() <= NOT_A_SUM * both.amax().max(sum.amax())
        });
        is_sum.then_some(parts)
    }
}

/// The solution of linear equations, each a row with its right side last, by elimination with the
/// largest pivot of each column; `None` where there is none. Its bits do not depend on the machine.
fn solved(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let count = rows.len();
    for column in 0..count {
        let sizes = rows[column..].iter().map(|row| row[column].abs());
        let largest = sizes.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        rows.swap(column, column + largest.0);
        let pivot = rows[column].clone();
        for (number, row) in rows.iter_mut().enumerate() {
            let factor = row[column] / pivot[column];
            if number != column {
                row.iter_mut()
                    .zip(&pivot)
                    .for_each(|(one, other)| *one -= factor * other);
            }
        }
    }
    let diagonal = rows.iter().enumerate();
    let solution: Vec<f64> = diagonal.map(|(k, row)| row[count] / row[k]).collect();
    solution
        .iter()
        .all(|value| value.is_finite())
        .then_some(solution)
}

impl Quantities<'_> {
    /// The names: `NAME.force` for each stop, then those of the formulas.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The reactions and the values of the formulas at a moment in these modes. A reaction that
    /// depends on the sides of several contacts that stick is not a number.
    pub fn at(&mut self, modes: &Modes, t: f64, x: &[f64]) -> Vec<f64> {
        let mut values = self.reactions_at(modes, t, x);
        if !self.formulas.is_empty() {
            let mut inputs = self.system.built.switching.extended(t, x);
            inputs.extend(&values);
            inputs.extend(match self.has_friction {
                true => self.friction_at(modes, t, x),
                false => vec![f64::NAN; self.system.contacts()],
            });
            for formula in &self.formulas {
                let mut value = [0.0];
                formula.evaluate(t, &inputs, &mut value);
                values.push(value[0]);
            }
        }
        // A reaction that vanishes is 0, not -0.
        values.iter_mut().for_each(|value| *value += 0.0);
        values
    }

    /// The names of all forces: of the stops, then of the contacts with friction.
    pub fn force_names(&self) -> Vec<String> {
        let file = &self.system.file;
        let stops = file.stops.iter().map(|stop| stop.name.clone());
        let contacts = self
            .frictional()
            .map(|contact| file.contacts[contact].name.clone());
        stops.chain(contacts).collect()
    }

    /// The contacts with friction.
    fn frictional(&self) -> impl Iterator<Item = usize> {
        let contacts = self.system.file.contacts.iter().enumerate();
        contacts.filter_map(|(number, contact)| contact.friction.as_ref().map(|_| number))
    }

    /// The forces of [`Quantities::force_names`] at a moment in these modes. The friction force of
    /// a contact that sticks beside others is not a number where the field is no sum of what each
    /// contact contributes.
    pub fn forces_at(&mut self, modes: &Modes, t: f64, x: &[f64]) -> Vec<f64> {
        let mut forces = self.reactions_at(modes, t, x);
        if self.frictional().next().is_some() {
            let all = self.friction_at(modes, t, x);
            forces.extend(self.frictional().map(|contact| all[contact]));
        }
        forces.iter_mut().for_each(|force| *force += 0.0);
        forces
    }

    /// The friction forces of all contacts.
    fn friction_at(&mut self, modes: &Modes, t: f64, x: &[f64]) -> Vec<f64> {
        let contacts = self.system.contacts();
        let is_above = |contact: &usize| modes.get(*contact) == Mode::Slip(Side::Above);
        let sticking: Vec<usize> = (0..contacts)
            .filter(|contact| modes.get(*contact) == Mode::Stick)
            .collect();
        let bits = |all: &mut dyn Iterator<Item = usize>| all.fold(0, |bits, one| bits | 1 << one);
        let of = Combination {
            above: bits(&mut (0..contacts).filter(is_above)),
            held: bits(&mut sticking.iter().copied()),
        };
        let parts = match sticking[..] {
            [] => Some(Vec::new()),
            [contact] => Some(vec![self.system.part_above(contact, of, t, x)]),
            _ => self.system.parts_above(&sticking, of, t, x),
        };
        let Some(parts) = parts else {
            return vec![f64::NAN; contacts];
        };
        let below = self.friction_in(of, t, x);
        let mut forces = below.clone();
        for (contact, part) in sticking.iter().zip(parts) {
            let above = of.above | 1 << contact;
            let above = self.friction_in(Combination { above, ..of }, t, x);
            for ((force, below), above) in forces.iter_mut().zip(&below).zip(above) {
                *force += part * (above - below);
            }
        }
        forces
    }

    fn friction_in(&mut self, of: Combination, t: f64, x: &[f64]) -> Vec<f64> {
        let known = self.frictions.iter().position(|(known, _)| *known == of);
        let place = known.unwrap_or_else(|| {
            self.frictions.push((of, self.system.friction_forces(of)));
            self.frictions.len() - 1
        });
        let mut values = vec![f64::NAN; self.system.contacts()];
        if let Some(tape) = &self.frictions[place].1 {
            let x = self.system.built.switching.extended(t, x);
            tape.evaluate(t, &x, &mut values);
        }
        values
    }

    fn reactions_at(&mut self, modes: &Modes, t: f64, x: &[f64]) -> Vec<f64> {
        let none = Combination { above: 0, held: 0 };
        if !self.is_sided {
            return self.reactions_in(none, t, x);
        }
        let sticks = |contact: &usize| modes.get(*contact) == Mode::Stick;
        let contacts = 0..self.system.contacts();
        let sticking: Vec<usize> = contacts.clone().filter(sticks).collect();
        let of = contacts.fold(none, |of, contact| Combination {
            above: of.above | usize::from(modes.get(contact) == Mode::Slip(Side::Above)) << contact,
            held: of.held | usize::from(sticks(&contact)) << contact,
        });
        match sticking[..] {
            [] => self.reactions_in(of, t, x),
            [contact] => {
                let part = self.system.part_above(contact, of, t, x);
                let below = self.reactions_in(of, t, x);
                let above = of.above | 1 << contact;
                let above = self.reactions_in(Combination { above, ..of }, t, x);
                let both = below.iter().zip(above);
                both.map(|(below, above)| below + part * (above - below))
                    .collect()
            }
            _ => vec![f64::NAN; self.system.file.stops.len()],
        }
    }

    fn reactions_in(&mut self, of: Combination, t: f64, x: &[f64]) -> Vec<f64> {
        let known = self.reactions.iter().position(|(known, _)| *known == of);
        let place = known.unwrap_or_else(|| {
            self.reactions.push((of, self.system.reactions(of)));
            self.reactions.len() - 1
        });
        let mut values = vec![f64::NAN; self.system.file.stops.len()];
        if let Some(tape) = &self.reactions[place].1 {
            let x = self.system.built.switching.extended(t, x);
            tape.evaluate(t, &x, &mut values);
        }
        values
    }
}
