//! Times to return, pushes out of basins, and edge states.

use std::f64::consts::{PI, TAU};

use stickslip::analysis::{
    AttractorKind, EdgeKind, EdgeSettings, EdgeState, PeriodicOrbit, Push, PushSettings,
    RecurrenceSettings, attractor, multipliers,
};
use stickslip::{Error, Options, math};
use stickslip_model::file::System;

use super::{WELLS, system};

fn returns(system: &System, start: &[f64], tolerance: f64) -> Option<f64> {
    let forcing = system.checked_period().unwrap();
    let settings = RecurrenceSettings {
        forcing,
        ..RecurrenceSettings::within(300.0)
    };
    let options = Options::tol(1e-12);
    let reached = attractor(system.dynamics(), start, &settings, &options).unwrap();
    reached
        .return_time(system.dynamics(), start, tolerance, &settings, &options)
        .unwrap()
}

#[test]
fn times_to_return_are_those_of_closed_forms() {
    // Exponential decay, and constant friction.
    let decay = system(&[("x", "-x")], 0.0);
    for (start, tolerance) in [(2.0, 1e-3), (-5.0, 1e-6), (1.0, 0.5)] {
        let time = returns(&decay, &[start], tolerance).unwrap();
        let wanted = math::ln(f64::abs(start) / tolerance);
        // The error of the state, over the rate of the distance.
        let allowed = 1e-12 / tolerance + 1e-12;
        assert!((time - wanted).abs() < allowed, "{start}: {time} {wanted}");
    }
    assert_eq!(returns(&decay, &[0.01], 0.02), Some(0.0));
    // A focus: the distance exp(-t/10) is the same in all directions.
    let focus = system(&[("x", "-0.1*x - y"), ("y", "x - 0.1*y")], 0.0);
    let time = returns(&focus, &[0.6, 0.8], 1e-3).unwrap();
    assert!((time - 10.0 * math::ln(1e3)).abs() < 1e-7, "{time}");
    // x = (x0 + (10 y0 + x0) t...) leaves again: y decays slowly and pushes x, so that the last
    // time counts. From x = 0, x = 100 y0 (exp(-t/2) - exp(-t)), y = y0 exp(-t/2).
    let detour = system(&[("x", "-x + 50*y"), ("y", "-0.5*y")], 0.0);
    let (y0, tolerance) = (1e-3, 1e-2);
    let time = returns(&detour, &[0.0, y0], tolerance).unwrap();
    let distance = |t: f64| {
        let (slow, fast) = (math::exp(-0.5 * t), math::exp(-t));
        math::hypot(100.0 * y0 * (slow - fast), y0 * slow)
    };
    assert!(
        (distance(time) - tolerance).abs() < 1e-10 && time > 4.0,
        "{time}"
    );
    // A cycle: r² = 1/(1 + (1/r0² - 1) exp(-2t)).
    let rate = |own: &str, other: &str| format!("{own}*(1 - x^2 - y^2) {other}");
    let cycle = system(&[("x", &rate("x", "- y")), ("y", &rate("y", "+ x"))], 0.0);
    for (r0, tolerance) in [(3.0, 1e-3), (0.1, 1e-3), (2.0, 1e-5), (2.0, 1e-6)] {
        let time = returns(&cycle, &[0.0, r0], tolerance).unwrap();
        let r = if r0 > 1.0 {
            1.0 + tolerance
        } else {
            1.0 - tolerance
        };
        let wanted = 0.5 * math::ln((1.0 / (r0 * r0) - 1.0) / (1.0 / (r * r) - 1.0));
        // A distance error `e` moves the time by `e / (2 tolerance)`. Parabolas miss the circle by
        // a twentieth of the tolerance times the square of their angle.
        let allowed = 0.05 * 1e-2 + 1e-10 / tolerance;
        assert!((time - wanted).abs() <= allowed, "{r0}: {time} {wanted}");
    }
    // A slow one: the attractor is known to far less than what is asked for.
    let slow = |own: &str, other: &str| format!("0.01*{own}*(1 - x^2 - y^2) {other}");
    let cycle = system(&[("x", &slow("x", "- y")), ("y", &slow("y", "+ x"))], 0.0);
    let settings = RecurrenceSettings::within(5000.0);
    let options = Options::tol(1e-12);
    let reached = attractor(cycle.dynamics(), [1.5, 0.0], &settings, &options).unwrap();
    for tolerance in [1e-3, 1e-5, 1e-6] {
        let found =
            reached.return_time(cycle.dynamics(), [1.5, 0.0], tolerance, &settings, &options);
        let r = 1.0 + tolerance;
        let wanted = 50.0 * math::ln((1.0 / 2.25 - 1.0) / (1.0 / (r * r) - 1.0));
        let off = found.unwrap().unwrap() - wanted;
        assert!(off.abs() < 0.05, "{tolerance}: {off}");
    }
    // A drive: x - (cos t + sin t)/2 = (x0 - 1/2) exp(-t), at whole periods.
    let driven = system(&[("x", "-x + cos(t)")], 0.0);
    for x0 in [5.5, 1e5] {
        let wanted = (math::ln((x0 - 0.5) / 1e-4) / TAU).ceil() * TAU;
        let time = returns(&driven, &[x0], 1e-4).unwrap();
        assert!((time - wanted).abs() < 1e-9, "{x0}: {time} {wanted}");
    }
    // Below what the run that found the attractor knew of it.
    let wanted = (math::ln(5.0 / 1e-9) / TAU).ceil() * TAU;
    let time = returns(&driven, &[5.5], 1e-9).unwrap();
    assert!((time - wanted).abs() < 1e-9, "{time} {wanted}");
}

