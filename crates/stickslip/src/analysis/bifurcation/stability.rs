//! Where an equilibrium loses its stability.

use super::{Reached, WhatChanges};
use crate::analysis::attractors::rest::equilibrium_near;
use crate::analysis::multipliers;
use crate::filippov::Switched;
use crate::ode::Timed;

/// Where the equilibrium loses its stability on the way to another value.
pub(super) fn loss_of_stability<S: Switched<N, G>, const N: usize, const G: usize>(
    family: &impl Fn(f64) -> S,
    from: (f64, &Reached<N, S::Mode>),
    to: f64,
) -> Option<WhatChanges<N, S::Mode>> {
    let mode = from.1.mode;
    let mut x = from.1.points.first()?.x;
    // The largest real part among the eigenvalues, and the imaginary part there; of stick the zeros across the boundary do not count.
    let mut leading = |parameter: f64| {
        let system = family(parameter);
        let rest = equilibrium_near(&system, mode, 0.0, &x, N)?;
        x = rest.x;
        let across = system.normals(mode, &Timed { t: 0.0, x }).len();
        let mut values = multipliers(&rest.jacobian);
        values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        let of_field = values.iter().skip(across);
        let first = of_field.max_by(|a, b| a.re.total_cmp(&b.re))?;
        Some((first.re, first.im.abs(), rest.x))
    };
    let (mut a, mut b) = (from.0, to);
    let (mut at_a, mut at_b) = (leading(a)?.0, leading(b)?.0);
    if at_a * at_b >= 0.0 {
        return None;
    }
    // Regula falsi, with the Illinois rule.
    let mut last = a;
    for _ in 0..100 {
        let next = b - at_b * (b - a) / (at_b - at_a);
        let value = leading(next)?.0;
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
    let (_, frequency, x) = leading(last)?;
    Some(WhatChanges::Equilibrium {
        parameter: last,
        x,
        frequency,
    })
}
