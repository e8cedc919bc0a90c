//! Static friction above the kinetic one at two stacked contacts, compared with a scan of the same
//! equations in steps of 1e-5.

use stickslip::{
    Contacts, Method, Mode, Options, Scalar, Several, Side, TransitionKind, math, solve,
};

use super::references::stacked;
use super::rig::Rig;
use super::two_states::TwoStates;

const STEP: f64 = 1e-5;
const T_END: f64 = 40.0;

/// The rig integrated by hand: contacts slip or hold, force by force.
struct Scan<'a> {
    rig: &'a Rig<3>,
    x: [f64; 2],
    v: [f64; 2],
    /// −1, 0 where it holds, 1.
    modes: [i32; 2],
}

impl Scan<'_> {
    /// Accelerations of both bodies with these friction forces.
    fn acceleration(&self, t: f64, x: [f64; 2], force: [f64; 2]) -> [f64; 2] {
        let (rig, drive) = (
            self.rig,
            math::cos(self.rig.omega * t) * self.rig.forcing[0],
        );
        [
            (drive - rig.stiffness[0][0] * x[0] - force[0] + force[1]) / rig.masses[0],
            (-rig.stiffness[1][1] * x[1] - force[1]) / rig.masses[1],
        ]
    }

    /// The forces that keep holding contacts in place.
    fn forces(&self, t: f64, x: [f64; 2]) -> [f64; 2] {
        let (f, m) = (self.rig.friction, self.rig.masses);
        let slip = [0, 1].map(|c| f[c] * f64::from(self.modes[c]));
        let free = self.acceleration(t, x, [0.0; 2]);
        match self.modes.map(|mode| mode == 0) {
            [false, false] => slip,
            // The lower body does not move: friction balances its drive.
            [true, false] => [m[0] * free[0] + slip[1], slip[1]],
            // Both move together.
            [false, true] => {
                let lower = free[0] - slip[0] / m[0];
                [slip[0], (free[1] - lower) / (1.0 / m[0] + 1.0 / m[1])]
            }
            [true, true] => [m[0] * free[0] + m[1] * free[1], m[1] * free[1]],
        }
    }

    fn relative(v: [f64; 2]) -> [f64; 2] {
        [v[0], v[1] - v[0]]
    }

    /// The modes of two contacts from zero. Modes are tried in descending order of the number of
    /// holding contacts, with static friction. Released contacts slip with kinetic friction.
    fn settle(&mut self, t: f64, at_zero: [bool; 2]) {
        let ratio = self.rig.ratio;
        let mut open = at_zero;
        while open.contains(&true) {
            let before = self.modes;
            let mut consistent = Vec::new();
            for code in 0..9 {
                let tried = [code % 3 - 1, code / 3 - 1];
                self.modes = [0, 1].map(|c| if open[c] { tried[c] } else { before[c] });
                if [0, 1].iter().any(|&c| !open[c] && tried[c] != 0) {
                    continue;
                }
                // Contacts that are decided now have static friction, also where they are released.
                let mut rig = self.rig.clone();
                for c in 0..2 {
                    rig.friction[c] *= if open[c] { ratio } else { 1.0 };
                }
                let scan = Scan { rig: &rig, ..*self };
                let force = scan.forces(t, self.x);
                let rates = Scan::relative(scan.acceleration(t, self.x, force));
                let fits = (0..2).all(|c| {
                    !open[c]
                        || if self.modes[c] == 0 {
                            force[c].abs() <= rig.friction[c]
                        } else {
                            rates[c] * f64::from(self.modes[c]) > 0.0
                        }
                });
                if fits {
                    consistent.push(self.modes);
                }
            }
            assert_eq!(consistent.len(), 1, "{consistent:?} at {t}");
            self.modes = consistent[0];
            let gave_way = (0..2).any(|c| open[c] && self.modes[c] != 0);
            for c in 0..2 {
                open[c] &= self.modes[c] == 0;
            }
            if !gave_way {
                break;
            }
        }
    }

    /// One step of order 4, and the events that it passes.
    fn step(&mut self, t: f64) -> bool {
        let slope =
            |x: [f64; 2], v: [f64; 2], t: f64| (v, self.acceleration(t, x, self.forces(t, x)));
        let moved = |a: [f64; 2], h: f64, b: [f64; 2]| [a[0] + h * b[0], a[1] + h * b[1]];
        let (x, v, h) = (self.x, self.v, STEP);
        let k1 = slope(x, v, t);
        let k2 = slope(
            moved(x, h / 2.0, k1.0),
            moved(v, h / 2.0, k1.1),
            t + h / 2.0,
        );
        let k3 = slope(
            moved(x, h / 2.0, k2.0),
            moved(v, h / 2.0, k2.1),
            t + h / 2.0,
        );
        let k4 = slope(moved(x, h, k3.0), moved(v, h, k3.1), t + h);
        for i in 0..2 {
            self.x[i] += h / 6.0 * (k1.0[i] + 2.0 * k2.0[i] + 2.0 * k3.0[i] + k4.0[i]);
            self.v[i] += h / 6.0 * (k1.1[i] + 2.0 * k2.1[i] + 2.0 * k3.1[i] + k4.1[i]);
        }
        let relative = Scan::relative(self.v);
        let force = self.forces(t + h, self.x);
        let mut at_zero = self.modes.map(|mode| mode == 0);
        let mut happened = false;
        for c in 0..2 {
            let mode = self.modes[c];
            if mode == 0 && force[c].abs() > self.rig.ratio * self.rig.friction[c] {
                (self.modes[c], at_zero[c], happened) =
                    (if force[c] > 0.0 { 1 } else { -1 }, false, true);
            } else if mode != 0 && relative[c] * f64::from(mode) < 0.0 {
                (at_zero[c], happened) = (true, true);
            }
        }
        if happened {
            self.settle(t + h, at_zero);
        }
        happened
    }
}

