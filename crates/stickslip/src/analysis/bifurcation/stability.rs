//! Where an equilibrium loses its stability.

use super::{Reached, WhatChanges};
use crate::analysis::attractors::rest::{ZERO, equilibrium_near};
use crate::analysis::multipliers;
use crate::filippov::Switched;
use crate::ode::Timed;
use crate::system::State;

/// How far behind a value of the sweep its change is looked for where that value hits it, as a part of the way between two.
const BEHIND: f64 = 1.0 / 64.0;

/// So much of that way behind the value it was hit; further on it is another pair's.
const NEXT_TO: f64 = 1e-6;

/// What decides on an equilibrium at one value of the parameter.
struct Leading<const N: usize> {
    x: State<N>,
    /// The largest real part among the eigenvalues, and the size of the imaginary part there.
    rate: f64,
    frequency: f64,
    /// Rates that cannot be told from zero.
    noise: f64,
}

/// Where the equilibrium loses its stability on the way to another value.
pub(super) fn loss_of_stability<S: Switched<N, G>, const N: usize, const G: usize>(
    family: &impl Fn(f64) -> S,
    from: (f64, &Reached<N, S::Mode>),
    to: f64,
) -> Option<WhatChanges<N, S::Mode>> {
    let mode = from.1.mode;
    let mut x = from.1.points.first()?.x;
    // Of stick the zeros across the boundary do not count.
    let mut leading = |parameter: f64| {
        let system = family(parameter);
        let rest = equilibrium_near(&system, mode, 0.0, &x, N)?;
        x = rest.x;
        let across = system.normals(mode, &Timed { t: 0.0, x }).len();
        let mut values = multipliers(&rest.jacobian);
        values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        let of_field = values.iter().skip(across);
        let first = of_field.max_by(|a, b| a.re.total_cmp(&b.re))?;
        Some(Leading {
            x,
            rate: first.re,
            frequency: first.im.abs(),
            noise: ZERO * rest.jacobian.amax(),
        })
    };
    let (mut a, mut b) = (from.0, to);
    let (mut at_a, there) = (leading(a)?.rate, leading(b)?);
    let mut at_b = there.rate;
    // At a change that a value of the sweep hits rounding tells the sign.
    if at_b.abs() <= there.noise {
        b += BEHIND * (b - a);
        at_b = leading(b)?.rate;
    }
    if at_a * at_b >= 0.0 {
        return None;
    }
    // Regula falsi, with the Illinois rule.
    let mut last = a;
    for _ in 0..100 {
        let next = b - at_b * (b - a) / (at_b - at_a);
        let value = leading(next)?.rate;
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
    if (last - to) / (to - from.0) > NEXT_TO {
        return None;
    }
    let Leading { x, frequency, .. } = leading(last)?;
    Some(WhatChanges::Equilibrium {
        parameter: last,
        x,
        frequency,
    })
}
