//! Branches of periodic orbits by the program, compared with known results.

use std::f64::consts::{LN_10, PI};
use std::path::Path;

use assert_cmd::Command;
use predicates::str::contains;
use serde_json::Value;

use crate::public_cases::results;

fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.current_dir(folder).arg("continue").args(arguments);
    command
}

/// The program's output for a branch, and the rows of `branch.csv` and of `special.csv` with the
/// names of their columns.
fn with_special(arguments: &[&str]) -> (Value, Vec<Value>, Vec<Value>) {
    let top = tempfile::tempdir().unwrap();
    let output = program(top.path(), arguments)
        .arg("--json")
        .assert()
        .success();
    let json = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let folder = top.path().join("stickslip-output/continue");
    let svg = std::fs::read_to_string(folder.join("continue.svg")).unwrap();
    roxmltree::Document::parse(&svg).unwrap();
    let [branch, special] = ["branch.csv", "special.csv"].map(|name| rows(&folder.join(name)));
    (json, branch, special)
}

fn rows(table: &Path) -> Vec<Value> {
    let mut rows = csv::Reader::from_path(table).unwrap();
    let heading = rows.headers().unwrap().clone();
    let rows = rows.records().map(|row| {
        let row = row.unwrap();
        let fields = heading.iter().zip(row.iter());
        fields
            .map(|(name, field)| (name.to_owned(), Value::from(field)))
            .collect()
    });
    rows.collect()
}

fn number(row: &Value, column: &str) -> f64 {
    row[column].as_str().unwrap().parse().unwrap()
}

fn special(json: &Value) -> Vec<(String, f64)> {
    let special = json["special"].as_array().unwrap().iter();
    special
        .map(|at| {
            (
                at["what"].as_str().unwrap().to_owned(),
                at["parameter"].as_f64().unwrap(),
            )
        })
        .collect()
}

/// P16: where the cycle ends, and where the unstable one between it and the fixed point begins.
#[test]
fn both_ends_of_the_cycle_beside_the_fixed_point_are_located() {
    let (json, rows, table) = with_special(&["basins", "--parameter", "vd=1.1:2"]);
    let found = special(&json);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].0, "grazing-sliding");
    // By bisection of orbits from the tangent point, in the library's tests.
    assert!(
        (found[0].1 - 1.836_600_972_31).abs() < 1e-9,
        "{}",
        found[0].1
    );
    let ends = &json["ends"];
    assert_eq!(
        (&ends[0]["stop"], &ends[1]["stop"]),
        (&"range".into(), &"equilibrium".into())
    );
    let hopf = ends[1]["hopf"]["parameter"].as_f64().unwrap();
    assert!((hopf - 0.5 * LN_10).abs() < 1e-9, "{hopf}");
    // The table lists it after all orbits, with the period of the eigenvalues.
    let [graze, end] = table.as_slice() else {
        panic!("{table:?}");
    };
    assert_eq!(
        (&graze["what"], &end["what"]),
        (&"grazing-sliding".into(), &"Hopf".into())
    );
    assert_eq!(
        (number(end, "vd"), number(end, "behind")),
        (hopf, rows.len() as f64)
    );
    let frequency = ends[1]["hopf"]["frequency"].as_f64().unwrap();
    assert!((number(end, "period") * frequency - 2.0 * PI).abs() < 1e-12);
    assert_eq!(number(&rows[0], "vd"), 1.1);
    assert!(number(&rows[0], "x_low") < number(&rows[0], "x_high"));
    let stable = rows.iter().filter(|row| row["stability"] == "stable");
    assert!(stable.clone().all(|row| row["phases"] == "- S"));
    assert!(stable.count() > 20 && rows.last().unwrap()["stability"] == "unstable");
}

