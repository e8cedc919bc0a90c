//! The derivative of the flow map by saltation matrices, compared with differences of the flow map.

use nalgebra::SMatrix;
use stickslip::TransitionKind::StickEntry;
use stickslip::analysis::multipliers;
use stickslip::dynamics::Matrix;
use stickslip::{Mode, Side, State, math};

use super::check::{TIGHT, kinds};
use crate::any_system::{monodromy, periodic_orbit, solve};
use crate::blocks::Block;
use crate::compiled::Compiled;
use crate::solver::systems::{
    Dip, Floor, MovingLine, Pair, Spiral, StaticFriction, decaying_friction,
};

/// Differences over five points with this change err by its fourth power times the fifth
/// derivative, and by the tolerance over it (1e-8).
const CHANGE: f64 = 1e-5;
const ALLOWED: f64 = 1e-6;

fn by_differences<S: Compiled<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: State<N>,
    t_end: f64,
) -> SMatrix<f64, N, N> {
    let end = |x: State<N>| {
        let orbit = solve(system, t0, x, t_end, &super::tol(TIGHT)).expect("runs");
        orbit.x_end
    };
    let columns: Vec<_> = (0..N)
        .map(|j| {
            let moved = |by: f64| {
                let mut x = x0;
                x[j] += by;
                end(x)
            };
            let near = moved(CHANGE) - moved(-CHANGE);
            let far = moved(2.0 * CHANGE) - moved(-2.0 * CHANGE);
            (near * 8.0 - far) / (12.0 * CHANGE)
        })
        .collect();
    SMatrix::from_columns(&columns)
}

fn assert_agree<S: Compiled<N>, const N: usize>(
    what: &str,
    system: &S,
    (t0, x0): (f64, State<N>),
    t_end: f64,
    stick_entries: usize,
) -> Matrix {
    let options = super::tol(TIGHT);
    let found = monodromy(system, t0, x0, t_end, &options).expect("runs");
    let orbit = solve(system, t0, x0, t_end, &options).expect("runs");
    assert_eq!(found.summary.x.as_slice(), orbit.x_end.as_slice(), "{what}");
    let entries = kinds(&orbit).iter().filter(|k| **k == StickEntry).count();
    assert_eq!(
        (found.stick_entries, entries),
        (stick_entries, stick_entries),
        "{what}"
    );
    let exact = by_differences(system, t0, x0, t_end);
    let exact = Matrix::from_column_slice(N, N, exact.as_slice());
    let error = (&found.matrix - &exact).amax() / exact.amax().max(1.0);
    assert!(
        error < ALLOWED,
        "{what} to {t_end}: {} {exact}",
        found.matrix
    );
    found.matrix
}

#[test]
fn crossings_of_the_floor_and_of_the_circle() {
    let m = assert_agree("floor", &Floor, (0.0, State::from([3.0, -0.1])), 8.0, 0);
    assert!(m.determinant().abs() > 1e-3);
    assert_agree(
        "floor at rest",
        &Floor,
        (0.0, State::from([3.0, -0.1])),
        14.0,
        1,
    );
    assert_agree("spiral", &Spiral, (0.0, State::from([0.3, 0.2])), 2.0, 0);
}

#[test]
fn stick_takes_one_from_the_rank() {
    let cases = [
        (decaying_friction(), [0.04, -0.01]),
        (Block::on_belt(0.4), [0.5, 1.5]),
    ];
    for (belt, start) in cases {
        let start = State::from(start);
        for (t_end, entries) in sticks_by(&belt, start, &[0.1, 2.0, 6.0, 9.0, 15.0, 25.0]) {
            let m = assert_agree("belt", &belt, (0.0, start), t_end, entries);
            if entries > 0 {
                // Rounding of a determinant that is zero: a few units of its two products.
                let rounding = 100.0 * f64::EPSILON * m.amax() * m.amax();
                assert!(
                    m.determinant().abs() <= rounding,
                    "{t_end}: {}",
                    m.determinant()
                );
            } else {
                assert!(m.determinant() > 0.1, "{t_end}: {}", m.determinant());
            }
        }
    }
}

/// Number of entries into stick up to each of the times.
fn sticks_by(belt: &Block, start: State<2>, times: &[f64]) -> Vec<(f64, usize)> {
    let orbit = solve(belt, 0.0, start, 100.0, &super::tol(TIGHT)).expect("runs");
    let entered = |t: &f64| orbit.sticks().filter(|stick| stick.t_start < *t).count();
    times.iter().map(|t| (*t, entered(t))).collect()
}

#[test]
fn a_moving_boundary_is_crossed_slid_on_and_left() {
    let crossed = assert_agree(
        "moving",
        &MovingLine { a: 0.3 },
        (0.0, State::from([0.7])),
        1.5,
        0,
    );
    assert!(
        (crossed[(0, 0)] - 1.0).abs() > 0.1,
        "the crossing must matter"
    );
    let slid = assert_agree(
        "moving",
        &MovingLine { a: 0.9 },
        (0.0, State::from([0.7])),
        1.5,
        1,
    );
    assert_eq!(slid[(0, 0)], 0.0);
    let dip = Dip {
        centre: 2.0,
        width: 0.3,
        amplitude: 0.5,
    };
    for (t_end, entries) in [(0.15, 0), (1.0, 1), (2.1, 1), (3.0, 2)] {
        assert_agree("dip", &dip, (0.0, State::from([0.1, 0.3])), t_end, entries);
    }
}

