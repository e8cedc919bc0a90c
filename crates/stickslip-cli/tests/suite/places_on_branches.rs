//! Places on branches: one name and one order of the phases, wherever a branch is begun.

use std::collections::HashMap;
use std::f64::consts::PI;

use assert_cmd::Command;
use stickslip::math;

use crate::public_cases::results;

/// Den Hartog's oscillator with a wall that it does not reach at small amplitudes of the force.
const WALL: &str = r#"
name = "wall"
[time]
period = "2*pi/w"
[states]
x = ""
v = ""
[parameters]
A = 0.4
w = 0.6
[contacts.floor]
boundary = "v"
friction = "0.1"
[field]
x = "v"
v = "-x + A*cos(w*t) - friction(floor)"
[jumps.wall]
when = "0.8 - x"
direction = "falling"
set = { v = "-0.8*v" }
[start]
x = 0
v = 0
"#;

/// The force at which the oscillator's amplitude is the distance of the wall (Den Hartog 1931).
fn at_wall(frequency: f64) -> f64 {
    let half = PI / frequency;
    let v = 1.0 / (1.0 - frequency * frequency);
    let u = math::sin(half) / (frequency * (1.0 + math::cos(half)));
    (0.8 * 0.8 + 0.1 * 0.1 * u * u).sqrt() / v
}

#[test]
fn the_graze_of_a_wall_is_followed_in_two_parameters_along_its_closed_form() {
    let top = tempfile::tempdir().unwrap();
    std::fs::write(top.path().join("system.toml"), WALL).unwrap();
    for method in ["dop853", "taylor"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
        let command = command.current_dir(top.path());
        let along = ["--parameter", "A=0.2:0.9", "--also", "w=0.55:0.7"];
        let how = ["--method", method, "--out", method];
        let command = command.args(["continue", "system.toml"]);
        command.args(along).args(how).assert().success();
        let table = top.path().join(method).join("curves.csv");
        let mut table = csv::Reader::from_path(table).unwrap();
        let rows: Vec<HashMap<String, String>> = table.deserialize().map(Result::unwrap).collect();
        let of = |row: &HashMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
        for row in &rows {
            assert_eq!(row["what"], "grazing of a jump");
            let (force, frequency) = (of(row, "A"), of(row, "w"));
            let off = (force - at_wall(frequency)).abs();
            assert!(off < 1e-7, "{method} at {frequency}: {off:e}");
        }
        let ends = [&rows[0], &rows[rows.len() - 1]].map(|row| of(row, "w"));
        assert!((ends[0] - 0.55).abs() < 1e-9 && (ends[1] - 0.7).abs() < 1e-9);
        assert!(rows.len() > 5);
    }
}

/// The block turns back at its amplitude. So the wall's function and the velocity of the contact
/// are zero at once, and rounding decides on which side of that moment the least distance lies.
#[test]
fn a_graze_of_a_wall_where_the_velocity_is_zero_has_one_name() {
    let exact = at_wall(0.6);
    for start in ["A=0.3", "A=0.33", "A=0.35", "A=0.38", "A=0.4", "A=0.42"] {
        let range = ["--set", start, "--parameter", "A=0.2:0.9"];
        let json = results(WALL, &[&["continue", "system.toml"], &range[..]].concat());
        let [graze] = json["special"].as_array().unwrap().as_slice() else {
            panic!("{start}: {json:#}");
        };
        assert_eq!(graze["what"], "grazing of a jump", "{start}");
        let [at, uncertainty] =
            ["parameter", "uncertainty"].map(|key| graze[key].as_f64().unwrap());
        let off = (at - exact).abs();
        assert!(
            off <= uncertainty && uncertainty < 1e-8,
            "{start}: {at} for {exact}, {uncertainty:e}"
        );
    }
}

