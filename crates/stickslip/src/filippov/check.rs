//! Checks whether a run can begin.

use super::flow::boundary_gradient;
use super::options::Options;
use crate::error::{Error, Point};
use crate::ode::Timed;
use crate::system::{Filippov, Side, components};

/// Checks options, parameters, times and start.
pub(super) fn check<S: Filippov<N>, const N: usize>(
    system: &S,
    start: &Timed<N>,
    t_end: f64,
    options: &Options,
) -> Result<(), Error> {
    options.check()?;
    system.check_parameters()?;
    let Timed { t, x } = *start;
    let outside = |what: &'static str| Error::StartOutsideDomain {
        t,
        x: Point::from(&x),
        what,
    };
    check_run(start, t_end)?;
    let h = system.boundary(t, components(&x));
    if !h.is_finite() {
        return Err(outside("the boundary function is not finite there"));
    }
    if h == 0.0 {
        let (gradient, in_time) = boundary_gradient(system, t, &x);
        if gradient.iter().all(|&slope| slope == 0.0) && in_time == 0.0 {
            return Err(outside(
                "the boundary function is zero there and has no slope, so it marks no boundary",
            ));
        }
    }
    // On Σ both fields matter; off it only one has to exist.
    for side in [Side::Below, Side::Above] {
        let matters = h * side.sign() >= 0.0;
        if matters
            && system
                .field(side, t, components(&x))
                .iter()
                .any(|v| !v.is_finite())
        {
            return Err(outside("the field is not finite there"));
        }
        let holding = system.holding(side, t, components(&x));
        if h == 0.0 && holding.iter().any(|v| !v.is_finite()) {
            return Err(outside("the field that holds is not finite there"));
        }
    }
    Ok(())
}

/// Checks what does not depend on the system: the times, and that the start is finite.
pub(super) fn check_run<const N: usize>(start: &Timed<N>, t_end: f64) -> Result<(), Error> {
    let Timed { t, x } = *start;
    if !(t.is_finite() && t_end.is_finite() && t < t_end) {
        return Err(Error::Interval { t0: t, t_end });
    }
    if x.iter().any(|v| !v.is_finite()) {
        return Err(Error::StartOutsideDomain {
            t,
            x: Point::from(&x),
            what: "the start itself is not finite",
        });
    }
    Ok(())
}
