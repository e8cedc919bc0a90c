//! Uncoupled oscillators in one system move as each does alone.

use stickslip::{
    Contacts, Filippov, Method, Mode, Options, Orbit, Scalar, Several, Side, Start, State,
    TransitionKind, ensemble, solve,
};

use super::rig::Rig;
use super::two_states::TwoStates;
use std::ops::ControlFlow;

/// Three driven blocks on a floor, each with its own spring and friction.
pub fn three() -> Rig<3> {
    let mut rig = Rig::at_rest();
    for (i, k) in [1.0, 2.5, 0.4].into_iter().enumerate() {
        rig.spring(k, i, None);
    }
    (rig.forcing, rig.omega) = ([1.5, 0.9, 1.1], 0.7);
    rig.friction = [0.3, 0.5, 0.7];
    rig
}

pub const START: [f64; 6] = [1.0, -0.5, 2.0, 0.0, 0.5, -0.3];

/// One oscillator of the rig alone.
pub struct SingleOscillator<'a>(pub &'a Rig<3>, pub usize);

impl Filippov<2> for SingleOscillator<'_> {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let SingleOscillator(rig, i) = *self;
        let shaking = (t * rig.omega).cos() * rig.forcing[i];
        [
            x[1],
            -x[0] * rig.stiffness[i][i] + shaking - rig.friction[i] * side.sign(),
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
}

fn each_goes_on_as_alone(options: &Options, allowed: f64) {
    let rig = three();
    let together = solve(&Several(&rig), 0.0, START, 40.0, options).unwrap();
    for i in 0..3 {
        let alone = solve(
            &SingleOscillator(&rig, i),
            0.0,
            [START[i], START[3 + i]],
            40.0,
            options,
        )
        .unwrap();
        let own: Vec<_> = together
            .transitions
            .iter()
            .filter(|at| at.contact == i)
            .collect();
        assert_eq!(own.len(), alone.transitions.len());
        assert!(own.len() > 8);
        let sticks = together.sticks_of(i);
        assert_eq!(sticks.len(), alone.sticks().count());
        for (stick, alone) in sticks.iter().zip(alone.sticks()) {
            assert!(
                (stick.0 - alone.t_start).abs() < allowed
                    && (stick.1 - alone.t_end).abs() < allowed
            );
        }
        for (own, alone) in own.iter().zip(&alone.transitions) {
            assert_eq!(
                (own.kind, own.from[i], own.to[i]),
                (alone.kind, alone.from, alone.to)
            );
            assert!((own.t - alone.t).abs() < allowed, "{own:?} {alone:?}");
        }
        let end = State::from([together.x_end[i], together.x_end[3 + i]]);
        assert!((end - alone.x_end).amax() < allowed);
    }
}

#[test]
fn oscillators_apart_go_on_as_each_alone_by_runge_kutta() {
    each_goes_on_as_alone(&Options::tol(1e-13), 1e-10);
}

#[test]
fn oscillators_apart_go_on_as_each_alone_by_taylor() {
    each_goes_on_as_alone(&Options::tol(1e-15).method(Method::Taylor), 1e-12);
}

/// The first of them with a contact that is never at zero.
pub struct WithIdle<'a>(&'a Rig<3>);

impl Contacts<2, 2> for WithIdle<'_> {
    fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, x: &[T; 2]) -> [T; 2] {
        SingleOscillator(self.0, 0).field(sides[0], t, x)
    }
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 2]) -> [T; 2] {
        [x[1], x[0] * x[0] + 1.0]
    }
}

#[test]
fn a_contact_that_never_acts_changes_nothing() {
    let rig = three();
    for (options, allowed) in [
        (Options::tol(1e-13), 1e-11),
        (Options::tol(1e-15).method(Method::Taylor), 1e-12),
    ] {
        let start = [START[0], START[3]];
        let alone = solve(&SingleOscillator(&rig, 0), 0.0, start, 40.0, &options).unwrap();
        let beside = solve(
            &Several(TwoStates::WithIdle(WithIdle(&rig))),
            0.0,
            start,
            40.0,
            &options,
        )
        .unwrap();
        assert_eq!(alone.transitions.len(), beside.transitions.len());
        assert!(alone.transitions.len() > 8);
        for (alone, beside) in alone.transitions.iter().zip(&beside.transitions) {
            assert_eq!((alone.kind, alone.to), (beside.kind, beside.to[0]));
            assert_eq!((beside.contact, beside.to[1]), (0, Mode::Slip(Side::Above)));
            assert!((alone.t - beside.t).abs() < allowed, "{alone:?} {beside:?}");
        }
        assert!((alone.x_end - beside.x_end).amax() < 10.0 * allowed);
    }
}

