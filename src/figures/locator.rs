//! Accuracy of five methods to locate an event: error against step length.
//!
//! This is not a figure of the paper. It measures what the paper's title promises.

use std::f64::consts::PI;

use super::FigureSpec;
use super::rows::Row;
use crate::paper::models::BeltOscillator;
use crate::paper::reading::Reading::Exact;
use crate::terminal::ProgramError;
use numerics::{PowerLaw, bisect};
use plot::{
    Axis, BLACK, BLUE, Color, Curve, Dash, Figure, GREEN, Legend, Markers, ORANGE, Panel, Shape,
    VERMILLION,
};
use stickslip::math;
use stickslip::ode::{Dense, Dop853, Rk4, RungeKutta, Timed, henon_step, step_end};
use stickslip::{Filippov, Side, State};

/// One method to locate an event.
#[derive(Clone, Debug)]
pub struct LocatorMethod {
    /// Name in rows.
    pub id: &'static str,
    /// Name in the legend.
    pub name: &'static str,
    /// Step lengths and errors of the event's time.
    pub errors: Vec<(f64, f64)>,
    /// Slope of the logarithm of the error against that of the step, where the error is above
    /// rounding.
    pub order: f64,
}

/// The event is at this fraction of the step. The middle would favour methods with symmetric
/// errors.
const EVENT_FRACTION: f64 = 0.6;
/// Speed of the belt, m/s.
const BELT_SPEED: f64 = 1.3;
/// Steps are 10^(-k/8), k from 0: three decades.
const STEP_RATIO: f64 = 0.749_894_209_332_455_8;
const STEPS: usize = 25;
/// Indices of the steps 0.1 and 0.01.
const REPORTED_STEPS: [(usize, &str); 2] = [(8, "error_at_0.1"), (16, "error_at_0.01")];
/// Errors below this are rounding: some units in the last place of times of order one.
const ROUNDING_FLOOR: f64 = 2e-15;
/// Least error that is used for the order: ten times the rounding.
const LEAST_FITTED_ERROR: f64 = 3e-14;
/// Longest step that is used for the order. Errors of longer ones are not yet a power of the step.
const LONGEST_FITTED_STEP: f64 = 0.5;

/// Error of the located event against step length.
pub const LOCATOR: FigureSpec<[LocatorMethod; 5]> = FigureSpec {
    name: "locator",
    title: "Error of a located event against the step",
    about: "A block on a belt of speed 1.3, x'' = -x - 0.4 sgn(x' - 1.3), moves on a circle of \
        radius 2.6 about (0.4, 0) until it is as fast as the belt: one step from the exact state \
        before crosses that event, which is then located by one Henon step of order 4 (the paper's \
        way) and of order 8, by a root search on the dense output of either order, and by linear \
        interpolation between the step's ends, as naive codes do. Reports the order of each and \
        its error at steps of 0.1 and 0.01.",
    compute,
    numbers,
    draw,
};

fn compute() -> Result<[LocatorMethod; 5], ProgramError> {
    let belt = BeltOscillator {
        k1: -1.0,
        k2: 0.0,
        mu0: 0.4,
        delta: 0.0,
        belt_speed: BELT_SPEED,
        ..BeltOscillator::default()
    };
    let method = |id, name, locate: fn(&Step) -> f64| {
        let errors = (0..STEPS).map(|k| math::powi(STEP_RATIO, k as i32));
        let errors: Vec<(f64, f64)> = errors.map(|h| (h, error(&belt, h, locate))).collect();
        LocatorMethod {
            id,
            name,
            order: order(&errors),
            errors,
        }
    };
    Ok([
        method("linear", "linear interpolation", Step::chord),
        method(
            "dense_4",
            "dense output of order 3 (RK4)",
            Step::on_dense::<Rk4>,
        ),
        method("henon_4", "Hénon step, order 4 (RK4)", Step::henon::<Rk4>),
        method(
            "dense_8",
            "dense output of order 7 (DOP853)",
            Step::on_dense::<Dop853>,
        ),
        method(
            "henon_8",
            "Hénon step, order 8 (DOP853)",
            Step::henon::<Dop853>,
        ),
    ])
}

fn numbers(methods: &[LocatorMethod; 5]) -> Vec<Row> {
    let mut rows = Vec::new();
    for method in methods {
        let id = |what: &str| format!("locator.{}.{what}", method.id);
        rows.push(Row::number(id("order"), Exact, method.order, "1"));
        for (index, what) in REPORTED_STEPS {
            if let Some((_, error)) = method.errors.get(index) {
                rows.push(Row::number(id(what), Exact, *error, "s"));
            }
        }
    }
    rows
}

