//! Curves of special equilibria in two parameters, compared with closed forms.

use stickslip::analysis::{
    ContinuationSettings, CurveStop, EquilibriumBifurcation, EquilibriumBranch, EquilibriumCurve,
    EquilibriumCurveBifurcation, SpecialEquilibrium,
};
use stickslip::dynamics::{DynamicsRef, Vector};
use stickslip::{Error, Filippov, Options, Scalar, Side, math};

use crate::compiled::Traced;

/// A planar system with the parameters q and p.
trait Planar {
    fn rates<T: Scalar>(side: Side, x: &[T; 4]) -> [T; 2];
    fn surface<T: Scalar>(x: &[T; 4]) -> T {
        x[0] - 50.0
    }
}

/// A system with both parameters as states.
struct Both<S>(S);

impl<S: Planar> Filippov<4> for Both<S> {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        let [a, b] = S::rates(side, x);
        [a, b, T::zero(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        S::surface(x)
    }
}

/// The same with a fixed q.
struct Own<S>(S, f64);

impl<S: Planar> Filippov<3> for Own<S> {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, y, p]: &[T; 3]) -> [T; 3] {
        let [a, b] = S::rates(side, &[x, y, T::constant(self.1), p]);
        [a, b, T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, &[x, y, p]: &[T; 3]) -> T {
        S::surface(&[x, y, T::constant(self.1), p])
    }
}

/// The curve of the first special equilibrium with a name, from p of a start on. Ranges are those
/// of p and q.
fn curve<S: Planar + Copy>(
    system: S,
    (start, q, upwards): ([f64; 3], f64, bool),
    (own, other): ((f64, f64), (f64, f64)),
    name: &str,
) -> EquilibriumCurve {
    let settings = ContinuationSettings::over(own.0, own.1);
    let options = Options::tol(1e-12);
    let branch = EquilibriumBranch::through(
        &Traced::of(&Own(system, q)).dynamics(),
        start,
        upwards,
        &settings,
        &options,
    )
    .unwrap();
    let mut special = branch.special.iter();
    let at = special.find(|at| at.what.to_string() == name).unwrap();
    let curve = at.curve(
        &Traced::of(&Both(system)).dynamics(),
        (q, &branch.sizes),
        (&settings, other),
    );
    curve.unwrap()
}

/// Asserts that a function vanishes at all points.
fn lies_on(curve: &EquilibriumCurve, function: impl Fn([f64; 2]) -> f64, bound: f64) {
    for point in &curve.points {
        let off = function(point.parameters);
        assert!(off.abs() < bound, "{off:e} at {:?}", point.parameters);
    }
    for one in &curve.special {
        let off = function(one.parameters);
        assert!(off.abs() < bound, "{off:e} at {one:?}");
        assert!(one.behind <= curve.points.len());
    }
}

fn names(curve: &EquilibriumCurve) -> Vec<String> {
    curve
        .special
        .iter()
        .map(|one| one.what.to_string())
        .collect()
}

/// The normal form of a Bogdanov–Takens point, `x' = y, y' = b + q x + x² - x y`, with
/// `b = p - 0.3 q²`. Folds lie at `p = 0.55 q²`, and Hopf bifurcations at `p = 0.3 q²` where q is
/// negative.
#[derive(Clone, Copy)]
struct BogdanovTakens;

impl Planar for BogdanovTakens {
    fn rates<T: Scalar>(_: Side, &[x, y, q, p]: &[T; 4]) -> [T; 2] {
        [y, p - q * q * 0.3 + q * x + x * x - x * y]
    }
}

#[test]
fn a_curve_of_hopf_bifurcations_ends_where_its_frequency_vanishes() {
    let ranges = ((-1.0, 3.0), (-2.0, 1.0));
    let found = curve(
        BogdanovTakens,
        ([-0.5, 0.0, 0.0], -1.0, true),
        ranges,
        "Hopf",
    );
    lies_on(&found, |[q, p]| p - 0.3 * q * q, 1e-12);
    for point in &found.points {
        let [q, _] = point.parameters;
        let frequency = point.frequency.unwrap();
        assert!((frequency * frequency + q).abs() < 1e-10, "{point:?}");
        assert!(point.x.rows(0, 2).amax() < 1e-11, "{point:?}");
    }
    assert_eq!(found.stops, [CurveStop::Range, CurveStop::BogdanovTakens]);
    assert_eq!(found.points[0].parameters[0], -2.0);
    let [end] = found.special.as_slice() else {
        panic!("{:?}", found.special);
    };
    assert_eq!(end.what, EquilibriumCurveBifurcation::BogdanovTakens);
    assert_eq!(end.behind, found.points.len() - 1);
    for (value, uncertainty) in end.parameters.into_iter().zip(end.uncertainties) {
        assert!(value.abs() <= uncertainty && uncertainty < 1e-9, "{end:?}");
    }
}

