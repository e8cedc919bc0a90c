//! Tangent vectors along a run: steps carry them on dual numbers, transitions by saltation.

use super::instant::Cause;
use super::simultaneous::{SAME, check_order};
use crate::dynamics::{
    Carrying, Dynamics, Matrix, Modes, Moment, Reset, Step, TANGENT_ERROR, Transition, Vector,
};
use crate::error::{Error, Point};
use crate::filippov::{EVENT_PRECISION, MIN_TOLERANCE, Options, TransitionKind};

/// Entries of the saltation matrix at a zero of `h`: `S = I + (f⁺ − f⁻) ∇hᵀ / (∂h/∂t + ∇h·f⁻)`. The
/// gradient and the time derivative are those of `h`; `before` is `f⁻`, and `after` is `f⁺`.
///
/// Aizerman & Gantmakher 1958; Müller, *Chaos, Solitons & Fractals* 5 (1995) 1671; Leine &
/// Nijmeijer 2004, Ch. 7. It holds for crossings and for entry into stick (`after` is the sliding
/// field), where it has a zero eigenvalue. Leaving stick at a tangent point changes no vector, and
/// its saltation matrix is the identity.
fn entry([gradient, before, after]: [&[f64]; 3], in_time: f64) -> impl Fn(usize, usize) -> f64 {
    let mut rate = in_time;
    for (gradient, before) in gradient.iter().zip(before) {
        rate += gradient * before;
    }
    move |i, j| f64::from(u8::from(i == j)) + (after[i] - before[i]) * gradient[j] / rate
}

/// Relative rounding of a jump's matrix, some hundred units in the last place: singular values
/// below it are zero.
pub(crate) const MATRIX_ROUNDING: f64 = 1e-13;

/// The velocity after a jump, less that which it makes of the one before. A component that is
/// rounding of its terms is zero: over the small rate of a landing it would count.
fn kick(after: Vector, (reset, before): (&Reset, &Vector)) -> Vector {
    let terms = after.abs() + reset.by_state.abs() * before.abs() + reset.by_time.abs();
    let kick = after - &reset.by_state * before - &reset.by_time;
    kick.zip_map(&terms, |kick, terms| {
        let is_rounding = kick.abs() <= MATRIX_ROUNDING * terms;
        if is_rounding { 0.0 } else { kick }
    })
}

/// The effect of a transition on tangent vectors.
pub(crate) struct Saltation {
    /// Saltation matrix.
    pub matrix: Matrix,
    /// Determinant of the derivative of a map of the state, which changes no time: zero where it
    /// annihilates a direction to rounding. It is 1 without a map.
    pub of_map: f64,
    /// Field after the transition minus field before it; at a map of the state, minus the image of
    /// the latter.
    pub kick: Vector,
    /// Determinant: zero on entry into stick.
    pub determinant: f64,
    /// Gradient of the function that vanishes there.
    pub gradient: Vector,
}

/// The tangent flow of a system as the solver integrates it.
#[derive(Clone, Copy)]
pub(crate) struct Tangent<'a> {
    pub system: &'a dyn Dynamics,
    carrying: Carrying,
}

impl<'a> Tangent<'a> {
    pub(crate) fn new(system: &'a dyn Dynamics, options: &Options) -> Self {
        let carrying = Carrying {
            method: options.method,
            tolerance: options.finest(),
        };
        Tangent { system, carrying }
    }

    /// The flow with so small an error that pieces of a step are halved at least once more: the
    /// error estimate of order 8 falls by 256.
    pub(crate) fn finer(mut self) -> Self {
        const TOLERANCE_PART: f64 = 1.0 / 512.0;
        self.carrying.tolerance = (TOLERANCE_PART * self.carrying.tolerance).max(MIN_TOLERANCE);
        self
    }

    /// Largest error of a vector over a step, relative to its length.
    pub(crate) fn error(&self) -> f64 {
        TANGENT_ERROR * self.carrying.tolerance
    }

    /// The tolerance of the run.
    pub(crate) fn tolerance(&self) -> f64 {
        self.carrying.tolerance
    }

