//! Measures of basins by `stickslip basin` and `stickslip bifurcation --shares`, of systems whose
//! values are known.

use std::fs;
use std::path::Path;

use predicates::str::contains;
use serde_json::Value;

use super::common::{files, folder, program, text};

/// Equilibria at (-1, 0) and (1, 0); the basins meet at x = y²/3.
const WELLS: &str = "name = \"wells\"\n[states]\nx = \"\"\ny = \"\"\n\
    [definitions]\nu = \"x - y^2/3\"\n\
    [field]\nx = \"u - u^3 - 2/3*y^2\"\ny = \"-y\"\n[ranges]\nx = [-2, 2]\ny = [-2, 2]\n\
    [start]\nx = 1\ny = 0\n";

/// Equilibria at -1 and 1, which meet at x = p.
const MOVING: &str = "name = \"moving\"\n[parameters]\np = 0\n[states]\nx = \"\"\n\
    [field]\nx = \"-(x + 1)*(x - p)*(x - 1)\"\n[ranges]\nx = [-2, 2]\n[start]\nx = 1\n";

fn json(top: &Path, arguments: &[&str]) -> Value {
    let output = program(top)
        .args(arguments)
        .arg("--json")
        .assert()
        .success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[test]
fn all_measures_of_a_known_boundary() {
    let top = folder();
    fs::write(top.path().join("wells.toml"), WELLS).unwrap();
    let arguments = [
        "basin",
        "wells.toml",
        "--grid",
        "64x64",
        "--tol",
        "1e-10",
        "--entropy",
        "8",
        "--dimension",
        "--return-within",
        "0.01",
        "--push",
        "-x",
        "--push",
        "x",
        "--push",
        "x=1,y=0.5",
        "--edges",
        "--out",
        "w",
    ];
    let found = json(top.path(), &arguments);
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let (sb, sbb) = (
        number(&found["entropy"]["sb"]),
        number(&found["entropy"]["sbb"]),
    );
    let part = number(&found["entropy"]["boundary_boxes"]) / number(&found["entropy"]["boxes"]);
    assert!(
        (sb - sbb * part).abs() < 1e-12 && (0.3..0.6).contains(&sbb),
        "{found}"
    );
    let boundary = &found["boundary"];
    let off = (number(&boundary["dimension"]) - 1.0).abs();
    assert!(
        off < 2.0 * number(&boundary["std_error"]) + 0.01,
        "{boundary}"
    );
    // The attractors by the sides on which they lie.
    let attractors = found["attractors"].as_array().unwrap();
    let side = |k: u64| number(&attractors[k as usize - 1]["points"][0]["x"]["x"]);
    for one in attractors {
        let times = &one["return_time"];
        assert_eq!(times["starts"], one["starts"]);
        assert!(
            number(&times["mean"]) < number(&times["largest"]),
            "{times}"
        );
        assert!(number(&times["std_error"]) > 0.0);
    }
    // From the right well along (-1, 0) to 0; from the left one along (1, 1/2) to the root of
    // s - 1 = s²/12.
    let pushes = found["pushes"].as_array().unwrap();
    assert_eq!(pushes.len(), 6);
    for push in pushes {
        let from = side(push["attractor"].as_u64().unwrap());
        let wanted = match (push["direction"].as_str().unwrap(), from > 0.0) {
            ("-x", true) | ("x", false) => 1.0,
            ("x=1,y=0.5", false) => 6.0 - 24f64.sqrt(),
            _ => f64::NAN,
        };
        let size = number(&push["push"]);
        assert!(
            (size - wanted).abs() < 1e-8 || size.is_nan() && wanted.is_nan(),
            "{push}"
        );
        assert_eq!(push["beyond"].is_null(), wanted.is_nan());
    }
    let [edge] = found["edges"].as_array().unwrap().as_slice() else {
        panic!("{found}");
    };
    assert_eq!(
        (&edge["motion"], &edge["unstable"]),
        (&"equilibrium".into(), &1.into())
    );
    assert!(number(&edge["x"]["x"]).abs() < 1e-9 && number(&edge["x"]["y"]).abs() < 1e-9);
    let names = files(&top.path().join("w"));
    for name in [
        "pushes.csv",
        "edges.csv",
        "tracks.csv",
        "uncertain.csv",
        "attractors.csv",
    ] {
        assert!(names.keys().any(|one| one.ends_with(name)), "{name}");
    }
    let table = text(top.path().join("w/basin.csv"));
    assert!(
        table.starts_with("x,y,attractor,motion,return_time\n"),
        "{table}"
    );
    // The saved sweep gives the same once more, and another distance is another sweep.
    assert_eq!(json(top.path(), &arguments), found);
}

#[test]
fn measures_that_cannot_be_taken_are_refused_before_the_sweep() {
    let top = folder();
    fs::write(top.path().join("wells.toml"), WELLS).unwrap();
    for (arguments, says) in [
        (&["--entropy", "7"][..], "divide the 10 columns and 10 rows"),
        (&["--dimension"], "64x64"),
        (&["--return-within", "0"], "positive and finite"),
        (&["--push", "z"], "there is no state `z`"),
        (&["--push", "x=0"], "not 0"),
        (&["--push", "x,x=2"], "stands twice"),
    ] {
        let mut command = program(top.path());
        command
            .args(["basin", "wells.toml", "--grid", "10x10"])
            .args(arguments);
        command.assert().code(2).stderr(contains(says));
    }
    let mut command = program(top.path());
    command.args(["basin", "wells.toml", "--random", "10", "--entropy", "5"]);
    command
        .assert()
        .code(2)
        .stderr(contains("needs starts on a grid"));
}

#[test]
fn shares_along_a_parameter_are_those_of_the_boundary() {
    let top = folder();
    fs::write(top.path().join("moving.toml"), MOVING).unwrap();
    let arguments = [
        "bifurcation",
        "moving.toml",
        "--parameter",
        "p=-0.9:0.9",
        "--values",
        "13",
        "--locate",
        "none",
        "--tol",
        "1e-9",
        "--duration",
        "1",
        "--shares",
        "400",
        "--out",
        "s",
    ];
    let found = json(top.path(), &arguments);
    let bands = found["shares"].as_array().unwrap();
    assert_eq!(bands.len(), 2);
    let sum_at = |k: usize| -> f64 {
        let each = bands.iter();
        each.map(|band| band["shares"][k]["share"].as_f64().unwrap())
            .sum()
    };
    // Which band is at -1 is known by its growth with p.
    let end = |band: &Value| band["shares"][12]["share"].as_f64().unwrap();
    let left = bands.iter().find(|band| end(band) > 0.5).unwrap();
    for (k, at) in left["shares"].as_array().unwrap().iter().enumerate() {
        let number = |name: &str| at[name].as_f64().unwrap();
        let wanted = 0.25 * (number("value") + 2.0);
        assert!(
            (number("share") - wanted).abs() < 4.0 * number("std_error"),
            "{at}"
        );
        let error = (number("share") * (1.0 - number("share")) / 400.0).sqrt();
        assert!((number("std_error") - error).abs() < 1e-12);
        assert!((sum_at(k) - 1.0).abs() < 1e-12);
    }
    let table = text(top.path().join("s/shares.csv"));
    let head = "p,band,motion,phases,starts,share,std_error,x,reason\n";
    assert!(table.starts_with(head), "{table}");
    assert_eq!(table.lines().count(), 1 + 26);
    assert!(top.path().join("s/shares.svg").exists());
    // In shards it is the same.
    let shard = |share: &str, out: &str| {
        let arguments = [&arguments[..arguments.len() - 1], &[out, "--shard", share]].concat();
        program(top.path()).args(arguments).assert().success();
    };
    shard("1/2", "a");
    shard("2/2", "b");
    program(top.path())
        .args(["merge", "--out", "joined", "a", "b"])
        .assert()
        .success();
    assert_eq!(text(top.path().join("joined/shares.csv")), table);
    let mut command = program(top.path());
    command.args([
        "bifurcation",
        "moving.toml",
        "--parameter",
        "p=0:1",
        "--over",
        "x=0:1",
    ]);
    command.assert().code(2).stderr(contains("--shares"));
}

/// Shares of the fixed point as published with bSTAB's example, from 5000 random starts each, and
/// one band for each of the two attractors.
#[test]
fn shares_along_the_speed_of_a_belt_are_the_published_ones() {
    let top = folder();
    let arguments = [
        "bifurcation",
        "basins",
        "--parameter",
        "vd=1.1:1.9",
        "--values",
        "17",
        "--locate",
        "none",
        "--tol",
        "1e-9",
        "--duration",
        "1",
        "--shares",
        "400",
    ];
    let found = json(top.path(), &arguments);
    let bands = found["shares"].as_array().unwrap();
    // Where the equilibrium attracts weakly, starts are undecided.
    let attractors = bands.iter().filter(|one| !one["band"].is_null());
    assert_eq!(attractors.count(), 2, "{found}");
    let rest = bands
        .iter()
        .find(|one| one["motion"] == "equilibrium")
        .unwrap();
    for (k, published) in [(0, 0.0), (6, 0.213), (8, 0.304), (12, 0.4922), (16, 1.0)] {
        let number = |name: &str| rest["shares"][k][name].as_f64().unwrap();
        let theirs: f64 = published * (1.0 - published) / 5000.0;
        let error = number("std_error");
        let bound = 3.0 * (error * error + theirs).sqrt();
        let off = (number("share") - published).abs();
        assert!(off <= bound, "{k}: {}", rest["shares"][k]);
    }
}
