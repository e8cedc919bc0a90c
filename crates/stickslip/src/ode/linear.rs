//! The vector operation of a Runge–Kutta step.

use crate::scalar::Scalar;
use crate::system::State;

/// A vector over the scalar `T` for Runge–Kutta steps.
pub trait Linear<T: Scalar>: Copy {
    /// The zero vector.
    fn zero() -> Self;
    /// `self + factor · other`.
    fn add_scaled(self, factor: T, other: &Self) -> Self;
}

impl<T: Scalar, const N: usize> Linear<T> for [T; N] {
    #[inline(always)]
    fn zero() -> Self {
        [T::constant(0.0); N]
    }
    #[inline(always)]
    fn add_scaled(mut self, factor: T, other: &Self) -> Self {
        for i in 0..N {
            self[i] = self[i] + factor * other[i];
        }
        self
    }
}

impl Linear<f64> for f64 {
    #[inline(always)]
    fn zero() -> Self {
        0.0
    }
    #[inline(always)]
    fn add_scaled(self, factor: f64, other: &Self) -> Self {
        self + factor * other
    }
}

impl<const N: usize> Linear<f64> for State<N> {
    #[inline(always)]
    fn zero() -> Self {
        State::from([0.0; N])
    }
    #[inline(always)]
    fn add_scaled(mut self, factor: f64, other: &Self) -> Self {
        for i in 0..N {
            self[i] += factor * other[i];
        }
        self
    }
}

/// Time and state together: the unknowns of the Hénon step, whose independent variable is another
/// one.
#[derive(Clone, Copy, Debug)]
pub struct Timed<const N: usize> {
    /// Time.
    pub t: f64,
    /// State.
    pub x: State<N>,
}

impl<const N: usize> Linear<f64> for Timed<N> {
    #[inline(always)]
    fn zero() -> Self {
        Timed {
            t: 0.0,
            x: State::zero(),
        }
    }
    #[inline(always)]
    fn add_scaled(self, factor: f64, other: &Self) -> Self {
        Timed {
            t: self.t + factor * other.t,
            x: self.x.add_scaled(factor, &other.x),
        }
    }
}
