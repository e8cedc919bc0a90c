//! Jumps: maps of the state at zeros of functions of the state.

use std::collections::VecDeque;

use super::section::TypedSection;
use super::typed::View;
use super::{OrbitProgress, Vector};
use crate::error::{Error, Point};
use crate::filippov::{
    Direction, EventFunctions, EventSearch, Integration, Options, Switched, TIME_ROUNDING,
    Transition, TransitionKind,
};
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::scalar::Scalar;
use crate::system::{State, components};

/// The jumps of a system of `N` states, and its inputs that kink at known times.
///
/// A jump occurs where its function passes through zero in the required direction, by the motion,
/// by another jump or by a kink. A function that the jump itself leaves at zero triggers no other
/// jump before it has left zero. Simultaneous jumps are carried out in their order.
///
/// ```
/// use stickslip::dynamics::{AsDynamics, OrbitProgress, Jumps, Moment, Section, WithJumps};
/// use stickslip::{Direction, Filippov, Options, Scalar, Side, TransitionKind};
///
/// /// A ball that falls, far from a boundary that does nothing.
/// struct Fall;
/// impl Filippov<2> for Fall {
///     fn field<T: Scalar>(&self, _: Side, _t: T, x: &[T; 2]) -> [T; 2] {
///         [x[1], T::constant(-9.81)]
///     }
///     fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 2]) -> T {
///         T::one()
///     }
/// }
/// /// It comes back from the ground with half its speed.
/// struct Bounce;
/// impl Jumps<2> for Bounce {
///     fn count(&self) -> usize {
///         1
///     }
///     fn direction(&self, _: usize) -> Direction {
///         Direction::Falling
///     }
///     fn when<T: Scalar>(&self, _: usize, _t: T, x: &[T; 2]) -> T {
///         x[0]
///     }
///     fn set<T: Scalar>(&self, _: usize, _t: T, x: &[T; 2]) -> [T; 2] {
///         [T::zero(), x[1] * -0.5]
///     }
/// }
/// let ball = WithJumps { system: Fall, jumps: Bounce };
/// let dynamics = ball.dynamics();
/// let start = Moment { t: 0.0, x: vec![1.0, 0.0].into() };
/// let mut orbit = dynamics.begin(&start, 1.0, &Options::default(), &Section::None)?;
/// let first = loop {
///     if let OrbitProgress::Transition(at) = orbit.step()? {
///         break at;
///     }
/// };
/// assert_eq!(first.kind, TransitionKind::Jump);
/// assert!((first.t - (2.0_f64 / 9.81).sqrt()).abs() < 1e-12);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub trait Jumps<const N: usize> {
    /// Number of jumps.
    fn count(&self) -> usize;

    /// The direction in which the function passes through zero at a jump.
    fn direction(&self, _jump: usize) -> Direction {
        Direction::Both
    }

    /// The function at whose zero the jump occurs.
    fn when<T: Scalar>(&self, jump: usize, t: T, x: &[T; N]) -> T;

    /// The state after a jump, from that before it.
    fn set<T: Scalar>(&self, jump: usize, t: T, x: &[T; N]) -> [T; N];

    /// Number of occurrences of a jump that ends the run; `None` by default.
    fn most(&self, _jump: usize) -> Option<u64> {
        None
    }

    /// Whether a component of the state takes discrete values, which jumps set. Tangent vectors
    /// have no component along it.
    fn is_discrete(&self, _state: usize) -> bool {
        false
    }

    /// Whether jumps alone change a component of the state. An equilibrium is sought at its present
    /// value.
    fn is_constant_between_jumps(&self, state: usize) -> bool {
        self.is_discrete(state)
    }

    /// The next time after `t` at which an input may kink; infinite, or after `t_end`, if none does
    /// before that.
    fn next_kink(&self, _t: f64, _x: &[f64], _t_end: f64) -> f64 {
        f64::INFINITY
    }

    /// Number of inputs.
    fn inputs(&self) -> usize {
        0
    }

    /// Whether an input kinks at a time.
    fn kinks(&self, _input: usize, _t: f64, _x: &[f64]) -> bool {
        false
    }

    /// The function of time that decides when an input kinks.
    fn clock<T: Scalar>(&self, _input: usize, t: T, _x: &[T; N]) -> T {
        t
    }

    /// Sets the components of the state that an input holds from `t` to its next kink; to NaN where
    /// its clock is undefined.
    fn hold(&self, _input: usize, _t: f64, _x: &mut [f64]) {}
}

