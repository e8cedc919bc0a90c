//! Friction at one contact depends on the side of another: the sliding field is the multi-affine
//! combination of all corners.

use stickslip::error::ContactFault;
use stickslip::{Contacts, Method, Mode, Options, Scalar, Several, Side, solve};

/// `x' = 1 - λ₁ (2 + λ₂/2)`, `y' = y₀ - λ₂ (2 + λ₁/2)` about x = 0 and y = 0, and `z' = λ₁ λ₂`,
/// which depends on both weights.
struct Coupled<const SAYS_SO: bool> {
    drift: f64,
}

impl<const SAYS_SO: bool> Contacts<3, 2> for Coupled<SAYS_SO> {
    const MULTI_AFFINE: bool = SAYS_SO;

    fn field<T: Scalar>(&self, sides: &[Side; 2], _t: T, _x: &[T; 3]) -> [T; 3] {
        let [a, b] = sides.map(Side::sign);
        [
            T::constant(1.0 - a * (2.0 + 0.5 * b)),
            T::constant(self.drift - b * (2.0 + 0.5 * a)),
            T::constant(a * b),
        ]
    }
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 3]) -> [T; 2] {
        [x[0], x[1]]
    }
}

/// λ₁, λ₂ with `1 = λ₁ (2 + λ₂/2)` and `drift = λ₂ (2 + λ₁/2)`. The second gives λ₂; the first is
/// then quadratic in λ₁.
fn shares(drift: f64) -> [f64; 2] {
    // λ₂ = drift/(2 + λ₁/2). λ₁ (2 (2 + λ₁/2) + drift/2) = 2 + λ₁/2, that is, λ₁² + (3.5 + drift/2)
    // λ₁ - 2 = 0.
    let p = 3.5 + 0.5 * drift;
    let first = 0.5 * (-p + (p * p + 8.0).sqrt());
    [first, drift / (2.0 + 0.5 * first)]
}

#[test]
fn two_contacts_that_hold_each_other_slide_by_the_multi_affine_combination() {
    let drift = 0.7;
    for options in [
        Options::tol(1e-12),
        Options::tol(1e-14).method(Method::Taylor),
    ] {
        let system = Several(Coupled::<true> { drift });
        let orbit = solve(&system, 0.0, [-0.4, 0.3, 0.0], 5.0, &options).unwrap();
        assert_eq!(orbit.phases.last().unwrap().mode, [Mode::Stick; 2]);
        let last = orbit.phases.last().unwrap();
        let [a, b] = shares(drift);
        let rate = last.displacement()[2] / last.duration();
        assert!((rate - a * b).abs() < 1e-12, "{rate} {}", a * b);
        assert!(last.x_end[0].abs() < 1e-15 && last.x_end[1].abs() < 1e-15);
    }
}

#[test]
fn friction_that_does_not_add_is_noticed_where_the_system_does_not_say_so() {
    let system = Several(Coupled::<false> { drift: 0.7 });
    let failure = solve(&system, 0.0, [-0.4, 0.3, 0.0], 5.0, &Options::default()).unwrap_err();
    assert!(
        crate::fault(&failure.error) == &ContactFault::NotAdditive { pair: (0, 1) },
        "{failure}"
    );
    assert!(failure.to_string().contains("MULTI_AFFINE"), "{failure}");
    // The run continues until both hold.
    assert!(failure.partial.t_end > 0.1);
}
