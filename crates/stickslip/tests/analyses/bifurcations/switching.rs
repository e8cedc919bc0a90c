//! Branches that begin at flips and branch points, compared with closed forms.

use std::f64::consts::PI;
use std::num::NonZeroUsize;

use stickslip::analysis::{
    ContinuationSettings, CycleBifurcation, Stop, SwitchedBranch, continue_periodic_orbit,
};
use stickslip::{Error, Filippov, Method, Options, Scalar, Side, State, math};

use super::branches::{accuracies, is_within};
use super::systems::{AtParameter, Pitchfork, TwoPitchforks};
use crate::compiled::{Compiled, traced};

traced!(3: Doubled);
traced!(2: AtParameter<Doubled>);
traced!(4: TwoPitchforks, Beside);

/// The orbit `c = (cos t, sin t)`, and about it, in a frame that rotates half as fast, the rates `p
/// u - u³` and `-w`. At `p = 0` its period doubles, to orbits at `u = ±√p`. A boundary at 0.2 is
/// crossed without effect.
pub struct Doubled;

impl Filippov<3> for Doubled {
    fn field<T: Scalar>(&self, _side: Side, t: T, &[x, y, p]: &[T; 3]) -> [T; 3] {
        let (sin, cos) = t.sin_cos();
        let (half_sin, half_cos) = (t * 0.5).sin_cos();
        let (a, b) = (x - cos, y - sin);
        let (u, w) = (half_cos * a + half_sin * b, half_cos * b - half_sin * a);
        let (along, across) = (p * u - u * u * u, -w);
        [
            -sin - b * 0.5 + half_cos * along - half_sin * across,
            cos + a * 0.5 + half_sin * along + half_cos * across,
            T::zero(),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0] - 0.2
    }
}

#[test]
fn the_branch_of_twice_the_period_begins_at_a_flip() {
    let settings = ContinuationSettings::over(-0.2, 0.3).forced(2.0 * PI);
    for method in [Method::Dop853, Method::Taylor] {
        let options = Options::tol(1e-12).method(method);
        let start = [1.0, 0.0, -0.1];
        let found = SwitchedBranch::of_special(
            &Doubled.dynamics(),
            start,
            (2.0 * PI, true, 0),
            (&settings, NonZeroUsize::MIN),
            &options,
        );
        let found = found.unwrap();
        assert_eq!(found.at.what, CycleBifurcation::Flip);
        assert!(found.at.parameter.abs() < 1e-9);
        let [branch] = found.branches.as_slice() else {
            panic!("{:?}", found.branches);
        };
        assert_eq!(branch.stop, Stop::Range);
        assert!(branch.points.len() > 10);
        for point in &branch.points {
            assert!((point.period - 4.0 * PI).abs() < 1e-12);
            let on_circle = State::from([math::cos(point.t), math::sin(point.t)]);
            let off = (point.x.rows(0, 2) - on_circle).norm_squared();
            assert!(
                (off - point.parameter).abs() < 1e-9,
                "{off} {}",
                point.parameter
            );
        }
    }
}

#[test]
fn both_ways_of_the_other_branch_begin_at_a_branch_point() {
    let settings = ContinuationSettings::over(-0.2, 0.3);
    let options = Options::tol(1e-12);
    let start = [1.0, 0.0, 0.0, -0.1];
    let system = Pitchfork;
    let found = SwitchedBranch::of_special(
        &system.dynamics(),
        start,
        (2.0 * PI, true, 0),
        (&settings, NonZeroUsize::MIN),
        &options,
    );
    let found = found.unwrap();
    assert_eq!(found.at.what, CycleBifurcation::BranchPoint);
    let [one, two] = found.branches.as_slice() else {
        panic!("{:?}", found.branches);
    };
    for branch in [one, two] {
        assert_eq!(branch.stop, Stop::Range);
        assert_eq!(branch.special, []);
        for point in &branch.points[1..] {
            let off = point.x[2] * point.x[2] - point.parameter;
            assert!(off.abs() < 1e-9, "{off:e} at {}", point.parameter);
        }
    }
    let ends = [one, two].map(|branch| branch.points.last().unwrap().x[2]);
    assert!(ends[0] * ends[1] < 0.0, "{ends:?}");
    // The branch that it leaves has none of these.
    let known = continue_periodic_orbit(
        &system.dynamics(),
        start,
        2.0 * PI,
        true,
        &settings,
        &options,
    );
    assert!(
        known
            .unwrap()
            .points
            .iter()
            .all(|point| point.x[2].abs() < 1e-9)
    );
    let none = SwitchedBranch::of_special(
        &system.dynamics(),
        start,
        (2.0 * PI, false, 0),
        (&settings, NonZeroUsize::MIN),
        &options,
    );
    assert!(matches!(none, Err(Error::NotFound { .. })), "{none:?}");
}

