//! The systems of two states and two contacts as one type, so that the solver is compiled once for
//! all of them.

use stickslip::{Contacts, Error, Scalar, Side};

use super::apart::WithIdle;
use super::bad_input::InvalidContacts;
use super::corners::Corner;
use super::static_friction::Stacked;

pub enum TwoStates<'a> {
    Corner(Corner),
    WithIdle(WithIdle<'a>),
    Invalid(InvalidContacts),
    Stacked(Stacked),
}

impl Contacts<2, 2> for TwoStates<'_> {
    fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, x: &[T; 2]) -> [T; 2] {
        match self {
            TwoStates::Corner(system) => system.field(sides, t, x),
            TwoStates::WithIdle(system) => system.field(sides, t, x),
            TwoStates::Invalid(system) => system.field(sides, t, x),
            TwoStates::Stacked(system) => system.field(sides, t, x),
        }
    }
    fn boundaries<T: Scalar>(&self, t: T, x: &[T; 2]) -> [T; 2] {
        match self {
            TwoStates::Corner(system) => system.boundaries(t, x),
            TwoStates::WithIdle(system) => system.boundaries(t, x),
            TwoStates::Invalid(system) => system.boundaries(t, x),
            TwoStates::Stacked(system) => system.boundaries(t, x),
        }
    }
    fn holding<T: Scalar>(&self, sides: &[Side; 2], held: &[bool; 2], t: T, x: &[T; 2]) -> [T; 2] {
        match self {
            TwoStates::Corner(system) => system.holding(sides, held, t, x),
            TwoStates::WithIdle(system) => system.holding(sides, held, t, x),
            TwoStates::Invalid(system) => system.holding(sides, held, t, x),
            TwoStates::Stacked(system) => system.holding(sides, held, t, x),
        }
    }
    fn check_parameters(&self) -> Result<(), Error> {
        match self {
            TwoStates::Corner(system) => system.check_parameters(),
            TwoStates::WithIdle(system) => system.check_parameters(),
            TwoStates::Invalid(system) => system.check_parameters(),
            TwoStates::Stacked(system) => system.check_parameters(),
        }
    }
}
