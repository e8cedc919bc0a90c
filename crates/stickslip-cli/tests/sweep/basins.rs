//! `stickslip basin` and `merge`.

use std::collections::BTreeMap;
use std::path::Path;

use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;

use super::common::{files, folder, program, text};

/// A sweep of some blocks that takes a moment.
const SWEEP: [&str; 4] = ["basin", "basins", "--grid", "24x16"];

fn attractors(top: &Path, arguments: &[&str]) -> Vec<Value> {
    let output = program(top)
        .args(["basin", "basins", "--json"])
        .args(arguments)
        .assert()
        .success();
    let json: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    json["attractors"].as_array().unwrap().clone()
}

/// Share and standard error of the equilibrium.
fn equilibrium(attractors: &[Value]) -> (f64, f64) {
    let found = attractors.iter().find(|one| one["motion"] == "equilibrium");
    found.map_or((0.0, 0.0), |one| {
        (
            one["share"].as_f64().unwrap(),
            one["std_error"].as_f64().unwrap(),
        )
    })
}

/// Shares of the fixed point as published with bSTAB's example, from 5000 random starts each.
#[test]
fn shares_are_the_published_ones() {
    let top = folder();
    for (speed, published) in [
        (1.1, 0.0),
        (1.4, 0.213),
        (1.5, 0.304),
        (1.7, 0.4922),
        (1.9, 1.0),
    ] {
        let setting = format!("vd={speed}");
        let arguments = [
            "--set", &setting, "--random", "600", "--tol", "1e-9", "--seed", "7",
        ];
        let out = format!("out {speed}");
        let (share, std_error) = equilibrium(&attractors(
            top.path(),
            &[&arguments[..], &["--out", &out]].concat(),
        ));
        let theirs = published * (1.0 - published) / 5000.0_f64;
        let bound = 3.0 * (std_error * std_error + theirs).sqrt();
        assert!(
            (share - published).abs() <= bound,
            "{speed}: {share} +- {std_error}"
        );
        // 600 starts distinguish 0.2 from 0.3.
        assert!(std_error < 0.021);
    }
}

#[test]
fn other_seeds_are_other_starts_and_the_same_seed_the_same() {
    let top = folder();
    let table = |seed: &str, out: &str| {
        attractors(
            top.path(),
            &["--random", "20", "--seed", seed, "--out", out],
        );
        text(top.path().join(out).join("basin.csv"))
    };
    let one = table("1", "a");
    assert_eq!(table("1", "b"), one);
    assert_ne!(table("2", "c"), one);
    assert_eq!(one.lines().count(), 21);
}

/// At this speed of the belt all starts lead to the focus, slowly. In a short time none is decided;
/// in a long one all are.
#[test]
fn undecided_starts_are_none_of_the_attractors() {
    let top = folder();
    let run = |until: &str, out: &str| {
        let mut program = program(top.path());
        program.args(["basin", "basins", "--set", "vd=1.9", "--grid", "3x2"]);
        program.args(["--until", until, "--out", out]);
        program
    };
    run("5", "short")
        .assert()
        .success()
        .stdout(contains("none  1.0000      0.0000  undecided after 5\n"));
    let output = run("5", "short").arg("--json").assert().success();
    let json: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    assert_eq!(json["attractors"], Value::Array(Vec::new()));
    let [none] = json["no_attractor"].as_array().unwrap().as_slice() else {
        panic!("{json}");
    };
    assert_eq!(
        (&none["motion"], &none["starts"]),
        (&"undecided".into(), &6.into())
    );
    assert_eq!(none["after"], 5.0);
    let rows = |out: &str| {
        let mut rows = csv::Reader::from_path(top.path().join(out).join("basin.csv")).unwrap();
        let rows = rows.records().map(|row| {
            let row = row.unwrap();
            (row[2].to_owned(), row[3].to_owned())
        });
        rows.collect::<Vec<_>>()
    };
    assert_eq!(
        rows("short"),
        vec![(String::new(), "undecided".to_owned()); 6]
    );
    let svg = text(top.path().join("short/basin.svg"));
    assert!(svg.contains("undecided after 5: 100.00 %"));
    run("5000", "long").assert().success();
    assert_eq!(
        rows("long"),
        vec![("1".to_owned(), "equilibrium".to_owned()); 6]
    );
}