/// The slow side of model 1 has a saddle, which the cycle without stick approaches as the belt
/// slows down. A test of the library computes the parameter from the saddle's own orbits.
#[test]
fn a_homoclinic_end_is_named() {
    let (json, rows, table) = with_special(&["belt", "--parameter", "vp=0.1:1"]);
    let [low, high] = [0, 1].map(|k| &json["ends"][k]);
    assert_eq!(
        (&low["stop"], &high["stop"]),
        (&"homoclinic".into(), &"range".into())
    );
    let homoclinic = &low["homoclinic"];
    assert!((homoclinic["parameter"].as_f64().unwrap() - 0.773_996_928_3).abs() < 1e-9);
    let end = &table[0];
    assert_eq!(
        (&end["what"], &end["behind"]),
        (&"homoclinic".into(), &"0".into())
    );
    assert_eq!(number(end, "vp"), homoclinic["parameter"].as_f64().unwrap());
    assert_eq!(
        number(end, "uncertainty"),
        homoclinic["uncertainty"].as_f64().unwrap()
    );
    let [comes, leaves] = ["comes", "leaves"].map(|name| homoclinic[name].as_f64().unwrap());
    // The trace is their sum: the slope of the friction at the saddle.
    let trace = 3f64.sqrt() / 9.0 / (1.773_996_928_3 * 1.773_996_928_3);
    assert!(
        (comes + leaves - trace).abs() < 1e-9 && comes < 0.0,
        "{comes} {leaves}"
    );
    for row in &rows {
        assert_eq!(row["stability"], "stable", "{row}");
    }
}

#[test]
fn a_period_that_is_missing_or_wrong_is_reported() {
    let top = tempfile::tempdir().unwrap();
    let text = include_str!("../../../stickslip-model/systems/den-hartog.toml");
    let without = text.replace("period = \"2*pi/O\"", "");
    let wrong = text.replace("2*pi/O", "2.1*pi/O");
    assert!(without != text && wrong != text);
    std::fs::write(top.path().join("without.toml"), without).unwrap();
    std::fs::write(top.path().join("wrong.toml"), wrong).unwrap();
    for (file, reported) in [
        ("without.toml", "what is its period?"),
        ("wrong.toml", "is not the same after the file's period"),
    ] {
        for arguments in [
            vec!["orbit", file],
            vec!["continue", file, "--parameter", "S=0.1:0.3"],
            vec!["basin", file],
            vec!["bifurcation", file, "--parameter", "S=0.1:0.3"],
            vec!["map", file, "--x", "S=0.1:0.3", "--y", "O=0.6:0.8"],
        ] {
            let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
            command
                .current_dir(top.path())
                .args(arguments)
                .assert()
                .code(2)
                .stderr(contains(reported));
        }
    }
}

#[test]
fn what_cannot_be_continued_is_reported_with_a_remedy() {
    let top = tempfile::tempdir().unwrap();
    for (arguments, reported) in [
        (
            vec!["basins", "--parameter", "vd=1.6:2"],
            "choose it with --set vd=",
        ),
        (
            vec!["basins", "--parameter", "vdd=1:2"],
            "did you mean `vd`",
        ),
        (
            vec!["basins", "--parameter", "vd=2:1"],
            "the lower one first",
        ),
        (
            vec!["basins", "--parameter", "vd=1:2", "--step", "0"],
            "step",
        ),
        (
            vec!["basins", "--parameter", "vd=1:2", "--points", "1"],
            "at least 2",
        ),
    ] {
        program(top.path(), &arguments)
            .assert()
            .code(2)
            .stderr(contains(reported));
    }
}

/// A linear flow about the orbit (cos t, sin t) rotates by 0.3 and grows at the rate p. At p = 0
/// the angle of the multipliers is 0.6π.
const TORUS: &str = r#"
name = "torus"
[states]
x = ""
y = ""
[parameters]
p = -0.1
[contacts.mark]
boundary = "x - 0.2"
[field]
x = "-sin(t) + by_side(mark, p*(x - cos(t)), p*(x - cos(t))) - 0.3*(y - sin(t))"
y = "cos(t) + p*(y - sin(t)) + 0.3*(x - cos(t))"
[time]
period = "2*pi"
[start]
x = 1
y = 0.01
"#;

