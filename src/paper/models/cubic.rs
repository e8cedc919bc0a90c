//! Tangent points, where sticking begins and ends: roots of `k₂z³ - k₁z = ±μ₀`.
//!
//! A body on the belt sticks while the spring force does not exceed static friction. Both
//! one-degree-of-freedom models of the paper have the spring `±(k₂z³ - k₁z)`. The sign cancels in
//! the transition function `σ`, so this module serves both (Eq. (9) and (19)).

use super::parameters::{not_negative, positive};
use stickslip::{Error, math};

/// The spring `k₂z³ - k₁z` with `k₁, k₂ > 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    k1: f64,
    k2: f64,
}

/// Sign of the friction force that balances the spring at a tangent point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Balance {
    /// `k₂z³ - k₁z = +μ₀`.
    Plus,
    /// `k₂z³ - k₁z = -μ₀`.
    Minus,
    /// Both, because `μ₀ = 0`.
    Both,
}

/// A zero of `σ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentPoint {
    /// Position (relative to the forced end of the spring in model 2), m.
    pub z: f64,
    /// Equation that it solves.
    pub balance: Balance,
    /// Multiplicity of the zero of `σ`: 2 where it touches the axis without crossing it, else 1.
    pub multiplicity: u8,
}

impl Cubic {
    /// Spring constants `k1`, N/m, and `k2`, N/m³.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless both are finite and greater than 0.
    pub fn new(k1: f64, k2: f64) -> Result<Self, Error> {
        Ok(Self {
            k1: positive("k1", k1)?,
            k2: positive("k2", k2)?,
        })
    }

    /// `k₂z³ - k₁z`, N.
    pub fn force(&self, z: f64) -> f64 {
        z * (self.k2 * z * z - self.k1)
    }

    /// Derivative `3k₂z² - k₁`, N/m.
    pub fn stiffness(&self, z: f64) -> f64 {
        3.0 * self.k2 * z * z - self.k1
    }

    /// The transition function `σ = ((k₂z³ - k₁z)² - μ₀²)/m²`, Eq. (19); with `k₁ = k₂ = m = 1`
    /// also Eq. (9). The body sticks where it is negative. Unit: m²/s⁴ for `m` in kg.
    pub fn sigma(&self, z: f64, mu0: f64, m: f64) -> f64 {
        let force = self.force(z);
        // (a - b)(a + b) keeps the digits that a² - b² loses near a zero.
        (force - mu0) * (force + mu0) / (m * m)
    }

    /// `∂σ/∂z = 2(k₂z³ - k₁z)(3k₂z² - k₁)/m²`, Eq. (11) and (21).
    pub fn sigma_slope(&self, z: f64, m: f64) -> f64 {
        2.0 * self.force(z) * self.stiffness(z) / (m * m)
    }

    /// The positive `μ₀` at which `σ` touches the axis: `(2k₁/3)√(k₁/(3k₂))`, Eq. (13) and (23).
    pub fn critical_mu0(&self) -> f64 {
        2.0 * self.k1 / 3.0 * (self.k1 / (3.0 * self.k2)).sqrt()
    }

    /// All zeros of `σ`, from the largest to the smallest: the paper's numbering 1, 2, … of tangent
    /// points.
    ///
    /// There are six below the critical `μ₀`, two above it, and three double ones at `μ₀ = 0`. At
    /// the critical value there are two simple ones and between them two double ones. `μ₀` within
    /// four units in the last place of the critical value counts as critical. Rounding alone can
    /// put it there, and would separate the double zeros by `1e-8`.
    ///
    /// # Errors
    /// [`Error::Parameter`] if `mu0` is negative or not finite.
    pub fn tangent_points(&self, mu0: f64) -> Result<Vec<TangentPoint>, Error> {
        let mu0 = not_negative("mu0", mu0)?;
        if mu0 == 0.0 {
            let far = (self.k1 / self.k2).sqrt();
            return Ok([far, 0.0, -far].map(|z| double(z, Balance::Both)).into());
        }
        // With z = aw and a = 2√(k1/3k2) the equation is 4w³ - 3w = ±r, and 4cos³θ - 3cos θ = cos
        // 3θ.
        let a = 2.0 * (self.k1 / (3.0 * self.k2)).sqrt();
        let r = mu0 / self.critical_mu0();
        // Roots for +μ₀. Those for -μ₀ are their mirror images.
        let plus: Vec<TangentPoint> = if (r - 1.0).abs() <= 4.0 * f64::EPSILON {
            vec![
                self.simple(a, mu0),
                double(-(self.k1 / (3.0 * self.k2)).sqrt(), Balance::Plus),
            ]
        } else if r < 1.0 {
            let theta = math::acos(r) / 3.0;
            let third = 2.0 * std::f64::consts::FRAC_PI_3;
            [theta, theta - third, theta + third]
                .map(|angle| self.simple(a * math::cos(angle), mu0))
                .into()
        } else {
            vec![self.simple(a * math::cosh(math::acosh(r) / 3.0), mu0)]
        };
        let mut points = plus.clone();
        points.extend(plus.iter().map(|point| TangentPoint {
            z: -point.z,
            balance: Balance::Minus,
            multiplicity: point.multiplicity,
        }));
        points.sort_by(|one, other| other.z.total_cmp(&one.z));
        Ok(points)
    }

