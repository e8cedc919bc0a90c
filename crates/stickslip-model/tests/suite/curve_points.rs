//! Ends and special points of curves in two parameters, and normal forms, against closed forms.

use std::f64::consts::PI;
use std::num::NonZeroUsize;

use stickslip::analysis::{
    ContinuationSettings, Criticality, Curve, CurveBifurcation, CurveSpecialPoint, CurveStop,
    CycleBifurcation, SequenceBifurcation, continue_periodic_orbit,
};
use stickslip::{Options, math};

use crate::run::{branch, options, orbit, system, with};
use crate::special_orbits::{CUSP, DOUBLED, Range, curves, of_one_period};
use stickslip_model::study::{Followed, ParameterLine, SideBranch, TwoSidedBranch};

/// Why a branch could not be joined.
type Failed = Box<dyn std::error::Error + Send + Sync>;

/// The special points of a kind.
fn all<'c>(curve: &'c Curve, what: &CurveBifurcation) -> Vec<&'c CurveSpecialPoint> {
    let special = curve.special.iter();
    special.filter(|at| at.what == *what).collect()
}

/// A special point is where it must be, to within its uncertainty and an error.
fn is_at(at: &CurveSpecialPoint, exact: [f64; 2], error: f64) {
    for (k, exact) in exact.into_iter().enumerate() {
        let off = (at.parameters[k] - exact).abs();
        let uncertainty = at.uncertainties[k];
        assert!(
            off <= uncertainty && uncertainty <= error,
            "{}: {} is off by {off:e}, ± {uncertainty:e}",
            at.what,
            at.parameters[k]
        );
    }
}

/// Deviations `u` from `cos t` have the rate `1 - p² - q² - u²`: folds on the unit circle.
const RING: &str = r#"
name = "ring"
[time]
period = "2*pi"
[states]
x = ""
[parameters]
p = 0
q = 0
[definitions]
u = "x - cos(t)"
[field]
x = "-sin(t) + 1 - p^2 - q^2 - u^2"
[start]
x = 2
"#;

#[test]
fn a_closed_curve_ends_where_it_began() {
    let found = curves(
        &system(RING),
        ("p", -2.0, 2.0),
        ("q", -2.0, 2.0),
        &options("taylor"),
    );
    assert!(!found.is_empty());
    for curve in &found {
        assert_eq!(curve.at.what, CycleBifurcation::Fold);
        assert_eq!(curve.stops, [CurveStop::Closed; 2]);
        assert_eq!(curve.first, 0);
        assert_eq!(curve.points.first(), curve.points.last());
        let mut turned = 0.0;
        for pair in curve.points.windows(2) {
            let [a, b] = [&pair[0], &pair[1]].map(|point| point.parameters);
            assert!((a[0] * a[0] + a[1] * a[1] - 1.0).abs() < 1e-8, "{a:?}");
            turned += math::atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
        }
        // Once round.
        assert!((turned.abs() - 2.0 * PI).abs() < 1e-6, "{turned}");
        assert!(curve.special.is_empty(), "{:?}", curve.special);
    }
}

/// A neuron that fires at v = 1. It fires once in a period of the drive where `I + P(t) = I0` at
/// the firing, with the forced motion `P` of amplitude `A/√17` and `I0 = 1/(1 - exp(-π/2))`.
const NEURON: &str = r#"
name = "neuron"
[time]
period = "2*pi/4"
[states]
v = ""
[parameters]
I = 1.25
A = 0.3
[field]
v = "-v + I + A*cos(4*t)"
[jumps.spike]
when = "v - 1"
direction = "rising"
set = { v = "0" }
[start]
v = 0
"#;

