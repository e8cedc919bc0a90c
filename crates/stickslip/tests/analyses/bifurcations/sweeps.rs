//! Sweeps up and down, and changes of phases between two values.

use std::f64::consts::{LN_10, PI};

use crate::is_same_cycle;
use stickslip::analysis::{
    AttractorChange, AttractorKind, CycleBifurcation, Exponent, NotFollowed, RecurrenceSettings,
    SequenceBifurcation, SequenceChange, SpectrumOptions, StepBudget, SweepPoint, WhatChanges,
    locate_changes, sweep,
};
use stickslip::dynamics::{self, Components};
use stickslip::{Error, Mode, Options, Side, math, solve};

use super::branches::{accuracies, is_within};
use super::switching::Doubled;
use super::systems::{
    AtParameter, Beat, BeatFamily, DenHartogFamily, DrivenFamily, End, Ends, EndsFamily,
    FasterBelt, Rhythm, Twisted,
};
use crate::attractors::systems::{Driven, Rings};
use crate::compiled::Compiled;
use crate::den_hartog::DenHartog;

const ABOVE: Mode = Mode::Slip(Side::Above);
const BELOW: Mode = Mode::Slip(Side::Below);

/// Leaks a system, since those of the list are borrowed.
pub(super) fn leaked<S>(system: S) -> &'static S {
    Box::leak(Box::new(system))
}

/// A sweep, and the changes in it.
pub(super) struct Swept {
    pub points: Vec<SweepPoint>,
    pub changes: Vec<AttractorChange>,
}

