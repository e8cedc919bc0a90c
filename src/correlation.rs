//! The correlation dimension of a section (Grassberger & Procaccia 1983).

use stickslip::math;

/// Shares of pairs between which the slope is taken.
const SHARES: (f64, f64) = (2e-3, 2e-2);
/// Radii at which it is measured.
const RADII: u32 = 12;
/// A set of a smaller correlation dimension is a curve.
pub(crate) const CURVE: f64 = 1.2;

/// Slope of ln C(r), C being the share of pairs of points nearer than r in every component.
pub(crate) fn correlation_dimension<const N: usize>(points: &[[f64; N]]) -> f64 {
    let mut distances = Vec::with_capacity(points.len() * points.len().saturating_sub(1) / 2);
    for (i, one) in points.iter().enumerate() {
        for other in &points[i + 1..] {
            let apart = one.iter().zip(other).map(|(a, b)| (a - b).abs());
            distances.push(apart.fold(0.0, f64::max));
        }
    }
    distances.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * distances.len() as f64) as usize;
        distances.get(index).copied().unwrap_or(f64::NAN)
    };
    let ratio = SHARES.1 / SHARES.0;
    let logs: Vec<(f64, f64)> = (0..RADII)
        .map(|k| SHARES.0 * math::pow(ratio, f64::from(k) / f64::from(RADII - 1)))
        .map(|share| (math::ln(at(share)), math::ln(share)))
        .collect();
    let n = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let above: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let below: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dimension_of_a_filled_square_is_two() {
        // A low-discrepancy sequence.
        let square: Vec<[f64; 2]> = (1..1200)
            .map(|k| {
                [
                    (0.754_877_67 * f64::from(k)).fract(),
                    (0.569_840_29 * f64::from(k)).fract(),
                ]
            })
            .collect();
        let dimension = correlation_dimension(&square);
        assert!((dimension - 2.0).abs() < 0.3, "{dimension}");
    }
}
