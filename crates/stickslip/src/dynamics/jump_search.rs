//! The search for jumps and kinks of inputs along an orbit.

use std::collections::VecDeque;

use numerics::bisect;

use super::OrbitProgress;
use super::jumps::{Jumps, allowed, kept, landed};
use super::section::TypedFunctions;
use super::view::View;
use crate::error::{Error, Point};
use crate::filippov::{
    Direction, EVENT_PRECISION, EventFunctions, EventRecord, EventSearch, Integration, Options,
    SearchMemory, Switched, TIME_ROUNDING, Transition, TransitionKind,
};
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::system::{State, components};

/// A pending jump.
#[derive(Clone, Copy)]
struct PendingJump {
    number: usize,
    /// Remainder of the zero of its function, at which location cut a step.
    left: f64,
    /// Whether its function came back before it had left its last zero.
    is_unresolved: bool,
}

impl PendingJump {
    /// A jump due by another one, a kink or a start.
    fn at_once(number: usize) -> Self {
        PendingJump {
            number,
            left: 0.0,
            is_unresolved: false,
        }
    }
}

/// The search for jumps along a run, and their execution.
pub(super) struct JumpSearch<'a, S: Switched<N, G>, V, J, const N: usize, const G: usize> {
    jumps: &'a J,
    search: EventSearch<'a, S, TypedFunctions<'a, S, V, J, N, G>, N, G>,
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
    due: VecDeque<PendingJump>,
    /// Whether no step has been taken since the last jump.
    has_jumped: bool,
    is_prescribed: bool,
}

/// The search for jumps and kinks between two steps.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct JumpMemory {
    search: SearchMemory,
    counts: Vec<u64>,
    last_kink: Option<f64>,
    kinks: u64,
    has_jumped: bool,
}

impl JumpMemory {
    /// Whether it is one of a system without jumps.
    pub(super) fn has_no_jumps(&self) -> bool {
        self.counts.is_empty()
    }
}

