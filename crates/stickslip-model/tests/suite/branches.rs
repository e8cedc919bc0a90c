//! Branches of periodic orbits and of equilibria, from files, compared with closed forms.

use std::f64::consts::PI;

use numerics::SplitMix;
use stickslip::analysis::{
    AttractorKind, ContinuationSettings, CycleBifurcation, EquilibriumBifurcation,
    SpecialEquilibrium, Stability, Stop, basin,
};
use stickslip::{Options, math};
use stickslip_model::file::{Interface, System};
use stickslip_model::study::{
    EquilibriaOfBranch, ParameterLine, TwoSidedBranch, boundary_of, equilibrium, extremes,
    recurrence,
};

use crate::run::{
    METHODS, Names, SEARCH, branch, branch_through, options, orbit, orbit_from, system, with,
};

pub const DEN_HARTOG: &str = include_str!("../../systems/den-hartog.toml");

/// The branch through the orbit of a file with other values of some parameters.
fn followed(
    text: &str,
    settings: &[(&str, f64)],
    range: (&str, f64, f64),
) -> (System, TwoSidedBranch) {
    followed_by(text, settings, range, &options("taylor"))
}

fn followed_by(
    text: &str,
    settings: &[(&str, f64)],
    range: (&str, f64, f64),
    options: &Options,
) -> (System, TwoSidedBranch) {
    let system = with(text, settings);
    let branch = branch(&system, range, options);
    (system, branch)
}

/// Names and parameters of the special orbits.
fn special(branch: &TwoSidedBranch) -> Vec<(String, f64)> {
    let special = branch.special.iter();
    special
        .map(|at| (at.what.to_string(), at.parameter))
        .collect()
}

fn ends(branch: &TwoSidedBranch) -> [&'static str; 2] {
    branch.ends().map(|end| end.word)
}

/// Letters of the phases of each orbit.
fn phases(system: &System, branch: &TwoSidedBranch) -> Vec<String> {
    let points = branch.points.iter();
    points
        .map(|point| system.sequence(&point.orbit.sequence))
        .collect()
}

fn amplitude(frequency: f64, friction: f64) -> f64 {
    let v = 1.0 / (1.0 - frequency * frequency);
    let half = PI / frequency;
    let u = math::sin(half) / (frequency * (1.0 + math::cos(half)));
    (v * v - friction * friction * u * u).sqrt()
}

/// P17: along the frequency the period changes, too. The amplitude is Den Hartog's.
#[test]
fn a_driven_orbit_is_continued_in_its_own_period() {
    let (system, branch) = followed(DEN_HARTOG, &[("O", 0.8)], ("O", 0.6, 0.95));
    assert!(branch.special.is_empty());
    assert_eq!(ends(&branch), ["range", "range"]);
    assert!(branch.points.len() > 20);
    assert_eq!(branch.points[0].orbit.parameter, 0.6);
    let x = system.file.states.iter().position(|one| one.name == "x");
    for point in &branch.points {
        let frequency = point.orbit.parameter;
        let period = point.orbit.period;
        assert!((period - 2.0 * PI / frequency).abs() < 1e-13, "{period}");
        let known = amplitude(frequency, 0.2);
        let (low, high) = point.extremes[x.unwrap()];
        for (found, known) in [(high, known), (low, -known)] {
            let error = (found - known).abs();
            assert!(error < 1e-9, "O = {frequency}: {error:e}");
        }
    }
}

/// Friction at which Den Hartog's orbit without stops begins to stop. It turns back at its
/// amplitude A, with the acceleration A Ω² from spring and force. It sticks if friction exceeds
/// that.
fn edge(frequency: f64) -> f64 {
    let square = frequency * frequency;
    let v = 1.0 / (1.0 - square);
    let half = PI / frequency;
    let u = math::sin(half) / (frequency * (1.0 + math::cos(half)));
    (v * square).abs() / (1.0 + u * u * square * square).sqrt()
}

