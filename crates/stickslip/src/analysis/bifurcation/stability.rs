//! Where an equilibrium loses its stability, or its mode no longer holds.

use super::{Family, Reached, WhatChanges};
use crate::analysis::attractors::rest::{ZERO, along_boundaries, equilibrium_near, least_guard};
use crate::analysis::multipliers::eigenvalues;
use crate::dynamics::{Moment, Vector};

/// How far behind a value of the sweep its change is looked for where that value hits it, as a part
/// of the way between two.
const BEHIND: f64 = 1.0 / 64.0;

/// So much of that way behind the value it was hit; further on it is another pair's.
pub(super) const NEXT_TO: f64 = 1e-6;

/// A guard of less than this part of what it was at the value before is rounding.
const ROUNDING: f64 = 1e-12;

/// What decides on an equilibrium at one value of the parameter.
struct Leading {
    /// The largest real part among the eigenvalues, and the size of the imaginary part there.
    rate: f64,
    frequency: f64,
    /// Rates that cannot be told from zero.
    noise: f64,
    /// The smallest guard of its mode.
    guard: f64,
}

/// Where the equilibrium loses its stability on the way to another value, or comes to the edge of
/// where its mode holds.
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

/// The zero of a function, of which what is below its noise cannot be told from zero, on the way
/// from one value of the parameter to another.
fn zero_on(
    (from, to): (f64, f64),
    mut function: impl FnMut(f64) -> Option<(f64, f64)>,
) -> Option<f64> {
    let (mut a, mut b) = (from, to);
    let ((mut at_a, _), (mut at_b, noise)) = (function(a)?, function(b)?);
    // At a change that a value of the sweep hits rounding tells the sign.
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
