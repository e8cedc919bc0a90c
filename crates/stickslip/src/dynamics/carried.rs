//! Tangent vectors over a step: the step is integrated again on dual numbers.

use crate::duals::Duals;
use crate::filippov::{Flow, Method, UseFlow};
use crate::ode::control::{Estimates, Tolerance, squared_error_of};
use crate::ode::{Dop853, MAX_STAGES, Rk4, RungeKutta, for_each_stage};
use crate::scalar::Scalar;
use crate::system::State;

use super::Carrying;

/// Allowed error of a tangent vector per step, in tolerances. Chosen: a step that is accurate for
/// the state mostly keeps it below ten.
pub(crate) const TANGENT_ERROR: f64 = 100.0;

/// Largest number of times that a step is halved for the accuracy of a tangent vector. Chosen: it
/// bounds the recursion where no step is accurate.
const MAX_HALVINGS: u32 = 30;

/// Directions of the dual numbers for few vectors, for some and for many. They are chosen: all
/// directions of a number take time, and each number takes the compiler time.
const FEW: usize = 2;
const SOME: usize = 4;
const MANY: usize = 8;

/// States of more components are long.
const LONG: usize = 9;

/// A tangent vector and the state at which it stands.
#[derive(Clone, Copy)]
pub(super) struct TangentVector<const N: usize> {
    pub x: State<N>,
    pub vector: State<N>,
}

/// Carries tangent vectors over a step, from one state. The step is integrated again on dual
/// numbers, several vectors at once.
///
/// Step-size control bounds the error of the state, which may not bound the vector's error: a state
/// near an equilibrium allows steps of any length. The step is then halved, up to a given number
/// of times, until the vector is accurate, too.
pub(super) struct CarriedOver<'v, const N: usize> {
    pub start: f64,
    pub length: f64,
    pub vectors: &'v mut [TangentVector<N>],
    /// Number of states of the system.
    pub states: usize,
    pub how: Carrying,
}

/// Data common to the pieces of a step.
#[derive(Clone, Copy)]
struct Pieces {
    states: usize,
    moving: usize,
    tolerance: f64,
}

impl<const N: usize> UseFlow<N> for CarriedOver<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) {
        let pieces = Pieces {
            states: self.states,
            moving: flow.dimension(),
            tolerance: self.how.tolerance,
        };
        let piece = (self.start, self.length);
        match self.how.method {
            // A fixed step is kept.
            Method::Rk4 { .. } => in_groups::<Rk4, F, N>(flow, pieces, piece, self.vectors, 0),
            // A Taylor step is longer than one of DOP853 would be; halving covers that as well.
            Method::Dop853 | Method::Taylor => {
                in_groups::<Dop853, F, N>(flow, pieces, piece, self.vectors, MAX_HALVINGS);
            }
        }
    }
}

/// Carries all vectors, as many at once as there are directions.
fn in_groups<M: RungeKutta, F: Flow<N>, const N: usize>(
    flow: &F,
    pieces: Pieces,
    piece: (f64, f64),
    vectors: &mut [TangentVector<N>],
    halvings: u32,
) {
    let mut rest = vectors;
    while !rest.is_empty() {
        // Numbers of many directions are too large for long states.
        let most = if const { N > LONG } { SOME } else { MANY };
        let (now, later) = rest.split_at_mut(rest.len().min(most));
        match now.len() {
            ..=FEW => {
                let field = &mut |t, x: &[Duals<_>; N]| flow.field(Duals::constant(t), x);
                advance::<M, N, FEW>(field, pieces, piece, now, halvings);
            }
            count if const { N > LONG } || count <= SOME => {
                let field = &mut |t, x: &[Duals<_>; N]| flow.field(Duals::constant(t), x);
                advance::<M, N, SOME>(field, pieces, piece, now, halvings);
            }
            _ => {
                let field = &mut |t, x: &[Duals<_>; N]| flow.field(Duals::constant(t), x);
                advance::<M, N, MANY>(field, pieces, piece, now, halvings);
            }
        }
        rest = later;
    }
}

/// A field on dual numbers. It is a dynamic call, so that what follows is compiled once for all
/// systems of a size.
type SeededField<'f, const N: usize, const W: usize> =
    dyn FnMut(f64, &[Duals<W>; N]) -> [Duals<W>; N] + 'f;

