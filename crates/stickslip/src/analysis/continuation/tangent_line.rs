//! The tangent of a branch, along which the next orbit is sought.

use super::parameter_of;
use crate::analysis::cycle::{Cycle, OrbitGuess, Shooting, SolutionsOnLine, resolved};
use crate::dynamics::Vector;

/// The line through an orbit along which the next one is sought. Newton's iteration stays in a
/// plane across it.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct TangentLine {
    /// The orbit at which it begins.
    pub from: OrbitGuess,
    /// Changes of the unknowns for a step of length 1.
    pub direction: Vector,
    /// The plane across the line, on which its product with the unknowns is constant.
    row: Vector,
    /// Whether the planes are those of a fixed parameter: in a family, the nearest orbit at each
    /// value is sought.
    is_of_families: bool,
}

/// The units of a step.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Units {
    /// Extent of the first orbit, which is the largest size of a state.
    pub size: f64,
    /// Size of each state.
    pub states: Vector,
    /// Width of the parameter's range.
    pub width: f64,
    /// Width of the other parameter's range; that is the last component but one, if there is one.
    pub other: Option<f64>,
}

/// Smallest cosine of the angle by which a branch may turn in a step. Chosen: 26 degrees, at which
/// Newton's iteration converges from the tangent.
pub(super) const LEAST_COSINE: f64 = 0.9;

impl Units {
    /// The units at the first orbit of a branch. A state has the size of its range over the orbit,
    /// or of its change over the parameter's range by its rate along the branch, if that is more.
    /// A state of which both are within the tolerances has the size of the orbit. So has one at
    /// rest whose rate changes with shorter steps of integration: beside a branch point, that is
    /// rounding.
    pub fn at(shooting: &Shooting<'_>, first: &Cycle, width: f64) -> Self {
        // Largest change of a rate by shorter steps. Chosen: of rounding, it is about 1.
        const CONFIRMED: f64 = 0.5;
        let (begin, size) = (&first.outline.begin.x, first.extent);
        let parameter = begin.len() - 1;
        let row = first.outline.unit(parameter);
        let changes = |cycle: &Cycle| {
            let along = cycle.jacobian.with_row(&row).tangent()?;
            Some(along.rows(0, shooting.states) * (width / along[parameter]))
        };
        let none = || Vector::zeros(shooting.states);
        let mut change = changes(first).unwrap_or_else(none);
        let resolves =
            |i: usize, own: f64| own > resolved(shooting.options.allowed(i, begin[i].abs()));
        let rests = |i: usize| !resolves(i, first.ranges[i]);
        if (0..shooting.states).any(|i| rests(i) && resolves(i, change[i].abs())) {
            let fixed = Some((&row, begin[parameter]));
            let finer = shooting.finer().solve(&first.outline, fixed);
            let finer = finer.as_ref().and_then(changes).unwrap_or_else(none);
            for (i, own) in change.iter_mut().enumerate() {
                if rests(i) && (*own - finer[i]).abs() > CONFIRMED * own.abs() {
                    *own = 0.0;
                }
            }
        }
        let states = Vector::from_fn(shooting.states, |i, _| {
            let own = first.ranges[i].max(change[i].abs()).min(size);
            if resolves(i, own) { own } else { size }
        });
        let other = None;
        Units {
            size,
            states,
            width,
            other,
        }
    }

    /// Includes an orbit: the size of a state is the range over all orbits of the branch, up to the
    /// extent of the first one.
    pub fn include(&mut self, first: &Cycle, next: &Cycle) {
        let [from, to] = [first, next].map(|cycle| &cycle.outline.begin.x);
        for (i, size) in self.states.iter_mut().enumerate() {
            let own = next.ranges[i].max((to[i] - from[i]).abs());
            *size = size.max(own.min(self.size));
        }
    }

    /// Weights of the squares of the unknowns.
    fn weights(&self, cycle: &Cycle, is_forced: bool) -> Vector {
        let n = cycle.outline.begin.x.len();
        let other = self.other.unwrap_or(self.size);
        let mut sizes = self.states.clone().resize_vertically(n, other);
        sizes[n - 1] = self.width;
        let states = sizes.map(|size| (size * size).recip());
        let by_period = (cycle.period * cycle.period).recip();
        let count = cycle.outline.segments.len();
        let of_begin = if is_forced { by_period } else { 0.0 };
        let durations = std::iter::repeat_n(by_period, count);
        let all = states.iter().copied().chain(durations).chain([of_begin]);
        // The states at the cuts follow from these.
        let others = cycle.outline.unknowns().len() - (n + count + 1);
        let all = all.chain(std::iter::repeat_n(0.0, others));
        Vector::from_vec(all.collect())
    }
}

impl TangentLine {
    /// The tangent of the branch at an orbit, in the direction in which the product with `row`
    /// grows.
    pub fn tangent(
        shooting: &Shooting<'_>,
        units: &Units,
        cycle: &Cycle,
        row: &Vector,
    ) -> Option<Self> {
        let direction = cycle.jacobian.with_row(row).tangent()?;
        let line = TangentLine::along(shooting, units, cycle, direction)?;
        if shooting.family == 0 {
            return Some(line);
        }
        let number = cycle.outline.begin.x.len() - 1;
        Some(TangentLine {
            row: cycle.outline.unit(number),
            is_of_families: true,
            ..line
        })
    }

