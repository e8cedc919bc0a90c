//! The two shifts of Eq. (25), on a map whose exponent is known.

use super::proof::Proof;
use stickslip::math;

/// States of the logistic map: about ten in each neighbourhood.
const STATES: usize = 4000;
/// Radius of the neighbourhoods. Within it the slope of the map changes by 0.016.
const RADIUS: f64 = 2e-3;

/// Eqs. (25) and (26) taken literally, for a series of one component. The neighbours' differences
/// `y` are taken after `neighbours` steps; `τ` is `points` steps.
fn exponent(series: &[f64], neighbours: usize, points: usize) -> f64 {
    let usable = series.len() - neighbours.max(points);
    let (mut sum, mut count) = (0.0, 0_u32);
    for j in 0..usable {
        let (mut above, mut below) = (0.0, 0.0);
        for k in 0..usable {
            let y = series[k] - series[j];
            if k != j && y.abs() < RADIUS {
                above += (series[k + neighbours] - series[j + neighbours]) * y;
                below += y * y;
            }
        }
        if below > 0.0 && above != 0.0 {
            sum += math::ln((above / below).abs());
            count += 1;
        }
    }
    sum / (f64::from(count) * points as f64)
}

/// The shifts of Eq. (25) on the logistic map, whose exponent is ln 2.
pub(super) fn shifts() -> Proof {
    let mut x = 0.3;
    let mut next = || {
        x = 4.0 * x * (1.0 - x);
        x
    };
    let series: Vec<f64> = (0..STATES).map(|_| next()).collect();
    let truth = math::ln(2.0);
    let [equal, twice, half] = [(1, 1), (2, 1), (1, 2)].map(|(m, d)| exponent(&series, m, d));
    let near = |value: f64| (value - truth).abs() < 0.05;
    let holds = near(equal) && !near(twice) && !near(half);
    Proof::new("shifts", [truth, equal, twice, half], holds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_map_that_doubles_the_estimate_is_ln_two() {
        // x -> 2x mod 1 loses a bit per step, so it is iterated in integers.
        let mut x = 123_456_789_u64;
        let series: Vec<f64> = (0..2000)
            .map(|_| {
                x = (2 * x) % 1_000_000_007;
                x as f64 / 1_000_000_007.0
            })
            .collect();
        assert!((exponent(&series, 1, 1) - math::ln(2.0)).abs() < 0.05);
    }
}
