//! Searches of one variable.

/// The first number from `from` to `to` for which `is_after` holds, to the last bit. Either may be
/// the smaller one. Once `is_after` holds, it must hold up to `to`.
///
/// ```
/// let root = numerics::bisect(1.0, 2.0, |x| x * x >= 2.0);
/// assert_eq!(root, 2f64.sqrt());
/// ```
pub fn bisect(mut from: f64, mut to: f64, mut is_after: impl FnMut(f64) -> bool) -> f64 {
    loop {
        let middle = 0.5 * (from + to);
        let is_between = (from < middle && middle < to) || (to < middle && middle < from);
        if !is_between {
            return to;
        }
        if is_after(middle) {
            to = middle;
        } else {
            from = middle;
        }
    }
}

/// The golden ratio minus one: the part of its interval that a golden section keeps.
const KEPT_PART: f64 = 0.618_033_988_749_894_9;

/// Minimum of a function with a single local minimum between `a` and `b`, by so many golden
/// sections.
///
/// Forty sections shrink the interval to 4e-9 of its length. The value is then accurate to
/// rounding.
pub fn golden_section(mut a: f64, mut b: f64, sections: u32, function: impl Fn(f64) -> f64) -> f64 {
    let (mut c, mut d) = (b - KEPT_PART * (b - a), a + KEPT_PART * (b - a));
    let (mut at_c, mut at_d) = (function(c), function(d));
    for _ in 0..sections {
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - KEPT_PART * (b - a);
            at_c = function(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + KEPT_PART * (b - a);
            at_d = function(d);
        }
    }
    at_c.min(at_d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bisection_ends_at_neighbouring_numbers() {
        for step in [1.0 / 3.0, 0.7, -0.4, -1e-300, 0.0] {
            let found = bisect(-1.0, 1.0, |x| x >= step);
            assert_eq!(found.to_bits() << 1, step.to_bits() << 1, "{step}");
            let found = bisect(1.0, -1.0, |x| x <= step);
            assert_eq!(found.to_bits() << 1, step.to_bits() << 1, "{step}");
        }
        assert_eq!(bisect(0.0, 1.0, |_| false), 1.0);
    }

    #[test]
    fn golden_sections_find_a_minimum() {
        let least = golden_section(-1.0, 2.0, 40, |x| (x - 0.3) * (x - 0.3) + 7.0);
        assert_eq!(least, 7.0);
    }
}