#[test]
fn a_torus_is_named_in_ascii_for_other_programs() {
    let top = tempfile::tempdir().unwrap();
    std::fs::write(top.path().join("torus.toml"), TORUS).unwrap();
    let output = program(top.path(), &["torus.toml", "--parameter", "p=-0.2:0.2"])
        .arg("--json")
        .assert()
        .success();
    let printed = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    assert!(printed.is_ascii(), "{printed}");
    let json: Value = serde_json::from_str(&printed).unwrap();
    let special = &json["special"][0];
    assert_eq!(special["what"], "Neimark-Sacker");
    assert!(special["parameter"].as_f64().unwrap().abs() < 1e-9);
    assert!((special["angle"].as_f64().unwrap() - 0.6 * PI).abs() < 1e-8);
    // In a linear flow nothing decides.
    assert_eq!(special["criticality"], Value::Null);
    for table in ["branch.csv", "special.csv"] {
        let path = top.path().join("stickslip-output/continue").join(table);
        assert!(std::fs::read_to_string(path).unwrap().is_ascii(), "{table}");
    }
}

/// Three lags under a relay. Either side's equilibrium is on the boundary where the threshold is
/// ±1, and the orbit shrinks to it.
const LAGS: &str = include_str!("../../../stickslip-model/tests/data/lags.toml");

/// A block on a belt whose static friction decreases to the kinetic one.
const WEAK: &str = include_str!("../../../stickslip-model/tests/data/weak-grip.toml");

#[test]
fn ends_of_branches_are_reported_everywhere() {
    let top = tempfile::tempdir().unwrap();
    let path = top.path().join("lags.toml");
    std::fs::write(&path, LAGS).unwrap();
    let file = path.to_str().unwrap();
    let (json, _, table) = with_special(&[file, "--parameter", "b=-2:2"]);
    let ends = json["ends"].as_array().unwrap();
    assert_eq!((ends.len(), table.len()), (2, 2));
    for (end, row) in ends.iter().zip(&table) {
        assert_eq!(end["stop"], "boundary equilibrium");
        assert_eq!(row["what"], "boundary equilibrium");
        assert_eq!(
            number(row, "b"),
            end["boundary_equilibrium"].as_f64().unwrap()
        );
    }
    let mut sweep = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    sweep
        .current_dir(top.path())
        .args(["bifurcation", file, "--parameter", "b=0.95:1.05"])
        .args(["--values", "2", "--duration", "20"])
        .assert()
        .success()
        .stdout(contains("up    at 1: boundary-equilibrium bifurcation"))
        .stdout(contains("down  at 1: boundary-equilibrium bifurcation"));
    let mut orbit = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    orbit
        .current_dir(top.path())
        .args(["orbit", file, "--set", "b=1"])
        .assert()
        .code(1)
        .stderr(contains("comes to the equilibrium (1, "));
    // Static friction below kinetic friction, where the branch has a reason of its own.
    std::fs::write(&path, WEAK).unwrap();
    let (json, _, _) = with_special(&[file, "--parameter", "s=0.9:1.6"]);
    let end = &json["ends"][0];
    assert_eq!(end["stop"], "friction", "{json:#}");
    let error = end["error"].as_str().unwrap();
    let reason = "the static friction of the contact `belt`";
    assert!(error.contains(reason), "{error}");
}

/// A roof that a lag touches.
const LAG: &str = include_str!("../../../stickslip-model/tests/data/lag.toml");

/// An orbit whose period doubles at p = 0.
const DOUBLED: &str = include_str!("../../../stickslip-model/tests/data/doubled.toml");

