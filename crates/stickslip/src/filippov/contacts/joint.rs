//! The smooth flow of one mode of several contacts: each slips on its side or holds.

use super::Contacts;
use super::equations::solve;
use crate::dual::{Dual, Dual3};
use crate::filippov::flow::{Flow, flow_path, seeded};
use crate::filippov::rules::LieDerivatives;
use crate::ode::{Linear, Timed};
use crate::scalar::Scalar;
use crate::system::{Mode, Side, State, components};

/// Number of Newton steps for a multi-affine combination, from the affine solution. Each squares
/// the error: seven reach rounding from an error of 0.75. The number is fixed, so that each
/// coefficient of a series converges, too.
const NEWTON_STEPS: usize = 7;

/// An effect below this fraction of that of friction is none: of one contact on another, and on a
/// rate after Newton's iteration. Chosen between the rounding of the forces and any coupling meant.
pub(super) const NEGLIGIBLE_FRICTION: f64 = 1e-9;

/// Contacts that hold or slip, and the resulting field. Guard `i` belongs to contact `i`. In slip
/// it is the boundary function times the sign of the side. In stick it is `w (1 − w) s` with `w`
/// the weight of the field above and `s` the strength of friction. The strength is the difference
/// of the contact's rates below and above if it alone holds, else 1. A weight at its limit ends
/// stick, and so does a strength that vanishes, as at a two-fold.
#[derive(Clone, Copy)]
pub(super) struct ContactFlow<'a, S, const M: usize> {
    pub(super) system: &'a S,
    /// The sides of the slipping contacts; below for the others.
    sides: [Side; M],
    holds: [bool; M],
    /// Contacts whose friction is static.
    at_rest: [bool; M],
    /// The holding contacts, first in the list.
    held: [usize; M],
    pub(super) count: usize,
    /// Whether they share their loads; see [`ContactFlow::shared`].
    shares_load: bool,
}

/// The combination of fields that keeps the holding contacts on their boundaries.
pub(super) struct FieldCombination<T, const N: usize, const M: usize> {
    pub(super) field: [T; N],
    /// The weight of the field above for every holding contact, in their order.
    pub(super) shares: [T; M],
    /// Pivots of the effects of the holding contacts on their rates, in their order; −1 where they
    /// share their loads.
    pivots: [T; M],
    /// Strength of friction of the only holding contact; 1 if several hold.
    strength: T,
}

impl<T: Scalar, const N: usize, const M: usize> FieldCombination<T, N, M> {
    /// The guard of a holding contact, by its index among them.
    #[inline(always)]
    fn stick_guard(&self, index: usize) -> T {
        let share = self.shares[index];
        share * (-share + 1.0) * self.strength
    }
}

/// The fields of the corners around one corner: linear in the weights.
pub(super) struct CornerFields<T, const N: usize, const M: usize> {
    /// The field with all holding contacts below.
    base: [T; N],
    /// The difference that each holding contact makes above, in their order.
    pub(super) changes: [[T; N]; M],
    /// Rates of all boundary functions along the base.
    pub(super) rates: [T; M],
    /// `slopes[j][i]`: change of the rate of the `j`-th boundary function with the weight of the
    /// `i`-th holding contact.
    pub(super) slopes: [[T; M]; M],
}

/// Rates of the boundary functions along `f`, in a time that passes at `pace`.
#[inline(always)]
pub(super) fn rates<S: Contacts<N, M>, T: Scalar, const N: usize, const M: usize>(
    system: &S,
    (t, pace): (T, T),
    x: &[T; N],
    f: &[T; N],
) -> [T; M] {
    let mut along = [Dual::zero(); N];
    for i in 0..N {
        along[i] = Dual::new(x[i], f[i]);
    }
    let h = system.boundaries(Dual::new(t, pace), &along);
    let mut rates = [T::zero(); M];
    for i in 0..M {
        rates[i] = h[i].eps;
    }
    rates
}

impl<'a, S, const M: usize> ContactFlow<'a, S, M> {
    /// The flow of a mode.
    #[inline(always)]
    pub(super) fn new(system: &'a S, modes: &[Mode; M]) -> Self {
        let mut joint = ContactFlow {
            system,
            sides: [Side::Below; M],
            holds: [false; M],
            at_rest: [false; M],
            held: [0; M],
            count: 0,
            shares_load: false,
        };
        for (i, mode) in modes.iter().enumerate() {
            match mode {
                Mode::Slip(side) => joint.sides[i] = *side,
                Mode::Stick => {
                    (joint.holds[i], joint.at_rest[i]) = (true, true);
                    joint.held[joint.count] = i;
                    joint.count += 1;
                }
            }
        }
        joint
    }

