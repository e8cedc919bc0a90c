//! Model 3: its derivation, stick condition and readings. Its figures are tested in
//! `report/block_and_bracket.rs`, which computes them once.

use std::fmt::Write;

use approx::assert_abs_diff_eq;
use proptest::prelude::*;
use replication::paper::models::{
    Amplitude, BlockAndBracket, Caption, CaptionOrder, Interpretation, Rig, Unloading,
};
use stickslip::{Error, Fate, Filippov, Options, Side, State, fate, run, solve};

fn rig() -> Rig {
    crate::models::rig().checked().unwrap()
}

fn exact(caption: &Caption) -> BlockAndBracket {
    BlockAndBracket::from_caption(caption, &Interpretation::exact()).unwrap()
}

/// Converts the nondimensional state to metres and metres per second.
fn in_metres(rig: &Rig, x: &State<4>) -> State<4> {
    let (length, speed) = (rig.length_unit(), rig.length_unit() / rig.time_unit());
    State::from([x[0] * length, x[1] * speed, x[2] * length, x[3] * speed])
}

proptest! {
    #[test]
    fn it_sticks_while_friction_can_hold_it(
        x1 in -6.0..6.0, x3 in -2.0..2.0, x4 in -2.0..2.0, set in 0usize..3,
    ) {
        let caption = [Caption::FIG10, Caption::FIG11, Caption::FIG12][set];
        let model = BlockAndBracket {
            coupling_damping: 0.2,
            ..exact(&caption)
        };
        let x = State::from([x1, model.belt_speed, x3, x4]);
        // The T for which x2' vanishes, and the limit of static friction.
        let needed = -x1 / model.coupling - 0.2 * (x[1] + x4) - x3;
        let most = model.mu0 * model.normal_force(x.as_ref());
        prop_assume!((needed.abs() - most).abs() > 1e-9);
        let wanted = if needed.abs() < most {
            Fate::Stick
        } else if needed > 0.0 {
            // The springs exceed friction and pull the block ahead of the belt.
            Fate::Slip(Side::Above)
        } else {
            Fate::Slip(Side::Below)
        };
        prop_assert_eq!(fate(&model, 0.0, &x), wanted);
    }
}

#[test]
fn both_forms_have_the_same_orbit() {
    let rig = rig();
    let start = State::from([0.4, -0.3, 0.2, 0.1]);
    let options = Options::tol(1e-13);
    let scaled = solve(&rig.nondimensional(), 0.0, start, 60.0, &options).unwrap();
    let t_end = 60.0 * rig.time_unit();
    let metres = solve(&rig, 0.0, in_metres(&rig, &start), t_end, &options).unwrap();
    let modes = |phases: &[stickslip::Phase<4>]| phases.iter().map(|p| p.mode).collect::<Vec<_>>();
    assert_eq!(modes(&scaled.phases), modes(&metres.phases));
    assert!(scaled.sticks().count() >= 5);
    for t in [5.0, 20.0, 40.0, 60.0] {
        let wanted = in_metres(&rig, &scaled.at(t).unwrap());
        let found = metres.at((t * rig.time_unit()).min(t_end)).unwrap();
        // A damped system forgets errors; those of a few steps remain.
        assert!((found - wanted).amax() < 1e-11, "{t}: {found} {wanted}");
    }
}

#[test]
fn the_unloading_follows_from_the_stiffness() {
    // ξ6/μ0 and ξ4 - 1 are both k3/k2. In all three captions ξ3/ξ1 is m r²/J.
    for (caption, digits) in [(Caption::FIG11, 1e-3), (Caption::FIG12, 1e-3)] {
        let model = exact(&caption);
        let ratio = model.bracket_stiffness - 1.0;
        assert_abs_diff_eq!(model.unloading, ratio, epsilon = digits);
    }
    for caption in [Caption::FIG10, Caption::FIG11, Caption::FIG12] {
        let model = exact(&caption);
        assert_abs_diff_eq!(model.mobility / model.coupling, 2.588, epsilon = 0.003);
        assert_eq!(model.unloading_rate, 0.0);
    }
}

