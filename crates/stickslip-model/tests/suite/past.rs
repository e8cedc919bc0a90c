//! Reversed time, and slides without a past.

use stickslip::Options;
use stickslip::dynamics::{Moment, OrbitProgress, Vector};
use stickslip::math;
use stickslip_model::file::System;
use stickslip_model::study::past::{PastWatch, check};

use super::run::system as read;

/// A block on a belt of speed 0.2: constant friction 0.3, and 0.5 in stick if that is `held`.
fn block(held: bool) -> System {
    let law = if held { "static = 0.5\n" } else { "" };
    read(&format!(
        "name = \"block\"\n[states]\nx = \"\"\nv = \"\"\n[contacts.belt]\nboundary = \"v - 0.2\"\n\
         friction = 0.3\n{law}[field]\nx = \"v\"\nv = \"-x - friction(belt)\"\n"
    ))
}

/// Time at which the past of a state ends: `None` at the time `t_end`, which is earlier.
fn past(system: &System, (t, x): (f64, [f64; 2]), t_end: f64) -> Option<f64> {
    let (reversed, options) = (system.reversed().unwrap(), Options::tol(1e-12));
    let watch = PastWatch::new(&reversed, &options);
    let x = Vector::from_column_slice(&x);
    let at = Moment { t: -t, x };
    if watch.start(&at).is_some() {
        return Some(t);
    }
    let mut orbit = reversed
        .dynamics()
        .begin(&at, -t_end, &options, &[])
        .unwrap();
    loop {
        let slide = match orbit.step().unwrap() {
            OrbitProgress::Step => watch.step(&mut *orbit).map(|(at, _)| at.t),
            OrbitProgress::Transition(at) => watch.transition(&at).map(|_| at.t),
            OrbitProgress::End(_) => return None,
            _ => None,
        };
        if let Some(slide) = slide {
            return Some(-slide);
        }
    }
}

#[test]
fn time_in_formulas_and_rates_is_reversed() {
    // x = sin t, so that x at -t is that at t.
    let drive = read(
        "name = \"drive\"\n[states]\nx = \"\"\n[definitions]\nrate = \"cos(t)\"\n\
         [field]\nx = \"rate\"\n",
    );
    let reversed = drive.reversed().unwrap();
    let x = Vector::from_element(1, math::sin(2.0));
    let at = Moment { t: -2.0, x };
    let dynamics = reversed.dynamics();
    let mut orbit = dynamics.begin(&at, 1.5, &Options::tol(1e-13), &[]).unwrap();
    let end = loop {
        if let OrbitProgress::End(end) = orbit.step().unwrap() {
            break end;
        }
    };
    assert!((end.x[0] - math::sin(-1.5)).abs() < 1e-12);
    assert!(!reversed.reversed().unwrap().file.is_reversed);
}

#[test]
fn the_past_ends_at_the_slide_and_nowhere_before() {
    // It slides to x = 0.3 and leaves there: x = 0.3 + 0.2 sin t, v = 0.2 cos t. At t = 2 pi it
    // touches the boundary again.
    let later = |t: f64| (t, [0.3 + 0.2 * math::sin(t), 0.2 * math::cos(t)]);
    for t in [0.3, 1.0, 3.0, 6.0] {
        let ends = past(&block(false), later(t), -5.0).unwrap();
        assert!(ends.abs() < 1e-4, "from {t}: {ends}");
        assert_eq!(past(&block(false), later(t), 0.1), None);
    }
    // A state in the slide, on its boundary to rounding.
    for v in [0.2, 0.2 + 1e-16] {
        assert_eq!(past(&block(false), (4.0, [0.1, v]), 0.0), Some(4.0));
    }
}

#[test]
fn a_crossing_has_a_past() {
    // Above the belt friction is -0.3, and the block crosses downwards at x > 0.3.
    let at = |t: f64| {
        let (sine, cosine) = (math::sin(t), math::cos(t));
        // From x = 1, v = 0.2 at t = 0, in slip below: x = 0.3 + 0.7 cos t + 0.2 sin t.
        [0.3 + 0.7 * cosine + 0.2 * sine, 0.2 * cosine - 0.7 * sine]
    };
    assert_eq!(past(&block(false), (0.5, at(0.5)), -0.5), None);
    // With static friction the block might have stuck where x < 0.5, but not at 1.
    assert_eq!(past(&block(true), (0.5, at(0.5)), -0.5), None);
    // It leaves stick at x = 0.5, with an acceleration of -0.2.
    let left = |t: f64| {
        let (sine, cosine) = (math::sin(t), math::cos(t));
        [0.3 + 0.2 * cosine + 0.2 * sine, 0.2 * cosine - 0.2 * sine]
    };
    let ends = past(&block(true), (0.5, left(0.5)), -5.0).unwrap();
    assert!(ends.abs() < 1e-9, "{ends}");
}

#[test]
fn what_is_defined_forwards_alone_is_named() {
    assert_eq!(check(&block(true)), Ok(()));
    let wall = read(
        "name = \"wall\"\n[states]\nx = \"\"\nv = \"\"\n[field]\nx = \"v\"\nv = -1\n[jumps.wall]\n\
         when = \"x\"\nset = { v = \"-v\" }\n",
    );
    let refused = check(&wall).unwrap_err().to_string();
    assert!(
        refused.contains("the system has jumps; run it forwards"),
        "{refused}"
    );
}
