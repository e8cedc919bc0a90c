//! The Taylor stepper beyond what every stepper is tested for: exact to the last digits, nothing missed, kinks, memory.

use std::f64::consts::PI;

use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum};
use stickslip::models::{BeltOscillator, BlockAndBracket, Caption, ForcedOscillator, Reading};
use stickslip::{
    Error, Filippov, Method, Options, Orbit, Scalar, Side, State, TransitionKind, math, run, solve,
};

fn taylor(tolerance: f64) -> Options {
    Options::tol(tolerance).method(Method::Taylor)
}

const TIGHTEST: f64 = 1e-15;

/// Events of a problem of data/references/belt.csv: kind, time, position.
fn reference(problem: &str) -> Vec<(String, f64, f64)> {
    let table = include_str!("../data/references/belt.csv");
    let rows = table.lines().skip(1).map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields[i].parse().expect("a number");
        (fields[0], fields[1].to_owned(), number(2), number(3))
    });
    rows.filter(|row| row.0 == problem)
        .map(|row| (row.1, row.2, row.3))
        .collect()
}

/// Largest error of the times of an orbit's transitions.
fn worst_time(orbit: &Orbit<2>, problem: &str) -> f64 {
    let exact = reference(problem);
    assert_eq!(orbit.transitions.len(), exact.len());
    let mut worst = 0.0f64;
    for (found, (kind, t, x)) in orbit.transitions.iter().zip(&exact) {
        assert_eq!(format!("{:?}", found.kind), *kind);
        assert!((found.x[0] - x).abs() < 1e-11);
        worst = worst.max((found.t - t).abs());
    }
    worst
}

#[test]
fn events_of_orbits_that_forget_errors_are_exact_to_1e_14() {
    let decaying = BeltOscillator {
        k1: -1.0,
        k2: 0.0,
        mu0: 1.0,
        belt_speed: 0.2,
        ..BeltOscillator::default()
    };
    let start = State::from([0.04, -0.01]);
    let orbit = solve(&decaying, 0.0, start, 40.0, &taylor(TIGHTEST)).expect("runs");
    let worst = worst_time(&orbit, "decaying");
    assert!(worst <= 1e-14, "{worst}");
}

#[test]
fn events_of_an_orbit_that_enlarges_errors_by_thousands_are_exact_to_5e_13() {
    let belt = BeltOscillator {
        belt_speed: 0.4,
        ..BeltOscillator::default()
    };
    let start = State::from([0.5, 1.5]);
    let orbit = solve(&belt, 0.0, start, 30.0, &taylor(TIGHTEST)).expect("runs");
    let worst = worst_time(&orbit, "belt");
    assert!(worst <= 5e-13, "{worst}");
}

/// `x'' = -x - 0.4 sgn x'`.
struct Floor;

