//! Boundary-equilibrium bifurcations: an equilibrium comes to the edge of where its mode holds (di Bernardo, Budd, Champneys & Kowalczyk 2008, Ch. 5).

use super::attractors::rest::{equilibrium_near, least_guard};
use super::critical::zero_between;
use crate::filippov::Switched;
use crate::ode::Timed;
use crate::system::State;

/// An orbit of less than this part of a wider one's extent may be about to shrink to an equilibrium.
pub(super) const SMALL: f64 = 1e-2;

/// Such an orbit is no further from the equilibrium than so many times its own extent.
const NEAR: f64 = 10.0;

/// Of two extents that differ by less than this part of them nothing is extrapolated.
const APART: f64 = 1e-3;

/// The equilibrium of a mode, and the smallest guard of that mode there: positive where it holds.
pub(super) struct Held<const N: usize> {
    pub x: State<N>,
    pub guard: f64,
}

impl<const N: usize> Held<N> {
    /// Of the equilibrium near a state, of which the first `free` components are states.
    pub fn near<S: Switched<N, G>, const G: usize>(
        system: &S,
        mode: S::Mode,
        x: &State<N>,
        free: usize,
    ) -> Option<Self> {
        let x = equilibrium_near(system, mode, 0.0, x, free)?.x;
        let guard = least_guard(system, mode, Timed { t: 0.0, x });
        Some(Held { x, guard })
    }
}

/// A periodic orbit that shrinks as a parameter goes on.
pub(super) struct Shrinking<const N: usize> {
    /// A state on it, and by how much it moves.
    pub x: State<N>,
    pub extent: f64,
    /// The parameter, and that at which it would be a point.
    pub here: f64,
    pub end: f64,
}

impl<const N: usize> Shrinking<N> {
    /// That orbit, of which another one was wider at another parameter; `None` if it does not shrink.
    pub fn from(here: (f64, f64), before: (f64, f64), x: State<N>) -> Option<Self> {
        let [(here, extent), (there, wider)] = [here, before];
        let way = (here - there) * extent / (wider - extent);
        let shrinks = extent * (1.0 + APART) < wider && here != there;
        shrinks.then_some(Shrinking {
            x,
            extent,
            here,
            end: here + way,
        })
    }

    /// The parameter, and the equilibrium of a mode that passes the edge of that mode's region there, next to where the orbit would be a point. `held`
    /// has the equilibrium of that mode near a state at a parameter; the first `free` components are states.
    pub fn ends_in(
        &self,
        free: usize,
        mut held: impl FnMut(f64, &State<N>) -> Option<Held<N>>,
    ) -> Option<(f64, State<N>)> {
        let mut x = self.x;
        let mut guard = |parameter: f64| {
            let found = held(parameter, &x)?;
            x = found.x;
            Some(found.guard)
        };
        let further = self.end + (self.end - self.here);
        let [one, other] = [guard(self.here)?, guard(further)?];
        if one * other > 0.0 {
            return None;
        }
        let parameter = zero_between((self.here, one), (further, other), &mut guard)?;
        guard(parameter)?;
        let off = (x - self.x).rows(0, free).amax();
        (off <= NEAR * self.extent).then_some((parameter, x))
    }
}
