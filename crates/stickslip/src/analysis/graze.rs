//! Grazes: an event function turns at zero, to the tolerance, and whether a neighbouring orbit
//! passes it is open. The flow has no derivative there.

use numerics::bisect;

use super::cycle::SegmentEnd;
use super::instant::Cause;
use super::tangent::{Tangent, singular};
use crate::dynamics::{Dynamics, Guard, Moment, OrbitUnderWay, Step, Transition};
use crate::error::Error;
use crate::filippov::TransitionKind;
use crate::system::Mode;

/// Refuses the last step of an orbit without parameters as states, if the orbit grazes within it.
///
/// # Errors
/// [`Error::TangentSingular`], with the place of the graze.
pub(super) fn check_step(
    tangent: &Tangent<'_>,
    step: &Step,
    orbit: &mut dyn OrbitUnderWay,
) -> Result<(), Error> {
    let turning = turning_guards(tangent.system, step);
    if turning.is_empty() {
        return Ok(());
    }
    let solution = orbit.solution();
    let moment = |t: f64| Moment { t, x: solution(t) };
    match graze_in(tangent, &turning, step, &moment) {
        Some(at) => Err(singular(at.t, &at.x)),
        None => Ok(()),
    }
}

/// Whether an orbit grazes at a transition, which `end` describes: a touch, or a zero that would be
/// another one within the tolerance, or none.
pub(super) fn is_graze(
    tangent: &Tangent<'_>,
    at: &Transition,
    end: &SegmentEnd,
    cause: Cause,
) -> bool {
    if at.kind == TransitionKind::Touch {
        return true;
    }
    if at.kind == TransitionKind::StickExit || end.at_kink.is_some() {
        return false;
    }
    let (system, here) = (tangent.system, at.moment());
    let flow = system.flow(at.from, &here);
    let reset = end.is_of_jump.then(|| system.reset(at.contact, &here));
    let gradient = match &reset {
        Some(reset) => reset.gradient.clone(),
        None => flow.guard_gradient(end.guard, &here).0,
    };
    let [_, rate, bend, _] = flow.guard_jet(end.guard, &here);
    let zero = tangent.tolerance() * (gradient.abs().dot(&here.x.abs()) + gradient.abs().sum());
    // Impacts that accumulate are as short, but each neighbour has them, too.
    let follows_itself = reset.is_some_and(|reset| {
        let after = Moment {
            t: here.t,
            x: reset.after,
        };
        let leaves_zero = || system.reset(at.contact, &after).value.abs() <= zero;
        reset.rests || cause.follows == Some(at.contact) && leaves_zero()
    });
    let turns_back = rate * bend < 0.0;
    (turns_back || !follows_itself) && rate * rate <= 2.0 * bend.abs() * zero
}

/// The distances of contacts from their boundaries, and the functions of jumps, that turn back from
/// falling to rising over a step.
pub(super) fn turning_guards(system: &dyn Dynamics, step: &Step) -> Vec<usize> {
    let flow = system.flow(step.mode, &step.start());
    let own = |guard: &Guard| match guard.is_of_jump {
        // A stop that a gap touches at zero rate gives no impulse.
        true => guard.is_watched && !guard.is_condition,
        false => !guard.continues_phase && step.mode.get(guard.contact) != Mode::Stick,
    };
    let guards = flow.guards().into_iter().filter(own);
    let numbers = guards.map(|guard| guard.number);
    let rate = |guard: usize, at: &Moment| flow.guard_jet(guard, at)[1];
    numbers
        .filter(|&one| rate(one, &step.start()) < 0.0 && rate(one, &step.end()) > 0.0)
        .collect()
}

/// The place in a step at which one of these guards turns back from zero: within the tolerance of
/// the state it passes through as well. A run reports nothing there if it does not pass.
pub(super) fn graze_in(
    tangent: &Tangent<'_>,
    guards: &[usize],
    step: &Step,
    moment: &dyn Fn(f64) -> Moment,
) -> Option<Moment> {
    let flow = tangent.system.flow(step.mode, &step.start());
    let is_zero = |guard: usize, at: &Moment| {
        let (gradient, _) = flow.guard_gradient(guard, at);
        let size = gradient.abs().dot(&at.x.abs()) + gradient.abs().sum();
        flow.guard(guard, at).abs() <= tangent.tolerance() * size
    };
    let turned = guards.iter().filter_map(|&guard| {
        // One that leaves its zero here has passed it before.
        if is_zero(guard, &step.start()) {
            return None;
        }
        let rises = |t: f64| flow.guard_jet(guard, &moment(t))[1] >= 0.0;
        let at = moment(bisect(step.t_start, step.t_end, rises));
        is_zero(guard, &at).then_some(at)
    });
    turned.min_by(|a, b| a.t.total_cmp(&b.t))
}
