//! Friction forces of contacts along an orbit, compared with balances of forces.

use std::ops::ControlFlow;

use stickslip::dynamics::{Modes, OrbitProgress, Vector};
use stickslip::{Mode, math};
use stickslip_model::file::SystemFile;
use stickslip_model::kernel::follow;

use crate::run::{METHODS, end, options, parsed, simulated, system};

/// A block on a belt, `k x + friction = 0` while it sticks.
const BELT: &str = "name = \"belt\"\n[states]\nx = \"\"\nv = \"\"\n[contacts.belt]\n\
                    boundary = \"v - 0.2\"\nfriction = \"0.4/(1 + 3*belt*(v - 0.2))\"\n\
                    static = 0.5\n[field]\nx = \"v\"\nv = \"-2*x - friction(belt)\"\n\
                    [start]\nx = 0.5\nv = 0.2\n";

#[test]
fn the_force_of_a_contact_is_its_law_in_slip_and_the_balance_in_stick() {
    let belt = system(BELT);
    let observed = [("force", "belt.force"), ("double", "2*belt.force + x")];
    let mut quantities = belt.quantities(&observed).unwrap();
    assert_eq!(quantities.names(), ["force", "double"]);
    assert_eq!(quantities.force_names(), ["belt"]);
    let mut counts = [0; 2];
    let dynamics = belt.dynamics();
    let watcher = &mut |progress, orbit: &mut dyn stickslip::dynamics::OrbitUnderWay| {
        if let OrbitProgress::Step = progress {
            let step = orbit.last_step();
            let middle = orbit.solution()(0.5 * (step.t_start + step.t_end));
            let (x, v) = (middle[0], middle[1]);
            let here = quantities.at(&step.mode, step.t_end, middle.as_slice());
            let wanted = match step.mode.get(0) {
                Mode::Stick => -2.0 * x,
                Mode::Slip(side) => side.sign() * 0.4 / (1.0 + 3.0 * (v - 0.2).abs()),
            };
            counts[usize::from(step.mode.any_sticks())] += 1;
            assert!(
                (here[0] - wanted).abs() < 1e-12,
                "{here:?} {wanted} at {x}, {v}"
            );
            assert!((here[1] - (2.0 * wanted + x)).abs() < 1e-12);
            assert!(here[0].abs() <= 0.5 + 1e-12);
            assert_eq!(
                quantities.forces_at(&step.mode, step.t_end, middle.as_slice())[0],
                here[0]
            );
        }
        ControlFlow::Continue(())
    };
    follow(
        dynamics,
        (0.0, &[0.5, 0.2]),
        20.0,
        &options("taylor"),
        &[],
        watcher,
    )
    .unwrap();
    assert!(counts.iter().all(|count| *count > 2), "{counts:?}");
}

/// Two blocks between springs, both of which stick: each force balances its own springs. A drive
/// acts on the second.
#[test]
fn forces_of_contacts_that_stick_together_balance_each_block() {
    let text = "name = \"two\"\n[states]\nx = \"\"\nv = \"\"\ny = \"\"\nw = \"\"\n\
                [contacts.one]\nboundary = \"v - 0.1\"\nfriction = 1\n\
                [contacts.two]\nboundary = \"w - 0.1\"\nfriction = 2\n\
                [field]\nx = \"v\"\nv = \"-x + 3*(y - x) - friction(one)\"\ny = \"w\"\n\
                w = \"(-3*(y - x) + cos(t) - friction(two) + friction(one)/4)/5\"\n\
                [start]\nx = 0\nv = 0.1\ny = 0\nw = 0.1\n";
    let two = system(text);
    let mut quantities = two.quantities(&[]).unwrap();
    assert_eq!(quantities.force_names(), ["one", "two"]);
    let (t, x, y) = (0.7, 0.2, 0.3);
    let state = Vector::from_vec(vec![x, 0.1, y, 0.1]);
    let one = -x + 3.0 * (y - x);
    let other = -3.0 * (y - x) + stickslip::math::cos(t) + one / 4.0;
    let forces = quantities.forces_at(&Modes::new(&[Mode::Stick; 2]), t, state.as_slice());
    assert!(
        (forces[0] - one).abs() < 1e-12 && (forces[1] - other).abs() < 1e-12,
        "{forces:?}"
    );
    // The second slips above: it has its law, and the first is as before.
    let state = [x, 0.1, y, 0.4];
    let above = Mode::Slip(stickslip::Side::Above);
    let forces = quantities.forces_at(&Modes::new(&[Mode::Stick, above]), t, &state);
    assert!(
        (forces[0] - one).abs() < 1e-12 && forces[1] == 2.0,
        "{forces:?}"
    );
}

