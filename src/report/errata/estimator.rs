//! Misprint of Sect. 5.1: the shifts of Eq. (25).

use super::{Erratum, erratum, number};
use stickslip::math;

/// States of the logistic map.
const STATES: usize = 4000;
/// Radius of the neighbourhoods.
const RADIUS: f64 = 2e-3;

pub(super) fn errata() -> Vec<Erratum> {
    vec![shifts()]
}

/// Eqs. (25) and (26) to the letter, for a series of one component: the neighbours' differences `y` after `neighbours` steps, `τ` of
/// `points` steps.
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

/// On the logistic map, whose exponent is ln 2.
fn shifts() -> Erratum {
    let mut x = 0.3;
    let series: Vec<f64> = (0..STATES)
        .map(|_| {
            x = 4.0 * x * (1.0 - x);
            x
        })
        .collect();
    let truth = math::ln(2.0);
    let (equal, twice, half) = (
        exponent(&series, 1, 1),
        exponent(&series, 2, 1),
        exponent(&series, 1, 2),
    );
    let near = |value: f64| (value - truth).abs() < 0.05;
    erratum(
        "Eq. (25)",
        "the neighbours are taken m steps on, the reference point d steps",
        "both d: m is defined nowhere, and with another shift than that in tau = d t the exponent is wrong",
        vec![
            number("ln 2, the exponent of the logistic map", truth, "1"),
            number("by Eqs. (25), (26) with m = d = 1", equal, "1"),
            number("with m = 2, d = 1", twice, "1"),
            number("with m = 1, d = 2", half, "1"),
        ],
        near(equal) && !near(twice) && !near(half),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_equal_shifts_give_the_exponent() {
        let found = shifts();
        assert!(found.holds, "{found:?}");
    }

    #[test]
    fn of_a_map_that_doubles_the_estimate_is_ln_two() {
        // x -> 2x mod 1 loses a bit a step, so it is followed in integers.
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
