//! Events that come at one instant: whether their order matters to the vectors that pass them.

use super::instant::{Cause, Zero, guard_of};
use super::tangent::singular;
use crate::dynamics::{
    Dynamics, Guard, KinkShift, Matrix, Modes, Moment, Step, Transition, Vector, instant,
};
use crate::error::{Error, Point};
use crate::filippov::TransitionKind;
use crate::system::Mode;

/// Relative difference of two numbers that are equal but for rounding: half of the digits of a
/// double. The other half is left to the errors of the vectors.
pub(super) const SAME: f64 = 1.490_116_119_384_765_6e-8;

/// Checks whether events that come at the instant of a transition may come in either order. They
/// are the first event there, and each other one that its own function or the kink of an input
/// decides. The order matters to a vector that moves their times apart, unless both orders lead to
/// the same state and to the same vector. Returns the effect of both where one transition covers
/// them, as of a jump at which a contact comes to its boundary.
///
/// # Errors
/// [`Error::SimultaneousEvents`] where the order matters to one of these vectors, which are those
/// at the transition; [`Error::TangentSingular`] where the events are zeros of two contacts.
pub(super) fn check_order(
    system: &dyn Dynamics,
    at: &Transition,
    cause: Cause,
    columns: &[Vector],
) -> Result<Option<Matrix>, Error> {
    if !cause.is_first || at.kind == TransitionKind::Touch {
        return Ok(None);
    }
    let place = Place {
        mode: at.from,
        at: at.moment(),
    };
    let matters = || Error::SimultaneousEvents {
        t: at.t,
        x: Point::from(&at.x),
    };
    if let Some(input) = cause.kink {
        let of_kink = |y: &Vector| kink_time(system, input, &place, y);
        let is_alike = |other: &Meeting| {
            let other = other.effect(system, &place, at.t);
            columns.iter().all(|y| other.is_at(of_kink(y), y))
        };
        let is_free = others(system, at, &place, 0.0).iter().all(is_alike);
        return is_free.then_some(None).ok_or_else(matters);
    }
    let own = Meeting::of(system, at);
    let zero = own.effect(system, &place, at.t).zero;
    // What location leaves of a guard.
    let late = match own {
        Meeting::Contact { .. } if zero.goes() => at.residual / zero.rate.abs(),
        _ => 0.0,
    };
    let mut joint = None;
    for other in others(system, at, &place, late) {
        match (order(system, &place, [own, other], columns), own, other) {
            (Order::Alike, ..) => {}
            (Order::Matters, Meeting::Contact { .. }, Meeting::Contact { .. }) => {
                return Err(singular(at.t, &at.x));
            }
            (Order::Free(both), Meeting::Jump(_), Meeting::Contact { contact, .. })
                if at.to.get(contact) != at.from.get(contact) =>
            {
                let is_whole = joint.is_none() && both.mode == at.to;
                joint = Some(is_whole.then_some(both.matrix).ok_or_else(matters)?);
            }
            (Order::Free(_), ..) => {}
            (Order::Matters, ..) => return Err(matters()),
        }
    }
    let kinks = system.kinks(&place.at);
    if !kinks.is_empty() && kink_matters(system, &place, own, &kinks, columns) {
        return Err(matters());
    }
    Ok(joint)
}

/// Checks whether kinks of several inputs that end a step may come in either order.
///
/// # Errors
/// [`Error::SimultaneousEvents`] where the order matters and one of these vectors moves the times
/// apart.
pub(super) fn check_kinks(
    system: &dyn Dynamics,
    step: &Step,
    columns: &[Vector],
) -> Result<(), Error> {
    let shifts = system.kink_shifts(step);
    let matters = |shift: &KinkShift| shift.order.amax() > SAME * shift.kick.amax();
    let is_apart = |y: &Vector| {
        let mut times = shifts
            .iter()
            .map(|shift| shift.gradient.dot(y) / shift.rate);
        let first = times.next().unwrap_or(0.0);
        times.any(|time| (time - first).abs() > SAME * time.abs().max(first.abs()))
    };
    match shifts.iter().any(matters) && columns.iter().any(is_apart) {
        true => Err(Error::SimultaneousEvents {
            t: step.t_end,
            x: Point::from(&step.x_end),
        }),
        false => Ok(()),
    }
}

/// Whether the order of two events matters.
enum Order {
    /// Vectors move the times of both alike.
    Alike,
    /// Both orders have this effect.
    Free(Joint),
    Matters,
}

/// The effect of two events, and the mode after them.
struct Joint {
    mode: Modes,
    matrix: Matrix,
}

/// A mode and a moment.
struct Place {
    mode: Modes,
    at: Moment,
}

/// An event that its own function decides.
#[derive(Clone, Copy)]
enum Meeting {
    /// A jump, counted after the contacts.
    Jump(usize),
    /// The zero of a contact's guard.
    Contact {
        contact: usize,
        guard: usize,
        to: Mode,
    },
}