    /// The flow with static friction at these contacts and no others.
    pub(super) fn with_static_friction_at(mut self, contacts: &[bool; M]) -> Self {
        self.at_rest = *contacts;
        self
    }

    /// The flow with contacts that share their loads, or each with its own.
    #[inline(always)]
    pub(super) fn with_shared_load(mut self, shared: bool) -> Self {
        self.shares_load = shared;
        self
    }

    /// Whether the holding contacts share their loads.
    pub(super) fn shares_load(&self) -> bool {
        self.shares_load
    }

    #[inline(always)]
    pub(super) fn held(&self) -> &[usize] {
        &self.held[..self.count]
    }

    /// The field with each holding contact above or below, by `above`.
    #[inline(always)]
    pub(super) fn corner<T: Scalar, const N: usize>(
        &self,
        above: impl Fn(usize) -> bool,
        t: T,
        x: &[T; N],
    ) -> [T; N]
    where
        S: Contacts<N, M>,
    {
        let mut sides = self.sides;
        for (index, &contact) in self.held().iter().enumerate() {
            if above(index) {
                sides[contact] = Side::Above;
            }
        }
        // With no contact at rest, `holding` does not count.
        if self.at_rest.contains(&true) {
            self.system.holding(&sides, &self.at_rest, t, x)
        } else {
            self.system.field(&sides, t, x)
        }
    }

    #[inline(always)]
    pub(super) fn affine<T: Scalar, const N: usize>(
        &self,
        t: T,
        x: &[T; N],
    ) -> CornerFields<T, N, M>
    where
        S: Contacts<N, M>,
    {
        let base = self.corner(|_| false, t, x);
        let mut affine = CornerFields {
            base,
            changes: [[T::zero(); N]; M],
            rates: rates(self.system, (t, T::one()), x, &base),
            slopes: [[T::zero(); M]; M],
        };
        for index in 0..self.count {
            let above = self.corner(|other| other == index, t, x);
            let change = &mut affine.changes[index];
            for k in 0..N {
                if !above[k].is_same(base[k]) {
                    change[k] = above[k] - base[k];
                }
            }
            let slopes = rates(self.system, (t, T::zero()), x, change);
            for (row, slope) in affine.slopes.iter_mut().zip(slopes) {
                row[index] = slope;
            }
        }
        affine
    }

    /// The combination that is tangent to the boundaries of all holding contacts.
    #[inline(always)]
    pub(super) fn combination<T: Scalar, const N: usize>(
        &self,
        t: T,
        x: &[T; N],
    ) -> FieldCombination<T, N, M>
    where
        S: Contacts<N, M>,
    {
        let affine = self.affine(t, x);
        if self.shares_load {
            return self.shared(affine);
        }
        let mut matrix = [[T::zero(); M]; M];
        let mut shares = [T::zero(); M];
        for (j, &contact) in self.held().iter().enumerate() {
            matrix[j] = affine.slopes[contact];
            shares[j] = -affine.rates[contact];
        }
        solve(&mut matrix, &mut shares, self.count);
        if S::MULTI_AFFINE && self.count > 1 {
            for _ in 0..NEWTON_STEPS {
                matrix = self.newton(t, x, &mut shares);
            }
            return FieldCombination {
                field: self.multi_affine(t, x, &shares).0,
                shares,
                pivots: diagonal(&matrix),
                strength: T::one(),
            };
        }
        let strength = match self.count {
            1 => -matrix[0][0],
            _ => T::one(),
        };
        self.combined(affine, shares, (diagonal(&matrix), strength))
    }

    /// The combination with these weights.
    #[inline(always)]
    fn combined<T: Scalar, const N: usize>(
        &self,
        affine: CornerFields<T, N, M>,
        shares: [T; M],
        (pivots, strength): ([T; M], T),
    ) -> FieldCombination<T, N, M> {
        let mut field = affine.base;
        let each = shares.iter().zip(&affine.changes).take(self.count);
        for (share, change) in each {
            for (rate, change) in field.iter_mut().zip(change) {
                *rate = *rate + *share * *change;
            }
        }
        FieldCombination {
            field,
            shares,
            pivots,
            strength,
        }
    }