#[test]
fn curves_end_at_the_end_of_a_range_where_orbits_have_any_phase() {
    let at_rest = 1.0 / (1.0 - math::exp(-0.5 * PI));
    let found = curves(
        &system(NEURON),
        ("I", 0.5, 2.0),
        ("A", 0.0, 2.0),
        &options("taylor"),
    );
    let folds = found.iter();
    let folds = folds.filter(|curve| curve.at.what == CycleBifurcation::Fold);
    let folds: Vec<&Curve> = folds.collect();
    assert_eq!(folds.len(), 2);
    for curve in &folds {
        let [begin, end] = [curve.points.first(), curve.points.last()].map(Option::unwrap);
        assert_eq!(curve.stops[0], CurveStop::Range);
        assert_eq!(begin.parameters[0], 0.0);
        for point in &curve.points {
            let [force, current] = point.parameters;
            let off = (current - at_rest).abs() - force / 17.0_f64.sqrt();
            assert!(off.abs() < 1e-8, "{force} {current}: {off:e}");
        }
        if curve.stops[1] == CurveStop::Range {
            assert_eq!(end.parameters[0], 2.0);
            continue;
        }
        // On the other the orbit touches the threshold before it fires. After the firing,
        // v(t) = I - a cos 4t - I0 exp(-t), with a = A/√17 and I = I0 + a.
        assert_eq!(curve.stops[1], CurveStop::AnotherChange);
        let what = CurveBifurcation::FoldAtChange(SequenceBifurcation::JumpGrazing);
        let [at] = all(curve, &what)[..] else {
            panic!("{:?}", curve.special);
        };
        assert_eq!(
            (at.parameters, at.behind),
            (end.parameters, curve.points.len() - 1)
        );
        let a = at.parameters[0] / 17.0_f64.sqrt();
        let v = |t: f64| at.parameters[1] - a * math::cos(4.0 * t) - at_rest * math::exp(-t);
        let highest = (1..40_000).map(|k| v(1.5 * f64::from(k) / 40_000.0));
        let highest = highest.fold(0.0, f64::max);
        assert!((highest - 1.0).abs() < 1e-8, "{highest}");
        assert!(at.uncertainties.iter().all(|one| *one < 1e-8));
    }
}

/// A belt with cubic friction (Kowalczyk & Piiroinen 2008).
const BELT: &str = r#"
name = "belt"
[time]
period = "2*pi/nu"
[states]
u = ""
w = ""
[parameters]
nu = { value = 1.8, range = [0.05, 10] }
A = 1
[definitions]
h = "w - 1"
[contacts.belt]
boundary = "w - 1"
[field]
u = "w"
w = "-u - by_side(belt, -1.5 - 1.5*h + 0.45*h^3, 1.5 - 1.5*h + 0.45*h^3) + A*cos(nu*t)"
[start]
u = 0
w = 0
"#;

#[test]
fn a_torus_curve_ends_in_the_resonance_of_the_orbit_of_half_the_period() {
    // At 1e-12 its uncertainty is 8e-8.
    let options = Options {
        rtol: 1e-13,
        atol: 1e-13.into(),
        ..options("taylor")
    };
    let found = curves(&system(BELT), ("nu", 1.0, 4.0), ("A", 0.9, 1.1), &options);
    let mut tori = found
        .iter()
        .filter(|curve| matches!(curve.at.what, CycleBifurcation::NeimarkSacker { .. }));
    let curve = tori.next().unwrap();
    assert!(tori.next().is_none());
    let mut stops = curve.stops;
    stops.sort_by_key(|stop| *stop != CurveStop::Range);
    assert_eq!(stops, [CurveStop::Range, CurveStop::Flip]);
    let half = CurveBifurcation::OfHalf(Box::new(CurveBifurcation::Resonance(2)));
    let [at] = all(curve, &half)[..] else {
        panic!("{:?}", curve.special);
    };
    for (value, exact) in at.parameters.iter().zip([1.05902276, 2.59475122]) {
        assert!((value - exact).abs() < 6e-9, "{value} {exact}");
    }
    assert!(at.uncertainties.iter().all(|one| *one < 1e-7), "{at:?}");
    // It is not followed back.
    let rising = curve.points.windows(2);
    let mut rising = rising.map(|pair| pair[1].parameters[0] > pair[0].parameters[0]);
    let first = rising.next().unwrap();
    assert!(rising.all(|one| one == first));
}

