//! Systems as one type for each number of states: the solver is compiled once for that type and not once for every system.

use stickslip::Filippov;

/// A system that is one of those below.
pub trait Listed<const N: usize>: Filippov<N> {
    type Any<'a>: Filippov<N> + Send + Sync
    where
        Self: 'a;
    fn any(&self) -> Self::Any<'_>;
}

/// `systems!(Name, n: Variant(Type), …)`: the type `Name` of the systems of `n` states.
macro_rules! systems {
    ($any:ident, $n:literal: $($name:ident($system:ty)),* $(,)?) => {
        pub enum $any<'a> {
            $($name(&'a $system)),*
        }

        impl Filippov<$n> for $any<'_> {
            #[inline(never)]
            fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; $n]) -> [T; $n] {
                match self {
                    $($any::$name(system) => system.field(side, t, x)),*
                }
            }
            #[inline(never)]
            fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; $n]) -> [T; $n] {
                match self {
                    $($any::$name(system) => system.holding(side, t, x)),*
                }
            }
            #[inline(never)]
            fn boundary<T: Scalar>(&self, t: T, x: &[T; $n]) -> T {
                match self {
                    $($any::$name(system) => system.boundary(t, x)),*
                }
            }
            #[inline(never)]
            fn contact<T: Scalar>(&self, t: T, x: &[T; $n]) -> Option<T> {
                match self {
                    $($any::$name(system) => system.contact(t, x)),*
                }
            }
            fn check_parameters(&self) -> Result<(), Error> {
                match self {
                    $($any::$name(system) => system.check_parameters()),*
                }
            }
        }

        $(impl Listed<$n> for $system {
            type Any<'a> = $any<'a>;
            fn any(&self) -> $any<'_> {
                $any::$name(self)
            }
        })*
    };
}

pub(crate) use systems;