/// [`Pitchfork`] with other rates beside the circle, which is at a = 0.
#[derive(Clone, Copy, Debug)]
enum Beside {
    /// `a' = a (p - |a|)`: the other branch has a corner where it meets the circle.
    Corner,
    /// `a' = a (p + a/250 - a²)`: the other branch turns back at a = 1/500, which is within the
    /// first step along it.
    Turning,
}

impl Beside {
    /// The parameter of the orbit at a value of `a`.
    fn parameter<T: Scalar>(self, a: T) -> T {
        match self {
            Beside::Corner => a.abs(),
            Beside::Turning => a * a - a * 0.004,
        }
    }
}

impl Filippov<4> for Beside {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 4]) -> [T; 4] {
        let [x_rate, y_rate, ..] = Pitchfork.field(side, t, x);
        let grows = x[3] - self.parameter(x[2]);
        [x_rate, y_rate, x[2] * grows, T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0] - 0.2
    }
}

#[test]
fn a_branch_is_followed_from_a_corner_and_through_a_fold_in_its_first_step() {
    let settings = ContinuationSettings::over(-0.2, 0.3);
    for (tolerance, options) in accuracies() {
        for system in [Beside::Corner, Beside::Turning] {
            let (any, way) = (system.dynamics(), (2.0 * PI, true, 0));
            let start = [1.0, 0.0, 0.0, -0.1];
            let found = SwitchedBranch::of_special(
                &any,
                start,
                way,
                (&settings, NonZeroUsize::MIN),
                &options,
            )
            .unwrap();
            is_within(found.at.parameter, found.at.uncertainty, tolerance);
            assert_eq!(found.branches.len(), 2);
            for branch in &found.branches {
                assert_eq!(branch.stop, Stop::Range, "{system:?} {:?}", branch.points);
                for point in &branch.points[1..] {
                    let off = system.parameter(point.x[2]) - point.parameter;
                    assert!(
                        off.abs() < 1e3 * tolerance,
                        "{off:e} at {}",
                        point.parameter
                    );
                }
                let is_upper = branch.points.last().unwrap().x[2] > 0.0;
                let folds = usize::from(is_upper && matches!(system, Beside::Turning));
                assert_eq!(
                    branch.special.len(),
                    folds,
                    "{system:?}: {:?}",
                    branch.special
                );
                for fold in &branch.special {
                    assert_eq!(fold.what, CycleBifurcation::Fold);
                    is_within(fold.parameter + 4e-6, fold.uncertainty, tolerance);
                }
            }
        }
    }
}

/// Each way follows the closed curve `a² = p (1 - p)` through the other branch point and back.
#[test]
fn a_branch_that_comes_back_to_its_branch_point_is_closed() {
    for step in [0.02, 0.005] {
        let settings = ContinuationSettings {
            step,
            ..ContinuationSettings::over(-0.2, 1.2)
        };
        let options = Options::tol(1e-12);
        let start = [1.0, 0.0, 0.0, -0.1];
        let system = TwoPitchforks;
        let way = (2.0 * PI, true, 0);
        let found = SwitchedBranch::of_special(
            &system.dynamics(),
            start,
            way,
            (&settings, NonZeroUsize::MIN),
            &options,
        );
        let found = found.unwrap();
        assert_eq!(found.branches.len(), 2);
        for branch in &found.branches {
            assert_eq!(branch.stop, Stop::Closed);
            let [other] = branch.special.as_slice() else {
                panic!("{:?}", branch.special);
            };
            assert_eq!(other.what, CycleBifurcation::BranchPoint);
            let off = (other.parameter - 1.0).abs();
            assert!(off <= other.uncertainty && off < 1e-7, "{off:e}");
            let sides = |sign: f64| {
                branch
                    .points
                    .iter()
                    .filter(|at| sign * at.x[2] > 1e-3)
                    .count()
            };
            let (one, two) = (sides(1.0) as f64, sides(-1.0) as f64);
            assert!((one / two - 1.0).abs() < 0.1, "{one} {two}");
        }
    }
}

/// The component that is zero on the branch becomes denormal in Newton's iterations.
#[test]
fn a_component_that_all_but_vanishes_ends_no_branch() {
    let settings = ContinuationSettings::over(-0.2, 0.3);
    for z in [0.0, 1e-12, 1e-300, 1e-311] {
        let start = [1.0, 0.0, z, -0.1];
        let options = Options::default();
        let system = Pitchfork;
        let found = continue_periodic_orbit(
            &system.dynamics(),
            start,
            2.0 * PI,
            true,
            &settings,
            &options,
        );
        assert_eq!(found.unwrap().stop, Stop::Range, "{z:e}");
    }
}