#[test]
fn a_curve_of_folds_passes_a_bogdanov_takens_point() {
    let ranges = ((-1.0, 3.0), (-2.0, 1.0));
    let found = curve(
        BogdanovTakens,
        ([-0.5, 0.0, 0.0], -1.0, true),
        ranges,
        "fold",
    );
    lies_on(&found, |[q, p]| p - 0.55 * q * q, 1e-11);
    assert_eq!(names(&found), ["Bogdanov-Takens"]);
    assert_eq!(found.stops, [CurveStop::Range; 2]);
    let at = &found.special[0];
    assert!(at.parameters[0].abs() <= at.uncertainties[0], "{at:?}");
    assert!(at.uncertainties[0] < 1e-9, "{at:?}");
    let ends = [
        found.points[0].clone(),
        found.points.last().unwrap().clone(),
    ];
    assert_eq!(ends.map(|end| end.parameters[0]), [-2.0, 1.0]);
}

/// `x' = p + q x - x³`: folds lie at `27 p² = 4 q³` and meet in the cusp 0.
#[derive(Clone, Copy)]
struct Cusp;

impl Planar for Cusp {
    fn rates<T: Scalar>(_: Side, &[x, y, q, p]: &[T; 4]) -> [T; 2] {
        [p + q * x - x * x * x, -y]
    }
}

#[test]
fn a_curve_of_folds_passes_its_cusp() {
    let ranges = ((-1.0, 1.0), (-1.0, 1.5));
    let found = curve(Cusp, ([1.0, 0.0, 0.0], 1.0, false), ranges, "fold");
    lies_on(&found, |[q, p]| 27.0 * p * p - 4.0 * q * q * q, 1e-11);
    assert_eq!(names(&found), ["cusp"]);
    assert_eq!(found.stops, [CurveStop::Range; 2]);
    let at = &found.special[0];
    for (value, uncertainty) in at.parameters.into_iter().zip(at.uncertainties) {
        assert!(value.abs() <= uncertainty && uncertainty < 1e-9, "{at:?}");
    }
    // Both arms come to the largest q.
    let ends = [
        found.points[0].clone(),
        found.points.last().unwrap().clone(),
    ];
    assert!(ends.iter().all(|end| end.parameters[0] == 1.5));
    assert!(ends[0].parameters[1] * ends[1].parameters[1] < 0.0);
}

/// Rounding decides how singular the equations are at a fold, and no fold loses its curve by that.
#[test]
fn every_fold_begins_its_curve() {
    for k in 0..60 {
        let q = 0.3 + 0.018 * f64::from(k);
        let ranges = ((-1.0, 1.0), (q - 0.05, q + 0.05));
        let found = curve(Cusp, ([q.sqrt(), 0.0, 0.0], q, false), ranges, "fold");
        lies_on(&found, |[q, p]| 27.0 * p * p - 4.0 * q * q * q, 1e-11);
        assert_eq!(found.stops, [CurveStop::Range; 2], "{q}");
    }
}

/// Equilibria of `x' = p² + q² - 1 + x²` are a sphere, and folds its equator.
#[derive(Clone, Copy)]
struct Sphere;

impl Planar for Sphere {
    fn rates<T: Scalar>(_: Side, &[x, y, q, p]: &[T; 4]) -> [T; 2] {
        [p * p + q * q - 1.0 + x * x, -y]
    }
}

