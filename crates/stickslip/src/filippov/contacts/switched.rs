//! A system of several contacts as a switched system.

use super::decision::Decision;
use super::joint::{ContactFlow, CornerFields, gradients, rates};
use super::{Contacts, Several};
use crate::dual::Dual;
use crate::dynamics::Modes;
use crate::error::{ContactFault, Error, Point};
use crate::filippov::check::check_run;
use crate::filippov::flow::Flow;
use crate::filippov::guard::Event;
use crate::filippov::observer::{Transition, TransitionKind};
use crate::filippov::options::{AtPileUp, Options};
use crate::filippov::run::StepState;
use crate::filippov::switched::{
    Next, PROJECTION_STEPS, StickingPoint, Switched, UseFlow, Vanishes,
};
use crate::filippov::two_fold::{two_fold_followed, two_fold_in_stick};
use crate::filippov::uncertainty::{STATE_ROUNDING, propagate, uncertainties};
use crate::ode::Timed;
use crate::scalar::Scalar;
use crate::system::{Mode, Side, State, components};

impl<S: Contacts<N, M>, const N: usize, const M: usize> Switched<N, M> for Several<S> {
    type Mode = [Mode; M];
    /// Whether holding contacts share their loads, since some do not affect their own rates.
    type Branch = bool;
    const UNDECIDED: [Mode; M] = [Mode::Stick; M];
    const INTERPRETED: bool = S::INTERPRETED;

    fn check(&self, start: &Timed<N>, t_end: f64, options: &Options) -> Result<(), Error> {
        options.check()?;
        self.0.check_parameters()?;
        let outside = |what| Error::StartOutsideDomain {
            t: start.t,
            x: Point::from(&start.x),
            what,
        };
        check_run(start, t_end)?;
        let x = components(&start.x);
        let h = self.0.boundaries(start.t, x);
        if h.iter().any(|h| !h.is_finite()) {
            return Err(outside("a boundary function is not finite there"));
        }
        let sides = h.map(side_of);
        if self
            .0
            .field(&sides, start.t, x)
            .iter()
            .any(|v| !v.is_finite())
        {
            return Err(outside("the field is not finite there"));
        }
        let at_rest = h.map(|h| h == 0.0);
        let holding = self.0.holding(&sides, &at_rest, start.t, x);
        if holding.iter().any(|v| !v.is_finite()) {
            return Err(outside("the field that holds is not finite there"));
        }
        Ok(())
    }

    fn branch(&self, mode: [Mode; M], at: &Timed<N>) -> bool {
        let joint = ContactFlow::new(&self.0, &mode);
        if joint.count < 2 {
            return false;
        }
        let CornerFields { rates, slopes, .. } = joint.affine(at.t, components(&at.x));
        // A contact that moves is not held, whatever its mode.
        let rounding = STATE_ROUNDING * at.x.amax().max(1.0);
        let is_moved_by_none = |&i: &usize| {
            slopes[i][..joint.count] == [0.0; M][..joint.count] && rates[i].abs() <= rounding
        };
        joint.held().iter().any(is_moved_by_none) || joint.hold_each_other(at)
    }

    fn restored_branch(shared: f64) -> bool {
        shared != 0.0
    }

    #[inline(always)]
    fn with_flow<U: UseFlow<N>>(&self, mode: [Mode; M], shared: bool, user: U) -> U::Output {
        user.use_flow(&ContactFlow::new(&self.0, &mode).with_shared_load(shared))
    }

    fn slip_field<T: Scalar>(&self, modes: [Mode; M], t: T, x: &[T; N]) -> Option<[T; N]> {
        let mut sides = [Side::Below; M];
        for (side, mode) in sides.iter_mut().zip(modes) {
            match mode {
                Mode::Slip(slips_on) => *side = slips_on,
                Mode::Stick => return None,
            }
        }
        Some(self.0.field(&sides, t, x))
    }

