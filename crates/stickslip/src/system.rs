//! The system that a user writes: a smooth field on either side of a discontinuity boundary.

use nalgebra::{DVector, SVector};

use crate::error::Error;
use crate::scalar::Scalar;

/// A state: `N` components, on the stack. It is a vector of nalgebra, and `[f64; N]` where a
/// function asks for one.
pub type State<const N: usize> = SVector<f64, N>;

/// The components of a state as an array, which the functions of a [`Filippov`] system take.
#[inline(always)]
pub(crate) fn components<const N: usize>(x: &State<N>) -> &[f64; N] {
    &x.data.0[0]
}

/// The components of a state of `N`: an array, a vector of fixed length, or one of run-time length
/// as the analyses return them. A vector of another length gives NaN components, which every run
/// rejects.
pub trait IntoState<const N: usize> {
    /// The state.
    fn into_state(self) -> State<N>;
}

impl<const N: usize> IntoState<N> for [f64; N] {
    fn into_state(self) -> State<N> {
        State::from(self)
    }
}

impl<const N: usize> IntoState<N> for State<N> {
    fn into_state(self) -> State<N> {
        self
    }
}

impl<const N: usize> IntoState<N> for &DVector<f64> {
    fn into_state(self) -> State<N> {
        match self.len() == N {
            true => State::from_column_slice(self.as_slice()),
            false => State::repeat(f64::NAN),
        }
    }
}

impl<const N: usize> IntoState<N> for DVector<f64> {
    fn into_state(self) -> State<N> {
        (&self).into_state()
    }
}

/// Side of the discontinuity boundary Σ = {h = 0}.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// h < 0: on a belt, the body slower than the belt.
    Below,
    /// h > 0: on a belt, the body faster than the belt.
    Above,
}

impl Side {
    /// The side across the boundary.
    pub fn opposite(self) -> Side {
        match self {
            Side::Below => Side::Above,
            Side::Above => Side::Below,
        }
    }

    /// Sign of the boundary function on this side: −1 below, +1 above.
    pub fn sign(self) -> f64 {
        match self {
            Side::Below => -1.0,
            Side::Above => 1.0,
        }
    }
}

/// The mode of the system: slip in one of the smooth fields, or stick to Σ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Motion through the smooth field of one side.
    Slip(Side),
    /// Sliding along Σ by Filippov's convex combination of the two fields: the body sticks to the
    /// belt.
    Stick,
}

/// A Filippov system of dimension `N`: two smooth fields and the boundary between them.
///
/// The two functions are all that is needed, written for any [`Scalar`]. The library runs them on
/// dual numbers. So it derives the sliding field, where sliding starts and ends, tangent points and
/// their visibility, Jacobians and saltation matrices.
///
/// Mark them `#[inline(always)]` to compile them into the solver's loops. With
/// [`crate::Method::Taylor`] that saves a third of the time.
///
/// A step that crosses Σ evaluates `field` a little beyond it, before the crossing is located. So
/// the formula of each side should extend smoothly across Σ: write friction by `side`, not by the
/// sign of a velocity.
///
/// ```
/// use stickslip::{Filippov, Scalar, Side};
///
/// /// x'' = -x - 0.4 sgn x': a block on a floor.
/// struct Block;
/// impl Filippov<2> for Block {
///     #[inline(always)]
///     fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
///         [x[1], -x[0] - 0.4 * side.sign()]
///     }
///     #[inline(always)]
///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
///         x[1]
///     }
/// }
/// ```
pub trait Filippov<const N: usize> {
    /// Whether the functions are interpreted, as those of a file: a call then takes longer than its
    /// arithmetic. [`crate::Method::Taylor`] calls interpreted functions once. It repeats their
    /// operations where the mode recurs and the comparisons have the same results. It calls
    /// compiled functions (the default) once for every order, which is faster for these. The orbits
    /// agree to rounding.
    const INTERPRETED: bool = false;

