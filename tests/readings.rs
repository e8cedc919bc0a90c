//! The program `readings` from the command line.

use assert_cmd::cargo::cargo_bin_cmd;
use predicates::str::contains;

#[test]
fn a_wrong_command_line_exits_with_2_and_a_folder_that_cannot_be_used_with_1() {
    let mut wrong = cargo_bin_cmd!("readings");
    wrong.arg("--slow").assert().code(2);
    // Reported before the search, which takes minutes.
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut unusable = cargo_bin_cmd!("readings");
    unusable
        .arg("--out-dir")
        .arg(file.path())
        .assert()
        .code(1)
        .stderr(contains("is a file, not a folder"))
        .stderr(contains("with --out"));
}
