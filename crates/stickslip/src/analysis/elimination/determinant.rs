//! Determinants of any size.

/// A determinant, as a number times a power of 2: of many rows, it may exceed the range of numbers.
#[derive(Clone, Copy, Debug)]
pub(in crate::analysis) struct Determinant {
    /// Absolute value between 1 and 2, or 0.
    mantissa: f64,
    /// The power of 2.
    pub exponent: i32,
}

impl Determinant {
    pub(super) const ZERO: Determinant = Determinant {
        mantissa: 0.0,
        exponent: 0,
    };

    pub(super) fn of(value: f64) -> Self {
        Determinant {
            mantissa: 1.0,
            exponent: 0,
        }
        .times(value)
    }

    /// The product with a number. One below the normal numbers counts as zero, and one that is not
    /// finite makes the product not a number.
    pub(super) fn times(self, factor: f64) -> Self {
        // Bits of the fraction, and the exponent of 1 in the bits.
        const FRACTION: u32 = 52;
        const EXPONENT_OF_ONE: i32 = 1023;
        let product = self.mantissa * factor;
        if !product.is_finite() {
            return Determinant {
                mantissa: f64::NAN,
                exponent: 0,
            };
        }
        if !product.is_normal() {
            return Determinant::ZERO;
        }
        let exponent = ((product.abs().to_bits() >> FRACTION) as i32) - EXPONENT_OF_ONE;
        Determinant {
            mantissa: product * power_of_two(-exponent),
            exponent: self.exponent.saturating_add(exponent),
        }
    }

    pub fn negated(self) -> Self {
        Determinant {
            mantissa: -self.mantissa,
            ..self
        }
    }

    /// The value over a power of 2.
    pub fn over_power(&self, exponent: i32) -> f64 {
        self.mantissa * power_of_two(self.exponent.saturating_sub(exponent))
    }
}

/// A power of 2 or, beyond the range of normal numbers, the nearest one in it.
fn power_of_two(exponent: i32) -> f64 {
    let bounded = exponent.clamp(-1022, 1023);
    f64::from_bits(((bounded + 1023) as u64) << 52)
}
