//! Where shooting begins on an orbit.

use crate::error::Error;
use crate::filippov::{Integration, Options, Settled, Switched, Velocity};
use crate::ode::Timed;
use crate::system::{Mode, State, components};

/// A state of an orbit, and the mode that it is in there. On Σ the state alone does not tell it: rounding moves it to one side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor<const N: usize, K> {
    pub t: f64,
    pub x: State<N>,
    pub mode: K,
}

impl<const N: usize, K: Copy> Anchor<N, K> {
    /// In the mode that a run from there begins in.
    ///
    /// # Errors
    /// Those of [`Integration::new`].
    pub fn at_start<S: Switched<N, G, Mode = K>, const G: usize>(
        system: &S,
        at: &Timed<N>,
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let mode = Integration::new(system, at.t, at.x, t_end, options)?.mode();
        Ok(Anchor::of(at, mode))
    }

    pub fn of(at: &Timed<N>, mode: K) -> Self {
        let Timed { t, x } = *at;
        Anchor { t, x, mode }
    }

    /// Without the mode.
    pub fn at(&self) -> Timed<N> {
        Timed {
            t: self.t,
            x: self.x,
        }
    }

    /// The same mode at another state.
    pub fn moved(&self, x: State<N>) -> Self {
        Anchor { x, ..*self }
    }

    /// On the boundary of what sticks, near to which it lies.
    pub fn settled<S: Switched<N, G, Mode = K>, const G: usize>(&self, system: &S) -> Self {
        let onto =
            |at: Self| at.moved(system.with_flow(at.mode, S::Branch::default(), Settled(at.at())));
        // The first leaves the rounding of the state that it came from, which next to zero is more than the boundary's own.
        onto(onto(*self))
    }

    /// Where a run begins that is meant to be in this mode there: on the boundary of what sticks, if that sticks, and in the mode that a run from
    /// there is in.
    ///
    /// # Errors
    /// Those of [`Integration::new`].
    pub fn begun<S: Switched<N, G, Mode = K>, const G: usize>(
        &self,
        system: &S,
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let onto = Anchor::at_start(system, &self.settled(system).at(), t_end, options)?;
        let meant = system.normals(self.mode, &self.at());
        let sticks = |contact: usize| S::mode_of(onto.mode, contact) == Mode::Stick;
        if meant.iter().all(|(contact, _)| sticks(*contact)) {
            return Ok(onto);
        }
        Anchor::at_start(system, &self.at(), t_end, options)
    }

    /// The vector that moves it.
    pub fn velocity<S: Switched<N, G, Mode = K>, const G: usize>(&self, system: &S) -> State<N> {
        velocity_in(system, self.mode, &self.at())
    }
}

/// The vector that moves a state in a mode.
pub(super) fn velocity_in<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    mode: S::Mode,
    at: &Timed<N>,
) -> State<N> {
    let here = Velocity(at.t, components(&at.x));
    system.with_flow(mode, S::Branch::default(), here).into()
}
