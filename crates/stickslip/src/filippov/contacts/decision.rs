//! Decides the mode that follows a point where contacts are at zero.

use std::cell::OnceCell;

use super::Contacts;
use super::complementarity::{combinations, solutions};
use super::equations::principal_minor;
use super::joint::{ContactFlow, NEGLIGIBLE_FRICTION, gradients, rates};
use crate::error::{ContactFault, Error};
use crate::filippov::flow::{Flow, flow_path, is_positive};
use crate::filippov::rules::LieDerivatives;
use crate::filippov::run::StepState;
use crate::filippov::switched::Next;
use crate::filippov::uncertainty::{
    EVENT_PRECISION, RELATIVE_ROUNDING, STATE_ROUNDING, Uncertainty, uncertainties,
};
use crate::interval::Interval;
use crate::ode::Timed;
use crate::system::{Mode, Side, components};

/// A point at which a mode is decided.
pub(super) struct Decision<'a, S, const N: usize, const M: usize> {
    pub(super) system: &'a S,
    pub(super) at: Timed<N>,
    /// The mode before, and the modes of the contacts that are decided already.
    pub(super) before: [Mode; M],
    pub(super) modes: [Mode; M],
    /// The contacts at zero that are to be decided.
    pub(super) open: [bool; M],
    /// A contact that has just reached the limit of what can hold it.
    pub(super) released: Option<usize>,
}

/// First motion of a contact from zero.
enum FirstMotion {
    /// Number of derivatives of its guard that vanish.
    Order(usize),
    /// Does not move by the mode; the contact has this outcome instead.
    Instead(Mode),
}

/// Derivatives of a motion at its beginning, for each contact.
struct InitialDerivatives<const M: usize> {
    /// Lie derivatives of the guards along the motion.
    derivatives: [LieDerivatives; M],
    blurs: [Uncertainty; M],
}

/// Modes with another one of a contact.
fn with<const M: usize>(modes: &[Mode; M], contact: usize, mode: Mode) -> [Mode; M] {
    let mut modes = *modes;
    modes[contact] = mode;
    modes
}

/// Sign of the numbers in a range; 0 if zero is among them, or within rounding of the bounds.
fn sign_of_range(range: Interval) -> f64 {
    if is_positive(range) {
        1.0
    } else if is_positive(-range) {
        -1.0
    } else {
        0.0
    }
}

