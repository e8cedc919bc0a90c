//! Choices at jumps, and the functions that others make up.

use stickslip::analysis::PeriodicOrbit;
use stickslip::{Error, math};
use stickslip_model::file::{Source, SystemFile};
use stickslip_model::study::Variables;

use super::run::{METHODS, Run, branch, options, orbit, real_multipliers, system};

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

/// What is chosen by a velocity is none.
#[test]
fn a_state_that_choices_set_to_isolated_values_is_discrete() {
    let discrete = |text: &str| system(text).built.switching.discrete.clone();
    assert_eq!(discrete(BALL), [false, false, true]);
    let sampled = BALL.replacen("vmin, 0, fly)", "vmin, v, fly)", 1);
    assert_eq!(discrete(&sampled), [false, false, false]);
    let timed = BALL.replacen("vmin, 0, fly)", "vmin, t, fly)", 1);
    assert_eq!(discrete(&timed), [false, false, false]);
}

/// Each comparison, at smaller, equal and larger numbers.
/// A memory that each period multiplies by a factor: its neighbours approach it or part.
#[test]
fn a_state_that_is_multiplied_has_neighbours_and_a_multiplier() {
    for (set, factor) in [
        ("1.5*u", 1.5),
        ("a*u", -0.4),
        ("0.5*u + b*x", 0.5),
        ("u*a*a", 0.16),
    ] {
        let text = format!(
            "name = \"memory\"\n[time]\nperiod = 1\n[states]\nx = \"\"\n[discrete]\nu = 0\n\
             [parameters]\na = -0.4\nb = 0\n[jumps.set]\nwhen = \"cos(2*pi*t)\"\n\
             direction = \"falling\"\nset = {{ u = \"{set}\" }}\n\
             [field]\nx = \"-x + u + sin(2*pi*t)\"\n[start]\nx = 0.1\n"
        );
        let system = system(&text);
        let options = options("taylor");
        let orbit = orbit(&system, &options);
        let found = real_multipliers(&orbit);
        let is_one = |wanted: f64| found.iter().any(|one| (one - wanted).abs() < 1e-9);
        assert!(
            is_one(factor) && is_one(math::exp(-1.0)),
            "{set}: {found:?}"
        );
    }
    let counted = |set: &str| {
        let text = format!(
            "name = \"counter\"\n[states]\nx = \"\"\n[discrete]\nn = 0\n[jumps.set]\n\
             when = \"x - 1\"\nset = {{ x = \"0\", n = \"{set}\" }}\n[field]\nx = \"1\"\n\
             [start]\nx = 0\n"
        );
        system(&text).built.switching.discrete[1]
    };
    for set in [
        "n - 1",
        "1 - n",
        "if(n > 3, 0, n + 1)",
        "abs(n - 2)",
        "max(n, 3)",
        "if(n > 1, -n, n)",
        "if(n > 1, if(n > 2, 0, -abs(n)), min(n + 1, 5))",
    ] {
        assert!(counted(set), "{set}");
    }
    for set in [
        "2*n",
        "n + n",
        "n/3",
        "if(n > 1, 0.5*n, n)",
        "n*n",
        "1/n",
        "1 + 2.5*n - 1.5*n^2",
        "if(n > 1, n, sin(n))",
    ] {
        assert!(!counted(set), "{set}");
    }
}

/// The map `-(1 + p) u + u^3`, once a period. From zero, which attracts for `p < 0`, an orbit
/// between `+-sqrt(p)` branches off, whose multiplier is the product of two slopes `2 p - 1`.
pub const FLIP: &str = r#"
name = "flip map"
[time]
period = 1
[states]
x = ""
[discrete]
u = 0.2
[parameters]
p = 0.1
[jumps.map]
when = "sin(2*pi*t + 1)"
direction = "rising"
set = { u = "-(1 + p)*u + u^3" }
[field]
x = "u - x"
[start]
x = 0.1
"#;

#[test]
fn a_state_that_jumps_map_has_the_multiplier_of_its_map() {
    let decay = math::exp(-1.0);
    for p in [0.1, 0.3] {
        let doubled = crate::run::with(FLIP, &[("p", p)]);
        let found = orbit(&doubled, &options("taylor"));
        let u = found.x[1].abs();
        assert!((u - f64::sqrt(p)).abs() < 1e-12, "{p}: {u}");
        assert_eq!(found.period, 2.0);
        let has = |found: &PeriodicOrbit, wanted: [f64; 2]| {
            let multipliers = real_multipliers(found);
            let near = |one: &f64| multipliers.iter().any(|found| (found - one).abs() < 1e-9);
            assert!(wanted.iter().all(near), "{p}: {multipliers:?}");
        };
        has(&found, [(2.0 * p - 1.0) * (2.0 * p - 1.0), decay * decay]);
        let at_zero = FLIP.replace("u = 0.2", "u = 0").replace("x = 0.1", "x = 0");
        let found = orbit(&crate::run::with(&at_zero, &[("p", p)]), &options("taylor"));
        has(&found, [-1.0 - p, decay]);
    }
}

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

