//! Runs that are long, stiff, or too much for a figure.

use std::fmt::Write;

use predicates::prelude::*;
use predicates::str::contains;

use super::public_cases::program;

/// An oscillator that a wall at 0.1 throws back.
const IMPACT: &str = r#"
name = "impact oscillator"
[time]
end = 6000
[states]
x = ""
v = ""
[jumps.wall]
when = "x - 0.1"
set = { v = "-0.8*v" }
[field]
x = "v"
v = "-x - 0.1*v + cos(2*t)"
[start]
x = 0
v = 0
"#;

#[test]
fn figures_of_a_long_run_are_small() {
    let (top, mut command) = program(IMPACT);
    command.args(["simulate", "system.toml", "--out", "out"]);
    command.assert().success().stderr("");
    for (file, most) in [("history.svg", 1_000_000), ("portrait.svg", 1_000_000)] {
        let svg = std::fs::read_to_string(top.path().join("out").join(file)).unwrap();
        roxmltree::Document::parse(&svg).unwrap();
        assert!(svg.len() < most, "{file}: {}", svg.len());
    }
}

#[test]
fn figures_and_steps_can_be_left_out() {
    let (top, mut command) = program(IMPACT);
    command.args(["simulate", "system.toml", "--until", "20", "--out", "out"]);
    command
        .args(["--no-figures", "--no-steps"])
        .assert()
        .success();
    let files = std::fs::read_dir(top.path().join("out")).unwrap();
    let mut files: Vec<_> = files.map(|file| file.unwrap().file_name()).collect();
    files.sort();
    assert_eq!(files, ["end.json", "phases.csv", "transitions.csv"]);
}

#[test]
fn a_run_goes_on_from_its_end() {
    let (top, mut command) = program(IMPACT);
    let at = |folder: &str| top.path().join(folder);
    command.args(["simulate", "system.toml", "--until", "60", "--no-figures"]);
    command.args(["--out", "whole"]).assert().success();
    let run = |arguments: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("stickslip").unwrap();
        command
            .current_dir(top.path())
            .args(["simulate", "system.toml"]);
        command.args(["--no-figures"]).args(arguments).assert()
    };
    run(&["--until", "20", "--out", "first"]).success();
    let first = at("first");
    let first = first.to_str().unwrap();
    run(&["--until", "60", "--resume", first, "--out", "rest"]).success();
    let last = |folder: &str| {
        let steps = std::fs::read_to_string(at(folder).join("steps.csv")).unwrap();
        steps.lines().last().unwrap().to_owned()
    };
    assert_eq!(last("rest"), last("whole"));
    let rows = |folder: &str| {
        let all = std::fs::read_to_string(at(folder).join("transitions.csv")).unwrap();
        all.lines().count() - 1
    };
    assert_eq!(rows("first") + rows("rest"), rows("whole"));
    // Another tolerance, another system, an earlier end, and what is no end of a run.
    for (arguments, words) in [
        (
            &["--until", "60", "--tol", "1e-6"][..],
            "--atol is 1e-12 there and 1e-6 here",
        ),
        (
            &["--until", "19.9"][..],
            "cannot integrate from t = 20 to t = 19.9",
        ),
        (
            &["--until", "60", "--start", "x=0"][..],
            "cannot be used with",
        ),
    ] {
        let mut arguments = arguments.to_vec();
        arguments.extend(["--resume", first, "--out", "refused"]);
        run(&arguments).failure().stderr(contains(words));
    }
    let missing = ["--until", "60", "--resume", "nowhere"];
    run(&missing)
        .code(2)
        .stderr(contains("nowhere cannot be read"));
    let text = std::fs::read_to_string(at("first").join("end.json")).unwrap();
    let changed = text.replacen("\"items\": ", "\"items\": 1", 1);
    assert_ne!(changed, text);
    std::fs::write(at("changed.json"), changed).unwrap();
    run(&["--until", "60", "--resume", "changed.json"])
        .code(2)
        .stderr(contains("was changed after it was written"));
    std::fs::write(at("end.json"), "{}").unwrap();
    run(&["--until", "60", "--resume", "end.json"])
        .code(2)
        .stderr(contains("is no end of a run"));
}

