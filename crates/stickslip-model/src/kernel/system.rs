//! Systems as tapes, in the form that the solver runs.

use std::fmt;
use std::sync::{Arc, OnceLock};

use stickslip::{Contacts, Direction, EventFunctions, Filippov, Scalar, Side};

use crate::expression::Tape;

/// A system with one contact and its fields as tapes.
#[derive(Clone, Debug)]
pub struct TapedFilippov {
    /// Number of states that move.
    pub dimension: usize,
    /// The field of each side, [`Side::Below`] first.
    pub field: [Tape; 2],
    /// The field of each side while the contact holds, if it differs.
    pub holding: Option<[Tape; 2]>,
    /// The boundary function.
    pub boundary: Tape,
    /// The normal force, if contact can be lost.
    pub normal_force: Option<Tape>,
    /// The period of the drive, where it depends on states that are parameters.
    pub period: Option<Tape>,
}

/// Index of a side.
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

impl<const N: usize> Filippov<N> for TapedFilippov {
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

    fn period<T: Scalar>(&self, x: &[T; N]) -> Option<T> {
        let [period] = values(self.period.as_ref()?, T::zero(), x);
        Some(period)
    }

    fn dimension(&self) -> usize {
        self.dimension.min(N)
    }
}

/// The contacts that are above and those that hold, as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Combination {
    /// Bit `i` is set where contact `i` is [`Side::Above`].
    pub above: usize,
    /// Bit `i` is set where contact `i` holds.
    pub held: usize,
}

/// Builds the tape of the field of a combination; `None` if there is none.
pub type BuildTape = dyn Fn(Combination) -> Option<Tape> + Send + Sync;

/// Storage of what belongs to a combination.
type Slot<T> = OnceLock<(Combination, T)>;

/// One value for each combination of sides and holding contacts, 4^M for M contacts. Each is made
/// on first use.
pub struct ByCombination<T> {
    contacts: usize,
    slots: Arc<[Slot<T>]>,
}

/// The fields of all combinations.
#[derive(Clone)]
pub struct Fields {
    tapes: ByCombination<Option<Tape>>,
    build: Arc<BuildTape>,
}

/// Number of combinations that are stored. It bounds memory to some 100 MB: seven contacts have as
/// many, and with more an orbit visits few of theirs. Those without room are rebuilt at every
/// evaluation.
const MOST_STORED_TAPES: usize = 1 << 14;

/// A factor that spreads numbers over all bits: 2^64 over the golden ratio (Knuth, *The Art of
/// Computer Programming* 3, Sect. 6.4).
const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;

/// Number of slots in which a combination is looked for. More would take as long as a rebuild.
const PROBES: usize = 16;

impl<T> Clone for ByCombination<T> {
    fn clone(&self) -> Self {
        ByCombination {
            contacts: self.contacts,
            slots: Arc::clone(&self.slots),
        }
    }
}

impl<T> ByCombination<T> {
    /// Nothing is made yet.
    pub fn new(contacts: usize) -> Self {
        let all = 1_usize
            .checked_shl(2 * contacts as u32)
            .unwrap_or(MOST_STORED_TAPES);
        let slots = (0..all.min(MOST_STORED_TAPES)).map(|_| OnceLock::new());
        ByCombination {
            contacts,
            slots: slots.collect(),
        }
    }

    /// Value of a combination, made if necessary; `None` if there is no room.
    pub fn get_or_make(&self, of: Combination, make: impl Fn() -> T) -> Option<&T> {
        let stored = self
            .slots_of(of)
            .map(|slot| slot.get_or_init(|| (of, make())));
        let mut own = stored.filter(|(other, _)| *other == of);
        own.next().map(|(_, found)| found)
    }

    /// The slots of a combination, in order of search: its own first, then the following ones.
    fn slots_of(&self, of: Combination) -> impl Iterator<Item = &Slot<T>> {
        let key = of.above | of.held << self.contacts;
        let own = match self.slots.len() {
            // All have room. Otherwise neighbours are spread.
            all if 2 * self.contacts < all.ilog2() as usize + 1 => key % all,
            some => ((key as u64).wrapping_mul(SPREAD) >> (u64::BITS - some.ilog2())) as usize,
        };
        let (before, from_own) = self.slots.split_at(own);
        from_own.iter().chain(before).take(PROBES)
    }
}

impl<T> fmt::Debug for ByCombination<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "combinations of {} contacts", self.contacts)
    }
}

impl Fields {
    /// No field is built yet.
    pub fn new(contacts: usize, build: Arc<BuildTape>) -> Self {
        let tapes = ByCombination::new(contacts);
        Fields { tapes, build }
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.tapes.contacts
    }

    /// Stores the tape of a combination, which then need not be built.
    pub fn keep(&self, of: Combination, tape: &Tape) {
        self.tapes.get_or_make(of, || Some(tape.clone()));
    }

