//! Where a branch of periodic orbits shrinks to an equilibrium.

use nalgebra::DMatrix;

use super::corrector::OnBranch;
use super::critical::zero_between;
use crate::analysis::attractors::rest::equilibrium_near;
use crate::analysis::multipliers::eigenvalues;
use crate::filippov::Switched;

/// The parameter near to the orbit's at which the equilibrium inside it has imaginary eigenvalues, and their size.
pub(super) fn hopf<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    orbit: &OnBranch<N, S::Mode>,
    width: f64,
) -> Option<(f64, f64)> {
    let mode = orbit.circuit.parts.last()?.mode;
    let mut x = orbit.circuit.anchor.x;
    let free = N - 1;
    let mut frequency = 0.0;
    let mut leading = |parameter: f64| {
        x[free] = parameter;
        let rest = equilibrium_near(system, mode, 0.0, &x, free)?;
        x = rest.x;
        let jacobian = DMatrix::from_fn(free, free, |i, j| rest.jacobian[(i, j)]);
        let values = eigenvalues(&jacobian);
        let pair = values.iter().filter(|value| value.im > 0.0);
        let first = pair.min_by(|a, b| a.re.abs().total_cmp(&b.re.abs()))?;
        frequency = first.im;
        Some(first.re)
    };
    let here = orbit.circuit.anchor.x[free];
    let at_here = leading(here)?;
    // The nearest change of sign on either side.
    let mut way = 1e-4 * width;
    for _ in 0..12 {
        for there in [here - way, here + way] {
            let at_there = leading(there)?;
            if at_here * at_there <= 0.0 {
                let parameter = zero_between((here, at_here), (there, at_there), &mut leading)?;
                leading(parameter)?;
                return Some((parameter, frequency));
            }
        }
        way *= 2.0;
    }
    None
}