    /// The combination for holding contacts of which some do not affect their own rates, as a
    /// position and its velocity. Such a rate is zero, and the other contacts keep it so. The
    /// weights are then not unique. Those nearest to the middle are taken, each scaled by its
    /// contact's strength. So no contact alone reaches its limit while others that act on the same
    /// rate do not.
    #[inline(never)]
    fn shared<T: Scalar, const N: usize>(
        &self,
        affine: CornerFields<T, N, M>,
    ) -> FieldCombination<T, N, M> {
        let held = self.held();
        // Strength of each contact, by which its column is divided.
        let mut weights = [T::zero(); M];
        for (index, weight) in weights.iter_mut().enumerate().take(self.count) {
            for &contact in held {
                *weight = *weight + Scalar::abs(affine.slopes[contact][index]);
            }
            *weight = T::one().divided_or(*weight, 0.0);
        }
        let (mut matrix, mut loads) = ([[T::zero(); M]; M], [T::zero(); M]);
        for (j, &row) in held.iter().enumerate() {
            let slopes = &affine.slopes[row];
            loads[j] = -affine.rates[row];
            for index in 0..self.count {
                loads[j] = loads[j] - slopes[index] * 0.5;
                let weighted = slopes[index] * weights[index];
                for (k, &column) in held.iter().enumerate() {
                    matrix[j][k] = matrix[j][k] + weighted * affine.slopes[column][index];
                }
            }
            // A rate that no contact affects is left as it is.
            let inverse = T::one().divided_or(matrix[j][j], 0.0);
            matrix[j][j] = T::one().divided_or(inverse, 1.0);
        }
        solve(&mut matrix, &mut loads, self.count);
        let mut shares = [T::constant(0.5); M];
        for index in 0..self.count {
            for (j, &row) in held.iter().enumerate() {
                shares[index] =
                    shares[index] + weights[index] * affine.slopes[row][index] * loads[j];
            }
        }
        self.combined(affine, shares, ([-T::one(); M], T::one()))
    }

    /// Whether a holding contact affects the rates of others only, and they affect its own.
    pub(super) fn hold_each_other<const N: usize>(&self, at: &Timed<N>) -> bool
    where
        S: Contacts<N, M>,
    {
        let slopes = self.affine(at.t, components(&at.x)).slopes;
        let is_held_by_others = |(own, &i): (usize, &usize)| {
            slopes[i][own] == 0.0 && slopes[i][..self.count].iter().any(|slope| *slope != 0.0)
        };
        self.count > 1 && self.held().iter().enumerate().any(is_held_by_others)
    }

    /// Whether all holding contacts can hold at a point and stay on their boundaries.
    pub(super) fn rests<const N: usize>(&self, at: &Timed<N>, slack: f64) -> bool
    where
        S: Contacts<N, M>,
    {
        if self.shares_load && S::MULTI_AFFINE {
            return false;
        }
        let shares = self.combination(at.t, components(&at.x)).shares;
        let is_within = |share: &f64| 0.0 < *share && *share < 1.0;
        let along = self.boundaries_along(at, slack, |t, x| self.field(t, x));
        let [below, above] = [false, true].map(|is_above| {
            self.boundaries_along(at, slack, |t, x| self.corner(|_| is_above, t, x))
        });
        let stays = |&i: &usize| along[i].holds_beside([&below[i], &above[i]]);
        shares[..self.count].iter().all(is_within) && self.held().iter().all(stays)
    }

    /// Lie derivatives of the boundary functions along a field.
    fn boundaries_along<const N: usize>(
        &self,
        at: &Timed<N>,
        slack: f64,
        field: impl Fn(Dual3<Dual<f64>>, &[Dual3<Dual<f64>>; N]) -> [Dual3<Dual<f64>>; N],
    ) -> [LieDerivatives; M]
    where
        S: Contacts<N, M>,
    {
        let here = (at.t, &at.x, self.system.dimension());
        LieDerivatives::along(here, slack, |t, x| {
            let path = flow_path(t, x, &field);
            self.system.boundaries(path.0, &path.1)
        })
    }