/// Frequency between 0.55 and 0.65 at which the edge has this friction.
pub fn frequency_of_the_edge(friction: f64) -> f64 {
    let (mut low, mut high) = (0.55, 0.65);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if edge(middle) < friction {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The edge along the frequency, which changes the drive's period. From above, the orbit loses its
/// stops there, so that they are among the phases below.
#[test]
fn the_edge_is_den_hartogs_along_the_frequency() {
    let known = frequency_of_the_edge(0.5);
    let set = [("O", 0.8), ("S", 0.5)];
    let (system, branch) = followed(DEN_HARTOG, &set, ("O", 0.5, 0.9));
    let found = branch.special.last().unwrap();
    let CycleBifurcation::Sequence(change) = &found.what else {
        panic!("{:?}", found.what);
    };
    let period = 2.0 * PI / known;
    for (value, wanted) in [
        (found.parameter, known),
        (found.period, period),
        (change.period, period),
    ] {
        assert!((value - wanted).abs() < 1e-9, "{value}, known {wanted}");
    }
    let [before, after] = [&change.before, &change.after].map(|modes| system.sequence(modes));
    assert!(
        before.contains('S') && !after.contains('S'),
        "{before}, {after}"
    );
}

/// P17.
#[test]
fn the_edge_of_the_region_without_stops_is_den_hartogs() {
    for frequency in [0.7, 0.8, 1.2, 1.5] {
        let known = edge(frequency);
        let set = [("O", frequency), ("S", 0.1)];
        let (system, branch) = followed(DEN_HARTOG, &set, ("S", 0.05, 0.95));
        let found = special(&branch);
        assert!(
            (found[0].1 - known).abs() < 1e-9,
            "O = {frequency}: {found:?}, known {known}"
        );
        let letters = phases(&system, &branch);
        let (below, above) = letters.split_at(branch.special[0].behind);
        assert!(!below.iter().any(|phases| phases.contains('S')));
        assert!(above.iter().all(|phases| phases.contains('S')));
    }
}

/// From an orbit with stops the branch reaches the same edge downwards, and rest upwards. A drive
/// of amplitude 1 does not move a block with friction 1.
#[test]
fn a_branch_of_orbits_with_stops_ends_at_neither_side_too_early() {
    let (_, branch) = followed(DEN_HARTOG, &[("S", 0.9)], ("S", 0.5, 1.2));
    let found = special(&branch);
    let [(name, edge_found)] = found.as_slice() else {
        panic!("{found:?}");
    };
    assert!(name.starts_with("crossing-sliding"), "{name}");
    assert!((edge_found - edge(0.7)).abs() < 1e-9, "{edge_found}");
    assert_eq!(ends(&branch), ["range", "rest"]);
    assert_eq!(branch.points[0].orbit.parameter, 0.5);
    let last = branch.points.last().unwrap().orbit.parameter;
    assert!((0.98..1.0).contains(&last), "{last}");
}

/// Den Hartog's orbit at S = 0.2 where its stick begins at the edge. It is released at x = -A with
/// cos(O t) = S - A, and comes to rest at x = A with cos(O t) = A - S. The multiplier is 1 there.
/// So rounding leaves nearby orbits open by 1e-5, and a location there uncertain by 1e-6. From afar
/// it is at least a thousand times as precise.
#[test]
fn a_change_at_which_the_multiplier_is_one_is_located_from_afar() {
    // From Newton's iteration with 40 digits; the test checks the equations.
    const FRICTION: f64 = 0.2;
    const FREQUENCY: f64 = 0.414_489_639_149_120_5;
    const AMPLITUDE: f64 = 1.164_133_099_064_008_3;
    let release = -math::acos(FRICTION - AMPLITUDE) / FREQUENCY;
    let rest = -math::acos(AMPLITUDE - FRICTION) / FREQUENCY;
    let forced = 1.0 / (1.0 - FREQUENCY * FREQUENCY);
    let begin = -AMPLITUDE + FRICTION - forced * (FRICTION - AMPLITUDE);
    let slope = forced * FREQUENCY * math::sin(FREQUENCY * release);
    let (cos, sin) = (math::cos(rest - release), math::sin(rest - release));
    let x = begin * cos + slope * sin + forced * (AMPLITUDE - FRICTION) - FRICTION;
    let v = slope * cos - begin * sin - forced * FREQUENCY * math::sin(FREQUENCY * rest);
    assert!((x - AMPLITUDE).abs() < 1e-14 && v.abs() < 1e-14, "{x} {v}");

    // Where the last orbit before the change lies depends on the range.
    for (low, high) in [(0.2, 0.8), (0.4, 0.8), (0.35, 0.72), (0.39, 0.8)] {
        let (_, branch) = followed(DEN_HARTOG, &[("O", 0.7)], ("O", low, high));
        let all = branch.special.iter();
        let switching = all.filter(|at| at.what.to_string() == "switching-sliding");
        let [at] = switching.collect::<Vec<_>>()[..] else {
            panic!("{low}: {:?}", branch.special);
        };
        let off = (at.parameter - FREQUENCY).abs();
        assert!(
            off < 1e-10 && off <= at.uncertainty && at.uncertainty < 1e-9,
            "{low}: {off} {}",
            at.uncertainty
        );
    }
}

/// A graze is noticed only if it is some tolerances deep; its location is the zero of the event
/// function. At S = 0.1, from Newton's iteration with 30 digits on the closed forms of the phases.
#[test]
fn where_phases_change_is_reported_within_the_uncertainty_at_any_tolerance() {
    const PLACES: [(&str, f64); 2] = [
        ("grazing-sliding", 0.295_290_401_103_174_5),
        ("adding-sliding", 0.304_210_379_955_270_2),
    ];
    for (tolerance, bound) in [(1e-8, 2e-9), (1e-10, 1e-10), (1e-12, 1e-10)] {
        let (set, range) = ([("S", 0.1), ("O", 0.3)], ("O", 0.29, 0.31));
        let options = Options {
            rtol: tolerance,
            atol: tolerance.into(),
            ..options("taylor")
        };
        let (_, branch) = followed_by(DEN_HARTOG, &set, range, &options);
        let special = &branch.special;
        assert_eq!(special.len(), PLACES.len(), "{tolerance}: {special:?}");
        for (at, (name, place)) in special.iter().zip(PLACES) {
            assert_eq!(at.what.to_string(), name);
            let (off, uncertainty) = ((at.parameter - place).abs(), at.uncertainty);
            assert!(
                off <= uncertainty && uncertainty < bound,
                "{tolerance}, {name}: {off:e} {uncertainty:e}"
            );
        }
    }
}

/// A continuation at a change of phases may lead back along the branch, which must not alternate.
#[test]
fn a_branch_goes_back_only_where_it_folds() {
    let (_, branch) = followed(DEN_HARTOG, &[("O", 0.7)], ("O", 0.2, 0.8));
    let found = special(&branch);
    assert!(found.len() >= 2);
    assert_eq!(ends(&branch)[0], "range");
    for (one, two) in found.iter().zip(&found[1..]) {
        assert!(one.0 != "fold" && two.1 - one.1 > 1e-4, "{found:?}");
    }
}

/// Two cycles at `r² = 1 ± √(1 + p)` meet at `p = -1`. The inner one shrinks to the focus at `p =
/// 0`.
#[test]
fn a_fold_of_a_system_from_a_file() {
    let file = r#"
name = "rings"
[states]
x = ""
y = ""
[parameters]
p = -0.5
[definitions]
grows = "p + 2*(x^2 + y^2) - (x^2 + y^2)^2"
[contacts.far]
boundary = "x - 50"
[field]
x = "x*grows - y"
y = "y*grows + x + by_side(far, 0, 1)"
[start]
x = 1.3
y = 0
"#;
    let (_, branch) = followed(file, &[], ("p", -1.5, 0.5));
    let found = special(&branch);
    assert_eq!((found.len(), found[0].0.as_str()), (1, "fold"));
    assert!((found[0].1 + 1.0).abs() < 1e-9, "{}", found[0].1);
    let Stop::Equilibrium {
        parameter,
        frequency,
    } = branch.stops[0]
    else {
        panic!("{:?}", branch.stops);
    };
    assert!(parameter.abs() < 1e-9 && (frequency - 1.0).abs() < 1e-9);
}

/// A circle of period 2π on a curved boundary, with a contact force of `p` and a pull of `x +
/// 1/10`. The orbit never leaves it for `p > 11/10`.
const SHEET: &str = r#"
name = "sheet"
[states]
x = ""
y = ""
z = ""
[parameters]
p = 1.3
[definitions]
forward = "x*(1 - x^2 - y^2) - y"
[contacts.sheet]
boundary = "z - x^2"
[field]
x = "forward"
y = "y*(1 - x^2 - y^2) + x"
z = "2*x*forward + x + 0.1 + by_side(sheet, p, -p)"
[start]
x = 0.5
y = 0.5
z = 2
"#;

#[test]
fn an_orbit_that_never_slips_is_found_and_followed_to_where_it_does() {
    let found = orbit(&system(SHEET), &options("taylor"));
    assert!((found.period - 2.0 * PI).abs() < 1e-9, "{}", found.period);
    let (system, branch) = followed(SHEET, &[], ("p", 1.0, 1.5));
    let found = special(&branch);
    assert_eq!((found.len(), found[0].0.as_str()), (1, "adding-sliding"));
    assert!((found[0].1 - 1.1).abs() < 1e-9, "{}", found[0].1);
    let letters = phases(&system, &branch);
    let all = branch.points.iter().zip(&letters);
    let slipping = all.filter(|(_, phases)| *phases != "S");
    assert!(slipping.clone().count() > 0 && letters.last().unwrap() == "S");
    for (point, _) in slipping {
        assert!(point.orbit.parameter < 1.1);
    }
}

/// For `z' = cos 2t + y/5 - K sgn z` the pull has the amplitude A, the root of (17/4)/(409/100).
/// For K < 0, the end of the branch, the system is not defined.
const RELAY: &str = r#"
name = "relay"
[time]
period = "pi"
[states]
y = ""
z = ""
[parameters]
K = { value = 1.5, range = [0, inf] }
[contacts.relay]
boundary = "z"
friction = "K"
[field]
y = "-0.3*y + cos(2*t)"
z = "cos(2*t) + 0.2*y - friction(relay)"
[start]
y = 0
z = 0
"#;

#[test]
fn a_branch_goes_through_two_changes_at_once_to_the_end_of_what_the_file_allows() {
    let (_, branch) = followed(RELAY, &[], ("K", 0.0, 3.0));
    let amplitude = (4.25_f64 / 4.09).sqrt();
    let vanishing = amplitude / (1.0 + 0.25 * PI * PI).sqrt();
    let found = special(&branch);
    let wanted = [
        ("crossing-sliding", vanishing),
        ("adding-sliding", amplitude),
    ];
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for ((name, parameter), (word, exact)) in found.iter().zip(wanted) {
        assert_eq!(name, word);
        assert!((parameter - exact).abs() < 1e-9, "{parameter} for {exact}");
    }
    let ends = [branch.points.first(), branch.points.last()];
    let [first, last] = ends.map(|point| point.unwrap().orbit.parameter);
    assert!(first >= 0.0 && last == 3.0);
}

/// The belt's speed is a multiple of the parameter: the change lies where the speed is the same.
/// The branch reaches both ends of its range with any multiple.
#[test]
fn a_branch_does_not_depend_on_the_unit_of_a_parameter_in_a_boundary() {
    let block = |multiple: f64| {
        format!(
            r#"name = "block"
[states]
x = ""
v = ""
[parameters]
q = {}
[definitions]
speed = "{multiple}*q"
[contacts.belt]
boundary = "v - speed"
friction = "0.4/(1 + 3*belt*(v - speed))"
[field]
x = "v"
v = "-x - 0.05*v - friction(belt)"
[start]
x = 0.5
v = 0
"#,
            0.5 / multiple
        )
    };
    let speeds = [1.0, 0.1, 2.0, 10.0].map(|multiple| {
        let range = [0.3, 0.7].map(|speed| speed / multiple);
        let (_, branch) = followed(&block(multiple), &[], ("q", range[0], range[1]));
        assert_eq!(ends(&branch), ["range", "range"], "{multiple}");
        let found = special(&branch);
        let [(name, place)] = found.as_slice() else {
            panic!("{multiple}: {found:?}");
        };
        assert_eq!(name, "switching-sliding");
        place * multiple
    });
    for speed in &speeds[1..] {
        assert!((speed - speeds[0]).abs() < 1e-10, "{speeds:?}");
    }
}

/// A branch along which a bad guess would require an endless orbit.
#[test]
fn a_long_branch_comes_to_its_end() {
    let text = include_str!("../../systems/leine.toml");
    let (_, branch) = followed(text, &[], ("vd", 0.05, 1.5));
    assert_eq!(ends(&branch), ["range", "range"]);
}

/// The block of the gallery's page on Popp's oscillator.
const POPP: &str = r#"name = "popp"
[states]
x = ""
v = ""
[parameters]
vb = 0.5
[contacts.belt]
boundary = "v - vb"
friction = "0.3/(1 + 1.42*belt*(v - vb)) + 0.1 + 0.01*(v - vb)^2"
[field]
x = "v"
v = "-x - friction(belt)"
[start]
x = 0
v = 0
"#;

#[test]
fn a_phase_that_vanishes_within_a_coarse_step_does_not_turn_the_branch() {
    let (popp, options) = (system(POPP), options("taylor"));
    let orbit = orbit(&popp, &options);
    // Where the slope of the friction vanishes.
    let slope = |v: f64| 0.02 * v * (1.0 + 1.42 * v) * (1.0 + 1.42 * v) - 0.426;
    let (mut low, mut high) = (0.1, 3.0);
    while high - low > 1e-13 {
        let middle = 0.5 * (low + high);
        *(if slope(middle) < 0.0 {
            &mut low
        } else {
            &mut high
        }) = middle;
    }
    let mut places: Vec<Vec<f64>> = Vec::new();
    for step in [0.05, 0.04, 0.03, 0.02] {
        let found = branch_through(&popp, &orbit, ("vb", 0.1, 3.0), step, &options);
        assert_eq!(ends(&found), ["range", "equilibrium"], "{step}");
        let Stop::Equilibrium { parameter, .. } = found.stops[1] else {
            panic!("{:?}", found.stops);
        };
        assert!((parameter - high).abs() < 1e-9, "{step}: {parameter}");
        // The field of one side is tangent to the boundary: x is the friction at rest.
        let expected = [
            ("switching-sliding", -0.4),
            ("switching-sliding", -0.4),
            ("grazing-sliding", 0.4),
        ];
        assert_eq!(
            found.special.len(),
            expected.len(),
            "{step}: {:?}",
            found.special
        );
        for (at, (name, x)) in found.special.iter().zip(expected) {
            let CycleBifurcation::Sequence(change) = &at.what else {
                panic!("{at:?}");
            };
            assert_eq!(at.what.to_string(), name, "{step}");
            assert!((change.x[0] - x).abs() < 1e-11, "{step}: {change:?}");
            assert!(
                (change.x[1] - at.parameter).abs() < 1e-11,
                "{step}: {change:?}"
            );
            assert!(at.uncertainty < 1e-9, "{step}: {at:?}");
        }
        places.push(found.special.iter().map(|at| at.parameter).collect());
    }
    for coarse in &places[..3] {
        for (one, other) in coarse.iter().zip(&places[3]) {
            assert!((one - other).abs() < 1e-9, "{places:?}");
        }
    }
}

/// The equilibria of a file along a parameter, through the one that the run comes to.
fn equilibria(text: &str, (name, low, high): (&str, f64, f64)) -> (System, EquilibriaOfBranch) {
    let (system, options) = (system(text), options("taylor"));
    let start = system.start().unwrap();
    let x = equilibrium(&system, &start, None, &options).unwrap();
    let settings = ContinuationSettings {
        step: 0.02,
        ..ContinuationSettings::over(low, high)
    };
    let along = ParameterLine::new(&system, name, (low, high)).unwrap();
    let branch = along.equilibria(&x, &settings, &options).unwrap();
    (system, branch)
}

/// Sizes at the start say nothing of the branch: `x = p²` passes zero, and `300 ± √p` turns.
#[test]
fn branches_of_equilibria_near_zero_and_beside_an_offset_go_to_the_ends_of_the_range() {
    let file = |rate: &str, p: f64, start: f64| {
        format!(
            "name = \"field\"\n[states]\nx = \"\"\n[parameters]\np = {p:e}\n[field]\n\
             x = \"{rate}\"\n[start]\nx = {start:e}\n"
        )
    };
    let (_, parabola) = equilibria(&file("p^2 - x", 1e-3, 1e-6), ("p", -1.0, 1.0));
    assert_eq!(parabola.stops, [Stop::Range, Stop::Range]);
    assert!(parabola.special.is_empty());
    for at in &parabola.points {
        assert!(
            (at.x[0] - at.parameter * at.parameter).abs() < 1e-14,
            "{at:?}"
        );
    }
    for size in [1.0, 1e-3] {
        let (p, start) = (0.25 * size * size, 300.0 + 0.5 * size);
        let text = file("p - (x - 300)^2", p, start);
        let width = size * size;
        let (_, turns) = equilibria(&text, ("p", -width, width));
        assert_eq!(turns.stops, [Stop::Range, Stop::Range], "{size}");
        let [fold] = turns.special.as_slice() else {
            panic!("{size}: {:?}", turns.special);
        };
        assert_eq!(fold.what, EquilibriumBifurcation::Fold);
        assert!(
            fold.parameter.abs() <= fold.uncertainty + 1e-12 * width,
            "{fold:?}"
        );
    }
}

/// A focus at (p, 0) below x = 0; above it the field (-1, -1). For p < 0 there is also an
/// equilibrium of sliding at y = 1.3 p / 0.7. At p = 0 both vanish.
const MEETS: &str = r#"
name = "meets"
[states]
x = ""
y = ""
[parameters]
p = -0.3
[definitions]
above = "by_side(wall, 0, 1)"
[contacts.wall]
boundary = "x"
[field]
x = "(1 - above)*(-0.3*(x - p) - y) - above"
y = "(1 - above)*((x - p) - 0.3*y) - above"
[start]
x = -0.4
y = 0.1
"#;

#[test]
fn a_nonsmooth_fold_turns_the_branch_back_on_the_boundary() {
    let (system, branch) = equilibria(MEETS, ("p", -0.5, 0.5));
    let [fold] = branch.special.as_slice() else {
        panic!("{:?}", branch.special);
    };
    assert!(fold.parameter.abs() < 1e-12, "{fold:?}");
    assert_eq!(boundary_of(fold, &system).1, ["-", "S"]);
    assert!(matches!(
        fold.what,
        EquilibriumBifurcation::Boundary { turns: true, .. }
    ));
    let ends = [branch.points.first(), branch.points.last()];
    assert_eq!(ends.map(|at| at.unwrap().parameter), [-0.5, -0.5]);
    for at in &branch.points {
        let (p, x, y) = (at.parameter, at.x[0], at.x[1]);
        let exact = match &*system.sequence(&[at.mode]) {
            "-" => [p, 0.0],
            _ => [0.0, 1.3 * p / 0.7],
        };
        assert!(
            (x - exact[0]).abs().max((y - exact[1]).abs()) < 1e-12,
            "{at:?}"
        );
    }
}

/// `x' = p + x - x³` folds at `x = ±1/√3`.
#[test]
fn folds_of_equilibria_turn_the_branch_where_the_slope_is_zero() {
    let cubic = "name = \"cubic\"\n[states]\nx = \"\"\n[parameters]\np = -0.8\n[field]\n\
                 x = \"p + x - x^3\"\n[start]\nx = -1\n";
    let (_, branch) = equilibria(cubic, ("p", -1.0, 1.0));
    let exact = 2.0 / (3.0 * 3.0_f64.sqrt());
    let special = &branch.special;
    assert_eq!(special.len(), 2, "{special:?}");
    for (at, (p, x)) in special.iter().zip([(exact, -1.0), (-exact, 1.0)]) {
        assert_eq!(at.what, EquilibriumBifurcation::Fold);
        assert!((at.parameter - p).abs() < 1e-12, "{at:?}");
        assert!((at.x[0] - x / 3.0_f64.sqrt()).abs() < 1e-6, "{at:?}");
        assert!(at.uncertainty < 1e-9, "{at:?}");
    }
    assert_eq!(branch.points.last().unwrap().parameter, 1.0);
    for at in &branch.points {
        let x = at.x[0];
        assert!((at.parameter + x - x * x * x).abs() < 1e-12);
        let is_stable = at.stability() == Stability::Stable;
        assert_eq!(is_stable, x * x > 1.0 / 3.0, "{at:?}");
    }
}

/// A pressure and a length, `z' = z (1 - (z/s)²) + a` with `y = z + r (p - P)`. The folds are those
/// of `z` alone, at `|a| = 2 s/(3 √3)`, whatever the size `P` of the pressure is.
fn pressure_and_length([pressure, length]: [f64; 2], driven: bool) -> String {
    let (ratio, drive) = (0.01 * length / pressure, if driven { 0.1 } else { 0.0 });
    let period = if driven {
        "[time]\nperiod = \"2*pi\"\n"
    } else {
        ""
    };
    format!(
        "name = \"sizes\"\n{period}[states]\np = \"Pa\"\ny = \"m\"\n[parameters]\na = 0\n\
         [definitions]\nrate = \"{pressure:?}*(1 + {drive:?}*sin(t)) - p\"\n\
         z = \"y - {ratio:?}*(p - {pressure:?})\"\n\
         [field]\np = \"rate\"\ny = \"z*(1 - (z/{length:?})^2) + a + {ratio:?}*rate\"\n\
         [start]\np = {pressure:?}\ny = {length:?}\n"
    )
}

/// Pressures and lengths of very different sizes.
const SIZES: [[f64; 2]; 4] = [[1.0, 1.0], [1.0, 1e-4], [1e5, 1e-4], [1e3, 1e-2]];

fn are_both_folds<'s>(special: impl Iterator<Item = (&'s str, f64)>, length: f64) {
    let exact = 2.0 / (3.0 * 3.0_f64.sqrt());
    let found: Vec<_> = special.map(|(name, at)| (name, at / length)).collect();
    let [(one, up), (other, down)] = found.as_slice() else {
        panic!("{length} {found:?}");
    };
    assert_eq!([*one, *other], ["fold", "fold"]);
    assert!(
        (up - exact).abs().max((down + exact).abs()) < 1e-9,
        "{found:?}"
    );
}