/// A block with constant friction and no spring loses all of its speed in a finite time.
#[test]
fn a_time_to_return_ends_where_sliding_does() {
    let text = "name = \"relay\"\n[states]\nx = \"\"\n[contacts.c]\nboundary = \"x\"\n\
                [field]\nx = \"-c\"\n";
    let relay = crate::lyapunov_jumps::system(text);
    for start in [2.0, -0.7_f64] {
        let time = returns(&relay, &[start], 0.01).unwrap();
        assert!(
            (time - (start.abs() - 0.01)).abs() < 1e-10,
            "{start}: {time}"
        );
    }
}

#[test]
fn motion_that_is_not_periodic_has_no_time_to_return() {
    let lorenz = [
        ("x", "10*(y - x)"),
        ("y", "x*(28 - z) - y"),
        ("z", "x*y - 8/3*z"),
    ];
    let lorenz = system(&lorenz, 0.0);
    let settings = RecurrenceSettings::within(400.0);
    let options = Options::tol(1e-9);
    let start = [1.0, 1.0, 20.0];
    let reached = attractor(lorenz.dynamics(), start, &settings, &options).unwrap();
    assert_eq!(reached.kind, AttractorKind::Recurrent);
    let time = reached.return_time(lorenz.dynamics(), start, 0.1, &settings, &options);
    assert_eq!(time, Ok(None));
    let error = reached.return_time(lorenz.dynamics(), start, 0.0, &settings, &options);
    assert!(matches!(
        error,
        Err(Error::Option {
            name: "return_within",
            ..
        })
    ));
}