/// A counter of the turns of x = -cos t that stops at three: the other zeros are no transitions.
#[test]
fn where_its_condition_does_not_hold_a_jump_does_not_happen() {
    let text = "name = \"counter\"\n[states]\nx = \"\"\nv = \"\"\n[discrete]\nn = 0\n\
                [jumps.turn]\nwhen = \"x\"\nif = \"n < 2.5 and not v < 0\"\n\
                set = { n = \"n + 1\" }\n[field]\nx = \"v\"\nv = \"-x\"\n\
                [start]\nx = -1\nv = 0\n[time]\nend = 30\n";
    for method in METHODS {
        let run = Run::of(system(text), &options(method), None);
        let times: Vec<f64> = run.transitions.iter().map(|at| at.0).collect();
        let turns = [0.5, 2.5, 4.5].map(|turns| turns * std::f64::consts::PI);
        assert_eq!(times.len(), turns.len(), "{method}: {times:?}");
        for (found, exact) in times.iter().zip(turns) {
            assert!((found - exact).abs() < 1e-10, "{method}: {found} {exact}");
        }
        assert_eq!(run.end("n"), 3.0);
        assert!((run.end("x") + math::cos(30.0)).abs() < 1e-10, "{method}");
    }
}

/// A ball that falls through the floor when it comes slowly enough.
#[test]
fn what_a_jump_does_not_hold_goes_on_as_without_it() {
    let text = BALL
        .replace("fly = \"if(-v < vmin, 0, fly)\" ", "")
        .replacen(
            "set = { v = \"if(-v < vmin, 0, -e*v)\",",
            "if = \"-v >= vmin\"\nset = { v = \"-e*v\"",
            1,
        );
    let (mut speed, mut t, mut count) = (2.0_f64.sqrt(), 2.0_f64.sqrt(), 0);
    while speed >= 0.3 {
        speed *= 0.8;
        t += 2.0 * speed;
        count += 1;
    }
    for method in METHODS {
        let run = Run::of(system(&text), &options(method), None);
        assert_eq!(run.transitions.len(), count, "{method}");
        let rest = 20.0 - t;
        let (h, v) = (-(speed + 0.5 * rest) * rest, -(speed + rest));
        let off = [run.end("h") - h, run.end("v") - v];
        assert!(
            off[0].abs() < 1e-10 && off[1].abs() < 1e-11,
            "{method}: {off:?}"
        );
    }
}

/// Jumps of one instant are judged in their order, each on the state that the one before has left.
#[test]
fn a_condition_is_judged_on_the_state_before_its_jump() {
    let text = |first: &str, second: &str| {
        format!(
            "name = \"two\"\n[states]\nx = \"\"\n[discrete]\na = 0\nb = 0\n\
             [jumps.{first}]\nwhen = \"x - 1\"\n{}\n[jumps.{second}]\nwhen = \"x - 1\"\n{}\n\
             [field]\nx = 1\n[start]\nx = 0\n[time]\nend = 2\n",
            of(first),
            of(second)
        )
    };
    fn of(jump: &str) -> &'static str {
        match jump {
            "sets" => "set = { a = 1 }",
            _ => "if = \"a > 0.5\"\nset = { b = 1 }",
        }
    }
    for method in METHODS {
        for (order, b) in [(["sets", "asks"], 1.0), (["asks", "sets"], 0.0)] {
            let run = Run::of(system(&text(order[0], order[1])), &options(method), None);
            assert_eq!([run.end("a"), run.end("b")], [1.0, b], "{order:?}");
            assert_eq!(run.transitions.len(), 1 + b as usize, "{order:?}");
            assert!((run.end("x") - 2.0).abs() < 1e-14);
        }
    }
}

