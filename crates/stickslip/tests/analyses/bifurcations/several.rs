//! Changes of phases of several contacts: each is located and assigned to its contact.

use std::f64::consts::PI;

use crate::is_same_cycle;
use stickslip::analysis::{
    AttractorChange, AttractorKind, ContinuationSettings, CycleBifurcation, PeriodicOrbit,
    RecurrenceSettings, SequenceBifurcation, SequenceChange, Stop, WhatChanges, attractor,
    continue_periodic_orbit,
};
use stickslip::dynamics::Modes;
use stickslip::{Mode, Options, Several, Side, State, math, solve};

use super::branches::{accuracies, is_within};
use super::sweeps::swept;
use super::systems::{Beat, Duet, DuetFamily, Released, Rhythm, Stack};

const ABOVE: Mode = Mode::Slip(Side::Above);
const BELOW: Mode = Mode::Slip(Side::Below);

type Change = SequenceChange;

/// The changes from one value to another of the parameter of one of two contacts.
fn changes(
    rhythms: [Rhythm; 2],
    other: f64,
    varied: usize,
    (from, to): (f64, f64),
    options: &Options,
) -> Vec<Change> {
    let family = |p| {
        let of = |i: usize| Beat {
            rhythm: rhythms[i],
            p: if i == varied { p } else { other },
        };
        Several(Duet([of(0), of(1)]))
    };
    let settings = RecurrenceSettings::within(400.0).forced(2.0 * PI);
    let start = [-0.5, -0.4];
    let any = Several(DuetFamily {
        rhythms,
        p: other,
        varied,
    });
    let found = swept((family, &any), [from, to], start, &settings, options);
    let change = |change: AttractorChange| match change.what {
        WhatChanges::Sequence(change) => change,
        other => panic!("{other:?}"),
    };
    found.changes.into_iter().map(change).collect()
}

#[test]
fn each_change_is_located_and_assigned_to_its_contact() {
    // As for one contact alone: y = sin t touches y = p, and the field above points down by 1 - p
    // cos t.
    let of_one = [
        (Rhythm::Touch, SequenceBifurcation::GrazingSliding),
        (Rhythm::Part, SequenceBifurcation::AddingSliding),
    ];
    for (rhythm, name) in of_one {
        for varied in [0, 1] {
            for ends in [(0.97, 1.02), (1.02, 0.97)] {
                let mut rhythms = [Rhythm::Clock; 2];
                rhythms[varied] = rhythm;
                for (tolerance, options) in accuracies() {
                    let found = changes(rhythms, 2.0, varied, ends, &options);
                    let [change] = found.as_slice() else {
                        panic!("{found:?}");
                    };
                    assert_eq!(
                        (change.bifurcation, change.contacts.as_slice()),
                        (name, &[varied][..]),
                        "{change:?}"
                    );
                    is_within(change.parameter - 1.0, change.uncertainty, tolerance);
                    let of = |modes: &[Modes]| {
                        let mut of: Vec<Mode> =
                            modes.iter().map(|modes| modes.get(varied)).collect();
                        of.dedup();
                        of
                    };
                    let more = [of(&change.before), of(&change.after)];
                    assert!(more[0].len() != more[1].len(), "{more:?}");
                }
            }
        }
    }
}

#[test]
fn contacts_that_change_places_coincide_and_do_not_graze() {
    // They cross at 0 and π, and at p and p + π.
    for varied in [0, 1] {
        let both = [(-0.2, 0.3), (0.3, -0.2)].into_iter();
        for (ends, (tolerance, options)) in
            both.flat_map(|one| accuracies().map(move |at| (one, at)))
        {
            let found = changes([Rhythm::Clock; 2], 0.0, varied, ends, &options);
            let [change] = found.as_slice() else {
                panic!("{found:?}");
            };
            assert_eq!(change.bifurcation, SequenceBifurcation::Coincidence);
            is_within(change.parameter, change.uncertainty, tolerance);
            let mut contacts = change.contacts.clone();
            contacts.sort_unstable();
            assert_eq!(contacts, [0, 1]);
            let first = |of: usize| {
                let mut cycle = [
                    [BELOW, BELOW],
                    [ABOVE, ABOVE],
                    [ABOVE, ABOVE],
                    [BELOW, BELOW],
                ];
                cycle[1][1 - of] = BELOW;
                cycle[3][1 - of] = ABOVE;
                cycle
            };
            let is = |modes: &[Modes], of| is_same_cycle(modes, &first(of));
            let (a, b) = (&change.before, &change.after);
            assert!(is(a, 0) && is(b, 1) || is(a, 1) && is(b, 0), "{change:?}");
        }
    }
}

