//! Bifurcations that test functions do not show, as they are products over all eigenvalues: several
//! at once, and beside neutral directions.

use std::f64::consts::FRAC_PI_3;

use stickslip::analysis::{
    ContinuationSettings, CycleBifurcation, EquilibriumBifurcation, SpecialPoint,
};
use stickslip_model::study::{EquilibriaOfBranch, ParameterLine, PeriodicSearch};

use crate::run::{SEARCH, branch_through, options, orbit, orbit_from, system, with};

/// A map of states, as jumps once in a unit of time.
fn map(states: &[&str], set: &str) -> String {
    let each = |value: &str| -> String {
        let lines = states.iter().map(|name| format!("{name} = {value}\n"));
        lines.collect()
    };
    format!(
        "name = \"map\"\n[time]\nperiod = 1\n[states]\n{}[parameters]\np = -0.3\n[jumps.map]\n\
         when = \"sin(2*pi*t + 1)\"\ndirection = \"rising\"\nset = {{ {set} }}\n[field]\n{}\
         [start]\n{}",
        each("\"\""),
        each("\"0\""),
        each("0")
    )
}

/// Names of the special orbits on the branch of the fixed point 0, for `p` between `-width` and
/// `width`. All are at `p = 0`.
fn names_at_zero(text: &str, width: f64) -> Vec<String> {
    let (system, options) = (with(text, &[("p", -0.3 * width)]), options("taylor"));
    let orbit = orbit(&system, &options);
    let branch = branch_through(&system, &orbit, ("p", -width, width), 0.02, &options);
    let name = |at: &SpecialPoint| {
        assert!(
            at.parameter.abs() <= at.uncertainty + 1e-12 && at.uncertainty < 1e-9,
            "{text}\n{at:?}"
        );
        if let CycleBifurcation::NeimarkSacker { angle } = at.what {
            let known = [FRAC_PI_3, stickslip::math::atan2(0.8, 0.6)];
            assert!(
                known.iter().any(|one| (one - angle).abs() < 1e-9),
                "{angle}"
            );
        }
        at.what.to_string()
    };
    branch.special.iter().map(name).collect()
}

