//! Ends of a run: the motion between events decides them, and never their number.

use std::f64::consts::PI;

use stickslip::{Ending, Error, Filippov, Method, Options, Orbit, Scalar, Side, math};

use crate::any_system::solve;

fn methods(tolerance: f64) -> [Options; 2] {
    let options = Options::tol(tolerance);
    [options, options.method(Method::Taylor)]
}

/// Systems of one state.
#[derive(Clone, Copy)]
pub enum Line {
    /// `v' = sin t - 0.8 sgn v`.
    Driven,
    /// A half-wave rectifier of 50 Hz with an inductance; the diode holds the current at zero.
    Rectifier,
    /// `x' = -x (1 ± 1/2)`, switched by a clock.
    Clocked,
    /// `x' = -x^power (1 + slope x)`.
    Torricelli { power: f64, slope: f64 },
    /// `x' = x²`.
    Pole,
    /// `x' = -rate x`.
    Decay { rate: f64 },
}

impl Filippov<1> for Line {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 1]) -> [T; 1] {
        let [x] = *x;
        [match *self {
            Line::Driven => t.sin() - 0.8 * side.sign(),
            Line::Rectifier => {
                let diode = if side == Side::Below { 650.0 } else { 0.0 };
                ((t * (100.0 * PI)).sin() * 325.0 - x * 10.0 + diode) * 20.0
            }
            Line::Clocked => -x * (1.0 + 0.5 * side.sign()),
            Line::Torricelli { power, slope } => -x.powf(power) * (x * slope + 1.0),
            Line::Pole => x * x,
            Line::Decay { rate } => -x * rate,
        }]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        match self {
            Line::Driven | Line::Rectifier => x[0],
            Line::Clocked => t.sin(),
            _ => x[0] - 1e3,
        }
    }
}

/// Systems of two states.
#[derive(Clone, Copy)]
pub enum Plane {
    /// A stable focus on the boundary, which is driven by `push max(t - 380, 0)`.
    Focus { push: f64 },
    /// A block on a belt that moves by the positive half waves of a sine and rests in between.
    RestingBelt { half_period: f64, limit: f64 },
}

impl Filippov<2> for Plane {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        match *self {
            Plane::Focus { push } => {
                let (stiffness, damping) = match side {
                    Side::Below => (1.2, 0.2),
                    Side::Above => (1.05, 0.05),
                };
                let drive = (t - 380.0).max(T::zero()) * push;
                [x[1], drive - x[0] * stiffness - x[1] * damping]
            }
            Plane::RestingBelt { limit, .. } => [x[1], -x[0] - limit * side.sign()],
        }
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        match *self {
            Plane::Focus { .. } => x[0] - x[1] * 0.3,
            Plane::RestingBelt { half_period, .. } => {
                x[1] - (t * (PI / half_period)).sin().max(T::zero())
            }
        }
    }
}

#[test]
fn driven_dry_friction_goes_on_for_ever() {
    // Slip begins where the drive exceeds friction, and is fastest where it falls below it again.
    let begin = 0.5 * PI - math::acos(0.8);
    let fastest = PI - begin;
    let speed = 1.2 - 0.8 * (PI - 2.0 * begin);
    assert!((speed - 0.17040).abs() < 1e-5, "{speed}");
    for options in methods(1e-10) {
        let orbit = solve(&Line::Driven, 0.0, [0.0], 1000.0, &options).unwrap();
        assert_eq!(orbit.ending, Ending::EndTime);
        let half_waves = (0..).map(f64::from).take_while(|k| begin + k * PI < 1000.0);
        for (k, exit) in half_waves.zip(orbit.transitions.iter().step_by(2)) {
            assert!((exit.t - begin - k * PI).abs() < 1e-8, "{k}: {}", exit.t);
            let sign = if k % 2.0 == 0.0 { 1.0 } else { -1.0 };
            let there = fastest + k * PI;
            if there < 1000.0 {
                let off = orbit.at(there).unwrap()[0] - sign * speed;
                assert!(off.abs() < 1e-8, "{k}: {off:e}");
            }
        }
        assert!(orbit.transitions.len() > 630, "{}", orbit.transitions.len());
    }
}

#[test]
fn a_rectifier_repeats_its_periods_for_ever() {
    for options in methods(1e-10) {
        let orbit = solve(&Line::Rectifier, 0.0, [0.0], 4.0, &options).unwrap();
        assert_eq!(orbit.ending, Ending::EndTime);
        for part in [0.003, 0.009, 0.012] {
            let at = |period: f64| orbit.at(0.02 * period + part).unwrap()[0];
            let (first, last) = (at(0.0), at(199.0));
            assert!(first > 1.0 && (first - last).abs() < 1e-7, "{first} {last}");
        }
    }
}

#[test]
fn a_clock_switches_what_rests_without_end() {
    for options in methods(1e-10) {
        for start in [1.0, 0.0] {
            let orbit = solve(&Line::Clocked, 1.0, [start], 2000.0, &options).unwrap();
            assert_eq!((orbit.ending, orbit.t_end), (Ending::EndTime, 2000.0));
            assert_eq!(orbit.transitions.len(), 636);
        }
    }
}

