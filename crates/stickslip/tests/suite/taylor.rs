//! Tests of Taylor steps beyond those of every method: accuracy to the last digits, missed events,
//! kinks, memory.

use std::f64::consts::PI;

use stickslip::analysis::{Exponent, SpectrumOptions};
use stickslip::{
    Error, Filippov, Method, Options, Orbit, Scalar, Side, State, TransitionKind, math,
};

use crate::any_system::{Oscillator, lyapunov_spectrum, solve};
use crate::blocks::{Block, Bracket};
use crate::compiled::Compiled;
use crate::ensemble::CompiledBlock;
use crate::solver::systems::{Floor, Parabola, decaying_friction};

fn taylor(tolerance: f64) -> Options {
    Options::tol(tolerance).method(Method::Taylor)
}

const TIGHTEST: f64 = 1e-15;

/// A table of data/references: kind, time, position.
fn reference(table: &str) -> Vec<(&str, f64, f64)> {
    let rows = table.lines().skip(1).map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields[i].parse().expect("a number");
        (fields[2], number(3), number(4))
    });
    rows.collect()
}

/// Largest error of the times of an orbit's transitions.
fn worst_time(orbit: &Orbit<2>, table: &str) -> f64 {
    let exact = reference(table);
    assert_eq!(orbit.transitions.len(), exact.len());
    let mut worst = 0.0f64;
    for (found, (kind, t, x)) in orbit.transitions.iter().zip(&exact) {
        let found_kind = format!("{:?}", found.kind).to_lowercase();
        assert_eq!(found_kind.trim_start_matches("stick"), *kind);
        assert!((found.x[0] - x).abs() < 1e-11);
        worst = worst.max((found.t - t).abs());
    }
    worst
}

#[test]
fn events_of_orbits_that_forget_errors_are_exact_to_1e_14() {
    let start = State::from([0.04, -0.01]);
    let orbit = solve(&decaying_friction(), 0.0, start, 40.0, &taylor(TIGHTEST)).expect("runs");
    let worst = worst_time(
        &orbit,
        include_str!("../../../../data/references/decay.csv"),
    );
    assert!(worst <= 1e-14, "{worst}");
}

#[test]
fn events_of_an_orbit_that_enlarges_errors_by_thousands_are_exact_to_5e_13() {
    let belt = Block::on_belt(0.4);
    let start = State::from([0.5, 1.5]);
    let orbit = solve(&belt, 0.0, start, 30.0, &taylor(TIGHTEST)).expect("runs");
    let worst = worst_time(
        &orbit,
        include_str!("../../../../data/references/belt_sensitive.csv"),
    );
    assert!(worst <= 5e-13, "{worst}");
}

#[test]
fn swings_on_the_floor_end_at_multiples_of_pi_to_1e_14() {
    let orbit = solve(
        &Floor,
        0.0,
        State::from([3.0, 0.0]),
        40.0,
        &taylor(TIGHTEST),
    )
    .expect("runs");
    assert_eq!(orbit.transitions.len(), 4);
    for (k, event) in orbit.transitions.iter().enumerate() {
        let error = (event.t - (k + 1) as f64 * PI).abs();
        assert!(error <= 1e-14, "{k}: {error}");
    }
}

#[test]
fn a_normal_force_that_is_clipped_ends_steps_where_it_is() {
    // The contact is unloaded until it is lost in every oscillation.
    let model = Bracket { unloading: 3.0 };
    let start = State::from([0.1, 0.1, 0.1, 0.1]);
    let by_taylor = solve(&model, 0.0, start, 60.0, &taylor(1e-14)).expect("runs");
    let by_runge_kutta = solve(&model, 0.0, start, 60.0, &Options::tol(1e-14)).expect("runs");
    let kinds = |orbit: &Orbit<4>| orbit.transitions.iter().map(|e| e.kind).collect::<Vec<_>>();
    assert_eq!(kinds(&by_taylor), kinds(&by_runge_kutta));
    let lost = kinds(&by_taylor)
        .iter()
        .filter(|k| **k == TransitionKind::ContactLoss)
        .count();
    assert!(lost > 2, "{lost}");
    for (one, other) in by_taylor
        .transitions
        .iter()
        .zip(&by_runge_kutta.transitions)
    {
        assert!((one.t - other.t).abs() < 1e-9, "{} {}", one.t, other.t);
    }
}

