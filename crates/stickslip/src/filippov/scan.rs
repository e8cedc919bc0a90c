//! The first zero of a function over a step, found by resolving the function and not by its signs
//! at the ends.
//!
//! The function is sampled at nine Chebyshev points of the interval. The sums of its Chebyshev
//! coefficients decide for the whole interval: there is no zero, or the function is monotone and
//! its ends decide. The last two coefficients count twice, as a margin for the truncated tail. If
//! neither holds, the interval is halved. So two crossings within a step, or a touch, are found
//! however close they lie, down to rounding.
//!
//! A feature between all samples is found if the function has interval bounds. An interval that
//! samples call clear is halved until its bounds confirm that.

use std::cell::Cell;

/// An interval with a positive value at its start and none at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bracket {
    pub a: f64,
    pub b: f64,
}

/// Number of Chebyshev points of an interval. Chosen: the dense output of a step
/// of order 8 has degree 7.
pub(crate) const NODES: usize = 9;

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

/// Intervals narrower than this fraction of the step are not halved again: the root of
/// [`f64::EPSILON`], so that a parabola bends over them by rounding. Longer intervals are halved as
/// often as one step.
pub(crate) const NARROWEST_INTERVAL: f64 = 1.5e-8;

/// The nine points of the unit interval.
pub(crate) const UNIT_NODES: [f64; NODES] = {
    let mut nodes = [1.0; NODES];
    let mut j = 0;
    while j < NODES - 1 {
        nodes[j] = 0.5 * (1.0 - COS[j]);
        j += 1;
    }
    nodes
};

/// Whether a function stays far from zero over the whole step, by its values at the points of
/// [`UNIT_NODES`]. The cheap test of a user's event functions.
///
/// Between nine Chebyshev points a polynomial leaves the range of its values by at most 1.2 times
/// its half-width (Lebesgue constant 2.4). The test requires four times. A value that is not finite
/// fails.
#[inline(always)]
pub(crate) fn far_from_zero(values: &[f64; NODES]) -> bool {
    let first = values[0];
    let (mut least, mut most, mut sum) = (first, first, first);
    for &v in &values[1..] {
        least = if v < least { v } else { least };
        most = if v > most { v } else { most };
        // Comparisons ignore a NaN; a sum does not.
        sum += v;
    }
    least + most > 4.0 * (most - least) && sum.is_finite()
}

/// Whether a function that is positive at the points of [`UNIT_NODES`] is so between them, as far
/// as samples tell.
pub(crate) fn stays_positive(values: &[f64; NODES]) -> bool {
    let samples = Samples {
        nodes: UNIT_NODES,
        values: *values,
    };
    values.iter().all(|v| *v > 0.0) && matches!(samples.verdict(), Verdict::Clear)
}

/// Whether the values at the points of [`far_from_zero`] are finite.
pub(crate) fn is_defined(value: impl Fn(f64) -> f64) -> bool {
    UNIT_NODES.iter().all(|&s| value(s).is_finite())
}

/// A bracket of the first zero of `value` in `[lo, hi]`, or `None`, by samples alone. A function
/// that varies faster than they resolve may have a zero that they do not see.
pub(crate) fn first_bracket(
    value: &mut dyn FnMut(f64) -> f64,
    lo: f64,
    hi: f64,
) -> Option<Bracket> {
    first_bracket_within(value, &mut |_, _| Bounds::Unknown, lo, hi)
}

/// Proof by interval bounds about a function over a part of the interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bounds {
    /// Certainly has no zero.
    Clear,
    /// May have a zero: an interval that is clear by samples is refined.
    Open,
    /// Nothing: samples decide.
    Unknown,
}

/// Largest number of parts of an interval whose bounds are computed in one search. Chosen: it
/// limits the cost of a step whose bounds are useless. Samples decide the rest.
const MAX_BOUNDS: u32 = 256;

/// Number of bounds after which it is checked whether they are of use. Chosen: most searches need
/// fewer.
const BOUNDS_BEFORE_TRIAL: u32 = 4;

/// Places in the rest of the unit interval at which that is checked. A function that reads values,
/// or compares equal numbers, has no bounds however narrow the interval. Chosen at irregular
/// distances, so that no period of a function fits them.
const TRIAL_PLACES: [f64; 5] = [0.0, 0.0117, 0.1234, 0.5678, 0.9119];

/// Width of the parts in which that is checked. Chosen so narrow that bounds of any use exclude a
/// zero in some of them.
const TRIAL_WIDTH: f64 = 1e-9;

