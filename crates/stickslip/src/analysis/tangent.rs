//! How tangent vectors travel along a run: through steps by the steps themselves on dual numbers, through transitions by
//! saltation.

use std::marker::PhantomData;

use nalgebra::SMatrix;

use crate::dual::Dual;
use crate::error::{Error, Point};
use crate::filippov::{
    Flow, GuardGradient, Method, Options, StepRecord, Switched, Transition, UseFlow, Velocity,
    boundary_gradient,
};
use crate::ode::control::squared_error;
use crate::ode::{Dop853, Rk4, RungeKutta, Stages, Timed, Tolerance, stages};
use crate::system::{Filippov, State, components};

/// The saltation matrix of a transition at `(t, x)` from the vector `before` to `after`:
/// `S = I + (f⁺ − f⁻) ∇hᵀ / (∂h/∂t + ∇h·f⁻)`.
///
/// Aizerman & Gantmakher 1958; Müller, *Chaos, Solitons & Fractals* 5 (1995) 1671; Leine & Nijmeijer 2004, Ch. 7. It
/// holds for crossing and for entry into stick (`after` the sliding field), where it has a zero eigenvalue; leaving
/// stick at a tangent point changes no vector and its saltation matrix is the identity.
pub fn saltation<S: Filippov<N>, const N: usize>(
    system: &S,
    t: f64,
    x: &State<N>,
    before: &State<N>,
    after: &State<N>,
) -> SMatrix<f64, N, N> {
    with_gradient(boundary_gradient(system, t, x), before, after)
}

/// The saltation matrix where a function of this gradient, and rate of change in time, is zero.
fn with_gradient<const N: usize>(
    (gradient, in_time): (State<N>, f64),
    before: &State<N>,
    after: &State<N>,
) -> SMatrix<f64, N, N> {
    let mut rate = in_time;
    for i in 0..N {
        rate += gradient[i] * before[i];
    }
    SMatrix::from_fn(|i, j| {
        f64::from(u8::from(i == j)) + (after[i] - before[i]) * gradient[j] / rate
    })
}

/// What a transition does to tangent vectors.
pub(crate) struct Jump<const N: usize> {
    /// Saltation matrix.
    pub matrix: SMatrix<f64, N, N>,
    /// Field after less field before.
    pub kick: State<N>,
    /// Rate of the boundary function before.
    pub rate_before: f64,
    /// The same after: zero on entry into stick.
    pub rate_after: f64,
    /// Gradient of the boundary function.
    pub gradient: State<N>,
}

/// Tolerances per step up to which a tangent vector may be off; a step that is right for the state mostly leaves it within
/// some ten.
const SLACK: f64 = 100.0;

/// Halvings of a step allowed for the sake of a tangent vector.
const MOST_HALVINGS: u32 = 30;

/// The tangent flow of a system as the solver integrates it.
pub(crate) struct Tangent<'a, S> {
    pub system: &'a S,
    method: Method,
    /// Error aimed at per step in units of the vector's own size.
    tolerance: f64,
}

/// A piece of a step: start and length.
struct Piece<const N: usize> {
    t: f64,
    x: State<N>,
    h: f64,
}

/// A tangent vector to be carried over a piece by method `M`; the piece is halved up to so many times.
struct Carried<'a, M, const N: usize> {
    piece: Piece<N>,
    vector: &'a State<N>,
    halvings: u32,
    tolerance: f64,
    method: PhantomData<M>,
}

impl<M: RungeKutta, const N: usize> UseFlow<N> for Carried<'_, M, N> {
    type Output = State<N>;

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) -> State<N> {
        advanced::<M, F, N>(
            flow,
            &self.piece,
            self.vector,
            self.halvings,
            self.tolerance,
        )
        .1
    }
}

impl<'a, S> Tangent<'a, S> {
    pub(crate) fn new(system: &'a S, options: &Options) -> Self {
        Tangent {
            system,
            method: options.method,
            tolerance: options.rtol.max(options.atol),
        }
    }

    /// `vector` after the step: the step run again on dual numbers.
    ///
    /// What the step-size control saw was the error of the state. Where that says nothing of the vector's (a state near
    /// rest allows steps of any length) the step is halved until the vector is accurate, too; a fixed step stays as
    /// it is.
    pub(crate) fn carried<const N: usize, const G: usize>(
        &self,
        step: &StepRecord<N, S::Mode>,
        vector: &State<N>,
    ) -> State<N>
    where
        S: Switched<N, G>,
    {
        match self.method {
            // A Taylor step is longer than DOP853's would be: halving takes care of that as well.
            Method::Dop853 | Method::Taylor => {
                self.carried_by::<Dop853, N, G>(step, vector, MOST_HALVINGS)
            }
            Method::Dop853Fixed { .. } => self.carried_by::<Dop853, N, G>(step, vector, 0),
            Method::Rk4 { .. } => self.carried_by::<Rk4, N, G>(step, vector, 0),
        }
    }

    fn carried_by<M: RungeKutta, const N: usize, const G: usize>(
        &self,
        step: &StepRecord<N, S::Mode>,
        vector: &State<N>,
        halvings: u32,
    ) -> State<N>
    where
        S: Switched<N, G>,
    {
        let carried = Carried::<M, N> {
            piece: Piece {
                t: step.t_start,
                x: step.x_start,
                h: step.t_end - step.t_start,
            },
            vector,
            halvings,
            tolerance: self.tolerance,
            method: PhantomData,
        };
        self.system
            .with_flow(step.mode, S::Branch::default(), carried)
    }

