//! Curves of changes of the phases in two parameters, against closed forms.

use std::f64::consts::PI;

use stickslip::analysis::{ContinuationSettings, CurveStop, SequenceBifurcation, continue_change};
use stickslip::{Error, Filippov, Method, Options, Scalar, Side, math};

use crate::listed::{Listed, traced};

traced!(3: Lag);
traced!(4: Touched);

/// `y' = -c y + cos t` below `y = p`, above which all falls: it touches where `p √(1 + c²) = 1`.
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
            let found = continue_change(
                &Lag.dynamics(),
                start,
                (6.3, false, 0),
                (&settings, (0.2, 2.0)),
                &options,
            );
            let found = found.unwrap();
            assert_eq!(
                found.change.bifurcation,
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

/// `r' = r (p + 2 r² - r⁴)`, `θ' = 1`, and a line at `x = q`, which means nothing. The cycles touch
/// it where `p = (q² - 1)² - 1`: past the fold at `p = -1` from the outer to the inner ones.
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
    // The outer cycle at p is left of the line at q = 5/4 up to p = (9/16)² - 1.
    let exact = math::powi(1.25 * 1.25 - 1.0, 2) - 1.0;
    let settings = ContinuationSettings::over(-1.5, 0.5);
    let radius = (1.0 + 0.1_f64.sqrt()).sqrt();
    let start = [radius, 0.0, 1.25, -0.9];
    let options = Options::tol(1e-12);
    let found = continue_change(
        &Touched.dynamics(),
        start,
        (6.3, true, 0),
        (&settings, (0.3, 1.35)),
        &options,
    );
    let found = found.unwrap();
    assert!(
        (found.change.parameter - exact).abs() < 1e-9,
        "{exact} {:?}",
        found.change
    );
    assert_eq!(found.change.bifurcation, SequenceBifurcation::Grazing);
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

#[test]
fn what_has_no_change_is_told() {
    let settings = ContinuationSettings::over(1.05, 1.2).forced(2.0 * PI);
    let options = Options::tol(1e-10);
    let start = [place(0.5), 0.5, 1.1];
    let none = continue_change(
        &Lag.dynamics(),
        start,
        (6.3, true, 0),
        (&settings, (0.2, 2.0)),
        &options,
    );
    assert!(matches!(none, Err(Error::NotFound { .. })), "{none:?}");
    let settings = ContinuationSettings::over(0.3, 1.2).forced(2.0 * PI);
    let wrong = continue_change(
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
