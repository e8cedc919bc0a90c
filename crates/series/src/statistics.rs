//! Medians, a power law, and random numbers with the same bits on every machine.

/// The two middle values, equal for an odd number of values; `None` without values. NaN is skipped.
pub fn middle_two(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    let mut values: Vec<f64> = values.into_iter().filter(|v| !v.is_nan()).collect();
    values.sort_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    Some([values[(values.len() - 1) / 2], upper])
}

/// The median (the upper of the middle two), without NaN; NaN if there are no values.
pub(crate) fn upper_median(values: impl IntoIterator<Item = f64>) -> f64 {
    middle_two(values).map_or(f64::NAN, |[_, upper]| upper)
}

/// Indices of the values in ascending order of value, equal ones by index.
pub(crate) fn order(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
    order
}

/// The exponent of a power law of `y` over `x`: the slope of the line of least squares through the
/// logarithms of positive numbers.
pub(crate) fn power(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let logs: Vec<(f64, f64)> = points.map(|(x, y)| (libm::log(x), libm::log(y))).collect();
    let n = logs.len() as f64;
    let x = logs.iter().map(|p| p.0).sum::<f64>() / n;
    let y = logs.iter().map(|p| p.1).sum::<f64>() / n;
    let above: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let below: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    above / below
}

/// Random numbers from a seed: `SplitMix64` (Steele, Lea & Flood, 2014).
pub(crate) struct SplitMix(u64);

impl SplitMix {
    /// The sequence of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        SplitMix(seed)
    }

    /// The next number, in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        // The upper 53 bits, which a double holds.
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next number, in [`low`, `high`).
    #[cfg(test)]
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_even_and_odd_counts() {
        assert_eq!(middle_two([]), None);
        assert_eq!(middle_two([f64::NAN]), None);
        assert_eq!(middle_two([3.0]), Some([3.0, 3.0]));
        assert_eq!(middle_two([5.0, 1.0, 2.0]), Some([2.0, 2.0]));
        assert_eq!(middle_two([9.0, 1.0, f64::NAN, 5.0, 2.0]), Some([2.0, 5.0]));
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
