//! The line along which the next orbit of a branch is sought.

use super::corrector::{Guess, OnBranch, parameter, with_parameter};
use super::walk::Walk;
use crate::analysis::anchor::Anchor;
use crate::analysis::bifurcation::pair_for;
use crate::dynamics::Vector;

/// The line through the last two orbits, along which the next is sought.
#[derive(Clone)]
pub(super) struct Line {
    pub base: Anchor,
    pub period: f64,
    /// Changes for a step of length 1, at the same time.
    pub direction: Vector,
    pub of_period: f64,
    /// Distance between the two.
    pub length: f64,
    /// Weights of the components.
    pub weights: Vector,
    /// Whether orbits are sought at a parameter: of a family at each, the nearest one. Elsewhere in
    /// the plane across the line.
    is_of_families: bool,
}

impl Line {
    /// Where the orbit is sought at a place on it.
    pub fn guess(&self, s: f64) -> Guess {
        let at = self.base.moved(&self.base.x + &self.direction * s);
        let period = self.period + self.of_period * s;
        if self.is_of_families {
            return Guess::at_parameter(&at, period, parameter(&at.x));
        }
        let row = self.direction.component_mul(&self.weights);
        Guess {
            value: row.dot(&at.x),
            at,
            period,
            row,
        }
    }
}

impl Walk<'_> {
    pub(super) fn line(&self) -> Line {
        let (a, b) = (&self.before.circuit, &self.last.circuit);
        let (state, parameter) = (1.0 / self.size, 1.0 / self.width);
        let weights = Vector::repeat(b.anchor.x.len(), state * state);
        let weights = with_parameter(weights, parameter * parameter);
        let is_forced = self.settings.forced.is_some();
        let way = self.corrector.way(&a.anchor, &b.anchor);
        let length = way.component_mul(&way).dot(&weights).sqrt();
        Line {
            // Only the forcing knows the time.
            base: b.anchor.at_time(if is_forced { b.anchor.t } else { 0.0 }),
            period: b.period,
            direction: way / length,
            of_period: (b.period - a.period) / length,
            length,
            weights,
            is_of_families: self.corrector.family > 0,
        }
    }

    /// The line through the last orbit along the branch's own tangent there.
    pub(super) fn tangent(&self, line: &Line) -> Option<Line> {
        let row = line.direction.component_mul(&line.weights);
        let (way, of_period) = self.corrector.tangent(&self.last, &row)?;
        let length = way.component_mul(&way).dot(&line.weights).sqrt();
        Some(Line {
            base: self.last.branch.start.at_time(line.base.t),
            direction: way / length,
            of_period: of_period / length,
            ..line.clone()
        })
    }

    /// The orbit next to a place on the line, if there is one no farther from it than the place is from the last orbit; between the last
    /// two, than these are from each other.
    pub(super) fn on(&self, line: &Line, s: f64) -> Option<OnBranch> {
        self.on_across(line, line.guess(s), s)
    }

    /// The same, sought where those lead to that were found on it: next to a change a guess that is a little off lies behind it.
    pub(super) fn on_beyond(&self, line: &Line, good: &[OnBranch], s: f64) -> Option<OnBranch> {
        let ([one, two], part) = pair_for(good, s)?;
        let [a, b] = [one, two].map(|one| {
            if one.s > 0.0 {
                &one.branch.start.x - &line.guess(one.s).at.x
            } else {
                // The last two of the branch are on it by themselves.
                Vector::zeros(line.base.x.len())
            }
        });
        let guess = line.guess(s);
        let guess = Guess {
            at: guess.at.moved(&guess.at.x + &b + (&b - a) * part),
            period: two.circuit.period + (two.circuit.period - one.circuit.period) * part,
            ..guess
        };
        self.on_across(line, guess, s)
    }

    fn on_across(&self, line: &Line, guess: Guess, s: f64) -> Option<OnBranch> {
        let found = self.corrector.orbit(&guess, s)?;
        let off = &found.branch.start.x - &guess.at.x;
        let distance = off.component_mul(&off).dot(&line.weights).sqrt();
        let room = if s < 0.0 { line.length } else { s };
        (distance <= room.max(0.1 * self.step)).then_some(found)
    }
}
