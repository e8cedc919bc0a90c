//! The line along which the next orbit of a branch is sought.

use super::{parameter_of, with_parameter};
use crate::analysis::critical::zero_between;
use crate::analysis::cycle::{Cycle, Outline, Shooting};
use crate::dynamics::Vector;

/// The line through an orbit along which the next one is sought, in the plane across it.
#[derive(Clone)]
pub(super) struct Line {
    /// The orbit that it begins at.
    pub from: Outline,
    /// Changes of the unknowns for a step of length 1.
    pub direction: Vector,
    /// The plane across the line: its product with the unknowns is the same.
    row: Vector,
    /// Whether orbits are sought at a parameter: of a family at each, the nearest one.
    is_of_families: bool,
}

/// The units of a step.
#[derive(Clone, Copy)]
pub(super) struct Units {
    /// Size of the first orbit.
    pub size: f64,
    /// Width of the parameter's range.
    pub width: f64,
    /// And of the other's, the last component but one, if there is one.
    pub other: Option<f64>,
}

/// The cosine of the angle by which a branch turns in a step, at least.
const BEND: f64 = 0.9;

impl Units {
    /// Weights of the squares of the unknowns.
    fn weights(&self, cycle: &Cycle, is_forced: bool) -> Vector {
        let n = cycle.outline.begin.x.len();
        let states = Vector::repeat(n, (self.size * self.size).recip());
        let mut states = with_parameter(states, (self.width * self.width).recip());
        if let Some(width) = self.other {
            states[n - 2] = (width * width).recip();
        }
        let by_period = (cycle.period * cycle.period).recip();
        let count = cycle.outline.segments.len();
        let of_begin = if is_forced { by_period } else { 0.0 };
        let durations = std::iter::repeat_n(by_period, count);
        let all = states.iter().copied().chain(durations).chain([of_begin]);
        // The states at the cuts follow from these.
        let rest = cycle.jacobian.ncols() - (n + count + 1);
        let all = all.chain(std::iter::repeat_n(0.0, rest));
        Vector::from_vec(all.collect())
    }
}

/// A direction that unknowns may go in: that of the parameter, or of a duration.
pub(super) fn unit(cycle: &Outline, number: usize) -> Vector {
    let count = cycle.unknowns().len();
    Vector::from_fn(count, |i, _| f64::from(u8::from(i == number)))
}

impl Line {
    /// Along the branch's tangent at an orbit, the way on which the product with `row` grows.
    pub fn tangent(
        shooting: &Shooting<'_>,
        units: Units,
        cycle: &Cycle,
        row: &Vector,
    ) -> Option<Self> {
        let rows = cycle.jacobian.nrows();
        let mut matrix = cycle.jacobian.clone().insert_row(rows, 0.0);
        let row = row.clone().resize_vertically(matrix.ncols(), 0.0);
        matrix.set_row(rows, &row.transpose());
        let mut right = Vector::zeros(rows + 1);
        right[rows] = 1.0;
        let way = matrix.lu().solve(&right)?;
        let weights = units.weights(cycle, shooting.forced.is_some());
        let length = way.component_mul(&way).dot(&weights).sqrt();
        let direction = way / length;
        let is_of_families = shooting.family > 0;
        let row = if is_of_families {
            let number = cycle.outline.begin.x.len() - 1;
            unit(&cycle.outline, number)
        } else {
            direction.component_mul(&weights)
        };
        (length > 0.0 && length.is_finite()).then_some(Line {
            from: cycle.outline.clone(),
            direction,
            row,
            is_of_families,
        })
    }

    /// Along a direction from an orbit.
    pub fn along(
        shooting: &Shooting<'_>,
        units: Units,
        cycle: &Cycle,
        way: Vector,
    ) -> Option<Self> {
        let weights = units.weights(cycle, shooting.forced.is_some());
        let length = way.component_mul(&way).dot(&weights).sqrt();
        let direction = way / length;
        let row = direction.component_mul(&weights);
        (length > 0.0 && length.is_finite()).then_some(Line {
            from: cycle.outline.clone(),
            direction,
            row,
            is_of_families: false,
        })
    }

    /// The same way from another orbit with the same sequence.
    pub fn goes_on(&self, shooting: &Shooting<'_>, units: Units, cycle: &Cycle) -> Option<Self> {
        if !self.is_of_families {
            return Line::tangent(shooting, units, cycle, &self.row);
        }
        let heading = self.heading();
        Line::tangent(shooting, units, cycle, &(&self.row * heading))
    }

    /// How the parameter changes along it.
    pub fn heading(&self) -> f64 {
        self.direction[self.from.begin.x.len() - 1]
    }

    /// Whether another line goes on in nearly the same direction.
    pub fn bends_little(&self, other: &Line) -> bool {
        if self.is_of_families {
            return self.heading() * other.heading() > 0.0;
        }
        self.row.dot(&other.direction) >= BEND
    }

    /// The plane across it.
    pub fn across(&self) -> &Vector {
        &self.row
    }

    pub fn guess(&self, s: f64) -> Outline {
        self.from
            .with(&(self.from.unknowns() + &self.direction * s))
    }

    /// The plane across it at a place: an outline in it, and its product with the unknowns.
    pub fn plane(&self, s: f64) -> Option<(Outline, f64)> {
        let guess = self.guess(s);
        let is_possible = guess.segments.iter().all(|one| one.duration >= 0.0);
        let value = self.row.dot(&guess.unknowns());
        is_possible.then_some((guess, value))
    }

    /// The orbit at a place on it.
    pub fn on(&self, shooting: &Shooting<'_>, s: f64) -> Option<Cycle> {
        let (guess, value) = self.plane(s)?;
        shooting.solve(&guess, Some((&self.row, value)))
    }

