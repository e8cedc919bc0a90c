//! The program `spectrum` as its user meets it.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use assert_cmd::cargo::cargo_bin_cmd;
use predicates::prelude::*;
use predicates::str::{contains, starts_with};

fn program() -> Command {
    cargo_bin_cmd!("spectrum")
}

/// Hénon's map, with names or without.
fn henon(names: bool) -> String {
    let mut text = String::from(if names { "x,y\n" } else { "" });
    let mut x = [0.1, 0.1];
    for i in 0..3100 {
        x = [1.0 - 1.4 * x[0] * x[0] + x[1], 0.3 * x[0]];
        if i >= 100 {
            writeln!(text, "{},{}", x[0], x[1]).unwrap();
        }
    }
    text
}

fn file(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("series.csv");
    std::fs::write(&path, text).unwrap();
    path
}

fn succeed(command: &mut Command) -> String {
    let output = command.assert().success().stderr("").get_output().clone();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn prints_a_table_without_any_option_but_the_time_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), &henon(true));
    let table = succeed(program().arg(&path).args(["--dt", "1"]));
    assert!(table.contains("3000 points of (x, y)"));
    assert!(table.contains("2 tangent directions"));
    let first = table
        .lines()
        .find(|line| line.starts_with("    1  "))
        .unwrap();
    let cells: Vec<&str> = first.split_whitespace().collect();
    // Over 3000 points the standard error is 0.005.
    assert!((cells[1].parse::<f64>().unwrap() - 0.419).abs() < 0.02);
    assert_eq!(cells[3], "ok");
    // Nothing is written that was not asked for.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn csv_and_json_hold_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), &henon(false));
    let csv = succeed(program().arg(&path).args(["--dt", "1", "--csv"]));
    let json = succeed(
        program()
            .arg(&path)
            .args(["--dt", "1", "--json", "--eps", "0.02"]),
    );
    let document: serde_json::Value = serde_json::from_str(&json).unwrap();
    let exponents = document["exponents"].as_array().unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    assert_eq!(
        reader.headers().unwrap(),
        vec!["index", "exponent", "stderr", "status"]
    );
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!((records.len(), exponents.len()), (2, 2));
    for (record, exponent) in records.iter().zip(exponents) {
        assert_eq!(record[0].parse::<u64>().ok(), exponent["index"].as_u64());
        assert_eq!(record[1].parse::<f64>().ok(), exponent["exponent"].as_f64());
        assert_eq!(record[2].parse::<f64>().ok(), exponent["stderr"].as_f64());
        assert_eq!(Some(&record[3]), exponent["status"].as_str());
    }
    assert_eq!(document["settings"]["dt"], 1.0);
    assert_eq!(document["settings"]["eps"], 0.02);
    assert_eq!(document["settings"]["theiler"], 1);
}

#[test]
fn reads_standard_input_and_chooses_columns() {
    let text: String = henon(true)
        .lines()
        .enumerate()
        .map(|(i, line)| {
            if i == 0 {
                format!("n,{line}\n")
            } else {
                format!("no {i},{line}\n")
            }
        })
        .collect();
    let arguments = ["-", "--dt", "1", "--csv", "--columns"];
    let by_name = succeed(
        program()
            .args(arguments)
            .arg("x,y")
            .write_stdin(text.clone()),
    );
    let by_number = succeed(program().args(arguments).arg("2,3").write_stdin(text));
    let plain = succeed(
        program()
            .args(["-", "--dt", "1", "--csv"])
            .write_stdin(henon(false)),
    );
    assert_eq!(by_name, by_number);
    assert_eq!(by_name, plain);
}

