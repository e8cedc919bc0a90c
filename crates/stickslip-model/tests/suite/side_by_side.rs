//! Orbits of a system from a file that are computed side by side are bit-for-bit the same as alone.

use std::sync::Arc;

use stickslip::analysis::{Attractor, AttractorKind, RecurrenceSettings};
use stickslip::dynamics::Interrupt;
use stickslip::{Error, Method, Options};
use stickslip_model::file::System;

use super::recorded::open;
use super::run::system as read;

/// Starts whose first two states fill a plane.
fn starts(system: &System, [x, y]: [(f64, f64); 2], side: usize) -> Vec<Vec<f64>> {
    let from = system.start().unwrap();
    let at =
        |(low, high): (f64, f64), k: usize| low + (high - low) * (k as f64 + 0.5) / side as f64;
    let start = |k: usize| {
        let mut start = from.clone();
        (start[0], start[1]) = (at(x, k % side), at(y, k / side));
        start
    };
    (0..side * side).map(start).collect()
}

/// Asserts that the orbits to the attractors are the same side by side and alone.
fn compare(name: &str, system: &System, starts: &[Vec<f64>], until: f64) {
    let settings = RecurrenceSettings {
        forcing: system.built.period,
        ..RecurrenceSettings::within(until)
    };
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-9).method(method);
        let system = system.dynamics();
        let each = starts.iter().map(Vec::as_slice);
        let together = Attractor::of_all(system, each, &settings, &options).unwrap();
        assert_eq!(together.len(), starts.len(), "{name}");
        for (start, together) in starts.iter().zip(together) {
            let alone = Attractor::of_any(system, start.as_slice(), &settings, &options).unwrap();
            // Texts differ if a bit of a number does, and NaN equals itself.
            let [alone, together] = [alone, together].map(|reached| format!("{reached:?}"));
            assert_eq!(together, alone, "{name} from {start:?}");
        }
    }
}

#[test]
fn with_one_contact_with_several_and_with_a_drive() {
    let basins = open("basins");
    let plane = [(-2.0, 2.0), (0.0, 2.0)];
    compare("basins", &basins, &starts(&basins, plane, 8), 500.0);
    let forced = open("forced");
    let plane = [(-0.4, 0.4), (-1.0, 1.0)];
    compare("forced", &forced, &starts(&forced, plane, 3), 60.0);
    let two = read(
        "name = \"two\"\n[time]\nend = 10\n[states]\nx = \"\"\ny = \"\"\nv = \"\"\nw = \"\"\n\
         [contacts.one]\nboundary = \"v - 0.2\"\nfriction = \"0.5/(1 + one*(v - 0.2))\"\n\
         [contacts.other]\nboundary = \"w - 0.3\"\nfriction = \"0.4/(1 + other*(w - 0.3))\"\n\
         [field]\nx = \"v\"\ny = \"w\"\nv = \"y - 2*x - friction(one)\"\n\
         w = \"x - 2*y - friction(other)\"\n[start]\nx = 0\ny = 0\nv = 0\nw = 0\n",
    );
    compare("two", &two, &starts(&two, [(-1.0, 1.0); 2], 4), 30.0);
}

#[test]
fn where_comparisons_differ_between_orbits_and_some_cannot_begin() {
    // The spring is another one beyond a stop and for negative x; the root ends at -2.
    let stop = read(
        "name = \"stop\"\n[time]\nend = 10\n[states]\nx = \"\"\nv = \"\"\n\
         [contacts.belt]\nboundary = \"v - 0.3\"\nfriction = \"0.4/(1 + belt*(v - 0.3))\"\n\
         [field]\nx = \"v\"\n\
         v = \"0.2*sqrt(x + 2) - x - 5*max(x - 0.4, 0) - 0.3*abs(x) - friction(belt)\"\n\
         [start]\nx = 0\nv = 0\n",
    );
    let starts = starts(&stop, [(-2.5, 2.0), (-1.0, 1.0)], 6);
    compare("stop", &stop, &starts, 60.0);
    let settings = RecurrenceSettings::within(60.0);
    let options = Options::tol(1e-9).method(Method::Taylor);
    let each = starts.iter().map(Vec::as_slice);
    let reached = Attractor::of_all(stop.dynamics(), each, &settings, &options).unwrap();
    let outside = |kind: &AttractorKind| {
        matches!(
            kind,
            AttractorKind::Failure(Error::StartOutsideDomain { .. })
        )
    };
    let failed = reached.iter().filter(|reached| outside(&reached.kind));
    assert_eq!(failed.count(), 6);
}

#[test]
fn with_jumps() {
    let impact = read(
        "name = \"impact\"\n[states]\nx = \"m\"\nv = \"m/s\"\n[parameters]\nr = 0.8\n\
         [time]\nend = 10\nperiod = 2\n\
         [field]\nx = \"v\"\nv = \"-x - 0.1*v + 0.5*cos(pi*t)\"\n\
         [jumps.bounce]\nwhen = \"x + 0.2\"\ndirection = \"falling\"\n\
         set = { x = \"-0.2\", v = \"-r*v\" }\n[start]\nx = 1\nv = 0\n",
    );
    let starts = starts(&impact, [(0.0, 1.0), (-0.5, 0.5)], 4);
    compare("impact", &impact, &starts, 40.0);
}

#[test]
fn an_interrupt_ends_all_of_them_at_their_next_step() {
    let basins = open("basins");
    let interrupt = Arc::new(Interrupt::default());
    let interrupted = basins.interrupted_by(interrupt.clone()).unwrap();
    let starts = starts(&basins, [(-2.0, 2.0), (0.0, 2.0)], 4);
    let reached = || {
        let settings = RecurrenceSettings::within(500.0);
        let options = Options::tol(1e-9).method(Method::Taylor);
        let each = starts.iter().map(Vec::as_slice);
        Attractor::of_all(interrupted.dynamics(), each, &settings, &options).unwrap()
    };
    let is_interrupted =
        |kind: &AttractorKind| matches!(kind, AttractorKind::Failure(Error::Interrupted { .. }));
    assert!(
        reached()
            .iter()
            .all(|reached| !is_interrupted(&reached.kind))
    );
    interrupt.raise();
    for reached in reached() {
        assert!(is_interrupted(&reached.kind), "{}", reached.kind);
        assert!(reached.t < 5.0, "{}", reached.t);
    }
}
