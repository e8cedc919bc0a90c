//! Families of systems, which are functions of constants.

use crate::dynamics::{DynamicsRef, Typed};
use crate::error::Error;
use crate::scalar::Scalar;
use crate::system::{Filippov, Side};

/// A family of [`Filippov`] systems with `N` states: functions of `C` constants, such as a speed or
/// the frequency of a drive.
///
/// [`Family::at`] is the system with values of the constants, for runs and all analyses.
/// [`Member::free`] is the same system with some constants free, for branches along them, and for
/// derivatives by them. Orbits have the same bits in both.
///
/// ```
/// use stickslip::analysis::{ContinuationSettings, continue_periodic_orbit};
/// use stickslip::{Family, Options, Scalar, Side, run};
///
/// /// A block on a belt, with a spring: friction falls with the slip speed.
/// struct Belt;
/// impl Family<2, 1> for Belt {
///     fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2], [speed]: &[T; 1]) -> [T; 2] {
///         let slip = (x[1] - *speed) * side.sign();
///         [x[1], -x[0] - (slip + 1.0).recip() * side.sign()]
///     }
///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2], [speed]: &[T; 1]) -> T {
///         x[1] - *speed
///     }
/// }
///
/// let (belt, options) = (Belt.at([0.3]), Options::tol(1e-10));
/// let end = run(&belt, 0.0, [0.0, 0.3], 50.0, &options, &mut ())?.x;
/// // The branch of its cycle along the speed, which follows the states.
/// let (along, settings) = (belt.free([0])?, ContinuationSettings::over(0.2, 0.4));
/// let start = [end[0], end[1], 0.3];
/// let branch = continue_periodic_orbit(&along, start, 8.5, true, &settings, &options)?;
/// assert!((branch.points.last().unwrap().parameter - 0.4).abs() < 1e-12);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub trait Family<const N: usize, const C: usize> {
    /// The field of a side, as [`Filippov::field`], with the constants `c`.
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N], c: &[T; C]) -> [T; N];

    /// The boundary function, as [`Filippov::boundary`].
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N], c: &[T; C]) -> T;

    /// The field of a side while the contact holds, as [`Filippov::holding`].
    #[inline(always)]
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; N], c: &[T; C]) -> [T; N] {
        self.field(side, t, x, c)
    }

    /// A function with the sign of the normal force, as [`Filippov::contact`].
    #[inline(always)]
    fn contact<T: Scalar>(&self, _t: T, _x: &[T; N], _c: &[T; C]) -> Option<T> {
        None
    }

    /// Period of the drive, where it depends on the constants. Branches of forced orbits follow it.
    #[inline(always)]
    fn period<T: Scalar>(&self, _c: &[T; C]) -> Option<T> {
        None
    }

    /// The system with these values of the constants.
    fn at(&self, c: [f64; C]) -> Member<'_, Self, C> {
        Member { family: self, c }
    }
}

/// A system of a [`Family`], with values of the constants.
#[derive(Debug)]
pub struct Member<'f, F: ?Sized, const C: usize> {
    family: &'f F,
    c: [f64; C],
}

impl<F: ?Sized, const C: usize> Clone for Member<'_, F, C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F: ?Sized, const C: usize> Copy for Member<'_, F, C> {}

impl<F: Family<N, C> + ?Sized, const N: usize, const C: usize> Filippov<N> for Member<'_, F, C> {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.family.field(side, t, x, &self.c.map(T::constant))
    }
    #[inline(always)]
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.family.holding(side, t, x, &self.c.map(T::constant))
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        self.family.boundary(t, x, &self.c.map(T::constant))
    }
    #[inline(always)]
    fn contact<T: Scalar>(&self, t: T, x: &[T; N]) -> Option<T> {
        self.family.contact(t, x, &self.c.map(T::constant))
    }
}

impl<'f, F: ?Sized, const C: usize> Member<'f, F, C> {
    /// The system with constants as last components of its state, in this order. They keep the
    /// values with which an orbit begins.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a number that is not below that of the constants, or occurs twice.
    pub fn free<const N: usize, const K: usize>(
        self,
        numbers: [usize; K],
    ) -> Result<DynamicsRef<'f>, Error>
    where
        F: Family<N, C> + Send + Sync,
        Sizes<N, K>: Together<N, K>,
    {
        let is_wrong = |k: &usize| numbers[*k] >= C || numbers[..*k].contains(&numbers[*k]);
        match (0..K).find(is_wrong) {
            Some(k) => Err(Error::Parameter {
                name: "the number of a free constant",
                value: numbers[k] as f64,
                bound: "below the number of constants, and named once",
            }),
            None => Ok(Sizes::dynamics(Freed { of: self, numbers })),
        }
    }
}

