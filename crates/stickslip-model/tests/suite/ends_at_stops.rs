//! Changes of the phases of periodic orbits at which a stop lets go, with closed forms.

use stickslip::analysis::{CycleBifurcation, SequenceBifurcation, SequenceChange};
use stickslip_model::file::System;
use stickslip_model::study::WholeBranch;

use super::run::{METHODS, Run, branch, options, system, with};

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
fn changes<'b>(system: &System, branch: &'b WholeBranch) -> Vec<(&'b SequenceChange, String)> {
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
    assert_eq!((change.bifurcation, names.as_str()), (name, what), "{method}");
    let off = (change.parameter - exact).abs();
    assert!(
        off <= change.uncertainty && change.uncertainty < 1e-8,
        "{method}: {} for {exact}, {:e}",
        change.parameter,
        change.uncertainty
    );
    // Behind it there is no such orbit.
    let last = found.points.iter().map(|one| one.orbit.parameter);
    let beyond = last.clone().fold(f64::NEG_INFINITY, f64::max);
    assert!(beyond <= exact + change.uncertainty, "{method}: {beyond}");
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
            let is_off = |at: &super::run::Transition| at.2 == "pad.lift-off";
            assert!(run.transitions.iter().any(is_off), "{method}, {force}");
        }
    }
}

#[test]
fn a_reaction_that_a_jump_takes_away_lets_go_with_it() {
    // The kick at t = 2πk sets z to 1, from where it decays: N = 1 - q z.
    let kick = "[jumps.kick]\nwhen = \"sin(0.5*t)\"\nset = { z = 1 }\n";
    for method in METHODS {
        let here = system(&pressed("q*z - 1", kick));
        let what = (SequenceBifurcation::Coincidence, "pad.lift-off, kick", 1.0);
        assert_change((&here, 0.2, 1.8), method, what);
    }
}
