//! Stops: impacts, rest, reactions and lift-off, against closed forms and 25-digit references.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use numerics::SplitMix;
use stickslip::dynamics::{Modes, OrbitProgress, OrbitUnderWay};
use stickslip::{Ending, Error, Mode, Side, math};
use stickslip_model::file::{Source, SystemFile};
use stickslip_model::kernel::follow;
use stickslip_model::study::Variables;

use super::run::{METHODS, Run, options, orbit, parsed, real_multipliers, system, with};

/// A ball on a floor, with the integral of its squared speed.
const BALL: &str = r#"name = "Ball"
[states]
h = ""
v = ""
s = ""
[parameters]
g = 1
e = 0.5
[field]
h = "v"
v = "-g"
s = "v^2"
[stops.floor]
gap = "h"
acts = { v = 1 }
restitution = "e"
[start]
h = 1
v = 0
s = 0
[time]
end = 40
"#;

/// A ball on a table that shakes; the table throws it where `A sin t = g`.
const TABLE: &str = r#"name = "Ball on a shaken table"
[states]
h = ""
v = ""
[parameters]
A = 1.5
e = 0.5
[field]
h = "v"
v = "-1"
[stops.table]
gap = "h - A*sin(t)"
acts = { v = 1 }
restitution = "e"
[start]
h = 0
v = "A"
[time]
end = 20
period = "2*pi"
"#;

/// A rod of length 2 and mass 1 falls on its tip, with friction that follows the reaction.
const ROD: &str = r#"name = "Falling rod"
[states]
x = ""
y = ""
th = ""
u = ""
w = ""
om = ""
[parameters]
mu = 0.3
g = 9.81
[contacts.tip]
boundary = "u + om*sin(th)"
friction = "mu*floor.force"
[stops.floor]
gap = "y - sin(th)"
acts = { w = 1, om = "-3*cos(th)" }
restitution = 0
[jumps.flat]
when = "th - 0.1"
direction = "falling"
stop = true
[field]
x = "u"
y = "w"
th = "om"
u = "-friction(tip)"
w = "-g"
om = "-3*friction(tip)*sin(th)"
[start]
x = 0
y = "sin(1.4)"
th = 1.4
u = 0
w = 0
om = 0
[time]
end = 3
"#;

/// Times of the events of one name.
fn times(run: &Run, name: &str) -> Vec<f64> {
    let all = run.transitions.iter();
    all.filter(|(_, _, of)| of == name)
        .map(|(t, ..)| *t)
        .collect()
}

fn close(found: f64, exact: f64, within: f64, what: &str) {
    assert!(
        (found - exact).abs() <= within,
        "{what}: {found}, exactly {exact}"
    );
}

#[test]
fn a_ball_comes_to_rest_where_its_impacts_accumulate() {
    let fall = 2.0_f64.sqrt();
    for method in METHODS {
        for e in [0.2, 0.5, 0.9] {
            let run = Run::of(with(BALL, &[("e", e)]), &options(method), None);
            assert_eq!(run.ending(), Ending::EndTime);
            let landings = times(&run, "floor.landing");
            let exact = fall * (1.0 + e) / (1.0 - e);
            assert_eq!(landings.len(), 1, "{method}, {e}");
            close(landings[0], exact, 1e-12 * exact, method);
            let state = ["h", "v", "floor.closed"].map(|name| run.end(name));
            assert_eq!(state, [0.0, 0.0, 1.0], "{method}, {e}");
            // Of each flight between two impacts, 2 v³/3 of the integral.
            let cubes = math::powi(e, 3);
            let exact = math::powi(fall, 3) / 3.0 * (1.0 + 2.0 * cubes / (1.0 - cubes));
            close(run.end("s"), exact, 1e-11, method);
        }
    }
}

