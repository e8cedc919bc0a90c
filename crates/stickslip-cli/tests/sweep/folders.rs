//! Contents of a folder that are accepted, and the messages for all others.

use std::fs;
use std::path::Path;

use serde_json::json;
use stickslip_cli::sweep::{Plan, Share, SweepError, Task, Writer};

use super::common::{
    block, compute, definition, folder, plan, program, table, task, text, undisturbed,
};

/// The message for a sweep in the folder of another one.
fn refusal(old: &Plan, new: &Plan) -> String {
    let folder = tempfile::tempdir().unwrap();
    compute(&task(old, folder.path())).unwrap();
    let before = files(folder.path());
    let error = compute(&task(new, folder.path())).unwrap_err();
    assert!(error.is_usage());
    assert_eq!(files(folder.path()), before, "something was changed");
    error.to_string()
}

/// Names and contents of all files.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path));
        } else {
            all.push((path.display().to_string(), fs::read(&path).unwrap()));
        }
    }
    all.sort();
    all
}

#[test]
fn another_argument_is_refused_with_both_values() {
    let old = plan(2, 1);
    let mut new = old.clone();
    new.arguments.insert("a b = µ".to_owned(), json!(0.2));
    let message = refusal(&old, &new);
    let wanted = "the argument `a b = µ` was 0.1 there and is 0.2 now";
    assert!(
        message.contains(wanted) && message.contains("--out"),
        "{message}"
    );

    let mut new = old.clone();
    new.arguments.remove("grid");
    let message = refusal(&old, &new);
    assert!(
        message.contains("`grid` was [3,4] there and is absent now"),
        "{message}"
    );

    let message = refusal(&old, &plan(3, 1));
    assert!(message.contains("the number of chains was 2"), "{message}");
}

#[test]
fn numbers_that_differ_in_the_last_bit_are_not_the_same() {
    let old = plan(2, 1);
    let mut new = old.clone();
    let next = 0.1_f64.next_up();
    new.arguments.insert("a b = µ".to_owned(), json!(next));
    assert!(refusal(&old, &new).contains("0.10000000000000002"));
}

#[test]
fn another_system_is_refused_with_the_line() {
    let old = plan(2, 1);
    let with = |text: &str| {
        let mut new = old.clone();
        new.system = definition(text);
        new
    };
    let message = refusal(&old, &with("first\nmu = 0.4\nlast\n"));
    let wanted = r#"line 2 of the system was "mu = 0.3" there and is "mu = 0.4" now"#;
    assert!(message.contains(wanted), "{message}");
    let message = refusal(&old, &with("first\nmu = 0.3\nlast\nmore\n"));
    assert!(
        message.contains(r#"line 4 of the system was "" there and is "more" now"#),
        "{message}"
    );
}

#[test]
fn blocks_of_another_sweep_are_not_overwritten() {
    let (ours, theirs) = (plan(2, 1), plan(3, 1));
    let (here, there) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    compute(&task(&theirs, there.path())).unwrap();
    compute(&task(&ours, here.path())).unwrap();
    let name = "blocks/00000001.block";
    fs::copy(there.path().join(name), here.path().join(name)).unwrap();
    let error = compute(&task(&ours, here.path())).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains(name) && message.contains("another sweep"),
        "{message}"
    );
    fs::remove_file(here.path().join(name)).unwrap();
    let all = compute(&task(&ours, here.path())).unwrap();
    assert!(table(&all.store) == undisturbed(&ours));
}

#[test]
fn a_manifest_that_is_gone_or_damaged_is_reported() {
    let plan = plan(2, 1);
    let folder = tempfile::tempdir().unwrap();
    compute(&task(&plan, folder.path())).unwrap();
    let path = folder.path().join("manifest.json");
    let sound = fs::read_to_string(&path).unwrap();
    fs::remove_file(&path).unwrap();
    let message = |wanted: &str| {
        let error = compute(&task(&plan, folder.path())).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error}");
    };
    message("no manifest.json");
    let other_format = sound.replace("\"format\": 22", "\"format\": 9");
    assert_ne!(other_format, sound);
    let other_text = sound.replace("mu = 0.3", "mu = 0.4");
    let other_program = sound.replace("stickslip 0.", "stickslip 9.");
    for (text, wanted) in [
        (&sound[..sound.len() / 2], "cannot be read"),
        ("{}", "it has no format"),
        (&other_format, "its format is 9, and this one reads 22"),
        (&other_text, "not the one that its hash is of"),
        (&other_program, "the program was `stickslip 9."),
    ] {
        fs::write(&path, text).unwrap();
        message(wanted);
    }
    fs::write(&path, sound).unwrap();
    assert_eq!(compute(&task(&plan, folder.path())).unwrap().old, 2);
}

#[test]
fn a_folder_that_is_a_file_or_below_one_is_reported() {
    let file = tempfile::NamedTempFile::new().unwrap();
    for folder in [file.path().to_owned(), file.path().join("below")] {
        let error = compute(&task(&plan(2, 1), &folder)).unwrap_err();
        assert!(matches!(error, SweepError::CreateFolder { .. }), "{error}");
        assert!(error.to_string().contains("--out"));
    }
}

#[test]
fn a_block_that_cannot_be_written_is_named_and_the_others_stay() {
    let plan = plan(4, 1);
    let folder = tempfile::tempdir().unwrap();
    let first = Task {
        share: Share::new(1, 2).unwrap(),
        ..task(&plan, folder.path())
    };
    compute(&first).unwrap();
    // A folder in place of the block cannot be replaced by a file.
    let place = folder.path().join("blocks/00000003.block");
    fs::create_dir(&place).unwrap();
    let error = compute(&task(&plan, folder.path())).unwrap_err();
    assert!(error.to_string().contains("00000003.block"), "{error}");
    fs::remove_dir(&place).unwrap();
    let all = compute(&task(&plan, folder.path())).unwrap();
    assert!(all.old >= 2);
    assert!(table(&all.store) == undisturbed(&plan));
}

