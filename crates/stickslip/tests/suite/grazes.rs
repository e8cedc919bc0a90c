//! A hundred thousand random grazes of each kind with known counts: none is missed, and none is
//! spurious.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use numerics::SplitMix;
use stickslip::{
    Filippov, Method, Observer, Options, Scalar, Side, State, Transition, TransitionKind, math,
};

use crate::any_system::run;
use crate::compiled::Compiled;

const CASES: u32 = 100_000;

/// `x₁ = r e^{gt} cos(wt + a)` has its maxima where `tan(wt + a) = g/w`. One of them, at the time
/// `top`, exceeds a ceiling by `gap`, or stays below it if `gap` is negative. Growth makes every
/// later maximum higher, decay every earlier one.
#[derive(Debug)]
struct Spiral {
    growth: f64,
    frequency: f64,
    top: f64,
    size: f64,
    gap: f64,
}

impl Spiral {
    /// Draws a spiral that exceeds the ceiling or stays below it.
    fn draw(draw: &mut SplitMix, pokes: bool) -> Self {
        let growth = draw.between(-0.2, 0.2);
        let frequency = draw.between(0.5, 3.0);
        let top = draw.between(0.2, 4.0);
        let size = math::exp(draw.between(-2.0, 2.0));
        let gap = size * math::pow(10.0, draw.between(-11.0, -1.5));
        Spiral {
            growth,
            frequency,
            top,
            size,
            gap: if pokes { gap } else { -gap },
        }
    }

    fn phase(&self) -> f64 {
        math::atan2(self.growth, self.frequency)
    }

    fn level(&self) -> f64 {
        self.size * math::cos(self.phase()) - self.gap
    }

    fn at(&self, t: f64) -> State<2> {
        let angle = self.frequency * (t - self.top) + self.phase();
        let radius = self.size * math::exp(self.growth * (t - self.top));
        State::from([radius * math::cos(angle), -radius * math::sin(angle)])
    }

    /// Times from half a turn before the maximum to half a turn after it, so that it is the only
    /// one.
    fn span(&self) -> (f64, f64) {
        let half = 0.999 * PI / self.frequency;
        (self.top - half, self.top + half)
    }

    fn slope<T: Scalar>(&self, x: [T; 2]) -> [T; 2] {
        let (g, w) = (self.growth, self.frequency);
        [x[0] * g + x[1] * w, x[1] * g - x[0] * w]
    }
}

/// A spiral under a fixed ceiling: field and boundary are linear.
pub struct AtRest(Spiral);

impl Filippov<2> for AtRest {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        self.0.slope([x[0], x[1]])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0] - self.0.level()
    }
}

/// Spiral and ceiling both oscillate by `a sin bt`, and the boundary is curved: `e^{c (x₁ − level −
/// a sin bt)} = 1`. It has the same zeros, and an infinite series.
pub struct Shaken {
    spiral: Spiral,
    amplitude: f64,
    rate: f64,
    bend: f64,
}

impl Shaken {
    fn draw(draw: &mut SplitMix, pokes: bool) -> Self {
        let spiral = Spiral::draw(draw, pokes);
        Shaken {
            amplitude: spiral.size * draw.between(0.1, 1.0),
            rate: draw.between(0.3, 5.0),
            bend: draw.between(-2.0, 2.0) / spiral.size,
            spiral,
        }
    }
}

impl Filippov<2> for Shaken {
    fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let shift = (t * self.rate).sin() * self.amplitude;
        let slope = self.spiral.slope([x[0] - shift, x[1]]);
        let drift = (t * self.rate).cos() * (self.amplitude * self.rate);
        [slope[0] + drift, slope[1]]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        let shift = (t * self.rate).sin() * self.amplitude;
        ((x[0] - shift - self.spiral.level()) * self.bend).exp() - 1.0
    }
}

/// Records crossings.
#[derive(Default)]
struct Crossings(Vec<f64>);

impl Observer<2> for Crossings {
    fn transition(&mut self, at: &Transition<2>) -> ControlFlow<()> {
        assert_ne!(at.kind, TransitionKind::Touch, "{at:?}");
        self.0.push(at.t);
        ControlFlow::Continue(())
    }
    // So that a Runge–Kutta step is judged by its stages alone where possible.
    fn watches_steps(&self) -> bool {
        false
    }
}

/// Around a spiral's maximum a system has two crossings, one on each side of it, or none.
fn assert_counted<S: Compiled<2>>(system: &S, spiral: &Spiral, start: State<2>, options: &Options) {
    let (from, to) = spiral.span();
    let mut found = Crossings::default();
    run(system, from, start, to, options, &mut found).expect("runs");
    match found.0[..] {
        [] => assert!(spiral.gap < 0.0, "missed: {spiral:?}"),
        [first, second] => assert!(
            spiral.gap > 0.0 && first < spiral.top && spiral.top < second,
            "{first} {second}: {spiral:?}"
        ),
        ref others => panic!("{others:?}: {spiral:?}"),
    }
}

fn at_rest(options: &Options) {
    let mut draw = SplitMix::new(2013);
    for case in 0..CASES {
        let system = AtRest(Spiral::draw(&mut draw, case % 2 == 0));
        let start = system.0.at(system.0.span().0);
        assert_counted(&system, &system.0, start, options);
    }
}

fn shaken(options: &Options) {
    let mut draw = SplitMix::new(1973);
    for case in 0..CASES {
        let system = Shaken::draw(&mut draw, case % 2 == 0);
        let from = system.spiral.span().0;
        let mut start = system.spiral.at(from);
        start[0] += system.amplitude * math::sin(system.rate * from);
        assert_counted(&system, &system.spiral, start, options);
    }
}

fn taylor() -> Options {
    Options::tol(1e-13).method(Method::Taylor)
}

fn by_runge_kutta() -> Options {
    Options::tol(1e-13)
}

#[test]
fn no_graze_at_rest_is_missed_by_taylor() {
    at_rest(&taylor());
}

#[test]
fn no_graze_at_rest_is_missed_by_runge_kutta() {
    at_rest(&by_runge_kutta());
}

#[test]
fn no_graze_of_a_moving_bent_boundary_is_missed_by_taylor() {
    shaken(&taylor());
}

#[test]
fn no_graze_of_a_moving_bent_boundary_is_missed_by_runge_kutta() {
    shaken(&by_runge_kutta());
}