    /// The place of an orbit with the same sequence.
    pub fn place(&self, cycle: &Cycle) -> f64 {
        let way = self
            .row
            .dot(&(cycle.outline.unknowns() - self.from.unknowns()));
        way / self.row.dot(&self.direction)
    }

    /// The segments whose durations would vanish on it by a place, the first of them first, and
    /// where.
    pub fn vanishing(&self, by: f64) -> Vec<(usize, f64)> {
        let n = self.from.begin.x.len();
        let places = self.from.segments.iter().enumerate();
        let places = places.map(|(k, segment)| (k, -segment.duration / self.direction[n + k]));
        let mut places: Vec<_> = places.filter(|(_, s)| *s > 0.0 && *s <= by).collect();
        places.sort_by(|a, b| a.1.total_cmp(&b.1));
        places
    }

    /// Two places at which a function of the orbits has different signs, or is zero, near the
    /// beginning of the line, where it has a value; they are less than a step apart as a rule.
    pub fn bracket(
        &self,
        shooting: &Shooting<'_>,
        (at_begin, step): (f64, f64),
        function: impl Fn(&Cycle) -> Option<f64>,
    ) -> Option<[(f64, f64); 2]> {
        // First step, and how far beyond the zero that it tells the next one goes.
        const FIRST: f64 = 1e-2;
        const FURTHER: f64 = 1.5;
        const MOST: usize = 6;
        let (mut a, mut at_a) = (0.0, at_begin);
        let mut b = FIRST * step;
        for _ in 0..MOST {
            let at_b = function(&self.on(shooting, b)?)?;
            if at_a * at_b <= 0.0 {
                return Some([(a, at_a), (b, at_b)]);
            }
            let slope = (at_b - at_a) / (b - a);
            (a, at_a, b) = (b, at_b, b - FURTHER * at_b / slope);
        }
        None
    }

    /// Where a function of the orbits is zero, between two places at which it has different signs,
    /// and by how much that may be off.
    pub fn zero(
        &self,
        shooting: &Shooting<'_>,
        (a, b): ((f64, f64), (f64, f64)),
        function: impl Fn(&Cycle) -> Option<f64>,
    ) -> Option<Zero> {
        let (s, cycle) = self.root(shooting, (a, b), &function)?;
        let length = (b.0 - a.0).abs();
        let uncertainty = self.uncertainty(shooting, (s, &cycle), length, &function);
        Some(Zero {
            s,
            parameter: parameter_of(&cycle),
            cycle,
            uncertainty,
        })
    }

    /// The same without how much that may be off.
    pub fn root(
        &self,
        shooting: &Shooting<'_>,
        ((a, at_a), (b, at_b)): ((f64, f64), (f64, f64)),
        function: impl Fn(&Cycle) -> Option<f64>,
    ) -> Option<(f64, Cycle)> {
        let value = |s: f64| function(&self.on(shooting, s)?);
        let s = zero_between((a, at_a), (b, at_b), value)?;
        // Where another branch meets this one none is found; next to it one is.
        const PARTS: [f64; 5] = [0.0, 1e-10, -1e-10, 1e-9, -1e-9];
        let place = |part: &f64| s + part * (b - a);
        let found = |s: f64| Some((s, self.on(shooting, s)?));
        let (s, cycle) = PARTS.iter().map(place).find_map(found)?;
        // Of a family a function may jump.
        const SMALL: f64 = 1e-3;
        let is_zero = function(&cycle)?.abs() <= SMALL * at_a.abs().max(at_b.abs());
        is_zero.then_some((s, cycle))
    }

    /// By how much the parameter may be off at which a function is about zero: what its value lacks
    /// of zero and what rounding leaves of it, over its slope, with what the tolerances do. A run
    /// with a tenth of them tells that. Not a number where nothing tells.
    fn uncertainty(
        &self,
        shooting: &Shooting<'_>,
        (s, cycle): (f64, &Cycle),
        length: f64,
        function: &impl Fn(&Cycle) -> Option<f64>,
    ) -> f64 {
        const APART: f64 = 1e-4;
        // Most of what a value is off by is its difference to one with a tenth of the tolerances;
        // twice that is on the safe side.
        const SAFE: f64 = 2.0;
        let by_slope = || {
            let beside = |way: f64| self.on(shooting, s + way);
            let (one, two) = (beside(-APART * length)?, beside(APART * length)?);
            let (value, [before, behind]) = (function(cycle)?, [function(&one)?, function(&two)?]);
            let options = &shooting.options.finer();
            let finer = Shooting {
                options,
                ..*shooting
            };
            let finer = self.on(&finer, s)?;
            let by_tolerance = SAFE * (function(&finer)? - value).abs();
            let lacks = value.abs() + (behind - 2.0 * value + before).abs() + by_tolerance;
            let parameter = parameter_of(cycle);
            // At a fold the parameter changes by the square of the way only.
            let ways = [&one, &two].map(|one| (parameter_of(one) - parameter).abs());
            let along = ways[0].max(ways[1]) * (2.0 * lacks / (behind - before)).abs();
            Some(along + SAFE * (parameter_of(&finer) - parameter).abs())
        };
        by_slope().unwrap_or(f64::NAN)
    }
}

/// An orbit at which a function is zero.
pub(super) struct Zero {
    pub s: f64,
    /// Its parameter, and the orbit that is computed there.
    pub parameter: f64,
    pub cycle: Cycle,
    /// By how much its parameter may be off; not a number where nothing tells.
    pub uncertainty: f64,
}
