//! Results known in closed form, or to many digits from other sources.

use std::f64::consts::PI;

use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum};
use stickslip::{Method, Options, Side, Visibility, math};
use stickslip_model::file::SystemFile;
use stickslip_model::study::extremes;
use stickslip_model::study::tangents::{BoundaryLine, LineResults, ZoneKind};

use crate::recorded::{open, run};
use crate::run::{options, orbit, system as read};

fn taylor() -> Options {
    Options::tol(1e-13).method(Method::Taylor)
}

/// Of a chaotic orbit, of a cycle with stick, and where stick annihilates the only direction.
#[test]
fn the_largest_exponent_alone_is_the_first_of_the_spectrum() {
    let sticks = "name = \"sticks\"\n[states]\nv = \"\"\n[contacts.belt]\nboundary = \"v - 1\"\n\
                  friction = \"1\"\n[field]\nv = \"-friction(belt)\"\n[start]\nv = 0\n";
    let forced = open("forced");
    let start = forced.start().unwrap();
    for (system, start) in [
        (forced, start),
        (open("belt"), vec![0.5, 0.1]),
        (read(sticks), vec![0.0]),
    ] {
        let settings = SpectrumOptions::over(50.0, 400.0).solver(taylor());
        let start = (0.0, start.as_slice());
        let all = lyapunov_spectrum(system.dynamics(), start, &settings).unwrap();
        let alone = Exponent::largest(system.dynamics(), start, &settings).unwrap();
        assert_eq!(alone, all.exponents[0], "{}", system.file.name);
    }
}

/// P17: without stops the amplitude from `orbit` is Den Hartog's.
#[test]
fn the_amplitudes_of_den_hartog() {
    let known = [
        (0.6, 0.1),
        (0.7, 0.2),
        (0.8, 0.1),
        (0.8, 0.3),
        (0.9, 0.3),
        (1.1, 0.4),
        (1.2, 0.2),
        (1.3, 0.1),
        (1.5, 0.2),
        (1.7, 0.3),
        (2.0, 0.1),
    ];
    for (frequency, friction) in known {
        let amplitude = {
            let v = 1.0 / (1.0 - frequency * frequency);
            let half = PI / frequency;
            let u = math::sin(half) / (frequency * (1.0 + math::cos(half)));
            (v * v - friction * friction * u * u).sqrt()
        };
        let settings = [("O".to_owned(), frequency), ("S".to_owned(), friction)];
        let system = SystemFile::open("den-hartog")
            .unwrap()
            .with(&settings)
            .unwrap();
        let options = options("taylor");
        let found = orbit(&system, &options);
        assert!((found.period / (2.0 * PI / frequency) - 1.0).abs() < 1e-12);
        let (t, x) = (found.t, found.x.as_slice());
        let (all, _) = extremes(system.dynamics(), (t, x), t + found.period, &options).unwrap();
        let (low, high) = all[0];
        for error in [high - amplitude, low + amplitude] {
            assert!(
                error.abs() < 1e-9,
                "O = {frequency}, S = {friction}: {error:e}"
            );
        }
    }
}

/// Eq. (16) of the paper: six tangent points in closed form, three of them visible, and three stick
/// zones between them.
#[test]
fn the_tangent_points_of_the_belt_oscillator() {
    let system = open("belt");
    let start = system.start().unwrap();
    let line = BoundaryLine::through(&system, 0, None, (-2.0, 2.0), (0.0, &start)).unwrap();
    let [(_, found)] = &line.scan(&system)[..] else {
        panic!("one branch is expected");
    };
    // With μ0 = √3/9, x - x³ = ∓μ0 at these places. The field moves along Σ at speed 1, so that the
    // normal component changes at the rate 1 - 3x².
    let known = [PI / 9.0, 2.0 * PI / 9.0, 4.0 * PI / 9.0];
    let known = known.map(|angle| 2.0 / 3f64.sqrt() * math::cos(angle));
    let known: Vec<f64> = known
        .into_iter()
        .chain(known.map(|x| -x).into_iter().rev())
        .collect();
    assert_eq!(found.points.len(), known.len());
    for (point, known) in found.points.iter().zip(&known) {
        assert!((point.x[0] - known).abs() < 1e-14);
        assert_eq!(point.x[1], 1.0);
        let rises = 1.0 - 3.0 * known * known > 0.0;
        let side = if known * (known * known - 1.0) > 0.0 {
            Side::Below
        } else {
            Side::Above
        };
        let is_visible = rises == (side == Side::Above);
        let visibility = [Visibility::Invisible, Visibility::Visible][usize::from(is_visible)];
        assert_eq!((point.side, point.visibility), (side, visibility));
    }
    let zones: Vec<(f64, f64)> = found
        .zones
        .iter()
        .filter(|zone| zone.kind == ZoneKind::Stick)
        .map(|zone| (zone.from, zone.to))
        .collect();
    assert_eq!(zones.len(), 3);
    for (zone, ends) in zones.iter().zip(known.chunks_exact(2)) {
        assert!((zone.0 - ends[1]).abs() < 1e-14 && (zone.1 - ends[0]).abs() < 1e-14);
    }
}