#[test]
fn folds_of_orbits_are_found_whatever_the_sizes_of_states_are() {
    for [pressure, length] in SIZES {
        let text = pressure_and_length([pressure, length], true);
        let (_, branch) = followed(&text, &[], ("a", -length, length));
        assert_eq!(ends(&branch), ["range", "range"], "{pressure} {length}");
        let found = special(&branch);
        are_both_folds(found.iter().map(|(name, at)| (name.as_str(), *at)), length);
    }
}

#[test]
fn folds_of_equilibria_are_found_whatever_the_sizes_of_states_are() {
    for [pressure, length] in SIZES {
        let text = pressure_and_length([pressure, length], false);
        let (_, branch) = equilibria(&text, ("a", -length, length));
        assert_eq!(
            branch.stops,
            [Stop::Range, Stop::Range],
            "{pressure} {length}"
        );
        let fold = |at: &SpecialEquilibrium| at.what == EquilibriumBifurcation::Fold;
        assert!(branch.special.iter().all(fold), "{:?}", branch.special);
        let special = branch.special.iter();
        are_both_folds(special.map(|at| ("fold", at.parameter)), length);
    }
}

/// At `a = 0` the equilibrium of the sliding field reaches a two-fold, where it is 0/0. Below it
/// sliding repels, and beyond `a = -1` the boundary is crossed.
#[test]
fn a_branch_of_sliding_equilibria_ends_at_a_two_fold() {
    let text = r#"
name = "two-fold"
[states]
x = ""
y = ""
z = ""
[parameters]
a = 0.513
[contacts.c]
boundary = "x"
[field]
x = { below = "y", above = "-z - z^2" }
y = { below = "1 + a - y", above = "-1 + a - y" }
z = "a - z"
[start]
x = 0
y = 0.5
z = 0.5
"#;
    let (system, branch) = equilibria(text, ("a", -1.9, 1.0));
    let [at] = branch.special.as_slice() else {
        panic!("{:?}", branch.special);
    };
    assert!(matches!(
        at.what,
        EquilibriumBifurcation::Boundary { after: None, .. }
    ));
    assert!(at.parameter.abs() <= at.uncertainty, "{at:?}");
    assert!(at.uncertainty < 1e-5, "{at:?}");
    assert_eq!(boundary_of(at, &system).1, ["S", ""]);
    assert!(branch.points.iter().all(|point| point.parameter > 0.0));
}

