//! `stickslip spectrum` from the command line.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use numerics::SplitMix;
use predicates::prelude::*;
use predicates::str::{contains, starts_with};
use stickslip::math;

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.arg("spectrum");
    command
}

/// Hénon's map, with names or without.
fn henon(names: bool) -> String {
    let names = if names { "x,y\n" } else { "" };
    names.to_owned() + &henon_of(3000)
}

fn henon_of(points: usize) -> String {
    let mut text = String::new();
    let mut x = [0.1, 0.1];
    for i in 0..points + 100 {
        x = [1.0 - 1.4 * x[0] * x[0] + x[1], 0.3 * x[0]];
        if i >= 100 {
            writeln!(text, "{},{}", x[0], x[1]).unwrap();
        }
    }
    text
}

fn file(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("series.csv");
    std::fs::write(&path, text).unwrap();
    path
}

fn succeed(command: &mut Command) -> String {
    let output = command.assert().success().stderr("").get_output().clone();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn prints_a_table_without_any_option_but_the_time_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), &henon(true));
    let table = succeed(program().arg(&path).args(["--dt", "1"]));
    assert!(table.contains("3000 points of (x, y)"));
    assert!(table.contains("2 tangent directions"));
    let first = table
        .lines()
        .find(|line| line.starts_with("    1  "))
        .unwrap();
    let cells: Vec<&str> = first.split_whitespace().collect();
    // Over 3000 points the standard error is 0.005.
    assert!((cells[1].parse::<f64>().unwrap() - 0.419).abs() < 0.02);
    assert_eq!(cells[4], "ok");
    // No file is written unless requested.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn csv_and_json_hold_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), &henon(false));
    let csv = succeed(program().arg(&path).args(["--dt", "1", "--csv"]));
    let json = succeed(program().arg(&path).args(["--dt", "1", "--json"]));
    let document: serde_json::Value = serde_json::from_str(&json).unwrap();
    let exponents = document["exponents"].as_array().unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    assert_eq!(
        reader.headers().unwrap(),
        vec!["index", "exponent", "stderr", "status"]
    );
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!((records.len(), exponents.len()), (2, 2));
    for (record, exponent) in records.iter().zip(exponents) {
        assert_eq!(record[0].parse::<u64>().ok(), exponent["index"].as_u64());
        assert_eq!(record[1].parse::<f64>().ok(), exponent["exponent"].as_f64());
        assert_eq!(record[2].parse::<f64>().ok(), exponent["stderr"].as_f64());
        assert_eq!(Some(&record[3]), exponent["status"].as_str());
    }
    // The note at the end of the table. For 5000 points and more there is none.
    let note = "The reliability of ok was measured on series of at least 5000 points; this series \
                has 3000.";
    assert_eq!(document["notes"], serde_json::json!([note]));
    let table = succeed(program().arg(&path).args(["--dt", "1"]));
    assert!(table.contains(note), "{table}");
    let long = program()
        .args(["-", "--dt", "1", "--json"])
        .write_stdin(henon_of(5000))
        .assert()
        .success()
        .get_output()
        .clone();
    let long: serde_json::Value = serde_json::from_slice(&long.stdout).unwrap();
    assert_eq!(long["notes"], serde_json::json!([]));
    assert_eq!(document["settings"]["dt"], 1.0);
    assert_eq!(document["settings"]["eps"], 0.1);
    assert_eq!(document["settings"]["theiler"], 1);
}

/// A rotation has the exponent zero; Hénon's map has no exponent near zero (see above).
#[test]
fn an_exponent_that_is_ok_and_may_be_zero_is_reported() {
    use stickslip::math::{cos, sin};
    let angle = |i: u32| f64::from(i) * 2.0_f64.sqrt();
    let text: String = (0..2000)
        .map(|i| format!("{:?},{:?}\n", cos(angle(i)), sin(angle(i))))
        .collect();
    let run = |format: &[&str]| {
        let mut program = program();
        succeed(
            program
                .args(["-", "--dt", "1"])
                .args(format)
                .write_stdin(text.clone()),
        )
    };
    let document: serde_json::Value = serde_json::from_str(&run(&["--json"])).unwrap();
    let first = &document["exponents"][0];
    let number = |name: &str| first[name].as_f64().unwrap();
    assert_eq!(first["status"], "ok");
    assert!(number("exponent").abs() < 2.0 * number("stderr"), "{first}");
    let note = "Zero is within two stderr of exponent 1: the sign is uncertain, although the \
                status is ok.";
    assert_eq!(document["notes"][0], note);
    assert!(run(&[]).contains(note));
}

