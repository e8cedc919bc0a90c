//! Phases that measured motion shows, beside those at the fit.

use stickslip::dynamics::Modes;
use stickslip::math;
use stickslip_model::file::SystemFile;
use stickslip_model::study::fit::{Fit, SeenPhase, Unknown, fit};

use super::fit::{exact, noisy, observable, record, request, times, unknown};
use super::run::parsed;

/// Kinetic and static friction, and the speed of the belt.
const KINETIC: f64 = 0.5;
const STATIC: f64 = 1.0;
const SPEED: f64 = 0.3;

/// A block of mass and stiffness 1 on a belt, which begins in stick.
const BLOCK: &str = r#"
name = "case"
[states]
x = ""
v = ""
[parameters]
kinetic = 0.5
static = 1
speed = 0.3
[contacts.belt]
boundary = "v - speed"
friction = "kinetic"
static = "static"
[field]
x = "v"
v = "-x - friction(belt)"
[start]
x = 0
v = "speed"
"#;

/// Position and velocity in closed form, and whether the block sticks. It sticks until the spring
/// pulls with the static friction. It slips as an oscillator about the kinetic one, until it is as
/// fast as the belt again.
fn motion(t: f64) -> ([f64; 2], bool) {
    let reach = STATIC - KINETIC;
    let slip = 2.0 * (std::f64::consts::PI - math::atan(reach / SPEED));
    let stick = 2.0 * reach / SPEED;
    let since = t - STATIC / SPEED;
    if since < 0.0 {
        return ([SPEED * t, SPEED], true);
    }
    let phase = since % (slip + stick);
    if phase < slip {
        let (sin, cos) = math::sin_cos(phase);
        let x = KINETIC + reach * cos + SPEED * sin;
        return ([x, SPEED * cos - reach * sin], false);
    }
    let x = KINETIC - reach + SPEED * (phase - slip);
    ([x, SPEED], true)
}

/// A fit of the kinetic friction, near its value, to the motion at times. One formula observes a
/// column of positions or of velocities.
fn fitted(text: &str, formula: &str, column: usize, times: &[f64], sigma: f64) -> Fit {
    let values: Vec<f64> = times.iter().map(|t| motion(*t).0[column]).collect();
    let columns = noisy(&[values], sigma, 5);
    let unknowns = vec![Unknown {
        bounds: (0.49, 0.51),
        ..unknown("kinetic", None)
    }];
    let observables = vec![observable(formula, Some(sigma))];
    let mut request = request(parsed(text), unknowns, observables);
    request.records.push(record(times, columns));
    fit(&request).unwrap_or_else(|error| panic!("{error}"))
}

fn letters(phases: &[SeenPhase]) -> String {
    let letters = phases.iter().map(|phase| Modes::from(phase.2).to_string());
    letters.collect()
}

/// The ends of the sticks that the motion has.
fn ends(times: &[f64]) -> Vec<f64> {
    let fine = (0..).map(|k| 1e-3 * f64::from(k));
    let fine: Vec<f64> = fine.take_while(|t| t < times.last().unwrap()).collect();
    let changes = fine
        .windows(2)
        .filter(|pair| motion(pair[0]).1 != motion(pair[1]).1);
    changes.map(|pair| pair[0]).collect()
}

#[test]
fn sticks_of_the_data_are_those_of_the_motion() {
    let times = times(150, 0.2);
    let ends = ends(&times);
    assert_eq!(ends.len(), 7);
    for (formula, column) in [("x", 0), ("v", 1), ("v - speed + 0.3", 1)] {
        let found = fitted(BLOCK, formula, column, &times, 0.004);
        let [seen] = &found.seen[..] else {
            panic!("{formula}: {:?}", found.seen);
        };
        assert!(
            seen.is_same() && letters(&seen.data) == "S-S-S-S-",
            "{formula}: {seen:?}"
        );
        // Near the end of a slip, the speed is below the noise for two rows.
        for (phase, end) in seen.data.iter().zip(&ends) {
            assert!((phase.1 - end).abs() < 0.6, "{formula}: {phase:?} {end}");
        }
        assert!(
            found.columns[0].off.is_empty(),
            "{:?}",
            found.columns[0].off
        );
    }
}

