//! The first zero of a polynomial over the unit interval, isolated rigorously.
//!
//! The Bernstein coefficients change sign at least as often as the polynomial has zeros in the
//! interval, and by Descartes' rule the difference is even. No change means no zero, and one change
//! means exactly one. Otherwise de Casteljau's construction halves the interval (Farouki, *Computer
//! Aided Geometric Design* 29 (2012) 379; Rouillier & Zimmermann, *J. Comput. Appl. Math.* 162
//! (2004) 33). So no pair of zeros is missed, however close, down to rounding.

use super::MAX_COEFFICIENTS;
use crate::ode::power_series;

/// Intervals narrower than this are not halved: a parabola bends over them by 1e-17, a tenth of
/// rounding.
const NARROWEST_INTERVAL: f64 = 7.5e-9;

/// An interval that holds a zero: the polynomial is positive at `a` and not positive at `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RootBracket {
    pub a: f64,
    pub b: f64,
    pub at_a: f64,
    pub at_b: f64,
}

/// Reciprocal binomial coefficients: `INVERSE_BINOMIAL[n][k] = 1/C(n, k)`.
const INVERSE_BINOMIAL: [[f64; MAX_COEFFICIENTS]; MAX_COEFFICIENTS] = {
    let mut table = [[0.0; MAX_COEFFICIENTS]; MAX_COEFFICIENTS];
    let mut n = 0;
    while n < MAX_COEFFICIENTS {
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

/// The first point of `[0, 1]` at which `Σ c_k s^k`, positive at 0, is not positive. A zero at 1
/// within rounding may be left to the next step.
#[inline(always)]
pub(crate) fn first_zero(c: &[f64]) -> Option<f64> {
    if is_positive(c) { None } else { search(c) }
}

/// Whether the size of the coefficients alone shows that `Σ c_k s^k` is positive on `[0, 1]`, as it
/// nearly always does. No power of `s` exceeds 1 there.
#[inline(always)]
pub(crate) fn is_positive(c: &[f64]) -> bool {
    let mut least = c[0];
    for &c in &c[1..] {
        least += if c < 0.0 { c } else { 0.0 };
    }
    least > 0.0
}

/// Degree to which a polynomial's higher powers are reduced. Chosen to fill one vector; a higher
/// degree decides more polynomials and takes longer.
const FOLDED_DEGREE: usize = 8;

/// Bernstein coefficients of the powers up to that degree, without the first, which is the value at
/// 0: `C(i, k)/C(FOLDED_DEGREE, k)` for `s^k`.
const BERNSTEIN: [[f64; FOLDED_DEGREE]; FOLDED_DEGREE + 1] = {
    let mut table = [[0.0; FOLDED_DEGREE]; FOLDED_DEGREE + 1];
    let mut i = 1;
    while i <= FOLDED_DEGREE {
        let mut k = 0;
        while k <= i {
            table[k][i - 1] = INVERSE_BINOMIAL[FOLDED_DEGREE][k] / INVERSE_BINOMIAL[i][k];
            k += 1;
        }
        i += 1;
    }
    table
};

/// Whether a polynomial of lower degree that bounds `Σ c_k s^k` from below has positive Bernstein
/// coefficients. On `[0, 1]` no power exceeds a lower power.
#[inline(always)]
pub(crate) fn is_positive_folded(c: &[f64; MAX_COEFFICIENTS]) -> bool {
    let mut beyond = [0.0; FOLDED_DEGREE];
    const { assert!((MAX_COEFFICIENTS - FOLDED_DEGREE - 1).is_multiple_of(FOLDED_DEGREE)) };
    for c in c[FOLDED_DEGREE + 1..].chunks_exact(FOLDED_DEGREE) {
        for (beyond, c) in beyond.iter_mut().zip(c) {
            *beyond += if *c < 0.0 { *c } else { 0.0 };
        }
    }
    let mut b = [0.0; FOLDED_DEGREE];
    for (k, column) in BERNSTEIN.iter().enumerate() {
        let c = if k < FOLDED_DEGREE {
            c[k]
        } else {
            c[k] + beyond.iter().sum::<f64>()
        };
        for (b, part) in b.iter_mut().zip(column) {
            *b += c * part;
        }
    }
    let mut is_positive = c[0] > 0.0;
    for b in b {
        is_positive &= b > 0.0;
    }
    is_positive
}

/// [`first_zero`] for polynomials that [`is_positive`] does not decide.
#[cold]
#[inline(never)]
pub(crate) fn search(c: &[f64]) -> Option<f64> {
    // A function that is not defined has no zero.
    if !c.iter().all(|c| c.is_finite()) {
        return None;
    }
    let mut all = [0.0; MAX_COEFFICIENTS];
    all[..c.len()].copy_from_slice(c);
    let (at_b, slope_at_b) = power_series(c, 1.0);
    if at_b > 0.0 && is_positive_folded(&all) {
        return None;
    }
    // A function that is monotone or convex or concave has one zero if it ends below zero. If it
    // ends above zero and falls throughout or is concave, it has none.
    let (at_a, slope_at_a) = (all[0], all[1]);
    let bend = slope_at_b - slope_at_a;
    let falls = slope_at_a < 0.0 && slope_at_b < 0.0 && is_positive_folded(&slope(&all, -1.0));
    let is_one_way = || at_a > 0.0 && is_positive_folded(&slope(&slope(&all, 1.0), bend.signum()));
    if at_b > 0.0 {
        if falls || (bend < 0.0 && is_one_way()) {
            return None;
        }
    } else if falls || is_one_way() {
        let guess = if falls {
            inverse_cubic([at_a, at_b], [slope_at_a, slope_at_b])
        } else {
            parabola(at_a, slope_at_a, at_b)
        };
        let (a, b) = (0.0, 1.0);
        return Some(newton(c, RootBracket { a, b, at_a, at_b }, guess));
    }
    let bracket = isolate(&bernstein(c)[..c.len()], 0.0, 1.0)?;
    let RootBracket { a, b, at_a, at_b } = bracket;
    let guess = a + (b - a) * (at_a / (at_a - at_b));
    Some(newton(c, bracket, guess))
}

/// Bernstein coefficients on the unit interval.
fn bernstein(c: &[f64]) -> [f64; MAX_COEFFICIENTS] {
    let n = c.len() - 1;
    let mut b = [0.0; MAX_COEFFICIENTS];
    for (k, (b, c)) in b.iter_mut().zip(c).enumerate() {
        *b = c * INVERSE_BINOMIAL[n][k];
    }
    // Bernstein coefficient i is Σ_k C(i, k)/C(n, k) c_k, computed as Pascal's triangle, by
    // additions alone.
    for i in 1..=n {
        let mut before = b[i - 1];
        for b in &mut b[i..=n] {
            let old = *b;
            *b = old + before;
            before = old;
        }
    }
    b
}

/// The places in the open unit interval at which `Σ c_k s^k` turns, in order, and their number. The
/// number is [`MAX_COEFFICIENTS`] where rounding finds more than there can be.
pub(crate) fn turning_points(c: &[f64]) -> ([f64; MAX_COEFFICIENTS], usize) {
    let mut places = ([0.0; MAX_COEFFICIENTS], 0);
    let mut all = [0.0; MAX_COEFFICIENTS];
    all[..c.len()].copy_from_slice(c);
    let slopes = slope(&all, 1.0);
    let slope_of = &slopes[..c.len() - 1];
    let others: f64 = slope_of[1..].iter().map(|c| c.abs()).sum();
    if slope_of[0].abs() > others {
        return places;
    }
    // Over most steps the function is monotone, or convex or concave with at most one turn.
    let (at_a, at_b) = (slope_of[0], slope_of.iter().sum::<f64>());
    let rises = at_a > 0.0;
    if rises == (at_b > 0.0) && is_positive_folded(&slope(&all, at_a.signum())) {
        return places;
    }
    if is_positive_folded(&slope(&slopes, (at_b - at_a).signum())) {
        if rises != (at_b > 0.0) {
            places.0[0] = between(slope_of, (0.0, 1.0), rises);
            places.1 = 1;
        }
        return places;
    }
    let b = bernstein(slope_of);
    sign_changes(slope_of, &b[..slope_of.len()], (0.0, 1.0), &mut places);
    places
}

/// Adds the places between `lo` and `hi` at which `Σ c_k s^k`, with Bernstein coefficients `b`
/// there, changes its sign.
fn sign_changes(
    c: &[f64],
    b: &[f64],
    (lo, hi): (f64, f64),
    places: &mut ([f64; MAX_COEFFICIENTS], usize),
) {
    let n = b.len() - 1;
    let is_changed = (b[0] > 0.0) != (b[n] > 0.0);
    let changes = b
        .windows(2)
        .filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0));
    let place = match changes.count() {
        0 => return,
        1 => between(c, (lo, hi), b[0] > 0.0),
        _ if hi - lo > NARROWEST_INTERVAL => {
            let ([left, right], middle) = (halves(b), 0.5 * (lo + hi));
            sign_changes(c, &left[..=n], (lo, middle), places);
            sign_changes(c, &right[..=n], (middle, hi), places);
            return;
        }
        _ if is_changed => lo,
        _ => return,
    };
    let (found, count) = places;
    if let Some(found) = found.get_mut(*count) {
        *found = place;
        *count += 1;
    }
}