#[test]
fn readings_are_data() {
    let [.., delta, speed] = Caption::FIG12.numbers;
    let literal =
        BlockAndBracket::from_caption(&Caption::FIG12, &Interpretation::as_printed()).unwrap();
    assert_eq!(
        (literal.displacement_sign, literal.friction_sign),
        (-1.0, -1.0)
    );
    assert_eq!(
        (literal.mu0, literal.unloading, literal.clipped),
        (2.9, 6.766, false)
    );
    assert_eq!((literal.delta, literal.belt_speed), (delta, speed));
    let scaled =
        BlockAndBracket::from_caption(&Caption::FIG12, &Interpretation::scaled_by_friction())
            .unwrap();
    assert_eq!((scaled.mu0, scaled.unloading), (1.0, 6.766));
    let heading = Interpretation {
        order: CaptionOrder::Heading { mu0: 0.5 },
        unloading: Unloading::OverMu0,
        amplitude: Amplitude::Mu0,
        ..Interpretation::exact()
    };
    let heading = BlockAndBracket::from_caption(&Caption::FIG12, &heading).unwrap();
    assert_eq!((heading.unloading, heading.unloading_rate), (5.8, 13.532));
    // Clipping affects friction, not the contact that is reported.
    let x = State::from([0.0, 0.0, 1.0, 0.0]);
    let model = exact(&Caption::FIG12);
    assert!(model.unclipped_normal_force(x.as_ref()) < -1.0);
    assert_eq!(model.normal_force(x.as_ref()), 0.0);
}

#[test]
fn bad_parameters_are_named() {
    let name = |error| match error {
        Error::Parameter { name, .. } => name,
        other => panic!("{other}"),
    };
    let mut caption = Caption::FIG10;
    caption.numbers[7] = -0.1;
    let error = BlockAndBracket::from_caption(&caption, &Interpretation::exact()).unwrap_err();
    assert_eq!(name(error), "delta");
    caption = Caption::FIG10;
    caption.numbers[5] = 0.0;
    let error = BlockAndBracket::from_caption(&caption, &Interpretation::exact()).unwrap_err();
    assert_eq!(name(error), "mu0");
    let half = Interpretation {
        friction_sign: 0.5,
        ..Interpretation::exact()
    };
    let error = BlockAndBracket::from_caption(&Caption::FIG10, &half).unwrap_err();
    assert_eq!(name(error), "friction_sign");
    assert_eq!(name(Rig { k2: 0.0, ..rig() }.checked().unwrap_err()), "k2");
}

#[test]
fn run_to_the_letter_the_first_two_sets_diverge() {
    let options = Options::default().escape(1e3);
    for caption in [Caption::FIG10, Caption::FIG11] {
        for unloading in [Unloading::Plain, Unloading::OverMu0] {
            let reading = Interpretation {
                unloading,
                ..Interpretation::as_printed()
            };
            let model = BlockAndBracket::from_caption(&caption, &reading).unwrap();
            let start = State::from(caption.start);
            let error = run(&model, 0.0, start, 1e3, &options, &mut ()).unwrap_err();
            assert!(
                matches!(error.error, Error::Escaped { t, .. } if t < 60.0),
                "{error}"
            );
        }
    }
}

/// The chaotic run must agree to the last bit, for as long as a difference of one bit stays below
/// the figures' tolerance. So must the runs of the other two sets.
#[test]
fn short_runs_have_the_same_bits_everywhere() {
    let mut text = String::new();
    for (name, caption) in [
        ("fig10", &Caption::FIG10),
        ("fig11", &Caption::FIG11),
        ("fig12", &Caption::FIG12),
    ] {
        let orbit = solve(
            &exact(caption),
            0.0,
            State::from(caption.start),
            300.0,
            &Options::tol(1e-10),
        )
        .unwrap();
        writeln!(text, "{name}: {:?}", orbit.counters).unwrap();
        let last = orbit.transitions.last().map(|at| (at.t, at.x));
        for (t, x) in last.into_iter().chain([(orbit.t_end, orbit.x_end)]) {
            let values = || std::iter::once(t).chain(x.as_slice().iter().copied());
            let decimal: Vec<String> = values().map(|v| format!("{v:?}")).collect();
            let bits: Vec<String> = values().map(|v| format!("{:016x}", v.to_bits())).collect();
            let (decimal, bits) = (decimal.join(" "), bits.join(" "));
            writeln!(text, "{name}: t x1 x2 x3 x4 = {decimal} = {bits}").unwrap();
        }
    }
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../golden");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!("short_runs", text));
}