/// A model whose static friction is too low sticks more often.
#[test]
fn another_sequence_and_the_phases_that_are_off_are_named() {
    let times = times(150, 0.2);
    let text = BLOCK.replace("static = 1\n", "static = 0.7\n");
    let found = fitted(&text, "v", 1, &times, 0.004);
    let [seen] = &found.seen[..] else {
        panic!("{:?}", found.seen);
    };
    assert!(
        !seen.is_same() && letters(&seen.data) == "S-S-S-S-",
        "{seen:?}"
    );
    let [data, fit] = seen.sticks();
    let sticks = found.phases[0].iter().filter(|phase| phase.2.any_sticks());
    assert!(data == 4 && fit == sticks.count() && fit == 5, "{seen:?}");
    // The first stick is the same until the model lets go; then they differ.
    let off: Vec<usize> = found.columns[0].off.iter().map(|one| one.phase).collect();
    assert!(!off.contains(&0) && off.contains(&1), "{off:?}");
}

#[test]
fn many_rows_with_much_noise_show_the_sticks_of_positions() {
    let times = times(3000, 0.01);
    let found = fitted(BLOCK, "x", 0, &times, 0.02);
    let [seen] = &found.seen[..] else {
        panic!("{:?}", found.seen);
    };
    assert!(
        seen.is_same() && letters(&seen.data) == "S-S-S-S-",
        "{seen:?}"
    );
}

#[test]
fn what_shows_no_phases_is_told() {
    let few = times(150, 0.2);
    // Not the slip of the contact alone, or noise that hides it.
    for (formula, column, sigma) in [("x + v", 0, 0.004), ("x*v", 0, 0.004), ("v", 1, 0.6)] {
        let found = fitted(BLOCK, formula, column, &few, sigma);
        assert!(found.seen.is_empty(), "{formula}: {:?}", found.seen);
    }
}

/// Den Hartog's oscillator, and one with more friction than the bounds of the fit allow.
#[test]
fn a_stick_that_the_friction_of_the_model_cannot_give_is_told() {
    let times = times(400, 0.1);
    let model = SystemFile::open("den-hartog").unwrap();
    let sticky = model.source.text.replace("value = 0.2", "value = 0.7");
    for (formula, column) in [("x", 0), ("v", 1)] {
        let [same, other] = [&model, &parsed(&sticky)].map(|file| {
            let columns = exact(file, &["x", "v"], &times);
            let unknowns = vec![Unknown {
                bounds: (0.1, 0.3),
                ..unknown("S", Some(0.2))
            }];
            let observables = vec![observable(formula, Some(0.004))];
            let mut request = request(model.clone(), unknowns, observables);
            let columns = noisy(&columns[column..=column], 0.004, 3);
            request.records.push(record(&times, columns));
            let found = fit(&request).unwrap();
            let [seen] = &found.seen[..] else {
                panic!("{formula}: {:?}", found.seen);
            };
            (seen.is_same(), seen.sticks())
        });
        assert_eq!(same, (true, [0, 0]), "{formula}");
        assert!(
            !other.0 && other.1[0] > 0 && other.1[1] == 0,
            "{formula}: {other:?}"
        );
    }
}

/// Shipped systems at their own parameters, whose slips cross slowly or end slowly.
#[test]
fn noise_alone_is_no_other_sequence() {
    let (mut shown, mut others) = (0, Vec::new());
    for (name, friction, end) in [
        ("belt", "mu0", 20.0),
        ("den-hartog", "S", 40.0),
        ("forced", "mu0", 6.0),
        ("leine", "Fs", 40.0),
    ] {
        let file = SystemFile::open(name).unwrap();
        let times = times(400, end / 400.0);
        let curves = exact(&file, &["x", "v"], &times);
        let columns = ["x", "v"].iter().zip(&curves);
        let cases = columns.flat_map(|one| [1e-3, 3e-3, 1e-2, 5e-2].map(|part| (one, part)));
        for (((formula, curve), part), seed) in
            cases.flat_map(|case| (0..20).map(move |k| (case, k)))
        {
            let column = noisy(std::slice::from_ref(curve), part * spread(curve), seed);
            let observables = vec![observable(formula, None)];
            let mut request = request(file.clone(), vec![unknown(friction, None)], observables);
            request.records.push(record(&times, column));
            let found = fit(&request).unwrap();
            shown += found.seen.len();
            let other = found.seen.iter().find(|one| !one.is_same());
            others.extend(other.map(|one| (name, *formula, part, letters(&one.data))));
        }
    }
    assert!(
        shown >= 300 && 100 * others.len() <= shown,
        "{shown}: {others:?}"
    );
}

fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares = values.iter().map(|x| (x - mean) * (x - mean));
    (squares.sum::<f64>() / values.len() as f64).sqrt()
}