    /// The images of vectors after the end of the step, and after the kink of an input there.
    pub(crate) fn carried(&self, step: &Step, vectors: &[Vector]) -> Vec<Vector> {
        let flow = self.system.flow(step.mode, &step.end());
        let shifts = self.system.kink_shifts(step);
        let mut images = flow.transport(step, vectors, self.carrying);
        for image in &mut images {
            for shift in &shifts {
                *image += &shift.kick * (shift.gradient.dot(image) / shift.rate);
            }
        }
        images
    }

    /// The effect of a jump's map `R` of the state with the derivative `D` (Müller 1995, Eq. 11):
    /// `S = D + (f⁺ − D f⁻ − ∂R/∂t) ∇hᵀ / (∂h/∂t + ∇h·f⁻)`. Where impacts have accumulated, `h` is
    /// the rate of the gap. A change of the time of accumulation appears in it, since all speeds of
    /// the last impacts vanish with their durations.
    ///
    /// # Errors
    /// [`Error::TangentSingular`] where the orbit grazes the surface of the jump, and
    /// [`Error::ChainedJumps`] and [`Error::TiedChoice`].
    fn reset(&self, at: &Transition, cause: Cause) -> Result<Saltation, Error> {
        let here = at.moment();
        let mut reset = self.system.reset(at.contact, &here);
        if let Some(input) = cause.kink {
            (_, reset.gradient, reset.in_time) = self.system.clock(input, &here);
        }
        if reset.is_tied {
            let (t, x, jump) = (at.t, Point::from(&at.x), at.contact);
            return Err(Error::TiedChoice { t, x, jump });
        }
        let after_jump = Moment {
            t: at.t,
            x: reset.after.clone(),
        };
        let before = self.system.flow(at.from, &here).velocity(&here);
        let after = self.system.flow(at.to, &after_jump).velocity(&after_jump);
        let kick = kick(after, (&reset, &before));
        let rate = reset.in_time + reset.gradient.dot(&before);
        // If its function is not zero, another jump triggered it and decides its time.
        let in_time = reset.in_time.abs() * at.t.abs();
        let size = reset.gradient.abs().dot(&at.x.abs()) + in_time + rate.abs();
        // Where impacts accumulate, all parts are small; the state is known to the tolerance.
        let located = EVENT_PRECISION * reset.gradient.abs().sum();
        let is_triggered = match reset.lands {
            true => self.is_landing_triggered(at, cause),
            false => reset.value.abs() > self.carrying.tolerance * (size + located),
        };
        let is_triggered = cause.kink.is_none() && is_triggered;
        // What is left of a gap's rate at its landing is no motion.
        let rounding = if reset.lands { SAME } else { f64::EPSILON };
        if is_triggered && kick.amax() > rounding * before.amax() {
            let (t, x, jump) = (at.t, Point::from(&at.x), at.contact);
            return Err(Error::ChainedJumps { t, x, jump });
        }
        let kick = if is_triggered { kick * 0.0 } else { kick };
        let matrix = &reset.by_state + &kick * reset.gradient.transpose() / rate;
        let matrix = self.landed(at, &after_jump, matrix);
        if matrix.iter().any(|entry| !entry.is_finite()) {
            return Err(singular(at.t, &at.x));
        }
        let size = reset.by_state.amax();
        let sizes = (0..matrix.nrows()).fold(1.0, |all, _| all * size);
        let of_map = reset.by_state.determinant();
        let is_regular = of_map.abs() > MATRIX_ROUNDING * sizes;
        Ok(Saltation {
            determinant: matrix.determinant(),
            of_map: if is_regular { of_map } else { 0.0 },
            matrix,
            kick,
            gradient: reset.gradient,
        })
    }

    /// The effect of a jump that leaves a body on a stop. The derivative by a restitution of 0
    /// gives it a speed `w` off there. It then lands after a flight of the duration `2 w/a`, with
    /// `a` the acceleration towards the stop.
    fn landed(&self, at: &Transition, after: &Moment, mut matrix: Matrix) -> Matrix {
        // On a stop that carries before and after, no vector has a speed off it.
        let carried = self.system.landings(&at.moment());
        let landings = self.system.landings(after).into_iter();
        for number in landings.filter(|number| !carried.contains(number)) {
            let landing = self.system.reset(number, after);
            let speeds = matrix.tr_mul(&landing.gradient);
            let sizes = matrix.abs().tr_mul(&landing.gradient.abs());
            let is_motion = |(speed, size): (&f64, &f64)| speed.abs() > SAME * size;
            if speeds.iter().zip(sizes.iter()).any(is_motion) {
                let flight = Moment {
                    t: after.t,
                    x: self.system.opened(after.x.clone()),
                };
                let [before, after] =
                    [&flight, after].map(|at_| self.system.flow(at.to, at_).velocity(at_));
                let acceleration = landing.in_time + landing.gradient.dot(&before);
                let kick = kick(after, (&landing, &before));
                matrix = &landing.by_state * matrix;
                matrix += kick * speeds.transpose() * (2.0 / acceleration);
            }
        }
        matrix
    }

