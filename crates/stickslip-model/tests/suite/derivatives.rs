//! Derivatives of orbits through events, against closed forms and differences of runs.

use std::ops::ControlFlow;

use stickslip::analysis::OrbitDerivatives;
use stickslip::dynamics::{Moment, OrbitProgress, OrbitUnderWay, RecordedOrbit, Sampling};
use stickslip::{Error, Options, math};
use stickslip_model::file::System;
use stickslip_model::kernel::follow_on;
use stickslip_model::study::Variables;

use super::recorded::open;
use super::run::{METHODS, Run, options, system};

/// A block on a belt with static friction. It is hit each time at x = 1.1, and a discrete state
/// samples its velocity there. The period of its drive is a parameter.
const DRIVEN: &str = r#"
name = "case"
[time]
end = 12
[states]
x = ""
v = ""
[discrete]
last = 0
[parameters]
mu = 0.5
more = 0.2
speed = 0.3
T = 3.1
e = 0.7
[inputs.push]
shape = "triangle"
period = "T"
[contacts.belt]
boundary = "v - speed"
friction = "mu/(1 + belt*(v - speed))"
static = "mu + more"
[jumps.stop]
when = "x - 1.1"
direction = "rising"
set = { v = "-e*v", last = "v" }
[field]
x = "v"
v = "-x + 0.9*push + 0.1*last - friction(belt)"
[start]
x = 0.2
v = 0.9
"#;

/// Two blocks, one on the other.
const STACK: &str = r#"
name = "case"
[time]
end = 14
[states]
x = ""
v = ""
y = ""
w = ""
[parameters]
a = 0.2
b = 0.31
k = 1.3
[contacts.floor]
boundary = "v"
friction = "a"
[contacts.between]
boundary = "w - v"
friction = "b"
static = "1.4*b"
[field]
x = "v"
v = "-x + k*(y - x) - friction(floor) + friction(between)"
y = "w"
w = "-k*(y - x) + sin(0.9*t) - friction(between)"
[start]
x = 1.4
v = 0
y = -0.3
w = 0.4
"#;

pub fn found(system: &System, names: &[&str], times: &[f64], method: &str) -> OrbitDerivatives {
    let variables = Variables::named(system, names.iter().copied()).unwrap();
    let (t, x) = (system.built.t_start, system.start().unwrap());
    let t_end = *times.last().unwrap();
    let of = ((t, &x[..]), t_end);
    let found = variables.along(system, of, (times, &[]), &options(method));
    let mut found = found.unwrap();
    // Beside a run, a change of several contacts at one instant has a row for each.
    let beside = beside(system, &variables, t_end, &options(method));
    assert_eq!(beside.lost.is_some(), found.lost.is_some());
    found.transitions = beside.transitions;
    found
}

/// Derivatives of a run from the start of the file, carried beside it.
fn beside(
    system: &System,
    variables: &Variables,
    t_end: f64,
    options: &Options,
) -> OrbitDerivatives {
    let varied = variables.of(system).unwrap();
    let (t, x) = (system.built.t_start, system.start().unwrap().into());
    let start = Moment { t, x };
    let mut run = system
        .dynamics()
        .begin(&start, t_end, options, &[])
        .unwrap();
    let mut tangents = varied.tangents((&*run, &start), &[], options).unwrap();
    let mut orbit = RecordedOrbit::new(&start, Sampling::Nowhere, false);
    let mut watcher = |progress, run: &mut dyn OrbitUnderWay| {
        let is_step = matches!(progress, OrbitProgress::Step);
        tangents.event(&progress);
        orbit.take(progress, run);
        if is_step {
            tangents.step(&orbit, run);
        }
        ControlFlow::Continue(())
    };
    let ended = follow_on(&mut *run, &mut watcher);
    tangents.finish(&orbit, &ended)
}

/// Times of transitions, without the kinks of inputs.
fn transitions(run: &Run) -> Vec<f64> {
    let all = run.transitions.iter();
    let own = all.filter(|(_, kind, _)| !["kink", "switch"].contains(kind));
    own.map(|(t, ..)| *t).collect()
}