#[test]
fn branches_that_begin_on_a_branch_have_numbers_in_its_tables() {
    let top = tempfile::tempdir().unwrap();
    let path = top.path().join("doubled.toml");
    std::fs::write(&path, DOUBLED).unwrap();
    let file = path.to_str().unwrap();
    let arguments = [file, "--parameter", "p=-0.2:0.3", "--periods", "1"];
    let run = |more: &[&str]| {
        let command = program(top.path(), &arguments)
            .args(more)
            .arg("--json")
            .assert();
        let output = command.success().get_output().stdout.clone();
        serde_json::from_slice::<Value>(&output).unwrap()
    };
    let json = run(&["--branches"]);
    let [other] = json["branches"].as_array().unwrap().as_slice() else {
        panic!("{json:#}");
    };
    let from = other["from"].as_u64().unwrap() as usize;
    assert_eq!(json["special"][from]["what"], "flip");
    assert_eq!(json["special"][from]["criticality"], "supercritical");
    assert_eq!(
        (&other["parent"], &other["to"]),
        (&Value::from(0), &Value::Null)
    );
    assert_eq!(other["stop"], "range");
    let folder = top.path().join("stickslip-output/continue");
    let read = |name: &str| {
        let mut table = csv::Reader::from_path(folder.join(name)).unwrap();
        let rows: Result<Vec<std::collections::HashMap<String, String>>, _> =
            table.deserialize().collect();
        rows.unwrap()
    };
    let rows = read("branch.csv");
    let counts = ["0", "1"].map(|of| rows.iter().filter(|row| row["branch"] == of).count());
    assert_eq!(
        counts.map(|count| count as u64),
        [&json["points"], &other["points"]].map(|n| n.as_u64().unwrap())
    );
    assert!(read("special.csv").iter().all(|row| row["branch"] == "0"));
    // By default they are not continued.
    let json = run(&[]);
    assert_eq!(json["branches"], Value::Null);
    assert!(!read("branch.csv")[0].contains_key("branch"));
}

/// Downwards, both pairs of values lead to the flip at the value that they share; upwards, the run
/// stays on the orbit that loses its stability there, to rounding.
#[test]
fn a_flip_that_a_value_of_a_diagram_hits_is_reported_once() {
    let top = tempfile::tempdir().unwrap();
    std::fs::write(top.path().join("doubled.toml"), DOUBLED).unwrap();
    let swept = |values: &str, locate: &str, out: &str| -> Value {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
        let arguments = [
            "bifurcation",
            "doubled.toml",
            "--json",
            "--parameter",
            "p=-0.1:0.1",
            "--start",
            "x=1.3",
            "--duration",
            "20",
        ];
        let more = ["--values", values, "--locate", locate, "--out", out];
        command.current_dir(top.path()).args(arguments).args(more);
        let output = command.assert().success();
        serde_json::from_slice(&output.get_output().stdout).unwrap()
    };
    // With 19 values the flip is at the last value of a block.
    for values in ["3", "19"] {
        let json = swept(values, "periodic", values);
        let [change] = json["down"]["changes"].as_array().unwrap().as_slice() else {
            panic!("{:#}", json["down"]["changes"]);
        };
        let change = &change["change"]["multiplier"];
        assert_eq!(change["name"], "flip");
        let [off, uncertainty] =
            ["parameter", "uncertainty"].map(|key| change[key].as_f64().unwrap());
        assert!(off.abs() <= uncertainty && uncertainty < 1e-9, "{off:e}");
    }
    let none = swept("3", "none", "none");
    assert_eq!(none["down"]["changes"], serde_json::json!([]));
}

#[test]
fn curves_in_two_parameters_are_written_and_a_wrong_second_one_is_refused() {
    let top = tempfile::tempdir().unwrap();
    let path = top.path().join("lag.toml");
    std::fs::write(&path, LAG).unwrap();
    let file = path.to_str().unwrap();
    let arguments = [file, "--parameter", "p=0.5:1.2", "--also", "c=0.2:2.5"];
    let output = program(top.path(), &arguments)
        .arg("--json")
        .assert()
        .success();
    let json: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let [curve] = json["curves"].as_array().unwrap().as_slice() else {
        panic!("{json:#}");
    };
    assert_eq!(curve["change"]["sequence"]["name"], "grazing-sliding");
    assert_eq!(curve["stops"], serde_json::json!(["range", "range"]));
    let folder = top.path().join("stickslip-output/continue");
    let mut table = csv::Reader::from_path(folder.join("curves.csv")).unwrap();
    let rows: Vec<std::collections::HashMap<String, String>> =
        table.deserialize().map(Result::unwrap).collect();
    assert_eq!(Some(rows.len() as u64), curve["points"].as_u64());
    let row = &rows[0];
    assert_eq!(row["what"], "grazing-sliding");
    assert!(
        ["c", "p", "period"]
            .iter()
            .all(|key| row[*key].parse::<f64>().is_ok())
    );
    let svg = std::fs::read_to_string(folder.join("curves.svg")).unwrap();
    assert!(svg.contains("grazing-sliding"));
    // What cannot be continued is reported with a remedy.
    let wrong = [
        ("p=0.5:1", "another parameter"),
        ("c=1:2", "--set c="),
        ("d=1:2", "`d`"),
    ];
    for (also, reported) in wrong {
        let arguments = [file, "--parameter", "p=0.5:1.2", "--also", also];
        let output = program(top.path(), &arguments).assert().code(2);
        let error = String::from_utf8(output.get_output().stderr.clone()).unwrap();
        assert!(error.contains(reported), "{also}: {error}");
    }
}

