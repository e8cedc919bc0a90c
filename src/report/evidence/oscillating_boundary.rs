//! `s6.oscillating_boundary`: whether the boundary of discontinuity itself oscillates.

use super::{Evidence, Part, ZoneOscillates};

/// What moves in model 2: Σ or the stick zone in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OscillatingBoundary {
    /// Travel of Σ along x2 over a forcing period (m/s).
    pub boundary: f64,
    /// Travel of the stick zone's end in Σ along x1 (m).
    pub zone: f64,
}

impl From<&ZoneOscillates> for OscillatingBoundary {
    fn from(found: &ZoneOscillates) -> Self {
        OscillatingBoundary {
            boundary: found.travel_x2,
            zone: found.travel_x1,
        }
    }
}

impl Evidence for OscillatingBoundary {
    fn parts(&self) -> Vec<Part> {
        vec![
            Part {
                what: "the boundary of discontinuity oscillates",
                holds: self.boundary > 0.0,
            },
            Part {
                what: "the harmonic excitation moves the stick zone in it",
                holds: self.zone > 0.0,
            },
        ]
    }

    fn line(&self) -> String {
        format!(
            "over a forcing period Σ travels {} m/s along x2; the stick zone in it travels {:.4} m along x1",
            self.boundary, self.zone
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn a_zone_at_rest_bears_out_nothing() {
        let found = ZoneOscillates::compute().unwrap();
        assert_eq!(OscillatingBoundary::from(&found).support(), Support::InPart);
        let at_rest = ZoneOscillates {
            travel_x1: 0.0,
            ..found
        };
        assert_eq!(
            OscillatingBoundary::from(&at_rest).support(),
            Support::Nothing
        );
    }
}