    /// What the transition does, or `None` where it changes no vector: on leaving stick, at a touch,
    /// where contact is lost or gained, and where the two fields agree (friction without normal force): the
    /// saltation matrix is the limit there, the identity, though its formula may read 0/0.
    ///
    /// # Errors
    /// [`Error::TangentSingular`] where two contacts come to zero in the same instant: which comes first depends on the change.
    pub(crate) fn jump<const N: usize, const G: usize>(
        &self,
        at: &Transition<N, S::Mode>,
    ) -> Result<Option<Jump<N>>, Error>
    where
        S: Switched<N, G>,
    {
        let Some(guard) = self.system.jumps_at(at) else {
            return Ok(None);
        };
        if !self.system.is_one_at_a_time(at) {
            return Err(singular(at.t, &at.x));
        }
        let branch = S::Branch::default();
        let velocity = |mode| {
            let here = Velocity(at.t, components(&at.x));
            State::from(self.system.with_flow(mode, branch, here))
        };
        let (before, after) = (velocity(at.from), velocity(at.to));
        let kick = after - before;
        if kick.iter().all(|v| *v == 0.0) {
            return Ok(None);
        }
        let (t, x) = (at.t, at.x);
        let of_guard = GuardGradient(guard, Timed { t, x });
        let (gradient, in_time) = self.system.with_flow(at.from, branch, of_guard);
        Ok(Some(Jump {
            matrix: with_gradient((gradient, in_time), &before, &after),
            kick,
            rate_before: in_time + gradient.dot(&before),
            rate_after: in_time + gradient.dot(&after),
            gradient,
        }))
    }
}

/// Where tangent vectors have no image.
pub(super) fn singular<const N: usize>(t: f64, x: &State<N>) -> Error {
    let x = Point::from(x);
    Error::TangentSingular { t, x }
}

/// State and vector at the end of the piece, halved up to so many times.
fn advanced<M: RungeKutta, F: Flow<N>, const N: usize>(
    flow: &F,
    piece: &Piece<N>,
    vector: &State<N>,
    halvings: u32,
    tolerance: f64,
) -> (State<N>, State<N>) {
    let mut field = |t: Dual<f64>, x: &[Dual<f64>; N]| flow.field(t, x);
    let start: [_; N] = std::array::from_fn(|i| Dual::new(piece.x[i], vector[i]));
    let (t, h) = (Dual::new(piece.t, 0.0), Dual::new(piece.h, 0.0));
    let slope = field(t, &start);
    let step = stages::<M, _, _>(&mut field, t, &start, slope, h);
    let end = (
        State::from(step.end.map(|v| v.re)),
        State::from(step.end.map(|v| v.eps)),
    );
    // Where there is nothing to carry, or nothing finite, halving is of no use.
    let size = vector.norm();
    if halvings == 0 || size == 0.0 || !size.is_finite() {
        return end;
    }
    let of_vector = Stages {
        k: step.k.map(|k| State::from(k.map(|v| v.eps))),
        end: end.1,
    };
    let allowed = Tolerance {
        rtol: 0.0,
        atol: tolerance * size,
    };
    let error = squared_error::<M, N>(&of_vector, vector, piece.h, &allowed);
    // Not a number where the piece is so long that its stages overflow.
    if error <= SLACK * SLACK {
        return end;
    }
    let half = 0.5 * piece.h;
    let first = Piece { h: half, ..*piece };
    let (x, between) = advanced::<M, F, N>(flow, &first, vector, halvings - 1, tolerance);
    let second = Piece {
        t: piece.t + half,
        x,
        ..first
    };
    advanced::<M, F, N>(flow, &second, &between, halvings - 1, tolerance)
}

/// Takes out of `vector` what it has across a boundary of this gradient.
pub(crate) fn flatten<const N: usize>(gradient: &State<N>, vector: &mut State<N>) {
    let square = gradient.norm_squared();
    let across: f64 = (0..N).map(|i| gradient[i] * vector[i]).sum();
    for i in 0..N {
        vector[i] -= gradient[i] * across / square;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filippov::TransitionKind;
    use crate::scalar::Scalar;
    use crate::system::{Mode, Side};

    /// A block whose friction is `friction` on either side of rest.
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
        // At rest at the origin: with friction the block sticks; without, Σ is nothing to it and its formula reads 0/0.
        let entry = Transition {
            t: 0.0,
            x: State::from([0.0, 0.0]),
            kind: TransitionKind::StickEntry,
            from: Mode::Slip(Side::Below),
            to: Mode::Stick,
            contact: 0,
            residual: 0.0,
        };
        let options = Options::default();
        let rough = Block { friction: 0.4 };
        let jump = Tangent::new(&rough, &options).jump(&entry);
        assert_eq!(jump.unwrap().unwrap().matrix.determinant(), 0.0);
        let smooth = Block { friction: 0.0 };
        assert!(
            Tangent::new(&smooth, &options)
                .jump(&entry)
                .unwrap()
                .is_none()
        );
    }
}