fn draw(methods: &[LocatorMethod; 5]) -> Result<Figure, ProgramError> {
    let mut panel = Panel::new(
        Axis::decades("step *h*, s", (-3.05, 0.05)),
        Axis::decades("error of the event's time, s", (-14.8, 0.3)),
    )
    .legend(Legend::Below);
    for (method, (color, dash, shape)) in methods.iter().zip(LINE_STYLES) {
        let above = method
            .errors
            .iter()
            .filter(|(_, error)| *error > ROUNDING_FLOOR);
        let points = above.map(|&(h, e)| (math::log10(h), math::log10(e)));
        let name = format!("{}: slope {:.1}", method.name, method.order);
        let curve = Curve::new(points.clone()).color(color).dash(dash);
        panel.add(curve.legend(&name));
        panel.add(Markers::new(points).color(color).shape(shape).size(5.0));
    }
    let description = "Logarithmic axes. Five lines rise with the step: linear interpolation least \
        steeply and by far the highest, then the dense output of order 3, the Hénon step of order \
        4, the dense output of order 7 and, steepest and lowest, the Hénon step of order 8, which \
        reaches rounding at a step of about a tenth.";
    let figure = Figure::new(LOCATOR.name, (560.0, 480.0), LOCATOR.title, description);
    Ok(figure.row(1.0, panel))
}

const LINE_STYLES: [(Color, Dash, Shape); 5] = [
    (BLACK, Dash::Dotted, Shape::Diamond),
    (ORANGE, Dash::Dashed, Shape::Square),
    (VERMILLION, Dash::Solid, Shape::Circle),
    (GREEN, Dash::Dashed, Shape::Up),
    (BLUE, Dash::Solid, Shape::Down),
];

/// A step that crosses the event.
struct Step {
    model: BeltOscillator,
    from: Timed<2>,
    h: f64,
}

impl Step {
    fn field(&self, x: &State<2>) -> State<2> {
        // The block is slower than the belt.
        self.model.field(Side::Below, 0.0, x.as_ref()).into()
    }

    /// Intersection of the dense output of one step of `M` with Σ.
    fn on_dense<M: RungeKutta>(&self) -> f64 {
        let Timed { t, x } = self.from;
        let field = &mut |_: f64, x: &State<2>| self.field(x);
        let dense = Dense::over_step::<M>(field, (t, &x), self.h);
        t + self.h * bisect(0.0, 1.0, |s| dense.at(s)[1] >= BELT_SPEED)
    }

    /// Intersection of the chord of one step of RK4 with Σ. (A method of order 8 has the same
    /// error.)
    fn chord(&self) -> f64 {
        let Timed { t, x } = self.from;
        let field = &mut |_: f64, x: &State<2>| self.field(x);
        let end = step_end::<Rk4, _>(field, t, &x, self.field(&x), self.h);
        t + self.h * (BELT_SPEED - x[1]) / (end[1] - x[1])
    }

    /// One Hénon step from the step's start onto Σ.
    fn henon<M: RungeKutta>(&self) -> f64 {
        let mut slope = |at: &Timed<2>| {
            let f = self.field(&at.x);
            Timed {
                t: 1.0 / f[1],
                x: f / f[1],
            }
        };
        henon_step::<M, 2>(&mut slope, &self.from, BELT_SPEED - self.from.x[1]).t
    }
}

/// Error of the time at which the block reaches the belt's speed. It is located in one step of
/// length `h` from the exact state before it.
fn error(model: &BeltOscillator, h: f64, locate: fn(&Step) -> f64) -> f64 {
    // Below the belt's speed the block moves on a circle about μ₀. At angle t its velocity is minus
    // the radius times sin t. The belt's speed is half the radius: the event is at 7π/6, where the
    // velocity is curved. Times are relative to the event.
    let lead = EVENT_FRACTION * h;
    let angle = 7.0 * PI / 6.0 - lead;
    let radius = 2.0 * BELT_SPEED;
    let x = State::from([
        model.mu0 + radius * math::cos(angle),
        -radius * math::sin(angle),
    ]);
    locate(&Step {
        model: *model,
        from: Timed { t: -lead, x },
        h,
    })
    .abs()
}

/// Slope of the logarithms, by least squares.
fn order(errors: &[(f64, f64)]) -> f64 {
    let is_fitted =
        |(h, error): &(f64, f64)| *error > LEAST_FITTED_ERROR && *h < LONGEST_FITTED_STEP;
    PowerLaw::through(errors.iter().copied().filter(is_fitted)).exponent
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_method_has_the_order_of_its_construction() {
        let methods = LOCATOR.compute().unwrap();
        let orders: Vec<f64> = methods.iter().map(|method| method.order).collect();
        // Over one step, an interpolant of degree p and a step of order p both have errors of
        // h^(p+1). Order 8 reaches rounding early, so its measured order is lower.
        let wanted = [1.9..2.1, 3.8..4.4, 4.7..5.3, 7.3..8.3, 8.0..9.3];
        for (order, wanted) in orders.iter().zip(wanted) {
            assert!(wanted.contains(order), "{orders:?}");
        }
    }
}
