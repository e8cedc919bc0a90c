//! Attractors followed along a parameter, and the changes between them.

use stickslip::Error;
use stickslip::analysis::{
    AttractorChange, AttractorKind, Criticality, CycleBifurcation, WhatChanges,
};
use stickslip_model::file::System;
use stickslip_model::study::{AtValue, Diagram, Locates};

use crate::run::{options, system, with};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// The results at values of a parameter in their order, and the changes between them.
fn swept(
    system: &System,
    parameter: &str,
    values: &[f64],
    until: f64,
) -> (Vec<AtValue>, Vec<AttractorChange>) {
    let diagram = Diagram {
        system,
        parameter,
        until,
        duration: None,
        locates: Locates::default(),
        values: values.len() as u64,
        options: &options("taylor"),
    };
    let start = |here: &System| Ok::<_, Failure>(here.start().unwrap());
    let described = |error: &Error, _: &System| error.to_string();
    let (mut found, mut changes) = (Vec::<AtValue>::new(), Vec::new());
    for &value in values {
        let at = diagram.at(value, found.last(), start, &described);
        let (at, between) = at.unwrap();
        found.push(at);
        changes.extend(between);
    }
    (found, AttractorChange::merged(changes))
}

/// The changes between values of a parameter, with rising and with falling values.
fn both_ways(system: &System, parameter: &str, mut values: Vec<f64>) -> [Vec<AttractorChange>; 2] {
    let up = swept(system, parameter, &values, 2000.0).1;
    values.reverse();
    [up, swept(system, parameter, &values, 2000.0).1]
}

#[test]
fn the_edge_of_the_region_without_stops_is_located_by_sweeps() {
    let den_hartog = with(super::branches::DEN_HARTOG, &[("S", 0.5)]);
    let known = super::branches::frequency_of_the_edge(0.5);
    let values = (0..9).map(|k| 0.5 + 0.05 * f64::from(k)).collect();
    for changes in both_ways(&den_hartog, "O", values) {
        let located = changes.iter().filter_map(|change| match &change.what {
            WhatChanges::Sequence(change) => Some(change.parameter),
            _ => None,
        });
        let off = located.fold(f64::INFINITY, |off, at| off.min((at - known).abs()));
        assert!(off < 1e-9, "{off:e}: {changes:?}");
    }
}

/// The only change both ways is a boundary-equilibrium bifurcation at `exact`.
fn meets_the_boundary(system: &System, parameter: &str, values: [f64; 2], exact: f64) {
    for changes in both_ways(system, parameter, values.to_vec()) {
        let [change] = &changes[..] else {
            panic!("{changes:?}");
        };
        let WhatChanges::BoundaryEquilibrium { parameter, .. } = change.what else {
            panic!("{change:?}");
        };
        assert!((parameter - exact).abs() < 1e-12, "{parameter}");
    }
}

#[test]
fn an_end_in_an_equilibrium_on_the_boundary_is_located_by_sweeps() {
    let lags = system(super::branches::LAGS);
    meets_the_boundary(&lags, "b", [0.95, 1.05], 1.0);
    // On the boundary itself the run does not end in accumulating transitions.
    let on_it = with(super::branches::LAGS, &[("b", 1.0)]);
    let start = on_it.start().unwrap();
    let search = crate::run::SEARCH.orbit(&on_it, (0.0, &start), &options("taylor"));
    let error = search.unwrap_err().to_string();
    let equilibrium = "comes to the equilibrium (1, 1, 1)";
    assert!(error.contains(equilibrium), "{error}");
}

#[test]
fn a_wide_orbit_that_ends_in_an_equilibrium_on_the_boundary_does_not_graze() {
    let ocean = system(super::branches::OCEAN);
    for values in [[-0.07, -0.065], [-0.09, -0.03]] {
        meets_the_boundary(&ocean, "eps", values, -1.0 / 15.0);
    }
}

/// The logistic map as a jump once in a period. Its period doubles at 1 + √6 in both directions.
#[test]
fn a_flip_has_one_name_in_both_directions() {
    let text = "name = \"logistic\"\n[states]\nx = \"\"\n[parameters]\nr = 3.3\n[jumps.map]\n\
                when = \"sin(2*pi*(t - 0.3))\"\ndirection = \"rising\"\n\
                set = { x = \"exp(0.05)*r*x*(1 - x)\" }\n[field]\nx = \"-0.05*x\"\n[start]\n\
                x = 0.3\n[time]\nperiod = 1\n";
    for changes in both_ways(&system(text), "r", vec![3.4, 3.44, 3.48]) {
        let [change] = &changes[..] else {
            panic!("{changes:?}");
        };
        let WhatChanges::Multiplier {
            what,
            parameter,
            criticality,
            ..
        } = &change.what
        else {
            panic!("{change:?}");
        };
        assert_eq!(*what, CycleBifurcation::Flip);
        // The doubled orbit attracts.
        assert_eq!(*criticality, Some(Criticality::Supercritical));
        let off = parameter - (1.0 + 6.0_f64.sqrt());
        assert!(off.abs() < 1e-12, "{off:e}");
    }
}

