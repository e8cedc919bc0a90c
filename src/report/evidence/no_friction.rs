//! `s4.no_stick_at_zero`: model 2 without friction.

use rayon::prelude::*;

use super::grid::{follow, starts};
use super::{Evidence, Part, small};
use stickslip::error::Error;
use stickslip::filippov::{TransitionKind, normal_component};
use stickslip::models::ForcedOscillator;
use stickslip::system::{Filippov, Mode, Side, State};

/// Starts on Σ, relative to the support (m): where σ vanishes without friction, and between.
const ON_BOUNDARY: [f64; 7] = [-1.0, -0.7, -0.3, 0.0, 0.3, 0.7, 1.0];
/// Times of the period at which they start.
const TIMES: u32 = 8;
/// A kink below this is none (m/s²).
const NONE: f64 = 1e-12;

/// What model 2 does without friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoFriction {
    /// Orbits followed.
    pub orbits: usize,
    /// Stick phases among them.
    pub sticks: usize,
    /// Stick phases from the same starts with the friction of Fig. 8.
    pub sticks_with_friction: usize,
    /// Least σ met at a crossing or a start on Σ (m²/s⁴).
    pub least_sigma: f64,
    /// Crossings of Σ.
    pub crossings: usize,
    /// Largest jump of the acceleration at a crossing (m/s²).
    pub largest_kink: f64,
    /// The same with the friction of Fig. 8.
    pub largest_kink_with_friction: f64,
}

/// Stick phases and crossings of many orbits.
#[derive(Clone, Copy)]
struct Tally {
    orbits: usize,
    sticks: usize,
    crossings: usize,
    largest_kink: f64,
    least_sigma: f64,
}

impl NoFriction {
    /// Follows orbits from off and on Σ.
    ///
    /// # Errors
    /// Those of [`stickslip::solve`] except an escape.
    pub fn compute() -> Result<NoFriction, Error> {
        let with = ForcedOscillator::default();
        let without = ForcedOscillator { mu0: 0.0, ..with };
        let (without, with) = (tally(&without)?, tally(&with)?);
        Ok(NoFriction {
            orbits: without.orbits,
            sticks: without.sticks,
            sticks_with_friction: with.sticks,
            least_sigma: without.least_sigma,
            crossings: without.crossings,
            largest_kink: without.largest_kink,
            largest_kink_with_friction: with.largest_kink,
        })
    }
}

fn tally(model: &ForcedOscillator) -> Result<Tally, Error> {
    let off = starts().into_iter().map(|x| (0.0, x));
    let on = (0..TIMES).flat_map(|k| {
        let t = model.period() * f64::from(k) / f64::from(TIMES);
        ON_BOUNDARY.map(|z| (t, State::from([z + model.support(t), model.belt_speed])))
    });
    let all: Vec<(f64, State<2>)> = off.chain(on).collect();
    let tallies = all
        .par_iter()
        .map(|&(t, x)| of_orbit(model, t, x))
        .collect::<Result<Vec<Tally>, Error>>()?;
    let none = Tally {
        orbits: 0,
        sticks: 0,
        crossings: 0,
        largest_kink: 0.0,
        least_sigma: f64::INFINITY,
    };
    Ok(tallies.into_iter().fold(none, |sum, one| Tally {
        orbits: sum.orbits + one.orbits,
        sticks: sum.sticks + one.sticks,
        crossings: sum.crossings + one.crossings,
        largest_kink: sum.largest_kink.max(one.largest_kink),
        least_sigma: sum.least_sigma.min(one.least_sigma),
    }))
}

fn of_orbit(model: &ForcedOscillator, t: f64, x: State<2>) -> Result<Tally, Error> {
    let orbit = follow(model, t, x)?;
    let mut tally = Tally {
        orbits: 1,
        sticks: orbit
            .phases
            .iter()
            .filter(|phase| phase.mode == Mode::Stick)
            .count(),
        crossings: 0,
        largest_kink: 0.0,
        least_sigma: f64::INFINITY,
    };
    let normal = |t: f64, x: &State<2>, side| {
        let x = x.as_ref();
        normal_component(model, t, x, &model.field(side, t, x))
    };
    let start = (x[1] == model.belt_speed).then_some((t, x));
    let crossings = orbit
        .transitions
        .iter()
        .filter(|at| at.kind == TransitionKind::Crossing);
    for at in crossings.clone() {
        tally.crossings += 1;
        let kink = normal(at.t, &at.x, Side::Above) - normal(at.t, &at.x, Side::Below);
        tally.largest_kink = tally.largest_kink.max(kink.abs());
    }
    for (t, x) in crossings.map(|at| (at.t, at.x)).chain(start) {
        let sigma = normal(t, &x, Side::Below) * normal(t, &x, Side::Above);
        tally.least_sigma = tally.least_sigma.min(sigma);
    }
    Ok(tally)
}

impl Evidence for NoFriction {
    fn parts(&self) -> Vec<Part> {
        vec![
            Part {
                what: "at mu0 = 0 the transition function is nowhere negative",
                holds: self.crossings > 0 && self.least_sigma >= 0.0,
            },
            Part {
                what: "there is no stick",
                holds: self.orbits > 0 && self.sticks == 0,
            },
            Part {
                what: "orbits that cross Σ are deflected there",
                holds: self.largest_kink > NONE,
            },
        ]
    }

    fn line(&self) -> String {
        format!(
            "model 2 at mu0 = 0 from {} starts: {} stick phases (with the friction of Fig. 8: {}), least σ on Σ {} m²/s⁴; at {} crossings the acceleration \
             jumps by at most {} m/s² (with friction by up to {:.2} m/s²): without friction nothing deflects; in another reading, \
             that deflections appear nowhere else, the sentence holds of none: it is not judged, for it says that deflections will appear",
            self.orbits,
            self.sticks,
            self.sticks_with_friction,
            small(self.least_sigma),
            self.crossings,
            small(self.largest_kink),
            self.largest_kink_with_friction,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn without_friction_nothing_sticks_and_nothing_deflects() {
        let found = NoFriction::compute().unwrap();
        assert_eq!(found.support(), Support::InPart, "{found:?}");
        assert!(!found.parts()[2].holds && found.sticks_with_friction > 0);
    }

    #[test]
    fn a_little_friction_is_seen() {
        let found = tally(&ForcedOscillator {
            mu0: 0.05,
            ..ForcedOscillator::default()
        })
        .unwrap();
        assert!(found.sticks > 0 && found.largest_kink > NONE);
    }
}
