//! Systems as tapes: what the solver runs.

use std::fmt;
use std::sync::{Arc, OnceLock};

use stickslip::{Contacts, Direction, EventFunctions, Filippov, Scalar, Side};

use crate::expression::Tape;

/// A system of one contact, its fields as tapes.
#[derive(Clone, Debug)]
pub struct OneContact {
    /// The field of each side, [`Side::Below`] first.
    pub field: [Tape; 2],
    /// The field of each side while the contact holds, where that is another.
    pub holding: Option<[Tape; 2]>,
    /// The boundary function.
    pub boundary: Tape,
    /// The normal force, where contact can be lost.
    pub normal_force: Option<Tape>,
}

/// Which of two a side is.
fn index(side: Side) -> usize {
    match side {
        Side::Below => 0,
        Side::Above => 1,
    }
}

#[inline(always)]
fn values<T: Scalar, const N: usize, const K: usize>(tape: &Tape, t: T, x: &[T; N]) -> [T; K] {
    let mut out = [T::zero(); K];
    tape.evaluate(t, x, &mut out);
    out
}

impl<const N: usize> Filippov<N> for OneContact {
    const INTERPRETED: bool = true;

    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        values(&self.field[index(side)], t, x)
    }

    #[inline(always)]
    fn holding<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        let fields = self.holding.as_ref().unwrap_or(&self.field);
        values(&fields[index(side)], t, x)
    }

    #[inline(always)]
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        let [height] = values(&self.boundary, t, x);
        height
    }

    #[inline(always)]
    fn contact<T: Scalar>(&self, t: T, x: &[T; N]) -> Option<T> {
        let [force] = values(self.normal_force.as_ref()?, t, x);
        Some(force)
    }
}

/// The contacts that are above and those that hold, a bit for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Combination {
    /// Bit `i` is set where contact `i` is [`Side::Above`].
    pub above: usize,
    /// Bit `i` is set where contact `i` holds.
    pub held: usize,
}

/// Makes the tape of the field of a combination; `None` where there is none.
pub type MakeTape = dyn Fn(Combination) -> Option<Tape> + Send + Sync;

/// Where the tape of a combination is kept.
type Place = OnceLock<(Combination, Option<Tape>)>;

/// The fields of all combinations of sides and holding contacts, of which there are 4 to the number
/// of contacts. Each is made when it is first asked for.
#[derive(Clone)]
pub struct Fields {
    contacts: usize,
    made: Arc<[Place]>,
    make: Arc<MakeTape>,
}

/// Combinations that are kept: more than an orbit comes to. Further ones are made at every
/// evaluation.
const MOST_KEPT: usize = 1 << 12;

impl Fields {
    /// None of them made yet.
    pub fn new(contacts: usize, make: Arc<MakeTape>) -> Self {
        let all = 1_usize
            .checked_shl(2 * contacts as u32)
            .unwrap_or(MOST_KEPT);
        let made = (0..all.min(MOST_KEPT)).map(|_| OnceLock::new());
        Fields {
            contacts,
            made: made.collect(),
            make,
        }
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// Keeps the tape of a combination, which need not be made then.
    pub fn keep(&self, of: Combination, tape: &Tape) {
        let kept = || (of, Some(tape.clone()));
        self.places(of)
            .find(|place| place.get_or_init(kept).0 == of);
    }

    /// The tape of a combination; `None` where it has none.
    pub fn tape(&self, of: Combination) -> Option<Tape> {
        match self.kept(of) {
            Some(tape) => tape.clone(),
            None => (self.make)(of),
        }
    }

    /// Evaluates the field of a combination; where it has none, to no numbers.
    pub fn evaluate<T: Scalar>(&self, of: Combination, t: T, x: &[T], out: &mut [T]) {
        match self.kept(of) {
            Some(tape) => evaluate(tape.as_ref(), t, x, out),
            None => evaluate((self.make)(of).as_ref(), t, x, out),
        }
    }

    /// The tape that is kept of a combination, made now if need be; `None` where there is no room.
    fn kept(&self, of: Combination) -> Option<&Option<Tape>> {
        let kept = self
            .places(of)
            .map(|place| place.get_or_init(|| (of, (self.make)(of))));
        let mut own = kept.filter(|(other, _)| *other == of);
        own.next().map(|(_, tape)| tape)
    }

    /// The places of a combination: its own if all have one, else the next free one behind that.
    fn places(&self, of: Combination) -> impl Iterator<Item = &Place> {
        let own = (of.above | of.held << self.contacts) % self.made.len();
        let (before, from_own) = self.made.split_at(own);
        from_own.iter().chain(before)
    }
}

fn evaluate<T: Scalar>(tape: Option<&Tape>, t: T, x: &[T], out: &mut [T]) {
    match tape {
        Some(tape) => tape.evaluate(t, x, out),
        None => out.fill(T::constant(f64::NAN)),
    }
}

/// Contacts up to which all sides are looked at before a run.
const ALL_SIDES: usize = 4;

/// The sides that are looked at before a run: all, or of many contacts all below, all above, and
/// each one by itself on the other side than the rest.
pub fn sides_to_check(contacts: usize) -> Vec<usize> {
    let all = (1 << contacts) - 1;
    if contacts <= ALL_SIDES {
        return (0..=all).collect();
    }
    let alone = (0..contacts).flat_map(|contact| [1 << contact, all ^ 1 << contact]);
    [0, all].into_iter().chain(alone).collect()
}

impl fmt::Debug for Fields {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fields of {} contacts", self.contacts)
    }
}