/// An equilibrium of cubic fields on both sides of `x = 0` lies where its mode holds: on its side,
/// or where both fields point to the boundary.
#[test]
fn equilibria_of_random_fields_lie_where_their_modes_hold() {
    const STATES: [&str; 3] = ["x", "y", "z"];
    const LAST: f64 = 1e-9;
    let mut random = SplitMix::new(4);
    let (mut followed, mut sliding, mut ended) = (0, 0, 0);
    for number in 0..40 {
        let monomials = |[x, y, z]: [f64; 3], a: f64| {
            let squares = [x * x, x * y, x * z, y * y, y * z, z * z];
            let cubes = [x * x * x, y * y * y, z * z * z];
            let linear = [1.0, x, y, z, a];
            [&linear[..], &squares, &cubes].concat()
        };
        let names = "1 x y z a x*x x*y x*z y*y y*z z*z x^3 y^3 z^3";
        let names: Vec<&str> = names.split(' ').collect();
        let sides = [0.5, -0.5].map(|towards| {
            [0, 1, 2].map(|row| {
                let mut all: Vec<f64> = names.iter().map(|_| random.between(-1.0, 1.0)).collect();
                all[11..].fill(0.0);
                all[11 + row] = -1.0;
                all[1 + row] -= 0.5;
                all[0] += if row == 0 { towards } else { 0.0 };
                all
            })
        });
        let text = |row: &Vec<f64>| {
            let terms = row.iter().zip(&names);
            let terms: Vec<String> = terms.map(|(c, name)| format!("({c}) * {name}")).collect();
            terms.join(" + ")
        };
        let mut file = "name = \"cubic\"\nstates = { x = \"\", y = \"\", z = \"\" }\n\
                        parameters = { a = 0 }\nstart = { x = 0.1, y = 0.1, z = 0.1 }\n\
                        [contacts.c]\nboundary = \"x\"\n[field]\n"
            .to_owned();
        for (k, state) in STATES.iter().enumerate() {
            let [below, above] = [0, 1].map(|side| text(&sides[side][k]));
            file += &format!("{state} = {{ below = \"{below}\", above = \"{above}\" }}\n");
        }
        let (system, options) = (system(&file), options("taylor"));
        // Some of them come to no equilibrium.
        let Ok(x) = equilibrium(&system, &system.start().unwrap(), None, &options) else {
            continue;
        };
        let along = ParameterLine::new(&system, "a", (-2.0, 2.0)).unwrap();
        let settings = ContinuationSettings::over(-2.0, 2.0);
        let Ok(branch) = along.equilibria(&x, &settings, &options) else {
            continue;
        };
        followed += 1;
        let is_end = |stop: &Stop| matches!(stop, Stop::BoundaryEquilibrium { .. });
        ended += branch.stops.iter().filter(|stop| is_end(stop)).count();
        for at in &branch.points {
            let terms = monomials([at.x[0], at.x[1], at.x[2]], at.parameter);
            let across = [0, 1].map(|side: usize| {
                let row = sides[side][0].iter().zip(&terms);
                row.map(|(c, term)| c * term).sum::<f64>()
            });
            let holds = match &*system.sequence(&[at.mode]) {
                "-" => at.x[0] <= LAST,
                "+" => at.x[0] >= -LAST,
                _ => {
                    sliding += 1;
                    across[0] >= -LAST && across[1] <= LAST
                }
            };
            assert!(holds, "{number}: {at:?}, {across:?}");
        }
    }
    assert!(
        followed > 10 && sliding > 100 && ended > 3,
        "{followed} {sliding} {ended}"
    );
}