    /// Whether a landing follows another jump in its instant, and no series of impacts.
    fn is_landing_triggered(&self, at: &Transition, cause: Cause) -> bool {
        let is_other = |jump: usize| {
            let is_impact = self.system.rest_after(jump) == Some(at.contact);
            !is_impact && !self.system.reset(jump, &at.moment()).lands
        };
        !cause.is_first && cause.follows.is_some_and(is_other)
    }

    /// The effect of a change of mode at the kink of an input. It occurs at the time of the kink,
    /// wherever the state is, so that the input's clock takes the place of the boundary function.
    /// `None` where nothing moves that time.
    fn change_at_kink(&self, at: &Transition, input: usize) -> Option<Saltation> {
        let here = at.moment();
        let (_, gradient, in_time) = self.system.clock(input, &here);
        let flow = |mode: Modes| self.system.flow(mode, &here);
        let (before, after) = (flow(at.from).velocity(&here), flow(at.to).velocity(&here));
        let rate = in_time + gradient.dot(&before);
        let kick = after - before;
        if gradient.amax() == 0.0 || rate == 0.0 || kick.amax() == 0.0 {
            return None;
        }
        let n = gradient.len();
        Some(Saltation {
            matrix: Matrix::identity(n, n) + &kick * gradient.transpose() / rate,
            determinant: 1.0 + gradient.dot(&kick) / rate,
            of_map: 1.0,
            kick,
            gradient,
        })
    }

    /// The effect of a transition on vectors, as [`Tangent::jump`] gives it, where other events at
    /// its instant may come before it or after it: see [`check_order`].
    ///
    /// # Errors
    /// Those of [`Tangent::jump`]; [`Error::SimultaneousEvents`].
    pub(crate) fn passed(
        &self,
        at: &Transition,
        cause: Cause,
        columns: &[Vector],
    ) -> Result<Option<Saltation>, Error> {
        let joint = check_order(self.system, at, cause, columns)?;
        let jump = self.jump(at, cause)?;
        Ok(match (joint, jump) {
            (Some(matrix), Some(jump)) => {
                let after = Moment {
                    t: at.t,
                    x: self.system.reset(at.contact, &at.moment()).after,
                };
                let matrix = self.landed(at, &after, matrix);
                Some(Saltation {
                    determinant: matrix.determinant(),
                    matrix,
                    ..jump
                })
            }
            (_, jump) => jump,
        })
    }

    /// The effect of the transition, or `None` where it changes no vector. Those are the exit from
    /// stick, a touch, contact lost or gained, and a contact whose two fields agree (friction
    /// without normal force). There the limit of the saltation matrix is the identity, though its
    /// formula may read 0/0.
    ///
    /// # Errors
    /// [`Error::TangentSingular`] where two contacts reach zero in the same instant: the
    /// perturbation decides which comes first.
    fn jump(&self, at: &Transition, cause: Cause) -> Result<Option<Saltation>, Error> {
        if at.kind == TransitionKind::Jump {
            return self.reset(at, cause).map(Some);
        }
        let here = at.moment();
        if let Some(input) = cause.kink {
            return Ok(self.change_at_kink(at, input));
        }
        let Some(guard) = self.system.discontinuity_guard(at) else {
            return Ok(None);
        };
        if !self.system.is_one_at_a_time(at) {
            return Err(singular(at.t, &at.x));
        }
        let flow = |mode: Modes| self.system.flow(mode, &here);
        let (before, after) = (flow(at.from).velocity(&here), flow(at.to).velocity(&here));
        let kick = &after - &before;
        if kick.iter().all(|v| *v == 0.0) {
            return Ok(None);
        }
        let (gradient, in_time) = flow(at.from).guard_gradient(guard, &here);
        let slices = [&gradient, &before, &after].map(|vector| vector.as_slice());
        let n = gradient.len();
        Ok(Some(Saltation {
            matrix: Matrix::from_fn(n, n, entry(slices, in_time)),
            // det(I + u vᵀ) = 1 + v·u.
            determinant: (in_time + gradient.dot(&after)) / (in_time + gradient.dot(&before)),
            of_map: 1.0,
            kick,
            gradient,
        }))
    }
}