#[test]
fn a_cusp_is_named_where_two_folds_meet() {
    let (along, also) = (("p", -1.0, 1.0), ("q", -0.5, 1.0));
    let found = curves(&system(CUSP), along, also, &options("taylor"));
    assert_eq!(found.len(), 2);
    for curve in &found {
        let [cusp] = &curve.special[..] else {
            panic!("{:?}", curve.special);
        };
        assert_eq!(cusp.what, CurveBifurcation::Cusp);
        is_at(cusp, [0.0, 0.0], 1e-8);
        let before = curve.points[..cusp.behind].iter();
        let behind = curve.points[cusp.behind..].iter();
        let side = |points: std::slice::Iter<'_, stickslip::analysis::CurvePoint>| {
            let signs: Vec<bool> = points.map(|point| point.parameters[1] > 0.0).collect();
            assert!(signs.iter().all(|sign| *sign == signs[0]));
            signs[0]
        };
        assert_ne!(side(before), side(behind));
    }
}

/// Hénon's map once a period. Its fixed point has the determinant `-b` and the trace `-2 a x`: a
/// fold at `4 a = -(1 - b)²`, a flip at `4 a = 3 (1 - b)²`, and a pair on the unit circle at
/// `b = -1` between both, with the trace 0 at `a = 0` and -1 at `a = 5/4`.
const HENON: &str = r#"
name = "Henon"
[time]
period = "1"
[states]
x = ""
y = ""
[parameters]
a = 0.1
b = -0.5
[field]
x = "0"
y = "0"
[jumps.map]
when = "-sin(2*pi*t)"
direction = "rising"
set = { x = "1 - a*x^2 + y", y = "b*x" }
[start]
x = 0.6
y = -0.3
"#;

#[test]
fn curves_of_henons_map_name_its_resonances() {
    let options = options("taylor");
    // Along a: the fold and the flip, in both parameters.
    let found = curves(&system(HENON), ("a", -1.5, 4.0), ("b", -1.5, 0.5), &options);
    let [fold, flip] = [CycleBifurcation::Fold, CycleBifurcation::Flip].map(|what| {
        let mut of = found.iter().filter(|curve| curve.at.what == what);
        of.next().unwrap_or_else(|| panic!("{what}: {found:?}"))
    });
    for (curve, factor) in [(fold, -0.25), (flip, 0.75)] {
        for point in &curve.points {
            let [b, a] = point.parameters;
            let off = a - factor * (1.0 - b) * (1.0 - b);
            assert!(off.abs() < 1e-9, "{a} {b}: {off:e}");
        }
    }
    let [one] = all(fold, &CurveBifurcation::Resonance(1))[..] else {
        panic!("{:?}", fold.special);
    };
    is_at(one, [-1.0, -1.0], 1e-8);
    let [two] = all(flip, &CurveBifurcation::Resonance(2))[..] else {
        panic!("{:?}", flip.special);
    };
    is_at(two, [-1.0, 3.0], 1e-8);
    // Along b: the pair on the unit circle.
    let found = curves(&system(HENON), ("b", -1.5, 0.5), ("a", -1.5, 4.0), &options);
    let mut tori = found
        .iter()
        .filter(|curve| matches!(curve.at.what, CycleBifurcation::NeimarkSacker { .. }));
    let torus = tori.next().unwrap_or_else(|| panic!("{found:?}"));
    assert_eq!(torus.stops, [CurveStop::Resonance; 2]);
    for (order, a) in [(1, -1.0), (2, 3.0), (3, 1.25), (4, 0.0)] {
        let [at] = all(torus, &CurveBifurcation::Resonance(order))[..] else {
            panic!("1:{order}: {:?}", torus.special);
        };
        is_at(at, [a, -1.0], 1e-7);
    }
    assert_eq!(torus.special.len(), 4, "{:?}", torus.special);
}

/// Deviations `u` from the orbit with the rate `p u + s u³` double its period at `p = 0`: over the
/// period of 2π the map is `u ↦ -u - 2π s u³`.
#[test]
fn a_flip_is_super_or_subcritical_by_its_normal_form() {
    for (sign, side) in [
        (-1.0, Criticality::Supercritical),
        (1.0, Criticality::Subcritical),
    ] {
        let text = DOUBLED.replace("p*u - u*u*u", &format!("p*u + ({sign})*u*u*u"));
        for method in ["taylor", "dop853"] {
            let found = branch(&system(&text), ("p", -0.2, 0.1), &options(method));
            let [flip] = found.special.as_slice() else {
                panic!("{:?}", found.special);
            };
            let form = flip.normal_form.unwrap();
            assert_eq!(form.criticality(), Some(side), "{form:?}");
            let off = (form.coefficient + 2.0 * PI * sign).abs();
            assert!(
                off <= form.uncertainty && form.uncertainty < 1e-2,
                "{off:e} {form:?}"
            );
        }
    }
}

