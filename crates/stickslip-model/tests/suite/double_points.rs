//! Bifurcations of codimension two of maps whose normal forms are known, applied once a period by a
//! clock.

use std::f64::consts::FRAC_1_SQRT_2;

use stickslip::analysis::{
    Curve, CurveBifurcation, CurveSpecialPoint, CycleBifurcation, SequenceBifurcation,
};

use crate::run::{options, system};
use crate::special_orbits::{Range, curves};

/// A map of three states once a unit of time, with the parameters `p` and `q`.
fn map(set: &str, values: [f64; 2], start: [f64; 3]) -> String {
    let [p, q] = values;
    let [x, y, z] = start;
    format!(
        "name = \"map\"\n[time]\nperiod = 1\n[states]\nx = \"\"\ny = \"\"\nz = \"\"\n[parameters]\n\
         p = {p}\nq = {q}\n[field]\nx = \"0\"\ny = \"0\"\nz = \"0\"\n[jumps.map]\n\
         when = \"-sin(2*pi*t)\"\ndirection = \"rising\"\nset = {{ {set} }}\n[start]\n\
         x = {x}\ny = {y}\nz = {z}\n"
    )
}

/// The special points of a kind on the curves of one kind.
fn on_curves(
    text: &str,
    ranges: [Range; 2],
    is_kind: impl Fn(&CycleBifurcation) -> bool,
) -> Vec<Curve> {
    let [own, other] = ranges;
    let found = curves(&system(text), own, other, &options("taylor"));
    let of: Vec<Curve> = found
        .into_iter()
        .filter(|curve| is_kind(&curve.at.what))
        .collect();
    assert!(!of.is_empty());
    of
}

fn is_change(what: &CycleBifurcation, bifurcation: SequenceBifurcation) -> bool {
    matches!(what, CycleBifurcation::Sequence(change) if change.bifurcation == bifurcation)
}

/// The only special point of all curves.
fn only(curves: &[Curve]) -> &CurveSpecialPoint {
    let all: Vec<&CurveSpecialPoint> = curves.iter().flat_map(|curve| &curve.special).collect();
    match all[..] {
        [one] => one,
        _ => panic!("{all:?}"),
    }
}

/// A special point of that name is where it must be, to within its uncertainty and an error. The
/// first parameter is that of the second range.
fn assert_is(at: &CurveSpecialPoint, what: &CurveBifurcation, exact: [f64; 2], error: f64) {
    assert_eq!(at.what, *what, "{at:?}");
    for (k, exact) in exact.into_iter().enumerate() {
        let off = (at.parameters[k] - exact).abs();
        let within = off <= at.uncertainties[k] && at.uncertainties[k] <= error;
        assert!(within, "{what}: {at:?} is off by {off:e}");
    }
}

/// The fold `x ↦ x + p - x²` at `p = 0`, and a state that `-q + x/2` multiplies.
const FOLD_AND_FLIP: &str = "x = \"x + p - x*x + y*y/4\", y = \"(-q + x/2)*y - y^3\", z = \"z/4\"";

#[test]
fn a_fold_meets_a_flip_where_both_multipliers_say() {
    let text = map(FOLD_AND_FLIP, [0.16, 0.5], [0.4, 0.0, 0.0]);
    let folds = on_curves(&text, [("p", -0.2, 0.3), ("q", 0.2, 1.4)], |what| {
        *what == CycleBifurcation::Fold
    });
    for point in folds.iter().flat_map(|curve| &curve.points) {
        assert!(point.parameters[1].abs() < 1e-9, "{:?}", point.parameters);
    }
    assert_is(only(&folds), &CurveBifurcation::FoldFlip, [1.0, 0.0], 1e-6);
    // The flips lie at q = 1 + x/2 with p = x², and turn there.
    let flips = on_curves(&text, [("q", 0.4, 1.4), ("p", -0.2, 0.3)], |what| {
        *what == CycleBifurcation::Flip
    });
    for point in flips.iter().flat_map(|curve| &curve.points) {
        let [p, q] = point.parameters;
        let off = p - 4.0 * (q - 1.0) * (q - 1.0);
        assert!(off.abs() < 1e-9, "{p} {q}");
    }
    let named = flips.iter().flat_map(|curve| &curve.special);
    let named = named.filter(|at| at.what == CurveBifurcation::FoldFlip);
    let named: Vec<&CurveSpecialPoint> = named.collect();
    assert_eq!(named.len(), 1, "{flips:?}");
    assert_is(named[0], &CurveBifurcation::FoldFlip, [0.0, 1.0], 1e-6);
}

/// The same fold, and a plane that is turned by one radian and scaled by `q + x/2`.
const FOLD_AND_TORUS: &str = "x = \"x + p - x*x + (y*y + z*z)/4\", \
     y = \"(q + x/2 - y*y - z*z)*(cos(1)*y - sin(1)*z)\", \
     z = \"(q + x/2 - y*y - z*z)*(sin(1)*y + cos(1)*z)\"";

#[test]
fn a_fold_meets_a_pair_on_the_unit_circle() {
    let text = map(FOLD_AND_TORUS, [0.16, 0.5], [0.4, 0.0, 0.0]);
    let folds = on_curves(&text, [("p", -0.2, 0.3), ("q", 0.2, 1.4)], |what| {
        *what == CycleBifurcation::Fold
    });
    let what = CurveBifurcation::FoldNeimarkSacker;
    assert_is(only(&folds), &what, [1.0, 0.0], 1e-6);
    let tori = on_curves(&text, [("q", 0.4, 1.4), ("p", -0.2, 0.3)], |what| {
        matches!(what, CycleBifurcation::NeimarkSacker { .. })
    });
    for point in tori.iter().flat_map(|curve| &curve.points) {
        let [p, q] = point.parameters;
        let off = p - 4.0 * (q - 1.0) * (q - 1.0);
        assert!(off.abs() < 1e-9, "{p} {q}");
    }
    assert_is(only(&tori), &what, [0.0, 1.0], 1e-6);
}

