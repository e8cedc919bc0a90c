//! An event function over a Taylor step, as polynomials in the part of the step.

use crate::ode::power_series;
use crate::taylor::MAX_COEFFICIENTS;
use crate::taylor::roots::turning_points;

/// Largest number of parts of a step with a polynomial each. Chosen: a polynomial about the middle
/// of a quarter converges eight times as fast as the step's own.
const MOST_PARTS: usize = 4;

/// Largest number of turns, and of ends of parts.
const MOST_TURNS: usize = MOST_PARTS * MAX_COEFFICIENTS;

/// A function over a step: a polynomial in each part.
pub(super) struct FunctionSeries {
    parts: [SeriesPart; MOST_PARTS],
    count: usize,
    /// Where it turns or a part ends, in order, and the values there; none while unknown.
    turns: [(f64, f64); MOST_TURNS],
    turn_count: usize,
}

#[derive(Clone, Copy)]
struct SeriesPart {
    from: f64,
    length: f64,
    /// Coefficients of the powers of the fraction of this part.
    c: [f64; MAX_COEFFICIENTS],
    order: usize,
}

/// One of the functions that differ from a series by a constant.
#[derive(Clone, Copy)]
pub(super) struct OnSeries<'a> {
    pub series: &'a FunctionSeries,
    pub constant: f64,
    /// The function at the ends of the step.
    pub start: f64,
    pub end: f64,
    /// Rounding of the function at a zero.
    pub rounding: f64,
    /// Whether the series is the function to rounding alone.
    pub is_affine: bool,
}

impl OnSeries<'_> {
    /// The function and its slope at a part of the step. At the ends it is that of their states.
    #[inline(always)]
    pub(super) fn at(&self, s: f64) -> (f64, f64) {
        let (value, slope) = self.series.at(s);
        let value = match s {
            0.0 => self.start,
            1.0 => self.end,
            _ => value + self.constant,
        };
        (value, slope)
    }
}

impl FunctionSeries {
    /// Without parts.
    pub(super) fn new() -> Self {
        let part = SeriesPart {
            from: 0.0,
            length: 1.0,
            c: [0.0; MAX_COEFFICIENTS],
            order: 0,
        };
        FunctionSeries {
            parts: [part; MOST_PARTS],
            count: 0,
            turns: [(0.0, 0.0); MOST_TURNS],
            turn_count: 0,
        }
    }

    /// Removes all parts.
    pub(super) fn clear(&mut self) {
        (self.count, self.turn_count) = (0, 0);
    }

    /// Adds the next part, from a place in the step on. Returns its coefficients to be set, up to
    /// the order.
    pub(super) fn add(
        &mut self,
        (from, length): (f64, f64),
        order: usize,
    ) -> &mut [f64; MAX_COEFFICIENTS] {
        let part = &mut self.parts[self.count];
        self.count += 1;
        (part.from, part.length, part.order) = (from, length, order);
        &mut part.c
    }

    /// The value and the slope at a part of the step.
    #[inline(always)]
    fn at(&self, s: f64) -> (f64, f64) {
        let behind = self.parts[..self.count]
            .iter()
            .rposition(|part| part.from <= s);
        let part = &self.parts[behind.unwrap_or(0)];
        let c = &part.c[..=part.order];
        let (value, slope) = power_series(c, (s - part.from) / part.length);
        (value, slope / part.length)
    }

    /// Where it turns or a part ends, in order, and the values there. Between two of them it rises
    /// or falls throughout.
    pub(super) fn turns(&self) -> &[(f64, f64)] {
        &self.turns[..self.turn_count]
    }

    /// Finds where it turns, in parts over which it changes by more than rounding. Returns whether
    /// that was not known.
    pub(super) fn find_turns(&mut self, rounding: f64) -> bool {
        if self.turn_count > 0 {
            return false;
        }
        for part in &self.parts[..self.count] {
            let c = &part.c[..=part.order];
            let reach: f64 = c[1..].iter().map(|c| c.abs()).sum();
            let (places, count) = match reach > rounding {
                true => turning_points(c),
                false => ([0.0; MAX_COEFFICIENTS], 0),
            };
            for &u in places[..count].iter().chain(&[1.0]) {
                // Parts are halves or quarters, whose ends are exact.
                self.turns[self.turn_count] = (part.from + u * part.length, power_series(c, u).0);
                self.turn_count += 1;
            }
        }
        true
    }

    /// Whether a value at the end of the step is the one there, up to rounding. The state at the
    /// end is moved onto a boundary, along which the series drift.
    pub(super) fn ends_at(&self, value: f64, rounding: f64) -> bool {
        let end = self.turns().last();
        end.is_some_and(|(_, end)| (value - end).abs() <= rounding)
    }

    /// Whether it has the sign `side` throughout the step, by more than rounding.
    pub(super) fn has_sign(&mut self, side: f64, rounding: f64) -> bool {
        self.find_turns(rounding);
        let [low, high] = self.range();
        let nearest = if side > 0.0 { low } else { -high };
        nearest > rounding
    }

    /// Bounds over the step, from the values where it turns.
    pub(super) fn range(&self) -> [f64; 2] {
        let start = self.parts[0].c[0];
        let turns = self.turns();
        turns
            .iter()
            .fold([start, start], |[low, high], (_, value)| {
                [low.min(*value), high.max(*value)]
            })
    }
}