/// A constant column: no value, said so in every format.
#[test]
fn what_has_no_value_is_empty_null_or_a_dash() {
    let text: String = henon(false)
        .lines()
        .map(|line| format!("{line},4\n"))
        .collect();
    let run = |format: &[&str]| {
        succeed(
            program()
                .args(["-", "--dt", "1"])
                .args(format)
                .write_stdin(text.clone()),
        )
    };
    assert!(run(&["--csv"]).ends_with("3,,,unidentified\n"));
    let json: serde_json::Value = serde_json::from_str(&run(&["--json"])).unwrap();
    assert!(json["exponents"][2]["exponent"].is_null());
    assert!(run(&[]).contains("flat"));
}

#[test]
fn writes_a_named_picture() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a/b");
    let table = succeed(
        program()
            .args([
                "-",
                "--dt",
                "1",
                "--affine",
                "--neighbours",
                "15-30",
                "--step",
                "2",
                "--theiler",
                "5",
                "--out",
            ])
            .arg(&out)
            .write_stdin(henon(false)),
    );
    assert!(table.contains("spectrum.svg") && table.contains("affine") && table.contains("step 2"));
    let text = std::fs::read_to_string(out.join("spectrum.svg")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    assert_eq!(document.root_element().attribute("role"), Some("img"));
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1);
}

#[test]
fn bad_files_are_failures_that_say_where() {
    let broken = henon(true).replacen("\n", "\n1,oops\n", 1);
    for (text, place) in [
        (broken.as_str(), "line 2, column 2 (y): 'oops'"),
        ("1,2\n3\n", "line 2, column 2: the line has 1 columns"),
        ("1,2\n3,NaN\n", "line 2, column 2: 'NaN' is not finite"),
        ("", "no data"),
        ("1\n2\n3\n", "3 points are too few"),
    ] {
        program()
            .args(["-", "--dt", "1"])
            .write_stdin(text)
            .assert()
            .code(1)
            .stdout("")
            .stderr(starts_with("error: ").and(contains(place)));
    }
    program()
        .args(["no/such/file.csv", "--dt", "1"])
        .assert()
        .code(1)
        .stderr(contains("no/such/file.csv"));
}

#[test]
fn wrong_command_lines_end_with_two() {
    for (arguments, says) in [
        (vec!["-"], "--dt"),
        (vec!["-", "--dt", "0"], "dt = 0"),
        (vec!["-", "--dt", "-1"], "dt = -1"),
        (vec!["-", "--dt", "1", "--step", "0"], "step = 0"),
        (vec!["-", "--dt", "1", "--eps", "-0.1"], "eps = -0.1"),
        (vec!["-", "--dt", "1", "--columns", "3"], "it has 1 to 2"),
        (vec!["-", "--dt", "1", "--columns", "1,1"], "twice"),
        (vec!["-", "--dt", "1", "--neighbours", "many"], "'many'"),
        (
            vec!["-", "--dt", "1", "--neighbours", "30", "--eps", "0.1"],
            "--eps",
        ),
        (vec!["-", "--dt", "1", "--json", "--csv"], "--csv"),
        (vec!["-", "--dt", "1", "--no-such-flag"], "--no-such-flag"),
    ] {
        program()
            .args(&arguments)
            .write_stdin(henon(false))
            .assert()
            .code(2)
            .stdout("")
            .stderr(contains(says));
    }
}

#[test]
fn an_unwritable_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let below = file(folder.path(), "kept").join("below");
    program()
        .args(["-", "--dt", "1", "--out"])
        .arg(&below)
        .write_stdin(henon(false))
        .assert()
        .code(1)
        .stdout("")
        .stderr(contains(below.to_str().unwrap()));
    assert_eq!(
        std::fs::read_to_string(folder.path().join("series.csv")).unwrap(),
        "kept"
    );
}

#[test]
fn help_has_examples_and_explains_the_status() {
    let help = succeed(program().arg("--help"));
    for word in [
        "Examples:",
        "unidentified",
        "annihilated",
        "--columns",
        "--theiler",
        "--dt 0.02",
    ] {
        assert!(help.contains(word), "{word}");
    }
    let version = succeed(program().arg("--version"));
    assert_eq!(version, format!("spectrum {}\n", env!("CARGO_PKG_VERSION")));
}