#[test]
fn shares_of_the_work_are_merged_to_what_one_run_gives() {
    let top = folder();
    let run = |arguments: &[&str]| {
        program(top.path())
            .args(SWEEP)
            .args(arguments)
            .assert()
            .success()
    };
    run(&["--out", "single", "--threads", "1"]);
    for number in ["1", "2", "3"] {
        run(&["--shard", &format!("{number}/3"), "--out", number])
            .stdout(contains(format!("share {number}/3")))
            .stdout(contains("stickslip merge"));
    }
    let merge = |shares: &[&str]| {
        let mut program = program(top.path());
        program
            .args(["merge", "--out", "merged"])
            .args(shares)
            .assert()
    };
    merge(&["1", "3"])
        .code(1)
        .stderr(contains("5 of 16 blocks are missing: 1, 4, 7, 10, 13"));
    merge(&["1", "2", "3", "nowhere"])
        .code(2)
        .stderr(contains("nowhere"));
    assert!(!top.path().join("merged").exists());
    merge(&["1", "2", "3"])
        .success()
        .stdout(contains("wrote merged/basin.csv"));
    assert!(files(&top.path().join("single")) == files(&top.path().join("merged")));
}

#[test]
fn another_argument_or_system_is_refused_in_the_same_folder() {
    let top = folder();
    program(top.path())
        .args(["new", "mine.toml"])
        .assert()
        .success();
    let sweep = |arguments: &[&str]| {
        let mut program = program(top.path());
        program
            .args([
                "basin",
                "mine.toml",
                "--grid",
                "3x3",
                "--x",
                "x=-1:1",
                "--y",
                "v=-1:1",
            ])
            .args(arguments)
            .assert()
    };
    sweep(&[]).success();
    let before = files(&top.path().join("stickslip-output/basin"));
    sweep(&["--until", "100"])
        .code(2)
        .stderr(contains(
            "the argument `until` was 2000.0 there and is 100.0 now",
        ))
        .stderr(contains("--out"));
    sweep(&["--tol", "1e-9"]).code(2).stderr(contains(
        "the argument `solver.tol` was 1e-12 there and is 1e-9 now",
    ));
    let mine = top.path().join("mine.toml");
    std::fs::write(&mine, text(&mine) + "# more\n").unwrap();
    sweep(&[])
        .code(2)
        .stderr(contains("of the system was"))
        .stderr(contains("# more"));
    assert!(files(&top.path().join("stickslip-output/basin")) == before);
}

#[test]
fn wrong_planes_are_reported() {
    let top = folder();
    for (arguments, message) in [
        (&["--grid", "0x4"][..], "--grid 0x4"),
        (&["--grid", "ten"], "--grid ten"),
        (&["--random", "0"], "'0' for '--random"),
        (&["--x", "y=0:1"], "there is no state `y`"),
        (&["--x", "x=1:0"], "from 1 to 0 is no range"),
        (&["--x", "x"], "there is no `=`"),
        (&["--x", "x=a:1"], "`a` is no number"),
        (&["--y", "x=0:1"], "a plane has two states"),
        (&["--shard", "3/2"], "`3/2` is no share"),
        (&["--until", "0"], "--until 0 is not allowed"),
    ] {
        program(top.path())
            .args(["basin", "basins"])
            .args(arguments)
            .assert()
            .code(2)
            .stderr(contains(message));
    }
    // Nothing was computed from it.
    assert_eq!(std::fs::read_dir(top.path()).unwrap().count(), 0);
    std::fs::write(top.path().join("file"), "precious").unwrap();
    program(top.path())
        .args(SWEEP)
        .args(["--out", "file"])
        .assert()
        .code(1)
        .stderr(contains("it is a file, not a folder").or(contains("Not a directory")));
    assert_eq!(text(top.path().join("file")), "precious");
}

/// A block on a belt, held by a spring with a logarithmic force, which is undefined left of 0.
const LOGARITHM: &str = r#"
name = "log spring"
[states]
x = "m"
v = "m/s"
[parameters]
vp = 0.2
mu = 0.3
[contacts.belt]
boundary = "v - vp"
friction = "mu"
[field]
x = "v"
v = "-ln(x) - friction(belt)"
[start]
x = 1
v = 0
[ranges]
x = [-1, 3]
v = [-0.1, 0.1]
"#;

