//! Curves of special orbits in two parameters, compared with closed forms.

use std::f64::consts::PI;

use stickslip::analysis::{
    ContinuationSettings, Curve, CurveStop, CycleBifurcation, SequenceBifurcation, SequenceChange,
};
use stickslip::dynamics::{self, Components};
use stickslip::{
    Contacts, Error, Filippov, Method, Options, Scalar, Several, Side, TransitionKind, math, solve,
};

use super::sweeps::{coming_back, landing};
use super::systems::FasterBelt;
use crate::compiled::{Compiled, traced};

traced!(3: Lag);
traced!(4: Touched);
traced!(4: Rings);
traced!(3: Cusp);
traced!(4: Doubled);
traced!(4: Turned);
traced!(3: TwoParameters);
traced!(4: Damped);

/// The change of phases with which a curve begins.
fn change(curve: &Curve) -> &SequenceChange {
    match &curve.at.what {
        CycleBifurcation::Sequence(change) => change,
        other => panic!("{other}"),
    }
}

/// `y' = -c y + cos t` below `y = p`; above it the field points down. It touches where `p √(1 + c²)
/// = 1`.
struct Lag;

impl Filippov<3> for Lag {
    fn field<T: Scalar>(&self, side: Side, t: T, &[y, lag, _]: &[T; 3]) -> [T; 3] {
        let rate = match side {
            Side::Below => t.cos() - lag * y,
            Side::Above => T::constant(-1.0),
        };
        [rate, T::zero(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0] - x[2]
    }
}

/// The orbit of [`Lag`] at time 0.
fn place(lag: f64) -> f64 {
    lag / (1.0 + lag * lag)
}

#[test]
fn a_curve_of_grazes_has_a_closed_form_by_both_methods_at_any_tolerance() {
    let settings = ContinuationSettings::over(0.3, 1.2).forced(2.0 * PI);
    for method in [Method::Dop853, Method::Taylor] {
        for tolerance in [1e-9, 1e-12] {
            let options = Options::tol(tolerance).method(method);
            let start = [place(0.5), 0.5, 1.1];
            let found = Curve::of_special(
                &Lag.dynamics(),
                start,
                (6.3, false, 0),
                (&settings, (0.2, 2.0)),
                &options,
            );
            let found = found.unwrap();
            assert_eq!(
                change(&found).bifurcation,
                SequenceBifurcation::GrazingSliding
            );
            assert_eq!(
                found.stops,
                [CurveStop::Range; 2],
                "{:?} {:?}",
                found.points.first(),
                found.points.last()
            );
            let mut worst = 0.0_f64;
            for point in &found.points {
                let [lag, height] = point.parameters;
                worst = worst.max((height * (1.0 + lag * lag).sqrt() - 1.0).abs());
            }
            assert!(
                worst < 100.0 * tolerance,
                "{method:?} {tolerance:e}: {worst:e}"
            );
            let ends = [found.points.first(), found.points.last()];
            let ends = ends.map(|point| point.unwrap().parameters[0]);
            assert!(
                (ends[0] - 0.2).abs() < 1e-9 && (ends[1] - 2.0).abs() < 1e-9,
                "{ends:?}"
            );
            let first = &found.points[found.first].parameters;
            assert!((first[0] - 0.5).abs() < 1e-12 && (first[1] - 0.8_f64.sqrt()).abs() < 1e-6);
        }
    }
}

/// `r' = r (p + 2 r² - r⁴)`, `θ' = 1`, and a line at `x = q` without effect. The cycles touch it
/// where `p = (q² - 1)² - 1`: beyond the fold at `p = -1` the outer cycles become the inner ones.
struct Touched;

impl Filippov<4> for Touched {
    fn field<T: Scalar>(&self, _side: Side, _t: T, &[x, y, _, p]: &[T; 4]) -> [T; 4] {
        let square = x * x + y * y;
        let grows = p + square * 2.0 - square * square;
        [x * grows - y, y * grows + x, T::zero(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0] - x[2]
    }
}

#[test]
fn a_curve_of_grazes_goes_round_the_fold_of_the_orbits_that_graze() {
    // The outer cycle at p is left of the line at q = 5/4 for p < (9/16)² - 1.
    let exact = math::powi(1.25 * 1.25 - 1.0, 2) - 1.0;
    let settings = ContinuationSettings::over(-1.5, 0.5);
    let radius = (1.0 + 0.1_f64.sqrt()).sqrt();
    let start = [radius, 0.0, 1.25, -0.9];
    let options = Options::tol(1e-12);
    let found = Curve::of_special(
        &Touched.dynamics(),
        start,
        (6.3, true, 0),
        (&settings, (0.3, 1.35)),
        &options,
    );
    let found = found.unwrap();
    assert!(
        (change(&found).parameter - exact).abs() < 1e-9,
        "{exact} {:?}",
        found.at
    );
    assert_eq!(change(&found).bifurcation, SequenceBifurcation::Grazing);
    let mut least = f64::INFINITY;
    for point in &found.points {
        let [place, p] = point.parameters;
        let off = math::powi(place * place - 1.0, 2) - 1.0 - p;
        assert!(off.abs() < 1e-10, "{place} {p}: {off:e}");
        assert!((point.period - 2.0 * PI).abs() < 1e-9);
        least = least.min(p);
    }
    assert!(least < -0.99, "{least}");
    let ends = [found.points.first(), found.points.last()];
    let ends = ends.map(|point| point.unwrap().parameters[0]);
    assert!(
        (ends[0] - 0.3).abs() < 1e-9 && (ends[1] - 1.35).abs() < 1e-9,
        "{ends:?}"
    );
}

/// The curve through the first change of the phases keeps to its closed form over the range of `q`,
/// by both methods and at two tolerances. The closed form is itself as accurate as `at_best`.
fn follows<Any>(
    system: &impl dynamics::AsDynamics<Any>,
    start: impl Components + Copy,
    (period, upwards): (f64, bool),
    (settings, other): (&ContinuationSettings, (f64, f64)),
    (name, exact): (SequenceBifurcation, impl Fn(f64) -> f64),
    at_best: f64,
) {
    for method in [Method::Dop853, Method::Taylor] {
        for tolerance in [1e-9, 1e-12] {
            let options = Options::tol(tolerance).method(method);
            let way = (period, upwards, 0);
            let found = Curve::of_special(system, start, way, (settings, other), &options);
            let found = found.unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(change(&found).bifurcation, name);
            let at = format!("{name} by {method:?} at {tolerance:e}");
            assert_eq!(found.stops, [CurveStop::Range; 2], "{at}: {found:?}");
            for point in &found.points {
                let [q, p] = point.parameters;
                let off = (p - exact(q)).abs();
                assert!(off < 1e3 * tolerance + at_best, "{at}, {q}: {off:e}");
            }
            let ends = [found.points.first(), found.points.last()];
            let [low, high] = ends.map(|point| point.unwrap().parameters[0]);
            assert!((low - other.0).abs() < 1e-9 && (high - other.1).abs() < 1e-9);
            assert!(found.points.len() > 5, "{at}: {}", found.points.len());
        }
    }
}

/// The rhythms of [`super::systems::Rhythm`] with a second parameter `q`.
#[derive(Clone, Copy, Debug)]
enum TwoParameters {
    /// Up at `9/5 + 2 sin t` from below, down at `q - p cos t` from above.
    Part,
    /// Up at `1/2 + sin t` from below, up at `sin(t - p) - q` above.
    Meet,
    /// `y = sin t` attracts below a distant boundary. Contact is lost where `q cos t > p`.
    Lift,
}

impl Filippov<3> for TwoParameters {
    fn field<T: Scalar>(&self, side: Side, t: T, &[y, q, p]: &[T; 3]) -> [T; 3] {
        let rate = match (self, side) {
            (TwoParameters::Part, Side::Below) => t.sin() * 2.0 + 1.8,
            (TwoParameters::Part, Side::Above) => t.cos() * p - q,
            (TwoParameters::Meet, Side::Below) => t.sin() + 0.5,
            (TwoParameters::Meet, Side::Above) => (t - p).sin() - q,
            (TwoParameters::Lift, _) => -y + t.sin() + t.cos(),
        };
        [rate, T::zero(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, &[y, ..]: &[T; 3]) -> T {
        match self {
            TwoParameters::Lift => y - 5.0,
            _ => y,
        }
    }
    fn contact<T: Scalar>(&self, t: T, &[_, q, p]: &[T; 3]) -> Option<T> {
        matches!(self, TwoParameters::Lift).then(|| p - q * t.cos())
    }
}

#[test]
fn curves_of_sliding_bifurcations_and_lost_contact_have_closed_forms() {
    let arcsin = |q: f64| math::atan(q / (1.0 - q * q).sqrt());
    let crossing = |q: f64| landing() - arcsin(q);
    let switching = |q: f64| landing() - PI + arcsin(q);
    let same = |q: f64| q;
    type Exact<'e> = &'e dyn Fn(f64) -> f64;
    let curves: [(_, _, f64, Exact<'_>); 4] = [
        (
            TwoParameters::Part,
            SequenceBifurcation::AddingSliding,
            1.0,
            &same,
        ),
        (
            TwoParameters::Meet,
            SequenceBifurcation::CrossingSliding,
            0.7,
            &crossing,
        ),
        (
            TwoParameters::Meet,
            SequenceBifurcation::SwitchingSliding,
            0.7,
            &switching,
        ),
        (
            TwoParameters::Lift,
            SequenceBifurcation::ContactGrazing,
            1.0,
            &same,
        ),
    ];
    for (system, name, q, exact) in curves {
        for upwards in [false, true] {
            let begin = exact(q) + if upwards { -0.1 } else { 0.09 };
            let settings = ContinuationSettings::over(exact(q) - 0.3, exact(q) + 0.3);
            let settings = settings.forced(2.0 * PI);
            let options = Options::tol(1e-12);
            let run = solve(&system.any(), 0.0, [-0.5, q, begin], 40.0 * PI, &options);
            let start = [run.unwrap().x_end[0], q, begin];
            let ranges = (&settings, (q - 0.1, q + 0.1));
            let system = &system.dynamics();
            follows(system, start, (6.3, upwards), ranges, (name, exact), 1e-12);
        }
    }
}

/// [`FasterBelt`] with its damping as a second parameter, before the static friction.
struct Damped;

impl Damped {
    fn rates<T: Scalar>([x, v, damping, _]: [T; 4], friction: T) -> [T; 4] {
        [v, -x - damping * v * 2.0 - friction, T::zero(), T::zero()]
    }
}

impl Filippov<4> for Damped {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        Damped::rates(*x, T::constant(side.sign()))
    }
    fn holding<T: Scalar>(&self, side: Side, _t: T, x: &[T; 4]) -> [T; 4] {
        Damped::rates(*x, x[3] * side.sign())
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[1] - 1.0
    }
}

/// The block comes back to the belt ever more tangentially, until it misses it.
#[test]
fn a_curve_of_grazes_at_the_end_of_a_slip_has_a_closed_form() {
    let damping = FasterBelt::DAMPING;
    let begin = coming_back(damping) + 0.01;
    let options = Options::tol(1e-12);
    let run = solve(
        &Damped.any(),
        0.0,
        [0.0, 1.0, damping, begin],
        100.0,
        &options,
    )
    .unwrap();
    let exits = run.transitions.iter();
    let exits = exits.filter(|at| at.kind == TransitionKind::StickExit);
    let times: Vec<f64> = exits.map(|at| at.t).collect();
    let period = times[times.len() - 1] - times[times.len() - 2];
    let (system, start) = (Damped.dynamics(), run.x_end);
    let settings = ContinuationSettings::over(1.2, 3.0);
    let ranges = (&settings, (0.03, 0.08));
    let kind = (SequenceBifurcation::GrazingSliding, coming_back);
    follows(&system, start, (period, false), ranges, kind, 1e-12);
}

/// Two contacts, the first of which is a clock that crosses its boundary at 3/10 and 3/10 + π.
#[derive(Clone, Copy, Debug)]
enum Pair {
    /// The second is pulled by `1 + q cos(t - 3/10) - |sin(t - 3/10)|` and held by `p`. The pull
    /// has a kink where the clock crosses, and is largest there: `1 + q`.
    Kinked,
    /// The second is pulled by `3/10 sin(t - 3/10) + 1/5 cos(t - 3/10) + 1/10 - q`, with `+ q`
    /// until the clock crosses upwards, and held by `p`. At that crossing the pull has risen to `q
    /// + 3/10`.
    Dropped,
    /// Both are clocks, which cross at `q` and `p`, and half a period later.
    Clocks,
}

impl Contacts<4, 2> for Pair {
    fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, &[first, second, q, p]: &[T; 4]) -> [T; 4] {
        let clock = |x: T, phase: T| (t - phase).sin() + (t - phase).cos() - x;
        let (sin, cos) = (t - 0.3).sin_cos();
        let [one, other] = sides.map(Side::sign);
        let (start, rate) = match self {
            Pair::Kinked => (T::constant(0.3), q * cos - first * one + 1.0 - p * other),
            Pair::Dropped => (
                T::constant(0.3),
                sin * 0.3 + cos * 0.2 + 0.1 - q * one - p * other,
            ),
            Pair::Clocks => (q, clock(second, p)),
        };
        [clock(first, start), rate, T::zero(), T::zero()]
    }
    fn boundaries<T: Scalar>(&self, _t: T, &[first, second, ..]: &[T; 4]) -> [T; 2] {
        [first, second]
    }
}

#[test]
fn curves_of_changes_where_another_contact_switches_have_closed_forms() {
    type Exact = fn(f64) -> f64;
    let curves: [(Pair, Exact, f64); 3] = [
        (Pair::Kinked, |q| 1.0 + q, 0.3),
        (Pair::Dropped, |q| 0.3 + q, 0.3),
        (Pair::Clocks, |q| q, 0.5),
    ];
    for (pair, exact, crosses) in curves {
        for off in [-0.1, 0.1] {
            let q = 0.5;
            let p = exact(q) + off;
            let second = match pair {
                Pair::Clocks => -math::sin(p),
                _ => 0.0,
            };
            let start = [-math::sin(crosses), second, q, p];
            let settings = ContinuationSettings::over(exact(q) - 0.3, exact(q) + 0.3);
            let settings = settings.forced(2.0 * PI);
            let ranges = (&settings, (q - 0.1, q + 0.1));
            let kind = (SequenceBifurcation::Coincidence, exact);
            follows(&Several(pair), start, (6.3, off < 0.0), ranges, kind, 0.0);
        }
    }
}

/// `r' = r (p + q r² - r⁴)`, `θ' = 1`: cycles fold where `p = -q²/4`, at `r² = q/2`. A boundary at
/// x = 0.1 is crossed without effect.
struct Rings;

impl Filippov<4> for Rings {
    fn field<T: Scalar>(&self, _side: Side, _t: T, &[x, y, q, p]: &[T; 4]) -> [T; 4] {
        let square = x * x + y * y;
        let grows = p + q * square - square * square;
        [x * grows - y, y * grows + x, T::zero(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0] - 0.1
    }
}

#[test]
fn a_curve_of_folds_has_a_closed_form_by_both_methods_at_any_tolerance() {
    let settings = ContinuationSettings::over(-3.0, 0.0);
    for method in [Method::Dop853, Method::Taylor] {
        for tolerance in [1e-9, 1e-12] {
            let options = Options::tol(tolerance).method(method);
            let start = [(1.0 + 0.5_f64.sqrt()).sqrt(), 0.0, 2.0, -0.5];
            let ranges = (&settings, (0.5, 3.0));
            let found =
                Curve::of_special(&Rings.dynamics(), start, (6.3, false, 0), ranges, &options);
            let found = found.unwrap();
            assert_eq!(found.at.what, CycleBifurcation::Fold);
            assert_eq!(found.stops, [CurveStop::Range; 2]);
            for point in &found.points {
                let [q, p] = point.parameters;
                let off = (p + 0.25 * q * q).abs();
                assert!(
                    off < 100.0 * tolerance,
                    "{method:?} {tolerance:e} at {q}: {off:e}"
                );
                assert!((point.period - 2.0 * PI).abs() < 1e3 * tolerance);
            }
            let ends = [found.points.first(), found.points.last()];
            let ends = ends.map(|point| point.unwrap().parameters[0]);
            assert!((ends[0] - 0.5).abs() < 1e-9 && (ends[1] - 3.0).abs() < 1e-9);
            assert!(found.points.len() > 30, "{}", found.points.len());
        }
    }
}

/// `u' = p + q u - u³` about `cos t`: folds where `p = -2 u³` and `q = 3 u²`, with a cusp at `p = q
/// = 0`. A boundary at 0.2 is crossed without effect.
struct Cusp;

impl Filippov<3> for Cusp {
    fn field<T: Scalar>(&self, _side: Side, t: T, &[x, q, p]: &[T; 3]) -> [T; 3] {
        let (sin, cos) = t.sin_cos();
        let u = x - cos;
        [p + q * u - u * u * u - sin, T::zero(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0] - 0.2
    }
}

#[test]
fn a_curve_of_folds_goes_round_its_cusp() {
    let settings = ContinuationSettings::over(-1.0, 1.0).forced(2.0 * PI);
    for method in [Method::Dop853, Method::Taylor] {
        let options = Options::tol(1e-12).method(method);
        let start = [1.0 + 0.75_f64.sqrt(), 0.75, 0.0];
        let ranges = (&settings, (-0.5, 1.0));
        let found = Curve::of_special(&Cusp.dynamics(), start, (6.3, false, 0), ranges, &options);
        let found = found.unwrap();
        assert_eq!(found.at.what, CycleBifurcation::Fold);
        assert!((found.at.parameter + 0.25).abs() < 1e-9);
        assert_eq!(found.stops, [CurveStop::Range; 2]);
        let mut least = f64::INFINITY;
        for point in &found.points {
            let [q, p] = point.parameters;
            let u = point.x[0] - math::cos(point.t);
            let off = [p + 2.0 * u * u * u, q - 3.0 * u * u].map(f64::abs);
            assert!(off[0].max(off[1]) < 1e-9, "{u} {q} {p}: {off:?}");
            least = least.min(q);
        }
        assert!(least < 1e-2, "{least}");
        let ends = [found.points.first(), found.points.last()].map(|point| point.unwrap());
        assert!(
            ends.iter()
                .all(|end| (end.parameters[0] - 1.0).abs() < 1e-9)
        );
        assert!(ends[0].parameters[1] * ends[1].parameters[1] < -0.1);
    }
}

/// The orbit `c = (cos t, sin t)`. About it, in a frame that rotates half as fast, the rates are
/// `(p + q²) u - u³` and `-w`. Its period doubles where `p = -q²`.
struct Doubled;

impl Filippov<4> for Doubled {
    fn field<T: Scalar>(&self, _side: Side, t: T, &[x, y, q, p]: &[T; 4]) -> [T; 4] {
        let (sin, cos) = t.sin_cos();
        let (half_sin, half_cos) = (t * 0.5).sin_cos();
        let (a, b) = (x - cos, y - sin);
        let (u, w) = (half_cos * a + half_sin * b, half_cos * b - half_sin * a);
        let (along, across) = ((p + q * q) * u - u * u * u, -w);
        [
            -sin - b * 0.5 + half_cos * along - half_sin * across,
            cos + a * 0.5 + half_sin * along + half_cos * across,
            T::zero(),
            T::zero(),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0] - 0.2
    }
}

/// The orbit of [`Doubled`] with a torus. Deviations from it rotate at the rate 0.3 and grow at `p
/// + q²` minus their square. A torus branches off where `p = -q²`, at an angle of 0.6 π.
struct Turned;

impl Filippov<4> for Turned {
    fn field<T: Scalar>(&self, _side: Side, t: T, &[x, y, q, p]: &[T; 4]) -> [T; 4] {
        let (sin, cos) = t.sin_cos();
        let (a, b) = (x - cos, y - sin);
        let grows = p + q * q - a * a - b * b;
        [
            grows * a - b * 0.3 - sin,
            grows * b + a * 0.3 + cos,
            T::zero(),
            T::zero(),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0] - 0.2
    }
}

#[test]
fn curves_of_flips_and_of_tori_have_closed_forms_by_both_methods() {
    let settings = ContinuationSettings::over(-0.4, 0.3).forced(2.0 * PI);
    let (start, way) = ([1.0, 0.0, 0.3, -0.3], (6.3, true, 0));
    let ranges = (&settings, (-0.5, 0.5));
    for method in [Method::Dop853, Method::Taylor] {
        for tolerance in [1e-9, 1e-12] {
            let options = Options::tol(tolerance).method(method);
            let flips = Curve::of_special(&Doubled.dynamics(), start, way, ranges, &options);
            let tori = Curve::of_special(&Turned.dynamics(), start, way, ranges, &options);
            let [flips, tori] = [flips.unwrap(), tori.unwrap()];
            assert_eq!(flips.at.what, CycleBifurcation::Flip);
            let CycleBifurcation::NeimarkSacker { angle } = tori.at.what else {
                panic!("{}", tori.at.what);
            };
            assert!((angle - 0.6 * PI).abs() < 1e-5, "{angle}");
            for curve in [flips, tori] {
                assert_eq!(curve.stops, [CurveStop::Range; 2]);
                for point in &curve.points {
                    let [q, p] = point.parameters;
                    let off = (p + q * q).abs();
                    // Accuracy of the multipliers: the uncertainty of the first location.
                    let known = 4.0 * curve.at.uncertainty;
                    assert!(off < known, "{method:?} {tolerance:e} at {q}: {off:e}");
                }
                let ends = [curve.points.first(), curve.points.last()];
                let ends = ends.map(|point| point.unwrap().parameters[0]);
                assert!((ends[0] + 0.5).abs() < 1e-9 && (ends[1] - 0.5).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn what_has_no_change_is_reported() {
    let settings = ContinuationSettings::over(1.05, 1.2).forced(2.0 * PI);
    let options = Options::tol(1e-10);
    let start = [place(0.5), 0.5, 1.1];
    let none = Curve::of_special(
        &Lag.dynamics(),
        start,
        (6.3, true, 0),
        (&settings, (0.2, 2.0)),
        &options,
    );
    assert!(matches!(none, Err(Error::NotFound { .. })), "{none:?}");
    let settings = ContinuationSettings::over(0.3, 1.2).forced(2.0 * PI);
    let wrong = Curve::of_special(
        &Lag.dynamics(),
        start,
        (6.3, true, 0),
        (&settings, (2.0, 2.0)),
        &options,
    );
    assert!(
        matches!(wrong, Err(Error::Option { name: "range", .. })),
        "{wrong:?}"
    );
}