/// C7: friction of a treadmill, `fc + (fs - fc) exp(-w) + fv w` with a negative fc.
const TREADMILL: &str = include_str!("../data/treadmill.toml");

/// At rest the belt slips at p. The Hopf point is where the friction's slope there is zero, at
/// ln(25/3), with the frequency of the spring. At p = 0 the belt stops, and static friction holds
/// the block in an interval. Beyond it the block rests on the other side.
#[test]
fn hopf_point_and_boundary_equilibria_of_a_stribeck_oscillator_are_closed_forms() {
    let (system, branch) = equilibria(TREADMILL, ("p", -4.0, 4.0));
    let exact = math::ln(25.0 / 3.0);
    let (mut hopf, mut boundary) = (Vec::new(), Vec::new());
    for at in &branch.special {
        match at.what {
            EquilibriumBifurcation::Hopf { frequency } => hopf.push((at, frequency)),
            EquilibriumBifurcation::Boundary { turns: false, .. } => boundary.push(at),
            _ => panic!("{at:?}"),
        }
    }
    assert_eq!((hopf.len(), boundary.len()), (2, 2));
    for ((at, frequency), exact) in hopf.iter().zip([-exact, exact]) {
        assert!((at.parameter - exact).abs() < 1e-12, "{at:?}");
        assert!((frequency - 1.0).abs() < 1e-12 && at.uncertainty < 1e-8);
    }
    for (at, (modes, u)) in boundary.iter().zip([(["+", "S"], -2.0), (["S", "-"], 2.0)]) {
        assert!(at.parameter.abs() < 1e-12, "{at:?}");
        assert_eq!(boundary_of(at, &system).1, modes);
        assert!((at.x[0] - u).abs() < 1e-12, "{at:?}");
    }
    for at in &branch.points {
        let (p, u) = (at.parameter, at.x[0]);
        let friction = |w: f64| -0.5 + 2.5 * math::exp(-w) + 0.3 * w;
        let mode = system.sequence(&[at.mode]);
        match &*mode {
            "-" => assert!(p >= 0.0 && (u - friction(p)).abs() < 1e-12, "{at:?}"),
            "+" => assert!(p <= 0.0 && (u + friction(-p)).abs() < 1e-12, "{at:?}"),
            _ => assert!(p.abs() < 1e-12 && u.abs() <= 2.0 + 1e-12, "{at:?}"),
        }
        if mode != "S" {
            let is_stable = at.stability() == Stability::Stable;
            assert_eq!(is_stable, p.abs() > exact, "{at:?}");
        }
    }
    assert_eq!(branch.stops, [Stop::Range, Stop::Range]);
}

