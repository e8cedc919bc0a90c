//! Properties of every orbit of a block on a belt, for random parameters and starts (from a fixed
//! seed).

use std::ops::ControlFlow;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use stickslip::scalar::Dual;
use stickslip::{Mode, Observer, Orbit, Side, State, Transition, TransitionKind};

use super::check::{assert_consistent, changes, ulp_of_boundary};
use crate::any_system::{monodromy, run, solve};
use crate::blocks::Block;
use crate::compiled::Compiled;
use crate::solver::systems::Reversed;

fn belt() -> impl Strategy<Value = Block> {
    (
        0.3..3.0f64,
        -1.0..1.5f64,
        0.2..2.0f64,
        0.02..1.0f64,
        0.0..2.0f64,
        0.05..1.5f64,
    )
        .prop_map(|(mass, k1, k2, mu0, delta, belt_speed)| Block {
            mass,
            k1,
            k2,
            mu0,
            delta,
            ..Block::on_belt(belt_speed)
        })
}

fn forced() -> impl Strategy<Value = Block> {
    (
        0.1..2.0f64,
        0.5..2.0f64,
        0.02..0.5f64,
        0.0..2.0f64,
        0.05..0.8f64,
        0.0..0.6f64,
        0.3..4.0f64,
    )
        .prop_map(
            |(mass, k1, mu0, delta, belt_speed, amplitude, omega)| Block {
                mass,
                k1: -k1,
                k2: -0.1,
                mu0,
                delta,
                belt_speed,
                amplitude,
                omega,
            },
        )
}

fn start() -> impl Strategy<Value = State<2>> {
    (-1.2..1.2f64, -1.2..1.2f64).prop_map(|(x, v)| State::from([x, v]))
}

fn seeded(cases: u32) -> Config {
    Config {
        cases,
        rng_seed: RngSeed::Fixed(2013),
        failure_persistence: None,
        ..Config::default()
    }
}

const TOLERANCE: f64 = 1e-12;

/// The run, or `None` if it escapes: a softening spring pushes outwards at large distances.
fn orbit_of<S: Compiled<2>>(system: &S, x0: State<2>, t_end: f64) -> Option<Orbit<2>> {
    solve(system, 0.0, x0, t_end, &super::tol(TOLERANCE).escape(20.0)).ok()
}

fn assert_invariants<S: Compiled<2>>(system: &S, belt_speed: f64, orbit: &Orbit<2>) {
    assert_consistent(system, orbit);
    // Between transitions the orbit is on the correct side of Σ, up to the tolerance.
    for step in &orbit.steps {
        for part in 1..8 {
            let t = step.t_start + (step.t_end - step.t_start) * f64::from(part) / 8.0;
            let x = orbit.at(t).expect("covered");
            let h = system.boundary(t, x.as_ref());
            match step.mode {
                Mode::Slip(side) => {
                    assert!(h * side.sign() > -20.0 * TOLERANCE, "t = {t}: h = {h}")
                }
                Mode::Stick => assert!(
                    h.abs() <= 8.0 * ulp_of_boundary(system, t, &x),
                    "t = {t}: h = {h}"
                ),
            }
        }
    }
    for change in changes(orbit) {
        let rate = |side| {
            let x = change.x.as_ref();
            let f = system.field(side, change.t, x);
            let along = std::array::from_fn(|i| Dual::new(x[i], f[i]));
            system.boundary(Dual::new(change.t, 1.0), &along).eps
        };
        let (below, above) = (rate(Side::Below), rate(Side::Above));
        // Rounding of forces of size ten over a mass of 0.1.
        let rounding = 1e-12;
        match (change.kind, change.from, change.to) {
            (TransitionKind::Crossing, _, Mode::Slip(side)) => {
                assert!(
                    below * side.sign() > -rounding && above * side.sign() > -rounding,
                    "{change:?}"
                );
            }
            (TransitionKind::StickEntry, ..) => {
                assert!(below > -rounding && above < rounding, "{change:?}")
            }
            (TransitionKind::StickExit, _, Mode::Slip(side)) => {
                let released = if side == Side::Below { below } else { above };
                assert!(released.abs() < rounding, "{change:?}: {released}");
            }
            _ => panic!("{change:?}"),
        }
    }
    for stick in orbit.sticks() {
        let length = stick.displacement()[0] - belt_speed * stick.duration();
        let steps = 1.0 + orbit.steps.iter().filter(|s| s.mode == Mode::Stick).count() as f64;
        let size = stick.x_end[0].abs()
            + stick.x_start[0].abs()
            + belt_speed * (stick.t_end + 28.0 * stick.duration());
        assert!(length.abs() <= steps * f64::EPSILON * size, "{length}");
    }
    for phase in &orbit.phases {
        assert_eq!(orbit.at(phase.t_end).expect("covered"), phase.x_end);
    }
    let ends: Vec<f64> = orbit.phases.iter().map(|p| p.t_end).collect();
    assert_eq!(
        orbit.sample(ends.iter().copied()).expect("covered").len(),
        ends.len()
    );
}

