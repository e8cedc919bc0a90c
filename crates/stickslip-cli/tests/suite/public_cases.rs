//! The program in a folder with a system, and the limits of a run.

use assert_cmd::Command;
use predicates::str::contains;
use serde_json::Value;

/// The program, in a folder with the system in `text` as `system.toml`.
pub fn program(text: &str) -> (tempfile::TempDir, Command) {
    let top = tempfile::tempdir().unwrap();
    std::fs::write(top.path().join("system.toml"), text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.current_dir(top.path());
    (top, command)
}

/// The results of a command for the system in `text`.
pub fn results(text: &str, arguments: &[&str]) -> Value {
    let (_top, mut command) = program(text);
    let output = command.args(arguments).arg("--json").assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[test]
fn crossings_without_end_are_limited() {
    // Both fields rotate about the point (0.75, 0.6) and grow: a focus on the boundary.
    let text = "name = \"ocean\"\n[time]\nend = 60\n[states]\nT = \"\"\nS = \"\"\n\
        [contacts.mixing]\nboundary = \"S - 0.8*T\"\n[field]\n\
        T = \"1 - T - by_side(mixing, 0, 1)*T\"\nS = \"0.5*(1 - S) - by_side(mixing, 0, 1)*S\"\n\
        [start]\nT = 0.9\nS = 0.6\n";
    for (limit, found, error) in [
        (
            ["--most-events", "2000"],
            "2000 × crossing",
            "more than 2000 transitions by t = ",
        ),
        (["--most-steps", "100"], "", "more than 100 steps by t = "),
    ] {
        let (_top, mut command) = program(text);
        let failed = command
            .args(["simulate", "system.toml"])
            .args(limit)
            .assert();
        failed
            .code(1)
            .stdout(contains(found))
            .stderr(contains(error));
    }
}

#[test]
fn a_system_without_contacts_has_no_tangent_points() {
    let text = "name = \"free\"\n[states]\nx = \"\"\nv = \"\"\n[field]\nx = \"v\"\nv = \"-x\"\n\
                [start]\nx = 1\nv = 0\n";
    let (_top, mut command) = program(text);
    let ended = command.args(["tangents", "system.toml"]).assert();
    ended.code(2).stderr(contains("has no contact"));
}
