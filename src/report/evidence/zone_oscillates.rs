//! `s4.zone_oscillates`: how the stick zone of model 2 moves over a forcing period.

use crate::bisection::bisect;
use rayon::prelude::*;

use super::stick_ends::stick_ends;
use super::{Evidence, Part, TangentSet, small};
use crate::paper::published::PublishedError;
use stickslip::models::ForcedOscillator;
use stickslip::system::Filippov;

/// Times in one forcing period; a quarter and three quarters of it are among them.
const TIMES: u32 = 48;
/// Differences within this are none (m): the last digits of a bisected position.
const NONE: f64 = 1e-12;

/// The ends of the stick zone over one forcing period.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneOscillates {
    /// Times looked at.
    pub times: usize,
    /// Times at which the zone has six ends.
    pub with_six_ends: usize,
    /// Largest difference of an end, bisected along Σ by where the body sticks, from `z_k + A sin(ωt)` (m).
    pub largest_difference: f64,
    /// The ends at time 0, when the support is where it would rest (m), ascending.
    pub at_rest: Vec<f64>,
    /// Travel of the uppermost end along x1 (m).
    pub travel_x1: f64,
    /// Twice the amplitude A of the support (m).
    pub twice_amplitude: f64,
    /// Travel of Σ, and of the zone in it, along x2 (m/s): where the boundary function vanishes at the zone's ends.
    pub travel_x2: f64,
}

impl ZoneOscillates {
    /// Bisects along Σ at all times.
    ///
    /// # Errors
    /// [`PublishedError`] if the table of claims lacks Eq. (24).
    pub fn compute() -> Result<ZoneOscillates, PublishedError> {
        Ok(ZoneOscillates::of(
            &ForcedOscillator::default(),
            &TangentSet::published()?,
        ))
    }

    fn of(model: &ForcedOscillator, set: &TangentSet) -> ZoneOscillates {
        let found: Vec<(f64, Vec<f64>)> = (0..TIMES)
            .into_par_iter()
            .map(|k| {
                let t = model.period() * f64::from(k) / f64::from(TIMES);
                (t, stick_ends(model, t))
            })
            .collect();
        let mut largest: f64 = 0.0;
        let (mut x1, mut x2) = (Range::EMPTY, Range::EMPTY);
        for (t, ends) in &found {
            for (end, z) in ends.iter().rev().zip(set.0) {
                largest = largest.max((end - (z + model.support(*t))).abs());
                x2.take(speed_on_boundary(model, *t, *end));
            }
            if let Some(uppermost) = ends.last() {
                x1.take(*uppermost);
            }
        }
        ZoneOscillates {
            times: found.len(),
            with_six_ends: found.iter().filter(|(_, ends)| ends.len() == 6).count(),
            largest_difference: largest,
            at_rest: found
                .first()
                .map_or_else(Vec::new, |(_, ends)| ends.clone()),
            travel_x1: x1.extent(),
            twice_amplitude: 2.0 * model.amplitude,
            travel_x2: x2.extent(),
        }
    }
}

/// The velocity (m/s) at which the boundary function vanishes above a position.
fn speed_on_boundary(model: &ForcedOscillator, t: f64, x1: f64) -> f64 {
    bisect(-10.0, 10.0, |x2| model.boundary(t, &[x1, x2]) >= 0.0)
}

/// Least and largest of some numbers.
struct Range(f64, f64);

impl Range {
    const EMPTY: Range = Range(f64::INFINITY, f64::NEG_INFINITY);

    fn take(&mut self, value: f64) {
        *self = Range(self.0.min(value), self.1.max(value));
    }

    fn extent(&self) -> f64 {
        self.1 - self.0
    }
}

impl Evidence for ZoneOscillates {
    fn parts(&self) -> Vec<Part> {
        vec![
            Part {
                what: "the tangent points move by A sin(ωt)",
                holds: self.with_six_ends == self.times
                    && self.largest_difference <= NONE
                    && (self.travel_x1 - self.twice_amplitude).abs() <= NONE,
            },
            Part {
                what: "the zone oscillates along x2",
                holds: self.travel_x2 > NONE,
            },
        ]
    }

    fn line(&self) -> String {
        format!(
            "ends of the stick zone bisected along Σ at {} times of a period: within {} m of z_k + A sin(ωt); they travel {:.4} m along x1, twice A being \
             {:.4} m, and {} m/s along x2",
            self.times,
            small(self.largest_difference),
            self.travel_x1,
            self.twice_amplitude,
            self.travel_x2,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn the_zone_moves_along_x1_and_not_along_x2() {
        let found = ZoneOscillates::compute().unwrap();
        assert_eq!(found.support(), Support::InPart, "{found:?}");
        assert!(found.parts()[0].holds);
    }

    #[test]
    fn another_friction_or_a_displaced_point_is_seen() {
        let (model, set) = (
            ForcedOscillator::default(),
            TangentSet::published().unwrap(),
        );
        let stronger = ForcedOscillator {
            mu0: 1.001 * model.mu0,
            ..model
        };
        assert!(!ZoneOscillates::of(&stronger, &set).parts()[0].holds);
        let driving = ForcedOscillator {
            mu0: -model.mu0,
            ..model
        };
        assert_eq!(ZoneOscillates::of(&driving, &set).with_six_ends, 0);
        let mut displaced = set;
        displaced.0[3] += 1e-9;
        assert!(!ZoneOscillates::of(&model, &displaced).parts()[0].holds);
    }
}