#[test]
fn a_plastic_impact_and_a_start_at_rest_close_at_once() {
    for method in METHODS {
        let run = Run::of(with(BALL, &[("e", 0.0)]), &options(method), None);
        let names: Vec<&str> = run.transitions.iter().map(|(.., of)| of.as_str()).collect();
        assert_eq!(names, ["floor.impact"], "{method}");
        assert_eq!(
            [run.end("h"), run.end("v"), run.end("floor.closed")],
            [0.0, 0.0, 1.0]
        );
        // At rest, or nearly: rounding is all that is left of a run before.
        for small in [0.0, 1e-17, -1e-17] {
            let start = (0.0, vec![small, -small, 0.0, 0.0]);
            let run = Run::from(system(BALL), &options(method), (start, 5.0));
            let (t, _, name) = run.transitions.last().unwrap();
            assert_eq!(name, "floor.landing", "{method}");
            // It falls from 1e-17 in 4e-9.
            close(*t, 0.0, 2e-8, method);
            close(run.end("h"), 0.0, 1e-15, method);
            assert_eq!(run.end("floor.closed"), 1.0);
        }
    }
}

#[test]
fn a_start_says_whether_a_stop_carries() {
    let at_rest = BALL.replace("h = 1\nv = 0\ns = 0", "h = 0\nv = 0\ns = 0\nCLOSED");
    for closed in ["floor.closed = 1", "\"floor.closed\" = 1.0"] {
        let run = Run::of(
            system(&at_rest.replace("CLOSED", closed)),
            &options("taylor"),
            None,
        );
        assert_eq!(run.transitions, []);
        assert_eq!(run.end("floor.closed"), 1.0);
    }
    for (closed, message) in [
        ("floor = 1", "there is no state `floor`; `floor` is a stop"),
        ("floor.open = 1", "has no entry `open`"),
        (
            "\"floor.open\" = 1",
            "there is no state `floor.open`; `floor` is a stop",
        ),
        (
            "floor.closed = 0.5",
            "is 0, or 1 where the stop carries, and not 0.5",
        ),
        ("floor.closed = true", "a number is expected here"),
    ] {
        let source = stickslip_model::file::Source {
            name: "ball.toml".to_owned(),
            text: at_rest.replace("CLOSED", closed),
        };
        let error = stickslip_model::file::SystemFile::parse(source).unwrap_err();
        assert!(error.to_string().contains(message), "{closed}: {error}");
    }
    let start = (0.0, vec![1.0, 0.0, 0.0, 0.5]);
    let run = Run::from(system(BALL), &options("taylor"), (start, 5.0));
    assert!(
        matches!(run.ended, Err(Error::Parameter { value: 0.5, .. })),
        "{:?}",
        run.ended
    );
}

#[test]
fn no_run_starts_behind_a_stop() {
    let start = (0.0, vec![-0.25, 1.0, 0.0, 0.0]);
    let run = Run::from(system(BALL), &options("taylor"), (start, 5.0));
    assert!(matches!(
        run.ended,
        Err(Error::BehindStop { gap: -0.25, .. })
    ));
    let words = run.words();
    assert!(
        words.contains("the gap of the stop `floor` is -0.25 at t = 0"),
        "{words}"
    );
}

#[test]
fn a_shaken_table_throws_a_ball_again_and_again() {
    const THROW: f64 = 0.729_727_656_226_966_4;
    const REST: f64 = 5.900_110_844_260_1;
    for method in METHODS {
        let run = Run::of(system(TABLE), &options(method), Some(200.0 * PI));
        let (thrown, mut landed) = (times(&run, "table.lift-off"), times(&run, "table.landing"));
        // It starts at rest on the table.
        assert_eq!(landed.remove(0), 0.0);
        assert_eq!(thrown.len(), 100, "{method}");
        for (number, (thrown, landed)) in thrown.iter().zip(&landed).enumerate() {
            let periods = 2.0 * PI * number as f64;
            close(*thrown - periods, THROW, 1e-12 * (1.0 + periods), method);
            // The time of an accumulation is extrapolated, by Aitken's rule. Its ratio varies here,
            // and rounding of time moves an impact by as much over its speed.
            close(*landed - periods, REST, 2e-9 * (1.0 + periods), method);
        }
    }
}

