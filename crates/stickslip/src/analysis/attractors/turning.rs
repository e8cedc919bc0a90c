//! A section for orbits that never meet a boundary: where the first state turns back.

use crate::filippov::{Direction, EventFunctions, Switched, Velocity};
use crate::scalar::Scalar;
use crate::system::State;

/// The largest values of the first state: where its rate falls through zero. Unlike a plane laid across an orbit they are the same points
/// of an attractor whatever start has led there.
pub(super) struct Turning<'a, S, const G: usize> {
    system: &'a dyn Dynamics,
}

impl<'a, S, const G: usize> Turning<'a, S, G> {
    pub fn of(system: &'a dyn Dynamics) -> Self {
        Turning { system }
    }
}

impl EventFunctions<N, 1> for Turning<'_, S, G> {
    #[inline(always)]
    fn values<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; 1] {
        let state = State::from(x.map(Scalar::value));
        let mode = self.system.mode_by_side(t.value(), &state);
        let velocity = self
            .system
            .with_flow(mode, S::Branch::default(), Velocity(t, x));
        [velocity[0]]
    }

    fn direction(&self, _number: usize) -> Direction {
        Direction::Falling
    }
}
