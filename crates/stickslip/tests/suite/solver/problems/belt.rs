//! Oscillators with dry friction, on a floor at rest and on a belt, with orbits known to double
//! precision.

use std::f64::consts::PI;

use stickslip::TransitionKind::{Crossing, StickEntry, StickExit};
use stickslip::{Mode, State};

use super::super::check::{
    TIGHT, assert_consistent, assert_lands_on_boundary, changes, every_locator, kinds,
};
use crate::any_system::solve;
use crate::solver::systems::{Floor, decaying_friction};

/// Errors of 1e-13 per step add up over some fifty steps to less than 5e-12. The velocity across Σ
/// is at least 0.2, but its error is at most that of the amplitude, so event times are as accurate.
const EVENT: f64 = 1e-11;

fn assert_near(what: &str, value: f64, exact: f64, tolerance: f64) {
    let error = (value - exact).abs();
    assert!(
        error <= tolerance,
        "{what}: {value} is off {exact} by {error}"
    );
}

#[test]
fn swings_on_the_floor_end_at_multiples_of_pi_and_the_fourth_for_good() {
    for options in every_locator() {
        let orbit = solve(&Floor, 0.0, State::from([3.0, 0.0]), 40.0, &options).expect("runs");
        assert_eq!(kinds(&orbit), [Crossing, Crossing, Crossing, StickEntry]);
        for (k, (event, exact)) in orbit
            .transitions
            .iter()
            .zip([-2.2, 1.4, -0.6, -0.2])
            .enumerate()
        {
            assert_near("t", event.t, (k + 1) as f64 * PI, EVENT);
            assert_near("x", event.x[0], exact, EVENT);
        }
        assert_eq!(
            orbit.x_end[0], orbit.transitions[3].x[0],
            "a block at rest stays where it is"
        );
        assert_consistent(&Floor, &orbit);
        assert_lands_on_boundary(&Floor, &orbit);
    }
}

#[test]
fn decaying_friction_sticks_first_at_the_known_time_and_cycles_as_known() {
    let belt = decaying_friction();
    for options in every_locator() {
        let orbit = solve(&belt, 0.0, State::from([0.04, -0.01]), 60.0, &options).expect("runs");
        assert_consistent(&belt, &orbit);
        assert_lands_on_boundary(&belt, &orbit);
        let changes = changes(&orbit);
        for (i, change) in changes.iter().enumerate() {
            let kind = if i % 2 == 0 { StickEntry } else { StickExit };
            assert_eq!(change.kind, kind);
        }
        assert_near("first stick", changes[0].t, 0.244_688_801_783_297_8, 1e-13);
        for exit in changes.iter().skip(1).step_by(2) {
            assert_near("exit", exit.x[0], 1.0, 4.0 * f64::EPSILON);
        }
        for entry in changes.iter().skip(2).step_by(2) {
            assert_near("touch-down", entry.x[0], 0.094_518_907_971_834_62, EVENT);
        }
        for slip in orbit
            .phases
            .iter()
            .skip(2)
            .step_by(2)
            .filter(|p| p.t_end < orbit.t_end)
        {
            assert_near("slip", slip.duration(), 4.703_364_997_942_152, EVENT);
        }
        let exits: Vec<f64> = changes.iter().skip(1).step_by(2).map(|c| c.t).collect();
        assert!(exits.len() >= 6);
        for pair in exits.windows(2) {
            assert_near("period", pair[1] - pair[0], 9.230_770_458_082_98, EVENT);
        }
        for stick in orbit.sticks() {
            // Time and position are each rounded once, at sizes of at most 64 and 1.
            let length = stick.displacement()[0];
            assert_near(
                "length",
                length,
                0.2 * stick.duration(),
                0.2 * 64.0 * f64::EPSILON + f64::EPSILON,
            );
        }
    }
}

#[test]
fn a_state_at_rest_relative_to_the_belt_sticks_at_once() {
    let belt = decaying_friction();
    let options = super::super::tol(TIGHT);
    let orbit = solve(&belt, 0.0, State::from([0.3, 0.2]), 3.0, &options).expect("runs");
    assert_eq!(orbit.phases[0].mode, Mode::Stick);
    assert!(orbit.transitions.is_empty());
    assert_near("x", orbit.x_end[0], 0.9, 4.0 * f64::EPSILON);
}