#[test]
fn chatter_annihilates_gap_and_rate() {
    let text = TABLE.replace("A = 1.5", "A = 1.2");
    let found = orbit(&system(&text), &options("taylor"));
    close(found.period, 2.0 * PI, 1e-9, "period");
    let multipliers = real_multipliers(&found);
    assert!(
        multipliers.iter().all(|m| m.abs() < 1e-6),
        "{multipliers:?}"
    );
}

#[test]
fn derivatives_pass_impacts_that_accumulate() {
    let system = system(BALL);
    let variables = Variables::named(&system, ["e", "g", "h"]).unwrap();
    for method in METHODS {
        let start = system.start().unwrap();
        let of = ((0.0, &start[..]), 10.0);
        let found = variables.along(&system, of, (&[10.0], &[]), &options(method));
        let found = found.unwrap();
        assert!(found.lost.is_none(), "{:?}", found.lost);
        let e: f64 = 0.5;
        let cubes = math::powi(e, 3);
        // The integral is V³/(3 g) (1 + 2 e³/(1 − e³)), with V² = 2 g h.
        let (speed, sum) = (2.0_f64.sqrt(), 1.0 + 2.0 * cubes / (1.0 - cubes));
        let scale = math::powi(speed, 3) / 3.0;
        let exact = [
            scale * 6.0 * e * e / math::powi(1.0 - cubes, 2),
            0.5 * scale * sum,
            1.5 * scale * sum,
        ];
        for (column, exact) in exact.into_iter().enumerate() {
            close(found.states[0][(2, column)], exact, 1e-7, method);
            close(found.states[0][(0, column)], 0.0, 1e-7, method);
            close(found.states[0][(1, column)], 0.0, 1e-7, method);
        }
    }
}

#[test]
fn a_restitution_depends_on_the_approach() {
    let text = BALL.replace("\"e\"", "\"exp(-approach)\"");
    for method in METHODS {
        let speed = 2.0_f64.sqrt();
        let run = Run::of(system(&text), &options(method), Some(speed + 1e-3));
        close(
            run.end("v"),
            speed * math::exp(-speed) - 1e-3,
            1e-13,
            method,
        );
    }
    let run = Run::of(
        system(&BALL.replace("\"e\"", "\"approach\"")),
        &options("taylor"),
        None,
    );
    let words = run.words();
    assert!(
        words.contains("`restitution` of [stops.floor] is not between 0 and 1"),
        "{words}"
    );
}

/// Three balls of mass 1 on a line, the first with speed 1.
fn balls(gap: f64) -> String {
    format!(
        r#"name = "balls"
[states]
x = ""
y = ""
z = ""
u = ""
v = ""
w = ""
[field]
x = "u"
y = "v"
z = "w"
u = 0
v = 0
w = 0
[stops.left]
gap = "y - x"
acts = {{ u = -1, v = 1 }}
restitution = 1
[stops.right]
gap = "z - y"
acts = {{ v = -1, w = 1 }}
restitution = 1
[start]
x = 0
y = {gap}
z = "2*{gap}"
u = 1
v = 0
w = 0
[time]
end = 1
"#
    )
}

