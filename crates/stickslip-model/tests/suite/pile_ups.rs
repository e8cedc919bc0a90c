//! Infinitely many transitions in finite time, from files, compared with closed forms, by both
//! methods.

use std::f64::consts::PI;

use stickslip::analysis::{AttractorKind, basin};
use stickslip::{AtPileUp, Ending, Error, Options};
use stickslip_model::study::recurrence;

use crate::run::{METHODS, Run, Transition, end, failed, options, simulated, simulated_by};

/// Options by which what piles up comes to rest.
fn rest(method: &str) -> Options {
    options(method).at_pile_up(AtPileUp::Rest)
}

/// A system with these states, contacts (name and boundary) and rates, and a start.
fn system(end: f64, contacts: &[(&str, &str)], rates: &[(&str, &str)], start: &[f64]) -> String {
    let contacts = contacts
        .iter()
        .map(|(name, boundary)| format!("[contacts.{name}]\nboundary = \"{boundary}\"\n"));
    let states: String = rates
        .iter()
        .map(|(state, _)| format!("{state} = \"\"\n"))
        .collect();
    let field = rates
        .iter()
        .map(|(state, rate)| format!("{state} = \"{rate}\"\n"));
    let start = rates
        .iter()
        .zip(start)
        .map(|((state, _), x)| format!("{state} = {x}\n"));
    format!(
        "name = \"case\"\n[time]\nend = {end}\n[states]\n{states}{}[field]\n{}[start]\n{}",
        contacts.collect::<String>(),
        field.collect::<String>(),
        start.collect::<String>()
    )
}

/// Filippov's spiral: |x| + |y| decreases at the rate 2 a.
fn spiral(a: f64, end: f64) -> String {
    let x = format!("-by_side(left, -{a}, {a}) + by_side(low, -52, 52)");
    let y = format!("-by_side(left, -52, 52) - by_side(low, -{a}, {a})");
    let contacts = [("left", "x"), ("low", "y")];
    system(end, &contacts, &[("x", &x), ("y", &y)], &[3.0, 3.0])
}

/// Twisting control, `x'' = push - 10 sgn x - b sgn x'`.
fn twisting(b: f64, push: &str, end: f64) -> String {
    let v = format!("{push} - by_side(place, -10, 10) - by_side(speed, -{b}, {b})");
    let contacts = [("place", "x"), ("speed", "v")];
    system(end, &contacts, &[("x", "v"), ("v", &v)], &[10.0, 10.0])
}

/// Time of its accumulation from (10, 10) without a push, and the ratio over two phases. It brakes
/// by `10 + b` away from the position and falls back by `10 - b`.
fn of_twisting(b: f64) -> (f64, f64) {
    let (away, back) = (10.0 + b, 10.0 - b);
    let highest = 10.0 + 50.0 / away;
    let speed = (2.0 * back * highest).sqrt();
    let ratio = (back / away).sqrt();
    let first = 10.0 / away + speed / back;
    let each = speed / away + speed / (away * back).sqrt();
    (first + each / (1.0 - ratio), ratio.sqrt())
}

/// The spiral moves a third contact to and fro, which reaches zero with it.
fn three_contacts() -> String {
    let rates = [
        ("x", "-by_side(a, -2, 2) + by_side(b, -52, 52)"),
        ("y", "-by_side(a, -52, 52) - by_side(b, -2, 2)"),
        ("z", "by_side(a, -50, 50) - by_side(c, -4, 4)"),
    ];
    let contacts = [("a", "x"), ("b", "y"), ("c", "z")];
    system(3.0, &contacts, &rates, &[3.0, 3.0, 0.5])
}

/// Flights above `x = 0` that keep the speed on return, and flights below that keep half of it.
fn flights(back: f64, contacts: &[(&str, &str)], more: &str) -> String {
    let x = "v + by_side(line, 3, 0)*max(v, 0)";
    let v = format!("-by_side(line, -1, {back}){more}");
    system(9.0, contacts, &[("x", x), ("v", &v)], &[0.0, 1.0])
}