/// A system of several contacts, its fields as tapes.
#[derive(Clone, Debug)]
pub struct ManyContacts {
    /// The fields.
    pub fields: Fields,
    /// Whether a field is another one while contacts hold.
    pub has_static: bool,
    /// The boundary functions; more than there are contacts are asked for, and those are never
    /// zero.
    pub boundaries: Tape,
}

impl ManyContacts {
    /// Those of the contacts that there are for which something is true.
    fn bits<const M: usize>(&self, is: impl Fn(usize) -> bool) -> usize {
        let contacts = self.fields.contacts.min(M);
        (0..contacts).fold(0, |bits, i| bits | usize::from(is(i)) << i)
    }

    fn values<T: Scalar, const N: usize>(&self, of: Combination, t: T, x: &[T; N]) -> [T; N] {
        let mut out = [T::zero(); N];
        self.fields.evaluate(of, t, x, &mut out);
        out
    }
}

impl<const N: usize, const M: usize> Contacts<N, M> for ManyContacts {
    const INTERPRETED: bool = true;

    #[inline(always)]
    fn field<T: Scalar>(&self, sides: &[Side; M], t: T, x: &[T; N]) -> [T; N] {
        let above = self.bits::<M>(|i| sides[i] == Side::Above);
        self.values(Combination { above, held: 0 }, t, x)
    }

    #[inline(always)]
    fn holding<T: Scalar>(&self, sides: &[Side; M], held: &[bool; M], t: T, x: &[T; N]) -> [T; N] {
        let above = self.bits::<M>(|i| sides[i] == Side::Above);
        let held = self.bits::<M>(|i| self.has_static && held[i]);
        self.values(Combination { above, held }, t, x)
    }

    #[inline(always)]
    fn boundaries<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; M] {
        // Where there are fewer contacts than the number that is compiled, the rest is never at
        // zero.
        let mut heights = [T::one(); M];
        self.boundaries.evaluate(t, x, &mut heights);
        heights
    }
}

/// The equations of a system of any kind.
#[derive(Clone, Debug)]
pub enum Equations {
    /// Of one contact.
    OneContact(Box<OneContact>),
    /// Of several.
    ManyContacts(ManyContacts),
}

/// A Poincaré section.
#[derive(Clone, Debug)]
pub struct Section {
    /// The function that is zero on it.
    pub function: Tape,
    /// Which way it is passed.
    pub direction: Direction,
}

/// The section that a system has, if it has one.
#[derive(Clone, Debug)]
pub(super) struct OwnSection(pub Option<Section>);

impl<const N: usize> EventFunctions<N, 1> for OwnSection {
    #[inline(always)]
    fn values<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; 1] {
        match &self.0 {
            Some(section) => values(&section.function, t, x),
            None => [T::one()],
        }
    }

    fn direction(&self, _number: usize) -> Direction {
        let own = self.0.as_ref();
        own.map_or(Direction::Both, |section| section.direction)
    }
}
