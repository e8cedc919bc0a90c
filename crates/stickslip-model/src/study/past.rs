//! The past of a state, by a run with reversed time.
//!
//! A slide along a boundary has no past of its own: every orbit that entered it before leads to the
//! same state. A run of the reversed system does not stop there by itself, since a slide is left
//! tangentially, and rounding decides whether the run meets the boundary.

use stickslip::dynamics::{Moment, OrbitUnderWay, SmoothFlow, Step, Transition, Vector};
use stickslip::scalar::Dual;
use stickslip::{Mode, Options};

use crate::file::System;
use crate::kernel::Combination;

/// Parts of a step at whose ends the distance from a boundary is evaluated. Chosen: a step of the
/// highest order is about a quarter of a period of a harmonic.
const PARTS_OF_STEP: u32 = 8;

/// Halvings of a part in which the distance has a minimum: all digits of a double.
const HALVINGS: u32 = 53;

/// Distance from a boundary that counts as none, in units of the tolerance of the run. Chosen: a
/// run that is followed there and back comes this close to a slide that it has left.
const TOLERANCES: f64 = 1e4;

/// Reason for which a system cannot run backwards.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "backwards in time is for smooth fields and contacts, and the system has {what}; run it \
        forwards, or leave {what} out"
)]
pub struct NoPast {
    what: &'static str,
}

/// Checks whether a system has nothing that is only defined forwards in time.
///
/// # Errors
/// [`NoPast`] for jumps, stops, and inputs with kinks.
pub fn check(system: &System) -> Result<(), NoPast> {
    let file = &system.file;
    let all = [
        (file.stops.is_empty(), "stops"),
        (file.jumps.is_empty(), "jumps"),
        (file.inputs.is_empty(), "inputs or switches"),
    ];
    match all.into_iter().find(|(is_empty, _)| !is_empty) {
        Some((_, what)) => Err(NoPast { what }),
        None => Ok(()),
    }
}

/// Finds where the past of an orbit is not unique, along a run of the reversed system.
pub struct PastWatch<'s> {
    system: &'s System,
    options: Options,
}

impl<'s> PastWatch<'s> {
    /// A watch on a run of a system that is reversed.
    pub fn new(system: &'s System, options: &Options) -> Self {
        PastWatch {
            system,
            options: *options,
        }
    }

    /// The contact that slides at a start.
    pub fn start(&self, at: &Moment) -> Option<usize> {
        (0..self.system.contacts()).find(|&contact| self.may_slide(contact, at))
    }

    /// The contact that a transition brings into a slide, or that may have left one there.
    pub fn transition(&self, at: &Transition) -> Option<usize> {
        let contact = Some(at.contact).filter(|&contact| contact < self.system.contacts())?;
        let sticks = at.to.get(contact) == Mode::Stick;
        (sticks || self.may_slide(contact, &at.moment())).then_some(contact)
    }

    /// The place at which the orbit touches a boundary in its last step, and the contact.
    pub fn step(&self, orbit: &mut dyn OrbitUnderWay) -> Option<(Moment, usize)> {
        if self.system.contacts() == 0 {
            return None;
        }
        let step = orbit.last_step();
        let flow = self.system.dynamics().flow(step.mode, &step_start(&step));
        let solution = orbit.solution();
        let state = |t: f64| Moment { t, x: solution(t) };
        let time = |part: u32| {
            let part = f64::from(part) / f64::from(PARTS_OF_STEP);
            step.t_start + part * (step.t_end - step.t_start)
        };
        let guards = flow.guards().into_iter();
        let own = guards.filter(|guard| !guard.is_of_jump && !guard.continues_phase);
        let touched = own.filter_map(|guard| {
            let rate = |t: f64| flow.guard_jet(guard.number, &state(t))[1];
            let (mut from, mut falls) = (step.t_start, rate(step.t_start) < 0.0);
            for part in 1..=PARTS_OF_STEP {
                let to = time(part);
                let still = rate(to) < 0.0;
                if falls && !still {
                    let at = state(minimum((from, to), &rate));
                    if self.is_on(&*flow, guard.number, &at) {
                        return Some((at, guard.contact));
                    }
                }
                (from, falls) = (to, still);
            }
            None
        });
        touched.min_by(|a, b| a.0.t.total_cmp(&b.0.t))
    }

    /// Whether a guard vanishes within what counts as no distance.
    fn is_on(&self, flow: &dyn SmoothFlow, guard: usize, at: &Moment) -> bool {
        flow.guard(guard, at).abs() <= self.allowed(&at.x)
    }

    /// The distance from a boundary that counts as none, at a state.
    fn allowed(&self, x: &Vector) -> f64 {
        TOLERANCES * self.options.largest_allowed(x)
    }

    /// Whether a state is on the boundary of a contact that holds there, forwards in time: both
    /// fields point towards it, which lead away from it in reversed time.
    fn may_slide(&self, contact: usize, at: &Moment) -> bool {
        let system = self.system;
        let x = at.x.as_slice();
        if system.boundary(contact, at.t, x).abs() > self.allowed(&at.x) {
            return false;
        }
        let rate = |is_above: bool| {
            let above = (0..system.contacts()).fold(0, |above, i| {
                let is_above = match i == contact {
                    true => is_above,
                    false => system.boundary(i, at.t, x) > 0.0,
                };
                above | usize::from(is_above) << i
            });
            let held = match system.built.has_static {
                true => 1 << contact,
                false => 0,
            };
            let velocity = system.field(Combination { above, held }, at.t, x);
            let moving = x.iter().zip(&velocity);
            let moving: Vec<Dual<f64>> = moving.map(|(&x, &v)| Dual::new(x, v)).collect();
            system.boundary(contact, Dual::new(at.t, 1.0), &moving).eps
        };
        let (below, above) = (rate(false), rate(true));
        let margin = self.allowed(&at.x).sqrt() * (below.abs() + above.abs());
        below < margin && above > -margin
    }
}

fn step_start(step: &Step) -> Moment {
    Moment {
        t: step.t_start,
        x: step.x_start.clone(),
    }
}

/// The time at which a falling function rises again, by bisection of its rate.
fn minimum((mut from, mut to): (f64, f64), rate: &dyn Fn(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        match rate(middle) < 0.0 {
            true => from = middle,
            false => to = middle,
        }
    }
    to
}
