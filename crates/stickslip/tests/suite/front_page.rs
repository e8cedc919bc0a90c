//! The front page names everything that the library exports.

use std::fs::read_to_string;
use std::path::Path;

/// The names of all `pub use` of a source file, and of its public modules.
fn exported(source: &str) -> Vec<String> {
    let lists = source.split("\npub use ").skip(1);
    let lists = lists.map(|rest| rest.split(';').next().unwrap());
    let words = lists.flat_map(|list| {
        let list = list.rsplit("::").next().unwrap();
        list.split(|c: char| !c.is_alphanumeric() && c != '_')
    });
    let words = words.filter(|word| !word.is_empty());
    words.map(str::to_owned).collect()
}

#[test]
fn the_front_page_names_everything_that_is_exported() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let read = |path: &str| read_to_string(folder.join(path)).unwrap();
    let lib = read("lib.rs");
    let page: String = lib
        .lines()
        .filter_map(|line| line.strip_prefix("//!"))
        .collect();
    for path in ["lib.rs", "analysis/mod.rs", "dynamics/mod.rs", "ode/mod.rs"] {
        let names = exported(&read(path));
        assert!(names.len() > 5, "{path}: {names:?}");
        let is_named = |name: &str| {
            let forms = [format!("`{name}`"), format!("::{name}`")];
            forms.iter().any(|form| page.contains(form))
        };
        let missing = names.iter().filter(|name| !is_named(name));
        let missing: Vec<&String> = missing.collect();
        assert!(missing.is_empty(), "{path}: {missing:?}");
    }
}
