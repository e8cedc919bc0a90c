//! Derivatives at events of one instant, against closed forms.

use stickslip::analysis::{OrbitDerivatives, monodromy};
use stickslip::math;
use stickslip_model::file::System;

use super::derivatives::found;
use super::run::{METHODS, options, system};

/// Checks numbers to rounding.
fn assert_close(own: impl IntoIterator<Item = f64>, wanted: &[f64], what: &str) {
    let own: Vec<f64> = own.into_iter().collect();
    let is_close = |(own, wanted): (&f64, &f64)| (own - wanted).abs() < 1e-10;
    let all = own.len() == wanted.len() && own.iter().zip(wanted).all(is_close);
    assert!(all, "{what}: {own:?}, not {wanted:?}");
}

/// Derivatives at a time of a run with each method, none of them lost.
fn each(system: &System, names: &[&str], t: f64, check: impl Fn(&OrbitDerivatives, &str)) {
    for method in METHODS {
        let found = found(system, names, &[t], method);
        assert!(found.lost.is_none(), "{method}: {:?}", found.lost);
        check(&found, method);
    }
}

/// Falls with rate 1.5 + 0.2 T above zero and 0.5 + 0.2 T below, where a table T of time has its
/// knot at the time 1. From 1.6 it comes there at that time.
const FALLS: &str = r#"
name = "falls"
[states]
y = ""
[inputs.T]
shape = "table"
times = [0, 1, 2]
values = [0, 1, 0]
[contacts.c]
boundary = "y"
[field]
y = "by_side(c, -0.5, -1.5) - 0.2*T"
[start]
y = 1.6
[time]
end = 1.3
"#;

#[test]
fn a_crossing_at_the_knot_of_a_table_keeps_its_saltation() {
    let at_knot = system(FALLS);
    each(&at_knot, &["y"], 1.3, |found, method| {
        assert_close([found.states[0][(0, 0)]], &[0.7 / 1.7], method);
        assert_close([found.transitions[0].t[0]], &[1.0 / 1.7], method);
    });
    for method in METHODS {
        let flow = monodromy(at_knot.dynamics(), 0.0, [1.6], 1.3, &options(method)).unwrap();
        assert_close([flow.matrix[(0, 0)]], &[0.7 / 1.7], method);
    }
}

/// The jump of an oscillator at the knot of its drive: the drive goes on, and the jump has its own
/// time.
#[test]
fn a_jump_at_the_kink_of_an_input_keeps_its_own_time() {
    let with = |input: &str| {
        system(&format!(
            "name = \"hit\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nT0 = 1\n\
             [inputs.T]\n{input}\n[jumps.hit]\nwhen = \"t - T0\"\nset = {{ v = \"-0.5*v\" }}\n\
             [field]\nx = \"v\"\nv = \"-x + T\"\n[start]\nx = 0.1\nv = 0.2\n[time]\nend = 1.5\n"
        ))
    };
    // Up to the knot the drive is the time: x = t + 0.1 cos t − 0.8 sin t.
    let (sin, cos) = (math::sin(1.0), math::cos(1.0));
    let (x, v) = (1.0 + 0.1 * cos - 0.8 * sin, 1.0 - 0.1 * sin - 0.8 * cos);
    // The field before it, as the jump maps it, without the field after it.
    let (by_x, by_v) = (1.5 * v, -1.5 * (1.0 - x));
    let (sin, cos) = (math::sin(0.5), math::cos(0.5));
    let wanted = [by_x * cos + by_v * sin, by_v * cos - by_x * sin];
    for input in [
        "shape = \"table\"\ntimes = [0, 1, 2]\nvalues = [0, 1, 0]",
        "shape = \"table\"\ntimes = [0, 1, 1.2, 2]\nvalues = [0, 1, 1.2, 2]",
    ] {
        let hit = with(input);
        each(&hit, &["T0"], 1.5, |found, method| {
            assert_close([found.transitions[0].t[0]], &[1.0], method);
            assert_close(found.states[0].column(0).iter().copied(), &wanted, method);
        });
    }
    // A drive that jumps there is another event. A jump whose time is fixed still has none by it.
    let steps = with("shape = \"table\"\ntimes = [0, 1, 2]\nvalues = [0, 1, 0]");
    each(&steps, &["x", "v"], 1.5, |found, method| {
        assert_close(found.transitions[0].t.iter().copied(), &[0.0, 0.0], method);
        let [sin_1, cos_1] = [math::sin(1.0), math::cos(1.0)];
        let hit = |x: f64, v: f64| [x * cos - 0.5 * v * sin, -0.5 * v * cos - x * sin];
        let wanted = [hit(cos_1, -sin_1), hit(sin_1, cos_1)].concat();
        assert_close(found.states[0].iter().copied(), &wanted, method);
    });
}

const BALL: &str = r#"
name = "ball"
[states]
h = ""
w = ""
[parameters]
g = 10
e = 0.5
[jumps.b]
when = "h"
direction = "falling"
set = { w = "-e*w" }
[field]
h = "w"
w = "-g"
[start]
h = 5
w = 0
[time]
end = 2.4
"#;

/// A jump with a condition that holds is the jump without it.
#[test]
fn a_jump_with_a_condition_has_the_derivatives_of_the_jump() {
    let names = ["h", "w", "g", "e"];
    let gated = BALL.replace("[jumps.b]\n", "[jumps.b]\nif = \"w < -0.1\"\n");
    let (plain, gated) = (system(BALL), system(&gated));
    each(&gated, &names, 2.4, |gated, method| {
        let plain = found(&plain, &names, &[2.4], method);
        assert_eq!(gated.transitions.len(), 2);
        assert_eq!(plain.transitions, gated.transitions);
        assert_eq!(plain.states, gated.states);
        // Falls for √(2h/g), which the height changes by 1/√(2hg).
        assert_close([gated.transitions[0].t[0]], &[0.1], method);
    });
}