#[test]
fn pushes_end_at_the_known_boundary() {
    let wells = system(&WELLS, 0.0);
    let (settings, options) = (RecurrenceSettings::within(300.0), Options::tol(1e-12));
    let how = PushSettings::up_to(10.0);
    let dynamics = wells.dynamics();
    let push = |from: [f64; 2], direction: [f64; 2], how: &PushSettings| {
        let found = Push::least(dynamics, from, [direction], how, &settings, &options);
        found.unwrap().remove(0)
    };
    // 1 - s = c² s²/3 along (-1, c).
    for c in [0.0, 0.5, -3.0_f64] {
        let wanted = match c {
            0.0 => 1.0,
            c => 1.5 * ((1.0 + 4.0 * c * c / 3.0).sqrt() - 1.0) / (c * c),
        };
        let found = push([1.0, 0.0], [-1.0, c], &how).unwrap();
        assert!(
            (found.size - wanted).abs() <= found.uncertainty + 1e-9,
            "{c}: {found:?}"
        );
        assert!(found.uncertainty < 1e-8);
        assert!((found.beyond.points[0].x[0] + 1.0).abs() < 1e-9);
    }
    assert_eq!(push([1.0, 0.0], [1.0, 0.0], &how), None);
    // Halves of the ray hit the saddle itself, where no orbit leaves.
    let dyadic = PushSettings {
        largest: 4.0,
        parts: 4,
    };
    let found = push([1.0, 0.0], [-1.0, 0.0], &dyadic).unwrap();
    assert!((found.size - 1.0).abs() <= found.uncertainty, "{found:?}");
    assert_eq!(found.beyond.kind, AttractorKind::Equilibrium);
    // -1 + 2 s = s²/3 has two roots: the ray leaves at the first and returns at the second.
    let roots = [-1.0, 1.0].map(|sign| 3.0 + sign * 6f64.sqrt());
    let found = push([-1.0, 0.0], [2.0, 1.0], &how).unwrap();
    assert!((found.size - roots[0]).abs() < 1e-8, "{found:?}");
    // Samples on both sides of the other basin do not see it.
    let coarse = PushSettings { parts: 1, ..how };
    assert_eq!(push([-1.0, 0.0], [2.0, 1.0], &coarse), None);
    let none = Push::least(
        dynamics,
        [1.0, 0.0],
        [[0.0, 0.0]],
        &how,
        &settings,
        &options,
    );
    assert!(matches!(
        none,
        Err(Error::Option {
            name: "direction",
            ..
        })
    ));
}

#[test]
fn edge_states_are_the_known_saddle_and_cycles() {
    let options = Options::tol(1e-12);
    let settings = RecurrenceSettings::within(300.0);
    let how = EdgeSettings::within(200.0);
    // The track begins on x = y²/3 and goes along it to the saddle.
    let wells = system(&WELLS, 0.0);
    let found = EdgeState::between(
        wells.dynamics(),
        [-1.0, 3.0],
        [6.0, 2.5],
        &how,
        &settings,
        &options,
    );
    let found = found.unwrap();
    assert_eq!((found.kind, found.unstable), (EdgeKind::Equilibrium, 1));
    assert!(found.x.amax() < 1e-12, "{}", found.x);
    for at in &found.track {
        assert!((at.x[0] - at.x[1] * at.x[1] / 3.0).abs() < 1e-3, "{at:?}");
    }
    assert!(found.track.len() > 10 && found.track[0].x[1] > 2.4);
    // A focus inside an unstable cycle of radius 1 inside a stable one of radius 2:
    // r' = -r (1 - r²)(4 - r²)/20, whose multiplier at 1 is exp(6/20 · 2π).
    let part = "0.05*(1 - x^2 - y^2)*(4 - x^2 - y^2)";
    let (x, y) = (format!("-x*{part} - y"), format!("-y*{part} + x"));
    let rings = system(&[("x", &x), ("y", &y)], 0.0);
    let found = EdgeState::between(
        rings.dynamics(),
        [0.1, 0.0],
        [0.5, 1.9],
        &how,
        &settings,
        &options,
    );
    let found = found.unwrap();
    let EdgeKind::Periodic { period } = found.kind else {
        panic!("{:?}", found.kind);
    };
    assert_eq!(found.unstable, 1);
    assert!((period - TAU).abs() < 1e-9 && (found.x.norm() - 1.0).abs() < 1e-9);
    let cycle = PeriodicOrbit::near(rings.dynamics(), &found.x, period, &options).unwrap();
    let multiplier = multipliers(&cycle.monodromy)
        .iter()
        .map(|one| one.norm())
        .fold(0.0, f64::max);
    assert!((multiplier / math::exp(0.3 * TAU) - 1.0).abs() < 1e-8);
    // u = x - cos(t)/2 has the rate u - u³: the edge is u = 0.
    let driven = system(
        &[("x", "-0.5*sin(t) + (x - 0.5*cos(t)) - (x - 0.5*cos(t))^3")],
        0.0,
    );
    let forced = settings.forced(TAU);
    let found =
        EdgeState::between(driven.dynamics(), [-2.0], [3.0], &how, &forced, &options).unwrap();
    assert_eq!(
        (found.kind, found.unstable),
        (EdgeKind::Periodic { period: TAU }, 1)
    );
    assert!((found.x[0] - 0.5).abs() < 1e-9, "{}", found.x);
}

