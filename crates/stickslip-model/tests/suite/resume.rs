//! Runs that go on from the end of another run have the bits of a single one.

use std::ops::ControlFlow;

use numerics::SplitMix;
use stickslip::dynamics::{Moment, OrbitProgress, OrbitUnderWay, RunMemory, Vector};
use stickslip::{AtPileUp, Options};
use stickslip_model::kernel::follow_on;

use crate::run::{METHODS, options, system};

/// Kind, contact and time of a transition or a kink.
type Change = (String, usize, f64);

/// Changes and end of a run, and what another one needs to go on.
struct Piece {
    changes: Vec<Change>,
    end: (f64, Vec<f64>),
    memory: Option<RunMemory>,
}

fn piece(text: &str, from: Option<&RunMemory>, until: f64, options: &Options) -> Piece {
    let system = system(text);
    let dynamics = system.dynamics();
    let mut orbit = match from {
        Some(memory) => dynamics.resume(memory, until, options, &[]),
        None => {
            let x = Vector::from_vec(system.start().unwrap());
            let t = system.built.t_start;
            dynamics.begin(&Moment { t, x }, until, options, &[])
        }
    }
    .unwrap();
    orbit.remember();
    let mut changes = Vec::new();
    let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
        match progress {
            OrbitProgress::Transition(at) => {
                changes.push((at.kind.name().to_owned(), at.contact, at.t));
            }
            OrbitProgress::Kink(at) => changes.push(("kink".to_owned(), at.input, at.t)),
            _ => {}
        }
        ControlFlow::Continue(())
    };
    let ended = follow_on(&mut *orbit, &mut watcher).unwrap();
    Piece {
        changes,
        end: (ended.t, ended.x.iter().copied().collect()),
        memory: orbit.memory(),
    }
}

/// Checks a system, of an end time, in pieces that end at random times and at all its changes.
fn same_in_pieces(text: &str, until: f64, options: &Options, draw: &mut SplitMix) {
    let difference = difference_in_pieces(text, until, (options, 0.0), draw);
    assert!(difference.is_none(), "{}", difference.unwrap_or_default());
}

/// Difference of a run in pieces that end at random times, and at its first changes, from the run
/// in one piece. End states may differ by so much.
pub fn difference_in_pieces(
    text: &str,
    until: f64,
    (options, within): (&Options, f64),
    draw: &mut SplitMix,
) -> Option<String> {
    let whole = piece(text, None, until, options);
    let mut cuts: Vec<f64> = (0..4).map(|_| until * draw.uniform()).collect();
    // At a change, and next to it.
    for (.., t) in whole.changes.iter().take(3) {
        cuts.extend([*t, t + 1e-9, t - 1e-9]);
    }
    cuts.retain(|t| 0.0 < *t && *t < until);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    cuts.push(until);
    let (mut memory, mut changes, mut end) = (None, Vec::new(), (0.0, Vec::new()));
    for cut in &cuts {
        let next = piece(text, memory.as_ref(), *cut, options);
        changes.extend(next.changes);
        end = next.end;
        memory = next.memory;
        if memory.is_none() {
            return Some(format!("no memory at {cut} of {text}"));
        }
    }
    let what = format!("{:?} in pieces {cuts:?} of {text}", options.method);
    let mut off = end
        .1
        .iter()
        .zip(&whole.end.1)
        .map(|(one, other)| (one - other).abs());
    if end.0 != whole.end.0 || off.any(|off| off > within) {
        return Some(format!("{end:?} and {:?}: {what}", whole.end));
    }
    let kinds = |all: &[Change]| -> Vec<(String, usize)> {
        let all = all.iter();
        all.map(|(kind, of, _)| (kind.clone(), *of)).collect()
    };
    if kinds(&changes) != kinds(&whole.changes) {
        return Some(format!("{changes:?} and {:?}: {what}", whole.changes));
    }
    // A step that the end of a piece has shortened has the error of a step.
    let allowed = f64::max(1e-11, options.rtol);
    let mut pairs = changes.iter().zip(&whole.changes);
    let is_apart = |(one, other): &(&Change, &Change)| {
        (one.2 - other.2).abs() > allowed * one.2.abs().max(1.0)
    };
    let apart = pairs.find(is_apart);
    apart.map(|(one, other)| format!("{one:?}, {other:?}: {what}"))
}

