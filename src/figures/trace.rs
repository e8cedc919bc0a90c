//! Curves through orbits.

use stickslip::orbit::Orbit;

/// Points per integration step: an order-8 step is long, and a curve through its ends alone would be polygonal.
/// What cannot be seen is thinned out when the curve is drawn.
const PER_STEP: u32 = 24;

/// Points along the orbit, each point made by `point` from time and state; every step's end is on it, and so is every
/// transition.
fn points<const N: usize, P>(orbit: &Orbit<N>, point: impl Fn(f64, &[f64]) -> P) -> Vec<P> {
    let mut points = vec![point(orbit.t_start, orbit.x_start.as_slice())];
    for step in &orbit.steps {
        for k in 1..PER_STEP {
            let t = step.t_start + f64::from(k) / f64::from(PER_STEP) * (step.t_end - step.t_start);
            points.push(point(t, step.dense.at_time(t).as_slice()));
        }
        points.push(point(step.t_end, step.x_end.as_slice()));
    }
    points
}

/// Time and the first two components.
pub(super) fn curve3<const N: usize>(orbit: &Orbit<N>) -> Vec<(f64, f64, f64)> {
    points(orbit, |t, x| (t, x[0], x[1]))
}

/// The orbit in the plane of its first two components.
pub(super) fn phase_plane<const N: usize>(orbit: &Orbit<N>) -> Vec<(f64, f64)> {
    points(orbit, |_, x| (x[0], x[1]))
}
