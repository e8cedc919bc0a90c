//! A sweep that is killed at random times and resumed.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use stickslip_cli::sweep::{Computed, Plan, SweepError, run};

use super::common::{block, files, folder, plan, program, table, task, undisturbed};

/// The variable with the folder for the process to be killed.
const FOLDER: &str = "STICKSLIP_TEST_SWEEP";

fn long() -> Plan {
    plan(5, 8)
}

/// Computes as slowly as needed for a kill in the middle.
fn slowly(plan: &Plan, folder: &Path) -> Result<Computed, SweepError> {
    run(&task(plan, folder), &|_, _| {}, |index, before| {
        sleep(Duration::from_millis(5));
        block(index, before)
    })
}

#[test]
#[ignore = "the process that the other tests kill"]
fn sweeps_until_it_is_killed() {
    let folder = std::env::var_os(FOLDER).unwrap();
    // Printed on standard output, so that the kill comes after the start.
    println!("begun");
    slowly(&long(), Path::new(&folder)).unwrap();
}

fn begin(folder: &Path) -> Child {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "kill::sweeps_until_it_is_killed"])
        .args(["--ignored", "--nocapture"])
        .env(FOLDER, folder)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let begun = lines
        .map_while(Result::ok)
        .any(|line| line.contains("begun"));
    assert!(begun);
    child
}

fn blocks_in(folder: &Path) -> usize {
    std::fs::read_dir(folder.join("blocks")).map_or(0, Iterator::count)
}

/// The next pseudorandom number between 0 and 1, the same in each run of the test.
fn drawn(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005) + 1_442_695;
    (*state >> 33) as f64 / f64::from(1_u32 << 31)
}

#[test]
fn killed_twenty_times_it_goes_on_to_the_same_bits() {
    let (plan, wanted) = (long(), undisturbed(&long()));
    let mut moment = 12_345_u64;
    let mut within = 0;
    for _ in 0..20 {
        let folder = tempfile::tempdir().unwrap();
        // Two kills each, so that a resumed run is killed as well. The blocks that are there
        // decide when, so that a busy machine does not.
        for part in [0.5, 1.0] {
            let mut child = begin(folder.path());
            let killed_at = (part * drawn(&mut moment) * plan.blocks() as f64) as usize;
            while blocks_in(folder.path()) < killed_at && child.try_wait().unwrap().is_none() {
                sleep(Duration::from_millis(1));
            }
            sleep(Duration::from_millis(5).mul_f64(drawn(&mut moment)));
            // SIGKILL cannot be handled.
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let there = blocks_in(folder.path());
        within += usize::from(there > 0 && there < plan.blocks());
        let all = slowly(&plan, folder.path()).unwrap();
        assert_eq!(all.repaired, [], "a block was there and not whole");
        assert_eq!((all.old, all.new), (there, plan.blocks() - there));
        assert!(table(&all.store) == wanted);
        let rest = std::fs::read_dir(folder.path().join("work/1-of-1")).unwrap();
        assert_eq!(rest.count(), 1, "something unfinished was left");
    }
    assert!(within >= 10, "only {within} of 20 were killed within");
}

/// Each resumable sweep, with its own table, and the number of kills.
const SWEEPS: [(&[&str], &str, u32); 3] = [
    (&["basin", "basins", "--grid", "24x16"], "basin.csv", 8),
    (
        &[
            "map",
            "basins",
            "--x",
            "vd=1.2:2",
            "--y",
            "d=0.05:0.15",
            "--grid",
            "8x4",
        ],
        "map.csv",
        6,
    ),
    (
        &[
            "bifurcation",
            "basins",
            "--parameter",
            "vd=1:2",
            "--values",
            "41",
            "--tol",
            "1e-10",
        ],
        "bifurcation.csv",
        6,
    ),
];

#[test]
fn the_program_killed_at_any_moment_goes_on_by_the_same_command() {
    let top = folder();
    let out = |name: &str| top.path().join(name);
    let mut moment = 54_321_u64;
    let mut within = 0;
    for (sweep, table, kills) in SWEEPS {
        let run = |name: &str| {
            let to = ["--out", name];
            program(top.path()).args(sweep).args(to).assert().success();
        };
        let begin = Instant::now();
        run("whole");
        let long = begin.elapsed();
        let whole = files(&out("whole"));
        for kill in 0..kills {
            let name = format!("killed {kill}");
            let mut child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
                .current_dir(top.path())
                .args(sweep)
                .args(["--out", &name])
                .stdout(Stdio::null())
                .spawn()
                .unwrap();
            sleep(long.mul_f64(drawn(&mut moment)));
            child.kill().unwrap();
            child.wait().unwrap();
            let is_within =
                blocks_in(&out(&name).join("sweep")) > 0 && !out(&name).join(table).exists();
            within += u32::from(is_within);
            run(&name);
            let there = files(&out(&name));
            let names: Vec<_> = there.keys().collect();
            assert!(there == whole, "{sweep:?}, {kill}: {names:?}");
            std::fs::remove_dir_all(out(&name)).unwrap();
        }
        // The state that a kill leaves while a table is being written.
        std::fs::write(out("whole/sweep/work/tables/.tmp"), "half").unwrap();
        run("whole");
        assert!(files(&out("whole")) == whole, "{sweep:?}");
        std::fs::remove_dir_all(out("whole")).unwrap();
    }
    assert!(within >= 5, "only {within} of 20 were killed within");
}

#[test]
fn a_branch_killed_as_it_grows_goes_on_by_the_same_command() {
    let top = folder();
    let range = ["--parameter", "vd=1.1:2", "--step", "0.004"];
    let branch = [&["continue", "basins"], &range[..]].concat();
    let run = |name: &str| {
        let to = ["--out", name];
        program(top.path())
            .args(&branch)
            .args(to)
            .assert()
            .success();
    };
    run("whole");
    let out = |name: &str| top.path().join(name);
    let whole = files(&out("whole"));
    let block = out("killed").join("sweep/blocks/00000001.block");
    // Until more orbits are saved on the way upwards.
    let mut size = 0;
    for kill in 0..2 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .current_dir(top.path())
            .args(&branch)
            .args(["--out", "killed"])
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let saved = || std::fs::metadata(&block).map_or(0, |file| file.len());
        while saved() <= size {
            assert_eq!(
                child.try_wait().unwrap(),
                None,
                "{kill}: it was done at {size}"
            );
            sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!out("killed/branch.csv").exists());
        size = saved();
    }
    // A resumed sweep continues from the saved state, not from the start.
    assert!(size > 0 && whole[Path::new("sweep/blocks/00000001.block")].len() as u64 > size);
    run("killed");
    assert!(files(&out("killed")) == whole);
    // A truncated file is computed again.
    let bytes = std::fs::read(&block).unwrap();
    std::fs::write(&block, &bytes[..bytes.len() / 2]).unwrap();
    run("killed");
    assert!(files(&out("killed")) == whole);
}