struct TransitionRecorder(Vec<Transition<2>>);

impl Observer<2> for TransitionRecorder {
    fn transition(&mut self, transition: &Transition<2>) -> ControlFlow<()> {
        self.0.push(*transition);
        ControlFlow::Continue(())
    }
}

fn assert_streams_alike<S: Compiled<2>>(system: &S, x0: State<2>, orbit: &Orbit<2>) {
    let mut keep = TransitionRecorder(Vec::new());
    let options = super::tol(TOLERANCE).escape(20.0);
    let summary = run(system, 0.0, x0, orbit.t_end, &options, &mut keep).expect("runs");
    assert_eq!(keep.0, orbit.transitions);
    assert_eq!(
        (summary.t, summary.x, summary.ending),
        (orbit.t_end, orbit.x_end, orbit.ending)
    );
    assert_eq!(summary.counters, orbit.counters);
    assert_eq!(
        orbit_of(system, x0, orbit.t_end).as_ref(),
        Some(orbit),
        "the same bits"
    );
}

/// Norm of the flow's derivative, the largest amplification of errors. It is computed wherever a
/// run succeeds: an infinite bound would allow anything.
fn growth<S: Compiled<2>>(system: &S, t0: f64, x0: State<2>, t_end: f64) -> f64 {
    let options = super::tol(TOLERANCE).escape(20.0);
    monodromy(system, t0, x0, t_end, &options)
        .expect("runs")
        .matrix
        .amax()
        .max(1.0)
}

fn assert_runs_join<S: Compiled<2>>(system: &S, x0: State<2>, orbit: &Orbit<2>, part: f64) {
    let (middle, end) = (orbit.t_end * part, orbit.t_end);
    let options = super::tol(TOLERANCE).escape(20.0);
    let first = solve(system, 0.0, x0, middle, &options).expect("runs");
    let second = solve(system, middle, first.x_end, end, &options).expect("runs");
    let error = (second.x_end - orbit.x_end).amax();
    let steps = orbit.steps.len() as f64;
    let allowed = 4.0
        * steps
        * TOLERANCE
        * growth(system, 0.0, x0, end)
        * growth(system, middle, first.x_end, end);
    assert!(error <= allowed.max(1e-10), "{error} {allowed}");
}

fn assert_reverses<S: Compiled<2> + Copy>(system: &S, orbit: &Orbit<2>)
where
    Reversed<S>: Compiled<2>,
{
    let options = super::tol(TOLERANCE);
    for phase in orbit.phases.iter().filter(|p| p.mode != Mode::Stick) {
        // A smooth stretch strictly inside the phase.
        let (from, to) = (
            phase.t_start + 0.1 * phase.duration(),
            phase.t_end - 0.1 * phase.duration(),
        );
        let (there, end) = (
            orbit.at(from).expect("covered"),
            orbit.at(to).expect("covered"),
        );
        let forth = solve(system, from, there, to, &options).expect("runs");
        let back = solve(&Reversed(*system), -to, forth.x_end, -from, &options).expect("runs");
        // A stretch inside a phase has only touches; beyond one neither direction is smooth.
        let mut met = forth.transitions.iter().chain(&back.transitions);
        if let Some(first) = met.next() {
            assert!(
                first.kind == TransitionKind::Touch && met.all(|at| at.kind == first.kind),
                "{first:?}"
            );
            continue;
        }
        let enlarged = growth(&Reversed(*system), -to, end, -from);
        let error = (back.x_end - there).amax();
        let steps = (forth.steps.len() + back.steps.len()) as f64;
        assert!(
            error <= 4.0 * steps * TOLERANCE * enlarged,
            "{error}, enlarged by {enlarged}"
        );
    }
}

proptest! {
    #![proptest_config(seeded(150))]

    #[test]
    fn belt_oscillators(belt in belt(), x0 in start(), part in 0.1..0.9f64) {
        let orbit = orbit_of(&belt, x0, 25.0).expect("a hardening spring holds");
        assert_invariants(&belt, belt.belt_speed, &orbit);
        assert_streams_alike(&belt, x0, &orbit);
        assert_runs_join(&belt, x0, &orbit, part);
        assert_reverses(&belt, &orbit);
    }

    #[test]
    fn forced_oscillators(forced in forced(), x0 in start(), part in 0.1..0.9f64) {
        // A case is rejected, not passed: the requested number of cases remains.
        let Some(orbit) = orbit_of(&forced, x0, 25.0) else {
            return Err(TestCaseError::reject("it escapes"));
        };
        assert_invariants(&forced, forced.belt_speed, &orbit);
        assert_streams_alike(&forced, x0, &orbit);
        assert_runs_join(&forced, x0, &orbit, part);
        assert_reverses(&forced, &orbit);
    }
}
