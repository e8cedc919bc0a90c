//! Fields that are a root of the distance from their boundary, against closed forms.

use stickslip::analysis::{OrbitDerivatives, Variable};
use stickslip::{
    AtPileUp, Contacts, Error, Filippov, Method, Options, Scalar, Several, Side, TransitionKind,
    math, solve,
};

const METHODS: [Method; 2] = [Method::Taylor, Method::Dop853];

/// Falls to zero at the rate `-s(a + k |x|^p) - b`, where `s` is the side.
struct Root {
    a: f64,
    k: f64,
    p: f64,
    b: f64,
}

impl Filippov<1> for Root {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 1]) -> [T; 1] {
        [(x[0].abs().powf(self.p) * self.k + self.a) * -side.sign() - self.b]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0]
    }
}

fn options(method: Method) -> Options {
    Options::tol(1e-12).method(method)
}

#[test]
fn a_root_of_the_distance_is_crossed() {
    // x' = -√x - 1 takes 2 (1 - ln 2) from 1 to 0; then x' = √-x - 1.
    let system = Root {
        a: 0.0,
        k: 1.0,
        p: 0.5,
        b: 1.0,
    };
    let crossing = 2.0 * (1.0 - math::ln(2.0));
    for method in METHODS {
        let orbit = solve(&system, 0.0, [1.0], 3.0, &options(method)).unwrap();
        let events = &orbit.transitions;
        assert_eq!(events.len(), 1, "{method:?}: {events:?}");
        assert_eq!(events[0].kind, TransitionKind::Crossing);
        assert!(
            (events[0].t - crossing).abs() < 1e-11,
            "{method:?}: {}",
            events[0].t
        );
        // With w = √-x, w' = (1 - w)/(2 w): t = -2 (w + ln(1 - w)) after the crossing.
        let w = (-orbit.x_end[0]).sqrt();
        let exact = crossing - 2.0 * (w + math::ln(1.0 - w));
        assert!((exact - 3.0).abs() < 1e-10, "{method:?}: {exact}");
    }
}

#[test]
fn other_powers_of_the_distance_are_crossed() {
    // With x = u³, 3 u² u' = -u - 1 on the way to zero.
    let system = Root {
        a: 0.0,
        k: 1.0,
        p: 1.0 / 3.0,
        b: 1.0,
    };
    let crossing = 3.0 * (math::ln(2.0) - 0.5);
    for method in METHODS {
        let orbit = solve(&system, 0.0, [1.0], 3.0, &options(method)).unwrap();
        assert_eq!(orbit.transitions.len(), 1, "{method:?}");
        let t = orbit.transitions[0].t;
        assert!((t - crossing).abs() < 1e-11, "{method:?}: {t}");
        // With x = -u³, 3 u² u' = 1 - u: t = 3 (-u²/2 - u - ln(1 - u)).
        let u = math::pow(-orbit.x_end[0], 1.0 / 3.0);
        let exact = crossing - 3.0 * (0.5 * u * u + u + math::ln(1.0 - u));
        assert!((exact - 3.0).abs() < 1e-9, "{method:?}: {exact}");
    }
}

#[test]
fn what_slides_at_a_root_slides() {
    // x' = -(1/2 + √x) takes 2 - ln 3 from 1 to 0, where both sides push.
    let system = Root {
        a: 0.5,
        k: 1.0,
        p: 0.5,
        b: 0.25,
    };
    let c: f64 = 0.75;
    let entry = 2.0 * (1.0 - c * math::ln(1.0 + 1.0 / c));
    for method in METHODS {
        let orbit = solve(&system, 0.0, [1.0], 5.0, &options(method)).unwrap();
        assert_eq!(orbit.transitions.len(), 1, "{method:?}");
        let at = &orbit.transitions[0];
        assert_eq!(at.kind, TransitionKind::StickEntry);
        assert!(
            (at.t - entry).abs() < 1e-11,
            "{method:?}: {} for {entry}",
            at.t
        );
        assert_eq!(orbit.x_end[0], 0.0);
    }
}

/// A mass under a force `t`, with friction `1 + k √|v|`. The distance is an absolute value, or
/// the velocity times the side, whose root has a value on one side alone.
struct Pushed {
    k: f64,
    by_side: bool,
}

impl Filippov<2> for Pushed {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let distance = match self.by_side {
            true => x[1] * side.sign(),
            false => x[1].abs(),
        };
        let friction = (distance.sqrt() * self.k + 1.0) * side.sign();
        [x[1], t - friction]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}