/// `x' = 1` and `y' = max(x, 0)` or `|x|`, by a comparison or by reading the value.
#[derive(Clone, Copy, PartialEq)]
pub struct Kink {
    pub by_value: bool,
}

impl Filippov<2> for Kink {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let slope = if self.by_value {
            if x[0].value() > 0.0 {
                x[0]
            } else {
                T::constant(0.0)
            }
        } else {
            x[0].max(T::constant(0.0))
        };
        [T::constant(1.0), slope]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - 100.0
    }
}

#[test]
fn a_kink_inside_a_step_is_seen_however_the_field_branches() {
    for by_value in [false, true] {
        for x0 in [-1.0, -0.317, -1e-9, 0.0] {
            let start = State::from([x0, 0.0]);
            let orbit = solve(&Kink { by_value }, 0.0, start, 3.0, &taylor(1e-12)).expect("runs");
            let end = x0 + 3.0;
            // If a comparison shows the kink, it costs nothing. If only the field's value shows it,
            // the error may be that of the tolerance.
            let allowed = if by_value { 1e-9 } else { 1e-14 };
            assert!(
                (orbit.x_end[1] - 0.5 * end * end).abs() <= allowed,
                "{by_value} {x0}: {}",
                orbit.x_end[1]
            );
        }
    }
}

#[test]
fn dense_output_is_as_exact_as_the_steps() {
    let orbit = solve(&Floor, 0.0, State::from([3.0, 0.0]), 3.0, &taylor(TIGHTEST)).expect("runs");
    for i in 0..=300 {
        let t = 0.01 * f64::from(i);
        let exact = 0.4 + 2.6 * math::cos(t);
        let x = orbit.at(t).expect("covered");
        assert!((x[0] - exact).abs() < 4e-15, "{t}: {}", x[0] - exact);
    }
}

#[test]
fn a_longer_run_allocates_no_more() {
    let belt = Oscillator::Belt(CompiledBlock(Block {
        mu0: 0.5,
        ..Block::on_belt(0.2)
    }));
    let count = |t_end: f64| {
        let info = allocation_counter::measure(|| {
            let start = State::from([0.1, 0.2]);
            let options = taylor(1e-12);
            stickslip::run(&belt, 0.0, start, t_end, &options, &mut ()).expect("runs");
        });
        info.count_total
    };
    assert_eq!(count(100.0), count(1000.0));
}

#[test]
fn tangent_vectors_travel_along_taylor_steps() {
    let belt = Block::on_belt(0.2);
    let settings = SpectrumOptions {
        solver: taylor(1e-10),
        ..SpectrumOptions::over(50.0, 300.0)
    };
    let start = (0.0, State::from([0.5, 0.1]));
    let spectrum = lyapunov_spectrum(&belt, start, &settings).expect("runs");
    assert!(spectrum.exponents[0].value().abs() < 0.02);
    assert_eq!(spectrum.exponents[1], Exponent::Annihilated);
}

#[test]
fn a_shaken_block_is_the_same_by_taylor_and_by_runge_kutta() {
    let model = Block::shaken();
    let start = State::from([0.1, 0.2]);
    let end = |options: &Options| solve(&model, 0.0, start, 5.0, options).map(|orbit| orbit.x_end);
    let (one, other) = (end(&taylor(1e-13)), end(&Options::tol(1e-13)));
    let difference = one.expect("runs") - other.expect("runs");
    assert!(difference.amax() < 1e-10, "{difference}");
}

/// A field that is undefined from t = 1 on.
pub struct UndefinedAfterOne;
impl Filippov<1> for UndefinedAfterOne {
    fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 1]) -> [T; 1] {
        [Scalar::ln(-t + 1.0) * x[0] + 1.0]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] + 100.0
    }
}