#[test]
fn the_cycle_without_stick_has_the_multiplier_of_its_return_map() {
    let belt = Block::on_belt(1.0);
    let options = super::tol(TIGHT);
    let guess = State::from([-0.27, -0.73]);
    let cycle = periodic_orbit(&belt, guess, 7.7, &options).expect("converges");
    let [trivial, other]: [_; 2] = multipliers(&cycle.monodromy).try_into().unwrap();
    // The monodromy is as accurate as the orbit. Its error, about 1e-12 per turn, is amplified by
    // its own norm.
    assert!(
        (trivial.re - 1.0).abs() < 1e-9 && trivial.im == 0.0,
        "{trivial}"
    );

    let upward = |orbit: &stickslip::Orbit<2>| {
        let to_above = |t: &&stickslip::Transition<2>| t.to == Mode::Slip(Side::Above);
        orbit.transitions.iter().find(to_above).expect("crosses").x[0]
    };
    let turn = solve(&belt, 0.0, &cycle.x, 10.0, &options).expect("runs");
    let fixed = upward(&turn);
    let mapped = |x: f64| {
        let orbit = solve(&belt, 0.0, State::from([x, 1.0]), 10.0, &options).expect("runs");
        assert_eq!(orbit.phases[0].mode, Mode::Slip(Side::Above));
        upward(&orbit)
    };
    assert!((mapped(fixed) - fixed).abs() < 1e-11);
    let slope = (mapped(fixed + CHANGE) - mapped(fixed - CHANGE)) / (2.0 * CHANGE);
    assert!((slope - other.re).abs() < ALLOWED, "{slope} {other}");
    assert!((other.re - 0.12629).abs() < 5e-6, "{other}");
    // Liouville: the determinant is the product. The friction law enters only through its slope.
    assert!(
        (math::ln(cycle.monodromy.determinant()) - math::ln(trivial.re * other.re)).abs() < 1e-9
    );
}

#[test]
fn static_friction_that_gives_way_jumps() {
    let block = StaticFriction {
        at_rest: 1.0,
        in_slip: 0.6,
    };
    // Off Σ, into stick, out of it across Σ, and back. The time of the exit depends on the position
    // at the entry.
    let slipping = (0.0, State::from([-0.3, 0.0]));
    assert_agree("static friction", &block, slipping, 12.0, 2);
    let m = assert_agree("static friction, one stick", &block, slipping, 8.0, 1);
    assert!(m.determinant().abs() < 1e-9);
}

/// For an orbit that begins in stick, a change across Σ returns to Σ at once, along the friction.
/// The position stays to first order. A change along Σ is carried by the stick and the following
/// slip.
#[test]
fn a_start_in_stick_forgets_what_is_across_the_boundary() {
    let belt = Block::on_belt(0.2);
    let start = State::from([-0.1, 0.2]);
    let orbit = solve(&belt, 0.0, start, 3.0, &super::tol(TIGHT)).expect("runs");
    assert_eq!(orbit.phases[0].mode, Mode::Stick);
    assert!(orbit.phases.len() > 1);
    let over = |t_end: f64| {
        let found = monodromy(&belt, 0.0, start, t_end, &super::tol(TIGHT)).expect("runs");
        // The returns from above and below take different times, so that only differences along Σ
        // are of second order.
        let along = by_differences(&belt, 0.0, start, t_end)
            .column(0)
            .into_owned();
        let error = (found.matrix.column(0) - along).amax();
        assert!(error < ALLOWED, "{} {along}", found.matrix);
        assert!(found.matrix.column(1).amax() < 1e-13, "{}", found.matrix);
        found.matrix
    };
    over(3.0);
    let [one, none]: [_; 2] = multipliers(&over(0.1)).try_into().unwrap();
    assert!((one.re - 1.0).abs() < 1e-13 && none.norm() < 1e-13);
}

#[test]
fn a_start_in_stick_comes_back_to_the_boundary_along_the_friction() {
    let start = State::from([0.1, 0.7, -0.2, 0.7]);
    let t_end = 2.0;
    let found = monodromy(&Pair, 0.0, start, t_end, &super::tol(TIGHT));
    let found = found.expect("runs").matrix;
    let mut exact = SMatrix::<f64, 4, 4>::identity();
    // Masses of 1 and 3.
    for (column, part) in [(1, 0.25), (3, 0.75)] {
        for row in [1, 3] {
            exact[(row, column)] = part;
            exact[(row - 1, column)] = part * t_end;
        }
    }
    let exact = Matrix::from_column_slice(4, 4, exact.as_slice());
    assert!((&found - &exact).amax() < 1e-13, "{found}");
}