/// Three lags under a relay. Either side's equilibrium is on the boundary where the threshold is
/// ±1, and the orbit shrinks to it.
pub const LAGS: &str = include_str!("../data/lags.toml");

/// Welander's box model of the ocean (di Bernardo et al. 2008, 1.2). Below `eps = -1/15` it rests
/// at (1/2, 1/3). Above, an oscillation approaches it next to the boundary.
pub const OCEAN: &str = r#"
name = "ocean"
[states]
T = ""
S = ""
[parameters]
eps = -0.01
[definitions]
k = "by_side(mixing, 0, 1)"
[contacts.mixing]
boundary = "S - 4*T/5 - eps"
[field]
T = "1 - T - k*T"
S = "(1 - S)/2 - k*S"
[start]
T = 0.9
S = 0.6
"#;

#[test]
fn a_branch_ends_in_an_equilibrium_on_the_boundary() {
    let on_boundary = |stop: &Stop, exact: f64| {
        let Stop::BoundaryEquilibrium { parameter } = *stop else {
            panic!("{stop:?}");
        };
        assert!((parameter - exact).abs() < 1e-12, "{parameter}");
    };
    let (lags, branch) = followed(LAGS, &[], ("b", -2.0, 2.0));
    for (stop, exact) in branch.stops.iter().zip([-1.0, 1.0]) {
        on_boundary(stop, exact);
    }
    let rows = branch.special_rows(&lags);
    let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["boundary equilibrium"; 2]);
    let (_, branch) = followed(OCEAN, &[], ("eps", -0.09, -0.005));
    on_boundary(&branch.stops[0], -1.0 / 15.0);
}