#[test]
fn a_field_that_is_not_a_number_is_reported_so() {
    let failure = solve(
        &UndefinedAfterOne,
        0.0,
        State::from([0.5]),
        2.0,
        &taylor(1e-12),
    )
    .expect_err("ends at 1");
    let (Error::StepCollapse { t, .. } | Error::NonFinite { t, .. }) = failure.error else {
        panic!("{}", failure.error);
    };
    assert!((t - 1.0).abs() < 1e-6, "{t}");
}

/// `x' = speed` and `y' = max(x, 0)`.
pub struct Ramp {
    pub speed: f64,
}

impl Filippov<2> for Ramp {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        [T::constant(self.speed), x[0].max(T::constant(0.0))]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - 100.0
    }
}

#[test]
fn a_kink_at_the_very_start_or_throughout_holds_nothing_up() {
    // Downwards from the kink at time zero; and always on it.
    for (speed, x) in [(-1.0, -3.0), (0.0, 0.0)] {
        let orbit = solve(
            &Ramp { speed },
            0.0,
            State::from([0.0, 0.0]),
            3.0,
            &taylor(1e-12),
        )
        .expect("runs");
        // The orbit leaves the ramp a few rounding units after its foot.
        assert!(orbit.x_end[1].abs() < 1e-30);
        assert!((orbit.x_end[0] - x).abs() < 1e-14);
        assert!(orbit.steps.len() < 20, "{}", orbit.steps.len());
    }
}

/// `x = sin t` on a circle's diameter. The boundary is the distance from the centre, which has no
/// series there, minus the radius.
pub struct Pit {
    pub radius: f64,
}