/// Deviations from the orbit `(cos t, sin t)` turn at the rate 0.3 and grow at `p + s r²`. For the
/// eigenvector `(1, -i)/√2` the map is `z ↦ exp(0.6πi) z (1 + 4π s |z|²)`.
const TORUS: &str = r#"
name = "torus"
[time]
period = "2*pi"
[states]
x = ""
y = ""
[parameters]
p = -0.1
s = -1
[definitions]
a = "x - cos(t)"
b = "y - sin(t)"
grows = "p + s*(a*a + b*b)"
[field]
x = "-sin(t) + grows*a - 0.3*b"
y = "cos(t) + grows*b + 0.3*a"
[start]
x = 1
y = 0
"#;

#[test]
fn a_torus_is_super_or_subcritical_by_its_normal_form() {
    for (sign, side) in [
        (-1.0, Some(Criticality::Supercritical)),
        (1.0, Some(Criticality::Subcritical)),
        // A linear flow has no such coefficient.
        (0.0, None),
    ] {
        let system = with(TORUS, &[("s", sign)]);
        let found = branch(&system, ("p", -0.2, 0.1), &options("taylor"));
        let [torus] = found.special.as_slice() else {
            panic!("{:?}", found.special);
        };
        let form = torus.normal_form.unwrap();
        assert_eq!(form.criticality(), side, "{form:?}");
        let off = (form.coefficient + 4.0 * PI * sign).abs();
        assert!(
            off <= form.uncertainty && form.uncertainty < 1e-2,
            "{off:e} {form:?}"
        );
    }
}

/// With the rate `p u + (q - 1/2) u³ - u⁵` the flip at `p = 0` changes its side at `q = 1/2`.
#[test]
fn a_generalized_flip_is_named_on_a_curve_of_flips() {
    let text = DOUBLED
        .replace("p*u - u*u*u", "p*u + (q - 0.5)*u^3 - u^5")
        .replace("p = -0.1", "p = -0.1\nq = 0");
    let found = curves(
        &system(&text),
        ("p", -0.2, 0.2),
        ("q", -0.3, 1.2),
        &options("taylor"),
    );
    let [curve] = found.as_slice() else {
        panic!("{found:?}");
    };
    let [at] = &curve.special[..] else {
        panic!("{:?}", curve.special);
    };
    assert_eq!(at.what, CurveBifurcation::GeneralizedFlip);
    is_at(at, [0.5, 0.0], 1e-3);
}

/// An oscillator before a wall. Without impacts its amplitude is that of the linear one, which
/// reaches the wall at `A² = (1 - w²)² + 0.01 w²`.
const WALL: &str = r#"
name = "wall"
[time]
period = "2*pi/w"
[states]
x = ""
v = ""
[parameters]
A = { value = 0.3, range = [0, 2] }
w = { value = 1, range = [0.1, 3] }
[jumps.wall]
when = "x - 1"
direction = "rising"
set = { v = "-0.8*v" }
[field]
x = "v"
v = "A*cos(w*t) - 0.1*v - x"
[start]
x = -0.98
v = -0.29
"#;

#[test]
fn folds_of_impacts_end_on_the_curve_of_grazes() {
    let found = curves(
        &system(WALL),
        ("A", 0.05, 0.5),
        ("w", 0.9, 1.2),
        &options("taylor"),
    );
    let mut folds = found.iter();
    let fold = folds.find(|curve| curve.at.what == CycleBifurcation::Fold);
    let fold = fold.unwrap();
    let first = fold.points[fold.first].parameters;
    assert!((first[1] - 0.09997075362831327).abs() < 1e-10, "{first:?}");
    let what = CurveBifurcation::FoldAtChange(SequenceBifurcation::JumpGrazing);
    let [at] = all(fold, &what)[..] else {
        panic!("{:?}", fold.special);
    };
    let [w, force] = at.parameters;
    let exact = (math::powi(1.0 - w * w, 2) + 0.01 * w * w).sqrt();
    assert!((force - exact).abs() < 1e-8, "{w} {force} {exact}");
    // Where the orbit arrives without speed, its derivative is unbounded, and no multiplier counts.
    let grazes = found
        .iter()
        .filter(|curve| curve.at.what != CycleBifurcation::Fold);
    for curve in grazes {
        assert!(curve.special.is_empty(), "{:?}", curve.special);
    }
}

