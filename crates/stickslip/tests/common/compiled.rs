//! Systems for tests of the solver that is compiled for systems from files. They are recorded as
//! formulas, so that the solver is not compiled for each of them.

use stickslip::dynamics::DynamicsRef;
use stickslip::{Error, Filippov, Scalar, Side};
use stickslip_model::kernel::{Equations, Size, Switching, TapedFilippov, dynamics};
use stickslip_model::trace::trace;

/// A system in a form for which the solver is compiled: its formulas or, if it branches on values,
/// a type of its own.
pub trait Compiled<const N: usize>: Filippov<N> {
    type Any<'a>: Filippov<N> + Send + Sync
    where
        Self: 'a;
    /// The system for functions that take a typed system.
    fn any(&self) -> Self::Any<'_>;
    /// The system for the analyses.
    fn dynamics(&self) -> DynamicsRef<'_>;
}

/// A system of `N` states as formulas.
#[derive(Clone)]
pub struct Traced<const N: usize> {
    formulas: TapedFilippov,
    allowed: Result<(), Error>,
}

/// A system at rest.
struct AtRest;

impl<const N: usize> Filippov<N> for AtRest {
    fn field<T: Scalar>(&self, _side: Side, _t: T, _x: &[T; N]) -> [T; N] {
        [T::zero(); N]
    }
    fn boundary<T: Scalar>(&self, _t: T, _x: &[T; N]) -> T {
        T::one()
    }
}

impl<const N: usize> Traced<N> {
    pub fn of<S: Filippov<N>>(system: &S) -> Self {
        let allowed = system.check_parameters();
        let formulas = match allowed {
            Ok(()) => trace(system),
            // The values may be NaN; no run starts with them.
            Err(_) => trace::<_, N>(&AtRest),
        };
        Traced {
            formulas: formulas.expect("a system that does not branch on values"),
            allowed,
        }
    }

    pub fn dynamics(self) -> DynamicsRef<'static> {
        let equations = Equations::OneContact(Box::new(self.formulas));
        let size = Size {
            states: N,
            contacts: 1,
        };
        dynamics(equations, Vec::new(), Switching::none(N), size, None).expect("few states")
    }
}

impl<const N: usize> Filippov<N> for Traced<N> {
    const INTERPRETED: bool = true;

    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.formulas.field(side, t, x)
    }
    #[inline(always)]
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.formulas.holding(side, t, x)
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        self.formulas.boundary(t, x)
    }
    #[inline(always)]
    fn contact<T: Scalar>(&self, t: T, x: &[T; N]) -> Option<T> {
        self.formulas.contact(t, x)
    }
    fn check_parameters(&self) -> Result<(), Error> {
        self.allowed.clone()
    }
}

/// `traced!(n: Type, …)`: systems of `n` states that do not branch on values.
macro_rules! traced {
    ($n:literal: $($system:ty),* $(,)?) => {
        $(impl $crate::compiled::Compiled<$n> for $system {
            type Any<'a> = $crate::compiled::Traced<$n>;
            fn any(&self) -> Self::Any<'_> {
                $crate::compiled::Traced::of(self)
            }
            fn dynamics(&self) -> stickslip::dynamics::DynamicsRef<'_> {
                self.any().dynamics()
            }
        })*
    };
}

pub(crate) use traced;
