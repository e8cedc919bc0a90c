//! Functions through points, in fields, laws and jumps, and functions of two arguments.

use stickslip::math;
use stickslip_model::file::{Source, SystemFile};

use super::run::{METHODS, Run, options, system};

/// A state whose rate is a curve.
fn along(curve: &str, end: f64) -> String {
    format!(
        "name = \"curve\"\n[states]\nx = \"\"\n[curves.rate]\n{curve}\n[field]\nx = \"rate(x)\"\n\
         [start]\nx = 0\n[time]\nend = {end}\n"
    )
}

/// x' = 1 + x up to 1, 2 - 1.5 (x - 1) up to 2, and 0.5 behind.
#[test]
fn steps_end_where_lines_meet() {
    let text = along("points = [[0, 1], [1, 2], [2, 0.5]]", 5.0);
    let exact = 2.0 + 0.5 * (5.0 - math::ln(2.0) - math::ln(4.0) / 1.5);
    for (method, close) in [("taylor", 1e-14), ("dop853", 1e-11)] {
        let run = Run::of(system(&text), &options(method), None);
        let off = run.end("x") - exact;
        assert!(off.abs() < close, "{method}: {off:e}");
    }
}

/// The time from 0 to 2 is the integral of 1/rate, by Simpson's rule between the points.
#[test]
fn a_monotone_curve_is_followed_through_its_points() {
    let (xs, ys) = ([0.0, 0.5, 1.25, 2.0], [0.4, 0.3, 0.25, 0.1]);
    let curve = "points = [[0, 0.4], [0.5, 0.3], [1.25, 0.25], [2, 0.1]]\nbetween = \"monotone\"";
    let file = system(&along(curve, 100.0)).file;
    let rate = |x: f64| file.curves[0].curve.of(x);
    let mut time = 0.0;
    for (from, to) in xs.iter().zip(&xs[1..]) {
        let count = 2000;
        let h = (to - from) / f64::from(count);
        let value = |k: i32| 1.0 / rate(from + h * f64::from(k));
        let inner = (1..count).map(|k| if k % 2 == 1 { 4.0 } else { 2.0 } * value(k));
        time += h / 3.0 * (value(0) + inner.sum::<f64>() + value(count));
    }
    for (method, close) in [("taylor", 1e-12), ("dop853", 1e-10)] {
        let run = Run::of(system(&along(curve, time)), &options(method), None);
        assert!(
            (run.end("x") - 2.0).abs() < close,
            "{method}: {}",
            run.end("x")
        );
        assert_eq!(rate(3.0), ys[3]);
    }
}

/// A block on a belt: friction over slip speed as a table, and the same lines as a formula.
fn belt(law: &str, curves: &str) -> String {
    format!(
        "name = \"belt\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nspeed = 0.5\n\
         [definitions]\nslip = \"belt*(v - speed)\"\n{curves}\n[contacts.belt]\n\
         boundary = \"v - speed\"\nfriction = \"{law}\"\n[field]\nx = \"v\"\n\
         v = \"-x - friction(belt) + 0.3*sin(0.7*t)\"\n[start]\nx = 1\n\
         v = -0.4\n[time]\nend = 120\n"
    )
}

#[test]
fn a_table_of_friction_is_the_law_that_its_lines_are() {
    let by_formula = "0.8 - min(slip, 0.25) - 0.2*min(max(slip - 0.25, 0), 0.75) \
                      + 0.1*min(max(slip - 1, 0), 1)";
    let points = "points = [[0, 0.8], [0.25, 0.55], [1, 0.4], [2, 0.5]]";
    for beyond in ["hold", "extend", "error"] {
        let curve = format!("[curves.mu]\n{points}\nbeyond = \"{beyond}\"");
        // Error control alone passes the corners, so that each run has errors of its own.
        for (method, close) in [("taylor", 1e-12), ("dop853", 1e-8)] {
            let one = Run::of(system(&belt(by_formula, "")), &options(method), None);
            let other = Run::of(system(&belt("mu(slip)", &curve)), &options(method), None);
            assert!(one.transitions.len() > 20, "{}", one.transitions.len());
            assert_eq!(
                one.transitions.len(),
                other.transitions.len(),
                "{method} {beyond}"
            );
            for (one, other) in one.transitions.iter().zip(&other.transitions) {
                assert_eq!(one.1, other.1, "{method} {beyond}");
                let off = (one.0 - other.0).abs();
                assert!(off < close, "{method} {beyond}: {off:e} at {}", one.0);
            }
            for state in ["x", "v"] {
                let off = (one.end(state) - other.end(state)).abs();
                assert!(off < close, "{method} {beyond}: {off:e}");
            }
        }
    }
}

#[test]
fn beyond_its_points_a_curve_may_be_an_error() {
    let text = along("points = [[0, 1], [1, 2]]\nbeyond = \"error\"", 5.0);
    for method in METHODS {
        let run = Run::of(system(&text), &options(method), None);
        let words = run.words();
        assert!(
            words.contains("`rate(x)` is not a number where `x` is 1.00000"),
            "{words}"
        );
    }
}