#[test]
fn a_contact_at_the_limit_of_what_holds_it_does_as_by_the_rules_of_one_boundary() {
    // The push equals the friction limit, and its rate is zero or not. So the second derivative
    // decides, or the first.
    let rig = |force: f64, omega: f64, stiffness: f64| {
        let mut rig = Rig::<3>::at_rest();
        (rig.forcing[0], rig.omega, rig.friction[0]) = (force, omega, 0.4);
        rig.stiffness[0][0] = stiffness;
        rig
    };
    for (rig, x, sticks) in [
        // The push is at its maximum, and friction holds.
        (rig(0.4, 1.0, 0.0), 0.0, true),
        (rig(-0.4, 1.0, 0.0), 0.0, true),
        // At its minimum it does not.
        (rig(-0.4, 1.0, 1.0), -0.8, false),
        (rig(0.4, 1.0, 1.0), 0.8, false),
        // It never changes.
        (rig(0.0, 1.0, 1.0), -0.4, true),
        (rig(0.0, 1.0, 1.0), 0.4, true),
    ] {
        for options in [
            Options::tol(1e-12),
            Options::tol(1e-14).method(Method::Taylor),
        ] {
            let alone = solve(&SingleOscillator(&rig, 0), 0.0, [x, 0.0], 1.0, &options).unwrap();
            let several = solve(
                &Several(TwoStates::WithIdle(WithIdle(&rig))),
                0.0,
                [x, 0.0],
                1.0,
                &options,
            )
            .unwrap();
            let first = alone.phases[0].mode;
            assert_eq!(first == Mode::Stick, sticks, "{rig:?}");
            assert_eq!(several.phases[0].mode[0], first, "{rig:?}");
            assert!((several.x_end - alone.x_end).amax() < 1e-11, "{rig:?}");
        }
    }
}

#[test]
fn two_that_come_to_rest_at_the_same_instant_are_decided_together() {
    // Two equal blocks with equal starts stop at the same time, whatever the rounding. The third
    // one stops at another time.
    let mut rig = three();
    rig.stiffness[1][1] = rig.stiffness[0][0];
    rig.forcing = [0.0; 3];
    rig.friction[1] = rig.friction[0];
    let start = [2.0, 2.0, -1.5, 0.0, 0.0, 0.0];
    for options in [
        Options::tol(1e-12),
        Options::tol(1e-14).method(Method::Taylor),
    ] {
        let orbit = solve(&Several(&rig), 0.0, start, 15.0, &options).unwrap();
        assert!((orbit.x_end[0] - orbit.x_end[1]).abs() < 1e-14);
        for phase in &orbit.phases {
            assert_eq!(phase.mode[0], phase.mode[1]);
        }
        assert_eq!(orbit.phases.last().unwrap().mode, [Mode::Stick; 3]);
    }
}

#[test]
fn an_ensemble_has_the_bits_of_each_orbit_alone() {
    let rig = three();
    let system = Several(&rig);
    let options = Options::tol(1e-10).method(Method::Taylor);
    let start = |k: usize| Start {
        system,
        t: 0.0,
        x: State::from(START) * (1.0 + 0.01 * k as f64),
    };
    let mut ends = Vec::new();
    ensemble(
        (0..20).map(start),
        10.0,
        &options,
        |_| (),
        |_, (), outcome| {
            ends.push(outcome.unwrap().x);
            ControlFlow::Continue(())
        },
    );
    assert_eq!(ends.len(), 20);
    for (k, end) in ends.iter().enumerate() {
        let alone = solve(&system, 0.0, start(k).x, 10.0, &options).unwrap();
        assert_eq!(*end, alone.x_end);
    }
}

#[test]
fn phases_and_steps_of_several_contacts_join() {
    let rig = three();
    let orbit: Orbit<6, [Mode; 3]> =
        solve(&Several(&rig), 0.0, START, 20.0, &Options::default()).unwrap();
    for pair in orbit.phases.windows(2) {
        assert_eq!(
            (pair[0].t_end, pair[0].x_end),
            (pair[1].t_start, pair[1].x_start)
        );
        assert_ne!(pair[0].mode, pair[1].mode);
    }
    for step in &orbit.steps {
        let phase = orbit
            .phases
            .iter()
            .find(|phase| phase.t_end >= step.t_end)
            .unwrap();
        assert_eq!(step.mode, phase.mode);
    }
    let changes = orbit
        .transitions
        .iter()
        .filter(|at| at.kind != TransitionKind::Touch);
    assert_eq!(changes.count() + 1, orbit.phases.len());
    // A contact that holds lies on its boundary to rounding.
    for step in &orbit.steps {
        let h = Contacts::boundaries(&rig, 0.0, step.x_end.as_ref());
        for (h, mode) in h.iter().zip(step.mode) {
            assert!(mode != Mode::Stick || h.abs() < 1e-15);
        }
    }
}