/// At a start on its zero, and at a zero that another jump causes.
#[test]
fn a_condition_counts_at_a_start_and_behind_another_jump() {
    let text = |condition: &str| {
        format!(
            "name = \"start\"\n[states]\nx = \"\"\n[discrete]\na = 0\nb = 0\n\
             [jumps.first]\nwhen = \"x\"\ndirection = \"rising\"\nif = \"{condition}\"\n\
             set = {{ a = \"a + 1\" }}\n[jumps.back]\nwhen = \"x - 1\"\n\
             set = {{ x = -1, b = \"b + 1\" }}\n[jumps.over]\nwhen = \"x + 0.5\"\n\
             direction = \"falling\"\nif = \"b > 1.5\"\nset = {{ a = \"a + 10\" }}\n\
             [field]\nx = 1\n[start]\nx = 0\n[time]\nend = 4\n"
        )
    };
    for method in METHODS {
        // Zeros of x at 0 and 2 and 4 (the end); x is put back at 1 and 3.
        let run = Run::of(system(&text("t > 1")), &options(method), Some(3.5));
        assert_eq!([run.end("a"), run.end("b")], [11.0, 2.0], "{method}");
        let run = Run::of(system(&text("t < 1")), &options(method), Some(3.5));
        assert_eq!([run.end("a"), run.end("b")], [11.0, 2.0], "{method}");
        assert_eq!(run.transitions[0].0, 0.0);
    }
}

/// A ball whose last impact is exactly as fast as the choice asks: the run goes on, and its
/// derivatives end there by name. A little beside it they are those of the branch.
#[test]
fn a_choice_between_equal_numbers_is_told_as_a_graze() {
    for (set, tied) in [
        ("v = \"if(-v < vmin, -0.8*e*v, -e*v)\"", true),
        ("v = \"if(n > 0.5 and -v < vmin, -0.8*e*v, -e*v)\"", false),
        ("v = \"if(n > 0.5, if(-v < vmin, 0, -v), -e*v)\"", false),
        (
            "v = \"if(n < 0.5, if(-v < vmin, -0.8*e*v, -e*v), 0)\"",
            true,
        ),
        ("v = \"if(n < 0 or n <= 0, -e*v, 0)\"", false),
    ] {
        let text = format!(
            "name = \"ball\"\n[states]\nh = \"\"\nv = \"\"\n[discrete]\nn = 0\n[parameters]\n\
             e = 0.5\nvmin = 0.5\n[jumps.bounce]\nwhen = \"h\"\ndirection = \"falling\"\n\
             set = {{ {set} }}\n[field]\nh = \"v\"\nv = -1\n[start]\nh = 0.5\nv = 0\n\
             [time]\nend = 2.3\n"
        );
        for method in METHODS {
            let system = system(&text);
            let variables = Variables::named(&system, ["h", "e"]).unwrap();
            let along = |h: f64| {
                let start = [h, 0.0, 0.0];
                let of = ((0.0, &start[..]), 2.3);
                variables
                    .along(&system, of, (&[2.3], &[]), &options(method))
                    .unwrap()
            };
            let exact = along(0.5);
            // It falls onto the floor at 1 with the speed 1, and at 2 with 0.5.
            assert_eq!(exact.transitions.len(), 2, "{method}, {set}");
            // It goes on by one of the branches.
            let height = |speed: f64| speed * 0.3 - 0.5 * 0.3 * 0.3;
            let found = exact.points[0][0];
            let slower = if tied { 0.2 } else { 0.25 };
            let off = [0.25, slower].map(|speed| (found - height(speed)).abs());
            assert!(off[0].min(off[1]) < 1e-12, "{method}, {set}: {found}");
            assert!(exact.transitions[0].t[0].is_finite());
            match (&exact.lost, tied) {
                (Some(Error::TiedChoice { t, jump: 0, .. }), true) => {
                    assert!((t - 2.0).abs() < 1e-12);
                    assert!(exact.states[0][(0, 0)].is_nan());
                }
                (None, false) => assert!(exact.states[0][(0, 0)].is_finite()),
                (lost, _) => panic!("{method}, {set}: {lost:?}"),
            }
            // The flow after two impacts from h: with V = sqrt(2 h), the second one is at
            // V (1 + 2 e) and leaves with e² V.
            let beside = along(0.52);
            assert!(beside.lost.is_none(), "{:?}", beside.lost);
            let (speed, e) = (1.04_f64.sqrt(), 0.5);
            let flight = 2.3 - speed * (1.0 + 2.0 * e);
            let by_speed = e * e * flight - (e * e * speed - flight) * (1.0 + 2.0 * e);
            let found = beside.states[0][(0, 0)];
            assert!(
                (found - by_speed / speed).abs() < 1e-9,
                "{method}, {set}: {found}"
            );
        }
    }
}

/// The branch that is not chosen may have no value.
#[test]
fn only_the_chosen_branch_needs_a_value() {
    for (y, wanted) in [(-4.0, 0.0), (4.0, 2.0)] {
        let text = format!(
            "name = \"root\"\n[states]\nx = \"\"\n[discrete]\nn = 7\ny = {y}\n\
             [jumps.one]\nwhen = \"x - 1\"\nset = {{ n = \"if(y < 0, 0, sqrt(y))\" }}\n\
             [field]\nx = 1\n[start]\nx = 0\n[time]\nend = 2\n"
        );
        let run = Run::of(system(&text), &options("taylor"), None);
        assert_eq!(run.end("n"), wanted);
    }
}

