//! Changes of the phases of periodic orbits at which a stop lets go, or a condition of a jump is an
//! equality, with closed forms; and why there is no orbit where a law has no derivative.

use std::f64::consts::PI;

use numerics::bisect;
use stickslip::analysis::{CycleBifurcation, SequenceBifurcation, SequenceChange};
use stickslip::{Error, math};
use stickslip_model::file::System;
use stickslip_model::study::{SearchError, TwoSidedBranch};

use super::run::{METHODS, Run, SEARCH, branch, options, system, with};

/// A body that a force presses on a pad, and a driven oscillator beside it.
fn pressed(force: &str, more: &str) -> String {
    format!(
        r#"name = "Body on a pad"
[states]
x = ""
v = ""
y = ""
w = ""
z = ""
[parameters]
q = 0.5
{more}
[field]
x = "v"
v = "{force}"
y = "w"
w = "-y - 0.4*w + cos(t)"
z = "-z"
[stops.pad]
gap = "x"
acts = {{ v = 1 }}
restitution = 0.5
[start]
x = 0
v = 0
y = 0
w = 0
z = 0.1
[time]
end = 60
period = "2*pi"
"#
    )
}

/// The changes of the phases on a branch, each with the names of what changes.
fn changes<'b>(system: &System, branch: &'b TwoSidedBranch) -> Vec<(&'b SequenceChange, String)> {
    let changes = branch.special.iter().filter_map(|at| match &at.what {
        CycleBifurcation::Sequence(change) => Some(&**change),
        _ => None,
    });
    let named = changes.map(|change| {
        let names = change.contacts.iter().map(|&one| system.contact_name(one));
        (change, names.collect::<Vec<_>>().join(", "))
    });
    named.collect()
}

fn assert_change(
    (system, low, high): (&System, f64, f64),
    method: &str,
    (name, what, exact): (SequenceBifurcation, &str, f64),
) {
    let found = branch(system, ("q", low, high), &options(method));
    let changes = changes(system, &found);
    let [(change, names)] = &changes[..] else {
        panic!("{method}: {changes:?}, {:?}", found.special);
    };
    assert_eq!(
        (change.bifurcation, names.as_str()),
        (name, what),
        "{method}"
    );
    let off = (change.parameter - exact).abs();
    // A choice in what a jump sets is extrapolated from the last step.
    let is_choice = name == SequenceBifurcation::Choice;
    let bound = if is_choice { 1e-6 } else { 1e-8 };
    assert!(
        off <= change.uncertainty && change.uncertainty < bound,
        "{method}: {} for {exact}, {:e}",
        change.parameter,
        change.uncertainty
    );
    // Behind it there is no such orbit.
    let all = || found.points.iter().map(|one| one.orbit.parameter - exact);
    let (least, most) = all().fold((0.0_f64, 0.0_f64), |(a, b), way| (a.min(way), b.max(way)));
    let beyond = most.min(-least);
    assert!(beyond <= change.uncertainty, "{method}: {beyond}");
}

#[test]
fn a_reaction_that_vanishes_in_a_phase_is_a_lift_off() {
    use SequenceBifurcation::LiftOff;
    let cases = [
        // The same at all times.
        ("q - 1", 1.0),
        ("q*q - 2", 2.0_f64.sqrt()),
        // Smallest at t = 3π/2.
        ("q - 1 - 0.25*sin(t)", 0.75),
        // Constant over each half of the period.
        ("q - 1 + 0.5*on", 0.5),
    ];
    let more = "[inputs.on]\nshape = \"square\"\nperiod = \"2*pi\"\n";
    for (force, exact) in cases {
        let more = if force.contains("on") { more } else { "" };
        let text = pressed(force, more);
        for method in METHODS {
            let here = with(&text, &[("q", 0.3)]);
            assert_change((&here, 0.2, 1.8), method, (LiftOff, "pad.lift-off", exact));
            // The body is in flight beyond.
            let beyond = with(&text, &[("q", exact + 1e-3)]);
            let run = Run::of(beyond, &options(method), None);
            let lifts_off = run.transitions.iter().any(|at| at.2 == "pad.lift-off");
            assert!(
                lifts_off || run.end("x") > 1.0,
                "{method}, {force}: {}",
                run.end("x")
            );
        }
    }
}