#[test]
fn newtons_rule_holds_where_several_stops_touch() {
    for method in METHODS {
        let speeds = |gap: f64| {
            let run = Run::of(system(&balls(gap)), &options(method), None);
            ["u", "v", "w"].map(|name| run.end(name))
        };
        let touching = [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
        for (found, exact) in speeds(0.0).into_iter().zip(touching) {
            close(found, exact, 1e-15, method);
        }
        for (found, exact) in speeds(1e-9).into_iter().zip([0.0, 0.0, 1.0]) {
            close(found, exact, 1e-15, method);
        }
    }
}

#[test]
fn friction_follows_the_reaction_of_a_table() {
    // The normal force is g − A sin t, so that the speed is v₀ − μ (g t + A (cos t − 1)).
    let text = r#"name = "block"
[states]
x = ""
v = ""
h = ""
u = ""
[parameters]
A = 0.6
mu = 0.1
[contacts.base]
boundary = "v"
friction = "mu*table.force"
[stops.table]
gap = "h - A*sin(t)"
acts = { u = 1 }
restitution = 0
[field]
x = "v"
v = "-friction(base)"
h = "u"
u = "-1"
[start]
x = 0
v = 1
h = 0
u = "A"
[time]
end = 8
"#;
    for method in METHODS {
        let run = Run::of(system(text), &options(method), None);
        let exact = 1.0 - 0.1 * (8.0 + 0.6 * (math::cos(8.0) - 1.0));
        close(run.end("v"), exact, 1e-11, method);
        close(run.end("h"), 0.6 * math::sin(8.0), 1e-11, method);
        let run = Run::of(system(text), &options(method), Some(20.0));
        let entry = run
            .transitions
            .iter()
            .find(|(_, kind, _)| *kind == "stick entry");
        let (t, ..) = entry.expect("it stops");
        close(
            1.0 - 0.1 * (t + 0.6 * (math::cos(*t) - 1.0)),
            0.0,
            1e-11,
            method,
        );
        assert_eq!(run.end("v"), 0.0);
    }
}

#[test]
fn a_rod_falls_on_its_tip_with_friction() {
    for method in METHODS {
        let run = Run::of(system(ROD), &options(method), None);
        assert_eq!(run.ending(), Ending::Stopped, "{:?}", run.transitions);
        let changes: Vec<f64> = run
            .transitions
            .iter()
            .filter(|(t, _, name)| name == "tip" && *t > 0.0)
            .map(|(t, ..)| *t)
            .collect();
        close(changes[0], 0.568_937_216_180_9, 1e-9, method);
        close(changes[1], 0.894_134_747_020_7, 1e-9, method);
        close(
            run.ended.as_ref().unwrap().t,
            1.064_408_995_112_0,
            1e-9,
            method,
        );
    }
}

#[test]
fn friction_that_undoes_a_reaction_ends_the_run_by_name() {
    // A unit of the reaction opens the gap by 1 + 3 cos² th − 3 mu cos th sin th.
    let (mu, tangent) = (1.5, 0.5 * (4.5 + (4.5_f64 * 4.5 - 16.0).sqrt()));
    let exact = math::atan2(tangent, 1.0);
    for method in METHODS {
        for (start, from) in [("1.4", 1.4), ("pi - 1.4", PI - 1.4)] {
            // It begins to slip against friction, or in its direction.
            for speed in [-1.0, 1.0] {
                let text = ROD
                    .replace("sin(1.4)", &format!("sin({start})"))
                    .replace("th = 1.4", &format!("th = \"{start}\""))
                    .replace("u = 0", &format!("u = {speed}"));
                let run = Run::of(with(&text, &[("mu", mu)]), &options(method), None);
                let (_, x) = run.ended.as_ref().unwrap_err().place().unwrap();
                let leant = x.0[2].min(PI - x.0[2]);
                close(leant, exact, 1e-6, &format!("{method}, {from}, {speed}"));
                let words = run.words();
                assert!(
                    words.contains("no motion in contact is consistent"),
                    "{words}"
                );
                assert!(words.contains("the stop `floor`"), "{words}");
            }
        }
        // Beyond that angle the rod cannot slide towards its upper end.
        let text = ROD.replace("1.4", "1.2").replace("u = 0", "u = 1");
        let run = Run::of(with(&text, &[("mu", mu)]), &options(method), None);
        assert!(run.words().contains("(Painlevé)"), "{}", run.words());
    }
}

/// The pressure relief valve of the benchmark of event-driven ensembles.
#[test]
fn a_valve_chatters_to_its_seat_and_lifts_off() {
    let text = r#"name = "valve"
[states]
y = ""
v = ""
p = ""
[parameters]
q = 0.2
[stops.seat]
gap = "y"
acts = { v = 1 }
restitution = 0.8
[field]
y = "v"
v = "-1.25*v - (y + 10) + p"
p = "20*(q - y*sqrt(p))"
[start]
y = 0.2
v = 0
p = 1e-300
[time]
end = 3
"#;
    let run = Run::of(system(text), &options("dop853"), None);
    let (rest, lift) = (times(&run, "seat.landing"), times(&run, "seat.lift-off"));
    close(rest[0], 1.602_522_1, 1e-6, "rest");
    close(lift[0], 2.765_040_5, 1e-6, "lift-off");
}

#[test]
fn gaps_stay_open_and_energy_never_rises() {
    let mut random = SplitMix::new(67);
    let mut draw = |low: f64, high: f64| random.between(low, high);
    // STICKSLIP_DRAWS=1000 draws more.
    let draws = std::env::var("STICKSLIP_DRAWS").ok();
    let draws = draws.and_then(|draws| draws.parse().ok()).unwrap_or(30);
    for number in 0..draws {
        // Two masses hang on springs between a floor and each other.
        let (m, e, k) = (draw(0.5, 2.0), draw(0.0, 0.95), draw(0.5, 3.0));
        let (x, y) = (draw(0.1, 0.5), draw(0.6, 1.5));
        let (u, v) = (draw(-1.0, 1.0), draw(-1.0, 1.0));
        let text = format!(
            r#"name = "masses"
[states]
x = ""
y = ""
u = ""
v = ""
[stops.floor]
gap = "x"
acts = {{ u = 1 }}
restitution = {e}
[stops.between]
gap = "y - x"
acts = {{ u = -1, v = "1/{m}" }}
restitution = {e}
[field]
x = "u"
y = "v"
u = "-1 - 0.1*u"
v = "-1 - {k}*(y - 1)/{m}"
[start]
x = {x}
y = {y}
u = {u}
v = {v}
[time]
end = 12
"#
        );
        for method in METHODS {
            let energy = |x: f64, y: f64, u: f64, v: f64| {
                0.5 * (u * u + m * v * v) + x + m * y + 0.5 * k * (y - 1.0) * (y - 1.0)
            };
            let (mut before, mut least) = (energy(x, y, u, v), f64::INFINITY);
            for part in 1..=24 {
                let run = Run::of(system(&text), &options(method), Some(0.5 * f64::from(part)));
                if let Err(error) = &run.ended {
                    panic!("{method}, {number}: {error}\n{text}");
                }
                let [x, y, u, v] = ["x", "y", "u", "v"].map(|name| run.end(name));
                least = least.min(x).min(y - x);
                let now = energy(x, y, u, v);
                assert!(
                    now <= before + 1e-10,
                    "{method}, {number}: {before} to {now}\n{text}"
                );
                before = now;
            }
            assert!(least >= -1e-11, "{method}, {number}: {least}\n{text}");
        }
    }
}

/// Replacements in the ball that are refused: old text, new text, a part of the message.
const WRONG: [[&str; 3]; 13] = [
    ["gap = \"h\"", "gap = \"v\"", "acts on its gap's rate"],
    ["gap = \"h\"", "gap = \"h^2\"", "vanishes where it closes"],
    [
        "gap = \"h\"",
        "gap = \"1 - cos(h - g)\"",
        "vanishes where it closes",
    ],
    ["gap = \"h\"", "gap = \"abs(h)\"", "is not smooth in time"],
    [
        "acts = { v = 1 }",
        "acts = { s = 1 }",
        "does not move its gap",
    ],
    ["acts = { v = 1 }", "acts = { v = -1 }", "but must open it"],
    [
        "acts = { v = 1 }",
        "acts = { v = -1 }",
        "draws the bodies together",
    ],
    [
        "acts = { v = 1 }",
        "acts = { w = 1 }",
        "there is no state `w`",
    ],
    ["acts = { v = 1 }\n", "", "has no `acts`"],
    [
        "restitution = \"e\"",
        "restitution = 1.5",
        "the restitution 1.5 is not between 0 and 1",
    ],
    ["restitution = \"e\"", "bounce = 1", "has no entry `bounce`"],
    [
        "v = \"-g\"",
        "v = \"-g + floor\"",
        "`floor` is a stop and has no value",
    ],
    [
        "v = \"-g\"",
        "v = \"-g*(1 + floor.force^2)\"",
        "is not linear in a reaction",
    ],
];

#[test]
fn what_is_wrong_with_a_stop_is_told_where_it_is_written() {
    parsed(BALL);
    for [before, after, message] in WRONG {
        let text = BALL.replace(before, after);
        assert_ne!(text, BALL);
        let source = stickslip_model::file::Source {
            name: "ball.toml".to_owned(),
            text,
        };
        let error = stickslip_model::file::SystemFile::parse(source).unwrap_err();
        assert!(error.to_string().contains(message), "{after}: {error}");
    }
}

/// Records at the ends of all steps up to a time: modes, time, state, and the quantities there.
type Observed = Vec<(Modes, f64, Vec<f64>, Vec<f64>)>;

fn observed(text: &str, formulas: &[(&str, &str)], t_end: f64, method: &str) -> Observed {
    let system = system(text);
    let (mut quantities, mut all) = (system.quantities(formulas).unwrap(), Vec::new());
    let mut watcher = |progress, orbit: &mut dyn OrbitUnderWay| {
        if let OrbitProgress::Step = progress {
            let step = orbit.last_step();
            let x = step.x_end.as_slice().to_vec();
            let values = quantities.at(&step.mode, step.t_end, &x);
            all.push((step.mode, step.t_end, x, values));
        }
        ControlFlow::Continue(())
    };
    let x = system.start().unwrap();
    let (dynamics, options) = (system.dynamics(), options(method));
    follow(dynamics, (0.0, &x), t_end, &options, &[], &mut watcher).unwrap();
    all
}

#[test]
fn reactions_are_those_of_the_motion() {
    for method in METHODS {
        // On the table the ball moves as A sin t; in flight there is no reaction.
        let formulas = [("work", "-table.force*v"), ("double", "2*table.force")];
        let table = observed(TABLE, &formulas, 60.0, method);
        let mut carried = 0;
        for (_, t, x, values) in &table {
            let force = if x[2] > 0.5 {
                1.0 - 1.5 * math::sin(*t)
            } else {
                0.0
            };
            close(values[0], force, 1e-12, "the reaction of the table");
            assert_eq!(
                values[1..],
                [-values[0] * x[1] + 0.0, 2.0 * values[0]],
                "{t}"
            );
            assert!(
                values
                    .iter()
                    .all(|value| value.to_bits() != (-0.0_f64).to_bits())
            );
            carried += usize::from(x[2] > 0.5);
        }
        assert!(carried > 10 && carried < table.len() - 10);
        // The rod turns about its tip while that sticks, then slips, then sticks to the other side.
        let mut counts = [0; 3];
        for (modes, _, x, values) in observed(ROD, &[], 1.2, method) {
            let (th, om, g, mu) = (x[2], x[5], 9.81, 0.3);
            let (s, c) = (math::sin(th), math::cos(th));
            let (number, force) = match modes.get(0) {
                Mode::Stick => (0, g - 0.75 * g * c * c - s * om * om),
                Mode::Slip(side) => {
                    let friction = mu * side.sign() * s;
                    let number = if side == Side::Below { 1 } else { 2 };
                    (number, (g - s * om * om) / (1.0 + 3.0 * c * (c + friction)))
                }
            };
            close(values[0], force, 1e-9, "the reaction of the floor");
            counts[number] += 1;
        }
        assert!(counts.iter().all(|count| *count > 1), "{counts:?}");
    }
}

/// The impulse of an impact is 1 + e times the speed; that of a landing is what is left of it.
#[test]
fn impulses_are_changes_of_momentum() {
    for method in METHODS {
        let run = Run::of(system(BALL), &options(method), Some(5.0));
        let system = &run.system;
        let mut speed = 2.0_f64.sqrt();
        let mut impacts = 0;
        let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
            if let OrbitProgress::Transition(at) = progress {
                let impulse = system.impulses(at.contact, at.t, at.x.as_slice());
                if system.contact_name(at.contact) == "floor.impact" {
                    close(impulse[0], 1.5 * speed, 1e-9, "an impulse");
                    speed *= 0.5;
                    impacts += 1;
                } else {
                    assert!(impulse[0].abs() < 1e-6, "{impulse:?}");
                }
            }
            ControlFlow::Continue(())
        };
        let x = system.start().unwrap();
        let (dynamics, options) = (system.dynamics(), options(method));
        follow(dynamics, (0.0, &x), 5.0, &options, &[], &mut watcher).unwrap();
        assert!(impacts > 5, "{impacts}");
    }
    // Two balls, of which the first hits the second, which touches a wall.
    let text = "name = \"row\"\n[states]\n\
                x = \"\"\ny = \"\"\nu = \"\"\nv = \"\"\n[field]\nx = \"u\"\n\
                y = \"v\"\nu = 0\nv = 0\n[stops.pair]\ngap = \"y - x\"\nacts = { u = -1, v = 1 }\n\
                restitution = 0\n[stops.wall]\ngap = \"1 - y\"\nacts = { v = -1 }\n\
                restitution = 0\n[start]\nx = 0\ny = 1\nu = 1\nv = 0\n[time]\nend = 2\n";
    let row = system(text);
    assert_eq!(
        row.impulses(0, 1.0, &[1.0, 1.0, 1.0, 0.0, 0.0, 1.0]),
        [1.0, 1.0]
    );
}