#[test]
fn another_branch_in_the_same_folder_is_refused_and_a_failed_search_leaves_nothing() {
    let top = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| program(top.path(), arguments).assert();
    let range = ["basins", "--parameter", "vd=1.1:2"];
    run(&[&range[..], &["--longest", "1"]].concat()).code(1);
    run(&range).success();
    let table = top.path().join("stickslip-output/continue/branch.csv");
    let whole = std::fs::read(&table).unwrap();
    run(&[&range[..], &["--step", "0.01"]].concat())
        .code(2)
        .stderr(contains(
            "the argument `step` was 0.02 there and is 0.01 now",
        ))
        .stderr(contains("choose another with --out"));
    assert_eq!(std::fs::read(&table).unwrap(), whole);
    run(&range).success();
    assert_eq!(std::fs::read(&table).unwrap(), whole);
}

/// The program's output for the equilibria of a file, with the rows of both tables.
fn equilibria(file: &str, arguments: &[&str]) -> (Value, Vec<Value>, Vec<Value>) {
    let top = tempfile::tempdir().unwrap();
    std::fs::write(top.path().join("system.toml"), file).unwrap();
    let output = program(top.path(), &["system.toml", "--equilibrium", "--json"])
        .args(arguments)
        .assert()
        .success();
    let json = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let folder = top.path().join("stickslip-output/continue");
    let svg = std::fs::read_to_string(folder.join("equilibria.svg")).unwrap();
    roxmltree::Document::parse(&svg).unwrap();
    let tables = ["equilibria.csv", "equilibria-special.csv"];
    let [points, special] = tables.map(|name| rows(&folder.join(name)));
    (json, points, special)
}

/// C7: a block on a treadmill.
const TREADMILL: &str = include_str!("../../../stickslip-model/tests/data/treadmill.toml");

#[test]
fn equilibria_are_written_with_their_special_ones() {
    let (json, points, special) = equilibria(TREADMILL, &["--parameter", "p=-4:4"]);
    let all = json["special"].as_array().unwrap();
    assert_eq!((all.len(), special.len()), (4, 4), "{json:#}");
    for (object, row) in all.iter().zip(&special) {
        assert_eq!(object["what"], row["what"]);
        let parameter = object["parameter"].as_f64().unwrap();
        assert_eq!(parameter, number(row, "p"));
        let modes = [&row["before"], &row["after"]].map(|one| one.as_str().unwrap());
        match row["what"].as_str().unwrap() {
            "Hopf" => assert!(number(row, "frequency") > 0.0 && modes == ["", ""], "{row}"),
            _ => assert!(
                object["boundary"]["turns"] == false && modes.contains(&"S"),
                "{row}"
            ),
        }
    }
    assert!(
        points
            .iter()
            .all(|row| ["+", "-", "S"].contains(&row["mode"].as_str().unwrap()))
    );
    assert!(points.iter().any(|row| row["stability"] == "stable"));
    for end in json["ends"].as_array().unwrap() {
        assert_eq!(end["stop"], "range");
    }
}