    /// The tape of a combination; `None` if there is none.
    pub fn tape(&self, of: Combination) -> Option<Tape> {
        match self.stored(of) {
            Some(tape) => tape.clone(),
            None => (self.build)(of),
        }
    }

    /// Evaluates the field of a combination; NaN if there is none.
    pub fn evaluate<T: Scalar>(&self, of: Combination, t: T, x: &[T], out: &mut [T]) {
        match self.stored(of) {
            Some(tape) => evaluate(tape.as_ref(), t, x, out),
            None => evaluate((self.build)(of).as_ref(), t, x, out),
        }
    }

    /// The stored tape of a combination, built if necessary; `None` if there is no room.
    fn stored(&self, of: Combination) -> Option<&Option<Tape>> {
        self.tapes.get_or_make(of, || (self.build)(of))
    }
}

fn evaluate<T: Scalar>(tape: Option<&Tape>, t: T, x: &[T], out: &mut [T]) {
    match tape {
        Some(tape) => tape.evaluate(t, x, out),
        None => out.fill(T::constant(f64::NAN)),
    }
}

/// Largest number of contacts for which all combinations of sides are checked before a run. It
/// bounds time: each takes the build of a tape.
const MOST_CONTACTS_WITH_ALL_SIDES: usize = 4;

/// The sides that are checked before a run: all combinations, or with many contacts only these: all
/// below, all above, and each contact alone on the other side.
pub fn sides_to_check(contacts: usize) -> Vec<usize> {
    let all = (1 << contacts) - 1;
    if contacts <= MOST_CONTACTS_WITH_ALL_SIDES {
        return (0..=all).collect();
    }
    let alone = (0..contacts).flat_map(|contact| [1 << contact, all ^ 1 << contact]);
    [0, all].into_iter().chain(alone).collect()
}

impl fmt::Debug for Fields {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fields of {} contacts", self.contacts())
    }
}

/// A system with several contacts and its fields as tapes.
#[derive(Clone, Debug)]
pub struct TapedContacts {
    /// Number of states that move.
    pub dimension: usize,
    /// The fields.
    pub fields: Fields,
    /// Whether the field differs while contacts hold.
    pub has_static: bool,
    /// Whether no rate depends on the sides of two contacts.
    pub frictions_add: bool,
    /// The boundary functions. Functions beyond the number of contacts are never zero.
    pub boundaries: Tape,
    /// The period of the drive, where it depends on states that are parameters.
    pub period: Option<Tape>,
}

impl TapedContacts {
    /// Bits of the existing contacts for which a condition holds.
    fn bits<const M: usize>(&self, is: impl Fn(usize) -> bool) -> usize {
        let contacts = self.fields.contacts().min(M);
        (0..contacts).fold(0, |bits, i| bits | usize::from(is(i)) << i)
    }

    fn values<T: Scalar, const N: usize>(&self, of: Combination, t: T, x: &[T; N]) -> [T; N] {
        let mut out = [T::zero(); N];
        self.fields.evaluate(of, t, x, &mut out);
        out
    }
}

impl<const N: usize, const M: usize> Contacts<N, M> for TapedContacts {
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
        // Contacts beyond those of the system are never at zero.
        let mut heights = [T::one(); M];
        self.boundaries.evaluate(t, x, &mut heights);
        heights
    }

    fn period<T: Scalar>(&self, x: &[T; N]) -> Option<T> {
        let [period] = values(self.period.as_ref()?, T::zero(), x);
        Some(period)
    }

    fn dimension(&self) -> usize {
        self.dimension.min(N)
    }

    fn contacts(&self) -> usize {
        self.fields.contacts().min(M)
    }

    fn frictions_add(&self) -> bool {
        self.frictions_add
    }

    fn has_static_friction(&self) -> bool {
        self.has_static
    }
}

/// The equations of any system.
#[derive(Clone, Debug)]
pub enum Equations {
    /// One contact.
    OneContact(Box<TapedFilippov>),
    /// Several contacts.
    ManyContacts(TapedContacts),
}

/// A Poincaré section.
#[derive(Clone, Debug)]
pub struct SectionFunction {
    /// The function that vanishes on the section.
    pub function: Tape,
    /// Direction of the crossings.
    pub direction: Direction,
}

/// The sections of a system.
#[derive(Clone, Debug)]
pub(super) struct OwnSections(pub Vec<SectionFunction>);

impl<const N: usize> EventFunctions<N> for OwnSections {
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn value<T: Scalar>(&self, number: usize, t: T, x: &[T; N]) -> T {
        let [value] = values(&self.0[number].function, t, x);
        value
    }

    fn direction(&self, number: usize) -> Direction {
        self.0[number].direction
    }

    fn is_as_smooth_as_state(&self, number: usize) -> bool {
        self.0[number].function.is_affine()
    }

    fn is_affine(&self, number: usize) -> bool {
        self.0[number].function.is_affine()
    }
}