/// The one sign change between two places, near enough that the function is flat there.
fn between(c: &[f64], (mut a, mut b): (f64, f64), is_positive_before: bool) -> f64 {
    let mut s = 0.5 * (a + b);
    while b - a > NARROWEST_INTERVAL {
        let (value, slope) = power_series(c, s);
        if (value > 0.0) == is_positive_before {
            a = s;
        } else {
            b = s;
        }
        let next = s - value / slope;
        if (next - s).abs() <= NARROWEST_INTERVAL {
            return next.clamp(a, b);
        }
        s = if next > a && next < b {
            next
        } else {
            0.5 * (a + b)
        };
    }
    s
}

/// Bernstein coefficients on the halves of the interval (de Casteljau).
fn halves(b: &[f64]) -> [[f64; MAX_COEFFICIENTS]; 2] {
    let n = b.len() - 1;
    let (mut left, mut right) = ([0.0; MAX_COEFFICIENTS], [0.0; MAX_COEFFICIENTS]);
    right[..=n].copy_from_slice(b);
    for (i, left) in left.iter_mut().enumerate().take(n + 1) {
        *left = right[0];
        for k in 0..n - i {
            right[k] = 0.5 * (right[k] + right[k + 1]);
        }
    }
    // Each `right[k]` has stopped at its own column of de Casteljau's triangle.
    [left, right]
}

