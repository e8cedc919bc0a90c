//! Changes of phases beyond which static friction above the kinetic one releases by a jump,
//! compared with closed forms.

use std::f64::consts::PI;

use stickslip::analysis::{
    ContinuationSettings, CycleBifurcation, RecurrenceSettings, SequenceBifurcation, Stop,
    WhatChanges, continue_periodic_orbit,
};
use stickslip::dynamics::Modes;
use stickslip::{Mode, Options, Side, math, solve};

use super::branches::{accuracies, is_within};
use super::sweeps::{leaked, swept};
use super::systems::{AtParameter, Dragged, Grip};
use crate::compiled::Compiled;

const ABOVE: Mode = Mode::Slip(Side::Above);
const BELOW: Mode = Mode::Slip(Side::Below);

/// Position, velocity and acceleration in slip on a side, at a time after a position on the belt,
/// by the formula of the damped spring.
fn slip(side: Side, damping: f64, x: f64, t: f64) -> [f64; 3] {
    let (rest, rate) = (-side.sign(), -0.5 * damping);
    let angle = (1.0 - rate * rate).sqrt();
    let (cos, sin, size) = (
        math::cos(angle * t),
        math::sin(angle * t),
        math::exp(rate * t),
    );
    let (a, b) = (x - rest, (Grip::SPEED - rate * (x - rest)) / angle);
    let (along, across) = (a * cos + b * sin, b * cos - a * sin);
    let [x, v] = [rest + size * along, size * (rate * along + angle * across)];
    [x, v, -x - damping * v + rest]
}