impl Filippov<2> for Pit {
    fn field<T: Scalar>(&self, _side: Side, t: T, _x: &[T; 2]) -> [T; 2] {
        [t.cos(), T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        (x[0] * x[0] + x[1] * x[1]).sqrt() - self.radius
    }
}

/// The motion of [`Pit`], with a boundary that reads the value.
#[derive(Clone, Copy, PartialEq)]
pub struct Gate {
    pub radius: f64,
}

impl Filippov<2> for Gate {
    fn field<T: Scalar>(&self, _side: Side, t: T, _x: &[T; 2]) -> [T; 2] {
        [t.cos(), T::constant(0.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        let distance = if x[0].value() < 0.25 {
            -x[0] + 0.5
        } else {
            x[0]
        };
        distance - self.radius
    }
}

/// Checks the motion over the edge at `asin r` and back at `π − asin r`, both within the first step
/// if that is long.
fn out_and_back<S: Compiled<2>>(system: &S, radius: f64) {
    for (tolerance, first_step, bound) in
        [(1e-3, 0.1, 2e-2), (1e-3, 3.0, 2e-2), (1e-14, 3.0, 1e-13)]
    {
        let options = Options {
            first_step: Some(first_step),
            ..taylor(tolerance)
        };
        let orbit = solve(system, 0.0, State::from([0.0, 0.0]), 3.0, &options).expect("runs");
        let times: Vec<f64> = orbit.transitions.iter().map(|event| event.t).collect();
        let out = math::atan2(radius, (1.0 - radius * radius).sqrt());
        assert_eq!(times.len(), 2, "first step {first_step}: {times:?}");
        for (found, exact) in times.iter().zip([out, PI - out]) {
            assert!(
                (found - exact).abs() < bound,
                "first step {first_step}: {times:?}"
            );
        }
    }
}

#[test]
fn a_boundary_without_a_series_at_the_start_is_met_all_the_same() {
    out_and_back(&Pit { radius: 0.9 }, 0.9);
}

#[test]
fn a_boundary_that_branches_by_value_is_met_on_the_other_branch() {
    out_and_back(&Gate { radius: 0.9 }, 0.9);
}

#[test]
fn a_contact_cut_in_two_by_a_step_s_end_is_one_touch() {
    // Negative from 2e-6 before the turning point to 2e-6 after it.
    let (depth, half_width) = (4e-12, 2e-6);
    for (start, longest) in [
        (-1.0, 1.0 - 3e-6),
        (-1.0, 1.0 - 1e-6),
        (-1.0, 1.0 - 1e-9),
        (-1.0, 1.0 + 1e-9),
        // Steps far shorter than the contact.
        (-5e-6, 2e-7),
    ] {
        let options = taylor(1e-12).longest_step(longest);
        let x = State::from([start, start * start - depth]);
        let orbit = solve(&Parabola { level: 0.0 }, 0.0, x, -2.0 * start, &options).expect("runs");
        let kinds: Vec<TransitionKind> = orbit.transitions.iter().map(|e| e.kind).collect();
        assert_eq!(kinds, [TransitionKind::Touch], "steps of {longest}");
        let off = (orbit.transitions[0].t + start).abs();
        let bound = if longest > half_width {
            1e-9
        } else {
            half_width
        };
        assert!(off < bound, "steps of {longest}: {off}");
    }
}

#[test]
fn a_contact_on_a_branch_by_value_is_one_touch_where_it_turns_back() {
    // sin t exceeds 1 - 1e-12 from 1.4e-6 before π/2 to 1.4e-6 after it.
    let gate = Gate {
        radius: 1.0 - 1e-12,
    };
    for longest in [3.0, 0.3, 0.1] {
        let options = taylor(1e-12).longest_step(longest);
        let orbit = solve(&gate, 0.0, State::from([0.0, 0.0]), 3.0, &options).expect("runs");
        let kinds: Vec<TransitionKind> = orbit.transitions.iter().map(|e| e.kind).collect();
        assert_eq!(kinds, [TransitionKind::Touch], "steps of {longest}");
        let off = (orbit.transitions[0].t - 0.5 * PI).abs();
        assert!(off < 1e-9, "steps of {longest}: {off}");
    }
}

/// `x = t` to a boundary at `x = 3/4` that is undefined beyond 1 and branches by value before.
#[derive(Clone, Copy)]
pub struct Brink;

impl Filippov<1> for Brink {
    fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(1.0)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        if x[0].value() < 0.25 {
            -x[0] + 0.616
        } else {
            (-x[0] + 1.0).sqrt() - 0.5
        }
    }
}

#[test]
fn a_step_into_where_the_boundary_is_not_defined_hides_no_event() {
    for first_step in [0.5, 1.5, 3.0] {
        let options = Options {
            first_step: Some(first_step),
            ..taylor(1e-12)
        };
        let failure = solve(&Brink, 0.0, State::from([0.0]), 3.0, &options).expect_err("ends at 1");
        assert!((failure.partial.t_end - 1.0).abs() < 1e-9, "{failure}");
        let times: Vec<f64> = failure.partial.transitions.iter().map(|e| e.t).collect();
        assert_eq!(times.len(), 1, "first step {first_step}: {times:?}");
        assert!((times[0] - 0.75).abs() < 1e-12, "{times:?}");
    }
}

/// A body in uniform motion, and a boundary with a dent in a power of the time that is never met.
/// Its series converges up to 1.
pub struct Dent {
    power: i32,
}

impl Filippov<1> for Dent {
    fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(0.2)]
    }

    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        x[0] + (t.powi(self.power) + 1.0).recip() * 1.2 - 1.0
    }
}

/// To the order of its series a high power is constant. The value of the boundary at the end of a
/// step shows the crossing.
#[test]
fn a_boundary_flatter_than_its_series_is_met() {
    for power in 8..=60 {
        for digits in 3..=15 {
            let tolerance = math::powi(10.0, -digits);
            let options = taylor(tolerance);
            let orbit = solve(&Dent { power }, 0.0, [0.5], 5.0, &options).expect("runs");
            let times: Vec<f64> = orbit.transitions.iter().map(|at| at.t).collect();
            assert_eq!(times.len(), 2, "{power}, {digits} digits: {times:?}");
            for t in times {
                let distance = 0.2 * t - 0.5 + 1.2 / (math::powi(t, power) + 1.0);
                assert!(
                    distance.abs() < (10.0 * tolerance).max(1e-12),
                    "{power}, {digits} digits: {distance:e} at {t}"
                );
            }
        }
    }
}

