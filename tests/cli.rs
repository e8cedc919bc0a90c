//! Every figure program from the command line, with valid and invalid arguments.

use std::path::Path;

use assert_cmd::Command;
use assert_cmd::cargo::cargo_bin_cmd;
use predicates::prelude::*;

/// Largest acceptable size of an SVG.
const LARGEST_SVG: u64 = 300_000;
/// Figures whose table has a status for exponents.
const WITH_STATUS: [&str; 3] = ["fig10", "fig11", "fig12"];

fn default_run_writes_a_named_picture_and_its_numbers(mut program: Command, name: &str) {
    let folder = tempfile::tempdir().unwrap();
    program
        .current_dir(folder.path())
        .assert()
        .success()
        .stdout(
            predicate::str::contains("published")
                .and(predicate::str::contains(format!("{name}.svg"))),
        )
        .stderr("");

    let figures = folder.path().join("figures");
    assert_eq!(
        files(&figures),
        [
            "curves".to_owned(),
            format!("{name}.csv"),
            format!("{name}.svg")
        ]
    );
    assert_eq!(files(&figures.join("curves")), [format!("{name}.csv")]);
    check_csv(&figures.join(format!("{name}.csv")), name);
    check_svg(&figures.join(format!("{name}.svg")), name);
}

/// This replaces a long run. One function serves all these programs. Where the figures are
/// computed, once, another test compares them with the committed files.
fn the_committed_files_are_well_formed(name: &str) {
    let figures = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures");
    check_csv(&figures.join(format!("{name}.csv")), name);
    check_svg(&figures.join(format!("{name}.svg")), name);
}

fn check_csv(path: &Path, name: &str) {
    let text = std::fs::read_to_string(path).unwrap();
    let header = if WITH_STATUS.contains(&name) {
        "id,reading,value,published,unit,agrees,status"
    } else {
        "id,reading,value,published,unit,agrees"
    };
    assert_eq!(text.lines().next(), Some(header));
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let mut ids = Vec::new();
    for record in reader.records() {
        let record = record.unwrap();
        assert!(!record[0].is_empty() && !record[1].is_empty() && !record[2].is_empty());
        assert!(["true", "false", ""].contains(&&record[5]), "{record:?}");
        assert_eq!(record[3].is_empty(), record[5].is_empty(), "{record:?}");
        if WITH_STATUS.contains(&name) {
            let exponent = record[0].contains(".lambda.");
            let known =
                ["ok", "annihilated", "unidentified", "unstable", "biased"].contains(&&record[6]);
            assert!(
                if exponent {
                    known
                } else {
                    record[6].is_empty()
                },
                "{record:?}"
            );
            assert_eq!(
                &record[6] == "annihilated",
                &record[2] == "-inf",
                "{record:?}"
            );
        }
        ids.push((record[0].to_owned(), record[1].to_owned()));
    }
    assert!(!ids.is_empty());
    let rows = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), rows, "an id occurs twice under one reading");
}

fn check_svg(path: &Path, name: &str) {
    assert!(std::fs::metadata(path).unwrap().len() < LARGEST_SVG);
    let text = std::fs::read_to_string(path).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let root = document.root_element();
    assert_eq!(root.tag_name().name(), "svg");
    assert_eq!(root.attribute("role"), Some("img"));
    let labelled_by = root.attribute("aria-labelledby").unwrap();
    assert!(labelled_by.starts_with(name));
    for id in labelled_by.split(' ') {
        let node = root
            .children()
            .find(|child| child.attribute("id") == Some(id))
            .unwrap();
        assert!(["title", "desc"].contains(&node.tag_name().name()));
        assert!(node.text().is_some_and(|text| text.len() > 10));
    }
    // Text stays text: it can be searched, selected and read aloud.
    assert!(
        document
            .descendants()
            .any(|node| node.tag_name().name() == "text")
    );
}

fn help_names_the_files_written(mut program: Command, name: &str) {
    program.arg("--help").assert().success().stdout(
        predicate::str::contains("--out-dir")
            .and(predicate::str::contains("--png"))
            .and(predicate::str::contains(format!("{name}.csv")))
            .and(predicate::str::contains("status where rows have one"))
            .and(predicate::str::contains("Examples")),
    );
}

fn version_is_the_crates(mut program: Command, name: &str) {
    program
        .arg("--version")
        .assert()
        .success()
        .stdout(format!("{name} {}\n", env!("CARGO_PKG_VERSION")));
}

fn unknown_flags_are_usage_errors(mut program: Command) {
    program
        .arg("--no-such-flag")
        .assert()
        .code(2)
        .stdout("")
        .stderr(predicate::str::contains("--no-such-flag"));
}

fn an_unwritable_folder_is_named_and_nothing_is_left(mut program: Command) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "kept").unwrap();
    let below = file.join("below");
    program
        .args(["--out-dir".as_ref(), below.as_os_str()])
        .assert()
        .code(1)
        .stdout("")
        .stderr(
            predicate::str::starts_with("error: ")
                .and(predicate::str::contains(below.to_str().unwrap()))
                .and(predicate::str::contains("--out-dir")),
        );
    assert_eq!(files(folder.path()), ["file"]);
    assert_eq!(std::fs::read_to_string(file).unwrap(), "kept");
}

/// With the feature a PNG is written. Without it the error names the remedy, and no file is
/// written.
fn png_works_or_says_how_to_get_it(mut program: Command, name: &str) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let assert = program
        .args(["--png".as_ref(), "--out-dir".as_ref(), out.as_os_str()])
        .assert();
    if cfg!(feature = "png") {
        assert.success();
        let png = std::fs::read(out.join(format!("{name}.png"))).unwrap();
        assert!(png.starts_with(b"\x89PNG"));
    } else {
        assert
            .code(1)
            .stderr(predicate::str::contains("--features png"));
        assert!(!out.exists());
    }
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

macro_rules! figure_programs {
    ($($name:ident),* $(,)?) => {$(
        mod $name {
            use super::*;

            const NAME: &str = stringify!($name);

            fn program() -> Command {
                cargo_bin_cmd!(stringify!($name))
            }

            #[test]
            fn default_run() {
                if WITH_STATUS.contains(&NAME) {
                    the_committed_files_are_well_formed(NAME);
                } else {
                    default_run_writes_a_named_picture_and_its_numbers(program(), NAME);
                }
            }

            #[test]
            fn help() {
                help_names_the_files_written(program(), NAME);
            }

            #[test]
            fn version() {
                version_is_the_crates(program(), NAME);
            }

            #[test]
            fn unknown_flag() {
                unknown_flags_are_usage_errors(program());
            }

            #[test]
            fn unwritable_folder() {
                an_unwritable_folder_is_named_and_nothing_is_left(program());
            }

            #[test]
            fn png() {
                png_works_or_says_how_to_get_it(program(), NAME);
            }
        }
    )*};
}

figure_programs!(fig04, fig06, fig07, fig08, fig10, fig11, fig12,);

mod report {
    use super::*;

    fn program() -> Command {
        cargo_bin_cmd!("report")
    }

    #[test]
    fn help() {
        program().arg("--help").assert().success().stdout(
            predicate::str::contains("--out-dir")
                .and(predicate::str::contains("claims.csv"))
                .and(predicate::str::contains("Examples")),
        );
    }

    #[test]
    fn version() {
        version_is_the_crates(program(), "report");
    }

    #[test]
    fn unknown_flag() {
        unknown_flags_are_usage_errors(program());
    }

    #[test]
    fn unwritable_folder() {
        an_unwritable_folder_is_named_and_nothing_is_left(program());
    }
}