/// A sole whose friction follows the reaction of the floor, pulled aside and upwards.
#[test]
fn friction_that_follows_a_reaction_balances_the_pull() {
    let text = "name = \"sole\"\n[states]\nx = \"\"\nv = \"\"\nh = \"\"\nw = \"\"\n\
                [stops.floor]\ngap = \"h\"\nacts = { w = 1 }\nrestitution = 0\n\
                [contacts.sole]\nboundary = \"v\"\nfriction = \"0.5*floor.force\"\n\
                [field]\nx = \"v\"\nv = \"t - friction(sole)\"\nh = \"w\"\nw = \"t/2 - 10\"\n\
                [start]\nx = 0\nv = 0\nh = 0\nw = 0\n\"floor.closed\" = 1\n";
    let text = text.replace("\"floor.closed\" = 1\n", "");
    let sole = system(&text);
    let mut quantities = sole
        .quantities(&[("angle", "sole.force/floor.force")])
        .unwrap();
    assert_eq!(quantities.force_names(), ["floor", "sole"]);
    let closed = [0.0, 0.0, 0.0, 0.0, 1.0];
    let (t, load) = (3.0, 10.0 - 1.5);
    let stick = Modes::new(&[Mode::Stick]);
    let forces = quantities.forces_at(&stick, t, &closed);
    assert!(
        (forces[0] - load).abs() < 1e-12 && (forces[1] - t).abs() < 1e-12,
        "{forces:?}"
    );
    let at = quantities.at(&stick, t, &closed);
    assert!((at[1] - t / load).abs() < 1e-12, "{at:?}");
    let slides = [0.0, -1.0, 0.0, 0.0, 1.0];
    let below = Modes::new(&[Mode::Slip(stickslip::Side::Below)]);
    let forces = quantities.forces_at(&below, t, &slides);
    assert!((forces[1] + load / 2.0).abs() < 1e-12, "{forces:?}");
}

/// What a side of one contact does to the friction of another is no sum.
#[test]
fn forces_that_the_sides_of_others_multiply_are_no_numbers() {
    let text = "name = \"two\"\n[states]\nv = \"\"\nw = \"\"\n\
                [contacts.one]\nboundary = \"v\"\nfriction = 1\n\
                [contacts.two]\nboundary = \"w\"\nfriction = 1\n\
                [field]\nv = \"0.3 - friction(one)*(1 + 0.2*two)\"\nw = \"0.4 - friction(two)\"\n\
                [start]\nv = 0\nw = 0\n";
    let two = system(text);
    let mut quantities = two.quantities(&[]).unwrap();
    let forces = quantities.forces_at(&Modes::new(&[Mode::Stick; 2]), 0.0, &[0.0, 0.0]);
    assert!(forces.iter().all(|force| force.is_nan()), "{forces:?}");
}

#[test]
fn a_field_has_the_friction_of_a_contact_by_its_function() {
    let wrong = BELT.replace("- friction(belt)", "- belt.force");
    let source = stickslip_model::file::Source {
        name: "system.toml".to_owned(),
        text: wrong,
    };
    let refused = stickslip_model::file::SystemFile::parse(source)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("`belt.force` is known along an orbit alone"),
        "{refused}"
    );
    assert!(refused.contains("friction(belt)"), "{refused}");
    let source = stickslip_model::file::Source {
        name: "system.toml".to_owned(),
        text: BELT.replace(
            "[field]",
            "[contacts.side]\nboundary = \"x\"\n\
                                       friction = \"0.5*belt.force\"\n[field]",
        ),
    };
    let refused = SystemFile::parse(source).unwrap_err().to_string();
    let remedy = "is [stops.NAME], with friction = \"mu*NAME.force\"";
    assert!(refused.contains(remedy), "{refused}");
    let belt = parsed(BELT).with(&[]).unwrap();
    let unknown = belt
        .quantities(&[("force", "belt.forces")])
        .err()
        .unwrap()
        .to_string();
    assert!(unknown.contains("did you mean `belt.force`?"), "{unknown}");
}

