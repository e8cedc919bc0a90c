//! `stickslip spectrum` with fewer columns than the system has, and its second estimate.

use std::fmt::Write;

use assert_cmd::Command;
use numerics::SplitMix;
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;

fn program(arguments: &[&str], text: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.args(["spectrum", "-", "--dt", "1"]).args(arguments);
    command.write_stdin(text);
    command
}

/// x of Hénon's map.
fn henon(points: usize) -> String {
    let mut text = String::from("x\n");
    let mut x = [0.1, 0.1];
    for i in 0..points + 100 {
        x = [1.0 - 1.4 * x[0] * x[0] + x[1], 0.3 * x[0]];
        if i >= 100 {
            writeln!(text, "{}", x[0]).unwrap();
        }
    }
    text
}

/// Sums of twelve uniform numbers, filtered: linear noise.
fn autoregression(points: usize) -> String {
    let mut random = SplitMix::new(20_131);
    let mut x = 0.0;
    (0..points)
        .map(|_| {
            x = 0.6 * x + (0..12).map(|_| random.between(-0.5, 0.5)).sum::<f64>();
            format!("{x}\n")
        })
        .collect()
}

fn json(arguments: &[&str], text: &str) -> Value {
    let mut command = program(arguments, text);
    let output = command
        .arg("--json")
        .assert()
        .success()
        .get_output()
        .clone();
    serde_json::from_slice(&output.stdout).unwrap()
}

/// λ1 = 0.4192. Over 3000 points its standard error is 0.007.
#[test]
fn one_column_is_embedded_by_itself() {
    let text = henon(3000);
    let output = program(&[], &text).assert().success().get_output().clone();
    let table = String::from_utf8(output.stdout).unwrap();
    for words in [
        "embedded: 2 values of x with a delay of 1 points (uncorrelated after one point, as a \
         map); dimension: below 1 % false neighbours; by Cao's method ",
        "The system's exponents: 1, 2; the embedding's own: none",
        "by time reversal",
        "Rosenstein  0.4",
        "Kantz       0.4",
        "step 1, affine",
    ] {
        assert!(table.contains(words), "{words}:\n{table}");
    }
    let found = json(&[], &text);
    let first = found["exponents"][0]["exponent"].as_f64().unwrap();
    assert!((first - 0.4192).abs() < 0.03, "{first}");
    assert_eq!(found["embedding"]["delay"], 1);
    assert_eq!(found["embedding"]["dimensions"][1]["dimension"], 2);
    for method in ["rosenstein", "kantz"] {
        let opinion = found["diverging_neighbours"][method]["exponent"]
            .as_f64()
            .unwrap();
        assert!((opinion - 0.4192).abs() < 0.03, "{method}: {opinion}");
    }
    assert!(found["surrogates"].is_null());
}

#[test]
fn spurious_exponents_are_marked_in_every_format() {
    let text = henon(3000);
    let three = ["--delay", "1", "--dimension", "3"];
    // Quadratic maps have no spurious exponents.
    let origins = &json(&three, &text)["embedding"]["origins"];
    assert_eq!(
        (&origins[0], &origins[1]),
        (&"system".into(), &"system".into())
    );
    let arguments = [&three[..], &["--estimator", "sano-sawada"]].concat();
    program(&arguments, &text)
        .assert()
        .success()
        .stdout(contains("(0.7").and(contains("  spurious  ")))
        .stderr(contains(
            "exponent 1 comes from the embedding, not from the system: try --dimension 2",
        ));
    program(&arguments, &text)
        .arg("--csv")
        .assert()
        .success()
        .stdout(contains(",spurious\n2,0.").and(contains(",ok\n")));
    let found = json(&arguments, &text);
    assert_eq!(found["exponents"][0]["status"], "spurious");
    assert_eq!(found["exponents"][1]["status"], "ok");
    let origins = &found["embedding"]["origins"];
    assert_eq!(origins[0], "spurious");
    assert_eq!(origins[1], "system");
}

