//! Tests that do not depend on the default method: fixed-step methods and a parameter that is
//! refused. They run once, not for every method.

use stickslip::TransitionKind::Touch;
use stickslip::analysis::SpectrumOptions;
use stickslip::{Error, Method, Options, State};

use super::check::{TIGHT, kinds};
use super::errors::{assert_kept, assert_says, failure};
use super::problems::grazing::{assert_two_crossings, parabola};
use crate::any_system::lyapunov_spectrum_watched;
use crate::blocks::Block;
use crate::solver::systems::BlowUp;

#[test]
fn grazes_and_crossings_exactly_at_the_end_of_a_step_are_seen_once() {
    // Steps, starts and gaps are powers of two: every number of the run is exact.
    for step in [0.5, 0.25, 0.125, 0.0625] {
        let bounded = Options {
            first_step: Some(step),
            ..super::tol(TIGHT).longest_step(step)
        };
        for (method, fixed) in [
            ("RK4", super::tol(TIGHT).method(Method::Rk4 { step })),
            ("DOP853", bounded.method(Method::Dop853)),
        ] {
            for &locator in super::LOCATORS {
                let options = fixed.locator(locator);
                let at_rest = kinds(&parabola(0.0, -1.0, 3.0, &options));
                assert!(
                    at_rest.is_empty() || at_rest == [Touch],
                    "{method} {locator:?}: {at_rest:?}"
                );
                assert_eq!(kinds(&parabola(-1e-10, -1.0, 3.0, &options)), []);
                assert_two_crossings(&parabola(1e-10, -1.0, 3.0, &options), -1.0, 1e-10, locator);
                // Crossings at the ends of steps: x = ±0.5 and, with the shorter steps, ±0.0625.
                assert_two_crossings(&parabola(0.25, -1.0, 3.0, &options), -1.0, 0.25, locator);
                assert_two_crossings(
                    &parabola(1.0 / 256.0, -1.0, 3.0, &options),
                    -1.0,
                    1.0 / 256.0,
                    locator,
                );
            }
        }
    }
}

#[test]
fn fixed_steps_into_a_pole_are_reported_with_their_length() {
    let fixed = Options::default().method(Method::Rk4 { step: 0.01 });
    let failure = failure(&BlowUp, 0.0, State::from([0.5]), 10.0, &fixed);
    assert!(
        matches!(failure.error, Error::NonFinite { step: 0.01, .. }),
        "{}",
        failure.error
    );
    assert_says(&failure.error, &["0.01", "pole", "too long"]);
    assert_kept(&failure.partial);
}

#[test]
fn no_run_begins_with_parameters_out_of_range() {
    let belt = Block {
        mass: -1.0,
        ..Block::on_belt(1.0)
    };
    let refused = failure(&belt, 0.0, State::from([0.5, 0.1]), 1.0, &super::tol(1e-10));
    assert_says(&refused, &["mass", "-1", "positive"]);
    assert!(refused.partial.steps.is_empty());
    let settings = SpectrumOptions::over(1.0, 1.0);
    let spectrum = lyapunov_spectrum_watched(&belt, (0.0, [0.5, 0.1]), &settings, &mut ());
    assert_says(&spectrum.unwrap_err(), &["mass", "-1", "positive"]);
}