/// Coefficients of the derivative, times a factor.
#[inline(always)]
fn slope(c: &[f64; MAX_COEFFICIENTS], factor: f64) -> [f64; MAX_COEFFICIENTS] {
    let mut slope = [0.0; MAX_COEFFICIENTS];
    for k in 1..MAX_COEFFICIENTS {
        slope[k - 1] = factor * k as f64 * c[k];
    }
    slope
}

/// The zero in the unit interval of the parabola with the given value and slope at the start and
/// the given value at the end. The two values have opposite signs.
fn parabola(at_a: f64, slope_at_a: f64, at_b: f64) -> f64 {
    let bend = at_b - at_a - slope_at_a;
    let root = (slope_at_a * slope_at_a - 4.0 * bend * at_a).sqrt();
    // Both formulas give the same zero; each is used where nothing cancels.
    if slope_at_a > 0.0 {
        (slope_at_a + root) / (-2.0 * bend)
    } else {
        2.0 * at_a / (root - slope_at_a)
    }
}

/// Approximate zero in the unit interval of a falling function with given values and slopes at the
/// ends, by Hermite interpolation of its inverse.
fn inverse_cubic([at_a, at_b]: [f64; 2], [slope_at_a, slope_at_b]: [f64; 2]) -> f64 {
    let rise = at_b - at_a;
    let t = -at_a / rise;
    // Larger slopes of the inverse would lead outside the interval.
    let [in_a, in_b] = [slope_at_a, slope_at_b].map(|slope| (rise / slope).min(3.0));
    let rest = 1.0 - t;
    t * (t * (3.0 - 2.0 * t) + rest * (rest * in_a - t * in_b))
}