#[test]
fn a_quantity_that_is_wrong_is_reported() {
    let system = system(TABLE);
    for (name, formula, message) in [
        ("v", "1", "the name `v` is taken already"),
        (
            "table.force",
            "1",
            "the name `table.force` is taken already",
        ),
        ("", "1", "the formula has no name"),
        ("power", "v*f", "unknown name `f`"),
        ("power", "v*", "something is missing"),
    ] {
        let error = system.quantities(&[(name, formula)]).err().unwrap();
        assert!(error.to_string().contains(message), "{error}");
    }
}

/// A rigid body on three feet, of which two hold it.
const FEET: &str = r#"name = "Three feet"
[states]
y = ""
phi = ""
v = ""
om = ""
[parameters]
l = 1
c = 3
[field]
y = "v"
phi = "om"
v = "-1"
om = 0
[stops.left]
gap = "y - l*phi"
acts = { v = 1, om = "-c*l" }
restitution = 0
[stops.middle]
gap = "y"
acts = { v = 1 }
restitution = 0
[stops.right]
gap = "y + l*phi"
acts = { v = 1, om = "c*l" }
restitution = 0
[start]
y = 1
phi = 0
v = 0
om = 0
[time]
end = 5
"#;

/// A gap needs a slope where it closes, however small or far from where one begins to look.
#[test]
fn gaps_with_any_slope_are_taken_and_flat_ones_refused() {
    let read = |gap: &str| {
        let text = BALL.replace("gap = \"h\"", &format!("gap = \"{gap}\""));
        assert!(gap == "h" || text != BALL);
        let name = "ball.toml".to_owned();
        SystemFile::parse(Source { name, text })
    };
    for gap in [
        "h",
        "h/(1 + h^2)",
        "1e-7*h + h^3",
        "h + sin(h)",
        "h^2 - 1e-8",
        "exp(h) - 1",
    ] {
        assert!(read(gap).is_ok(), "{gap}");
    }
    for gap in [
        "h^2",
        "h^3",
        "h^4",
        "(h - 1)^2",
        "1 - cos(h)",
        "sqrt(h^2 + 1) - 1",
    ] {
        let words = read(gap).unwrap_err().to_string();
        assert!(words.contains("slope of the gap"), "{gap}: {words}");
    }
}

