//! Random systems with jumps, discrete states, inputs and a contact: both methods find the same
//! events.

use std::collections::BTreeMap;

use numerics::SplitMix;
use stickslip::dynamics::{Moment, OrbitProgress, Vector};
use stickslip::{Ending, Error, TransitionKind};
use stickslip_model::file::System;

use crate::resume::difference_in_pieces;
use crate::run::{METHODS, options, system};

/// Number of events compared: later, neighbouring orbits may have separated.
const MAX_COMPARED: usize = 40;

/// End of each run.
const UNTIL: f64 = 6.0;

/// Largest difference of the end state of a run in pieces where a piece ends so near before an
/// event that rounding moves the event. All others have the bits of the run in one piece.
const ROUNDED: f64 = 1e-12;

/// Allowed difference of event times.
const TIME_TOLERANCE: f64 = 1e-6;

/// The file of a random system.
fn text(random: &mut SplitMix) -> String {
    let mut a = |low: f64, high: f64| random.between(low, high);
    let mut text = "name = \"random\"\n[states]\nx = \"\"\ny = \"\"\n".to_owned();
    let mut acts = String::new();
    text += "[discrete]\nn = 1\nm = 0\n";
    // Each input is optional.
    for (number, shape) in ["square", "triangle", "sawtooth", "pulse"]
        .iter()
        .enumerate()
    {
        if a(0.0, 1.0) < 0.4 {
            let (period, phase) = (a(0.4, 3.0), a(0.0, 1.0));
            text += &format!("[inputs.i{number}]\nshape = \"{shape}\"\nperiod = {period}\n");
            text += &format!("phase = {phase}\n");
            if *shape == "pulse" {
                text += &format!("width = {}\n", a(0.02, 0.6));
            }
            acts += &format!(" + {}*i{number}", a(-1.5, 1.5));
        }
    }
    if a(0.0, 1.0) < 0.4 {
        let times = [a(0.0, 1.0), a(1.1, 3.0), a(3.1, 5.0)];
        let values = [a(-1.0, 1.0), a(-1.0, 1.0), a(-1.0, 1.0)];
        let between = ["linear", "constant"][usize::from(a(0.0, 1.0) < 0.5)];
        text += &format!("[inputs.points]\nshape = \"table\"\ntimes = {times:?}\n");
        text += &format!("values = {values:?}\nbetween = \"{between}\"\n");
        acts += " + points";
    }
    if a(0.0, 1.0) < 0.4 {
        let function = format!("sin({}*t) - {}", a(1.0, 6.0), a(-0.8, 0.8));
        text += &format!("[switches.drive]\nfunction = \"{function}\"\n");
        acts += &format!(" + {}*drive", a(-1.0, 1.0));
    }
    // A contact with friction is optional.
    let mut friction = "";
    if a(0.0, 1.0) < 0.6 {
        let (speed, size) = (a(-0.5, 0.5), a(0.1, 1.0));
        text += &format!("[contacts.belt]\nboundary = \"y - ({speed})\"\n");
        text += &format!("friction = \"{size}/(1 + 0.5*belt*(y - ({speed})))\"\n");
        if a(0.0, 1.0) < 0.3 {
            text += &format!("static = \"{}\"\n", size * a(1.0, 1.5));
        }
        friction = " - friction(belt)";
    }
    text += &format!(
        "[field]\nx = \"y + {}*n\"\ny = \"{}*x + {}*y + {}*sin(2*x) + {}*m{acts}{friction}\"\n",
        a(-0.3, 0.3),
        a(-3.0, -0.5),
        a(-0.4, 0.1),
        a(-0.5, 0.5),
        a(-1.0, 1.0),
    );
    let jumps = 1 + (a(0.0, 2.999) as usize);
    for number in 0..jumps {
        let direction = ["rising", "falling", "both"][a(0.0, 2.999) as usize];
        let when = match a(0.0, 4.0) as usize {
            0 => format!("x - ({})", a(-0.7, 0.7)),
            1 => format!("x + {}*y - ({})", a(-1.0, 1.0), a(-0.7, 0.7)),
            2 => format!("x*x + y*y - {}", a(0.1, 1.5)),
            _ => format!("x - {}*sin({}*t)", a(-0.7, 0.7), a(0.5, 4.0)),
        };
        let set = match a(0.0, 4.0) as usize {
            0 => format!("y = \"{}*y\"", a(-0.9, 0.9)),
            1 => format!("n = \"-n\", x = \"x + {}\"", a(-0.2, 0.2)),
            2 => "m = \"1 - m\"".to_owned(),
            _ => format!("y = \"y + {}*n\", m = \"1 - m\"", a(-0.5, 0.5)),
        };
        text += &format!("[jumps.j{number}]\nwhen = \"{when}\"\ndirection = \"{direction}\"\n");
        text += &format!("set = {{ {set} }}\n");
    }
    text + &format!("[start]\nx = {}\ny = {}\n", a(-1.0, 1.0), a(-1.0, 1.0))
}

/// Result of a run.
#[derive(Debug)]
struct RunResult {
    events: Vec<(TransitionKind, usize, f64)>,
    ending: String,
}

