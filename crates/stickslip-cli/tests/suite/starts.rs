//! `simulate --starts`: orbits from the rows of a table.

use predicates::str::contains;

use crate::public_cases::program;

/// A block that friction of two sides holds on a belt, and one state that may escape.
const BLOCK: &str = "name = \"block\"\n[states]\nx = \"\"\nv = \"\"\nz = \"\"\n\
    [parameters]\nvp = 0.2\n[contacts.belt]\nboundary = \"v - vp\"\n\
    friction = \"0.4/(1 + 3*belt*(v - vp))\"\n[field]\n\
    x = \"v\"\nv = \"-x - 0.05*v - friction(belt)\"\nz = \"z*z\"\n[section]\nfunction = \"x\"\n\
    [start]\nx = 0.5\nv = 0\nz = 0\n[time]\nend = 20\n";

/// The rows of a table that a command wrote, as cells.
fn rows(folder: &std::path::Path, name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().map(cells).collect()
}

#[test]
fn each_orbit_has_the_bits_of_a_single_run_and_its_number() {
    let (top, mut command) = program(BLOCK);
    let starts = "x;vp\n0,5;0,2\n-0,3;0,1\n0,1;0,2\n";
    std::fs::write(top.path().join("starts.csv"), starts).unwrap();
    command.args([
        "simulate",
        "system.toml",
        "--starts",
        "starts.csv",
        "--out",
        "all",
    ]);
    command.assert().success().stdout(contains(
        "block: 3 orbits from starts.csv, t = 0 to 20\n  ended        3 × end time",
    ));
    let all = top.path().join("all");
    assert!(!all.join("history.svg").exists());
    // None of them goes on alone, and nor does an earlier run in the folder.
    let mut resumed = assert_cmd::Command::new(env!("CARGO_BIN_EXE_stickslip"));
    resumed.current_dir(top.path());
    resumed.args([
        "simulate",
        "system.toml",
        "--resume",
        "all",
        "--until",
        "30",
    ]);
    resumed.assert().code(2).stderr(contains(
        "that ended at t = 20 (3 orbits of --starts), from where none goes on",
    ));
    let names = [
        "orbits.csv",
        "phases.csv",
        "transitions.csv",
        "section.csv",
        "steps.csv",
    ];
    for name in names {
        assert_eq!(rows(&all, name)[0][0], "orbit", "{name}");
    }
    for (number, x, vp) in [
        ("1", "0.5", "0.2"),
        ("2", "-0.3", "0.1"),
        ("3", "0.1", "0.2"),
    ] {
        let mut one = assert_cmd::Command::new(env!("CARGO_BIN_EXE_stickslip"));
        one.current_dir(top.path())
            .args(["simulate", "system.toml", "--no-figures"]);
        let (x, vp) = (format!("x={x}"), format!("vp={vp}"));
        one.args(["--out", "one", "--start", &x, "--set", &vp]);
        one.assert().success();
        for name in &names[1..] {
            let own = rows(&all, name).into_iter();
            let own = own
                .filter(|row| row[0] == number)
                .map(|row| row[1..].to_vec());
            let alone = rows(&top.path().join("one"), name);
            assert!(alone.len() > 1, "{name}");
            assert!(own.eq(alone.into_iter().skip(1)), "{name} of {number}");
        }
    }
}