/// The sum of Hénon's exponents is ln 0.3 at every point. A given divergence that differs is
/// reported.
#[test]
fn a_known_divergence_is_held_against_the_sum() {
    let run = |divergence: &str| {
        let output = program()
            .args(["-", "--dt", "1", "--divergence", divergence])
            .write_stdin(henon(false))
            .assert()
            .success()
            .get_output()
            .clone();
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap())
    };
    let [table, warnings] = run("-1.2039728043259361");
    assert!(table.contains("add up to -1.20397") && table.contains("as does"));
    assert_eq!(warnings, "");
    let [table, warnings] = run("-1.3");
    assert!(table.contains("unlike the divergence"));
    // Given with four digits.
    assert!(run("-1.204")[0].contains("as does the divergence"));
    assert!(warnings.contains("from the divergence -1.30000"));
}

#[test]
fn reads_standard_input_and_chooses_columns() {
    let text: String = henon(true)
        .lines()
        .enumerate()
        .map(|(i, line)| {
            if i == 0 {
                format!("n,{line}\n")
            } else {
                format!("no {i},{line}\n")
            }
        })
        .collect();
    let arguments = ["-", "--dt", "1", "--csv", "--columns"];
    let by_name = succeed(
        program()
            .args(arguments)
            .arg("x,y")
            .write_stdin(text.clone()),
    );
    let by_number = succeed(
        program()
            .args(arguments)
            .arg("2, 3")
            .write_stdin(text.clone()),
    );
    let plain = succeed(
        program()
            .args(["-", "--dt", "1", "--csv"])
            .write_stdin(henon(false)),
    );
    assert_eq!(by_name, by_number);
    // A name that two columns have selects neither.
    program()
        .args(arguments)
        .arg("x")
        .write_stdin(text.replacen("n,x,y", "x,x,y", 1))
        .assert()
        .code(2)
        .stderr(contains("columns 1 and 2 of standard input are called so"));
    assert_eq!(by_name, plain);
}

/// A column twice: a direction without a value, which every format shows.
#[test]
fn what_has_no_value_is_empty_null_or_a_dash() {
    let text: String = henon(false)
        .lines()
        .map(|line| format!("{line},{}\n", line.split(',').next().unwrap()))
        .collect();
    let run = |format: &[&str]| {
        succeed(
            program()
                .args(["-", "--dt", "1"])
                .args(format)
                .write_stdin(text.clone()),
        )
    };
    assert!(run(&["--csv"]).ends_with("3,,,unidentified\n"));
    let json: serde_json::Value = serde_json::from_str(&run(&["--json"])).unwrap();
    assert!(json["exponents"][2]["exponent"].is_null());
    assert!(run(&[]).contains("flat"));
}

#[test]
fn writes_a_named_picture() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a/b");
    // Two steps at 3000 points are biased, which is reported on standard error.
    let output = program()
        .args([
            "-",
            "--dt",
            "1",
            "--estimator",
            "sano-sawada",
            "--affine",
            "--neighbours",
            "15-30",
            "--step",
            "2",
            "--theiler",
            "5",
            "--out",
        ])
        .arg(&out)
        .write_stdin(henon(false))
        .assert()
        .success()
        .stderr(contains(
            "exponent 2 is unstable, which concerns the estimate: it changes with \
             the size of the neighbourhoods, by more than four standard errors and 5 %, which is \
             bias: try a smaller --step, fewer --neighbours, or more points",
        ))
        .get_output()
        .clone();
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("spectrum.svg") && table.contains("affine") && table.contains("step 2"));
    let text = std::fs::read_to_string(out.join("spectrum.svg")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    assert_eq!(document.root_element().attribute("role"), Some("img"));
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1);
}

#[test]
fn the_picture_is_listed_in_json_and_leaves_the_csv_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), &henon(false));
    let of = |options: &[&str]| succeed(program().arg(&path).args(["--dt", "1"]).args(options));
    let out = folder.path().join("picture");
    let out = out.to_str().unwrap();
    let json = of(&["--json", "--out", out]);
    let document: serde_json::Value = serde_json::from_str(&json).unwrap();
    let picture = Path::new(out).join("spectrum.svg");
    assert_eq!(document["files"], serde_json::json!([picture]));
    assert!(picture.exists());
    assert_eq!(of(&["--csv", "--out", out]), of(&["--csv"]));
}