#[test]
fn a_closed_curve_of_folds_closes_after_one_round() {
    let ranges = ((-2.5, 2.5), (-2.5, 2.5));
    let found = curve(Sphere, ([-0.9, 0.0, 0.0], 0.3, true), ranges, "fold");
    lies_on(&found, |[q, p]| p * p + q * q - 1.0, 1e-11);
    assert_eq!(found.stops, [CurveStop::Closed; 2]);
    assert_eq!(
        found.points[0].parameters,
        found.points.last().unwrap().parameters
    );
    let angle = |point: &[f64; 2]| math::atan2(point[0], point[1]);
    let angles: Vec<f64> = found
        .points
        .iter()
        .map(|at| angle(&at.parameters))
        .collect();
    let turns = angles.windows(2).map(|pair| {
        let turn = pair[1] - pair[0];
        turn - (turn / std::f64::consts::TAU).round() * std::f64::consts::TAU
    });
    let round: f64 = turns.sum();
    assert!(
        (round.abs() - std::f64::consts::TAU).abs() < 1e-9,
        "{round}"
    );
    assert!(found.special.is_empty());
}

/// The focus at (p, 0) with the decay `0.3 + q` comes to the boundary `x = q² + 0.2` at `p = q² +
/// 0.2`. At q = -0.3 its eigenvalues are imaginary there.
#[derive(Clone, Copy)]
struct Collision;

impl Planar for Collision {
    fn rates<T: Scalar>(side: Side, &[x, y, q, p]: &[T; 4]) -> [T; 2] {
        let (off, decay) = (x - p, q + 0.3);
        match side {
            Side::Below => [-off * decay - y, off - y * decay],
            Side::Above => [T::constant(-1.0), T::constant(1.0)],
        }
    }
    fn surface<T: Scalar>(&[x, _, q, _]: &[T; 4]) -> T {
        x - q * q - 0.2
    }
}

#[test]
fn a_curve_of_boundary_equilibria_is_where_the_focus_comes_to_the_boundary() {
    let ranges = ((-1.0, 2.0), (-1.0, 1.0));
    for start in [
        ([-0.3, 0.0, -0.3], 0.2, true),
        ([0.24, -0.1, 0.5], 0.2, false),
    ] {
        let found = curve(Collision, start, ranges, "boundary equilibrium");
        lies_on(&found, |[q, p]| p - q * q - 0.2, 1e-12);
        assert_eq!(found.stops, [CurveStop::Range; 2]);
        let EquilibriumBifurcation::Boundary { before, .. } = found.at.what else {
            panic!("{:?}", found.at);
        };
        assert_eq!(before, found.at.mode);
        // The sliding field has one dimension.
        if start.2 {
            assert_eq!(names(&found), ["Hopf at boundary equilibrium"]);
            let at = &found.special[0];
            assert!(
                (at.parameters[0] + 0.3).abs() <= at.uncertainties[0],
                "{at:?}"
            );
            assert!(at.uncertainties[0] < 1e-9, "{at:?}");
        }
    }
}

/// `x' = p - x²` with y decaying, below the boundary `x = q`: folds at p = 0 meet it at q = 0.
#[derive(Clone, Copy)]
struct FoldAtEdge;

impl Planar for FoldAtEdge {
    fn rates<T: Scalar>(side: Side, &[x, y, _, p]: &[T; 4]) -> [T; 2] {
        match side {
            Side::Below => [p - x * x, -y],
            Side::Above => [T::constant(1.0), -y],
        }
    }
    fn surface<T: Scalar>(&[x, _, q, _]: &[T; 4]) -> T {
        x - q
    }
}

#[test]
fn a_curve_of_folds_ends_at_a_boundary_and_one_of_boundary_equilibria_passes_the_fold() {
    let ranges = ((-1.0, 2.0), (-1.0, 1.0));
    let start = ([-1.0, 0.0, 1.0], 0.5, false);
    let found = curve(FoldAtEdge, start, ranges, "fold");
    lies_on(&found, |[_, p]| p, 1e-12);
    assert_eq!(found.stops, [CurveStop::AnotherChange, CurveStop::Range]);
    assert_eq!(names(&found), ["fold at boundary equilibrium"]);
    let at = &found.special[0];
    assert!(at.parameters[0].abs() <= at.uncertainties[0], "{at:?}");
    assert!(at.uncertainties[0] < 1e-9 && at.behind == 0, "{at:?}");
    let found = curve(FoldAtEdge, start, ranges, "boundary equilibrium");
    lies_on(&found, |[q, p]| p - q * q, 1e-12);
    assert_eq!(names(&found), ["fold at boundary equilibrium"]);
    assert_eq!(found.stops, [CurveStop::Range; 2]);
}

