//! Stops beside contacts whose friction acts along their gaps, against closed forms.
//!
//! While a wall carries a block, friction at the block's velocity and the wall's reaction share the
//! load. The motion does not depend on how: the block rests.

use std::f64::consts::PI;

use numerics::SplitMix;
use stickslip::{Ending, math};

use super::run::{METHODS, Run, options, system, with};

/// A block that is pressed against a wall, with friction.
const BLOCK: &str = r#"name = "Block at a wall"
[states]
x = ""
v = ""
[parameters]
F = 1
A = 0
w = 1
mu = 0.2
r = 0.7
[contacts.sole]
boundary = "v"
friction = "mu"
[stops.wall]
gap = "0.5 - x"
acts = { v = -1 }
restitution = "r"
[field]
x = "v"
v = "F + A*sin(w*t) - friction(sole)"
[start]
x = 0
v = 0.1
[time]
end = 20
"#;

/// A block in a corner: the friction of either contact follows the reaction of its own stop.
pub const CORNER: &str = r#"name = "Block in a corner"
[states]
x = ""
y = ""
v = ""
u = ""
[parameters]
F = 0.5
w = 0.3
mu = 0.2
nu = 0.3
e = 0.6
[contacts.sole]
boundary = "v"
friction = "mu*floor.force"
[contacts.side]
boundary = "u"
friction = "nu*wall.force"
[stops.wall]
gap = "0.5 - x"
acts = { v = -1 }
restitution = "e"
[stops.floor]
gap = "y"
acts = { u = 1 }
restitution = 0.5
[field]
x = "v"
y = "u"
v = "F*cos(w*t) - friction(sole)"
u = "-1 - friction(side)"
[start]
x = 0
y = 1
v = 0
u = 0
[time]
end = 30
"#;

/// Times of the events of one kind of one name.
fn times(run: &Run, kind: &str, name: &str) -> Vec<f64> {
    let all = run.transitions.iter();
    all.filter(|(_, what, of)| *what == kind && of == name)
        .map(|(t, ..)| *t)
        .collect()
}

fn close(found: &[f64], exact: &[f64], within: f64, what: &str) {
    let far = |(found, exact): (&f64, &f64)| (found - exact).abs() > within;
    let is_off = found.len() != exact.len() || found.iter().zip(exact).any(far);
    assert!(!is_off, "{what}: {found:?}, exactly {exact:?}");
}

fn ended(run: &Run, what: &str) {
    assert_eq!(run.ending(), Ending::EndTime, "{what}");
}

#[test]
fn a_pressed_block_with_friction_comes_to_rest_at_a_wall() {
    // Between impacts the block leaves with deceleration 1.2 and comes back with 0.8.
    let (away, back, r) = (1.2_f64, 0.8_f64, 0.7);
    let speed = (0.01 + 2.0 * back * 0.5).sqrt();
    let shrinks = r * (back / away).sqrt();
    let round = r / away + shrinks / back;
    let exact = (speed - 0.1) / back + speed * round / (1.0 - shrinks);
    for method in METHODS {
        let run = Run::of(system(BLOCK), &options(method), None);
        ended(&run, method);
        close(&times(&run, "jump", "wall.landing"), &[exact], 1e-9, method);
        let state = ["x", "v", "wall.closed"].map(|name| run.end(name));
        assert_eq!(state, [0.5, 0.0, 1.0], "{method}");
    }
}

#[test]
fn what_friction_holds_alone_it_holds_after_the_stop() {
    // The stop lets go where the force vanishes, friction where the force exceeds it.
    let slow = [("F", 0.0), ("A", 1.0), ("w", 0.5)];
    // Friction lets the block into the wall, and the wall lets it go, once a period.
    let pressed = [("F", 0.15), ("A", 0.3)];
    let start = BLOCK.replace("x = 0\nv = 0.1", "x = 0.5\nv = 0");
    let turns = |of: f64, count: usize| (0..count).map(move |turn| of + 2.0 * PI * turn as f64);
    let slips: Vec<f64> = turns(math::atan2(1.0, 35.0_f64.sqrt()), 4).collect();
    let opens: Vec<f64> = turns(PI + PI / 6.0, 3).collect();
    for method in METHODS {
        let run = Run::of(with(BLOCK, &slow), &options(method), None);
        ended(&run, method);
        close(
            &times(&run, "jump", "wall.lift-off"),
            &[2.0 * PI],
            1e-9,
            method,
        );
        let let_go = 2.0 * PI + 2.0 * math::atan2(0.2, 0.96_f64.sqrt());
        close(
            &times(&run, "stick exit", "sole")[..1],
            &[let_go],
            1e-9,
            method,
        );

        let run = Run::of(with(&start, &pressed), &options(method), Some(21.0));
        ended(&run, method);
        close(&times(&run, "stick exit", "sole"), &slips, 1e-9, method);
        close(&times(&run, "jump", "wall.landing"), &slips, 1e-9, method);
        close(&times(&run, "jump", "wall.lift-off"), &opens, 1e-9, method);
        close(&[run.end("x")], &[0.5], 1e-12, method);
    }
}

