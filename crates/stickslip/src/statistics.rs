//! Power laws and random numbers, for the library and its users.

use crate::math;

/// A straight line through points whose coordinates are both positive, in logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// The exponent: the slope by least squares.
    pub exponent: f64,
    /// Standard error of the exponent from the points' distances; not a number for two points.
    pub std_error: f64,
}

impl PowerLaw {
    /// Through points `(x, y)`; those with a `y` that is not positive are left out.
    ///
    /// ```
    /// use stickslip::statistics::PowerLaw;
    ///
    /// let errors = [(0.1, 3e-4), (0.05, 3e-4 / 16.0), (0.025, 3e-4 / 256.0)];
    /// assert!((PowerLaw::through(errors).exponent - 4.0).abs() < 1e-12);
    /// ```
    pub fn through(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let logs: Vec<(f64, f64)> = points
            .into_iter()
            .filter(|point| point.1 > 0.0)
            .map(|(x, y)| (math::ln(x), math::ln(y)))
            .collect();
        let n = logs.len() as f64;
        let (x, y) = (
            logs.iter().map(|p| p.0).sum::<f64>() / n,
            logs.iter().map(|p| p.1).sum::<f64>() / n,
        );
        let above: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        let below: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
        let exponent = above / below;
        let residual = |p: &(f64, f64)| p.1 - y - exponent * (p.0 - x);
        let squares: f64 = logs.iter().map(|p| residual(p) * residual(p)).sum();
        let std_error = (squares / (n - 2.0) / below).sqrt();
        PowerLaw {
            exponent,
            std_error,
        }
    }
}

/// Random numbers from a seed, the same on every machine: `SplitMix64` (Steele, Lea & Flood, 2014).
#[derive(Clone, Debug)]
pub struct SplitMix(u64);

/// Increment of the generator's state from one number to the next: 2⁶⁴ over the golden ratio.
const GOLDEN_GAMMA: u64 = 0x9E37_79B9_7F4A_7C15;

impl SplitMix {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        SplitMix(seed)
    }

    /// The sequence of a seed from number `index` on, counted from 0.
    pub fn from_index(seed: u64, index: u64) -> Self {
        SplitMix(seed.wrapping_add(index.wrapping_mul(GOLDEN_GAMMA)))
    }

    /// The next number, in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(GOLDEN_GAMMA);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        // The upper 53 bits, which a double holds.
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next number, in [`low`, `high`).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_with_scatter_has_the_textbook_s_error() {
        // Slope 2 through e³ with residuals 0.1, -0.2, 0.1 at -1, 0, 1: √(0.06/1/2).
        let e = std::f64::consts::E;
        let points = [(-1.0, 0.1), (0.0, -0.2), (1.0, 0.1)]
            .map(|(x, off)| (math::pow(e, x), math::exp(3.0 + 2.0 * x + off)));
        let law = PowerLaw::through(points.into_iter().chain([(1.0, 0.0)]));
        assert!((law.exponent - 2.0).abs() < 1e-14);
        assert!((law.std_error - 0.03f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn the_generator_is_the_published_one() {
        // The first two outputs of the reference implementation for the seed 1234567, their upper
        // 53 bits.
        let mut generator = SplitMix::new(1_234_567);
        for wanted in [6_457_827_717_110_365_317_u64, 3_203_168_211_198_807_973] {
            assert_eq!(
                generator.uniform(),
                (wanted >> 11) as f64 / (1u64 << 53) as f64
            );
        }
    }
}