#[test]
fn a_series_with_gaps_is_not_taken_for_one_that_ends() {
    for power in 2..=7 {
        for digits in 2..=15 {
            let options = taylor(math::powi(10.0, -digits));
            let orbit = solve(&Dent { power }, 0.0, State::from([1.0]), 10.0, &options);
            let orbit = orbit.expect("runs");
            assert_eq!(orbit.transitions, [], "{power}, {digits} digits");
            assert!(
                (orbit.x_end[0] - 3.0).abs() < 1e-14,
                "{power}, {digits} digits"
            );
        }
    }
}

/// Moves at speed one, through a boundary that bends too sharply for a series from far away.
pub struct Steep {
    kind: usize,
    steepness: f64,
}

impl Steep {
    /// Positions of the boundary.
    fn places(&self) -> Vec<f64> {
        match self.kind {
            0 => vec![math::ln(1.5) / self.steepness],
            1 | 5 => vec![0.5 * math::ln(3.0) / self.steepness],
            3 | 6 => vec![],
            4 => vec![math::ln(2.0) / self.steepness],
            _ => {
                let place = (0.25 - 1.0 / self.steepness).sqrt();
                vec![-place, place]
            }
        }
    }
}

impl Filippov<1> for Steep {
    fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::one()]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        match self.kind {
            0 => (x[0] * self.steepness).exp() - 1.5,
            1 => (x[0] * self.steepness).tanh() - 0.5,
            3 => (x[0] * x[0] + 1.0 / self.steepness).sqrt() + 0.1,
            4 => ((x[0] * self.steepness).exp() - 2.0).max(x[0] - 0.3),
            5 => (x[0] * self.steepness).tanh().max(x[0]) - 0.5,
            // Its rounding error grows as a singularity of the function would allow.
            6 => {
                let y = x[0] - 1.0 / self.steepness;
                y.sin() / y + 0.5
            }
            _ => (x[0] * x[0] + 1.0 / self.steepness).sqrt() - 0.5,
        }
    }
}

#[test]
fn a_boundary_that_bends_too_sharply_for_its_series_is_met_where_it_is() {
    let steep = [0, 1, 4, 5, 6].map(|kind| (kind, [10.0, 30.0, 100.0, 300.0, 1000.0]));
    let rounded = [2, 3].map(|kind| (kind, [1e2, 1e6, 1e10, 1e20, 1e200]));
    for (kind, steepnesses) in steep.into_iter().chain(rounded) {
        for steepness in steepnesses {
            let system = Steep { kind, steepness };
            for (digits, start) in (3..=15).flat_map(|digits| [(digits, -0.9), (digits, -0.67)]) {
                let tolerance = math::powi(10.0, -digits);
                // Otherwise the bend is within the tolerance, and is a touch.
                if ![2, 3, 6].contains(&kind) && steepness * tolerance > 0.01 {
                    continue;
                }
                let orbit = solve(&system, 0.0, [start], 0.65 - start, &taylor(tolerance));
                let found = orbit.expect("runs").transitions;
                let places: Vec<f64> = found.iter().map(|at| at.t + start).collect();
                let wanted = system.places();
                let what = format!("{kind}, {steepness:e}, {digits} digits from {start}");
                assert_eq!(places.len(), wanted.len(), "{what}: {places:?}");
                for (place, wanted) in places.iter().zip(&wanted) {
                    assert!(
                        (place - wanted).abs() < 1e-2 * tolerance + 1e-15,
                        "{what}: {place}"
                    );
                }
            }
        }
    }
}

/// Oscillates to a boundary that grows steeply there, just beyond it and back.
pub struct Steepening {
    steepness: f64,
}

impl Filippov<1> for Steepening {
    fn field<T: Scalar>(&self, _side: Side, t: T, _x: &[T; 1]) -> [T; 1] {
        [t.cos()]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        (x[0] * self.steepness).exp() - 1.5
    }
}

