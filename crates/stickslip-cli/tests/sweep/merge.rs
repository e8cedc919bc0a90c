//! Shares in separate folders, merged.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;
use stickslip_cli::sweep::{Plan, Share, SweepError, Task, merge};
use tempfile::TempDir;

use super::common::{compute, plan, table, task, undisturbed};

/// Computes share `number` of `of` into a folder below `top`.
fn share(plan: &Plan, top: &TempDir, number: usize, of: usize) -> PathBuf {
    let folder = top.path().join(format!("share {number}"));
    let one = Task {
        share: Share::new(number, of).unwrap(),
        ..task(plan, &folder)
    };
    compute(&one).unwrap();
    folder
}

fn shares(plan: &Plan, top: &TempDir, of: usize) -> Vec<PathBuf> {
    (1..=of)
        .map(|number| share(plan, top, number, of))
        .collect()
}

fn name(block: usize) -> String {
    format!("blocks/{block:08}.block")
}

fn refused(out: &Path, folders: &[PathBuf]) -> String {
    let error = merge(out, folders).unwrap_err();
    assert!(!out.exists(), "something was written");
    error.to_string()
}

#[test]
fn shares_make_the_whole_bit_for_bit() {
    for plan in [plan(11, 1), plan(3, 4)] {
        let top = tempfile::tempdir().unwrap();
        let folders = shares(&plan, &top, 4);
        let out = top.path().join("out");
        let merged = merge(&out, &folders).unwrap();
        assert_eq!(merged.repeated, 0);
        assert!(table(&merged.store) == undisturbed(&plan));
        drop(merged);
        // The files are those of a single run, which can be resumed from them.
        let single = tempfile::tempdir().unwrap();
        compute(&task(&plan, single.path())).unwrap();
        for block in 0..plan.blocks() {
            let of = |folder: &Path| fs::read(folder.join(name(block))).unwrap();
            assert!(of(&out) == of(single.path()));
        }
        assert_eq!(compute(&task(&plan, &out)).unwrap().new, 0);
    }
}

#[test]
fn one_of_the_shares_can_take_in_the_others() {
    let plan = plan(6, 1);
    let top = tempfile::tempdir().unwrap();
    let folders = shares(&plan, &top, 2);
    let merged = merge(&folders[0], &folders).unwrap();
    assert!(table(&merged.store) == undisturbed(&plan));
}

#[test]
fn gaps_are_refused_and_named() {
    let plan = plan(12, 1);
    let top = tempfile::tempdir().unwrap();
    let mut folders = shares(&plan, &top, 3);
    let out = top.path().join("out");
    let path = folders[0].join(name(3));
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    folders.pop();
    let message = refused(&out, &folders);
    let wanted = "5 of 12 blocks are missing: 2-3, 5, 8, 11";
    assert!(message.contains(wanted), "{message}");
    assert!(
        message.contains("share 1/blocks/00000003.block is cut short"),
        "{message}"
    );
}

#[test]
fn a_damaged_block_is_taken_from_another_share_that_has_it() {
    let plan = plan(4, 1);
    let top = tempfile::tempdir().unwrap();
    let folders = [share(&plan, &top, 1, 1), share(&plan, &top, 2, 2)];
    fs::write(folders[0].join(name(1)), b"stickslip-block").unwrap();
    let merged = merge(&top.path().join("out"), &folders).unwrap();
    assert_eq!(merged.repeated, 1);
    assert!(table(&merged.store) == undisturbed(&plan));
}

#[test]
fn overlaps_that_differ_are_refused() {
    let plan = plan(4, 1);
    let top = tempfile::tempdir().unwrap();
    let folders = [share(&plan, &top, 1, 1), share(&plan, &top, 2, 2)];
    // The same sweep by a program that computes something else.
    let wrong = Task {
        share: Share::new(2, 2).unwrap(),
        ..task(&plan, &folders[1])
    };
    fs::remove_file(folders[1].join(name(3))).unwrap();
    let other = |_, _: Option<&[u8]>| Ok(b"other".to_vec());
    stickslip_cli::sweep::run(&wrong, &|_, _| {}, other).unwrap();
    let message = refused(&top.path().join("out"), &folders);
    assert!(message.starts_with("block 3 in "), "{message}");
    assert!(
        message.contains("share 1") && message.contains("share 2"),
        "{message}"
    );
}

#[test]
fn strangers_are_refused() {
    let (ours, mut theirs) = (plan(4, 1), plan(4, 1));
    theirs.arguments.insert("grid".to_owned(), json!([3, 5]));
    let (top, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let out = top.path().join("out");
    let ours = shares(&ours, &top, 2);
    let strange = share(&theirs, &other, 2, 2);
    let message = refused(&out, &[ours[0].clone(), strange.clone()]);
    let wanted = "the argument `grid` is [3,4] in the first and [3,5] in the second";
    assert!(message.contains(wanted), "{message}");
    // A foreign block among ours.
    fs::copy(strange.join(name(1)), ours[1].join(name(1))).unwrap();
    let message = refused(&out, &ours);
    assert!(
        message.contains("share 2/blocks/00000001.block is a block of another"),
        "{message}"
    );
    // A block that this sweep does not have.
    fs::rename(ours[1].join(name(1)), ours[1].join(name(4))).unwrap();
    let message = refused(&out, &ours);
    assert!(
        message.contains("share 2/blocks/00000004.block is a block of another"),
        "{message}"
    );
}

#[test]
fn a_folder_without_a_sweep_is_refused() {
    let top = tempfile::tempdir().unwrap();
    let out = top.path().join("out");
    let error = merge(&out, &[top.path()]).unwrap_err();
    assert!(matches!(error, SweepError::NoSweep { .. }), "{error}");
    let none: [&Path; 0] = [];
    assert!(matches!(
        merge(&out, &none),
        Err(SweepError::NoSweep { .. })
    ));
}

#[test]
fn what_is_merged_into_must_be_the_same_sweep() {
    let top = tempfile::tempdir().unwrap();
    let folders = shares(&plan(4, 1), &top, 2);
    let other = tempfile::tempdir().unwrap();
    compute(&task(&plan(5, 1), other.path())).unwrap();
    let error = merge(other.path(), &folders).unwrap_err();
    assert!(matches!(error, SweepError::Differs { .. }), "{error}");
}
