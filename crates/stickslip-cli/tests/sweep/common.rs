//! A sweep that is fast and whose bits depend on everything they may depend on; and the program.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use serde_json::json;
use stickslip_cli::sweep::{
    BlockError, Computed, Definition, Plan, Share, Store, SweepError, Task, run,
};

/// A sweep of so many chains of blocks.
pub fn plan(chains: usize, length: usize) -> Plan {
    let arguments = BTreeMap::from([
        ("a b = µ".to_owned(), json!(0.1)),
        ("grid".to_owned(), json!([3, 4])),
    ]);
    let size = [chains, length].map(|size| NonZeroUsize::new(size).unwrap());
    let system = definition("first\nmu = 0.3\nlast\n");
    Plan::new("test", arguments, size.into(), system)
}

/// A system from this text.
pub fn definition(text: &str) -> Definition {
    Definition::new("a system".to_owned(), text.to_owned())
}

/// A block: iterates of the logistic map, which are chaotic, from the end of the previous block.
pub fn block(index: usize, before: Option<&[u8]>) -> Result<Vec<u8>, BlockError> {
    let mut x = match before {
        None => 0.3 + 1e-3 * index as f64,
        Some(bytes) => {
            let text = std::str::from_utf8(bytes)?;
            text.lines().last().ok_or("an empty block")?.parse()?
        }
    };
    let mut text = String::new();
    for _ in 0..50 {
        x = 3.99 * x * (1.0 - x);
        writeln!(text, "{x:?}")?;
    }
    Ok(text.into_bytes())
}

pub fn task<'a>(plan: &'a Plan, folder: &'a Path) -> Task<'a> {
    Task {
        plan,
        folder,
        share: Share::WHOLE,
        threads: None,
    }
}

pub fn compute(task: &Task<'_>) -> Result<Computed, SweepError> {
    run(task, &|_, _| {}, block)
}

/// All blocks of a complete sweep, in order.
pub fn table(store: &Store) -> Vec<u8> {
    let mut table = Vec::new();
    let appended = store.for_each(|index, content| {
        table.extend_from_slice(format!("# {index}\n").as_bytes());
        table.extend_from_slice(content);
        Ok::<_, SweepError>(())
    });
    appended.unwrap();
    table
}

/// The result of an uninterrupted run on one thread.
pub fn undisturbed(plan: &Plan) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let one = Task {
        threads: NonZeroUsize::new(1),
        ..task(plan, folder.path())
    };
    table(&compute(&one).unwrap().store)
}

/// The program, run in a folder.
pub fn program(folder: &Path) -> assert_cmd::Command {
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.current_dir(folder);
    command
}

pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

pub fn text(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// All files below a folder except locks, by name.
pub fn files(top: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![top.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name().unwrap() != "lock" {
                let name = path.strip_prefix(top).unwrap().to_owned();
                all.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    all
}