#[test]
fn bad_files_are_failures_that_say_where() {
    let broken = henon(true).replacen("\n", "\n1,oops\n", 1);
    for (text, place) in [
        (broken.as_str(), "line 2, column 2 (y): 'oops'"),
        ("1,2\n3\n", "line 2, column 2: the line has 1 columns"),
        ("1,2\n3,NaN\n", "line 2, column 2: 'NaN' is not finite"),
        ("", "no data"),
        ("x,y\r\n", "no data"),
        (
            "t\n0\n1\n",
            "the only column of standard input, t, was skipped as the time",
        ),
        (
            &"1e308,1\n-1e308,2\n1e308,3\n".repeat(50),
            "row 2, column 1 (counted from 1) is -1e308",
        ),
        (
            "1 2\n3 4 5\n",
            "the line has 3 columns, separated by spaces",
        ),
        ("1,5;2.5\n1.5;2,5\n", "decimal comma"),
        (
            "t,x\n0,1\n1,2\n3,3\n",
            "line 4, column 1 (t): the time goes",
        ),
        (
            "t,x\n2,1\n1,2\n0,3\n",
            "line 3, column 1 (t): the time goes from 2 to 1, not forward",
        ),
        ("1,2\n1,2\n1,2\n", "3 points are too few"),
        ("1\n2\n3\n", "3 points are too few"),
    ] {
        program()
            .args(["-", "--dt", "1"])
            .write_stdin(text)
            .assert()
            .code(1)
            .stdout("")
            .stderr(starts_with("error: ").and(contains(place)));
    }
    program()
        .args(["no/such/file.csv", "--dt", "1"])
        .assert()
        .code(1)
        .stderr(contains("no/such/file.csv"));
}

#[test]
fn wrong_command_lines_end_with_two() {
    for (arguments, says) in [
        (vec!["-"], "--dt"),
        (vec!["-", "--dt", "0"], "--dt = 0"),
        (vec!["-", "--dt", "-1"], "--dt = -1"),
        (vec!["-", "--dt", "1", "--step", "0"], "--step = 0"),
        (vec!["-", "--dt", "1", "--step", "-1"], "'-1'"),
        (vec!["-", "--dt", "1", "--eps", "-0.1"], "--eps = -0.1"),
        (vec!["-", "--dt", "1", "--ridge", "-1"], "--ridge = -1"),
        (
            vec!["-", "--dt", "1", "--rank", "9"],
            "--rank = 9 is not allowed: it must be 1 to the number of columns, 2",
        ),
        (vec!["-", "--dt", "-1e-300"], "--dt = -1e-300 is"),
        (
            vec!["-", "--dt", "1", "--references", "1"],
            "--references = 1",
        ),
        (
            vec!["-", "--dt", "1", "--neighbours", "2-9"],
            "--neighbours, minimum = 2 is not allowed: it must be above the number of columns, 2",
        ),
        (
            vec!["-", "--dt", "1", "--rank-tolerance", "1"],
            "--rank-tolerance = 1",
        ),
        (vec!["-", "--dt", "1", "--columns", "3"], "it has 1 to 2"),
        (vec!["-", "--dt", "1", "--columns", "1,1"], "twice"),
        (vec!["-", "--dt", "1", "--neighbours", "many"], "'many'"),
        (
            vec!["-", "--dt", "1", "--neighbours", "30", "--eps", "0.1"],
            "--eps",
        ),
        (vec!["-", "--dt", "1", "--delay", "0"], "--delay = 0"),
        (
            vec!["-", "--dt", "1", "--dimension", "0"],
            "--dimension = 0",
        ),
        (
            vec!["-", "--dt", "1", "--dimension", "6"],
            "--dimension = 6 is not allowed: it must be 1 to 5",
        ),
        (vec!["-", "--dt", "1", "--dimension", "-3"], "'-3'"),
        (
            vec!["-", "--dt", "1", "--surrogates", "18"],
            "--surrogates = 18 is not allowed: it must be 19 to 10000",
        ),
        (
            vec!["-", "--dt", "abc"],
            "'abc' for '--dt <TIME>': this is not a number; write it as 0.02",
        ),
        (
            vec!["-", "--dt", "1", "--eps", "0,2"],
            "'0,2' for '--eps <FRACTION>': a number has a decimal point here: write 0.2",
        ),
        (vec!["-", "--dt", "1", "--json", "--csv"], "--csv"),
        (vec!["-", "--dt", "1", "--no-such-flag"], "--no-such-flag"),
    ] {
        program()
            .args(&arguments)
            .write_stdin(henon(false))
            .assert()
            .code(2)
            .stdout("")
            .stderr(contains(says));
    }
}