/// Files, the names of the contacts whose transitions accumulate, the time, and the mean ratio of
/// successive phases if known.
fn cases() -> Vec<(String, &'static [&'static str], f64, Option<f64>)> {
    let (twisted, ratio) = of_twisting(3.0);
    let (strong, strong_ratio) = of_twisting(9.9);
    assert!((twisted - 12.264208764654).abs() < 1e-12, "{twisted}");
    vec![
        (spiral(2.0, 3.0), &["left", "low"], 1.5, Some(50.0 / 54.0)),
        // More than four thousand crossings.
        (spiral(0.1, 40.0), &["left", "low"], 30.0, Some(51.9 / 52.1)),
        (
            twisting(3.0, "0", 20.0),
            &["place", "speed"],
            twisted,
            Some(ratio),
        ),
        // The tolerance allows sixteen.
        (
            twisting(9.9, "0", 20.0),
            &["place", "speed"],
            strong,
            Some(strong_ratio),
        ),
        (three_contacts(), &["a", "b", "c"], 1.5, None),
    ]
}

#[test]
fn a_pile_up_is_reported_with_its_contacts_and_the_point() {
    for (text, contacts, t, ratio) in cases() {
        for method in METHODS {
            let run = Run::of(crate::run::system(&text), &options(method), None);
            let words = run.words();
            let names: Vec<String> = contacts.iter().map(|name| format!("`{name}`")).collect();
            let names = format!("transitions at {} within", names.join(", "));
            assert!(words.contains(&names), "{method}: {words}");
            assert!(words.ends_with("by at_pile_up = rest they rest"), "{words}");
            let Err(Error::EventPileUp { accumulation, .. }) = run.ended else {
                panic!("{method}: {words}");
            };
            let found = accumulation.unwrap();
            assert!(words.contains("at the accumulation point, t = "), "{words}");
            assert!((found.t - t).abs() < 2e-11, "{method}: {t}: {words}");
            assert!(found.uncertainty < 1e-10, "{method}: {words}");
            for x in &found.x.0 {
                assert!(x.abs() < 1e-11, "{method}: {words}");
            }
            if let Some(ratio) = ratio {
                assert!(
                    (found.ratio - ratio).abs() < 1e-5,
                    "{method}: {ratio}: {words}"
                );
            }
        }
    }
}

/// The entries into stick of one of `contacts`.
fn entries(transitions: &[Transition]) -> Vec<(f64, &str)> {
    let entries = transitions.iter().filter(|at| at.1 == "stick entry");
    entries
        .map(|(t, _, contact)| (*t, contact.as_str()))
        .collect()
}

#[test]
fn contacts_that_can_hold_rest_where_they_pile_up() {
    for (text, contacts, t, _) in cases() {
        for method in METHODS {
            let (found, transitions) = simulated_by(&text, &rest(method), None);
            assert_eq!(found.ending(), Ending::EndTime, "{method}");
            let entries = entries(&transitions);
            let names: Vec<&str> = entries.iter().map(|entry| entry.1).collect();
            assert_eq!(names, contacts, "{method}");
            for (at, name) in entries {
                assert!((at - t).abs() < 2e-11, "{method}: {name} at {at}, not {t}");
            }
            assert!(found.ended.unwrap().x.iter().all(|&x| x == 0.0), "{method}");
        }
    }
}

#[test]
fn what_rests_leaves_when_all_contacts_together_cannot_hold() {
    // The relay at the position takes 10 of the push and the velocity relay 3: together up to t =
    // 27.
    let text = twisting(3.0, "max(0, t - 14)", 28.0);
    for method in METHODS {
        let (found, transitions) = simulated_by(&text, &rest(method), None);
        let (entered, _) = of_twisting(3.0);
        for (t, _) in entries(&transitions) {
            assert!((t - entered).abs() < 1e-11, "{method}: {t}");
        }
        for (t, kind, _) in &transitions[transitions.len() - 2..] {
            assert_eq!(*kind, "stick exit", "{method}");
            assert!((t - 27.0).abs() < 1e-11, "{method}: {t}");
        }
        assert!((end(&found, "v") - 0.5).abs() < 1e-11, "{method}");
        assert!((end(&found, "x") - 1.0 / 6.0).abs() < 1e-11, "{method}");
    }
}

#[test]
fn a_jump_or_a_kink_leaves_what_rests_at_rest() {
    let rates = [
        ("x", "v"),
        ("v", "-by_side(place, -10, 10) - by_side(speed, -3, 3)"),
        ("u", "1"),
    ];
    let contacts = [("place", "x"), ("speed", "v")];
    let clock = "[jumps.clock]\nwhen = \"u - 13\"\nset = { u = \"0\" }\n";
    let step = "[inputs.step]\nshape = \"table\"\ntimes = [0, 13]\nvalues = [1, 0]\n\
                between = \"constant\"\n";
    for start in [[10.0, 10.0, 0.0], [0.0; 3]] {
        let case = system(20.5, &contacts, &rates, &start);
        let kinked = case.replace("u = \"1\"", "u = \"step\"");
        for (text, u) in [
            (format!("{case}{clock}"), 7.5),
            (format!("{kinked}{step}"), 13.0),
        ] {
            for method in METHODS {
                let (found, _) = simulated_by(&text, &rest(method), None);
                assert_eq!(found.ending(), Ending::EndTime, "{method}");
                assert_eq!((end(&found, "x"), end(&found, "v")), (0.0, 0.0), "{method}");
                assert!((end(&found, "u") - u).abs() < 1e-11, "{method}");
            }
        }
    }
}

