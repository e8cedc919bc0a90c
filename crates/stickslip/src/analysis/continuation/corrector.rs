//! Newton's iteration for a periodic orbit and a parameter together.

use nalgebra::{DMatrix, DVector, SMatrix};

use crate::analysis::monodromy::monodromy;
use crate::analysis::periodic::{rounding, slope_at};
use crate::analysis::sequence::circuit::Circuit;
use crate::analysis::sequence::locate::Known;
use crate::filippov::{Options, Switched};
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::system::State;

/// Iterations allowed.
const MOST: usize = 12;

/// What the branch needs of a periodic orbit besides its circuit.
#[derive(Clone, Debug)]
pub(super) struct Solved<const N: usize> {
    /// The derivative of the flow map over the period, that with respect to the parameter in the last column.
    pub matrix: SMatrix<f64, N, N>,
    /// The start, and the direction of the flow there.
    pub start: State<N>,
    pub slope: State<N>,
    pub iterations: usize,
}

/// An orbit on a branch.
pub(super) type OnBranch<const N: usize, K> = Known<Solved<N>, N, K>;

/// Where an orbit is sought: near a state with its time and period, and where `row · x` has a value.
#[derive(Clone, Copy)]
pub(super) struct Guess<const N: usize> {
    pub at: Timed<N>,
    pub period: f64,
    pub row: State<N>,
    pub value: f64,
}

/// A system whose last state is a parameter.
pub(super) struct Corrector<'a, S> {
    pub system: &'a S,
    /// The period, where it is the forcing's.
    pub forced: Option<f64>,
    pub options: &'a Options,
}

impl<S> Corrector<'_, S> {
    /// The orbit near a guess; `s` is its place on the branch.
    pub fn orbit<const N: usize, const G: usize>(
        &self,
        guess: &Guess<N>,
        s: f64,
    ) -> Option<OnBranch<N, S::Mode>>
    where
        S: Switched<N, G>,
    {
        let t = guess.at.t;
        let (mut x, mut period) = (guess.at.x, self.forced.unwrap_or(guess.period));
        let slope = slope_at(self.system, t, &x);
        let by_tolerance = 100.0 * self.options.atol.max(self.options.rtol);
        let mut residual = f64::INFINITY;
        for iterations in 1..=MOST {
            let turn = monodromy(self.system, t, x, t + period, self.options).ok()?;
            if turn.summary.ending != Ending::EndTime {
                return None;
            }
            let mut gap = turn.summary.x - x;
            gap[N - 1] = 0.0;
            let off = guess.value - guess.row.dot(&x);
            let size = gap.amax();
            let wanted = by_tolerance.max(rounding(&turn, &x));
            let is_on = off.abs() <= by_tolerance.min(1e-12) * guess.row.amax();
            if size <= wanted && is_on && (size >= 0.5 * residual || size == 0.0) {
                let circuit =
                    Circuit::follow(self.system, &Timed { t, x }, period, self.options).ok()?;
                // The period of another orbit, or a point of rest.
                let is_near = (period - guess.period).abs() <= 0.3 * guess.period;
                let branch = Solved {
                    matrix: turn.matrix,
                    start: x,
                    slope: slope_at(self.system, t, &x),
                    iterations,
                };
                return (is_near && circuit.extent > by_tolerance).then_some(Known {
                    s,
                    circuit,
                    branch,
                });
            }
            residual = size;
            let velocity = slope_at(self.system, t + period, &turn.summary.x);
            let unknowns = N + usize::from(self.forced.is_none());
            let mut matrix = DMatrix::<f64>::zeros(unknowns, unknowns);
            let mut right = DVector::<f64>::zeros(unknowns);
            for i in 0..N - 1 {
                for j in 0..N {
                    matrix[(i, j)] = turn.matrix[(i, j)] - f64::from(u8::from(i == j));
                }
                right[i] = -gap[i];
            }
            for j in 0..N {
                matrix[(N - 1, j)] = guess.row[j];
            }
            right[N - 1] = off;
            if self.forced.is_none() {
                for i in 0..N - 1 {
                    matrix[(i, N)] = velocity[i];
                    matrix[(N, i)] = slope[i];
                }
                // Along the flow nothing is corrected.
                right[N] = slope.dot(&(guess.at.x - x)) - slope[N - 1] * (guess.at.x - x)[N - 1];
            }
            let change = matrix.lu().solve(&right)?;
            x += State::<N>::from_fn(|i, _| change[i]);
            if self.forced.is_none() {
                period += change[N];
            }
            // A bad guess may ask for any period, and as long a run.
            let is_possible = (period - guess.period).abs() < guess.period;
            if !(is_possible && x.iter().all(|v| v.is_finite())) {
                return None;
            }
        }
        None
    }
}