fn found(system: &System, method: &str) -> RunResult {
    let x = Vector::from_vec(system.start().unwrap());
    let options = options(method).escape(1e3);
    let start = Moment { t: 0.0, x };
    let mut orbit = match system.dynamics().begin(&start, UNTIL, &options, &[]) {
        Ok(orbit) => orbit,
        Err(error) => return failed(Vec::new(), &error),
    };
    let mut events = Vec::new();
    loop {
        match orbit.step() {
            // At a touch, a function comes to zero within rounding and turns back.
            Ok(OrbitProgress::Transition(at)) if at.kind != TransitionKind::Touch => {
                events.push((at.kind, at.contact, at.t));
                if events.len() == MAX_COMPARED {
                    let ending = "enough".to_owned();
                    return RunResult { events, ending };
                }
            }
            Ok(OrbitProgress::End(summary)) => {
                let ending = match summary.ending {
                    Ending::EndTime => "end time".to_owned(),
                    other => format!("{other:?}"),
                };
                return RunResult { events, ending };
            }
            Ok(_) => {}
            Err(error) => return failed(events, &error),
        }
    }
}

fn failed(events: Vec<(TransitionKind, usize, f64)>, error: &Error) -> RunResult {
    let name = format!("{error:?}");
    let ending = name.split(' ').next().unwrap().to_owned();
    RunResult { events, ending }
}

/// Whether both have the same events.
fn are_alike([one, other]: &[RunResult; 2]) -> bool {
    let is_alike = |(a, b): (&(TransitionKind, usize, f64), &(TransitionKind, usize, f64))| {
        (a.0, a.1) == (b.0, b.1) && (a.2 - b.2).abs() < TIME_TOLERANCE
    };
    // Where transitions accumulate, the last ones have fewer significant digits.
    let count = match one.ending.as_str() {
        "EventPileUp" => one.events.len().min(other.events.len()).saturating_sub(8),
        _ if one.events.len() != other.events.len() => return false,
        _ => one.events.len(),
    };
    one.ending == other.ending
        && one
            .events
            .iter()
            .zip(&other.events)
            .take(count)
            .all(is_alike)
}

/// Runs of random systems in pieces, against those in one.
#[derive(Default)]
struct InPieces {
    count: usize,
    /// Runs whose end differs by rounding alone.
    rounded: usize,
    different: Vec<String>,
}

fn in_pieces(seeds: std::ops::Range<u64>) -> InPieces {
    let mut all = InPieces::default();
    for seed in seeds {
        let text = text(&mut SplitMix::new(seed));
        let system = system(&text);
        for method in METHODS {
            // A run of too many events, or one that fails, has no end to compare.
            if found(&system, method).ending != "end time" {
                continue;
            }
            all.count += 1;
            let options = options(method).escape(1e3);
            let difference = |within| {
                let mut draw = SplitMix::new(seed ^ 0xC07);
                difference_in_pieces(&text, UNTIL, (&options, within), &mut draw)
            };
            if difference(0.0).is_none() {
                continue;
            }
            match difference(ROUNDED) {
                None => all.rounded += 1,
                Some(what) => all.different.push(format!("seed {seed}, {method}: {what}")),
            }
        }
    }
    all
}

/// Counts the events of so many random systems and their endings, and lists the systems for which
/// the methods differ.
fn compared(seeds: std::ops::Range<u64>) -> (usize, BTreeMap<String, usize>, Vec<String>) {
    let (mut events, mut different) = (0, Vec::new());
    let mut endings = BTreeMap::new();
    for seed in seeds {
        let text = text(&mut SplitMix::new(seed));
        let system = system(&text);
        let both = METHODS.map(|method| found(&system, method));
        events += both[0].events.len();
        *endings.entry(both[0].ending.clone()).or_insert(0) += 1;
        if !are_alike(&both) {
            let first = (0..MAX_COMPARED).find(|&k| {
                let [one, other] = [&both[0], &both[1]].map(|found| found.events.get(k));
                !matches!((one, other), (Some(a), Some(b)) if (a.0, a.1) == (b.0, b.1)
                    && (a.2 - b.2).abs() < TIME_TOLERANCE)
            });
            let shown = [&both[0], &both[1]].map(|found| {
                let from = first.unwrap_or(0).saturating_sub(1);
                let part: Vec<_> = found.events.iter().skip(from).take(4).collect();
                format!("{} events, {}: {part:?}", found.events.len(), found.ending)
            });
            different.push(format!(
                "seed {seed}, from event {first:?}: {shown:#?}\n{text}"
            ));
        }
    }
    (events, endings, different)
}

#[test]
fn both_methods_find_the_same_events_of_random_systems() {
    let (events, endings, different) = compared(0..400);
    assert!(different.is_empty(), "{}", different.join("\n"));
    let to_the_end = endings.get("end time").copied().unwrap_or(0);
    assert!(events > 4000 && to_the_end > 300, "{events} {endings:?}");
}

/// Checks that at most one in a hundred differs, and that by rounding.
fn check_pieces(all: &InPieces) {
    assert!(all.different.is_empty(), "{}", all.different.join("\n"));
    assert!(
        100 * all.rounded <= all.count,
        "{} of {}",
        all.rounded,
        all.count
    );
}

#[test]
fn runs_of_random_systems_in_pieces_are_those_in_one() {
    let all = in_pieces(0..150);
    check_pieces(&all);
    assert!(all.count > 200, "{}", all.count);
}

#[test]
#[ignore = "takes minutes; make random runs it"]
fn runs_of_ten_thousand_random_systems_in_pieces_are_those_in_one() {
    let all = in_pieces(0..10_000);
    let (count, rounded, different) = (all.count, all.rounded, all.different.len());
    println!("{count} runs, {rounded} rounded, {different} differ in pieces");
    check_pieces(&all);
}

#[test]
#[ignore = "takes minutes; make random runs it"]
fn both_methods_find_the_same_events_of_ten_thousand_random_systems() {
    let (events, endings, different) = compared(0..10_000);
    println!(
        "{events} events, {endings:?}, {} systems differ",
        different.len()
    );
    assert!(different.is_empty(), "{}", different.join("\n"));
}