/// The first bracket in `[lo, hi]` for the polynomial with Bernstein coefficients `b` there.
fn isolate(b: &[f64], lo: f64, hi: f64) -> Option<RootBracket> {
    let n = b.len() - 1;
    let mut changes = 0;
    for pair in b.windows(2) {
        changes += u32::from((pair[0] > 0.0) != (pair[1] > 0.0));
    }
    let bracket = RootBracket {
        a: lo,
        b: hi,
        at_a: b[0],
        at_b: b[n],
    };
    if changes == 0 {
        // A half may start at a zero within rounding.
        return (b[0] <= 0.0).then_some(bracket);
    }
    if changes == 1 && b[0] > 0.0 {
        return Some(bracket);
    }
    if hi - lo <= NARROWEST_INTERVAL {
        return (b[n] <= 0.0).then_some(bracket);
    }
    let [left, right] = halves(b);
    let middle = 0.5 * (lo + hi);
    isolate(&left[..=n], lo, middle).or_else(|| isolate(&right[..=n], middle, hi))
}

/// First and second derivative at `s`.
pub(crate) fn slope_and_bend(c: &[f64], s: f64) -> (f64, f64) {
    let (mut value, mut slope, mut half_bend) = (0.0, 0.0, 0.0);
    for &c in c.iter().rev() {
        half_bend = half_bend * s + slope;
        slope = slope * s + value;
        value = value * s + c;
    }
    (slope, 2.0 * half_bend)
}

/// Relative change by a Newton iteration after which the next change, about its square, would be
/// below rounding.
const CONVERGED_CHANGE: f64 = 1e-9;

/// A relative change below this is lost to rounding: a twentieth of a unit in the last place.
const ROUNDED_CHANGE: f64 = 1e-17;