#[test]
fn redundant_stops_are_named() {
    // Elimination leaves zero or rounding of either sign for the third reaction.
    for method in METHODS {
        for (l, c) in [(1.0, 3.0), (0.3, 3.0), (1.3, 2.2), (2.7, 1.7), (0.9, 3.0)] {
            let feet = with(FEET, &[("l", l), ("c", c)]);
            let run = Run::of(feet, &options(method), None);
            let words = run.words();
            let whole = "the reactions of the stops `left`, `middle`, `right` are not unique there";
            assert!(words.contains(whole), "{method}, {l}, {c}: {words}");
            assert!(words.contains("leave one of them out"), "{words}");
        }
        let without = FEET.split("[stops.middle]").collect::<Vec<_>>();
        let two = format!("{}[stops.right]{}", without[0], {
            without[1].split("[stops.right]").nth(1).unwrap()
        });
        let run = Run::of(system(&two), &options(method), None);
        assert_eq!(run.ending(), Ending::EndTime);
    }
}

#[test]
fn a_reaction_that_pulls_on_the_way_is_told_from_its_restitution() {
    for (before, after, message) in [
        (
            "acts = { v = 1 }",
            "acts = { v = \"-v^2 - 0.1\" }",
            "a unit of `acts` of [stops.floor] changes the rate of the gap by -2.1 there",
        ),
        (
            "restitution = \"e\"",
            "restitution = \"approach\"",
            "`restitution` of [stops.floor] is not between 0 and 1 there but 1.414",
        ),
    ] {
        let run = Run::of(
            system(&BALL.replace(before, after)),
            &options("taylor"),
            None,
        );
        let words = run.words();
        assert!(words.contains(message), "{words}");
    }
}