/// The error of tangent vectors without an image.
pub(super) fn singular(t: f64, x: &Vector) -> Error {
    let x = Point::from(x);
    Error::TangentSingular { t, x }
}

/// Removes the component of `vector` across a boundary with this gradient.
pub(crate) fn flatten(gradient: &Vector, vector: &mut Vector) {
    let square = gradient.norm_squared();
    let across: f64 = (0..gradient.len()).map(|i| gradient[i] * vector[i]).sum();
    for i in 0..gradient.len() {
        vector[i] -= gradient[i] * across / square;
    }
}

#[cfg(test)]
mod tests {
    use super::super::instant::LastEvent;
    use super::*;
    use crate::dynamics::AsDynamics;
    use crate::filippov::Method;
    use crate::scalar::Scalar;
    use crate::system::{Filippov, Mode, Side};

    /// A block with friction `friction` on either side of zero velocity.
    struct Block {
        friction: f64,
    }
    impl Filippov<2> for Block {
        fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
            [x[1], -x[0] - self.friction * side.sign()]
        }
        fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
            x[1]
        }
    }

    #[test]
    fn where_the_fields_agree_vectors_pass_unchanged() {
        // At rest at the origin: with friction the block sticks; without it Σ has no effect, and
        // the formula reads 0/0.
        let entry = Transition {
            t: 0.0,
            x: Vector::zeros(2),
            kind: TransitionKind::StickEntry,
            from: Mode::Slip(Side::Below).into(),
            to: Mode::Stick.into(),
            contact: 0,
            residual: 0.0,
        };
        let jump = |friction: f64| {
            let block = Block { friction };
            let jump = Tangent::new(&*block.dynamics(), &Options::default()).jump(
                &entry,
                LastEvent::none().cause_of(&*block.dynamics(), &entry),
            );
            jump.unwrap()
        };
        assert_eq!(jump(0.4).unwrap().matrix.determinant(), 0.0);
        assert!(jump(0.0).is_none());
    }

    /// A pendulum that is shaken.
    struct Pendulum;
    impl Filippov<2> for Pendulum {
        fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 2]) -> [T; 2] {
            [x[1], t.cos() * 0.3 - x[0].sin() * (x[1] * 0.1).exp()]
        }
        fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 2]) -> T {
            T::one()
        }
    }

    #[test]
    fn vectors_carried_together_have_the_bits_that_each_has_alone() {
        let system = Pendulum.dynamics();
        // The longer step is halved, and for the short vector more often than for the others.
        for (t_end, method) in [
            (0.3, Method::Dop853),
            (9.0, Method::Taylor),
            (0.1, Method::Rk4 { step: 0.1 }),
        ] {
            let step = Step {
                mode: Mode::Slip(Side::Above).into(),
                t_start: 0.0,
                t_end,
                x_start: Vector::from_vec(vec![2.9, 0.1]),
                x_end: Vector::zeros(2),
            };
            let options = Options::tol(1e-9).method(method);
            let tangent = Tangent::new(&*system, &options);
            let all = [[1.0, 0.0], [0.0, 0.0], [0.7, 1.9], [-1e-3, 2.0], [0.0, 1.0]];
            let mut all = all.map(|v| Vector::from_vec(v.to_vec()));
            // Almost along the direction that shrinks near the upper equilibrium.
            all[3] = Vector::from_vec(vec![1.0, -0.985]);
            let together = tangent.carried(&step, &all);
            for (vector, image) in all.iter().zip(&together) {
                let alone = tangent.carried(&step, std::slice::from_ref(vector));
                assert_eq!(&alone[0], image);
            }
            assert_eq!(together[1].amax(), 0.0);
            assert!(together[0].norm() > 0.1 && tangent.carried(&step, &[]).is_empty());
        }
    }
}
