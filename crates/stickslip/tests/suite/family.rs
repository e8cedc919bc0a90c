//! Families: one definition serves runs, branches and derivatives.

use std::f64::consts::PI;

use stickslip::analysis::{
    ContinuationSettings, OrbitDerivatives, Stop, Variable, continue_periodic_orbit,
};
use stickslip::dynamics::{AsDynamics, DynamicsRef, Moment, OrbitProgress, Vector};
use stickslip::{Error, Family, Method, Options, Scalar, Side, math, run};

/// Den Hartog's oscillator, `x'' = cos wt - x - S sgn x'`, with the constants `w` and `S`.
struct Driven;

impl Family<2, 2> for Driven {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2], &[w, s]: &[T; 2]) -> [T; 2] {
        [x[1], (w * t).cos() - x[0] - s * side.sign()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2], _c: &[T; 2]) -> T {
        x[1]
    }
    fn period<T: Scalar>(&self, &[w, _]: &[T; 2]) -> Option<T> {
        Some(T::constant(2.0 * PI) / w)
    }
}

/// Friction that falls with the slip speed and is larger at rest, on a belt; the load of a contact
/// that is lost multiplies the constants.
struct Belt;

impl Family<2, 3> for Belt {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2], c: &[T; 3]) -> [T; 2] {
        let slip = (x[1] - c[0]) * side.sign();
        [x[1], -x[0] / c[2] - c[1] * side.sign() / (slip + 1.0)]
    }
    fn holding<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2], c: &[T; 3]) -> [T; 2] {
        [x[1], -x[0] / c[2] - c[1] * 1.2 * side.sign()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2], c: &[T; 3]) -> T {
        (x[1] - c[0]) * c[2]
    }
}

/// Times and states at all reports of a run from time 0, of which the first `states` count.
fn reports(system: &DynamicsRef<'_>, x: &[f64], options: &Options) -> Vec<(f64, [f64; 2])> {
    let x = Vector::from_column_slice(x);
    let mut run = system
        .begin(&Moment { t: 0.0, x }, 40.0, options, &[])
        .unwrap();
    let mut reports = Vec::new();
    while !matches!(run.step().unwrap(), OrbitProgress::End(_)) {
        reports.push((run.t(), [run.x()[0], run.x()[1]]));
    }
    reports
}

#[test]
fn an_orbit_beside_free_constants_has_the_bits_of_the_orbit_alone() {
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-11).method(method);
        let (belt, driven) = (Belt.at([0.3, 0.7, 1.3]), Driven.at([0.7, 0.2]));
        for (alone, free, c) in [
            (belt.dynamics(), belt.free([2]), vec![1.3]),
            (belt.dynamics(), belt.free([0, 1, 2]), vec![0.3, 0.7, 1.3]),
            (driven.dynamics(), driven.free([0]), vec![0.7]),
            (driven.dynamics(), driven.free([1, 0]), vec![0.2, 0.7]),
        ] {
            let alone = reports(&alone, &[0.1, 0.5], &options);
            let within = [vec![0.1, 0.5], c].concat();
            assert_eq!(alone, reports(&free.unwrap(), &within, &options));
            assert!(alone.len() > 20, "{}", alone.len());
        }
    }
}

/// The restriction to a drive of constant period is none of the equations.
#[test]
fn a_branch_follows_the_period_of_its_drive() {
    let amplitude = |w: f64, s: f64| {
        let (v, half) = (1.0 / (1.0 - w * w), PI / w);
        let u = math::sin(half) / (w * (1.0 + math::cos(half)));
        (v * v - s * s * u * u).sqrt()
    };
    let (system, options) = (Driven.at([0.8, 0.2]), Options::tol(1e-12));
    let period = 2.0 * PI / 0.8;
    let settled = run(&system, 0.0, [0.0, 0.0], 60.0 * period, &options, &mut ()).unwrap();
    let start = [settled.x[0], settled.x[1], 0.8];
    let settings = ContinuationSettings::over(0.6, 0.95).forced(period);
    let along = system.free([0]).unwrap();
    for upwards in [true, false] {
        let found = continue_periodic_orbit(&along, start, period, upwards, &settings, &options);
        let found = found.unwrap();
        assert_eq!(found.stop, Stop::Range);
        assert!(found.points.len() > 10 && found.special.is_empty());
        for point in &found.points {
            let w = point.parameter;
            assert!((point.period - 2.0 * PI / w).abs() < 1e-13);
            // The orbit turns back at its amplitude.
            let mut highest = 0.0_f64;
            let mut orbit = along
                .begin(
                    &Moment {
                        t: point.t,
                        x: point.x.clone(),
                    },
                    point.t + point.period,
                    &options,
                    &[],
                )
                .unwrap();
            while !matches!(orbit.step().unwrap(), OrbitProgress::End(_)) {
                highest = highest.max(orbit.x()[0]);
            }
            let off = (highest - amplitude(w, 0.2)).abs();
            assert!(off < 1e-9, "w = {w}: {off:e}");
        }
    }
}

#[test]
fn derivatives_by_a_free_constant_are_those_of_differences() {
    let (options, end) = (Options::tol(1e-13), 3.0);
    let at = |w: f64| {
        run(
            &Driven.at([w, 0.2]),
            0.0,
            [0.1, 0.5],
            end,
            &options,
            &mut (),
        )
        .unwrap()
        .x
    };
    let along = Driven.at([0.7, 0.2]).free([0]).unwrap();
    let (by, times) = ([Variable::Start(2)], [end]);
    let start = [0.1, 0.5, 0.7];
    let found =
        OrbitDerivatives::of(&along, 0.0, start, end, (&by, &times), &[], &options).unwrap();
    let difference = (at(0.7 + 1e-5) - at(0.7 - 1e-5)) / 2e-5;
    for (i, slope) in difference.iter().enumerate() {
        assert!((found.states[0][(i, 0)] - slope).abs() < 1e-8);
    }
}

#[test]
fn constants_that_do_not_exist_or_occur_twice_are_not_free() {
    for numbers in [[0, 2], [1, 1]] {
        let error = Driven.at([0.7, 0.2]).free(numbers).err();
        assert!(matches!(error, Some(Error::Parameter { .. })), "{error:?}");
    }
}
