//! Reactions of stops along an orbit, their impulses, and formulas that have them.

use stickslip::dynamics::Modes;
use stickslip::error::readable;
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

/// The reactions of the stops of a system, and formulas of states, parameters, inputs, time and
/// these reactions, at any moment of an orbit.
pub struct Quantities<'a> {
    system: &'a System,
    /// Names of reactions and formulas: the reactions first.
    names: Vec<String>,
    /// The reactions in those combinations of sides that have occurred. Only one is needed where
    /// they do not depend on sides.
    reactions: Vec<(Combination, Option<Tape>)>,
    is_sided: bool,
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
        let mut tapes = Vec::new();
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
            let made = formula.and_then(|formula| self.with_reactions(&formula));
            tapes.push(made.map_err(|problem| FileError::wrong(problem, source(text)))?);
            names.push(name.to_owned());
        }
        let all = (1 << file.contacts.len()) - 1;
        let [below, above] = [0, all].map(|above| self.reactions(Combination { above, held: 0 }));
        Ok(Quantities {
            system: self,
            names,
            is_sided: below != above,
            reactions: Vec::new(),
            formulas: tapes,
        })
    }

    /// The tape of a formula, with the reactions behind all states.
    fn with_reactions(&self, formula: &Formula) -> Result<Tape, Problem> {
        let build = || {
            let (file, mut graph) = (&self.file, Graph::new());
            let first = file.states.len() + HELD_PER_INPUT * file.inputs.len();
            let reactions: Vec<Id> = (0..file.stops.len())
                .map(|stop| graph.state(first + stop))
                .collect();
            let inputs = Inputs::fixed(&self.values);
            let scope = Scope::NoSides("what is observed");
            let builder = Builder::new(file, inputs, &mut graph, scope);
            let root = builder.with_forces(reactions).formula(formula)?;
            let tape = Tape::new(&graph, &[root], first + file.stops.len());
            let tape = tape.map_err(|error| Problem::new(error.to_string(), 0..0))?;
            Ok(TapeBuild::new(graph, tape))
        };
        self.formula_tape(FormulaKey::WithReactions(formula.text.clone()), build)
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

    /// Why a stop that carries at a state has no finite reaction there, in words: on some sides of
    /// the contacts, the friction that follows the reaction undoes its effect on the gap. `None` if
    /// all reactions are finite.
    pub(super) fn without_reaction(&self, t: f64, x: &[f64]) -> Option<String> {
        let file = &self.file;
        if file.stops.is_empty() || x.len() != self.states() {
            return None;
        }
        let extended = self.built.switching.extended(t, x);
        sides_to_check(self.contacts()).into_iter().find_map(|above| {
            let (mut graph, inputs) = (Graph::new(), Inputs::fixed(&self.values));
            let of = Combination { above, held: 0 };
            let roots = stops::openings(file, inputs, &mut graph, of).ok()?;
            let tape = tape(file, &graph, &roots.concat(), inputs).ok()?;
            let mut values = vec![0.0; 2 * roots.len()];
            tape.evaluate(t, &extended, &mut values);
            let all = file.stops.iter().zip(values.chunks_exact(2));
            let mut carrying = all.filter(|(stop, _)| x[stop.closed] > 0.5);
            let (stop, values) =
                carrying.find(|(_, values)| values[0] <= NO_EFFECT * values[1])?;
            Some(format!(
                "no motion in contact is consistent there, or several are (Painlevé): a unit of \
                 the reaction of the stop `{}` changes the second derivative of its gap by {}, \
                 and by {} with the friction that follows it",
                stop.name,
                readable(values[1]),
                // Where it vanishes, rounding is left.
                readable(if values[0].abs() <= NO_EFFECT * values[1] { 0.0 } else { values[0] }),
            ))
        })
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
            let rates = self.field(of, t, x);
            let moved = x.iter().zip(rates).map(|(x, rate)| Dual::new(*x, rate));
            let moved: Vec<Dual<f64>> = moved.collect();
            self.boundary(contact, Dual::new(t, 1.0), &moved).eps
        });
        below / (below - above)
    }
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