/// An oscillator that a clock drives against a wall.
const STRUCK: &str = r#"
name = "struck"
[time]
period = "2*pi/w"
[states]
x = ""
v = ""
[parameters]
w = 1.3
A = 1.2
c = 0.3
[field]
x = "v"
v = "-x - c*v + A*cos(w*t)"
[jumps.hit]
when = "x - 1"
direction = "rising"
set = { v = "-0.7*v" }
[start]
x = 0
v = 0
"#;

/// Without impacts the amplitude is `A / √((1 - w²)² + c² w²)`. At amplitude 1 the flow map has no
/// derivative, and rounding decides whether the speed of the impact is zero or nearly so.
#[test]
fn a_curve_of_grazes_does_not_depend_on_the_rounding_of_the_speed() {
    for c in ["0.2", "0.25", "0.3", "0.35", "0.4", "0.45", "0.5"] {
        let text = STRUCK.replace("c = 0.3", &format!("c = {c}"));
        let range = [("A", 0.3, 2.0), ("w", 0.8, 1.6)];
        let found = curves(&system(&text), range[0], range[1], &options("dop853"));
        let c: f64 = c.parse().unwrap();
        let grazes = found
            .iter()
            .filter(|curve| curve.at.what.to_string() == "grazing of a jump");
        let [curve] = grazes.collect::<Vec<_>>()[..] else {
            panic!("c = {c}");
        };
        assert_eq!(curve.stops, [CurveStop::Range; 2], "c = {c}");
        for point in &curve.points {
            let [w, force] = point.parameters;
            let exact = (math::powi(1.0 - w * w, 2) + c * c * w * w).sqrt();
            assert!((force - exact).abs() < 1e-11, "{c} {w} {force} {exact}");
        }
    }
}

/// After a firing at the phase θ, `v = P(t) - P(θ) e^(-t)` with the forced motion P, and
/// `v(T) = 1` gives `P(θ) = 1 / (1 - e^-T)`. Rate and acceleration vanish together at θ = π with
/// `I - A = 1`.
#[test]
fn a_curve_of_grazes_ends_in_a_cubic_tangency() {
    let found = curves(
        &system(NEURON),
        ("I", 0.5, 2.0),
        ("A", 0.0, 2.0),
        &options("taylor"),
    );
    let force = 17.0 / 16.0 / (math::exp(0.5 * PI) - 1.0);
    let named = found.iter().flat_map(|curve| {
        let there = all(curve, &CurveBifurcation::CubicTangency);
        there.into_iter().map(move |at| (curve, at))
    });
    let [(curve, at)] = named.collect::<Vec<_>>()[..] else {
        panic!("{found:?}");
    };
    is_at(at, [force, 1.0 + force], 1e-8);
    let ends = [curve.points.first(), curve.points.last()].map(Option::unwrap);
    let end = ends.iter().position(|one| one.parameters == at.parameters);
    assert_eq!(curve.stops[end.unwrap()], CurveStop::AnotherChange);
}

/// The logistic map once a period: flips at 3, at `1 + √6`, and at 3.54409035955192.
const LOGISTIC: &str = r#"
name = "logistic"
[time]
period = "1"
[states]
x = ""
[parameters]
r = 2.8
[field]
x = "0"
[jumps.map]
when = "-sin(2*pi*t)"
direction = "rising"
set = { x = "r*x*(1 - x)" }
[start]
x = 0.6
"#;