/// Period one below the flip at 24.5166, period two above it. Each run starts from the previous
/// value's end.
#[test]
fn a_sweep_goes_on_from_the_state_behind_a_kink() {
    let buck = system(super::hybrid::BUCK);
    for values in [[22.0, 27.0], [27.0, 22.0]] {
        let (found, _) = swept(&buck, "E", &values, 0.4);
        for at in found {
            let expected = if at.value < 24.0 { 400e-6 } else { 800e-6 };
            let AttractorKind::Periodic { period, .. } = at.reached.kind else {
                panic!("{:?}", at.reached.kind);
            };
            assert!((period - expected).abs() < 1e-12, "{}: {period}", at.value);
        }
    }
}

/// A system of one state along p.
fn of_one(field: &str, period: &str, start: f64) -> String {
    format!(
        "name = \"case\"\n[states]\nx = \"\"\n[parameters]\np = 0\n[field]\nx = \"{field}\"\n\
         [start]\nx = {start}\n{period}"
    )
}

fn values(from: f64, to: f64, count: usize) -> Vec<f64> {
    let value = |k| from + (to - from) * k as f64 / (count - 1) as f64;
    (0..count).map(value).collect()
}

/// Folds at 2/3√3 of equilibria and of orbits that keep their phases: both directions jump.
#[test]
fn a_jump_between_attractors_of_the_same_phases_is_located() {
    let exact = 2.0 / 27.0_f64.sqrt();
    let forced = "-sin(t) + p + (x - cos(t)) - (x - cos(t))^3";
    let orbits = of_one(forced, "[time]\nperiod = \"2*pi\"\n", -1.3);
    let equilibria = of_one("p + x - x^3", "", -1.3);
    // Another state is 1e5 times as large.
    let beside = equilibria.replace("[parameters]", "P = \"\"\n[parameters]");
    let beside = beside.replace("[start]", "P = \"1e5 - P\"\n[start]\nP = 1e5");
    for text in [equilibria, orbits, beside] {
        let [up, down] = both_ways(&system(&text), "p", values(-1.0, 1.0, 21));
        for (changes, exact) in [(up, exact), (down, -exact)] {
            let [change] = &changes[..] else {
                panic!("{changes:?}");
            };
            let off = (change.what.parameter().unwrap() - exact).abs();
            assert!(off < 1e-9, "{change:?}: {off:e}");
        }
    }
}

/// Equilibria of `p - x - x³`, and orbits about them, have no change however coarse the values.
#[test]
fn attractors_that_move_smoothly_change_nowhere() {
    let forced = "-sin(t) + p - (x - cos(t)) - (x - cos(t))^3";
    let orbits = of_one(forced, "[time]\nperiod = \"2*pi\"\n", 0.0);
    let equilibria = of_one("p - x - x^3", "", 0.0);
    for text in [equilibria, orbits] {
        for count in [3, 21] {
            for changes in both_ways(&system(&text), "p", values(-1.0, 1.0, count)) {
                assert!(changes.is_empty(), "{changes:?}");
            }
        }
    }
}

/// An orbit without phases: the period doubles where `continue` has a flip.
#[test]
fn a_doubled_period_without_phases_is_a_flip() {
    let roessler = system(
        "name = \"Roessler\"\n[states]\nx = \"\"\ny = \"\"\nz = \"\"\n[parameters]\nc = 2.5\n\
         [field]\nx = \"-y - z\"\ny = \"x + 0.2*y\"\nz = \"0.2 + z*(x - c)\"\n[start]\nx = 1\n\
         y = 1\nz = 0\n",
    );
    let found = crate::run::branch(&roessler, ("c", 2.5, 3.0), &options("taylor"));
    let [flip] = crate::run::flips(&found)[..] else {
        panic!("{:?}", found.special);
    };
    for changes in both_ways(&roessler, "c", vec![2.6, 3.0]) {
        let [change] = &changes[..] else {
            panic!("{changes:?}");
        };
        let off = (change.what.parameter().unwrap() - flip.parameter).abs();
        assert!(off < 1e-9, "{change:?}: {off:e}");
    }
}