/// Carries at most `W` vectors, which stand at one state, over a piece from `t` of length `h`. It
/// is halved up to a given number of times for those that are not accurate.
fn advance<M: RungeKutta, const N: usize, const W: usize>(
    field: &mut SeededField<'_, N, W>,
    pieces: Pieces,
    (t, h): (f64, f64),
    vectors: &mut [TangentVector<N>],
    halvings: u32,
) {
    let Some(TangentVector { x, .. }) = vectors.first().copied() else {
        return;
    };
    let mut start = [Duals::constant(0.0); N];
    for (i, number) in start.iter_mut().enumerate() {
        number.re = x[i];
        for (eps, one) in number.eps.iter_mut().zip(vectors.iter()) {
            *eps = one.vector[i];
        }
    }
    let step = DualStep::take::<M>(field, (t, h), &start, pieces.moving);
    let end = State::from_fn(|i, _| step.end[i].re);
    // Those that are not accurate yet, with their places.
    let (mut open, mut places, mut count) = ([vectors[0]; W], [0; W], 0);
    for (l, one) in vectors.iter_mut().enumerate().take(W) {
        let start = one.vector;
        let of = |numbers: &[Duals<W>; N]| State::from_fn(|i, _| numbers[i].eps[l]);
        let carried = TangentVector {
            x: end,
            vector: of(&step.end),
        };
        // A vector whose norm underflows is zero: no step would be accurate for it.
        let size = start.norm();
        if size == 0.0 {
            one.x = end;
            one.vector = State::from([0.0; N]);
            continue;
        }
        let is_accurate = || {
            let allowed = Tolerance {
                rtol: 0.0,
                atol: [pieces.tolerance * size; N],
            };
            let of_vector = step.estimates.as_ref().map(|estimates| Estimates {
                fifth: of(&estimates.fifth),
                third: of(&estimates.third),
            });
            let ends = [&start, &carried.vector];
            let error = squared_error_of(of_vector.as_ref(), ends, h, (&allowed, pieces.states));
            // NaN where the piece is so long that its stages overflow.
            error <= TANGENT_ERROR * TANGENT_ERROR
        };
        if halvings == 0 || !size.is_finite() || is_accurate() {
            *one = carried;
        } else {
            (open[count], places[count]) = (*one, l);
            count += 1;
        }
    }
    if count == 0 {
        return;
    }
    let half = 0.5 * h;
    let open = &mut open[..count];
    advance::<M, N, W>(field, pieces, (t, half), open, halvings - 1);
    // Vectors that took other pieces stand at other states, to rounding.
    for group in open.chunk_by_mut(|one, other| one.x == other.x) {
        advance::<M, N, W>(field, pieces, (t + half, half), group, halvings - 1);
    }
    for (one, place) in open.iter().zip(places) {
        vectors[place] = *one;
    }
}

/// A step on dual numbers, in place: vectors of them are too long to be passed around. Of the state
/// only the first components move; the others and their derivatives are constant.
struct DualStep<const N: usize, const W: usize> {
    end: [Duals<W>; N],
    estimates: Option<Estimates<[Duals<W>; N]>>,
}

impl<const N: usize, const W: usize> DualStep<N, W> {
    /// The step of [`crate::ode::stages`] from `t` of length `h`.
    #[inline(always)]
    fn take<M: RungeKutta>(
        field: &mut SeededField<'_, N, W>,
        (t, h): (f64, f64),
        start: &[Duals<W>; N],
        moving: usize,
    ) -> Self {
        let moving = moving.min(N);
        let mut slopes = [[Duals::constant(0.0); N]; MAX_STAGES];
        let mut at = *start;
        slopes[0] = field(t, start);
        macro_rules! stage {
            ($number:literal) => {
                if $number < M::COEFFICIENTS.stages {
                    let weights = &M::COEFFICIENTS.a[$number];
                    for i in 0..moving {
                        at[i] = start[i];
                        for j in 0..$number {
                            if weights[j] != 0.0 {
                                at[i].add_scaled(h * weights[j], &slopes[j][i]);
                            }
                        }
                    }
                    slopes[$number] = field(t + h * M::COEFFICIENTS.c[$number], &at);
                }
            };
        }
        for_each_stage!(stage);
        let weigh = |weights: &[f64; MAX_STAGES], i: usize| {
            let mut sum = Duals::constant(0.0);
            for j in 0..MAX_STAGES {
                if weights[j] != 0.0 {
                    sum.add_scaled(weights[j], &slopes[j][i]);
                }
            }
            sum
        };
        let mut step = DualStep {
            end: *start,
            estimates: None,
        };
        let Some(embedded) = &M::EMBEDDED else {
            for i in 0..moving {
                step.end[i].add_scaled(h, &weigh(&M::COEFFICIENTS.b, i));
            }
            return step;
        };
        let (mut fifth, mut third) = ([Duals::constant(0.0); N], [Duals::constant(0.0); N]);
        for i in 0..moving {
            let eighth = weigh(&M::COEFFICIENTS.b, i);
            step.end[i].add_scaled(h, &eighth);
            fifth[i] = weigh(&embedded.e5, i);
            third[i] = eighth;
            third[i].add_scaled(-1.0, &weigh(&embedded.third_order, i));
        }
        step.estimates = Some(Estimates { fifth, third });
        step
    }
}
