//! Orbits from many starts, with the bits of single runs.

use std::ops::ControlFlow;

use stickslip::dynamics::{Moment, OrbitProgress, OrbitUnderWay, Vector, Watching};
use stickslip::{Method, Options};
use stickslip_model::file::{SettingError, System};
use stickslip_model::kernel::{follow, follow_all};
use stickslip_model::study::ensemble::by_system;

use super::run::system as read;

/// A block on a belt, whose speed is a parameter.
const BLOCK: &str = "name = \"block\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nvp = 0.2\n\
    [contacts.belt]\nboundary = \"v - vp\"\nfriction = \"0.4/(1 + 3*belt*(v - vp))\"\n[field]\n\
    x = \"v\"\nv = \"-x - 0.05*v - friction(belt)\"\n";

fn starts(count: usize) -> Vec<Moment> {
    let start = |k: usize| {
        let part = k as f64 / count as f64;
        let x = Vector::from_column_slice(&[2.0 * part - 1.0, 0.5 - part]);
        Moment { t: 0.25, x }
    };
    (0..count).map(start).collect()
}

/// Items that an orbit reports, and with `solutions` the state in the middle of each step.
fn noted(progress: &OrbitProgress, orbit: &mut dyn OrbitUnderWay, solutions: bool) -> String {
    let step = orbit.last_step();
    match progress {
        OrbitProgress::Step if solutions => {
            let middle = orbit.solution()(0.5 * (step.t_start + step.t_end));
            format!("{step:?} {middle:?}")
        }
        OrbitProgress::Step => format!("{step:?}"),
        other => format!("{other:?}"),
    }
}

/// Orbits alone, as their reports.
fn alone(system: &System, starts: &[Moment], options: &Options, solutions: bool) -> Vec<String> {
    let follow = |start: &Moment| {
        let mut all = String::new();
        let mut watcher = |progress, orbit: &mut dyn OrbitUnderWay| {
            all += &noted(&progress, orbit, solutions);
            ControlFlow::Continue(())
        };
        let from = (start.t, start.x.as_slice());
        let ended = follow(system.dynamics(), from, 8.0, options, &[], &mut watcher);
        format!("{all} {ended:?}")
    };
    starts.iter().map(follow).collect()
}

fn together(system: &System, starts: &[Moment], options: &Options, solutions: bool) -> Vec<String> {
    let mut all = vec![String::new(); starts.len()];
    let watcher = &mut |number: usize, progress, orbit: &mut dyn OrbitUnderWay| {
        all[number] += &noted(&progress, orbit, solutions);
        ControlFlow::Continue(())
    };
    let watching = Watching {
        sections: &[],
        solutions,
    };
    let ended = follow_all(system.dynamics(), starts, 8.0, options, watching, watcher);
    let both = all.into_iter().zip(ended);
    both.map(|(all, ended)| format!("{all} {ended:?}"))
        .collect()
}

#[test]
fn steps_events_and_solutions_are_those_of_single_runs() {
    let smooth = read(
        "name = \"smooth\"\n[states]\nx = \"\"\nv = \"\"\n[field]\nx = \"v\"\nv = \"-x - x^3\"\n",
    );
    for (system, has_contacts) in [(read(BLOCK), true), (smooth, false)] {
        for method in [Method::Taylor, Method::Dop853] {
            for solutions in [true, false] {
                let (options, starts) = (Options::tol(1e-10).method(method), starts(41));
                let found = together(&system, &starts, &options, solutions);
                assert_eq!(found, alone(&system, &starts, &options, solutions));
                let sticks = found.iter().filter(|all| all.contains("StickEntry"));
                assert_eq!(sticks.count() > 0, has_contacts);
            }
        }
    }
}

#[test]
fn an_orbit_that_the_watcher_ends_and_one_that_fails_keep_the_others() {
    let grows = read("name = \"grows\"\n[states]\nx = \"\"\n[field]\nx = \"x*x\"\n");
    let starts: Vec<Moment> = [0.1, 1.0, -1.0, f64::NAN, -2.0]
        .map(|x| Moment {
            t: 0.0,
            x: Vector::from_element(1, x),
        })
        .into();
    let mut ends = vec![0; starts.len()];
    let watcher = &mut |number: usize, progress, orbit: &mut dyn OrbitUnderWay| {
        ends[number] += usize::from(matches!(progress, OrbitProgress::PhaseEnd(_)));
        match number == 4 && orbit.t() > 0.0 {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let options = Options::tol(1e-9);
    let watching = Watching::default();
    let ended = follow_all(grows.dynamics(), &starts, 5.0, &options, watching, watcher);
    let times: Vec<Option<f64>> = ended
        .iter()
        .map(|end| end.as_ref().ok().map(|end| end.t))
        .collect();
    assert_eq!((times[0], times[1], times[2]), (Some(5.0), None, Some(5.0)));
    assert_eq!(times[3], None);
    assert!(times[4].is_some_and(|t| t > 0.0 && t < 5.0));
    let x = ended[2].as_ref().unwrap().x[0];
    assert!((x + 1.0 / 6.0).abs() < 1e-9, "{x}");
    // The phase of an orbit that is ended early ends, too, and one that cannot begin has none.
    assert_eq!(ends, [1, 1, 1, 0, 1]);
}

#[test]
fn blocks_have_every_orbit_once_with_its_own_parameters() {
    let system = read(BLOCK);
    let names = ["vp".to_owned()];
    let values: Vec<Vec<f64>> = (0..700).map(|k| vec![0.1 * f64::from(k % 3 + 1)]).collect();
    let found = by_system(&system, &names, &values, |system, numbers| {
        assert!(numbers.len() <= 128);
        let value = system.unwrap().values[0];
        numbers.iter().map(|&number| (number, value)).collect()
    });
    let wanted = values.iter().map(|row| row[0]).enumerate();
    assert_eq!(found, wanted.collect::<Vec<_>>());
    // Values that the system cannot have are those of their orbits alone.
    let ranged = read(&BLOCK.replace("vp = 0.2", "vp = { value = 0.2, range = [0, 1] }"));
    let mut outside = values.clone();
    outside[3][0] = 1.5;
    let built = by_system(&ranged, &names, &outside, |system, numbers| {
        vec![system.is_ok(); numbers.len()]
    });
    assert!(
        built
            .iter()
            .enumerate()
            .all(|(number, is)| *is == (number != 3))
    );
    let refused = by_system(&system, &["mu".to_owned()], &values, |system, numbers| {
        let unknown = matches!(system, Err(SettingError::Unknown { name, .. }) if name == "mu");
        vec![unknown; numbers.len()]
    });
    assert_eq!(refused, vec![true; 700]);
    let none: Vec<()> = by_system(&system, &[], &[], |_, numbers| vec![(); numbers.len()]);
    assert!(none.is_empty());
}
