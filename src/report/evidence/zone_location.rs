//! `s4.zone_location`: on which parameters of model 2 the place of its stick zones depends.

use super::stick_ends::stick_ends;
use super::{Evidence, Part, small};
use stickslip::models::ForcedOscillator;

/// Factor by which each parameter is changed.
const FACTOR: f64 = 1.05;
/// Shifts within this are none (m): the last digits of a bisected position.
const NONE: f64 = 1e-12;

/// How far the ends of the zones move when one parameter changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// The parameter.
    pub parameter: &'static str,
    /// Whether Sect. 4.1 names it.
    pub named: bool,
    /// Least and largest shift among the ends (m).
    pub shift: (f64, f64),
}

/// Shifts for all parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneLocation {
    /// Ends of the zones.
    pub ends: usize,
    /// One for each parameter.
    pub moved: Vec<Moved>,
}

impl ZoneLocation {
    /// Bisects along Σ for each parameter.
    pub fn compute() -> ZoneLocation {
        ZoneLocation::of(&ForcedOscillator::default())
    }

    fn of(model: &ForcedOscillator) -> ZoneLocation {
        let f = FACTOR;
        let changed = [
            (
                "k1",
                true,
                ForcedOscillator {
                    k1: f * model.k1,
                    ..*model
                },
            ),
            (
                "k2",
                true,
                ForcedOscillator {
                    k2: f * model.k2,
                    ..*model
                },
            ),
            (
                "mu0",
                true,
                ForcedOscillator {
                    mu0: f * model.mu0,
                    ..*model
                },
            ),
            (
                "m",
                false,
                ForcedOscillator {
                    mass: f * model.mass,
                    ..*model
                },
            ),
            (
                "vp",
                false,
                ForcedOscillator {
                    belt_speed: f * model.belt_speed,
                    ..*model
                },
            ),
            (
                "delta",
                false,
                ForcedOscillator {
                    delta: f * model.delta,
                    ..*model
                },
            ),
        ];
        let ends = stick_ends(model, 0.0);
        let moved = changed
            .into_iter()
            .map(|(parameter, named, other)| {
                let others = stick_ends(&other, 0.0);
                let shifts = || ends.iter().zip(&others).map(|(a, b)| (a - b).abs());
                let same = others.len() == ends.len();
                Moved {
                    parameter,
                    named,
                    shift: if same {
                        (
                            shifts().fold(f64::INFINITY, f64::min),
                            shifts().fold(0.0, f64::max),
                        )
                    } else {
                        // Zones that appear or vanish have moved all the more.
                        (f64::INFINITY, f64::INFINITY)
                    },
                }
            })
            .collect();
        ZoneLocation {
            ends: ends.len(),
            moved,
        }
    }
}

impl Evidence for ZoneLocation {
    fn parts(&self) -> Vec<Part> {
        let named = self.moved.iter().filter(|one| one.named);
        let mut named = named.map(|one| one.shift.0 > NONE);
        vec![Part {
            what: "the place of the stick zones depends on k1, k2 and mu0",
            holds: self.ends > 0 && named.all(|moves| moves),
        }]
    }

    fn line(&self) -> String {
        let list = |named: bool| -> Vec<String> {
            let of = self.moved.iter().filter(|one| one.named == named);
            of.map(|one| format!("{} {}", one.parameter, small(one.shift.1)))
                .collect()
        };
        format!(
            "each parameter {:.0} % larger moves the {} ends of the zones by up to (m): {}; not named and without influence: {}",
            100.0 * (FACTOR - 1.0),
            self.ends,
            list(true).join(", "),
            list(false).join(", "),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn springs_and_friction_move_the_zones_and_nothing_else_does() {
        let found = ZoneLocation::compute();
        assert_eq!((found.ends, found.support()), (6, Support::Whole));
        let others = found.moved.iter().filter(|one| !one.named);
        assert!(others.clone().count() == 3);
        assert!(
            others.into_iter().all(|one| one.shift.1 <= NONE),
            "{found:?}"
        );
    }

    #[test]
    fn friction_that_drives_leaves_no_zone_to_move() {
        let driving = ForcedOscillator {
            mu0: -0.2,
            ..ForcedOscillator::default()
        };
        assert_eq!(ZoneLocation::of(&driving).support(), Support::Nothing);
    }
}