#[test]
fn an_error_of_a_block_names_it_and_keeps_what_was_done() {
    let plan = plan(1, 4);
    let folder = tempfile::tempdir().unwrap();
    let failing = |index, before: Option<&[u8]>| match index {
        2 => Err("no such state".into()),
        _ => block(index, before),
    };
    let whole = task(&plan, folder.path());
    let error = stickslip_cli::sweep::run(&whole, &|_, _| {}, failing).unwrap_err();
    assert_eq!(error.to_string(), "block 2: no such state");
    let all = compute(&whole).unwrap();
    assert_eq!((all.old, all.new), (2, 2));
    assert!(table(&all.store) == undisturbed(&plan));
}

#[test]
fn shares_are_numbered_from_one() {
    assert_eq!("3/8".parse::<Share>().unwrap().to_string(), "3/8");
    for wrong in ["0/8", "9/8", "3", "3/", "/8", "-1/8", "3/8/2", "0/0", "a/b"] {
        let error = wrong.parse::<Share>().unwrap_err();
        assert!(error.is_usage());
        assert!(error.to_string().contains(&format!("`{wrong}`")), "{error}");
    }
}

#[test]
fn only_the_blocks_of_a_share_are_removed() {
    let plan = plan(4, 2);
    let folder = tempfile::tempdir().unwrap();
    let computed = compute(&task(&plan, folder.path())).unwrap();
    let second = Share::new(2, 2).unwrap();
    let writer = Writer::open(folder.path(), &plan, second).unwrap();
    writer.remove_blocks(second).unwrap();
    let is_there = |block: usize| computed.store.find(block).unwrap().is_some();
    let there: Vec<usize> = (0..plan.blocks())
        .filter(|&block| is_there(block))
        .collect();
    assert_eq!(there, [0, 1, 4, 5]);
}

#[test]
fn blocks_of_a_share_that_another_process_computes_are_not_removed() {
    let plan = plan(4, 2);
    let folder = tempfile::tempdir().unwrap();
    // What it returns holds a lock until it is dropped.
    drop(compute(&task(&plan, folder.path())).unwrap());
    let blocks = || fs::read_dir(folder.path().join("blocks")).unwrap().count();
    assert_eq!(blocks(), plan.blocks());
    let begun = Writer::open(folder.path(), &plan, Share::new(1, 2).unwrap()).unwrap();
    let removed = |command: &str| Writer::remove_sweep(folder.path(), command);
    let error = removed(&plan.command).unwrap_err();
    assert!(
        matches!(&error, SweepError::Busy { share, .. } if share == "1/2"),
        "{error}"
    );
    assert_eq!(blocks(), plan.blocks());
    drop(begun);
    let error = removed("another").unwrap_err();
    assert!(matches!(error, SweepError::Differs { .. }), "{error}");
    assert_eq!(blocks(), plan.blocks());
    removed(&plan.command).unwrap();
    assert_eq!(blocks(), 0);
    // Without its manifest the folder is free for another sweep.
    Writer::check(folder.path(), &super::common::plan(3, 1)).unwrap();
}

/// Counts of the blocks that a command reports: computed and found.
fn blocks_of(folder: &Path, arguments: &[&str]) -> (u64, u64) {
    let output = program(folder).args(arguments).arg("--json").unwrap();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let count = |key: &str| json[key].as_u64().unwrap();
    (count("computed"), count("there_before"))
}

#[test]
fn a_sweep_begins_anew_on_request() {
    let folder = folder();
    let share = ["basin", "belt", "--grid", "2x4", "--shard", "1/2"];
    assert_eq!(blocks_of(folder.path(), &share), (2, 0));
    assert_eq!(blocks_of(folder.path(), &share), (0, 2));
    let fresh = [&share[..], &["--fresh"]].concat();
    assert_eq!(blocks_of(folder.path(), &fresh), (2, 0));
}

#[test]
fn a_branch_begins_anew_on_request() {
    let folder = folder();
    let branch = [
        "continue",
        "belt",
        "--parameter",
        "vp=0.9:1.1",
        "--out",
        "out",
    ];
    program(folder.path()).args(branch).assert().success();
    let table = text(folder.path().join("out/branch.csv"));
    // A block beyond those of the branch, as of a curve in two parameters.
    let further = folder.path().join("out/sweep/blocks/00000042.block");
    fs::write(&further, "").unwrap();
    program(folder.path()).args(branch).assert().success();
    assert!(further.exists());
    program(folder.path())
        .args(branch)
        .arg("--fresh")
        .assert()
        .success();
    assert!(!further.exists());
    assert_eq!(text(folder.path().join("out/branch.csv")), table);
    // Also with other options, and before a branch of equilibria, which saves nothing.
    let mut longer = branch.to_vec();
    longer.extend(["--step", "0.05"]);
    program(folder.path()).args(&longer).assert().failure();
    longer.push("--fresh");
    program(folder.path()).args(&longer).assert().success();
    assert!(text(folder.path().join("out/branch.csv")) != table);
    longer.extend(["--equilibrium", "--set", "vp=2", "--start", "x=0.4,y=0"]);
    program(folder.path()).args(&longer).output().unwrap();
    assert!(!folder.path().join("out/sweep/manifest.json").exists());
}