/// A body on a circle, with a gap in its angle. It comes to the cut of `atan2` at π.
const TURNING: &str = r#"name = "Turning body"
[states]
x = ""
y = ""
u = ""
w = ""
[field]
x = "u"
y = "w"
u = "-x"
w = "-y"
[stops.wall]
gap = "GAP"
acts = { w = "SIGN*x/(x^2 + y^2)", u = "-SIGN*y/(x^2 + y^2)" }
restitution = 0.5
[start]
x = 1
y = 0
u = 0
w = "SIGN"
[time]
end = 20
[parameters]
SIGN = 1
"#;

#[test]
fn a_gap_that_jumps_is_told_with_its_place() {
    for method in METHODS {
        for (sign, gap) in [(1.0, "atan2(y, x) + 0.5"), (-1.0, "2.5 - atan2(y, x)")] {
            let turning = with(&TURNING.replace("GAP", gap), &[("SIGN", sign)]);
            let run = Run::of(turning, &options(method), None);
            assert_eq!(run.transitions, [], "{method}, {gap}");
            let Err(Error::GapJumps { t, .. }) = run.ended else {
                panic!("{method}, {gap}: {:?}", run.ended);
            };
            close(t, PI, 1e-12, method);
            let words = run.words();
            assert!(
                words.contains("the gap of the stop `wall` jumps to or from"),
                "{words}"
            );
        }
    }
}

#[test]
fn a_gap_without_value_is_named() {
    let ball = BALL.replace("gap = \"h\"", "gap = \"asin(h)\"");
    let from = |h: f64, v: f64| {
        let start = (0.0, vec![h, v, 0.0, 0.0]);
        Run::from(system(&ball), &options("taylor"), (start, 5.0)).words()
    };
    for words in [from(3.0, 0.0), from(0.5, 4.0)] {
        let part = "in `gap` of [stops.floor], `asin(h)` is not a number";
        assert!(words.contains(part), "{words}");
    }
}