#[test]
fn a_condition_without_a_value_is_an_error() {
    let text = BALL.replacen("set =", "if = \"h < 1 and sqrt(-v - 10) < 2\"\nset =", 1);
    for method in METHODS {
        let run = Run::of(system(&text), &options(method), None);
        let words = run.words();
        let place = "in `if` of [jumps.bounce], `sqrt(-v - 10)` is not a number where `-v - 10` is";
        assert!(words.contains(place), "{words}");
        // What comes first and decides leaves the rest open.
        for (condition, count) in [
            ("v < -10 and sqrt(-v - 10) < 2", 0),
            ("not (v > -10 or sqrt(-v - 10) < 2)", 0),
            ("-v >= vmin and (v > -10 or sqrt(-v - 10) < 2)", 7),
        ] {
            let text = BALL.replacen("set =", &format!("if = \"{condition}\"\nset ="), 1);
            let run = Run::of(system(&text), &options(method), None);
            assert_eq!(run.transitions.len(), count, "{condition}");
        }
    }
}

/// A thermostat with a jump that is never carried out has the orbit that it has without it.
#[test]
fn orbits_and_branches_go_through_zeros_that_say_nothing() {
    let house = |more: &str| {
        system(&format!(
            "name = \"house\"\n[states]\nT = \"\"\n[discrete]\nh = 1\n[parameters]\np = 20\n\
             [jumps.on]\nwhen = \"T - 19\"\ndirection = \"falling\"\nset = {{ h = 1 }}\n\
             [jumps.off]\nwhen = \"T - 21\"\ndirection = \"rising\"\nset = {{ h = 0 }}\n{more}\
             [field]\nT = \"10 + p*h - T\"\n[start]\nT = 19\n[time]\nend = 3\n"
        ))
    };
    let more = "[jumps.never]\nwhen = \"T - 20\"\nif = \"h > 2\"\nset = { T = 0 }\n";
    for method in METHODS {
        let options = options(method);
        for system in [house(""), house(more)] {
            let found = orbit(&system, &options);
            let exact = 2.0 * math::ln(11.0 / 9.0);
            assert!((found.period - exact).abs() < 1e-10, "{method}");
            let branch = branch(&system, ("p", 18.0, 24.0), &options);
            // ln((p - 9)/(p - 11)) up and ln(11/9) down.
            for point in &branch.points {
                let p = point.orbit.parameter;
                let exact = math::ln((p - 9.0) / (p - 11.0)) + math::ln(11.0 / 9.0);
                assert!((point.orbit.period - exact).abs() < 1e-9, "{method} at {p}");
            }
            let last = branch.points.iter().map(|point| point.orbit.parameter);
            assert!(last.fold(0.0, f64::max) > 23.9, "{method}");
        }
    }
}

#[test]
fn a_condition_is_refused_where_it_is_none() {
    for (condition, message) in [
        ("\"h\"", "this is a number, not a condition"),
        ("\"h < 1 and v\"", "this is a number, not a condition"),
        ("\"0 < h < 1\"", "`<` is not expected here"),
        ("\"nothing < 1\"", "unknown name `nothing`"),
        ("true", "a condition in quotes"),
        ("\"h == 1\"", "`=` does not belong into an expression"),
    ] {
        let text = BALL.replacen("set =", &format!("if = {condition}\nset ="), 1);
        let name = "ball.toml".to_owned();
        let error = SystemFile::parse(Source { name, text })
            .unwrap_err()
            .to_string();
        assert!(error.contains(message), "{condition}: {error}");
    }
}

#[test]
fn a_choice_elsewhere_is_refused() {
    for (before, after, message) in [
        (
            "v = \"-fly\"",
            "v = \"if(h < 0, 1, -1)\"",
            "a choice can stand only at a jump",
        ),
        (
            "when = \"h\"",
            "when = \"if(h < 0, h, v)\"",
            "a choice can stand only at a jump",
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
                f = \"clamp(4*x + 1, 0.5, 1)\"\ng = \"atan2(x, -3)\"\nh = \"erf(x)\"\n\
                [field]\nclamp = \"clamp\"\n\
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
    assert_eq!(start[5..7], [0.5, 1.0]);
    // π − arctan(1/12), and erf(1/4) to 16 digits.
    close(start[7], 3.058_451_421_701_352);
    close(start[8], 0.276_326_390_168_236_9);
}