/// The effect of an event at a place on vectors and on the place.
struct Effect {
    zero: Zero,
    /// The time of the event changes by its product with a vector.
    time: Vector,
    matrix: Matrix,
    after: Place,
}

impl Effect {
    /// Whether a vector changes the time of the event by so much, to rounding.
    fn is_at(&self, time: f64, y: &Vector) -> bool {
        let size = self.time.abs().dot(&y.abs());
        (self.time.dot(y) - time).abs() <= SAME * size.max(time.abs())
    }

    /// Whether it is the event of another effect, which another event has not moved.
    fn is_still(&self, before: &Effect) -> bool {
        self.zero.is_reached() && self.zero.rate * before.zero.rate > 0.0
    }
}

impl Meeting {
    /// The event of a transition.
    fn of(system: &dyn Dynamics, at: &Transition) -> Self {
        match at.kind {
            TransitionKind::Jump => Meeting::Jump(at.contact),
            _ => Meeting::Contact {
                contact: at.contact,
                guard: guard_of(system, at, at.t).map_or(at.contact, |guard| guard.number),
                to: at.to.get(at.contact),
            },
        }
    }

    /// The effect at a place, where inputs hold their values from a time on. It is not a number
    /// where a jump does not happen.
    fn effect(self, system: &dyn Dynamics, place: &Place, held: f64) -> Effect {
        let Place { mode, ref at } = *place;
        let flow = system.flow_held(mode, at, held);
        let before = flow.velocity(at);
        let n = at.x.len();
        match self {
            Meeting::Jump(jump) => {
                let zero = Zero::of_jump(system, jump, mode, at, held);
                let reset = system.reset_held(jump, at, held);
                let to = Moment {
                    t: at.t,
                    x: reset.after,
                };
                let after = Place {
                    mode: mode_after(system, place, &to, held),
                    at: to,
                };
                let flow = system.flow_held(after.mode, &after.at, held);
                let kick = flow.velocity(&after.at) - &reset.by_state * before - &reset.by_time;
                let time = -reset.gradient / zero.rate;
                Effect {
                    zero,
                    matrix: reset.by_state - kick * time.transpose(),
                    time,
                    after,
                }
            }
            Meeting::Contact { contact, guard, to } => {
                let zero = Zero::of_guard(system, guard, mode, at, held);
                let (gradient, _) = flow.guard_gradient(guard, at);
                let after = Place {
                    mode: mode.with(contact, to),
                    at: at.clone(),
                };
                let kick = system.flow_held(after.mode, at, held).velocity(at) - before;
                let time = -gradient / zero.rate;
                Effect {
                    zero,
                    matrix: Matrix::identity(n, n) - kick * time.transpose(),
                    time,
                    after,
                }
            }
        }
    }
}

/// The mode after a jump: contacts that slip lie on the side to which it sets them.
fn mode_after(system: &dyn Dynamics, place: &Place, to: &Moment, held: f64) -> Modes {
    let flow = system.flow_held(place.mode, to, held);
    let guards = flow.guards().into_iter();
    let own = guards.filter(|guard| !guard.is_of_jump && !guard.continues_phase);
    own.fold(place.mode, |mode, guard| {
        let zero = Zero::of_guard(system, guard.number, place.mode, to, held);
        match place.mode.get(guard.contact) {
            Mode::Slip(side) if zero.value < 0.0 && !zero.is_here() => {
                mode.with(guard.contact, Mode::Slip(side.opposite()))
            }
            _ => mode,
        }
    })
}

/// The mode of a contact that comes to its boundary: the other side if its field leads away from
/// there, and stick if it leads back.
fn beyond(system: &dyn Dynamics, place: &Place, contact: usize, held: f64) -> Option<Mode> {
    let Mode::Slip(side) = place.mode.get(contact) else {
        return None;
    };
    let other = Mode::Slip(side.opposite());
    let mode = place.mode.with(contact, other);
    let flow = system.flow_held(mode, &place.at, held);
    let guards = flow.guards().into_iter();
    let mut own = guards.filter(|guard| guard.contact == contact && !guard.continues_phase);
    let guard = own.next()?;
    let rate = Zero::of_guard(system, guard.number, mode, &place.at, held).rate;
    Some(if rate > 0.0 { other } else { Mode::Stick })
}

/// The other events that the motion leads to at the instant of a transition, which may be located
/// late by some time.
fn others(system: &dyn Dynamics, at: &Transition, place: &Place, late: f64) -> Vec<Meeting> {
    let flow = system.flow(place.mode, &place.at);
    let guards = flow.guards().into_iter();
    let event = |guard: Guard| {
        let zero = Zero::of_guard(system, guard.number, place.mode, &place.at, at.t);
        let (zero, goes) = (zero.later(late), zero.goes());
        if guard.contact == at.contact || guard.continues_phase || !zero.is_here() {
            return None;
        }
        if guard.is_of_jump {
            // An impact and the landing that ends a series of it are one event.
            if at.kind == TransitionKind::Jump
                && system.rest_after(guard.contact) == Some(at.contact)
            {
                return None;
            }
            let zero = Zero::of_jump(system, guard.contact, place.mode, &place.at, at.t);
            let reset = system.reset(guard.contact, &place.at);
            let happens = zero.goes() && !reset.lands && reset.after.iter().all(|x| x.is_finite());
            return happens.then_some(Meeting::Jump(guard.contact));
        }
        let to = beyond(system, place, guard.contact, at.t).filter(|_| goes)?;
        Some(Meeting::Contact {
            contact: guard.contact,
            guard: guard.number,
            to,
        })
    };
    guards.filter_map(event).collect()
}