#[test]
fn the_whole_state_is_not_embedded() {
    let columns = |of: &dyn Fn(f64, f64) -> String| -> String {
        let text = henon(3001);
        let x: Vec<f64> = text
            .lines()
            .skip(1)
            .map(|line| line.parse().unwrap())
            .collect();
        x.windows(2)
            .map(|pair| of(pair[1], 0.3 * pair[0]))
            .collect()
    };
    let both = columns(&|x, y| format!("{x} {y}\n"));
    assert!(json(&[], &both)["embedding"].is_null());
    // Unless it is requested.
    assert_eq!(
        json(&["--dimension", "2"], &both)["embedding"]["dimension"],
        2
    );
    // A delay without delayed values is reported.
    let one = columns(&|x, _| format!("{x}\n"));
    program(&["--dimension", "1", "--delay", "3"], &one)
        .assert()
        .success()
        .stderr(contains("--delay 3 changes nothing with --dimension 1"));
    program(&["--affine"], &one)
        .assert()
        .success()
        .stderr(contains("--affine changes nothing with delayed values"));
    program(&["--delay", "3000", "--dimension", "2"], &one)
        .assert()
        .code(2)
        .stdout("")
        .stderr(contains(
            "3000 points are too few for 2 values with a delay of 3000",
        ));
}

#[test]
fn surrogates_tell_a_map_from_noise() {
    let map = json(&["--surrogates", "19"], &henon(1500));
    assert_eq!(map["surrogates"]["is_significant"], true);
    assert_eq!(map["surrogates"]["p"], 0.05);
    let noise = json(&["--surrogates", "19"], &autoregression(1500));
    assert_eq!(noise["surrogates"]["is_significant"], false);
    assert!(noise["diverging_neighbours"]["rosenstein"].is_null());
    program(&["--surrogates", "19"], &autoregression(1500))
        .assert()
        .success()
        .stdout(contains("does not differ from linear noise"));
}

/// Two rows more than without an embedding.
#[test]
fn the_picture_shows_the_choice_and_the_straight_parts() {
    let folder = tempfile::tempdir().unwrap();
    program(&["--surrogates", "19", "--out"], &henon(1500))
        .arg(folder.path())
        .assert()
        .success();
    let text = std::fs::read_to_string(folder.path().join("spectrum.svg")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let description = document
        .descendants()
        .find(|node| node.has_tag_name("desc"))
        .and_then(|node| node.text())
        .unwrap();
    for word in [
        "Mutual information",
        "false neighbours",
        "straight parts",
        "surrogates",
    ] {
        assert!(
            description.to_lowercase().contains(&word.to_lowercase()),
            "{word}: {description}"
        );
    }
}

/// The series lies in a plane, and the third exponent is due to its rounding.
#[test]
fn an_exponent_that_the_axis_leaves_out_is_said_to_be_outside() {
    let text = henon(3001);
    let x: Vec<f64> = text
        .lines()
        .skip(1)
        .map(|line| line.parse().unwrap())
        .collect();
    let three: String = x
        .windows(2)
        .map(|pair| format!("{:.6} {:.6} {:.6}\n", pair[1], pair[0], pair[1] + pair[0]))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    program(&["--out"], &three)
        .arg(folder.path())
        .assert()
        .success()
        .stdout(contains("unidentified"));
    let picture = std::fs::read_to_string(folder.path().join("spectrum.svg")).unwrap();
    assert_eq!(picture.matches("unidentified, outside the axis").count(), 1);
    assert_eq!(picture.matches("outside the axis").count(), 1);
}

/// Neighbours on the same value of a coarse grid look annihilated; a warning reports that. Random
/// whole numbers from 0 to 2 have no tangent direction, and nothing to compare the embedding with.
#[test]
fn values_on_a_coarse_grid_get_a_warning_and_no_error() {
    let rows = |digits: usize| {
        let mut x = [0.1, 0.1];
        (0..4000)
            .map(|_| {
                x = [1.0 - 1.4 * x[0] * x[0] + x[1], 0.3 * x[0]];
                format!("{:.digits$},{:.digits$}\n", x[0], x[1])
            })
            .collect::<String>()
    };
    let says = contains("256 different values, on a grid of 0.01, as rounded ones").and(contains(
        "minus infinity, as neighbours that fall on one value",
    ));
    program(&["--csv"], &rows(2))
        .assert()
        .success()
        .stdout(contains("annihilated"))
        .stderr(says);
    program(&["--csv"], &rows(9))
        .assert()
        .success()
        .stdout(contains("annihilated").not())
        .stderr(contains("different values").not());
    let mut random = SplitMix::new(7);
    let noise: String = (0..3000)
        .map(|_| format!("{}\n", random.between(0.0, 3.0).floor()))
        .collect();
    program(&["--dimension", "3"], &noise)
        .assert()
        .success()
        .stdout(contains("is not determined").and(contains("nothing to extrapolate")));
}