/// The zero in a bracket by Newton's iteration from a guess, safeguarded by bisection.
pub(crate) fn newton(c: &[f64], bracket: RootBracket, guess: f64) -> f64 {
    let RootBracket {
        mut a, mut b, at_a, ..
    } = bracket;
    if at_a <= 0.0 {
        return a;
    }
    // The guess stays off the end, which may be another zero within rounding.
    let mut s = guess.min(a + 0.99 * (b - a));
    let mut last = 0.0;
    for _ in 0..100 {
        if !(s > a && s < b) {
            (s, last) = (0.5 * (a + b), 0.0);
            if s <= a || s >= b {
                return b;
            }
        }
        let (value, slope) = power_series(c, s);
        if value > 0.0 {
            a = s;
        } else {
            b = s;
        }
        let next = s - value / slope;
        let change = (next - s).abs();
        // Quadratic convergence: the next change over this one is the square of this one over the
        // last.
        let is_close = change <= CONVERGED_CHANGE * s
            || change * change * change <= ROUNDED_CHANGE * s * (last * last);
        // If the slope is positive, the nearby zero is another one, after the bracket.
        if slope < 0.0 && is_close {
            return next.clamp(a, b);
        }
        (s, last) = (next, change);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use numerics::SplitMix;

    /// Coefficients of `scale Π (s − root)`, with zeros up to the degree.
    fn polynomial(roots: &[f64], scale: f64) -> Vec<f64> {
        let mut c = vec![scale];
        for root in roots {
            c.push(0.0);
            for k in (0..c.len()).rev() {
                c[k] = if k > 0 { c[k - 1] } else { 0.0 } - root * c[k];
            }
        }
        c.resize(MAX_COEFFICIENTS, 0.0);
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
    fn another_zero_at_or_behind_the_end_of_a_bracket_is_not_taken_for_the_first() {
        let mut draw = SplitMix::new(1913);
        for end in [1.0, 0.5, 0.25] {
            for behind in [
                0.0, 1e-16, 3e-16, 1e-15, 1e-13, 1e-11, 9e-10, -1e-16, -1e-11,
            ] {
                for _ in 0..500 {
                    let first = draw.between(0.01, 0.9) * end;
                    let c = polynomial(&[first, end + behind], draw.between(0.1, 3.0));
                    let found = first_zero(&c).expect("has a zero");
                    assert!(
                        (found - first).abs() < 1e-13,
                        "{first} {end} {behind:e}: {found}"
                    );
                }
            }
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
    fn a_polynomial_turns_at_the_zeros_of_its_slope() {
        let mut draw = SplitMix::new(1961);
        for count in 0..6 {
            for _ in 0..200 {
                let mut places: Vec<f64> = (0..count).map(|_| draw.between(0.02, 0.98)).collect();
                places.sort_by(f64::total_cmp);
                let slope = polynomial(&places, draw.between(0.1, 3.0));
                let mut c = vec![draw.between(-1.0, 1.0); MAX_COEFFICIENTS];
                for k in 1..MAX_COEFFICIENTS {
                    c[k] = slope[k - 1] / k as f64;
                }
                let (found, turns) = turning_points(&c);
                let close = places.windows(2).any(|pair| pair[1] - pair[0] < 1e-2);
                if !close {
                    assert_eq!(turns, count, "{places:?}");
                    for (found, place) in found.iter().zip(&places) {
                        assert!((found - place).abs() < 1e-7, "{found} {place}");
                    }
                }
                // From one to the next it is monotone to rounding.
                let ends = [&[0.0], &found[..turns], &[1.0]].concat();
                for pair in ends.windows(2) {
                    let at = |i: i32| {
                        let s = pair[0] + (pair[1] - pair[0]) * f64::from(i) / 50.0;
                        power_series(&c, s).0
                    };
                    let way = (at(50) - at(0)).signum();
                    assert!((0..50).all(|i| way * (at(i + 1) - at(i)) > -1e-14));
                }
            }
        }
        assert_eq!(turning_points(&polynomial(&[], 2.0)).1, 0);
    }

    #[test]
    fn a_bernstein_coefficient_of_zero_between_positive_ones_is_two_changes_of_sign_and_no_zero() {
        // (1 - s)² + s², with the coefficients 1, 0, 1.
        assert_eq!(first_zero(&[1.0, -2.0, 2.0]), None);
    }

    #[test]
    fn what_is_said_by_lower_powers_alone_holds_for_all() {
        let mut draw = SplitMix::new(1912);
        let (mut positive, mut not) = (0, 0);
        for _ in 0..20_000 {
            let falls = draw.between(0.3, 2.0);
            let mut c = [0.0; MAX_COEFFICIENTS];
            for (k, c) in c.iter_mut().enumerate() {
                *c = draw.between(-1.0, 1.0) * math::powi(falls, k as i32);
            }
            c[0] = draw.between(0.0, 3.0);
            let least = (0..=1000)
                .map(|i| power_series(&c, f64::from(i) / 1000.0).0)
                .fold(f64::INFINITY, f64::min);
            if is_positive_folded(&c) {
                assert!(least > 0.0, "{least}: {c:?}");
                positive += 1;
            } else {
                not += 1;
            }
            // If samples show a sign change, the search finds a zero at or before it, and there is
            // none before that zero.
            let found = first_zero(&c);
            assert!(found.is_some() || least > -1e-13, "{least}: {c:?}");
            if let Some(s) = found {
                let size: f64 = c.iter().map(|c| c.abs()).sum();
                let before = (0..1000).map(|i| power_series(&c, s * f64::from(i) / 1000.0).0);
                assert!(
                    before.fold(f64::INFINITY, f64::min) > -1e-15 * size,
                    "{s}: {c:?}"
                );
                assert!(power_series(&c, s).0.abs() < 1e-14 * size, "{s}: {c:?}");
            }
        }
        assert!(positive > 1000 && not > 1000, "{positive} {not}");
    }
}