#[test]
fn a_start_that_fails_keeps_the_others() {
    let (top, mut command) = program(BLOCK);
    std::fs::write(top.path().join("starts.csv"), "z\n0\n1\n-1\n").unwrap();
    command.args([
        "simulate",
        "system.toml",
        "--starts",
        "starts.csv",
        "--no-steps",
    ]);
    command.args(["--out", "all", "--json", "--start", "x=0.3"]);
    let done = command.assert().code(1);
    let done = done.stderr(contains("1 of 3 orbits failed; the first, orbit 2: "));
    let all = top.path().join("all");
    let ends = rows(&all, "orbits.csv");
    let column = |name: &str| ends[0].iter().position(|known| known == name).unwrap();
    let of = |name: &str| -> Vec<&str> {
        let rows = ends[1..].iter();
        rows.map(|row| row[column(name)].as_str()).collect()
    };
    assert_eq!(of("ending"), ["end time", "failed", "end time"]);
    assert_eq!(of("x_start"), ["0.3"; 3]);
    let z: f64 = of("z_end")[2].parse().unwrap();
    assert!((z + 1.0 / 21.0).abs() < 1e-12, "{z}");
    assert!(of("error")[1].contains("escape") && of("error")[0].is_empty());
    assert!(!all.join("steps.csv").exists());
    let json: serde_json::Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    assert_eq!(json["orbits"].as_array().unwrap().len(), 3);
}

#[test]
fn a_row_that_the_system_cannot_have_keeps_the_others() {
    let ranged = BLOCK.replace("vp = 0.2", "vp = { value = 0.2, range = [0.05, 1] }");
    let (top, mut command) = program(&ranged);
    std::fs::write(
        top.path().join("starts.csv"),
        "vp,x\n0.2,0.3\n5,0.3\n0.1,0.3\n",
    )
    .unwrap();
    command.args(["simulate", "system.toml", "--starts", "starts.csv"]);
    command.args(["--out", "all", "--observe", "power=x*v"]);
    let said = "1 of 3 orbits failed; the first, orbit 2: vp = 5 is not allowed: its range in \
                the file is from 0.05 to 1";
    command.assert().code(1).stderr(contains(said));
    let all = top.path().join("all");
    let ends = rows(&all, "orbits.csv");
    let words: Vec<&str> = ends[1..].iter().map(|row| row[6].as_str()).collect();
    assert_eq!(ends[0][6], "ending");
    assert_eq!(words, ["end time", "failed", "end time"]);
    assert_eq!(&ends[2][1..7], ["5.0", "", "", "", "", "failed"]);
    let steps = rows(&all, "steps.csv");
    assert_eq!(steps[0].last().map(String::as_str), Some("power"));
    for number in ["1", "3"] {
        assert!(steps.iter().any(|row| row[0] == number), "{number}");
    }
}

#[test]
fn tables_that_are_no_starts_are_refused() {
    for (text, more, said) in [
        ("1\n2\n", None, "the first line has no names"),
        (
            "x,y\n1,2\n",
            None,
            "there is no state or parameter `y`; there are x, v, z, vp",
        ),
        ("x,x\n1,2\n", None, "the column x stands twice"),
        (
            "x,v\n1,2\n1,nan\n",
            None,
            "line 3: 2 finite numbers are needed, one for each of x, v",
        ),
        ("x,v\n1,2\n1\n", None, "line 3: 2 finite numbers are needed"),
        (
            "x\n1\n",
            Some(["--start", "x=1"]),
            "--start x=… has no effect",
        ),
        (
            "x,vp\n1,2\n",
            Some(["--set", "vp=1"]),
            "--set vp=… has no effect: vp is a column of starts.csv",
        ),
        (
            "x\n1\n",
            Some(["--no-steps", "--observe=q=x"]),
            "--observe q=x has no effect",
        ),
        (
            "x\n1\n",
            Some(["--derivatives", "vp"]),
            "cannot be used with",
        ),
    ] {
        let (top, mut command) = program(BLOCK);
        std::fs::write(top.path().join("starts.csv"), text).unwrap();
        command.args(["simulate", "system.toml", "--starts", "starts.csv"]);
        command.args(more.iter().flatten());
        command.assert().failure().stderr(contains(said));
    }
    let (_top, mut command) = program(BLOCK);
    command.args(["simulate", "system.toml", "--starts", "none.csv"]);
    command
        .assert()
        .failure()
        .stderr(contains("cannot read none.csv"));
}
