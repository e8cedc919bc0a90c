//! How far twelve exponents are from the published ones.

use crate::paper::claim_id::SpectrumFigure;
use crate::paper::published::{Claims, PublishedError};

/// The twelve exponents of Figs. 10–12, each figure's in descending order.
pub type Twelve = [[f64; 4]; 3];

/// Added to a published exponent's size before a difference is divided by it, so that exponents near zero
/// do not decide everything.
pub const FLOOR: f64 = 0.002;
/// Differences count no more than this; nor does an exponent that is missing or minus infinity.
pub const CAP: f64 = 3.0;

/// The published exponents.
///
/// # Errors
/// [`PublishedError`] if the table of claims lacks one.
pub fn target() -> Result<Twelve, PublishedError> {
    let claims = Claims::committed()?;
    let mut all = [[0.0; 4]; 3];
    for (figure, row) in all.iter_mut().enumerate() {
        for (k, value) in row.iter_mut().enumerate() {
            *value = claims.value(SpectrumFigure::ALL[figure].exponents()[k]);
        }
    }
    Ok(all)
}

fn squares(found: &[f64; 4], wanted: &[f64; 4]) -> f64 {
    found
        .iter()
        .zip(wanted)
        .map(|(value, wanted)| {
            let difference = (value - wanted).abs() / (wanted.abs() + FLOOR);
            // `min` takes the number where the other is none.
            let bounded = difference.min(CAP);
            bounded * bounded
        })
        .sum()
}

/// Root mean square of the differences of some figures (0, 1, 2).
pub fn distance(found: &Twelve, wanted: &Twelve, figures: &[usize]) -> f64 {
    let sum: f64 = figures
        .iter()
        .map(|&f| squares(&found[f], &wanted[f]))
        .sum();
    (sum / (4 * figures.len()) as f64).sqrt()
}

/// Distances of the three figures, and of all.
pub fn scores(found: &Twelve, wanted: &Twelve) -> [f64; 4] {
    [&[0][..], &[1], &[2], &[0, 1, 2]].map(|figures| distance(found, wanted, figures))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_formula_and_nothing_is_worse_than_the_cap() {
        let target = target().unwrap();
        // One exponent of twelve off by half its size with the floor: the root of 0.25/12.
        let mut off = target;
        off[2][0] += 0.5 * (target[2][0].abs() + FLOOR);
        let wanted = (0.25_f64 / 12.0).sqrt();
        assert!((distance(&off, &target, &[0, 1, 2]) - wanted).abs() < 1e-12);
        assert_eq!(distance(&off, &target, &[0, 1]), 0.0);
        let none = [[f64::NAN, f64::NEG_INFINITY, 1e9, -1e9]; 3];
        assert_eq!(distance(&none, &target, &[0, 1, 2]), CAP);
    }
}