/// A flip at `p = 1`, and a plane that is turned by one radian and scaled by `q`.
const FLIP_AND_TORUS: &str = "x = \"-p*x + x^3 + (y*y + z*z)*x\", \
     y = \"(q - x*x - y*y - z*z)*(cos(1)*y - sin(1)*z)\", \
     z = \"(q - x*x - y*y - z*z)*(sin(1)*y + cos(1)*z)\"";

#[test]
fn a_flip_meets_a_pair_on_the_unit_circle() {
    let text = map(FLIP_AND_TORUS, [0.5, 0.5], [0.0, 0.0, 0.0]);
    let what = CurveBifurcation::FlipNeimarkSacker;
    let flips = on_curves(&text, [("p", 0.3, 1.4), ("q", 0.2, 1.4)], |what| {
        *what == CycleBifurcation::Flip
    });
    assert_is(only(&flips), &what, [1.0, 1.0], 1e-6);
    let tori = on_curves(&text, [("q", 0.3, 1.4), ("p", 0.2, 1.4)], |what| {
        matches!(what, CycleBifurcation::NeimarkSacker { .. })
    });
    assert_is(only(&tori), &what, [1.0, 1.0], 1e-6);
}

/// `z ↦ e^i z (1 + p + (q - 1/2) |z|² - |z|⁴)`: a torus at `p = 0`, whose side changes at
/// `q = 1/2`. The third state is not in it.
const CHENCINER: &str = "x = \"x/4\", \
     y = \"(1 + p + (q - 0.5)*(y*y + z*z) - (y*y + z*z)^2)*(cos(1)*y - sin(1)*z)\", \
     z = \"(1 + p + (q - 0.5)*(y*y + z*z) - (y*y + z*z)^2)*(sin(1)*y + cos(1)*z)\"";

#[test]
fn a_chenciner_point_is_where_the_torus_changes_its_side() {
    let text = map(CHENCINER, [-0.1, 0.0], [0.0, 0.0, 0.0]);
    let tori = on_curves(&text, [("p", -0.2, 0.2), ("q", -0.3, 1.2)], |what| {
        matches!(what, CycleBifurcation::NeimarkSacker { .. })
    });
    assert_is(only(&tori), &CurveBifurcation::Chenciner, [0.5, 0.0], 1e-3);
}

/// `x` follows `p + cos(t)`, with the maximum `p + 1/√2`, and drags on a contact beyond 1. Once a
/// period `-q` multiplies `y`, and a plane may be turned.
fn dragging(set: &str, q: f64) -> String {
    let period = std::f64::consts::TAU;
    map(set, [0.2, q], [0.2, 0.0, 0.0])
        .replace("period = 1\n", &format!("period = {period:?}\n"))
        .replace("sin(2*pi*t)", "sin(t)")
        .replace(
            "[field]\nx = \"0\"",
            "[field]\nx = \"-x + p + cos(t) - (1 + drag)/20\"",
        )
        .replace("[field]", "[contacts.drag]\nboundary = \"x - 1\"\n[field]")
}

#[test]
fn flips_and_tori_at_a_graze_are_named() {
    let graze = SequenceBifurcation::GrazingSliding;
    let flip = "y = \"-q*y + y^3\", z = \"z/4\"";
    let torus = "y = \"(q - y*y - z*z)*(cos(1)*y - sin(1)*z)\", \
                 z = \"(q - y*y - z*z)*(sin(1)*y + cos(1)*z)\"";
    for (set, what) in [
        (flip, CurveBifurcation::FlipAtChange(graze)),
        (torus, CurveBifurcation::NeimarkSackerAtChange(graze)),
    ] {
        let grazes = on_curves(
            &dragging(set, 0.5),
            [("p", 0.1, 0.32), ("q", 0.2, 1.4)],
            |what| is_change(what, graze),
        );
        for point in grazes.iter().flat_map(|curve| &curve.points) {
            let off = point.parameters[1] - (1.0 - FRAC_1_SQRT_2);
            assert!(off.abs() < 1e-9, "{:?}", point.parameters);
        }
        assert_is(only(&grazes), &what, [1.0, 1.0 - FRAC_1_SQRT_2], 1e-6);
    }
}

/// Two of these side by side: both graze where `p` and `q` are `1 - 1/√2`.
#[test]
fn two_grazes_at_once_are_named() {
    let text = "name = \"two\"\n[time]\nperiod = \"2*pi\"\n[states]\nx = \"\"\ny = \"\"\n\
                [parameters]\np = 0.2\nq = 0.2\n\
                [contacts.one]\nboundary = \"x - 1\"\n[contacts.two]\nboundary = \"y - 1\"\n\
                [field]\nx = \"-x + p + cos(t) - (1 + one)/20\"\n\
                y = \"-y + q + cos(t + 1) - (1 + two)/20\"\n[start]\nx = 0.7\ny = 0.7\n";
    let graze = SequenceBifurcation::GrazingSliding;
    let grazes = on_curves(text, [("p", 0.1, 0.295), ("q", 0.1, 0.35)], |what| {
        is_change(what, graze)
    });
    let exact = 1.0 - FRAC_1_SQRT_2;
    for point in grazes.iter().flat_map(|curve| &curve.points) {
        assert!(
            (point.parameters[1] - exact).abs() < 1e-9,
            "{:?}",
            point.parameters
        );
    }
    let what = CurveBifurcation::TwoChanges([graze, graze]);
    assert_is(only(&grazes), &what, [exact, exact], 1e-6);
}