/// The map `x + p x - x^3`, once a period. From zero, which attracts for `p < 0`, the attractors
/// `+-sqrt(p)` branch off.
const PITCHFORK: &str = r#"
name = "pitchfork"
[time]
period = 1
[states]
x = ""
[parameters]
p = 0.1
[jumps.map]
when = "sin(2*pi*t + 1)"
direction = "rising"
set = { x = "x + p*x - x^3" }
[field]
x = "0"
[start]
x = 0.01
"#;

#[test]
fn a_diagram_leaves_an_orbit_that_has_become_unstable() {
    let values: Vec<f64> = (0..10).map(|k| f64::from(k) * 0.1 - 0.45).collect();
    for point in swept(&system(PITCHFORK), "p", &values, 2000.0).0 {
        let exact = point.value.max(0.0).sqrt();
        let off = point.reached.x[0].abs() - exact;
        assert!(point.reached.kind.is_attractor(), "{}", point.reached.kind);
        assert!(off.abs() < 1e-5, "{off:e} at {}", point.value);
    }
}

#[test]
fn a_diagram_follows_a_discrete_state_to_its_doubled_period() {
    let values: Vec<f64> = (0..10).map(|k| f64::from(k) * 0.1 - 0.45).collect();
    for point in swept(&system(crate::choices::FLIP), "p", &values, 2000.0).0 {
        let exact = point.value.max(0.0).sqrt();
        let off = point.reached.x[1].abs() - exact;
        assert!(point.reached.kind.is_attractor(), "{}", point.reached.kind);
        assert!(off.abs() < 1e-5, "{off:e} at {}", point.value);
    }
}

/// The circle of radius 1 attracts in the plane of `x` and `y`. Across it, zero does for `p < 0`.
/// From there the attractors `+-sqrt(p)` branch off.
const CIRCLE: &str = r#"
name = "circle"
[states]
x = ""
y = ""
z = ""
[parameters]
p = 0.1
[field]
x = "x - y - x*(x^2 + y^2)"
y = "x + y - y*(x^2 + y^2)"
z = "p*z - z^3"
[start]
x = 1
y = 0
z = 0
"#;

#[test]
fn a_diagram_leaves_an_unstable_orbit_without_a_drive() {
    let values = [-0.2, -0.1, 0.1, 0.2, 0.3];
    for point in swept(&system(CIRCLE), "p", &values, 2000.0).0 {
        let exact = point.value.max(0.0).sqrt();
        let off = point.reached.x[2].abs() - exact;
        assert!(point.reached.kind.is_attractor(), "{}", point.reached.kind);
        assert!(off.abs() < 1e-5, "{off:e} at {}", point.value);
    }
}

/// The fixed point `1 - 1/p` of the logistic map has the multiplier `2 - p`.
fn logistic() -> System {
    system(&PITCHFORK.replace("x + p*x - x^3", "p*x*(1 - x)"))
}

/// Shortly before `p = 3` every second point repeats long before all do.
#[test]
fn a_diagram_has_no_doubled_period_before_a_flip() {
    let values: Vec<f64> = (0..6).map(|k| 2.986 + 0.002 * f64::from(k)).collect();
    for point in swept(&logistic(), "p", &values, 2000.0).0 {
        let off = point.reached.x[0] - (1.0 - point.value.recip());
        let kind = &point.reached.kind;
        let is_single = matches!(kind, AttractorKind::Periodic { returns: 1, .. });
        assert!(is_single, "{kind} at {}", point.value);
        assert!(off.abs() < 1e-5, "{off:e} at {}", point.value);
    }
}

/// A driven circle, whose phase turns by `a` in a period: a torus.
const TORUS: &str = r#"
name = "torus"
[time]
period = 1
[states]
x = ""
y = ""
[parameters]
a = 0.44
[field]
x = "x - a*2*pi*y - x*(x^2 + y^2) + 0.1*cos(2*pi*t)"
y = "y + a*2*pi*x - y*(x^2 + y^2)"
[start]
x = 1
y = 0
"#;

/// Its phase drifts slowly and one way where `a` is near a fraction.
#[test]
fn a_torus_near_a_resonance_is_recurrent() {
    for point in swept(&system(TORUS), "a", &[0.42, 0.44, 0.46], 3000.0).0 {
        let kind = &point.reached.kind;
        let is_recurrent = matches!(kind, AttractorKind::Recurrent);
        assert!(is_recurrent, "{kind} at {}", point.value);
    }
}
