//! Bisection to the last bit.

/// The least number in `(low, high]` for which `is_after` holds, if it holds from some number on.
pub(crate) fn bisect(mut low: f64, mut high: f64, is_after: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if !(low < middle && middle < high) {
            return high;
        }
        if is_after(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_told_apart_and_signs_do_not_matter() {
        for step in [1.0 / 3.0, 0.7, -0.4, -1e-300, 0.0] {
            let found = bisect(-1.0, 1.0, |x| x >= step);
            assert_eq!(found.to_bits() << 1, step.to_bits() << 1, "{step}");
        }
        assert_eq!(bisect(0.0, 1.0, |_| false), 1.0);
    }
}
