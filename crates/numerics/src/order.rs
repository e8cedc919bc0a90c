//! Medians and the order of values.

/// The two middle values, equal for an odd number of values; `None` without values. NaN is skipped.
pub fn middle_two(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    let mut values: Vec<f64> = values.into_iter().filter(|v| !v.is_nan()).collect();
    values.sort_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    Some([values[(values.len() - 1) / 2], upper])
}

/// The median (the upper of the middle two), without NaN; NaN if there are no values.
pub fn upper_median(values: impl IntoIterator<Item = f64>) -> f64 {
    middle_two(values).map_or(f64::NAN, |[_, upper]| upper)
}

/// Indices of the values in ascending order of value, equal ones by index.
pub fn order(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_even_and_odd_counts() {
        assert_eq!(middle_two([]), None);
        assert_eq!(middle_two([f64::NAN]), None);
        assert_eq!(middle_two([3.0]), Some([3.0, 3.0]));
        assert_eq!(middle_two([5.0, 1.0, 2.0]), Some([2.0, 2.0]));
        assert_eq!(middle_two([9.0, 1.0, f64::NAN, 5.0, 2.0]), Some([2.0, 5.0]));
    }
}
