//! The product of the two normal components on Σ, its derivative, and the region where friction
//! holds the body.

use super::zone_attraction::critical;
use crate::figures::normals;
use crate::numbers::ROUNDING;
use crate::paper::models::{BeltOscillator, ForcedOscillator};
use crate::paper::reading::Reading::Exact;
use crate::report::digits::small;
use crate::report::finding::{Finding, statement};
use stickslip::scalar::Dual;
use stickslip::{Fate, Filippov, State, fate};

/// `s2.sigma`: model 1, with springs of 1 N/m and 1 N/m³ as in Eq. (9).
pub(super) fn of_belt() -> Vec<Finding> {
    belts().findings("Eqs. (9), (11)")
}

fn belts() -> SigmaComparison {
    let mut compared = SigmaComparison::default();
    for mu0 in frictions(2.0 / (3.0 * 3f64.sqrt())) {
        let model = BeltOscillator {
            mu0,
            ..BeltOscillator::default()
        };
        compared.parameters += 1;
        compared.compare(&model, (0.0, model.belt_speed), 0.0, |z| belt(z, mu0));
    }
    compared
}

/// `eq19.sigma`: model 2, over masses, springs, friction and times of the forcing.
pub(super) fn of_forced() -> Vec<Finding> {
    forced_ones().findings("Eqs. (19), (21)")
}

fn forced_ones() -> SigmaComparison {
    let mut compared = SigmaComparison::default();
    for (mass, k1, k2) in [(0.1, 1.0_f64, 1.0), (1.0, 1.0, 1.0), (0.4, 1.7, 0.6)] {
        let model = ForcedOscillator {
            mass,
            k1,
            k2,
            ..ForcedOscillator::default()
        };
        for mu0 in frictions(critical(&model)) {
            let model = ForcedOscillator { mu0, ..model };
            compared.parameters += 1;
            for part in [0.0, 0.17, 0.6] {
                let t = part * model.period();
                let on = (t, model.belt_speed);
                compared.compare(&model, on, model.support(t), |z| forced(&model, z));
            }
        }
    }
    compared
}

/// σ from the library's own normal components, compared with the printed polynomial.
#[derive(Default)]
struct SigmaComparison {
    /// Number of points on Σ, over positions, friction and the other parameters, and number of sets
    /// of parameters.
    points: usize,
    parameters: usize,
    /// Largest difference of the product from the polynomial, relative to the terms that are
    /// subtracted.
    off: f64,
    /// Largest difference of its derivative, by dual numbers, from the printed factors, relative to
    /// the terms.
    slope_off: f64,
    /// Points where the polynomial is negative.
    negative: usize,
    /// Points where the body sticks although the polynomial is not negative, or slips although it
    /// is.
    disagreements: usize,
}

/// Printed values at a point: σ, the size of its terms, its derivative, and the size of the
/// derivative's terms.
struct PrintedSigma {
    sigma: f64,
    size: f64,
    slope: f64,
    slope_size: f64,
}

/// Friction amplitudes (N): zero, fractions of the critical one, the critical one, and a larger
/// one.
fn frictions(critical: f64) -> [f64; 5] {
    [0.0, 0.2, 0.5, 1.0, 1.5].map(|part| part * critical)
}

impl SigmaComparison {
    fn compare<S: Filippov<2>>(
        &mut self,
        system: &S,
        (t, belt_speed): (f64, f64),
        offset: f64,
        printed: impl Fn(f64) -> PrintedSigma,
    ) {
        // No position (m) along Σ is at a zero of any polynomial used here.
        for z in (0..=300).map(|k| 0.01 * (f64::from(k) - 150.0) + 0.0013) {
            let position = z + offset;
            let seeded = [Dual::new(position, 1.0), Dual::new(belt_speed, 0.0)];
            let [below, above] = normals(system, Dual::new(t, 0.0), &seeded);
            let product = below * above;
            // The sum rounds the displacement of the support, so the polynomial is evaluated at the
            // rounded position.
            let expected = printed(position - offset);
            let relative = |off: f64, size: f64| off.abs() / size.max(f64::MIN_POSITIVE);
            let off = relative(product.re - expected.sigma, expected.size);
            let slope_off = relative(product.eps - expected.slope, expected.slope_size);
            self.points += 1;
            (self.off, self.slope_off) = (self.off.max(off), self.slope_off.max(slope_off));
            let attracts = fate(system, t, &State::from([position, belt_speed])) == Fate::Stick;
            let negative = expected.sigma < 0.0;
            self.negative += usize::from(negative);
            self.disagreements += usize::from(attracts != negative);
        }
    }

