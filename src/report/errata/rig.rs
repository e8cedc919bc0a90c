//! Misprints on model 3 shown by a rig in SI units: the friction of Eq. (28) and the unit of time.

use super::proof::Proof;
use crate::paper::TOLERANCE;
use crate::paper::models::{BlockAndBracket, Caption, Interpretation, Rig, Unloading};
use stickslip::{Error, Options, State, solve};

/// A block and a bracket in SI units, undamped as in the captions.
fn rig(gravity: f64, stiffness: f64) -> Rig {
    Rig {
        mass: 1.0,
        inertia: 0.5,
        arm: 0.7,
        k1: 2.0 * stiffness,
        k2: stiffness,
        k3: 0.9 * stiffness,
        c1: 0.0,
        c2: 0.0,
        gravity,
        mu0: 0.7,
        delta: 0.1,
        belt_speed: 0.2,
    }
}

/// Time over which the rig is integrated, in units of 1/ω: several oscillations.
const RIG_SPAN: f64 = 40.0;

/// The state of a rig after [`RIG_SPAN`], in the units of Eq. (27).
fn rig_state(rig: &Rig, start: &State<4>) -> Result<State<4>, Error> {
    let (length, time) = (rig.length_unit(), rig.time_unit());
    let units = State::from([length, length / time, length, length / time]);
    let x = start.component_mul(&units);
    let end = solve(rig, 0.0, x, RIG_SPAN * time, &Options::tol(TOLERANCE))?;
    Ok(end.x_end.component_div(&units))
}

/// Newton's law in SI units, compared with two ways to write the normal force with ξ6.
pub(super) fn friction_counted_twice() -> Result<Proof, Error> {
    let rig = rig(9.81, 1.0);
    let start = State::from([0.0, 0.01, 0.0, -0.05]);
    let newton = rig_state(&rig, &start)?;
    let plain = rig.nondimensional();
    // The captions' sixth and seventh numbers for this rig.
    let (sixth, seventh) = (rig.mu0, rig.mu0 * rig.k3 / rig.k2);
    let stiffness = plain.bracket_stiffness;
    let first = [plain.coupling, 0.0, plain.mobility, stiffness, 0.0];
    let last = [sixth, seventh, plain.delta, plain.belt_speed];
    let mut caption = Caption {
        numbers: [0.0; 9],
        start: start.into(),
    };
    caption.numbers[..5].copy_from_slice(&first);
    caption.numbers[5..].copy_from_slice(&last);
    let with = |unloading| -> Result<f64, Error> {
        let reading = Interpretation {
            unloading,
            ..Interpretation::exact()
        };
        let model = BlockAndBracket::from_caption(&caption, &reading)?;
        let end = solve(&model, 0.0, start, RIG_SPAN, &Options::tol(TOLERANCE))?;
        Ok((end.x_end - newton).amax())
    };
    let (printed, corrected) = (with(Unloading::Plain)?, with(Unloading::OverMu0)?);
    let holds = corrected < 1e-6 && printed > 1e-3;
    Ok(Proof::new(
        "friction_counted_twice",
        [printed, corrected],
        holds,
    ))
}

/// Two rigs with different units of time have the same Eq. (27).
pub(super) fn unit_of_time() -> Result<Proof, Error> {
    let slow = rig(9.81, 1.0);
    // Four times the stiffness and, to keep the unit of length, four times gravity. Speeds double.
    let fast = Rig {
        belt_speed: 2.0 * slow.belt_speed,
        delta: 0.5 * slow.delta,
        ..rig(4.0 * 9.81, 4.0)
    };
    let start = State::from([0.0, 0.01, 0.0, -0.05]);
    let apart = (rig_state(&slow, &start)? - rig_state(&fast, &start)?).amax();
    let (slow, fast) = (slow.time_unit(), fast.time_unit());
    let holds = (slow / fast - 2.0).abs() < 1e-12 && apart < 1e-6;
    Ok(Proof::new("unit_of_time", [slow, fast, apart], holds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_equations_run_at_two_paces() {
        // With the belt of the slow rig, the fast one is another system.
        let slow = rig(9.81, 1.0);
        let other = rig(4.0 * 9.81, 4.0);
        let start = State::from([0.0, 0.01, 0.0, -0.05]);
        let apart = rig_state(&slow, &start).unwrap() - rig_state(&other, &start).unwrap();
        assert!(apart.amax() > 1e-3);
    }
}
