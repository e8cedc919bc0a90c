//! `s2.sigma` and `eq19.sigma`: the product of the two normal components on Σ, its derivative, and where friction holds the body.

use stickslip::scalar::Dual;

use super::{Evidence, Part, small};
use stickslip::filippov::{Fate, fate, normal_component};
use stickslip::models::{BeltOscillator, ForcedOscillator};
use stickslip::scalar::Scalar;
use stickslip::system::{Filippov, Side, State};

/// Differences within this are rounding, relative to the terms that are subtracted.
const ROUNDING: f64 = 1e-13;

/// The model whose σ is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Model 1, Eqs. (8), (9), (11).
    Belt,
    /// Model 2, Eqs. (19), (21).
    Forced,
}

/// σ by the library's own normal components against the printed polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigma {
    /// The model.
    pub model: Model,
    /// Points of Σ compared, over positions, friction and the other parameters.
    pub points: usize,
    /// Sets of parameters among them.
    pub parameters: usize,
    /// Largest difference of the product from the polynomial, relative to its two terms.
    pub largest_difference: f64,
    /// Largest difference of its derivative, by dual numbers, from the printed factors, relative to the terms.
    pub largest_slope_difference: f64,
    /// Points where the polynomial is negative.
    pub negative: usize,
    /// Points where the body sticks though it is not negative, or does not though it is.
    pub disagreements: usize,
}

/// Printed values at a point: σ, the size of its terms, its derivative, and the size of that one's terms.
struct Printed {
    sigma: f64,
    size: f64,
    slope: f64,
    slope_size: f64,
}

/// Positions (m) along Σ: none of them at a zero of any of the polynomials used here.
fn positions() -> impl Iterator<Item = f64> {
    (0..=300).map(|k| 0.01 * (f64::from(k) - 150.0) + 0.0013)
}

/// Friction amplitudes (N): half the critical one, the critical one and beyond, and none.
fn frictions(critical: f64) -> [f64; 5] {
    [
        0.0,
        0.2 * critical,
        0.5 * critical,
        critical,
        1.5 * critical,
    ]
}

impl Sigma {
    /// Model 1, at rest springs of 1 N/m and 1 N/m³ as in Eq. (9).
    pub fn of_belt() -> Sigma {
        let mut found = Sigma::new(Model::Belt);
        for mu0 in frictions(2.0 / (3.0 * 3f64.sqrt())) {
            let model = BeltOscillator {
                mu0,
                ..BeltOscillator::default()
            };
            found.parameters += 1;
            found.compare(&model, (0.0, model.belt_speed), 0.0, |z| belt(z, mu0));
        }
        found
    }

    /// Model 2, over masses, springs, friction and times of the forcing.
    pub fn of_forced() -> Sigma {
        let mut found = Sigma::new(Model::Forced);
        for (mass, k1, k2) in [
            (0.1_f64, 1.0_f64, 1.0_f64),
            (1.0, 1.0, 1.0),
            (0.4, 1.7, 0.6),
        ] {
            for mu0 in frictions(2.0 * k1 / 3.0 * (k1 / (3.0 * k2)).sqrt()) {
                let model = ForcedOscillator {
                    mass,
                    k1,
                    k2,
                    mu0,
                    ..ForcedOscillator::default()
                };
                found.parameters += 1;
                for part in [0.0, 0.17, 0.6] {
                    let t = part * model.period();
                    let on = (t, model.belt_speed);
                    found.compare(&model, on, model.support(t), |z| forced(&model, z));
                }
            }
        }
        found
    }

    fn new(model: Model) -> Sigma {
        Sigma {
            model,
            points: 0,
            parameters: 0,
            largest_difference: 0.0,
            largest_slope_difference: 0.0,
            negative: 0,
            disagreements: 0,
        }
    }

    fn compare<S: Filippov<2>>(
        &mut self,
        system: &S,
        (t, belt_speed): (f64, f64),
        offset: f64,
        printed: impl Fn(f64) -> Printed,
    ) {
        for z in positions() {
            let position = z + offset;
            let seeded = [Dual::new(position, 1.0), Dual::new(belt_speed, 0.0)];
            let found = product(system, Dual::new(t, 0.0), &seeded);
            // What the support adds is lost in the sum: the polynomial is taken where the body is.
            let expected = printed(position - offset);
            let off = (found.re - expected.sigma).abs() / expected.size.max(f64::MIN_POSITIVE);
            let slope_off =
                (found.eps - expected.slope).abs() / expected.slope_size.max(f64::MIN_POSITIVE);
            self.points += 1;
            self.largest_difference = self.largest_difference.max(off);
            self.largest_slope_difference = self.largest_slope_difference.max(slope_off);
            let attracts = fate(system, t, &State::from([position, belt_speed])) == Fate::Stick;
            let negative = expected.sigma < 0.0;
            self.negative += usize::from(negative);
            self.disagreements += usize::from(attracts != negative);
        }
    }
}