/// No jumps.
#[derive(Clone, Copy, Debug)]
pub struct NoJumps;

impl<const N: usize> Jumps<N> for NoJumps {
    fn count(&self) -> usize {
        0
    }

    fn when<T: Scalar>(&self, _jump: usize, _t: T, _x: &[T; N]) -> T {
        T::one()
    }

    fn set<T: Scalar>(&self, _jump: usize, _t: T, x: &[T; N]) -> [T; N] {
        *x
    }
}

impl<J: Jumps<N>, const N: usize> Jumps<N> for &J {
    fn count(&self) -> usize {
        (**self).count()
    }
    fn direction(&self, jump: usize) -> Direction {
        (**self).direction(jump)
    }
    fn when<T: Scalar>(&self, jump: usize, t: T, x: &[T; N]) -> T {
        (**self).when(jump, t, x)
    }
    fn set<T: Scalar>(&self, jump: usize, t: T, x: &[T; N]) -> [T; N] {
        (**self).set(jump, t, x)
    }
    fn most(&self, jump: usize) -> Option<u64> {
        (**self).most(jump)
    }
    fn is_discrete(&self, state: usize) -> bool {
        (**self).is_discrete(state)
    }
    fn is_constant_between_jumps(&self, state: usize) -> bool {
        (**self).is_constant_between_jumps(state)
    }
    fn next_kink(&self, t: f64, x: &[f64], t_end: f64) -> f64 {
        (**self).next_kink(t, x, t_end)
    }
    fn inputs(&self) -> usize {
        (**self).inputs()
    }
    fn kinks(&self, input: usize, t: f64, x: &[f64]) -> bool {
        (**self).kinks(input, t, x)
    }
    fn clock<T: Scalar>(&self, input: usize, t: T, x: &[T; N]) -> T {
        (**self).clock(input, t, x)
    }
    fn hold(&self, input: usize, t: f64, x: &mut [f64]) {
        (**self).hold(input, t, x)
    }
}

/// A system with jumps. Every analysis accepts it like the system alone.
#[derive(Clone, Copy, Debug)]
pub struct WithJumps<S, J> {
    /// The system between jumps.
    pub system: S,
    /// The jumps.
    pub jumps: J,
}

/// The effect of a jump at a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Reset {
    /// The state after it.
    pub after: Vector,
    /// The derivative of that state by the state before, square in the states.
    pub by_state: super::Matrix,
    /// The derivative of that state by time.
    pub by_time: Vector,
    /// The function that vanishes at it.
    pub value: f64,
    /// The gradient of that function in the state; at the kink of an input, the gradient of the
    /// clock that decides its time.
    pub gradient: Vector,
    /// The time derivative of that function or clock.
    pub in_time: f64,
}

/// The effect on tangent vectors of an input's kink at the end of a step. The time of the kink
/// depends on the state if its clock does.
#[derive(Clone, Debug, PartialEq)]
pub struct KinkShift {
    /// Field after the kink minus field before it.
    pub kick: Vector,
    /// Gradient of the clock in the state.
    pub gradient: Vector,
    /// Rate of the clock along the motion before the kink.
    pub rate: f64,
}

/// The search for jumps along a run, and their execution.
pub(super) struct JumpSearch<'a, S: Switched<N, G>, V, J, const N: usize, const G: usize> {
    jumps: &'a J,
    /// One for each jump.
    searches: Vec<EventSearch<'a, S, TypedSection<'a, S, V, J, N, G>, N, 1, G>>,
    counts: Vec<u64>,
    /// Number of contacts; jumps are numbered after them.
    contacts: usize,
    /// End of the run.
    t_end: f64,
    /// The times of the next and of the last kink of an input.
    next_kink: f64,
    last_kink: f64,
    /// Number of kinks so far, and the largest number allowed.
    kinks: u64,
    most_kinks: u64,
    /// The pending jumps, in order.
    due: VecDeque<usize>,
    /// Whether no step has been taken since the last jump.
    has_jumped: bool,
    is_prescribed: bool,
}

