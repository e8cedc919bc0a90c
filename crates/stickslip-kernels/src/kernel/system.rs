//! Systems as tapes: what the solver runs.

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

/// A system of several contacts, its fields as tapes.
#[derive(Clone, Debug)]
pub struct ManyContacts {
    /// The field of every combination of sides: bit `i` of the index is set where contact `i` is [`Side::Above`].
    pub field: Vec<Tape>,
    /// The fields while contacts hold, those in the first index (bit by bit as above); empty where nothing differs then.
    pub holding: Vec<Vec<Tape>>,
    /// The boundary functions; more than there are contacts are asked for, and those are never zero.
    pub boundaries: Tape,
}

/// Bits of what is true.
fn bits<const M: usize>(is: impl Fn(usize) -> bool) -> usize {
    (0..M).fold(0, |bits, i| bits | usize::from(is(i)) << i)
}

impl ManyContacts {
    /// The tape of these sides among the fields of all combinations. A contact that only fills up the number has no side.
    fn of_sides<'a, const M: usize>(fields: &'a [Tape], sides: &[Side; M]) -> &'a Tape {
        let combination = bits::<M>(|i| sides[i] == Side::Above);
        &fields[combination & (fields.len() - 1)]
    }
}

impl<const N: usize, const M: usize> Contacts<N, M> for ManyContacts {
    const INTERPRETED: bool = true;

    #[inline(always)]
    fn field<T: Scalar>(&self, sides: &[Side; M], t: T, x: &[T; N]) -> [T; N] {
        values(ManyContacts::of_sides(&self.field, sides), t, x)
    }

    #[inline(always)]
    fn holding<T: Scalar>(&self, sides: &[Side; M], held: &[bool; M], t: T, x: &[T; N]) -> [T; N] {
        let fields = self
            .holding
            .get(bits::<M>(|i| held[i]))
            .unwrap_or(&self.field);
        values(ManyContacts::of_sides(fields, sides), t, x)
    }

    #[inline(always)]
    fn boundaries<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; M] {
        // Where there are fewer contacts than the number that is compiled, the rest is never at zero.
        let mut heights = [T::one(); M];
        self.boundaries.evaluate(t, x, &mut heights);
        heights
    }
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
