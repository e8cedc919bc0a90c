//! Newton's iteration for a periodic orbit and a parameter together.

use nalgebra::{DMatrix, DVector, SMatrix};

use crate::analysis::anchor::Anchor;
use crate::analysis::bifurcation::extrapolated;
use crate::analysis::critical::Critical;
use crate::analysis::monodromy::turn;
use crate::analysis::periodic::{by_tolerance_of, known, left, newton_solution, rounding};
use crate::analysis::sequence::circuit::Circuit;
use crate::analysis::sequence::determined::Closing;
use crate::analysis::sequence::locate::Known;
use crate::filippov::{
    Direction, Happening, Integration, Options, Plane, Progress, Switched, Watched,
};
use crate::orbit::Ending;
use crate::system::State;

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
        let states = N - 1;
        let matrix = DMatrix::from_fn(states, states, |i, j| self.matrix[(i, j)]);
        let flow = DVector::from_fn(states, |i, _| self.slope[i]);
        Critical::of(&matrix, (!is_forced).then_some(&flow), self.family)
    }
}

/// An orbit on a branch.
pub(super) type OnBranch = Known<Solved, N, K>;

/// Where an orbit is sought: near a state with its time and period, and where `row · x` has a value.
#[derive(Clone, Copy)]
pub(super) struct Guess {
    pub at: Anchor,
    pub period: f64,
    pub row: Vector,
    pub value: f64,
}