/// The normal form of a Bogdanov–Takens point at q = 0: folds lie at p = 0.55 q², and Hopf
/// bifurcations at p = 0.3 q² where q is negative.
const BOGDANOV_TAKENS: &str = r#"
name = "Bogdanov-Takens"
[states]
x = ""
y = ""
[parameters]
p = 0
q = -1
[field]
x = "y"
y = "p - 0.3*q^2 + q*x + x^2 - x*y"
[start]
x = -0.24
y = 0
"#;

#[test]
fn special_equilibria_are_followed_in_two_parameters() {
    let top = tempfile::tempdir().unwrap();
    std::fs::write(top.path().join("system.toml"), BOGDANOV_TAKENS).unwrap();
    let arguments = ["system.toml", "--equilibrium", "--transient", "0", "--json"];
    let ranges = ["--parameter", "p=-1:3", "--also", "q=-2:1"];
    let run = |more: &[&str]| {
        program(top.path(), &arguments[..4])
            .args(ranges)
            .args(more)
            .assert()
            .success()
    };
    let output = run(&["--json"]);
    let json: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let curves = json["curves"].as_array().unwrap();
    assert_eq!(json["also"]["name"], "q");
    let folder = top.path().join("stickslip-output/continue");
    let [points, special] =
        ["curves.csv", "curves-special.csv"].map(|name| rows(&folder.join(name)));
    for (k, curve) in curves.iter().enumerate() {
        let factor = match curve["what"].as_str().unwrap() {
            "Hopf" => 0.3,
            "fold" => 0.55,
            other => panic!("{other}"),
        };
        let own = |row: &&Value| number(row, "curve") == k as f64;
        let own: Vec<&Value> = points.iter().filter(own).collect();
        assert_eq!(own.len() as u64, curve["points"].as_u64().unwrap());
        for row in own {
            assert_eq!(row["what"], curve["what"]);
            let q = number(row, "q");
            assert!((number(row, "p") - factor * q * q).abs() < 1e-11, "{row}");
            if factor == 0.3 {
                let frequency = number(row, "frequency");
                assert!((frequency * frequency + q).abs() < 1e-10, "{row}");
            } else {
                assert_eq!(row["frequency"], "");
            }
        }
    }
    assert_eq!((curves.len(), special.len()), (2, 2), "{json:#}");
    for row in &special {
        assert_eq!(row["what"], "Bogdanov-Takens");
        assert!(
            number(row, "q").abs() <= number(row, "uncertainty_q"),
            "{row}"
        );
        assert!(number(row, "uncertainty_q") < 1e-9, "{row}");
    }
    let svg = std::fs::read_to_string(folder.join("curves.svg")).unwrap();
    roxmltree::Document::parse(&svg).unwrap();
    run(&[])
        .stdout(contains("(its pair of eigenvalues becomes real)"))
        .stdout(contains(": Bogdanov-Takens"));
}

#[test]
fn an_equilibrium_that_is_none_or_one_of_a_set_is_refused() {
    let top = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| program(top.path(), arguments).assert();
    run(&[
        "basins",
        "--equilibrium",
        "--parameter",
        "vd=1.1:2",
        "--start",
        "v=1.9",
    ])
    .code(1)
    .stderr(contains(
        "no equilibrium was found: the run comes to periodic",
    ));
    run(&["den-hartog", "--equilibrium", "--parameter", "O=0.6:0.95"])
        .code(2)
        .stderr(contains(
            "--equilibrium has no effect: the system depends on time",
        ));
    run(&[
        "basins",
        "--equilibrium",
        "--branches",
        "--parameter",
        "vd=1.1:2",
    ])
    .code(2)
    .stderr(contains("cannot be used with"));
    std::fs::write(top.path().join("system.toml"), TREADMILL).unwrap();
    // With the belt at rest, it rests in an interval.
    let rests = [
        "system.toml",
        "--equilibrium",
        "--set",
        "p=0",
        "--start",
        "u=1",
    ];
    run(&[&rests[..], &["--parameter", "p=-1:1", "--transient", "0"]].concat())
        .code(1)
        .stderr(contains("none of a set of equilibria"));
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
