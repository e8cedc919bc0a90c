//! Where a run stands between two phases, and where it goes from there by the switching rules.

use num_dual::Dual;

use super::driver::Summary;
use super::flow::{CONTACT, MOST_GUARDS, Stick, project, sliding_field};
use super::march::{PhaseEnd, Run};
use super::observer::{Observer, Phase, Transition, TransitionKind};
use super::options::AtRepelling;
use super::rules::{Departure, Fate, Leading, LieDerivatives, departure};
use crate::error::Error;
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::system::{Filippov, Mode, Side, State};

/// Where the run goes from a point of Σ.
enum Course {
    On(Mode, [usize; MOST_GUARDS]),
    Repelled,
}

/// Runs `$body` with the flow of the journey's mode as `$flow`.
macro_rules! on_flow {
    ($journey:expr, $system:expr, |$flow:ident| $body:expr) => {{
        let (system, contact) = ($system, $journey.contact);
        use $crate::filippov::flow::{Slip, Stick};
        use $crate::system::{Mode, Side};
        match $journey.mode {
            Mode::Slip(Side::Below) => {
                let $flow = &Slip::<_, false> { system, contact };
                $body
            }
            Mode::Slip(Side::Above) => {
                let $flow = &Slip::<_, true> { system, contact };
                $body
            }
            Mode::Stick => {
                let $flow = &Stick { system, contact };
                $body
            }
        }
    }};
}
pub(super) use on_flow;

/// Where a run stands between two phases.
pub(super) struct Journey<const N: usize> {
    /// Where the next phase, or the rest of one, begins.
    pub at: Timed<f64, N>,
    pub mode: Mode,
    /// How many derivatives of each guard vanish there.
    pub orders: [usize; MOST_GUARDS],
    /// Sign of the contact function.
    pub contact: f64,
    /// Where the phase began.
    from: Timed<f64, N>,
}

impl<const N: usize> Journey<N> {
    /// The first phase from `start`, or the end where there is none.
    pub(super) fn begin<S: Filippov<N>, O>(
        run: &mut Run<'_, O>,
        system: &S,
        start: Timed<f64, N>,
    ) -> Result<Self, Summary<N>> {
        let Course::On(mode, orders) = run.first_course(system, &start) else {
            return Err(run.summary(Ending::Repelling, start));
        };
        let mut journey = Journey {
            at: start,
            mode,
            orders,
            contact: contact_sign(system, &start),
            from: start,
        };
        journey.land(system);
        Ok(journey)
    }

    /// A stick phase begins on Σ.
    fn land<S: Filippov<N>>(&mut self, system: &S) {
        if self.mode == Mode::Stick {
            self.at.x = project(system, self.at.t, self.at.x);
        }
    }

    /// Goes on from the end of a march: to the next phase, to the rest of this one, or to the end of the run.
    pub(super) fn turn<S: Filippov<N>, O: Observer<N>>(
        &mut self,
        run: &mut Run<'_, O>,
        system: &S,
        end: PhaseEnd<N>,
    ) -> Result<Option<Summary<N>>, Error> {
        let (at, exit) = match end {
            PhaseEnd::Time(at) => (at, Err(Ending::EndTime)),
            PhaseEnd::Stopped(at) => (at, Err(Ending::Stopped)),
            PhaseEnd::Exit {
                at,
                guard,
                residual,
                orders,
            } => (at, Ok((guard, residual, orders))),
        };
        self.at = at;
        let mode = self.mode;
        if let Ok((CONTACT, residual, departures)) = exit {
            run.note_event(&at, &velocity(system, mode, &at))?;
            let change = Transition {
                t: at.t,
                x: at.x,
                kind: if self.contact > 0.0 {
                    TransitionKind::ContactLoss
                } else {
                    TransitionKind::ContactGain
                },
                from: mode,
                to: mode,
                residual,
            };
            if run.observer.transition(&change).is_break() {
                return Ok(Some(run.summary(Ending::Stopped, at)));
            }
            self.contact = -self.contact;
            self.orders = departures;
            self.orders[CONTACT] = 1;
            self.land(system);
            return Ok(None);
        }
        let phase = Phase {
            mode,
            t_start: self.from.t,
            t_end: at.t,
            x_start: self.from.x,
            x_end: at.x,
        };
        let told = run.observer.phase(&phase);
        let (guard, residual) = match exit {
            Ok((guard, residual, _)) => (guard, residual),
            Err(ending) => return Ok(Some(run.summary(ending, at))),
        };
        let tangent = (mode == Mode::Stick).then(|| Stick::<S>::side_of_guard(guard));
        let departure = run.departure(system, &at, tangent);
        let (next, next_orders) = match run.course(departure) {
            Course::On(next, orders) => (next, orders),
            Course::Repelled => return Ok(Some(run.summary(Ending::Repelling, at))),
        };
        run.note_event(&at, &velocity(system, next, &at))?;
        let transition = Transition {
            t: at.t,
            x: at.x,
            kind: kind(mode, next),
            from: mode,
            to: next,
            residual,
        };
        if run.observer.transition(&transition).is_break() || told.is_break() {
            return Ok(Some(run.summary(Ending::Stopped, at)));
        }
        (self.mode, self.orders, self.from) = (next, next_orders, at);
        self.land(system);
        Ok(None)
    }
}

