//! Derivatives at events of one instant, against closed forms.

use stickslip::analysis::{Monodromy, OrbitDerivatives};
use stickslip::{Error, math};
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
        let flow = Monodromy::of(at_knot.dynamics(), 0.0, [1.6], 1.3, &options(method)).unwrap();
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

/// Two states that fall, each with a jump at zero from a start at 1.
fn falling(sets: &str) -> System {
    system(&format!(
        "name = \"two\"\n[states]\ny = \"\"\nz = \"\"\n[jumps.a]\nwhen = \"y\"\n\
         direction = \"falling\"\nset = {{ y = \"1\" }}\n[jumps.b]\nwhen = \"z\"\n\
         direction = \"falling\"\nset = {{ z = \"{sets}\" }}\n[field]\ny = \"-1\"\nz = \"-1\"\n\
         [start]\ny = 1\nz = 1\n[time]\nend = 1.2\n"
    ))
}

/// Checks that derivatives end at an instant, for two events there.
fn assert_lost(system: &System, names: &[&str], [t, until]: [f64; 2]) {
    for method in METHODS {
        let found = found(system, names, &[0.9 * t, until], method);
        let Some(Error::SimultaneousEvents { t: lost, .. }) = found.lost else {
            panic!("{method}: {:?}", found.lost);
        };
        assert_close([lost], &[t], method);
        assert!(found.states[0].iter().all(|of| of.is_finite()));
        assert!(found.states[1].iter().all(|of| of.is_nan()));
    }
}

#[test]
fn two_jumps_at_one_instant_have_derivatives_where_they_commute() {
    each(&falling("2"), &["y", "z"], 1.2, |found, method| {
        assert_close(
            found.states[0].iter().copied(),
            &[1.0, 0.0, 0.0, 1.0],
            method,
        );
    });
    // In one order the second jump sees the state that the first one sets: z is 1.8 or 2.8.
    assert_lost(&falling("2 + y"), &["y", "z"], [1.0, 1.2]);
    let of_flow = Monodromy::of(
        falling("2 + y").dynamics(),
        0.0,
        [1.0, 1.0],
        1.2,
        &options("taylor"),
    );
    assert!(matches!(of_flow, Err(Error::SimultaneousEvents { .. })));
}

/// A jump at a crossing, which one order avoids: the derivative is 1/3 from one side and 1/9 from
/// the other.
#[test]
fn a_jump_at_a_crossing_has_derivatives_where_they_commute() {
    let with = |jump: &str| {
        system(&format!(
            "name = \"both\"\n[states]\ny = \"\"\nz = \"\"\n[contacts.c]\nboundary = \"y\"\n\
             [jumps.j]\n{jump}\n[field]\ny = \"by_side(c, -0.5, -1.5)\"\nz = \"-1\"\n\
             [start]\ny = 1.5\nz = 1\n[time]\nend = 1.4\n"
        ))
    };
    assert_lost(
        &with("when = \"t - 1\"\nset = { y = \"y + 1\" }"),
        &["y"],
        [1.0, 1.4],
    );
    let apart = with("when = \"z\"\ndirection = \"falling\"\nset = { z = \"2*z + 3\" }");
    each(&apart, &["y", "z"], 1.4, |found, method| {
        let wanted = [1.0 / 3.0, 0.0, 0.0, 1.0];
        assert_close(found.states[0].iter().copied(), &wanted, method);
    });
}

/// A drive that jumps at the instant of another jump.
#[test]
fn a_jump_where_the_field_jumps_has_derivatives_if_both_move_alike() {
    let with = |when: &str| {
        system(&format!(
            "name = \"hit\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nP = 2\n\
             [inputs.u]\nshape = \"square\"\nperiod = \"P\"\n\
             [jumps.hit]\nwhen = \"{when}\"\nset = {{ v = \"-0.5*v\" }}\n\
             [field]\nx = \"v\"\nv = \"-x + 0.8*u\"\n[start]\nx = 0.1\nv = 0.2\n\
             [time]\nend = 1.5\n"
        ))
    };
    let turned = |[x, v]: [f64; 2]| {
        let (sin, cos) = (math::sin(0.5), math::cos(0.5));
        [x * cos + v * sin, v * cos - x * sin]
    };
    let (sin, cos) = (math::sin(1.0), math::cos(1.0));
    let (x, v) = (0.8 - 0.7 * cos + 0.2 * sin, 0.7 * sin + 0.2 * cos);
    // With the drive, at half of its period.
    let (before, after) = ([v, 0.8 - x], [-0.5 * v, -0.8 - x]);
    let wanted = turned([
        0.5 * (before[0] - after[0]),
        0.5 * (-0.5 * before[1] - after[1]),
    ]);
    each(&with("t - P/2"), &["P"], 1.5, |found, method| {
        assert_close([found.transitions[0].t[0]], &[0.5], method);
        assert_close(found.states[0].iter().copied(), &wanted, method);
    });
    // At a fixed time the drive jumps before or after it. Start values move neither.
    let fixed = with("t - 1");
    assert_lost(&fixed, &["P"], [1.0, 1.5]);
    each(&fixed, &["x", "v"], 1.5, |found, method| {
        assert_close(found.transitions[0].t.iter().copied(), &[0.0, 0.0], method);
        let wanted = [turned([cos, 0.5 * sin]), turned([sin, -0.5 * cos])].concat();
        assert_close(found.states[0].iter().copied(), &wanted, method);
    });
}

/// The knot of a table where the rate of a jump's function changes: the time of the jump changes by
/// 1 to one side and by 1/2 to the other.
#[test]
fn a_jump_that_reads_a_table_at_its_knot_has_no_derivative() {
    let reads = system(
        "name = \"reads\"\n[states]\ny = \"\"\n[inputs.T]\nshape = \"table\"\n\
         times = [0, 1, 2]\nvalues = [0, 1, 3]\n[jumps.j]\nwhen = \"T - y\"\n\
         direction = \"rising\"\nset = { y = \"7*y\" }\n[field]\ny = \"0*y\"\n\
         [start]\ny = 1\n[time]\nend = 1.2\n",
    );
    assert_lost(&reads, &["y"], [1.0, 1.2]);
}
