//! Branches of equilibria, compared with closed forms.

use stickslip::analysis::{
    ContinuationSettings, EquilibriumBifurcation, EquilibriumBranch, Stability, Stop,
};
use stickslip::{Error, Filippov, Mode, Options, Scalar, Side};

use super::systems::{Persists, Pitchfork};
use crate::attractors::systems::Rings;
use crate::compiled::Compiled;

fn followed<const N: usize>(
    system: &impl Compiled<N>,
    start: [f64; N],
    upwards: bool,
    (low, high): (f64, f64),
) -> Result<EquilibriumBranch, Error> {
    let settings = ContinuationSettings::over(low, high);
    // An equilibrium does not depend on the integration: one tolerance and method are enough.
    let options = Options::tol(1e-12);
    EquilibriumBranch::through(&system.dynamics(), start, upwards, &settings, &options)
}

/// The centre of `r' = r (p + 2 r² - r⁴)` has a Hopf bifurcation at p = 0, with the frequency 1.
#[test]
fn a_hopf_bifurcation_is_located_to_rounding() {
    let system = Rings { place: 50.0 };
    for (from, upwards) in [(-0.7, true), (0.4, false)] {
        let found = followed(&system, [0.01, 0.02, from], upwards, (-1.0, 0.5)).unwrap();
        let [hopf] = found.special.as_slice() else {
            panic!("{:?}", found.special);
        };
        assert!(
            hopf.parameter.abs() < 1e-13 && hopf.uncertainty < 1e-12,
            "{hopf:?}"
        );
        let EquilibriumBifurcation::Hopf { frequency } = hopf.what else {
            panic!("{hopf:?}");
        };
        assert!((frequency - 1.0).abs() < 1e-13);
        assert_eq!(found.stop, Stop::Range);
        for at in &found.points {
            assert!(at.x.rows(0, 2).amax() < 1e-13);
            assert!((at.eigenvalues[0].re - at.parameter).abs() < 1e-13);
            let is_stable = at.stability() == Stability::Stable;
            assert_eq!(is_stable, at.parameter < 0.0);
        }
    }
}

/// The equilibrium 0 of `a' = p a - a³` meets the other two at p = 0, and the branch continues.
#[test]
fn a_branch_point_is_located_and_passed() {
    let found = followed(&Pitchfork, [0.0, 0.0, 0.0, -0.63], true, (-1.0, 1.0)).unwrap();
    let [at] = found.special.as_slice() else {
        panic!("{:?}", found.special);
    };
    assert_eq!(at.what, EquilibriumBifurcation::BranchPoint);
    assert!(at.parameter.abs() < 1e-12, "{at:?}");
    let last = found.points.last().unwrap();
    assert_eq!((&found.stop, last.parameter), (&Stop::Range, 1.0));
    assert!(found.points.iter().all(|at| at.x.rows(0, 3).amax() < 1e-13));
}

/// The focus at (p, 0) comes to the boundary at p = 0 and becomes the equilibrium of the sliding
/// field. There the fields `(0.3 p - y, -p - 0.3 y)` and `(-1, 1)` are opposite.
#[test]
fn an_equilibrium_goes_over_into_sliding_and_back() {
    let sliding = |p: f64| -0.7 * p / 1.3;
    for (start, upwards) in [
        ([-0.3, 0.0, -0.3], true),
        ([0.0, sliding(0.45), 0.45], false),
    ] {
        let found = followed(&Persists, start, upwards, (-0.5, 0.5)).unwrap();
        let [at] = found.special.as_slice() else {
            panic!("{:?}", found.special);
        };
        let EquilibriumBifurcation::Boundary {
            before,
            after: Some(after),
            turns: false,
            contact: 0,
        } = at.what
        else {
            panic!("{at:?}");
        };
        assert!(
            at.parameter.abs() < 1e-13 && at.uncertainty < 1e-12,
            "{at:?}"
        );
        let modes = [before, after].map(|mode| mode.get(0));
        let order = [Mode::Slip(Side::Below), Mode::Stick];
        assert_eq!(modes, if upwards { order } else { [order[1], order[0]] });
        assert_eq!(found.stop, Stop::Range);
        for at in &found.points {
            let p = at.parameter;
            let exact = if p < 0.0 { [p, 0.0] } else { [0.0, sliding(p)] };
            let off = (0..2).map(|k| (at.x[k] - exact[k]).abs());
            assert!(off.fold(0.0, f64::max) < 1e-13, "{at:?}");
            assert_eq!(at.eigenvalues.len(), if p < 0.0 { 2 } else { 1 });
            assert_eq!(at.stability(), Stability::Stable);
        }
    }
}

/// Above the boundary there is no equilibrium, so the equilibrium of a mode that differs by the
/// contact is taken. The start is below `y = 1 + 0.3 p`, where the sliding field has a pole, which
/// Newton's iteration may not pass.
#[test]
fn a_start_beside_an_equilibrium_finds_its_mode_and_one_outside_the_range_is_refused() {
    for (p, mode) in [(0.2, Mode::Stick), (-0.2, Mode::Slip(Side::Below))] {
        let found = followed(&Persists, [0.5, 0.5, p], true, (-0.5, 0.5)).unwrap();
        assert_eq!(found.points[0].mode.get(0), mode);
    }
    let rings = Rings { place: 50.0 };
    let error = followed(&rings, [0.0, 0.0, 2.0], true, (-1.0, 0.5)).unwrap_err();
    assert!(
        matches!(
            error,
            Error::Parameter {
                name: "the last state",
                ..
            }
        ),
        "{error}"
    );
}

/// `x' = 1 - x² - p²`: the equilibria lie on a circle, which folds at p = ±1.
struct Circle;

impl Filippov<2> for Circle {
    fn field<T: Scalar>(&self, _side: Side, _t: T, [x, p]: &[T; 2]) -> [T; 2] {
        [-*x * *x - *p * *p + 1.0, T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, [x, _]: &[T; 2]) -> T {
        *x - 9.0
    }
}

#[test]
fn a_closed_branch_ends_where_it_began() {
    let (settings, options) = (ContinuationSettings::over(-2.0, 2.0), Options::tol(1e-12));
    for upwards in [false, true] {
        let found = EquilibriumBranch::through(&Circle, [1.0, 0.1], upwards, &settings, &options);
        let found = found.unwrap();
        let sign = if upwards { 1.0 } else { -1.0 };
        let folds: Vec<f64> = found.special.iter().map(|at| at.parameter * sign).collect();
        let [one, other] = folds.as_slice() else {
            panic!("{:?}", found.special);
        };
        assert!(
            (one - 1.0).abs().max((other + 1.0).abs()) < 1e-12,
            "{folds:?}"
        );
        assert_eq!(found.stop, Stop::Closed);
        assert_eq!(found.points.last(), found.points.first());
        for at in &found.points {
            assert!((at.x.norm() - 1.0).abs() < 1e-12, "{at:?}");
        }
    }
}
