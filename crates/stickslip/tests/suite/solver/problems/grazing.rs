//! Orbits that cross Σ by a gap of 1e-2 down to 1e-10, just touch it, or just miss it, anywhere in
//! a step.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use stickslip::TransitionKind::{Crossing, Touch};
use stickslip::{Locator, Mode, Options, Orbit, Side, State, math};

use super::super::check::{TIGHT, assert_consistent, kinds};
use crate::any_system::solve;
use crate::solver::systems::{Ceiling, Parabola};

const GAPS: [f64; 5] = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10];

pub fn parabola(level: f64, x0: f64, t_end: f64, options: &Options) -> Orbit<2> {
    let system = Parabola { level };
    let orbit = solve(&system, 0.0, State::from([x0, x0 * x0]), t_end, options).expect("runs");
    assert_consistent(&system, &orbit);
    orbit
}

pub fn assert_two_crossings(orbit: &Orbit<2>, x0: f64, gap: f64, locator: Locator) {
    assert_eq!(
        kinds(orbit),
        [Crossing, Crossing],
        "gap {gap} from {x0}: {:?}",
        orbit.transitions
    );
    // Each step leaves a rounding error of a few units in the last place of y <= x0² + (end)². The
    // slope there, 2 √gap, divides it.
    if locator == Locator::Henon {
        return;
    }
    let reach = orbit.t_end.max(x0 * x0);
    let allowed = 40.0 * f64::EPSILON * reach * reach / gap.sqrt() + 1e-14;
    for (crossing, exact) in orbit.transitions.iter().zip([-gap.sqrt(), gap.sqrt()]) {
        let error = (crossing.x[0] - exact).abs();
        assert!(
            error < allowed,
            "gap {gap} from {x0}: off by {error}, allowed {allowed}"
        );
    }
}

fn seeded(cases: u32) -> Config {
    Config {
        cases,
        rng_seed: RngSeed::Fixed(1982),
        failure_persistence: None,
        ..Config::default()
    }
}

proptest! {
    #![proptest_config(seeded(400))]

    #[test]
    fn no_graze_is_missed_wherever_it_falls_in_a_step(
        x0 in -3.0..-0.2f64, first in 0.01..5.0f64, longest in 0.05..8.0f64,
        locator in prop::sample::select(super::super::LOCATORS),
    ) {
        let tight = super::super::tol(TIGHT);
        let options = Options { first_step: Some(first), longest_step: longest, ..tight }
            .locator(locator);
        for gap in GAPS {
            assert_two_crossings(&parabola(gap, x0, 4.0, &options), x0, gap, locator);
            // A level below the parabola's minimum is not met.
            prop_assert_eq!(kinds(&parabola(-gap, x0, 4.0, &options)), []);
        }
        let at_rest = kinds(&parabola(0.0, x0, 4.0, &options));
        prop_assert!(at_rest.is_empty() || at_rest == [Touch], "{:?}", at_rest);
    }
}

#[test]
fn a_circle_pokes_through_the_ceiling_twice_each_turn() {
    for gap in [1e-2, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10] {
        for k in 0..12 {
            let system = Ceiling { gap };
            let phase = 0.4 + 0.45 * f64::from(k);
            let start = State::from([math::cos(phase), -math::sin(phase)]);
            let options = super::super::tol(TIGHT)
                .locator(super::super::LOCATORS[k as usize % super::super::LOCATORS.len()]);
            let turns = 40;
            let t_end = 2.0 * std::f64::consts::PI * f64::from(turns);
            let orbit = solve(&system, 0.0, start, t_end, &options).expect("runs");
            assert_consistent(&system, &orbit);
            assert_eq!(
                kinds(&orbit),
                vec![Crossing; 2 * turns as usize],
                "gap {gap}, phase {phase}"
            );
            let half_width = math::acos(1.0 - gap);
            let mut worst = 0.0f64;
            for above in orbit
                .phases
                .iter()
                .filter(|p| p.mode == Mode::Slip(Side::Above))
            {
                worst = worst.max((above.duration() / (2.0 * half_width) - 1.0).abs());
            }
            // The radius drifts by a few 1e-13 over the turns, a fraction of the gap, which the
            // square root halves.
            if options.locator == Locator::Henon {
                continue;
            }
            assert!(worst * 2.0 * gap < 5e-12, "gap {gap}: {worst}");
        }
    }
}

#[test]
fn a_circle_just_under_the_ceiling_never_touches_it() {
    for gap in [-1e-2, -1e-6, -1e-10] {
        let system = Ceiling { gap };
        for k in 0..12 {
            let phase = 0.4 + 0.45 * f64::from(k);
            let start = State::from([math::cos(phase), -math::sin(phase)]);
            let orbit = solve(&system, 0.0, start, 250.0, &super::super::tol(TIGHT)).expect("runs");
            assert_eq!(kinds(&orbit), [], "gap {gap}");
        }
    }
}
