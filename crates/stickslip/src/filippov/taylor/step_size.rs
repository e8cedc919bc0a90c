//! How far a series reaches within the tolerance.

use super::TaylorStepper;
use crate::filippov::options::Options;
use crate::system::State;
use crate::taylor::MOST_ORDER;

/// Part of the tolerance that the last coefficients are held to: the steps are long and few, and all of the next ones enlarge
/// what one leaves out.
const SAFETY: f64 = 0.1;

/// Growth of the step from one to the next at most. The series of a polynomial solution ends and would allow any; but over a step that is too
/// long by this factor a guard that bends is known to rounding times its square, and no better are its grazes. One very near the start of
/// a very long step is badly resolved.
const GROW_MOST: f64 = 64.0;

/// Longest step in units of the radius of convergence as the terms' own ratio tells it: beyond it a series means nothing,
/// however small its terms.
const FARTHEST: f64 = 0.7;

/// One over an order.
#[inline(always)]
fn inverse(k: usize) -> f64 {
    const ALL: [f64; MOST_ORDER + 1] = {
        let mut all = [0.0; MOST_ORDER + 1];
        let mut k = 1;
        while k <= MOST_ORDER {
            all[k] = 1.0 / k as f64;
            k += 1;
        }
        all
    };
    ALL[k]
}

/// What the exponent in a number's bits is more than its own.
const BIAS: f64 = 1023.0;

/// Logarithm to base 2 of a normal positive number, up to 0.09 too small: good enough for a root of high order.
#[inline(always)]
fn rough_log2(x: f64) -> f64 {
    const MANTISSA: f64 = (1u64 << 52) as f64;
    // As a number with a sign, which is cheaper to convert; that of what is no number is the machine's.
    x.abs().to_bits() as i64 as f64 / MANTISSA - BIAS
}

/// `2^x` to three parts in a thousand: a step that is longer by that has an error larger by a twelfth. The inverse of [`rough_log2`] would make
/// it four times as large.
#[inline(always)]
fn rough_exp2(x: f64) -> f64 {
    let shifted = (x + BIAS).max(0.0);
    let power = shifted as i64;
    let rest = shifted - power as f64;
    f64::from_bits((power << 52) as u64) * (1.0 + rest * (0.66 + 0.34 * rest))
}

impl<const N: usize, const G: usize> TaylorStepper<N, G> {
    /// Step length within the tolerance, over that which the series is scaled with: where the last coefficients, extrapolated
    /// by the radius of convergence that they tell, have fallen to the tolerance (Jorba & Zou 2005, Sect. 3.2).
    pub(super) fn step_ratio(&self, options: &Options, x: &State<N>) -> f64 {
        let p = self.order;
        let relative = options.rtol.max(options.atol);
        let tolerance = rough_log2(SAFETY * relative);
        let wanted = tolerance * inverse(p);
        let farthest = rough_log2(FARTHEST);
        let mut log = rough_log2(GROW_MOST);
        for i in 0..N {
            let row = self.series.row(i);
            let at = |k: usize| row.lane(0, k).abs();
            let scale = rough_log2((options.atol + options.rtol * x[i].abs()) / relative);
            // Even or odd series have every other coefficient zero.
            let (mut early, mut late) = (0.0, 0.0);
            for k in p - 3..=p {
                let newest = at(k);
                early = f64::max(early, at(k - p / 2));
                late = f64::max(late, newest);
                if newest > 0.0 {
                    log = log.min((scale - rough_log2(newest)) * inverse(k) + wanted);
                }
            }
            if early > 0.0 && late > 0.0 {
                let ratio = rough_log2(early) - rough_log2(late);
                log = log.min(ratio * inverse(p / 2) + farthest);
            }
        }
        for function in self.expansion.watched.iter().flatten() {
            // What is linear in the state is as good as that.
            if function.is_linear {
                continue;
            }
            // What a guard's series leaves out, against how far the guard moves in the step: by any of its first three terms, unless it is
            // flatter than that.
            let row = self.series.row(function.row);
            let g = |k: usize| row.lane(0, k).abs();
            if (0..3).all(|k| g(k) == 0.0) {
                continue;
            }
            for k in p - 1..=p {
                if g(k) > 0.0 {
                    let against = |j| (tolerance + rough_log2(g(j) / g(k))) * inverse(k - j);
                    log = log.min(f64::max(against(0), against(1)).max(against(2)));
                }
            }
        }
        rough_exp2(log)
    }
}

#[cfg(test)]
mod tests {
    use super::{rough_exp2, rough_log2};
    use crate::math;

    #[test]
    fn rough_powers_and_logarithms_are_as_good_as_said() {
        for i in -4000..4000 {
            let x = f64::from(i) / 40.0;
            let exact = math::exp(x * std::f64::consts::LN_2);
            assert!((rough_exp2(x) / exact - 1.0).abs() < 3e-3, "{x}");
            let short = x - rough_log2(exact);
            assert!((-1e-12..0.09).contains(&short), "{x}: {short}");
        }
        assert_eq!(rough_exp2(-2000.0), 0.0);
    }
}