/// A ball with restitution 0.5 comes to rest at 3, where no jump can go on.
#[test]
fn nothing_goes_on_from_the_end_of_a_run_that_failed_in_the_same_folder() {
    let (top, _) = program(
        r#"
name = "ball"
[states]
h = ""
w = ""
[jumps.bounce]
when = "h"
direction = "falling"
set = { w = "-w/2" }
[field]
h = "w"
w = "-2"
[start]
h = 1
w = 0
"#,
    );
    let run = |arguments: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("stickslip").unwrap();
        command
            .current_dir(top.path())
            .args(["simulate", "system.toml", "--no-figures"]);
        command.args(["--out", "one"]).args(arguments).assert()
    };
    run(&["--until", "0.5"]).success();
    run(&["--until", "0.9", "--resume", "one"]).success();
    run(&["--until", "4"]).code(1);
    run(&["--until", "4", "--resume", "one"])
        .code(2)
        .stderr(contains("ended at t = 3"))
        .stderr(contains("from where none goes on"));
}

#[test]
fn steps_too_short_for_the_end_are_refused_at_once() {
    let (_top, mut command) = program(IMPACT);
    let clock = std::time::Instant::now();
    command.args(["simulate", "system.toml", "--until", "2", "--longest-step"]);
    command.arg("1e-20").assert().failure().stderr(contains(
        "--longest-step 1e-20 takes more than 10000000 steps to t = 2: give at least 2e-7, end the \
         run earlier, or raise --most-steps",
    ));
    assert!(clock.elapsed().as_secs() < 5);
    // Just enough steps are allowed.
    let (_top, mut command) = program(IMPACT);
    command.args(["simulate", "system.toml", "--until", "2", "--no-figures"]);
    let few = [
        "--most-steps",
        "1000",
        "--out",
        "out",
        "--longest-step",
        "0.002",
    ];
    command
        .args(few)
        .assert()
        .stderr(contains("takes more than").not());
}

#[test]
fn a_legend_without_room_costs_no_result() {
    let mut text =
        "name = \"s\"\n[time]\nend = 5\n[states]\nx = \"\"\n[discrete]\nn = 0\n".to_owned();
    for k in 0..200 {
        let at = 0.001 * f64::from(k + 1);
        let _ = write!(
            text,
            "[jumps.j{k}]\nwhen = \"x - {at}\"\nset = {{ n = \"n + 1\" }}\n"
        );
    }
    text += "[field]\nx = \"1\"\n[start]\nx = 0\n";
    let (top, mut command) = program(&text);
    command.args(["simulate", "system.toml", "--out", "out"]);
    command
        .assert()
        .success()
        .stdout(contains("x = 5, n = 200"));
    let svg = std::fs::read_to_string(top.path().join("out/portrait.svg")).unwrap();
    assert!(svg.contains(" more<"));
}

#[test]
fn a_figure_that_fails_costs_no_table() {
    // An axis around the largest of numbers has no room for a margin; one of large numbers has.
    for (field, start, end, is_drawn) in [("0", "1.3e308", 1, false), ("x", "1", 500, true)] {
        let text = format!(
            "name = \"s\"\n[time]\nend = {end}\n[states]\nx = \"\"\n[field]\nx = \"{field}\"\n\
             [start]\nx = {start}\n"
        );
        let (top, mut command) = program(&text);
        command.args(["simulate", "system.toml", "--escape", "inf", "--out", "out"]);
        let assert = command.assert().stdout(contains("end time"));
        if is_drawn {
            assert.success().stderr("");
        } else {
            let failure = contains("the figure history is left out: axis 'x' runs from");
            assert.code(1).stderr(failure);
        }
        assert!(top.path().join("out/steps.csv").exists());
        assert_eq!(top.path().join("out/history.svg").exists(), is_drawn);
    }
}

