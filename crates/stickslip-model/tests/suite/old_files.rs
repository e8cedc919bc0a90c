//! System files of version 0.2.0 mean what they meant. `data/version-0.2.0` has all of that
//! version's systems and of its documentation, and the results of its program. Nothing there is
//! edited.

use std::collections::BTreeMap;
use std::fs::{read_dir, read_to_string};
use std::path::Path;

use crate::run::{METHODS, Run, options, system};

#[test]
fn system_files_of_version_0_2_0_mean_what_they_meant() {
    const T_END: f64 = 12.0;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/version-0.2.0");
    let ends = read_to_string(folder.join("ends.csv")).unwrap();
    let mut expected = BTreeMap::<_, Vec<_>>::new();
    for line in ends.lines().skip(1) {
        let [file, transitions, state, x] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("{line}");
        };
        let row = (
            transitions.parse::<usize>().unwrap(),
            state,
            x.parse::<f64>().unwrap(),
        );
        expected.entry(file.to_owned()).or_default().push(row);
    }
    let files = read_dir(&folder).unwrap();
    let files = files.map(|entry| entry.unwrap().path());
    let files: Vec<_> = files
        .filter(|path| path.extension().unwrap() == "toml")
        .collect();
    assert_eq!(files.len(), expected.len());
    for path in files {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let text = read_to_string(&path).unwrap();
        for method in METHODS {
            let run = Run::of(system(&text), &options(method), Some(T_END));
            for (transitions, state, x) in &expected[name] {
                assert_eq!(run.transitions.len(), *transitions, "{name} by {method}");
                let off = (run.end(state) - x).abs();
                assert!(off < 1e-8, "{name} by {method}: {state} is off by {off:e}");
            }
        }
    }
}
