//! Misprints of Sect. 4: signs of friction and springs, lengths and durations, regions and
//! directions.

use rayon::prelude::*;

use super::{Proof, proof};
use crate::figures::rows::Value;
use crate::report::until_escape;
use stickslip::models::{BeltOscillator, ForcedOscillator};
use stickslip::system::Unchecked;
use stickslip::{Ending, Error, Filippov, Side, State};

const TOLERANCE: f64 = 1e-12;
/// Forcing periods that starts are followed over.
const FOLLOWED: f64 = 6.0;

/// Starts of both models: positions (m) and velocities (m/s).
fn starts() -> Vec<State<2>> {
    let positions = (0..9).map(|k| 0.25 * f64::from(k) - 1.0);
    positions
        .flat_map(|x1| [-0.8, 0.0, 0.4, 0.8].map(|x2| State::from([x1, x2])))
        .collect()
}

/// Stick phases of model 2 from all starts, and orbits that end where Σ repels.
fn sticks_and_ends(model: &ForcedOscillator) -> Result<(usize, usize), Error> {
    let span = FOLLOWED * model.period();
    let found = starts().into_par_iter().map(|x| {
        // Friction of the other sign is what is asked about.
        let (orbit, _) = until_escape(&Unchecked(model), (0.0, x), span, TOLERANCE)?;
        let ends = usize::from(orbit.ending == Ending::Repelling);
        Ok((orbit.sticks().count(), ends))
    });
    let found = found.collect::<Result<Vec<(usize, usize)>, Error>>()?;
    let (sticks, ends): (Vec<usize>, Vec<usize>) = found.into_iter().unzip();
    Ok((sticks.iter().sum(), ends.iter().sum()))
}

pub(super) fn sign_of_friction() -> Result<Proof, Error> {
    let model = ForcedOscillator::default();
    let printed = ForcedOscillator {
        mu0: -model.mu0,
        ..model
    };
    let (with_plus, with_minus) = (sticks_and_ends(&printed)?, sticks_and_ends(&model)?);
    let shown = [starts().len(), with_plus.0, with_plus.1, with_minus.0];
    let holds = with_plus.0 == 0 && with_plus.1 > 0 && with_minus.0 > 0;
    Ok(proof("sign_of_friction", shown, holds))
}

pub(super) fn spring_signs() -> Result<Proof, Error> {
    let first = BeltOscillator::default();
    // The same mass, belt and friction, and no forcing: what differs is the spring.
    let second = ForcedOscillator {
        mass: first.mass,
        belt_speed: first.belt_speed,
        amplitude: 0.0,
        ..ForcedOscillator::default()
    };
    let mut sigma = 0.0_f64;
    for k in -150..=150 {
        let x = [f64::from(k) / 100.0, first.belt_speed];
        let one = [Side::Below, Side::Above].map(|side| first.field(side, 0.0, &x)[1]);
        let other = [Side::Below, Side::Above].map(|side| second.field(side, 0.0, &x)[1]);
        sigma = sigma.max((one[0] * one[1] - other[0] * other[1]).abs());
    }
    let span = FOLLOWED * ForcedOscillator::default().period();
    let (mut escapes_first, mut escapes_second) = (0, 0);
    for x in starts() {
        escapes_first += usize::from(until_escape(&first, (0.0, x), span, TOLERANCE)?.1);
        escapes_second += usize::from(until_escape(&second, (0.0, x), span, TOLERANCE)?.1);
    }
    let counts = [starts().len(), escapes_first, escapes_second].map(Value::from);
    let shown = std::iter::once(sigma.into()).chain(counts);
    let holds = sigma < 1e-14 && escapes_first == 0 && escapes_second > 0;
    Ok(proof("spring_signs", shown, holds))
}
