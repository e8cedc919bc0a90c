//! Attractors from recurrence, and their basins, compared with published results.

use std::f64::consts::PI;

use crate::is_same_cycle;
use numerics::SplitMix;
use stickslip::analysis::{
    Attractor, AttractorKind, Attractors, PeriodicOrbit, RecurrenceSettings, attractor, basin,
};
use stickslip::{Error, IntoState, Method, Mode, Options, Side, State, math, solve};

use crate::compiled::Compiled;
use crate::constant_fields::ConstantFields;
use crate::den_hartog::DenHartog;
use crate::lyapunov_jumps::system;
use crate::smooth::{Lorenz, Smooth};

pub mod systems;
use systems::{
    Backwards, Detour, Driven, Leine, Mechanism, NearWells, Pushed, Rings, Shear, ToZero, Wells,
};

const ABOVE: Mode = Mode::Slip(Side::Above);
const BELOW: Mode = Mode::Slip(Side::Below);

fn within(longest: f64) -> RecurrenceSettings {
    RecurrenceSettings::within(longest)
}

fn reached<S: Compiled<N>, const N: usize>(
    system: &S,
    x: [f64; N],
    settings: &RecurrenceSettings,
    options: &Options,
) -> Attractor {
    attractor(&system.dynamics(), x, settings, options).expect("a start that is allowed")
}

#[test]
fn the_stick_slip_cycle_of_leine_is_found_and_refined() {
    for method in [Method::Dop853, Method::Taylor] {
        let options = Options::tol(1e-13).method(method);
        let found = reached(&Leine, [1.0, 0.0], &within(200.0), &options);
        let AttractorKind::Periodic { returns: 2, period } = found.kind else {
            panic!("{:?}", found.kind);
        };
        let exact = 12.001_031_294_831;
        assert!((period - exact).abs() < 1e-11, "{period}");
        assert!(found.period_uncertainty < 1e-9);
        assert!(is_same_cycle(&found.sequence(), &[Mode::Stick, BELOW]));
        let [stick, slip] = [Mode::Stick, BELOW].map(|mode| {
            let phase = found.phases.iter().find(|phase| phase.mode == mode);
            phase.cloned().expect("is in the sequence")
        });
        assert!((stick.duration() - 7.705_031_769_350).abs() < 1e-11);
        assert!((slip.duration() - 4.295_999_525_480).abs() < 1e-11);
        assert!((stick.x_start[0] + 0.541_006_353_870).abs() < 1e-11);
        assert!((found.in_stick - stick.duration() / period).abs() < 1e-12);
        // By shooting from a point in its slip phase.
        let orbit = stickslip::solve(&Leine.any(), 0.0, slip.x_start, 2.0, &options);
        let inside = orbit.expect("runs").x_end;
        let cycle =
            PeriodicOrbit::near(&Leine.dynamics(), inside, period, &options).expect("converges");
        assert!((cycle.period - exact).abs() < 1e-11, "{}", cycle.period);
    }
}

/// Published shares of starts that end on the fixed point (P16), by the belt's speed. Each is from
/// 5000 random starts: Stender & Hoffmann, *Nonlinear Dyn.* 107 (2022) 1451.
const SHARES: &str = include_str!("../../data/shares.csv");

fn starts(count: usize) -> impl Iterator<Item = State<2>> {
    let mut random = SplitMix::new(16);
    (0..count).map(move |_| [random.between(-2.0, 2.0), random.between(0.0, 2.0)].into())
}

