//! The first zero of a function over a step, none missed: found by resolving the function, not by its end signs.
//!
//! The function is sampled at nine Chebyshev points of the interval. The sums of its Chebyshev coefficients (those
//! of the last two, the interpolant's tail, counted again as a margin for what it leaves out) then say
//! for the whole interval that there is no zero, or that the function is monotone so that its ends
//! decide; where they say neither, the interval is halved. So two crossings within a step, or a touch
//! from which the function returns, are seen however close they lie, down to rounding.

/// An interval at whose start the function is positive and at whose end it is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bracket {
    pub a: f64,
    pub b: f64,
}

const NODES: usize = 9;

/// cos(k π/8) for k = 0 … 15: all the cosines that the transform of nine points needs.
const COS: [f64; 16] = {
    let (c1, c2, c3) = (
        0.923_879_532_511_286_7,
        std::f64::consts::FRAC_1_SQRT_2,
        0.382_683_432_365_089_8,
    );
    [
        1.0, c1, c2, c3, 0.0, -c3, -c2, -c1, -1.0, -c1, -c2, -c3, 0.0, c3, c2, c1,
    ]
};

/// Intervals narrower than this part of the step are not halved again: a parabola bends by 1e-16 over it.
const NARROWEST: f64 = 1.5e-8;

/// Zeros of `value` in `[lo, hi]`: a bracket of the first, or `None` when there is none.
pub(crate) fn first_zero(
    value: &mut impl FnMut(f64) -> f64,
    lo: f64,
    hi: f64,
) -> Option<Bracket> {
    // Depth-first, left half first; the depth is bounded by NARROWEST.
    let mut pending = [(0.0, 0.0); 64];
    pending[0] = (lo, hi);
    let mut count = 1;
    while count > 0 {
        count -= 1;
        let (lo, hi) = pending[count];
        match look(value, lo, hi) {
            Look::Clear => {}
            Look::Zero(bracket) => return Some(bracket),
            Look::Unresolved(nodes, values) => {
                if hi - lo <= NARROWEST {
                    if let Some(j) = (0..NODES).find(|&j| values[j] <= 0.0) {
                        let a = nodes[j.saturating_sub(1)];
                        return Some(Bracket { a, b: nodes[j] });
                    }
                } else {
                    let middle = nodes[NODES / 2];
                    pending[count] = (middle, hi);
                    pending[count + 1] = (lo, middle);
                    count += 2;
                }
            }
        }
    }
    None
}

enum Look {
    Clear,
    Zero(Bracket),
    Unresolved([f64; NODES], [f64; NODES]),
}

#[inline(always)]
fn look(value: &mut impl FnMut(f64) -> f64, lo: f64, hi: f64) -> Look {
    let half = 0.5 * (hi - lo);
    let mut nodes = [lo; NODES];
    let mut values = [0.0; NODES];
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for j in 0..NODES {
        nodes[j] = if j == NODES - 1 { hi } else { lo + half * (1.0 - COS[j]) };
        values[j] = value(nodes[j]);
        least = if values[j] < least { values[j] } else { least };
        most = if values[j] > most { values[j] } else { most };
    }
    // Far from zero: between nine Chebyshev points a polynomial leaves the range of its values by at most
    // 1.2 times its half-width (Lebesgue constant 2.4); four times is asked for.
    if least + most > 4.0 * (most - least) {
        return Look::Clear;
    }
    if values[0] <= 0.0 {
        return Look::Zero(Bracket { a: lo, b: lo });
    }
    let c = coefficients(&values);
    let tail = c[NODES - 2].abs() + c[NODES - 1].abs();
    if c[0] > c[1..].iter().map(|c| c.abs()).sum::<f64>() + tail {
        return Look::Clear;
    }
    if is_monotone(&c, tail) {
        return if values[NODES - 1] > 0.0 {
            Look::Clear
        } else {
            Look::Zero(Bracket { a: lo, b: hi })
        };
    }
    Look::Unresolved(nodes, values)
}

/// Chebyshev coefficients of the interpolant through the values (argument running downwards: odd ones
/// change sign, which no use here minds).
fn coefficients(values: &[f64; NODES]) -> [f64; NODES] {
    let n = NODES - 1;
    let mut c = [0.0; NODES];
    for (k, coefficient) in c.iter_mut().enumerate() {
        let mut sum = 0.5 * (values[0] + values[n] * COS[(n * k) % 16]);
        for j in 1..n {
            sum += values[j] * COS[(j * k) % 16];
        }
        *coefficient = sum * if k == 0 || k == n { 1.0 } else { 2.0 } / n as f64;
    }
    c
}

/// Whether the derivative of the interpolant keeps one sign.
fn is_monotone(c: &[f64; NODES], tail: f64) -> bool {
    let mut d = [0.0; NODES + 1];
    for k in (1..NODES).rev() {
        d[k - 1] = d[k + 1] + 2.0 * k as f64 * c[k];
    }
    let rest: f64 = d[1..].iter().map(|d| d.abs()).sum();
    // The derivative of T_8 reaches 64: what the tail leaves out may be that steep.
    0.5 * d[0].abs() > rest + 64.0 * tail
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zero_of(mut f: impl FnMut(f64) -> f64) -> Option<Bracket> {
        first_zero(&mut f, 0.0, 1.0)
    }

    #[test]
    fn finds_pairs_of_crossings_down_to_rounding_and_no_others() {
        for gap in [1e-2, 1e-6, 1e-10, 1e-13] {
            for centre in [0.31, 0.5, 0.77123] {
                let parabola = |g: f64| move |s: f64| (s - centre) * (s - centre) - g;
                let bracket = zero_of(parabola(gap)).expect("two crossings");
                let first = centre - gap.sqrt();
                assert!(bracket.a <= first && first <= bracket.b + 1e-15, "{gap} {centre}");
                assert!(bracket.b < centre + gap.sqrt());
                assert_eq!(zero_of(parabola(-gap)), None);
            }
        }
    }

    #[test]
    fn resolves_functions_that_nine_points_cannot() {
        let wave = |s: f64| crate::math::cos(60.0 * s) + 1.0 - 1e-6;
        let bracket = zero_of(wave).expect("cosine dips below");
        let first = (std::f64::consts::PI - (2e-6_f64).sqrt()) / 60.0;
        assert!(bracket.a <= first + 1e-9 && first - 1e-9 <= bracket.b);
        assert_eq!(zero_of(|s| crate::math::cos(60.0 * s) + 1.0 + 1e-6), None);
    }

    #[test]
    fn takes_the_first_of_many() {
        let product = |s: f64| -(s - 0.2) * (s - 0.4) * (s - 0.6) * (s - 0.8) * (s - 0.9);
        let bracket = zero_of(product).expect("five zeros");
        assert!(bracket.a <= 0.2 && 0.2 <= bracket.b && bracket.b < 0.4);
    }

    #[test]
    fn a_function_that_is_not_positive_at_the_start_is_zero_there() {
        assert_eq!(zero_of(|s| s - 0.5), Some(Bracket { a: 0.0, b: 0.0 }));
    }
}
