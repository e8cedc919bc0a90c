//! `stickslip fit`: arguments, exit codes and files.

use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;

fn program(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.current_dir(folder);
    command
}

fn text(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// A folder with a record of the belt, `data.csv` with the columns t, x, v and force; one cell of x
/// is empty.
fn folder() -> tempfile::TempDir {
    let top = tempfile::tempdir().unwrap();
    let mut command = program(top.path());
    command.args([
        "simulate",
        "belt",
        "--t-end",
        "8",
        "--no-figures",
        "--longest-step",
        "0.1",
    ]);
    command.args(["--out", "run"]).assert().success();
    let steps = text(top.path().join("run/steps.csv"));
    let mut rows = vec!["t,x,v,force".to_owned()];
    let mut last = 0.0;
    for (k, row) in steps.lines().skip(2).enumerate() {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        // Behind an event the same time stands again.
        if cells[0] <= last {
            continue;
        }
        last = cells[0];
        let x = if k == 5 {
            String::new()
        } else {
            format!("{:?}", cells[1])
        };
        rows.push(format!(
            "{:?},{x},{:?},{:?}",
            cells[0],
            cells[2],
            3.0 * cells[1] + 0.5
        ));
    }
    std::fs::write(top.path().join("data.csv"), rows.join("\n") + "\n").unwrap();
    top
}

fn fit(top: &Path, arguments: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = program(top);
    command.args(["fit", "belt", "data.csv", "--out", "fit"]);
    command.args(arguments).assert()
}

#[test]
fn an_exact_record_is_fitted_with_all_files() {
    let top = folder();
    let truth = 3.0_f64.sqrt() / 9.0;
    let arguments = [
        "--fit",
        "mu0,x,gain",
        "--observe",
        "x",
        "--observe",
        "force=gain*x + 0.5",
        "--extra",
        "gain=2",
        "--set",
        "mu0=0.17",
        "--start",
        "x=0.45",
        "--bounds",
        "mu0=0.1..0.3",
        "--json",
    ];
    let done = fit(top.path(), &arguments).success();
    let told: serde_json::Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    let value = |k: usize| told["values"][k]["value"].as_f64().unwrap();
    assert!((value(0) - truth).abs() < 1e-7, "{told}");
    assert!((value(1) - 0.5).abs() < 1e-7 && (value(2) - 3.0).abs() < 1e-7);
    assert_eq!(told["residuals"].as_array().unwrap().len(), 2);
    let seen = &told["seen"][0];
    assert_eq!(seen["contact"], "belt");
    assert_eq!(seen["same"], true);
    let sticks = |of: &serde_json::Value| {
        let phases = of.as_array().unwrap().iter();
        phases.filter(|phase| phase[2] == "S").count()
    };
    assert!(sticks(&seen["data"]) > 0 && sticks(&seen["data"]) == sticks(&seen["fit"]));
    let at = |name: &str| text(top.path().join("fit").join(name));
    assert!(at("parameters.csv").starts_with("name,value,std_error,low,high,start,"));
    assert_eq!(at("parameters.csv").lines().count(), 4);
    assert!(at("correlations.csv").starts_with("name,mu0,x,gain\n"));
    let phases = at("phases.csv");
    assert!(
        phases.starts_with("record,contact,column,of,from,to,mode\n1,belt,x,data,"),
        "{phases}"
    );
    let rows = at("fit.csv");
    assert!(rows.starts_with("t,x,x_fit,x_residual,force,force_fit,force_residual\n"));
    assert_eq!(
        rows.lines().count(),
        text(top.path().join("data.csv")).lines().count()
    );
    assert!(at("fit.svg").starts_with("<?xml") || at("fit.svg").starts_with("<svg"));
}

#[test]
fn values_at_impacts_have_no_standard_error_and_the_event_is_named() {
    let top = tempfile::tempdir().unwrap();
    let ball = "name = \"ball\"\n[states]\nh = \"\"\nw = \"\"\n[parameters]\ng = 9.81\n\
                [jumps.bounce]\nwhen = \"h\"\ndirection = \"falling\"\n\
                set = { w = \"-0.8*w\" }\n[field]\nh = \"w\"\nw = \"-g\"\n[start]\nh = 1\n\
                w = 0\n";
    std::fs::write(top.path().join("ball.toml"), ball).unwrap();
    // The velocity after each impact, at its time in closed form, with some noise.
    let fall = (2.0_f64 / 9.81).sqrt();
    let (mut t, mut w) = (fall, 0.8 * 9.81 * fall);
    let mut rows = vec!["t,w".to_owned()];
    for noise in [-0.004, 0.007, -0.01, -0.002, 0.005, -0.001] {
        rows.push(format!("{t:?},{:?}", w + noise));
        t += 2.0 * w / 9.81;
        w *= 0.8;
    }
    std::fs::write(top.path().join("w.csv"), rows.join("\n") + "\n").unwrap();
    let mut command = program(top.path());
    command.args(["fit", "ball.toml", "w.csv", "--fit", "g", "--observe", "w"]);
    command.args(["--set", "g=10", "--sigma", "0.01"]);
    let words = "none: w.csv: the value of w at ";
    command
        .assert()
        .success()
        .stdout(contains(words).and(contains("the event `bounce` at")));
}

#[test]
fn impacts_that_accumulate_are_counted() {
    let top = tempfile::tempdir().unwrap();
    let ball = "name = \"ball\"\n[states]\nh = \"\"\nw = \"\"\n[parameters]\ng = 9\n\
                [stops.floor]\ngap = \"h\"\nrestitution = 0.5\nacts = { w = \"1\" }\n\
                [field]\nh = \"w\"\nw = \"-g\"\n[start]\nh = 1\nw = 0\n";
    std::fs::write(top.path().join("ball.toml"), ball).unwrap();
    // The fall from a height of 1, and rest.
    let mut rows = vec!["t,h".to_owned()];
    rows.extend([0.1, 0.2, 0.3, 0.4].map(|t: f64| format!("{t},{}", 1.0 - 5.0 * t * t)));
    rows.extend([1.5, 1.75, 2.0].map(|t| format!("{t},0")));
    std::fs::write(top.path().join("h.csv"), rows.join("\n") + "\n").unwrap();
    let arguments = ["fit", "ball.toml", "h.csv", "--fit", "g", "--observe", "h"];
    let mut command = program(top.path());
    let said = command.args(arguments).assert().success();
    let counted = contains("phases       floor.impact × ").and(contains(" floor.landing ·"));
    said.stdout(counted);
    let mut command = program(top.path());
    let json = command.args(arguments).arg("--json").assert().success();
    json.stdout(contains("floor.impact floor.impact floor.impact"));
}

/// The data are those of k² = 1. Both signs of k are minima, and the bounds cut one of them off.
#[test]
fn other_minima_mark_values_on_their_bounds() {
    let top = tempfile::tempdir().unwrap();
    let spring = "name = \"spring\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nk = 0.5\n\
                  [field]\nx = \"v\"\nv = \"-k*k*x\"\n[start]\nx = 1\nv = 0\n";
    std::fs::write(top.path().join("spring.toml"), spring).unwrap();
    let times = (1..=40).map(|k| 0.1 * f64::from(k));
    let rows = times.map(|t| format!("{t:?},{:.3}\n", stickslip::math::cos(t)));
    let rows: String = std::iter::once("t,x\n".to_owned()).chain(rows).collect();
    std::fs::write(top.path().join("x.csv"), rows).unwrap();
    let mut command = program(top.path());
    command.args([
        "fit",
        "spring.toml",
        "x.csv",
        "--fit",
        "k",
        "--observe",
        "x",
    ]);
    command.args(["--bounds", "k=-0.9:1.5", "--search", "20"]);
    let said = command.assert().success();
    said.stdout(contains("other minima k = -0.9 (on its bound), cost "));
}

#[test]
fn several_records_have_files_of_their_own() {
    let top = folder();
    std::fs::copy(top.path().join("data.csv"), top.path().join("again.csv")).unwrap();
    let arguments = [
        "again.csv",
        "--fit",
        "mu0,x",
        "--observe",
        "x",
        "--sigma",
        "0.01",
        "--set-in",
        "2:vp=1",
        "--start-in",
        "2:x=0.49",
    ];
    let done = fit(top.path(), &arguments).success();
    done.stdout(
        contains("x@1")
            .and(contains("x@2"))
            .and(contains("of a noise of 0.01")),
    );
    for name in ["fit_1.csv", "fit_2.csv", "fit_1.svg", "fit_2.svg"] {
        assert!(top.path().join("fit").join(name).is_file(), "{name}");
    }
}

/// Two records of an integrator with the rates 1 and 2: only their own inputs fit both.
#[test]
fn a_record_has_an_input_from_a_file() {
    let top = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(top.path().join(name), text).unwrap();
    write(
        "integrator.toml",
        "name = \"integrator\"\n[states]\nx = \"\"\n[parameters]\ngain = 1\n[inputs.u]\n\
         shape = \"table\"\ntimes = [0, 4]\nvalues = [1, 1]\n[field]\nx = \"gain*u\"\n\
         [start]\nx = 0\n",
    );
    write("one.csv", "t,x\n1,3\n2,6\n4,12\n");
    write("two.csv", "t,x\n1,6\n2,12\n4,24\n");
    write("drive.csv", "t;u\n0;2\n4;2\n");
    let arguments = |inputs: &[&'static str]| {
        let mut all = vec![
            "fit",
            "integrator.toml",
            "one.csv",
            "two.csv",
            "--fit",
            "gain",
        ];
        all.extend(["--observe", "x", "--sigma", "0.01", "--json"]);
        for input in inputs {
            all.extend(["--input-in", input]);
        }
        program(top.path()).args(all).assert()
    };
    let done = arguments(&["2:u=drive.csv"]).success();
    let told: serde_json::Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    let gain = told["values"][0]["value"].as_f64().unwrap();
    assert!((gain - 3.0).abs() < 1e-9, "{told}");
    for (input, said) in [
        ("2:u", "an input, `=` and a file are expected"),
        ("3:u=drive.csv", "a record from 1 to 2 stands in front"),
        ("2:w=drive.csv", "there is no input `w`"),
        ("2:u=none.csv", "its path begins in the working folder"),
    ] {
        arguments(&[input]).code(2).stderr(contains(said));
    }
    let twice = arguments(&["2:u=drive.csv", "2:u=drive.csv"]).code(2);
    twice.stderr(contains("the input stands twice for one record"));
}

#[test]
fn what_is_wrong_is_told_with_the_remedy() {
    let top = folder();
    let x = ["--observe", "x"];
    for (arguments, code, said) in [
        (vec!["--fit", "mu", x[0], x[1]], 2, "did you mean `mu0`?"),
        (
            vec!["--fit", "mu0", "--observe", "y"],
            2,
            "there is no column `y` in data.csv, which has",
        ),
        (
            vec!["--fit", "mu0", "--observe", "x=y"],
            2,
            "unknown name `y`",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--bounds", "mu0=0.3..0.4"],
            2,
            "outside its bounds",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--bounds", "mu0=0.3:0.4"],
            2,
            "outside its bounds",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--bounds", "mu0=0.3"],
            2,
            "NAME=LOW:HIGH is expected",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--set-in", "1:mu0=0.2"],
            2,
            "`mu0` is set to 0.2 in this record and fitted for all",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--bounds", "vp=0..1"],
            2,
            "it is not fitted",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--sigma", "v=1"],
            2,
            "--observe has no such column",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--loss", "l1"],
            2,
            "it is squares, soft-l1:SCALE or",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--t-start", "0.5"],
            2,
            "is before the start of the run",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--set-in", "2:vp=1"],
            2,
            "a record from 1 to 1 stands in front, as in 1:vp=1",
        ),
        (
            vec!["--fit", "idle,mu0", x[0], x[1], "--extra", "idle=1"],
            2,
            "`idle` has no effect",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--extra", "x=1"],
            2,
            "is the name of a state already",
        ),
        (
            vec!["--fit", "mu0", x[0], x[1], "--escape", "0.6"],
            1,
            "start elsewhere",
        ),
        (
            vec![
                "--fit",
                "mu0,k1,x",
                x[0],
                x[1],
                "--set",
                "mu0=0.15",
                "--most-runs",
                "1",
            ],
            1,
            "no minimum was found in",
        ),
    ] {
        let done = fit(top.path(), &arguments);
        done.code(code).stderr(contains(said));
    }
    std::fs::write(
        top.path().join("data.csv"),
        "t,x\n0.5,0.4\n0.4,0.5\n0.6,1\n",
    )
    .unwrap();
    let arguments = ["--fit", "mu0", "--observe", "x"];
    fit(top.path(), &arguments)
        .code(2)
        .stderr(contains("in row 2, does not come after"));
    std::fs::write(top.path().join("data.csv"), "t,x\n0.5,0.4\n0.6,\n").unwrap();
    fit(top.path(), &arguments)
        .code(2)
        .stderr(contains("1 values cannot determine 1 unknowns"));
}