impl<'a, S, V, J, const N: usize, const G: usize> JumpSearch<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
    J: Jumps<N>,
{
    /// The search between two steps.
    pub(super) fn memory(&self) -> JumpMemory {
        JumpMemory {
            search: self.search.memory(),
            counts: self.counts.clone(),
            last_kink: Some(self.last_kink).filter(|t| t.is_finite()),
            kinks: self.kinks,
            has_jumped: self.has_jumped,
        }
    }

    /// Goes on as the search of a memory. Returns whether it is one of the same jumps.
    pub(super) fn restore(&mut self, memory: &JumpMemory) -> bool {
        self.due.clear();
        (self.kinks, self.has_jumped) = (memory.kinks, memory.has_jumped);
        self.last_kink = memory.last_kink.unwrap_or(f64::NEG_INFINITY);
        let is_same = memory.counts.len() == self.counts.len();
        if is_same {
            self.counts.clone_from(&memory.counts);
        }
        is_same && self.search.restore(&memory.search)
    }

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
        if !integration.is_prescribed()
            && let Some(value) = jumps.half_carried(x, options.atol.largest() + options.rtol)
        {
            return Err(Error::Parameter {
                name: "NAME.closed of a stop",
                value,
                bound: "0, or 1 where the stop carries",
            });
        }
        if jumps.count() == 0 && kink == f64::INFINITY {
            return Ok(None);
        }
        integration.end_at(t_end.min(kink));
        let rests = (0..jumps.count()).filter_map(|jump| {
            let next = jumps.rests(jump)?;
            Some((view.contacts + jump, view.contacts + next))
        });
        integration.number_jumps_from(view.contacts, rests.collect());
        let is_prescribed = integration.is_prescribed();
        let count = if is_prescribed { 0 } else { jumps.count() };
        let functions = view.functions_of_jumps(count);
        let mut jump_search = JumpSearch {
            jumps,
            search: EventSearch::new(view.system, functions, options).only_first(),
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
        jump_search.find_due_at_start(integration)?;
        Ok(Some(jump_search))
    }

    /// A jump whose function is zero at the start and goes in its direction there is due; otherwise
    /// the function stands at zero. A function just beyond zero that goes on is at zero: the state
    /// has been rounded. Of one that depends on time alone, the run that ended there has carried
    /// the jump out.
    ///
    /// # Errors
    /// [`Error::BehindStop`].
    fn find_due_at_start(&mut self, integration: &Integration<'a, S, N, G>) -> Result<(), Error> {
        if integration.has_ended() {
            return Ok(());
        }
        let at = Timed {
            t: integration.t(),
            x: *integration.x(),
        };
        let velocity = integration.velocity();
        for number in 0..self.counts.len() {
            let search = &mut self.search;
            if !search.depends_on_state(number, &at, |i| self.jumps.is_constant_between_jumps(i)) {
                continue;
            }
            let sign = search.sign_at(number, &at);
            if sign < 0.0 && self.jumps.is_reaction(number) {
                self.due.push_back(PendingJump::at_once(number));
                continue;
            }
            if sign < 0.0 && self.jumps.is_never_negative(number) {
                self.check_gap(number, integration)?;
            } else if sign != 0.0 && !self.is_passing(number, sign, integration) {
                self.search.set_side(number, sign);
                continue;
            }
            let search = &mut self.search;
            let rate = match search.sign_of_rate(number, &at, &velocity) {
                _ if self.jumps.is_never_negative(number) => {
                    search.sign_of_departure((number, integration.slack()), integration)
                }
                0.0 => search.sign_of_departure((number, 0.0), integration),
                rate => rate,
            };
            if goes(self.jumps, number, rate) {
                let due = self.closing(number, integration);
                self.due.push_back(PendingJump::at_once(due));
            } else {
                self.search.stand_at_zero(number, 0.0, rate);
            }
        }
        self.pass_idle(integration);
        // A phase of zero length lies before it.
        self.has_jumped = self.is_due();
        Ok(())
    }

    /// Whether a function is about to go on from a zero of which only rounding shows it beyond.
    fn is_passing(&self, number: usize, sign: f64, integration: &Integration<'a, S, N, G>) -> bool {
        let at = integration.at();
        let with = (integration.states(), integration.options());
        let rate = self
            .search
            .sign_of_rate(number, &at, &integration.velocity());
        let zero = EVENT_PRECISION * allowed(self.jumps, number, &at, with);
        let height = self.jumps.when(number, at.t, components(&at.x));
        rate == sign && goes(self.jumps, number, rate) && height.abs() <= zero
    }

    /// Whether a function that is never negative is zero within the tolerance of the state.
    ///
    /// # Errors
    /// [`Error::BehindStop`].
    fn check_gap(
        &self,
        number: usize,
        integration: &Integration<'a, S, N, G>,
    ) -> Result<(), Error> {
        let (t, x) = (integration.t(), *integration.x());
        let gap = self.jumps.when(number, t, components(&x));
        if gap >= 0.0 {
            return Ok(());
        }
        let least = -self
            .search
            .tolerated(number, &Timed { t, x }, integration.options());
        match gap < least {
            true => Err(Error::BehindStop {
                number: self.contacts + number,
                gap,
                t,
                x: Point::from(&x),
            }),
            false => Ok(()),
        }
    }

    /// Whether a gap is continuous over the last step, at whose end it is closed or negative.
    ///
    /// # Errors
    /// [`Error::GapJumps`].
    fn check_continuous(
        &self,
        number: usize,
        integration: &mut Integration<'a, S, N, G>,
    ) -> Result<(), Error> {
        let gap = |at: &Timed<N>| self.jumps.when(number, at.t, components(&at.x));
        let end = integration.at();
        if gap(&end).abs() <= self.search.tolerated(number, &end, integration.options()) {
            return Ok(());
        }
        let step = integration.last_step();
        let options = integration.options();
        let least = |at: &Timed<N>| self.search.tolerated(number, at, options);
        let at = |t: f64| Timed {
            t,
            x: step.dense.at_time(t),
        };
        // The event may lie to either side of the place.
        let rounding = |t: f64| f64::max(TIME_ROUNDING * t.abs(), f64::MIN_POSITIVE);
        let to = end.t + rounding(end.t);
        let behind = at(bisect(step.t_start, to, |t| gap(&at(t)) < 0.0));
        let before = at(behind.t - rounding(behind.t));
        // Rounding of time moves a continuous gap by rounding.
        let far = least(&before).max(least(&behind));
        match gap(&before) - gap(&behind) > far {
            true => Err(Error::GapJumps {
                number: self.contacts + number,
                gap: gap(&behind),
                t: behind.t,
                x: Point::from(&behind.x),
            }),
            false => Ok(()),
        }
    }

    /// The jump that is due where the function of this one goes on from zero. It is the one that
    /// follows its accumulation, if the rate is zero within the tolerance of the state.
    fn closing(&self, number: usize, integration: &Integration<'a, S, N, G>) -> usize {
        let Some(rest) = self.jumps.rests(number) else {
            return number;
        };
        let at = integration.at();
        let with = (integration.states(), integration.options());
        let rate = self.jumps.when(rest, at.t, components(&at.x));
        match rate.abs() <= allowed(self.jumps, rest, &at, with) {
            true => rest,
            false => number,
        }
    }

    /// The jumps that follow where others have accumulated.
    pub(super) fn follow(&mut self, numbers: &[usize]) {
        let due = numbers
            .iter()
            .map(|number| PendingJump::at_once(number - self.contacts));
        self.due = due.collect();
    }

    /// Takes every function as it is at the present state; one that is zero stands there.
    pub(super) fn begin_at(&mut self, integration: &Integration<'a, S, N, G>) {
        self.has_jumped = false;
        let at = Timed {
            t: integration.t(),
            x: *integration.x(),
        };
        for number in 0..self.counts.len() {
            match self.unless_behind(number, self.search.sign_at(number, &at)) {
                0.0 => self.search.stand_at_zero(number, 0.0, 0.0),
                sign => self.search.set_side(number, sign),
            }
        }
    }

    /// The sign of a function; 0 where a gap is negative, which is an error within the tolerance.
    fn unless_behind(&self, number: usize, sign: f64) -> f64 {
        match sign < 0.0 && self.jumps.is_never_negative(number) {
            true => 0.0,
            false => sign,
        }
    }

    /// Whether a jump's function goes in its direction with this sign.
    fn goes(&self, number: usize, sign: f64) -> bool {
        goes(self.jumps, number, sign)
    }

    /// Whether the functions of all jumps are defined, and no gap is negative.
    fn check(&self, integration: &Integration<'a, S, N, G>) -> Result<(), Error> {
        let (t, x) = (integration.t(), integration.x());
        for number in (0..self.counts.len()).filter(|&jump| self.jumps.is_never_negative(jump)) {
            self.check_gap(number, integration)?;
        }
        let is_none = |&number: &usize| self.jumps.when(number, t, components(x)).is_nan();
        match (0..self.counts.len()).find(is_none) {
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
        if self.counts.is_empty() {
            return Ok(());
        }
        let step = integration.last_step();
        self.search.in_step(&step);
        let (t, x) = (step.t_start, step.x_start);
        if let Some(number) = self.missed_return(&Timed { t, x }, integration) {
            integration.stop_at(Timed { t, x });
            self.search.cut(&x, &x);
            self.due.push_back(PendingJump {
                is_unresolved: true,
                ..PendingJump::at_once(number)
            });
            return Ok(());
        }
        let events = self.search.last_events();
        let Some(&EventRecord { t, x, .. }) = events.first() else {
            // Only a flight that rounding hides leaves a reaction that pulls.
            let pulls =
                |&number: &usize| self.jumps.is_reaction(number) && self.search.side(number) < 0.0;
            if let Some(number) = (0..self.counts.len()).find(pulls) {
                integration.stop_at(integration.at());
                self.due.push_back(PendingJump::at_once(number));
            }
            if let Err(error) = self.check(integration) {
                if let Error::BehindStop { number, .. } = error {
                    self.check_continuous(number - self.contacts, integration)?;
                }
                return Err(error);
            }
            self.stay_on_stops(integration);
            return Ok(());
        };
        let kinks = (self.next_kink - t).abs() <= TIME_ROUNDING * t.abs();
        let t = if kinks { self.next_kink } else { t };
        integration.stop_at(Timed { t, x });
        let is_due = |at: &&EventRecord<N, S::Mode>| at.t - t <= TIME_ROUNDING * t.abs();
        let mut due: Vec<usize> = events
            .iter()
            .take_while(is_due)
            .map(|at| at.number)
            .collect();
        due.sort_unstable();
        self.due.extend(due.iter().map(|&number| PendingJump {
            number,
            left: self.jumps.when(number, t, components(&x)).abs(),
            is_unresolved: self.search.stands_at_zero(number),
        }));
        self.search.cut(&step.x_start, &x);
        let distance = integration.distance_to_settle();
        for number in (0..self.counts.len()).filter(|number| !due.contains(number)) {
            // It may have passed in the other direction since the step began, or left its zero.
            let left = self.search.left_of_zero(number);
            let side = self
                .search
                .sign_beyond(number, (left, distance), &Timed { t, x });
            let side = self.unless_behind(number, side);
            if side != 0.0 {
                self.search.set_side(number, side);
            }
        }
        self.pass_idle(integration);
        match self.is_due() {
            true => Ok(()),
            false => integration.go_on_in_phase(),
        }
    }

    /// The impact that ends a flight of which the last step shows none. A gap that is zero at its
    /// start is negative at its end then, and the return lies below rounding.
    fn missed_return(
        &self,
        start: &Timed<N>,
        integration: &Integration<'a, S, N, G>,
    ) -> Option<usize> {
        let at = integration.at();
        let is_missed = |&number: &usize| {
            let mut events = self.search.last_events().iter();
            self.jumps.is_never_negative(number)
                && self.search.stood_at_zero(number)
                && !events.any(|event| event.number == number)
                && self.search.sign_at(number, &at) < 0.0
                && self.search.hardly_rises(number, start, integration)
        };
        (0..self.counts.len()).find(is_missed)
    }

    /// Removes the pending jumps that do not happen, up to the first that does. The others follow
    /// from the state after that one.
    fn pass_idle(&mut self, integration: &Integration<'a, S, N, G>) {
        while let Some(due) = self.due.front().copied() {
            let x = components(integration.x());
            let happens = match self.jumps.is_reaction(due.number) {
                true => self.brings_forward(integration),
                false => self.jumps.happens(due.number, integration.t(), x),
            };
            // A zero that comes back before it was left ends an accumulation.
            if due.is_unresolved || happens {
                return;
            }
            self.due.pop_front();
            self.leave_zero(due.number, due.left, integration);
        }
    }

    /// Moves the first pending reaction that lets go before all others. Returns whether there is
    /// one.
    fn brings_forward(&mut self, integration: &Integration<'a, S, N, G>) -> bool {
        let lets_go = |due: &PendingJump| self.lets_go(due, integration);
        let Some(place) = self.due.iter().position(lets_go) else {
            return false;
        };
        let first = self.due.remove(place);
        first.into_iter().for_each(|due| self.due.push_front(due));
        true
    }

    /// Whether a pending jump is that of a reaction that ends at the present state.
    fn lets_go(&self, due: &PendingJump, integration: &Integration<'a, S, N, G>) -> bool {
        let (Timed { t, x }, velocity) = (integration.at(), integration.velocity());
        let (at, velocity) = ((t, components(&x)), components(&velocity));
        let &PendingJump { number, left, .. } = due;
        self.jumps.is_reaction(number) && self.jumps.lets_go(number, at, velocity, left)
    }

    /// The next pending jump.
    pub(super) fn due(&self) -> Option<usize> {
        self.due.front().map(|due| due.number)
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
        integration.is_at_end() && self.has_reached_kink(integration)
    }

    /// Whether an input kinks at the present time or before.
    pub(super) fn has_reached_kink(&self, integration: &Integration<'a, S, N, G>) -> bool {
        integration.t() >= self.next_kink
    }

    /// Whether an input has kinked at this time.
    pub(super) fn has_kinked(&self, t: f64) -> bool {
        self.last_kink == t
    }

    /// Carries out the next pending jump.
    ///
    /// # Errors
    /// Those of [`Integration::new`] at the state after it, those of too many transitions and of a
    /// pile-up, and [`Error::Undefined`].
    pub(super) fn jump(
        &mut self,
        integration: &mut Integration<'a, S, N, G>,
    ) -> Result<Option<Transition<N, S::Mode>>, Error> {
        let Some(due) = self.due.pop_front() else {
            return Ok(None);
        };
        // A flight that rounding hides is none, unless it is one of a series.
        let is_hidden = due.is_unresolved && !integration.is_in_series(self.contacts + due.number);
        let hidden = self.jumps.rests(due.number).filter(|_| is_hidden);
        if due.is_unresolved && hidden.is_none() {
            integration.end_pile_up()?;
            return Ok(None);
        }
        let number = hidden.unwrap_or(due.number);
        if self.jumps.is_never_negative(number) {
            self.check_continuous(number, integration)?;
        }
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
            self.leave_zero(number, due.left, integration);
            // After its impact, a gap that stays closed without being kept rises.
            if self.jumps.is_never_negative(number) && self.search.stands_at_zero(number) {
                let left = self.search.left_of_zero(number);
                self.search.stand_at_zero(number, left, 1.0);
            }
            // A jump that moves its function by less than rounding, to where the function goes on
            // to the next jump, has no end but an accumulation.
            let value = |x: &State<N>| self.jumps.when(number, t, components(x));
            if self.search.stands_at_zero(number)
                && self.goes(number, self.search.side(number))
                && value(&before) != value(&after)
            {
                integration.end_accumulation_of(self.contacts + number)?;
            }
            self.detect_jumps(integration, [&before, &after], Some(number))?;
            if hidden.is_some() {
                self.hold_down(due.number, &Timed { t, x: after });
            }
            self.pass_idle(integration);
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

    /// Puts the state back on the stops that carry, once errors have moved it off by as much as
    /// those of a step may. The motion keeps what is off, and the rate of it.
    fn stay_on_stops(&self, integration: &mut Integration<'a, S, N, G>) {
        let (at, states) = (integration.at(), integration.states());
        let with = (states, integration.options());
        let is_off = kept(self.jumps, at)
            .any(|(number, off)| off.abs() > allowed(self.jumps, number, &at, with));
        if is_off {
            integration.move_to(landed(self.jumps, at));
        }
    }

    /// Holds the body on its stop where rounding hides the flight before an impact, even if the
    /// reaction pulls by as little. It lifts off once the reaction has pushed.
    fn hold_down(&mut self, impact: usize, at: &Timed<N>) {
        for number in 0..self.counts.len() {
            if self.jumps.leaves_at_zero(number, impact) && self.search.sign_at(number, at) <= 0.0 {
                self.search.set_side(number, -1.0);
                self.due.retain(|due| due.number != number);
            }
        }
    }

    /// Notes the sign of a jump's function just after the jump: zero, up to what was `left` of it
    /// before, or a side.
    fn leave_zero(&mut self, number: usize, left: f64, integration: &Integration<'a, S, N, G>) {
        let at = Timed {
            t: integration.t(),
            x: *integration.x(),
        };
        let distance = integration.distance_to_settle();
        let sign = self.search.sign_beyond(number, (left, distance), &at);
        let sign = self.unless_behind(number, sign);
        let search = &mut self.search;
        match sign {
            0.0 => {
                let rate = search.sign_of_rate(number, &at, &integration.velocity());
                search.stand_at_zero(number, left, rate);
            }
            sign => search.set_side(number, sign),
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
        self.detect_jumps(integration, [&before, &after], None)?;
        self.due.make_contiguous().sort_by_key(|due| due.number);
        self.pass_idle(integration);
        if changed.is_some() || self.is_due() || integration.phase().is_none() {
            let phase = phase.map(|phase| view.phase(&phase, self.due()));
            pending.extend(phase.map(OrbitProgress::PhaseEnd));
            integration.begin_phase();
        }
        pending.extend(changed.map(|at| OrbitProgress::Transition(view.transition(&at))));
        Ok(())
    }

    /// Detects the jumps whose functions have passed through zero between two states of one
    /// instant. One that stands at zero has not left it.
    ///
    /// # Errors
    /// [`Error::BehindStop`].
    fn detect_jumps(
        &mut self,
        integration: &Integration<'a, S, N, G>,
        [before, after]: [&State<N>; 2],
        but: Option<usize>,
    ) -> Result<(), Error> {
        let t = integration.t();
        let mut closings = Vec::new();
        for number in 0..self.counts.len() {
            if Some(number) == but || self.due.iter().any(|due| due.number == number) {
                continue;
            }
            if but.is_some_and(|jump| self.jumps.leaves_at_zero(jump, number)) {
                let left = self.jumps.when(number, t, components(after)).abs();
                self.search.stand_at_zero(number, left, 1.0);
                continue;
            }
            if self.jumps.is_never_negative(number) {
                self.check_gap(number, integration)?;
            }
            if self.search.stands_at_zero(number) {
                let (left, side) = (self.search.left_of_zero(number), self.search.side(number));
                self.leave_zero(number, left, integration);
                // As at a start, one that goes in its direction from now on is due.
                let now = self.search.side(number);
                let stands = self.search.stands_at_zero(number);
                let turns = stands && now != side;
                // A rate may be rounding.
                let departs = |slack| self.search.sign_of_departure((number, slack), integration);
                // Whatever has changed the motion, it must not lead behind a stop.
                let is_due = match self.jumps.is_never_negative(number) {
                    true => stands && departs(integration.slack()) < 0.0,
                    false => turns && self.goes(number, now) && departs(0.0) == now,
                };
                if is_due {
                    let due = self.closing(number, integration);
                    if !self.due.iter().any(|other| other.number == due) {
                        self.due.push_back(PendingJump::at_once(due));
                        closings.push(due);
                    }
                }
                continue;
            }
            let search = &mut self.search;
            let at = |x: &State<N>| search.sign_at(number, &Timed { t, x: *x });
            let (side, now) = (search.side(number), at(after));
            let side = if side == 0.0 { at(before) } else { side };
            if now == 0.0 {
                search.set_side(number, side);
                continue;
            }
            search.set_side(number, now);
            if side * now < 0.0 && self.goes(number, now) {
                self.due.push_back(PendingJump::at_once(number));
            }
        }
        // Whether a gap closes is asked again once all stops have let go.
        let mut due = self.due.iter();
        if !closings.is_empty() && due.any(|due| self.lets_go(due, integration)) {
            self.due.retain(|due| !closings.contains(&due.number));
        }
        Ok(())
    }
}

/// Whether the function of a jump goes in the jump's direction with this sign.
fn goes<J: Jumps<N>, const N: usize>(jumps: &J, number: usize, sign: f64) -> bool {
    let way = match sign > 0.0 {
        true => Direction::Rising,
        false => Direction::Falling,
    };
    sign != 0.0 && jumps.direction(number).includes(way)
}