/// Doubtful estimates that look like any other: a warning, a status, and exit code 0.
#[test]
fn doubtful_spectra_come_with_a_warning() {
    let column: String = henon(false)
        .lines()
        .map(|line| format!("{}\n", line.split(',').next().unwrap()))
        .collect();
    for (text, arguments, status, says) in [
        (
            henon(false),
            vec!["--eps", "1e-9"],
            "starved",
            "give more points (a larger --eps would",
        ),
        (
            // More neighbours than the quadratic maps need.
            henon(false),
            vec!["--eps", "1e-9", "--neighbours", "60-60"],
            "starved",
            "give more points or fewer --neighbours (a larger --eps would",
        ),
        (
            henon(false),
            vec![
                "--eps",
                "1e-9",
                "--neighbours",
                "12-30",
                "--estimator",
                "sano-sawada",
            ],
            "starved",
            "give a larger --eps",
        ),
        (
            henon(false),
            vec!["--rank", "1", "--estimator", "sano-sawada"],
            "ok",
            "exponent 1: the fit of rank 1 gives",
        ),
        (
            henon(false)
                .lines()
                .enumerate()
                .map(|(i, line)| format!("{},{line}\n", 0.25 * i as f64))
                .collect(),
            vec!["--columns", "1,2,3"],
            "starved",
            "column 1 goes on evenly by 0.25000 from row to row, as a time or an index does, and \
             is used as part of the state: leave it out with --columns 2,3",
        ),
        (
            // On a grid of hundredths.
            henon(false)
                .lines()
                .take(2000)
                .map(|line| {
                    let values = line.split(',').map(|v| v.parse::<f64>().unwrap());
                    let rounded: Vec<String> = values.map(|v| format!("{v:.2}")).collect();
                    format!("{}\n", rounded.join(","))
                })
                .collect(),
            vec![],
            "undetermined",
            "exponent 1 is undetermined: at more than 1 %",
        ),
        (
            // With noise of 0.002, sums of two uniform errors.
            {
                let mut random = SplitMix::new(5);
                let mut noise = move || 0.005 * (random.uniform() + random.uniform() - 1.0);
                henon(false)
                    .lines()
                    .map(|line| {
                        let values = line.split(',').map(|v| v.parse::<f64>().unwrap());
                        let noisy: Vec<String> =
                            values.map(|v| (v + noise()).to_string()).collect();
                        format!("{}\n", noisy.join(","))
                    })
                    .collect()
            },
            vec![],
            "noisy",
            "give more --neighbours, values with less noise",
        ),
        (
            column,
            vec!["--dimension", "1"],
            "unpredictable",
            "all columns of the state",
        ),
        (
            henon(false),
            vec!["--step", "4", "--stride", "2", "--estimator", "sano-sawada"],
            "unstable",
            "smaller --step",
        ),
    ] {
        let run = |format: &[&str]| {
            let output = program()
                .args(["-", "--dt", "1"])
                .args(&arguments)
                .args(format)
                .write_stdin(text.clone())
                .assert()
                .success()
                .stderr(starts_with("warning: ").and(contains(says)))
                .get_output()
                .clone();
            String::from_utf8(output.stdout).unwrap()
        };
        assert!(run(&[]).contains(status));
        assert!(run(&["--csv"]).contains(status));
        let json: serde_json::Value = serde_json::from_str(&run(&["--json"])).unwrap();
        assert!(json["warnings"][0].as_str().unwrap().contains(says));
        let exponents = json["exponents"].as_array().unwrap();
        assert!(exponents.iter().any(|e| e["status"] == status));
        assert!(exponents[0]["eps_sensitivity"].is_f64());
    }
}