#[test]
fn a_boundary_that_grows_steeply_within_a_step_is_met_there_and_back() {
    // Steeper ones are zero at the start in double precision.
    for steepness in [30.0, 100.0, 300.0, 600.0] {
        let beyond = 1.0 - 1.0 / steepness;
        let place = beyond + math::ln(1.5) / steepness;
        let there = math::atan(place / (1.0 - place * place).sqrt());
        for digits in 5..=15 {
            let options = taylor(math::powi(10.0, -digits));
            let orbit = solve(&Steepening { steepness }, 0.0, [-beyond], 5.0, &options);
            let times: Vec<f64> = orbit
                .expect("runs")
                .transitions
                .iter()
                .map(|at| at.t)
                .collect();
            let what = format!("{steepness}, {digits} digits: {times:?}");
            assert_eq!(times.len(), 2, "{what}");
            for (time, wanted) in times.iter().zip([there, PI - there]) {
                assert!(
                    (time - wanted).abs() < options.rtol + 1e-13,
                    "{what}: {wanted}"
                );
            }
        }
    }
}

/// Rest except for a push between 1 - 1/30 and 1 + 1/30, by the excess of `1/(1 + 100 (t - 1)²)`
/// over 0.9. Σ is far away.
pub struct Push;

impl Filippov<1> for Push {
    fn field<T: Scalar>(&self, _side: Side, t: T, _x: &[T; 1]) -> [T; 1] {
        let push = ((t - 1.0).powi(2) * 100.0 + 1.0).recip() - 0.9;
        [push.max(T::zero())]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] - 100.0
    }
}

#[test]
fn a_comparison_that_changes_there_and_back_within_a_step_is_not_passed_over() {
    let rise = 0.2 * math::atan(1.0 / 3.0) - 0.06;
    for tenth in 0..=9 {
        let start = 0.1 * f64::from(tenth) + 0.004;
        for tolerance in [1e-8, 1e-10, 1e-12] {
            let orbit = solve(&Push, start, [0.0], 5.0, &taylor(tolerance)).expect("runs");
            let error = (orbit.x_end[0] - rise).abs();
            assert!(error < tolerance, "{start}, {tolerance:e}: {error:e}");
        }
    }
}

/// An oscillator whose spring is four times as stiff above its equilibrium as below. From time 500
/// on it is pushed up with a growing force, or pulled down at once. Σ is far away.
#[derive(Clone, Copy, PartialEq)]
pub struct Bilinear {
    rest: f64,
    damping: f64,
    is_pulled: bool,
}

impl Filippov<2> for Bilinear {
    fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let above = x[0] - self.rest;
        let spring = above.max(T::zero()) * 4.0 + above.min(T::zero());
        let push = if !self.is_pulled {
            (t - 500.0).max(T::zero())
        } else if t.exceeds(T::constant(500.0)) {
            T::constant(-1.0)
        } else {
            T::zero()
        };
        [x[1], -x[1] * self.damping - spring + push]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0] - 1e6
    }
}

