//! Elementary functions with the same bits on every platform.
//!
//! `+ - * /` and `sqrt` are exact to the last bit by IEEE 754, and rustc never contracts them. The
//! standard library's `sin`, `exp`, … call the C library of the platform. This project calls the
//! functions below instead; the lint `disallowed-methods` bans the others.

use std::cell::Cell;

use nalgebra::{Complex, DMatrix, Dyn, Matrix, Storage};

/// An argument with its sine and cosine.
#[derive(Clone, Copy)]
struct Angle {
    x: f64,
    sine: f64,
    cosine: f64,
}

thread_local! {
    // A forcing or a moving boundary is evaluated many times in a row at one time: ten times at an
    // event.
    static LAST: Cell<Angle> = const {
        Cell::new(Angle {
            x: 0.0,
            sine: 0.0,
            cosine: 1.0,
        })
    };
}

/// Sine of `x` in radians.
#[inline]
pub fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

/// Cosine of `x` in radians.
#[inline]
pub fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

/// Sine and cosine of `x` in radians, in little more time than one of them. The last ones are
/// stored.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    let last = LAST.get();
    // The two zeros have different sines.
    if last.x == x && x != 0.0 {
        (last.sine, last.cosine)
    } else {
        computed(x)
    }
}

#[inline(never)]
fn computed(x: f64) -> (f64, f64) {
    let (sine, cosine) = libm::sincos(x);
    LAST.set(Angle { x, sine, cosine });
    (sine, cosine)
}

/// Tangent of `x` in radians.
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Arc tangent in `(-π/2, π/2)`.
pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// Arc cosine in `[0, π]`; NaN outside `[-1, 1]`.
pub fn acos(x: f64) -> f64 {
    libm::acos(x)
}

/// Angle of the point `(x, y)` in `(-π, π]`.
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Hyperbolic sine.
pub fn sinh(x: f64) -> f64 {
    libm::sinh(x)
}

/// Hyperbolic tangent.
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

/// The error function, `2/√π ∫ exp(−t²) dt` from 0 to `x`.
pub fn erf(x: f64) -> f64 {
    libm::erf(x)
}

/// Slope of the error function at 0.
pub(crate) const ERF_SLOPE: f64 = std::f64::consts::FRAC_2_SQRT_PI;

/// The complement of the error function, `2/√π ∫ exp(−t²) dt` from `x` on.
pub fn erfc(x: f64) -> f64 {
    libm::erfc(x)
}

/// `e^x`.
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm.
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Decimal logarithm.
pub fn log10(x: f64) -> f64 {
    libm::log10(x)
}

/// `x^y` for real `y`.
pub fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// `√(x² + y²)` without overflow.
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// Product of two matrices of run-time size. The operator `*` gives those of more than five rows
/// and columns to code that chooses its instructions, and with them bits, by the processor.
///
/// # Panics
/// If the first has not as many columns as the second has rows, as with the operator.
pub fn product<S, T>(a: &Matrix<f64, Dyn, Dyn, S>, b: &Matrix<f64, Dyn, Dyn, T>) -> DMatrix<f64>
where
    S: Storage<f64, Dyn, Dyn>,
    T: Storage<f64, Dyn, Dyn>,
{
    let mut product = DMatrix::zeros(a.nrows(), b.ncols());
    for (mut column, of) in product.column_iter_mut().zip(b.column_iter()) {
        column.gemv(1.0, a, &of, 0.0);
    }
    product
}

/// `|z|`. The method `norm` of a complex number calls the C library of the platform.
pub fn modulus(z: Complex<f64>) -> f64 {
    hypot(z.re, z.im)
}

/// `x^n` by repeated squaring: only multiplications (and one division for `n < 0`), in a fixed
/// order.
pub fn powi(x: f64, n: i32) -> f64 {
    let mut base = x;
    let mut left = n.unsigned_abs();
    let mut product = 1.0;
    while left > 0 {
        if left & 1 == 1 {
            product *= base;
        }
        base *= base;
        left >>= 1;
    }
    if n < 0 { 1.0 / product } else { product }
}