#[test]
fn the_attractor_of_two_is_that_of_each() {
    // Pushed up to the boundary at 1/2, the contact leaves it where sin t + cos t falls through
    // 1/2. The other one crosses at 0.3 and 0.3 + π.
    let of = |rhythm, p| Beat { rhythm, p };
    let system = Several(Duet([of(Rhythm::Touch, 0.5), of(Rhythm::Clock, 0.3)]));
    let settings = RecurrenceSettings::within(400.0).forced(2.0 * PI);
    for start in [[-0.5, 0.4], [0.2, -2.0]] {
        let found = attractor(&system, start, &settings, &Options::tol(1e-12)).unwrap();
        assert!(
            matches!(found.kind, AttractorKind::Periodic { returns: 1, .. }),
            "{}",
            found.kind
        );
        let ends = |contact: usize, mode: Mode| {
            let phases = found.phases.windows(2);
            let mut left = phases.filter(move |pair| {
                pair[0].mode.get(contact) == mode && pair[1].mode.get(contact) != mode
            });
            left.next().map(|pair| pair[0].t_end.rem_euclid(2.0 * PI))
        };
        // √2 sin(t + π/4) = 1/2, falling; the tangent of that angle is 1/√7.
        let leaves = 0.75 * PI - math::atan(1.0 / 7.0_f64.sqrt());
        let found_at = ends(0, Mode::Stick).expect("it leaves");
        assert!((found_at - leaves).abs() < 1e-9, "{found_at} for {leaves}");
        let rises = ends(1, BELOW).expect("it crosses");
        assert!((rises - 0.3).abs() < 1e-6, "{rises}");
    }
}

#[test]
fn a_branch_of_two_contacts_is_followed_through_the_change_of_one() {
    for varied in [0, 1] {
        let mut rhythms = [Rhythm::Part; 2];
        rhythms[varied] = Rhythm::Touch;
        let system = Several(DuetFamily {
            rhythms,
            p: 0.5,
            varied,
        });
        let settings = ContinuationSettings::over(0.9, 1.1).forced(2.0 * PI);
        let mut start = [0.0, 0.0, 0.95];
        start[1 - varied] = -0.1;
        for (tolerance, options) in accuracies() {
            let found =
                continue_periodic_orbit(&system, start, 2.0 * PI, true, &settings, &options);
            let found = found.unwrap();
            let named = found.special.iter().filter_map(|at| match &at.what {
                CycleBifurcation::Sequence(change) => Some((change.bifurcation, change)),
                _ => None,
            });
            let grazes: Vec<_> = named
                .filter(|(name, _)| *name == SequenceBifurcation::GrazingSliding)
                .collect();
            let [(_, graze)] = grazes.as_slice() else {
                panic!("{:?}", found.special);
            };
            assert_eq!(graze.contacts, [varied]);
            is_within(graze.parameter - 1.0, graze.uncertainty, tolerance);
            assert_eq!(found.stop, Stop::Range);
            assert!((found.points.last().unwrap().parameter - 1.1).abs() < 1e-12);
        }
    }
}

#[test]
fn a_contact_that_always_sticks_does_not_hide_what_the_other_does() {
    for varied in [0, 1] {
        let mut rhythms = [Rhythm::Hold; 2];
        rhythms[varied] = Rhythm::Touch;
        for ends in [(0.97, 1.02), (1.02, 0.97)] {
            for (tolerance, options) in accuracies() {
                let found = changes(rhythms, 2.0, varied, ends, &options);
                let [change] = found.as_slice() else {
                    panic!("{found:?}");
                };
                let name = (change.bifurcation, change.contacts.as_slice());
                assert_eq!(name, (SequenceBifurcation::GrazingSliding, &[varied][..]));
                is_within(change.parameter - 1.0, change.uncertainty, tolerance);
            }
        }
        let system = Several(DuetFamily {
            rhythms,
            p: 2.0,
            varied,
        });
        let settings = ContinuationSettings::over(0.9, 1.1).forced(2.0 * PI);
        for (p, upwards) in [(0.95, true), (1.05, false)] {
            let mut start = [0.0, 0.0, p];
            start[varied] = -0.1;
            for (tolerance, options) in accuracies() {
                let found =
                    continue_periodic_orbit(&system, start, 6.3, upwards, &settings, &options)
                        .unwrap();
                assert_eq!(found.stop, Stop::Range, "{:?}", found.special);
                let [graze] = found.special.as_slice() else {
                    panic!("{:?}", found.special);
                };
                is_within(graze.parameter - 1.0, graze.uncertainty, tolerance);
                for point in &found.points {
                    assert!(
                        point
                            .sequence
                            .iter()
                            .all(|modes| modes.get(1 - varied) == Mode::Stick)
                    );
                    let off = point.x[1 - varied] - math::sin(point.t);
                    assert!(off.abs() < 1e-14, "{off:e}");
                }
            }
        }
    }
}

