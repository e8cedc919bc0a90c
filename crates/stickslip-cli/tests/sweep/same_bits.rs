//! Identity of the bits on any number of threads, in any shares, after any damage.

use std::fs;
use std::num::NonZeroUsize;
use std::sync::Mutex;

use stickslip_cli::sweep::{Share, Task};

use super::common::{compute, plan, table, task, undisturbed};

#[test]
fn threads_do_not_change_a_bit() {
    for plan in [plan(40, 1), plan(3, 7)] {
        let one = undisturbed(&plan);
        for threads in [2, 5] {
            let folder = tempfile::tempdir().unwrap();
            let many = Task {
                threads: NonZeroUsize::new(threads),
                ..task(&plan, folder.path())
            };
            assert!(table(&compute(&many).unwrap().store) == one, "{threads}");
        }
    }
}

#[test]
fn a_block_goes_on_from_the_one_before_in_its_chain() {
    let text = String::from_utf8(undisturbed(&plan(2, 3))).unwrap();
    let one_chain = String::from_utf8(undisturbed(&plan(1, 3))).unwrap();
    // The first chain is the same sweep; the second one starts anew.
    assert!(text.starts_with(&one_chain));
    let x0 = 0.3 + 1e-3 * 3.0;
    let fourth = text.split("# 3\n").nth(1).unwrap();
    let first: f64 = fourth.lines().next().unwrap().parse().unwrap();
    assert_eq!(first, 3.99 * x0 * (1.0 - x0));
}

#[test]
fn shares_in_one_folder_make_the_whole() {
    // More shares than chains: the last ones are empty.
    for (plan, shares) in [(plan(10, 1), 3), (plan(3, 4), 5)] {
        let folder = tempfile::tempdir().unwrap();
        let mut blocks = 0;
        for number in 1..=shares {
            let share = Share::new(number, shares).unwrap();
            let one = Task {
                share,
                ..task(&plan, folder.path())
            };
            blocks += compute(&one).unwrap().new;
        }
        assert_eq!(blocks, plan.blocks());
        let all = compute(&task(&plan, folder.path())).unwrap();
        assert_eq!((all.new, all.old), (0, plan.blocks()));
        assert!(table(&all.store) == undisturbed(&plan));
    }
}

#[test]
fn damaged_blocks_are_computed_anew() {
    let plan = plan(3, 4);
    let folder = tempfile::tempdir().unwrap();
    compute(&task(&plan, folder.path())).unwrap();
    let path = |block: usize| folder.path().join(format!("blocks/{block:08}.block"));
    let whole = fs::read(path(1)).unwrap();
    fs::write(path(1), &whole[..whole.len() / 2]).unwrap();
    fs::write(path(2), b"").unwrap();
    let mut changed = fs::read(path(6)).unwrap();
    *changed.last_mut().unwrap() ^= 1;
    fs::write(path(6), changed).unwrap();
    fs::copy(path(10), path(11)).unwrap();
    fs::remove_file(path(4)).unwrap();
    let again = compute(&task(&plan, folder.path())).unwrap();
    let repaired: Vec<usize> = again.repaired.iter().map(|one| one.0).collect();
    assert_eq!(repaired, [1, 2, 6, 11]);
    assert_eq!((again.new, again.old), (5, 7));
    assert!(table(&again.store) == undisturbed(&plan));
}

#[test]
fn the_count_goes_from_what_was_there_to_all() {
    let plan = plan(6, 1);
    let folder = tempfile::tempdir().unwrap();
    let half = Task {
        share: Share::new(1, 2).unwrap(),
        ..task(&plan, folder.path())
    };
    compute(&half).unwrap();
    let seen = Mutex::new(Vec::new());
    let report = |done, all| seen.lock().unwrap().push((done, all));
    let whole = task(&plan, folder.path());
    stickslip_cli::sweep::run(&whole, &report, super::common::block).unwrap();
    let mut seen = seen.into_inner().unwrap();
    // Two threads may report in either order.
    seen.sort_unstable();
    assert_eq!(seen, [(3, 6), (4, 6), (5, 6), (6, 6)]);
}
