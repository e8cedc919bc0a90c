//! The program as it is called.

use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;

fn program(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.current_dir(folder);
    command
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn text(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn an_example_is_written_checked_and_run() {
    let top = folder();
    for name in [
        "system.toml",
        "a name with spaces.toml",
        "k=v.toml",
        "θ.toml",
    ] {
        program(top.path())
            .args(["new", name])
            .assert()
            .success()
            .stdout(contains(format!("wrote {name}")));
        program(top.path())
            .args(["check", name])
            .assert()
            .success()
            .stdout(contains("Block on a belt"))
            .stdout(contains("stick zone"));
        let out = format!("output of {name}");
        program(top.path())
            .args(["simulate", name, "--out", &out])
            .assert()
            .success()
            .stdout(contains("stick entry"))
            .stdout(contains(format!("wrote {out}/phases.csv")));
        for file in ["phases.csv", "transitions.csv", "steps.csv", "section.csv"] {
            assert!(
                text(top.path().join(&out).join(file)).lines().count() > 2,
                "{file}"
            );
        }
        for file in ["portrait.svg", "history.svg"] {
            let svg = text(top.path().join(&out).join(file));
            roxmltree::Document::parse(&svg).unwrap();
        }
    }
}

#[test]
fn an_existing_file_is_not_overwritten_by_an_example() {
    let top = folder();
    std::fs::write(top.path().join("mine.toml"), "precious").unwrap();
    program(top.path())
        .args(["new", "mine.toml"])
        .assert()
        .code(2)
        .stderr(contains("mine.toml exists already"));
    assert_eq!(text(top.path().join("mine.toml")), "precious");
}

#[test]
fn every_shipped_model_is_understood_and_runs() {
    let top = folder();
    for name in ["belt", "forced", "bracket", "leine", "basins", "den-hartog"] {
        program(top.path()).args(["check", name]).assert().success();
        let output = program(top.path())
            .args(["simulate", name, "--json", "--out", name])
            .assert()
            .success()
            .get_output()
            .stdout
            .clone();
        let json: serde_json::Value = serde_json::from_slice(&output).unwrap();
        assert_eq!(json["ending"], "end time", "{name}");
        assert!(json["phases"].as_u64().unwrap() > 1, "{name}");
    }
}

#[test]
fn parameters_and_starts_can_be_set() {
    let top = folder();
    program(top.path())
        .args(["check", "leine", "--set", "gamma=0", "--set", "vd=1/4"])
        .assert()
        .success()
        .stdout(contains("gamma = 0  (set)"))
        .stdout(contains("vd = 0.25  (set)"));
    let run = |start: &str| {
        let mut command = program(top.path());
        command.args([
            "simulate", "leine", "--t-end", "5", "--json", "--start", start,
        ]);
        let output = command.assert().success().get_output().stdout.clone();
        let json: serde_json::Value = serde_json::from_slice(&output).unwrap();
        json["x_end"]["x"].as_f64().unwrap()
    };
    assert_ne!(run("x=0.1"), run("x=-0.4"));
}

#[test]
fn wrong_arguments_are_told_with_a_remedy() {
    let top = folder();
    let bad: [(&[&str], &str); 16] = [
        (
            &["simulate", "belt", "--set", "muo=1"],
            "there is no parameter `muo`; did you mean `mu0`?",
        ),
        (
            &["simulate", "belt", "--set", "mu0"],
            "a name, `=` and a value are expected",
        ),
        (
            &["simulate", "belt", "--set", "mu0=much"],
            "the value is no number: unknown name `much`",
        ),
        (
            &["simulate", "belt", "--set", "mu0=1", "--set", "mu0=2"],
            "is set twice",
        ),
        (
            &["simulate", "belt", "--set", "mu0=-1"],
            "mu0 = -1 is not allowed: its range in the file is from 0 to inf",
        ),
        (
            &["simulate", "belt", "--start", "y=1"],
            "there is no state `y`; the states are x, v",
        ),
        (
            &["simulate", "belt", "--tol", "1"],
            "option rtol = 1 is not allowed: it must be between 1e-15 and 0.1",
        ),
        (
            &["simulate", "belt", "--t-end", "-1"],
            "cannot integrate from t = 0 to t = -1",
        ),
        (
            &["simulate", "belt", "--method", "euler"],
            "possible values: taylor, dop853",
        ),
        (&["simulate", "nofile.toml"], "cannot read nofile.toml"),
        (
            &["tangents", "belt", "--along", "y"],
            "there is no state `y`",
        ),
        (
            &["tangents", "belt", "--from", "1", "--to", "0"],
            "the range of `x` from 1 to 0 is empty",
        ),
        (
            &["tangents", "belt", "--contact", "bell"],
            "did you mean `belt`?",
        ),
        (&["orbit", "belt", "--transient", "-1"], "--transient"),
        (
            &["orbit", "den-hartog", "--periods", "0"],
            "an orbit takes one period at least",
        ),
        (
            &["lyapunov", "belt", "--duration", "0"],
            "option duration = 0 is not allowed",
        ),
    ];
    for (arguments, message) in bad {
        program(top.path())
            .args(arguments)
            .assert()
            .code(2)
            .stderr(contains(message))
            .stdout("");
    }
    assert_eq!(std::fs::read_dir(top.path()).unwrap().count(), 0);
}

#[test]
fn a_wrong_file_is_shown_with_line_and_column() {
    let top = folder();
    let example = {
        program(top.path())
            .args(["new", "e.toml"])
            .assert()
            .success();
        text(top.path().join("e.toml"))
    };
    let wrong = example.replace("mu0/(1 + delta*slip)", "mu_0/(1 + delta*slip)");
    let line = wrong
        .lines()
        .position(|line| line.contains("mu_0/"))
        .unwrap()
        + 1;
    std::fs::write(top.path().join("w x.toml"), wrong).unwrap();
    program(top.path())
        .args(["check", "w x.toml"])
        .assert()
        .code(2)
        .stderr(contains("error: unknown name `mu_0`"))
        .stderr(contains(format!("w x.toml:{line}:13")))
        .stderr(contains("help: did you mean `mu0`?"));
}

#[test]
fn an_orbit_that_escapes_is_written_as_far_as_it_went() {
    let top = folder();
    program(top.path())
        .args(["simulate", "forced", "--start", "x=5", "--out", "o"])
        .assert()
        .code(1)
        .stdout(contains("failed"))
        .stderr(contains("the orbit escaped"));
    assert!(text(top.path().join("o/steps.csv")).lines().count() > 3);
}

#[test]
fn an_output_folder_that_cannot_be_made_is_told() {
    let top = folder();
    std::fs::write(top.path().join("taken"), "").unwrap();
    program(top.path())
        .args(["simulate", "belt", "--out", "taken"])
        .assert()
        .code(1)
        .stderr(contains("cannot create folder taken").and(contains("--out")));
}

#[test]
fn tangents_are_listed_and_drawn() {
    let top = folder();
    program(top.path())
        .args(["tangents", "belt", "--out", "o"])
        .assert()
        .success()
        .stdout(contains(" visible tangent point of the field below").count(2));
    assert_eq!(text(top.path().join("o/tangents.csv")).lines().count(), 7);
    assert_eq!(text(top.path().join("o/zones.csv")).lines().count(), 4);
    assert!(text(top.path().join("o/tangents.svg")).contains("<svg"));
}

#[test]
fn a_periodic_orbit_is_found_with_its_phases() {
    let top = folder();
    program(top.path())
        .args(["orbit", "leine", "--out", "o"])
        .assert()
        .success()
        .stdout(contains("stability    stable"))
        .stdout(contains("(the trivial one)"));
    // P15, to the digits that are published; stick takes all that is not along the orbit.
    let orbit = text(top.path().join("o/orbit.csv"));
    let period: f64 = orbit
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!((period - 12.001031294831).abs() < 1e-11, "{period}");
    let multipliers = text(top.path().join("o/multipliers.csv"));
    let moduli: Vec<f64> = multipliers
        .lines()
        .skip(1)
        .map(|line| line.rsplit(',').next().unwrap().parse().unwrap())
        .collect();
    assert!(
        (moduli[0] - 1.0).abs() < 1e-8 && moduli[1] < 1e-9,
        "{moduli:?}"
    );
    let output = program(top.path())
        .args(["orbit", "den-hartog", "--json"])
        .assert()
        .success();
    let json: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    assert_eq!(json["periods_of_drive"], 1);
    assert_eq!(json["stable"], true);
    assert!(["- +", "+ -"].contains(&json["phases"].as_str().unwrap()));
    let highest = json["extremes"]["x"][1].as_f64().unwrap();
    assert!((highest - 1.9277745179).abs() < 1e-6, "{highest}");
}

#[test]
fn exponents_are_measured() {
    let top = folder();
    program(top.path())
        .args([
            "lyapunov",
            "leine",
            "--transient",
            "20",
            "--duration",
            "100",
            "--out",
            "o",
        ])
        .assert()
        .success()
        .stdout(contains("λ2           -∞"));
    assert!(text(top.path().join("o/convergence.csv")).lines().count() > 20);
}

#[test]
fn whoever_stops_reading_is_no_failure() {
    program(folder().path())
        .args(["--help"])
        .assert()
        .success()
        .stdout(contains("stickslip new"));
    program(folder().path()).arg("--version").assert().success();
}

#[cfg(not(feature = "png"))]
#[test]
fn a_program_without_png_says_so() {
    program(folder().path())
        .args(["simulate", "belt", "--png"])
        .assert()
        .code(1)
        .stderr(contains("--features png"));
}

#[cfg(feature = "png")]
#[test]
fn figures_are_also_written_as_png() {
    let top = folder();
    program(top.path())
        .args(["simulate", "belt", "--png", "--out", "o"])
        .assert()
        .success();
    let png = std::fs::read(top.path().join("o/portrait.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
}