#[test]
fn a_reaction_that_pulls_behind_a_kink_no_more_is_a_lift_off() {
    // N is 1 and, while the pulse lasts, 1 - q: the body lifts off at the kink if q exceeds 1.
    let text = "name = \"pulled\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nq = 1.2\n\
                [inputs.pull]\n\
                shape = \"pulse\"\nwidth = 0.25\nperiod = 4\nphase = 0.5\n[field]\nx = \"v\"\n\
                v = \"q*pull - 1\"\n[stops.pad]\ngap = \"x\"\nacts = { v = 1 }\nrestitution = 0\n\
                [start]\nx = 0\nv = 0\n[time]\nend = 60\nperiod = 4\n";
    for method in METHODS {
        let pulled = system(text);
        let found = branch(&pulled, ("q", 0.5, 1.4), &options(method));
        let changes = changes(&pulled, &found);
        let [(change, names)] = &changes[..] else {
            panic!("{method}: {changes:?}");
        };
        // At 1 the body floats, so that its flight may also end with the lift-off.
        let expected = ["pad.lift-off", "pad.lift-off, pad.impact"];
        assert!(expected.contains(&names.as_str()), "{method}: {change:?}");
        let off = (change.parameter - 1.0).abs();
        assert!(
            off <= change.uncertainty && change.uncertainty < 1e-8,
            "{change:?}"
        );
    }
}

#[test]
fn a_reaction_that_a_jump_takes_away_lets_go_with_it() {
    // The kick at t = 2πk sets z to 1, from where it decays: N = 1 - q z.
    let kick = "[jumps.kick]\nwhen = \"sin(t)\"\ndirection = \"rising\"\nset = { z = 1 }\n";
    for method in METHODS {
        let here = system(&pressed("q*z - 1", kick));
        let what = (SequenceBifurcation::Coincidence, "pad.lift-off, kick", 1.0);
        assert_change((&here, 0.2, 1.8), method, what);
    }
}

#[test]
fn a_jump_that_leads_to_a_stop_is_a_named_change() {
    // Once a period the body is put at q, with a speed off the pad.
    let text = "name = \"put\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nq = 0.3\n[field]\n\
                x = \"v\"\nv = -1\n[jumps.put]\nwhen = \"sin(t)\"\ndirection = \"rising\"\n\
                set = { x = \"q\", v = 0.5 }\n[stops.pad]\ngap = \"x\"\nacts = { v = 1 }\n\
                restitution = 0\n[start]\nx = 0.1\nv = 0\n[time]\nstart = 1\nend = 60\n\
                period = \"2*pi\"\n";
    for method in METHODS {
        let what = (SequenceBifurcation::Coincidence, "pad.impact, put", 0.0);
        assert_change((&system(text), -0.1, 0.5), method, what);
    }
}

#[test]
fn a_law_without_a_derivative_is_named_where_no_orbit_is_found() {
    let text = "name = \"root\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nk = 0.5\n[field]\n\
                x = \"v\"\nv = \"-x - 0.2*v + cos(t) - friction(c)\"\n[contacts.c]\n\
                boundary = \"v\"\nfriction = \"k*sqrt(abs(v))\"\n[start]\nx = 0.5\nv = 0.5\n\
                [time]\nend = 60\nperiod = \"2*pi\"\n";
    for method in METHODS {
        let root = system(text);
        let start = root.start().unwrap();
        let found = SEARCH.orbit(&root, (0.0, &start), &options(method));
        // Where the motion turns.
        let Err(SearchError::Failed(Error::TangentSingular { x, .. })) = &found else {
            panic!("{method}: {found:?}");
        };
        assert!(x.0[1].abs() < 1e-12, "{method}: {x:?}");
        let smooth = system(&text.replace("sqrt(abs(v))", "abs(v)"));
        let found = SEARCH.orbit(&smooth, (0.0, &start), &options(method));
        assert!(found.is_ok(), "{method}: {found:?}");
    }
}

/// A clock that a jump sets back; the jump kicks z, in what it sets by a choice.
fn kicked(condition: &str, set: &str) -> String {
    format!(
        "name = \"kicked\"\n[states]\nz = \"\"\ny = \"\"\n[parameters]\nq = 0.5\n[field]\n\
         z = \"-z\"\ny = \"-y + cos(t)\"\n[jumps.kick]\nwhen = \"sin(t)\"\n\
         direction = \"rising\"\n{condition}\nset = {{ z = \"{set}\" }}\n[start]\nz = 1\ny = 0.5\n\
         [time]\nstart = 1\nend = 60\nperiod = \"2*pi\"\n"
    )
}

#[test]
fn an_equality_of_a_condition_is_a_named_change() {
    use SequenceBifurcation::Choice;
    // Before the kick z is a = e^(-2 pi) (z + 1), so that a = 1/(e^(2 pi) - 1); and y is 0.5.
    let a = 1.0 / (math::exp(2.0 * PI) - 1.0);
    let cases = [
        ("if = \"z < 1 - q\"", "z + 1", 1.0 - a),
        ("if = \"y > q and z < 5\"", "z + 1", 0.5),
        ("if = \"not (y <= q or z > 5)\"", "z + 1", 0.5),
        ("", "if(z + q < 1, z + 1, z + 3)", 1.0 - a),
        ("", "if(y > 3, 7, if(y > q, z + 1, z - 1))", 0.5),
    ];
    for (condition, set, exact) in cases {
        let text = kicked(condition, set);
        for method in METHODS {
            let here = with(&text, &[("q", 0.2)]);
            assert_change((&here, 0.1, 1.8), method, (Choice, "kick", exact));
        }
    }
}

