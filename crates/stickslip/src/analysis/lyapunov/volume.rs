//! Growth of volumes by Liouville's formula.

use crate::dual::Dual;

use crate::filippov::{Step, Switched, Velocity};
use crate::system::State;

/// Nodes in `[0, 1]` and weights of Gauss and Legendre's rule of five points: exact to degree 9.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_45),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Divergence of the field that rules in `mode`.
fn divergence(
    system: &dyn Dynamics,
    mode: Modes,
    t: f64,
    x: &Vector,
) -> f64 {
    let frozen = Dual::new(t, 0.0);
    (0..N)
        .map(|i| {
            let seed = |j: usize| f64::from(u8::from(i == j));
            let seeded = std::array::from_fn(|j| Dual::new(x[j], seed(j)));
            let here = Velocity(frozen, &seeded);
            system.with_flow(mode, S::Branch::default(), here)[i].eps
        })
        .sum()
}

/// Integral of the divergence over a step: the logarithm of the factor by which it changes volumes.
pub(super) fn growth(
    system: &dyn Dynamics,
    step: &dyn DynamicstepRecord,
) -> f64 {
    let length = step.t_end - step.t_start;
    let mean: f64 = GAUSS
        .iter()
        .map(|&(node, weight)| {
            let t = step.t_start + node * length;
            weight * divergence(system, step.mode, t, &step.dense.at_time(t))
        })
        .sum();
    mean * length
}