/// The multiplier of a flip is `-(1 + p)`, that of a pair `(1 + p) exp(±i angle)`.
#[test]
fn bifurcations_at_once_and_beside_neutral_multipliers_are_found() {
    let flip = |x: &str| format!("{x} = \"-(1 + p)*{x} - {x}^3\"");
    let pair = |[x, y]: [&str; 2], (factor, cos, sin): (&str, &str, &str)| {
        format!(
            "{x} = \"({factor})*({cos}*{x} - {sin}*{y})\", {y} = \"({factor})*({sin}*{x} + \
             {cos}*{y})\""
        )
    };
    let (third, other) = (("0.5", "sqrt(3)/2"), ("0.6", "0.8"));
    let torus = |[x, y]: [&str; 2], (cos, sin): (&str, &str)| {
        pair([x, y], (&format!("1 + p - {x}^2 - {y}^2"), cos, sin))
    };
    let neutral = |names, (cos, sin): (&str, &str)| pair(names, ("1", cos, sin));
    let cases = [
        (
            map(&["x", "y"], &format!("{}, {}", flip("x"), flip("y"))),
            vec!["flip"; 2],
        ),
        (
            map(
                &["x", "y", "z"],
                &[flip("x"), flip("y"), flip("z")].join(", "),
            ),
            vec!["flip"; 3],
        ),
        (
            map(&["x", "y"], &format!("{}, y = \"-y\"", flip("x"))),
            vec!["flip"],
        ),
        (
            map(
                &["x", "u", "v"],
                &format!("{}, {}", flip("x"), neutral(["u", "v"], other)),
            ),
            vec!["flip"],
        ),
        (
            map(
                &["x", "y", "u", "v"],
                &format!(
                    "{}, {}",
                    torus(["x", "y"], third),
                    neutral(["u", "v"], other)
                ),
            ),
            vec!["Neimark-Sacker"],
        ),
        (
            map(
                &["x", "y", "u", "v"],
                &format!("{}, {}", torus(["x", "y"], third), torus(["u", "v"], other)),
            ),
            vec!["Neimark-Sacker"; 2],
        ),
        (
            map(&["x", "y"], "x = \"x + p*x - x^3\", y = \"y + p*y - y^3\""),
            vec!["branch point"; 2],
        ),
        // Nothing is hidden here.
        (map(&["x"], &flip("x")), vec!["flip"]),
        (
            map(
                &["x", "u", "v"],
                &format!("x = \"0.5*x\", {}", neutral(["u", "v"], other)),
            ),
            vec![],
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(names_at_zero(&text, 0.3), expected, "{text}");
    }
    // All multipliers there are within 1e-5 of the unit circle.
    for (text, expected) in [
        (map(&["x"], &flip("x")), "flip"),
        (
            map(&["x", "y"], &torus(["x", "y"], third)),
            "Neimark-Sacker",
        ),
    ] {
        for width in [1e-5, 3e-5] {
            assert_eq!(names_at_zero(&text, width), [expected], "{text} {width:e}");
        }
    }
}

/// The equilibrium 0 from `p = -0.5` to 0.5.
fn equilibria(states: &[(&str, &str)]) -> EquilibriaOfBranch {
    let each = |value: &dyn Fn(&str) -> String| -> String {
        let lines = states
            .iter()
            .map(|(name, rate)| format!("{name} = {}\n", value(rate)));
        lines.collect()
    };
    let text = format!(
        "name = \"field\"\n[states]\n{}[parameters]\np = -0.5\n[field]\n{}[start]\n{}",
        each(&|_| "\"\"".to_owned()),
        each(&|rate| format!("\"{rate}\"")),
        each(&|_| "0".to_owned())
    );
    let (system, options) = (system(&text), options("taylor"));
    let along = ParameterLine::new(&system, "p", (-0.5, 0.5)).unwrap();
    let settings = ContinuationSettings::over(-0.5, 0.5);
    let start = system.start().unwrap();
    along.equilibria(&start, &settings, &options).unwrap()
}

/// Oscillators `x'' = p x' - w² x - x² x'` have a Hopf bifurcation at `p = 0` with the frequency w.
#[test]
fn hopf_bifurcations_at_once_and_beside_an_undamped_mode_are_found() {
    let one = [("x", "v"), ("v", "p*v - x - x^2*v")];
    let equal = [("y", "w"), ("w", "p*w - y - y^2*w")];
    let faster = [("y", "w"), ("w", "p*w - 4*y - y^2*w")];
    let undamped = [("y", "w"), ("w", "-4*y")];
    let real = [("y", "p*y - y^3"), ("w", "-w")];
    let pitchforks = [("y", "p*y - y^3"), ("w", "p*w - w^3")];
    let stable = [("y", "-y"), ("w", "-2*w")];
    let cases: [(_, &[f64], usize); 6] = [
        (equal, &[1.0, 1.0], 0),
        (faster, &[1.0, 2.0], 0),
        (undamped, &[1.0], 0),
        (real, &[1.0], 1),
        (pitchforks, &[1.0], 2),
        (stable, &[1.0], 0),
    ];
    for (other, expected, points) in cases {
        let branch = equilibria(&[one, other].concat());
        let mut frequencies: Vec<f64> = Vec::new();
        let mut found = 0;
        for at in &branch.special {
            // Where eigenvalues cross at different rates, their order changes there, and the slope.
            assert!(
                at.parameter.abs() < 1e-12 && at.uncertainty < 1e-5,
                "{at:?}"
            );
            match at.what {
                EquilibriumBifurcation::Hopf { frequency } => frequencies.push(frequency),
                EquilibriumBifurcation::BranchPoint => found += 1,
                _ => panic!("{at:?}"),
            }
        }
        frequencies.sort_by(f64::total_cmp);
        let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
        assert!(
            frequencies.len() == expected.len()
                && frequencies.iter().zip(expected).all(is_near)
                && found == points,
            "{other:?}: {frequencies:?} {found}"
        );
    }
}

/// A fold at `p = 0`. On both of its arms a pair of multipliers crosses the circle at `p = 1/2`.
const ARMS: &str = r#"
name = "arms"
[time]
period = 1
[states]
x = ""
y = ""
z = ""
w = ""
[parameters]
p = 1e-13
[field]
x = "p - x^2"
y = "(p - 0.5)*y - 2*z"
z = "2*y + (p - 0.5)*z"
w = "-w + cos(2*pi*t)"
[start]
x = 3.2e-7
y = 0
z = 0
w = 0
"#;

#[test]
fn both_arms_of_a_fold_at_the_start_keep_their_bifurcations() {
    let (system, options) = (system(ARMS), options("taylor"));
    let search = PeriodicSearch {
        transient: Some(0.0),
        ..SEARCH
    };
    let orbit = orbit_from(&system, 0.0, &search, &options);
    let branch = branch_through(&system, &orbit, ("p", -1.0, 1.0), 0.05, &options);
    let names: Vec<String> = branch
        .special
        .iter()
        .map(|at| at.what.to_string())
        .collect();
    assert_eq!(names, ["Neimark-Sacker", "fold", "Neimark-Sacker"]);
    for (at, exact) in branch.special.iter().zip([0.5, 0.0, 0.5]) {
        assert!(
            (at.parameter - exact).abs() <= at.uncertainty + 1e-12,
            "{at:?}"
        );
    }
}
