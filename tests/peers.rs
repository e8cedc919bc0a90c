//! The program `peers` from the command line.

use std::path::Path;

use assert_cmd::Command;
use assert_cmd::cargo::cargo_bin_cmd;
use predicates::prelude::*;
use predicates::str::contains;

/// A short measurement of one problem that writes its files into `folder`.
fn short(folder: &Path, process_rounds: &str) -> Command {
    let mut command = cargo_bin_cmd!("peers");
    command.args(["--rounds", "1", "--problems", "decay"]);
    command.args([
        "--process-problems",
        "decay",
        "--process-rounds",
        process_rounds,
    ]);
    command
        .arg("--report-dir")
        .arg(folder)
        .arg("--figures-dir")
        .arg(folder);
    command
}

#[test]
fn says_what_it_does() {
    let mut command = cargo_bin_cmd!("peers");
    let help = contains("Error of event times")
        .and(contains("bench.csv"))
        .and(contains("--python"));
    command.arg("--help").assert().success().stdout(help);
}

#[test]
fn measures_ours_alone_without_python() {
    let folder = tempfile::tempdir().unwrap();
    let message = contains("no peers")
        .and(contains("Whole processes"))
        .and(contains("wrote"));
    short(folder.path(), "1").assert().success().stdout(message);
    let mut reader = csv::Reader::from_path(folder.path().join("bench.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert!(rows.len() >= 11);
    let number = |row: &csv::StringRecord, cell: usize| row[cell].parse::<f64>().unwrap();
    for row in &rows {
        // All nine events at every tolerance, and plausible times.
        assert_eq!((&row[1], &row[5], &row[10]), ("decay", "9", ""));
        // Loose tolerances must find the events; tight ones must be accurate.
        let bound = if number(row, 3) <= 1e-12 { 1e-11 } else { 1e-2 };
        assert!(number(row, 4) < bound, "{row:?}");
        assert!(number(row, 6) > 0.0 && number(row, 7) <= number(row, 6));
    }
    // One whole process for each of our solvers: two methods compiled, one by formulas.
    assert_eq!(rows.iter().filter(|row| !row[9].is_empty()).count(), 3);
    let svg = std::fs::read_to_string(folder.path().join("bench.svg")).unwrap();
    roxmltree::Document::parse(&svg).unwrap();
    assert!(folder.path().join("bench.txt").exists());
}

#[test]
fn the_committed_picture_is_that_of_the_committed_table() {
    let folder = tempfile::tempdir().unwrap();
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut command = cargo_bin_cmd!("peers");
    command
        .arg("redraw")
        .arg("--report-dir")
        .arg(top.join("report"));
    command.arg("--figures-dir").arg(folder.path());
    command.assert().success().stdout(contains("bench.svg"));
    let drawn = std::fs::read_to_string(folder.path().join("bench.svg")).unwrap();
    let committed = std::fs::read_to_string(top.join("figures/bench.svg")).unwrap();
    // assert_eq would print both pictures.
    assert!(drawn == committed, "run `peers redraw`");
}

#[test]
fn without_a_table_nothing_is_redrawn() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = cargo_bin_cmd!("peers");
    command.arg("redraw").arg("--report-dir").arg(folder.path());
    command
        .arg("--figures-dir")
        .arg(folder.path().join("figures"));
    let stderr = contains("cannot read").and(contains("--report-dir"));
    command.assert().code(1).stderr(stderr);
    assert!(!folder.path().join("figures").exists());
}

#[test]
fn one_problem_prints_its_events() {
    let mut command = cargo_bin_cmd!("peers");
    command.args(["one", "--problem", "decay", "--tolerance", "1e-12"]);
    let output = command.assert().success().get_output().clone();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 9);
    assert!(text.starts_with("entry,2.4468880178"), "{text}");
}

#[test]
fn a_wrong_command_line_is_distinguished() {
    let folder = tempfile::tempdir().unwrap();
    let unknown = contains("invalid value 'drift'").and(contains("belt_sensitive"));
    short(folder.path(), "1")
        .args(["--problems", "drift"])
        .assert()
        .code(2)
        .stderr(unknown);
    let mut none = cargo_bin_cmd!("peers");
    none.args(["--rounds", "0"])
        .assert()
        .code(2)
        .stderr(contains("--rounds"));
    let mut one = cargo_bin_cmd!("peers");
    one.args(["one", "--problem", "decay", "--solver", "euler"]);
    one.assert()
        .code(2)
        .stderr(contains("invalid value 'euler'").and(contains("stickslip Taylor")));
}

#[test]
fn a_folder_that_cannot_be_written_is_reported_before_the_measurement() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let stderr = contains("cannot create folder")
        .and(contains("--report-dir"))
        .and(contains("measuring").not());
    short(&file.path().join("report"), "0")
        .assert()
        .code(1)
        .stderr(stderr);
}

#[test]
fn a_python_that_is_none_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = short(folder.path(), "1");
    command.arg("--python").arg(folder.path().join("python"));
    command
        .assert()
        .code(1)
        .stderr(contains("cannot start").and(contains("--python")));
    assert!(!folder.path().join("bench.csv").exists());
}

/// A program that replaces Python and prints arbitrary answers.
#[cfg(unix)]
mod impostor {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    fn python(folder: &Path, script: &str) -> Command {
        let path = folder.join("python");
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        let mut command = short(folder, "0");
        command.arg("--python").arg(path);
        command
    }

    #[test]
    fn a_malformed_row_is_reported_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let script = "read command\n\
            echo version,scipy,1.0\n\
            echo curve,0,SciPy,tol,tight,0.1,entry@1\n\
            echo done\n";
        let stderr =
            contains("line 2 of the peers' process").and(contains("'tight' is no finite number"));
        python(folder.path(), script)
            .assert()
            .code(1)
            .stderr(stderr);
        assert!(!folder.path().join("bench.csv").exists());
    }

    #[test]
    fn a_process_that_dies_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let stderr = contains("ended while 'prepare decay' was under way");
        python(folder.path(), "read command")
            .assert()
            .code(1)
            .stderr(stderr);
    }

    #[test]
    fn rows_of_peers_stand_beside_ours() {
        let folder = tempfile::tempdir().unwrap();
        let script = "read command\n\
            echo version,scipy,1.0\n\
            echo curve,0,SciPy,tol,1e-6,0.1,entry@1\n\
            echo 'cannot,heyoka,tol,,it is not here'\n\
            echo done\n\
            while read command; do echo seconds,0,0.25; echo done; done";
        let stdout =
            contains("beside scipy 1.0").and(contains("failed: 1 events, the reference has 9"));
        python(folder.path(), script)
            .assert()
            .success()
            .stdout(stdout);
        let text = std::fs::read_to_string(folder.path().join("bench.csv")).unwrap();
        assert!(text.contains("SciPy,decay,tol,1.000e-6,,1,2.500e-1,2.500e-1,1.000e-1,,"));
        assert!(
            text.contains("heyoka,decay,tol,,,,,,,,it is not here"),
            "{text}"
        );
    }
}