    /// One Newton step for the weights of a multi-affine combination. Returns its matrix after
    /// elimination.
    #[inline(never)]
    fn newton<T: Scalar, const N: usize>(
        &self,
        t: T,
        x: &[T; N],
        shares: &mut [T; M],
    ) -> [[T; M]; M]
    where
        S: Contacts<N, M>,
    {
        let (field, changes) = self.multi_affine(t, x, shares);
        let off = rates(self.system, (t, T::one()), x, &field);
        let mut matrix = [[T::zero(); M]; M];
        let mut step = [T::zero(); M];
        for index in 0..self.count {
            let slopes = rates(self.system, (t, T::zero()), x, &changes[index]);
            for (j, &contact) in self.held().iter().enumerate() {
                matrix[j][index] = slopes[contact];
                step[j] = off[contact];
            }
        }
        solve(&mut matrix, &mut step, self.count);
        for index in 0..self.count {
            shares[index] = shares[index] - step[index];
        }
        matrix
    }

    /// The multi-affine combination of all corners, and its derivative in every weight.
    #[inline(never)]
    fn multi_affine<T: Scalar, const N: usize>(
        &self,
        t: T,
        x: &[T; N],
        shares: &[T; M],
    ) -> ([T; N], [[T; N]; M])
    where
        S: Contacts<N, M>,
    {
        let mut field = [T::zero(); N];
        let mut changes = [[T::zero(); N]; M];
        for corner in 0..1_usize << self.count {
            let is_above = |index: usize| corner >> index & 1 == 1;
            let value = self.corner(is_above, t, x);
            // The corner's coefficient without the factor of one contact, or of none.
            let weight = |without: Option<usize>| {
                let mut weight = T::one();
                for index in (0..self.count).filter(|&index| Some(index) != without) {
                    let share = shares[index];
                    weight = weight * if is_above(index) { share } else { -share + 1.0 };
                }
                weight
            };
            let product = weight(None);
            for k in 0..N {
                field[k] = field[k] + product * value[k];
            }
            for (index, change) in changes.iter_mut().enumerate().take(self.count) {
                let sign = if is_above(index) { 1.0 } else { -1.0 };
                let slope = weight(Some(index)) * sign;
                for k in 0..N {
                    change[k] = change[k] + slope * value[k];
                }
            }
        }
        (field, changes)
    }

    /// The index of a contact among the holding ones.
    #[inline(always)]
    fn index_among_held(&self, contact: usize) -> usize {
        self.held()
            .iter()
            .position(|&held| held == contact)
            .unwrap_or(0)
    }

    /// The side whose friction a holding contact is nearest to.
    pub(super) fn nearest_side<const N: usize>(&self, contact: usize, t: f64, x: &State<N>) -> Side
    where
        S: Contacts<N, M>,
    {
        let shares = self.combination(t, components(x)).shares;
        if shares[self.index_among_held(contact)] > 0.5 {
            Side::Above
        } else {
            Side::Below
        }
    }

    /// Reserve of a holding contact, `w (1 − w)`: at most 1/4, and 0 at its limit.
    pub(super) fn reserve<const N: usize>(&self, contact: usize, t: f64, x: &State<N>) -> f64
    where
        S: Contacts<N, M>,
    {
        let shares = self.combination(t, components(x)).shares;
        let share = shares[self.index_among_held(contact)];
        share * (1.0 - share)
    }

    #[inline(always)]
    fn slip_guard<T: Scalar>(&self, contact: usize, h: &[T; M]) -> T {
        h[contact] * self.sides[contact].sign()
    }

    /// One Newton step from `x` onto the boundaries of these contacts, along their gradients.
    pub(super) fn project<const N: usize>(
        &self,
        contacts: &[usize],
        t: f64,
        x: State<N>,
    ) -> State<N>
    where
        S: Contacts<N, M>,
    {
        let h = self.system.boundaries(t, components(&x));
        if contacts.iter().all(|&i| h[i] == 0.0) {
            return x;
        }
        let at = Timed { t, x };
        let gradients = gradients(self.system, &at, self.system.dimension());
        let mut gram = [[0.0; M]; M];
        let mut multipliers = [0.0; M];
        for (row, &i) in contacts.iter().enumerate() {
            multipliers[row] = -h[i];
            for (column, &j) in contacts.iter().enumerate() {
                gram[row][column] = gradients[i].dot(&gradients[j]);
            }
        }
        solve(&mut gram, &mut multipliers, contacts.len());
        let mut projected = x;
        for (row, &i) in contacts.iter().enumerate() {
            projected = projected.add_scaled(multipliers[row], &gradients[i]);
        }
        if projected.iter().all(|v| v.is_finite()) {
            projected
        } else {
            x
        }
    }
}

fn diagonal<T: Scalar, const M: usize>(matrix: &[[T; M]; M]) -> [T; M] {
    std::array::from_fn(|k| matrix[k][k])
}

