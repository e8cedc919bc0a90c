//! The functions whose zeros a run locates: sections and jumps, over typed states.

use super::Section;
use super::jumps::Jumps;
use super::view::View;
use crate::filippov::{Direction, EventFunctions, Plane, Strobe, Switched, Velocity};
use crate::ode::Timed;
use crate::scalar::Scalar;
use crate::system::State;

/// An event function of no system's own.
#[derive(Clone, Copy, Debug)]
pub struct NoSection;

impl<const N: usize> EventFunctions<N, 1> for NoSection {
    #[inline(always)]
    fn values<T: Scalar>(&self, _t: T, _x: &[T; N]) -> [T; 1] {
        [T::one()]
    }
}

impl<'a, S, V, J, const N: usize, const G: usize> View<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    J: Jumps<N>,
{
    pub(super) fn section(&self, section: &Section) -> TypedSection<'a, S, V, J, N, G> {
        let kind = match section {
            Section::None => FunctionKind::Nothing,
            Section::Plane {
                point,
                normal,
                direction,
            } => FunctionKind::Plane(Plane {
                point: self.state(point.as_slice()),
                normal: self.state(normal.as_slice()),
                direction: *direction,
            }),
            Section::Strobe(strobe) => FunctionKind::Strobe(*strobe),
            Section::Turning => FunctionKind::Turning,
            Section::Own => FunctionKind::Own,
        };
        self.function(kind)
    }

    fn function(&self, kind: FunctionKind<N>) -> TypedSection<'a, S, V, J, N, G> {
        TypedSection {
            system: self.system,
            own: self.own,
            jumps: self.jumps,
            kind,
        }
    }

    /// The function of a jump.
    pub(super) fn when(&self, jump: usize) -> TypedSection<'a, S, V, J, N, G> {
        self.function(FunctionKind::Jump(jump))
    }
}

/// A section over typed states.
pub(super) struct TypedSection<'a, S, V, J, const N: usize, const G: usize> {
    system: &'a S,
    own: &'a V,
    jumps: &'a J,
    kind: FunctionKind<N>,
}

#[derive(Clone, Copy)]
enum FunctionKind<const N: usize> {
    Nothing,
    Plane(Plane<N>),
    Strobe(Strobe),
    Turning,
    Own,
    Jump(usize),
}

impl<S, V, J, const N: usize, const G: usize> EventFunctions<N, 1>
    for TypedSection<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
    J: Jumps<N>,
{
    #[inline(always)]
    fn values<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; 1] {
        match self.kind {
            FunctionKind::Nothing => [T::one()],
            FunctionKind::Plane(plane) => plane.values(t, x),
            FunctionKind::Strobe(strobe) => strobe.values(t, x),
            FunctionKind::Turning => {
                let here = Timed {
                    t: t.value(),
                    x: State::from(x.map(Scalar::value)),
                };
                let mode = self.system.mode_by_side(here.t, &here.x);
                let branch = self.system.branch_of_field(mode, &here);
                let velocity = self.system.with_flow(mode, branch, Velocity(t, x));
                [velocity[0]]
            }
            FunctionKind::Own => self.own.values(t, x),
            FunctionKind::Jump(number) => [self.jumps.when(number, t, x)],
        }
    }

    fn direction(&self, number: usize) -> Direction {
        match self.kind {
            FunctionKind::Plane(plane) => plane.direction,
            FunctionKind::Turning => Direction::Falling,
            FunctionKind::Nothing | FunctionKind::Strobe(_) => Direction::Both,
            FunctionKind::Own => self.own.direction(number),
            FunctionKind::Jump(number) => self.jumps.direction(number),
        }
    }

    fn is_as_smooth_as_state(&self, number: usize) -> bool {
        match self.kind {
            FunctionKind::Nothing | FunctionKind::Plane(_) | FunctionKind::Turning => true,
            FunctionKind::Own => self.own.is_as_smooth_as_state(number),
            FunctionKind::Strobe(_) | FunctionKind::Jump(_) => false,
        }
    }
}