/// A block on a belt whose static friction decreases to the kinetic one.
const WEAK: &str = include_str!("../data/weak-grip.toml");

/// If friction does not fall with speed, stick vanishes at the end, too, which is a change of
/// phases.
#[test]
fn a_branch_ends_with_the_reason_where_static_friction_falls_below_kinetic() {
    let constant = WEAK.replace("1/(1 + abs(v - 0.3))", "1");
    for (text, within, changes) in [(WEAK, 1e-9, 0), (&constant, 1e-4, 1)] {
        let (system, branch) = followed(text, &[], ("s", 0.5, 2.0));
        assert_eq!(ends(&branch), ["friction", "range"]);
        let Stop::Refused(error) = &branch.stops[0] else {
            panic!("{:?}", branch.stops);
        };
        let words = Names.words(error, Some(&system));
        let reason = "the static friction of the contact `belt`";
        assert!(words.contains(reason), "{words}");
        let place = branch.points[0].orbit.parameter;
        assert!((place - 1.0).abs() < within, "{place}");
        assert_eq!(branch.special.len(), changes);
    }
}

/// A damped oscillator, driven with a period of 2, with a kick where a square wave rises.
#[test]
fn a_branch_goes_along_the_phase_of_an_input() {
    let kicked = system(
        "name = \"kicked\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nph = 0\n[inputs.d]\n\
         shape = \"square\"\nperiod = 2\nphase = \"ph\"\n[field]\nx = \"v\"\n\
         v = \"-x - 0.3*v + 0.2*sin(pi*t)\"\n[jumps.kick]\nwhen = \"d\"\n\
         direction = \"rising\"\nset = { v = \"v + 1\" }\n[start]\nx = 0.1\nv = 0\n[time]\n\
         period = 2\nend = 20\n",
    );
    let options = options("taylor");
    let first = orbit_from(&kicked, 0.5, &SEARCH, &options);
    let branch = branch_through(&kicked, &first, ("ph", -0.3, 0.3), 0.02, &options);
    assert_eq!(ends(&branch), ["range", "range"]);
    for point in [&branch.points[0], branch.points.last().unwrap()] {
        let here = kicked
            .with_values(&[("ph", point.orbit.parameter)])
            .unwrap();
        let alone = orbit_from(&here, 0.5, &SEARCH, &options);
        let (start, t_end) = ((alone.t, alone.x.as_slice()), alone.t + alone.period);
        let (alone, _) = extremes(here.dynamics(), start, t_end, &options).unwrap();
        let off = alone[0].1 - point.extremes[0].1;
        assert!(off.abs() < 1e-9, "{off:e} at {}", point.orbit.parameter);
    }
}