/// Hyperbolic cosine.
pub fn cosh(x: f64) -> f64 {
    libm::cosh(x)
}

/// Inverse hyperbolic cosine in `[0, ∞)`; NaN below 1.
pub fn acosh(x: f64) -> f64 {
    libm::acosh(x)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use nalgebra::DMatrix;

    use super::product;

    #[test]
    fn sine_and_cosine_together_have_the_bits_of_each_alone() {
        let mut values = vec![0.0, -0.0, f64::NAN, f64::INFINITY, 1e22, -1e300, 5e-324];
        // Around the sizes at which an expansion, or a reduction, begins; and many others.
        for size in [super::powi(2.0, -27), super::powi(2.0, -26), FRAC_PI_4, 1.0] {
            for k in 0..2000 {
                let near = size * (0.5 + f64::from(k) / 1000.0);
                values.extend([near, -near, 40.0 * near]);
            }
        }
        for x in values {
            let alone = [libm::sin(x), libm::cos(x)].map(f64::to_bits);
            // Computed, and then remembered.
            for _ in 0..2 {
                let (sine, cosine) = super::sin_cos(x);
                assert_eq!([sine, cosine].map(f64::to_bits), alone, "{x:e}");
                let [sine, cosine] = [super::sin(x), super::cos(x)];
                assert_eq!([sine, cosine].map(f64::to_bits), alone, "{x:e}");
            }
            // Of another one nothing is remembered.
            let other = [super::sin(x + 1.0), super::cos(x + 1.0)];
            let alone = [libm::sin(x + 1.0), libm::cos(x + 1.0)];
            assert_eq!(other.map(f64::to_bits), alone.map(f64::to_bits), "{x:e}");
        }
    }

    /// Each entry of the product is a² − a² with a² rounded once. A product that multiplies and
    /// adds with one rounding, as newer processors may, leaves the rounding error of a².
    #[test]
    fn products_of_matrices_round_each_term_and_each_sum() {
        let a = 1.0 + super::powi(2.0, -30);
        for size in 2..=24 {
            for columns in [[0, size - 1], [size - 1, 0]] {
                let (mut left, mut right) =
                    (DMatrix::zeros(size, size), DMatrix::zeros(size, size));
                left.column_mut(columns[0]).fill(a);
                right.row_mut(columns[0]).fill(a);
                left.column_mut(columns[1]).fill(-a * a);
                right.row_mut(columns[1]).fill(1.0);
                let zeros = DMatrix::zeros(size, size);
                assert_eq!(product(&left, &right), zeros, "{size}, {columns:?}");
            }
        }
    }

    #[test]
    fn products_of_small_matrices_are_those_of_the_operator() {
        let mut random = numerics::SplitMix::new(3);
        for (rows, inner, columns) in [(1, 1, 1), (2, 3, 4), (5, 5, 5), (9, 4, 9), (3, 0, 2)] {
            let a = DMatrix::from_fn(rows, inner, |_, _| random.uniform());
            let b = DMatrix::from_fn(inner, columns, |_, _| random.uniform());
            assert_eq!(product(&a, &b), &a * &b);
            // A view has the entries of a larger matrix.
            let wider = a.clone().insert_column(0, 2.0);
            assert_eq!(product(&wider.columns(1, inner), &b), &a * &b);
        }
    }

    #[test]
    fn lengths_in_factorisations_are_of_these_functions() {
        let mut random = numerics::SplitMix::new(5);
        for _ in 0..10_000 {
            let [x, y] = [random.uniform(), random.uniform()];
            let of_matrices = nalgebra::ComplexField::hypot(x, y);
            assert_eq!(
                of_matrices.to_bits(),
                super::hypot(x, y).to_bits(),
                "{x} {y}"
            );
        }
    }
}