    fn findings(&self, equations: &str) -> Vec<Finding> {
        let (points, parameters) = (self.points, self.parameters);
        let (negative, disagreements) = (self.negative, self.disagreements);
        let is_rounding = |off: f64| points > 0 && off <= ROUNDING;
        let sticks = negative > 0 && disagreements == 0;
        let what = "the product of the two normal components on Σ is the printed polynomial";
        let factors = "its derivative has the printed factors";
        let parts = [
            (what, is_rounding(self.off)),
            (factors, is_rounding(self.slope_off)),
            ("the body sticks exactly where it is negative", sticks),
        ];
        let [off, slope_off] = [self.off, self.slope_off].map(small);
        let line = format!(
            "{points} points of Σ, {parameters} sets of parameters: product and derivative of the \
             library's own fields off {equations} by at most {off} and {slope_off} of their terms; \
             stick and sign of σ disagree at {disagreements} points, {negative} of them have σ < 0"
        );
        vec![statement(Exact, parts, line)]
    }
}

/// Eqs. (9) and (11).
fn belt(x1: f64, mu0: f64) -> PrintedSigma {
    let (square, factor) = (x1 * x1, x1 * x1 - 1.0);
    PrintedSigma {
        sigma: square * factor * factor - mu0 * mu0,
        size: square * (square + 1.0) * (square + 1.0) + mu0 * mu0,
        slope: 2.0 * x1 * factor * (3.0 * square - 1.0),
        slope_size: 2.0 * x1.abs() * (square + 1.0) * (3.0 * square + 1.0) + mu0,
    }
}

/// Eqs. (19) and (21).
fn forced(model: &ForcedOscillator, z: f64) -> PrintedSigma {
    let (k1, k2, mu0) = (model.k1, model.k2, model.mu0);
    let per_mass = 1.0 / (model.mass * model.mass);
    let force = k2 * z * z * z - k1 * z;
    let terms = k2 * z.abs() * z * z + k1 * z.abs();
    // A rounding error of the time moves the support, and z with it.
    let moved = k1 + 3.0 * k2 * z * z;
    PrintedSigma {
        sigma: per_mass * (force * force - mu0 * mu0),
        size: per_mass * ((terms + moved) * (terms + moved) + mu0 * mu0),
        slope: 2.0 * z * per_mass * (3.0 * k2 * z * z - k1) * (k2 * z * z - k1),
        slope_size: 2.0 * per_mass * moved * (terms + moved),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_models_have_the_printed_product() {
        for compared in [belts(), forced_ones()] {
            assert!(compared.points > 1000);
            let found = compared.findings("");
            assert_eq!(found[0].parts(), [true; 3], "{found:?}");
        }
    }

    #[test]
    fn friction_that_drives_holds_nothing() {
        // The product does not show it; the direction of the motion does.
        let mu0 = 0.2;
        let driving = BeltOscillator {
            mu0: -mu0,
            ..BeltOscillator::default()
        };
        let mut found = SigmaComparison::default();
        found.compare(&driving, (0.0, driving.belt_speed), 0.0, |z| belt(z, mu0));
        assert!(found.points > 300 && found.off <= ROUNDING);
        assert_eq!(found.disagreements, found.negative);
    }

    #[test]
    fn another_polynomial_is_not_the_product() {
        let model = ForcedOscillator::default();
        let other = ForcedOscillator { k2: 1.001, ..model };
        let mut found = SigmaComparison::default();
        found.compare(&model, (0.3, model.belt_speed), model.support(0.3), |z| {
            forced(&other, z)
        });
        assert!(found.off > 1e-5 && found.slope_off > 1e-5);
    }
}