/// The number of bounds that a search has computed, up to [`MAX_BOUNDS`].
#[derive(Default)]
pub(crate) struct BoundsBudget(Cell<u32>);

impl BoundsBudget {
    /// Whether no bounds were computed.
    pub fn is_unused(&self) -> bool {
        self.0.get() == 0
    }

    /// Forbids further bounds, so that samples decide.
    pub fn exhaust(&self) {
        self.0.set(MAX_BOUNDS);
    }

    /// Proof by bounds about a function between two places, if `is_clear` returns whether they
    /// exclude a zero there.
    pub fn bounds(&self, (from, to): (f64, f64), is_clear: &dyn Fn(f64, f64) -> bool) -> Bounds {
        let used = self.0.get();
        if used >= MAX_BOUNDS {
            return Bounds::Unknown;
        }
        self.0.set(used + 1);
        if is_clear(from, to) {
            return Bounds::Clear;
        }
        let places = TRIAL_PLACES.map(|part| from + part * (1.0 - from));
        if used == BOUNDS_BEFORE_TRIAL && !places.iter().any(|&s| is_clear(s, s + TRIAL_WIDTH)) {
            self.exhaust();
            return Bounds::Unknown;
        }
        Bounds::Open
    }
}

/// Closer than this to a sampled zero, no earlier zero is searched for (fraction of the step).
/// Chosen: a zero hidden there is earlier by less than a hundredth of a step.
const ZERO_NEIGHBOURHOOD: f64 = 0.0078125;

/// Number of halvings without samples of a part that samples call clear and bounds leave open.
/// Chosen: bounds cost less than nine samples.
const HALVINGS_UNSAMPLED: u32 = 3;

/// [`first_bracket`] with interval bounds of parts of the interval. Halves intervals until each
/// is clear or holds a bracket: depth first, the left half first.
pub(crate) fn first_bracket_within(
    value: &mut dyn FnMut(f64) -> f64,
    bounds: &mut dyn FnMut(f64, f64) -> Bounds,
    lo: f64,
    hi: f64,
) -> Option<Bracket> {
    // Each halving leaves one interval waiting, and NARROWEST_INTERVAL allows 26 of them,
    // HALVINGS_UNSAMPLED two more.
    let narrowest = NARROWEST_INTERVAL * (hi - lo).max(1.0);
    let mut waiting = [ScanPart::default(); 32];
    let mut count = 0;
    let mut part = ScanPart {
        ends: (lo, hi),
        ..ScanPart::default()
    };
    loop {
        let (lo, hi) = part.ends;
        let mut halves = None;
        match bounds(lo, hi) {
            Bounds::Clear => {}
            Bounds::Open if 0 < part.halvings && part.halvings < HALVINGS_UNSAMPLED => {
                halves = Some(part.halved(part.halvings + 1));
            }
            proven => {
                let samples = Samples::take(value, lo, hi);
                let is_narrow = hi - lo <= narrowest;
                match samples.verdict() {
                    Verdict::Clear if proven == Bounds::Unknown || is_narrow => {}
                    Verdict::Clear => halves = Some(part.halved(1)),
                    Verdict::Zero(sampled) => {
                        // If an earlier zero is excluded, the sampled bracket is the first.
                        let bracket = part.remainder_of.unwrap_or(sampled);
                        let unproven = (proven == Bounds::Open)
                            .then(|| unproven_before(sampled, value, bounds))
                            .flatten();
                        let Some((from, middle, to)) = unproven else {
                            return Some(bracket);
                        };
                        let before = ScanPart {
                            ends: (from, middle),
                            halvings: 1,
                            remainder_of: None,
                        };
                        let remainder = ScanPart {
                            ends: (middle, to),
                            halvings: 0,
                            remainder_of: Some(bracket),
                        };
                        halves = Some((before, remainder));
                    }
                    Verdict::Unresolved if is_narrow => {
                        if let Some(bracket) = samples.first_sign_change() {
                            return Some(bracket);
                        }
                    }
                    Verdict::Unresolved => halves = Some(part.halved(0)),
                }
            }
        }
        if let Some((first, second)) = halves {
            (part, waiting[count]) = (first, second);
            count += 1;
        } else if count > 0 {
            count -= 1;
            part = waiting[count];
        } else {
            return None;
        }
    }
}

/// A part of the interval that is searched.
#[derive(Clone, Copy, Default)]
struct ScanPart {
    ends: (f64, f64),
    /// Number of halvings since samples were clear.
    halvings: u32,
    /// The sampled bracket whose remainder it is. The part before it is searched first.
    remainder_of: Option<Bracket>,
}