/// Two oscillators whose rates of growth are `p + q` and `p - q`, and a fold `u' = p + 2 - u²`. The
/// equilibrium has u = √(p + 2) and its decay; the third oscillator grows by `q - u`.
struct Pairs<const N: usize>(f64);

impl<const N: usize> Filippov<N> for Pairs<N> {
    fn field<T: Scalar>(&self, _: Side, _t: T, x: &[T; N]) -> [T; N] {
        let p = x[N - 1];
        let q = if N == 9 { x[7] } else { T::constant(self.0) };
        let mut rates = [T::zero(); N];
        let turning = [(p + q, 1.0), (p - q, 2.0), (q - x[6], 3.0)];
        for (k, (grows, frequency)) in turning.into_iter().enumerate() {
            let (a, b) = (x[2 * k], x[2 * k + 1]);
            rates[2 * k] = grows * a - b * frequency;
            rates[2 * k + 1] = a * frequency + grows * b;
        }
        rates[6] = p + 2.0 - x[6] * x[6];
        rates
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; N]) -> T {
        x[6] - 50.0
    }
}

fn of_nine() -> DynamicsRef<'static> {
    Traced::of(&Pairs::<9>(0.0)).dynamics()
}

/// The special equilibria of [`Pairs`] between p = -3 and 3, with q = 0.5, and the curve of one.
fn of_pairs(number: usize) -> (Vec<SpecialEquilibrium>, Result<EquilibriumCurve, Error>) {
    let settings = ContinuationSettings::over(-3.0, 3.0);
    let mut start = [0.0; 8];
    (start[6], start[7]) = (5.0_f64.sqrt(), 3.0);
    let options = Options::tol(1e-12);
    let of_eight = Traced::of(&Pairs::<8>(0.5)).dynamics();
    let branch = EquilibriumBranch::through(&of_eight, start, false, &settings, &options);
    let special = branch.unwrap().special;
    let at = &special[number];
    let (how, ones) = ((&settings, (-2.5, 2.5)), Vector::repeat(7, 1.0));
    let curve = at.curve(&of_nine(), (0.5, &ones), how);
    (special, curve)
}

/// The special equilibria of a curve: q, which lies within the uncertainty of a whole number, and
/// the name.
fn located(curve: &EquilibriumCurve) -> Vec<(f64, &'static str)> {
    let special = curve.special.iter();
    let located = special.map(|one| {
        let [q, _] = one.parameters;
        assert!((q - q.round()).abs() <= one.uncertainties[0], "{one:?}");
        assert!(one.uncertainties[0] < 1e-9, "{one:?}");
        let name = match one.what {
            EquilibriumCurveBifurcation::DoubleHopf => "double Hopf",
            EquilibriumCurveBifurcation::FoldHopf => "fold-Hopf",
            other => panic!("{other}"),
        };
        (q.round() + 0.0, name)
    });
    located.collect()
}

#[test]
fn curves_of_hopf_bifurcations_and_folds_name_what_they_meet() {
    let (special, first) = of_pairs(0);
    let places: Vec<f64> = special.iter().map(|at| at.parameter).collect();
    assert!((places[0] - 0.5).abs() < 1e-12, "{places:?}");
    let found = first.unwrap();
    lies_on(&found, |[q, p]| p - q, 1e-12);
    // Beyond the fold at p = -2 the curve comes back with u < 0. The first oscillator meets it at
    // q = 0 twice, the third one at q = u, which is 2 and -1.
    let met = located(&found);
    let expected = [
        (0.0, "double Hopf"),
        (-1.0, "double Hopf"),
        (-2.0, "fold-Hopf"),
        (0.0, "double Hopf"),
        (2.0, "double Hopf"),
    ];
    assert!(met == expected || met.iter().rev().eq(&expected), "{met:?}");
    assert_eq!(found.stops, [CurveStop::Range; 2]);
    let fold = special
        .iter()
        .position(|at| at.what == EquilibriumBifurcation::Fold);
    let (_, found) = of_pairs(fold.unwrap());
    let found = found.unwrap();
    lies_on(&found, |[_, p]| p + 2.0, 1e-12);
    let met = located(&found);
    let expected = [-2.0, 0.0, 2.0].map(|q| (q, "fold-Hopf"));
    assert!(met == expected || met.iter().rev().eq(&expected), "{met:?}");
}

