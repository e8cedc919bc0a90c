//! Properties of every orbit of any system.

use stickslip::scalar::Dual;
use stickslip::{
    Filippov, Locator, Mode, Options, Orbit, Side, State, StepRecord, Transition, TransitionKind,
};

/// Tolerance of the comparisons with closed forms.
pub const TIGHT: f64 = 1e-13;

/// The locators of the method, at [`TIGHT`].
pub fn every_locator() -> impl Iterator<Item = Options> {
    super::LOCATORS
        .iter()
        .map(|locator| super::tol(TIGHT).locator(*locator))
}

/// The locators that keep the tolerance for any step length. The paper's single Hénon step over all
/// of it does not.
pub fn exact_locators() -> Vec<Locator> {
    let all = super::LOCATORS.iter().copied();
    all.filter(|locator| *locator != Locator::Henon).collect()
}

/// Kinds of the transitions, in order.
pub fn kinds<const N: usize>(orbit: &Orbit<N>) -> Vec<TransitionKind> {
    orbit.transitions.iter().map(|t| t.kind).collect()
}

/// Transitions other than touches, in order.
pub fn changes<const N: usize>(orbit: &Orbit<N>) -> Vec<Transition<N>> {
    let no_touch = |t: &&Transition<N>| t.kind != TransitionKind::Touch;
    orbit.transitions.iter().filter(no_touch).copied().collect()
}

/// Gradient of the boundary function in the state, and its time derivative.
fn boundary_gradient<S: Filippov<N>, const N: usize>(
    system: &S,
    t: f64,
    x: &State<N>,
) -> ([f64; N], f64) {
    let along = |direction: usize| {
        let seed = |component| f64::from(u8::from(component == direction));
        let x = std::array::from_fn(|i| Dual::new(x[i], seed(i)));
        system.boundary(Dual::new(t, seed(N)), &x).eps
    };
    (std::array::from_fn(along), along(N))
}

/// One unit in the last place of the boundary function at `(t, x)`: its change when every component
/// and the time change by one unit.
pub fn ulp_of_boundary<S: Filippov<N>, const N: usize>(system: &S, t: f64, x: &State<N>) -> f64 {
    let (gradient, in_time) = boundary_gradient(system, t, x);
    let by_state: f64 = gradient.iter().zip(x).map(|(g, x)| (g * x).abs()).sum();
    // Terms of the boundary function may be as large as 1 where those of the state are small.
    f64::EPSILON * (by_state + (in_time * t).abs() + 1.0)
}

/// Asserts properties of any orbit. Phases and steps join without gap or overlap, and none is
/// empty. The transitions belong to them, and states on Σ lie on Σ.
pub fn assert_consistent<S: Filippov<N>, const N: usize>(system: &S, orbit: &Orbit<N>) {
    assert_steps_join(orbit);
    assert_phases_join(orbit);
    assert_transitions_match(orbit);
    assert_on_boundary(system, orbit);
}

fn assert_steps_join<const N: usize>(orbit: &Orbit<N>) {
    assert_eq!(orbit.counters.steps as usize, orbit.steps.len());
    assert_eq!(orbit.steps[0].t_start, orbit.t_start);
    for pair in orbit.steps.windows(2) {
        assert_eq!(pair[0].t_end, pair[1].t_start);
        if pair[0].mode == pair[1].mode || pair[1].mode != Mode::Stick {
            assert_eq!(pair[0].x_end, pair[1].x_start);
        } else {
            // On entry into stick the state is projected onto Σ; only rounding moves it.
            let moved = (pair[0].x_end - pair[1].x_start).amax();
            assert!(
                moved <= 8.0 * f64::EPSILON * (1.0 + pair[0].x_end.amax()),
                "{moved}"
            );
        }
    }
    for step in &orbit.steps {
        // Rounding may put an event after the end of a step; then the next step may be very short.
        assert!(
            step.t_start <= step.t_end,
            "{} .. {}",
            step.t_start,
            step.t_end
        );
    }
    let last = orbit.steps.last().expect("steps");
    assert_eq!((last.t_end, last.x_end), (orbit.t_end, orbit.x_end));
}

