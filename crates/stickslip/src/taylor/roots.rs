//! The first zero of a polynomial over the unit interval, isolated for certain.
//!
//! The coefficients in Bernstein's basis change sign at least as often as the polynomial has zeros in the interval, and by
//! Descartes' rule the difference is even: none means no zero, one means exactly one. De Casteljau's construction halves the
//! interval where they say neither (Farouki, *Computer Aided Geometric Design* 29 (2012) 379; Rouillier & Zimmermann,
//! *J. Comput. Appl. Math.* 162 (2004) 33). So no pair of zeros is missed, however close, down to rounding.

use super::MOST_ORDER;

const ROOM: usize = MOST_ORDER + 1;

/// Halves narrower than this are not halved again: a parabola bends by 1e-17 over them.
const NARROWEST: f64 = 7.5e-9;

/// An interval that holds a zero: positive at `a`, not at `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bracket {
    a: f64,
    b: f64,
    at_a: f64,
    at_b: f64,
}

/// Binomial coefficients' inverses: `INVERSE_BINOMIAL[n][k] = 1/C(n, k)`.
const INVERSE_BINOMIAL: [[f64; ROOM]; ROOM] = {
    let mut table = [[0.0; ROOM]; ROOM];
    let mut n = 0;
    while n < ROOM {
        let mut binomial: u64 = 1;
        let mut k = 0;
        while k <= n {
            table[n][k] = 1.0 / binomial as f64;
            binomial = binomial * (n - k) as u64 / (k + 1) as u64;
            k += 1;
        }
        n += 1;
    }
    table
};

/// Where `Σ c_k s^k`, positive at 0, first is not positive in `[0, 1]`. A zero at 1 to rounding may be left to the step that
/// begins there.
#[inline(always)]
pub(crate) fn first_zero(c: &[f64]) -> Option<f64> {
    if is_positive(c) { None } else { search(c) }
}

/// Whether `Σ c_k s^k` is positive throughout by the size of its coefficients alone, as nearly always: no power exceeds 1.
#[inline(always)]
pub(crate) fn is_positive(c: &[f64]) -> bool {
    let mut least = c[0];
    for &c in &c[1..] {
        least += if c < 0.0 { c } else { 0.0 };
    }
    least > 0.0
}

#[cold]
#[inline(never)]
fn search(c: &[f64]) -> Option<f64> {
    // Where the function is not defined there is no zero of it.
    if !c.iter().all(|c| c.is_finite()) {
        return None;
    }
    let n = c.len() - 1;
    let mut b = [0.0; ROOM];
    for (k, (b, c)) in b.iter_mut().zip(c).enumerate() {
        *b = c * INVERSE_BINOMIAL[n][k];
    }
    // Bernstein coefficient i is Σ_k C(i, k)/C(n, k) c_k: Pascal's triangle, by additions alone.
    for i in 1..=n {
        let mut before = b[i - 1];
        for b in &mut b[i..=n] {
            let old = *b;
            *b = old + before;
            before = old;
        }
    }
    let bracket = isolate(&b[..=n], 0.0, 1.0)?;
    Some(newton(c, bracket))
}

/// The first bracket in `[lo, hi]`, where the polynomial has the Bernstein coefficients `b`.
fn isolate(b: &[f64], lo: f64, hi: f64) -> Option<Bracket> {
    let n = b.len() - 1;
    let mut changes = 0;
    for pair in b.windows(2) {
        changes += u32::from((pair[0] > 0.0) != (pair[1] > 0.0));
    }
    let bracket = Bracket {
        a: lo,
        b: hi,
        at_a: b[0],
        at_b: b[n],
    };
    if changes == 0 {
        // A half may start at a zero to rounding.
        return (b[0] <= 0.0).then_some(bracket);
    }
    if changes == 1 && b[0] > 0.0 {
        return Some(bracket);
    }
    if hi - lo <= NARROWEST {
        return (b[n] <= 0.0).then_some(bracket);
    }
    let (mut left, mut right) = ([0.0; ROOM], [0.0; ROOM]);
    right[..=n].copy_from_slice(b);
    for (i, left) in left.iter_mut().enumerate().take(n + 1) {
        *left = right[0];
        for k in 0..n - i {
            right[k] = 0.5 * (right[k] + right[k + 1]);
        }
    }
    // `right[k]` has stopped at the column of de Casteljau's triangle that is its own.
    let middle = 0.5 * (lo + hi);
    isolate(&left[..=n], lo, middle).or_else(|| isolate(&right[..=n], middle, hi))
}

