//! Files in the folder of a sweep. The first byte says which: a block, the manifest, or the content
//! of a block, whose hash is right. What is accepted is what the program writes.

#![no_main]

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use stickslip::analysis::{Attractor, PartialBranch};
use stickslip_cli::sweep::{Definition, Plan, Share, Store, Writer};
use tempfile::TempDir;

struct Folder {
    _keeps: TempDir,
    path: PathBuf,
    writer: Writer,
}

static FOLDER: LazyLock<Folder> = LazyLock::new(|| {
    let keeps = TempDir::new().expect("a temporary folder");
    let path = keeps.path().to_owned();
    let definition = Definition::new("fuzz.toml".to_owned(), "text".to_owned());
    let size = (NonZeroUsize::MIN, NonZeroUsize::MIN);
    let plan = Plan::new("basin", BTreeMap::new(), size, definition);
    let writer = Writer::open(&path, &plan, Share::WHOLE).expect("a new folder");
    writer.put(0, b"content").expect("a block");
    Folder {
        _keeps: keeps,
        path,
        writer,
    }
});

fn write(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).expect("the folder is there");
}

fuzz_target!(|bytes: &[u8]| {
    let Some((which, rest)) = bytes.split_first() else {
        return;
    };
    let folder = &*FOLDER;
    match which % 3 {
        0 => {
            let block = folder.path.join("blocks").join("00000000.block");
            write(&block, rest);
            if let Ok(Some(Ok(content))) = folder.writer.store.find(0) {
                folder.writer.put(0, &content).expect("a block");
                assert_eq!(std::fs::read(&block).expect("it was written"), rest);
            }
        }
        1 => {
            let manifest = folder.path.join("manifest.json");
            let sound = std::fs::read(&manifest).expect("the folder has one");
            write(&manifest, rest);
            let opened = Store::open(&folder.path).map(drop);
            write(&manifest, &sound);
            if let Err(fault) = opened {
                assert!(!fault.to_string().is_empty());
            }
        }
        _ => {
            if let Ok(branch) = ciborium::from_reader::<PartialBranch, _>(rest) {
                let mut again = Vec::new();
                ciborium::into_writer(&branch, &mut again).expect("it was read");
            }
            let _ = ciborium::from_reader::<Vec<Attractor>, _>(rest);
        }
    }
});
