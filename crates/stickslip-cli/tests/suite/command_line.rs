//! The program from the command line.

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
fn derivatives_have_a_row_for_each_step_and_each_transition() {
    let top = folder();
    let simulate = |by: &str| {
        let mut command = program(top.path());
        command.args(["simulate", "belt", "--no-figures", "--out", "run"]);
        command.args(["--derivatives", by]).assert()
    };
    simulate("mu0, x,t0").success();
    let at = |name: &str| text(top.path().join("run").join(name));
    let (found, steps) = (at("derivatives.csv"), at("steps.csv"));
    assert!(found.starts_with("t,dx/dmu0,dx/dx,dx/dt0,dv/dmu0,dv/dx,dv/dt0\n0.0,0.0,1.0,"));
    assert_eq!(found.lines().count(), steps.lines().count());
    let (events, transitions) = (at("event_derivatives.csv"), at("transitions.csv"));
    assert!(events.starts_with("t,kind,contact,dt/dmu0,dt/dx,dt/dt0,before_dx/dmu0,"));
    assert_eq!(events.lines().count(), transitions.lines().count());
    // An autonomous orbit that begins later is later throughout.
    for row in events.lines().skip(1) {
        let later: f64 = row.split(',').nth(5).unwrap().parse().unwrap();
        assert!((later - 1.0).abs() < 1e-6, "{row}");
    }
    // Passages of the section of a file have a table of their own.
    program(top.path())
        .args(["new", "own.toml"])
        .assert()
        .success();
    program(top.path())
        .args(["simulate", "own.toml", "--no-figures", "--out", "run"])
        .args(["--derivatives", "t0,x"])
        .assert()
        .success();
    let (found, section) = (at("section_derivatives.csv"), at("section.csv"));
    assert!(found.starts_with("t,dt/dt0,dt/dx,dx/dt0,dx/dx,dv/dt0,dv/dx\n"));
    assert_eq!(found.lines().count(), section.lines().count());
    assert!(found.lines().count() > 2);
    for (row, passage) in found.lines().zip(section.lines()).skip(1) {
        let later: f64 = row.split(',').nth(1).unwrap().parse().unwrap();
        assert!((later - 1.0).abs() < 1e-6, "{row}");
        assert_eq!(row.split(',').next(), passage.split(',').next());
    }
    for (by, said) in [
        (
            "mu",
            "--derivatives mu: `mu` is neither a parameter nor a state: did you mean `mu0`?",
        ),
        ("x,x", "`x` is given twice"),
    ] {
        simulate(by).code(2).stderr(contains(said));
    }
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
fn wrong_arguments_are_reported_with_a_remedy() {
    let top = folder();
    let bad: [(&[&str], &str); 36] = [
        (
            &["simulate", "belt", "--set", "muo=1"],
            "there is no parameter `muo`; did you mean `mu0`?",
        ),
        (
            &["basin", "belt", "--start", "v=0.1"],
            "--start v=… has no effect: the starts go through v",
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
            "--tol 1 is not allowed: it must be between 1e-15 and 0.1",
        ),
        (
            &["simulate", "belt", "--atol", "v=-1e-9"],
            "--atol -1e-9 is not allowed: it must be between 1e-280 and 0.1",
        ),
        (
            &["simulate", "belt", "--atol", "NaN"],
            "--atol NaN: a number is expected, or a state, `=` and a number",
        ),
        (
            &["simulate", "belt", "--atol", "y=1e-9"],
            "there is no state `y`; the states are x, v",
        ),
        (
            &["simulate", "belt", "--atol", "v=1e-9", "--atol", "v=1e-8"],
            "--atol v=1e-8: the state `v` is set twice",
        ),
        (
            &["simulate", "belt", "--atol", "1e-9", "--atol", "1e-8"],
            "--atol 1e-8: that of all states is set twice",
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
        (&["simulate", "forcd"], "did you mean `forced`?"),
        (&["check", "dem-hartog"], "did you mean `den-hartog`?"),
        (
            &["simulate", "belt", "--start", "x=1", "--start", "x=2"],
            "the state `x` is set twice",
        ),
        // A number outside the bounds is still a number.
        (
            &["simulate", "belt", "--tol", "-1e-9"],
            "--tol -1e-9 is not allowed: it must be between 1e-15 and 0.1",
        ),
        (
            &["simulate", "belt", "--longest-step", "-1e-2"],
            "--longest-step -0.01 is not allowed: it must be positive",
        ),
        (
            &["basin", "basins", "--until", "-1e3"],
            "--until -1000 is not allowed: it must be positive and finite",
        ),
        (
            &[
                "continue",
                "belt",
                "--parameter",
                "mu0=0:1",
                "--step",
                "-1e-2",
            ],
            "--step -0.01 is not allowed: it must be positive and at most 1",
        ),
        (
            &[
                "bifurcation",
                "belt",
                "--parameter",
                "mu0=0:1",
                "--values",
                "-3",
            ],
            "invalid value '-3' for '--values <NUMBER>': a whole number is expected, 1 at least",
        ),
        (
            &[
                "map", "basins", "--x", "vd=1:2", "--y", "d=0:1", "--grid", "-3x4",
            ],
            "--grid -3x4: numbers of columns and rows are expected, both at least 1",
        ),
        (
            &["basin", "basins", "--random", "9", "--seed", "-1"],
            "invalid value '-1' for '--seed <SEED>': a whole number is expected, 0 at least",
        ),
        // Options that would have no effect are refused.
        (
            &["orbit", "leine", "--periods", "2"],
            "--periods 2 has no effect: the system does not depend on time",
        ),
        (
            &["orbit", "den-hartog", "--longest", "5"],
            "--longest 5 has no effect: the system depends on time",
        ),
        (
            &[
                "simulate",
                "leine",
                "--no-steps",
                "--no-figures",
                "--observe",
                "q=x",
            ],
            "--observe q=x has no effect: neither steps nor pictures are written",
        ),
        (
            &["basin", "basins", "--seed", "4"],
            "--seed 4 has no effect on a grid",
        ),
        (&["orbit", "belt", "--transient", "-1"], "--transient"),
        (
            &["orbit", "den-hartog", "--periods", "0"],
            "an orbit takes one period at least",
        ),
        (
            &["lyapunov", "belt", "--duration", "0"],
            "--duration 0 is not allowed: it must be positive and finite",
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
fn a_negative_value_is_a_value() {
    let top = folder();
    for arguments in [
        ["--start", "x=-1"],
        ["--start", "v=-1e-1"],
        ["--t-start", "-1e1"],
    ] {
        program(top.path())
            .args(["simulate", "belt", "--t-end", "5", "--out", "o"])
            .args(arguments)
            .assert()
            .success();
    }
    program(top.path())
        .args([
            "tangents", "belt", "--from", "-1", "--to", "-0.5", "--out", "o",
        ])
        .assert()
        .success()
        .stdout(contains("from -1 to -0.5"));
}

#[test]
fn a_folder_is_not_named_after_an_option() {
    let top = folder();
    program(top.path())
        .args(["simulate", "belt", "--out", "--json"])
        .assert()
        .code(2)
        .stderr(contains("a value is required for '--out <DIR>'"));
    assert_eq!(std::fs::read_dir(top.path()).unwrap().count(), 0);
}

/// Runs a command and reads the JSON that it prints.
fn json(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let mut program = program(folder);
    let output = program.args(arguments).arg("--json").assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[test]
fn what_was_understood_and_written_is_reported_as_json_too() {
    let top = folder();
    let written = json(top.path(), &["new", "mine.toml"]);
    assert_eq!(written, serde_json::json!({ "files": ["mine.toml"] }));
    let mine = json(top.path(), &["check", "mine.toml"]);
    assert_eq!(mine["system"]["name"], "Block on a belt");
    // The file is checked with the values that are set.
    let found = json(top.path(), &["check", "leine", "--set", "vd=1/4"]);
    assert_eq!(found["system"]["parameters"]["vd"], 0.25);
    let all = |name: &str| found[name].as_array().unwrap().clone();
    let vd = all("parameters")
        .into_iter()
        .find(|one| one["name"] == "vd");
    let vd = vd.unwrap();
    assert_eq!((&vd["value"], &vd["in_file"]), (&0.25.into(), &0.2.into()));
    let states = all("states");
    assert_eq!((states.len(), &states[1]["name"]), (2, &"v".into()));
    let contacts = all("contacts");
    assert_eq!(contacts.len(), 1);
    // At v = 0 the block is slower than the belt.
    assert_eq!(contacts[0]["start"]["height"], -0.25);
    assert_eq!(contacts[0]["start"]["side"], "below");
    assert_eq!(
        all("field")[0],
        serde_json::json!({ "state": "x", "rate": "v" })
    );
    assert_eq!(found["time"]["depends_on_time"], false);
    // Static friction 1 and a spring of 1: it sticks up to x = 1 on either side.
    let boundary = &found["boundary"];
    assert_eq!(boundary["zones"][0]["kind"], "stick");
    let ends = ["from", "to"].map(|end| boundary["zones"][0][end].as_f64().unwrap());
    assert!((ends[0] + 1.0).abs() < 1e-12 && (ends[1] - 1.0).abs() < 1e-12);
    assert_eq!(boundary["tangent_points"].as_array().unwrap().len(), 2);
    let driven = json(top.path(), &["check", "den-hartog", "--set", "O=0.5"]);
    assert_eq!(driven["time"]["depends_on_time"], true);
    assert_eq!(driven["time"]["period"], 4.0 * std::f64::consts::PI);
}

/// Files that integrate without errors but are probably not meant.
#[test]
fn a_formula_of_very_many_terms_is_shown_by_its_ends() {
    let top = folder();
    let system = |terms: usize| {
        let sum = vec!["sin(x)"; terms].join(" + ");
        let file = format!("name = \"s\"\n[states]\nx = \"\"\n[field]\nx = \"{sum} - 7*x\"\n");
        std::fs::write(top.path().join("s.toml"), file).unwrap();
    };
    system(30_000);
    let found = program(top.path())
        .args(["check", "s.toml"])
        .output()
        .unwrap();
    let found = String::from_utf8(found.stdout).unwrap();
    assert!(found.len() < 3000, "{}", found.len());
    // 30 000 terms of 9 characters, four at the end, and the name of the rate, without 2000.
    assert!(found.contains(" (268011 characters left out) "), "{found}");
    assert!(found.contains("dx/dt = sin(x) + sin(x)") && found.contains("sin(x) - 7*x\n"));
    let whole = json(top.path(), &["check", "s.toml"]);
    assert!(whole["field"][0]["rate"].as_str().unwrap().len() > 200_000);
    system(200);
    let short = program(top.path()).args(["check", "s.toml"]).assert();
    short.stdout(contains("left out").not());
}

#[test]
fn a_period_that_is_none_is_warned_of() {
    const DRIVEN: &str = r#"
name = "driven"
[states]
x = "m"
v = "m/s"
[parameters]
w = 2
[contacts.ground]
boundary = "v"
friction = "0.1"
[field]
x = "v"
v = "cos(w*t) - x - friction(ground)"
[start]
x = 1
v = 0
[time]
period = "2*pi/w"
"#;
    let top = folder();
    for (period, warnings) in [("2*pi/w", 0), ("4*pi/w", 0), ("2.2*pi/w", 1)] {
        let text = DRIVEN.replace("2*pi/w", period);
        std::fs::write(top.path().join("driven.toml"), text).unwrap();
        let found = json(top.path(), &["check", "driven.toml"]);
        let doubtful = found["doubtful"].as_array().unwrap();
        assert_eq!(doubtful.len(), warnings, "{doubtful:?}");
        let wanted = "not the same after the file's period 3.45";
        assert!(
            doubtful
                .iter()
                .all(|one| one.as_str().unwrap().contains(wanted))
        );
    }
}

#[test]
fn friction_of_the_wrong_sign_or_less_at_rest_is_warned_of() {
    let top = folder();
    program(top.path())
        .args(["new", "mine.toml"])
        .assert()
        .success();
    let right = text(top.path().join("mine.toml"));
    let warnings = |replaced: &str, by: &str| {
        assert!(right.contains(replaced));
        let name = top.path().join("other.toml");
        std::fs::write(&name, right.replace(replaced, by)).unwrap();
        let found = json(top.path(), &["check", "other.toml"]);
        let warnings = found["doubtful"].as_array().unwrap().clone();
        let reported = program(top.path())
            .args(["check", "other.toml"])
            .assert()
            .success();
        let reported = String::from_utf8(reported.get_output().stdout.clone()).unwrap();
        assert_eq!(reported.contains("doubtful"), !warnings.is_empty());
        warnings
    };
    let law = "friction(belt))";
    assert_eq!(warnings(law, law), [""; 0]);
    let [driving] = &warnings("- friction(belt))", "+ friction(belt))")[..] else {
        panic!("one doubt is expected");
    };
    let driving = driving.as_str().unwrap();
    // Friction of 0.4 on either side.
    assert!(
        driving.contains("drives the slip") && driving.contains("larger by 0.8 above than below"),
        "{driving}"
    );
    let commented = "# static = \"1.5*mu0\"";
    assert_eq!(warnings(commented, "static = \"1.5*mu0\""), [""; 0]);
    let [less] = &warnings(commented, "static = \"0.5*mu0\"")[..] else {
        panic!("one doubt is expected");
    };
    let less = less.as_str().unwrap();
    assert!(
        less.contains("takes 0.4 of the rate") && less.contains("in slip 0.8"),
        "{less}"
    );
    // Kinetic friction at zero velocity equals the static one up to rounding, also beside a large
    // force.
    let same = "static = \"mu0*(0.09*m)/(0.09*m)\"";
    assert_eq!(warnings(commented, same), [""; 0]);
    let start = "[start]\nx = 0.5";
    assert!(right.contains(start));
    let far = right
        .replace(commented, same)
        .replace(start, "[start]\nx = \"1e6/3\"");
    std::fs::write(top.path().join("far.toml"), far).unwrap();
    let found = json(top.path(), &["check", "far.toml"]);
    assert_eq!(found["doubtful"], serde_json::json!([]));
}

#[test]
fn check_and_simulate_report_the_jumps_at_a_start() {
    let top = folder();
    let text = "name = \"beats\"\n[states]\nx = \"\"\n[discrete]\nn = 0\n\
                [jumps.beat]\nwhen = \"sin(t)\"\ndirection = \"rising\"\nset = { n = \"n + 1\" }\n\
                [jumps.level]\nwhen = \"x\"\nset = { n = \"n + 1\" }\n\
                [field]\nx = \"1\"\n[start]\nx = 0\n";
    std::fs::write(top.path().join("beats.toml"), text).unwrap();
    let checked = json(top.path(), &["check", "beats.toml"]);
    assert_eq!(checked["jumps_at_start"], serde_json::json!(["level"]));
    let ran = json(
        top.path(),
        &["simulate", "beats.toml", "--until", "1", "--no-figures"],
    );
    for found in [&checked, &ran] {
        let [done] = &found["doubtful"].as_array().unwrap()[..] else {
            panic!("{found}");
        };
        assert!(
            done.as_str()
                .unwrap()
                .contains("the jump beat is due by time alone")
        );
    }
    let lines = program(top.path())
        .args(["check", "beats.toml"])
        .assert()
        .success();
    let lines = String::from_utf8(lines.get_output().stdout.clone()).unwrap();
    assert!(lines.contains("level happens at once"), "{lines}");
}

#[test]
fn friction_of_a_single_state_is_checked() {
    let top = folder();
    for (sign, warnings) in [("+", 1), ("-", 0)] {
        let text = format!(
            "name = \"slides\"\n[states]\nv = \"\"\n[contacts.floor]\nboundary = \"v - 1\"\n\
             friction = \"0.4\"\n[field]\nv = \"{sign}friction(floor)\"\n[start]\nv = 3\n"
        );
        std::fs::write(top.path().join("slides.toml"), text).unwrap();
        let found = json(top.path(), &["check", "slides.toml"]);
        let doubtful = found["doubtful"].as_array().unwrap();
        assert_eq!(doubtful.len(), warnings, "{doubtful:?}");
        let drives = |one: &serde_json::Value| one.as_str().unwrap().contains("by 0.8 above");
        assert!(doubtful.iter().all(drives), "{doubtful:?}");
    }
}

#[test]
fn a_jump_past_its_zero_at_the_start_is_warned_of() {
    const ROOM: &str = r#"
name = "room"
[states]
T = "C"
[discrete]
heater = 0
[jumps.on]
when = "T - 19"
direction = "falling"
set = { heater = "1" }
[jumps.off]
when = "T - 21"
direction = "rising"
set = { heater = "0" }
[jumps.clock]
when = "cos(t)"
direction = "rising"
set = { heater = "1" }
[field]
T = "10*heater - (T - 5)/10"
[start]
T = 18
"#;
    let top = folder();
    let doubtful = |from: &str, to: &str| {
        assert!(ROOM.contains(from));
        std::fs::write(top.path().join("room.toml"), ROOM.replace(from, to)).unwrap();
        let found = json(top.path(), &["check", "room.toml"]);
        found["doubtful"].as_array().unwrap().clone()
    };
    let [cold] = &doubtful("T = 18", "T = 18")[..] else {
        panic!("one doubt is expected");
    };
    let cold = cold.as_str().unwrap();
    assert!(
        cold.contains("the jump on") && cold.contains("T - 19") && cold.contains("negative (-1)"),
        "{cold}"
    );
    // With the heater on, and where the jump is ahead.
    assert_eq!(doubtful("heater = 0", "heater = 1"), [""; 0]);
    assert_eq!(doubtful("T = 18", "T = 20"), [""; 0]);
    assert_eq!(doubtful("falling", "both"), [""; 0]);
}

#[test]
fn a_run_that_comes_to_rest_is_no_periodic_orbit_and_is_reported_where() {
    let top = folder();
    // x = F(-vd) = (1 + e^(-2 vd))/2.
    let rest = 0.5 + 0.5 * stickslip::math::exp(-3.8);
    for transient in ["200", "20000"] {
        for command in [&["orbit"][..], &["continue", "--parameter", "vd=1:2"]] {
            program(top.path())
                .args(command)
                .args(["basins", "--set", "vd=1.9", "--transient", transient])
                .assert()
                .code(1)
                .stdout("")
                .stderr(contains("no periodic orbit was found"))
                .stderr(contains(format!("the equilibrium ({rest:.7}, 0)")))
                .stderr(contains("--start"))
                .stderr(contains("residual").not());
        }
    }
    assert_eq!(std::fs::read_dir(top.path()).unwrap().count(), 0);
}

#[test]
fn an_orbit_that_takes_longer_than_asked_to_come_back_is_reported_with_its_period() {
    let top = folder();
    program(top.path())
        .args(["orbit", "belt", "--longest", "3"])
        .assert()
        .code(1)
        .stderr(contains("comes back within 3"))
        .stderr(contains("one of period 7.722"))
        .stderr(contains("--longest"));
}

/// The position of a block that another one carries: nothing depends on it.
#[test]
fn a_place_that_nothing_depends_on_keeps_no_orbit_from_being_found() {
    let top = folder();
    let text = r#"
name = "carried"
[time]
period = "2.5*pi"
[states]
x = ""
v = ""
place = ""
upper = ""
[contacts.floor]
boundary = "v"
friction = "0.3"
[contacts.top]
boundary = "upper - v"
friction = "0.5"
[field]
x = "v"
v = "cos(0.8*t) - x - friction(floor) + friction(top)"
place = "upper"
upper = "-5*friction(top)"
[start]
x = 0
v = 0
place = 0
upper = 0
"#;
    std::fs::write(top.path().join("carried.toml"), text).unwrap();
    let found = json(top.path(), &["orbit", "carried.toml"]);
    assert_eq!(found["stability"], "neutral");
    assert!(found["residual"].as_f64().unwrap() < 1e-9, "{found}");
}

/// Two blocks on a belt, each with its own friction.
const TWO: &str = r#"
name = "two"
[states]
x1 = ""
v1 = ""
x2 = ""
v2 = ""
[parameters]
hold = 1
[contacts.upper]
boundary = "v1 - 0.2"
friction = "1/(1 + 3*upper*(v1 - 0.2))"
[contacts.lower]
boundary = "v2 - 0.2"
friction = "1"
static = "hold"
[field]
x1 = "v1"
v1 = "-x1 - friction(upper)"
x2 = "v2"
v2 = "-x2 - friction(lower)"
[start]
x1 = 1
v1 = 0
x2 = 0
v2 = 0
[time]
end = 20
[ranges]
x1 = [-1, 1]
v1 = [-1, 1]
"#;

/// With a drive weaker than friction, the block comes to rest, too.
#[test]
fn rest_under_a_drive_is_no_periodic_orbit() {
    let top = folder();
    let driven = ["den-hartog", "--set", "S=2", "--start", "v=0.5"];
    for command in [&["orbit"][..], &["continue", "--parameter", "S=1.5:3"]] {
        program(top.path())
            .args(command)
            .args(driven)
            .assert()
            .code(1)
            .stderr(contains(
                "no periodic orbit was found: the run comes to rest at (0.117",
            ))
            .stderr(contains("against the drive"));
    }
}

#[test]
fn contacts_are_spoken_of_by_their_names() {
    let top = folder();
    std::fs::write(top.path().join("two.toml"), TWO).unwrap();
    program(top.path())
        .args(["basin", "two.toml", "--at-repelling", "below"])
        .assert()
        .code(2)
        .stderr(contains(
            "--at-repelling has no effect on a system of several contacts",
        ));
    let message = "the static friction of the contact `lower`";
    let weak = ["two.toml", "--set", "hold=0.5"];
    for command in ["simulate", "orbit", "lyapunov"] {
        program(top.path())
            .arg(command)
            .args(weak)
            .assert()
            .code(1)
            .stderr(contains(message))
            .stderr(contains("contact 1").not());
    }
    program(top.path())
        .arg("basin")
        .args(weak)
        .args(["--grid", "2x2", "--out", "b"])
        .assert()
        .success()
        .stdout(contains("none  1.0000").and(contains(message)));
    let found = json(top.path(), &["simulate", "two.toml"]);
    let transitions = found["transitions"].as_array().unwrap();
    for name in ["upper", "lower"] {
        assert!(transitions.iter().any(|at| at["contact"] == name), "{name}");
    }
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

/// What rounding adds to a number is shown to programs alone.
#[test]
fn numbers_are_printed_without_rounding_errors() {
    let top = folder();
    let set = ["check", "belt", "--set", "vp=3*0.15"];
    program(top.path())
        .args(set)
        .assert()
        .success()
        .stdout(contains("vp = 0.45  m/s"));
    let json = json(top.path(), &set);
    let parameters = json["parameters"].as_array().unwrap();
    let vp = parameters.iter().find(|one| one["name"] == "vp").unwrap();
    assert_eq!(vp["value"], 3.0 * 0.15);
    assert_ne!(vp["value"], 0.45);
}

#[test]
fn an_undefined_formula_is_named_with_the_values_in_it() {
    let file = |definition: &str, friction: &str, rate: &str| {
        format!(
            "name = \"test\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nk = 2\n\
             [definitions]\nspring = \"{definition}\"\n\
             [contacts.belt]\nboundary = \"v - 1\"\nfriction = \"{friction}\"\n\
             [field]\nx = \"v\"\nv = \"{rate} - spring - friction(belt)\"\n\
             [start]\nx = 0.5\nv = 0\n[time]\nend = 1\n"
        )
    };
    let cases = [
        (
            file("k*x", "0.4", "ln(x - 3)"),
            "in `v` of [field], `ln(x - 3)` is not a number where `x - 3` is -2.5",
        ),
        (
            file("k/v", "0.4", "1"),
            "in `spring` of [definitions], `k/v` is infinite where `k` is 2 and `v` is 0",
        ),
        (
            file("k*x", "sqrt(belt*x)", "1"),
            "in `friction` of [contacts.belt], `sqrt(belt*x)` is not a number where `belt*x` is \
             -0.5",
        ),
    ];
    for (text, wanted) in cases {
        let top = folder();
        std::fs::write(top.path().join("a.toml"), text).unwrap();
        program(top.path())
            .args(["simulate", "a.toml"])
            .assert()
            .code(1)
            .stderr(contains(wanted))
            .stderr(contains("cannot start at t = 0, x = (0.5, 0)"));
    }
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
fn an_output_folder_that_cannot_be_made_is_reported() {
    let top = folder();
    std::fs::write(top.path().join("taken"), "").unwrap();
    program(top.path())
        .args(["simulate", "belt", "--out", "taken"])
        .assert()
        .code(1)
        .stderr(contains("cannot create folder taken").and(contains("--out")));
}

/// A block on another on the ground, both of mass 1, pulled by t. The ground releases at 2 and
/// brakes with 1 afterwards. Together they would start at 1/2 then, but the upper one is held with
/// 0.2 only.
const STACKED: &str = r#"
name = "stacked"
[states]
v1 = "m/s"
v2 = "m/s"
[parameters]
T = 1
[contacts.ground]
boundary = "v1"
friction = "1"
static = "2"
[contacts.top]
boundary = "v2 - v1"
friction = "0.2"
[field]
v1 = "t - friction(ground) + friction(top)"
v2 = "-friction(top)"
[start]
v1 = 0
v2 = 0
[time]
start = "T - 1"
end = "3*T"
"#;

#[test]
fn a_contact_that_another_one_lets_go_has_a_transition_of_its_own() {
    let top = folder();
    std::fs::write(top.path().join("stacked.toml"), STACKED).unwrap();
    let found = json(top.path(), &["simulate", "stacked.toml"]);
    let transitions = found["transitions"].as_array().unwrap();
    let reported: Vec<(&str, &str)> = transitions
        .iter()
        .map(|at| ["contact", "kind"].map(|name| at[name].as_str().unwrap()))
        .map(|[contact, kind]| (contact, kind))
        .collect();
    assert_eq!(reported, [("ground", "stick exit"), ("top", "stick exit")]);
    for at in transitions {
        assert!((at["t"].as_f64().unwrap() - 2.0).abs() < 1e-12);
        assert_eq!((&at["from"], &at["to"]), (&"S|S".into(), &"+|-".into()));
    }
    let end = ["v1", "v2"].map(|state| found["x_end"][state].as_f64().unwrap());
    assert!(
        (end[0] - 1.3).abs() < 1e-9 && (end[1] - 0.2).abs() < 1e-9,
        "{end:?}"
    );
}

#[test]
fn the_times_of_a_run_are_expressions_of_parameters() {
    let top = folder();
    std::fs::write(top.path().join("stacked.toml"), STACKED).unwrap();
    for (set, start, end) in [("T=1", 0.0, 3.0), ("T=5/4", 0.25, 3.75)] {
        let found = json(top.path(), &["simulate", "stacked.toml", "--set", set]);
        assert_eq!(
            (&found["t_start"], &found["t_end"]),
            (&start.into(), &end.into())
        );
        let found = json(top.path(), &["check", "stacked.toml", "--set", set]);
        assert_eq!(
            (&found["time"]["start"], &found["time"]["end"]),
            (&start.into(), &end.into())
        );
    }
    program(top.path())
        .args(["simulate", "stacked.toml", "--set", "T=-1"])
        .assert()
        .code(2)
        .stderr(contains("the end -3 does not lie after the start -2"));
}

/// A run cannot continue where the boundaries of two contacts coincide.
#[test]
fn boundaries_that_depend_on_each_other_are_warned_of() {
    let top = folder();
    let warnings = |boundaries: [&str; 3]| {
        let [a, b, c] = boundaries;
        let text = format!(
            r#"
name = "three"
[states]
x = ""
v = ""
w = ""
[contacts.a]
boundary = "{a}"
friction = "1"
[contacts.b]
boundary = "{b}"
friction = "1"
[contacts.c]
boundary = "{c}"
friction = "1"
[field]
x = "v - friction(c)"
v = "-x - friction(a)"
w = "-w - friction(b)"
[start]
x = 0.3
v = 0.2
w = 0.1
"#
        );
        std::fs::write(top.path().join("three.toml"), text).unwrap();
        let found = json(top.path(), &["check", "three.toml"]);
        let warnings = found["doubtful"].as_array().unwrap().iter();
        let warnings = warnings.map(|doubt| doubt.as_str().unwrap().to_owned());
        let depend = |doubt: &String| doubt.contains("depend on each other");
        warnings.filter(depend).collect::<Vec<String>>()
    };
    for boundaries in [
        ["v", "w", "x"],
        // Parallel, and nowhere zero together.
        ["v - 1", "v + 1", "x"],
        ["v", "w*w + 1", "x"],
        ["x", "v", "w - x - v^2"],
    ] {
        assert_eq!(warnings(boundaries), [""; 0], "{boundaries:?}");
    }
    for (boundaries, names) in [
        (["v", "2*v", "x"], "`a`, `b`"),
        (["v", "w", "v + (w - 1)^2*v"], "`a`, `c`"),
        // They touch.
        (["w", "v", "v - 3*(x - 1)^2"], "`b`, `c`"),
        // Any two are independent.
        (["v", "w", "v - w"], "`a`, `b`, `c`"),
    ] {
        let found = warnings(boundaries);
        assert_eq!(found.len(), 1, "{boundaries:?}");
        assert!(
            found[0].contains(&format!("contacts {names} have")),
            "{}",
            found[0]
        );
    }
}

/// A tangent point at zero, which is not a value of the scan.
#[test]
fn no_number_is_a_row_of_zeros() {
    const ORIGIN: &str = r#"
name = "origin"
[states]
x = ""
v = ""
[contacts.belt]
boundary = "v"
[field]
x = "1"
v = { below = "x", above = "x - 1" }
[start]
x = 1e-300
v = "-0"
[time]
start = 1e-300
end = 1
"#;
    let top = folder();
    std::fs::write(top.path().join("origin.toml"), ORIGIN).unwrap();
    for arguments in [
        &["tangents", "origin.toml", "--from", "-1", "--to", "2"][..],
        &["check", "origin.toml"],
        &["simulate", "origin.toml"],
        &["simulate", "origin.toml", "--t-end", "1e-300"],
    ] {
        let run = program(top.path()).args(arguments).output().unwrap();
        let reported = [run.stdout, run.stderr].map(|text| String::from_utf8(text).unwrap());
        let reported = reported.concat();
        assert!(
            !reported.contains("0000000000") && !reported.contains("= -0,"),
            "{arguments:?}: {reported}"
        );
    }
}

#[test]
fn branches_of_a_closed_boundary_are_listed_and_drawn() {
    const CIRCLE: &str = r#"
name = "circle"
[states]
x = ""
y = ""
[contacts.rim]
boundary = "x^2 + y^2 - 2"
[field]
x = { below = "x", above = "1" }
y = { below = "y", above = "-1" }
[start]
x = 0
y = 0.1
[ranges]
x = [-2, 2]
y = [-2, 2]
"#;
    let top = folder();
    std::fs::write(top.path().join("circle.toml"), CIRCLE).unwrap();
    let all = ["tangents", "circle.toml", "--from", "-5", "--to", "5"];
    program(top.path())
        .args(all)
        .args(["--out", "o"])
        .assert()
        .success()
        .stdout(
            contains("branch ")
                .count(2)
                .and(contains("stick zone").count(2)),
        );
    let zones = text(top.path().join("o/zones.csv"));
    assert!(zones.starts_with("kind,x_from,x_to,branch\n"), "{zones}");
    let found = json(top.path(), &all);
    let numbers = |name: &str| -> Vec<i64> {
        let all = found[name].as_array().unwrap().iter();
        all.map(|one| one["branch"].as_i64().unwrap()).collect()
    };
    assert_eq!(found["branches"].as_array().unwrap().len(), 2);
    // The table has the same values as JSON for each point.
    let points = text(top.path().join("o/tangents.csv"));
    assert!(
        points.starts_with("side,visibility,t,x,y,branch\n"),
        "{points}"
    );
    assert_eq!(found["tangent_points"][0]["t"], 0.0);
    assert_eq!(
        (numbers("tangent_points"), numbers("zones")),
        (vec![1, 2], vec![1, 2])
    );
    program(top.path())
        .args(["check", "circle.toml"])
        .assert()
        .success()
        .stdout(contains("branch 2  x from -1.414"));
    program(top.path())
        .args(["tangents", "circle.toml", "--from", "5", "--to", "6"])
        .assert()
        .success()
        .stdout(contains("the boundary has no point there"));
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

/// x'' = cos t - 2 x has no damping: x = cos t repeats, and neighbouring orbits stay beside it.
#[test]
fn an_orbit_without_damping_is_neutral() {
    const UNDAMPED: &str = r#"
name = "undamped"
[states]
x = ""
v = ""
[contacts.stop]
boundary = "x - 5"
[field]
x = "v"
v = "cos(t) - 2*x + by_side(stop, 0, -1)"
[time]
period = "2*pi"
[start]
x = 0.5
v = 0
"#;
    let top = folder();
    std::fs::write(top.path().join("undamped.toml"), UNDAMPED).unwrap();
    let output = program(top.path())
        .args(["orbit", "undamped.toml", "--periods", "1", "--json"])
        .assert()
        .success();
    let json: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    assert_eq!(json["stability"], "neutral");
    let lowest = json["extremes"]["x"][0].as_f64().unwrap();
    assert!((lowest + 1.0).abs() < 1e-6, "{lowest}");
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
    // At a loose tolerance multipliers have fewer digits.
    let loose = program(top.path())
        .args(["orbit", "leine", "--tol", "1e-6", "--out", "loose"])
        .assert()
        .success();
    let loose = String::from_utf8_lossy(&loose.get_output().stdout).into_owned();
    let line = loose
        .lines()
        .find(|line| line.contains("(the trivial one)"));
    let (value, rest) = line.unwrap().split_once('±').unwrap();
    let within = rest.split_whitespace().next().unwrap();
    let decimals = value.trim().split_once('.').unwrap().1.len();
    assert!((3..10).contains(&decimals), "{value}");
    assert!(within.parse::<f64>().unwrap() > 1e-12, "{within}");
    // P15, to the published digits. Stick annihilates all directions except that along the orbit.
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
        .map(|line| line.split(',').nth(2).unwrap().parse().unwrap())
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
    assert_eq!(json["stability"], "stable");
    assert_eq!(json["phases"], "+ -");
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
    let top = folder();
    for arguments in [
        &["simulate", "belt"][..],
        &["basin", "basins"],
        &["merge", "a", "b"],
    ] {
        program(top.path())
            .args(arguments)
            .arg("--png")
            .assert()
            .code(1)
            .stderr(contains("without PNG output"))
            .stderr(contains("--features png"));
    }
    // It is reported before anything is computed.
    assert_eq!(std::fs::read_dir(top.path()).unwrap().count(), 0);
}

#[cfg(feature = "png")]
#[test]
fn figures_are_also_written_as_png() {
    let top = folder();
    let plane = ["--grid", "4x3", "--until", "300"];
    let commands: [(&[&str], &[&str]); 8] = [
        (&["simulate", "belt"], &["history", "portrait"]),
        (&["tangents", "belt"], &["tangents"]),
        (&["orbit", "leine"], &["history", "portrait"]),
        (
            &[
                "lyapunov",
                "leine",
                "--transient",
                "20",
                "--duration",
                "100",
            ],
            &["convergence"],
        ),
        (
            &["continue", "leine", "--parameter", "vd=0.19:0.21"],
            &["continue"],
        ),
        (
            &[
                "bifurcation",
                "leine",
                "--parameter",
                "vd=0.1:0.3",
                "--values",
                "3",
            ],
            &["bifurcation"],
        ),
        (
            &["basin", "basins", plane[0], plane[1], plane[2], plane[3]],
            &["basin"],
        ),
        (
            &[
                "map",
                "basins",
                "--x",
                "vd=1:2",
                "--y",
                "d=0.1:0.2",
                plane[0],
                plane[1],
            ],
            &["map"],
        ),
    ];
    for (arguments, figures) in commands {
        let out = arguments[0];
        program(top.path())
            .args(arguments)
            .args(["--png", "--out", out])
            .assert()
            .success();
        for figure in figures {
            let of = |ending: &str| top.path().join(out).join(format!("{figure}.{ending}"));
            let png = std::fs::read(of("png")).unwrap();
            assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"), "{out} {figure}");
            // Width and height in the header, at twice the size of the drawing.
            let pixels = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
            let svg = text(of("svg"));
            let document = roxmltree::Document::parse(&svg).unwrap();
            let nominal = |name: &str| -> f64 {
                let size = document.root_element().attribute(name).unwrap();
                size.trim_end_matches("px").parse().unwrap()
            };
            for (at, name) in [(16, "width"), (20, "height")] {
                let off = f64::from(pixels(at)) - 2.0 * nominal(name);
                assert!(off.abs() <= 1.0, "{out} {figure}: {name} off by {off}");
            }
        }
    }
}

/// Driving friction: both fields point away from the boundary.
#[test]
fn a_start_without_a_unique_future_is_reported() {
    let top = folder();
    let system = r#"
name = "pushed on"
[states]
x = ""
v = ""
[contacts.belt]
boundary = "v - 0.2"
friction = "0.3"
[field]
x = "v"
v = "-x + friction(belt)"
[start]
x = 0
v = 0.2
[time]
end = 20
"#;
    std::fs::write(top.path().join("s.toml"), system).unwrap();
    for command in ["simulate", "orbit"] {
        program(top.path())
            .args([command, "s.toml", "--out", "o"])
            .assert()
            .code(1)
            .stderr(contains("no unique future").and(contains("--at-repelling")));
    }
    program(top.path())
        .args([
            "simulate",
            "s.toml",
            "--at-repelling",
            "below",
            "--out",
            "o",
        ])
        .assert()
        .success();
}

#[test]
fn friction_that_becomes_negative_is_told_by_check_and_by_a_run() {
    let top = folder();
    // N = -57.7 and less: with this friction no motion of the rod is consistent.
    let rod = r#"
name = "Falling rod"
[states]
x = "m"
th = "rad"
v = "m/s"
om = "rad/s"
[parameters]
mu = 1.5
g = 9.81
[definitions]
N = "(g - om^2*sin(th))/(1 + 3*cos(th)^2 + 3*mu*tip*cos(th)*sin(th))"
T = "-friction(tip)"
al = "3*(T*sin(th) - N*cos(th))"
[contacts.tip]
boundary = "v"
friction = "mu*N"
[jumps.flat]
when = "th - 0.1"
direction = "falling"
stop = true
[field]
x = "v"
th = "om"
v = "T + al*sin(th) + om^2*cos(th)"
om = "al"
[time]
end = 3
"#;
    std::fs::write(top.path().join("rod.toml"), rod).unwrap();
    let start = [
        "--start", "x=0", "--start", "th=1.4", "--start", "v=0", "--start", "om=0",
    ];
    let found = json(top.path(), &[&["check", "rod.toml"], &start[..]].concat());
    assert_eq!(found["states"][1]["start"], 1.4);
    assert_eq!(found["doubtful"].as_array().unwrap().len(), 0, "{found}");
    // Where it spins fast enough, the tip would lift.
    let spun = [
        &["check", "rod.toml"],
        &start[..6],
        &["--start", "om=4", "--t-start", "1"],
    ];
    let found = json(top.path(), &spun.concat());
    let doubt = found["doubtful"][0].as_str().unwrap();
    assert!(
        doubt.contains("friction of tip is negative at t = 1, -"),
        "{doubt}"
    );
    // Where a run fails, the error tells it: friction drives the slip there.
    let failing = [
        "--start", "x=0", "--start", "th=1", "--start", "v=-0.1", "--start", "om=0",
    ];
    for command in ["simulate", "orbit"] {
        let mut run = program(top.path());
        run.args([command, "rod.toml", "--out", "failed"])
            .args(failing);
        let told = contains("the step collapsed")
            .and(contains("the friction of tip is negative at t = 0.05"));
        run.assert().failure().stderr(told);
    }
    // At 1 rad N is -57.7 as long as the tip slips to the left.
    let paradox = [
        "--start", "x=0", "--start", "th=1", "--start", "v=-0.1", "--start", "om=0",
    ];
    let until = ["simulate", "rod.toml", "--until", "1e-4", "--out", "o"];
    let run = [&until, &paradox[..]].concat();
    let doubt = json(top.path(), &run)["doubtful"][0]
        .as_str()
        .map(str::to_owned);
    let doubt = doubt.unwrap_or_default();
    assert!(
        doubt.contains("friction of tip is negative at t = "),
        "{doubt}"
    );
    program(top.path())
        .args(["check", "rod.toml", "--start", "x=0"])
        .assert()
        .code(2)
        .stderr(contains("the start has no value of `th`"));
    program(top.path())
        .args(["check", "rod.toml"])
        .assert()
        .success();
}

#[test]
fn derivatives_of_a_periodic_orbit_are_reported_with_their_table() {
    let top = folder();
    let arguments = [
        "orbit",
        "den-hartog",
        "--derivatives",
        "S,O",
        "--json",
        "--out",
        "orbit",
    ];
    let output = program(top.path()).args(arguments).assert().success();
    let json: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let of = &json["derivatives"];
    assert_eq!(of["by"], serde_json::json!(["S", "O"]));
    // The period is that of the drive, 2π/O with O = 0.7.
    let slope = of["period"][1].as_f64().unwrap();
    assert!((slope + 2.0 * std::f64::consts::PI / 0.49).abs() < 1e-12);
    assert_eq!(of["period"][0], 0.0);
    let most = of["extremes"]["x"][1][0].as_f64().unwrap();
    let least = of["extremes"]["x"][0][0].as_f64().unwrap();
    // The orbit is symmetric, and friction takes from its amplitude.
    assert!((most + least).abs() < 1e-6 && most < 0.0, "{most} {least}");
    assert_eq!(of["multipliers"]["S"].as_array().unwrap().len(), 2);
    let table = text(top.path().join("orbit/orbit_derivatives.csv"));
    assert!(table.starts_with("of,d/dS,d/dO\nperiod,"), "{table}");
    assert!(table.contains("\nmax x,") && table.contains("\nim multiplier 2,"));
    program(top.path())
        .args(["orbit", "den-hartog", "--derivatives", "S,x"])
        .assert()
        .code(2)
        .stderr(contains(
            "`x` is a state, on which a periodic orbit does not depend",
        ));
}
