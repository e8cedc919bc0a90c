//! Where an equilibrium loses its stability, or its mode ceases to hold.

use super::{Family, Reached, WhatChanges};
use crate::analysis::attractors::rest::{ZERO, along_boundaries, equilibrium_near, least_guard};
use crate::analysis::multipliers::eigenvalues;
use crate::dynamics::{Moment, Vector};

/// Distance behind a value of the sweep within which its change is sought if that value lies
/// exactly on it, as a fraction of the interval.
const BEHIND: f64 = 1.0 / 64.0;

/// The change counts as hit within this fraction of the interval behind the value; farther on it
/// belongs to another pair.
pub(super) const NEXT_TO: f64 = 1e-6;

/// A guard below this fraction of its previous value is rounding.
const ROUNDING: f64 = 1e-12;

/// The quantities that decide at one value of the parameter.
struct Leading {
    /// The largest real part of the eigenvalues, and the absolute imaginary part there.
    rate: f64,
    frequency: f64,
    /// Largest rate that cannot be distinguished from zero.
    noise: f64,
    /// The smallest guard of its mode.
    guard: f64,
}

/// Where the equilibrium loses its stability on the way to another value, or reaches the edge of
/// its mode's domain.
pub(super) fn loss_of_stability(
    family: &Family<'_>,
    from: (f64, &Reached),
    to: f64,
) -> Option<WhatChanges> {
    let mode = from.1.mode;
    let begin = &from.1.points.first()?.x;
    let leading = |parameter: f64, x: &mut Vector| {
        let system = family(parameter);
        let rest = equilibrium_near(&*system, mode, 0.0, x, x.len())?;
        x.clone_from(&rest.x);
        let at = Moment { t: 0.0, x: rest.x };
        let along = along_boundaries(&*system, mode, &at, &rest.jacobian, x.len());
        let values = eigenvalues(&along).into_iter();
        let first = values.max_by(|a, b| a.re.total_cmp(&b.re))?;
        Some(Leading {
            rate: first.re,
            frequency: first.im.abs(),
            noise: ZERO * rest.jacobian.amax(),
            guard: least_guard(&*system, mode, &at),
        })
    };
    let way = (from.0, to);
    let mut x = begin.clone();
    let guard = ROUNDING * leading(from.0, &mut x)?.guard.abs();
    let edge = zero_on(way, |parameter| {
        Some((leading(parameter, &mut x)?.guard, guard))
    });
    let mut crosses = begin.clone();
    let rate = zero_on(way, |parameter| {
        let Leading { rate, noise, .. } = leading(parameter, &mut crosses)?;
        Some((rate, noise))
    });
    let nearer = |one: f64, other: Option<f64>| {
        other.is_none_or(|other| (one - from.0).abs() <= (other - from.0).abs())
    };
    if let Some(parameter) = edge.filter(|&edge| nearer(edge, rate)) {
        leading(parameter, &mut x)?;
        return Some(WhatChanges::BoundaryEquilibrium { parameter, x });
    }
    let parameter = rate?;
    let Leading { frequency, .. } = leading(parameter, &mut crosses)?;
    Some(WhatChanges::Equilibrium {
        parameter,
        x: crosses,
        frequency,
    })
}

/// The zero of a function between two values of the parameter. Values below its noise cannot be
/// distinguished from zero.
fn zero_on(
    (from, to): (f64, f64),
    mut function: impl FnMut(f64) -> Option<(f64, f64)>,
) -> Option<f64> {
    let (mut a, mut b) = (from, to);
    let ((mut at_a, _), (mut at_b, noise)) = (function(a)?, function(b)?);
    // At a change that a value of the sweep hits exactly, rounding decides the sign.
    if at_b.abs() <= noise {
        b += BEHIND * (b - a);
        at_b = function(b)?.0;
    }
    if at_a * at_b >= 0.0 {
        return None;
    }
    // Regula falsi, with the Illinois rule.
    let mut last = a;
    for _ in 0..100 {
        let next = b - at_b * (b - a) / (at_b - at_a);
        let value = function(next)?.0;
        let has_settled = (next - last).abs() <= 2.0 * f64::EPSILON * next.abs();
        last = next;
        if value == 0.0 || has_settled {
            break;
        }
        if value * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        (b, at_b) = (next, value);
    }
    ((last - to) / (to - from) <= NEXT_TO).then_some(last)
}