#[test]
fn a_fast_clock_does_not_pile_up() {
    let clock = "[jumps.clock]\nwhen = \"u - 1e-9\"\nset = { u = \"u - 1e-9\", n = \"n + 1\" }\n";
    let text = system(1.0005e-6, &[], &[("u", "1")], &[0.0]);
    let text = format!("{text}{clock}[discrete]\nn = 0\n");
    for method in METHODS {
        let (found, _) = simulated(&text, method, None);
        assert_eq!(end(&found, "n"), 1000.0, "{method}");
    }
}

#[test]
fn a_body_beside_what_rests_slips_and_sticks_as_without_it() {
    let rates = [
        ("x", "v"),
        ("v", "-by_side(place, -10, 10) - by_side(speed, -3, 3)"),
        ("y", "w"),
        ("w", "-y - by_side(block, -0.1, 0.1)"),
    ];
    let contacts = [("place", "x"), ("speed", "v"), ("block", "w")];
    let text = system(40.0, &contacts, &rates, &[10.0, 10.0, 2.05, 0.0]);
    let held = system(40.0, &contacts, &rates, &[10.0, 10.0, 0.05, 0.0]);
    for method in METHODS {
        let (found, transitions) = simulated_by(&text, &rest(method), None);
        let of_block = transitions.iter().filter(|at| at.2 == "block");
        let of_block: Vec<(f64, &str)> = of_block.map(|at| (at.0, at.1)).collect();
        // Half turns of π, each of which reduces the amplitude of 2.05 by 0.2.
        assert_eq!(of_block.len(), 10, "{method}: {of_block:?}");
        for (half, (t, kind)) in of_block.iter().enumerate() {
            let expected = PI * (half + 1) as f64;
            assert!((t - expected).abs() < 1e-9, "{method}: {t}");
            assert_eq!(*kind, ["crossing", "stick entry"][usize::from(half == 9)]);
        }
        assert!((end(&found, "y") - 0.05).abs() < 1e-9, "{method}");
        assert_eq!((end(&found, "x"), end(&found, "v")), (0.0, 0.0), "{method}");
        // A contact that always sticks is at zero with the others.
        let words = failed(&held, &options(method));
        assert!(
            words.contains("transitions at `place`, `speed` within"),
            "{words}"
        );
        let (found, transitions) = simulated_by(&held, &rest(method), None);
        let names: Vec<&str> = entries(&transitions).iter().map(|entry| entry.1).collect();
        assert_eq!(names, ["place", "speed"], "{method}");
        assert_eq!(
            (end(&found, "x"), end(&found, "y")),
            (0.0, 0.05),
            "{method}"
        );
    }
}

#[test]
fn one_contact_rests_at_the_two_fold_where_its_crossings_accumulate() {
    // Runge–Kutta steps miss the kink of the field below at the top of a flight.
    for (method, within) in [("taylor", 1e-12), ("dop853", 1e-5)] {
        let line = [("line", "x")];
        let text = flights(1.0, &line, "");
        // Flights of 2 and 1 + 1/2 times the speed, which is then halved.
        let (found, transitions) = simulated_by(&text, &rest(method), None);
        let entries = entries(&transitions);
        assert_eq!(entries.len(), 1, "{method}");
        assert!((entries[0].0 - 7.0).abs() < within, "{method}: {entries:?}");
        assert_eq!((end(&found, "x"), end(&found, "v")), (0.0, 0.0), "{method}");
        assert_eq!(found.ending(), Ending::EndTime, "{method}");
        let is_two_fold = |run: &Run| matches!(run.ending(), Ending::TwoFold(_));
        assert!(is_two_fold(&simulated(&text, method, None).0), "{method}");
        // The pushes from above and below differ, so that their mean is not zero.
        let text = flights(2.0, &line, "");
        let (found, transitions) = simulated_by(&text, &rest(method), None);
        assert!(is_two_fold(&found), "{method}");
        assert!((found.ended.unwrap().t - 5.0).abs() < 1e-5, "{method}");
        assert!(transitions.iter().all(|at| at.1 == "crossing"), "{method}");
    }
}