    /// Off its boundary a contact's side decides. Contacts on their boundaries, to rounding, are
    /// decided together. If that decides nothing, they may hold as where transitions accumulate.
    fn first_mode(&self, run: &mut StepState<N, M>) -> Result<Next<[Mode; M], M>, Error> {
        let Timed { t, x } = run.at;
        let modes = self
            .0
            .boundaries(t, components(&x))
            .map(|h| Mode::Slip(side_of(h)));
        let decision = Decision {
            system: &self.0,
            at: run.at,
            before: modes,
            modes,
            open: self.at_zero(run, &modes),
            released: None,
        };
        let undecided = match decision.mode(run) {
            Err(error) if run.options.at_pile_up == AtPileUp::Rest => error,
            decided => return decided,
        };
        let sticking = match &undecided {
            Error::Contacts {
                fault:
                    ContactFault::NoUniqueMode {
                        contacts,
                        candidates,
                    },
                ..
            } if candidates.is_empty() => {
                let at = run.at;
                self.stick_at_accumulation(run, modes, contacts, &at)
            }
            _ => None,
        };
        let is_here = |point: &StickingPoint<_, _, N, M>| (point.at.x - x).amax() <= run.slack();
        match sticking.filter(is_here) {
            Some(point) => Ok(Next::Mode(point.to, point.orders)),
            None => Err(undecided),
        }
    }

    fn event_within_mode(&self, _guard: usize, _branch: &mut bool) -> Option<TransitionKind> {
        None
    }

    fn switch(
        &self,
        run: &mut StepState<N, M>,
        from: [Mode; M],
        branch: &mut bool,
        event: &Event<N>,
    ) -> Result<Next<[Mode; M], M>, Error> {
        let contact = event.guard;
        let shared = std::mem::take(branch);
        match two_fold_followed(self, run, from, contact) {
            Some(Next::Mode(to, orders)) => {
                *branch = self.branch(to, &run.at);
                return Ok(Next::Mode(to, orders));
            }
            Some(ended) => return Ok(ended),
            None => {}
        }
        if shared && let Some((to, still_shared)) = self.with_shared_load_kept(run, from, contact) {
            *branch = still_shared;
            let mut orders = [0; M];
            orders[contact] = 1;
            return Ok(Next::Mode(to, orders));
        }
        let mut open = self.at_zero(run, &from);
        let mut modes = from;
        let mut released = None;
        if from[contact] == Mode::Stick
            && self.with_flow(from, shared, Vanishes(event, &run.options))
        {
            let Timed { t, x } = run.at;
            let joint = ContactFlow::new(&self.0, &from).with_shared_load(shared);
            modes[contact] = Mode::Slip(joint.nearest_side(contact, t, &x));
            released = Some(contact);
        }
        open[contact] = released.is_none();
        let decision = Decision {
            system: &self.0,
            at: run.at,
            before: from,
            modes,
            open,
            released,
        };
        let next = decision.mode(run)?;
        if released.is_some() {
            self.check_static_ties(run, from, (contact, &next))?;
        }
        if let Next::Mode(to, _) = &next {
            *branch = ContactFlow::new(&self.0, to).hold_each_other(&run.at);
        }
        Ok(next)
    }

    fn guard_at_collapse(&self, run: &StepState<N, M>, mode: [Mode; M]) -> Option<usize> {
        two_fold_in_stick(self, run, mode)
    }

    fn stick_at_accumulation(
        &self,
        run: &mut StepState<N, M>,
        mut modes: [Mode; M],
        contacts: &[usize],
        at: &Timed<N>,
    ) -> Option<StickingPoint<[Mode; M], bool, N, M>> {
        for &i in contacts {
            modes[i] = Mode::Stick;
        }
        let joint = ContactFlow::new(&self.0, &modes);
        let onto = |x: State<N>, _| joint.project(joint.held(), at.t, x);
        let at = Timed {
            t: at.t,
            x: (0..PROJECTION_STEPS).fold(at.x, onto),
        };
        let branch = self.branch(modes, &at);
        let joint = joint.with_shared_load(branch);
        run.counters.field_calls += joint.field_calls() * 6;
        if !joint.rests(&at, run.slack()) {
            return None;
        }
        Some(StickingPoint {
            at,
            to: modes,
            branch,
            orders: [0; M],
            contact: contacts[0],
        })
    }