#[test]
fn points_in_a_file_are_read_as_tables_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("system.toml");
    std::fs::write(&path, along("file = \"rate.csv\"", 1.0)).unwrap();
    std::fs::write(folder.path().join("rate.csv"), "x;y\n0,0;1,0\n1,0;2,0\n").unwrap();
    let file = SystemFile::open(path.to_str().unwrap()).unwrap();
    assert_eq!(
        (file.curves[0].points, file.curves[0].curve.of(0.5)),
        (2, 1.5)
    );
    std::fs::write(folder.path().join("rate.csv"), "x,y\n0,1\n1\n").unwrap();
    let error = SystemFile::open(path.to_str().unwrap())
        .unwrap_err()
        .to_string();
    assert!(error.contains("line 3 has no value"), "{error}");
    // Which of three columns is meant is not guessed; blank ones behind the two are none.
    for (text, words) in [
        (
            "x,mu,sigma\n0,1,0.1\n1,2,0.1\n",
            "has 3 columns (x, mu, sigma)",
        ),
        (
            "0 1 0.1\n1 2 0.1\n",
            "has 3 columns, and only two can be meant",
        ),
    ] {
        std::fs::write(folder.path().join("rate.csv"), text).unwrap();
        let error = SystemFile::open(path.to_str().unwrap()).unwrap_err();
        let error = error.to_string();
        assert!(error.contains(words), "{error}");
        assert!(error.contains("argument and value") && error.contains("leave these two"));
    }
    std::fs::write(folder.path().join("rate.csv"), "x,mu,\n0,1,\n1,2,\n").unwrap();
    assert_eq!(
        SystemFile::open(path.to_str().unwrap()).unwrap().curves[0].points,
        2
    );
}

#[test]
fn a_curve_that_is_wrong_is_reported() {
    let good = "points = [[0, 1], [1, 2]]";
    for (curve, rate, message) in [
        ("points = [[0, 1]]", "rate(x)", "a curve of 1 points"),
        (
            "points = [[0, 1], [0, 2]]",
            "rate(x)",
            "0 comes before 0, as number 1 and 2 of 2",
        ),
        (
            "points = [[0, 1, 2], [0, 2]]",
            "rate(x)",
            "a point has two numbers, this has 3",
        ),
        (
            "points = [0, 1]",
            "rate(x)",
            "a point of two numbers is expected here",
        ),
        (
            "points = [[0, \"a\"], [1, 2]]",
            "rate(x)",
            "a number is expected here, not a text",
        ),
        (
            "between = \"linear\"",
            "rate(x)",
            "a curve has points, or a file with them",
        ),
        (
            "points = [[0, 1], [1, 2]]\nbetween = \"spline\"",
            "rate(x)",
            "cannot be `spline`",
        ),
        (
            "points = [[0, 1], [1, 2]]\nbeyond = \"zero\"",
            "rate(x)",
            "cannot be `zero`",
        ),
        (
            "points = [[0, 1], [1, 2]]\nunit = \"m\"",
            "rate(x)",
            "has no entry `unit`",
        ),
        (good, "rate", "`rate` is a curve and has no value by itself"),
        (good, "rate(x, x)", "rate takes one argument, not 2"),
        (good, "rote(x)", "did you mean `rate`?"),
        (good, "qqq(x)", "clamp, if, rate"),
    ] {
        let text = along(curve, 1.0).replace("rate(x)", rate);
        let name = "curve.toml".to_owned();
        let error = SystemFile::parse(Source { name, text })
            .unwrap_err()
            .to_string();
        assert!(error.contains(message), "{curve}: {error}");
    }
}

/// A point that goes round at the rate 1, and a rate that is the slope of an error function.
#[test]
fn angles_and_error_functions_have_their_derivatives() {
    let text = "name = \"round\"\n[states]\nx = \"\"\ny = \"\"\nz = \"\"\nw = \"\"\n[field]\n\
                x = \"-2*y\"\ny = \"2*x\"\nz = \"atan2(y, x)\"\nw = \"erf(2*t - 3)\"\n\
                [start]\nx = 1\ny = 0\nz = 0\nw = 0\n[time]\nend = 6\n";
    // z: the angle 2t is a sawtooth between -π and π; w: an antiderivative of the error function.
    let turns = 6.0 - 2.0 * std::f64::consts::PI;
    let z = turns * turns;
    let primitive = |u: f64| {
        let bell = math::exp(-u * u) / std::f64::consts::PI.sqrt();
        u * math::erf(u) + bell
    };
    let w = 0.5 * (primitive(9.0) - primitive(-3.0));
    // Error control alone passes the jumps of the angle.
    for (method, close) in [("taylor", 1e-12), ("dop853", 1e-9)] {
        let run = Run::of(system(text), &options(method), None);
        let off = [run.end("z") - z, run.end("w") - w];
        assert!(
            off[0].abs() < close && off[1].abs() < 1e-12,
            "{method}: {off:?}"
        );
    }
}