#[test]
fn contacts_that_cannot_hold_end_the_run_with_the_words_for_that() {
    // As for one contact with different pushes, in a system with another contact far away.
    let contacts = [("line", "x"), ("far", "x - 100 + 0*v")];
    let text = flights(2.0, &contacts, " - by_side(far, 0, 1)");
    for (method, within) in [("taylor", 1e-12), ("dop853", 1e-5)] {
        for options in [options(method), rest(method)] {
            let run = Run::of(crate::run::system(&text), &options, None);
            let words = run.words();
            assert!(words.contains("transitions at `line` within"), "{words}");
            let Err(Error::EventPileUp { accumulation, .. }) = run.ended else {
                panic!("{method}: {words}");
            };
            let t = accumulation.unwrap().t;
            assert!((t - 5.0).abs() < within, "{method}: {words}");
            assert!(
                words.contains("nothing holds all of them at once"),
                "{words}"
            );
        }
    }
}

#[test]
fn crossings_on_the_way_to_a_pole_are_no_pile_up() {
    // `u' = u²` is infinite at 1, and y and z rotate by `-ln(1 - t)`. Their crossings accumulate
    // there geometrically, but the state diverges.
    let rates = [
        ("u", "u*u"),
        ("y", "u*z - by_side(line, -0.1, 0.1)"),
        ("z", "-u*y - by_side(other, -0.1, 0.1)"),
    ];
    let contacts = [("line", "y"), ("other", "z")];
    let text = system(2.0, &contacts, &rates, &[1.0, 0.0, 1.0]);
    for method in METHODS {
        let words = failed(&text, &options(method).escape(1e300));
        assert!(words.starts_with("the step collapsed"), "{method}: {words}");
    }
}

#[test]
fn a_run_may_end_between_the_last_crossing_and_the_accumulation_point() {
    // The last crossing that is followed is at 12.26420869.
    for method in METHODS {
        let text = twisting(3.0, "0", 20.0);
        let (found, transitions) = simulated_by(&text, &rest(method), 12.26420874);
        assert_eq!(found.ending(), Ending::EndTime, "{method}");
        assert_eq!(found.ended.as_ref().unwrap().t, 12.26420874, "{method}");
        assert!(entries(&transitions).is_empty(), "{method}");
        assert!(end(&found, "v").abs() < 1e-6, "{method}");
    }
}

#[test]
fn starts_whose_orbits_rest_belong_to_the_equilibrium_there() {
    let twisting = crate::run::system(&twisting(3.0, "0", 20.0));
    let at = |k: usize, half: f64| half * (0.5 * k as f64 - 0.75);
    let starts = (0..16).map(|k| [at(k % 4, 9.0), at(k / 4, 8.0)]);
    let settings = recurrence(&twisting, 2000.0);
    let found = basin(twisting.dynamics(), starts, &settings, &rest("taylor")).unwrap();
    let [attractor] = &found.attractors[..] else {
        panic!("{:?}", found.attractors);
    };
    assert_eq!(attractor.kind, AttractorKind::Equilibrium);
    assert!(found.reached.iter().all(|&reached| reached == 0));
}

#[test]
fn what_goes_on_through_an_accumulation_keeps_its_value() {
    // A rate that changes fast, beside a motion that comes to rest.
    let v = "0.4*sin(3*t) - 0.2*x - by_side(place, -2, 2) - by_side(speed, -1, 1)";
    let (contacts, rate) = ([("place", "x"), ("speed", "v")], "100*cos(20*t)");
    let rates = [("x", "v"), ("v", v), ("c", rate)];
    let text = system(10.0, &contacts, &rates, &[1.0, 0.0, 0.0]);
    for method in METHODS {
        for tolerance in [1e-8, 1e-12] {
            let options = Options {
                rtol: tolerance,
                ..rest(method).atol(tolerance)
            };
            let (run, transitions) = simulated_by(&text, &options, None);
            assert_eq!(transitions.last().unwrap().1, "stick entry");
            assert_eq!(run.ending(), Ending::EndTime);
            let off = end(&run, "c") - 5.0 * stickslip::math::sin(200.0);
            // The rate is a hundred times the size of the states.
            assert!(
                off.abs() < 10.0 * tolerance,
                "{method}, {tolerance}: {off:e}"
            );
        }
    }
}
