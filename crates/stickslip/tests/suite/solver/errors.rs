//! Every error of the solver, by a run that causes it: its values, its message, and the orbit kept
//! up to it.

use std::time::{Duration, Instant};

use stickslip::Visibility;
use stickslip::error::readable;
use stickslip::{
    Approach, AtPileUp, Ending, Error, Failure, Method, Options, Orbit, State, TransitionKind,
    TwoFold, math,
};

use crate::any_system::solve;
use crate::compiled::Compiled;
use crate::constant_fields::ConstantFields;
use crate::solver::systems::{BlowUp, Ledge, Wall, Window, Zeno, decaying_friction};

pub fn failure<S: Compiled<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: State<N>,
    t_end: f64,
    options: &Options,
) -> Failure<Orbit<N>> {
    let start = Instant::now();
    let result = solve(system, t0, x0, t_end, options);
    assert!(
        start.elapsed() < Duration::from_secs(5),
        "an error comes promptly"
    );
    result.expect_err("must fail")
}

fn line(t0: f64, x0: f64, t_end: f64, options: &Options) -> Error {
    let failure = failure(
        &ConstantFields {
            below: 1.0,
            above: 1.0,
        },
        t0,
        State::from([x0]),
        t_end,
        options,
    );
    assert!(failure.partial.phases.is_empty() && failure.partial.steps.is_empty());
    failure.error
}

pub fn assert_says(error: &impl std::fmt::Display, words: &[&str]) {
    let message = error.to_string();
    for word in words {
        assert!(message.contains(word), "{message:?} lacks {word:?}");
    }
}

/// The kept part of a failed run: phases, steps and transitions join and reach the end of the
/// orbit.
pub fn assert_kept<const N: usize>(orbit: &Orbit<N>) {
    let (last, step) = (
        orbit.phases.last().expect("phases"),
        orbit.steps.last().expect("steps"),
    );
    assert_eq!((last.t_end, step.t_end), (orbit.t_end, orbit.t_end));
    assert_eq!(last.x_end, orbit.x_end);
    assert_eq!(orbit.phases[0].t_start, orbit.t_start);
    assert!(
        orbit
            .phases
            .windows(2)
            .all(|pair| pair[0].t_end == pair[1].t_start)
    );
    assert!(
        orbit
            .steps
            .windows(2)
            .all(|pair| pair[0].t_end == pair[1].t_start)
    );
    let middle = 0.5 * (orbit.t_start + orbit.t_end);
    assert!(
        orbit
            .at(middle)
            .expect("covered")
            .iter()
            .all(|v| v.is_finite())
    );
}

#[test]
fn times_that_make_no_interval() {
    let options = super::tol(1e-10);
    for (t0, t_end) in [
        (f64::NAN, 1.0),
        (0.0, f64::NAN),
        (0.0, f64::INFINITY),
        (f64::NEG_INFINITY, 0.0),
        (1.0, 1.0),
        (1.0, 0.0),
    ] {
        let error = line(t0, -1.0, t_end, &options);
        assert!(matches!(error, Error::Interval { .. }), "{error}");
        assert_says(
            &error,
            &[&t0.to_string(), &t_end.to_string(), "later than the start"],
        );
    }
}

#[test]
fn options_out_of_range() {
    let good = super::tol(1e-10);
    let bad_tolerances = [0.0, -1e-9, f64::NAN, f64::INFINITY, 1.0, 1e-300];
    for bad in bad_tolerances {
        for (options, name) in [
            (Options { rtol: bad, ..good }, "rtol"),
            (good.atol(bad), "atol"),
        ] {
            let error = line(0.0, -1.0, 1.0, &options);
            assert!(
                matches!(error, Error::Option { name: n, .. } if n == name),
                "{error}"
            );
            let least = if name == "rtol" { "1e-15" } else { "1e-280" };
            assert_says(
                &error,
                &[name, &readable(bad), &format!("between {least} and 0.1")],
            );
        }
    }
    for bad in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        assert_says(
            &line(0.0, -1.0, 1.0, &good.method(Method::Rk4 { step: bad })),
            &["method.step", "positive"],
        );
        assert_says(
            &line(
                0.0,
                -1.0,
                1.0,
                &Options {
                    first_step: Some(bad),
                    ..good
                },
            ),
            &["first_step", "positive"],
        );
    }
    for bad in [0.0, -1.0, f64::NAN] {
        assert_says(
            &line(0.0, -1.0, 1.0, &good.longest_step(bad)),
            &["longest_step", "positive"],
        );
        assert_says(
            &line(0.0, -1.0, 1.0, &good.escape(bad)),
            &["escape", "positive"],
        );
        assert_says(
            &line(
                0.0,
                -1.0,
                1.0,
                &Options {
                    pile_up_span: bad,
                    ..good
                },
            ),
            &["pile_up_span"],
        );
    }
    assert_says(
        &line(
            0.0,
            -1.0,
            1.0,
            &Options {
                touch: -1.0,
                ..good
            },
        ),
        &["touch", "at least 0"],
    );
    assert_says(
        &line(
            0.0,
            -1.0,
            1.0,
            &Options {
                pile_up_count: 1,
                ..good
            },
        ),
        &["pile_up_count", "1", "at least 2"],
    );
}

