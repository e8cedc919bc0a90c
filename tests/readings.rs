//! The program `readings` from the command line.

use std::path::Path;

use assert_cmd::Command;
use assert_cmd::cargo::cargo_bin_cmd;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

fn program(folder: &Path) -> Command {
    let mut command = cargo_bin_cmd!("readings");
    command.arg("--quick").arg("--out").arg(folder);
    command
}

/// The rows of a finished table are read, not computed again: there is no time for that.
fn all_is_kept(folder: &Path, whole: &[Vec<u8>; 2]) {
    program(folder)
        .args(["--time-limit", "1e-9"])
        .assert()
        .success()
        .stdout(contains("Tried: 8 of 8"));
    assert_eq!(*whole, files(folder));
}

fn files(folder: &Path) -> [Vec<u8>; 2] {
    ["readings.csv", "readings.txt"].map(|name| std::fs::read(folder.join(name)).unwrap())
}

#[test]
fn the_same_bytes_whatever_the_threads_and_after_a_kill() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    program(one.path())
        .args(["--threads", "1"])
        .assert()
        .success()
        .stderr("")
        .stdout(contains("random targets"));
    program(two.path())
        .args(["--threads", "2"])
        .assert()
        .success();
    let whole = files(one.path());
    assert_eq!(whole, files(two.path()));
    all_is_kept(two.path(), &whole);

    // Cut within a line, within the heading, and to nothing. Complete groups stay; the rest is
    // computed again.
    let length = whole[0].len();
    for left in [length - 3, length / 2, 20, 0] {
        let table = two.path().join("readings.csv");
        std::fs::write(&table, &whole[0][..left]).unwrap();
        program(two.path()).assert().success();
        assert_eq!(whole, files(two.path()), "{left} bytes left");
    }
    // Damage in the last line: invalid UTF-8, an unknown word, an additional digit.
    let line = whole[0][..length - 1]
        .iter()
        .rposition(|&b| b == b'\n')
        .unwrap()
        + 1;
    let last = String::from_utf8(whole[0][line..].to_vec()).unwrap();
    for damaged in [
        b"search,\xff\xfe\n".to_vec(),
        last.replacen("escaped", "escape", 1).into_bytes(),
        last.replacen(",3\n", ",31\n", 1).into_bytes(),
    ] {
        assert_ne!(damaged, last.as_bytes());
        let table = [&whole[0][..line], &damaged].concat();
        std::fs::write(two.path().join("readings.csv"), table).unwrap();
        program(two.path()).assert().success();
        assert_eq!(whole, files(two.path()));
    }
    assert_eq!(std::fs::read_dir(two.path()).unwrap().count(), 2);
}

/// A run with a time limit of zero does one unit of work, here two configurations, if one is
/// missing.
fn one_more(folder: &Path) {
    program(folder)
        .args(["--time-limit", "1e-9", "--threads", "1"])
        .assert()
        .success();
}

/// Number of configurations in the table.
fn rows(folder: &Path) -> usize {
    let table = std::fs::read_to_string(folder.join("readings.csv")).unwrap_or_default();
    table
        .lines()
        .filter(|line| line.starts_with("search,"))
        .count()
}

#[test]
fn a_killed_run_is_continued_to_the_same_bytes() {
    let (whole, killed) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    program(whole.path()).assert().success();
    // The run may end before the kill. Then another one is tried.
    let cut_short = (0..20).any(|_| {
        let _ = std::fs::remove_file(killed.path().join("readings.csv"));
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("readings"))
            .args(["--quick", "--threads", "1", "--out"])
            .arg(killed.path())
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        while rows(killed.path()) == 0 && child.try_wait().unwrap().is_none() {
            std::thread::yield_now();
        }
        child.kill().unwrap();
        child.wait().unwrap();
        (1..8).contains(&rows(killed.path()))
    });
    assert!(cut_short);
    let left = rows(killed.path());
    one_more(killed.path());
    assert_eq!(rows(killed.path()), left + 2, "rows were lost");
    program(killed.path()).assert().success();
    assert_eq!(files(whole.path()), files(killed.path()));
}

#[test]
fn a_table_of_other_settings_is_refused_by_the_setting_that_differs() {
    let folder = tempfile::tempdir().unwrap();
    program(folder.path()).assert().success();
    let table = folder.path().join("readings.csv");
    let whole = std::fs::read_to_string(&table).unwrap();
    let settings = whole
        .lines()
        .filter_map(|line| line.strip_prefix("# ")?.split_once(" = "));
    let mut tried = 0;
    for (name, value) in settings {
        let line = format!("# {name} = {value}\n");
        for other in [
            whole.replacen(&line, &format!("# {name} = 7x\n"), 1),
            whole.replacen(&line, "", 1),
        ] {
            std::fs::write(&table, &other).unwrap();
            program(folder.path())
                .assert()
                .code(1)
                .stderr(contains(format!("'# {name} = {value}'")))
                .stderr(contains("move it away"));
            assert_eq!(std::fs::read_to_string(&table).unwrap(), other);
        }
        tried += 1;
    }
    assert!(tried > 10);
}

#[test]
fn a_limit_leaves_a_table_that_can_be_continued() {
    let folder = tempfile::tempdir().unwrap();
    // However short the limit, every call adds one reading with one integrator.
    for done in [2, 4, 6] {
        program(folder.path())
            .args(["--time-limit", "1e-9", "--threads", "1"])
            .assert()
            .success()
            .stdout(contains(format!("Tried: {done} of 8")))
            .stdout(contains("not complete"));
    }
    program(folder.path())
        .args(["--time-limit", "1e-9", "--threads", "1"])
        .assert()
        .success()
        .stdout(contains("Tried: 8 of 8"))
        .stdout(contains("not complete").not());
}

#[test]
fn wrong_arguments_exit_with_2() {
    let folder = tempfile::tempdir().unwrap();
    for wrong in [
        ["--time-limit", "-1"],
        ["--time-limit", "soon"],
        ["--threads", "0"],
        ["--slow", ""],
    ] {
        program(folder.path()).args(wrong).assert().code(2);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn folders_that_cannot_be_used_exit_with_1() {
    let file = tempfile::NamedTempFile::new().unwrap();
    program(&file.path().join("sub"))
        .assert()
        .code(1)
        .stderr(contains("--out").and(contains("--out-dir").not()));
    program(file.path()).assert().code(1).stderr(
        contains("is a file, not a folder")
            .and(contains("with --out"))
            .and(contains("--out-dir").not()),
    );
    // A table of another search is left unchanged.
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("readings.csv");
    std::fs::write(&table, "a,b\n1,2\n").unwrap();
    program(folder.path())
        .assert()
        .code(1)
        .stderr(contains("move it away"));
    assert_eq!(std::fs::read(&table).unwrap(), b"a,b\n1,2\n");
}