/// The branches that begin on the branch of an orbit of one period, to a depth.
fn side_branches(text: &str, range: Range, depth: usize) -> (TwoSidedBranch, Vec<SideBranch>) {
    let (name, low, high) = range;
    let (system, options) = (system(text), options("taylor"));
    let orbit = of_one_period(&system);
    let along = ParameterLine::new(&system, name, (low, high)).unwrap();
    let settings = ContinuationSettings::over(low, high);
    let (settings, x) = along.start(&orbit, &settings, &options, None).unwrap();
    let begin = |upwards| {
        let period = orbit.period;
        continue_periodic_orbit(&along.dynamics, &x, period, upwards, &settings, &options).unwrap()
    };
    let main = along.joined::<Failed>([begin(false), begin(true)], &options);
    let main = main.unwrap();
    let depth = NonZeroUsize::new(depth).unwrap();
    let junctions: Vec<usize> = main.junctions().map(|(from, _)| from).collect();
    let switched = junctions.iter().enumerate().filter_map(|(k, &from)| {
        let found = along.switched((orbit.period, &x), (&main, k), (&settings, depth), &options);
        Some((from, found.unwrap()?))
    });
    let others = along.side_branches::<Failed>(&main, switched.collect(), &options);
    let others = others.unwrap();
    (main, others)
}

#[test]
fn flips_of_flips_are_followed_to_a_depth() {
    let exact = [3.0, 1.0 + 6.0_f64.sqrt(), 3.544090359551922];
    for depth in [1, 3] {
        let (main, others) = side_branches(LOGISTIC, ("r", 2.5, 3.555), depth);
        let form = main.special[0].normal_form.unwrap();
        // The map is quadratic, with the second derivative -6.
        assert!(
            (form.coefficient - 9.0).abs() <= form.uncertainty,
            "{form:?}"
        );
        let parents: Vec<usize> = others.iter().map(|one| one.parent).collect();
        assert_eq!(parents, (0..depth).collect::<Vec<_>>());
        for (number, other) in others.iter().enumerate() {
            let special = match number {
                0 => &main.special,
                _ => &others[number - 1].branch.special,
            };
            let (at, exact) = (&special[other.from], exact[number]);
            assert_eq!(at.what, CycleBifurcation::Flip);
            let off = (at.parameter - exact).abs();
            assert!(off <= at.uncertainty && off < 1e-8, "{exact}: {off:e}");
            assert_eq!(other.to, None);
            let period = other.branch.points[1].orbit.period;
            assert!(
                (period - math::powi(2.0, number as i32 + 1)).abs() < 1e-9,
                "{period}"
            );
        }
    }
}

/// The period doubles at `p = 0` and at `p = 1`. The orbits between both begin at either.
#[test]
fn a_bubble_between_two_flips_is_one_branch() {
    let text = DOUBLED.replace("p*u - u*u*u", "p*(1 - p)*u - u*u*u");
    let (main, others) = side_branches(&text, ("p", -0.2, 1.2), 2);
    assert_eq!(main.special.len(), 2);
    let [bubble] = &others[..] else {
        panic!("{} branches", others.len());
    };
    assert_eq!((bubble.parent, bubble.from, bubble.to), (0, 0, Some(1)));
}

/// Orbits turn about two tangencies, which meet where `p = sin q + q²`.
const TURNS: &str = r#"
name = "two tangencies"
[states]
x = ""
y = ""
[parameters]
p = 0.3
q = 0.1
[contacts.line]
boundary = "y"
[field]
x = { below = "-1", above = "1" }
y = { below = "q - x", above = "p - sin(x) - x^2" }
[start]
x = -0.9
y = 0.05
"#;