#[test]
fn starts_outside_the_domain() {
    for bad in [f64::NAN, f64::INFINITY] {
        let error = line(0.0, bad, 1.0, &super::tol(1e-10));
        assert!(
            matches!(error, Error::StartOutsideDomain { t: 0.0, .. }),
            "{error}"
        );
        assert_says(&error, &["the start itself", "finite"]);
    }
    // √(1 - x) at 2.
    let error = failure(&Wall, 0.5, State::from([2.0]), 1.0, &super::tol(1e-10)).error;
    assert!(matches!(error, Error::StartOutsideDomain { .. }), "{error}");
    assert_says(&error, &["t = 0.5", "(2)", "the field", "start elsewhere"]);
}

#[test]
fn a_solution_that_becomes_infinite_is_followed_to_within_rounding_of_that_time() {
    for &locator in super::LOCATORS {
        let failure = failure(
            &BlowUp,
            0.0,
            State::from([0.5]),
            10.0,
            &super::tol(1e-12).locator(locator),
        );
        let (Error::StepCollapse { t, .. } | Error::NonFinite { t, .. }) = failure.error else {
            panic!("{}", failure.error);
        };
        // The location of the pole is accurate to the tolerance.
        assert!((t - 2.0).abs() < 1e-10, "{t}");
        assert_kept(&failure.partial);
        assert_eq!(failure.partial.t_end, t);
        assert!((failure.partial.at(1.0).expect("covered")[0] - 1.0).abs() < 1e-10);
    }
}

#[test]
fn an_escape_bound_ends_the_run_just_beyond_it() {
    let options = super::tol(1e-10).escape(1e3);
    let failure = failure(&BlowUp, 0.0, State::from([0.5]), 10.0, &options);
    let Error::Escaped { t, ref x, bound } = failure.error else {
        panic!("{}", failure.error)
    };
    assert_eq!(bound, 1e3);
    assert!(
        x.0[0] > 1e3 && (t - (2.0 - 1.0 / x.0[0])).abs() < 1e-8,
        "{t} {x}"
    );
    assert_says(&failure.error, &["1000", "raise the escape bound"]);
    assert_kept(&failure.partial);
    // A start beyond the bound is reported at once.
    let far = line(0.0, -2e3, 1.0, &options);
    assert!(matches!(far, Error::Escaped { t: 0.0, .. }), "{far}");
}

#[test]
fn a_field_that_ends_on_the_way_is_an_error_at_its_edge() {
    let failure = failure(&Wall, 0.0, State::from([0.0]), 10.0, &super::tol(1e-10));
    let (Error::StepCollapse { t, ref x, .. } | Error::NonFinite { t, ref x, .. }) = failure.error
    else {
        panic!("{}", failure.error);
    };
    // u = √(1 - x) obeys 2u u' = -(1 + u): from u = 1 to 0 in time 2 (1 - ln 2).
    let edge = 2.0 * (1.0 - math::ln(2.0));
    assert!(
        (t - edge).abs() < 1e-8 && (x.0[0] - 1.0).abs() < 1e-8,
        "{t} {x}"
    );
    assert_kept(&failure.partial);
    assert_eq!(failure.partial.t_end, t);
}

#[test]
fn a_boundary_that_ends_on_the_way_is_an_error_at_its_edge() {
    let failure = failure(
        &Ledge,
        0.0,
        State::from([0.5, 0.4]),
        40.0,
        &super::tol(1e-10),
    );
    let Error::StepCollapse { ref x, .. } = failure.error else {
        panic!("{}", failure.error);
    };
    assert!(x.0[0].abs() < 1e-8, "{x}");
    assert_says(&failure.error, &["boundary", "not defined", "e-"]);
    assert_kept(&failure.partial);
    for transition in &failure.partial.transitions {
        assert!(transition.residual < 1e-9, "{transition:?}");
    }
}

#[test]
fn a_boundary_that_is_no_number_only_inside_a_step_ends_the_run_there_too() {
    // Only the window limits the steps; without it one step would pass it.
    let options = super::tol(1e-10);
    for (from, to) in [(3.0, 4.0), (2.0, 2.5)] {
        let window = Window { from, to };
        let failure = failure(&window, 0.0, State::from([0.0]), 6.0, &options);
        let Error::StepCollapse { ref x, .. } = failure.error else {
            panic!("{}", failure.error);
        };
        assert!((x.0[0] - from).abs() < 1e-8, "{x}");
        assert_kept(&failure.partial);
    }
}