/// A sweep through systems with one value of the parameter each, and what changes in it, located on
/// a system with the parameter as its last state.
pub(super) fn swept<S: dynamics::AsDynamics<One>, One, Any>(
    systems: (impl Fn(f64) -> S, &impl dynamics::AsDynamics<Any>),
    values: impl IntoIterator<Item = f64>,
    start: impl Components,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Swept {
    swept_and_located(systems, values, start, settings, [options; 2])
}

/// Sweeps as [`swept`], with options of its own for the location.
fn swept_and_located<S: dynamics::AsDynamics<One>, One, Any>(
    (family, system): (impl Fn(f64) -> S, &impl dynamics::AsDynamics<Any>),
    values: impl IntoIterator<Item = f64>,
    start: impl Components,
    settings: &RecurrenceSettings,
    [options, finer]: [&Options; 2],
) -> Swept {
    let points = sweep(family, values, start, (settings, None), options).unwrap();
    let changes = locate_changes(system, &points, settings.forcing, (finer, None)).unwrap();
    Swept { points, changes }
}

/// The only change in a sweep, a change of phases.
fn only(found: &Swept) -> &SequenceChange {
    let [change] = found.changes.as_slice() else {
        panic!("{:?}", found.changes);
    };
    match &change.what {
        WhatChanges::Sequence(change) => change,
        other => panic!("{other:?}"),
    }
}

/// Values from one to the other.
fn values(from: f64, to: f64, steps: u32) -> impl Iterator<Item = f64> {
    (0..=steps).map(move |k| from + (to - from) * f64::from(k) / f64::from(steps))
}

/// The change between two values, from the sweep up and from the sweep down, at any tolerance.
fn both_ways(
    rhythm: Rhythm,
    (from, to): (f64, f64),
    (name, exact): (SequenceBifurcation, f64),
) -> Vec<(f64, [SequenceChange; 2])> {
    let both = accuracies().map(|(tolerance, options)| {
        let ways = [(from, to), (to, from)].map(|(from, to)| {
            let settings = RecurrenceSettings::within(400.0).forced(2.0 * PI);
            let family = |p| leaked(Beat { rhythm, p }).dynamics();
            let any = leaked(BeatFamily(rhythm)).dynamics();
            let values = values(from, to, 3);
            let found = swept((family, &any), values, [-0.5], &settings, &options);
            check(only(&found), (name, exact), tolerance);
            only(&found).clone()
        });
        (tolerance, ways)
    });
    both.collect()
}

/// Changes of [`both_ways`], one after the other, each with its tolerance.
fn each_way(
    rhythm: Rhythm,
    ends: (f64, f64),
    expected: (SequenceBifurcation, f64),
) -> impl Iterator<Item = (f64, SequenceChange)> {
    let found = both_ways(rhythm, ends, expected).into_iter();
    found.flat_map(|(tolerance, ways)| ways.map(|change| (tolerance, change)))
}

/// A value of a sweep may hit the graze at p = 1, or lie where the orbit crosses by less than the
/// tolerances resolve.
#[test]
fn a_change_that_a_value_hits_is_located() {
    for (tolerance, options) in accuracies() {
        for (beyond, end) in [(0.0, 0.95), (0.0, 1.05), (1e-12, 0.95), (1e-12, 1.05)] {
            let settings = RecurrenceSettings::within(400.0).forced(2.0 * PI);
            let rhythm = Rhythm::Touch;
            let family = |p| leaked(Beat { rhythm, p }).dynamics();
            let values = [2.0 - end, 1.0 - beyond, end];
            let any = leaked(BeatFamily(rhythm)).dynamics();
            let found = swept((family, &any), values, [-0.5], &settings, &options);
            let change = only(&found);
            assert_eq!(change.bifurcation, SequenceBifurcation::GrazingSliding);
            // The place may be that of the value itself.
            is_within(
                0.9 * (change.parameter - 1.0),
                change.uncertainty,
                tolerance,
            );
        }
    }
}

fn check(change: &SequenceChange, (name, exact): (SequenceBifurcation, f64), tolerance: f64) {
    assert_eq!(change.bifurcation, name, "{change:?}");
    is_within(change.parameter - exact, change.uncertainty, tolerance);
    assert!(change.residual < 1e-4, "{change:?}");
}

/// The only change in a sweep, by a multiplier: its location, uncertainty and kind.
fn multiplier(found: &Swept) -> ([f64; 2], &CycleBifurcation) {
    let [change] = found.changes.as_slice() else {
        panic!("{:?}", found.changes);
    };
    match &change.what {
        WhatChanges::Multiplier {
            parameter,
            uncertainty,
            what,
            ..
        } => ([*parameter, *uncertainty], what),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_flip_a_torus_and_a_fold_of_an_attractor_are_located_and_named() {
    let settings = RecurrenceSettings::within(2000.0);
    for (tolerance, options) in accuracies() {
        let options = options.escape(100.0);
        for half_turn in [true, false] {
            let system = |value| AtParameter {
                system: Twisted { half_turn },
                value,
            };
            let settings = settings.forced(2.0 * PI);
            let family = |value| leaked(system(value)).dynamics();
            let any = leaked(Twisted { half_turn }).dynamics();
            let (values, start) = ([-0.1, 0.12], [1.01, 0.0]);
            let found = swept((family, &any), values, start, &settings, &options);
            let ([parameter, bound], what) = multiplier(&found);
            is_within(parameter, bound, tolerance);
            match *what {
                CycleBifurcation::Flip => assert!(half_turn),
                CycleBifurcation::NeimarkSacker { angle } => {
                    assert!(
                        !half_turn && (angle - 0.6 * PI).abs() < 1e3 * tolerance,
                        "{angle}"
                    );
                }
                ref other => panic!("{other:?}"),
            }
        }
        let system = |value| AtParameter {
            system: Rings { place: 50.0 },
            value,
        };
        let family = |value| leaked(system(value)).dynamics();
        let any = leaked(Rings { place: 50.0 }).dynamics();
        let (values, start) = ([-0.8, -1.1], [1.3, 0.0]);
        let found = swept((family, &any), values, start, &settings, &options);
        let ([parameter, bound], what) = multiplier(&found);
        is_within(parameter + 1.0, bound, tolerance);
        assert_eq!(*what, CycleBifurcation::Fold);
    }
}

/// A value of the sweep may hit a change exactly: it belongs to the pair that ends there. On one
/// side the orbit of twice the period folds at the flip, which has the name by the shorter orbit.
#[test]
fn a_flip_that_a_value_of_the_sweep_hits_is_reported_once() {
    let settings = RecurrenceSettings::within(2000.0).forced(2.0 * PI);
    // At looser tolerances a flip is located less precisely than a value can hit it.
    let finer = Options::tol(1e-13);
    for (_, options) in accuracies() {
        let family = |value| {
            let system = Doubled;
            leaked(AtParameter { system, value }).dynamics()
        };
        let any = Doubled.dynamics();
        let (values, start) = ([0.1, 0.0, -0.1], [1.01, 0.0]);
        let with = [&options, &finer];
        let found = swept_and_located((family, &any), values, start, &settings, with);
        let ([parameter, bound], what) = multiplier(&found);
        is_within(parameter, bound, finer.rtol);
        assert_eq!(*what, CycleBifurcation::Flip);
    }
}

#[test]
fn grazing_sliding_where_the_orbit_touches_the_boundary() {
    // y = sin t under y = p.
    let expected = (SequenceBifurcation::GrazingSliding, 1.0);
    for (tolerance, [up, down]) in both_ways(Rhythm::Touch, (0.8, 1.2), expected) {
        for change in [&up, &down] {
            assert!((change.x[0] - 1.0).abs() < 100.0 * tolerance);
            // It is tangent from below, with the curvature of the sine. From above it is pushed
            // down.
            assert!(change.own[0].abs() < 10.0 * tolerance.sqrt());
            assert!((change.own[1] - 1.0).abs() < 1e-3);
            assert_eq!(change.other[0], -1.0);
        }
        assert_eq!(down.before, [BELOW]);
        assert!(is_same_cycle(&down.after, &[BELOW, Mode::Stick]));
        assert!(is_same_cycle(&up.before, &[BELOW, Mode::Stick]));
    }
}

#[test]
fn adding_sliding_where_the_stick_touches_its_edge() {
    // The field above points down by 1 - p cos t, at least by 1 - p.
    let expected = (SequenceBifurcation::AddingSliding, 1.0);
    for (_, change) in each_way(Rhythm::Part, (0.9, 1.1), expected) {
        let long = [ABOVE, Mode::Stick, BELOW, Mode::Stick];
        let short = [Mode::Stick, BELOW];
        let (a, b) = (&change.before, &change.after);
        assert!(
            is_same_cycle(a, &long) && is_same_cycle(b, &short)
                || is_same_cycle(b, &long) && is_same_cycle(a, &short)
        );
    }
}

/// Landing of `Rhythm::Meet` from below: `(t - t₀)/2 - cos t + cos t₀ = 0` for `t > t₀ = 7π/6`.
pub fn landing() -> f64 {
    let start = 7.0 * PI / 6.0;
    let height = |t: f64| 0.5 * (t - start) - math::cos(t) + math::cos(start);
    let (mut a, mut b) = (2.0 * PI, 7.2);
    assert!(height(a) < 0.0 && height(b) > 0.0);
    for _ in 0..80 {
        let middle = 0.5 * (a + b);
        if height(middle) < 0.0 {
            a = middle
        } else {
            b = middle
        }
    }
    a
}

#[test]
fn crossing_sliding_where_the_field_above_begins_to_lead_away() {
    // sin(t - p) rises through 7/10.
    let rises = math::atan(0.7 / 0.51_f64.sqrt());
    let exact = landing() - rises;
    let (ends, expected) = (
        (exact - 0.11, exact + 0.1),
        (SequenceBifurcation::CrossingSliding, exact),
    );
    for (tolerance, change) in each_way(Rhythm::Meet, ends, expected) {
        assert!(change.own[0] < -0.1 && change.other[0].abs() < 100.0 * tolerance);
        // Away from the boundary at cos(t - p) = √0.51.
        assert!((change.other[1] - 0.51_f64.sqrt()).abs() < 1e-6);
    }
}

#[test]
fn switching_sliding_where_the_field_above_ceases_to_lead_away() {
    // sin(t - p) falls through 7/10.
    let falls = PI - math::atan(0.7 / 0.51_f64.sqrt());
    let exact = landing() - falls;
    let (ends, expected) = (
        (exact - 0.11, exact + 0.1),
        (SequenceBifurcation::SwitchingSliding, exact),
    );
    for (tolerance, change) in each_way(Rhythm::Meet, ends, expected) {
        assert!(change.own[0] < -0.1 && change.other[0].abs() < 100.0 * tolerance);
        assert!((change.other[1] + 0.51_f64.sqrt()).abs() < 1e-6);
    }
}

#[test]
fn a_contact_grazes_where_its_function_touches_zero() {
    // p - cos t.
    let expected = (SequenceBifurcation::ContactGrazing, 1.0);
    both_ways(Rhythm::Lift, (0.8, 1.2), expected);
}

#[test]
fn den_hartog_s_orbits_have_stops_from_his_edge_on() {
    for frequency in [0.6, 0.7, 0.8, 1.25] {
        // At the stop, friction just holds: A O² = S, with A² = V² - S² U².
        let v = 1.0 / (1.0 - frequency * frequency);
        let angle = PI / frequency;
        let u = math::sin(angle) / (frequency * (1.0 + math::cos(angle)));
        let edge = v.abs() / (u * u + 1.0 / (frequency * frequency * frequency * frequency)).sqrt();
        let family = |friction| {
            leaked(DenHartog {
                frequency,
                friction,
            })
            .dynamics()
        };
        let settings = RecurrenceSettings::within(2e3).forced(2.0 * PI / frequency);
        let values = [edge - 0.02, edge + 0.03];
        let any = leaked(DenHartogFamily { frequency }).dynamics();
        for (tolerance, options) in accuracies() {
            let found = swept((family, &any), values, [1.0, 0.0], &settings, &options);
            let change = only(&found);
            check(
                change,
                (SequenceBifurcation::CrossingSliding, edge),
                tolerance,
            );
            assert!(is_same_cycle(&change.before, &[ABOVE, BELOW]));
            assert!((change.x[0].abs() - edge / (frequency * frequency)).abs() < 1e-6);
        }
    }
}

/// Rounding decides whether the focus is stable at such a value.
#[test]
fn a_loss_of_stability_that_a_value_of_the_sweep_hits_is_located() {
    let focus = 0.5 * LN_10;
    let family = |vd| leaked(Driven { vd }).dynamics();
    for hit in [focus.next_down(), focus, focus.next_up()] {
        let settings = RecurrenceSettings::within(200.0);
        let any = DrivenFamily.dynamics();
        let (values, start) = ([1.3, hit], [0.55, 0.0]);
        for (_, options) in accuracies() {
            let found = swept((family, &any), values, start, &settings, &options);
            let [change] = found.changes.as_slice() else {
                panic!("{:?}", found.points);
            };
            let WhatChanges::Equilibrium { parameter, .. } = &change.what else {
                panic!("{change:?}");
            };
            assert!((parameter - focus).abs() < 1e-12, "{parameter}");
        }
    }
}

#[test]
fn the_ends_of_bistability_are_found_by_sweeps_up_and_down() {
    // At half the logarithm of ten the falling friction cancels all damping: 0.1 = e^(-2 vd).
    let focus = 0.5 * LN_10;
    let family = |vd| leaked(Driven { vd }).dynamics();
    let settings = RecurrenceSettings::within(3e4);
    let (any, tolerance) = (DrivenFamily.dynamics(), 1e-10);
    let options = Options::tol(tolerance);
    let (values_down, start) = (values(1.3, 1.0, 6), [0.55, 0.0]);
    let down = swept((family, &any), values_down, start, &settings, &options);
    let [change] = down.changes.as_slice() else {
        panic!("{:?}", down.changes);
    };
    let WhatChanges::Equilibrium {
        parameter,
        x,
        frequency,
    } = &change.what
    else {
        panic!("{change:?}");
    };
    assert!((parameter - focus).abs() < 1e-12, "{parameter}");
    assert!((frequency - 1.0).abs() < 1e-12 && (x[0] - 0.55).abs() < 1e-12);
    // Upwards from there the block continues its stick–slip motion, until the cycle only touches
    // the belt's speed.
    let (values_up, start) = (values(1.0, 2.0, 50), [0.0, 0.0]);
    let up = swept((family, &any), values_up, start, &settings, &options);
    let touch = only(&up);
    check(
        touch,
        (SequenceBifurcation::GrazingSliding, touching()),
        tolerance,
    );
    assert!(is_same_cycle(&touch.before, &[Mode::Stick, BELOW]));
    assert_eq!(touch.after, [BELOW], "the unstable cycle of slip alone");
    // Between the two values the motion depends on the direction of the sweep.
    let at = |found: &Swept, vd: f64| {
        let point = found
            .points
            .iter()
            .find(|point| (point.parameter - vd).abs() < 1e-9);
        point.expect("was swept").reached.kind.clone()
    };
    assert_eq!(at(&down, 1.2), AttractorKind::Equilibrium);
    assert!(matches!(
        at(&up, 1.2),
        AttractorKind::Periodic { returns: 2, .. }
    ));
    assert_eq!(at(&up, 2.0), AttractorKind::Equilibrium);
}

/// Static friction, in units of the kinetic one, above which a released block returns to the belt's
/// speed. With ω² = 1 - ζ² its velocity is R exp(-ζt) cos(ωt + φ), R cos φ = 1, R sin φ = (z +
/// ζ)/ω, and z = `ratio` - 2ζ - 1. It is largest where ωt + φ = 2π - atan(ζ/ω).
pub fn coming_back(damping: f64) -> f64 {
    let omega = (1.0 - damping * damping).sqrt();
    let highest = |ratio: f64| {
        let sine = (ratio - damping - 1.0) / omega;
        let angle = 2.0 * PI - math::atan(damping / omega) - math::atan(sine);
        (1.0 + sine * sine).sqrt() * math::exp(-damping * angle / omega) * omega
    };
    let (mut a, mut b) = (1.2, 3.0);
    assert!(highest(a) < 1.0 && highest(b) > 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if highest(middle) < 1.0 {
            a = middle
        } else {
            b = middle
        }
    }
    a
}

#[test]
fn with_static_friction_the_graze_that_ends_stick_and_slip_is_located_and_named() {
    let exact = coming_back(FasterBelt::DAMPING);
    let settings = RecurrenceSettings::within(3e3);
    let both = [0.02, 0.1].into_iter();
    for (width, (tolerance, options)) in
        both.flat_map(|width| accuracies().map(move |one| (width, one)))
    {
        let system = |value| AtParameter {
            system: FasterBelt,
            value,
        };
        let family = |ratio| leaked(system(ratio)).dynamics();
        let ends = [exact + 0.6 * width, exact - 0.4 * width];
        let any = FasterBelt.dynamics();
        let found = swept((family, &any), ends, [0.0, 1.0], &settings, &options);
        let kinds = [0, 1].map(|k| found.points[k].reached.kind.clone());
        assert!(
            matches!(kinds[0], AttractorKind::Periodic { .. }),
            "{}",
            kinds[0]
        );
        assert_eq!(kinds[1], AttractorKind::Equilibrium);
        let change = only(&found);
        check(
            change,
            (SequenceBifurcation::GrazingSliding, exact),
            tolerance,
        );
        assert!(is_same_cycle(&change.before, &[Mode::Stick, BELOW]));
        // Beyond it this orbit does not continue.
        assert_eq!(
            (change.after.as_slice(), change.contacts.as_slice()),
            (&[][..], &[0][..])
        );
        // At the belt's speed, where kinetic friction and spring balance: 1 = x + 2ζ.
        assert!((change.x[1] - 1.0).abs() < 1e-12);
        assert!(
            (change.x[0] - (1.0 - 2.0 * FasterBelt::DAMPING)).abs() < 1e-4,
            "{change:?}"
        );
        assert!(change.own[0].abs() < 1e-4 && (change.other[0] + 2.0).abs() < 1e-4);
    }
}

#[test]
fn an_orbit_that_ends_or_fails_is_reported_and_the_next_one_begins_anew() {
    let options = Options::tol(1e-10).escape(20.0);
    let settings = RecurrenceSettings::within(1e3);
    for end in [End::TwoFold, End::Pole] {
        let family = |p| leaked(Ends { end, p }).dynamics();
        let start = [-1.0, if end == End::TwoFold { 0.0 } else { 1.0 }];
        let any = leaked(EndsFamily(end)).dynamics();
        let found = swept((family, &any), [1.0, -1.0], start, &settings, &options);
        let [ended, escaped] = found.points.as_slice() else {
            panic!("{:?}", found.points);
        };
        let ended = &ended.reached;
        match (end, &ended.kind) {
            (End::TwoFold, AttractorKind::TwoFold(_)) => {
                assert!((ended.t - 2.0 / 3.0).abs() < 1e-6 && ended.x.amax() < 1e-6);
            }
            (
                End::Pole,
                AttractorKind::Failure(Error::StepCollapse { t, .. } | Error::NonFinite { t, .. }),
            ) => {
                assert!((t - 0.5).abs() < 1e-3, "{t}");
            }
            (_, other) => panic!("{end:?}: {other}"),
        }
        // From the start again and not from the end of the first one: x = -1 - 3t/2, or x² = 1 +
        // 2t.
        assert_eq!(escaped.reached.kind, AttractorKind::Escape);
        let (t, x) = (escaped.reached.t, escaped.reached.x[0]);
        let start = match end {
            End::TwoFold => x + 1.5 * t,
            End::Pole => 2.0 * t - x * x,
        };
        assert!(x < -20.0 && (start + 1.0).abs() < 1e-6, "{t} {x}");
        let [AttractorChange { between, what }] = found.changes.as_slice() else {
            panic!("{:?}", found.changes);
        };
        assert_eq!((*between, what), ((1.0, -1.0), &WhatChanges::Unlocated));
    }
}

/// The belt's speed at which the orbit that leaves the belt at the tangent point returns to it.
/// Below it a turn meets the belt, above it does not.
pub fn touching() -> f64 {
    let meets = |vd: f64| {
        let tangent = [1.0 - 0.1 * vd, vd];
        let system = Driven { vd };
        let orbit = solve(&system.any(), 0.0, tangent, 9.0, &Options::tol(1e-14)).unwrap();
        orbit.transitions.iter().any(|at| at.t > 3.0)
    };
    let (mut a, mut b) = (1.7, 2.0);
    assert!(meets(a) && !meets(b));
    for _ in 0..50 {
        let middle = 0.5 * (a + b);
        if meets(middle) {
            a = middle
        } else {
            b = middle
        }
    }
    a
}

#[test]
fn exponents_are_measured_where_they_are_asked_for() {
    let family = |vd| leaked(Driven { vd }).dynamics();
    let settings = RecurrenceSettings::within(3e4);
    let spectrum = SpectrumOptions::over(50.0, 500.0);
    let found = sweep(
        family,
        [1.5, 1.9],
        [0.0, 1.5],
        (&settings, Some(&spectrum)),
        &Options::tol(1e-9),
    )
    .unwrap();
    let [cycle, rest] = [0, 1].map(|k| found[k].exponent);
    assert!(matches!(cycle, Some(Exponent::Finite { value, .. }) if value.abs() < 1e-2));
    // Half of the remaining damping: (0.1 - e^(-2 vd))/2.
    let exact = -0.5 * (0.1 - math::exp(-3.8));
    assert!((rest.unwrap().value() - exact).abs() < 1e-3);
}

#[test]
fn changes_are_located_on_a_system_with_the_parameter_as_its_last_state_only() {
    let family = |vd| leaked(Driven { vd }).dynamics();
    let (settings, options) = (RecurrenceSettings::within(3e4), Options::tol(1e-9));
    let points = sweep(family, [1.5, 1.9], [0.0, 1.5], (&settings, None), &options).unwrap();
    let refused = locate_changes(&family(1.5), &points, None, (&options, None)).unwrap_err();
    let Error::Parameter { name, value, .. } = refused else {
        panic!("{refused}");
    };
    assert_eq!((name, value), ("the number of states", 2.0));
}

#[test]
fn changes_are_followed_within_a_budget_of_steps() {
    let family = |vd| leaked(Driven { vd }).dynamics();
    let (settings, options) = (RecurrenceSettings::within(3e4), Options::tol(1e-9));
    let points = sweep(family, [1.5, 1.9], [0.0, 1.5], (&settings, None), &options).unwrap();
    let taken: Vec<u64> = points.iter().map(|point| point.reached.steps).collect();
    assert!(taken.iter().all(|steps| *steps > 10), "{taken:?}");
    let finer = Options::tol(1e-13);
    let within = |budget: &StepBudget| {
        locate_changes(&DrivenFamily, &points, None, (&finer, Some(budget))).unwrap()
    };
    let ample = StepBudget::of(1 << 40);
    let found = within(&ample);
    let all = locate_changes(&DrivenFamily, &points, None, (&finer, None)).unwrap();
    // Steps are longer within a budget.
    let [[own], [other]] = [&found[..], &all[..]] else {
        panic!("{found:?} {all:?}");
    };
    let place = |change: &AttractorChange| {
        let what = &change.what;
        (
            what.to_string(),
            what.parameter().unwrap(),
            what.uncertainty().unwrap(),
        )
    };
    let ((name, at, error), (other_name, other_at, other_error)) = (place(own), place(other));
    assert!(name == other_name && (at - other_at).abs() <= error + other_error && error < 1e-11);
    // What the orbit takes is not there, so that it is not begun.
    let taken = (1 << 40) - ample.left();
    let scarce = StepBudget::of(taken / 100);
    let [cut] = &within(&scarce)[..] else {
        panic!()
    };
    assert_eq!(cut.what, WhatChanges::NotFollowed(NotFollowed::Budget));
    assert_eq!(scarce.left(), taken / 100);
}
