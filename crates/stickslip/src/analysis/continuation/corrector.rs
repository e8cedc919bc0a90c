//! Newton's iteration for a periodic orbit and a parameter together.

use crate::analysis::anchor::Anchor;
use crate::analysis::bifurcation::extrapolated;
use crate::analysis::critical::Critical;
use crate::analysis::monodromy::turn;
use crate::analysis::periodic::{by_tolerance_of, known, left, newton_solution, rounding};
use crate::analysis::sequence::circuit::Circuit;
use crate::analysis::sequence::determined::Closing;
use crate::analysis::sequence::locate::Known;
use crate::dynamics::{Dynamics, Happening, Matrix, Section, Vector};
use crate::filippov::{Direction, Options};
use crate::orbit::Ending;

/// Iterations allowed.
const MOST: usize = 12;

/// An orbit closes in its velocity to this part of it. Where it is slow that says more than that it closes in place: next to an equilibrium any orbit
/// comes back to where it was, within what rounding leaves.
const SAME_VELOCITY: f64 = 1e-4;

/// With a loose tolerance it closes in its velocity to as many times what it may be off in place.
const TIMES: f64 = 100.0;

/// An iterate's run is left where it goes so many times as far as orbits of the branch do: it escapes, maybe by ever shorter steps.
const FAR: f64 = 100.0;

/// An orbit whose period has jumped comes back within so many periods.
const MOST_PERIODS: f64 = 2.0;

/// What the branch needs of a periodic orbit besides its circuit.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    /// The derivative of the flow map over the period, that with respect to the parameter in the last column.
    pub matrix: Matrix,
    /// The start, and the direction of the flow there.
    pub start: Anchor,
    pub slope: Vector,
    pub iterations: usize,
    /// Dimension of the family of orbits at its parameter that it is one of.
    pub family: usize,
}

impl Solved {
    /// The functions of its multipliers.
    pub fn critical(&self, is_forced: bool) -> Critical {
        let states = self.slope.len() - 1;
        let matrix = self.matrix.view((0, 0), (states, states)).into_owned();
        let flow = self.slope.rows(0, states).into_owned();
        Critical::of(&matrix, (!is_forced).then_some(&flow), self.family)
    }
}

/// An orbit on a branch.
pub(super) type OnBranch = Known<Solved>;

impl OnBranch {
    pub fn parameter(&self) -> f64 {
        parameter(&self.circuit.anchor.x)
    }
}

/// The parameter, which is the last state.
pub(super) fn parameter(x: &Vector) -> f64 {
    x[x.len() - 1]
}

/// A state at another parameter.
pub(super) fn with_parameter(mut x: Vector, parameter: f64) -> Vector {
    let last = x.len() - 1;
    x[last] = parameter;
    x
}

/// Where an orbit is sought: near a state with its time and period, and where `row · x` has a value.
#[derive(Clone)]
pub(super) struct Guess {
    pub at: Anchor,
    pub period: f64,
    pub row: Vector,
    pub value: f64,
}

impl Guess {
    /// At a given parameter, near a state.
    pub fn at_parameter(at: &Anchor, period: f64, parameter: f64) -> Self {
        Guess {
            at: at.moved(with_parameter(at.x.clone(), parameter)),
            period,
            row: with_parameter(Vector::zeros(at.x.len()), 1.0),
            value: parameter,
        }
    }
}

/// A system whose last state is a parameter.
pub(super) struct Corrector<'a> {
    pub system: &'a dyn Dynamics,
    /// The period, where it is the forcing's.
    pub forced: Option<f64>,
    /// How far the widest orbit goes that is known.
    pub extent: f64,
    /// Dimension of the families that the orbits are of.
    pub family: usize,
    pub options: &'a Options,
}