/// Whether the order of two events at a place matters to vectors.
fn order(system: &dyn Dynamics, place: &Place, pair: [Meeting; 2], columns: &[Vector]) -> Order {
    let effect = |event: Meeting, place: &Place| event.effect(system, place, place.at.t);
    let [one, other] = pair.map(|event| effect(event, place));
    let is_apart = |y: &&Vector| !one.is_at(other.time.dot(y), y);
    let apart: Vec<&Vector> = columns.iter().filter(is_apart).collect();
    if apart.is_empty() {
        return Order::Alike;
    }
    let last = [effect(pair[1], &one.after), effect(pair[0], &other.after)];
    let ways = [
        &last[0].matrix * &one.matrix,
        &last[1].matrix * &other.matrix,
    ];
    let is_same = last[0].is_still(&other)
        && last[1].is_still(&one)
        && same_place([&last[0].after, &last[1].after])
        && apart
            .iter()
            .all(|y| same_vector(&ways.each_ref().map(|way| way * *y), y));
    let [matrix, _] = ways;
    match is_same {
        true => Order::Free(Joint {
            mode: last[0].after.mode,
            matrix,
        }),
        false => Order::Matters,
    }
}

/// Whether the order of an event and of kinks of inputs at a place matters to vectors.
fn kink_matters(
    system: &dyn Dynamics,
    place: &Place,
    event: Meeting,
    kinks: &[usize],
    columns: &[Vector],
) -> bool {
    let (t, near) = (place.at.t, instant(place.at.t));
    let [before, after] = [t - near, t + near];
    // A vector whose time the kinks have passed already comes back before them.
    let passed = shifts(system, place, [before, t]);
    let columns = columns.iter().map(|y| {
        let shifted = |y: Vector, shift: &KinkShift| {
            let part = shift.gradient.dot(&y) / shift.rate;
            y - &shift.kick * part
        };
        passed.iter().fold(y.clone(), shifted)
    });
    let [first, last] = [before, after].map(|held| event.effect(system, place, held));
    let is_apart = |y: &Vector| {
        let mut times = kinks
            .iter()
            .map(|input| kink_time(system, *input, place, y));
        times.any(|time| !first.is_at(time, y))
    };
    let apart: Vec<Vector> = columns.filter(is_apart).collect();
    if apart.is_empty() {
        return false;
    }
    let leads_on = |held: f64| match event {
        Meeting::Contact { contact, .. } => beyond(system, place, contact, held),
        Meeting::Jump(_) => None,
    };
    let [earlier, later] = [place, &first.after].map(|at| shifts(system, at, [before, after]));
    let shifted = |y: &Vector, shifts: &[KinkShift]| {
        let shift = |y: Vector, shift: &KinkShift| {
            let part = shift.gradient.dot(&y) / shift.rate;
            y + &shift.kick * part
        };
        shifts.iter().fold(y.clone(), shift)
    };
    let is_same = last.is_still(&first)
        && leads_on(before) == leads_on(after)
        && same_place([&first.after, &last.after])
        && apart.iter().all(|y| {
            let behind = shifted(y, &earlier);
            let ways = [
                shifted(&(&first.matrix * y), &later),
                &last.matrix * &behind,
            ];
            same_vector(&ways, y) && last.is_at(first.time.dot(y), &behind)
        });
    !is_same
}

/// The change of the time of an input's kink with a vector.
fn kink_time(system: &dyn Dynamics, input: usize, place: &Place, y: &Vector) -> f64 {
    let velocity = system.flow(place.mode, &place.at).velocity(&place.at);
    let (_, gradient, in_time) = system.clock(input, &place.at);
    -gradient.dot(y) / (in_time + gradient.dot(&velocity))
}

/// The effect of kinks between two times at a place.
fn shifts(system: &dyn Dynamics, place: &Place, [t_start, t_end]: [f64; 2]) -> Vec<KinkShift> {
    system.kink_shifts(&Step {
        mode: place.mode,
        t_start,
        t_end,
        x_start: place.at.x.clone(),
        x_end: place.at.x.clone(),
    })
}

fn same_place([one, other]: [&Place; 2]) -> bool {
    let (a, b) = (&one.at.x, &other.at.x);
    one.mode == other.mode && (a - b).amax() <= SAME * a.amax().max(b.amax())
}

/// Whether two images of a vector are equal to rounding.
fn same_vector([one, other]: &[Vector; 2], y: &Vector) -> bool {
    let size = one.amax().max(other.amax()).max(y.amax());
    (one - other).amax() <= SAME * size
}
