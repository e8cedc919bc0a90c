//! A typed system as the solver and the analyses see it.

use super::interrupt::Interrupt;
use super::jumps::{Jumps, Reset, allowed, kept, landed};
use super::{Kink, Matrix, Modes, Moment, Passage, Phase, Summary, Transition, Vector};
use crate::dual::Dual;
use crate::error::{Error, Point};
use crate::filippov::{
    EventOf, EventRecord, Integration, Options, PhaseOf, Switched, TOLERATED, TransitionKind,
    TransitionOf, gradient, seeded,
};
use crate::ode::Timed;
use crate::orbit::SummaryOf;
use crate::system::{State, components};

/// A typed system as seen from outside: conversions in both directions.
pub(super) struct View<'a, S, V, J, const N: usize, const G: usize> {
    pub(super) system: &'a S,
    pub(super) own: &'a V,
    pub(super) jumps: &'a J,
    pub(super) states: usize,
    pub(super) contacts: usize,
    pub(super) interrupt: Option<&'a Interrupt>,
    /// The time from which inputs hold their values, if it is not that of a moment.
    pub(super) held: Option<f64>,
}

impl<S, V, J, const N: usize, const G: usize> Clone for View<'_, S, V, J, N, G> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, V, J, const N: usize, const G: usize> Copy for View<'_, S, V, J, N, G> {}

impl<'a, S, V, J, const N: usize, const G: usize> View<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    J: Jumps<N>,
{
    /// The state; all NaN if the number of components is wrong, which every run rejects.
    pub(super) fn state(&self, x: &[f64]) -> State<N> {
        let is_right = x.len() == self.states;
        State::from_fn(|i, _| match x.get(i) {
            _ if i >= self.states => 0.0,
            Some(value) if is_right => *value,
            _ => f64::NAN,
        })
    }

    /// The moment with the held values of inputs.
    pub(super) fn timed(&self, at: &Moment) -> Timed<N> {
        let (t, x) = (at.t, self.with_inputs(at.t, self.state(at.x.as_slice())));
        Timed { t, x }
    }

    /// A state with the values that inputs hold from a time on.
    pub(super) fn with_inputs(&self, t: f64, mut x: State<N>) -> State<N> {
        let t = self.held.unwrap_or(t);
        (0..self.jumps.inputs()).for_each(|input| self.jumps.hold(input, t, x.as_mut_slice()));
        x
    }

    /// Whether all held values of inputs at a moment are defined.
    pub(super) fn check_inputs(&self, &Timed { t, x }: &Timed<N>) -> Result<(), Error> {
        let is_none = |&input: &usize| {
            let mut held = x.map(|_| 0.0);
            held.rows_mut(0, self.states)
                .copy_from(&x.rows(0, self.states));
            self.jumps.hold(input, t, held.as_mut_slice());
            held.iter().any(|held| held.is_nan())
        };
        match (0..self.jumps.inputs()).find(is_none) {
            Some(input) => Err(Error::Undefined {
                what: "the function of the switch",
                number: self.contacts + self.jumps.count() + input,
                t,
                x: Point::from(&x),
            }),
            None => Ok(()),
        }
    }

    /// The jumps whose functions the motion from a state keeps, with what is off.
    pub(super) fn kept(&self, at: Timed<N>) -> impl Iterator<Item = (usize, f64)> {
        kept(self.jumps, at)
    }

    /// The jumps that put a state on the stops that carry there.
    pub(super) fn landings(&self, at: Timed<N>) -> impl Iterator<Item = usize> {
        self.kept(at).filter_map(|(jump, _)| self.jumps.rests(jump))
    }

    /// A moment on the stops that carry there. What is off within the tolerance would grow: the
    /// motion keeps its rate.
    ///
    /// # Errors
    /// [`Error::OffStop`] where more is off than errors within the tolerance may move it.
    pub(super) fn settled(&self, at: Timed<N>, options: &Options) -> Result<Timed<N>, Error> {
        for (jump, off) in self.kept(at) {
            let allowed = allowed(self.jumps, jump, &at, (self.states, options));
            if off.abs() > TOLERATED * allowed {
                return Err(Error::OffStop {
                    number: self.contacts + jump,
                    off,
                    t: at.t,
                    x: Point::from(&at.x),
                });
            }
        }
        Ok(self.landed(at))
    }

    /// A moment on the stops that carry there, by their landings.
    pub(super) fn landed(&self, at: Timed<N>) -> Timed<N> {
        match self.kept(at).any(|(_, off)| off != 0.0) {
            true => Timed {
                x: landed(self.jumps, at),
                ..at
            },
            false => at,
        }
    }

