//! Quantiles, a test of residuals, and starts that fill a box.

use std::f64::consts::PI;

use numerics::SplitMix;
use stickslip::math;

/// Fewest residuals of each sign for the normal approximation of the test of runs (Siegel,
/// *Nonparametric Statistics*, 1956, asks for 20 in all).
const FEWEST_SIGNS: usize = 10;

/// Fewest values of a phase that are tested. Chosen: fewer say more of their noise than of it.
pub(super) const FEWEST_IN_PHASE: usize = 3;

/// Chance at which a test of residuals reports more than noise.
pub(super) const FALSE_ALARMS: f64 = 0.01;

/// Test of the order of the signs of residuals (Wald and Wolfowitz, *Ann. Math. Stat.* 11 (1940)
/// 147). Noise that is independent from value to value gives all orders the same chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunsTest {
    /// Number of runs of one sign.
    pub runs: usize,
    /// Number expected of independent noise.
    pub expected: f64,
    /// Chance of a number at least as far off.
    pub p_value: f64,
}

impl RunsTest {
    /// Whether the residuals have a systematic part, with 1 % of false alarms.
    pub fn is_systematic(&self) -> bool {
        self.p_value < FALSE_ALARMS
    }
}

/// The test of runs; none for too few residuals. NaN is a missing one.
pub(super) fn runs_test(residuals: &[f64]) -> Option<RunsTest> {
    let signs = residuals.iter().filter(|r| **r != 0.0 && !r.is_nan());
    let signs: Vec<bool> = signs.map(|r| *r > 0.0).collect();
    let above = signs.iter().filter(|sign| **sign).count();
    let below = signs.len() - above;
    if signs.len() < 2 * FEWEST_SIGNS {
        return None;
    }
    let runs = 1 + signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let (a, b, n) = (above as f64, below as f64, signs.len() as f64);
    let expected = 2.0 * a * b / n + 1.0;
    let variance = (expected - 1.0) * (expected - 2.0) / (n - 1.0);
    let p_value = match above.min(below) {
        // The order says little; that so few of a coin's sides are one says enough.
        few if few < FEWEST_SIGNS / 2 => math::erfc((0.5 * n - few as f64) / (0.5 * n).sqrt()),
        _ => math::erfc((runs as f64 - expected).abs() / (2.0 * variance).sqrt()),
    };
    Some(RunsTest {
        runs,
        expected,
        p_value,
    })
}

/// Chance that so many squares of normal deviates have a larger sum (Wilson and Hilferty, *Proc.
/// Natl. Acad. Sci.* 17 (1931) 684).
pub(super) fn above_squares(sum: f64, count: usize) -> f64 {
    let part = 2.0 / (9.0 * count as f64);
    let root = math::pow(sum / count as f64, 1.0 / 3.0);
    0.5 * math::erfc((root - 1.0 + part) / (2.0 * part).sqrt())
}

/// A normal deviate (Box and Muller, *Ann. Math. Stat.* 29 (1958) 610).
pub(super) fn normal_deviate(random: &mut SplitMix) -> f64 {
    let size = (-2.0 * math::ln(1.0 - random.uniform())).sqrt();
    size * math::cos(2.0 * PI * random.uniform())
}

/// The quantile 0.975 of Student's distribution (Abramowitz and Stegun 26.7.5; below 1e-3 from
/// four degrees of freedom on), or of the normal one without degrees.
pub(super) fn quantile(freedom: Option<usize>) -> f64 {
    const Z: f64 = 1.959_963_984_540_054;
    // The expansion is of no use below.
    const SMALL: [f64; 3] = [12.706_204_7, 4.302_652_7, 3.182_446_3];
    let Some(freedom) = freedom else {
        return Z;
    };
    if let Some(value) = freedom.checked_sub(1).and_then(|k| SMALL.get(k)) {
        return *value;
    }
    let n = freedom.max(1) as f64;
    let z2 = Z * Z;
    let g1 = Z * (z2 + 1.0) / 4.0;
    let g2 = Z * ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    let g3 = Z * (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
    let g4 = Z * ((((79.0 * z2 + 776.0) * z2 + 1482.0) * z2 - 1920.0) * z2 - 945.0) / 92160.0;
    Z + (g1 + (g2 + (g3 + g4 / n) / n) / n) / n
}

/// Standard deviation of values, or 1 where they are all the same.
pub(super) fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|value| (value - mean) * (value - mean)).sum();
    match (squares / count).sqrt() {
        spread if spread > 0.0 && spread.is_finite() => spread,
        _ => 1.0,
    }
}

/// Number `k` of the sequence of van der Corput for a dimension: parts of Halton's points (*Numer.
/// Math.* 2 (1960) 84).
pub(super) fn halton(k: usize, dimension: usize) -> f64 {
    const PRIMES: [usize; 24] = [
        2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89,
    ];
    let base = PRIMES[dimension % PRIMES.len()];
    let (mut rest, mut part, mut value) = (k, 1.0, 0.0);
    while rest > 0 {
        part /= base as f64;
        value += part * (rest % base) as f64;
        rest /= base;
    }
    value
}