#[test]
fn stick_ends_at_a_root_law_as_the_square_of_the_time() {
    // After t = 1 the speed is b τ², with 2 b + k √b = 1, for ever.
    for (k, by_side) in [(0.3, false), (2.0, false), (0.3, true), (2.0, true)] {
        let root = (-k + (k * k + 8.0_f64).sqrt()) / 4.0;
        let b = root * root;
        let system = Pushed { k, by_side };
        for method in METHODS {
            let orbit = solve(&system, 0.0, [0.0, 0.0], 3.0, &options(method)).unwrap();
            assert_eq!(orbit.transitions.len(), 1, "{method:?}, {k}, {by_side}");
            let at = &orbit.transitions[0];
            assert_eq!(at.kind, TransitionKind::StickExit);
            assert!((at.t - 1.0).abs() < 1e-11, "{method:?}, {k}: {}", at.t);
            let [x, v] = [orbit.x_end[0], orbit.x_end[1]];
            assert!((v - 4.0 * b).abs() < 1e-10, "{method:?}, {k}: {v}");
            assert!((x - 8.0 / 3.0 * b).abs() < 1e-10, "{method:?}, {k}: {x}");
        }
    }
}

/// Levant's super-twisting control.
struct SuperTwisting;

impl Filippov<2> for SuperTwisting {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let s = side.sign();
        [x[1] - x[0].abs().sqrt() * (1.5 * s), T::constant(-1.1 * s)]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0]
    }
}

#[test]
fn super_twisting_comes_to_rest() {
    for method in METHODS {
        let options = options(method).at_pile_up(AtPileUp::Rest);
        let orbit = solve(&SuperTwisting, 0.0, [1.0, 0.0], 3.0, &options).unwrap();
        let times: Vec<f64> = orbit.transitions.iter().map(|at| at.t).collect();
        for (found, exact) in times.iter().zip([0.732_705_460_065_167, 1.581_628_143_43]) {
            assert!((found - exact).abs() < 1e-10, "{method:?}: {found}");
        }
        // Distances fall as the square of the time left: below the tolerance it is 1e-6.
        let rest = times[times.len() - 1];
        assert!(
            (rest - 1.741_662_725_127_465).abs() < 1e-8,
            "{method:?}: {rest}"
        );
        assert_eq!([orbit.x_end[0], orbit.x_end[1]], [0.0, 0.0]);
    }
}

/// A mass between two contacts, the second with a root law.
struct TwoContacts;

impl Contacts<2, 2> for TwoContacts {
    fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, x: &[T; 2]) -> [T; 2] {
        let root = x[1].abs().sqrt() * sides[1].sign();
        [
            T::constant(-0.1 * sides[0].sign()) + t.sin(),
            t.cos() - root - 0.1 * sides[1].sign(),
        ]
    }
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 2]) -> [T; 2] {
        [x[0], x[1]]
    }
}

/// A boundary that moves.
struct Moving;

impl Filippov<2> for Moving {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let slip = self.boundary(t, x);
        [x[1], -(slip.abs().sqrt() + 0.5) * side.sign()]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        x[1] - t.cos() * 0.3
    }
}

/// A tank of level `h` with an inflow of one and an outflow of `√h`.
struct Tank;

impl Filippov<1> for Tank {
    fn field<T: Scalar>(&self, _: Side, _t: T, x: &[T; 1]) -> [T; 1] {
        [-x[0].sqrt() + 1.0]
    }
    fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 1]) -> T {
        T::one()
    }
}

/// With `u = √h`, `t = -2 (u + ln(1 - u))` from an empty tank.
#[test]
fn a_start_where_the_field_has_no_series_is_left() {
    for method in METHODS {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let options = Options::tol(tolerance).method(method);
            let orbit = solve(&Tank, 0.0, [0.0], 3.0, &options).unwrap();
            let u = orbit.x_end[0].sqrt();
            let off = -2.0 * (u + math::ln(1.0 - u)) - 3.0;
            assert!(off.abs() < 100.0 * tolerance, "{method:?}: {off:e}");
        }
        // The start has no derivative of the flow: never a number.
        let (by, times) = ([Variable::Start(0)], [1.0]);
        let found = OrbitDerivatives::of(
            &Tank,
            0.0,
            [0.0],
            3.0,
            (&by, &times),
            &[],
            &Options::default().method(method),
        )
        .unwrap();
        assert!(found.states[0][(0, 0)].is_nan());
        let lost = found.lost.as_ref();
        assert!(matches!(lost, Some(Error::TangentSingular { t, .. }) if *t == 0.0));
    }
}

#[test]
fn a_root_law_that_is_not_followed_is_refused() {
    for method in METHODS {
        let options = options(method);
        let failed = solve(&Several(TwoContacts), 0.0, [5.0, 1.0], 9.0, &options).unwrap_err();
        let Error::RootAtBoundary { ref x, .. } = failed.error else {
            panic!("{method:?}: {}", failed.error);
        };
        assert!(x.0[1].abs() < 1e-9, "{x}");
        let failed = solve(&Moving, 0.0, [0.0, 1.0], 9.0, &options).unwrap_err();
        assert!(
            matches!(failed.error, Error::RootAtBoundary { .. }),
            "{method:?}: {}",
            failed.error
        );
    }
}