/// `s` has the sign of `x` at the jump. Before it, and where `y` starts below zero, it is 0.
const SIDES: &str = r#"
name = "sides"
[states]
x = ""
y = ""
[discrete]
s = 0
[parameters]
a = 1
[jumps.side]
when = "y"
direction = "falling"
set = { s = "x/abs(x)" }
[field]
x = "a*s - x"
y = "-y - 1"
[start]
x = 0.5
y = 1
"#;

#[test]
fn an_equilibrium_holds_discrete_states() {
    let sides = system(SIDES);
    let starts: Vec<[f64; 3]> = (0..64)
        .map(|k| {
            let [x, y] = [k % 8, k / 8].map(|k| (f64::from(k) + 0.5) / 8.0);
            [2.0 * x - 1.0, y - 0.5, 0.0]
        })
        .collect();
    for method in METHODS {
        let (settings, options) = (recurrence(&sides, 2000.0), options(method));
        let found = basin(sides.dynamics(), starts.clone(), &settings, &options).unwrap();
        let attractors = found.attractors.iter().enumerate().map(|(number, one)| {
            assert_eq!(one.kind, AttractorKind::Equilibrium);
            let [x, y, s] = [0, 1, 2].map(|state| one.points[0].x[state]);
            assert!(
                (y + 1.0).abs() < 1e-9 && (x - s).abs() < 1e-9,
                "{x} {y} {s}"
            );
            (s, found.share(number).part)
        });
        let mut attractors: Vec<(f64, f64)> = attractors.collect();
        attractors.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert_eq!(
            attractors,
            [(-1.0, 0.25), (0.0, 0.5), (1.0, 0.25)],
            "{method}"
        );
    }
    let (_, branch) = equilibria(SIDES, ("a", 0.5, 2.0));
    assert!(branch.special.is_empty() && branch.points.len() > 10);
    for point in &branch.points {
        let [x, y, s] = [0, 1, 2].map(|state| point.x[state]);
        assert!(
            (x - point.parameter).abs() < 1e-12 && y == -1.0 && s == 1.0,
            "{point:?}"
        );
        let [one, two] = [0, 1].map(|k| point.eigenvalues[k].re);
        assert!((one + 1.0).abs() + (two + 1.0).abs() < 1e-14, "{point:?}");
        assert_eq!(point.stability(), Stability::Stable);
    }
}
