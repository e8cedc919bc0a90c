//! The chain against the dense matrix of the same equations.

use super::*;
use crate::analysis::cycle::{Cycle, Shooting, ShootingNodes};
use crate::dynamics::{AsDynamics, Matrix, Moment};
use crate::{Filippov, Options, Scalar, Side, math};

/// Frequency of the drive: near that of the block alone, which it entrains.
const FREQUENCY: f64 = 0.8;

/// A block on a belt, on a spring, with friction that falls with the slip speed; driven by `push`.
/// The belt's speed is the last state.
struct Block {
    push: f64,
}

impl Filippov<3> for Block {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 3]) -> [T; 3] {
        let slip_speed = (x[1] - x[2]) * side.sign();
        let friction = ((-slip_speed).exp() * 0.5 + 0.5) * side.sign();
        let push = (t * FREQUENCY).cos() * self.push;
        [x[1], push - x[0] - x[1] * 0.05 - friction, T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1] - x[2]
    }
}

/// The orbit near a start, run through twice a number of times.
fn orbit(system: &Block, (start, period): ([f64; 3], f64), doublings: u32) -> Cycle {
    let options = Options::tol(1e-12);
    let system = &*system.dynamics();
    let forced = (period > 0.0).then_some(period);
    let guess = if period > 0.0 { period } else { -period };
    let at = Moment {
        t: 0.0,
        x: Vector::from_vec(start.to_vec()),
    };
    let settled = crate::dynamics::run(system, &at, 40.0 * guess, &options).unwrap();
    let at = Moment {
        t: 40.0 * guess,
        x: settled.x,
    };
    let outline = OrbitGuess::of_run(system, &at, guess, &options).unwrap();
    let with_states = |outline: &OrbitGuess, times: f64| Shooting {
        states: 2,
        forced: forced.map(|period| times * period),
        ..Shooting::of(system, outline, None, &options)
    };
    let shooting = with_states(&outline, 1.0);
    let row = outline.unit(2);
    let cycle = shooting.nearest(&outline, Some((&row, start[2]))).unwrap();
    let mut outline = cycle.outline.clone();
    for _ in 0..doublings {
        outline = outline.twice(system);
    }
    // The states of each loop keep the errors of one out of the next.
    let begin = |k: usize| cycle.begins[k % cycle.begins.len()].x.clone();
    let begins = (1..outline.segments.len()).map(begin);
    let cut = cycle.outline.cut.clone().unwrap();
    let middle = match outline.segments.len() {
        1 => begin(0),
        _ => cut.states.last().unwrap().clone(),
    };
    outline.cut = Some(ShootingNodes {
        number: cut.number,
        states: begins.chain([middle]).collect(),
    });
    let times = f64::from(1_u32 << doublings);
    with_states(&outline, times).evaluated(&outline).unwrap()
}

/// Autonomous with a stick, and driven with and without one.
fn orbits(doublings: u32) -> [Cycle; 3] {
    let period = 2.0 * std::f64::consts::PI / FREQUENCY;
    [
        (0.0, ([0.5, 0.3, 0.3], -7.0)),
        (0.3, ([0.5, 0.3, 0.3], period)),
        (0.2, ([0.9, 0.0, 3.0], period)),
    ]
    .map(|(push, start)| orbit(&Block { push }, start, doublings))
}

fn dense(jacobian: &Jacobian) -> Matrix {
    let column = |k: usize| jacobian.times_vector(&unit(jacobian.unknowns, k));
    let columns: Vec<Vector> = (0..jacobian.unknowns).map(column).collect();
    Matrix::from_columns(&columns)
}

/// A row as that across a branch: along all durations.
fn across(cycle: &Cycle) -> Vector {
    let known = cycle.outline.begin.x.len() + cycle.outline.segments.len() + 1;
    Vector::from_fn(known, |k, _| math::sin(1.0 + 2.0 * k as f64))
}

#[test]
fn an_orbit_of_64_loops_has_the_solutions_of_the_dense_matrix() {
    for cycle in orbits(6) {
        let jacobian = cycle.jacobian.with_row(&across(&cycle));
        let matrix = dense(&jacobian);
        let count = matrix.nrows();
        assert_eq!(matrix.ncols(), count);
        assert!(cycle.outline.segments.len() == 1 || count > 64 * 3);
        let right = Vector::from_fn(count, |k, _| math::cos(3.0 * k as f64));
        let exact = matrix.clone().lu().solve(&right).unwrap();
        let found = jacobian.solve(&right).unwrap();
        let [own, others] = [&found, &exact].map(|x| (&matrix * x - &right).amax());
        assert!(
            own <= 10.0 * others.max(f64::EPSILON * exact.amax()),
            "{own:e} {others:e}"
        );
        // Sums of up to 200 terms, whose roundings mostly cancel.
        let (_, error) = jacobian.backward_error(&found, &right);
        assert!(error <= 16.0 * f64::EPSILON, "{error:e}");
        // Both have the error of a condition number that the singular values show.
        let values = matrix.clone().svd(false, false).singular_values;
        let condition = values.max() / values.min();
        let off = (&found - &exact).norm() / exact.norm();
        let rounding = count as f64 * f64::EPSILON * condition;
        assert!(off <= rounding, "{off:e} {condition:e}");
        let ratio = jacobian.determinant().over_power(0) / matrix.determinant();
        assert!((ratio - 1.0).abs() <= rounding, "{ratio} {condition:e}");
        let tangent = jacobian.tangent().unwrap();
        assert!((cycle.jacobian.times_vector(&tangent)).amax() <= 1e-12 * tangent.amax());
    }
}

#[test]
fn lengths_and_directions_are_those_of_the_dense_matrix() {
    for cycle in orbits(1) {
        let jacobian = cycle.jacobian.with_row(&across(&cycle));
        let matrix = dense(&jacobian);
        let count = matrix.nrows();
        let units = Vector::from_fn(count, |k, _| 1.5 + math::sin(k as f64));
        let weights = Vector::from_fn(count, |k, _| 1.5 + math::cos(k as f64));
        for (k, length) in jacobian.row_lengths(&units).iter().enumerate() {
            let exact = matrix.row(k).transpose().component_mul(&units).norm();
            assert!(
                (length - exact).abs() <= 1e-14 * exact.max(1e-300),
                "{k}: {length} {exact}"
            );
        }
        for (k, length) in jacobian.column_lengths(&weights).iter().enumerate() {
            let exact = matrix.column(k).component_mul(&weights).norm();
            assert!(
                (length - exact).abs() <= 1e-14 * exact.max(1e-300),
                "{k}: {length} {exact}"
            );
        }
        // The chain without an end leaves one direction, and not a second one.
        let matrix = dense(&cycle.jacobian);
        let found = cycle.jacobian.least_determined().unwrap();
        assert!(
            found[0].0 <= 1e-13 && found[1].0 > 1e-6,
            "{:e} {:e}",
            found[0].0,
            found[1].0
        );
        let square = matrix.resize_vertically(count, 0.0);
        let parts = square.svd(false, true);
        let smallest = parts.singular_values.imin();
        let exact = parts.v_t.unwrap().row(smallest).transpose();
        let cosine = exact.dot(&found[0].1).abs();
        assert!((cosine - 1.0).abs() < 1e-12, "{cosine}");
    }
}