#[test]
fn crossings_that_pile_up_are_reported_with_their_number() {
    // Twenty transitions in ten units of time exceed this limit, and no two-fold is near.
    let mut options = super::tol(1e-12);
    (options.pile_up_count, options.pile_up_span) = (20, 10.0);
    let failure = failure(
        &Zeno { brake: 0.1 },
        0.0,
        State::from([0.0, 1.0]),
        100.0,
        &options,
    );
    let Error::EventPileUp {
        count,
        span,
        ref contacts,
        ref accumulation,
        ..
    } = failure.error
    else {
        panic!("{}", failure.error)
    };
    assert!(count == 20 && span <= 10.0 * failure.partial.t_end.max(1.0));
    assert_eq!(contacts, &[0]);
    assert_says(&failure.error, &["20 transitions", "Zeno", "accumulation"]);
    assert_kept(&failure.partial);
    // The accumulation point is predicted early: a run that continues ends there.
    let accumulation = accumulation.as_deref().expect("a geometric series");
    let start = State::from([0.0, 1.0]);
    let orbit = solve(&Zeno { brake: 0.1 }, 0.0, start, 100.0, &super::tol(1e-12)).expect("runs");
    let off = (accumulation.t - orbit.t_end).abs();
    assert!(accumulation.t > failure.partial.t_end + 1.0);
    assert!(
        off < 1e-8 && accumulation.uncertainty < 1e-9,
        "{accumulation:?}"
    );
    assert!(accumulation.x.0.iter().all(|x| x.abs() < 1e-6));
}

#[test]
fn a_contact_does_not_rest_where_the_field_is_undefined() {
    // The brake is 0/0 at the two-fold.
    let options = super::tol(1e-12).at_pile_up(AtPileUp::Rest);
    let start = State::from([0.0, 1.0]);
    let orbit = solve(&Zeno { brake: 0.1 }, 0.0, start, 100.0, &options).expect("runs");
    assert!(
        matches!(orbit.ending, Ending::TwoFold(_)),
        "{:?}",
        orbit.ending
    );
}

#[test]
fn crossings_that_accumulate_end_at_the_two_fold_where_they_do() {
    for brake in [0.1, 0.2, 0.3, 0.5] {
        let start = State::from([0.0, 1.0]);
        let orbit = solve(&Zeno { brake }, 0.0, start, 100.0, &super::tol(1e-12)).expect("runs");
        let two_fold = TwoFold {
            below: Visibility::Invisible,
            above: Visibility::Invisible,
            approach: Approach::Crossings,
        };
        assert_eq!(orbit.ending, Ending::TwoFold(two_fold));
        let transitions = &orbit.transitions;
        assert!(
            transitions[..60]
                .iter()
                .all(|e| e.kind == TransitionKind::Crossing)
        );
        let times: Vec<f64> = transitions[..40].iter().map(|e| e.t).collect();
        let ratios: Vec<f64> = times
            .windows(3)
            .map(|w| (w[2] - w[1]) / (w[1] - w[0]))
            .collect();
        // Every excursion is a scaled copy of the previous one: 40 of them, the last of size 1e-8
        // or more, with errors of 1e-12.
        for ratio in &ratios[..15] {
            assert!(
                (ratio - ratios[0]).abs() < 1e-7 && *ratio < 0.95,
                "{ratios:?}"
            );
        }
        let accumulation = times[1] + (times[2] - times[1]) / (1.0 - ratios[0]);
        let t = orbit.t_end;
        assert!((t - accumulation).abs() < 1e-6, "{t} {accumulation}");
    }
}

#[test]
fn nothing_is_lost_of_an_orbit_that_fails_after_transitions() {
    let belt = decaying_friction();
    let options = super::tol(1e-10).longest_step(0.01).escape(1.02);
    // The slip after the first stick reaches x = 1.04.
    let failure = failure(&belt, 0.0, State::from([0.04, -0.01]), 100.0, &options);
    assert!(
        matches!(failure.error, Error::Escaped { .. }),
        "{}",
        failure.error
    );
    assert_kept(&failure.partial);
    let whole = solve(
        &belt,
        0.0,
        State::from([0.04, -0.01]),
        100.0,
        &options.escape(1e9),
    )
    .expect("runs");
    let kept = &failure.partial;
    assert_eq!(
        kept.transitions[..],
        whole.transitions[..kept.transitions.len()]
    );
    assert_eq!(kept.steps[..], whole.steps[..kept.steps.len()]);
    assert_eq!(kept.phases.len(), kept.transitions.len() + 1);
}

#[test]
fn times_outside_an_orbit() {
    let orbit = solve(&BlowUp, 0.0, State::from([0.5]), 1.0, &super::tol(1e-10)).expect("runs");
    for t in [-0.1, 1.1, f64::NAN] {
        let error = orbit.at(t).expect_err("outside");
        assert!(
            matches!(
                error,
                Error::OutsideOrbit {
                    from: 0.0,
                    to: 1.0,
                    ..
                }
            ),
            "{error}"
        );
        assert_says(&error, &[&t.to_string(), "covers 0.0 to 1.0"]);
    }
}