impl ScanPart {
    fn halved(self, halvings: u32) -> (Self, Self) {
        let (lo, hi) = self.ends;
        // The same arithmetic as for the samples gives the same bits.
        let middle = lo + 0.5 * (hi - lo);
        let half = |ends| ScanPart {
            ends,
            halvings,
            remainder_of: None,
        };
        (half((lo, middle)), half((middle, hi)))
    }
}

/// The part of a bracket that may have a zero before the sampled one, and the rest. `None` if
/// bounds exclude an earlier zero.
fn unproven_before(
    Bracket { mut a, mut b }: Bracket,
    value: &mut dyn FnMut(f64) -> f64,
    bounds: &mut dyn FnMut(f64, f64) -> Bounds,
) -> Option<(f64, f64, f64)> {
    while b - a > ZERO_NEIGHBOURHOOD {
        let middle = 0.5 * (a + b);
        if value(middle) <= 0.0 {
            b = middle;
        } else if bounds(a, middle) == Bounds::Open {
            return Some((a, middle, b));
        } else {
            a = middle;
        }
    }
    None
}

/// The first zero of `value`, positive at `from`, in `[from, to]`; `None` without one. Two
/// successive zeros are found however close they lie, down to rounding.
///
/// ```
/// use stickslip::first_zero;
///
/// let zero = first_zero(|s| (s - 0.5) * (s - 0.500_001), 0.0, 1.0);
/// assert!((zero.unwrap() - 0.5).abs() < 1e-9);
/// assert_eq!(first_zero(|s| (s - 0.5) * (s - 0.5) + 1e-6, 0.0, 1.0), None);
/// ```
pub fn first_zero(mut value: impl FnMut(f64) -> f64, from: f64, to: f64) -> Option<f64> {
    let bracket = first_bracket(&mut value, from, to)?;
    Some(zero_in(&mut value, bracket))
}

/// The zero of `value` in a bracket (positive at `a`, not at `b`), to a few parts in 1e15 of the
/// step. The method is regula falsi, Illinois variant.
pub(crate) fn zero_in(value: &mut dyn FnMut(f64) -> f64, bracket: Bracket) -> f64 {
    let (mut a, mut b) = (bracket.a, bracket.b);
    let (mut at_a, mut at_b) = (value(a), value(b));
    if at_a <= 0.0 {
        return a;
    }
    let mut last_moved_a = None;
    for _ in 0..100 {
        if b - a <= 4.0 * f64::EPSILON * b || at_b == 0.0 {
            break;
        }
        let falsi = b - at_b * (b - a) / (at_b - at_a);
        let inside = falsi > a && falsi < b;
        let middle = if inside { falsi } else { 0.5 * (a + b) };
        let at_middle = value(middle);
        let moves_a = at_middle > 0.0;
        // An end that has stayed twice gets half its weight, or it would stay without end.
        let again = last_moved_a == Some(moves_a);
        if moves_a {
            (a, at_a) = (middle, at_middle);
            at_b *= if again { 0.5 } else { 1.0 };
        } else {
            (b, at_b) = (middle, at_middle);
            at_a *= if again { 0.5 } else { 1.0 };
        }
        last_moved_a = Some(moves_a);
    }
    b
}

enum Verdict {
    Clear,
    Zero(Bracket),
    Unresolved,
}

/// The function at the nine points of an interval.
#[derive(Clone, Copy)]
struct Samples {
    nodes: [f64; NODES],
    values: [f64; NODES],
}

impl Samples {
    fn take(value: &mut dyn FnMut(f64) -> f64, lo: f64, hi: f64) -> Self {
        let half = 0.5 * (hi - lo);
        let (mut nodes, mut values) = ([hi; NODES], [0.0; NODES]);
        for j in 0..NODES {
            if j < NODES - 1 {
                nodes[j] = lo + half * (1.0 - COS[j]);
            }
            values[j] = value(nodes[j]);
        }
        Samples { nodes, values }
    }

    fn verdict(&self) -> Verdict {
        let (first, last) = (0, NODES - 1);
        if self.values[first] <= 0.0 {
            let a = self.nodes[first];
            return Verdict::Zero(Bracket { a, b: a });
        }
        let c = coefficients(&self.values);
        if !c[0].is_finite() {
            // The function is undefined somewhere here; halving would never end.
            return Verdict::Clear;
        }
        let tail = c[NODES - 2].abs() + c[NODES - 1].abs();
        if c[0] > c[1..].iter().map(|c| c.abs()).sum::<f64>() + tail {
            return Verdict::Clear;
        }
        if is_monotone(&c, tail) {
            return if self.values[last] > 0.0 {
                Verdict::Clear
            } else {
                Verdict::Zero(Bracket {
                    a: self.nodes[first],
                    b: self.nodes[last],
                })
            };
        }
        Verdict::Unresolved
    }

