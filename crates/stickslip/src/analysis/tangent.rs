//! How tangent vectors travel along a run: through steps by the steps themselves on dual numbers, through transitions by
//! saltation.

use crate::dual::Dual;
use nalgebra::SMatrix;

use crate::filippov::{
    Method, Options, StepRecord, Transition, TransitionKind, boundary_gradient, sliding_field,
};
use crate::ode::control::squared_error;
use crate::ode::{Dop853, Rk4, RungeKutta, Stages, Tolerance, stages};
use crate::scalar::Scalar;
use crate::system::{Filippov, Mode, State, components};

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
    let (gradient, in_time) = boundary_gradient(system, t, x);
    let mut rate = in_time;
    for i in 0..N {
        rate += gradient[i] * before[i];
    }
    SMatrix::from_fn(|i, j| {
        f64::from(u8::from(i == j)) + (after[i] - before[i]) * gradient[j] / rate
    })
}

/// The field that rules in `mode`.
#[inline(always)]
pub(crate) fn field_in<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    mode: Mode,
    t: T,
    x: &[T; N],
) -> [T; N] {
    match mode {
        Mode::Slip(side) => system.field(side, t, x),
        Mode::Stick => sliding_field(system, t, x),
    }
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

/// A piece of a step: mode, start and length.
struct Piece<const N: usize> {
    mode: Mode,
    t: f64,
    x: State<N>,
    h: f64,
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
    pub(crate) fn carried<const N: usize>(
        &self,
        step: &StepRecord<N>,
        vector: &State<N>,
    ) -> State<N>
    where
        S: Filippov<N>,
    {
        let whole = Piece {
            mode: step.mode,
            t: step.t_start,
            x: step.x_start,
            h: step.t_end - step.t_start,
        };
        match self.method {
            // A Taylor step is longer than DOP853's would be: halving takes care of that as well.
            Method::Dop853 | Method::Taylor => {
                self.advanced::<Dop853, N>(&whole, vector, MOST_HALVINGS).1
            }
            Method::Dop853Fixed { .. } => self.advanced::<Dop853, N>(&whole, vector, 0).1,
            Method::Rk4 { .. } => self.advanced::<Rk4, N>(&whole, vector, 0).1,
        }
    }

    /// State and vector at the end of the piece, halved up to so many times.
    fn advanced<M: RungeKutta, const N: usize>(
        &self,
        piece: &Piece<N>,
        vector: &State<N>,
        halvings: u32,
    ) -> (State<N>, State<N>)
    where
        S: Filippov<N>,
    {
        let mut field = |t: Dual<f64>, x: &[Dual<f64>; N]| field_in(self.system, piece.mode, t, x);
        let start: [_; N] = std::array::from_fn(|i| Dual::new(piece.x[i], vector[i]));
        let (t, h) = (Dual::new(piece.t, 0.0), Dual::new(piece.h, 0.0));
        let slope = field(t, &start);
        let step = stages::<M, _, _>(&mut field, t, &start, slope, h);
        let end = (
            State::from(step.end.map(|v| v.re)),
            State::from(step.end.map(|v| v.eps)),
        );
        if halvings == 0 {
            return end;
        }
        let of_vector = Stages {
            k: step.k.map(|k| State::from(k.map(|v| v.eps))),
            end: end.1,
        };
        let tolerance = Tolerance {
            rtol: 0.0,
            atol: self.tolerance * vector.norm(),
        };
        let error = squared_error::<M, N>(&of_vector, vector, piece.h, &tolerance);
        // Not a number where the vector is zero; then, and where it is not finite, halving is of no use.
        if error.is_nan() || error <= SLACK * SLACK {
            return end;
        }
        let half = 0.5 * piece.h;
        let first = Piece { h: half, ..*piece };
        let (x, between) = self.advanced::<M, N>(&first, vector, halvings - 1);
        let second = Piece {
            t: piece.t + half,
            x,
            ..first
        };
        self.advanced::<M, N>(&second, &between, halvings - 1)
    }

    /// What the transition does, or `None` where it changes no vector: on leaving stick, at a touch,
    /// where contact is lost or gained, and where the two fields agree (friction without normal force): the
    /// saltation matrix is the limit there, the identity, though its formula may read 0/0.
    pub(crate) fn jump<const N: usize>(&self, at: &Transition<N>) -> Option<Jump<N>>
    where
        S: Filippov<N>,
    {
        match at.kind {
            // At a loss of contact the fields are continuous: they kink, they do not jump.
            TransitionKind::StickExit
            | TransitionKind::Touch
            | TransitionKind::ContactLoss
            | TransitionKind::ContactGain => return None,
            TransitionKind::Crossing | TransitionKind::StickEntry => {}
        }
        let velocity = |mode| State::from(field_in(self.system, mode, at.t, components(&at.x)));
        let (before, after) = (velocity(at.from), velocity(at.to));
        let kick = after - before;
        if kick.iter().all(|v| *v == 0.0) {
            return None;
        }
        let (gradient, in_time) = boundary_gradient(self.system, at.t, &at.x);
        Some(Jump {
            matrix: saltation(self.system, at.t, &at.x, &before, &after),
            kick,
            rate_before: in_time + gradient.dot(&before),
            rate_after: in_time + gradient.dot(&after),
            gradient,
        })
    }
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
    use crate::scalar::Scalar;
    use crate::system::Side;

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
            residual: 0.0,
        };
        let options = Options::default();
        let rough = Block { friction: 0.4 };
        let jump = Tangent::new(&rough, &options).jump(&entry);
        assert_eq!(jump.unwrap().matrix.determinant(), 0.0);
        let smooth = Block { friction: 0.0 };
        assert!(Tangent::new(&smooth, &options).jump(&entry).is_none());
    }
}