    /// The intervals `(lower, upper)` in which the body can stick, where `σ < 0`, from the largest
    /// `z` to the smallest. There are three below the critical `μ₀`, one from there on, and none at
    /// `μ₀ = 0`.
    ///
    /// # Errors
    /// As [`Cubic::tangent_points`].
    pub fn stick_zones(&self, mu0: f64) -> Result<Vec<(f64, f64)>, Error> {
        let points = self.tangent_points(mu0)?;
        let simple: Vec<f64> = points
            .iter()
            .filter(|point| point.multiplicity == 1)
            .map(|point| point.z)
            .collect();
        Ok(simple
            .chunks_exact(2)
            .map(|pair| (pair[1], pair[0]))
            .collect())
    }

    /// A simple root of `k₂z³ - k₁z = μ₀` near `z`. Newton steps remove the errors of the
    /// elementary functions.
    fn simple(&self, z: f64, mu0: f64) -> TangentPoint {
        let mut best = z;
        for _ in 0..3 {
            let next = best - (self.force(best) - mu0) / self.stiffness(best);
            let better = (self.force(next) - mu0).abs() < (self.force(best) - mu0).abs();
            if !better {
                break;
            }
            best = next;
        }
        TangentPoint {
            z: best,
            balance: Balance::Plus,
            multiplicity: 1,
        }
    }
}