#[test]
fn a_condition_that_begins_to_hold_is_a_named_change() {
    // Without the kick z decays to 0, and y is 0.5 where the clock of the kick is zero.
    for method in METHODS {
        let here = with(&kicked("if = \"y < q\"", "z + 1"), &[("q", 0.2)]);
        let what = (SequenceBifurcation::Choice, "kick", 0.5);
        assert_change((&here, 0.1, 1.8), method, what);
    }
}

/// Value of the parameter at which the impacts of a ball accumulate only as its stop lets go.
///
/// Time `s` is counted back from the lift-off: the acceleration is `-q s`. A flight from `s`
/// with the speed `r q s^2` ends at `(1 - c) s` where `r = c/2 - c^2/6`. A ratio `r` that the next
/// flight has again is the largest from which the ball comes to rest.
fn landing_meets_lift_off(restitution: f64) -> f64 {
    let again = |c: f64| {
        let kept = (0.5 - c / 6.0) * (1.0 - c) * (1.0 - c);
        kept < restitution * (0.5 - c / 3.0)
    };
    let c = bisect(1e-6, 1.0, again);
    let ratio = c / 2.0 - c * c / 6.0;
    let is_thrown_on = |q: f64| {
        // It lifts off at 1/q; the force drops to -1 at 1.
        let s = 1.0 - 1.0 / q;
        let (height, speed) = (q * s * s * s / 6.0, q * s * s / 2.0);
        let gap = |r: f64| height + speed * r - r * r / 2.0 + q * r * r * r / 6.0;
        // It falls from where its rate vanishes to 1/q.
        let turns = bisect(0.0, 1.0 / q, |r| speed - r + q * r * r / 2.0 <= 0.0);
        if gap(1.0 / q) > 0.0 {
            return true;
        }
        let hit = bisect(turns, 1.0 / q, |r| gap(r) <= 0.0);
        let back = -restitution * (speed - hit + q * hit * hit / 2.0);
        let left = 1.0 / q - hit;
        back > ratio * q * left * left
    };
    bisect(1.1, 1.6, is_thrown_on)
}

#[test]
fn a_branch_ends_where_the_landing_of_a_ball_meets_its_lift_off() {
    let text = "name = \"ball\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nq = 1.2\n\
                [inputs.saw]\n\
                shape = \"sawtooth\"\nperiod = 1\n[field]\nx = \"v\"\nv = \"q*saw - 1\"\n\
                [stops.pad]\n\
                gap = \"x\"\nacts = { v = 1 }\nrestitution = 0.5\n[start]\nx = 0\nv = 0\n[time]\n\
                start = 0.5\nend = 60\nperiod = 1\n";
    let exact = landing_meets_lift_off(0.5);
    for method in METHODS {
        let what = (
            SequenceBifurcation::Coincidence,
            "pad.landing, pad.lift-off",
            exact,
        );
        assert_change((&system(text), 1.05, 1.7), method, what);
    }
}

/// A jump whose condition never holds has no effect, and a choice between equal maps none where it
/// changes.
#[test]
fn branches_pass_conditions_and_choices_that_change_nothing() {
    let wall = "name = \"p\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nq = 0.3\n[field]\n\
                x = \"v\"\nv = \"-x - 0.3*v + cos(t)\"\n[jumps.hit]\nwhen = \"x - 0.5\"\n\
                direction = \"rising\"\nif = \"v < q\"\nset = { v = \"0.5*v\" }\n[start]\nx = 0\n\
                v = 0\n[time]\nend = 200\nperiod = \"2*pi\"\n";
    // Rises through 1/2 are faster than this.
    let speed = 2.5;
    let kicked = |set: &str| {
        format!(
            "name = \"kicked\"\n[states]\nz = \"\"\ny = \"\"\n[parameters]\nq = 0.2\n[field]\n\
             z = \"-z\"\ny = \"-y + cos(t)\"\n[jumps.kick]\nwhen = \"sin(t)\"\n\
             direction = \"rising\"\nset = {{ z = \"{set}\" }}\n[start]\nz = 1\ny = 0.5\n\
             [time]\nstart = 1\nend = 60\nperiod = \"2*pi\"\n"
        )
    };
    // At t = 0 the oscillator y = (cos t + sin t)/2 is at 1/2.
    let equal = kicked("if(y > q, z + 1, 1 + z)");
    for method in METHODS {
        for (text, low, high) in [(wall, 0.05, speed), (&equal, 0.1, 0.9)] {
            let found = branch(&system(text), ("q", low, high), &options(method));
            assert!(found.special.is_empty(), "{method}: {:?}", found.special);
            let ends = [found.points.first(), found.points.last()];
            let ends = ends.map(|at| at.unwrap().orbit.parameter);
            assert_eq!(ends, [low, high], "{method}: {text}");
        }
    }
}