impl<S: Contacts<N, M>, const N: usize, const M: usize> Decision<'_, S, N, M> {
    /// The mode that follows, and how many derivatives of each guard vanish. Contacts that are not
    /// to be decided are away from zero: none of theirs vanish.
    pub(super) fn mode(mut self, run: &mut StepState<N, M>) -> Result<Next<[Mode; M], M>, Error> {
        let decided: Vec<usize> = (0..self.system.contacts())
            .filter(|&i| self.open[i] || self.released == Some(i))
            .collect();
        self.check(&decided)?;
        let moves_by_state = |&i: &usize| !self.can_hold(i) && !self.is_led(i);
        let closed: Vec<usize> = decided.iter().copied().filter(moves_by_state).collect();
        self.close(&closed);
        self.complement(run)?;
        // A contact whose weight or rate vanishes to rounding is decided by the next derivative.
        // Each may change the others once.
        for _ in 0..=2 * M {
            let mut orders = [0; M];
            let mut change = None;
            let joint = ContactFlow::new(self.system, &self.modes);
            let shared = joint.hold_each_other(&self.at);
            let joint = joint.with_shared_load(shared);
            let ranges = self.ranges(run, &joint);
            let initial = OnceCell::new();
            let mut initial = || initial.get_or_init(|| self.initial_derivatives(run, &joint));
            for &i in &decided {
                let clear = ranges.as_ref().and_then(|of| self.clear_motion(&of[i], i));
                let motion = clear.unwrap_or_else(|| self.first_motion(&joint, initial(), i));
                match motion {
                    FirstMotion::Order(order) => orders[i] = order,
                    FirstMotion::Instead(mode) => {
                        change = Some((i, mode));
                        break;
                    }
                }
            }
            let Some((i, mode)) = change else {
                return Ok(Next::Mode(self.modes, orders));
            };
            self.modes[i] = mode;
            if !self.can_hold(i) {
                // Across it the loads of the others may change.
                for &j in &decided {
                    self.open[j] = self.released != Some(j) && self.can_hold(j);
                }
                self.complement(run)?;
            }
        }
        Err(self.no_unique_mode(&decided, &[]))
    }

    /// Leaves contacts whose sides have no effect on their rates to what their rates are.
    fn close(&mut self, contacts: &[usize]) {
        for &i in contacts {
            self.open[i] = false;
            if self.modes[i] == Mode::Stick {
                self.modes[i] = Mode::Slip(Side::Above);
            }
        }
    }

    /// Solves the complementarity problem of the contacts to be decided. With static above kinetic
    /// friction, a released contact changes the loads of the others, which are decided again.
    fn complement(&mut self, run: &mut StepState<N, M>) -> Result<(), Error> {
        let open = self.open;
        self.complement_by_release(run)?;
        if !self.system.has_static_friction() {
            return Ok(());
        }
        let with_limits = |&i: &usize| open[i] && self.can_hold(i);
        let decided: Vec<usize> = (0..self.system.contacts()).filter(with_limits).collect();
        let groups = self.coupled(&decided);
        { groups.iter() }.try_for_each(|group| self.weigh_static_limits(group, run))
    }

    /// Groups of contacts, such that the friction of none acts on one of another group.
    fn coupled(&self, contacts: &[usize]) -> Vec<Vec<usize>> {
        let joint = self.corners_of(contacts);
        let slopes = joint.affine(self.at.t, components(&self.at.x)).slopes;
        let adds = S::MULTI_AFFINE || self.system.frictions_add();
        let acts = |(a, i): (usize, usize), (b, j): (usize, usize)| {
            !adds || slopes[i][b] != 0.0 || slopes[j][a] != 0.0
        };
        let mut groups: Vec<Vec<(usize, usize)>> = Vec::new();
        for one in contacts.iter().copied().enumerate() {
            let is_coupled = |group: &mut Vec<(usize, usize)>| {
                let mut members = group.iter();
                members.any(|other| acts(one, *other))
            };
            let joined: Vec<_> = groups.extract_if(.., is_coupled).flatten().collect();
            groups.push(joined.into_iter().chain([one]).collect());
        }
        let contacts_of = |group: Vec<(usize, usize)>| group.into_iter().map(|(_, i)| i).collect();
        groups.into_iter().map(contacts_of).collect()
    }

    /// Compares what [`Decision::complement_by_release`] has decided of coupled contacts with all
    /// motions that static and kinetic friction allow. A contact that can stick does. Contacts that
    /// stuck before keep sticking if some motion lets all of them.
    ///
    /// # Errors
    /// [`ContactFault::NoUniqueMode`] where several motions remain, and
    /// [`ContactFault::TooManyContacts`] where they are too many to try.
    fn weigh_static_limits(
        &mut self,
        group: &[usize],
        run: &mut StepState<N, M>,
    ) -> Result<(), Error> {
        let slips = |&&i: &&usize| self.modes[i] != Mode::Stick && self.has_static_friction(i);
        if group.len() < 2 || group.iter().find(slips).is_none() {
            return Ok(());
        }
        let stuck = |&i: &usize| self.before[i] == Mode::Stick;
        let (kept, arrived): (Vec<usize>, Vec<usize>) = group.iter().copied().partition(stuck);
        let mut holding = self.modes;
        kept.iter().for_each(|&i| holding[i] = Mode::Stick);
        for (modes, free) in [(holding, &arrived[..]), (self.modes, group)] {
            let set = |outcomes: &[Mode; M]| {
                let mut modes = modes;
                free.iter()
                    .zip(outcomes)
                    .for_each(|(&i, outcome)| modes[i] = *outcome);
                modes
            };
            run.counters.field_calls += group.len() as u64;
            let found = combinations(free.len(), |outcomes| {
                let modes = set(outcomes);
                self.agrees(group, &modes) && !self.can_stick_more(group, &modes)
            });
            let Some(found) = found else {
                let contacts = free.to_vec();
                let fault = ContactFault::TooManyContacts { contacts };
                return Err(Error::at_contacts(&self.at, fault));
            };
            match &found[..] {
                [] => {}
                [one] => {
                    self.modes = set(one);
                    return Ok(());
                }
                _ => return Err(self.no_unique_mode(free, &found)),
            }
        }
        // Rates or loads that are rounding are left to higher derivatives, unless one could stick.
        match self.can_stick_more(group, &self.modes) {
            true => Err(self.no_unique_mode(group, &[])),
            false => Ok(()),
        }
    }

    /// Whether a set of modes agrees with the rates and limits of the contacts to be decided, of
    /// which those that stick have their static limits.
    fn agrees(&self, decided: &[usize], modes: &[Mode; M]) -> bool {
        let joint = ContactFlow::new(self.system, modes);
        let shared = joint.hold_each_other(&self.at);
        let joint = joint.with_shared_load(shared);
        let (t, x) = (self.at.t, components(&self.at.x));
        let combination = joint.combination(t, x);
        let rates = rates(self.system, (t, 1.0), x, &combination.field);
        let shares = joint.held().iter().zip(&combination.shares);
        let mut of_decided = shares.filter(|(contact, _)| decided.contains(contact));
        let is_slip = |&i: &usize| match modes[i] {
            Mode::Stick => true,
            Mode::Slip(side) => {
                rates[i] * side.sign() > RELATIVE_ROUNDING * self.friction(i, false).abs()
            }
        };
        of_decided.all(|(_, share)| (0.0..=1.0).contains(share)) && decided.iter().all(is_slip)
    }

    /// Whether one more contact can stick.
    fn can_stick_more(&self, decided: &[usize], modes: &[Mode; M]) -> bool {
        let mut slipping = decided.iter().filter(|&&i| modes[i] != Mode::Stick);
        slipping.any(|&i| self.agrees(decided, &with(modes, i, Mode::Stick)))
    }

    /// [`Decision::complement`] by static limits of all. Those that slip are released for good.
    fn complement_by_release(&mut self, run: &mut StepState<N, M>) -> Result<(), Error> {
        while self.open.contains(&true) {
            let mut tried = self.modes;
            for (mode, is_open) in tried.iter_mut().zip(self.open) {
                if is_open {
                    *mode = Mode::Stick;
                }
            }
            let joint = ContactFlow::new(self.system, &tried);
            run.counters.field_calls += joint.field_calls();
            let (t, x) = (self.at.t, &self.at.x);
            let Some(consistent) = solutions(&joint, &self.modes, t, x) else {
                let contacts = joint.held().to_vec();
                let fault = ContactFault::TooManyContacts { contacts };
                return Err(Error::at_contacts(&self.at, fault));
            };
            let held: Vec<usize> = joint.held().to_vec();
            let [outcomes] = consistent[..] else {
                let is_led = |&i: &usize| self.open[i] && !self.can_hold(i);
                let led: Vec<usize> = held.iter().copied().filter(is_led).collect();
                if !consistent.is_empty() || led.is_empty() {
                    return Err(self.no_unique_mode(&held, &consistent));
                }
                // A higher derivative of theirs may decide, given the others.
                self.close(&led);
                continue;
            };
            let mut changes_the_rest = false;
            for (&i, outcome) in held.iter().zip(outcomes) {
                self.modes[i] = outcome;
                if outcome != Mode::Stick {
                    self.open[i] = false;
                    changes_the_rest |= self.has_static_friction(i);
                }
            }
            if !changes_the_rest {
                self.open = [false; M];
            }
        }
        Ok(())
    }

    /// Ranges of the guards and of their first three Lie derivatives along the motion in the
    /// decided mode, over all states and times that the present one may stand for. One pass bounds
    /// what [`Decision::initial_derivatives`] takes a pass in every direction to estimate. `None`
    /// where a comparison in the fields is undecided.
    fn ranges(
        &self,
        run: &mut StepState<N, M>,
        joint: &ContactFlow<'_, S, M>,
    ) -> Option<[[Interval; 4]; M]> {
        // Its weights depend on comparisons, or on an iteration.
        if joint.shares_load() || S::MULTI_AFFINE {
            return None;
        }
        let Timed { t, x } = self.at;
        let slack = run.slack();
        run.counters.field_calls += joint.field_calls() * 4;
        let time = Interval::around(t, STATE_ROUNDING * t.abs());
        let state: [Interval; N] = std::array::from_fn(|k| {
            let size = x[k].abs();
            let by_tolerance = EVENT_PRECISION * run.options.allowed(k, size);
            let is_used = k < self.system.dimension();
            let radius = STATE_ROUNDING * size + by_tolerance.max(slack);
            Interval::around(x[k], if is_used { radius } else { 0.0 })
        });
        Interval::decided(|| {
            let path = flow_path(time, &state, |t, x| joint.field(t, x));
            let guards: [_; M] = joint.field_and_guards(path.0, &path.1).1;
            guards.map(|guard| [guard.re, guard.v1, guard.v2, guard.v3])
        })
    }

    /// First motion of a contact, if the range of one number has one sign and decides it.
    fn clear_motion(&self, range: &[Interval; 4], i: usize) -> Option<FirstMotion> {
        match self.modes[i] {
            Mode::Stick => (sign_of_range(range[0]) > 0.0).then_some(FirstMotion::Order(0)),
            Mode::Slip(side) => {
                let order = if self.is_tangent(i) { 2 } else { 1 };
                // The time is known to rounding, in which the derivative moves by the next one.
                let next = range.get(order + 1)?;
                let drift = STATE_ROUNDING * self.at.t.abs() * (next.low.abs() + next.high.abs());
                let derivative = range[order] + Interval::new(-drift, drift);
                let sign = sign_of_range(derivative);
                (sign != 0.0).then(|| self.slip_begins(side, (order, sign), i))
            }
        }
    }

    /// Whether a slipping contact leaves its boundary along it: its holding has just reached its
    /// limit, so that the rate is zero, whatever its rounding.
    fn is_tangent(&self, i: usize) -> bool {
        self.released == Some(i)
            && !self.has_static_friction(i)
            && (0..M).all(|j| j == i || self.modes[j] == self.before[j])
    }

    /// Derivatives of the motion in the decided mode.
    fn initial_derivatives(
        &self,
        run: &mut StepState<N, M>,
        joint: &ContactFlow<'_, S, M>,
    ) -> InitialDerivatives<M> {
        let Timed { t, x } = self.at;
        // Four passes through the field, and one for the rounding in each direction.
        let dimension = self.system.dimension();
        run.counters.field_calls += joint.field_calls() * 5 * (dimension as u64 + 1);
        InitialDerivatives {
            derivatives: LieDerivatives::along((t, &x, dimension), run.slack(), |t, x| {
                let path = flow_path(t, x, |t, x| joint.field(t, x));
                joint.field_and_guards(path.0, &path.1).1
            }),
            blurs: uncertainties(joint, &self.at, &run.options.tolerance()),
        }
    }

    /// First motion of a contact in the decided mode, by the first derivative of its guard that
    /// does not vanish. If all vanish, it holds. An equilibrium on one side, which one contact may
    /// have, is not considered.
    fn first_motion(
        &self,
        joint: &ContactFlow<'_, S, M>,
        initial: &InitialDerivatives<M>,
        i: usize,
    ) -> FirstMotion {
        let Timed { t, x } = self.at;
        let derivatives = &initial.derivatives[i];
        match self.modes[i] {
            Mode::Stick if derivatives.values[0] > initial.blurs[i].zero() => FirstMotion::Order(0),
            Mode::Stick => match derivatives.leading(false) {
                (_, sign) if sign < 0.0 => {
                    FirstMotion::Instead(Mode::Slip(joint.nearest_side(i, t, &x)))
                }
                (order, _) => FirstMotion::Order(order.min(3)),
            },
            Mode::Slip(side) => {
                let leading = derivatives.leading(self.is_tangent(i));
                self.slip_begins(side, leading, i)
            }
        }
    }

    /// First motion of a contact on `side` by the first derivative of its guard that does not
    /// vanish, and its sign.
    fn slip_begins(&self, side: Side, (order, sign): (usize, f64), i: usize) -> FirstMotion {
        match (sign, self.can_hold(i)) {
            (sign, _) if sign > 0.0 => FirstMotion::Order(order),
            (_, true) => FirstMotion::Instead(Mode::Stick),
            // It remains at zero: no derivative up to the third moves it.
            (0.0, false) => FirstMotion::Order(3),
            (_, false) => FirstMotion::Instead(Mode::Slip(side.opposite())),
        }
    }

    /// Difference of a contact's rates below and above: twice the effect of friction on it, at rest
    /// or in slip.
    fn friction(&self, i: usize, at_rest: bool) -> f64 {
        let mut rests = [false; M];
        rests[i] = at_rest;
        self.friction_with(i, &rests)
    }

    /// The corners around the present mode: these contacts on either side, the other holding
    /// contacts below.
    fn corners_of(&self, contacts: &[usize]) -> ContactFlow<'_, S, M> {
        let mut modes = self.modes.map(|mode| match mode {
            Mode::Stick => Mode::Slip(Side::Below),
            slip => slip,
        });
        for &i in contacts {
            modes[i] = Mode::Stick;
        }
        ContactFlow::new(self.system, &modes)
    }

    /// Whether the side of a contact affects its own rate. It does not for a boundary in position,
    /// where only velocities jump.
    fn can_hold(&self, i: usize) -> bool {
        self.friction(i, true) != 0.0
    }

    /// Whether the side of another contact that is to be decided affects the rate of this one.
    fn is_led(&self, i: usize) -> bool {
        let (t, x) = (self.at.t, components(&self.at.x));
        (0..self.system.contacts()).any(|j| {
            let leads = || self.corners_of(&[j]).affine(t, x).slopes[i][0] != 0.0;
            j != i && self.open[j] && leads()
        })
    }

    /// [`Decision::friction`] with these contacts at rest.
    fn friction_with(&self, i: usize, rests: &[bool; M]) -> f64 {
        let joint = self.corners_of(&[i]).with_static_friction_at(rests);
        let affine = joint.affine(self.at.t, components(&self.at.x));
        -affine.slopes[i][0]
    }

    /// Whether a contact's friction at rest exceeds that in slip.
    pub(super) fn has_static_friction(&self, i: usize) -> bool {
        if !self.system.has_static_friction() {
            return false;
        }
        let (at_rest, in_slip) = (self.friction(i, true), self.friction(i, false));
        (at_rest - in_slip).abs() > RELATIVE_ROUNDING * in_slip.abs()
    }

    /// Checks that the contacts to be decided form a well-posed problem.
    fn check(&self, contacts: &[usize]) -> Result<(), Error> {
        let fault = |fault| Err(Error::at_contacts(&self.at, fault));
        let dependent = |contacts: &[usize]| {
            let contacts = contacts.to_vec();
            fault(ContactFault::DependentContacts { contacts })
        };
        let normals = gradients(self.system, &self.at, self.system.dimension());
        let mut gram = [[0.0; M]; M];
        for &i in contacts {
            let size = normals[i].norm();
            if size == 0.0 || !size.is_finite() {
                return dependent(&[i]);
            }
            for &j in contacts {
                gram[i][j] = normals[i].dot(&normals[j]) / (size * normals[j].norm());
            }
        }
        // Of boundaries that coincide, the gradients span no volume.
        if principal_minor(&gram, contacts) <= RELATIVE_ROUNDING {
            return dependent(contacts);
        }
        self.check_static(contacts)?;
        if S::MULTI_AFFINE || self.system.frictions_add() {
            return Ok(());
        }
        for (index, &i) in contacts.iter().enumerate() {
            for &j in &contacts[index + 1..] {
                if !self.adds_up(i, j) {
                    return fault(ContactFault::NotAdditive { pair: (i, j) });
                }
            }
        }
        Ok(())
    }

    /// Checks that each contact's static friction is not below its friction in slip, and acts on
    /// that contact alone.
    fn check_static(&self, contacts: &[usize]) -> Result<(), Error> {
        if !self.system.has_static_friction() {
            return Ok(());
        }
        let fault = |fault| Err(Error::at_contacts(&self.at, fault));
        let slipping: [f64; M] = std::array::from_fn(|i| self.friction(i, false));
        for &i in contacts {
            let (at_rest, in_slip) = (self.friction(i, true), slipping[i]);
            if at_rest < in_slip - RELATIVE_ROUNDING * in_slip.abs() {
                return fault(ContactFault::StaticBelowKinetic {
                    contact: i,
                    ratio: at_rest / in_slip,
                });
            }
            for j in (0..self.system.contacts()).filter(|j| *j != i) {
                let mut rests = [false; M];
                rests[i] = true;
                let (beside, alone) = (self.friction_with(j, &rests), slipping[j]);
                if (beside - alone).abs() > NEGLIGIBLE_FRICTION * (alone.abs() + in_slip.abs()) {
                    let (held, slipping) = (i, j);
                    return fault(ContactFault::HoldsElsewhere { held, slipping });
                }
            }
        }
        Ok(())
    }

    /// Whether the frictions of two contacts add: the effect of one does not depend on the side of
    /// the other.
    fn adds_up(&self, i: usize, j: usize) -> bool {
        let joint = self.corners_of(&[i, j]);
        let corner = |above: [bool; 2]| {
            joint.corner(|index| above[index], self.at.t, components(&self.at.x))
        };
        let [none, first, second, both] =
            [[false, false], [true, false], [false, true], [true, true]].map(corner);
        (0..N).all(|k| {
            let step = (none[k] - first[k]).abs() + (none[k] - second[k]).abs();
            let size = none[k].abs() + both[k].abs();
            // Forces that cancel leave their rounding; a real dependence on the other side has the
            // size of the forces.
            let allowed = NEGLIGIBLE_FRICTION * step + STATE_ROUNDING * size;
            (none[k] - first[k] - second[k] + both[k]).abs() <= allowed
        })
    }

    fn no_unique_mode(&self, contacts: &[usize], consistent: &[[Mode; M]]) -> Error {
        let candidates = consistent
            .iter()
            .map(|outcomes| format!("{:?}", &outcomes[..contacts.len()]))
            .collect();
        let fault = ContactFault::NoUniqueMode {
            contacts: contacts.to_vec(),
            candidates,
        };
        Error::at_contacts(&self.at, fault)
    }
}