#[test]
fn an_oscillator_comes_to_rest_on_its_kink_and_leaves_it_again() {
    for rest in [0.0, 0.3, 1.0, -7.7, 1000.1] {
        let ulp = f64::EPSILON * f64::abs(rest);
        for tolerance in [1e-4, 1e-8, 1e-12] {
            // By half oscillations above and below, each with its own frequency.
            let damping = 0.2;
            let system = Bilinear {
                rest,
                damping,
                is_pulled: false,
            };
            let [above, below] = [4.0, 1.0].map(|k| PI / (k - 0.01f64).sqrt());
            let t_end = 12.0 * (above + below);
            let orbit = solve(&system, 0.0, [rest, 1.0], t_end, &taylor(tolerance));
            let x = orbit.expect("runs").x_end;
            let wanted = math::exp(-0.1 * t_end);
            let off = (x[1] - wanted).abs().max((x[0] - rest).abs());
            assert!(
                off < 10.0 * tolerance + 30.0 * ulp,
                "{rest}, {tolerance:e}: {off:e}"
            );

            for damping in [0.2, 1.0, 3.0, 6.0] {
                let system = Bilinear {
                    rest,
                    damping,
                    is_pulled: false,
                };
                let orbit = solve(&system, 0.0, [rest + 0.5, 0.3], 500.0, &taylor(tolerance));
                let orbit = orbit.expect("runs");
                assert!(
                    orbit.counters.steps < 10_000,
                    "{rest}, {damping}: {:?}",
                    orbit.counters
                );
                let off = (orbit.x_end[0] - rest).abs();
                assert!(off <= tolerance, "{rest}, {damping}: {off:e}");
            }

            let w = 1.75f64.sqrt();
            let (sin, cos) = math::sin_cos(w);
            let pushed = 1.0 / 16.0 + math::exp(-1.5) * (3.0 / 16.0 * cos + sin / (32.0 * w));
            let [slow, fast] = [-1.0, 1.0].map(|sign| 1.5 + sign * 1.25f64.sqrt());
            let decay = fast * math::exp(-slow) - slow * math::exp(-fast);
            let pulled = decay / (fast - slow) - 1.0;
            for (is_pulled, wanted) in [(false, pushed), (true, pulled)] {
                let system = Bilinear {
                    rest,
                    damping: 3.0,
                    is_pulled,
                };
                let orbit = solve(&system, 0.0, [rest + 0.5, 0.3], 501.0, &taylor(tolerance));
                let off = (orbit.expect("runs").x_end[0] - rest - wanted).abs();
                let allowed = tolerance * rest.abs().max(1.0);
                assert!(off < allowed, "{rest}, {tolerance:e}, {is_pulled}: {off:e}");
            }
        }
    }
}

/// Falls to zero from both sides at speed one, by a comparison; Σ is far away.
#[derive(Clone, Copy)]
pub struct Valley;

impl Filippov<1> for Valley {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 1]) -> [T; 1] {
        let is_above = x[0].exceeds(T::zero());
        [T::constant(if is_above { -1.0 } else { 1.0 })]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] - 100.0
    }
}

#[test]
fn a_boundary_that_the_field_hides_and_that_holds_the_orbit_is_reported() {
    for (start, from) in [(0.5, 1.0), (-0.25, -30.0), (0.0, 1.0), (3.0, 0.0)] {
        let failure = solve(&Valley, from, [start], 10.0, &taylor(1e-10)).expect_err("slides");
        let Error::BranchPileUp {
            count, t, ref x, ..
        } = failure.error
        else {
            panic!("{start}: {}", failure.error);
        };
        let arrival = from + f64::abs(start);
        // A hundred turns pass the tie by up to sixteen roundings of the longest step, to and fro.
        let allowed = 100.0 * 32.0 * f64::EPSILON * (10.0 - from);
        assert!((t - arrival).abs() < allowed, "{start}: {t}");
        assert!(
            x.0[0].abs() < allowed && count == 100,
            "{start}: {x} {count}"
        );
        let message = failure.error.to_string();
        assert!(message.contains("write the difference"), "{message}");
    }
}

/// A body that flies against a soft stop at `gap`, whose force increases from zero: it does not
/// stick there.
pub struct SoftStop {
    pub gap: f64,
}

impl Filippov<2> for SoftStop {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let press = (x[0] - self.gap).max(T::zero());
        [x[1], press * -10.0]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0] + 1e9
    }
}

/// Follows `|sin ωt|`, which has a kink every half period.
pub struct Rectified {
    pub omega: f64,
}

impl Filippov<1> for Rectified {
    fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 1]) -> [T; 1] {
        [((t * self.omega).sin().abs() - x[0]) * (0.1 * self.omega)]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] + 1e9
    }
}

