//! Where a branch of periodic orbits ends at an equilibrium: shrinks to one, or passes ever nearer to a saddle.

use nalgebra::DMatrix;

use super::Stop;
use super::corrector::OnBranch;
use super::critical::zero_between;
use super::walk::Walk;
use crate::analysis::attractors::rest::{ZERO, equilibrium_near};
use crate::analysis::multipliers::eigenvalues;
use crate::filippov::{Integration, Progress, Switched, Velocity};
use crate::system::{State, components};

/// An orbit passes a saddle where, at its least speed, it would go this part of its extent in a period.
const SLOW: f64 = 1e-2;

/// The saddle is no farther away than this part of the orbit's extent.
const CLOSE: f64 = 1e-2;

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

impl<S: Switched<N, G>, const N: usize, const G: usize> Walk<'_, S, N, G> {
    /// Whether the last orbit is about to be a homoclinic one: slower than the one before it, and close to a saddle.
    pub(super) fn homoclinic(&self) -> Option<Stop> {
        let circuit = &self.last.circuit;
        if self.settings.forced.is_some() || circuit.period <= self.before.circuit.period {
            return None;
        }
        let (mode, x) = self.slowest(SLOW * circuit.extent / circuit.period)?;
        let free = N - 1;
        let rest = equilibrium_near(self.corrector.system, mode, 0.0, &x, free)?;
        if (rest.x - x).norm() > CLOSE * circuit.extent {
            return None;
        }
        let jacobian = DMatrix::from_fn(free, free, |i, j| rest.jacobian[(i, j)]);
        let values = eigenvalues(&jacobian);
        let zero = ZERO * jacobian.amax();
        let nearest = |sign: f64| {
            let rates = values.iter().map(|value| sign * value.re);
            rates.filter(|&rate| rate > zero).min_by(f64::total_cmp)
        };
        Some(Stop::Homoclinic {
            parameter: circuit.anchor.x[free],
            leaves: nearest(1.0)?,
            comes: -nearest(-1.0)?,
        })
    }

    /// Where the last orbit is slowest, at the ends of steps, if it is slower than this there.
    fn slowest(&self, than: f64) -> Option<(S::Mode, State<N>)> {
        let circuit = &self.last.circuit;
        let (system, options) = (self.corrector.system, self.corrector.options);
        let start = circuit.anchor;
        let t_end = start.t + circuit.period;
        let mut integration = Integration::new(system, start.t, start.x, t_end, options).ok()?;
        let (mut least, mut place) = (than, None);
        loop {
            match integration.step().ok()? {
                Progress::Step => {
                    let (mode, x) = (integration.mode(), *integration.x());
                    let here = Velocity(integration.t(), components(&x));
                    let velocity = system.with_flow(mode, S::Branch::default(), here);
                    let speed = State::from(velocity).norm();
                    if speed < least {
                        (least, place) = (speed, Some((mode, x)));
                    }
                }
                Progress::Transition(_) | Progress::PhaseEnd(_) => {}
                Progress::End(_) => return place,
            }
        }
    }
}
