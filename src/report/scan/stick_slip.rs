//! Periodic motions with stick, and how far they are from the published one.

/// Stick phases whose lengths differ by no more are the same (m).
const SAME_LENGTH: f64 = 1e-4;

/// A periodic motion with stick.
#[derive(Clone, Debug, PartialEq)]
pub struct StickSlip {
    /// Forcing periods after which it repeats.
    pub period: usize,
    /// Lengths of its stick phases in one pattern (m), the longest first.
    pub lengths: Vec<f64>,
}

impl StickSlip {
    /// Larger of the relative differences of the two longest stick phases of two forcing periods from `published`; infinite where
    /// there are not two.
    pub fn distance(&self, published: [f64; 2]) -> f64 {
        // A motion of period one has each of its stick phases twice in two periods.
        let twice = if self.period == 1 { 2 } else { 1 };
        let mut all = self
            .lengths
            .iter()
            .flat_map(|&l| std::iter::repeat_n(l, twice));
        match (all.next(), all.next()) {
            (Some(first), Some(second)) => [(first, published[0]), (second, published[1])]
                .map(|(found, wanted)| (found / wanted - 1.0).abs())
                .into_iter()
                .fold(0.0, f64::max),
            _ => f64::INFINITY,
        }
    }

    /// Whether two starts have found the same motion.
    pub(super) fn is(&self, other: &StickSlip) -> bool {
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_LENGTH;
        self.period == other.period
            && self.lengths.len() == other.lengths.len()
            && self.lengths.iter().zip(&other.lengths).all(near)
    }
}
