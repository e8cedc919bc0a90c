//! Systems from files against the events of the benchmark problems, which have thirty digits.
//! `data/references/problems.json` has the same parameters for other solvers.

use std::ops::ControlFlow;

use stickslip::dynamics::{OrbitProgress, OrbitUnderWay};
use stickslip::{Method, Options, TransitionKind};
use stickslip_model::file::{Source, SystemFile};
use stickslip_model::kernel::follow;

/// The boundary is `x - sin t`, and rates point towards it.
const MOVING: &str = r#"
name = "moving boundary"
[states]
x = ""
[contacts.edge]
boundary = "x - sin(t)"
[field]
x = "-0.5*edge"
"#;

/// Compares every event, by time and states, with the reference at two methods.
fn assert_meets(name: &str, file: &SystemFile, settings: &[(&str, f64)], run: (&[f64], f64, f64)) {
    let (start, t_start, t_end) = run;
    let settings: Vec<(String, f64)> = settings
        .iter()
        .map(|(k, v)| ((*k).to_owned(), *v))
        .collect();
    let system = file.with(&settings).unwrap();
    let path = format!(
        "{}/../../data/references/{name}.csv",
        env!("CARGO_MANIFEST_DIR")
    );
    let records: Vec<csv::StringRecord> = csv::Reader::from_path(path)
        .unwrap()
        .records()
        .map(Result::unwrap)
        .collect();
    for (method, tolerance, bound) in [
        (Method::Taylor, 1e-14, 1e-11),
        (Method::Dop853, 1e-12, 1e-8),
    ] {
        let options = Options::tol(tolerance).method(method);
        let mut events = Vec::new();
        let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
            if let OrbitProgress::Transition(at) = progress
                && at.kind != TransitionKind::Touch
            {
                events.push(at);
            }
            ControlFlow::Continue(())
        };
        let from = (t_start, start);
        follow(system.dynamics(), from, t_end, &options, &[], &mut watcher).unwrap();
        assert_eq!(events.len(), records.len(), "{name}, {method:?}");
        for (event, record) in events.iter().zip(&records) {
            let kind = match event.kind {
                TransitionKind::StickEntry => "entry",
                TransitionKind::StickExit => "exit",
                TransitionKind::Crossing => "crossing",
                _ => "other",
            };
            assert_eq!(kind, &record[2], "{name}, {method:?}: {event:?}");
            let found = std::iter::once(event.t).chain(event.x.iter().copied());
            for (one, wanted) in found.zip(record.iter().skip(3)) {
                let off = (one - wanted.parse::<f64>().unwrap()).abs();
                assert!(
                    off < bound,
                    "{name}, {method:?}: {event:?} is off by {off:e}"
                );
            }
        }
    }
}

#[test]
fn the_shipped_files_meet_every_reference() {
    let belt = SystemFile::open("belt").unwrap();
    let slow = [("vp", 0.4)];
    assert_meets("belt_sensitive", &belt, &slow, (&[0.5, 1.5], 0.0, 30.0));
    assert_meets("belt_periodic", &belt, &slow, (&[0.1, 0.0], 0.0, 30.0));
    assert_meets("belt_grazing", &belt, &slow, (&[0.483, 0.0], 0.0, 30.0));
    let decay = [("k1", -1.0), ("k2", 0.0), ("mu0", 1.0), ("vp", 0.2)];
    assert_meets("decay", &belt, &decay, (&[0.04, -0.01], 0.0, 40.0));
    let forced = SystemFile::open("forced").unwrap();
    assert_meets(
        "forced",
        &forced,
        &[],
        (&[0.0, 0.0], 0.0, 164.85333333333332),
    );
    let bracket = SystemFile::open("bracket").unwrap();
    assert_meets(
        "bracket",
        &bracket,
        &[],
        (&[-0.5, -0.5, 0.5, 0.3], 0.0, 60.0),
    );
    let (name, text) = ("moving.toml".to_owned(), MOVING.to_owned());
    let moving = SystemFile::parse(Source { name, text }).unwrap();
    assert_meets(
        "moving",
        &moving,
        &[],
        (&[1.0], std::f64::consts::FRAC_PI_2, 40.0),
    );
}