fn double(z: f64, balance: Balance) -> TangentPoint {
    TangentPoint {
        z,
        balance,
        multiplicity: 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn unit() -> Cubic {
        Cubic::new(1.0, 1.0).unwrap()
    }

    fn assert_near(found: f64, exact: f64) {
        assert!((found - exact).abs() <= 1e-15, "{found} {exact}");
    }

    fn positions(points: &[TangentPoint]) -> Vec<f64> {
        points.iter().map(|point| point.z).collect()
    }

    #[test]
    fn the_six_points_of_equation_16() {
        let points = unit().tangent_points(1.0 / (3.0 * 3f64.sqrt())).unwrap();
        let c = PI / 9.0;
        let expected = [
            math::cos(c),
            math::cos(2.0 * c),
            math::sin(0.5 * c),
            -math::sin(0.5 * c),
            -math::cos(2.0 * c),
            -math::cos(c),
        ];
        assert_eq!(points.len(), 6);
        for (point, w) in points.iter().zip(expected) {
            assert_near(point.z, 2.0 / 3f64.sqrt() * w);
        }
        use Balance::{Minus, Plus};
        let balance: Vec<Balance> = points.iter().map(|point| point.balance).collect();
        assert_eq!(balance, [Plus, Minus, Minus, Plus, Plus, Minus]);
    }

    #[test]
    fn without_friction_three_double_points_and_no_zone() {
        let points = unit().tangent_points(0.0).unwrap();
        assert_eq!(positions(&points), [1.0, 0.0, -1.0]);
        assert!(
            points
                .iter()
                .all(|p| p.multiplicity == 2 && p.balance == Balance::Both)
        );
        assert!(unit().stick_zones(0.0).unwrap().is_empty());
    }

    #[test]
    fn at_the_critical_value_one_zone_between_the_outer_points() {
        // Three expressions for the number that differ in the last place.
        for mu0 in [
            2.0 * 3f64.sqrt() / 9.0,
            2.0 / (3.0 * 3f64.sqrt()),
            unit().critical_mu0(),
        ] {
            let points = unit().tangent_points(mu0).unwrap();
            let expected = [
                2.0 / 3f64.sqrt(),
                1.0 / 3f64.sqrt(),
                -1.0 / 3f64.sqrt(),
                -2.0 / 3f64.sqrt(),
            ];
            assert_eq!(points.len(), 4);
            for (point, z) in points.iter().zip(expected) {
                assert_near(point.z, z);
            }
            let multiplicity: Vec<u8> = points.iter().map(|p| p.multiplicity).collect();
            assert_eq!(multiplicity, [1, 2, 2, 1]);
            let zones = unit().stick_zones(mu0).unwrap();
            assert_eq!(zones, [(points[3].z, points[0].z)]);
        }
    }

    #[test]
    fn above_the_critical_value_two_points_remain() {
        // z³ - z = 6 at z = 2.
        let points = unit().tangent_points(6.0).unwrap();
        assert_eq!(positions(&points), [2.0, -2.0]);
    }

    #[test]
    fn the_critical_friction() {
        assert_near(unit().critical_mu0(), 0.384_900_179_459_750_5);
    }

    #[test]
    fn sigma_is_negative_inside_the_zones_only() {
        let mu0 = 3f64.sqrt() / 9.0;
        for (low, high) in unit().stick_zones(mu0).unwrap() {
            assert!(unit().sigma(0.5 * (low + high), mu0, 0.1) < 0.0);
            assert!(unit().sigma(low - 1e-6, mu0, 0.1) > 0.0);
            assert!(unit().sigma(high + 1e-6, mu0, 0.1) > 0.0);
        }
        // The force at 2 is 6: (6² - 1²)/0.5².
        assert_eq!(unit().sigma(2.0, 1.0, 0.5), 140.0);
    }

    #[test]
    fn bad_parameters_are_named() {
        let says = |error: Error, text: &str| assert_eq!(error.to_string(), text);
        says(
            Cubic::new(0.0, 1.0).unwrap_err(),
            "parameter k1 = 0 is not allowed: it must be positive and finite",
        );
        says(
            Cubic::new(1.0, f64::INFINITY).unwrap_err(),
            "parameter k2 = inf is not allowed: it must be positive and finite",
        );
        says(
            unit().tangent_points(-1.0).unwrap_err(),
            "parameter mu0 = -1 is not allowed: it must be finite and at least 0",
        );
    }

    proptest! {
        #[test]
        fn residuals_are_rounding_errors(k1 in 0.01..100.0, k2 in 0.01..100.0, r in 1e-6..50.0) {
            let spring = Cubic::new(k1, k2).unwrap();
            let mu0 = r * spring.critical_mu0();
            for point in spring.tangent_points(mu0).unwrap() {
                let target = if point.balance == Balance::Plus { mu0 } else { -mu0 };
                // Half a unit in the last place of z changes the force by this, plus the rounding
                // of the force.
                let size = (k2 * math::powi(point.z, 3)).abs() + (k1 * point.z).abs() + mu0;
                prop_assert!((spring.force(point.z) - target).abs() <= 4.0 * f64::EPSILON * size);
            }
        }

        #[test]
        fn sigma_is_stationary_at_the_critical_points(k1 in 0.01..100.0, k2 in 0.01..100.0) {
            let spring = Cubic::new(k1, k2).unwrap();
            let span = (k1 / k2).sqrt();
            let size = k1 * k1 * span;
            // Eqs. (12) and (22).
            let near = (k1 / (3.0 * k2)).sqrt();
            for z in [0.0, span, -span, near, -near] {
                prop_assert!(spring.sigma_slope(z, 1.0).abs() <= 1e-14 * size);
                // The formula for the slope against a difference of sigma.
                let step = 1e-5 * span;
                let difference =
                    spring.sigma(z + step, 0.0, 1.0) - spring.sigma(z - step, 0.0, 1.0);
                let quotient = difference / (2.0 * step);
                prop_assert!(quotient.abs() <= 1e-8 * size);
            }
        }

        #[test]
        fn the_count_follows_the_regime(k1 in 0.01..100.0, k2 in 0.01..100.0, r in 1e-6..3.0) {
            prop_assume!(f64::abs(r - 1.0) > 1e-12);
            let spring = Cubic::new(k1, k2).unwrap();
            let points = spring.tangent_points(r * spring.critical_mu0()).unwrap();
            prop_assert_eq!(points.len(), if r < 1.0 { 6 } else { 2 });
            prop_assert!(points.windows(2).all(|pair| pair[0].z > pair[1].z));
            let mirrored: Vec<f64> = points.iter().rev().map(|point| -point.z).collect();
            prop_assert_eq!(positions(&points), mirrored);
        }
    }
}
