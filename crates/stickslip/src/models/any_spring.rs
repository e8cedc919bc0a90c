//! Tangent points and stick zones for springs `k2 z³ − k1 z` of any signs.

use super::cubic::{Balance, Cubic, TangentPoint};
use super::parameters::{finite, not_negative};
use crate::error::Error;
use crate::math;

/// The zeros of `σ`, largest first, for any finite k1 and k2.
///
/// With both positive the force is not monotone, and [`Cubic`] has its up to six points. With both
/// negative it is the same spring reversed. Otherwise the force is monotone and equals each of ±μ0
/// once, or never if there is no spring.
pub(super) fn tangent_points(k1: f64, k2: f64, mu0: f64) -> Result<Vec<TangentPoint>, Error> {
    let (k1, k2) = (finite("k1", k1)?, finite("k2", k2)?);
    let mu0 = not_negative("mu0", mu0)?;
    if k1 > 0.0 && k2 > 0.0 {
        return Cubic::new(k1, k2)?.tangent_points(mu0);
    }
    if k1 < 0.0 && k2 < 0.0 {
        let mut points = Cubic::new(-k1, -k2)?.tangent_points(mu0)?;
        for point in &mut points {
            point.balance = reversed(point.balance);
        }
        return Ok(points);
    }
    if mu0 == 0.0 && k1 == 0.0 && k2 == 0.0 {
        // No force and no friction: all of Σ is tangent.
        let (name, value, bound) = ("mu0", mu0, "positive where there is no spring");
        return Err(Error::Parameter { name, value, bound });
    }
    let Some(reach) = monotone_root(k1.abs(), k2.abs(), mu0) else {
        return Ok(Vec::new());
    };
    let point = |z, balance, multiplicity| TangentPoint {
        z,
        balance,
        multiplicity,
    };
    if mu0 == 0.0 {
        return Ok(vec![point(0.0, Balance::Both, 2)]);
    }
    // The force rises with z where k2 is not negative and k1 is not positive.
    let rises = k1 <= 0.0 && k2 >= 0.0;
    let (upper, lower) = if rises {
        (Balance::Plus, Balance::Minus)
    } else {
        (Balance::Minus, Balance::Plus)
    };
    Ok(vec![point(reach, upper, 1), point(-reach, lower, 1)])
}

/// The stick zones (lower end, upper end), largest first.
pub(super) fn stick_zones(k1: f64, k2: f64, mu0: f64) -> Result<Vec<(f64, f64)>, Error> {
    let points = tangent_points(k1, k2, mu0)?;
    if points.is_empty() {
        // No spring but friction: the body sticks at every position.
        return Ok(vec![(f64::NEG_INFINITY, f64::INFINITY)]);
    }
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

fn reversed(balance: Balance) -> Balance {
    match balance {
        Balance::Plus => Balance::Minus,
        Balance::Minus => Balance::Plus,
        Balance::Both => Balance::Both,
    }
}

/// The root of `a z³ + b z = mu0` with `a, b ≥ 0`; `None` if both are zero. The trigonometric form
/// has no real angle here, so it is computed by the hyperbolic sine, then refined by Newton's
/// iteration.
fn monotone_root(b: f64, a: f64, mu0: f64) -> Option<f64> {
    let mut z = match (a > 0.0, b > 0.0) {
        (false, false) => return None,
        (false, true) => return Some(mu0 / b),
        (true, false) => return Some(math::cbrt(mu0 / a)),
        (true, true) => {
            let scale = (b / (3.0 * a)).sqrt();
            2.0 * scale * math::sinh(math::asinh(1.5 * mu0 / (b * scale)) / 3.0)
        }
    };
    for _ in 0..3 {
        z -= (z * (a * z * z + b) - mu0) / (3.0 * a * z * z + b);
    }
    Some(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monotone_springs_meet_each_friction_limit_once() {
        for (k1, k2) in [
            (-2.0, 3.0),
            (2.0, -3.0),
            (0.0, 2.0),
            (0.0, -2.0),
            (-1.5, 0.0),
            (1.5, 0.0),
        ] {
            for mu0 in [1e-6, 0.3, 40.0] {
                let points = tangent_points(k1, k2, mu0).unwrap();
                assert_eq!(points.len(), 2);
                assert!(points[0].z > 0.0 && points[1].z == -points[0].z);
                for point in &points {
                    let force = point.z * (k2 * point.z * point.z - k1);
                    let wanted = if point.balance == Balance::Plus {
                        mu0
                    } else {
                        -mu0
                    };
                    assert!((force - wanted).abs() <= 4e-15 * mu0, "{k1} {k2} {mu0}");
                }
                let zones = stick_zones(k1, k2, mu0).unwrap();
                assert_eq!(zones, [(points[1].z, points[0].z)]);
            }
        }
    }

    #[test]
    fn a_reversed_spring_has_the_same_points_with_the_limits_exchanged() {
        let (plain, turned) = (
            tangent_points(1.0, 1.0, 0.2).unwrap(),
            tangent_points(-1.0, -1.0, 0.2).unwrap(),
        );
        assert_eq!(plain.len(), 6);
        for (one, other) in plain.iter().zip(&turned) {
            assert_eq!(one.z, other.z);
            assert_eq!(one.balance, reversed(other.balance));
        }
    }

    #[test]
    fn without_a_spring_the_body_sticks_everywhere_or_nothing_holds_it() {
        assert!(tangent_points(0.0, 0.0, 0.2).unwrap().is_empty());
        let everywhere = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(stick_zones(0.0, 0.0, 0.2).unwrap(), [everywhere]);
        assert!(tangent_points(0.0, 0.0, 0.0).is_err());
        assert!(tangent_points(f64::NAN, 1.0, 0.2).is_err());
        assert!(stick_zones(-1.0, 1.0, 0.0).unwrap().is_empty());
    }
}