/// The stick zone of static friction extends beyond the tangent points of slip.
#[test]
fn static_friction_widens_the_stick_zone() {
    let system = read(
        r#"
name = "static"
[states]
x = ""
v = ""
[contacts.belt]
boundary = "v - 0.2"
friction = "0.6"
static = "1"
[field]
x = "v"
v = "-x - friction(belt)"
"#,
    );
    let line = BoundaryLine::through(&system, 0, None, (-2.0, 2.0), (0.0, &[0.0, 0.2])).unwrap();
    let [(_, found)] = &line.scan(&system)[..] else {
        panic!("one branch is expected");
    };
    let points: Vec<(f64, Side, Visibility)> = found
        .points
        .iter()
        .map(|point| (point.x[0], point.side, point.visibility))
        .collect();
    let wanted = [
        (0.6, Side::Below, Visibility::Visible),
        (-0.6, Side::Above, Visibility::Invisible),
    ];
    assert_eq!(points.len(), 2);
    for (point, wanted) in points.iter().zip(wanted) {
        assert!((point.0 - wanted.0).abs() < 1e-15);
        assert_eq!((point.1, point.2), (wanted.1, wanted.2));
    }
    assert_eq!(found.zones.len(), 1);
    let zone = found.zones[0];
    assert_eq!(zone.kind, ZoneKind::Stick);
    assert!((zone.from + 1.0).abs() < 1e-15 && (zone.to - 1.0).abs() < 1e-15);
}

/// Two-state fields with a boundary in both states, and the results on it along the first state.
fn on_boundary(
    boundary: &str,
    start: [f64; 2],
    range: (f64, f64),
) -> Vec<(BoundaryLine, LineResults)> {
    let system = read(&format!(
        r#"
name = "plane"
[states]
x = ""
y = ""
[contacts.rim]
boundary = "{boundary}"
[field]
x = {{ below = "x", above = "1" }}
y = {{ below = "y", above = "-1" }}
"#
    ));
    let line = BoundaryLine::through(&system, 0, Some(0), range, (0.0, &start)).unwrap();
    assert_eq!((line.along, line.solved), (0, 1));
    line.scan(&system)
}

/// A field outwards from the centre of a circle, and (1, -1) outside. Inside, the rate of x² + y²
/// is 4. Outside it is 2x - 2y, which pushes back where x < y.
#[test]
fn a_circle_has_two_branches_and_a_stick_zone_on_each() {
    let rim = 2.0_f64.sqrt();
    // At its centre the gradient of the circle's boundary function vanishes.
    for start in [[-1.0 / 15.0, 0.1], [0.0, 0.0], [0.0, 3.0], [1.0, -1.0]] {
        let found = on_boundary("x^2 + y^2 - 2", start, (-5.0, 5.0));
        assert_eq!(found.len(), 2);
        for ((branch, found), side) in found.iter().zip([-1.0, 1.0]) {
            let ends = [branch.path[0], branch.path[branch.path.len() - 1]];
            for (end, x) in ends.iter().zip([-rim, rim]) {
                assert!((end[0] - x).abs() < 1e-14 && end[1].abs() < 1e-6, "{end:?}");
            }
            for [x, y] in &branch.path[1..branch.path.len() - 1] {
                assert!((x * x + y * y - 2.0).abs() < 1e-14 && side * y > 0.0);
            }
            let [point] = &found.points[..] else {
                panic!("{:?}", found.points);
            };
            let kind = (point.side, point.visibility);
            assert_eq!(kind, (Side::Above, Visibility::Visible));
            assert!(
                point.x.iter().all(|x| (x - side).abs() < 1e-14),
                "{point:?}"
            );
            let [zone] = found.zones[..] else {
                panic!("{:?}", found.zones);
            };
            assert_eq!(zone.kind, ZoneKind::Stick);
            assert!(
                (zone.from + rim).abs() < 1e-14 && (zone.to - side).abs() < 1e-14,
                "{zone:?}"
            );
        }
    }
}