/// Behind the basin of 0 lies that of π's multiples: the boundary is that of the first basin.
#[test]
fn a_third_basin_between_is_named() {
    let pendulum = system(&[("x", "-sin(x)")], 0.0);
    let (settings, options) = (RecurrenceSettings::within(300.0), Options::tol(1e-12));
    let how = EdgeSettings::within(50.0);
    let dynamics = pendulum.dynamics();
    let found =
        EdgeState::between(dynamics, [0.3], [4.0 * PI + 0.1], &how, &settings, &options).unwrap();
    assert!((found.x[0] - PI).abs() < 1e-9, "{}", found.x);
    assert!((found.beside[1].points[0].x[0] - TAU).abs() < 1e-9);
    let none = EdgeState::between(dynamics, [0.3], [0.4], &how, &settings, &options);
    assert!(
        matches!(
            none,
            Err(Error::Option {
                name: "distance",
                ..
            })
        ),
        "{none:?}"
    );
}

/// The boundary between steady sliding and the stick–slip cycle of a damped block on a belt is an
/// unstable cycle: a little inside of it orbits come to rest, a little outside they do not.
#[test]
fn the_edge_of_a_stick_slip_cycle_is_an_unstable_cycle() {
    let text = "name = \"belt\"\n[states]\nx = \"\"\nv = \"\"\n[contacts.belt]\n\
                boundary = \"v - 1.5\"\n\
                friction = \"0.5 + 0.5*exp(-2*belt*(v - 1.5))\"\n\
                [field]\nx = \"v\"\nv = \"-x - 0.1*v - friction(belt)\"\n";
    let block = crate::lyapunov_jumps::system(text);
    let (settings, options) = (RecurrenceSettings::within(2000.0), Options::tol(1e-11));
    let how = EdgeSettings::within(1000.0);
    let dynamics = block.dynamics();
    let rest = 0.5 + 0.5 * math::exp(-3.0);
    let (inside, outside) = ([rest, 0.0], [-1.0, 1.5]);
    let found = EdgeState::between(dynamics, inside, outside, &how, &settings, &options).unwrap();
    let EdgeKind::Periodic { period } = found.kind else {
        panic!("{:?}", found.kind);
    };
    assert_eq!(found.unstable, 1);
    let kinds = found.beside.each_ref().map(|one| one.kind.word());
    assert_eq!(kinds, ["equilibrium", "periodic"]);
    for (part, kind) in [(1.0 - 1e-5, "equilibrium"), (1.0 + 1e-5, "periodic")] {
        let start = [rest + part * (found.x[0] - rest), part * found.x[1]];
        let reached = attractor(dynamics, start, &settings, &options).unwrap();
        assert_eq!(reached.kind.word(), kind, "{part}: {}", found.x);
    }
    // Nearly harmonic, and below the speed of the belt throughout.
    assert!((period / TAU - 1.0).abs() < 0.01, "{period}");
}