/// The force that carries the upper block along is largest when the lower one turns back. With less
/// friction it slips just before that and after it. Both slips vanish there, in both halves of the
/// period, and the branch continues without them.
#[test]
fn a_slip_about_the_switch_of_another_contact_vanishes_at_a_known_friction() {
    let system = Several(Stack);
    let period = 2.0 * PI / Stack::PACE;
    let options = Options::tol(1e-12);
    // If it is always carried along, friction has no effect.
    let along = [0.0, 0.0, 0.0, 0.6];
    let along = solve(&system, 0.0, along, 40.0 * period, &options).unwrap();
    let along = PeriodicOrbit::near_forced(&system, 0.0, along.x_end, period, &options).unwrap();
    let start = State::from_column_slice(along.x.as_slice());
    let orbit = solve(&system, 0.0, start, period, &options).unwrap();
    let back = orbit.transitions.last().unwrap();
    let Mode::Slip(side) = back.from[0] else {
        panic!("{back:?}");
    };
    let force = math::cos(Stack::PACE * back.t) - back.x[0] - Stack::FLOOR * side.sign();
    let exact = (force * Stack::TOP / (1.0 + Stack::TOP)).abs();
    for (p, upwards) in [(0.5, true), (0.6, false)] {
        let begin = [0.0, 0.0, 0.0, p];
        let settled = solve(&system, 0.0, begin, 40.0 * period, &options).unwrap();
        let steps = [0.05, 0.1, 0.2].into_iter();
        for (step, (tolerance, options)) in
            steps.flat_map(|step| accuracies().map(move |at| (step, at)))
        {
            let settings = ContinuationSettings {
                step,
                ..ContinuationSettings::over(0.4, 0.8).forced(period)
            };
            let start = settled.x_end;
            let found =
                continue_periodic_orbit(&system, start, period, upwards, &settings, &options);
            let found = found.unwrap();
            let [special] = found.special.as_slice() else {
                panic!("{:?}", found.special);
            };
            let CycleBifurcation::Sequence(change) = &special.what else {
                panic!("{special:?}");
            };
            assert_eq!(change.bifurcation, SequenceBifurcation::Coincidence);
            is_within(change.parameter - exact, change.uncertainty, tolerance);
            let phases = [change.before.len(), change.after.len()];
            assert_eq!(phases, if upwards { [6, 2] } else { [2, 6] });
            assert_eq!(found.stop, Stop::Range, "from {p} by {step}");
        }
    }
}

/// A contact released by another contact's switch leaves its boundary there at every parameter.
#[test]
fn a_contact_that_another_one_lets_go_hides_no_change() {
    let settings = ContinuationSettings::over(0.9, 1.1).forced(2.0 * PI);
    for (p, upwards) in [(0.95, true), (1.05, false)] {
        for (tolerance, options) in accuracies() {
            let (system, start) = (Several(Released), [-0.05, 0.0, -0.1, p]);
            let found = continue_periodic_orbit(&system, start, 6.3, upwards, &settings, &options);
            let found = found.unwrap();
            assert_eq!(found.stop, Stop::Range, "{:?}", found.special);
            let [special] = found.special.as_slice() else {
                panic!("{:?}", found.special);
            };
            let CycleBifurcation::Sequence(change) = &special.what else {
                panic!("{special:?}");
            };
            let name = (change.bifurcation, change.contacts.as_slice());
            assert_eq!(name, (SequenceBifurcation::GrazingSliding, &[2][..]));
            is_within(change.parameter - 1.0, change.uncertainty, tolerance);
        }
    }
}
