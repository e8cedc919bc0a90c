//! Systems whose boundary is never reached.

use stickslip::{Filippov, Scalar, Side};

/// A smooth system: `boundary` is never reached.
pub struct Smooth<F>(pub F);

/// A field, generic over the scalar, which closures cannot be.
pub trait Field<const N: usize> {
    fn at<T: Scalar>(&self, x: &[T; N]) -> [T; N];
}

impl<F: Field<N>, const N: usize> Filippov<N> for Smooth<F> {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; N]) -> [T; N] {
        self.0.at(x)
    }
    fn boundary<T: Scalar>(&self, _t: T, _x: &[T; N]) -> T {
        T::constant(-1.0)
    }
}

/// Lorenz' system with his parameters.
pub struct Lorenz;
impl Field<3> for Lorenz {
    fn at<T: Scalar>(&self, x: &[T; 3]) -> [T; 3] {
        [
            (x[1] - x[0]) * 10.0,
            x[0] * (-x[2] + 28.0) - x[1],
            x[0] * x[1] - x[2] * (8.0 / 3.0),
        ]
    }
}