/// Thirty points of a torus, whose Theiler window is 6, are enough. For a slower torus they are a
/// short piece with little information.
#[test]
fn a_short_piece_of_an_orbit_and_a_series_that_repeats_itself_get_a_warning() {
    let torus = |by: f64| -> String {
        (0..3000)
            .map(|i| {
                let (a, b) = (by * f64::from(i), 1.618_033_988_749_895 * by * f64::from(i));
                let of = |angle: f64| (stickslip::math::cos(angle), stickslip::math::sin(angle));
                let ((c, s), (d, t)) = (of(a), of(b));
                format!("{c} {s} {d} {t}\n")
            })
            .collect()
    };
    let warnings = |text: String, arguments: &[&str]| {
        let output = program()
            .args(["-", "--dt", "1"])
            .args(arguments)
            .write_stdin(text)
            .assert()
            .success()
            .get_output()
            .clone();
        String::from_utf8(output.stderr).unwrap()
    };
    let short = "less than 2 Theiler windows";
    let thirty = ["--references", "30"];
    assert!(!warnings(torus(0.2), &thirty).contains(short));
    assert!(!warnings(torus(0.02), &[]).contains(short));
    let reported = warnings(torus(0.02), &thirty);
    assert!(
        reported.contains("the 30 reference points reach over 30 points, ")
            && reported.contains(short),
        "{reported}"
    );
    // The number of points that it asks for is enough.
    let wanted = reported
        .split("give ")
        .last()
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    assert!(
        !warnings(torus(0.02), &["--references", wanted]).contains(short),
        "{wanted}"
    );

    let sine: String = (0..2000)
        .map(|i| {
            format!(
                "{}\n",
                stickslip::math::sin(std::f64::consts::TAU * f64::from(i) / 100.0)
            )
        })
        .collect();
    assert!(warnings(sine, &[]).contains("every row comes again 100 rows later"));
}

/// Values of a sensor with few bits, and of one that hangs.
#[test]
fn values_on_a_grid_and_states_that_stand_still_get_a_word() {
    let series = |digits: usize, held: usize| -> String {
        let rows: Vec<String> = henon_of(2000)
            .lines()
            .map(|line| {
                let values = line.split(',').map(|v| v.parse::<f64>().unwrap());
                let rounded: Vec<String> = values.map(|v| format!("{v:.digits$}")).collect();
                format!("{}\n", rounded.join(","))
            })
            .collect();
        let hangs = std::iter::repeat_n(rows[1000].as_str(), held);
        let before = rows[..1000].iter().map(String::as_str);
        let after = rows[1000..].iter().map(String::as_str);
        before.chain(hangs).chain(after).collect()
    };
    for (digits, held, is_on_grid, stands) in [
        (12, 0, false, false),
        (12, 200, false, true),
        // Less than a hundredth of all values.
        (12, 15, false, false),
        (2, 0, true, false),
        (2, 200, true, true),
    ] {
        for columns in ["1", "1,2"] {
            let output = program()
                .args(["-", "--dt", "1", "--columns", columns])
                .write_stdin(series(digits, held))
                .assert()
                .success()
                .get_output()
                .clone();
            let reported = String::from_utf8(output.stderr).unwrap();
            let case = format!("{digits} digits, {held} rows, columns {columns}: {reported}");
            assert_eq!(reported.contains("different values"), is_on_grid, "{case}");
            let grid = "different values, on a grid of 0.01, as rounded ones";
            assert_eq!(reported.contains(grid), is_on_grid, "{case}");
            assert_eq!(
                reported.contains("the same as those before them"),
                stands,
                "{case}"
            );
        }
    }
}