/// Gradients of the boundary functions in the first components of the state, whose number is given.
pub(super) fn gradients<S: Contacts<N, M>, const N: usize, const M: usize>(
    system: &S,
    at: &Timed<N>,
    states: usize,
) -> [State<N>; M] {
    let mut gradients = [State::from([0.0; N]); M];
    for k in 0..states {
        let (t, x) = seeded(at, k);
        for (gradient, h) in gradients.iter_mut().zip(system.boundaries(t, &x)) {
            gradient[k] = h.eps;
        }
    }
    gradients
}

/// The numbers of the first 64 contacts, of which a system uses the first ones.
const CONTACT_NUMBERS: [usize; 64] = {
    let mut numbers = [0; 64];
    let mut i = 0;
    while i < 64 {
        numbers[i] = i;
        i += 1;
    }
    numbers
};

impl<S: Contacts<N, M>, const N: usize, const M: usize> Flow<N> for ContactFlow<'_, S, M> {
    const TOGETHER: bool = M > 1;
    const INTERPRETED: bool = S::INTERPRETED;

    fn guards(&self) -> &'static [usize] {
        const {
            assert!(
                1 <= M && M <= CONTACT_NUMBERS.len(),
                "a system has 1 to 64 contacts"
            );
            CONTACT_NUMBERS.split_at(M).0
        }
    }

    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    #[inline(always)]
    fn field_calls(&self) -> u64 {
        let around = self.count as u64 + 1;
        if S::MULTI_AFFINE && self.count > 1 {
            around.saturating_add(
                (NEWTON_STEPS as u64 + 1).saturating_mul(2_u64.saturating_pow(self.count as u32)),
            )
        } else {
            around
        }
    }

    #[inline(always)]
    fn field<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; N] {
        if self.count == 0 {
            self.system.field(&self.sides, t, x)
        } else {
            self.combination(t, x).field
        }
    }

    #[inline(always)]
    fn guard<T: Scalar>(&self, i: usize, t: T, x: &[T; N]) -> T {
        if self.holds[i] {
            self.combination(t, x).stick_guard(self.index_among_held(i))
        } else {
            self.slip_guard(i, &self.system.boundaries(t, x))
        }
    }

    fn friction_vanishes(&self, from: &Timed<N>, at: &Timed<N>) -> bool {
        // Half of the digits: the place is a zero to rounding.
        let part = f64::EPSILON.sqrt();
        self.count > 1 && {
            let [from, here] = [from, at].map(|at| self.affine(at.t, components(&at.x)).changes);
            let size = |of: &[f64; N]| of.iter().fold(0.0, |size: f64, one| size.max(one.abs()));
            (0..self.count).any(|k| size(&here[k]) <= part * size(&from[k]))
        }
    }

    fn may_hide_two_fold(&self) -> bool {
        self.count > 1 && !self.shares_load
    }

    fn attraction<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        match self.count {
            0 => T::zero(),
            1 => self.combination(t, x).strength,
            // The determinant of the effects of friction on the rates. Where it vanishes, a contact
            // is at a two-fold while the others hold.
            _ => {
                let pivots = self.combination(t, x).pivots;
                let pivots = pivots.iter().take(self.count);
                pivots.fold(T::one(), |product, pivot| product * -*pivot)
            }
        }
    }

    #[inline(always)]
    fn field_and_guards<T: Scalar, const G: usize>(&self, t: T, x: &[T; N]) -> ([T; N], [T; G]) {
        let mut guards = [T::one(); G];
        let h = self.system.boundaries(t, x);
        if self.count == 0 {
            for (i, guard) in guards.iter_mut().enumerate().take(M) {
                *guard = self.slip_guard(i, &h);
            }
            return (self.system.field(&self.sides, t, x), guards);
        }
        let combination = self.combination(t, x);
        for (i, guard) in guards.iter_mut().enumerate().take(M) {
            *guard = if self.holds[i] {
                combination.stick_guard(self.index_among_held(i))
            } else {
                self.slip_guard(i, &h)
            };
        }
        (combination.field, guards)
    }

    fn settle(&self, t: f64, x: State<N>) -> State<N> {
        self.project(self.held(), t, x)
    }

    fn land(&self, i: usize, t: f64, x: State<N>) -> State<N> {
        if self.holds[i] {
            return self.settle(t, x);
        }
        let mut contacts = self.held;
        contacts[self.count] = i;
        self.project(&contacts[..=self.count], t, x)
    }
}