#[test]
fn static_friction_at_two_contacts_agrees_with_a_scan() {
    let mut rig = stacked();
    rig.ratio = 1.5;
    let mut scan = Scan {
        rig: &rig,
        x: [0.0; 2],
        v: [0.0; 2],
        modes: [0, 0],
    };
    scan.settle(0.0, [true, true]);
    let mut expected = vec![(0.0, scan.modes)];
    for k in 0..(T_END / STEP) as usize {
        if scan.step(k as f64 * STEP) {
            expected.push(((k + 1) as f64 * STEP, scan.modes));
        }
    }
    let sign = |mode: Mode| match mode {
        Mode::Slip(Side::Below) => -1,
        Mode::Slip(Side::Above) => 1,
        Mode::Stick => 0,
    };
    for options in [
        Options::tol(1e-12),
        Options::tol(1e-14).method(Method::Taylor),
    ] {
        let orbit = solve(&Several(&rig), 0.0, [0.0; 6], T_END, &options).unwrap();
        let found: Vec<_> = orbit
            .phases
            .iter()
            .map(|phase| (phase.t_start, [sign(phase.mode[0]), sign(phase.mode[1])]))
            .collect();
        assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
        assert!(found.len() > 15);
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!(found.1, expected.1, "{found:?} {expected:?}");
            // The scan is late by up to a step at every event, which affects the following events.
            assert!(
                (found.0 - expected.0).abs() < 100.0 * STEP,
                "{found:?} {expected:?}"
            );
        }
    }
}

/// One block on another on the ground, of mass 1 each, pulled by t. The ground releases at 2 and
/// brakes with 1 afterwards. Together both would then start at 1/2, but the upper one is held with
/// 0.2 only.
pub struct Stacked;

impl Stacked {
    fn with<T: Scalar>(ground: f64, sides: &[Side; 2], t: T) -> [T; 2] {
        let top = 0.2 * sides[1].sign();
        [t - ground * sides[0].sign() + top, T::constant(-top)]
    }
}

impl Contacts<2, 2> for Stacked {
    fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, _x: &[T; 2]) -> [T; 2] {
        Stacked::with(1.0, sides, t)
    }
    fn holding<T: Scalar>(&self, sides: &[Side; 2], held: &[bool; 2], t: T, _x: &[T; 2]) -> [T; 2] {
        Stacked::with(if held[0] { 2.0 } else { 1.0 }, sides, t)
    }
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 2]) -> [T; 2] {
        [x[0], x[1] - x[0]]
    }
}

#[test]
fn a_contact_that_another_one_lets_go_is_among_those_that_change() {
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-13).method(method);
        let orbit = solve(
            &Several(TwoStates::Stacked(Stacked)),
            0.0,
            [0.0, 0.0],
            3.0,
            &options,
        )
        .unwrap();
        let [at] = &orbit.transitions[..] else {
            panic!("{:?}", orbit.transitions);
        };
        assert!((at.t - 2.0).abs() < 1e-13);
        assert_eq!((at.contact, at.kind), (0, TransitionKind::StickExit));
        let other = TransitionKind::between(at.from[1], at.to[1]);
        assert_eq!(other, TransitionKind::StickExit);
        assert!((orbit.x_end[0] - 1.3).abs() < 1e-12 && (orbit.x_end[1] - 0.2).abs() < 1e-12);
    }
}