const SYSTEMS: [(&str, f64); 8] = [
    // Stick and slip on a belt, pushed.
    (
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[contacts.belt]\nboundary = \"v - 0.3\"\n\
         friction = \"1/(1 + abs(v - 0.3))\"\n[field]\nx = \"v\"\n\
         v = \"- x + 0.2*cos(1.7*t) - friction(belt)\"\n[start]\nx = 0.5\nv = 0.1\n",
        30.0,
    ),
    // Static friction.
    (
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[contacts.belt]\nboundary = \"v - 0.2\"\n\
         friction = \"0.8\"\nstatic = \"1.1\"\n[field]\nx = \"v\"\nv = \"- x - friction(belt)\"\n\
         [start]\nx = 0\nv = 0\n",
        25.0,
    ),
    // Impacts.
    (
        "name = \"case\"\n[states]\nh = \"\"\nv = \"\"\n[jumps.floor]\nwhen = \"h\"\n\
         direction = \"falling\"\nset = { v = \"-0.9*v\" }\n[field]\nh = \"v\"\nv = \"-1\"\n\
         [start]\nh = 1\nv = 0\n",
        12.0,
    ),
    // A counter that leaves its function at zero, and a clock.
    (
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\ny = \"\"\n[discrete]\nn = 0\n\
         [jumps.count]\nwhen = \"x\"\ndirection = \"rising\"\nset = { n = \"n + 1\" }\n\
         [jumps.beat]\nwhen = \"sin(2*pi*t)\"\ndirection = \"rising\"\n\
         set = { v = \"0.9*v + 0.1\" }\n\
         [field]\nx = \"v\"\nv = \"-x\"\ny = \"n\"\n[start]\nx = 0.3\nv = 0\ny = 0\n",
        20.0,
    ),
    // A jump on a velocity in stick.
    (
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[discrete]\nn = 0\n[contacts.belt]\n\
         boundary = \"v - sin(t)\"\nfriction = \"3\"\n[jumps.level]\nwhen = \"v - 0.5\"\n\
         set = { n = \"n + 1\" }\n[field]\nx = \"v\"\nv = \"- 0.1*x - friction(belt)\"\n\
         [start]\nx = 0\nv = 0\n",
        20.0,
    ),
    // Inputs that kink, and a switch.
    (
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[inputs.push]\nshape = \"sawtooth\"\n\
         period = 1.3\n[contacts.floor]\nboundary = \"v\"\nfriction = \"0.4\"\n[field]\nx = \"v\"\n\
         v = \"2*push - x - friction(floor)\"\n[start]\nx = 0.1\nv = 0.4\n",
        15.0,
    ),
    // Contact and jump accumulate, and rest.
    (
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[contacts.c]\nboundary = \"x\"\n[jumps.j]\n\
         when = \"x\"\nset = { v = \"0.5*v\" }\n[field]\nx = \"v\"\nv = \"-c\"\n\
         [start]\nx = 1\nv = 0\n",
        6.0,
    ),
    // Two blocks.
    (
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\ny = \"\"\nw = \"\"\n[contacts.a]\n\
         boundary = \"v - 0.1\"\nfriction = \"0.5\"\nstatic = \"0.7\"\n[contacts.b]\n\
         boundary = \"w - 0.1\"\nfriction = \"0.3\"\nstatic = \"0.5\"\n[field]\nx = \"v\"\n\
         v = \"y - 2*x - friction(a)\"\ny = \"w\"\nw = \"x - 2*y - friction(b)\"\n[start]\n\
         x = 0.2\nv = 0\ny = -0.4\nw = 0.3\n",
        25.0,
    ),
];

#[test]
fn a_run_in_pieces_has_the_bits_of_a_single_one() {
    let mut draw = SplitMix::new(630);
    for (text, until) in SYSTEMS {
        for method in METHODS {
            for tolerance in [1e-7, 1e-12] {
                let options = Options {
                    rtol: tolerance,
                    atol: tolerance.into(),
                    ..options(method)
                };
                same_in_pieces(text, until, &options.at_pile_up(AtPileUp::Rest), &mut draw);
            }
        }
    }
}