    fn first_sign_change(&self) -> Option<Bracket> {
        let j = (1..NODES).find(|&j| self.values[j] <= 0.0)?;
        Some(Bracket {
            a: self.nodes[j - 1],
            b: self.nodes[j],
        })
    }
}

/// Chebyshev coefficients of the interpolant through the values (argument running downwards: odd
/// ones change sign, which no use here minds).
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
    let others: f64 = d[1..].iter().map(|d| d.abs()).sum();
    // The derivative of T_8 reaches 64: the truncated tail may be that steep.
    0.5 * d[0].abs() > others + 64.0 * tail
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zero_of(mut f: impl FnMut(f64) -> f64) -> Option<Bracket> {
        first_bracket(&mut f, 0.0, 1.0)
    }

    #[test]
    fn finds_pairs_of_crossings_down_to_rounding_and_no_others() {
        for gap in [1e-2, 1e-6, 1e-10, 1e-13] {
            for centre in [0.31, 0.5, 0.77123] {
                let parabola = |g: f64| move |s: f64| (s - centre) * (s - centre) - g;
                let bracket = zero_of(parabola(gap)).expect("two crossings");
                let first = centre - gap.sqrt();
                assert!(
                    bracket.a <= first && first <= bracket.b + 1e-15,
                    "{gap} {centre}"
                );
                assert!(bracket.b < centre + gap.sqrt());
                assert_eq!(zero_of(parabola(-gap)), None);
            }
        }
    }

    #[test]
    fn an_interval_however_long_is_searched_to_its_end() {
        for length in [1e3, 1e6, 1e12] {
            let middle = 0.3 * length;
            let touch = |s: f64| (s - middle) * (s - middle);
            let found = first_zero(touch, 0.0, length);
            assert!(found.is_none_or(|s| (s - middle).abs() < 1e-3 * length));
            assert_eq!(first_zero(|s| middle - s, 0.0, length), Some(middle));
        }
    }

    #[test]
    fn a_spike_beside_all_samples_is_seen_where_bounds_leave_its_place_open() {
        let at = 0.7123;
        let spike = |s: f64| if (s - at).abs() < 1e-6 { -1.0 } else { 1.0 };
        assert_eq!(zero_of(spike), None);
        let bounds = |from: f64, to: f64| {
            if to < at - 1e-6 || at + 1e-6 < from {
                Bounds::Clear
            } else {
                Bounds::Open
            }
        };
        let found = first_bracket_within(&mut { spike }, &mut { bounds }, 0.0, 1.0);
        let found = found.expect("a spike");
        assert!(
            found.a <= at - 1e-6 && (found.b - at).abs() < 1e-5,
            "{found:?}"
        );
        // A zero before the sampled one.
        let falling = |s: f64| (0.9 - s).min(spike(s));
        let bounds = |from: f64, to: f64| {
            if to > 0.9 {
                Bounds::Open
            } else {
                bounds(from, to)
            }
        };
        let found = first_bracket_within(&mut { falling }, &mut { bounds }, 0.0, 1.0);
        assert!(
            found.is_some_and(|found| (found.b - at).abs() < 1e-5),
            "{found:?}"
        );
        // Without bounds the bracket is that of samples alone.
        let smooth = |s: f64| 0.9 - s;
        let found = first_bracket_within(&mut { smooth }, &mut { bounds }, 0.0, 1.0);
        assert_eq!(found, zero_of(smooth));
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
    fn far_from_zero_is_what_varies_little_and_is_defined_throughout() {
        let far = |function: &dyn Fn(f64) -> f64| far_from_zero(&UNIT_NODES.map(function));
        assert!(far(&|s| 10.0 + s));
        // Half the sum must exceed four times the difference.
        assert!(far(&|s| 3.6 + s) && !far(&|s| 1.4 + s));
        assert!(!far(&|s| -10.0 - s));
        assert!(!far(&|s| if s == 0.5 { f64::NAN } else { 10.0 }));
    }

    #[test]
    fn a_jump_through_zero_is_bracketed_as_narrowly_as_any_interval() {
        let bracket = zero_of(|s| if s < 0.3 { 1.0 } else { -1.0 }).expect("a jump");
        assert!(bracket.a < 0.3 && 0.3 <= bracket.b);
        assert!(bracket.b - bracket.a <= NARROWEST_INTERVAL);
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
