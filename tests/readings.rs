//! The program `readings` as its user meets it.

use std::path::Path;

use assert_cmd::Command;
use assert_cmd::cargo::cargo_bin_cmd;
use predicates::str::contains;

fn program(folder: &Path) -> Command {
    let mut command = cargo_bin_cmd!("readings");
    command.arg("--quick").arg("--out").arg(folder);
    command
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

    // Cut within a line, within the heading, and to nothing: whole groups stay, the rest is done again.
    let length = whole[0].len();
    for left in [length - 3, length / 2, 20, 0] {
        let table = two.path().join("readings.csv");
        std::fs::write(&table, &whole[0][..left]).unwrap();
        program(two.path()).assert().success();
        assert_eq!(whole, files(two.path()), "{left} bytes left");
    }
    assert_eq!(std::fs::read_dir(two.path()).unwrap().count(), 2);
}

#[test]
fn a_limit_leaves_a_table_that_can_be_continued() {
    let folder = tempfile::tempdir().unwrap();
    program(folder.path())
        .args(["--time-limit", "1e-9"])
        .assert()
        .success()
        .stdout(contains("not complete"));
    program(folder.path())
        .assert()
        .success()
        .stdout(contains("Tried: 8 of 8"));
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
        .stderr(contains("--out"));
    // Someone else's table is left alone.
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("readings.csv");
    std::fs::write(&table, "a,b\n1,2\n").unwrap();
    program(folder.path())
        .assert()
        .code(1)
        .stderr(contains("move it away"));
    assert_eq!(std::fs::read(&table).unwrap(), b"a,b\n1,2\n");
}