#[test]
fn shares_of_starts_are_the_published_ones_within_three_standard_errors() {
    let mut lines = SHARES.lines();
    assert_eq!(lines.next(), Some("belt_speed,share"));
    assert_eq!(lines.clone().count(), 10);
    for line in lines {
        let (vd, published) = line.split_once(',').expect("two columns");
        let [vd, published] = [vd, published].map(|text| text.parse::<f64>().unwrap());
        let system = Driven { vd };
        let settings = RecurrenceSettings {
            closeness: 1e-5,
            ..within(2e4)
        };
        let found = basin(
            &system.dynamics(),
            starts(5000),
            &settings,
            &Options::tol(1e-8),
        )
        .unwrap();
        let at = |kind: fn(&AttractorKind) -> bool| {
            let mut these =
                (0..found.attractors.len()).filter(|k| kind(&found.attractors[*k].kind));
            let part = these.next().map_or(0.0, |k| found.share(k).part);
            assert_eq!(these.next(), None, "one of each kind at vd = {vd}");
            part
        };
        let rest = at(|kind| *kind == AttractorKind::Equilibrium);
        let cycle = at(|kind| matches!(kind, AttractorKind::Periodic { returns: 2, .. }));
        assert_eq!(
            found.attractors.len(),
            usize::from(rest > 0.0) + usize::from(cycle > 0.0)
        );
        assert!((rest + cycle - 1.0).abs() < 1e-12);
        // Both are samples of 5000 starts.
        let error = (published * (1.0 - published) / 5000.0).sqrt();
        assert!(
            (rest - published).abs() <= 3.0 * error,
            "{vd}: {rest}, published {published}"
        );
        // The fixed point in closed form: x = F(-vd).
        for attractor in &found.attractors {
            if attractor.kind == AttractorKind::Equilibrium {
                let exact = 0.5 + 0.5 * math::exp(-2.0 * vd);
                assert!((attractor.points[0].x[0] - exact).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn a_basin_has_the_same_bits_on_any_number_of_threads() {
    let system = Driven { vd: 1.5 };
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            basin(
                &system.dynamics(),
                starts(200),
                &within(5e3),
                &Options::tol(1e-7),
            )
            .unwrap()
        })
    };
    let one = run(1);
    assert_eq!(one, run(3));
    // In the order of the starts, each computed as if alone.
    let first = starts(1).next().unwrap();
    let alone = reached(&system, first.into(), &within(5e3), &Options::tol(1e-7));
    assert_eq!(one.attractors[one.reached[0]], alone);
    assert_eq!(one.reached[0], 0);
}

#[test]
fn rest_is_distinguished_by_the_interval_that_holds_it() {
    // |x - x³| ≤ 0.3 where friction holds: about -1, 0 and 1, but not between.
    let system = Wells { friction: 0.3 };
    let any = system.dynamics();
    let mut known = Attractors::new(&any, &within(100.0), &Options::default());
    let mut number = |x: f64| {
        let found = reached(&system, [x, 0.0], &within(100.0), &Options::default());
        assert_eq!(found.kind, AttractorKind::EquilibriumSet, "from {x}");
        assert_eq!((found.mode, found.in_stick), (Mode::Stick.into(), 1.0));
        known.number(found)
    };
    let places = [1.0, 1.1, -1.0, 0.0, 0.9, 1.4, -0.9, 0.2, -0.2];
    assert_eq!(places.map(&mut number), [0, 0, 1, 2, 0, 0, 1, 2, 2]);
}

#[test]
fn an_equilibrium_at_zero_is_one_attractor_and_not_one_for_each_start() {
    for by in [Mechanism::Spring, Mechanism::Relay, Mechanism::CurvedRelay] {
        let system = ToZero(by);
        let any = system.dynamics();
        let settings = within(200.0);
        let mut known = Attractors::new(&any, &settings, &Options::default());
        let starts = [
            [1.0, 0.0],
            [-0.3, 0.7],
            [0.01, -2.0],
            [1e-6, 1e-5],
            [0.0, 0.0],
        ];
        for start in starts {
            let found = attractor(&any, start, &settings, &Options::default()).unwrap();
            assert_eq!(
                found.kind,
                AttractorKind::Equilibrium,
                "{by:?} from {start:?}"
            );
            assert!(found.points[0].x.amax() < 1e-9, "{:?}", found.points);
            assert_eq!(known.number(found), 0, "{by:?} from {start:?}");
        }
    }
}

#[test]
fn equilibria_beside_each_other_are_two_however_far_the_starts() {
    let any = NearWells.dynamics();
    let settings = within(200.0);
    let mut known = Attractors::new(&any, &settings, &Options::default());
    let numbers = [1e3, -1e3, 2e-3, -2e-3].map(|x| {
        let found = attractor(&any, [x], &settings, &Options::default()).unwrap();
        assert_eq!(found.kind, AttractorKind::Equilibrium, "from {x}");
        known.number(found)
    });
    assert_eq!(numbers, [0, 1, 0, 1]);
}

#[test]
fn a_cycle_that_meets_no_boundary_is_known_by_where_it_turns_back() {
    let far = Rings { place: 50.0 };
    let any = far.dynamics();
    let settings = within(400.0);
    let mut known = Attractors::new(&any, &settings, &Options::default());
    for start in [[0.9, 0.0, -0.5], [0.0, -2.0, -0.5], [1.0, 1.0, -0.5]] {
        let found = reached(&far, start, &settings, &Options::default());
        let AttractorKind::Periodic { returns: 1, period } = found.kind else {
            panic!("{:?}", found.kind);
        };
        // Its error is reported.
        let uncertainty = found.period_uncertainty;
        assert!((period - 2.0 * PI).abs() <= uncertainty && uncertainty < 1e-5);
        let radius = (1.0 + 0.5_f64.sqrt()).sqrt();
        assert!((&found.points[0].x - State::from([radius, 0.0, -0.5])).amax() < 1e-5);
        assert_eq!(found.sequence(), [BELOW]);
        assert_eq!(known.number(found), 0);
    }
    // Inside the repelling cycle all orbits go to the focus. Their increasingly slow turns are not
    // cycles.
    let found = reached(&far, [0.5, 0.0, -0.5], &settings, &Options::default());
    assert_eq!(
        found.kind,
        AttractorKind::EquilibriumSet,
        "the parameter is any number"
    );
    assert!(found.points[0].x.rows(0, 2).amax() < 1e-9);
    assert_eq!(known.number(found), 1);
}

#[test]
fn a_slow_spiral_is_no_cycle() {
    // A rate of a tenth of a percent per turn: the orbit would need time 14000 to the cycle, and as
    // much to the focus.
    let found = |x: f64, p: f64, longest: f64| {
        let start = [x, 0.0, p];
        reached(
            &Rings { place: 50.0 },
            start,
            &within(longest),
            &Options::tol(1e-11),
        )
        .kind
    };
    assert_eq!(found(0.01, -2e-4, 2e3), AttractorKind::Undecided);
    // Just beyond the fold the orbit creeps past r = 1 for about 2π/√(8·1e-6).
    assert_eq!(found(1.01, -1.0 - 1e-5, 100.0), AttractorKind::Undecided);
    assert_eq!(found(1.01, -1.0 - 1e-5, 2e3), AttractorKind::EquilibriumSet);
}

#[test]
fn rest_is_known_as_soon_as_nothing_can_keep_the_orbit_from_it() {
    // Inside the cycle of amplitude 2 orbits come to rest; outside they escape.
    let system = Smooth(Backwards);
    let found = |x: f64| reached(&system, [x, 0.0], &within(2000.0), &Options::tol(1e-10));
    for x in [-1.95, -1.0, 0.1, 0.7, 1.5, 1.9] {
        let inside = found(x);
        assert_eq!(inside.kind, AttractorKind::Equilibrium, "from {x}");
        assert!(inside.points[0].x.amax() < 1e-12);
        // The orbit decays by half its damping: to vanish it would take 270.
        assert!(inside.t < 130.0, "from {x}: {}", inside.t);
        // The orbit is then near the equilibrium, but not on it.
        let left = inside.x.amax();
        assert!(0.0 < left && left < 1e-5, "from {x}: {left:e}");
    }
    for x in [-2.05, 2.05, 3.0] {
        let outside = found(x).kind;
        assert!(
            matches!(outside, AttractorKind::Failure(_)),
            "from {x}: {outside:?}"
        );
    }
    // On the belt: an orbit that is reported to be attracted does not meet the belt again.
    let (system, options) = (Driven { vd: 1.5 }, Options::tol(1e-9));
    let mut decided = 0;
    for start in starts(200) {
        let found = attractor(&system.dynamics(), start, &within(2000.0), &options).unwrap();
        if found.kind == AttractorKind::Equilibrium {
            let all = solve(&system.any(), 0.0, start, found.t + 1000.0, &options).unwrap();
            let last = all.phases.last().unwrap();
            assert!(last.t_start < found.t, "from {start}");
            let rest: State<2> = (&found.points[0].x).into_state();
            assert!((last.x_end - rest).amax() < 1e-9, "from {start}");
            let then = all.at(found.t).unwrap() - rest;
            decided += usize::from(then.amax() > 1e-3);
        }
    }
    assert!(decided > 40, "{decided} while they were far from it");
}

#[test]
fn a_trap_reaches_as_far_as_the_mean_slope_on_the_way_from_its_middle() {
    // V = (x² + y²)/2 decreases while the slope of y' = -y + x² in x, averaged from the centre, is
    // at most 9/5. Within radius r the slope is at most 2 r. Its average, over eight parts, is at
    // most 9/8 r.
    let radius = |[x, y]: [f64; 2]| math::hypot(x, y);
    let options = Options::default().longest_step(0.003);
    let known = |[x, y]: [f64; 2]| {
        let found = reached(&Smooth(Shear), [x, y], &within(50.0), &options);
        assert_eq!(found.kind, AttractorKind::Equilibrium, "from {x}, {y}");
        let left = math::exp(-found.t);
        let there = [x * left, y * left + x * x * (left - left * left)];
        (found.t, radius(there))
    };
    let (early, _) = known([0.3, 1.5]);
    assert!(early < 0.1, "{early}");
    // Each size that is tried is 0.85 times the previous one.
    let (late, there) = known([0.4, 2.0]);
    assert!(
        late > 0.1 && there < 1.6 && there > 0.85 * 1.59,
        "{late} {there}"
    );
}

#[test]
fn stick_is_known_to_repeat_at_its_second_release() {
    let options = Options::tol(1e-10);
    let start = [1.0, 0.0];
    let found = reached(&Leine, start, &within(200.0), &options);
    assert!(matches!(
        found.kind,
        AttractorKind::Periodic { returns: 2, .. }
    ));
    let orbit = solve(&Leine.any(), 0.0, start, 100.0, &options).unwrap();
    let second = orbit.sticks().nth(1).unwrap();
    assert!((found.t - second.t_start).abs() < 1e-9, "{}", found.t);
    assert_eq!(found.mode, Mode::Stick);
    let released = found.points.last().unwrap();
    assert!((released.t - second.t_end).abs() < 1e-9, "{}", released.t);
    assert!(((&released.x).into_state() - second.x_end).amax() < 1e-9);
}

#[test]
fn an_orbit_that_escapes_on_its_way_to_rest_escapes() {
    // Tested after a tenth of the way out.
    let options = Options::default().longest_step(0.003);
    let found = |bound| {
        reached(
            &Smooth(Detour),
            [0.0, 1.0],
            &within(50.0),
            &options.escape(bound),
        )
    };
    let free = found(f64::INFINITY);
    assert_eq!(free.kind, AttractorKind::Equilibrium);
    assert!(free.t < 0.1, "{}", free.t);
    assert_eq!(found(20.0).kind, AttractorKind::Escape);
}

#[test]
fn a_field_that_depends_on_time_draws_to_no_equilibrium() {
    // The last starts where the field vanishes momentarily.
    for (decay, x) in [(0.0, 0.5), (0.001, 0.5), (0.001, 1.0)] {
        let found = reached(
            &Pushed { decay },
            [x, 0.0],
            &within(300.0),
            &Options::default(),
        );
        if decay == 0.0 {
            // As often as it is pushed.
            let AttractorKind::Periodic { returns: 1, period } = found.kind else {
                panic!("{}", found.kind);
            };
            assert!((period - 40.0 * PI).abs() < 1e-5, "{period}");
        } else {
            assert_eq!(
                found.kind,
                AttractorKind::Undecided,
                "decay {decay}, from {x}"
            );
        }
    }
}

#[test]
fn what_does_not_close_is_recurrent_or_undecided() {
    let options = Options::tol(1e-9);
    // A rotation by 2π sampled once per unit of time never repeats.
    let start = [1.4, 0.0, 0.0];
    let ring = reached(
        &Rings { place: 50.0 },
        start,
        &within(600.0).forced(1.0),
        &options,
    );
    assert_eq!(ring.kind, AttractorKind::Recurrent);
    // The same, sampled at every eighth of a turn, closes.
    let eighth = within(600.0).forced(PI / 4.0);
    let ring = reached(&Rings { place: 50.0 }, start, &eighth, &options);
    assert!(
        matches!(ring.kind, AttractorKind::Periodic { returns: 8, .. }),
        "{}",
        ring.kind
    );
    let chaos = Smooth(Lorenz);
    let found = |z: f64, longest| reached(&chaos, [1.0, 1.0, z], &within(longest), &options);
    let (one, other) = (found(20.0, 600.0), found(25.0, 600.0));
    assert_eq!([&one.kind, &other.kind], [&AttractorKind::Recurrent; 2]);
    let any = chaos.dynamics();
    assert!(Attractors::new(&any, &within(600.0), &options).is_same(&one, &other));
    // Too short to decide.
    assert_eq!(found(20.0, 60.0).kind, AttractorKind::Undecided);
}

#[test]
fn forced_orbits_are_compared_at_whole_periods() {
    let system = DenHartog {
        frequency: 0.7,
        friction: 0.2,
    };
    let period = 2.0 * PI / 0.7;
    let settings = within(2e3).forced(period);
    let found = reached(&system, [0.3, 0.2], &settings, &Options::tol(1e-11));
    let AttractorKind::Periodic {
        returns: 1,
        period: p,
    } = found.kind
    else {
        panic!("{}", found.kind);
    };
    assert!((p - period).abs() < 1e-12);
    assert!(is_same_cycle(&found.sequence(), &[ABOVE, BELOW]));
    let turning = found.phases.iter().map(|phase| phase.x_end[0].abs());
    for amplitude in turning {
        assert!((amplitude - 1.927_774_517_9).abs() < 1e-5, "{amplitude}");
    }
}

/// A drive with less force than friction moves nothing within their difference of the centre, at
/// any phase of its period.
#[test]
fn rest_under_a_drive_is_one_set_of_equilibria() {
    let options = Options::tol(1e-10);
    let settings = within(2e3).forced(2.0 * PI);
    let held = DenHartog {
        frequency: 1.0,
        friction: 2.0,
    };
    let any = held.dynamics();
    let mut known = Attractors::new(&any, &settings, &Options::default());
    for start in [
        [0.3, 0.0],
        [-0.9, 0.0],
        [3.1, -0.4],
        [0.8, -0.9],
        [0.0, 0.0],
    ] {
        let found = reached(&held, start, &settings, &options);
        assert_eq!(
            (&found.kind, found.mode),
            (&AttractorKind::EquilibriumSet, Mode::Stick.into())
        );
        assert!(found.points[0].x[0].abs() <= 1.0 && found.points[0].x[1] == 0.0);
        assert_eq!(found.in_stick, 1.0);
        assert_eq!(known.number(found), 0, "{start:?}");
    }
    // With less friction the same drive moves the block. Its orbit is not at rest, although it
    // sticks at times.
    let moved = DenHartog {
        frequency: 0.4,
        friction: 0.9,
    };
    let found = reached(&moved, [0.3, 0.0], &within(2e3).forced(5.0 * PI), &options);
    assert!(
        matches!(found.kind, AttractorKind::Periodic { .. }),
        "{}",
        found.kind
    );
    assert!(found.in_stick > 0.1);
}

#[test]
fn den_hartog_s_amplitudes_are_found_from_a_run_and_refined() {
    let settings = [
        (0.65, 0.2),
        (0.7, 0.2),
        (0.7, 0.5),
        (0.77, 0.3),
        (0.77, 0.6),
        (0.83, 0.4),
        (1.3, 0.2),
        (1.3, 0.4),
        (1.45, 0.15),
        (1.45, 0.3),
    ];
    for (frequency, friction) in settings {
        let system = DenHartog {
            frequency,
            friction,
        };
        let v = 1.0 / (1.0 - frequency * frequency);
        let u = math::sin(PI / frequency) / (frequency * (1.0 + math::cos(PI / frequency)));
        let exact = (v * v - friction * friction * u * u).sqrt();
        let period = 2.0 * PI / frequency;
        let options = Options::tol(1e-12);
        let found = reached(&system, [0.5, 0.0], &within(3e3).forced(period), &options);
        assert!(
            matches!(found.kind, AttractorKind::Periodic { returns: 1, .. }),
            "{frequency} {friction} {}",
            found.kind
        );
        assert!(is_same_cycle(&found.sequence(), &[ABOVE, BELOW]));
        let x = &found.points[0].x;
        let cycle =
            PeriodicOrbit::near_forced(&system.dynamics(), 0.0, x, period, &options).unwrap();
        let orbit = stickslip::solve(&system.any(), 0.0, cycle.x, period, &options).unwrap();
        for at in &orbit.transitions {
            let error = (at.x[0].abs() - exact).abs();
            assert!(error < 1e-9, "{frequency} {friction}: {error:e}");
        }
        assert_eq!(orbit.transitions.len(), 2);
    }
}

#[test]
fn ends_and_failures_are_kinds_and_bad_settings_errors() {
    let default = Options::default();
    let apart = ConstantFields {
        below: -1.0,
        above: 1.0,
    };
    let kind = |x: f64, options| reached(&apart, [x], &within(1e3), options).kind;
    assert_eq!(kind(0.0, &default), AttractorKind::Repelling);
    assert_eq!(kind(0.5, &default.escape(10.0)), AttractorKind::Escape);
    let bad = |settings: RecurrenceSettings| {
        let found = attractor(&Leine.dynamics(), [1.0, 0.0], &settings, &default);
        match found.unwrap_err() {
            Error::Option { name, .. } => name,
            other => panic!("{other}"),
        }
    };
    assert_eq!(bad(within(-1.0)), "longest");
    assert_eq!(bad(within(f64::NAN)), "longest");
    let settings = RecurrenceSettings {
        closeness: 0.5,
        ..within(1.0)
    };
    assert_eq!(bad(settings), "closeness");
    assert_eq!(bad(within(1.0).forced(0.0)), "forcing");
    let (most_returns, kept) = (0, 3);
    assert_eq!(
        bad(RecurrenceSettings {
            most_returns,
            ..within(1.0)
        }),
        "most_returns"
    );
    assert_eq!(
        bad(RecurrenceSettings {
            kept,
            ..within(1.0)
        }),
        "kept"
    );
}

/// An integrate-and-fire neuron fires after `ln(I/(I - 1))`; a clock that is set back ticks.
#[test]
fn what_returns_after_a_jump_is_periodic() {
    let fires = |rate: &str| {
        let text = format!(
            "name = \"resets\"\n[states]\nx = \"\"\n[field]\nx = \"{rate}\"\n[jumps.back]\n\
             when = \"x - 1\"\ndirection = \"rising\"\nset = {{ x = \"0\" }}\n"
        );
        let options = Options::tol(1e-10);
        let found = attractor(system(&text).dynamics(), [0.3], &within(500.0), &options).unwrap();
        let AttractorKind::Periodic { returns: 1, period } = found.kind else {
            panic!("{rate}: {}", found.kind);
        };
        period
    };
    assert!((fires("1") - 1.0).abs() < 1e-9);
    for current in [1.1, 1.15, 1.2, 1.5, 2.0, 3.0, 10.0] {
        let period = math::ln(current / (current - 1.0));
        let found = fires(&format!("{current} - x"));
        assert!((found / period - 1.0).abs() < 1e-8, "{current}: {found}");
    }
}

/// A pendulum with a moving pivot: the state of rest is unstable, and an orbit of twice the period
/// attracts.
#[test]
fn a_start_on_an_unstable_orbit_reaches_no_attractor() {
    let text = "name = \"pivot\"\n[time]\nperiod = \"2*pi\"\n[states]\nx = \"\"\nv = \"\"\n\
                [field]\nx = \"v\"\nv = \"-(0.25 + 0.4*cos(t))*x - x^3 - 0.2*v\"\n";
    let system = system(text);
    let (settings, options) = (within(2000.0).forced(2.0 * PI), Options::tol(1e-10));
    let mut known = Attractors::new(system.dynamics(), &settings, &options);
    let number = |known: &mut Attractors<'_>, start: [f64; 2]| {
        let found = attractor(system.dynamics(), start, &settings, &options).unwrap();
        known.number(found)
    };
    assert_eq!(number(&mut known, [0.5, 0.3]), 0);
    assert_eq!(number(&mut known, [0.0, 0.0]), 1);
    assert_eq!(number(&mut known, [0.0, 0.0]), 1);
    assert!(
        known.all()[0].kind.is_attractor(),
        "{}",
        known.all()[0].kind
    );
    assert_eq!(known.all()[1].kind, AttractorKind::Unstable);
    assert!(!AttractorKind::Unstable.is_attractor());
    // The displaced orbit reaches the attractor.
    let on_it = attractor(system.dynamics(), [0.0, 0.0], &settings, &options).unwrap();
    let beside = on_it.by_shooting(system.dynamics(), &settings, &options);
    assert!(beside.kind.is_attractor() && beside.x.norm() > 0.1);
    let again = beside
        .clone()
        .by_shooting(system.dynamics(), &settings, &options);
    assert_eq!(beside, again);
}

/// A driven double well beside a state that decays. What is left of the decay when an orbit repeats
/// differs from start to start.
#[test]
fn a_state_that_decays_beside_an_orbit_makes_no_attractors() {
    for rate in [0.07, 0.1, 0.3, 0.5] {
        let text = format!(
            "name = \"decay\"\n[time]\nperiod = \"2*pi\"\n[states]\nx = \"\"\ny = \"\"\n\
             [field]\nx = \"x - x^3 + 0.1*sin(t)\"\ny = \"-{rate}*y\"\n"
        );
        let system = system(&text);
        let (settings, options) = (within(5000.0).forced(2.0 * PI), Options::tol(1e-10));
        let mut known = Attractors::new(system.dynamics(), &settings, &options);
        for start in [-1.0, 1.0].map(|x| [-1.0, -0.7, -0.2, 0.3, 0.6, 1.0].map(|y| [x, y])) {
            for start in start {
                let found = attractor(system.dynamics(), start, &settings, &options).unwrap();
                known.number(found);
            }
        }
        assert_eq!(known.all().len(), 2, "{rate}");
    }
}

/// A pressure in Pa beside a lift in m, which comes to rest, or oscillates, at 0.1 mm on either
/// side.
#[test]
fn attractors_differ_in_a_state_that_is_small_beside_another() {
    for (time, drive) in [("", "0"), ("[time]\nperiod = \"2*pi\"\n", "1e4*sin(t)")] {
        let text = format!(
            "name = \"valve\"\n{time}[states]\np = \"Pa\"\ny = \"m\"\n[field]\n\
             p = \"1e5 + {drive} - p\"\ny = \"y*(1 - (y/1e-4)^2) + 1e-10*(p - 1e5)\"\n"
        );
        let system = system(&text);
        let settings = match time {
            "" => within(500.0),
            _ => within(500.0).forced(2.0 * PI),
        };
        let options = Options::default();
        let mut known = Attractors::new(system.dynamics(), &settings, &options);
        let numbers = [-2e-4, -5e-5, 5e-5, 2e-4].map(|y| {
            let found = attractor(system.dynamics(), [1.1e5, y], &settings, &options).unwrap();
            known.number(found)
        });
        assert_eq!(numbers, [0, 0, 1, 1], "{drive}");
    }
}