#[test]
fn starts_outside_the_domain_or_the_bound_lose_nothing_of_the_others() {
    let top = folder();
    std::fs::write(top.path().join("log.toml"), LOGARITHM).unwrap();
    let motions = |arguments: &[&str], folder: &str| {
        let output = program(top.path())
            .args(arguments)
            .args(["--json", "--out", folder])
            .assert();
        let json: Value = serde_json::from_slice(&output.success().get_output().stdout).unwrap();
        let found = json["attractors"]
            .as_array()
            .unwrap()
            .iter()
            .chain(json["no_attractor"].as_array().unwrap());
        let share = |one: &Value| {
            (
                one["motion"].as_str().unwrap().to_owned(),
                one["starts"].as_u64().unwrap(),
            )
        };
        // There may be several attractors of a kind.
        let mut starts = BTreeMap::new();
        for (motion, count) in found.map(share) {
            *starts.entry(motion).or_insert(0) += count;
        }
        starts
    };
    // The centres of two columns of eight lie left of 0.
    let found = motions(&["basin", "log.toml", "--grid", "8x1"], "o");
    assert_eq!(found["failure"], 2, "{found:?}");
    assert_eq!(found.values().sum::<u64>(), 8);
    let found = motions(
        &["basin", "leine", "--x", "x=2e6:3e6", "--grid", "2x1"],
        "p",
    );
    assert_eq!(found["escape"], 2, "{found:?}");
    let plane = ["--x", "vp=0.1:0.2", "--y", "mu=0.2:0.3", "--grid", "2x1"];
    program(top.path())
        .args(["map", "log.toml", "--start", "x=-1", "--out", "m"])
        .args(plane)
        .assert()
        .success();
    let cells = text(top.path().join("m/map.csv"));
    assert_eq!(cells.matches("failure").count(), 2, "{cells}");
}

#[test]
fn more_points_than_any_memory_holds_are_refused() {
    let top = folder();
    for (option, value) in [("--grid", "99999999x99999999"), ("--random", "100000001")] {
        program(top.path())
            .args(["basin", "leine", option, value])
            .assert()
            .code(2)
            .stderr(contains(format!(
                "{option} {value}: these are more than 100000000 points"
            )));
    }
}

/// A drive weaker than friction leaves the block where it is, in one set of equilibria, not in a
/// separate attractor for each position.
#[test]
fn rest_under_a_weak_drive_is_one_attractor() {
    let top = folder();
    let arguments = [
        "basin",
        "den-hartog",
        "--set",
        "S=2",
        "--x",
        "x=-0.9:0.9",
        "--y",
        "v=-0.3:0.3",
    ];
    let output = program(top.path())
        .args(arguments)
        .args(["--grid", "4x4", "--json"])
        .assert()
        .success();
    let json: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let [rest] = &json["attractors"].as_array().unwrap()[..] else {
        panic!("{json:#}");
    };
    assert_eq!(
        (&rest["motion"], &rest["starts"]),
        (&"set of equilibria".into(), &16.into())
    );
}

/// The folder identifies a system by its text, wherever its file is.
#[test]
fn a_system_is_the_same_by_another_path() {
    let top = folder();
    program(top.path())
        .args(["new", "mine.toml"])
        .assert()
        .success();
    let basin = |file: &str| {
        let mut program = program(top.path());
        program.args(["basin", file, "--grid", "3x3"]).assert()
    };
    basin("mine.toml").success();
    std::fs::create_dir(top.path().join("there")).unwrap();
    std::fs::rename(
        top.path().join("mine.toml"),
        top.path().join("there/other.toml"),
    )
    .unwrap();
    basin("./there/other.toml").success();
    let changed = text(top.path().join("there/other.toml"))
        .replace("mu0 = { value = 0.4", "mu0 = { value = 0.5");
    std::fs::write(top.path().join("there/other.toml"), changed).unwrap();
    basin("there/other.toml").failure().stderr(contains(
        "holds another sweep: the argument `parameters.mu0` was 0.4 there and is 0.5 now",
    ));
}
