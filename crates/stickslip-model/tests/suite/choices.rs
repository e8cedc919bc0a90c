//! Choices at jumps, and the functions that others make up.

use stickslip::math;
use stickslip_model::file::{Source, SystemFile};

use super::run::{METHODS, Run, options, system};

/// A ball that is put to rest by an impact slower than `vmin`.
const BALL: &str = r#"name = "ball"
[states]
h = ""
v = ""
[discrete]
fly = 1
[parameters]
e = 0.8
vmin = 0.3
[jumps.bounce]
when = "h"
direction = "falling"
set = { v = "if(-v < vmin, 0, -e*v)", fly = "if(-v < vmin, 0, fly)" }
[field]
h = "v"
v = "-fly"
[start]
h = 1
v = 0
[time]
end = 20
"#;

#[test]
fn a_jump_chooses_what_it_sets() {
    let (fall, e) = (2.0_f64.sqrt(), 0.8);
    // The last impact is the first slower than 0.3.
    let (mut speed, mut t, mut count) = (fall, fall, 1);
    while speed >= 0.3 {
        speed *= e;
        t += 2.0 * speed;
        count += 1;
    }
    for method in METHODS {
        let run = Run::of(system(BALL), &options(method), None);
        assert_eq!(run.transitions.len(), count, "{method}");
        let last = run.transitions[count - 1].0;
        assert!((last - t).abs() < 1e-12, "{method}: {last} and {t}");
        assert_eq!([run.end("v"), run.end("fly")], [0.0, 0.0]);
        assert!(run.end("h").abs() < 1e-14);
    }
}

/// Each comparison, at smaller, equal and larger numbers.
#[test]
fn comparisons_hold_as_they_are_written() {
    for (comparison, holds) in [
        ("<", [true, false, false]),
        ("<=", [true, true, false]),
        (">", [false, false, true]),
        (">=", [false, true, true]),
    ] {
        for (y, holds) in [-0.5, 0.25, 1.0].into_iter().zip(holds) {
            let text = format!(
                "name = \"choice\"\n[states]\nx = \"\"\n[discrete]\nn = 0\ny = {y}\n[jumps.one]\n\
                 when = \"x - 1\"\nset = {{ n = \"if(y + 0.25 {comparison} 2*0.25, 3, 4 + y)\" }}\n\
                 [field]\nx = 1\n[start]\nx = 0\n[time]\nend = 2\n"
            );
            let run = Run::of(system(&text), &options("taylor"), None);
            let wanted = if holds { 3.0 } else { 4.0 + y };
            assert_eq!(run.end("n"), wanted, "{y} {comparison}");
        }
    }
}

#[test]
fn a_choice_elsewhere_is_refused() {
    for (before, after, message) in [
        (
            "v = \"-fly\"",
            "v = \"if(h < 0, 1, -1)\"",
            "a choice can stand only in what a jump sets",
        ),
        (
            "when = \"h\"",
            "when = \"if(h < 0, h, v)\"",
            "a choice can stand only in what a jump sets",
        ),
        ("-e*v)\"", "-e*v, 2)\"", "if takes a condition"),
        (
            "-v < vmin, 0, -e*v",
            "-v, 0, -e*v < 2",
            "`<` does not belong into an expression",
        ),
        (
            "v = \"-fly\"",
            "v = \"-fly < 2\"",
            "`<` does not belong into an expression",
        ),
    ] {
        let text = BALL.replacen(before, after, 1);
        assert_ne!(text, BALL);
        let name = "ball.toml".to_owned();
        let error = SystemFile::parse(Source { name, text })
            .unwrap_err()
            .to_string();
        assert!(error.contains(message), "{after}: {error}");
    }
}

/// Values of functions with all digits, and a state whose name one of them has.
#[test]
fn composed_functions_have_their_values() {
    let text = "name = \"functions\"\n[states]\nclamp = \"\"\n[parameters]\nx = 0.25\n[discrete]\n\
                a = \"asin(x)\"\nb = \"acos(-x)\"\nc = \"log10(1000 + x)\"\n\
                d = \"hypot(3*x, 4*x)\"\ne = \"clamp(x, 0.5, 1)\"\n\
                f = \"clamp(4*x + 1, 0.5, 1)\"\n[field]\nclamp = \"clamp\"\n\
                [start]\nclamp = 1\n";
    let start = system(text).start().unwrap();
    let close = |found: f64, exact: f64| {
        assert!(
            (found - exact).abs() <= 4.0 * f64::EPSILON * exact,
            "{found} and {exact}"
        );
    };
    // sin(asin x) = x and so on; ln 1000.25 / ln 10.
    close(math::sin(start[1]), 0.25);
    close(-math::cos(start[2]), 0.25);
    close(start[3], 3.000_108_560_051_035);
    close(start[4], 1.25);
    assert_eq!(start[5..], [0.5, 1.0]);
}