/// A zero of a function between two points at which its signs differ.
fn zero(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    let sign = function(low).signum();
    assert!(sign * function(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if function(middle) * sign > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Position at which stick is released.
fn release(damping: f64) -> f64 {
    Grip::STATIC - damping * Grip::SPEED
}

/// Position at which the slip that begins there meets the belt again.
fn landing(damping: f64) -> f64 {
    let from = release(damping);
    let t = zero(3.0, 5.0, |t| {
        slip(Side::Below, damping, from, t)[1] - Grip::SPEED
    });
    slip(Side::Below, damping, from, t)[0]
}

/// The damping at which it lands where friction can just hold. With less damping it crosses at once
/// and returns to the position of release.
fn let_go() -> f64 {
    let room = |damping: f64| landing(damping) + Grip::STATIC + damping * Grip::SPEED;
    zero(-0.7, -0.6, room)
}

/// The period of slip below, slip above and stick, until the release.
fn period_with_slip_above(damping: f64) -> f64 {
    let from = release(damping);
    let faster = |side, from, t| slip(side, damping, from, t)[1] - Grip::SPEED;
    let below = zero(3.0, 5.0, |t| faster(Side::Below, from, t));
    let there = slip(Side::Below, damping, from, below)[0];
    let above = zero(1.0, 4.0, |t| faster(Side::Above, there, t));
    let stuck = slip(Side::Above, damping, there, above)[0];
    below + above + (from - stuck) / Grip::SPEED
}

/// The damping at which the following slip above ends just where stick is released.
fn no_stick() -> f64 {
    zero(-0.75, -0.7, |damping| {
        let from = landing(damping);
        let t = zero(1.0, 4.0, |t| {
            slip(Side::Above, damping, from, t)[1] - Grip::SPEED
        });
        slip(Side::Above, damping, from, t)[0] - release(damping)
    })
}

/// The damping at which the maximal velocity of the slip below equals the belt's.
fn touch() -> f64 {
    zero(0.2, 0.3, |damping| {
        let from = release(damping);
        let t = zero(4.0, 6.0, |t| slip(Side::Below, damping, from, t)[2]);
        slip(Side::Below, damping, from, t)[1] - Grip::SPEED
    })
}

#[test]
fn a_branch_goes_on_behind_a_jump_and_does_not_take_another_family_for_it() {
    let (lets_go, no_stick, touches) = (let_go(), no_stick(), touch());
    let steps = [
        (0.01, (-0.9, 0.5)),
        (0.02, (-1.0, 1.0)),
        (0.03, (-0.9, 0.5)),
    ]
    .into_iter();
    for ((step, range), (tolerance, options)) in
        steps.flat_map(|one| accuracies().map(move |at| (one, at)))
    {
        let settings = ContinuationSettings {
            step,
            most_points: 400,
            ..ContinuationSettings::over(range.0, range.1)
        };
        let start = [0.0, -1.0, 0.0];
        let [down, up] = [false, true].map(|upwards| {
            let start = start_of_cycle(start);
            continue_periodic_orbit(&Grip.dynamics(), start, 7.55, upwards, &settings, &options)
                .unwrap()
        });
        let expected = [
            (&down, lets_go, SequenceBifurcation::CrossingSliding, 3),
            (&down, no_stick, SequenceBifurcation::CrossingSliding, 2),
            (&up, touches, SequenceBifurcation::GrazingSliding, 0),
        ];
        for (k, (branch, place, name, phases)) in expected.into_iter().enumerate() {
            let at = &branch.special.get(k % 2).unwrap_or_else(|| {
                panic!(
                    "{k} {:?} {:?} {}",
                    branch.stop,
                    branch.special,
                    branch.points.last().unwrap().parameter
                )
            });
            let CycleBifurcation::Sequence(change) = &at.what else {
                panic!("{at:?}");
            };
            assert_eq!(
                (change.bifurcation, change.after.len()),
                (name, phases),
                "{change:?}"
            );
            is_within(at.parameter - place, change.uncertainty, tolerance);
        }
        // Beyond it there is no such orbit.
        assert_eq!(up.stop, Stop::SequenceEnds);
        let mut behind = 0;
        for point in down.points.iter().filter(|point| point.sequence.len() == 3) {
            assert_eq!(rotated(&point.sequence), [ABOVE, Mode::Stick, BELOW]);
            let exact = period_with_slip_above(point.parameter);
            let off = (point.period - exact).abs();
            assert!(off < 1e3 * tolerance, "{off:e} at {}", point.parameter);
            behind += 1;
        }
        assert!(behind > 1);
    }
}

/// A state of the undamped cycle, in the middle of its slip.
fn start_of_cycle(start: [f64; 3]) -> [f64; 3] {
    let [x, v, _] = slip(Side::Below, start[2], release(start[2]), 2.0);
    [x, v, start[2]]
}

/// The phases from the slip above onwards.
fn rotated(phases: &[Modes]) -> Vec<Modes> {
    let first = phases.iter().position(|mode| *mode == ABOVE).unwrap();
    let mut phases = phases.to_vec();
    phases.rotate_left(first);
    phases
}

#[test]
fn a_sweep_locates_them_however_wide_its_steps() {
    for values in [7_u32, 9, 13] {
        let dampings = (0..values).map(|k| -0.8 + 1.1 * f64::from(k) / f64::from(values - 1));
        let family = |value| AtParameter {
            system: Grip,
            value,
        };
        let family = |value| leaked(family(value)).dynamics();
        let settings = RecurrenceSettings::within(500.0);
        let any = Grip.dynamics();
        for (tolerance, options) in accuracies() {
            // With the least damping the motion grows without bound.
            let options = options.escape(100.0);
            let (all, start) = (dampings.clone(), [1.2, 0.3]);
            let found = swept((&family, &any), all, start, &settings, &options);
            let places = found
                .changes
                .iter()
                .filter_map(|change| match &change.what {
                    WhatChanges::Sequence(change) => Some((change.parameter, change.uncertainty)),
                    _ => None,
                });
            let places: Vec<(f64, f64)> = places.collect();
            let exact = [no_stick(), let_go(), touch()];
            // With the widest steps no value lies between the first two changes.
            let skipped = usize::from(values == 7);
            assert_eq!(places.len(), 3 - skipped, "{options:?}: {places:?}");
            for ((place, uncertainty), exact) in places.into_iter().zip(&exact[skipped..]) {
                is_within(place - exact, uncertainty, tolerance);
            }
        }
    }
}

/// The orbit before it ends in a fold. The orbit that the run then reaches began in a graze further
/// back. The two are unrelated.
#[test]
fn a_fold_is_reported_beside_the_graze_in_which_another_orbit_begins() {
    let period = 2.0 * PI / Dragged::PACE;
    let options = Options::tol(1e-12);
    let settings = ContinuationSettings::over(0.2, 0.4).forced(period);
    let begin = [0.5, 0.3, 0.35];
    let settled = solve(&Dragged.any(), 0.0, begin, 60.0 * period, &options).unwrap();
    let x = settled.x_end;
    let branch =
        continue_periodic_orbit(&Dragged.dynamics(), x, period, false, &settings, &options);
    let branch = branch.unwrap();
    let mut folds = branch
        .special
        .iter()
        .filter(|at| at.what == CycleBifurcation::Fold);
    let fold = folds.next().unwrap().parameter;
    let family = |value| {
        let system = AtParameter {
            system: Dragged,
            value,
        };
        leaked(system).dynamics()
    };
    let settings = RecurrenceSettings::within(4000.0).forced(period);
    let (any, options) = (Dragged.dynamics(), Options::tol(1e-10));
    let (values, start) = ([0.26, 0.23], [0.5, 0.3]);
    let found = swept((family, &any), values, start, &settings, &options);
    let [ends, begins] = found.changes.as_slice() else {
        panic!("{:?}", found.changes);
    };
    let WhatChanges::Multiplier {
        parameter,
        what: CycleBifurcation::Fold,
        ..
    } = ends.what
    else {
        panic!("{ends:?}");
    };
    assert!((parameter - fold).abs() < 1e-9, "{parameter} for {fold}");
    let WhatChanges::Sequence(change) = &begins.what else {
        panic!("{begins:?}");
    };
    assert_eq!(change.bifurcation, SequenceBifurcation::GrazingSliding);
    assert!(change.before.is_empty() && change.parameter < fold - 1e-3);
}
