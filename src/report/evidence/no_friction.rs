//! `s4.no_stick_at_zero`: model 2 without friction.

use rayon::prelude::*;

use super::sticks::{follow, starts};
use super::{found, small};
use crate::paper::reading::Reading::Exact;
use crate::report::finding::Finding;
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

pub(super) fn no_stick_at_zero() -> Result<Vec<Finding>, Error> {
    let with = ForcedOscillator::default();
    let without = ForcedOscillator { mu0: 0.0, ..with };
    let (without, with) = (tally(&without)?, tally(&with)?);
    let parts = [
        (
            "at mu0 = 0 the transition function is nowhere negative",
            without.crossings > 0 && without.least_sigma >= 0.0,
        ),
        (
            "there is no stick",
            without.orbits > 0 && without.sticks == 0,
        ),
        (
            "orbits that cross Σ are deflected there",
            without.largest_kink > NONE,
        ),
    ];
    let line = format!(
        "model 2 at mu0 = 0 from {} starts: {} stick phases (with the friction of Fig. 8: {}), least σ on Σ {} m²/s⁴; at {} crossings the acceleration \
         jumps by at most {} m/s² (with friction by up to {:.2} m/s²): without friction nothing deflects; in another reading, \
         that deflections appear nowhere else, the sentence holds of none: it is not judged, for it says that deflections will appear",
        without.orbits,
        without.sticks,
        with.sticks,
        small(without.least_sigma),
        without.crossings,
        small(without.largest_kink),
        with.largest_kink,
    );
    Ok(vec![found(Exact, parts, line)])
}

/// What orbits from off and on Σ go through.
struct Tally {
    orbits: usize,
    sticks: usize,
    crossings: usize,
    /// Largest jump of the acceleration at a crossing (m/s²).
    largest_kink: f64,
    /// Least σ at a crossing or a start on Σ (m²/s⁴).
    least_sigma: f64,
}

impl Tally {
    const NONE: Tally = Tally {
        orbits: 0,
        sticks: 0,
        crossings: 0,
        largest_kink: 0.0,
        least_sigma: f64::INFINITY,
    };

    fn and(self, other: Tally) -> Tally {
        Tally {
            orbits: self.orbits + other.orbits,
            sticks: self.sticks + other.sticks,
            crossings: self.crossings + other.crossings,
            largest_kink: self.largest_kink.max(other.largest_kink),
            least_sigma: self.least_sigma.min(other.least_sigma),
        }
    }
}

fn tally(model: &ForcedOscillator) -> Result<Tally, Error> {
    let off = starts().into_iter().map(|x| (0.0, x));
    let on = (0..TIMES).flat_map(|k| {
        let t = model.period() * f64::from(k) / f64::from(TIMES);
        ON_BOUNDARY.map(|z| (t, State::from([z + model.support(t), model.belt_speed])))
    });
    let all: Vec<(f64, State<2>)> = off.chain(on).collect();
    let tallies = all.par_iter().map(|&(t, x)| of_orbit(model, t, x));
    let tallies = tallies.collect::<Result<Vec<Tally>, Error>>()?;
    Ok(tallies.into_iter().fold(Tally::NONE, Tally::and))
}

fn of_orbit(model: &ForcedOscillator, t: f64, x: State<2>) -> Result<Tally, Error> {
    let orbit = follow(model, t, x)?;
    let sticks = orbit.phases.iter().filter(|one| one.mode == Mode::Stick);
    let mut tally = Tally {
        orbits: 1,
        sticks: sticks.count(),
        ..Tally::NONE
    };
    let normal = |t: f64, x: &State<2>, side| {
        let x = x.as_ref();
        normal_component(model, t, x, &model.field(side, t, x))
    };
    if x[1] == model.belt_speed {
        tally.least_sigma = normal(t, &x, Side::Below) * normal(t, &x, Side::Above);
    }
    let transitions = orbit.transitions.iter();
    for at in transitions.filter(|at| at.kind == TransitionKind::Crossing) {
        let (below, above) = (
            normal(at.t, &at.x, Side::Below),
            normal(at.t, &at.x, Side::Above),
        );
        tally.crossings += 1;
        tally.largest_kink = tally.largest_kink.max((above - below).abs());
        tally.least_sigma = tally.least_sigma.min(below * above);
    }
    Ok(tally)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_friction_nothing_sticks_and_nothing_deflects() {
        assert_eq!(no_stick_at_zero().unwrap()[0].parts(), [true, true, false]);
        assert!(tally(&ForcedOscillator::default()).unwrap().sticks > 0);
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