/// The distance from a boundary is smooth on each side. However it is written, the orbit is that of
/// the law with the side, bit for bit.
#[test]
fn the_absolute_value_of_a_boundary_has_no_kink() {
    let ways = [
        "belt*(v - 0.2)",
        "abs(v - 0.2)",
        "abs(0.2 - v)",
        "abs(slip)",
    ];
    for method in METHODS {
        let ends = ways.map(|way| {
            let text = BELT.replace("belt*(v - 0.2)", way);
            let named = "[definitions]\nslip = \"v - 0.2\"\n[field]";
            let (run, transitions) = simulated(&text.replace("[field]", named), method, 20.0);
            let transitions: Vec<_> = transitions.iter().map(|at| at.0.to_bits()).collect();
            assert!(transitions.len() > 4);
            (
                transitions,
                end(&run, "x").to_bits(),
                run.ended.unwrap().counters.steps,
            )
        });
        assert!(ends.iter().all(|one| *one == ends[0]), "{method}: {ends:?}");
        // Drag with the friction 1/10 stops the body where √a t = atan(1/√a).
        let drag = "name = \"drag\"\n[states]\nv = \"\"\n[contacts.rest]\nboundary = \"v\"\n\
                    [field]\nv = \"-v*abs(v) - 0.1*rest\"\n[start]\nv = 1\n";
        let (_, transitions) = simulated(drag, method, 5.0);
        let root = 0.1_f64.sqrt();
        let off = transitions[0].0 - math::atan(1.0 / root) / root;
        assert!(off.abs() < 1e-11, "{method}: {off:e}");
    }
}

/// The spring exceeds the static limit of a law with a root, and the block is released, however the
/// distance is written.
#[test]
fn a_law_with_a_root_lets_go() {
    let by_side = "by_side(belt, 0.2 - v, v - 0.2)";
    for distance in ["abs(v - 0.2)", "belt*(v - 0.2)", by_side] {
        let text = BELT
            .replace("0.4/(1 + 3*belt*(v - 0.2))", "0.2 + 0.3*sqrt(D)")
            .replace("sqrt(D)", &format!("sqrt({distance})"))
            .replace("static = 0.5\n", "")
            .replace("-2*x", "-x")
            .replace("x = 0.5\n", "x = 0.1\n");
        for method in METHODS {
            let (run, transitions) = simulated(&text, method, 5.0);
            let (t, kind, _) = &transitions[0];
            assert_eq!(*kind, "stick exit", "{method}, {distance}: {transitions:?}");
            assert!((t - 0.5).abs() < 1e-9, "{method}");
            assert!((end(&run, "x") - 0.281_175_749).abs() < 1e-7, "{method}");
        }
    }
}

/// A pulse that is far below rounding beside itself sets off its jump.
#[test]
fn a_narrow_pulse_beside_a_smooth_term_is_seen() {
    let text = "name = \"pulse\"\n[states]\nx = \"\"\nv = \"\"\n[jumps.pulse]\n\
                when = \"(0.5 + 0.5*cos(t - 2.5))^1000 - 0.5 - 0.1*sin(t)\"\n\
                direction = \"rising\"\nset = { v = \"v + 1\" }\n[field]\nx = \"v\"\n\
                v = \"-x\"\n[start]\nx = 0.3\nv = 0.95\n";
    for method in METHODS {
        let (_, transitions) = simulated(text, method, 6.0);
        let [(t, kind, _)] = &transitions[..] else {
            panic!("{method}: {transitions:?}");
        };
        let pulse = math::powi(0.5 + 0.5 * math::cos(t - 2.5), 1000);
        assert_eq!(*kind, "jump");
        assert!(
            (pulse - 0.5 - 0.1 * math::sin(*t)).abs() < 1e-9,
            "{method}: {t}"
        );
    }
}