/// x of Lorenz' system, rounded to 0.05, that is constant for 200 points (nolds #19). Its exponent
/// is finite, and the grid is reported.
#[test]
fn a_rounded_series_that_hangs_has_a_finite_exponent_and_a_grid() {
    let field = |[x, y, z]: [f64; 3]| [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
    let ahead = |x: [f64; 3], k: [f64; 3], h: f64| [0, 1, 2].map(|i| x[i] + h * k[i]);
    let mut state = [1.0, 1.0, 20.0];
    let mut next = || {
        let h = 0.01;
        let k1 = field(state);
        let k2 = field(ahead(state, k1, 0.5 * h));
        let k3 = field(ahead(state, k2, 0.5 * h));
        let k4 = field(ahead(state, k3, h));
        state = [0, 1, 2].map(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        state[0]
    };
    let values: Vec<f64> = (0..12_000).map(|_| next()).skip(2000).collect();
    let of = |step: f64| -> serde_json::Value {
        let mut text = String::new();
        for i in (0..6000).chain([6000; 200]).chain(6000..10_000) {
            writeln!(text, "{}", (values[i] / step).round() * step).unwrap();
        }
        let mut program = program();
        let arguments = ["-", "--dt", "0.01", "--json"];
        let output = program.args(arguments).write_stdin(text).output().unwrap();
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let rounded = of(0.05);
    assert_eq!(rounded["grid"]["step"], 0.05);
    assert_eq!(rounded["grid"]["column"], "1");
    assert!(rounded["exponents"][0]["exponent"].is_f64());
    let warnings = rounded["warnings"].as_array().unwrap();
    let reported = |says: &str| {
        warnings
            .iter()
            .any(|one| one.as_str().unwrap().contains(says))
    };
    assert!(reported(
        "on a grid of 0.05, as rounded ones or those of few bits"
    ));
    assert!(reported("states are the same as those before them"));
    assert!(of(1e-9)["grid"].is_null());
}

/// Ten values five points apart need 45 points more than the neighbours of a state.
#[test]
fn a_file_that_is_too_short_is_reported_how_many_rows_it_needs() {
    let column = |rows: usize| -> String {
        let rows = henon_of(rows);
        let first = rows.lines().map(|line| line.split(',').next().unwrap());
        first.map(|value| format!("{value}\n")).collect()
    };
    let run = |rows: usize, options: &[&str]| {
        let mut program = program();
        let program = program.args(["-", "--dt", "1"]).args(options);
        let output = program.write_stdin(column(rows)).output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let needed = |reported: &str| -> usize {
        let before = reported.split(" are needed").next().unwrap();
        before.rsplit(' ').next().unwrap().parse().unwrap()
    };
    let delayed = ["--delay", "5", "--dimension", "10"];
    let (code, reported) = run(45, &delayed);
    assert_eq!(code, Some(2), "{reported}");
    let rows = needed(&reported);
    let (code, reported) = run(rows - 1, &delayed);
    assert_eq!((code, needed(&reported)), (Some(1), rows), "{reported}");
    assert!(
        reported.starts_with(&format!("error: {} points are too few", rows - 1)),
        "{reported}"
    );
    let (code, reported) = run(rows, &delayed);
    assert_eq!(code, Some(0), "{reported}");
    // Complete states need exactly those rows.
    let (_, reported) = run(10, &["--dimension", "1"]);
    let rows = needed(&reported);
    assert_eq!(run(rows, &["--dimension", "1"]).0, Some(0), "{reported}");
}

#[test]
fn exponents_have_a_unit() {
    let run = |format: &[&str]| {
        let mut program = program();
        succeed(
            program
                .args(["-", "--dt", "1"])
                .args(format)
                .write_stdin(henon(false)),
        )
    };
    let unit = "natural logarithms of growth per unit of the time that dt is given in";
    assert!(run(&[]).contains(&format!("Exponents are {unit}.")));
    let json: serde_json::Value = serde_json::from_str(&run(&["--json"])).unwrap();
    assert_eq!(json["unit"], unit);
}

#[test]
fn files_as_they_come() {
    let run = |text: String| {
        succeed(
            program()
                .args(["-", "--dt", "1", "--csv"])
                .write_stdin(text),
        )
    };
    let plain = run(henon(true));
    assert_eq!(run(henon(true).replace('\n', "\r\n")), plain);
    assert_eq!(run(henon(true).replace(',', ";")), plain);
    assert_eq!(run(format!("\u{feff}# measured\n\n{}", henon(true))), plain);
    // The same forty points repeatedly: no neighbour is another point, and nothing is `ok`.
    let forty: Vec<String> = henon(false).lines().take(40).map(str::to_owned).collect();
    let repeats = forty.join("\n") + "\n";
    let output = program()
        .args(["-", "--dt", "1", "--csv"])
        .write_stdin(repeats.repeat(50))
        .assert()
        .success()
        .get_output()
        .clone();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(!text.contains(",ok"), "{text}");
}

/// Columns separated by spaces, a name in a comment, and the time step from the time.
#[test]
fn a_file_as_other_programs_write_it_needs_no_option() {
    let rows: String = henon(false)
        .lines()
        .enumerate()
        .map(|(i, line)| format!("{:.3}   {}\n", 0.5 * i as f64, line.replace(',', "   ")))
        .collect();
    let table = succeed(program().arg("-").write_stdin(format!("# t x y\n{rows}")));
    assert!(
        table.contains("3000 points of (x, y), dt = 0.5 from column t"),
        "{table}"
    );
    let named = succeed(
        program()
            .args(["-", "--csv"])
            .write_stdin(format!("# t x y\n{rows}")),
    );
    let given = succeed(
        program()
            .args(["-", "--dt", "0.5", "--csv"])
            .write_stdin(henon(true)),
    );
    assert_eq!(named, given);
    // Without names it is taken as the time, with a note.
    program()
        .args(["-", "--csv"])
        .write_stdin(rows)
        .assert()
        .success()
        .stdout(given)
        .stderr(contains(
            "column 1 goes on evenly by 0.5 and is taken as the time",
        ));
}

#[test]
fn what_is_left_out_or_has_no_effect_is_said() {
    let constant: String = henon(true)
        .lines()
        .enumerate()
        .map(|(i, line)| format!("{line},{}\n", if i == 0 { "z" } else { "4" }))
        .collect();
    let plain = succeed(
        program()
            .args(["-", "--dt", "1", "--csv"])
            .write_stdin(henon(true)),
    );
    program()
        .args(["-", "--dt", "1", "--csv"])
        .write_stdin(constant)
        .assert()
        .success()
        .stdout(plain.clone())
        .stderr("warning: column z is 4 in every row and is left out\n");
    let sano_sawada = ["--estimator", "sano-sawada"];
    let linear = succeed(
        program()
            .args(["-", "--dt", "1", "--csv"])
            .args(sano_sawada)
            .write_stdin(henon(true)),
    );
    for (arguments, same, says) in [
        (
            vec!["--eps", "5"],
            &plain,
            "--eps changes no extrapolated exponent, which comes from nearest points, however far; \
             it only says which points are called starved: give other --neighbours than 12, or \
             --estimator sano-sawada with a range such as --neighbours 12-24",
        ),
        (
            vec!["--ridge", "0.1"],
            &plain,
            "--ridge changes no extrapolated exponent",
        ),
        (
            vec!["--delay", "2"],
            &plain,
            "--delay 2 changes nothing, as less than 1 %",
        ),
        (
            vec!["--references", "3000"],
            &plain,
            "--references 3000 changes nothing: there are 2999, and all are used",
        ),
        (
            [&["--eps", "5"], &sano_sawada[..]].concat(),
            &linear,
            "--eps changes no neighbour where the fewest and the most are both 12",
        ),
        (
            [&["--degree", "linear"], &sano_sawada[..]].concat(),
            &linear,
            "--degree changes nothing where nothing is extrapolated",
        ),
    ] {
        program()
            .args(["-", "--dt", "1", "--csv"])
            .args(arguments)
            .write_stdin(henon(true))
            .assert()
            .success()
            .stdout(same.clone())
            .stderr(starts_with(format!("warning: {says}")));
    }
    // An option that has an effect is not reported as ineffective.
    for arguments in [
        [&["--ridge", "0.1"], &sano_sawada[..]].concat(),
        [
            &["--eps", "0.02", "--neighbours", "12-24"],
            &sano_sawada[..],
        ]
        .concat(),
        vec!["--references", "2998"],
    ] {
        let output = program()
            .args(["-", "--dt", "1", "--csv"])
            .args(&arguments)
            .write_stdin(henon(true))
            .assert()
            .success()
            .get_output()
            .clone();
        assert!(
            !String::from_utf8_lossy(&output.stderr).contains(" changes no"),
            "{arguments:?}"
        );
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text != plain && text != linear, "{arguments:?}");
    }
}

#[test]
fn an_unwritable_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let below = file(folder.path(), "kept").join("below");
    program()
        .args(["-", "--dt", "1", "--out"])
        .arg(&below)
        .write_stdin(henon(false))
        .assert()
        .code(1)
        .stdout("")
        .stderr(
            contains(below.to_str().unwrap())
                .and(contains("--out"))
                .and(contains("--out-dir").not()),
        );
    assert_eq!(
        std::fs::read_to_string(folder.path().join("series.csv")).unwrap(),
        "kept"
    );
}

/// Two columns of noise have two tangent directions, and no exponent.
#[test]
fn of_noise_no_exponent_is_ok() {
    let mut random = SplitMix::new(3);
    let noise: String = (0..1000)
        .map(|_| format!("{} {}\n", random.uniform(), random.uniform()))
        .collect();
    for (text, says) in [
        (noise, "no exponent is ok;"),
        (henon(false), "2 exponents are ok;"),
    ] {
        program()
            .args(["-", "--dt", "1"])
            .write_stdin(text)
            .assert()
            .success()
            .stdout(contains(format!("2 tangent directions: {says}")));
    }
}

#[test]
fn short_help_has_a_line_for_each_option() {
    let help = succeed(program().arg("-h"));
    assert!(help.lines().count() < 40, "{help}");
    assert!(help.contains("--surrogates") && help.contains("more examples: --help"));
}

#[test]
fn help_has_examples_and_explains_the_status() {
    let help = succeed(program().arg("--help"));
    for word in [
        "Examples:",
        "unidentified",
        "annihilated",
        "--columns",
        "--theiler",
        "--dt 0.02",
        "Exit codes",
        "statistical only",
        "eps_sensitivity",
        "by rank r",
        "slope",
        "residual ratio",
        "--step 5 --affine",
        "collapses",
        "undetermined",
        "noisy",
        "fixed_rank",
        "--delay",
        "--dimension",
        "--surrogates",
        "spurious",
        "Rosenstein",
        "IAAFT",
    ] {
        assert!(help.contains(word), "{word}");
    }
}

/// Numbers near the largest double do not overflow.
#[test]
fn huge_settings_are_refused() {
    let huge = usize::MAX.to_string();
    for (option, value, says) in [
        ("--surrogates", huge.as_str(), "must be 19 to 10000"),
        ("--surrogates", "10001", "must be 19 to 10000"),
        ("--surrogates", "18", "must be 19 to 10000"),
        (
            "--divergence",
            "inf",
            "--divergence = inf is not allowed: it must be finite",
        ),
        ("--divergence", "nan", "must be finite"),
        ("--dt", "1e-300", "must be 1e-100 to 1e100"),
        ("--dt", "1e300", "must be 1e-100 to 1e100"),
        ("--delay", "-3", "a whole number from 0"),
        ("--theiler", "1.5", "a whole number from 0"),
    ] {
        let dt = if option == "--dt" {
            vec![]
        } else {
            vec!["--dt", "1"]
        };
        program()
            .args(["-", option, value])
            .args(dt)
            .write_stdin(henon(false))
            .assert()
            .code(2)
            .stdout("")
            .stderr(contains(says));
    }
    for option in ["--theiler", "--neighbours", "--step"] {
        program()
            .args(["-", "--dt", "1", option, &huge])
            .write_stdin(henon(false))
            .assert()
            .code(1)
            .stdout("")
            .stderr(contains("too few"));
    }
    program()
        .args(["-", "--dt", "1", "--eps", "1", "--neighbours", &huge])
        .write_stdin(henon(false))
        .assert()
        .code(2)
        .stderr(contains("--eps"));
}

/// Numbers with many zeros are written as powers of ten.
#[test]
fn tiny_steps_are_readable() {
    let table = succeed(
        program()
            .args(["-", "--dt", "1e-100"])
            .write_stdin(henon(false)),
    );
    assert!(table.contains("dt = 1e-100\n"), "{table}");
}

/// An uneven time is an error unless columns and the time step are both given.
#[test]
fn an_uneven_time_is_no_matter_where_columns_and_step_are_given() {
    let text: String = std::iter::once("t x y\n".to_owned())
        .chain(henon(false).lines().enumerate().map(|(i, line)| {
            let t = f64::from(i as u32) + if i == 700 { 0.4 } else { 0.0 };
            format!("{t:.3} {}\n", line.replace(',', " "))
        }))
        .collect();
    let run = |arguments: &[&str]| {
        let mut program = program();
        program.arg("-").args(arguments).write_stdin(text.clone());
        program.assert()
    };
    let both = run(&["--columns", "x,y", "--dt", "1"]).success();
    both.stderr(contains("warning: --dt is used, although").and(contains("699 to 700.4")));
    for arguments in [&["--columns", "x,y"][..], &["--dt", "1"]] {
        run(arguments)
            .code(1)
            .stderr(contains("699 to 700.4").and(contains("give --columns and --dt")));
    }
}

/// Angles that wrap by a turn, in both units. An angle that never wraps is not reported.
#[test]
fn an_angle_that_wraps_is_warned_of() {
    let standard_map = |turn: f64, most: f64| -> String {
        let tau = 2.0 * std::f64::consts::PI;
        let (mut angle, mut momentum) = (0.3, 0.2);
        (0..2000)
            .map(|_| {
                momentum = (momentum + 8.0 * math::sin(angle)).rem_euclid(tau);
                angle = (angle + momentum).rem_euclid(tau);
                let [a, p] = [angle, momentum].map(|v| v / tau * turn * most);
                format!("{a} {p}\n")
            })
            .collect()
    };
    let tau = 2.0 * std::f64::consts::PI;
    // Over a full turn, without a jump.
    let sine: String = (0..2000)
        .map(|i| format!("{0} {0}\n", 3.135 * math::sin(0.1 * f64::from(i))))
        .collect();
    for (text, warns) in [
        (standard_map(tau, 1.0), true),
        (standard_map(360.0, 1.0), true),
        (standard_map(360.0, 0.9), false),
        (sine, false),
    ] {
        let says = contains("column 1 fills a whole turn of");
        let outcome = program()
            .args(["-", "--dt", "1"])
            .write_stdin(text)
            .assert()
            .success();
        if warns {
            outcome.stderr(says);
        } else {
            outcome.stderr(says.not());
        }
    }
}
