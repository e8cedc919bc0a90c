//! The two steps of the listing: Runge–Kutta in time (lines 103–114) and Hénon's in velocity (116–127).
//!
//! Each exists as printed, overwriting its own start, and as it was meant. Both take the forcing as a
//! function of time, so that it can stand still or not.

use super::Params;

/// `(t, x1, x2)` in seconds, metres, metres per second.
pub(super) type State = [f64; 3];

/// The smooth field on one side of `x2 = vp`.
#[derive(Clone, Copy)]
pub(super) struct Field {
    inverse_mass: f64,
    k1: f64,
    k2: f64,
    mu0: f64,
    /// `vp + 1` below the belt's speed, `vp − 1` above (line 25): makes `μ0/(pole − x2)` the friction.
    pole: f64,
}

impl Field {
    pub(super) fn below(params: &Params) -> Field {
        Field::with_pole(params, params.belt_speed + 1.0)
    }

    pub(super) fn above(params: &Params) -> Field {
        Field::with_pole(params, params.belt_speed - 1.0)
    }

    fn with_pole(params: &Params, pole: f64) -> Field {
        Field {
            inverse_mass: 1.0 / params.mass,
            k1: params.k1,
            k2: params.k2,
            mu0: params.mu0,
            pole,
        }
    }

    /// `x2'` in metres per second squared (lines 83–84).
    fn acceleration(&self, x: &State, xs: f64) -> f64 {
        let z = x[1] - xs;
        self.inverse_mass
            * (-self.k1 * z
                + self.k2 * stickslip::math::pow(z, 3.0)
                + self.mu0 / (self.pole - x[2]))
    }
}

/// A time step of the state, the clock left as it is (the loop sets it, lines 60 and 76).
#[derive(Clone, Copy)]
pub(super) struct TimeStep {
    pub(super) h: f64,
    pub(super) half: f64,
    pub(super) sixth: f64,
}

impl TimeStep {
    /// Lines 103–114 as printed: every stage moves the state itself.
    pub(super) fn in_place(
        &self,
        field: &Field,
        start: State,
        forcing: impl Fn(f64) -> f64,
    ) -> State {
        let [t, ..] = start;
        let mut x = start;
        let (xs_start, xs_half, xs_end) = (forcing(t), forcing(t + self.half), forcing(t + self.h));
        let (kx1, kv1) = (x[2], field.acceleration(&x, xs_start));
        x[1] += self.half * kx1;
        x[2] += self.half * kv1;
        let (kx2, kv2) = (x[2], field.acceleration(&x, xs_half));
        x[1] += self.half * kx2;
        x[2] += self.half * kv2;
        let (kx3, kv3) = (x[2], field.acceleration(&x, xs_half));
        x[1] += self.h * kx3;
        x[2] += self.h * kv3;
        let (kx4, kv4) = (x[2], field.acceleration(&x, xs_end));
        x[1] += self.sixth * (kx1 + 2.0 * (kx2 + kx3) + kx4);
        x[2] += self.sixth * (kv1 + 2.0 * (kv2 + kv3) + kv4);
        x
    }

    /// The classical Runge–Kutta step the lines were meant to be.
    pub(super) fn classical(
        &self,
        field: &Field,
        start: State,
        forcing: impl Fn(f64) -> f64,
    ) -> State {
        let [t, x1, x2] = start;
        let stage = |step: f64, kx: f64, kv: f64| [t + step, x1 + step * kx, x2 + step * kv];
        let slope = |x: &State| (x[2], field.acceleration(x, forcing(x[0])));
        let (kx1, kv1) = slope(&start);
        let (kx2, kv2) = slope(&stage(self.half, kx1, kv1));
        let (kx3, kv3) = slope(&stage(self.half, kx2, kv2));
        let (kx4, kv4) = slope(&stage(self.h, kx3, kv3));
        [
            t,
            x1 + self.sixth * (kx1 + 2.0 * (kx2 + kx3) + kx4),
            x2 + self.sixth * (kv1 + 2.0 * (kv2 + kv3) + kv4),
        ]
    }
}

/// A step in velocity, `dx1/dx2 = x2/x2'` and `dt/dx2 = 1/x2'`.
#[derive(Clone, Copy)]
pub(super) struct VelocityStep {
    /// Change of `x2` in metres per second.
    pub(super) h: f64,
    /// The listing's `h6`.
    pub(super) sixth: f64,
}

impl VelocityStep {
    /// Lines 116–127 as printed: every stage moves the state itself, the clock moves at the end only.
    pub(super) fn in_place(
        &self,
        field: &Field,
        start: State,
        forcing: impl Fn(f64) -> f64,
    ) -> State {
        let [t, ..] = start;
        let mut x = start;
        let half = self.h * 0.5;
        let kv1 = 1.0 / field.acceleration(&x, forcing(t));
        let kx1 = x[2] * kv1;
        x[1] += half * kx1;
        x[2] += half;
        let kv2 = 1.0 / field.acceleration(&x, forcing(t + half * kv1));
        let kx2 = x[2] * kv2;
        x[1] += half * kx2;
        let kv3 = 1.0 / field.acceleration(&x, forcing(t + half * kv2));
        let kx3 = x[2] * kv3;
        x[1] += self.h * kx3;
        x[2] += self.h;
        let kv4 = 1.0 / field.acceleration(&x, forcing(t + self.h * kv3));
        let kx4 = x[2] * kv4;
        x[1] += self.sixth * (kx1 + 2.0 * (kx2 + kx3) + kx4);
        x[0] += self.sixth * (kv1 + 2.0 * (kv2 + kv3) + kv4);
        x
    }

    /// The classical Runge–Kutta step in velocity the lines were meant to be.
    pub(super) fn classical(
        &self,
        field: &Field,
        start: State,
        forcing: impl Fn(f64) -> f64,
    ) -> State {
        let [t, x1, x2] = start;
        let half = self.h * 0.5;
        let stage = |step: f64, kx: f64, kv: f64| [t + step * kv, x1 + step * kx, x2 + step];
        let slope = |x: &State| {
            let kv = 1.0 / field.acceleration(x, forcing(x[0]));
            (x[2] * kv, kv)
        };
        let (kx1, kv1) = slope(&start);
        let (kx2, kv2) = slope(&stage(half, kx1, kv1));
        let (kx3, kv3) = slope(&stage(half, kx2, kv2));
        let (kx4, kv4) = slope(&stage(self.h, kx3, kv3));
        [
            t + self.sixth * (kv1 + 2.0 * (kv2 + kv3) + kv4),
            x1 + self.sixth * (kx1 + 2.0 * (kx2 + kx3) + kx4),
            x2 + self.h,
        ]
    }
}