    /// The effect of a jump at a moment, whether or not its condition holds there.
    pub(super) fn map(&self, number: usize, at: &Moment) -> Reset {
        let jump = number - self.contacts;
        let here = self.timed(at);
        let Timed { t, x } = here;
        let states = self.states;
        let along = |direction: usize| {
            let (t, x) = seeded(&here, direction);
            let change = self.jumps.set(jump, t, &x);
            Vector::from_fn(states, |i, _| change[i].eps)
        };
        let columns: Vec<Vector> = (0..states).map(along).collect();
        let (gradient, in_time) = self.gradient(|t, x| self.jumps.when(jump, t, x), &here);
        let x_there = components(&x);
        Reset {
            after: self.vector(&self.jumps.set(jump, t, x_there).into()),
            by_state: Matrix::from_fn(states, states, |i, j| columns[j][i]),
            by_time: along(N),
            value: self.jumps.when(jump, t, components(&x)),
            direction: self.jumps.direction(jump),
            gradient: self.vector(&gradient),
            in_time,
            is_tied: self.jumps.is_tied(jump, t, x_there),
            rests: self.jumps.rests(jump).is_some(),
            lands: (0..self.jumps.count()).any(|other| self.jumps.rests(other) == Some(jump)),
        }
    }

    /// The moment that stops admit next to one: on those that carry, and in front of the others, as
    /// after an impact.
    pub(super) fn admitted(&self, at: Timed<N>) -> Timed<N> {
        let Timed { t, x } = self.landed(at);
        let in_front = |x: State<N>, jump: usize| {
            let is_behind = self.jumps.is_never_negative(jump)
                && self.jumps.when(jump, t, components(&x)) < 0.0;
            match is_behind {
                true => self.jumps.set(jump, t, components(&x)).into(),
                false => x,
            }
        };
        let x = (0..self.jumps.count()).fold(x, in_front);
        Timed { t, x }
    }

    /// The inputs that kink at a time.
    pub(super) fn kinked(&self, &Timed { t, x }: &Timed<N>) -> Vec<usize> {
        let kinks = |&input: &usize| self.jumps.kinks(input, t, components(&x));
        (0..self.jumps.inputs()).filter(kinks).collect()
    }

    pub(super) fn kink(&self, input: usize, of: &Integration<'_, S, N, G>) -> Kink {
        Kink {
            t: of.t(),
            x: self.vector(of.x()),
            mode: self.modes(of.mode()),
            input,
        }
    }

    /// Gradient of a function in the states, and its time derivative.
    pub(super) fn gradient(
        &self,
        function: impl Fn(Dual<f64>, &[Dual<f64>; N]) -> Dual<f64>,
        at: &Timed<N>,
    ) -> (State<N>, f64) {
        gradient(function, at, self.states)
    }

    pub(super) fn vector(&self, x: &State<N>) -> Vector {
        Vector::from_column_slice(&x.as_slice()[..self.states])
    }

    pub(super) fn modes(&self, mode: S::Mode) -> Modes {
        let modes = S::of_contacts(&mode);
        Modes::new(&modes[..self.contacts.min(modes.len())])
    }

    /// A phase, and the jump that ends it.
    pub(super) fn phase(&self, phase: &PhaseOf<State<N>, S::Mode>, until: Option<usize>) -> Phase {
        Phase {
            mode: self.modes(phase.mode).until(until),
            t_start: phase.t_start,
            t_end: phase.t_end,
            x_start: self.vector(&phase.x_start),
            x_end: self.vector(&phase.x_end),
        }
    }

    pub(super) fn transition(&self, at: &TransitionOf<State<N>, S::Mode>) -> Transition {
        Transition {
            t: at.t,
            x: self.vector(&at.x),
            kind: at.kind,
            from: self.modes(at.from),
            to: self.modes(at.to),
            contact: match at.kind {
                TransitionKind::Jump => self.contacts + at.contact,
                _ => at.contact,
            },
            residual: at.residual,
        }
    }

    pub(super) fn typed_transition(&self, at: &Transition) -> TransitionOf<State<N>, S::Mode> {
        TransitionOf {
            t: at.t,
            x: self.timed(&at.moment()).x,
            kind: at.kind,
            from: S::restored(at.from),
            to: S::restored(at.to),
            contact: at.contact,
            residual: at.residual,
        }
    }

    pub(super) fn passage(&self, at: &EventRecord<N, S::Mode>) -> Passage {
        EventOf {
            number: at.number,
            t: at.t,
            x: self.vector(&at.x),
            mode: self.modes(at.mode),
            direction: at.direction,
            rate: at.rate,
        }
    }

    pub(super) fn summary(&self, summary: &SummaryOf<State<N>>) -> Summary {
        Summary {
            ending: summary.ending,
            t: summary.t,
            x: self.vector(&summary.x),
            counters: summary.counters,
        }
    }
}
