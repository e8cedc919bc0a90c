//! The Appendix's program: its results, the effect of each defect, and that none of it changes.

use std::fmt::Write as _;

use approx::assert_abs_diff_eq;
use proptest::prelude::*;
use replication::paper::claim_id::ClaimId;
use replication::paper::listing::{
    Crossing, Defect, Defects, Motion, Run, Sample, Setup, Zone, ZoneEnd, run, run_with,
};
use replication::paper::models::ForcedOscillator;
use replication::paper::published::Claims;
use stickslip::{Mode, Side, math};

/// Samples of a run.
fn samples(setup: &Setup) -> Vec<Sample> {
    let mut kept = Vec::new();
    run_with(setup, |sample| kept.push(*sample));
    kept
}

fn printed(h: f64) -> Run {
    run(&Setup {
        h,
        ..Setup::default()
    })
}

/// A slip phase far from the belt's speed that lasts more than 0.1 s; in place it lasts a third of
/// that.
fn slipping(defects: Defects, h: f64) -> Setup {
    Setup {
        start: [0.0, 0.0, -1.0],
        defects,
        h,
        window_start: 0.0,
        end: 0.1,
        ..Setup::default()
    }
}

/// The state after 0.1 s of it, which is a whole number of steps.
fn after_a_tenth(defects: Defects, h: f64) -> [f64; 2] {
    let setup = slipping(defects, h);
    let steps = (0.1 / h).round() as usize;
    let phase = &samples(&setup)[..steps];
    assert!(
        phase
            .iter()
            .all(|sample| sample.mode == Mode::Slip(Side::Below)),
        "the comparison needs one smooth phase"
    );
    let last = phase[steps - 1];
    assert_abs_diff_eq!(last.t, 0.1, epsilon = 1e-12);
    [last.x1, last.x2]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// Observed order of a scheme, compared with the mended one at a tiny step.
fn observed_order(defects: Defects) -> f64 {
    let reference = after_a_tenth(Defects::MENDED, 1e-5);
    let error = |h| distance(after_a_tenth(defects, h), reference);
    math::ln(error(1e-2) / error(2.5e-3)) / math::ln(4.0)
}

#[test]
fn mended_slip_converges_with_order_four() {
    let order = observed_order(Defects::MENDED);
    assert!((3.8..4.3).contains(&order), "observed order {order}");
}

#[test]
fn frozen_forcing_alone_costs_three_orders() {
    let order = observed_order(Defects::MENDED.flipped(Defect::FrozenForcing));
    assert!((0.9..1.1).contains(&order), "observed order {order}");
}

#[test]
fn in_place_stages_do_not_converge_to_the_motion() {
    let reference = after_a_tenth(Defects::MENDED, 1e-5);
    let in_place = Defects::MENDED.flipped(Defect::InPlaceStages);
    let coarse = distance(after_a_tenth(in_place, 1e-3), reference);
    let fine = distance(after_a_tenth(in_place, 1e-5), reference);
    assert!(
        coarse > 0.1 && (fine / coarse - 1.0).abs() < 0.05,
        "errors {coarse} and {fine}"
    );
}

/// Largest |Δx1 − factor·h·x2| / h over the slip steps: the deviation from `factor` times the
/// field's displacement.
fn displacement_error(defects: Defects, h: f64, factor: f64) -> f64 {
    samples(&slipping(defects, h))
        .windows(2)
        .map(|pair| {
            (pair[1].x1 - pair[0].x1 - factor * h * pair[0].x2.midpoint(pair[1].x2)).abs() / h
        })
        .fold(0.0, f64::max)
}

#[test]
fn a_step_in_place_goes_three_times_as_far() {
    // With the factor 3 the deviation is of first order in h: halving h halves it. With the factor
    // 1 it stays.
    let (coarse, fine) = (
        displacement_error(Defects::AS_PRINTED, 1e-3, 3.0),
        displacement_error(Defects::AS_PRINTED, 1e-4, 3.0),
    );
    assert!(
        fine < 2e-3 && (8.0..12.0).contains(&(coarse / fine)),
        "{coarse}, {fine}"
    );
    assert!(displacement_error(Defects::AS_PRINTED, 1e-4, 1.0) > 0.5);
    assert!(displacement_error(Defects::MENDED, 1e-4, 1.0) < 1e-6);
}

#[test]
fn as_printed_it_gives_the_four_published_numbers() {
    let numbers = printed(1e-4).stick_numbers().unwrap();
    for (value, id) in numbers.into_iter().zip(ClaimId::STICK_NUMBERS) {
        let claim = Claims::committed().unwrap().of(id);
        assert!(
            claim.agrees(value),
            "{id}: {value} is not {}",
            claim.published
        );
    }
    assert_eq!(
        numbers.map(|value| format!("{value:.4}")),
        ["0.4697", "0.1663", "1.1746", "0.4161"]
    );
}

#[test]
fn as_printed_it_has_the_published_class_and_deflections() {
    let run = printed(1e-4);
    assert_eq!(
        run.motion,
        Motion::StickSlip {
            sticks: 2,
            period: 2
        }
    );
    let phases = run.settled_phases();
    assert_eq!(phases.len(), 2);
    assert!(
        phases
            .iter()
            .all(|phase| phase.zone == Some(Zone::Middle) && phase.end == ZoneEnd::Upper)
    );
    // Two deflections on the left in each pattern. The other crossings are corrections of the wrong
    // exit side.
    let last = run.crossings.last().unwrap().at.t - 1.99 * run.forcing_period;
    let pattern = run.crossings.iter().filter(|crossing| crossing.at.t > last);
    let (repairs, deflections): (Vec<&Crossing>, Vec<&Crossing>) =
        pattern.partition(|crossing| crossing.after_exit);
    assert_eq!((repairs.len(), deflections.len()), (2, 2));
    assert!(
        deflections
            .iter()
            .all(|c| c.to == Side::Above && c.at.x1 < -0.7)
    );
    assert!(repairs.iter().all(|c| c.to == Side::Below));
}

#[test]
fn length_and_duration_disagree_by_the_zero_time_correction() {
    // The exit is placed on the zone's end but the clock advances by the whole step: the
    // displacement is less than vp times the time.
    for phase in printed(1e-4).settled_phases() {
        let excess = phase.stick.duration() - phase.stick.length() / 0.4;
        assert!(excess > 1e-4 && excess < 4e-4, "{excess}");
    }
    // With that mended the two agree to rounding. In its transient to a motion without stick it
    // sticks a few times.
    let mended = Setup::with(Defects::MENDED);
    let phases = run(&mended).phases;
    assert!(!phases.is_empty(), "there is nothing to compare");
    for phase in phases {
        let ridden = phase.stick.length() / 0.4;
        assert_abs_diff_eq!(phase.stick.duration(), ridden, epsilon = 1e-12);
    }
}

#[test]
fn as_printed_time_advances_on_the_belt() {
    let mut previous: Option<Sample> = None;
    let mut ridden = 0;
    run_with(&Setup::default(), |sample| {
        if let Some(before) = previous.filter(|before| before.mode == Mode::Stick) {
            assert_eq!(sample.t, before.t + 1e-4);
            assert_eq!(sample.x2, 0.4);
            ridden += 1;
        }
        previous = Some(*sample);
    });
    assert!(ridden > 100_000, "{ridden}");
}

#[test]
fn the_window_is_the_listings() {
    let mut steps = Vec::new();
    run_with(&Setup::default(), |sample| {
        if sample.in_window {
            steps.push(sample.step);
        }
    });
    assert_eq!(
        (steps.first(), steps.last(), steps.len()),
        (Some(&600_000), Some(&633_000), 33_001)
    );
}

#[test]
fn stick_slip_needs_the_stages_in_place() {
    // Among the single defects only this one gives the published class, whatever the others are.
    for (defect, defects) in Defects::MENDED.one_flipped() {
        let motion = run(&Setup::with(defects)).motion;
        let sticks = matches!(motion, Motion::StickSlip { .. });
        assert_eq!(
            sticks,
            defect == Defect::InPlaceStages,
            "{}: {motion:?}",
            defect.name()
        );
    }
}

#[test]
fn mended_it_settles_on_slip_only_at_every_step() {
    for h in [1e-3, 1e-4] {
        let run = run(&Setup {
            defects: Defects::MENDED,
            h,
            ..Setup::default()
        });
        assert_eq!(run.motion, Motion::SlipOnly { period: 1 }, "h = {h}");
    }
}

#[test]
fn the_start_is_tested_in_all_zones_when_mended() {
    let tangent = Setup::default().tangent_points;
    let start = [0.0, tangent[4].midpoint(tangent[5]), 0.4];
    let starts_sticking = |defects| {
        let setup = Setup {
            start,
            defects,
            end: 0.01,
            window_start: 0.0,
            ..Setup::default()
        };
        let run = run(&setup);
        run.phases
            .first()
            .map(|phase| phase.stick.entry)
            .or(run.unfinished.map(|(entry, _)| entry))
            .unwrap()
            .t
            == 0.0
    };
    assert!(!starts_sticking(Defects::AS_PRINTED));
    assert!(starts_sticking(
        Defects::AS_PRINTED.flipped(Defect::StartUpTest)
    ));
}

#[test]
fn a_body_beyond_the_spring_escapes() {
    for defects in [Defects::AS_PRINTED, Defects::MENDED] {
        match run(&Setup {
            start: [0.0, 1.5, 2.0],
            defects,
            ..Setup::default()
        })
        .motion
        {
            Motion::Escaped { t } => assert!(t < 5.0),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_henon_step_without_acceleration_breaks_down() {
    // Without friction a zone is a point, and the body leaves it with zero acceleration.
    let model = ForcedOscillator {
        mu0: 0.0,
        amplitude: 0.0,
        ..ForcedOscillator::default()
    };
    let defects = Defects::MENDED.flipped(Defect::ReversedExitSide);
    let motion = run(&Setup {
        model,
        tangent_points: [1.0, 1.0, 0.0, 0.0, -1.0, -1.0],
        start: [0.0, 0.0, 0.4],
        defects,
        ..Setup::default()
    })
    .motion;
    assert!(
        matches!(motion, Motion::BrokenDown { t } if t < 1.0),
        "{motion:?}"
    );
}

#[test]
fn flipping_a_defect_flips_it_alone() {
    for (defect, defects) in Defects::AS_PRINTED.one_flipped() {
        for other in Defect::ALL {
            assert_eq!(defects.has(other), other != defect);
        }
        assert_eq!(defects.flipped(defect), Defects::AS_PRINTED);
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Any start with any of the 128 sets of defects ends in a typed outcome. Stuck bodies move
    /// with the belt, and all results are finite.
    #[test]
    fn every_variant_ends(x1 in -1.3..1.3, x2 in -1.5..1.5, mended in 0u32..128) {
        let mut defects = Defects::AS_PRINTED;
        for (bit, defect) in Defect::ALL.into_iter().enumerate() {
            if mended >> bit & 1 == 1 {
                defects = defects.flipped(defect);
            }
        }
        let start = [0.0, x1, x2];
        let setup = Setup {
            start,
            defects,
            h: 1e-3,
            window_start: 0.0,
            end: 6.0,
            ..Setup::default()
        };
        let mut previous: Option<Sample> = None;
        run_with(&setup, |sample| {
            assert!(sample.t.is_finite() && sample.x1.is_finite() && sample.x2.is_finite());
            if let Some(before) = previous.filter(|before| before.mode == Mode::Stick) {
                assert_eq!(sample.x2, 0.4);
                if sample.mode == Mode::Stick {
                    assert!(sample.t > before.t && sample.x1 > before.x1);
                }
            }
            previous = Some(*sample);
        });
    }
}

/// One line of the table: name, the four numbers in full precision, the class.
fn line(table: &mut String, name: &str, setup: &Setup) {
    let run = run(setup);
    let numbers = match run.stick_numbers() {
        Some(numbers) => numbers.map(|value| format!("{value:<20?}")).join(" "),
        None => "-".to_owned(),
    };
    writeln!(table, "{name:<44} {numbers:<84} {:?}", run.motion).unwrap();
}

#[test]
fn the_matrix_is_frozen() {
    let mut table = String::from(
        "case; lengths of the two longest stick phases (m), their durations (s); class of the \
            settled motion\n",
    );
    for h in [1e-3, 2e-4, 1e-4, 5e-5] {
        line(
            &mut table,
            &format!("as printed, h = {h:?}"),
            &Setup {
                h,
                ..Setup::default()
            },
        );
    }
    for (defect, defects) in Defects::AS_PRINTED.one_flipped() {
        line(
            &mut table,
            &format!("mended: {}", defect.name()),
            &Setup::with(defects),
        );
    }
    for second in [Defect::ReversedExitSide, Defect::S2StepSign] {
        let defects = Defects::AS_PRINTED
            .flipped(Defect::InPlaceStages)
            .flipped(second);
        let name = format!("mended: in_place_stages, {}", second.name());
        line(&mut table, &name, &Setup::with(defects));
    }
    line(&mut table, "mended: all", &Setup::with(Defects::MENDED));
    for (defect, defects) in Defects::MENDED.one_flipped() {
        line(
            &mut table,
            &format!("mended: only {} present", defect.name()),
            &Setup::with(defects),
        );
    }
    insta::with_settings!({
        snapshot_path => "../golden",
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, {
        insta::assert_snapshot!("listing", table);
    });
}