impl Filippov<2> for Floor {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        State::from([x[1], -x[0] - 0.4 * side.sign()])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T {
        x[1]
    }
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

/// A spiral of the given growth and frequency under a ceiling.
struct Ceiling {
    growth: f64,
    frequency: f64,
    level: f64,
}

impl Filippov<2> for Ceiling {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        let (g, w) = (self.growth, self.frequency);
        State::from([x[0] * g + x[1] * w, x[1] * g - x[0] * w])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T {
        x[0] - self.level
    }
}

/// A sequence of numbers in [0, 1) from a fixed seed (SplitMix64).
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Counts crossings.
#[derive(Default)]
struct Crossings(Vec<f64>);

impl stickslip::Observer<2> for Crossings {
    fn transition(&mut self, at: &stickslip::Transition<2>) -> std::ops::ControlFlow<()> {
        assert_ne!(at.kind, TransitionKind::Touch, "{at:?}");
        self.0.push(at.t);
        std::ops::ControlFlow::Continue(())
    }
}

#[test]
fn no_graze_of_a_hundred_thousand_is_missed() {
    let mut draw = Draw(2013);
    let mut pairs = 0;
    for case in 0..100_000 {
        // x₁ = r e^{gt} cos(wt + a) has its tops where tan(wt + a) = g/w. One of them, at the time `top`, is beyond the ceiling
        // by `gap` or below it by as much; growth makes every later one higher, decay every earlier one.
        let growth = draw.between(-0.2, 0.2);
        let frequency = draw.between(0.5, 3.0);
        let top = draw.between(0.2, 4.0);
        let size = math::exp(draw.between(-2.0, 2.0));
        let gap = size
            * math::pow(10.0, draw.between(-11.0, -1.5))
            * if case % 2 == 0 { 1.0 } else { -1.0 };
        let phase = math::atan2(growth, frequency);
        let height = size * math::cos(phase);
        let at = |t: f64| {
            let angle = frequency * (t - top) + phase;
            let radius = size * math::exp(growth * (t - top));
            State::from([radius * math::cos(angle), -radius * math::sin(angle)])
        };
        let system = Ceiling {
            growth,
            frequency,
            level: height - gap,
        };
        // From half a turn before the top to half a turn behind it, so that it is the only one.
        let half = 0.999 * PI / frequency;
        let mut found = Crossings::default();
        let start = at(top - half);
        run(
            &system,
            top - half,
            start,
            top + half,
            &taylor(1e-13),
            &mut found,
        )
        .expect("runs");
        let expected = if gap > 0.0 { 2 } else { 0 };
        assert_eq!(
            found.0.len(),
            expected,
            "case {case}, gap {gap}, growth {growth}: {:?}",
            found.0
        );
        if let [first, second] = found.0[..] {
            assert!(first < top && top < second, "case {case}");
            pairs += 1;
        }
    }
    assert_eq!(pairs, 50_000);
}

fn fig11() -> BlockAndBracket {
    BlockAndBracket::from_caption(&Caption::FIG11, &Reading::exact()).expect("allowed")
}

#[test]
fn a_normal_force_that_is_clipped_ends_steps_where_it_is() {
    // Unloaded until contact is lost in every turn.
    let model = BlockAndBracket {
        unloading: 3.0,
        ..fig11()
    };
    let start = State::from([0.1, 0.1, 0.1, 0.1]);
    let by_series = solve(&model, 0.0, start, 60.0, &taylor(1e-14)).expect("runs");
    let by_slopes = solve(&model, 0.0, start, 60.0, &Options::tol(1e-14)).expect("runs");
    let kinds = |orbit: &Orbit<4>| orbit.transitions.iter().map(|e| e.kind).collect::<Vec<_>>();
    assert_eq!(kinds(&by_series), kinds(&by_slopes));
    let lost = kinds(&by_series)
        .iter()
        .filter(|k| **k == TransitionKind::ContactLoss)
        .count();
    assert!(lost > 2, "{lost}");
    for (one, other) in by_series.transitions.iter().zip(&by_slopes.transitions) {
        assert!((one.t - other.t).abs() < 1e-9, "{} {}", one.t, other.t);
    }
}

/// `x' = 1` and `y' = max(x, 0)` or `|x|`, by a comparison or by reading the value.
struct Kink {
    by_value: bool,
}

impl Filippov<2> for Kink {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        let slope = if self.by_value {
            if x[0].value() > 0.0 {
                x[0]
            } else {
                T::constant(0.0)
            }
        } else {
            x[0].max(T::constant(0.0))
        };
        State::from([T::constant(1.0), slope])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T {
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
            // Seen by a comparison, the kink costs nothing; by the field's value, as much as the tolerance leaves open.
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
    let belt = BeltOscillator {
        belt_speed: 0.2,
        mu0: 0.5,
        ..BeltOscillator::default()
    };
    let count = |t_end: f64| {
        let info = allocation_counter::measure(|| {
            let start = State::from([0.1, 0.2]);
            run(&belt, 0.0, start, t_end, &taylor(1e-12), &mut ()).expect("runs");
        });
        info.count_total
    };
    assert_eq!(count(100.0), count(1000.0));
}

#[test]
fn tangent_vectors_travel_along_taylor_steps() {
    let belt = BeltOscillator {
        belt_speed: 0.2,
        ..BeltOscillator::default()
    };
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
fn the_forced_oscillator_is_the_same_by_series_and_by_slopes() {
    let model = ForcedOscillator::default();
    let start = State::from([0.1, 0.2]);
    let end = |options: &Options| solve(&model, 0.0, start, 5.0, options).map(|orbit| orbit.x_end);
    let (one, other) = (end(&taylor(1e-13)), end(&Options::tol(1e-13)));
    let difference = one.expect("runs") - other.expect("runs");
    assert!(difference.amax() < 1e-10, "{difference}");
}

#[test]
fn a_field_that_is_not_a_number_is_told_so() {
    struct Nowhere;
    impl Filippov<1> for Nowhere {
        fn field<T: Scalar>(&self, _side: Side, t: T, x: &State<T, 1>) -> State<T, 1> {
            State::from([Scalar::ln(-t + 1.0) * x[0] + 1.0])
        }
        fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 1>) -> T {
            x[0] + 100.0
        }
    }
    let failure =
        solve(&Nowhere, 0.0, State::from([0.5]), 2.0, &taylor(1e-12)).expect_err("ends at 1");
    let (Error::StepCollapse { t, .. } | Error::NonFinite { t, .. }) = failure.error else {
        panic!("{}", failure.error);
    };
    assert!((t - 1.0).abs() < 1e-6, "{t}");
}

/// `x' = speed` and `y' = max(x, 0)`.
struct Ramp {
    speed: f64,
}

impl Filippov<2> for Ramp {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        State::from([T::constant(self.speed), x[0].max(T::constant(0.0))])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T {
        x[1] - 100.0
    }
}

#[test]
fn a_kink_at_the_very_start_or_throughout_holds_nothing_up() {
    // Downwards from the kink at time zero; and on it for ever.
    for (speed, x) in [(-1.0, -3.0), (0.0, 0.0)] {
        let orbit = solve(
            &Ramp { speed },
            0.0,
            State::from([0.0, 0.0]),
            3.0,
            &taylor(1e-12),
        )
        .expect("runs");
        // The ramp is left a few units of rounding behind its foot.
        assert!(orbit.x_end[1].abs() < 1e-30);
        assert!((orbit.x_end[0] - x).abs() < 1e-14);
        assert!(orbit.steps.len() < 20, "{}", orbit.steps.len());
    }
}
