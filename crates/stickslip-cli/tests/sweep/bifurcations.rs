//! `stickslip bifurcation`.

use std::collections::BTreeSet;

use predicates::str::contains;

use super::common::{folder, program, text};

const DIAGRAM: [&str; 8] = [
    "bifurcation",
    "basins",
    "--parameter",
    "vd=1:2",
    "--values",
    "41",
    "--tol",
    "1e-10",
];

/// The values at which a direction of the sweep has a motion, from the table.
fn values(table: &str, way: &str, motion: &str) -> Vec<f64> {
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let mut found = Vec::new();
    for row in rows.records() {
        let row = row.unwrap();
        let value = row[1].parse().unwrap();
        if &row[0] == way && &row[2] == motion && !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

/// The stick–slip cycle ends above the speed at which the equilibrium becomes stable, at (1/2) ln
/// 10. Between them each direction keeps to its own attractor. By the published shares the cycle
/// exists at 1.775, and not at 1.85.
#[test]
fn up_and_down_show_the_hysteresis() {
    let top = folder();
    program(top.path())
        .args(DIAGRAM)
        .args(["--start", "v=1.8", "--until", "20000", "--out", "d"])
        .assert()
        .success()
        .stdout(contains("41 values of vd from 1 to 2, up and down"))
        // The orbit that vanishes is named.
        .stdout(contains(": lost periodic, period "))
        .stdout(contains("; reached equilibrium at ("));
    let table = text(top.path().join("d/bifurcation.csv"));
    let cycles = values(&table, "up", "periodic");
    assert_eq!(cycles[0], 1.0);
    let last_cycle = *cycles.last().unwrap();
    assert!((1.775..1.85).contains(&last_cycle), "{last_cycle}");
    let rests = values(&table, "down", "equilibrium");
    assert_eq!(rests[0], 2.0);
    let born = 0.5 * stickslip::math::ln(10.0);
    let last = *rests.last().unwrap();
    assert!((born..born + 0.025).contains(&last), "{last}");
    // Every value has one of the motions, or is undecided where the equilibrium attracts too
    // weakly.
    let undecided = values(&table, "down", "undecided");
    assert!(undecided.iter().all(|value| (value - born).abs() < 0.025));

    // Both ends of the interval of two attractors, between the values of the sweep.
    let changes = text(top.path().join("d/changes.csv"));
    let change = |way: &str, what: &str| {
        let mut rows = csv::Reader::from_reader(changes.as_bytes());
        let mut rows = rows.records().map(Result::unwrap);
        let row = rows.find(|row| &row[0] == way && &row[4] == what).unwrap();
        let number = |k: usize| row[k].parse::<f64>().unwrap_or(f64::NAN);
        (number(1), number(6), row[8].to_owned())
    };
    let (lower, ..) = change("down", "Hopf bifurcation of the equilibrium");
    assert!((lower - born).abs() < 1e-12, "{lower}");
    let (upper, uncertainty, before) = change("up", "grazing-sliding");
    assert!(uncertainty < 1e-10 && before == "- S", "{uncertainty}");
    assert!((last_cycle..last_cycle + 0.025).contains(&upper), "{upper}");

    let sticks = text(top.path().join("d/sticks.csv"));
    let mut rows = csv::Reader::from_reader(sticks.as_bytes());
    let mut seen = BTreeSet::new();
    for row in rows.records() {
        let row = row.unwrap();
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        // In stick, the block travels with the belt, at the belt's speed.
        let (speed, duration, length, change) = (number(1), number(2), number(3), number(4));
        assert!((length - speed * duration).abs() < 1e-9, "{length}");
        assert!(change.abs() < 1e-9);
        seen.insert(row[0].to_owned());
    }
    assert_eq!(seen.len(), 2);
    roxmltree::Document::parse(&text(top.path().join("d/bifurcation.svg"))).unwrap();
}

#[test]
fn ways_computed_apart_are_merged_to_what_one_run_gives() {
    let top = folder();
    let run = |arguments: &[&str]| {
        program(top.path())
            .args(DIAGRAM)
            .args(arguments)
            .assert()
            .success()
    };
    run(&["--out", "single"]);
    run(&["--shard", "1/2", "--out", "a"]);
    run(&["--shard", "2/2", "--out", "b"]);
    program(top.path())
        .args(["merge", "--out", "merged", "a", "b"])
        .assert()
        .success();
    // A block in the middle of a chain, computed again, is the same.
    std::fs::remove_file(top.path().join("a/sweep/blocks/00000002.block")).unwrap();
    let words = "5 blocks, 4 of them from earlier runs";
    run(&["--shard", "1/2", "--out", "a"]).stdout(contains(words));
    program(top.path())
        .args(["merge", "--out", "merged", "a", "b"])
        .assert()
        .success();
    for name in [
        "bifurcation.csv",
        "sticks.csv",
        "changes.csv",
        "bifurcation.svg",
    ] {
        let of = |folder: &str| text(top.path().join(folder).join(name));
        assert!(of("merged") == of("single"), "{name}");
    }
}

#[test]
fn wrong_diagrams_are_reported() {
    let top = folder();
    for (parameter, further, message) in [
        ("x=0:1", &[][..], "there is no parameter `x`"),
        ("vd=0:1", &["--values", "1"], "at least 2 values"),
        ("mud=-1:1", &[], "not allowed"),
        ("vd=0:1", &["--duration", "0"], "--duration 0"),
    ] {
        program(top.path())
            .args(["bifurcation", "basins", "--parameter", parameter])
            .args(further)
            .assert()
            .code(2)
            .stderr(contains(message));
    }
    assert_eq!(std::fs::read_dir(top.path()).unwrap().count(), 0);
}

/// y' = -y + sin t + cos t attracts to sin t below the boundary of `roof`, y = p; above it the
/// field points down. Beside it, z follows sin(t - q) across zero.
const TWO: &str = r#"
name = "two"
[states]
z = ""
y = ""
[parameters]
p = 1
q = 2
[definitions]
rate = "sin(t - q) + cos(t - q) - z"
[contacts.clock]
boundary = "z"
[contacts.roof]
boundary = "y - p"
[field]
z = "by_side(clock, rate, rate)"
y = "by_side(roof, sin(t) + cos(t) - y, -1)"
[time]
period = "2*pi"
[start]
z = -0.4
y = -0.5
"#;

/// The sine touches the boundary at p = 1.
#[test]
fn a_change_of_phases_is_reported_at_the_contact_of_that_name() {
    let top = folder();
    std::fs::write(top.path().join("two.toml"), TWO).unwrap();
    let output = program(top.path())
        .args(["bifurcation", "two.toml", "--parameter", "p=0.97:1.02"])
        .args(["--values", "2", "--until", "400", "--duration", "20"])
        .args(["--out", "o", "--json"])
        .assert()
        .success();
    let json: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    for way in ["up", "down"] {
        let changes = json[way]["changes"].as_array().unwrap();
        assert_eq!(changes.len(), 1, "{json}");
        let change = &changes[0]["change"]["sequence"];
        assert_eq!(change["contacts"], serde_json::json!(["roof"]));
        assert_eq!(change["name"], "grazing-sliding");
        let parameter = change["parameter"].as_f64().unwrap();
        assert!((parameter - 1.0).abs() < 1e-9, "{parameter}");
    }
    let mut rows = csv::Reader::from_path(top.path().join("o/changes.csv")).unwrap();
    let contact = rows
        .headers()
        .unwrap()
        .iter()
        .position(|name| name == "contacts");
    let named = rows
        .records()
        .map(|row| row.unwrap()[contact.unwrap()].to_owned());
    assert_eq!(named.collect::<Vec<_>>(), ["roof", "roof"]);
    program(top.path())
        .args(["bifurcation", "two.toml", "--parameter", "p=0.97:1.02"])
        .args(["--values", "2", "--until", "400", "--duration", "20"])
        .args(["--out", "o"])
        .assert()
        .success()
        .stdout(contains("grazing-sliding of roof"));
    program(top.path())
        .args([
            "continue",
            "two.toml",
            "--set",
            "p=0.98",
            "--parameter",
            "p=0.97:1.02",
        ])
        .args(["--out", "c"])
        .assert()
        .success()
        .stdout(contains("grazing-sliding of roof"));
    // Other programs need the ASCII minus.
    for table in [
        "o/changes.csv",
        "o/bifurcation.csv",
        "c/special.csv",
        "c/branch.csv",
    ] {
        assert!(text(top.path().join(table)).is_ascii(), "{table}");
    }
}

/// The block of `roof` leaves it where sin t + cos t falls through p, at 3π/4 - asin(p/√2). At q
/// the other contact passes zero.
#[test]
fn contacts_that_change_places_are_reported_together() {
    let top = folder();
    std::fs::write(top.path().join("two.toml"), TWO).unwrap();
    let output = program(top.path())
        .args(["bifurcation", "two.toml", "--set", "p=0.98"])
        .args([
            "--parameter",
            "q=1.55:1.64",
            "--values",
            "2",
            "--until",
            "400",
        ])
        .args(["--duration", "20", "--out", "o"])
        .assert()
        .success();
    let message = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    let sine = 0.98 / 2.0_f64.sqrt();
    let exact =
        0.75 * std::f64::consts::PI - stickslip::math::atan(sine / (1.0 - sine * sine).sqrt());
    let reported: Vec<&str> = message
        .lines()
        .filter(|line| line.contains("coincidence"))
        .collect();
    assert_eq!(reported.len(), 2, "{message}");
    for line in reported {
        let both = [" of clock and roof", " of roof and clock"];
        assert!(both.iter().any(|names| line.ends_with(names)), "{line}");
        let value = line
            .split("at ")
            .nth(1)
            .and_then(|rest| rest.split(':').next());
        // An uncertainty below the last digit is not shown.
        let value = value.unwrap();
        let (value, uncertainty) = value.split_once(" ± ").unwrap_or((value, "1e-12"));
        let [value, uncertainty] = [value, uncertainty].map(|text| text.parse::<f64>().unwrap());
        let error = (value - exact).abs();
        assert!(error < 1e-9 && uncertainty < 1e-9, "{line} for {exact}");
    }
}

#[test]
fn a_failure_has_its_reason_on_the_screen_in_the_table_and_in_json() {
    let top = folder();
    let pole = "name = \"pole\"\n[time]\nend = 1\n[states]\nx = \"\"\n[parameters]\na = 1\n\
                [field]\nx = \"-a/x\"\n[start]\nx = 1\n";
    std::fs::write(top.path().join("pole.toml"), pole).unwrap();
    let sweep = "bifurcation pole.toml --parameter a=1:2 --values 2 --until 10";
    let run = |rest: &[&str]| {
        let all = sweep.split(' ').chain(rest.iter().copied());
        program(top.path()).args(all).assert().success()
    };
    let output = run(&["--out", "a", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let span = &json["up"]["motions"][0];
    let reason = span["reason"].as_str().unwrap().to_owned();
    assert_eq!(span["motion"], "failure");
    assert!(reason.contains("t = 0.5"), "{reason}");
    run(&["--out", "b"]).stdout(contains(format!("1 to 2: failure, first as {reason}")));
    let mut rows = csv::Reader::from_path(top.path().join("b/bifurcation.csv")).unwrap();
    let first = rows.records().next().unwrap().unwrap();
    assert_eq!(first.iter().next_back(), Some(reason.as_str()));
}

/// Of two jumps at one instant the second changes the field, so that no vector has an image.
#[test]
fn an_exponent_that_cannot_be_measured_has_its_reason() {
    let top = folder();
    let system = "name = \"chain\"\n[parameters]\nA = 1\nq = 1\n[states]\nx = \"\"\nv = \"\"\n\
                  [discrete]\ns = 0\nr = 1\n[field]\nx = \"r\"\nv = \"x - q*v\"\n[jumps.top]\n\
                  when = \"x - A\"\ndirection = \"rising\"\nset = { s = 1 }\n[jumps.turn]\n\
                  when = \"s - 0.5\"\ndirection = \"rising\"\nset = { r = -1, s = 0 }\n\
                  [jumps.bottom]\nwhen = \"x + A\"\ndirection = \"falling\"\nset = { r = 1 }\n\
                  [start]\nx = 0\nv = 0\n";
    std::fs::write(top.path().join("chain.toml"), system).unwrap();
    let plane = ["--x", "A=1:1.2", "--y", "q=1:2", "--grid", "2x1"];
    for arguments in [
        &[
            "bifurcation",
            "chain.toml",
            "--parameter",
            "A=1:1.2",
            "--values",
            "2",
        ][..],
        &[&["map", "chain.toml"][..], &plane].concat(),
    ] {
        let command = arguments[0];
        program(top.path())
            .args(arguments)
            .args(["--duration", "50", "--out", command])
            .assert()
            .success();
        let table = text(top.path().join(command).join(format!("{command}.csv")));
        let mut rows = csv::Reader::from_reader(table.as_bytes());
        let names = rows.headers().unwrap().clone();
        let column = |name: &str| names.iter().position(|one| one == name).unwrap();
        let of = [column("motion"), column("lambda1"), column("reason")];
        let rows: Vec<_> = rows.records().map(Result::unwrap).collect();
        assert!(rows.len() >= 2);
        for row in rows {
            assert_eq!([&row[of[0]], &row[of[1]]], ["periodic", ""], "{command}");
            assert!(row[of[2]].contains("follows another one"), "{row:?}");
        }
    }
}