#[test]
fn a_stiff_run_says_so_once_and_ends() {
    let text = "name = \"s\"\n[time]\nend = 5\n[states]\nx = \"\"\n[field]\n\
        x = \"-1e7*(x - cos(t))\"\n[start]\nx = 1\n";
    for method in ["taylor", "dop853"] {
        let (_top, mut command) = program(text);
        command.args(["simulate", "system.toml", "--most-steps", "4000"]);
        let output = command.args(["--method", method]).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1));
        assert_eq!(stderr.matches("the system is stiff").count(), 1, "{stderr}");
        assert!(
            stderr.contains("e6 of them are to come") || stderr.contains("e7 of them"),
            "{stderr}"
        );
        assert!(stderr.contains("--most-steps"), "{stderr}");
    }
}

#[test]
fn runs_of_many_events_or_small_steps_are_not_stiff() {
    for arguments in [
        &["--until", "600"][..],
        &["--until", "1", "--longest-step", "1e-4"],
    ] {
        let (_top, mut command) = program(IMPACT);
        command.args(["simulate", "system.toml"]).args(arguments);
        command.assert().success().stderr("");
    }
    // Steps that the kinks of an input cut.
    let text = "name = \"s\"\n[time]\nend = 9000\n[states]\nx = \"\"\n[inputs.u]\n\
        shape = \"square\"\nperiod = 0.1\n[field]\nx = \"-x*(1 + 0.5*u)\"\n[start]\nx = 1\n";
    let (_top, mut command) = program(text);
    command.args(["simulate", "system.toml", "--no-figures", "--no-steps"]);
    command.assert().success().stderr("");
}

/// Leine's oscillator with a unit of length, and a unit of time of as many seconds as that of
/// metres allows.
fn leine(length: &str) -> String {
    format!(
        "name = \"Leine\"\n[time]\nend = 60e-12\n[states]\nx = \"\"\nv = \"\"\n[parameters]\n\
            L = {length}\ntau = 1e-12\n[contacts.c]\nboundary = \"v - 0.2*L/tau\"\n\
            friction = \"L/tau^2/(1 + 3*c*(v*tau/L - 0.2))\"\n[field]\nx = \"v\"\n\
            v = \"-x/tau^2 - friction(c)\"\n[start]\nx = 0\nv = \"0.2*L/tau\"\n"
    )
}

#[test]
fn a_state_far_below_its_tolerance_is_named_with_one_that_resolves_it() {
    let (_top, mut command) = program(&leine("1e-15"));
    command.args(["simulate", "system.toml"]);
    let warning = contains("the state x stays within").and(contains("give --atol 1e-2"));
    command.assert().success().stdout(warning);
    let transitions = "5 × stick entry, 5 × stick exit";
    let (_top, mut command) = program(&leine("1e-15"));
    command.args(["simulate", "system.toml", "--atol", "1e-27"]);
    command
        .assert()
        .success()
        .stdout(contains(transitions).and(contains("stays within").not()));
}

/// The file's values give the bits of those on the command line, and are replaced by them.
#[test]
fn each_state_may_have_its_own_absolute_tolerance() {
    let text = leine("1e-15");
    let in_file = text.replace("x = \"\"", "x = { unit = \"\", atol = 1e-27 }");
    assert_ne!(in_file, text);
    let steps = |text: &str, arguments: &[&str]| {
        let (top, mut command) = program(text);
        command.args(["simulate", "system.toml", "--no-figures", "--out", "run"]);
        command.args(arguments).assert().success();
        std::fs::read_to_string(top.path().join("run/steps.csv")).unwrap()
    };
    let given = steps(&text, &["--atol", "x=1e-27"]);
    assert_eq!(steps(&in_file, &[]), given);
    let coarse = steps(&text, &[]);
    assert_ne!(coarse, given);
    assert_eq!(steps(&in_file, &["--atol", "x=1e-12"]), coarse);
    assert_eq!(steps(&in_file, &["--atol", "1e-12"]), coarse);
    let both = steps(&text, &["--atol", "1e-12", "--atol", "x=1e-27"]);
    assert_eq!(both, given);
}