/// Value and slope at `s`.
#[inline(always)]
pub(crate) fn value_and_slope(c: &[f64], s: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for &c in c.iter().rev() {
        slope = slope * s + value;
        value = value * s + c;
    }
    (value, slope)
}

/// Slope and curvature at `s`.
pub(crate) fn slope_and_bend(c: &[f64], s: f64) -> (f64, f64) {
    let (mut value, mut slope, mut half_bend) = (0.0, 0.0, 0.0);
    for &c in c.iter().rev() {
        half_bend = half_bend * s + slope;
        slope = slope * s + value;
        value = value * s + c;
    }
    (slope, 2.0 * half_bend)
}

/// The zero in a bracket by Newton's iteration, kept inside by regula falsi and bisection.
fn newton(c: &[f64], bracket: Bracket) -> f64 {
    let Bracket {
        mut a,
        mut b,
        at_a,
        at_b,
    } = bracket;
    if at_a <= 0.0 {
        return a;
    }
    let mut s = a + (b - a) * (at_a / (at_a - at_b));
    for _ in 0..100 {
        if !(s > a && s < b) {
            s = 0.5 * (a + b);
            if s <= a || s >= b {
                return b;
            }
        }
        let (value, slope) = value_and_slope(c, s);
        if value > 0.0 {
            a = s;
        } else {
            b = s;
        }
        let next = s - value / slope;
        if (next - s).abs() <= f64::EPSILON * s {
            return next.clamp(bracket.a, bracket.b);
        }
        s = next;
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of `scale Π (s − root)`, and as many zeros as fill up the degree.
    fn polynomial(roots: &[f64], scale: f64) -> Vec<f64> {
        let mut c = vec![scale];
        for root in roots {
            c.push(0.0);
            for k in (0..c.len()).rev() {
                c[k] = if k > 0 { c[k - 1] } else { 0.0 } - root * c[k];
            }
        }
        c.resize(ROOM, 0.0);
        c
    }

    #[test]
    fn the_first_of_many_zeros_is_found_to_rounding() {
        for (roots, scale) in [
            (vec![0.2, 0.4, 0.6, 0.8, 0.9], -1.0),
            (vec![0.5], -3.0),
            (vec![0.999], -1.0),
            (vec![0.3, 0.7, -0.1], 2.0),
            (vec![1e-9, 0.5], 1.0),
            (vec![0.999_999, 1.5], 1.0),
        ] {
            let c = polynomial(&roots, scale);
            let first = roots
                .iter()
                .copied()
                .filter(|r| *r > 0.0)
                .fold(2.0, f64::min);
            let found = first_zero(&c).expect("has a zero");
            assert!(
                (found - first).abs() < 1e-14 * first.max(0.1),
                "{roots:?}: {found}"
            );
        }
    }

    #[test]
    fn pairs_are_seen_down_to_rounding_and_misses_are_not_taken_for_pairs() {
        for gap in [1e-2, 1e-6, 1e-10, 1e-13] {
            for centre in [0.31, 0.5, 0.771_23] {
                let with_gap = |gap: f64| {
                    let mut c = polynomial(&[centre, centre], 1.0);
                    c[0] -= gap;
                    c
                };
                let first = centre - f64::sqrt(gap);
                let found = first_zero(&with_gap(gap)).expect("two zeros");
                assert!(
                    (found - first).abs() < 1e-15 / f64::sqrt(gap) + 1e-15,
                    "{gap}"
                );
                assert_eq!(first_zero(&with_gap(-gap)), None);
            }
        }
    }

    #[test]
    fn a_bernstein_coefficient_of_zero_between_positive_ones_is_two_changes_of_sign_and_no_zero() {
        // (1 - s)² + s², with the coefficients 1, 0, 1.
        assert_eq!(first_zero(&[1.0, -2.0, 2.0]), None);
    }
}
