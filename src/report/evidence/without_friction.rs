//! `s4.no_stick_at_zero`: without friction nothing sticks and nothing deflects.

use rayon::prelude::*;

use super::stick_phases::{follow, starts};
use crate::figures::normals;
use crate::numbers::{ROUNDING, extent, largest};
use crate::paper::models::ForcedOscillator;
use crate::paper::reading::Reading::Exact;
use crate::report::digits::small;
use crate::report::finding::{Finding, statement};
use stickslip::{Error, Mode, State, TransitionKind};

/// Starts on Σ relative to the support (m): where σ vanishes without friction, and between.
const ON_BOUNDARY: [f64; 7] = [-1.0, -0.7, -0.3, 0.0, 0.3, 0.7, 1.0];
/// Times of the forcing period at which they start, including its quarters.
const TIMES: u32 = 8;

/// Judges the statement by model 2 without friction, with the friction of Fig. 8 beside.
pub(super) fn no_stick_at_zero() -> Result<Vec<Finding>, Error> {
    let with = ForcedOscillator::default();
    let without = ForcedOscillator { mu0: 0.0, ..with };
    let with = tally(&with)?;
    let EventTally {
        orbits,
        sticks,
        crossings,
        largest_kink,
        least_sigma,
    } = tally(&without)?;
    let deflects = largest_kink > ROUNDING;
    let parts = [
        (
            "at mu0 = 0 the transition function is nowhere negative",
            crossings > 0 && least_sigma >= 0.0,
        ),
        ("there is no stick", orbits > 0 && sticks == 0),
        ("orbits that cross Σ are deflected there", deflects),
    ];
    let (sigma, kink) = (small(least_sigma), small(largest_kink));
    let (with_sticks, with_kink) = (with.sticks, with.largest_kink);
    let line = format!(
        "model 2 at mu0 = 0 from {orbits} starts: {sticks} stick phases (with the friction of Fig. \
         8: {with_sticks}), least σ on Σ {sigma} m²/s⁴; at {crossings} crossings the acceleration \
         jumps by at most {kink} m/s² (with friction by up to {with_kink:.2} m/s²). Without \
         friction nothing deflects. That deflections appear nowhere else is another reading, which \
         is not judged: the sentence says that they will appear"
    );
    Ok(vec![statement(Exact, parts, line)])
}

/// Events of orbits from starts off and on Σ.
struct EventTally {
    orbits: usize,
    sticks: usize,
    crossings: usize,
    /// Largest jump of the acceleration at a crossing (m/s²).
    largest_kink: f64,
    /// Smallest σ at a crossing or a start on Σ (m²/s⁴).
    least_sigma: f64,
}

fn tally(model: &ForcedOscillator) -> Result<EventTally, Error> {
    let off = starts().into_iter().map(|x| (0.0, x));
    let on = (0..TIMES).flat_map(|k| {
        let t = model.period() * f64::from(k) / f64::from(TIMES);
        ON_BOUNDARY.map(|z| (t, State::from([z + model.support(t), model.belt_speed])))
    });
    let all: Vec<(f64, State<2>)> = off.chain(on).collect();
    let orbits = all.par_iter().map(|&(t, x)| follow(model, t, x));
    let orbits = orbits.collect::<Result<Vec<_>, Error>>()?;
    let phases = orbits.iter().flat_map(|orbit| &orbit.phases);
    let transitions = orbits.iter().flat_map(|orbit| &orbit.transitions);
    let crossings = transitions.filter(|at| at.kind == TransitionKind::Crossing);
    let crossings: Vec<(f64, State<2>)> = crossings.map(|at| (at.t, at.x)).collect();
    let normals = |(t, x): &(f64, State<2>)| normals(model, *t, x.as_ref());
    let kink = |at: &(f64, State<2>)| {
        let [below, above] = normals(at);
        (above - below).abs()
    };
    let on_boundary = all.iter().filter(|(_, x)| x[1] == model.belt_speed);
    let sigmas = crossings.iter().chain(on_boundary).map(|at| {
        let [below, above] = normals(at);
        below * above
    });
    Ok(EventTally {
        orbits: orbits.len(),
        sticks: phases.filter(|phase| phase.mode == Mode::Stick).count(),
        crossings: crossings.len(),
        largest_kink: largest(crossings.iter().map(kink)),
        least_sigma: extent(sigmas).0,
    })
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
    fn a_little_friction_sticks_and_deflects() {
        let found = tally(&ForcedOscillator {
            mu0: 0.05,
            ..ForcedOscillator::default()
        })
        .unwrap();
        assert!(found.sticks > 0 && found.largest_kink > ROUNDING);
    }
}