    /// The vector field of `side` at time `t` and state `x`: dx/dt.
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N];

    /// The boundary function h: negative on [`Side::Below`], positive on [`Side::Above`], zero on
    /// Σ. It may depend on time: Σ then moves. It must be defined along the whole orbit: a step at
    /// whose end it is NaN is shortened, until the run ends with an error.
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T;

    /// The field of `side` while the contact holds, for static friction above the kinetic friction
    /// of [`Filippov::field`]. Stick begins where both of these fields push to Σ and ends where one
    /// of them no longer does. The slip that follows leaves Σ across, by the field of slip. By
    /// default the friction of slip holds, and stick ends at a tangent point.
    ///
    /// ```
    /// use stickslip::{Filippov, Options, Scalar, Side, solve};
    ///
    /// /// A block on a belt of speed 0.2: friction 1 at rest, 0.6 in slip.
    /// struct Block;
    /// impl Block {
    ///     fn with<T: Scalar>(friction: f64, side: Side, x: &[T; 2]) -> [T; 2] {
    ///         [x[1], -x[0] - friction * side.sign()]
    ///     }
    /// }
    /// impl Filippov<2> for Block {
    ///     fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
    ///         Block::with(0.6, side, x)
    ///     }
    ///     fn holding<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
    ///         Block::with(1.0, side, x)
    ///     }
    ///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
    ///         x[1] - 0.2
    ///     }
    /// }
    /// let orbit = solve(&Block, 0.0, [0.0, 0.2], 20.0, &Options::default())?;
    /// // The belt carries it from 0 to 1, where static friction gives way.
    /// assert!((orbit.phases[0].duration() - 5.0).abs() < 1e-9);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    #[inline(always)]
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.field(side, t, x)
    }

    /// A function whose sign is that of the normal force (in any unit), for systems that can lose
    /// contact. Its zeros are located like all events, so that no step crosses the kink of a field
    /// that is clipped there. They are recorded as [`crate::TransitionKind::ContactLoss`] and
    /// [`crate::TransitionKind::ContactGain`]. The default, `None`, never loses contact.
    #[inline(always)]
    fn contact<T: Scalar>(&self, _t: T, _x: &[T; N]) -> Option<T> {
        None
    }

    /// Number of components of the state that move: the first ones. Those beyond have the rate
    /// zero, as parameters, and are exact: they enter no error, so that an orbit has the bits of
    /// the same orbit with constants in their place.
    #[inline(always)]
    fn dimension(&self) -> usize {
        N
    }

    /// Period of the drive, where it depends on components that do not move; it uses no others.
    /// Branches of forced orbits follow it.
    #[inline(always)]
    fn period<T: Scalar>(&self, _x: &[T; N]) -> Option<T> {
        None
    }

    /// Checks the parameters, once before every run: a negative mass gives a message and not an
    /// orbit. The default allows everything.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first parameter that is not allowed.
    fn check_parameters(&self) -> Result<(), Error> {
        Ok(())
    }

    /// The system, if its parameters are allowed.
    ///
    /// # Errors
    /// As [`Filippov::check_parameters`].
    fn checked(self) -> Result<Self, Error>
    where
        Self: Sized,
    {
        self.check_parameters().map(|()| self)
    }
}

impl<const N: usize, S: Filippov<N>> Filippov<N> for &S {
    const INTERPRETED: bool = S::INTERPRETED;

    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        (**self).field(side, t, x)
    }
    #[inline(always)]
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        (**self).holding(side, t, x)
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        (**self).boundary(t, x)
    }
    #[inline(always)]
    fn contact<T: Scalar>(&self, t: T, x: &[T; N]) -> Option<T> {
        (**self).contact(t, x)
    }
    #[inline(always)]
    fn dimension(&self) -> usize {
        (**self).dimension()
    }
    fn period<T: Scalar>(&self, x: &[T; N]) -> Option<T> {
        (**self).period(x)
    }
    fn check_parameters(&self) -> Result<(), Error> {
        (**self).check_parameters()
    }
}
