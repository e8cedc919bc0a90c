//! Where shooting begins on an orbit.

use crate::dynamics::{Dynamics, Modes, Moment, Section, Vector};
use crate::error::Error;
use crate::filippov::Options;
use crate::system::Mode;

/// A state of an orbit, and the mode that it is in there. On Σ the state alone does not tell it: rounding moves it to one side.
#[derive(Clone, Debug)]
pub(crate) struct Anchor {
    pub at: Moment,
    pub mode: Modes,
}

impl std::ops::Deref for Anchor {
    type Target = Moment;

    fn deref(&self) -> &Moment {
        &self.at
    }
}

impl Anchor {
    /// In the mode that a run from there begins in.
    ///
    /// # Errors
    /// Those of [`crate::Integration::new`].
    pub fn at_start(
        system: &dyn Dynamics,
        at: Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let mode = system.begin(&at, t_end, options, &Section::None)?.mode();
        Ok(Anchor { at, mode })
    }

    pub fn new(t: f64, x: Vector, mode: Modes) -> Self {
        let at = Moment { t, x };
        Anchor { at, mode }
    }

    /// The same mode at another state.
    pub fn moved(&self, x: Vector) -> Self {
        Anchor::new(self.at.t, x, self.mode)
    }

    /// The same state and mode at another time.
    pub fn at_time(&self, t: f64) -> Self {
        Anchor::new(t, self.at.x.clone(), self.mode)
    }

    /// On the boundary of what sticks, near to which it lies.
    pub fn settled(self, system: &dyn Dynamics) -> Self {
        let onto = |at: Self| at.moved(system.flow(at.mode, &at.at).settled(&at.at));
        // The first leaves the rounding of the state that it came from, which next to zero is more than the boundary's own.
        onto(onto(self))
    }

    /// Where a run begins that is meant to be in this mode there: on the boundary of what sticks, if that sticks, and in the mode that a run from
    /// there is in.
    ///
    /// # Errors
    /// Those of [`crate::Integration::new`].
    pub fn begun(
        self,
        system: &dyn Dynamics,
        t_end: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let onto = Anchor::at_start(system, self.clone().settled(system).at, t_end, options)?;
        let meant = system.normals(self.mode, &self.at);
        let sticks = |contact: usize| onto.mode.get(contact) == Mode::Stick;
        if meant.iter().all(|(contact, _)| sticks(*contact)) {
            return Ok(onto);
        }
        Anchor::at_start(system, self.at, t_end, options)
    }

    /// The vector that moves it.
    pub fn velocity(&self, system: &dyn Dynamics) -> Vector {
        velocity_in(system, self.mode, &self.at)
    }
}

/// The vector that moves a state in a mode.
pub(super) fn velocity_in(system: &dyn Dynamics, mode: Modes, at: &Moment) -> Vector {
    system.flow(mode, at).velocity(at)
}