/// The product of the two fields' normal components.
fn product<S: Filippov<2>, T: Scalar>(system: &S, t: T, x: &[T; 2]) -> T {
    let of = |side| normal_component(system, t, x, &system.field(side, t, x));
    of(Side::Below) * of(Side::Above)
}

/// Eqs. (9) and (11).
fn belt(x1: f64, mu0: f64) -> Printed {
    let (square, factor) = (x1 * x1, x1 * x1 - 1.0);
    Printed {
        sigma: square * factor * factor - mu0 * mu0,
        size: square * (square + 1.0) * (square + 1.0) + mu0 * mu0,
        slope: 2.0 * x1 * factor * (3.0 * square - 1.0),
        slope_size: 2.0 * x1.abs() * (square + 1.0) * (3.0 * square + 1.0) + mu0,
    }
}

/// Eqs. (19) and (21).
fn forced(model: &ForcedOscillator, z: f64) -> Printed {
    let ForcedOscillator {
        mass, k1, k2, mu0, ..
    } = *model;
    let per_mass = 1.0 / (mass * mass);
    let force = k2 * z * z * z - k1 * z;
    let terms = k2 * z.abs() * z * z + k1 * z.abs();
    // A rounding of the time moves the support, and with it z.
    let moved = k1 + 3.0 * k2 * z * z;
    Printed {
        sigma: per_mass * (force * force - mu0 * mu0),
        size: per_mass * ((terms + moved) * (terms + moved) + mu0 * mu0),
        slope: 2.0 * z * per_mass * (3.0 * k2 * z * z - k1) * (k2 * z * z - k1),
        slope_size: 2.0 * per_mass * moved * (terms + moved),
    }
}

impl Evidence for Sigma {
    fn parts(&self) -> Vec<Part> {
        vec![
            Part {
                what: "the product of the two normal components on Σ is the printed polynomial",
                holds: self.points > 0 && self.largest_difference <= ROUNDING,
            },
            Part {
                what: "its derivative has the printed factors",
                holds: self.points > 0 && self.largest_slope_difference <= ROUNDING,
            },
            Part {
                what: "the body sticks exactly where it is negative",
                holds: self.negative > 0 && self.disagreements == 0,
            },
        ]
    }

    fn line(&self) -> String {
        let equations = match self.model {
            Model::Belt => "Eqs. (9), (11)",
            Model::Forced => "Eqs. (19), (21)",
        };
        format!(
            "{} points of Σ, {} sets of parameters: product and derivative of the library's own fields off {equations} by at most {} and {} of their \
             terms; stick and sign of σ disagree at {} points, {} of them have σ < 0",
            self.points,
            self.parameters,
            small(self.largest_difference),
            small(self.largest_slope_difference),
            self.disagreements,
            self.negative,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn both_models_have_the_printed_product() {
        for found in [Sigma::of_belt(), Sigma::of_forced()] {
            assert_eq!(found.support(), Support::Whole, "{found:?}");
            assert!(found.points > 1000);
        }
    }

    #[test]
    fn friction_that_drives_holds_nothing() {
        // The product cannot tell, where the body goes can.
        let mu0 = 0.2;
        let driving = BeltOscillator {
            mu0: -mu0,
            ..BeltOscillator::default()
        };
        let mut found = Sigma::new(Model::Belt);
        found.compare(&driving, (0.0, driving.belt_speed), 0.0, |z| belt(z, mu0));
        assert!(found.largest_difference <= ROUNDING);
        assert_eq!(found.disagreements, found.negative);
    }

    #[test]
    fn another_polynomial_is_not_the_product() {
        let model = ForcedOscillator::default();
        let other = ForcedOscillator { k2: 1.001, ..model };
        let mut found = Sigma::new(Model::Forced);
        found.compare(&model, (0.3, model.belt_speed), model.support(0.3), |z| {
            forced(&other, z)
        });
        assert!(found.largest_difference > 1e-5 && found.largest_slope_difference > 1e-5);
    }
}