impl Corrector<'_> {
    /// The next orbit of a branch at another parameter. Newton's iteration begins at the orbit itself, so that its first step is along the tangent:
    /// states and period go with the parameter while the orbit closes.
    pub fn next_at(&self, from: &OnBranch, value: f64) -> Option<OnBranch> {
        let start = &from.branch.start;
        let guess = Guess {
            value,
            ..Guess::at_parameter(start, from.circuit.period, parameter(&start.x))
        };
        self.orbit(&guess, value)
    }

    /// The orbit at a parameter, which is its place, by those known.
    pub fn by_parameter(&self, good: &[OnBranch], parameter: f64) -> Option<OnBranch> {
        let (at, period) = extrapolated(good, parameter)?;
        self.orbit(&Guess::at_parameter(&at, period, parameter), parameter)
    }

    /// The orbit near a guess with a tenth of the tolerances.
    pub fn finer(&self, guess: &Guess, s: f64) -> Option<OnBranch> {
        let options = &self.options.finer();
        Corrector { options, ..*self }.orbit(guess, s)
    }

    /// The way from one orbit of a branch to the next, across the flow; with a forcing, at the second one's time.
    pub fn way(&self, from: &Anchor, to: &Anchor) -> Vector {
        let way = &to.x - &from.x;
        let [before, flow] = [from, to].map(|at| at.velocity(self.system));
        // What one orbit moves while the other is waited for, by the trapezium rule: next to a graze orbits differ by the square of that time.
        let mean = (before + &flow) * 0.5;
        if self.forced.is_some() {
            return way - mean * (to.t - from.t);
        }
        // Along the flow it is the same orbit.
        let across = |way: Vector, flow: &Vector| {
            let part = flow.dot(&way) / flow.norm_squared();
            way - flow * part
        };
        across(across(way, &mean), &flow)
    }

    /// The options for a run from a state, which is left where it goes far.
    fn bounded(&self, x: &Vector) -> Options {
        let reach = x.amax() + FAR * self.extent;
        self.options.escape(self.options.escape.min(reach))
    }

    /// After what time, of about a period, the orbit from a state is first back within a distance of it.
    pub fn comes_back(&self, from: &Anchor, period: f64, distance: f64) -> Option<f64> {
        if self.forced.is_some() {
            return None;
        }
        let section = Section::Plane {
            point: from.x.clone(),
            normal: from.velocity(self.system),
            direction: Direction::Rising,
        };
        let t_end = from.t + MOST_PERIODS * period;
        let options = self.bounded(&from.x);
        let mut orbit = self.system.begin(from, t_end, &options, &section).ok()?;
        loop {
            match orbit.step().ok()? {
                Happening::Passage(at) if (&at.x - &from.x).norm() <= distance => {
                    return Some(at.t - from.t);
                }
                Happening::End(_) => return None,
                _ => {}
            }
        }
    }

    /// The matrix of Newton's iteration, of state, parameter and, where it is not the forcing's, period: that an orbit closes, `row · x` and where along the flow
    /// it begins.
    fn newton(&self, turn: &Matrix, velocity: &Vector, slope: &Vector, row: &Vector) -> Matrix {
        let n = row.len();
        let unknowns = n + usize::from(self.forced.is_none());
        let mut matrix = Matrix::zeros(unknowns, unknowns);
        for i in 0..n - 1 {
            for j in 0..n {
                matrix[(i, j)] = turn[(i, j)] - f64::from(u8::from(i == j));
            }
        }
        for j in 0..n {
            matrix[(n - 1, j)] = row[j];
        }
        if self.forced.is_none() {
            for i in 0..n - 1 {
                matrix[(i, n)] = velocity[i];
                matrix[(n, i)] = slope[i];
            }
        }
        matrix
    }

    /// How state, parameter and period change along the branch at an orbit, where `row · x` changes by 1.
    pub fn tangent(&self, orbit: &OnBranch, row: &Vector) -> Option<(Vector, f64)> {
        let n = row.len();
        let Solved { matrix, slope, .. } = &orbit.branch;
        let matrix = self.newton(matrix, slope, slope, row);
        let mut right = Vector::zeros(matrix.nrows());
        right[n - 1] = 1.0;
        let sizes = orbit.circuit.sizes.map(|size| match size {
            0.0 => orbit.circuit.extent,
            size => size,
        });
        let (change, _) = newton_solution(matrix, &right, (n - 1, 0), (sizes, 0.0))?;
        let of_period = change.get(n).copied().unwrap_or(0.0);
        Some((change.rows(0, n).into_owned(), of_period))
    }

    /// The orbit near a guess; `s` is its place on the branch.
    pub fn orbit(&self, guess: &Guess, s: f64) -> Option<OnBranch> {
        let n = guess.row.len();
        let is_autonomous = self.forced.is_none();
        let mut period = self.forced.unwrap_or(guess.period);
        let begun = |at: Anchor, period: f64| {
            let t_end = at.t + period;
            at.begun(self.system, t_end, self.options).ok()
        };
        let mut at = begun(guess.at.clone(), period)?;
        let slope = at.velocity(self.system);
        let by_tolerance = 100.0 * self.options.atol.max(self.options.rtol);
        let bounded = self.bounded(&at.x);
        let mut residual = f64::INFINITY;
        for iterations in 1..=MOST {
            let turn = turn(self.system, &at, at.t + period, &bounded, is_autonomous).ok()?;
            let known = known(&turn, self.options);
            let (velocity, turn) = (turn.velocity, turn.monodromy);
            if turn.summary.ending != Ending::EndTime {
                return None;
            }
            let gap = with_parameter(&turn.summary.x - &at.x, 0.0);
            let off = guess.value - guess.row.dot(&at.x);
            let size = gap.amax();
            let wanted = by_tolerance.max(rounding(&turn, &at.x));
            let is_on = off.abs() <= by_tolerance.min(1e-12) * guess.row.amax();
            let matrix = self.newton(&turn.matrix, &velocity, &slope, &guess.row);
            let mut right = Vector::zeros(matrix.nrows());
            for i in 0..n - 1 {
                right[i] = -gap[i];
            }
            right[n - 1] = off;
            if is_autonomous {
                // Along the flow nothing is corrected.
                let back = &guess.at.x - &at.x;
                right[n] = slope.dot(&back) - slope[n - 1] * back[n - 1];
            }
            let closes = size <= wanted && is_on && (size >= 0.5 * residual || size == 0.0);
            let free = if closes { 0 } else { self.family };
            let solved = newton_solution(matrix, &right, (n - 1, free), known);
            if closes {
                let family = solved.map_or(0, |(_, free)| free);
                let start = at.velocity(self.system);
                let meant = guess.at.moved(at.x.clone());
                let circuit = Circuit::follow(self.system, &meant, period, self.options).ok()?;
                let closing = Closing {
                    states: n - 1,
                    matrix: turn.matrix.clone(),
                    flow: is_autonomous.then(|| start.clone()),
                    by_rounding: left(&gap, wanted, &turn, &at.x),
                    by_tolerance: by_tolerance_of(&at.x, self.options),
                    family,
                };
                let circuit = circuit.that_closes(self.system, &meant, &closing, self.options);
                // The period of another orbit, or a point of rest.
                let is_near = (period - guess.period).abs() <= 0.3 * guess.period;
                let is_same = !is_autonomous
                    || (velocity - &start).norm()
                        <= SAME_VELOCITY.max(TIMES * by_tolerance) * start.norm();
                let branch = Solved {
                    matrix: turn.matrix,
                    start: at,
                    slope: start,
                    iterations,
                    family,
                };
                return (is_near && is_same && circuit.extent > by_tolerance).then_some(Known {
                    s,
                    circuit,
                    branch,
                });
            }
            residual = size;
            let (change, _) = solved?;
            let moved = guess.at.moved(&at.x + change.rows(0, n));
            if is_autonomous {
                period += change[n];
            }
            // A bad guess may ask for any period, and as long a run.
            let is_possible = (period - guess.period).abs() < guess.period;
            if !(is_possible && moved.x.iter().all(|v| v.is_finite())) {
                return None;
            }
            at = begun(moved, period)?;
        }
        None
    }
}