    /// The line along a direction from an orbit.
    pub fn along(
        shooting: &Shooting<'_>,
        units: &Units,
        cycle: &Cycle,
        direction: Vector,
    ) -> Option<Self> {
        let weights = units.weights(cycle, shooting.forced.is_some());
        let length = direction.component_mul(&direction).dot(&weights).sqrt();
        let direction = shooting.without_rounding(&cycle.outline, direction / length);
        let row = direction.component_mul(&weights);
        (length > 0.0 && length.is_finite()).then_some(TangentLine {
            from: cycle.outline.clone(),
            direction,
            row,
            is_of_families: false,
        })
    }

    /// The tangent at another orbit with the same sequence, in the same direction.
    pub fn continued(&self, shooting: &Shooting<'_>, units: &Units, cycle: &Cycle) -> Option<Self> {
        if !self.is_of_families {
            return TangentLine::tangent(shooting, units, cycle, &self.row);
        }
        let heading = self.heading();
        TangentLine::tangent(shooting, units, cycle, &(&self.row * heading))
    }

    /// Rate of the parameter along the line.
    pub fn heading(&self) -> f64 {
        self.direction[self.from.begin.x.len() - 1]
    }

    /// Whether another line continues in nearly the same direction.
    pub fn bends_little(&self, other: &TangentLine) -> bool {
        if self.is_of_families {
            return self.heading() * other.heading() > 0.0;
        }
        self.row.dot(&other.direction) >= LEAST_COSINE
    }

    /// Whether an orbit lies farther from it than a branch does that bends little on the way there:
    /// where there is none, Newton's iteration may lead to another branch.
    pub fn strays(&self, shooting: &Shooting<'_>, units: &Units, cycle: &Cycle) -> bool {
        // Largest distance from the line, as a fraction of the way on it. Chosen: twice that of an
        // arc that turns as far as it may.
        const FARTHEST: f64 = 0.5;
        let s = self.place(cycle);
        let off = cycle.outline.unknowns() - self.guess(s).unknowns();
        let weights = units.weights(cycle, shooting.forced.is_some());
        let square = off.component_mul(&off).dot(&weights);
        !self.is_of_families && square > (FARTHEST * s) * (FARTHEST * s)
    }

    /// The row of the planes across it.
    pub fn across(&self) -> &Vector {
        &self.row
    }

    /// The point at a place on it.
    pub fn guess(&self, s: f64) -> OrbitGuess {
        self.from
            .with(&(self.from.unknowns() + &self.direction * s))
    }

    /// The plane across it at a place: an outline in it, and its product with the unknowns.
    pub fn plane(&self, shooting: &Shooting<'_>, s: f64) -> Option<(OrbitGuess, f64)> {
        let guess = self.guess(s);
        let value = self.row.dot(&guess.unknowns());
        let lasts = shooting.lasts(&guess, guess.period());
        lasts.then_some((guess, value))
    }

    /// The orbit in the plane at a place.
    pub fn on(&self, shooting: &Shooting<'_>, s: f64) -> Option<Cycle> {
        let (guess, value) = self.plane(shooting, s)?;
        shooting.solve(&guess, Some((&self.row, value)))
    }

    /// The place of an orbit with the same sequence.
    pub fn place(&self, cycle: &Cycle) -> f64 {
        let step = cycle.outline.unknowns() - self.from.unknowns();
        self.row.dot(&step) / self.row.dot(&self.direction)
    }

    /// The segments whose durations vanish on it before a place, with the place where each does, in
    /// that order.
    pub fn vanishing(&self, by: f64) -> Vec<(usize, f64)> {
        let n = self.from.begin.x.len();
        let places = self.from.segments.iter().enumerate();
        let places = places.map(|(k, segment)| (k, -segment.duration / self.direction[n + k]));
        let mut places: Vec<_> = places.filter(|(_, s)| *s > 0.0 && *s <= by).collect();
        places.sort_by(|a, b| a.1.total_cmp(&b.1));
        places
    }

    /// The orbits on it.
    pub fn orbits<'l>(&'l self, shooting: &'l Shooting<'l>) -> Orbits<'l> {
        let line = self;
        Orbits { line, shooting }
    }
}

/// The orbits on a line, by their place on it.
pub(super) struct Orbits<'l> {
    line: &'l TangentLine,
    shooting: &'l Shooting<'l>,
}

impl SolutionsOnLine for Orbits<'_> {
    type Solution = Cycle;

    fn on(&self, place: f64) -> Option<Cycle> {
        self.line.on(self.shooting, place)
    }

    fn finer(&self, place: f64) -> Option<Cycle> {
        self.line.on(&self.shooting.finer(), place)
    }

    fn parameter(&self, cycle: &Cycle) -> f64 {
        parameter_of(cycle)
    }
}