/// Times of transitions and the state at a time, from the start with one number changed.
fn changed(system: &System, name: &str, by: f64, t_end: f64) -> (Vec<f64>, Vec<f64>) {
    let parameter = system
        .file
        .parameters
        .iter()
        .position(|one| one.name == name);
    let state = system.file.states.iter().position(|one| one.name == name);
    let (mut t, mut x) = (system.built.t_start, system.start().unwrap());
    let mut values = Vec::new();
    match (parameter, state) {
        (Some(number), _) => values.push((name, system.values[number] + by)),
        (None, Some(state)) => x[state] += by,
        (None, None) => t += by,
    }
    let changed = system.with_values(&values).unwrap();
    let run = Run::from(changed, &options("taylor"), ((t, x), t_end));
    (transitions(&run), run.ended.unwrap().x.as_slice().to_vec())
}

/// Compares derivatives of states and of times of events with differences of order four.
fn compare(system: &System, names: &[&str], until: f64) -> usize {
    // Chosen: the rounding of a difference is about 1e-8, and its truncation less.
    const STEP: f64 = 2e-5;
    const CLOSE: f64 = 1e-6;
    let difference =
        |[one, two, three, four]: [f64; 4]| (8.0 * (two - three) - (one - four)) / (12.0 * STEP);
    let start = system.built.t_start;
    let times = [0.31, 0.67, 1.0].map(|part| start + part * (until - start));
    let mut events = 0;
    for method in METHODS {
        let found = found(system, names, &times, method);
        assert!(found.lost.is_none(), "{:?}", found.lost);
        for (column, name) in names.iter().enumerate() {
            let is_close = |own: f64, by_runs: f64, what: &str| {
                let off = (own - by_runs).abs();
                let is_close = off < CLOSE * own.abs().max(1.0);
                assert!(is_close, "{method}: {what} by {name}: {own} and {by_runs}");
            };
            for (k, &t) in times.iter().enumerate() {
                let places = [2.0, 1.0, -1.0, -2.0];
                let runs = places.map(|place| changed(system, name, place * STEP, t));
                for state in 0..system.states() {
                    let by_runs = difference(runs.each_ref().map(|(_, x)| x[state]));
                    let what = format!("state {state} at {t}");
                    is_close(found.states[k][(state, column)], by_runs, &what);
                }
                if k < 2 {
                    continue;
                }
                for (times, _) in &runs {
                    assert_eq!(times.len(), found.transitions.len(), "{name}");
                }
                for (number, event) in found.transitions.iter().enumerate() {
                    let by_runs = difference(runs.each_ref().map(|(times, _)| times[number]));
                    is_close(event.t[column], by_runs, &format!("event at {}", event.at));
                    events += 1;
                }
            }
        }
    }
    events
}

#[test]
fn derivatives_are_those_of_differences_on_all_shipped_systems() {
    let mut events = 0;
    for (name, by, until) in [
        ("belt", &["mu0", "delta", "vp", "x", "t0"][..], 21.0),
        ("leine", &["x", "v", "t0"], 14.0),
        ("basins", &["x", "v", "t0"], 12.0),
        ("den-hartog", &["S", "O", "x"], 9.0),
        ("forced", &["mu0", "vp", "A", "omega", "t0"], 3.0),
    ] {
        events += compare(&open(name), by, until);
    }
    assert!(events > 100, "{events}");
}

