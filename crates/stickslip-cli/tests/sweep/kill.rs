//! A sweep that is killed at random moments, and goes on.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use stickslip_cli::sweep::{Computed, Plan, SweepError, run};

use super::common::{block, plan, table, task, undisturbed};

/// Where the process to be killed finds its folder.
const FOLDER: &str = "STICKSLIP_TEST_SWEEP";

fn long() -> Plan {
    plan(5, 8)
}

/// As slow as it must be to be killed within.
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
    // Told on standard output, so that nobody kills it before it has begun.
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

#[test]
fn killed_twenty_times_it_goes_on_to_the_same_bits() {
    let (plan, wanted) = (long(), undisturbed(&long()));
    // A sequence of moments without order, the same at each run of the test.
    let mut moment = 12_345_u64;
    let mut within = 0;
    for _ in 0..20 {
        let folder = tempfile::tempdir().unwrap();
        // Two kills each, so that what goes on is killed as well.
        for _ in 0..2 {
            moment = moment.wrapping_mul(6_364_136_223_846_793_005) + 1_442_695;
            let mut child = begin(folder.path());
            sleep(Duration::from_micros((moment >> 33) % 60_000));
            // SIGKILL: the process has no say in it.
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
    // The lock went with the process.
    slowly(&long(), folder.path()).unwrap();
}