    fn discontinuity_guard(&self, at: &Transition<N, [Mode; M]>) -> Option<usize> {
        let decision = Decision {
            system: &self.0,
            at: Timed { t: at.t, x: at.x },
            before: at.from,
            modes: at.to,
            open: [false; M],
            released: None,
        };
        let jumps = match at.kind {
            TransitionKind::Crossing | TransitionKind::StickEntry => true,
            // If the holding field ends as the slipping one begins, the fields agree.
            TransitionKind::StickExit | TransitionKind::Touch => {
                changed(at).any(|i| at.from[i] != Mode::Stick || decision.has_static_friction(i))
            }
            TransitionKind::ContactLoss | TransitionKind::ContactGain | TransitionKind::Jump => {
                false
            }
        };
        jumps.then_some(at.contact)
    }

    fn is_one_at_a_time(&self, at: &Transition<N, [Mode; M]>) -> bool {
        // A contact that is released by this one belongs to this event. Another contact at its own
        // zero is a second event at the same time.
        let joint = ContactFlow::new(&self.0, &at.from);
        let comes_of_this = |i: usize| {
            at.from[i] == Mode::Stick && joint.reserve(i, at.t, &at.x) > RESERVE_AT_LIMIT
        };
        changed(at).all(|i| i == at.contact || comes_of_this(i))
    }

    fn contact_of(guard: usize) -> usize {
        guard
    }

    fn mode_by_side(&self, t: f64, x: &State<N>) -> [Mode; M] {
        self.0.boundaries(t, components(x)).map(|h| {
            if h == 0.0 {
                Mode::Stick
            } else {
                Mode::Slip(side_of(h))
            }
        })
    }

    fn normals(&self, mode: [Mode; M], at: &Timed<N>, states: usize) -> Vec<(usize, State<N>)> {
        let gradients = gradients(&self.0, at, states);
        (0..M)
            .filter(|&i| mode[i] == Mode::Stick)
            .map(|i| (i, gradients[i]))
            .collect()
    }

    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn period(&self, x: &[Dual<f64>; N]) -> Option<Dual<f64>> {
        self.0.period(x)
    }

    const CONTACTS: usize = M;

    fn of_contacts(mode: &[Mode; M]) -> &[Mode] {
        mode
    }

    fn restored(modes: Modes) -> [Mode; M] {
        let beyond = Mode::Slip(Side::Above);
        std::array::from_fn(|i| {
            if i < modes.len() {
                modes.get(i)
            } else {
                beyond
            }
        })
    }
}

impl<S> Several<S> {
    /// The mode after an event of one contact while others share their loads, if these continue to
    /// hold in any case.
    fn with_shared_load_kept<const N: usize, const M: usize>(
        &self,
        run: &StepState<N, M>,
        from: [Mode; M],
        contact: usize,
    ) -> Option<([Mode; M], bool)>
    where
        S: Contacts<N, M>,
    {
        let Timed { t, x } = run.at;
        let candidates = match from[contact] {
            Mode::Slip(side) => [Mode::Slip(side.opposite()), Mode::Stick],
            Mode::Stick => {
                let joint = ContactFlow::new(&self.0, &from).with_shared_load(true);
                [Mode::Slip(joint.nearest_side(contact, t, &x)); 2]
            }
        };
        candidates.into_iter().find_map(|mode| {
            let mut to = from;
            to[contact] = mode;
            let shared = self.branch(to, &run.at);
            let joint = ContactFlow::new(&self.0, &to).with_shared_load(shared);
            let leads_there = match mode {
                Mode::Slip(side) => {
                    let field = joint.field(t, components(&x));
                    rates(&self.0, (t, 1.0), components(&x), &field)[contact] * side.sign() > 0.0
                }
                Mode::Stick => true,
            };
            (shared && leads_there && joint.rests(&run.at, run.slack())).then_some((to, shared))
        })
    }

