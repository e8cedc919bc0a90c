//! Random numbers with the same bits on every machine.

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
