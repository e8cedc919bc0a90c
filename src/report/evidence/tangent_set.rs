//! The set (24) of tangent points as the paper prints it.

use crate::bisection::bisect;
use crate::paper::claim_id::ClaimId;
use crate::paper::published::{Claims, PublishedError};
use stickslip::models::ForcedOscillator;

/// The six tangent points of Eq. (24) at rest (m), numbered from the largest down as the paper does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentSet(pub [f64; 6]);

impl TangentSet {
    /// As published.
    ///
    /// # Errors
    /// [`PublishedError`] if the table of claims has no such set.
    pub fn published() -> Result<TangentSet, PublishedError> {
        let mut values = Claims::committed()?
            .of(ClaimId::Eq24TangentPoints)
            .values()
            .to_vec();
        values.sort_by(|one, other| other.total_cmp(one));
        Ok(TangentSet(std::array::from_fn(|k| {
            values.get(k).copied().unwrap_or(f64::NAN)
        })))
    }

    /// Distances (m) of a body at `x1` from the points moved by the support at `t`.
    pub(super) fn gaps(&self, model: &ForcedOscillator, t: f64, x1: f64) -> [f64; 6] {
        let offset = model.support(t);
        self.0.map(|z| x1 - (z + offset))
    }

    /// Number, counted from 1, of the moved point nearest to `x1`, and its distance (m).
    pub(super) fn nearest(&self, model: &ForcedOscillator, t: f64, x1: f64) -> (usize, f64) {
        let gaps = self.gaps(model, t, x1);
        let mut best = (1, f64::INFINITY);
        for (number, gap) in (1..).zip(gaps) {
            if gap.abs() < best.1 {
                best = (number, gap.abs());
            }
        }
        best
    }

    /// Whether a body lies between the ends of one of the three zones that the points bound, by which of the points it is above.
    pub(super) fn in_zone(above: [bool; 6]) -> bool {
        above.chunks_exact(2).any(|zone| !zone[0] && zone[1])
    }

    /// When (s) a body that rides the belt from `(t, x1)` first meets one of the moved points, by that equation alone; nothing
    /// within `span`.
    pub(super) fn first_meeting(
        &self,
        model: &ForcedOscillator,
        (t, x1): (f64, f64),
        span: f64,
    ) -> Option<f64> {
        // A gap changes by less than its own size over such a part of the forcing period.
        let part = model.period() / 2000.0;
        let at = |later: f64| self.gaps(model, t + later, x1 + model.belt_speed * later);
        let ahead = |gaps: [f64; 6]| gaps.map(|gap| gap > 0.0);
        let start = ahead(at(0.0));
        let steps = (span / part).ceil() as u32;
        let after = (1..=steps).find(|&k| ahead(at(f64::from(k) * part)) != start)?;
        let (low, high) = (f64::from(after - 1) * part, f64::from(after) * part);
        Some(t + bisect(low, high, |later| ahead(at(later)) != start))
    }
}
