//! Static friction above the kinetic one: stick ends where the spring exceeds it, and slip leaves Σ
//! across.

use stickslip::TransitionKind::{StickEntry, StickExit};
use stickslip::error::ContactFault;
use stickslip::{Error, Mode, Options, Side, State, math};

use super::super::check::{TIGHT, every_locator, kinds};
use crate::any_system::solve;
use crate::solver::systems::StaticFriction;

const SPEED: f64 = 0.2;
const AT_REST: f64 = 1.0;
const IN_SLIP: f64 = 0.6;

fn block(at_rest: f64) -> StaticFriction {
    StaticFriction {
        at_rest,
        in_slip: IN_SLIP,
    }
}

#[test]
fn sticks_and_slips_last_as_the_circles_say() {
    for options in every_locator() {
        let orbit = solve(&block(AT_REST), 0.0, [0.0, SPEED], 40.0, &options).expect("runs");
        // From rest at 0 to where the spring equals static friction; then circles about the kinetic
        // friction.
        let first = AT_REST / SPEED;
        let slip = 2.0 * (std::f64::consts::PI - math::atan((AT_REST - IN_SLIP) / SPEED));
        let stick = 2.0 * (AT_REST - IN_SLIP) / SPEED;
        let mut due = first;
        for (k, at) in orbit.transitions.iter().enumerate() {
            let (kind, x) = if k % 2 == 0 {
                (StickExit, AT_REST)
            } else {
                (StickEntry, 2.0 * IN_SLIP - AT_REST)
            };
            assert_eq!(at.kind, kind, "{at:?}");
            assert!((at.t - due).abs() < 2e-12, "{at:?}: {due}");
            assert!((at.x[0] - x).abs() < 2e-12, "{at:?}: {x}");
            due += if k % 2 == 0 { slip } else { stick };
        }
        assert!(due > 40.0 && orbit.transitions.len() > 4);
    }
}

#[test]
fn what_kinetic_friction_would_let_through_static_friction_stops() {
    // At x = 0.8 the spring exceeds kinetic friction but not static friction.
    let start = State::from([0.8, SPEED]);
    let mode = |at_rest| {
        let orbit = solve(&block(at_rest), 0.0, start, 0.1, &super::super::tol(TIGHT));
        orbit.expect("runs").phases[0].mode
    };
    assert_eq!(mode(AT_REST), Mode::Stick);
    assert_eq!(mode(IN_SLIP), Mode::Slip(Side::Below));
}

#[test]
fn the_same_friction_at_rest_changes_nothing() {
    let options = super::super::tol(TIGHT);
    let orbit = solve(&block(IN_SLIP), 0.0, [0.0, SPEED], 10.0, &options).expect("runs");
    assert_eq!(kinds(&orbit)[0], StickExit);
    // It leaves at a tangent point, and its circle returns to Σ exactly there.
    assert!((orbit.transitions[0].t - IN_SLIP / SPEED).abs() < 1e-12);
    assert!((orbit.transitions[0].x[0] - IN_SLIP).abs() < 1e-12);
}

#[test]
fn less_friction_at_rest_than_in_slip_is_an_error_that_says_so() {
    let failure = solve(&block(0.3), 0.0, [0.0, SPEED], 10.0, &Options::default()).unwrap_err();
    assert!(
        matches!(
            failure.error,
            Error::Contacts {
                fault: ContactFault::StaticBelowKinetic { contact: 0, ratio },
                ..
            } if (ratio - 0.5).abs() < 1e-12
        ),
        "{failure}"
    );
}
