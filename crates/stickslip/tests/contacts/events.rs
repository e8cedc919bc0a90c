//! User-defined events and a Poincaré map with several contacts: circles in closed form.

use std::f64::consts::PI;

use stickslip::Direction::{Falling, Rising};
use stickslip::analysis::PoincareMap;
use stickslip::{EventFunctions, Method, Mode, Options, Scalar, Several, Side, math};

use crate::rig::Rig;

/// The first body passes 1.
struct Level;

impl EventFunctions<6> for Level {
    fn value<T: Scalar>(&self, _number: usize, _t: T, x: &[T; 6]) -> T {
        x[0] - 1.0
    }
}

#[test]
fn events_and_sections_are_those_of_the_body_that_moves() {
    // The first of three bodies is a block on the floor with friction 0.4. The others are held in
    // place.
    let mut rig = Rig::<3>::at_rest();
    rig.spring(1.0, 0, None);
    rig.friction[0] = 0.4;
    // From 3 at rest its circles have radii 2.6, 1.8, 1 and 0.2 about ±0.4, half a turn each. Then
    // it rests at -0.2.
    let start = [3.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let passes = [
        (math::acos(0.6 / 2.6), Falling),
        (PI + math::acos(-1.4 / 1.8), Rising),
        (2.0 * PI + math::acos(0.6), Falling),
    ];
    let system = Several(rig);
    for options in [
        Options::tol(1e-14),
        Options::tol(1e-14).method(Method::Taylor),
    ] {
        let found =
            stickslip::solve_with_events(&system, &Level, 0.0, start, 20.0, &options).unwrap();
        assert_eq!(found.events.len(), 3);
        for (event, (t, direction)) in found.events.iter().zip(passes) {
            assert!((event.t - t).abs() < 1e-12, "{} {t}", event.t);
            assert_eq!(event.direction, direction);
            let side = if direction == Rising {
                Side::Above
            } else {
                Side::Below
            };
            assert_eq!(event.mode, [Mode::Slip(side), Mode::Stick, Mode::Stick]);
        }
        let mut map = PoincareMap::new(&system, &Level, (0.0, start), 20.0, &options).unwrap();
        let (first, derivative) = map.step_with_derivative().unwrap();
        assert!((first.t - passes[0].0).abs() < 1e-12);
        // v² = r² - 0.36 with r = x₀ - 0.4 and x₀ the start.
        let by_start = 2.6 / first.x[3];
        assert!(
            (derivative[(3, 0)] - by_start).abs() < 1e-11,
            "{derivative}"
        );
        assert!(derivative.row(0).amax() < 1e-14);
    }
}
