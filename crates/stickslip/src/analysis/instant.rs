//! Cause of an event's time: its own function, or the kink of an input.

use crate::dynamics::{Dynamics, Guard, Modes, Moment, Transition, Vector, instant};
use crate::filippov::{Direction, RELATIVE_ROUNDING, TransitionKind};

/// The last event of an orbit that is followed from event to event.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LastEvent {
    t: f64,
    kink: Option<usize>,
    jump: Option<usize>,
}

/// Function, or kink of an input, that decides the time of an event.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cause {
    /// The input whose kink decides it. Without one, it is the event's own function, or an event
    /// before it in the same instant.
    pub kink: Option<usize>,
    /// Whether no other event comes before it in the same instant.
    pub is_first: bool,
    /// The jump that is the last event before it, counted after the contacts.
    pub follows: Option<usize>,
}

impl LastEvent {
    /// No event so far.
    pub fn none() -> Self {
        LastEvent {
            t: f64::NEG_INFINITY,
            kink: None,
            jump: None,
        }
    }

    /// The cause of the next event.
    pub fn cause_of(&mut self, system: &dyn Dynamics, at: &Transition) -> Cause {
        let is_first = at.t - self.t > instant(at.t);
        let earlier = self.kink.filter(|_| !is_first);
        self.t = at.t;
        self.kink = deciding_kink(system, at, earlier);
        let jump = (at.kind == TransitionKind::Jump).then_some(at.contact);
        Cause {
            kink: self.kink,
            is_first,
            follows: std::mem::replace(&mut self.jump, jump),
        }
    }
}

/// The input whose kink decides the time of an event, where that of an event before it in the same
/// instant is known. A kink at which the event's own function passes through zero is a coincidence.
fn deciding_kink(system: &dyn Dynamics, at: &Transition, earlier: Option<usize>) -> Option<usize> {
    let here = at.moment();
    let input = system.kink(&here)?;
    let near = instant(at.t);
    let [before, after] = [at.t - near, at.t + near].map(|held| own_zero(system, at, held));
    // A jump that another one sets off is beyond its zero on both sides.
    let is_set_off = at.kind == TransitionKind::Jump
        && !before.is_here()
        && !after.is_here()
        && before.value * after.value > 0.0;
    match before.is_reached() {
        true => None,
        false if is_set_off => earlier,
        false => Some(input),
    }
}

/// The guard of a contact that is nearest to zero at a transition, among those that end a mode as
/// the transition does.
pub(super) fn guard_of(system: &dyn Dynamics, at: &Transition, held: f64) -> Option<Guard> {
    let here = at.moment();
    let flow = system.flow_held(at.from, &here, held);
    let goes_on = is_of_contact(at.kind);
    let own = flow
        .guards()
        .into_iter()
        .filter(|guard| guard.contact == at.contact && guard.continues_phase == goes_on);
    let value = |number: usize| flow.guard(number, &here).abs();
    own.min_by(|a, b| value(a.number).total_cmp(&value(b.number)))
}

/// Whether contact is lost or gained at a transition.
pub(super) fn is_of_contact(kind: TransitionKind) -> bool {
    use TransitionKind::{ContactGain, ContactLoss};
    matches!(kind, ContactLoss | ContactGain)
}

/// A function of an event at a moment, with its rate along the motion to it.
#[derive(Clone)]
pub(super) struct Zero {
    pub value: f64,
    pub rate: f64,
    /// Directions of the rate with which the function causes its event.
    direction: Direction,
    /// Values that are zero to rounding, and such rates.
    rounding: [f64; 2],
    t: f64,
}

impl Zero {
    /// The function of a jump, counted after the contacts.
    pub fn of_jump(
        system: &dyn Dynamics,
        jump: usize,
        from: Modes,
        at: &Moment,
        held: f64,
    ) -> Self {
        let reset = system.reset_held(jump, at, held);
        let slopes = (reset.gradient, reset.in_time);
        let flow = system.flow_held(from, at, held);
        Zero::of(reset.value, slopes, reset.direction, &flow.velocity(at), at)
    }

    /// A guard, which is positive before its zero.
    pub fn of_guard(
        system: &dyn Dynamics,
        guard: usize,
        from: Modes,
        at: &Moment,
        held: f64,
    ) -> Self {
        let flow = system.flow_held(from, at, held);
        let (value, slopes) = (flow.guard(guard, at), flow.guard_gradient(guard, at));
        Zero::of(value, slopes, Direction::Falling, &flow.velocity(at), at)
    }

    fn of(
        value: f64,
        (gradient, in_time): (Vector, f64),
        direction: Direction,
        velocity: &Vector,
        at: &Moment,
    ) -> Self {
        let size = gradient.abs();
        let of_value = size.dot(&at.x.abs()) + (in_time * at.t).abs();
        let of_rate = size.dot(&velocity.abs()) + in_time.abs();
        Zero {
            value,
            rate: in_time + gradient.dot(velocity),
            direction,
            rounding: [of_value, of_rate].map(|size| RELATIVE_ROUNDING * size),
            t: at.t,
        }
    }

    /// The function, of which the time of its zero is known up to `late`.
    pub fn later(&self, late: f64) -> Self {
        let mut later = self.clone();
        later.rounding[0] += self.rate.abs() * late;
        later
    }

    /// Whether the function vanishes at the instant, to rounding.
    pub fn is_here(&self) -> bool {
        self.value.abs() <= self.rounding[0] + self.rate.abs() * 2.0 * instant(self.t)
    }

    /// Whether the function goes through zero in its direction, by more than rounding.
    pub fn goes(&self) -> bool {
        let way = match self.rate > 0.0 {
            true => Direction::Rising,
            false => Direction::Falling,
        };
        self.rate.abs() > self.rounding[1] && self.direction.includes(way)
    }

    /// Whether the motion leads to the zero.
    pub fn is_reached(&self) -> bool {
        self.is_here() && self.goes()
    }
}

/// The function of a transition, where inputs hold their values from a time on.
fn own_zero(system: &dyn Dynamics, at: &Transition, held: f64) -> Zero {
    let here = at.moment();
    if at.kind == TransitionKind::Jump {
        return Zero::of_jump(system, at.contact, at.from, &here, held);
    }
    let guard = guard_of(system, at, held).map_or(at.contact, |guard| guard.number);
    let mut zero = Zero::of_guard(system, guard, at.from, &here, held);
    // What location leaves of a guard.
    zero.rounding[0] += at.residual;
    zero
}
