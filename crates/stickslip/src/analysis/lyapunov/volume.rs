//! Growth of volumes by Liouville's formula.

use crate::dynamics::{Dynamics, Moment, Step, Vector};

/// Nodes in `[0, 1]` and weights of the Gauss–Legendre rule of five points: exact to degree 9.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_45),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Integral of the divergence over a step with its solution: the logarithm of the factor by which
/// the step changes volumes.
pub(super) fn growth(system: &dyn Dynamics, step: &Step, solution: &dyn Fn(f64) -> Vector) -> f64 {
    let length = step.t_end - step.t_start;
    // Within the rounding of a time, the solution has no places.
    if length == 0.0 {
        return 0.0;
    }
    let flow = system.flow(step.mode, &step.end());
    let mean: f64 = GAUSS
        .iter()
        .map(|&(node, weight)| {
            let t = step.t_start + node * length;
            weight * flow.divergence(&Moment { t, x: solution(t) })
        })
        .sum();
    mean * length
}