/// `u' = p + q u - u³` about `cos t` has two folds over p.
const CUSP: &str = include_str!("../../../stickslip-model/tests/data/cusp.toml");

/// An orbit about `cos t` doubles its period at p = 0.
const FLIP: &str = include_str!("../../../stickslip-model/tests/data/doubled.toml");

/// Each takes a second part, which is killed when the first of its results is saved.
#[test]
fn curves_and_other_branches_are_kept_over_a_kill() {
    let top = folder();
    for (name, text, arguments) in [
        ("cusp", CUSP, ["p=-1:1", "--also=q=-0.5:1"].as_slice()),
        ("flip", FLIP, &["p=-0.2:0.3", "--branches"]),
    ] {
        let file = format!("{name}.toml");
        std::fs::write(top.path().join(&file), text).unwrap();
        let out = |of: &str| top.path().join(format!("{name}-{of}"));
        let run = |of: &str| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
            command.current_dir(top.path()).args(["continue", &file]);
            command
                .args(["--periods", "1", "--parameter"])
                .args(arguments);
            command.arg("--out").arg(out(of)).stdout(Stdio::null());
            command
        };
        assert!(run("whole").status().unwrap().success());
        let whole = files(&out("whole"));
        let kept = || {
            let blocks = std::fs::read_dir(out("killed").join("sweep/blocks"));
            let blocks = blocks.into_iter().flatten().map(|block| block.unwrap());
            let blocks = blocks.filter(|block| block.file_name() > *"00000001.block");
            let times = blocks.map(|block| (block.path(), block.metadata().unwrap().modified()));
            times
                .map(|(path, time)| (path, time.unwrap()))
                .collect::<BTreeMap<_, _>>()
        };
        let mut child = run("killed").spawn().unwrap();
        while kept().is_empty() && child.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(1));
        }
        let _ = child.kill();
        child.wait().unwrap();
        let before = kept();
        assert!(run("killed").status().unwrap().success());
        assert!(files(&out("killed")) == whole, "{name}");
        // What was saved is used, not computed anew.
        let after = kept();
        assert!(before.iter().all(|(path, time)| after[path] == *time));
    }
}

#[test]
fn two_processes_do_not_compute_the_same_share() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = begin(folder.path());
    while blocks_in(folder.path()) == 0 {
        sleep(Duration::from_millis(1));
    }
    let error = slowly(&long(), folder.path()).unwrap_err();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(matches!(error, SweepError::Busy { .. }), "{error}");
    // The lock ends with the process.
    slowly(&long(), folder.path()).unwrap();
}