impl<O> Run<'_, O> {
    fn summary<const N: usize>(&self, ending: Ending, at: Timed<f64, N>) -> Summary<N> {
        Summary {
            ending,
            t: at.t,
            x: at.x,
            counters: self.counters,
        }
    }

    /// Off Σ the side decides; on it, to rounding, the rules.
    fn first_course<S: Filippov<N>, const N: usize>(
        &mut self,
        system: &S,
        at: &Timed<f64, N>,
    ) -> Course {
        let h = system.boundary(at.t, &at.x);
        let side = if h < 0.0 { Side::Below } else { Side::Above };
        if !LieDerivatives::new(system, side, at.t, &at.x, self.slack()).on_boundary() {
            return Course::On(Mode::Slip(side), [0; MOST_GUARDS]);
        }
        let departure = self.departure(system, at, None);
        self.course(departure)
    }

    /// A state this near to where it should be is there: a thousandth of what error control lets pass.
    fn slack(&self) -> f64 {
        1e-3 * self.options.atol
    }

    /// What a point of Σ leads to. `tangent` names the side whose normal component is known to vanish: a stick phase has
    /// just ended there.
    fn departure<S: Filippov<N>, const N: usize>(
        &mut self,
        system: &S,
        at: &Timed<f64, N>,
        tangent: Option<Side>,
    ) -> Departure {
        let slack = self.slack();
        let mut of = |side| {
            let tangent = tangent == Some(side);
            let leading = Leading::new(system, side, at.t, &at.x, slack, tangent);
            self.counters.field_calls += leading.calls;
            leading
        };
        departure(of(Side::Below), of(Side::Above))
    }

    fn course(&self, departure: Departure) -> Course {
        let orders = departure.orders;
        match (departure.fate, self.options.at_repelling) {
            (Fate::Slip(side), _) => Course::On(Mode::Slip(side), orders),
            (Fate::Stick, _) => Course::On(Mode::Stick, orders),
            (Fate::Repelling, AtRepelling::Stop) => Course::Repelled,
            (Fate::Repelling, AtRepelling::GoBelow) => {
                Course::On(Mode::Slip(Side::Below), [orders[0] + 1, 0, 0])
            }
            (Fate::Repelling, AtRepelling::GoAbove) => {
                Course::On(Mode::Slip(Side::Above), [orders[1] + 1, 0, 0])
            }
        }
    }
}

/// Sign of the contact function; where it is zero, of its rate along the mean of the two fields.
fn contact_sign<S: Filippov<N>, const N: usize>(system: &S, at: &Timed<f64, N>) -> f64 {
    let below = system.field(Side::Below, at.t, &at.x);
    let above = system.field(Side::Above, at.t, &at.x);
    let path =
        State::<Dual<f64>, N>::from_fn(|i, _| Dual::new(at.x[i], 0.5 * (below[i] + above[i])));
    match system.contact(Dual::new(at.t, 1.0), &path) {
        Some(contact) if contact.re < 0.0 || contact.re == 0.0 && contact.eps < 0.0 => -1.0,
        _ => 1.0,
    }
}

/// The vector that moves the state in a mode.
fn velocity<S: Filippov<N>, const N: usize>(
    system: &S,
    mode: Mode,
    at: &Timed<f64, N>,
) -> State<f64, N> {
    match mode {
        Mode::Slip(side) => system.field(side, at.t, &at.x),
        Mode::Stick => sliding_field(system, at.t, &at.x),
    }
}

fn kind(from: Mode, to: Mode) -> TransitionKind {
    match (from, to) {
        (Mode::Slip(before), Mode::Slip(after)) if before != after => TransitionKind::Crossing,
        (Mode::Slip(_), Mode::Stick) => TransitionKind::StickEntry,
        (Mode::Stick, Mode::Slip(_)) => TransitionKind::StickExit,
        _ => TransitionKind::Touch,
    }
}