/// A system of which some constants follow the states.
pub struct Freed<'f, F: ?Sized, const N: usize, const C: usize, const K: usize> {
    of: Member<'f, F, C>,
    numbers: [usize; K],
}

impl<F: ?Sized, const N: usize, const C: usize, const K: usize> Freed<'_, F, N, C, K> {
    /// States and constants among the components of a state.
    #[inline(always)]
    fn parts<T: Scalar, const M: usize>(&self, x: &[T; M]) -> ([T; N], [T; C]) {
        let mut c = self.of.c.map(T::constant);
        for (k, &number) in self.numbers.iter().enumerate() {
            c[number] = x[N + k];
        }
        (std::array::from_fn(|i| x[i]), c)
    }

    /// Rates of all components.
    #[inline(always)]
    fn rates<T: Scalar, const M: usize>(rates: [T; N]) -> [T; M] {
        std::array::from_fn(|i| if i < N { rates[i] } else { T::zero() })
    }
}

impl<F, const N: usize, const C: usize, const K: usize, const M: usize> Filippov<M>
    for Freed<'_, F, N, C, K>
where
    F: Family<N, C> + ?Sized,
{
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; M]) -> [T; M] {
        let (x, c) = self.parts(x);
        Self::rates(self.of.family.field(side, t, &x, &c))
    }
    #[inline(always)]
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; M]) -> [T; M] {
        let (x, c) = self.parts(x);
        Self::rates(self.of.family.holding(side, t, &x, &c))
    }
    #[inline(always)]
    fn boundary<T: Scalar>(&self, t: T, x: &[T; M]) -> T {
        let (x, c) = self.parts(x);
        self.of.family.boundary(t, &x, &c)
    }
    #[inline(always)]
    fn contact<T: Scalar>(&self, t: T, x: &[T; M]) -> Option<T> {
        let (x, c) = self.parts(x);
        self.of.family.contact(t, &x, &c)
    }
    fn period<T: Scalar>(&self, x: &[T; M]) -> Option<T> {
        self.of.family.period(&self.parts(x).1)
    }
    #[inline(always)]
    fn dimension(&self) -> usize {
        N
    }
}

/// Numbers of states and of free constants.
pub struct Sizes<const N: usize, const K: usize>;

/// The solver for states and free constants together, whose number is one of its type.
#[diagnostic::on_unimplemented(
    message = "a family has at most 8 states, of which at most 3 constants are free",
    note = "implement `Filippov` with the constants as last states, and `Filippov::dimension`"
)]
pub trait Together<const N: usize, const K: usize> {
    /// The dynamics of a system.
    fn dynamics<'f, F, const C: usize>(system: Freed<'f, F, N, C, K>) -> DynamicsRef<'f>
    where
        F: Family<N, C> + Send + Sync + ?Sized;
}

fn owned<'f, S, const M: usize>(system: S) -> DynamicsRef<'f>
where
    S: Filippov<M> + Send + Sync + 'f,
{
    DynamicsRef::Owned(Box::new(Typed::<S, S, _, _, _, M, _>::new(system)))
}

macro_rules! together {
    ($($n:literal + $k:literal = $m:literal),*) => {$(
        impl Together<$n, $k> for Sizes<$n, $k> {
            fn dynamics<'f, F, const C: usize>(system: Freed<'f, F, $n, C, $k>) -> DynamicsRef<'f>
            where
                F: Family<$n, C> + Send + Sync + ?Sized,
            {
                owned::<_, $m>(system)
            }
        }
    )*};
}

together!(
    1 + 1 = 2,
    2 + 1 = 3,
    3 + 1 = 4,
    4 + 1 = 5,
    5 + 1 = 6,
    6 + 1 = 7,
    7 + 1 = 8,
    8 + 1 = 9,
    1 + 2 = 3,
    2 + 2 = 4,
    3 + 2 = 5,
    4 + 2 = 6,
    5 + 2 = 7,
    6 + 2 = 8,
    7 + 2 = 9,
    8 + 2 = 10,
    1 + 3 = 4,
    2 + 3 = 5,
    3 + 3 = 6,
    4 + 3 = 7,
    5 + 3 = 8,
    6 + 3 = 9,
    7 + 3 = 10,
    8 + 3 = 11
);