#[test]
fn a_focus_on_the_boundary_ends_the_run_unless_it_is_driven_later() {
    for options in methods(1e-10) {
        let run = |push: f64, t_end: f64| -> Orbit<2> {
            solve(&Plane::Focus { push }, 0.0, [0.3, 0.0], t_end, &options).unwrap()
        };
        // Errors of Runge-Kutta steps keep a motion below the tolerance alive, whose crossings are
        // touches.
        let orbit = run(0.0, 1e4);
        let ending = match options.method {
            Method::Taylor => Ending::Shrunk,
            _ => Ending::EndTime,
        };
        assert_eq!(orbit.ending, ending);
        assert!(orbit.x_end.amax() < 1e-8, "{:?}", orbit.x_end);
        let orbit = run(1.0, 480.0);
        assert_eq!(orbit.ending, Ending::EndTime);
        // It follows the drive beyond the boundary.
        assert!(orbit.x_end[0] > 80.0, "{:?}", orbit.x_end);
    }
}

#[test]
fn a_belt_that_rests_between_its_moves_is_followed_over_all_its_kinks() {
    // Also where the run ends at a kink.
    let late = [6500.0, 7999.0, 10_000.0, 20_000.0].map(|t_end| (1e-12, t_end));
    let fine = (11..=50).map(|tenth| (1e-14, 10.0 * f64::from(tenth)));
    for (tolerance, t_end) in late.into_iter().chain(fine) {
        for options in methods(tolerance) {
            let belt = Plane::RestingBelt {
                half_period: 5.0,
                limit: 3.0,
            };
            let orbit = solve(&belt, 0.0, [0.0; 2], t_end, &options)
                .unwrap_or_else(|failure| panic!("{options:?}: {}", failure.error));
            assert_eq!(orbit.ending, Ending::EndTime);
        }
    }
}

#[test]
fn a_time_that_is_too_coarse_and_a_step_that_is_too_small_are_named() {
    for options in methods(1e-10) {
        let error = |line: Line, t0: f64, options: &Options| {
            solve(&line, t0, [1.0], t0 + 3.0, options)
                .unwrap_err()
                .error
        };
        let coarse = error(Line::Decay { rate: 1e5 }, 1e12, &options);
        assert!(
            matches!(coarse, Error::TimeRounding { t: 1e12, bound: None, rounding, .. }
                if rounding > 8e-4 && rounding < 9e-4),
            "{coarse}"
        );
        let small = error(Line::Decay { rate: 1.0 }, 1.0, &options.longest_step(1e-17));
        assert!(
            matches!(
                small,
                Error::TimeRounding {
                    step: 1e-17,
                    bound: Some("longest_step"),
                    ..
                }
            ),
            "{small}"
        );
        let words = small.to_string();
        assert!(
            words.contains("1e-17") && words.contains("raise longest_step"),
            "{words}"
        );
        // A singularity stays one.
        for t0 in [0.0, 1e6] {
            let pole = error(Line::Pole, t0, &options);
            assert!(matches!(pole, Error::StepCollapse { .. }), "{pole}");
        }
    }
}

#[test]
fn a_field_that_is_not_lipschitz_ends_the_run_where_the_orbit_meets_that() {
    for (power, slope, end) in [
        (0.5, 0.0, 2.0),
        (0.5, 1.0, 0.5 * PI),
        (1.0 / 3.0, 0.0, 1.5),
        (2.0 / 3.0, 0.0, 3.0),
        (0.75, 0.0, 4.0),
        (0.9, 0.0, 10.0),
    ] {
        for options in [1e-8, 1e-10, 1e-12].into_iter().flat_map(methods) {
            let line = Line::Torricelli { power, slope };
            let what = format!("{power} {slope} {options:?}");
            let failure = solve(&line, 0.0, [1.0], 50.0, &options).unwrap_err();
            let Error::NotLipschitz { t, ref x } = failure.error else {
                panic!("{what}: {}", failure.error);
            };
            // The time that the last tolerance of the way takes.
            let last = math::pow(options.atol.largest(), 1.0 - power) / (1.0 - power);
            assert!((t - end).abs() < 10.0 * last, "{what}: {t}");
            assert!(x.0[0].abs() < options.atol.largest(), "{what}: {x}");
            let counters = failure.partial.counters;
            assert!(counters.steps < 300, "{what}: {counters:?}");
        }
    }
}

/// Whether a field that only turns fast is taken for one that holds the orbit.
#[derive(Clone, Copy)]
pub struct Wave;

impl Filippov<1> for Wave {
    fn field<T: Scalar>(&self, _side: Side, t: T, _x: &[T; 1]) -> [T; 1] {
        let is_up = (t * (1e9 * PI)).sin().exceeds(T::zero());
        [T::constant(if is_up { 1.0 } else { -1.0 })]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0] - 100.0
    }
}

#[test]
fn a_field_that_turns_fast_is_followed() {
    let options = Options::tol(1e-12).method(Method::Taylor);
    let orbit = solve(&Wave, 0.0, [0.5], 1e-6, &options).unwrap();
    assert_eq!(orbit.ending, Ending::EndTime);
    assert!((orbit.x_end[0] - 0.5).abs() < 1e-12, "{:?}", orbit.x_end);
}
