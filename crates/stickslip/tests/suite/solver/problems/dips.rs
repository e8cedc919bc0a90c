//! Stick that is released for as little as 1e-5 time units, within a step of any length.

use stickslip::TransitionKind::{StickEntry, StickExit};
use stickslip::{Options, State};

use super::super::check::{TIGHT, assert_consistent, exact_locators, kinds};
use crate::any_system::solve;
use crate::solver::systems::Dip;

fn release(width: f64, centre: f64, amplitude: f64, options: &Options) {
    let dip = Dip {
        centre,
        width,
        amplitude,
    };
    let end = centre + 1.7;
    let orbit = solve(&dip, 0.0, State::from([0.0, 0.0]), end, options).expect("runs");
    assert_consistent(&dip, &orbit);
    let what = format!("width {width}, centre {centre}, amplitude {amplitude}, {options:?}");
    assert_eq!(kinds(&orbit), [StickExit, StickEntry], "{what}");
    let (exit, entry) = (orbit.transitions[0].t, orbit.transitions[1].t);
    let e = (
        (exit - (centre - width)).abs(),
        (entry - (centre + 2.0 * width)).abs(),
    );
    // The released push has slope 2 width. A few units in the last place of q², which are those of
    // the time (near the centre) times 2 width, move the exit by a few units of the time. A moving
    // Σ adds a velocity to the push, which is subtracted again. The slope converts its rounding
    // into time.
    let allowed = 16.0 * f64::EPSILON * (1.0 + centre) + f64::EPSILON * amplitude / (2.0 * width);
    assert!(e.0 < allowed, "exit {what}: {e:?}");
    assert!(e.1 < 1e-3 * width, "entry {what}: {e:?}");
}

#[test]
fn a_short_release_is_found_in_a_long_step() {
    for width in [0.3, 1e-2, 1e-3, 1e-4, 5e-6] {
        for centre in [0.77, 1.5, 3.3, 5.0] {
            for longest in [f64::INFINITY, 2.0, 0.31] {
                for locator in exact_locators() {
                    let options = super::super::tol(TIGHT)
                        .locator(locator)
                        .longest_step(longest);
                    release(width, centre, 0.0, &options);
                }
            }
        }
    }
}

#[test]
fn a_short_release_from_a_moving_boundary_is_found() {
    for width in [0.3, 1e-2, 1e-3] {
        for centre in [0.77, 3.3] {
            for locator in exact_locators() {
                let options = super::super::tol(TIGHT).locator(locator);
                release(width, centre, 0.5, &options);
            }
        }
    }
}
