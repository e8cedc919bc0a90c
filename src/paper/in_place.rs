//! The arithmetic of the Appendix's listing for systems of any dimension. It gives the result that
//! model 3 would have if it was run that way.
//!
//! The paper prints a program for Model 2 only. This is the same scheme with its defects for a
//! [`Filippov`] system whose boundary function is `x₂ − vp`. Runge–Kutta stages overwrite their own
//! start, so a slip phase runs three times too fast. The Hénon step onto Σ has the same defect and
//! starts beyond Σ. From above, it leads away from Σ; it takes 0.166666 for 1/6. In a stick phase
//! the body moves with the belt at the correct speed. See [`super::listing`] for the original.

use super::stages::{VELOCITY, in_time, in_velocity};
use stickslip::{Filippov, Mode, Side, State};

/// The listing's rounded 1/6.
const SIXTH: f64 = 0.166666;

/// Reason for which the scheme cannot go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Breakdown {
    /// A component exceeded the bound.
    Escaped {
        /// Time of the last state within the bound.
        t: f64,
    },
    /// A component is not a number.
    NotFinite {
        /// Time of the last finite state.
        t: f64,
    },
}

/// The state of a run of the scheme.
#[derive(Clone, Debug)]
pub struct InPlace<S, const N: usize> {
    system: S,
    h: f64,
    bound: f64,
    /// Time.
    pub t: f64,
    /// State.
    pub x: State<N>,
    mode: Mode,
}

impl<S: Filippov<N>, const N: usize> InPlace<S, N> {
    /// Starts at `(0, x)` with step `h`. The run fails when a component exceeds `bound`. A start on
    /// Σ sticks if both fields push towards it. Otherwise it goes to the side above, as in the
    /// listing.
    pub fn start(system: S, x: State<N>, h: f64, bound: f64) -> Self {
        let mut scheme = InPlace {
            system,
            h,
            bound,
            t: 0.0,
            x,
            mode: Mode::Stick,
        };
        let gap = scheme.system.boundary(0.0, &x.into());
        scheme.mode = if gap < 0.0 {
            Mode::Slip(Side::Below)
        } else if gap == 0.0 && scheme.release_side().is_none() {
            Mode::Stick
        } else {
            Mode::Slip(Side::Above)
        };
        scheme
    }

    /// One pass of the listing's loop.
    ///
    /// # Errors
    /// [`Breakdown`] where the state is no longer a motion of the system.
    pub fn advance(&mut self) -> Result<(), Breakdown> {
        let t = self.t;
        match self.mode {
            Mode::Stick => self.stick(),
            Mode::Slip(side) => self.slip(side),
        }
        if !self.t.is_finite() || self.x.iter().any(|v| !v.is_finite()) {
            return Err(Breakdown::NotFinite { t });
        }
        if self.x.amax() > self.bound {
            return Err(Breakdown::Escaped { t });
        }
        Ok(())
    }

    fn slip(&mut self, side: Side) {
        let system = &self.system;
        let moved = in_time(true, self.h, (self.t, self.x), |t, x| {
            State::from(system.field(side, t, &(*x).into()))
        });
        let gap = self.system.boundary(self.t, &moved.into());
        if gap * side.sign() > 0.0 {
            self.t += self.h;
            self.x = moved;
            return;
        }
        // Back onto Σ from below. From above, the listing has the wrong sign.
        let to_go = gap * if side == Side::Below { -1.0 } else { 1.0 };
        let slope = |t: f64, x: &State<N>| {
            let f = State::from(system.field(side, t, &(*x).into()));
            let per_velocity = 1.0 / f[VELOCITY];
            (per_velocity, f * per_velocity)
        };
        let step = (to_go, to_go * SIXTH);
        (self.t, self.x) = in_velocity(true, step, (self.t, moved), slope);
        self.x[VELOCITY] = moved[VELOCITY] - gap;
        self.mode = match self.release_side() {
            None => Mode::Stick,
            Some(_) => Mode::Slip(side.opposite()),
        };
    }

    fn stick(&mut self) {
        let system = &self.system;
        let velocity = self.x[VELOCITY];
        let mut moved = in_time(true, self.h, (self.t, self.x), |t, x| {
            let mut f = sliding(system, t, x);
            f[0] = 0.0;
            f[VELOCITY] = 0.0;
            f
        });
        moved[0] = self.x[0] + self.h * velocity;
        self.x = moved;
        self.t += self.h;
        if let Some(side) = self.release_side() {
            self.mode = Mode::Slip(side);
        }
    }

    /// The side whose field does not push towards Σ, if there is one.
    fn release_side(&self) -> Option<Side> {
        let x = &self.x.into();
        if self.system.field(Side::Below, self.t, x)[VELOCITY] <= 0.0 {
            Some(Side::Below)
        } else if self.system.field(Side::Above, self.t, x)[VELOCITY] >= 0.0 {
            Some(Side::Above)
        } else {
            None
        }
    }
}

/// Filippov's convex combination of the fields, which keeps the velocity constant.
fn sliding<S: Filippov<N>, const N: usize>(system: &S, t: f64, x: &State<N>) -> State<N> {
    let velocity = |side| State::from(system.field(side, t, &(*x).into()));
    let (below, above) = (velocity(Side::Below), velocity(Side::Above));
    let gap = below[VELOCITY] - above[VELOCITY];
    let weight = if gap == 0.0 {
        0.5
    } else {
        below[VELOCITY] / gap
    };
    below + (above - below) * weight
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::models::{BlockAndBracket, Caption, Interpretation};

    #[test]
    fn a_constant_field_carries_three_steps_at_a_time() {
        let x = in_time(true, 0.1, (0.0, State::from([1.0, 2.0])), |_, _| {
            State::from([1.0, -2.0])
        });
        assert!((x - State::from([1.3, 1.4])).amax() < 1e-15);
    }

    fn fig11(bound: f64) -> InPlace<BlockAndBracket, 4> {
        let system =
            BlockAndBracket::from_caption(&Caption::FIG11, &Interpretation::exact()).unwrap();
        InPlace::start(system, State::from(Caption::FIG11.start), 1e-2, bound)
    }

    #[test]
    fn the_clock_and_the_belt_keep_their_own_pace() {
        let mut scheme = fig11(1e3);
        let mut sticks = 0;
        for _ in 0..100_000 {
            let (before, t, x) = (scheme.mode, scheme.t, scheme.x);
            scheme.advance().unwrap();
            if before == Mode::Stick {
                sticks += 1;
                assert_eq!(scheme.t, t + 1e-2);
                assert_eq!(scheme.x[0], x[0] + 1e-2 * 0.707);
                assert_eq!(scheme.x[1], x[1]);
            }
            if scheme.mode == Mode::Stick {
                assert!((scheme.x[1] - 0.707).abs() < 1e-12);
            }
        }
        assert!(sticks > 0);
    }

    #[test]
    fn leaving_the_bound_is_an_outcome() {
        let mut scheme = fig11(0.3);
        let breakdown = (0..100_000).find_map(|_| scheme.advance().err());
        assert!(matches!(breakdown, Some(Breakdown::Escaped { t }) if t > 0.0));
    }
}
