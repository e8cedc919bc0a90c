//! Periodic orbits that are not isolated.

use assert_cmd::Command;

/// Without damping every swing has its own period: a family over the energy.
const PENDULUM: &str = include_str!("../../../stickslip-model/tests/data/pendulum.toml");

/// A block on a floor that shakes: its position does not matter.
const FLOOR: &str = r#"
name = "block on a shaken floor"
[time]
end = 40
period = "1"
[states]
x = "m"
v = "m/s"
[contacts.floor]
boundary = "v"
friction = "2"
[field]
x = "v"
v = "4*pi^2*sin(2*pi*t) - friction(floor)"
[start]
x = 0
v = 10
[ranges]
x = [-2, 2]
v = [-2, 2]
"#;

/// The output of a command for a system, as JSON and in words.
fn answers(text: &str, arguments: &[&str]) -> (serde_json::Value, String) {
    let top = tempfile::tempdir().unwrap();
    std::fs::write(top.path().join("system.toml"), text).unwrap();
    let run = |further: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
        let command = command.current_dir(top.path());
        let output = command.args(arguments).args(further).assert().success();
        output.get_output().stdout.clone()
    };
    let json = serde_json::from_slice(&run(&["--json", "--out", "a"])).unwrap();
    let words = String::from_utf8(run(&["--out", "b"])).unwrap();
    (json, words)
}

const ONE_OF: &str = "one of a family of periodic orbits of dimension 1";

#[test]
fn a_swing_of_a_pendulum_without_damping_is_one_of_a_family() {
    let (json, words) = answers(PENDULUM, &["orbit", "system.toml"]);
    assert_eq!(json["family_dimension"], 1);
    assert!(words.contains(ONE_OF), "{words}");
}

#[test]
fn swings_of_all_energies_are_one_attractor_with_its_dimension() {
    let basin = ["basin", "system.toml", "--grid", "4x3", "--tol", "1e-10"];
    for system in [PENDULUM, FLOOR] {
        let (json, words) = answers(system, &basin);
        let all = json["attractors"].as_array().unwrap();
        assert_eq!(all.len(), 1, "{words}");
        assert_eq!(
            (&all[0]["starts"], &all[0]["family_dimension"]),
            (&12.into(), &1.into())
        );
        assert!(
            words.contains(&format!("{ONE_OF}, here the one through (")),
            "{words}"
        );
    }
}

/// For each family the nearest orbit is continued to the ends of the range, with no special points.
#[test]
fn a_family_is_followed_along_a_parameter() {
    let along = ["continue", "system.toml", "--parameter", "g=0.5:2"];
    let (json, words) = answers(PENDULUM, &along);
    for end in json["ends"].as_array().unwrap() {
        assert_eq!(end["stop"], "range", "{words}");
    }
    assert_eq!(json["special"].as_array().unwrap().len(), 0, "{words}");
    assert!(words.contains(ONE_OF), "{words}");
}

/// Both exponents are zero. Neighbours separate linearly in time, which leaves a logarithm, and
/// blocks whose rates fall one after the other are as uncertain as correlated ones.
#[test]
fn exponents_without_damping_are_zero_to_their_uncertainty() {
    let (json, words) = answers(PENDULUM, &["lyapunov", "system.toml"]);
    for one in json["exponents"].as_array().unwrap() {
        let [value, uncertainty] = ["value", "uncertainty"].map(|key| one[key].as_f64().unwrap());
        assert!(value.abs() <= uncertainty && uncertainty < 1e-2, "{one}");
    }
    assert!(words.contains("λ1           0.0012 ± 6e-3\n"), "{words}");
}

/// A block at rest has a zero exponent: its position does not matter.
#[test]
fn the_exponent_of_what_rests_has_an_uncertainty() {
    let at_rest = [
        "lyapunov",
        "system.toml",
        "--duration",
        "50",
        "--start",
        "v=0.1",
    ];
    let still = FLOOR.replace("4*pi^2*sin(2*pi*t)", "0");
    let (json, words) = answers(&still.replace("period = \"1\"", ""), &at_rest);
    assert_eq!(json["exponents"][0]["value"].as_f64().unwrap(), 0.0);
    assert!(json["exponents"][0]["std_error"].as_f64().unwrap() < 1e-12);
    assert!(!words.contains("inf"), "{words}");
}