/// Cases where the state is rounded more coarsely than it passes the kink, or where kinks follow in
/// rapid succession.
#[test]
fn kinks_of_a_field_that_goes_on_hold_no_orbit() {
    for (gap, speed) in [(5000.0, 1.0), (1e5, 1.0), (1.0, 3e-5), (1.0, 1e-6)] {
        let start = [gap - speed, speed];
        let end = solve(&SoftStop { gap }, 0.0, start, 5.0, &taylor(1e-12)).expect("passes");
        // In contact for half a period of the spring, and back at the same speed.
        assert!(
            (end.x_end[1] / speed + 1.0).abs() < 1e-6,
            "{gap} {speed}: {}",
            end.x_end
        );
    }
    for (omega, start, t_end) in [(2e9 * PI, 0.0, 1e-7), (2e3 * PI, 1e6, 1e6 + 0.2)] {
        let options = taylor(1e-10);
        solve(&Rectified { omega }, start, [0.0], t_end, &options).expect("follows");
    }
}

/// A body at rest, and a boundary that arrives at 1.03 and goes at most 0.0009 beyond it.
pub struct Cup;

impl Filippov<1> for Cup {
    fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::zero()]
    }

    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        x[0] + (t - 1.03).powi(2) - 9e-4
    }
}

/// A body in uniform motion, and a boundary whose kink at `t = 1` is far from the crossing.
pub struct Knee;

impl Filippov<1> for Knee {
    fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(1.0)]
    }

    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        x[0] * x[0] - 100.0 + (t - 1.0).max(T::zero())
    }
}

/// Beyond the kink the boundary is not compared with its series.
#[test]
fn a_kink_of_the_boundary_rejects_no_step() {
    for tolerance in [1e-4, 1e-8, 1e-12] {
        let orbit = solve(&Knee, 0.0, [0.0], 20.0, &taylor(tolerance)).expect("runs");
        // t² + t = 101.
        let met = 0.5 * (f64::sqrt(405.0) - 1.0);
        assert!((orbit.transitions[0].t - met).abs() < 1e-13);
        assert_eq!(orbit.transitions.len(), 1);
        assert_eq!(orbit.counters.rejected, 0);
    }
}

/// A rotation, and a boundary that is never met: it jumps, or is a small difference of large
/// numbers.
pub struct Turn {
    jumps: bool,
}

impl Filippov<2> for Turn {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        [-x[1], x[0]]
    }

    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        if self.jumps {
            (x[1] / x[0]).atan() + 2.0
        } else {
            (x[0] * x[0] + 1e12).sqrt() - (1e6 - 1.0)
        }
    }
}

#[test]
fn a_boundary_that_is_off_its_series_in_short_steps_too_holds_nothing_up() {
    for jumps in [false, true] {
        for digits in 3..=15 {
            let options = taylor(math::powi(10.0, -digits));
            let orbit = solve(&Turn { jumps }, 0.0, [1.0, 0.1], 20.0, &options);
            let orbit = orbit.expect("runs");
            assert_eq!(orbit.transitions, [], "{jumps}, {digits} digits");
            assert!(orbit.counters.steps < 5000, "{:?}", orbit.counters);
        }
    }
}

/// The step before the last may end between the two zeros, with the end time before the turning
/// point.
#[test]
fn a_run_ends_at_its_end_time_while_a_touch_lasts() {
    for method in [Method::Taylor, Method::Dop853] {
        let mut touches = 0;
        for thousandth in 0..50 {
            let t_end = 0.99 + 0.001 * f64::from(thousandth);
            for parts in 2..400 {
                let options = Options {
                    first_step: Some(t_end / f64::from(parts)),
                    ..Options::tol(1e-3).method(method)
                };
                let orbit = solve(&Cup, 0.0, [0.0], t_end, &options).expect("runs");
                assert_eq!((orbit.t_end, orbit.x_end), (t_end, State::from([0.0])));
                touches += orbit.transitions.len();
                assert!(
                    orbit
                        .transitions
                        .iter()
                        .all(|touch| touch.kind == TransitionKind::Touch && touch.t <= t_end),
                    "{method:?} {t_end} {parts}: {:?}",
                    orbit.transitions
                );
            }
        }
        assert!(touches > 1000, "{method:?}: {touches}");
    }
}