fn assert_phases_join<const N: usize>(orbit: &Orbit<N>) {
    let (first, last) = (orbit.phases[0], *orbit.phases.last().expect("phases"));
    assert_eq!(
        (first.t_start, first.x_start),
        (orbit.t_start, orbit.x_start)
    );
    assert_eq!((last.t_end, last.x_end), (orbit.t_end, orbit.x_end));
    for pair in orbit.phases.windows(2) {
        assert_eq!(pair[0].t_end, pair[1].t_start);
        assert_eq!(pair[0].x_end, pair[1].x_start);
        assert_ne!(pair[0].mode, pair[1].mode, "at t = {}", pair[0].t_end);
    }
    for phase in &orbit.phases {
        assert!(
            phase.duration() > 0.0,
            "empty phase at t = {}",
            phase.t_start
        );
    }
}

fn assert_transitions_match<const N: usize>(orbit: &Orbit<N>) {
    assert_eq!(orbit.counters.events as usize, orbit.transitions.len());
    assert!(orbit.counters.locations >= orbit.counters.events);
    let changes = changes(orbit);
    assert_eq!(changes.len(), orbit.phases.len() - 1);
    for (change, pair) in changes.iter().zip(orbit.phases.windows(2)) {
        assert_eq!((change.t, change.x), (pair[1].t_start, pair[1].x_start));
        assert_eq!((change.from, change.to), (pair[0].mode, pair[1].mode));
        let kind = match (change.from, change.to) {
            (Mode::Slip(_), Mode::Slip(_)) => TransitionKind::Crossing,
            (_, Mode::Stick) => TransitionKind::StickEntry,
            (Mode::Stick, _) => TransitionKind::StickExit,
        };
        assert_eq!(change.kind, kind);
    }
    for pair in orbit.transitions.windows(2) {
        assert!(
            pair[0].t < pair[1].t,
            "two transitions at t = {}",
            pair[1].t
        );
    }
}

/// Rounding in the boundary function after one step of DOP853. Its weights add up to 13.6 in
/// magnitude; each slope is rounded once, at a state that is rounded as often.
fn rounding_of_step<S: Filippov<N>, const N: usize>(system: &S, step: &StepRecord<N>) -> f64 {
    let (gradient, _) = boundary_gradient(system, step.t_end, &step.x_end);
    let side = match step.mode {
        Mode::Slip(side) => side,
        Mode::Stick => Side::Below,
    };
    let before = system.field(side, step.t_start, &step.x_start.into());
    let after = system.field(side, step.t_end, &step.x_end.into());
    let slope = (0..N).map(|i| gradient[i].abs() * before[i].abs().max(after[i].abs()));
    32.0 * f64::EPSILON * (step.t_end - step.t_start) * slope.sum::<f64>()
}

fn assert_on_boundary<S: Filippov<N>, const N: usize>(system: &S, orbit: &Orbit<N>) {
    let starts_of_other_phases = orbit
        .steps
        .windows(2)
        .filter(|pair| pair[0].mode != pair[1].mode);
    let landings = starts_of_other_phases.map(|pair| &pair[0]);
    let sticks = orbit.steps.iter().filter(|step| step.mode == Mode::Stick);
    for step in landings.chain(sticks) {
        let ulp = ulp_of_boundary(system, step.t_end, &step.x_end);
        let allowed = 4.0 * ulp + rounding_of_step(system, step);
        let h = system.boundary(step.t_end, &step.x_end.into()).abs();
        assert!(
            h <= allowed,
            "t = {}: |h| = {h}, allowed {allowed}",
            step.t_end
        );
    }
}

/// Asserts that every change of phase lies on Σ to four units in the last place, as every
/// locator manages where steps are short or the rate across Σ is steady.
pub fn assert_lands_on_boundary<S: Filippov<N>, const N: usize>(system: &S, orbit: &Orbit<N>) {
    for change in changes(orbit) {
        let ulp = ulp_of_boundary(system, change.t, &change.x);
        let h = system.boundary(change.t, &change.x.into()).abs();
        assert!(
            h <= 4.0 * ulp,
            "{:?} at t = {}: |h| = {h}, ulp {ulp}",
            change.kind,
            change.t
        );
    }
}