impl<'a, S, V, J, const N: usize, const G: usize> JumpSearch<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
    J: Jumps<N>,
{
    /// The jumps of a run that has not begun; `None` if the system has none.
    ///
    /// # Errors
    /// [`Error::Undefined`].
    pub(super) fn of(
        view: &View<'a, S, V, J, N, G>,
        integration: &mut Integration<'a, S, N, G>,
        options: &Options,
        t_end: f64,
    ) -> Result<Option<Self>, Error> {
        let jumps = view.jumps;
        let (t, x) = (integration.t(), components(integration.x()));
        let kink = jumps.next_kink(t, x, t_end);
        if jumps.count() == 0 && kink == f64::INFINITY {
            return Ok(None);
        }
        integration.end_at(t_end.min(kink));
        let is_prescribed = integration.is_prescribed();
        let count = if is_prescribed { 0 } else { jumps.count() };
        let search =
            |number| EventSearch::new(view.system, view.when(number), options).only_first();
        let jump_search = JumpSearch {
            jumps,
            searches: (0..count).map(search).collect(),
            counts: vec![0; count],
            contacts: view.contacts,
            t_end,
            next_kink: kink,
            last_kink: f64::NEG_INFINITY,
            kinks: 0,
            most_kinks: options.most_events,
            due: VecDeque::new(),
            has_jumped: false,
            is_prescribed,
        };
        jump_search.check(integration)?;
        Ok(Some(jump_search))
    }

    /// Whether the functions of all jumps are defined.
    fn check(&self, integration: &Integration<'a, S, N, G>) -> Result<(), Error> {
        let (t, x) = (integration.t(), integration.x());
        let is_none = |&number: &usize| self.jumps.when(number, t, components(x)).is_nan();
        match (0..self.searches.len()).find(is_none) {
            Some(number) => Err(self.undefined("the function of the jump", number, (t, x))),
            None => Ok(()),
        }
    }

    fn undefined(&self, what: &'static str, jump: usize, (t, x): (f64, &State<N>)) -> Error {
        let (number, x) = (self.contacts + jump, Point::from(x));
        Error::Undefined { what, number, t, x }
    }

    /// Shortens the last step to the first jump in it.
    ///
    /// # Errors
    /// [`Error::Undefined`].
    pub(super) fn shorten_step(
        &mut self,
        integration: &mut Integration<'a, S, N, G>,
    ) -> Result<(), Error> {
        self.has_jumped = false;
        if self.searches.is_empty() {
            return Ok(());
        }
        let step = integration.last_step();
        let states: Vec<_> = self.searches.iter().map(EventSearch::state).collect();
        for search in &mut self.searches {
            search.in_step(&step);
        }
        let firsts = self
            .searches
            .iter()
            .map(|search| search.last_events().first());
        let earliest = firsts.flatten().min_by(|a, b| a.t.total_cmp(&b.t));
        let Some(Timed { t, x }) = earliest.map(|at| Timed { t: at.t, x: at.x }) else {
            return self.check(integration);
        };
        integration.stop_at(Timed { t, x });
        for (number, (search, state)) in self.searches.iter_mut().zip(states).enumerate() {
            let event = search.last_events().first();
            let is_due = event.is_some_and(|at| at.t - t <= TIME_ROUNDING * t.abs());
            search.cut(state, &step.x_start, &x);
            if is_due {
                self.due.push_back(number);
                continue;
            }
            // It may have passed in the other direction since the step began.
            let side = search.sign_at(&Timed { t, x });
            if side != 0.0 {
                search.set_side(side);
            }
        }
        Ok(())
    }

    /// The next pending jump.
    pub(super) fn due(&self) -> Option<usize> {
        self.due.front().copied()
    }

    /// Whether a jump is pending.
    pub(super) fn is_due(&self) -> bool {
        !self.due.is_empty()
    }

    /// Whether the next jump follows another one in the same instant. A phase of zero length then
    /// lies between them; the answer is yes only once.
    pub(super) fn takes_empty_phase(&mut self) -> bool {
        std::mem::take(&mut self.has_jumped) && self.is_due()
    }

    /// Whether a run has reached a kink. A kink at the end of the run is passed, too: a run from
    /// there continues after it.
    pub(super) fn is_at_kink(&self, integration: &Integration<'a, S, N, G>) -> bool {
        integration.is_at_end() && integration.t() >= self.next_kink
    }

    /// Whether an input has kinked at this time.
    pub(super) fn has_kinked(&self, t: f64) -> bool {
        self.last_kink == t
    }

    /// Carries out the next pending jump.
    ///
    /// # Errors
    /// Those of [`Integration::new`] at the state after it, those of too many transitions, and
    /// [`Error::Undefined`].
    pub(super) fn jump(
        &mut self,
        integration: &mut Integration<'a, S, N, G>,
    ) -> Result<Option<Transition<N, S::Mode>>, Error> {
        let Some(number) = self.due.pop_front() else {
            return Ok(None);
        };
        let (t, before, from) = (integration.t(), *integration.x(), integration.mode());
        let residual = self.jumps.when(number, t, components(&before)).abs();
        let after: State<N> = self.jumps.set(number, t, components(&before)).into();
        if after.iter().any(|v| !v.is_finite()) {
            return Err(self.undefined("the state that is set by the jump", number, (t, &before)));
        }
        self.has_jumped = true;
        self.counts[number] += 1;
        let most = self.jumps.most(number);
        if most.is_some_and(|most| self.counts[number] >= most) {
            self.due.clear();
            integration.restart_at(self.contacts + number, after, Some(Ending::Stopped))?;
        } else {
            integration.restart_at(self.contacts + number, after, None)?;
            let side = self.side_after(number, integration);
            self.searches[number].set_side(side);
            self.detect_jumps(t, [&before, &after], Some(number));
        }
        Ok(Some(Transition {
            t,
            x: before,
            kind: TransitionKind::Jump,
            from,
            to: integration.mode(),
            contact: number,
            residual,
        }))
    }

    /// The sign of a jump's function just after it; 0 where its rate does not decide.
    fn side_after(&self, number: usize, integration: &Integration<'a, S, N, G>) -> f64 {
        let (t, x) = (integration.t(), *integration.x());
        let search = &self.searches[number];
        match search.sign_at(&Timed { t, x }) {
            0.0 => search.sign_of_rate(&Timed { t, x }, &integration.velocity()),
            sign => sign,
        }
    }

    /// Continues after the kink of an input. Reports the phase that ends with it: a contact may no
    /// longer stick.
    ///
    /// # Errors
    /// Those of [`Integration::new`], and [`Error::TooMany`].
    pub(super) fn pass_kink(
        &mut self,
        integration: &mut Integration<'a, S, N, G>,
        view: &View<'a, S, V, J, N, G>,
        pending: &mut VecDeque<OrbitProgress>,
    ) -> Result<(), Error> {
        let (t, before) = (integration.t(), *integration.x());
        let after = view.with_inputs(t, before);
        if after.iter().any(|held| held.is_nan()) {
            view.check_inputs(&Timed { t, x: before })?;
        }
        self.last_kink = t;
        self.kinks += 1;
        if self.kinks > self.most_kinks {
            let (name, most, x) = ("most_events", self.most_kinks, Point::from(&before));
            return Err(Error::TooMany { name, most, t, x });
        }
        self.next_kink = self.jumps.next_kink(t, components(&after), self.t_end);
        integration.end_at(self.t_end.min(self.next_kink));
        if !self.is_prescribed {
            let kinks = |&input: &usize| self.jumps.kinks(input, t, components(&after));
            let inputs = (0..self.jumps.inputs()).filter(kinks);
            pending.extend(inputs.map(|input| OrbitProgress::Kink(view.kink(input, integration))));
        }
        let phase = integration.phase();
        let changed = integration.restart_at_kink(after)?;
        self.detect_jumps(t, [&before, &after], None);
        if changed.is_some() || self.is_due() || integration.phase().is_none() {
            let phase = phase.map(|phase| view.phase(&phase, self.due()));
            pending.extend(phase.map(OrbitProgress::PhaseEnd));
            integration.begin_phase();
        }
        pending.extend(changed.map(|at| OrbitProgress::Transition(view.transition(&at))));
        Ok(())
    }

    /// Detects the jumps whose functions have passed through zero between two states of one
    /// instant.
    fn detect_jumps(&mut self, t: f64, [before, after]: [&State<N>; 2], but: Option<usize>) {
        if self.is_prescribed {
            return;
        }
        for (number, search) in self.searches.iter_mut().enumerate() {
            if Some(number) == but || self.due.contains(&number) {
                continue;
            }
            let at = |x: &State<N>| search.sign_at(&Timed { t, x: *x });
            let (side, now) = (search.side(), at(after));
            let side = if side == 0.0 { at(before) } else { side };
            if now == 0.0 {
                search.set_side(side);
                continue;
            }
            search.set_side(now);
            let way = if now > 0.0 {
                Direction::Rising
            } else {
                Direction::Falling
            };
            if side * now < 0.0 && self.jumps.direction(number).includes(way) {
                self.due.push_back(number);
            }
        }
    }
}