impl Guess {
    /// At a given parameter, near a state.
    pub fn at_parameter(mut at: Anchor, period: f64, parameter: f64) -> Self {
        at.x[N - 1] = parameter;
        Guess {
            at,
            period,
            row: State::from_fn(|i, _| f64::from(u8::from(i == N - 1))),
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

impl<S> Corrector<'_> {
    /// The next orbit of a branch at another parameter. Newton's iteration begins at the orbit itself, so that its first step is along the tangent:
    /// states and period go with the parameter while the orbit closes.
    pub fn next_at(
        &self,
        from: &OnBranch,
        parameter: f64,
    ) -> Option<OnBranch>
    {
        let start = from.branch.start;
        let guess = Guess {
            value: parameter,
            ..Guess::at_parameter(start, from.circuit.period, start.x[N - 1])
        };
        self.orbit(&guess, parameter)
    }

    /// The orbit at a parameter, which is its place, by those known.
    pub fn by_parameter(
        &self,
        good: &[OnBranch],
        parameter: f64,
    ) -> Option<OnBranch>
    {
        let (at, period) = extrapolated(good, parameter)?;
        self.orbit(&Guess::at_parameter(at, period, parameter), parameter)
    }

    /// The orbit near a guess with a tenth of the tolerances.
    pub fn finer(
        &self,
        guess: &Guess,
        s: f64,
    ) -> Option<OnBranch>
    {
        let options = &self.options.finer();
        Corrector { options, ..*self }.orbit(guess, s)
    }

    /// The way from one orbit of a branch to the next, across the flow; with a forcing, at the second one's time.
    pub fn way(
        &self,
        from: &Anchor,
        to: &Anchor,
    ) -> Vector
    {
        let way = to.x - from.x;
        let [before, flow] = [from, to].map(|at| at.velocity(self.system));
        // What one orbit moves while the other is waited for, by the trapezium rule: next to a graze orbits differ by the square of that time.
        let mean = (before + flow) * 0.5;
        if self.forced.is_some() {
            return way - mean * (to.t - from.t);
        }
        // Along the flow it is the same orbit.
        let across =
            |way: Vector, flow: Vector| way - flow * (flow.dot(&way) / flow.norm_squared());
        across(across(way, mean), flow)
    }

    /// The options for a run from a state, which is left where it goes far.
    fn bounded(&self, x: &Vector) -> Options {
        let reach = x.amax() + FAR * self.extent;
        self.options.escape(self.options.escape.min(reach))
    }

    /// After what time, of about a period, the orbit from a state is first back within a distance of it.
    pub fn comes_back(
        &self,
        from: &Anchor,
        period: f64,
        distance: f64,
    ) -> Option<f64>
    {
        if self.forced.is_some() {
            return None;
        }
        let section = Plane {
            point: from.x,
            normal: from.velocity(self.system),
            direction: Direction::Rising,
        };
        let t_end = from.t + MOST_PERIODS * period;
        let options = self.bounded(&from.x);
        let begun = Integration::new(self.system, from.t, from.x, t_end, &options).ok()?;
        let mut watched = Watched::new(begun, &section);
        loop {
            match watched.step().ok()? {
                Happening::Event(event) if (event.x - from.x).norm() <= distance => {
                    return Some(event.t - from.t);
                }
                Happening::Progress(Progress::End(_)) => return None,
                _ => {}
            }
        }
    }

    /// The matrix of Newton's iteration, of state, parameter and, where it is not the forcing's, period: that an orbit closes, `row · x` and where along the flow
    /// it begins.
    fn newton(
        &self,
        turn: &Matrix,
        velocity: &Vector,
        slope: &Vector,
        row: &Vector,
    ) -> DMatrix<f64> {
        let unknowns = N + usize::from(self.forced.is_none());
        let mut matrix = DMatrix::<f64>::zeros(unknowns, unknowns);
        for i in 0..N - 1 {
            for j in 0..N {
                matrix[(i, j)] = turn[(i, j)] - f64::from(u8::from(i == j));
            }
        }
        for j in 0..N {
            matrix[(N - 1, j)] = row[j];
        }
        if self.forced.is_none() {
            for i in 0..N - 1 {
                matrix[(i, N)] = velocity[i];
                matrix[(N, i)] = slope[i];
            }
        }
        matrix
    }

    /// How state, parameter and period change along the branch at an orbit, where `row · x` changes by 1.
    pub fn tangent(
        &self,
        orbit: &OnBranch,
        row: &Vector,
    ) -> Option<(Vector, f64)> {
        let Solved { matrix, slope, .. } = &orbit.branch;
        let matrix = self.newton(matrix, slope, slope, row);
        let mut right = DVector::<f64>::zeros(matrix.nrows());
        right[N - 1] = 1.0;
        let sizes = orbit.circuit.sizes.map(|size| match size {
            0.0 => orbit.circuit.extent,
            size => size,
        });
        let (change, _) = newton_solution(matrix, &right, (N - 1, 0), (sizes, 0.0))?;
        let of_period = change.get(N).copied().unwrap_or(0.0);
        Some((State::from_fn(|i, _| change[i]), of_period))
    }

    /// The orbit near a guess; `s` is its place on the branch.
    pub fn orbit(
        &self,
        guess: &Guess,
        s: f64,
    ) -> Option<OnBranch>
    {
        let mut period = self.forced.unwrap_or(guess.period);
        let begun = |at: Anchor, period: f64| {
            at.begun(self.system, at.t + period, self.options).ok()
        };
        let mut at = begun(guess.at, period)?;
        let slope = at.velocity(self.system);
        let by_tolerance = 100.0 * self.options.atol.max(self.options.rtol);
        let bounded = self.bounded(&at.x);
        let mut residual = f64::INFINITY;
        for iterations in 1..=MOST {
            let is_autonomous = self.forced.is_none();
            let end = at.t + period;
            let turn = turn(self.system, &at.at(), end, &bounded, is_autonomous).ok()?;
            let known = known(&turn, self.options);
            let (velocity, turn) = (turn.velocity, turn.monodromy);
            if turn.summary.ending != Ending::EndTime {
                return None;
            }
            let mut gap = turn.summary.x - at.x;
            gap[N - 1] = 0.0;
            let off = guess.value - guess.row.dot(&at.x);
            let size = gap.amax();
            let wanted = by_tolerance.max(rounding(&turn, &at.x));
            let is_on = off.abs() <= by_tolerance.min(1e-12) * guess.row.amax();
            let matrix = self.newton(&turn.matrix, &velocity, &slope, &guess.row);
            let mut right = DVector::<f64>::zeros(matrix.nrows());
            for i in 0..N - 1 {
                right[i] = -gap[i];
            }
            right[N - 1] = off;
            if self.forced.is_none() {
                // Along the flow nothing is corrected.
                let back = guess.at.x - at.x;
                right[N] = slope.dot(&back) - slope[N - 1] * back[N - 1];
            }
            let closes = size <= wanted && is_on && (size >= 0.5 * residual || size == 0.0);
            let free = if closes { 0 } else { self.family };
            let solved = newton_solution(matrix, &right, (N - 1, free), known);
            if closes {
                let family = solved.map_or(0, |(_, free)| free);
                let start = at.velocity(self.system);
                let meant = guess.at.moved(at.x);
                let circuit = Circuit::follow(self.system, &meant, period, self.options).ok()?;
                let closing = Closing {
                    states: N - 1,
                    matrix: turn.matrix,
                    flow: is_autonomous.then_some(start),
                    by_rounding: left(&gap, wanted, &turn, &at.x),
                    by_tolerance: by_tolerance_of(&at.x, self.options),
                    family,
                };
                let circuit = circuit.that_closes(self.system, &meant, &closing, self.options);
                // The period of another orbit, or a point of rest.
                let is_near = (period - guess.period).abs() <= 0.3 * guess.period;
                let is_same = self.forced.is_some()
                    || (velocity - start).norm()
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
            let moved = guess.at.moved(at.x + State::<N>::from_fn(|i, _| change[i]));
            if self.forced.is_none() {
                period += change[N];
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
