//! The one vector operation that a Runge–Kutta step needs.

use crate::scalar::Scalar;
use crate::system::State;

/// A vector over the scalar `T` that a step can be taken in.
pub trait Linear<T: Scalar>: Copy {
    /// The zero vector.
    fn zero() -> Self;
    /// `self + factor · other`.
    fn add_scaled(self, factor: T, other: &Self) -> Self;
}

impl<T: Scalar, const N: usize> Linear<T> for State<T, N> {
    #[inline(always)]
    fn zero() -> Self {
        State::from([T::constant(0.0); N])
    }
    #[inline(always)]
    fn add_scaled(mut self, factor: T, other: &Self) -> Self {
        for i in 0..N {
            self[i] = self[i] + factor * other[i];
        }
        self
    }
}

/// Time and state together: the unknowns of the Hénon step, in which another variable is independent.
#[derive(Clone, Copy, Debug)]
pub struct Timed<T, const N: usize> {
    /// Time.
    pub t: T,
    /// State.
    pub x: State<T, N>,
}

impl<T: Scalar, const N: usize> Linear<T> for Timed<T, N> {
    #[inline(always)]
    fn zero() -> Self {
        Timed {
            t: T::constant(0.0),
            x: Linear::<T>::zero(),
        }
    }
    #[inline(always)]
    fn add_scaled(self, factor: T, other: &Self) -> Self {
        Timed {
            t: self.t + factor * other.t,
            x: self.x.add_scaled(factor, &other.x),
        }
    }
}