#[test]
fn derivatives_are_those_of_forty_digits() {
    // Chosen: some hundred tolerances, times the growth of an error along the orbit.
    const CLOSE: f64 = 1e-9;
    let mut compared = 0;
    for row in include_str!("../data/derivatives.csv").lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let (system, name) = (open(cells[0]), cells[1]);
        let until = if cells[0] == "belt" { 12.0 } else { 14.0 };
        for method in METHODS {
            let found = found(&system, &[name], &[until], method);
            assert!(found.lost.is_none(), "{row}: {:?}", found.lost);
            assert_eq!(found.transitions.len().to_string(), cells[2], "{row}");
            let last = found.transitions.last().unwrap().t[0];
            let own = [last, found.states[0][(0, 0)], found.states[0][(1, 0)]];
            for (own, wanted) in own.into_iter().zip(&cells[3..]) {
                let wanted: f64 = wanted.parse().unwrap();
                let off = (own - wanted).abs();
                assert!(
                    off < CLOSE * wanted.abs().max(1.0),
                    "{method}, {row}: {own}"
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 2 * 3 * 7);
}

#[test]
fn derivatives_pass_jumps_samples_inputs_static_friction_and_several_contacts() {
    let driven = system(DRIVEN);
    let by = ["mu", "more", "speed", "T", "e", "x", "v"];
    assert!(compare(&driven, &by, 11.0) > 100);
    // Blows that are slow enough do nothing, and friction is a table.
    let gated = DRIVEN
        .replace(
            "[jumps.stop]\n",
            "[jumps.stop]\nif = \"v > 0.2 and last < 10\"\n",
        )
        .replace("mu/(1 + belt*(v - speed))", "mu*law(belt*(v - speed))")
        .replace(
            "[contacts.belt]",
            "[curves.law]\npoints = [[0, 1], [0.4, 0.8], [2, 0.5]]\nbetween = \"monotone\"\n\
             beyond = \"extend\"\n[contacts.belt]",
        );
    assert!(compare(&system(&gated), &by, 11.0) > 50);
    let stack = system(STACK);
    assert!(compare(&stack, &["a", "b", "k", "x", "y", "w", "t0"], 11.0) > 60);
}

/// A ball from height h under gravity g: with T = √(2h/g) it bounces at T (1 + 2e + 2e² + …).
#[test]
fn times_of_bounces_have_the_derivatives_of_their_formula() {
    let text = "name = \"ball\"\n[states]\nh = \"\"\nu = \"\"\n[parameters]\ng = 9.81\ne = 0.8\n\
        [jumps.floor]\nwhen = \"h\"\ndirection = \"falling\"\nset = { u = \"-e*u\" }\n\
        [field]\nh = \"u\"\nu = \"-g\"\n[start]\nh = 1.5\nu = 0\n[time]\nend = 4\n";
    let (h, g, e) = (1.5_f64, 9.81, 0.8_f64);
    for method in METHODS {
        let found = found(&system(text), &["h", "g", "e"], &[2.0], method);
        let first = (2.0 * h / g).sqrt();
        let (mut factor, mut by_e) = (1.0, 0.0);
        assert!(found.transitions.len() >= 2);
        for (bounce, event) in found.transitions.iter().enumerate() {
            if bounce > 0 {
                let power = bounce as i32;
                factor += 2.0 * math::powi(e, power);
                by_e += 2.0 * f64::from(power) * math::powi(e, power - 1);
            }
            let exact = [
                first * factor / (2.0 * h),
                -first * factor / (2.0 * g),
                first * by_e,
            ];
            for (own, exact) in event.t.iter().zip(exact) {
                assert!((own - exact).abs() < 1e-11, "{method}: {own} {exact}");
            }
            // The height there stays zero, whatever changes.
            assert!(event.before.row(0).amax() < 1e-12 && event.after.row(0).amax() < 1e-12);
        }
    }
}

/// The orbit with parameters as states takes the steps of the orbit itself.
#[test]
fn parameters_as_states_change_no_step() {
    let names = ["belt", "leine", "basins", "den-hartog", "forced", "bracket"];
    for one in names
        .map(open)
        .into_iter()
        .chain([DRIVEN, STACK].map(system))
    {
        let all: Vec<usize> = (0..one.file.parameters.len()).collect();
        let extended = one.with_states_of(&all).unwrap();
        let (t, x) = (one.built.t_start, one.start().unwrap());
        let mut longer = x.clone();
        longer.extend(&one.values);
        for method in METHODS {
            let (options, t_end) = (options(method), t + 10.0);
            let end = |of: &_, x: &[f64]| {
                let ignore = &mut stickslip_model::kernel::ignore;
                stickslip_model::kernel::follow(of, (t, x), t_end, &options, &[], ignore).unwrap()
            };
            let (plain, with) = (end(one.dynamics(), &x), end(&extended, &longer));
            assert_eq!(
                plain.counters.steps, with.counters.steps,
                "{}",
                one.file.name
            );
            let off = (with.x.rows(0, x.len()) - &plain.x).amax();
            assert!(off < 1e-11, "{}: {off}", one.file.name);
        }
    }
}

#[test]
fn where_there_is_none_or_the_name_is_wrong_it_is_said() {
    // A turning point at the boundary, to the tolerance.
    let graze = system(
        "name = \"graze\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\np = 0.3\n[contacts.c]\n\
         boundary = \"x - 0.9999999999999\"\n[field]\nx = \"v\"\nv = \"by_side(c, -x, -x - p)\"\n\
         [start]\nx = 0\n\
         v = 1\n[time]\nend = 9\n",
    );
    let lost = found(&graze, &["p", "x"], &[1.0, 3.0], "taylor");
    let Some(Error::TangentSingular { t, .. }) = lost.lost else {
        panic!("{:?}", lost.lost);
    };
    assert!((t - 0.5 * std::f64::consts::PI).abs() < 1e-5, "{t}");
    assert!(lost.states[0].iter().all(|of| of.is_finite()));
    assert!(lost.states[1].iter().all(|of| of.is_nan()));
    let driven = system(DRIVEN);
    for (name, said) in [
        ("", "a name is empty"),
        ("spede", "did you mean `speed`?"),
        ("belt", "neither a parameter nor a state"),
    ] {
        let error = Variables::named(&driven, [name]).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    // One that samples carries what it has sampled; one that counts has no derivative.
    assert!(Variables::named(&driven, ["last"]).is_ok());
    let counts = system(&DRIVEN.replace("last = \"v\"", "last = \"last + 1\""));
    let counted = Variables::named(&counts, ["last"]).unwrap_err().to_string();
    assert!(counted.contains("a discrete state"), "{counted}");
    let twice = Variables::named(&driven, ["x", "x"]).unwrap_err();
    assert_eq!(twice.to_string(), "`x` is given twice");
}

/// A ball that rises to 4 and turns there: whether it passes is rounding, and so is what follows.
#[test]
fn a_turn_exactly_at_a_boundary_or_a_jump_is_a_graze() {
    let text = |event: &str, rate: &str| {
        system(&format!(
            "name = \"graze\"\n[states]\nh = \"\"\nw = \"\"\n{event}\n[field]\nh = \"w\"\n\
             w = \"{rate}\"\n[start]\nh = 0\nw = 8\n[time]\nend = 1.5\n"
        ))
    };
    let boundary = text("[contacts.c]\nboundary = \"h - 4\"", "by_side(c, -8, -10)");
    let jump = text(
        "[jumps.c]\nwhen = \"h - 4\"\ndirection = \"rising\"\nset = { w = \"-w\" }",
        "-8",
    );
    for method in METHODS {
        for graze in [&boundary, &jump] {
            let lost = found(graze, &["h", "w"], &[0.7, 1.3], method);
            let Some(Error::TangentSingular { t, .. }) = lost.lost else {
                panic!("{method}: {:?}", lost.lost);
            };
            assert!((t - 1.0).abs() < 1e-6, "{t}");
            assert!(lost.states[0].iter().all(|of| of.is_finite()));
            assert!(lost.states[1].iter().all(|of| of.is_nan()));
        }
        // Below by more than the tolerance, there is nothing.
        let below = text(
            "[contacts.c]\nboundary = \"h - 4.000001\"",
            "by_side(c, -8, -10)",
        );
        let below = found(&below, &["h", "w"], &[0.7, 1.3], method);
        assert!(below.lost.is_none() && (below.states[1][(0, 1)] - 1.3).abs() < 1e-12);
    }
}

/// A block at rest is released by an input: at its kink the mode changes, and a parameter moves the
/// kink. A wall reverses a velocity, and with it friction.
#[test]
fn derivatives_pass_modes_that_change_at_kinks_and_at_jumps() {
    let block = |input: &str, parameters: &str, contact: &str, rate: &str| {
        system(&format!(
            "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nmu = 0.5\n{parameters}\n\
             {input}\n[contacts.b]\n{contact}\n[field]\nx = \"v\"\nv = \"{rate}\"\n\
             [start]\nx = 0\nv = 0\n[time]\nstart = 1\nend = 8\n"
        ))
    };
    let on_floor = "boundary = \"v\"\nfriction = \"mu\"";
    let pulse = "[inputs.u]\nshape = \"pulse\"\nperiod = \"T\"\nwidth = 0.4";
    let pushed = block(pulse, "T = 2", on_floor, "u - friction(b)");
    // Released at T with acceleration 1/2, and at rest again at 1.8 T.
    let found_by = |method: &str| found(&pushed, &["T", "mu"], &[2.7, 3.9], method);
    for method in METHODS {
        let found = found_by(method);
        let exact = [[-0.35, -0.245], [-0.5, -0.7]];
        for (state, exact) in exact.iter().enumerate() {
            for (column, exact) in exact.iter().enumerate() {
                let own = found.states[0][(state, column)];
                assert!((own - exact).abs() < 1e-9, "{method}: {own} {exact}");
            }
        }
        let [exit, entry] = [0, 1].map(|number| &found.transitions[number]);
        assert!((exit.t[0] - 1.0).abs() < 1e-9 && (entry.t[0] - 1.8).abs() < 1e-9);
        assert!(exit.after.row(1).amax() < 1e-9, "{}", exit.after);
    }
    assert!(compare(&pushed, &["T", "mu", "x"], 7.0) > 10);
    let switch = "[switches.s]\nfunction = \"sin(om*t)\"";
    let switched = block(switch, "om = 1.3", on_floor, "0.8*s - friction(b)");
    assert!(compare(&switched, &["om", "mu"], 6.0) > 6);
    let on_belt = "boundary = \"v - vb*u\"\nfriction = \"mu\"";
    let stepped = block(pulse, "T = 2\nvb = 0.3", on_belt, "-x - friction(b)");
    assert!(compare(&stepped, &["T", "vb", "mu"], 6.3) > 6);

    let wall = system(
        "name = \"wall\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nmu = 0.2\nr = 0.8\nw = 0.4\n\
         [contacts.fl]\nboundary = \"v\"\nfriction = \"mu\"\n\
         [jumps.wall]\nwhen = \"x - w\"\ndirection = \"rising\"\nset = { v = \"-r*v\" }\n\
         [field]\nx = \"v\"\nv = \"cos(1.1*t) - 0.3*x - friction(fl)\"\n[start]\nx = 0\nv = 1\n\
         [time]\nend = 9\n",
    );
    assert!(compare(&wall, &["mu", "r", "w", "x", "v"], 8.0) > 20);
}

/// Impacts that accumulate are impacts to the last, and a jump at a turning point is a graze.
#[test]
fn short_flights_are_no_chain_of_jumps_and_a_jump_at_a_turning_point_has_none() {
    let text = |when: &str| {
        format!(
            "name = \"ball\"\n[states]\nh = \"\"\nu = \"\"\n[parameters]\ng = 10\ne = 0.5\n\
             [jumps.floor]\nwhen = \"{when}\"\nset = {{ u = \"-e*u\" }}\n\
             [field]\nh = \"u\"\nu = \"-g\"\n[start]\nh = 5\nu = 0\n[time]\nend = 4\n"
        )
    };
    let ball = system(&text("h").replace("when", "direction = \"falling\"\nwhen"));
    let found_by = |system: &System, t: f64| found(system, &["g", "h"], &[t], "taylor");
    let bouncing = found_by(&ball, 2.999);
    assert!(bouncing.lost.is_none(), "{:?}", bouncing.lost);
    assert!(bouncing.transitions.len() > 9);
    for event in &bouncing.transitions {
        // Every time is that of the first impact, scaled.
        assert!((event.t[0] / event.at + 0.05).abs() < 1e-8, "{event:?}");
        assert!((event.t[1] / event.at - 0.1).abs() < 1e-8, "{event:?}");
    }
    let turning = system(
        "name = \"turn\"\n[states]\nh = \"\"\nu = \"\"\n[jumps.top]\nwhen = \"h - 1\"\n\
         direction = \"rising\"\nset = { u = \"-0.5*u\" }\n[field]\nh = \"u\"\nu = \"-2\"\n\
         [start]\nh = 1e-13\nu = 2\n[time]\nend = 3\n",
    );
    let lost = found(&turning, &["h"], &[0.5, 2.0], "taylor");
    let Some(Error::TangentSingular { t, .. }) = lost.lost else {
        panic!("{:?}", lost.lost);
    };
    assert!(
        (t - 1.0).abs() < 1e-6 && lost.states[1].iter().all(|of| of.is_nan()),
        "{t}"
    );
}

/// Two inputs switch at 2: one of period `T`, after its first period, and one of period `S`.
#[test]
fn kinks_of_two_inputs_at_one_instant_have_derivatives_where_their_order_is_nothing() {
    let of = |field: &str| {
        system(&format!(
            "name = \"kinks\"\n[states]\nx = \"\"\n[parameters]\nT = 2\nS = 4\n[inputs.p]\n\
             shape = \"square\"\nperiod = \"T\"\n[inputs.q]\nshape = \"square\"\n\
             period = \"S\"\n[field]\nx = \"{field}\"\n[start]\nx = 0\n[time]\nend = 2.5\n"
        ))
    };
    for method in METHODS {
        // A period longer by d moves the switches of p by d/2 and d, and that of q by d/2.
        let sum = found(&of("p + 3*q"), &["T", "S"], &[1.5, 2.5], method);
        assert!(sum.lost.is_none());
        let off = |row: usize, exact: [f64; 2]| {
            let states = &sum.states[row];
            (states[(0, 0)] - exact[0]).abs() + (states[(0, 1)] - exact[1]).abs()
        };
        assert!(off(0, [1.0, 0.0]) < 1e-12 && off(1, [-1.0, 3.0]) < 1e-12);
        // Of p*q the two sides are -1 and 3 by T, and -1 and 1 by S.
        for by in [&["T", "S"][..], &["T"], &["S"]] {
            let product = found(&of("p*q"), by, &[1.5, 2.5], method);
            let Some(Error::SimultaneousEvents { t, .. }) = product.lost else {
                panic!("{method}: {:?}", product.lost);
            };
            assert!((t - 2.0).abs() < 1e-12);
            assert!(product.states[0].iter().all(|of| of.is_finite()));
            assert!(product.states[1].iter().all(|of| of.is_nan()));
        }
        // Nothing moves the switches by the start.
        let start = found(&of("p*q"), &["x"], &[2.5], method);
        assert!(start.lost.is_none() && (start.states[0][(0, 0)] - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_start_on_what_moves_is_taken_along_by_it() {
    // A later start on the table does not change the motion that the table imposes, nor where it
    // throws the ball.
    let carried = r#"
name = "case"
[states]
h = ""
v = ""
[field]
h = "v"
v = "-1"
[stops.table]
gap = "h - 1.5*sin(t)"
acts = { v = 1 }
restitution = 0.5
[start]
h = "1.5*sin(0.25)"
v = "1.5*cos(0.25)"
table.closed = 1
[time]
start = 0.25
end = 4
"#;
    // The belt takes the block along, which rests on it.
    let stuck = r#"
name = "case"
[states]
x = ""
v = ""
[contacts.belt]
boundary = "v - sin(t)"
friction = 5
[field]
x = "v"
v = "-x - friction(belt)"
[start]
x = 0.1
v = "sin(0.25)"
[time]
start = 0.25
end = 4
"#;
    for method in METHODS {
        let of = found(&system(carried), &["t0"], &[0.25, 0.5, 2.0, 4.0], method);
        assert!(of.lost.is_none(), "{:?}", of.lost);
        for by in &of.states {
            assert!(by.amax() < 1e-12, "{method}: {by}");
        }
        assert!(of.transitions[0].t[0].abs() < 1e-12, "{method}");
        for by in found(&system(stuck), &["t0"], &[0.25, 0.5, 1.0], method).states {
            let exact = [-math::sin(0.25), 0.0];
            for (found, exact) in by.iter().zip(exact) {
                assert!((found - exact).abs() < 1e-12, "{method}: {by}");
            }
        }
    }
}

#[test]
fn a_plastic_impact_at_another_event_leaves_no_speed_off_the_stop() {
    // A body lands on a floor in the instant in which a block crosses a boundary.
    let joint = r#"
name = "case"
[states]
h = ""
v = ""
u = ""
[parameters]
e = 0
[contacts.belt]
boundary = "u"
friction = 0.5
[field]
h = "v"
v = "-1"
u = "1 - friction(belt)"
[stops.floor]
gap = "h"
acts = { v = 1 }
restitution = "e"
[start]
h = 1
v = 0
u = "-1.5*sqrt(2)"
[time]
end = 3
"#;
    for method in METHODS {
        for names in [&["e"][..], &["e", "h"], &["h", "u", "e"]] {
            let of = found(&system(joint), names, &[2.0, 3.0], method);
            assert!(of.lost.is_none(), "{:?}", of.lost);
            for by in &of.states {
                for state in [0, 1] {
                    let row = by.row(state);
                    assert!(row.amax() < 1e-12, "{method}, {names:?}: {by}");
                }
            }
        }
    }
}
