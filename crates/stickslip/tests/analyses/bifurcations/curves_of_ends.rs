//! Curves of homoclinic orbits and two-folds in two parameters, compared with closed forms.

use stickslip::analysis::{ContinuationSettings, Curve, CurveStop, CycleBifurcation};
use stickslip::{Error, Filippov, Mode, Options, Scalar, Side, math, solve};

use super::branches::accuracies;
use crate::compiled::{Compiled, traced};

traced!(4: Loop);
traced!(4: Turns);

/// The Hamiltonian flow of `H = y²/2 - x²/2 + x³/3`, with a part along its gradient: the level
/// `H = q² - p` attracts the orbits. It is a cycle about (1, 0), and the loop of the saddle at the
/// origin where `p = q²`. Beyond `x = 1` everything is twice as fast.
struct Loop;

fn level<T: Scalar>(x: T, y: T) -> T {
    y * y * 0.5 - x * x * 0.5 + x * x * x * (1.0 / 3.0)
}

impl Filippov<4> for Loop {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, y, q, p]: &[T; 4]) -> [T; 4] {
        let slope = x * x - x;
        let off = level(x, y) + p - q * q;
        let speed = match side {
            Side::Below => 1.0,
            Side::Above => 2.0,
        };
        let rates = [y - off * slope, -slope - off * y];
        [rates[0] * speed, rates[1] * speed, T::zero(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[0] - 1.0
    }
}

/// Below `y = 0` the field `(-1, q - x)`, above it `(1, p - sin x - x²)`. Orbits cross and turn
/// about the points where these are tangent, which coincide where `p = sin q + q²`.
struct Turns;

impl Filippov<4> for Turns {
    fn field<T: Scalar>(&self, side: Side, _t: T, &[x, _, q, p]: &[T; 4]) -> [T; 4] {
        let rates = match side {
            Side::Below => [T::constant(-1.0), q - x],
            Side::Above => [T::constant(1.0), p - x.sin() - x * x],
        };
        [rates[0], rates[1], T::zero(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 4]) -> T {
        x[1]
    }
}

/// A state on the orbit that a start approaches, and the time between its last two crossings
/// upwards.
fn settled<S>(system: &S, start: [f64; 4], options: &Options) -> ([f64; 4], f64)
where
    S: Filippov<4> + Compiled<4>,
{
    let settled = solve(&system.any(), 0.0, start, 200.0, options).unwrap();
    let crossings = settled.transitions.iter().rev();
    let mut upwards = crossings.filter(|at| at.to == Mode::Slip(Side::Above));
    let [last, before] = [upwards.next().unwrap().t, upwards.next().unwrap().t];
    (settled.x_end.into(), last - before)
}

/// Whether a curve covers the range of the other parameter, and how far it lies from a function of
/// that.
fn off(curve: &Curve, ends: [f64; 2], function: impl Fn(f64) -> f64) -> f64 {
    assert_eq!(
        curve.stops,
        [CurveStop::Range; 2],
        "{:?}",
        curve.points.len()
    );
    let mut reached = [&curve.points[0], curve.points.last().unwrap()].map(|at| at.parameters[0]);
    reached.sort_by(f64::total_cmp);
    assert_eq!(reached, ends);
    let off = curve.points.iter().map(|at| {
        let ([q, p], uncertainty) = (at.parameters, at.uncertainty.unwrap());
        let off = (p - function(q)).abs();
        assert!(off <= uncertainty, "{q}: {off:e}, ± {uncertainty:e}");
        off
    });
    off.fold(0.0, f64::max)
}

#[test]
fn the_loops_of_a_saddle_lie_on_a_parabola() {
    let settings = ContinuationSettings::over(-0.1, 0.5);
    // The coarsest by one method, the finest by the other.
    for (tolerance, options) in accuracies().step_by(5) {
        let (start, period) = settled(&Loop, [0.5, 0.0, 0.3, 0.19], &options);
        let how = (&settings, (-0.4, 0.5));
        let curve = Curve::of_end(&Loop.dynamics(), start, (period, false), how, &options).unwrap();
        let CycleBifurcation::Homoclinic { saddles } = curve.at.what else {
            panic!("{}", curve.at.what);
        };
        assert_eq!(saddles.get(), 1);
        let off = off(&curve, [-0.4, 0.5], |q| q * q);
        assert!(off < tolerance + 1e-10, "{tolerance:e}: {off:e}");
    }
}

#[test]
fn the_points_where_two_tangencies_meet_lie_on_a_curve() {
    let settings = ContinuationSettings::over(-0.5, 1.0);
    for (tolerance, options) in accuracies() {
        let (start, period) = settled(&Turns, [-0.9, 0.05, 0.1, 0.3], &options);
        let how = (&settings, (-0.2, 0.4));
        let curve =
            Curve::of_end(&Turns.dynamics(), start, (period, false), how, &options).unwrap();
        assert_eq!(curve.at.what, CycleBifurcation::TwoFold);
        let off = off(&curve, [-0.2, 0.4], |q| math::sin(q) + q * q);
        assert!(off < 1e-10, "{tolerance:e}: {off:e}");
    }
}

#[test]
fn another_end_has_no_such_curve() {
    let settings = ContinuationSettings::over(0.25, 0.5);
    let options = Options::tol(1e-10);
    let (start, period) = settled(&Turns, [-0.9, 0.05, 0.1, 0.3], &options);
    let how = (&settings, (-0.2, 0.4));
    let found = Curve::of_end(&Turns.dynamics(), start, (period, false), how, &options);
    assert!(matches!(found, Err(Error::NotFound { .. })), "{found:?}");
    // An end is not among the special orbits.
    let settings = ContinuationSettings::over(-0.5, 0.5);
    let how = (&settings, (-0.2, 0.4));
    let found = Curve::of_special(&Turns.dynamics(), start, (period, false, 0), how, &options);
    assert!(matches!(found, Err(Error::NotFound { .. })), "{found:?}");
}