#[test]
fn a_branch_point_has_no_curve_and_what_is_no_parameter_is_refused() {
    let (special, _) = of_pairs(0);
    let branch_point = SpecialEquilibrium {
        what: EquilibriumBifurcation::BranchPoint,
        ..special[0].clone()
    };
    let settings = ContinuationSettings::over(-3.0, 3.0);
    let ones = Vector::repeat(7, 1.0);
    let curve = |at: &SpecialEquilibrium, other: f64| {
        let how = (&settings, (-2.5, 2.5));
        at.curve(&of_nine(), (other, &ones), how)
    };
    let error = curve(&branch_point, 0.5).unwrap_err();
    assert!(matches!(error, Error::NotFound { .. }), "{error}");
    let outside = ContinuationSettings::over(1.0, 3.0);
    let how = (&outside, (-2.5, 2.5));
    let error = special[0].curve(&of_nine(), (0.5, &ones), how);
    let error = error.unwrap_err();
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

/// A relay of one state, `x' = p - x - (m + m²/10) sgn x`. It sticks at x = 0 up to
/// `|p| = m + m²/10`. The sliding field is rounding alone.
struct Relay<const N: usize>;

impl<const N: usize> Filippov<N> for Relay<N> {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; N]) -> [T; N] {
        let m = if N == 3 { x[1] } else { T::constant(1.0) };
        let mut rates = [T::zero(); N];
        rates[0] = x[N - 1] - x[0] - (m + m * m * 0.1) * side.sign();
        rates
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; N]) -> T {
        x[0]
    }
}

#[test]
fn boundary_equilibria_of_a_relay_of_one_state_are_followed_to_the_ends_of_the_range() {
    let settings = ContinuationSettings::over(-3.0, 3.0);
    let options = Options::tol(1e-12);
    for upwards in [false, true] {
        let branch =
            EquilibriumBranch::through(&Relay::<2>, [0.0, 0.3], upwards, &settings, &options)
                .unwrap();
        let how = (&settings, (0.1, 2.0));
        let found = branch.special[0].curve(&Relay::<3>, (1.0, &branch.sizes), how);
        let found = found.unwrap();
        let sign = if upwards { 1.0 } else { -1.0 };
        lies_on(&found, |[m, p]| p - sign * (m + m * m * 0.1), 1e-12);
        assert_eq!(found.stops, [CurveStop::Range; 2]);
    }
}

/// `x' = p + x - x³` folds at `|p| = 2/(3 √3)`. The boundary is q = 1, beside which the field is
/// the same.
struct Gate<const N: usize>;

impl<const N: usize> Filippov<N> for Gate<N> {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; N]) -> [T; N] {
        let mut rates = [T::zero(); N];
        rates[0] = x[N - 1] + x[0] - x[0] * x[0] * x[0];
        rates
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; N]) -> T {
        if N == 3 { x[1] - 1.0 } else { T::constant(0.5) }
    }
}

#[test]
fn a_curve_does_not_go_where_a_guard_that_is_zero_at_its_beginning_is_negative() {
    let settings = ContinuationSettings::over(-1.0, 1.0);
    let options = Options::tol(1e-12);
    let branch =
        EquilibriumBranch::through(&Gate::<2>, [1.0, 0.0], false, &settings, &options).unwrap();
    let (at, sizes, range) = (&branch.special[0], &branch.sizes, (0.0, 2.0));
    let along = |q: f64| at.curve(&Gate::<3>, (q, sizes), (&settings, range));
    let found = along(1.0).unwrap();
    assert_eq!(found.points[0].parameters[0], 1.0);
    assert_eq!(found.points.last().unwrap().parameters[0], 2.0);
    lies_on(
        &found,
        |[_, p]| p.abs() - 2.0 / (3.0 * 3.0_f64.sqrt()),
        1e-12,
    );
    assert_eq!(found.stops, [CurveStop::NoConvergence, CurveStop::Range]);
    // The mode has no equilibrium at q < 1 at all.
    assert_eq!(along(0.5).unwrap().points.len(), 1);
}
