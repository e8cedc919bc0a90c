//! What num-dual asks of a number before dual numbers can be built over it.
//!
//! Only arithmetic is recorded here. The elementary functions reach a recording through [`Scalar`], as they do everywhere in
//! this crate; num-dual's own, which nothing calls, and remainders are not a number.

use std::cmp::Ordering;
use std::fmt;
use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Rem, RemAssign, Sub, SubAssign};

use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};

use super::recorder::Recorded;
use crate::scalar::Scalar;

fn unknown() -> Recorded {
    Recorded::constant(f64::NAN)
}

macro_rules! assigning {
    ($($assign:ident, $method:ident, $trait:ident, $plain:ident;)*) => {$(
        impl $assign for Recorded {
            fn $method(&mut self, other: Self) {
                *self = $trait::$plain(*self, other);
            }
        }
        impl $assign<f64> for Recorded {
            fn $method(&mut self, other: f64) {
                *self = $trait::$plain(*self, other);
            }
        }
        impl $trait<&Recorded> for Recorded {
            type Output = Self;
            fn $plain(self, other: &Self) -> Self {
                $trait::$plain(self, *other)
            }
        }
    )*};
}

assigning! {
    AddAssign, add_assign, Add, add;
    SubAssign, sub_assign, Sub, sub;
    MulAssign, mul_assign, Mul, mul;
    DivAssign, div_assign, Div, div;
    RemAssign, rem_assign, Rem, rem;
}

impl Rem for Recorded {
    type Output = Self;
    fn rem(self, _: Self) -> Self {
        unknown()
    }
}

impl Rem<f64> for Recorded {
    type Output = Self;
    fn rem(self, _: f64) -> Self {
        unknown()
    }
}

impl PartialEq for Recorded {
    fn eq(&self, other: &Self) -> bool {
        self.value() == other.value()
    }
}

impl PartialEq<f64> for Recorded {
    fn eq(&self, other: &f64) -> bool {
        self.value() == *other
    }
}

impl PartialOrd for Recorded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value().partial_cmp(&other.value())
    }
}

impl PartialOrd<f64> for Recorded {
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.value().partial_cmp(other)
    }
}

impl fmt::Display for Recorded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.peek())
    }
}

impl Zero for Recorded {
    fn zero() -> Self {
        Self::constant(0.0)
    }
    fn is_zero(&self) -> bool {
        self.value() == 0.0
    }
}

impl One for Recorded {
    fn one() -> Self {
        Self::constant(1.0)
    }
}

impl Num for Recorded {
    type FromStrRadixErr = num_traits::ParseFloatError;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self::constant)
    }
}

impl Signed for Recorded {
    fn abs(&self) -> Self {
        if self.is_negative() { -*self } else { *self }
    }
    fn abs_sub(&self, _: &Self) -> Self {
        unknown()
    }
    fn signum(&self) -> Self {
        Self::constant(self.value().signum())
    }
    fn is_positive(&self) -> bool {
        self.value() > 0.0
    }
    fn is_negative(&self) -> bool {
        self.value() < 0.0
    }
}

impl Inv for Recorded {
    type Output = Self;
    fn inv(self) -> Self {
        self.recip()
    }
}

impl Sum for Recorded {
    fn sum<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Self::zero(), |sum, x| sum + x)
    }
}

impl<'a> Sum<&'a Recorded> for Recorded {
    fn sum<I: Iterator<Item = &'a Self>>(numbers: I) -> Self {
        numbers.copied().sum()
    }
}

impl Product for Recorded {
    fn product<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Self::one(), |product, x| product * x)
    }
}

impl<'a> Product<&'a Recorded> for Recorded {
    fn product<I: Iterator<Item = &'a Self>>(numbers: I) -> Self {
        numbers.copied().product()
    }
}

impl FromPrimitive for Recorded {
    fn from_i64(n: i64) -> Option<Self> {
        f64::from_i64(n).map(Self::constant)
    }
    fn from_u64(n: u64) -> Option<Self> {
        f64::from_u64(n).map(Self::constant)
    }
    fn from_f64(n: f64) -> Option<Self> {
        Some(Self::constant(n))
    }
}

impl From<f64> for Recorded {
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl DualStruct for Recorded {
    type Real = f64;
    type Inner = f64;
    fn re(&self) -> f64 {
        self.value()
    }
    fn from_inner(inner: &f64) -> Self {
        Self::constant(*inner)
    }
}

impl Mappable<Recorded> for Recorded {
    type Output<O> = O;
    fn map_dual<M: Fn(Recorded) -> O, O>(self, f: M) -> O {
        f(self)
    }
}

macro_rules! unrecorded {
    ($($function:ident),*) => {$(
        fn $function(&self) -> Self {
            unknown()
        }
    )*};
}

impl DualNum for Recorded {
    type Primitive = f64;
    const NDERIV: usize = 0;
    type InnerDual = f64;

    fn from_re(re: f64) -> Self {
        Self::constant(re)
    }
    fn scale(self, factor: &f64) -> Self {
        self * *factor
    }
    fn recip(&self) -> Self {
        Self::one() / *self
    }
    fn powi(&self, n: i32) -> Self {
        Scalar::powi(*self, n)
    }
    fn sqrt(&self) -> Self {
        Scalar::sqrt(*self)
    }
    fn exp(&self) -> Self {
        Scalar::exp(*self)
    }
    fn ln(&self) -> Self {
        Scalar::ln(*self)
    }
    fn sin(&self) -> Self {
        Scalar::sin(*self)
    }
    fn cos(&self) -> Self {
        Scalar::cos(*self)
    }
    fn sin_cos(&self) -> (Self, Self) {
        (Scalar::sin(*self), Scalar::cos(*self))
    }
    fn powf(&self, _: f64) -> Self {
        unknown()
    }
    fn log(&self, _: f64) -> Self {
        unknown()
    }
    fn atan2(&self, _: Self) -> Self {
        unknown()
    }
    unrecorded!(
        cbrt, exp2, exp_m1, log2, log10, ln_1p, tan, asin, acos, atan, sinh, cosh, tanh, asinh,
        acosh, atanh, sph_j0, sph_j1, sph_j2
    );
}