    /// Checks that the release of a contact has the same mode after it as that of another one which
    /// has reached its static limit in the same instant.
    ///
    /// # Errors
    /// [`ContactFault::NoUniqueMode`] where it is not; those of [`Decision::mode`].
    fn check_static_ties<const N: usize, const M: usize>(
        &self,
        run: &mut StepState<N, M>,
        from: [Mode; M],
        (contact, next): (usize, &Next<[Mode; M], M>),
    ) -> Result<(), Error>
    where
        S: Contacts<N, M>,
    {
        let Next::Mode(to, _) = next else {
            return Ok(());
        };
        if !self.0.has_static_friction() {
            return Ok(());
        }
        let Timed { t, x } = run.at;
        let joint = ContactFlow::new(&self.0, &from);
        let guards: [f64; M] = joint.field_and_guards(t, components(&x)).1;
        let blurs: [_; M] = uncertainties(&joint, &run.at, &run.options.tolerance());
        for other in (0..M).filter(|&i| i != contact && from[i] == Mode::Stick) {
            // It slips beside the one that is released, or has not reached its limit.
            if to[other] != Mode::Stick || guards[other] > blurs[other].zero() {
                continue;
            }
            let mut open = self.at_zero(run, &from);
            open[other] = false;
            let mut modes = from;
            modes[other] = Mode::Slip(joint.nearest_side(other, t, &x));
            let decision = Decision {
                system: &self.0,
                at: run.at,
                before: from,
                modes,
                open,
                released: Some(other),
            };
            if !decision.has_static_friction(other) {
                continue;
            }
            if let Next::Mode(instead, _) = decision.mode(run)?
                && instead != *to
            {
                let contacts = vec![contact, other];
                let candidates = [to, &instead].map(|modes| {
                    let of = contacts.iter().map(|&i| modes[i]);
                    format!("{:?}", of.collect::<Vec<Mode>>())
                });
                let candidates = candidates.to_vec();
                let fault = ContactFault::NoUniqueMode {
                    contacts,
                    candidates,
                };
                return Err(Error::at_contacts(&run.at, fault));
            }
        }
        Ok(())
    }

    /// The contacts at zero: the holding ones, and those whose boundary function is rounding,
    /// though they may be just leaving.
    fn at_zero<const N: usize, const M: usize>(
        &self,
        run: &StepState<N, M>,
        modes: &[Mode; M],
    ) -> [bool; M]
    where
        S: Contacts<N, M>,
    {
        let joint = ContactFlow::new(&self.0, modes);
        let Timed { t, x } = run.at;
        let heights = self.0.boundaries(t, components(&x));
        let rates = rates(
            &self.0,
            (t, 1.0),
            components(&x),
            &joint.field(t, components(&x)),
        );
        let tolerance = run.options.tolerance();
        let of = (self.0.dimension(), &tolerance);
        let blurs: [_; M] = propagate(&run.at, of, |t, x| self.0.boundaries(t, x));
        std::array::from_fn(|i| match modes[i] {
            Mode::Stick => true,
            Mode::Slip(_) => {
                // The time is known to rounding, and the rate scales it.
                let drift = STATE_ROUNDING * rates[i].abs() * t.abs();
                heights[i].abs() <= blurs[i].zero() + drift
            }
        })
    }
}

/// A holding contact is at its limit if its reserve is below this; midway that is 1/4. Chosen far
/// above the error of a located event, and far below the reserve of a contact that holds.
const RESERVE_AT_LIMIT: f64 = 1e-6;

/// The contacts whose mode changes.
fn changed<const N: usize, const M: usize>(
    at: &Transition<N, [Mode; M]>,
) -> impl Iterator<Item = usize> {
    let (from, to) = (at.from, at.to);
    (0..M).filter(move |&i| from[i] != to[i])
}

fn side_of(h: f64) -> Side {
    if h < 0.0 { Side::Below } else { Side::Above }
}