#[test]
fn frictions_of_several_stops_hold_a_block_in_a_corner() {
    for method in METHODS {
        let turned = CORNER.replace("cos(w*t)", "sin(w*t)");
        let run = Run::of(system(&turned), &options(method), None);
        ended(&run, method);
        let landing = 3.0 * 2.0_f64.sqrt();
        close(
            &times(&run, "jump", "floor.landing"),
            &[landing],
            1e-9,
            method,
        );
        // The wall lets go where the force turns, the sole where it exceeds 0.2.
        let turns = PI / 0.3;
        close(
            &times(&run, "jump", "wall.lift-off")[..1],
            &[turns],
            1e-9,
            method,
        );
        let slips = turns + math::atan2(0.4, 0.84_f64.sqrt()) / 0.3;
        let all = times(&run, "stick exit", "sole");
        assert!(
            all.iter().any(|t| (t - slips).abs() < 1e-9),
            "{method}: {all:?}"
        );
    }
}

#[test]
fn blocks_in_corners_stay_there_and_lose_energy() {
    let mut random = SplitMix::new(672);
    // STICKSLIP_DRAWS=1000 draws more.
    let draws = std::env::var("STICKSLIP_DRAWS").ok();
    let draws = draws.and_then(|draws| draws.parse().ok()).unwrap_or(40);
    for number in 0..draws {
        let mut draw = |low: f64, high: f64| random.between(low, high);
        let force = draw(-0.6, 0.6);
        let (v, u) = (draw(-1.0, 1.0), draw(-1.0, 1.0));
        let (mu, nu, e) = (draw(0.0, 1.0), draw(0.0, 1.0), draw(0.0, 0.9));
        let set = [("F", force), ("w", 0.0), ("mu", mu), ("nu", nu), ("e", e)];
        let start = format!("x = 0\ny = 1\nv = {v}\nu = {u}");
        let text = CORNER.replace("x = 0\ny = 1\nv = 0\nu = 0", &start);
        let mut ends = Vec::new();
        for method in METHODS {
            let energy = |[x, y, v, u]: [f64; 4]| 0.5 * (v * v + u * u) - force * x + y;
            let mut before = energy([0.0, 1.0, v, u]);
            for part in 1..=10 {
                let end = 1.2 * f64::from(part);
                let run = Run::of(with(&text, &set), &options(method), Some(end));
                if let Err(error) = &run.ended {
                    panic!("{method}, {number}, {set:?}: {error}\n{text}");
                }
                let state = ["x", "y", "v", "u"].map(|name| run.end(name));
                let now = energy(state);
                assert!(now <= before + 1e-10, "{method}, {number}, {set:?}\n{text}");
                assert!(
                    state[0] <= 0.5 + 1e-11 && state[1] >= -1e-11,
                    "{method}, {number}, {set:?}: {state:?}\n{text}"
                );
                before = now;
                if part == 10 {
                    ends.push(state);
                }
            }
        }
        let apart = ends[0].iter().zip(&ends[1]);
        let apart = apart.fold(0.0_f64, |most, (one, other)| most.max((one - other).abs()));
        assert!(apart < 1e-7, "{number}, {set:?}: {ends:?}\n{text}");
    }
}

/// A block rests in a corner and sticks to both of its sides. The wall lets go where the force
/// turns, and its friction, which holds nothing, vanishes and changes its sign there.
#[test]
fn a_stop_lets_go_beside_another_contact_that_holds() {
    let text = "name = \"corner\"\n[time]\nend = 15\n[states]\nx = \"\"\ny = \"\"\nv = \"\"\n\
                u = \"\"\n[stops.wall]\ngap = \"0.5 - x\"\nacts = { v = \"-1\" }\n\
                restitution = 0.6\n[stops.floor]\ngap = \"y\"\nacts = { u = \"1\" }\n\
                restitution = 0.5\n[contacts.sole]\nboundary = \"v\"\n\
                friction = \"0.2*floor.force\"\n[contacts.side]\nboundary = \"u\"\n\
                friction = \"0.3*wall.force\"\n[field]\nx = \"v\"\ny = \"u\"\n\
                v = \"0.5*sin(0.3*t) - friction(sole)\"\nu = \"-1 - friction(side)\"\n\
                [start]\nx = 0\ny = 1\nv = 0\nu = 0\n";
    for method in METHODS {
        let run = Run::of(system(text), &options(method), None);
        let times = |kind: &str, name: &str| -> Vec<f64> {
            let all = run.transitions.iter();
            let own = all.filter(|(_, of, contact)| *of == kind && contact == name);
            own.map(|(t, ..)| *t).collect()
        };
        let lifts = times("jump", "wall.lift-off");
        let off = lifts[0] - PI / 0.3;
        assert!(off.abs() < 1e-9, "{method}: {off:e}");
        // The floor bears 1, and lets go where 0.5 sin(0.3 t) = -0.2.
        let exits = times("stick exit", "sole");
        let off = exits[exits.len() - 1] - (PI + math::atan(0.4 / 0.84_f64.sqrt())) / 0.3;
        assert!(off.abs() < 1e-9, "{method}: {off:e}");
    }
}