#[test]
fn the_two_fold_in_which_a_branch_ends_is_followed_as_its_row_says() {
    let (system, options) = (system(TURNS), options("taylor"));
    let (range, other) = (("p", -0.5, 0.7), ("q", -0.2, 0.4));
    let whole = branch(&system, range, &options);
    let [(which, at)] = &whole.followed()[..] else {
        panic!("{:?}", whole.stops);
    };
    assert_eq!(*which, Followed::End { upwards: false });
    assert_eq!(
        (&at.what, whole.row_of(*which)),
        (&CycleBifurcation::TwoFold, 0)
    );
    assert_eq!(whole.special_rows(&system)[0].name, "two-fold");
    let along = ParameterLine::new(&system, "p", (range.1, range.2)).unwrap();
    let number = system.file.parameter("q").unwrap();
    let both = system.with_states_of(&[number, along.number]).unwrap();
    let begin = orbit(&system, &options);
    let settings = ContinuationSettings::over(range.1, range.2);
    let (settings, x) = along.start(&begin, &settings, &options, Some(0.1)).unwrap();
    let (both, from) = ((&both, (other.1, other.2)), (begin.period, &x));
    let curve = along.curve(both, from, (&whole, *which), &settings, &options);
    let curve = curve.unwrap().unwrap();
    assert_eq!(curve.stops, [CurveStop::Range; 2]);
    for point in &curve.points {
        let [q, p] = point.parameters;
        assert!((p - math::sin(q) - q * q).abs() < 1e-9, "{q} {p}");
    }
}

/// A map of the plane, iterated once in a unit of time.
fn map(parameters: &str, x: &str, y: &str, start: f64) -> String {
    format!(
        r#"name = "map"
[time]
period = 1
[states]
x = ""
y = ""
[parameters]
{parameters}
[jumps.map]
when = "sin(2*pi*t + 1)"
direction = "rising"
set = {{ x = "{x}", y = "{y}" }}
[field]
x = 0
y = 0
[start]
x = {start}
y = 0
"#
    )
}

#[test]
fn a_generalized_flip_is_found_wherever_the_orbits_of_the_curve_lie() {
    // On the centre manifold y = 0.6 x², and the flip changes where 1 + c + 0.12 = 0. One of the
    // ranges has an orbit there, at which the coefficient has no sign.
    let text = map(
        "p = -0.3\nc = 1",
        "-(1 + p)*x + x^2 + c*x^3 + 0.2*x*y",
        "0.5*y + 0.3*x^2",
        0.01,
    );
    for high in [1.5, 1.9, 2.3, 2.9] {
        let ranges = (("p", -0.5, 0.5), ("c", -3.0, high));
        let found = curves(&system(&text), ranges.0, ranges.1, &options("taylor"));
        let [curve] = &found[..] else {
            panic!("{}", found.len());
        };
        let [at] = all(curve, &CurveBifurcation::GeneralizedFlip)[..] else {
            panic!("{high}: {:?}", curve.special);
        };
        is_at(at, [-1.12, 0.0], 1e-3);
    }
}

#[test]
fn a_resonance_at_the_first_orbit_of_a_curve_is_named_once() {
    let text = map(
        "p = -0.1\ns = 0",
        "y",
        "-(1 + p)*x + s*y + 0.1*x^2 - 0.3*y^3",
        0.0,
    );
    let ranges = (("p", -0.5, 0.5), ("s", -1.5, 1.5));
    let found = curves(&system(&text), ranges.0, ranges.1, &options("taylor"));
    let [curve] = &found[..] else {
        panic!("{}", found.len());
    };
    for (order, exact) in [(3, [-1.0, 0.0]), (4, [0.0, 0.0])] {
        let [at] = all(curve, &CurveBifurcation::Resonance(order))[..] else {
            panic!("1:{order}: {:?}", curve.special);
        };
        is_at(at, exact, 1e-10);
        let [before, behind] = [at.behind - 1, at.behind].map(|k| curve.points[k].parameters[0]);
        let (low, high) = (before.min(behind), before.max(behind));
        assert!(
            (low - 1e-9..=high + 1e-9).contains(&exact[0]),
            "{low} {high}"
        );
    }
}

#[test]
fn a_flip_of_the_orbit_with_which_a_branch_begins_is_on_it_once() {
    // The multiplier of x = p is 1 - p.
    let text = map("p = 2", "x + p*x - x^2", "0.5*y", 2.0);
    let found = branch(&system(&text), ("p", 1.0, 3.0), &options("taylor"));
    let [at] = &found.special[..] else {
        panic!("{:?}", found.special);
    };
    assert_eq!(at.what, CycleBifurcation::Flip);
    assert!(
        (at.parameter - 2.0).abs() <= at.uncertainty.max(1e-12),
        "{}",
        at.parameter
    );
}