/// Branches that end at no side, at one, in a corner, or do not exist.
#[test]
fn branches_end_where_the_boundary_turns() {
    let ends = |boundary: &str, start: [f64; 2], range: (f64, f64)| -> Vec<[f64; 4]> {
        let found = on_boundary(boundary, start, range);
        let of = found.iter().map(|(branch, _)| {
            let (from, to) = (branch.path[0], branch.path[branch.path.len() - 1]);
            [from[0], to[0], from[1], to[1]]
        });
        of.collect()
    };
    let same = |found: &[[f64; 4]], wanted: &[[f64; 4]]| {
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for (found, wanted) in found.iter().zip(wanted) {
            // At a turning point x is accurate to rounding, the other state to its square root.
            let near = |i: usize, by: f64| (found[i] - wanted[i]).abs() <= by;
            assert!(
                near(0, 1e-14) && near(1, 1e-14) && near(2, 1e-6) && near(3, 1e-6),
                "{found:?}"
            );
        }
    };
    let root = 5.0_f64.sqrt();
    same(
        &ends("y^2 - x^2 - 1", [0.0, 0.5], (-2.0, 2.0)),
        &[[-2.0, 2.0, -root, -root], [-2.0, 2.0, root, root]],
    );
    // The turning point lies between two values of the scan, at zero.
    let parabola = ends("y^2 - x", [0.5, 0.5], (-1.0, 2.0));
    same(
        &parabola,
        &[
            [0.0, 2.0, 0.0, -(2.0_f64.sqrt())],
            [0.0, 2.0, 0.0, 2.0_f64.sqrt()],
        ],
    );
    same(
        &ends("abs(x) + abs(y) - 1", [0.0, 0.5], (-3.0, 3.0)),
        &[[-1.0, 1.0, 0.0, 0.0], [-1.0, 1.0, 0.0, 0.0]],
    );
    // Far from the start, and one of several at every position.
    same(
        &ends("y - 1000*x - 1000", [0.0, 0.5], (-1.0, 2.0)),
        &[[-1.0, 2.0, 0.0, 3000.0]],
    );
    let waves = ends("sin(y) + 0.1*y - x", [0.0, 0.0], (0.0, 1.5));
    assert!(
        waves
            .iter()
            .any(|one| one[0] == 0.0 && one[2] == 0.0 && one[1] < 1.5),
        "{waves:?}"
    );
    same(&ends("x^2 + y^2 - 2", [0.0, 0.5], (5.0, 6.0)), &[]);
}

#[test]
fn the_exponents_of_a_sticking_orbit() {
    let system = open("leine");
    let start = system.start().unwrap();
    let settings = SpectrumOptions::over(50.0, 200.0).solver(taylor());
    let spectrum = lyapunov_spectrum(system.dynamics(), (0.0, &*start), &settings).unwrap();
    assert!(spectrum.exponents[0].value().abs() < 0.05);
    assert_eq!(spectrum.exponents[1], Exponent::Annihilated);
    assert!(spectrum.stick_entries >= 15);
    assert!((spectrum.stick_fraction - 7.705031769350 / 12.001031294831).abs() < 0.02);
}

/// Four uncoupled blocks move as each does alone.
#[test]
fn four_blocks_side_by_side_are_four_blocks() {
    let mut text = "name = \"four\"\n[states]\n".to_owned();
    let (mut contacts, mut field, mut start) = (String::new(), String::new(), String::new());
    for k in 1..=4 {
        text += &format!("x{k} = \"\"\nv{k} = \"\"\n");
        contacts += &format!(
            "[contacts.c{k}]\n\
                boundary = \"v{k} - 0.{k}\"\n\
                friction = \"1/(1 + 3*c{k}*(v{k} - 0.{k}))\"\n"
        );
        field += &format!("x{k} = \"v{k}\"\nv{k} = \"-x{k} - friction(c{k})\"\n");
        start += &format!("x{k} = 0\nv{k} = 0\n");
    }
    text += &format!("{contacts}[field]\n{field}[start]\n{start}");
    let four = read(&text);
    let (ended, together) = run(&four, 30.0, &taylor());
    for k in 1..=4usize {
        let speed = k as f64 / 10.0;
        let one = open("leine")
            .file
            .with(&[("vd".to_owned(), speed)])
            .unwrap();
        let (alone_ended, alone) = run(&one, 30.0, &taylor());
        let of_this: Vec<_> = together.iter().filter(|event| event.1 == k - 1).collect();
        assert!(alone.len() >= 4);
        assert_eq!(of_this.len(), alone.len(), "block {k}");
        for (one, other) in of_this.iter().zip(&alone) {
            assert_eq!(one.0, other.0);
            assert!((one.2 - other.2).abs() < 1e-10, "{one:?} {other:?}");
        }
        for i in 0..2 {
            assert!((ended.x[2 * (k - 1) + i] - alone_ended.x[i]).abs() < 1e-10);
        }
    }
}

/// A field without friction on each side, of one state: it comes to rest on the boundary.
#[test]
fn one_state_slides_on_a_point() {
    let system = read(
        r#"
name = "relay"
[states]
x = ""
[contacts.relay]
boundary = "x"
[field]
x = { below = "2", above = "-1" }
[start]
x = 1
"#,
    );
    let (ended, events) = run(&system, 3.0, &taylor());
    assert_eq!(ended.x.as_slice(), [0.0]);
    assert_eq!(events.len(), 1);
    assert!((events[0].2 - 1.0).abs() < 1e-14);
}

/// The examples of the documentation are valid files, and all of the same system.
#[test]
fn the_examples_of_the_documentation_are_good_files() {
    let readme = include_str!("../../../stickslip-cli/README.md").to_owned();
    let module = include_str!("../../src/file/mod.rs").lines();
    let module: Vec<&str> = module
        .map(|line| line.trim_start_matches("//!").trim_start())
        .collect();
    for text in [readme, module.join("\n")] {
        let example = text
            .split("```toml\n")
            .nth(1)
            .and_then(|rest| rest.split("```").next());
        let system = read(example.expect("an example"));
        let (ended, events) = run(&system, 50.0, &taylor());
        assert!(events.len() > 10 && ended.t == 50.0);
    }
}