/// Begun at the lower friction or the higher frequency, the orbit grazes the edge of stick between
/// two samples of a step. At the switching a multiplier is 1. That leaves the tangent undetermined,
/// and orbits next to it.
#[test]
fn a_branch_has_the_same_places_wherever_it_is_begun() {
    let branches = [
        ("S=0.3", "O=0.35:0.9", ["O=0.4", "O=0.7"]),
        ("S=0.305", "O=0.35:0.9", ["O=0.4", "O=0.7"]),
        ("S=0.28", "O=0.35:0.9", ["O=0.7", "O=0.4"]),
        ("O=0.4", "S=0.02:1.2", ["S=0.3", "S=0.1"]),
        ("O=0.45", "S=0.02:1.2", ["S=0.3", "S=0.1"]),
    ];
    for (set, range, starts) in branches {
        let set = ["continue", "den-hartog", "--set", set, "--parameter", range];
        let special = starts.map(|start| {
            let json = results("", &[&set[..], &["--set", start]].concat());
            json["special"].as_array().unwrap().clone()
        });
        let [one, other] = &special;
        assert_eq!((one.len(), other.len()), (2, 2), "{set:?}: {special:#?}");
        for (a, b) in one.iter().zip(other) {
            assert_eq!(a["what"], b["what"], "{set:?}");
            let value = |key: &str| [a, b].map(|at| at[key].as_f64().unwrap());
            let ([a, b], [by, or]) = (value("parameter"), value("uncertainty"));
            assert!(
                (a - b).abs() <= by + or && by.max(or) < 1e-6,
                "{set:?}: {a} ± {by:e} and {b} ± {or:e}"
            );
        }
    }
}

/// Wherever an orbit is begun, its phases are written in one order.
#[test]
fn orbits_and_branches_write_phases_in_one_order() {
    let top = tempfile::tempdir().unwrap();
    let set = ["den-hartog", "--set", "S=0.5", "--set", "O=0.4"];
    let mut all = Vec::new();
    for start in ["x=0", "x=1.5", "x=-1.5"] {
        let orbit = [&["orbit"], &set[..], &["--start", start]].concat();
        let orbit = results("", &orbit);
        all.push(orbit["phases"].as_str().unwrap().to_owned());
        let along = ["--parameter", "O=0.4:0.41", "--points", "2"];
        let out = format!("branch-{start}");
        let from = [&set[..], &["--start", start, "--out", &out], &along].concat();
        let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
        let command = command.current_dir(top.path()).arg("continue").args(from);
        command.assert().success();
        let mut table = csv::Reader::from_path(top.path().join(&out).join("branch.csv")).unwrap();
        let column = table
            .headers()
            .unwrap()
            .iter()
            .position(|name| name == "phases");
        let row = table.records().next().unwrap().unwrap();
        all.push(row[column.unwrap()].to_owned());
    }
    assert!(all[0].contains('S'), "{all:?}");
    assert!(all.iter().all(|phases| *phases == all[0]), "{all:?}");
}

/// A heater warms a room towards 1 and goes off at p. The warming takes `ln(0.8/(1 - p))`.
const THERMOSTAT: &str = r#"
name = "thermostat"
[states]
T = ""
[discrete]
heater = 1
[parameters]
p = 0.5
[field]
T = "heater - T"
[jumps.off]
when = "T - p"
direction = "rising"
set = { heater = "0" }
[jumps.on]
when = "T - 0.2"
direction = "falling"
set = { heater = "1" }
[start]
T = 0.3
"#;

#[test]
fn a_threshold_at_an_equilibrium_ends_the_branch_by_name() {
    let arguments = ["continue", "system.toml", "--parameter", "p=0.3:1.2"];
    let json = results(THERMOSTAT, &arguments);
    let end = &json["ends"][1];
    assert_eq!(end["stop"], "boundary equilibrium", "{json:#}");
    let at = end["boundary_equilibrium"].as_f64().unwrap();
    assert!((at - 1.0).abs() < 1e-9, "{at}");
}
