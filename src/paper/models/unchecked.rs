//! Systems with values that their own check rejects.

use stickslip::{Filippov, Scalar, Side};

/// A system whose parameters are not checked, for values that [`Filippov::check_parameters`]
/// rejects, such as friction of the other sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unchecked<S>(pub S);

impl<const N: usize, S: Filippov<N>> Filippov<N> for Unchecked<S> {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.0.field(side, t, x)
    }
    #[inline(always)]
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.0.holding(side, t, x)
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        self.0.boundary(t, x)
    }
    #[inline(always)]
    fn contact<T: Scalar>(&self, t: T, x: &[T; N]) -> Option<T> {
        self.0.contact(t, x)
    }
    #[inline(always)]
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
    fn period<T: Scalar>(&self, x: &[T; N]) -> Option<T> {
        self.0.period(x)
    }
}
